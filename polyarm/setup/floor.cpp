#include "polyarm/setup/floor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace polyarm::cell {
namespace {

constexpr double kInside = 1e-4, kBelow = 0.01;  // m

/// How far a shape extends below its origin, m; `up` is the world's z in the shape's frame.
double depth_of(const description::Shape& shape, const Vec3& up) {
  const double along = std::abs(up.z), across = std::sqrt(std::max(0.0, 1 - up.z * up.z));
  switch (shape.kind) {
    case description::ShapeKind::box:
      return (std::abs(up.x) * shape.size.x + std::abs(up.y) * shape.size.y + along * shape.size.z) / 2;
    case description::ShapeKind::cylinder:
      return along * shape.length / 2 + across * shape.radius;
    case description::ShapeKind::sphere:
      return shape.radius;
    case description::ShapeKind::capsule:
      return along * shape.length / 2 + shape.radius;
    case description::ShapeKind::mesh: {
      double lowest = std::numeric_limits<double>::infinity();
      for (const auto& piece : shape.pieces)
        for (const Vec3& corner : piece) lowest = std::min(lowest, dot(up, corner));
      return -lowest;
    }
  }
  return 0;
}

/// Is there a joint that moves between the link and the root?
bool moves(const description::RobotModel& model, std::size_t link) {
  for (int joint = model.links[link].parent_joint; joint >= 0;) {
    const description::Joint& at = model.joints[static_cast<std::size_t>(joint)];
    if (at.moves()) return true;
    joint = model.links[static_cast<std::size_t>(at.parent_link)].parent_joint;
  }
  return false;
}

}  // namespace

bool is_freestanding(const CellRobot& robot) {
  return std::any_of(robot.blocks.begin(), robot.blocks.end(), [](const HardwareBlock& block) {
    const auto base = block.info->parameters.find("base");
    return base != block.info->parameters.end() && base->second == "free";
  });
}

double lowest_point(const CellRobot& robot) {
  double lowest = std::numeric_limits<double>::infinity();
  if (is_freestanding(robot)) return lowest;
  const kinematics::Chain chain(robot.model, robot.model.root, robot.entry.base);
  std::vector<Pose> poses(chain.links());
  chain.link_poses(robot.start, poses);
  for (std::size_t i = 0; i < robot.model.links.size(); ++i) {
    if (!moves(robot.model, i)) continue;
    for (const description::Shape& shape : robot.model.links[i].collisions) {
      const Pose at = poses[i] * shape.pose;
      lowest = std::min(lowest, at.position.z - depth_of(shape, inverse(at.rotation) * Vec3{0, 0, 1}));
    }
  }
  return lowest;
}

description::Scene scene_without_file(const CellRobots& robots, std::vector<std::string>& notes) {
  description::Scene scene;
  for (const auto& robot : robots) {
    const double lowest = lowest_point(*robot);
    if (!(lowest < scene.floor_height - kInside)) continue;
    scene.floor_height = std::floor(lowest / kBelow - 1) * kBelow;
    notes.push_back(
        fmt::format("{}: starts {:.3f} m below its base, so the floor is at z = {:.2f} m (a scene says where "
                    "it is)",
                    robot->entry.name, robot->entry.base.position.z - lowest, scene.floor_height));
  }
  return scene;
}

}  // namespace polyarm::cell
