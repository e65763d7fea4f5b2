#pragma once
/// The collision bodies that physics uses for contacts, and what has no body. Any thread.
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/description/scene.hpp"
#include "polyarm/setup/robots.hpp"
#include "polyarm/surroundings/bodies.hpp"

namespace polyarm::cell {

/// True if physics checks this robot for contacts.
bool checks_contacts(const CellRobot& robot);
/// Builds convex pieces of the collision meshes and tool meshes of robots that physics simulates. Reads the
/// disk and may take seconds the first time. Adds a warning for each mesh that cannot be read.
void make_robot_bodies(const CellRobots& robots, Problems& problems);
/// The same for the fixtures and parts of the scene, if physics simulates a robot. Warns of parts that are
/// inside something where they start.
void make_scene_bodies(const CellRobots& robots, description::Scene& scene, Problems& problems);

/// Robots and scene of a cell as contacts see them, whatever its hardware. Copies, so that their meshes can get
/// their pieces beside a running cell. Const once it is made: any thread.
struct ContactBodies {
  std::vector<description::RobotModel> models;
  std::vector<description::Tool> tools;
  description::Scene scene;
  std::vector<surroundings::Robot> robots;  ///< in the order of the cell; refer to models and tools
  std::vector<Problem> warnings;            ///< meshes that cannot be read, and bodies that are missing
};
/// Reads the disk; takes milliseconds, the first time for a mesh seconds. Throws Error for a robot that has too
/// many bodies, or shapes that are not finite.
std::shared_ptr<const ContactBodies> contact_bodies(const CellRobots& robots, const description::Scene& scene);
/// One for each robot, tool and fixture that passes through everything: a warning of code no-contacts (robot,
/// driver), links-without-body (robot, count, all, links), tool-without-body (robot, tool) or
/// fixture-without-body (fixture).
std::vector<Problem> unchecked_bodies(const CellRobots& robots, const description::Scene& scene);
/// The texts of the problems.
std::vector<std::string> sentences(const std::vector<Problem>& problems);
/// Problems with masses and efforts of the robots that physics simulates, one sentence each: values that look
/// like placeholders, and efforts that do not hold the robot at the start.
std::vector<std::string> physics_notes(const CellRobots& robots);
/// Why gravity pulls a robot down in physics: the joints whose efforts do not hold it at the start, with
/// limits and torques. Empty if all do, or if physics does not simulate it. Takes milliseconds.
std::string why_it_sags(const CellRobot& robot);

}  // namespace polyarm::cell
