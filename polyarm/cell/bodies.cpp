#include "polyarm/cell/bodies.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/description/bodies.hpp"

namespace polyarm::cell {

namespace {
void add_robot(const CellRobot& robot, std::vector<std::string>& out) {
  const std::string& name = robot.entry.name;
  if (!checks_contacts(robot)) {
    out.push_back(fmt::format("{}: contacts are not detected, its hardware is {} (hardware: mujoco detects them)",
                              name, robot.driver));
    return;
  }
  const std::vector<std::string> links = description::links_without_body(robot.model);
  if (!links.empty())
    out.push_back(fmt::format(
        "{}: contacts of {} of {} links are not detected, as their collision is a mesh or missing: {}", name,
        links.size(), robot.model.links.size(), join(links, ", ")));
  if (robot.tool.name != "none" && !description::has_body(robot.tool.body) &&
      robot.tool.gripper != description::GripperKind::parallel)
    out.push_back(
        fmt::format("{}: contacts of its tool {} are not detected, as it has no body", name, robot.tool.name));
}
}  // namespace

bool checks_contacts(const CellRobot& robot) {
  if (robot.blocks.empty()) return robot.driver == "mujoco";
  return std::any_of(robot.blocks.begin(), robot.blocks.end(),
                     [](const HardwareBlock& block) { return block.driver == "mujoco"; });
}

std::vector<std::string> unchecked_bodies(const CellRobots& robots, const description::Scene& scene) {
  std::vector<std::string> out;
  for (const auto& robot : robots) add_robot(*robot, out);
  for (const description::Fixture& fixture : scene.fixtures)
    if (!fixture.shapes.empty() && !description::has_body(fixture.shapes))
      out.push_back("fixture " + fixture.name + ": contacts are not detected, as its shape is a mesh");
  return out;
}

std::vector<std::string> placeholder_notes(const CellRobots& robots) {
  std::vector<std::string> out;
  for (const auto& robot : robots)
    if (checks_contacts(*robot))
      for (const std::string& text : description::placeholders(robot->model))
        out.push_back(robot->entry.name + ": " + text);
  return out;
}

}  // namespace polyarm::cell
