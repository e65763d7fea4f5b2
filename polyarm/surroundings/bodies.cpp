#include "polyarm/surroundings/bodies.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "polyarm/description/bodies.hpp"
#include "polyarm/description/branch.hpp"
#include "polyarm/description/tools.hpp"
#include "polyarm/hulls/robot_bodies.hpp"

namespace polyarm::surroundings {

using collision::AttachedBody;
using collision::RobotBody;
using description::RobotModel;
using description::Shape;

namespace {

std::size_t at(int index) {
  return static_cast<std::size_t>(index);
}

Shape pad(const description::Tool& tool, int side) {
  Shape out;
  out.size = {tool.finger_width, description::kFingerThickness, tool.finger_length};
  out.pose = tool.tcp *
             Pose{{0, side * (tool.stroke + description::kFingerThickness) / 2, -tool.finger_length / 2}, {}};
  return out;
}

/// The link at which the rigid group of a link begins.
int group_of(const RobotModel& model, int link) {
  for (int joint = model.links[at(link)].parent_joint; joint >= 0 && !model.joints[at(joint)].moves();
       joint = model.links[at(link)].parent_joint)
    link = model.joints[at(joint)].parent_link;
  return link;
}

void make(std::vector<Shape*> meshes, const std::string& of, Problems& problems) {
  std::erase_if(meshes, [](const Shape* shape) {
    return shape->kind != description::ShapeKind::mesh || !shape->pieces.empty();
  });
  if (meshes.empty()) return;
  for (Problem& problem : hulls::make_bodies(meshes, hulls::bodies_cache()).warnings) {
    if (!of.empty()) problem.what = of + ": " + problem.what;
    problems.add(std::move(problem));
  }
}

std::string prefixed(const Robot& robot, const std::string& name) {
  return robot.name.empty() ? name : robot.name + "/" + name;
}

/// `own`: index of the robot for which it is an obstacle.
void add_robot(collision::World& world, const Robot& robot, const RobotBody& body,
               const Moment::RobotState& state, std::size_t own) {
  std::array<Pose, collision::kMostSteps> frames;
  body.place(state.joints, frames);
  for (std::size_t i = 0; i < robot.model->links.size(); ++i) {
    const int frame = body.frame_of(static_cast<int>(i));
    const Pose pose =
        state.base * (frame < 0 ? Pose{} : frames[at(frame)]) * body.pose_in_frame(static_cast<int>(i));
    const bool shared = robot.shares(static_cast<int>(i), own);
    for (const Shape& shape : robot.model->links[i].collisions)
      if (!shared) world.add(prefixed(robot, robot.model->links[i].name), shape, pose);
    if (!robot.tool || static_cast<int>(i) != robot.model->tool_link()) continue;
    for (const Shape& shape : robot.tool->body) world.add(prefixed(robot, "tool"), shape, pose);
    if (robot.tool->gripper == description::GripperKind::parallel)
      for (const int side : {-1, 1}) world.add(prefixed(robot, "fingers"), pad(*robot.tool, side), pose);
  }
}

/// What a robot shares with another one is checked as that one's own. Its names are those of add_robot().
void allow_shared(const Robot& robot, const Robot& other, std::size_t index,
                  std::vector<std::pair<std::string, std::string>>& allowed) {
  for (std::size_t i = 0; i < robot.model->links.size(); ++i) {
    if (!robot.shares(static_cast<int>(i), index)) continue;
    const std::string& link = robot.model->links[i].name;
    for (const description::Link& its : other.model->links)
      allowed.emplace_back(link, prefixed(other, its.name));
    for (const char* its : {"tool", "fingers"}) allowed.emplace_back(link, prefixed(other, its));
  }
}

}  // namespace

void find_shared(std::vector<Robot>& robots, const std::vector<Pose>& T_world_base) {
  const auto drives = [](const Robot& robot) { return robot.is_free && robot.on < 0; };
  for (std::size_t a = 0; a < robots.size(); ++a)
    for (std::size_t b = 0; b < robots.size(); ++b) {
      if (a == b || robots[a].on != robots[b].on || drives(robots[a]) || drives(robots[b])) continue;
      std::vector<char> links =
          description::shared_links(*robots[a].model, T_world_base[a], *robots[b].model, T_world_base[b]);
      if (!links.empty()) robots[a].shared.push_back({b, std::move(links)});
    }
}

std::vector<char> links_on_floor(const Robot& robot) {
  if (!robot.is_free || robot.on >= 0) return {};
  return description::links_on_the_floor(*robot.model, true, robot.wheel_joints);
}

bool is_first_moving(const RobotModel& model, int link) {
  const int joint = model.links[at(group_of(model, link))].parent_joint;
  return joint >= 0 && group_of(model, model.joints[at(joint)].parent_link) == group_of(model, model.root);
}

bool is_rigid_with_root(const RobotModel& model, int link) {
  return group_of(model, link) == group_of(model, model.root);
}

Moment start_of(const description::Scene& scene) {
  Moment out;
  for (const description::Part& part : scene.parts)
    out.parts.push_back({part.start, part.feeder.empty(), -1});
  out.movers.assign(scene.movers.size(), 0);
  return out;
}

void make_meshes(RobotModel& model, description::Tool& tool, const std::string& of, Problems& problems) {
  std::vector<Shape*> shapes;
  for (description::Link& link : model.links)
    for (Shape& shape : link.collisions) shapes.push_back(&shape);
  for (Shape& shape : tool.body) shapes.push_back(&shape);
  make(std::move(shapes), of, problems);
}

void make_meshes(description::Scene& scene, Problems& problems) {
  for (description::Fixture& fixture : scene.fixtures) {
    std::vector<Shape*> shapes;
    for (Shape& shape : fixture.shapes) shapes.push_back(&shape);
    make(std::move(shapes), "fixture " + fixture.name, problems);
  }
  std::map<std::string, std::vector<Shape*>> by_kind;
  for (description::Part& part : scene.parts) by_kind[part.kind].push_back(&part.shape);
  for (auto& [kind, shapes] : by_kind) make(std::move(shapes), "part " + kind, problems);
}

std::vector<int> links_at_tool(const RobotModel& model) {
  const int mount = group_of(model, model.tool_link()), joint = model.links[at(mount)].parent_joint;
  const int before = joint < 0 ? mount : group_of(model, model.joints[at(joint)].parent_link);
  std::vector<int> out;
  for (int i = 0; i < static_cast<int>(model.links.size()); ++i)
    if (const int group = group_of(model, i); group == mount || group == before) out.push_back(i);
  return out;
}

std::shared_ptr<const RobotBody> robot_body(const Robot& robot, const std::vector<HeldPart>& held) {
  if (robot.body && held.empty()) return robot.body;
  collision::RobotBodyOptions options;
  const int link = robot.model->tool_link();
  const std::vector<int> near = links_at_tool(*robot.model);
  if (robot.tool) {
    if (description::has_body(robot.tool->body))
      options.attached.push_back({"tool", link, {}, robot.tool->body, near});
    if (robot.tool->gripper == description::GripperKind::parallel)
      options.attached.push_back({"fingers", link, {}, {pad(*robot.tool, -1), pad(*robot.tool, 1)}, near});
  }
  for (const HeldPart& part : held)
    options.attached.push_back({"part " + part.part->name, link, part.pose, {part.part->shape}, near});
  return std::make_shared<const RobotBody>(*robot.model, options);
}

std::vector<std::string> without_body(const Robot& robot, const description::Scene& scene) {
  std::vector<std::string> out;
  for (const std::string& link : description::links_without_body(*robot.model))
    out.push_back("link " + prefixed(robot, link));
  if (robot.tool && robot.tool->name != "none" && !description::has_body(robot.tool->body) &&
      robot.tool->gripper != description::GripperKind::parallel)
    out.push_back("tool " + robot.tool->name);
  for (const description::Fixture& fixture : scene.fixtures)
    if (!fixture.shapes.empty() && !description::has_body(fixture.shapes))
      out.push_back("fixture " + fixture.name);
  return out;
}

Pose pose_of(const description::Fixture& fixture, const description::Scene& scene, const Moment& moment) {
  Pose out = fixture.pose;
  for (std::size_t i = 0; i < scene.movers.size() && i < moment.movers.size(); ++i)
    if (scene.movers[i].name == fixture.mover)
      out.position = out.position + moment.movers[i] * normalized(scene.movers[i].axis);
  return out;
}

std::vector<HeldPart> held_by(std::size_t robot, const Robot& facts, const RobotBody& body,
                              const description::Scene& scene, const Moment& moment) {
  std::vector<HeldPart> out;
  const int link = facts.model->tool_link(), frame = body.frame_of(link);
  std::array<Pose, collision::kMostSteps> frames;
  body.place(moment.robots[robot].joints, frames);
  const Pose T_world_link =
      moment.robots[robot].base * (frame < 0 ? Pose{} : frames[at(frame)]) * body.pose_in_frame(link);
  for (std::size_t i = 0; i < scene.parts.size() && i < moment.parts.size(); ++i)
    if (moment.parts[i].in_world && moment.parts[i].held_by == static_cast<int>(robot))
      out.push_back({&scene.parts[i], inverse(T_world_link) * moment.parts[i].pose});
  return out;
}

Surroundings::Surroundings(const std::vector<Robot>& robots, const description::Scene& scene,
                           const Moment& moment, std::size_t own, double clearance,
                           const std::vector<std::string>& touching) {
  const Robot& robot = robots[own];
  const auto left_out = [&](const std::string& name) {
    return std::find(touching.begin(), touching.end(), name) != touching.end();
  };
  collision::World world;
  collision::CheckerOptions options;
  std::vector<std::string> ground;
  if (scene.floor) {
    ground.push_back("floor");
    if (!left_out("floor")) world.add("floor", collision::HalfSpace{{0, 0, 1}, scene.floor_height});
  }
  for (const description::Fixture& fixture : scene.fixtures) {
    const std::string name = "fixture " + fixture.name;
    if (fixture.mover.empty()) ground.push_back(name);
    if (left_out(name)) continue;
    for (const Shape& shape : fixture.shapes) world.add(name, shape, pose_of(fixture, scene, moment));
  }
  for (std::size_t i = 0; i < scene.parts.size() && i < moment.parts.size(); ++i) {
    const Moment::PartState& part = moment.parts[i];
    const std::string name = "part " + scene.parts[i].name;
    if (part.in_world && part.held_by != static_cast<int>(own) && !left_out(name))
      world.add(name, scene.parts[i].shape, part.pose);
  }
  for (std::size_t r = 0; r < robots.size(); ++r) {
    if (r == own || r >= moment.robots.size()) continue;
    if (robots[r].carries(robot, r))
      for (std::size_t i = 0; i < robots[r].model->links.size(); ++i)
        if (is_rigid_with_root(*robots[r].model, static_cast<int>(i)))
          ground.push_back(prefixed(robots[r], robots[r].model->links[i].name));
    add_robot(world, robots[r], *robot_body(robots[r]), moment.robots[r], own);
    allow_shared(robot, robots[r], r, options.allowed);
  }
  std::vector<HeldPart> held;
  if (own < moment.robots.size()) {
    held = held_by(own, robot, *robot_body(robot), scene, moment);
    options.T_world_base = moment.robots[own].base;
  }
  const std::shared_ptr<const RobotBody> body = robot_body(robot, held);
  if (!robot.is_free || robot.on >= 0)
    for (std::size_t i = 0; i < robot.model->links.size(); ++i)
      if (is_first_moving(*robot.model, static_cast<int>(i)))
        for (const std::string& name : ground) options.allowed.emplace_back(robot.model->links[i].name, name);
  if (const std::vector<char> rolling = links_on_floor(robot); !rolling.empty())
    for (std::size_t i = 0; i < rolling.size(); ++i)
      if (rolling[i]) options.allowed.emplace_back(robot.model->links[i].name, "floor");
  options.clearance = clearance;
  checker_ = std::make_unique<const collision::Checker>(body, world, options);
  probe_ = std::make_unique<collision::Probe>(*checker_);
}

}  // namespace polyarm::surroundings
