#include "polyarm/machine/contact_watch.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace polyarm::cell {

namespace {
using World = hardware::WorldState;

bool kept(const World& world, int number) {
  return number < world.finding_count && number + World::kMaxFindings >= world.finding_count;
}
}  // namespace

const char* name(ContactDuring during) {
  constexpr const char* kNames[] = {"program", "jog", "move", "start", "rest", "other"};
  return kNames[static_cast<std::size_t>(during)];
}

std::string depth_text(double depth_m) {
  const double mm = 1e3 * depth_m;
  if (mm >= 0.1) return fmt::format("{:.2f} mm", mm);
  if (mm < 0.001) return mm > 0 ? "less than 0.001 mm" : "0 mm";
  return fmt::format("{:.2g} mm", mm);
}

std::string ContactReport::sentence() const {
  if (during == ContactDuring::start)
    return fmt::format("{} is inside {} where it starts, {} deep", a, b, depth_text(depth));
  std::string out = fmt::format("{} touched {} at {:.3f} s, {} deep", a, b, seconds(time), depth_text(depth));
  if (during == ContactDuring::jog) out += ", moved by hand";
  if (during == ContactDuring::move) out += ", on the way to a requested point";
  if (during == ContactDuring::rest) out += ", while the robot only stood there";
  return out;
}

Facts ContactReport::facts() const {
  return {{"a", a}, {"b", b}, {"depth_m", depth}, {"at_s", seconds(time)}, {"doing", name(during)}};
}

/// Removes contacts that have ended first.
void ContactWatch::make_room() {
  while (list_.size() > kKept) {
    const auto over = std::find_if(list_.begin(), list_.end(), [](const ContactReport& c) { return !c.now; });
    list_.erase(over != list_.end() ? over : list_.begin());
  }
}

void ContactWatch::follow(const World& world) {
  touching_ = nullptr;
  for (ContactReport& contact : list_) {
    contact.now = contact.now && kept(world, contact.number);
    if (!kept(world, contact.number)) continue;
    const hardware::Contact& seen = world.findings[static_cast<std::size_t>(contact.number % World::kMaxFindings)];
    contact.now = seen.now;
    contact.depth = seen.depth;
    contact.position = seen.position;
  }
  for (const ContactReport& contact : list_)
    if (contact.now) touching_ = &contact;
}

std::vector<ContactReport*> ContactWatch::tick(const control::Snapshot& snapshot,
                                               const std::vector<std::string>& names) {
  const World& world = snapshot.world;
  if (world.finding_count < seen_) seen_ = 0, list_.clear();  // the world was replaced by another one
  const auto called = [&](int id) {
    return id >= 0 && id < static_cast<int>(names.size()) ? names[static_cast<std::size_t>(id)] : "something";
  };
  const int first = std::max(seen_, world.finding_count - World::kMaxFindings);
  for (int number = first; number < world.finding_count; ++number) {
    const hardware::Contact& found = world.findings[static_cast<std::size_t>(number % World::kMaxFindings)];
    ContactReport report;
    report.a = called(found.a), report.b = called(found.b);
    report.number = number;
    report.time = found.time;
    list_.push_back(std::move(report));
  }
  seen_ = world.finding_count;
  follow(world);
  make_room();
  follow(world);  // updates pointers into the list
  std::vector<ContactReport*> news;
  for (ContactReport& contact : list_)
    if (contact.number >= first) news.push_back(&contact);
  return news;
}

}  // namespace polyarm::cell
