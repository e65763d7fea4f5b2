#include "polyarm/setup/relative_moves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {
namespace {

/// Beyond that, rad, a line would turn the other way round.
constexpr double kMostTurn = 3;

data::Value line_target(const data::Record& by, const Pose& here) {
  constexpr const char* kAxes[] = {"x", "y", "z", "rx", "ry", "rz"};
  double d[6]{};
  for (std::size_t k = 0; k < 6; ++k)
    if (const data::Value* value = by.find(kAxes[k])) d[k] = value->as_number()->value;
  const Vec3 turn{d[3], d[4], d[5]};
  const double angle = norm(turn);
  if (angle > kMostTurn)
    throw Error("turn-too-large",
                fmt::format("it would turn by {:.0f} deg; one line turns by less than half a turn",
                            angle * 180 / std::numbers::pi),
                "write two, each for half as long");
  Pose out = here;
  out.position = out.position + Vec3{d[0], d[1], d[2]};
  if (angle > 0) out.rotation = normalized(from_axis_angle((1 / angle) * turn, angle) * out.rotation);
  return data::Point{out, true};
}

data::Value joint_target(const data::Record& by, const CellRobot& robot, std::span<const double> joints) {
  data::JointState out;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto index = static_cast<std::size_t>(robot.model.actuated[j]);
    out.names.push_back(robot.model.joints[index].name);
    out.positions.push_back(joints[j]);
  }
  for (std::size_t i = 0; i < by.names.size(); ++i) {
    const auto at = std::find(out.names.begin(), out.names.end(), by.names[i]);
    if (at == out.names.end())
      throw Error("unknown-joint",
                  "'" + robot.entry.name + "' has no joint '" + by.names[i] + "'" +
                      did_you_mean(by.names[i], out.names),
                  "its joints are " + join(out.names, ", "));
    const auto j = static_cast<std::size_t>(at - out.names.begin());
    const data::Number& much = *by.values[i].as_number();
    const bool slides = robot.model.joints[static_cast<std::size_t>(robot.model.actuated[j])].type ==
                        description::JointType::prismatic;
    if ((much.dimension == Dimension::length) != slides)
      throw Error("bad-move",
                  "the joint '" + by.names[i] + "' " + (slides ? "slides" : "turns") + ": it has " +
                      (slides ? "a speed such as 20mm/s" : "an angular speed such as 10deg/s"),
                  {});
    out.positions[j] += much.value;
  }
  return out;
}

}  // namespace

bool is_relative(const program::Move& move) {
  return !move.of_base() && move.targets.size() == 1 && move.targets.front().value.as_record();
}

program::Move from_here(program::Move move, const data::Point& here, const CellRobot& robot,
                        std::span<const double> joints) {
  program::Move::Target& target = move.targets.front();
  const data::Record by = *target.value.as_record();
  target.value =
      move.kind == program::Move::Kind::line ? line_target(by, here.pose) : joint_target(by, robot, joints);
  move.around = false;  // it goes where it is sent
  return move;
}

}  // namespace polyarm::cell
