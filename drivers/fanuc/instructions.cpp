#include "drivers/fanuc/instructions.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "drivers/wire/six_axes.hpp"

namespace polyarm::fanuc {

using hardware::ForwardMove;

namespace {

constexpr const char* kFlags[] = {"Front", "Up", "Left", "Flip", "Turn4", "Turn5", "Turn6"};
using Pairs = std::vector<std::pair<const char*, double>>;

Pairs pose_group(const Pose& pose, bool with_extra_axes) {
  const Vec3 wpr = to_rpy(pose.rotation);
  Pairs out{{"X", 1000 * pose.position.x}, {"Y", 1000 * pose.position.y}, {"Z", 1000 * pose.position.z},
            {"W", wpr.x * wire::kDegrees}, {"P", wpr.y * wire::kDegrees}, {"R", wpr.z * wire::kDegrees}};
  if (with_extra_axes)
    for (const char* one : {"Ext1", "Ext2", "Ext3"}) out.emplace_back(one, 0);
  return out;
}

Pairs joint_group(const ForwardMove& move) {
  constexpr const char* kKeys[] = {"J1", "J2", "J3", "J4", "J5", "J6"};
  Six q;
  std::copy_n(move.joints.begin(), 6, q.begin());
  q = rmi_joints(q);
  Pairs out;
  for (std::size_t i = 0; i < 6; ++i) out.emplace_back(kKeys[i], q[i]);
  for (const char* one : {"J7", "J8", "J9"}) out.emplace_back(one, 0);
  return out;
}

Pairs configuration_group(const Configuration& configuration, int tool) {
  Pairs out{{"UToolNumber", tool}, {"UFrameNumber", 0}};
  for (std::size_t i = 0; i < configuration.values.size(); ++i)
    out.emplace_back(kFlags[i], configuration.values[i]);
  return out;
}

/// Of the TCP in the controller's world frame.
Pose controller_pose(const Pose& T_world_tcp, const InstructionFrame& frame) {
  Pose out = inverse(frame.base) * T_world_tcp;
  out.position.z -= frame.world_height;
  return out;
}

/// The interface has whole numbers; a robot that is a little slower keeps the limits of the plan.
double whole(double value) {
  return std::max(1.0, std::floor(value + 1e-3));
}

void add_speed(const ForwardMove& move, RmiLine& line) {
  if (move.kind == ForwardMove::Kind::joint)
    line.text("SpeedType", "Percent").number("Speed", std::min(whole(100 * move.share), 100.0));
  else if (move.speed > 0)
    line.text("SpeedType", "mmSec").number("Speed", whole(1000 * move.speed));
  else
    line.text("SpeedType", "mSec").number("Speed", std::max(1.0, std::round(1000 * move.duration)));
}

}  // namespace

Configuration configuration_of(const RmiMessage& answer) {
  Configuration out;
  for (std::size_t i = 0; i < out.values.size(); ++i)
    out.values[i] = answer.whole(std::string("Configuration.") + kFlags[i], -10, 10).value_or(0);
  return out;
}

Pose tool_of(const ForwardMove& move, const InstructionFrame& frame) {
  Six q;
  std::copy_n(move.joints.begin(), 6, q.begin());
  return inverse(frame.flange->forward(q)) * inverse(frame.base) * move.at;
}

Six rmi_joints(const Six& radians) {
  Six out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = radians[i] * wire::kDegrees;
  out[2] -= out[1];
  return out;
}

Six radians_of(const Six& joints) {
  Six out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = joints[i] / wire::kDegrees;
  out[2] += out[1];
  return out;
}

int cnt_of(const ForwardMove& move, double ramp) {
  const double slowing = move.speed * ramp / 2;  // m
  if (!(move.blend > 0)) return 0;
  return slowing > move.blend ? static_cast<int>(100 * std::sqrt(move.blend / slowing)) : 100;
}

RmiLine instruction_of(const ForwardMove& move, const InstructionFrame& frame, int sequence, bool fine,
                       const Configuration& configuration) {
  constexpr const char* kNames[] = {"FRC_JointMotionJRep", "FRC_LinearMotionJRep", "FRC_CircularMotion"};
  RmiLine out("Instruction", kNames[static_cast<std::size_t>(move.kind)]);
  out.number("SequenceID", sequence);
  if (move.kind == ForwardMove::Kind::arc) {
    const Pairs flags = configuration_group(configuration, frame.tool);
    out.group("Configuration", flags).group("Position", pose_group(controller_pose(move.at, frame), true));
    out.group("ViaConfiguration", flags)
        .group("ViaPosition", pose_group(controller_pose(move.via, frame), true));
  } else {
    out.group("JointAngle", joint_group(move));
  }
  add_speed(move, out);
  const int cnt = fine || move.stops ? 0 : cnt_of(move, frame.ramp);
  out.text("TermType", cnt > 0 ? "CNT" : "FINE").number("TermValue", cnt);
  if (move.acceleration < 1) out.number("ACC", std::max(1.0, std::round(100 * move.acceleration)));
  return out;
}

RmiLine tool_line(const Pose& tool, const InstructionFrame& frame) {
  return RmiLine("Command", "FRC_WriteUToolData")
      .number("ToolNumber", frame.tool)
      .group("Frame", pose_group(tool, false));
}

}  // namespace polyarm::fanuc
