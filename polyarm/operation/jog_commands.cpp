#include "polyarm/operation/jog_commands.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/frame_chain.hpp"
#include "polyarm/operation/point_edits.hpp"

namespace polyarm::cell {

using jog::JogCommand;
using jog::JogHold;
using protocol::Any;
using protocol::Map;

namespace {

using Kind = jog::JogSetpoint::Kind;

constexpr double kMostHold = 10;
constexpr double kMostJogged = 1e6;       // a larger distance or speed is a mistake
constexpr double kTargetRounding = 1e-4;  // rad or m; rounding of numbers in messages

std::string short_name(const controllers::JointFacts& joint) {
  return joint.name.substr(joint.name.find('/') + 1);
}

const char* such_as(Dimension dimension) {
  switch (dimension) {
    case Dimension::angle:
      return "write such as 5deg; a bare number is in rad";
    case Dimension::length:
      return "write such as 20mm; a bare number is in m";
    case Dimension::angular_speed:
      return "write such as 10deg/s; a bare number is in rad/s";
    default:
      return "write such as 50mm/s; a bare number is in m/s";
  }
}

/// Accepts a number in SI units, or text with a unit.
double jog_quantity(const Any& value, const std::string& of, Dimension dimension) {
  std::optional<double> number = value.number();
  if (const auto text = value.text()) number = parse_quantity(*text, dimension);
  if (number && std::abs(*number) > kMostJogged)
    throw Error("beyond-limits", "'" + of + "' gets a command for " + format_number(*number),
                "robots move by a few m or rad, at a few m/s or rad/s");
  if (number && std::isfinite(*number)) return *number;
  throw Error("bad-argument",
              "'" + of + "' is " + value.text().value_or(value.dump()) + ", not " + name(dimension),
              such_as(dimension));
}

/// {elbow_joint: 0.2} → one value per joint; `absent` for joints that are not named.
jog::JogValues joint_values(const CellRobot& robot, const Map& map, bool rates, double absent) {
  jog::JogValues out;
  out.fill(absent);
  std::vector<std::string> names;
  for (const controllers::JointFacts& joint : robot.joints) names.push_back(short_name(joint));
  for (const auto& [key, value] : map) {
    auto found = std::find(names.begin(), names.end(), key);
    if (found == names.end() && key.starts_with(robot.entry.name + "/"))
      found = std::find(names.begin(), names.end(), key.substr(robot.entry.name.size() + 1));
    if (found == names.end())
      throw Error("unknown-joint",
                  "'" + robot.entry.name + "' has no joint '" + key + "'" + did_you_mean(key, names),
                  "it has: " + join(names, ", "));
    const auto j = static_cast<std::size_t>(found - names.begin());
    const bool slides = robot.facts->chain.slides(j);
    const Dimension dimension = rates ? (slides ? Dimension::speed : Dimension::angular_speed)
                                      : (slides ? Dimension::length : Dimension::angle);
    out[j] = jog_quantity(value, key, dimension);
  }
  return out;
}

/// {z: 0.02, rx: 0.1} → a twist, or a translation and a rotation vector.
jog::Twist twist_values(const Map& map, bool rates) {
  const std::vector<std::string> names = {"x", "y", "z", "rx", "ry", "rz"};
  jog::Twist out{};
  for (const auto& [key, value] : map) {
    const auto found = std::find(names.begin(), names.end(), key);
    if (found == names.end())
      throw Error("bad-argument", "the TCP does not move along '" + key + "'" + did_you_mean(key, names),
                  "x, y, z (m) and rx, ry, rz (rad)");
    const auto k = static_cast<std::size_t>(found - names.begin());
    const Dimension dimension = k < 3 ? (rates ? Dimension::speed : Dimension::length)
                                      : (rates ? Dimension::angular_speed : Dimension::angle);
    out[k] = jog_quantity(value, key, dimension);
  }
  return out;
}

/// T_world_frame; gives the axes of the frame. A user's frame is a point of the cell's data, which may itself
/// be given in another frame.
Pose frame_of(const JogOwners& cell, const CellRobot& robot, const std::string& frame) {
  const data::Value* const value = cell.data.store.find(frame);
  if (frame == "world" || data::robot_frame(frame) || (value && value->as_point()))
    return frame_in_world(cell.setup, cell.data.store, frame, &robot, &cell.motions);
  std::vector<std::string> names = {"base", "world", "tool"};
  for (const std::string& known : cell.data.store.names())
    if (cell.data.store.find(known)->as_point()) names.push_back(known);
  throw Error("unknown-frame", "there is no frame '" + frame + "'" + did_you_mean(frame, names),
              "there are: " + join(names, ", "));
}

jog::Twist turned(const Quaternion& r, const jog::Twist& t) {
  const Vec3 v = r * Vec3{t[0], t[1], t[2]}, w = r * Vec3{t[3], t[4], t[5]};
  return {v.x, v.y, v.z, w.x, w.y, w.z};
}

Nanoseconds hold_of(const std::optional<double>& given) {
  const double hold = given.value_or(0.25);
  if (!(hold >= 0.02 && hold <= kMostHold))
    throw Error("bad-argument", "'hold' is " + format_number(hold) + " s",
                "a command is valid for 0.02 to 10 s");
  return nanoseconds(hold);
}

double speed_of(const std::optional<double>& given) {
  const double speed = given.value_or(1);
  if (!(speed > 0 && speed <= 1))
    throw Error("bad-argument", "'speed' is " + format_number(speed), "a fraction of the maximum: 0.01 to 1");
  return speed;
}

}  // namespace

std::string which_text(const JogOwners& cell, std::size_t index, JogHold hold, std::int32_t which) {
  const CellRobot& robot = *cell.setup.robots[index];
  const auto i = static_cast<std::size_t>(std::max(which, 0));
  if (hold == JogHold::joint_limit && i < robot.joints.size()) return short_name(robot.joints[i]);
  if (hold == JogHold::workspace && i < robot.facts->workspace.zones().size())
    return robot.facts->workspace.zones()[i].name;
  if (hold == JogHold::body) return cell.jogging.barrier_name(index, which);
  return "";
}

std::string reason_text(const JogOwners& cell, std::size_t robot, JogHold hold, std::int32_t which) {
  if (hold == JogHold::none) return "";
  const std::string what = which_text(cell, robot, hold, which);
  if (hold == JogHold::body) return what.empty() ? "something is near" : "near " + what;
  if (!what.empty()) return std::string(name(hold)) + " " + what;
  if (hold == JogHold::direction) return "direction: the arm has too few joints for it";
  return name(hold);
}

protocol::JogAnswer jog_answer(const JogOwners& cell, std::size_t i) {
  const CellRobot& robot = *cell.setup.robots[i];
  const jog::JogStatus status = cell.jogging.status(i);
  const bool ours = cell.jogging.engaged(i);
  protocol::JogAnswer out;
  std::vector<double> q;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const auto index = cell.machine.table().find_state(robot.joints[j].name + "/position");
    const std::string name = short_name(robot.joints[j]);
    q.push_back(ours ? status.joints[j] : index ? cell.machine.snapshot().states[*index] : 0.0);
    out.joints[name] = q.back();
    out.names.push_back(name);
    out.slides.push_back(robot.facts->chain.slides(j));
    const double lower = robot.joints[j].lower, upper = robot.joints[j].upper;
    auto& limits = out.limits[name];
    if (std::isfinite(lower) && std::isfinite(upper) && upper - lower < 1e6)
      limits.emplace(std::array{lower, upper});
  }
  const Pose tcp = robot.facts->chain.forward(q);
  const bool going = ours && status.session != 0 && !status.standing;
  out.robot = robot.entry.name;
  out.model = robot.entry.model;
  out.tool = robot.entry.tool;
  out.position = tcp.position;
  out.rpy = to_rpy(tcp.rotation);
  out.orientation = tcp.rotation;
  out.speed = ours ? status.tcp_speed : 0.0;
  out.moving = ours && !status.standing;
  out.held_back = going ? name(status.hold) : "none";
  out.reason = going ? reason_text(cell, i, status.hold, status.which) : "";
  out.which = going ? which_text(cell, i, status.hold, status.which) : "";
  out.profile = cell.motions.profile();
  out.control = control_holder(cell.programs, cell.jogging);
  return out;
}

JogCommand jog_command(const JogOwners& cell, const CellRobot& robot, const protocol::JogMotion& request) {
  JogCommand out;
  out.hold = hold_of(request.hold);
  out.by = request.by;
  out.wish.speed = speed_of(request.speed);
  if (request.joints.has_value() == request.tcp.has_value())
    throw Error("bad-argument", request.joints ? "jog moves joints or the TCP, not both" : "jog what?",
                "'joints': {elbow_joint: 0.1} or 'tcp': {z: 0.02}, in rad/s or m/s; with 'by', in rad or m");
  if (request.joints) {
    out.wish.kind = out.by ? Kind::joint_target : Kind::joint_velocity;
    out.wish.joints = joint_values(robot, *request.joints, !out.by, 0);
    return out;
  }
  out.wish.kind = out.by ? Kind::tcp_target : Kind::tcp_velocity;
  const std::string frame = request.frame.value_or("base");
  out.wish.twist = twist_values(*request.tcp, !out.by);
  out.wish.tool_frame = frame == "tool";
  if (!out.wish.tool_frame) out.wish.twist = turned(frame_of(cell, robot, frame).rotation, out.wish.twist);
  return out;
}

std::uint32_t session_of(const std::optional<double>& given) {
  const double number = given.value_or(0);
  if (!(number >= 0 && number < 4e9 && number == std::floor(number)))
    throw Error("bad-argument", "'session' is " + format_number(number),
                "use the number from an earlier answer");
  return static_cast<std::uint32_t>(number);
}

namespace {

Pose desired_pose(const JogOwners& cell, std::size_t i, const protocol::FollowTarget& request) {
  const CellRobot& robot = *cell.setup.robots[i];
  const Map& map = *request.pose;
  const std::vector<std::string> known = {"position", "orientation", "rpy"};
  for (const auto& [key, value] : map)
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw Error("bad-argument", "a pose has no '" + key + "'" + did_you_mean(key, known));
  const auto numbers = [&](const char* key, std::size_t count) {
    const nlohmann::json& list = map.at(key).json();
    std::vector<double> out;
    if (list.is_array())
      for (const nlohmann::json& item : list)
        if (item.is_number() && std::abs(item.get<double>()) <= kMostJogged)
          out.push_back(item.get<double>());
    if (out.size() != count)
      throw Error("bad-argument",
                  std::string("'") + key + "' of the pose must be " + std::to_string(count) + " numbers");
    return out;
  };
  Pose out = cell.jogging.last_target(i, session_of(request.session));
  const Pose frame = frame_of(cell, robot, request.frame.value_or("world"));
  out = inverse(frame) * out;  // parts that are not given keep their value
  if (map.contains("position")) {
    const auto p = numbers("position", 3);
    out.position = {p[0], p[1], p[2]};
  }
  if (map.contains("orientation")) {
    const auto q = numbers("orientation", 4);
    if (std::abs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) > 1e-3)
      throw Error("bad-argument", "'orientation' of the pose is not a unit quaternion x y z w");
    out.rotation = normalized(Quaternion{q[0], q[1], q[2], q[3]});
  } else if (map.contains("rpy")) {
    const auto r = numbers("rpy", 3);
    out.rotation = from_rpy(r[0], r[1], r[2]);
  }
  return frame * out;
}

/// Throws if a target is outside the limits of a joint. A joint that is already outside may stay there or
/// move back.
void require_within_limits(const JogOwners& cell, std::size_t i, const jog::JogValues& wanted) {
  const CellRobot& robot = *cell.setup.robots[i];
  Problems problems;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const controllers::JointFacts& joint = robot.joints[j];
    if (!std::isfinite(wanted[j]) || joint.continuous || !(joint.lower <= joint.upper)) continue;
    const auto place = cell.machine.table().find_state(joint.name + "/position");
    const double at = place ? cell.machine.snapshot().states[*place] : NAN;
    const double lower = std::isfinite(at) ? std::min(joint.lower, at) : joint.lower;
    const double upper = std::isfinite(at) ? std::max(joint.upper, at) : joint.upper;
    if (wanted[j] >= lower - kTargetRounding && wanted[j] <= upper + kTargetRounding) continue;
    problems.error("beyond-limits", {},
                   "'" + short_name(joint) + "' gets a command for a position of " +
                       format_number(wanted[j]) + "; its limits are " + format_number(joint.lower) + " to " +
                       format_number(joint.upper),
                   "command a position within them, rad or m");
  }
  problems.throw_if_errors();
}

}  // namespace

JogCommand target_command(const JogOwners& cell, std::size_t i, const protocol::FollowTarget& request) {
  JogCommand command;
  command.hold = hold_of(request.hold);
  command.wish.speed = speed_of(request.speed);
  if (request.joints.has_value() == request.pose.has_value())
    throw Error("bad-argument",
                request.joints ? "a target is joints or a pose, not both" : "the target of what?",
                "'joints': {elbow_joint: 1.2}, or 'pose': {position: [x, y, z], orientation: [x, y, z, w]}");
  if (request.joints) {
    command.wish.kind = Kind::joint_target;
    command.wish.joints = joint_values(*cell.setup.robots[i], *request.joints, false, NAN);
    require_within_limits(cell, i, command.wish.joints);
  } else {
    command.wish.kind = Kind::tcp_target;
    command.wish.target = desired_pose(cell, i, request);
  }
  return command;
}

const char* control_holder(const Programs& programs, const Jogging& jogging) {
  if (jogging.engaged()) return "jog";
  return programs.runs() ? "program" : "nobody";
}

}  // namespace polyarm::cell
