#include "polyarm/setup/bodies.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/description/bodies.hpp"
#include "polyarm/hulls/robot_bodies.hpp"
#include "polyarm/moves/holding.hpp"

namespace polyarm::cell {

namespace {
Problem unchecked(const char* code, std::string what, Facts facts) {
  return {code, {}, std::move(what), {}, Severity::warning, std::move(facts)};
}

void add_robot(const CellRobot& robot, std::vector<Problem>& out) {
  const std::string& name = robot.entry.name;
  if (!checks_contacts(robot)) {
    out.push_back(unchecked(
        "no-contacts",
        fmt::format("{}: contacts are not detected, its hardware is {} (hardware: mujoco detects them)", name,
                    robot.driver),
        {{"robot", name}, {"driver", robot.driver}}));
    return;
  }
  const std::vector<std::string> links = description::links_without_body(robot.model);
  if (!links.empty())
    out.push_back(unchecked(
        "links-without-body",
        fmt::format(
            "{}: contacts of {} of {} links are not detected, as they have no <collision> or its mesh could not be read: {}",
            name, links.size(), robot.model.links.size(), join(links, ", ")),
        {{"robot", name},
         {"count", static_cast<double>(links.size())},
         {"all", static_cast<double>(robot.model.links.size())},
         {"links", join(links, ", ")}}));
  if (robot.tool.name != "none" && !description::has_body(robot.tool.body) &&
      robot.tool.gripper != description::GripperKind::parallel)
    out.push_back(unchecked(
        "tool-without-body",
        fmt::format("{}: contacts of its tool {} are not detected, as it has no body", name, robot.tool.name),
        {{"robot", name}, {"tool", robot.tool.name}}));
}

void make(const std::vector<description::Shape*>& shapes, const std::string& of, const Location& where,
          Problems& problems) {
  for (Problem& problem : hulls::make_bodies(shapes, hulls::bodies_cache()).warnings) {
    problem.what = of + ": " + problem.what;
    if (problem.where.file.empty()) problem.where = where;
    problems.add(std::move(problem));
  }
}
}  // namespace

void make_robot_bodies(const CellRobots& robots, Problems& problems) {
  for (const auto& robot : robots) {
    if (!checks_contacts(*robot)) continue;
    std::vector<description::Shape*> shapes;
    for (description::Link& link : robot->model.links)
      for (description::Shape& shape : link.collisions) shapes.push_back(&shape);
    for (description::Shape& shape : robot->tool.body) shapes.push_back(&shape);
    make(shapes, robot->entry.name, robot->entry.where, problems);
  }
}

void make_scene_bodies(const CellRobots& robots, description::Scene& scene, Problems& problems) {
  if (std::none_of(robots.begin(), robots.end(), [](const auto& robot) { return checks_contacts(*robot); })) return;
  for (description::Fixture& fixture : scene.fixtures) {
    std::vector<description::Shape*> shapes;
    for (description::Shape& shape : fixture.shapes) shapes.push_back(&shape);
    make(shapes, "fixture " + fixture.name, {}, problems);
  }
}

bool checks_contacts(const CellRobot& robot) {
  if (robot.blocks.empty()) return robot.driver == "mujoco";
  return std::any_of(robot.blocks.begin(), robot.blocks.end(),
                     [](const HardwareBlock& block) { return block.driver == "mujoco"; });
}

std::vector<Problem> unchecked_bodies(const CellRobots& robots, const description::Scene& scene) {
  std::vector<Problem> out;
  for (const auto& robot : robots) add_robot(*robot, out);
  for (const description::Fixture& fixture : scene.fixtures)
    if (!fixture.shapes.empty() && !description::has_body(fixture.shapes))
      out.push_back(
          unchecked("fixture-without-body",
                    "fixture " + fixture.name + ": contacts are not detected, as its mesh could not be read",
                    {{"fixture", fixture.name}}));
  return out;
}

std::vector<std::string> sentences(const std::vector<Problem>& problems) {
  std::vector<std::string> out;
  for (const Problem& problem : problems) out.push_back(problem.what);
  return out;
}

std::vector<std::string> physics_notes(const CellRobots& robots) {
  std::vector<std::string> out;
  for (const auto& robot : robots) {
    if (!checks_contacts(*robot)) continue;
    for (const std::string& text : description::placeholders(robot->model))
      out.push_back(robot->entry.name + ": " + text);
    if (const std::string why = why_it_falls(*robot); !why.empty()) out.push_back(why);
  }
  return out;
}

std::string why_it_falls(const CellRobot& robot) {
  if (!checks_contacts(robot)) return {};
  const moves::Payload load = moves::joined(
      {robot.tool.mass, robot.tool.center},
      {robot.entry.payload.mass, robot.entry.payload.center.value_or(robot.tool.tcp.position)});
  std::vector<std::string> weak;
  for (const moves::Overload& over :
       moves::overloads_at(robot.model, robot.entry.base, load, robot.start)) {
    const int index = robot.model.actuated[over.joint];
    const description::Joint& joint = robot.model.joints[static_cast<std::size_t>(index)];
    const char* unit = joint.type == description::JointType::prismatic ? "N" : "N m";
    weak.push_back(fmt::format("{} (effort limit {:.4g} {}, gravity takes {:.3g} {})", joint.name, over.limit, unit,
                               over.torque, unit));
  }
  if (weak.empty()) return {};
  return robot.entry.name + ": it falls in physics, as its efforts do not hold it at the start: " + join(weak, ", ");
}

}  // namespace polyarm::cell
