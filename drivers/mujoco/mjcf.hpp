#pragma once
/// Writes the world of a cell as MJCF text, the model language of MuJoCo. SI units. Allocates; not for the
/// control thread.
#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/force_sensor.hpp"

namespace polyarm::drivers {

/// Names of objects in the model. Robots, parts, slots and movers are numbered.
std::string joint_name(std::size_t robot, int joint);
std::string link_name(std::size_t robot, int link);
std::string finger_name(std::size_t robot, int side);
inline std::string tool_name(std::size_t robot) {
  return "tool" + std::to_string(robot);
}
inline std::string held_name(std::size_t robot) {
  return "held" + std::to_string(robot);
}
inline std::string base_name(std::size_t robot) {
  return "base" + std::to_string(robot);
}
inline std::string twin_name(std::size_t part) {
  return "twin" + std::to_string(part);
}
inline std::string slot_name(std::size_t slot) {
  return "slot" + std::to_string(slot);
}
/// The geoms of a twin, a slot or a held part follow each other; the first has the name of its owner.
inline std::string piece_name(const std::string& owner, std::size_t piece) {
  return piece == 0 ? owner : owner + "_" + std::to_string(piece);
}
/// How many geoms the part takes: the convex pieces of its mesh, or one.
inline std::size_t pieces_of(const description::Part& part) {
  return std::max<std::size_t>(1, part.shape.pieces.size());
}
/// The most of any part. All slots have as many geoms, so that each can take the shape of any part.
std::size_t most_pieces(const description::Scene* scene);
inline std::string mover_name(std::size_t mover) {
  return "mover" + std::to_string(mover);
}
/// A belt is a heavy body that slides or turns; each physics step gives it its velocity and puts it back.
inline std::string belt_name(std::size_t belt) {
  return "belt" + std::to_string(belt);
}
inline std::string fixture_name(std::size_t fixture, std::size_t shape) {
  return "fixture" + std::to_string(fixture) + "_" + std::to_string(shape);
}

/// The grouping of a robot's links into rigid bodies.
struct Rigid {
  std::vector<int> body_of_link;  ///< for each link the link whose body carries it: itself, or one that it is
                                  ///< fixed to
};
Rigid rigid_links(const description::RobotModel& model);

/// True if the robot stands on the floor instead of being bolted down. One of its <ros2_control> blocks then
/// has `<param name="base">free</param>`, and its links may touch the floor.
bool is_freestanding(const hardware::RobotInstance& robot);
/// Joints of the model that the controller of its base names (`wheel_joints` of a block: their indices).
std::vector<int> wheel_joints(const hardware::RobotInstance& robot);
/// A force/torque sensor between a link and the one that carries it (hardware/force_sensor.hpp).
struct ForceSensor {
  std::string name;  ///< as the description has it
  int link = -1;     ///< its axes and its origin are those of this link, which is not the root
  hardware::ForceSensorErrors errors{};
};
std::vector<ForceSensor> force_sensors(const hardware::RobotInstance& robot);

/// The robot among `robots` that `on NAME` of this one names; null: none.
const hardware::RobotInstance* carrier_of(const hardware::RobotInstance& robot,
                                          std::span<const hardware::RobotInstance> robots);

/// A mimic joint: its position is `multiplier` times that of `source` plus `offset`. Chains are resolved to
/// the independent joint. Indices of RobotModel::joints.
struct Follower {
  int joint = -1, source = -1;
  double multiplier = 1, offset = 0;
};
std::vector<Follower> followers(const description::RobotModel& model);

/// How many contacts a world may have, and how many rows their constraints may take (four each, friction and
/// limits of joints beside them). Parts at rest do not touch each other. `geoms`: of each slot; several of
/// them touch at once. Memory grows with the square of the rows, so many slots get no more for their geoms.
struct Capacity {
  int rows, contacts;
};
inline Capacity capacity_of(std::size_t slots, std::size_t geoms = 1) {
  constexpr std::size_t kTouching = 4, kMany = 64;
  const std::size_t each =
      std::clamp<std::size_t>(kMany / std::max<std::size_t>(slots, 1), 1, std::min(geoms, kTouching));
  const int shares = static_cast<int>(slots * each);
  return {600 + 60 * shares, 120 + 12 * shares};
}

/// The whole model with `slots` free bodies for moving parts. Parts at rest are mocap twins without degrees
/// of freedom. In the model with one slot for each part, slot i has the shape and mass of part i; geoms
/// beyond its pieces touch nothing. `excluded`: pairs of bodies of a robot that overlap at the start, because
/// their enclosing shapes are loose.
using BodyPairs = std::vector<std::pair<std::string, std::string>>;
std::string write_mjcf(const hardware::ComponentContext& context, double timestep, std::size_t slots,
                       const BodyPairs& excluded, Capacity capacity);

}  // namespace polyarm::drivers
