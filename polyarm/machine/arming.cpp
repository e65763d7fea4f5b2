#include "polyarm/machine/arming.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace polyarm::cell {

namespace {
// Reduced speed: TCP at most 250 mm/s (ISO 10218-1), joints at most a tenth of their limits.
constexpr double kReducedTcp = 0.25, kReducedJoint = 0.1;
constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr double kGoverned = 0.8, kSlowest = 0.01;
constexpr double kBeyond = 1.05;           // tolerance if the motion was planned within the limit
constexpr double kRise = 2.5, kFall = 50;  // per second: exponential rates of increase and decrease
/// TCP speeds are averaged over this time, or over one turn of the slowest robot: between two turns of a
/// robot no new value is measured or commanded, which must not count as standstill. Share and speed rise by
/// 13 % in this time.
constexpr Nanoseconds kLook = 50'000'000;
constexpr double kStandingTcp = 0.01;  // m/s; noise of measured positions of a standing robot
}  // namespace

Arming::Arming(control::ControlLoop& loop, const CellRobots& robots, bool full_speed, Observer& observer)
    : loop_(loop), robots_(robots), observer_(observer), full_speed_(full_speed) {
  for (std::size_t i = 0; i < loop_.hardware().size(); ++i)
    if (loop_.hardware().real(i)) components_.push_back(i);
  if (!components_.empty()) slow_down();
}

void Arming::announce() const {
  if (components_.empty()) return;
  for (const std::size_t i : components_)
    observer_.on_note(loop_.hardware().component_name(i) + " is real hardware and disarmed");
  for (const Expected& joint : expected_positions(loop_.table().states()))
    observer_.on_note(
        fmt::format("{}: measured {:.4f}, expected {:.4f}", joint.joint, joint.measured, joint.expected));
  observer_.on_note(
      "nothing moves before a person types 'arm' here, or 'polyarm control arm' in another terminal");
}

void Arming::slow_down() {
  reduced_ = !full_speed_;
  share_ = reduced_ ? kSlowest : 1;
  set_share(share_, reduced_ ? kReducedJoint : 1);
}

void Arming::look_again() {
  for (std::size_t i = 0; i < loop_.hardware().size(); ++i) {
    if (!loop_.hardware().real(i) || is_real(i)) continue;
    components_.push_back(i);
    armed_ = false;
    loop_.supervisor().watch_cell = loop_.holds_after_gap();
    slow_down();
    observer_.on_note(loop_.hardware().component_name(i) + " is real hardware now and disarmed");
  }
}

void Arming::set_share(double of_path, double of_joints) {
  loop_.supervisor().set_share(of_path);
  loop_.limits().set_share(of_joints);
}

bool Arming::is_real(std::size_t component) const {
  return std::find(components_.begin(), components_.end(), component) != components_.end();
}

void Arming::require_armed(std::size_t component) const {
  if (may_be_enabled(component)) return;
  throw Error("disarmed",
              "'" + loop_.hardware().component_name(component) + "' is real hardware that is not armed",
              "polyarm control arm");
}

std::vector<Arming::Expected> Arming::expected_positions(std::span<const double> states) const {
  std::vector<Expected> out;
  for (const auto& robot : robots_)
    for (std::size_t j = 0; j < robot->joints.size(); ++j) {
      const auto index = loop_.table().find_state(robot->joints[j].name + "/position");
      if (!index || *index >= states.size()) continue;
      const int component = loop_.hardware().component_of_state(*index);
      if (component >= 0 && is_real(static_cast<std::size_t>(component)))
        out.push_back({robot->joints[j].name, states[*index], robot->start[j]});
    }
  return out;
}

void Arming::require_verified() const {
  for (const auto& robot : robots_) {
    const std::vector<std::string>& doubts = robot->model.provenance.notes;
    if (doubts.empty() || robot->entry.accept_unverified) continue;
    throw Error(
        Problem{"unverified", robot->entry.where,
                "facts of " + robot->model.name + " are not verified: " + doubts.front() +
                    (doubts.size() > 1 ? " (and " + std::to_string(doubts.size() - 1) + " more)" : ""),
                "compare them with the maker's data, then write 'accept_unverified: true' at the robot '" +
                    robot->entry.name + "' of the cell"});
  }
}

void Arming::set_armed(Nanoseconds now) {
  armed_ = true;
  armed_at_ = now;
  observer_.on_note(reduced_ ? "armed, at reduced speed until the program has run through once"
                             : "armed, at full speed");
}

namespace {
/// Longest time between two turns of the cell's hardware, ns.
Nanoseconds longest_turn(const CellRobots& robots, Nanoseconds loop) {
  Nanoseconds out = loop;
  const auto at = [&out](double rate) {
    if (rate > 0) out = std::max(out, static_cast<Nanoseconds>(1e9 / rate) + 1);
  };
  for (const auto& robot : robots) {
    at(robot->entry.rate);
    for (const HardwareBlock& block : robot->blocks) at(block.info->rw_rate);
  }
  return out;
}
}  // namespace

bool Arming::stands(double fastest, std::span<const double> commands) {
  const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  const bool unchanged =
      std::equal(commands.begin(), commands.end(), commands_before_.begin(), commands_before_.end(), same);
  commands_before_.assign(commands.begin(), commands.end());
  return unchanged && fastest < kStandingTcp;
}

void Arming::govern(Nanoseconds now, std::span<const Vec3> tcps, std::span<const double> commands,
                    bool passed, bool planned) {
  if (!reduced()) return;
  if (passed && reduced_) {
    reduced_ = false;
    if (!profile_reduced_) set_share(1, 1);
    observer_.on_note("the program has run through once: full speed from now on");
    return;
  }
  if (std::exchange(planned_, planned) != planned) set_share(share_ = planned ? 1 : kSlowest, joint_share());
  const Nanoseconds since = now - before_;
  if (since < std::max(kLook, longest_turn(robots_, loop_.options().period))) return;
  double fastest = 0;
  for (std::size_t i = 0; i < tcps_before_.size(); ++i)
    fastest = std::max(fastest, norm(tcps[i] - tcps_before_[i]) / seconds(since));
  tcps_before_.assign(tcps.begin(), tcps.end());
  before_ = now;
  const double tcp = std::min(reduced_ ? kReducedTcp : kNone, profile_reduced_ ? profile_tcp_ : kNone);
  const bool standing = stands(fastest, commands);
  if (planned)
    share_ = fastest > kBeyond * tcp ? share_ * kGoverned * tcp / fastest
                                     : std::min(1.0, share_ * std::exp(kRise * seconds(since)));
  else if (standing)
    share_ *= std::exp(-kFall * seconds(since));
  else
    share_ *= fastest > kGoverned * tcp ? kGoverned * tcp / fastest : std::exp(kRise * seconds(since));
  const double joints = joint_share();
  share_ = std::clamp(share_, std::min(kSlowest, joints), planned ? 1 : joints);
  set_share(share_, joints);
}

double Arming::joint_share() const {
  return std::min(reduced_ ? kReducedJoint : 1, profile_reduced_ ? profile_joint_ : 1);
}

void Arming::set_profile(bool reduced, double tcp_speed, double joint_share) {
  profile_reduced_ = reduced;
  planned_ = false;
  profile_tcp_ = tcp_speed;
  profile_joint_ = joint_share;
  if (reduced)
    set_share(share_ = kSlowest, joint_share);
  else if (!reduced_)
    set_share(share_ = 1, 1);
}

}  // namespace polyarm::cell
