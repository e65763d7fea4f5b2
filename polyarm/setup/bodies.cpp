#include "polyarm/setup/bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "polyarm/base/text.hpp"
#include "polyarm/description/bodies.hpp"
#include "polyarm/moves/holding.hpp"
#include "polyarm/setup/floor.hpp"
#include "polyarm/surroundings/at_start.hpp"
#include "polyarm/surroundings/bodies.hpp"

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

}  // namespace

void make_robot_bodies(const CellRobots& robots, Problems& problems) {
  for (const auto& robot : robots) {
    if (!checks_contacts(*robot)) continue;
    Problems found;
    surroundings::make_meshes(robot->model, robot->tool, robot->entry.name, found);
    for (Problem problem : found.list()) {
      if (problem.where.file.empty()) problem.where = robot->entry.where;
      problems.add(std::move(problem));
    }
  }
}

void make_scene_bodies(const CellRobots& robots, description::Scene& scene, Problems& problems) {
  if (std::any_of(robots.begin(), robots.end(), [](const auto& robot) { return checks_contacts(*robot); }))
    surroundings::make_meshes(scene, problems);
  for (Problem& problem : surroundings::parts_inside(scene)) problems.add(std::move(problem));
  for (Problem& problem : surroundings::belts_blocked(scene)) problems.add(std::move(problem));
}

bool checks_contacts(const CellRobot& robot) {
  if (robot.blocks.empty()) return robot.driver == "mujoco";
  return std::any_of(robot.blocks.begin(), robot.blocks.end(),
                     [](const HardwareBlock& block) { return block.driver == "mujoco"; });
}

namespace {
/// It stands free or has wheels, or is on a robot that does.
bool can_move(const CellRobot& robot, const CellRobots& robots) {
  const std::vector<char> rolling = description::links_on_the_floor(robot.model, false, robot.wheel_joints);
  if (is_freestanding(robot) || std::find(rolling.begin(), rolling.end(), 1) != rolling.end()) return true;
  return std::any_of(robots.begin(), robots.end(), [&](const auto& other) {
    return other.get() != &robot && other->entry.name == robot.entry.on && can_move(*other, {});
  });
}
}  // namespace

std::shared_ptr<const ContactBodies> contact_bodies(const CellRobots& robots, const description::Scene& scene) {
  const auto out = std::make_shared<ContactBodies>();
  Problems problems;
  out->scene = scene;
  surroundings::make_meshes(out->scene, problems);
  for (const auto& robot : robots) out->models.push_back(robot->model), out->tools.push_back(robot->tool);
  for (std::size_t r = 0; r < robots.size(); ++r) {
    const CellRobot& robot = *robots[r];
    surroundings::make_meshes(out->models[r], out->tools[r], robot.entry.name, problems);
    surroundings::Robot one{
        robot.entry.name,  &out->models[r], &out->tools[r], -1, can_move(robot, robots), {},
        robot.wheel_joints};
    for (std::size_t i = 0; i < robots.size(); ++i)
      if (!robot.entry.on.empty() && robots[i]->entry.name == robot.entry.on) one.on = static_cast<int>(i);
    one.body = surroundings::robot_body(one);
    out->robots.push_back(std::move(one));
  }
  std::vector<Pose> bases;
  for (const auto& robot : robots) bases.push_back(robot->entry.base);
  surroundings::find_shared(out->robots, bases);
  std::set<std::string> without;
  for (const surroundings::Robot& robot : out->robots)
    for (const std::string& what : surroundings::without_body(robot, out->scene)) without.insert(what);
  for (const std::string& what : without)
    problems.warning("no-body", {}, what + " has no known body: contacts with it are not found",
                     "give it boxes, cylinders, spheres or capsules");
  out->warnings = problems.list();
  return out;
}

std::vector<Problem> unchecked_bodies(const CellRobots& robots, const description::Scene& scene) {
  std::vector<Problem> out;
  for (const auto& robot : robots) add_robot(*robot, out);
  const bool has_physics =
      std::any_of(robots.begin(), robots.end(), [](const auto& robot) { return checks_contacts(*robot); });
  for (const description::Fixture& fixture : scene.fixtures) {
    if (fixture.shapes.empty()) continue;
    const std::string& cloud = description::cloud_of(fixture.shapes.front());
    if (has_physics && !cloud.empty())
      out.push_back(unchecked(
          "cloud-without-physics",
          fmt::format("fixture {}: physics leaves out its point cloud {}; guards, check and plans take it",
                      fixture.name, cloud),
          {{"fixture", fixture.name}, {"cloud", cloud}}));
    if (!description::has_body(fixture.shapes))
      out.push_back(
          unchecked("fixture-without-body",
                    "fixture " + fixture.name + ": contacts are not detected, as its mesh could not be read",
                    {{"fixture", fixture.name}}));
  }
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
    if (const std::string why = why_it_sags(*robot); !why.empty()) out.push_back(why);
  }
  return out;
}

std::string why_it_sags(const CellRobot& robot) {
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
  return robot.entry.name +
         ": it falls in physics, because its efforts do not hold it at the start: " + join(weak, ", ");
}

}  // namespace polyarm::cell
