#include "polyarm/recording/state_messages.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace polyarm::recording {

namespace {

namespace msg = messages::geometry_msgs::msg;
constexpr std::int64_t kSecond = 1'000'000'000;

msg::Transform to_message(const Pose& pose) {
  return {{pose.position.x, pose.position.y, pose.position.z},
          {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w}};
}

Pose moved(const description::Joint& joint, double q) {
  if (joint.type == description::JointType::prismatic) return {q * joint.axis, {}};
  return {{}, from_axis_angle(joint.axis, q)};
}

double value(std::span<const double> states, int index) {
  const auto at = static_cast<std::size_t>(index);
  return index >= 0 && at < states.size() ? states[at] : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

messages::builtin_interfaces::msg::Time stamp_of(std::int64_t nanoseconds) {
  std::int64_t whole = nanoseconds / kSecond, part = nanoseconds % kSecond;
  if (part < 0) --whole, part += kSecond;
  return {static_cast<std::int32_t>(whole), static_cast<std::uint32_t>(part)};
}

msg::TransformStamped transform(const std::string& parent, const std::string& child, const Pose& pose) {
  msg::TransformStamped out;
  out.header.frame_id = parent;
  out.child_frame_id = child;
  out.transform = to_message(pose);
  return out;
}

std::string frame_of(const cell::CellRobot& robot, int link, bool several) {
  return (several ? robot.entry.name + "/" : "") + robot.model.links[static_cast<std::size_t>(link)].name;
}

namespace {
/// The robot on which it is mounted; null: none.
const cell::CellRobot* carrier_of(const cell::CellRobots& robots, const cell::CellRobot& robot) {
  for (const auto& each : robots)
    if (each->entry.name == robot.entry.on) return each.get();
  return nullptr;
}
}  // namespace

StateMessages::StateMessages(const cell::CellRobots& robots, const hardware::InterfaceTable& table,
                             const std::vector<bool>& drives) {
  for (std::size_t i = 0; i < robots.size(); ++i)
    add_robot(*robots[i], carrier_of(robots, *robots[i]), table, robots.size() > 1,
              i < drives.size() && drives[i]);
  const auto any = [&](int Measured::*what) {
    return std::any_of(measured_.begin(), measured_.end(),
                       [what](const Measured& each) { return each.*what >= 0; });
  };
  joints_.position.resize(measured_.size());
  if (any(&Measured::velocity)) joints_.velocity.resize(measured_.size());
  if (any(&Measured::effort)) joints_.effort.resize(measured_.size());
}

void StateMessages::add_robot(const cell::CellRobot& robot, const cell::CellRobot* carrier,
                              const hardware::InterfaceTable& table, bool several, bool drives) {
  const std::vector<description::Joint>& joints = robot.model.joints;
  const std::string prefix = several ? robot.entry.name + "/" : "";
  const auto frame = [&](int link) { return frame_of(robot, link, several); };
  const auto state = [&](const description::Joint& joint, const char* what) {
    const auto index = table.find_state(robot.entry.name + "/" + joint.name + "/" + what);
    return index ? static_cast<int>(*index) : -1;
  };
  if (carrier)
    fixed_.transforms.push_back(transform(frame_of(*carrier, carrier->model.root, several),
                                          frame(robot.model.root),
                                          inverse(carrier->entry.base) * robot.entry.base));
  else if (!drives && (several || frame(robot.model.root) != "world"))
    fixed_.transforms.push_back(transform("world", frame(robot.model.root), robot.entry.base));
  for (const description::Joint& joint : joints) {
    const std::string parent = frame(joint.parent_link), child = frame(joint.child_link);
    if (!joint.moves()) {
      fixed_.transforms.push_back(transform(parent, child, joint.origin));
      continue;
    }
    const Measured measured{state(joint, "position"), state(joint, "velocity"), state(joint, "effort")};
    if (measured.position >= 0) {
      joints_.name.push_back(prefix + joint.name);
      measured_.push_back(measured);
    }
    const description::Joint& followed =
        joint.mimic ? joints[static_cast<std::size_t>(joint.mimic->joint)] : joint;
    moving_.push_back({&joint, state(followed, "position")});
    frames_.transforms.push_back(transform(parent, child, joint.origin));
  }
}

const messages::sensor_msgs::msg::JointState& StateMessages::joint_states(std::span<const double> states,
                                                                          std::int64_t stamp) {
  joints_.header.stamp = stamp_of(stamp);
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    joints_.position[i] = value(states, measured_[i].position);
    if (!joints_.velocity.empty()) joints_.velocity[i] = value(states, measured_[i].velocity);
    if (!joints_.effort.empty()) joints_.effort[i] = value(states, measured_[i].effort);
  }
  return joints_;
}

const messages::tf2_msgs::msg::TFMessage& StateMessages::moving_frames(std::span<const double> states,
                                                                       std::int64_t stamp) {
  const auto time = stamp_of(stamp);
  for (std::size_t i = 0; i < moving_.size(); ++i) {
    const description::Joint& joint = *moving_[i].joint;
    double q = value(states, moving_[i].state);
    if (!std::isfinite(q)) q = 0;
    if (joint.mimic) q = joint.mimic->multiplier * q + joint.mimic->offset;
    frames_.transforms[i].header.stamp = time;
    frames_.transforms[i].transform = to_message(joint.origin * moved(joint, q));
  }
  return frames_;
}

}  // namespace polyarm::recording
