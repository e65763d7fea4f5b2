#include "polyarm/machine/stops.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace polyarm::cell {

namespace {
constexpr double kNoWay = 1e-9;                // rad or m; less does not count as motion
constexpr Nanoseconds kSettles = 300'000'000;  // ns; time at standstill until a robot counts as at rest
constexpr double kPushed = 0.01;               // rad or m; less is noise or compliance of a servo
}  // namespace

std::string StopReport::sentence() const {
  std::string out = fmt::format("stopped in {:.3f} s (category {})", time_s, category);
  for (const Way& tcp : tcps) out += fmt::format(", TCP of {} {:.1f} mm", tcp.name, 1e3 * tcp.way);
  const auto most = std::max_element(joints.begin(), joints.end(),
                                     [](const Way& a, const Way& b) { return a.way < b.way; });
  if (most != joints.end()) out += fmt::format(", {} {:.4f} rad or m", most->name, most->way);
  return out + ": " + cause;
}

Facts StopReport::facts() const {
  Facts out{{"cause", cause_code}, {"category", static_cast<double>(category)}, {"time_s", time_s}};
  const auto most =
      std::max_element(tcps.begin(), tcps.end(), [](const Way& a, const Way& b) { return a.way < b.way; });
  if (most == tcps.end()) return out;
  out.push_back({"robot", most->name});
  out.push_back({"tcp_m", most->way});
  return out;
}

protocol::StopFacts facts_of(const StopReport& stop) {
  protocol::StopFacts out{
      seconds(stop.begun), stop.time_s, stop.category, stop.cause, stop.cause_code, {}, {}};
  for (const StopReport::Way& tcp : stop.tcps) out.tcp_m[tcp.name] = tcp.way;
  for (const StopReport::Way& joint : stop.joints) out.joints[joint.name] = joint.way;
  return out;
}

JointPlaces::JointPlaces(const CellRobots& robots, const hardware::InterfaceTable& table) {
  const auto index = [](const auto& found) { return found ? static_cast<int>(*found) : -1; };
  for (std::size_t r = 0; r < robots.size(); ++r) {
    first_.push_back(places_.size());
    const kinematics::Chain& chain = robots[r]->facts->chain;
    for (std::size_t j = 0; j < robots[r]->joints.size(); ++j) {
      const std::string& name = robots[r]->joints[j].name;
      places_.push_back({name, r, index(table.find_state(name + "/position")),
                         index(table.find_command(name + "/position")),
                         j < chain.names().size() && chain.slides(j)});
    }
  }
  first_.push_back(places_.size());
}

std::span<const JointPlaces::Place> JointPlaces::of(std::size_t robot) const {
  if (robot + 1 >= first_.size()) return {};
  return std::span(places_).subspan(first_[robot], first_[robot + 1] - first_[robot]);
}

void JointPlaces::commanded(const control::Snapshot& snapshot, std::vector<double>& out) const {
  out.clear();
  for (const Place& place : places_) out.push_back(commanded(snapshot, place));
}

double JointPlaces::commanded(const control::Snapshot& snapshot, const Place& p) {
  double q = p.command >= 0 ? snapshot.commands[static_cast<std::size_t>(p.command)]
                            : std::numeric_limits<double>::quiet_NaN();
  if (!std::isfinite(q) && p.state >= 0) q = snapshot.states[static_cast<std::size_t>(p.state)];
  return std::isfinite(q) ? q : 0;
}

void StopWatch::add(const CellRobots& robots, const JointPlaces& places, const std::vector<double>& now) {
  const auto& all = places.all();
  for (std::size_t j = 0; j < now.size(); ++j) joint_way_[j] += std::abs(now[j] - before_[j]);
  for (std::size_t j = 0; j < now.size();) {
    const std::size_t robot = all[j].robot, first = j;
    while (j < now.size() && all[j].robot == robot) ++j;
    const std::span<const double> a(before_), b(now);
    const kinematics::Chain& chain = robots[robot]->facts->chain;
    tcp_way_[robot] += norm(chain.forward(b.subspan(first, j - first)).position -
                            chain.forward(a.subspan(first, j - first)).position);
  }
}

std::optional<StopReport> StopWatch::tick(const control::Snapshot& snapshot, const CellRobots& robots,
                                          const JointPlaces& places) {
  std::vector<double>& now = now_;
  places.commanded(snapshot, now);
  if (before_.size() != now.size()) before_ = now;
  if (snapshot.stop.begun >= 0 && snapshot.stop.begun != seen_) {
    seen_ = snapshot.stop.begun;
    under_way_ = true;
    joint_way_.assign(now.size(), 0.0);
    tcp_way_.assign(robots.size(), 0.0);
  }
  if (under_way_) add(robots, places, now);
  before_.swap(now);
  if (!under_way_ || snapshot.stop.ended < 0) return std::nullopt;
  under_way_ = false;
  StopReport out;
  out.begun = seen_;
  out.time_s = seconds(snapshot.stop.ended - seen_);
  out.category = category_;
  out.cause = control::name(snapshot.cause);
  out.cause_code = control::code(snapshot.cause);
  category_ = 2;
  for (std::size_t r = 0; r < robots.size(); ++r)
    if (tcp_way_[r] > kNoWay) out.tcps.push_back({robots[r]->entry.name, tcp_way_[r]});
  for (std::size_t j = 0; j < joint_way_.size(); ++j)
    if (joint_way_[j] > kNoWay) out.joints.push_back({places.all()[j].name, joint_way_[j]});
  return out.joints.empty() ? std::nullopt : std::optional(std::move(out));
}

void HeldPlace::forget() {
  references_.clear();
  most_ = 0;
}

void HeldPlace::tick(const control::Snapshot& snapshot, const JointPlaces& places, bool excused) {
  if (snapshot.state != control::RunState::held || excused) return forget();
  references_.resize(places.all().size());
  most_ = 0;
  for (std::size_t j = 0; j < references_.size(); ++j) {
    const JointPlaces::Place& place = places.all()[j];
    if (place.state < 0 || place.command < 0) continue;
    Reference& reference = references_[j];
    const double command = snapshot.commands[static_cast<std::size_t>(place.command)];
    const double off = snapshot.states[static_cast<std::size_t>(place.state)] - command;
    const bool changed = std::isnan(command) != std::isnan(reference.command) ||
                         std::abs(command - reference.command) > kPushed;
    const bool there = !(std::abs(off) > kPushed);
    if (reference.since < 0 || (changed && there)) reference = {command, 0, snapshot.cycle.time, false};
    if (snapshot.cycle.time - reference.since < kSettles || !std::isfinite(off)) continue;
    if (!std::exchange(reference.taken, true)) reference.settled = off;
    const double moved = off - reference.settled;
    if (!(std::abs(moved) > std::abs(most_))) continue;
    most_ = moved;
    joint_ = place.name;
    slides_ = place.slides;
  }
}

std::optional<Problem> HeldPlace::pushed() const {
  if (std::abs(most_) <= kPushed) return std::nullopt;
  return Problem{
      "moved-while-held",
      {},
      fmt::format(
          "{} was moved by {:+.4f} {} during the hold, away from the position where the motion continues",
          joint_, most_, slides_ ? "m" : "rad"),
      "let it go back; or discard the motion: polyarm control discard; or continue from here: polyarm "
      "control resume --anyway",
      Severity::error,
      {{"joint", joint_}, {slides_ ? "moved_m" : "moved_rad", most_}}};
}

}  // namespace polyarm::cell
