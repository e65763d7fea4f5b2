#include "polyarm/io/parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace polyarm::cell {

namespace {
bool inside(const description::Bin& bin, const Vec3& p) {
  return p.x >= bin.lower.x && p.x <= bin.upper.x && p.y >= bin.lower.y && p.y <= bin.upper.y &&
         p.z >= bin.lower.z && p.z <= bin.upper.z;
}
}  // namespace

const char* name(PartFate fate) {
  constexpr const char* kNames[] = {"waiting", "held", "moving", "placed", "off_goal", "wrong_bin"};
  return kNames[static_cast<std::size_t>(fate)];
}

std::string PartReport::sentence() const {
  const std::string place = fmt::format("({:.3f}, {:.3f}, {:.3f})", at.x, at.y, at.z);
  switch (fate) {
    case PartFate::waiting:
      return fmt::format("{} still waits at {}", name, place);
    case PartFate::held:
      return fmt::format("{} is still held by the gripper, at {}", name, place);
    case PartFate::moving:
      return fmt::format("{} had not come to rest, last seen at {}", name, place);
    case PartFate::placed:
      return fmt::format("{} was placed at {}", name, place);
    case PartFate::off_goal:
      return fmt::format("{} lies at {}, {:.1f} mm from its goal; {:.1f} mm are allowed", name, place,
                         1000 * error_m.value_or(0), 1000 * (goal ? goal->tolerance : 0));
    case PartFate::wrong_bin:
      return fmt::format("{} lies at {} in {}, it belongs in {}", name, place, bin.empty() ? "no bin" : bin,
                         goal ? goal->bin : "");
  }
  return name;
}

void PartTracker::update(Nanoseconds now, const hardware::WorldState& world) {
  for (std::size_t i = 0; i < tracks_.size() && i < world.parts.size(); ++i) {
    const hardware::PartState& part = world.parts[i];
    Track& track = tracks_[i];
    track.entered |= part.entered;
    track.taken = part.entered && !part.in_world;
    if (!part.in_world) continue;
    track.at = part.pose.position;
    track.held = part.held_by >= 0;
    if (track.held) {
      track.touched = true;
      track.at_rest = track.slow = false;
      continue;
    }
    const bool slow = part.asleep || part.speed < kRestSpeed;
    if (slow && !track.slow) track.slow_since = now;
    track.slow = slow;
    track.at_rest = slow && now - track.slow_since >= kRestTime;
  }
}

bool PartTracker::anything_moving() const {
  return std::any_of(tracks_.begin(), tracks_.end(),
                     [](const Track& t) { return t.touched && !t.held && !t.at_rest && !t.taken; });
}

PartReport PartTracker::judge(std::size_t i) const {
  const description::Part& part = scene_->parts[i];
  const Track& track = tracks_[i];
  PartReport out{part.name, part.kind, "", track.at, part.goal, std::nullopt, PartFate::waiting, track.taken};
  for (const description::Bin& bin : scene_->bins)
    if (inside(bin, track.at)) out.bin = bin.name;
  if (track.held) out.fate = PartFate::held;
  if (!track.touched || track.held) return out;
  if (!track.at_rest && !track.taken) {
    out.fate = PartFate::moving;
    return out;
  }
  out.fate = PartFate::placed;
  if (!part.goal) return out;
  out.error_m = norm(track.at - part.goal->at);
  if (*out.error_m > part.goal->tolerance) out.fate = PartFate::off_goal;
  const auto bin = std::find_if(scene_->bins.begin(), scene_->bins.end(),
                                [&](const description::Bin& b) { return b.name == part.goal->bin; });
  if (bin != scene_->bins.end()) {
    if (inside(*bin, track.at))
      out.bin = bin->name;
    else
      out.fate = PartFate::wrong_bin;
  }
  return out;
}

std::vector<PartReport> PartTracker::report() const {
  std::vector<PartReport> out;
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    if (tracks_[i].entered) out.push_back(judge(i));
  return out;
}

std::vector<std::string> PartTracker::failures(bool cut_short) const {
  std::vector<std::string> out;
  for (const PartReport& part : report()) {
    if (part.fate == PartFate::placed || !part.goal) continue;
    if (part.fate == PartFate::waiting && cut_short) continue;
    out.push_back(part.sentence());
  }
  return out;
}

HeldParts::HeldParts(std::vector<std::string> robots, const description::Scene& scene,
                     const hardware::InterfaceTable& table)
    : robots_(std::move(robots)), scene_(scene) {
  for (const std::string& robot : robots_)
    sensors_.push_back(table.find_state(robot + "/tool/part_present").value_or(kNoSensor));
}

bool HeldParts::senses(std::size_t robot, const control::Snapshot& snapshot) const {
  const std::size_t at = sensors_[robot];
  return at < snapshot.states.size() && snapshot.states[at] > 0.5;
}

std::vector<std::string> HeldParts::names(const control::Snapshot& snapshot) const {
  std::vector<std::string> out;
  std::vector<char> known(robots_.size(), 0);
  const auto& parts = snapshot.world.parts;
  for (std::size_t i = 0; i < parts.size() && i < scene_.parts.size(); ++i) {
    if (parts[i].held_by < 0) continue;
    out.push_back(scene_.parts[i].name);
    const auto robot = static_cast<std::size_t>(parts[i].held_by);
    if (robot < known.size()) known[robot] = 1;
  }
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (known[i] == 0 && senses(i, snapshot)) out.push_back("a part in '" + robots_[i] + "'");
  return out;
}

bool HeldParts::changed(const control::Snapshot& snapshot) {
  const auto& parts = snapshot.world.parts;
  const std::size_t count = parts.size() + robots_.size();
  bool changed = false;
  if (seen_.size() != count) seen_.assign(count, -1);
  for (std::size_t i = 0; i < count; ++i) {
    const int now = i < parts.size() ? parts[i].held_by : senses(i - parts.size(), snapshot) ? 1 : -1;
    changed = std::exchange(seen_[i], now) != now || changed;
  }
  return changed;
}

}  // namespace polyarm::cell
