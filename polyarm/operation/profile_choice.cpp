#include "polyarm/operation/profile_choice.hpp"

#include "polyarm/base/text.hpp"
#include "polyarm/machine/cell_data.hpp"
#include "polyarm/machine/machine.hpp"
#include "polyarm/machine/motions.hpp"

namespace polyarm::cell {

namespace {
/// The profile is given back when there was no reason for this long, ns, and the TCP is as far back, m.
constexpr Nanoseconds kNoReason = 500'000'000;
constexpr double kBack = 0.01;

bool is_set(const data::Value* value) {
  if (!value) return false;
  if (const bool* flag = value->as_boolean()) return *flag;
  const data::Number* const number = value->as_number();
  return number && !(number->value == 0);  // NaN: nobody knows, so it is slow
}
}  // namespace

void ProfileChoice::build(Problems& problems) {
  const ProfileEntry& reduced = cell_.setup.file.profiles.reduced;
  if (reduced.tag.empty() || cell_.data.store.find(reduced.tag)) return;
  problems.error("unknown-name", reduced.tag_place,
                 "the cell has no tag or variable '" + reduced.tag + "'" +
                     did_you_mean(reduced.tag, cell_.data.store.names()),
                 "declare it in the signals file");
}

/// Why the cell has the reduced profile now; empty: nothing asks for it.
std::string ProfileChoice::reason() {
  const std::string& tag = cell_.setup.file.profiles.reduced.tag;
  if (!tag.empty() && is_set(cell_.data.store.find(tag))) return tag + " is true";
  for (std::size_t r = 0; r < cell_.setup.robots.size(); ++r) {
    const CellRobot& robot = *cell_.setup.robots[r];
    if (robot.slow_zones.empty()) continue;
    const Pose tcp = cell_.motions.tcp(r);
    for (std::size_t i = 0; i < robot.slow_zones.boundaries(); ++i)
      if (robot.slow_zones.distance(i, tcp, {}).distance < (chosen_ ? kBack : 0))
        return robot.entry.name + " is beyond '" +
               robot.slow_zones.zones()[robot.slow_zones.zone_of(i)].name + "'";
  }
  return {};
}

void ProfileChoice::tick() {
  if (cell_.machine.snapshot().states.empty()) return;  // before the first cycle
  const std::string why = reason();
  const Nanoseconds now = cell_.machine.now();
  if (why.empty() && chosen_) {
    if (since_ < 0) since_ = now;
    if (now - since_ < kNoReason) return;
  }
  since_ = -1;
  if (why.empty() != chosen_) return;
  chosen_ = !why.empty();
  cell_.motions.set_reduced(chosen_);
  cell_.observer.on_note(chosen_ ? "reduced profile: " + why
                                 : "profile " + cell_.motions.profile() + " again");
}

}  // namespace polyarm::cell
