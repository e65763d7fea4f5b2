#include "polyarm/io/links.hpp"

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/hardware/driver_loader.hpp"

namespace polyarm::cell {

namespace {
using signals::Direction;
using signals::LinkEntry;
using signals::LinkEvent;
using signals::LinkTag;

/// In lock-step, remote devices are polled at this interval of cell time, ns.
constexpr Nanoseconds kLockStepRounds = 10'000'000;

data::Kind kind_of(LinkTag::Type type) {
  constexpr data::Kind kKinds[] = {data::Kind::boolean, data::Kind::number, data::Kind::text,
                                   data::Kind::pose};
  return kKinds[static_cast<std::size_t>(type)];
}

data::Value nothing_of(LinkTag::Type type) {
  switch (type) {
    case LinkTag::Type::boolean:
      return false;
    case LinkTag::Type::number:
      return 0;
    case LinkTag::Type::text:
      return "";
    case LinkTag::Type::pose:
      return data::Point{};
  }
  return false;
}

/// For each tag of the link, the cell's tag with that name; null if there is none.
std::vector<const signals::Tag*> rules_of(const LinkEntry& entry, const std::vector<signals::Tag>& tags) {
  std::unordered_map<std::string_view, const signals::Tag*> by_name;
  for (const signals::Tag& tag : tags) by_name.emplace(tag.name, &tag);
  std::vector<const signals::Tag*> out;
  for (const LinkTag& tag : entry.tags) {
    const auto found = by_name.find(tag.name);
    out.push_back(found == by_name.end() ? nullptr : found->second);
  }
  return out;
}
}  // namespace

std::vector<std::filesystem::path> CellLinks::module_folders() {
  return hardware::driver_folders();
}

CellLinks::CellLinks(const signals::Signals& signals, CellStates& own, data::DataStore& store, bool lock_step,
                     bool off, Problems& problems)
    : tags_(signals.tags), own_(own), store_(store), lock_step_(lock_step) {
  for (const LinkEntry& entry : signals.links) {
    declare(entry, store, problems);
    Running running;
    const auto state = [&](const std::string& of) {
      const std::string name = "link/" + entry.name + "/" + of;
      const auto known = own.find(name);
      return known ? *known : own.add(name);
    };
    running.up_state = state("up");
    running.losses_state = state("losses");
    if (off) continue;
    collect(problems, [&] {
      signals::LinkOptions options;
      options.thread = !lock_step;
      running.link =
          std::make_unique<signals::Link>(entry, signals::load_link_port(entry, module_folders()), options);
      running.sent.resize(entry.tags.size());
      running.rules = rules_of(entry, tags_);
      running.state = running.link->state();
      links_.push_back(std::move(running));
    });
  }
  write({});  // initial values, before anybody reads them
}

void CellLinks::declare(const LinkEntry& entry, data::DataStore& store, Problems& problems) const {
  for (const LinkTag& tag : entry.tags) {
    const data::Value* known = store.find(tag.name);
    if (!known) {
      store.declare_tag(tag.name, nothing_of(tag.type));
      continue;
    }
    if (known->kind() != kind_of(tag.type))
      problems.error("bad-link", tag.where,
                     "'" + tag.name + "' is " + data::name(known->kind()) + ", over the link '" + entry.name +
                         "' it is " + data::name(kind_of(tag.type)),
                     "give its type");
    if (tag.direction != Direction::out && store.tag_role(tag.name) == data::TagRole::state)
      problems.error(
          "bad-link", tag.where,
          "'" + tag.name + "' comes from the hardware, so the link '" + entry.name + "' cannot bring it",
          "direction: out");
  }
}

bool CellLinks::ready() const {
  return std::all_of(links_.begin(), links_.end(), [](const Running& running) {
    return running.state.was_up || running.link->entry().on_loss == LinkEntry::OnLoss::go_on;
  });
}

std::optional<Problem> CellLinks::lost() const {
  for (const Running& running : links_) {
    const LinkEntry& entry = running.link->entry();
    if (entry.on_loss != LinkEntry::OnLoss::hold || !running.state.was_up) continue;
    if (!running.state.up)
      return Problem{"link-lost",
                     {},
                     "the link '" + entry.name + "' is lost: " + running.state.reason,
                     {},
                     Severity::warning,
                     {{"link", entry.name}, {"reason", running.state.reason}}};
    for (std::size_t i = 0; i < entry.tags.size(); ++i)
      if (running.state.stale[i] && running.state.heard[i])
        return Problem{
            "link-stale",
            {},
            "the link '" + entry.name + "' has sent no new value of '" + entry.tags[i].name + "' for " +
                format_number(seconds(entry.tags[i].stale)) + " s",
            {},
            Severity::warning,
            {{"link", entry.name}, {"tag", entry.tags[i].name}, {"time_s", seconds(entry.tags[i].stale)}}};
  }
  return std::nullopt;
}

bool CellLinks::any_down() const {
  return std::any_of(links_.begin(), links_.end(),
                     [](const Running& running) { return running.state.was_up && !running.state.up; });
}

void CellLinks::take(Running& running, LinkEvent& event) {
  const LinkEntry& entry = running.link->entry();
  const auto tell = [&](const char* code, const std::string& what) {
    news_.push_back({code,
                     {},
                     what,
                     "polyarm tags shows every link and tag",
                     Severity::warning,
                     {{"link", entry.name}, {"reason", event.text}}});
  };
  switch (event.kind) {
    case LinkEvent::Kind::value: {
      const std::string& name = entry.tags[event.tag].name;
      const data::Value* known = store_.find(name);
      if (known && known->kind() != event.value.kind()) return;
      if (known && known->as_point() && *known == event.value) return;
      running.sent[event.tag] = event.value;  // the remote device has this value already
      store_.set(name, std::move(event.value), "link " + entry.name);
      return;
    }
    case LinkEvent::Kind::refused:
      return tell("refused-value", "what the link '" + entry.name + "' brings of '" +
                                       entry.tags[event.tag].name + "' is not taken: " + event.text);
    case LinkEvent::Kind::lost:
      return tell("link-lost", "the link '" + entry.name + "' is lost: " + event.text);
    case LinkEvent::Kind::note:
      return tell("link-note", "the link '" + entry.name + "': " + event.text);
    case LinkEvent::Kind::found:
      if (running.state.losses > 0) tell("link-found", "the link '" + entry.name + "' is connected again");
      return;
  }
}

void CellLinks::read(Nanoseconds now) {
  const bool round = lock_step_ && now - stepped_ >= kLockStepRounds;
  if (round) stepped_ = now;
  for (Running& running : links_) {
    if (round) running.link->step(now);
    running.state = running.link->state();
    for (LinkEvent& event : running.link->take_events()) take(running, event);
    own_.set(running.up_state, running.state.up ? 1 : 0);
    own_.set(running.losses_state, static_cast<double>(running.state.losses));
  }
}

void CellLinks::write(const signals::Situation& situation) {
  if (store_.version() == seen_version_ && situation == seen_situation_) return;
  seen_version_ = store_.version();
  seen_situation_ = situation;
  for (Running& running : links_) {
    const LinkEntry& entry = running.link->entry();
    for (std::size_t i = 0; i < entry.tags.size(); ++i) {
      if (entry.tags[i].direction == Direction::in) continue;
      const data::Value* value = store_.find(entry.tags[i].name);
      if (!value || value->kind() != kind_of(entry.tags[i].type)) continue;
      const data::Value& out = running.rules[i] ? running.rules[i]->output(*value, situation) : *value;
      if (running.sent[i] && *running.sent[i] == out) continue;
      running.sent[i] = out;
      running.link->post(i, out);
    }
  }
}

bool CellLinks::idle() const {
  return std::all_of(links_.begin(), links_.end(),
                     [](const Running& running) { return !running.state.up || running.link->idle(); });
}

std::optional<CellLinks::Source> CellLinks::source_of(const std::string& name) const {
  for (const Running& running : links_) {
    const LinkEntry& entry = running.link->entry();
    for (std::size_t i = 0; i < entry.tags.size(); ++i)
      if (entry.tags[i].name == name)
        return Source{entry.name, signals::name(entry.tags[i].direction),
                      !running.state.heard[i] && entry.tags[i].direction != Direction::out ? "none"
                      : running.state.up && !running.state.stale[i]                        ? "good"
                                                                                           : "stale"};
  }
  return std::nullopt;
}

std::vector<CellLinks::Status> CellLinks::status() const {
  std::vector<Status> out;
  for (const Running& running : links_) out.push_back({&running.link->entry(), running.state});
  return out;
}

}  // namespace polyarm::cell
