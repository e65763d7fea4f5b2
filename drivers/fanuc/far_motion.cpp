#include "drivers/fanuc/far_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/wire/arcs.hpp"

namespace polyarm::fanuc {

namespace {

constexpr double kRamp = 0.2;  // s of speeding up, and of slowing down
constexpr double kStep = 5;    // mm of a line between two steps
constexpr int kMostSteps = 2000;
constexpr double kMostSpeed = 4000;  // mm/s
constexpr double kSettled = 0.01;    // degrees
constexpr double kTurnLength = 5;    // mm that a degree of turning counts for
constexpr double kJump = 10;         // degrees between two steps: a change of the arm's configuration

struct Name {
  const char* name;
  bool relative, joints, line, circle;
};
constexpr Name kMotions[] = {
    {"FRC_LinearMotion", false, false, true, false},    {"FRC_LinearRelative", true, false, true, false},
    {"FRC_JointMotion", false, false, false, false},    {"FRC_JointRelative", true, false, false, false},
    {"FRC_CircularMotion", false, false, true, true},   {"FRC_CircularRelative", true, false, true, true},
    {"FRC_JointMotionJRep", false, true, false, false}, {"FRC_JointRelativeJRep", true, true, false, false},
    {"FRC_LinearMotionJRep", false, true, true, false}, {"FRC_LinearRelativeJRep", true, true, true, false}};

const Name* motion_named(const std::string& name) {
  for (const Name& one : kMotions)
    if (name == one.name) return &one;
  return nullptr;
}

Six add(const Six& a, const Six& b, double sign = 1) {
  Six out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = a[i] + sign * b[i];
  return out;
}

std::array<double, 6> values_of(const RmiMessage& message, const std::string& group) {
  std::array<double, 6> out{};
  constexpr const char* kKeys[] = {"X", "Y", "Z", "W", "P", "R"};
  for (std::size_t i = 0; i < 6; ++i) out[i] = message.number(group + "." + kKeys[i]);
  return out;
}

bool sane(const std::array<double, 6>& values) {
  return std::ranges::all_of(values, [](double v) { return std::isfinite(v) && std::abs(v) < 1e5; });
}

}  // namespace

Six FarMotion::Motion::at(double t) const {
  const double cruise = total - ramp, s = std::clamp(t, 0.0, total);
  double share = 0;  // a trapezoid of speed
  if (s < ramp)
    share = s * s / (2 * ramp) / cruise;
  else if (s > cruise)
    share = 1 - (total - s) * (total - s) / (2 * ramp) / cruise;
  else
    share = (s - ramp / 2) / cruise;
  const double place = share * static_cast<double>(path.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(place), path.size() - 2);
  Six out;
  for (std::size_t i = 0; i < 6; ++i)
    out[i] = path[low][i] + (place - static_cast<double>(low)) * (path[low + 1][i] - path[low][i]);
  return out;
}

Six FarMotion::now() const {
  return active_.empty() ? machine_.commanded() : active_.back().path.back();
}

Pose FarMotion::tool() const {
  const auto found = machine_.tools.find(machine_.tool);
  return found == machine_.tools.end() ? Pose{} : Machine::pose_of(found->second);
}

Pose FarMotion::frame() const {
  const auto found = machine_.frames.find(machine_.frame);
  return found == machine_.frames.end() ? Pose{} : Machine::pose_of(found->second);
}

int FarMotion::check_motion(const RmiMessage& message) const {
  const Name* motion = motion_named(message.name);
  if (!motion) return kRmiBadInstruction;
  const std::string type = message.text("SpeedType"), term = message.text("TermType");
  if (type != "mmSec" && type != "Percent" && type != "Time" && type != "mSec") return kRmiSpeedType;
  if (!motion->line && type == "mmSec") return kRmiSpeedType;
  const double speed = message.number("Speed");
  if (!(speed > 0) || speed > (type == "Percent" ? 100 : 100'000)) return kRmiSpeedValue;
  if (term != "FINE" && term != "CNT") return kRmiTermType;
  const double value = message.number("TermValue");
  if (term == "CNT" && !(value >= 0 && value <= 100)) return kRmiTermValue;
  const bool whole = motion->joints ? message.has("JointAngle.J1") : message.has("Position.X");
  if (!whole) return kRmiBadPosition;
  if (motion->circle && !message.has("ViaPosition.X")) return kRmiVia;
  if (!sane(values_of(message, "Position")) || !sane(values_of(message, "ViaPosition")))
    return kRmiBadPosition;
  return 0;
}

int FarMotion::add(const RmiMessage& message) {
  const auto sequence = message.whole("SequenceID", 0, 1 << 30);
  if (!sequence || *sequence != next_) return kRmiSequence;
  if (queue_.size() + active_.size() >= bounds::kRmiInstructions) return kRmiWaitInstruction;
  if (held_) return kRmiHold;
  Instruction out{message.name, Kind::motion, *sequence, message, 0};
  if (message.name == "FRC_WaitDIN") {
    out.kind = Kind::wait_input;
    if (!Machine::valid(message.whole("PortNumber", 1, Machine::kPorts).value_or(0))) return kRmiPort;
  } else if (message.name == "FRC_WaitTime") {
    out.kind = Kind::wait_time;
    out.left = message.number("Time", -1);
    if (!(out.left >= 0 && out.left <= 3600)) return kRmiBadValue;
  } else if (message.name == "FRC_SetUFrame" || message.name == "FRC_SetUTool") {
    out.kind = message.name == "FRC_SetUFrame" ? Kind::set_frame : Kind::set_tool;
    const char* key = out.kind == Kind::set_frame ? "FrameNumber" : "ToolNumber";
    if (!message.whole(key, 0, 20)) return out.kind == Kind::set_frame ? kRmiFrameNumber : kRmiToolNumber;
  } else if (const int error = check_motion(message); error != 0) {
    return error;
  }
  ++next_;
  queue_.push_back(std::move(out));
  return 0;
}

void FarMotion::clear(bool at_once) {
  queue_.clear();
  held_ = false;
  ending_ = !at_once && !active_.empty() && pace_ > 0;
  if (!ending_) active_.clear();
}

void FarMotion::finish(const std::string& name, int sequence, int error) {
  ++done_;
  finished_(name, sequence, error);
}

/// The Cartesian target of an instruction: of the face plate, in the world.
Pose FarMotion::tool_pose(const RmiMessage& message, const std::string& group, const Six& from) const {
  const std::array<double, 6> values = values_of(message, group);
  const bool relative = motion_named(message.name)->relative;
  if (!relative) return frame() * Machine::pose_of(values) * inverse(tool());
  std::array<double, 6> at = Machine::pose_values(inverse(frame()) * machine_.flange(from) * tool());
  for (std::size_t i = 0; i < 6; ++i) at[i] += values[i];
  return frame() * Machine::pose_of(at) * inverse(tool());
}

bool FarMotion::joints_of(const RmiMessage& message, const Six& from, Six& out) const {
  std::array<double, 6> values{};
  for (std::size_t i = 0; i < 6; ++i) values[i] = message.number("JointAngle.J" + std::to_string(i + 1));
  if (!sane(values)) return false;
  values[2] += values[1];  // this interface has joint 3 against the horizontal
  out = motion_named(message.name)->relative ? fanuc::add(from, values) : Six(values);
  const MachineFacts& facts = machine_.options().facts;
  for (std::size_t i = 0; i < 6; ++i)
    if (out[i] < facts.lower[i] || out[i] > facts.upper[i]) return false;
  return true;
}

bool FarMotion::plan_line(const Six& from, const Six& to, Motion& out) const {
  const Pose a = machine_.flange(from), b = machine_.flange(to);
  const double degrees = angle_between(a.rotation, b.rotation) * 180 / std::numbers::pi;
  const double length = 1000 * norm(b.position - a.position) + degrees;
  const int steps = std::clamp(static_cast<int>(std::ceil(length / kStep)), 1, kMostSteps);
  Six at = from;
  out.path.assign(1, from);
  for (int i = 1; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const Pose pose{a.position + t * (b.position - a.position), wire::between(a.rotation, b.rotation, t)};
    const auto joints = machine_.joints_for(pose, at);
    if (!joints) return false;
    for (std::size_t j = 0; j < 6; ++j)
      if (std::abs((*joints)[j] - at[j]) > kJump) return false;
    out.path.push_back(at = *joints);
  }
  return true;
}

bool FarMotion::plan_circle(const Six& from, const Pose& via, const Pose& to, Motion& out) const {
  const Pose a = machine_.flange(from);
  const auto circle = wire::Circle::through(a.position, via.position, to.position);
  if (!circle) return false;
  const double whole = circle->angle_of(to.position), length = 1000 * whole * norm(circle->arm);
  const int steps = std::clamp(static_cast<int>(std::ceil(length / kStep)), 2, kMostSteps);
  Six at = from;
  out.path.assign(1, from);
  for (int i = 1; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const Pose pose{circle->point(t * whole), wire::between(a.rotation, to.rotation, t)};
    const auto joints = machine_.joints_for(pose, at);
    if (!joints) return false;
    out.path.push_back(at = *joints);
  }
  return true;
}

/// `length`: mm.
int FarMotion::set_time(const RmiMessage& message, double length, Motion& out) const {
  const std::string type = message.text("SpeedType");
  const double speed = message.number("Speed");
  const MachineFacts& facts = machine_.options().facts;
  double least = 0;  // s, at the speed limits of the joints
  for (std::size_t k = 1; k < out.path.size(); ++k)
    for (std::size_t i = 0; i < 6; ++i)
      least = std::max(least, std::abs(out.path[k][i] - out.path[k - 1][i]) / facts.velocity[i]);
  least *= static_cast<double>(out.path.size() - 1);
  double time = least;
  if (type == "mmSec") time = length / std::min(speed, kMostSpeed);
  if (type == "Percent") time = least * 100 / speed;
  if (type == "Time") time = speed / 10;  // the interface counts it in tenths of a second
  if (type == "mSec") time = speed / 1000;
  out.ramp = kRamp;
  out.total = std::max(time, std::max(least, 1e-3)) + out.ramp;
  out.total = std::max(out.total, 2 * out.ramp);
  return 0;
}

int FarMotion::plan(const RmiMessage& message, Motion& out) const {
  const Name& motion = *motion_named(message.name);
  const Six from = now();
  Six to = from;
  if (motion.joints) {
    if (!joints_of(message, from, to)) return kRmiDestination;
  } else {
    const auto joints = machine_.joints_for(tool_pose(message, "Position", from), from);
    if (!joints) return kRmiDestination;
    to = *joints;
  }
  out.path = {from, to};
  double length = 1000 * norm(machine_.flange(to).position - machine_.flange(from).position);
  if (motion.circle) {
    if (!plan_circle(from, tool_pose(message, "ViaPosition", from), machine_.flange(to), out)) return kRmiVia;
    length = 0;
    for (std::size_t k = 1; k < out.path.size(); ++k)
      length +=
          1000 * norm(machine_.flange(out.path[k]).position - machine_.flange(out.path[k - 1]).position);
  } else if (motion.line && !plan_line(from, to, out)) {
    return kRmiDestination;
  }
  const double turned = angle_between(machine_.flange(from).rotation, machine_.flange(to).rotation);
  length = std::max(length, kTurnLength * turned * 180 / std::numbers::pi);
  out.blend = message.text("TermType") == "CNT" ? message.number("TermValue") / 100 : -1;
  return set_time(message, length, out);
}

/// True if the instruction is over, or became a motion.
bool FarMotion::begin(Instruction& one) {
  const bool standing = active_.empty();
  if (one.kind != Kind::motion && !standing) return false;
  int error = 0;
  if (one.kind == Kind::motion) {
    Motion motion;
    motion.name = one.name;
    motion.sequence = one.sequence;
    error = plan(one.message, motion);
    if (error == 0) {
      if (standing) base_ = machine_.commanded();
      active_.push_back(std::move(motion));
      return true;
    }
    held_ = true;  // after an error the program is on hold
  }
  if (one.kind == Kind::wait_input) {
    const int port = one.message.whole("PortNumber", 1, Machine::kPorts).value_or(1);
    if (machine_.input(port) != (one.message.text("PortValue") == "ON")) return false;
  }
  if (one.kind == Kind::wait_time && one.left > 0) return false;
  if (one.kind == Kind::set_frame) machine_.frame = one.message.whole("FrameNumber", 0, 20).value_or(0);
  if (one.kind == Kind::set_tool) machine_.tool = one.message.whole("ToolNumber", 0, 20).value_or(1);
  finish(one.name, one.sequence, error);
  return true;
}

/// Pauses and ends slow down on the path. False: nothing moves.
bool FarMotion::set_pace(double dt) {
  if (!machine_.may_move()) {
    held_ = !ending_;
    pace_ = 0;
  } else if (active_.empty()) {
    pace_ = held_ ? 0 : 1;
  } else {
    pace_ = std::clamp(pace_ + (held_ || ending_ ? -dt : dt) / kRamp, 0.0, 1.0);
  }
  if (ending_ && pace_ <= 0) clear(true);
  return pace_ > 0;
}

void FarMotion::cycle(double dt) {
  if (idle() || !set_pace(dt)) return;
  if (!queue_.empty() && active_.empty()) queue_.front().left -= dt;
  const bool room =
      active_.empty() || (active_.size() == 1 && active_[0].blend >= 0 &&
                          active_[0].total - active_[0].time <= active_[0].ramp * active_[0].blend);
  if (room && !held_ && !queue_.empty() && begin(queue_.front())) queue_.pop_front();
  if (active_.empty()) return;
  Six next = base_;
  for (Motion& motion : active_) {
    motion.time += dt * pace_ * machine_.override_percent / 100;
    next = fanuc::add(next, fanuc::add(motion.at(motion.time), motion.path.front(), -1));
  }
  machine_.drive(next);
  Motion& first = active_.front();
  const bool over = first.time >= first.total;
  double off = 0;
  for (std::size_t i = 0; i < 6; ++i) off = std::max(off, std::abs(machine_.q()[i] - next[i]));
  if (!over || (first.blend < 0 && off > kSettled)) return;
  base_ = fanuc::add(base_, fanuc::add(first.path.back(), first.path.front(), -1));
  const Motion done = std::move(first);
  active_.pop_front();
  if (!ending_) finish(done.name, done.sequence, 0);
}

}  // namespace polyarm::fanuc
