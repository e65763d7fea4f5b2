#include "polyarm/server/documents.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "polyarm/base/hash.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/description/bodies.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/meshes/robot_meshes.hpp"
#include "polyarm/protocol/reference.hpp"
#include "polyarm/shapes/robot_shapes.hpp"
#include "polyarm/shapes/tool_shapes.hpp"

namespace polyarm::server {

using description::Shape;
using description::ShapeKind;

namespace {

using Color = std::array<double, 4>;
constexpr Color kBase{0.46, 0.49, 0.53, 1}, kTool{0.30, 0.32, 0.35, 1}, kFixture{0.62, 0.64, 0.66, 1},
    kPart{0.86, 0.52, 0.20, 1}, kBin{0.25, 0.55, 0.35, 0.25};
constexpr std::array<Color, 2> kLinks{{{0.97, 0.97, 0.96, 1}, {0.84, 0.87, 0.90, 1}}};

const char* name_of(ShapeKind kind) {
  constexpr const char* kNames[] = {"box", "cylinder", "sphere", "capsule", "mesh"};
  return kNames[static_cast<std::size_t>(kind)];
}

Json vec(const Vec3& v) {
  return {v.x, v.y, v.z};
}

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

/// Parts of one kind have one colour.
Color kind_color(std::size_t kind) {
  constexpr std::array<Color, 6> kColors{{{0.80, 0.24, 0.20, 1},
                                          {0.20, 0.45, 0.75, 1},
                                          {0.24, 0.60, 0.32, 1},
                                          {0.88, 0.68, 0.16, 1},
                                          {0.55, 0.33, 0.65, 1},
                                          {0.20, 0.60, 0.62, 1}}};
  return kColors[kind % kColors.size()];
}

Json shapes_json(const std::vector<Shape>& shapes, const Color& color) {
  Json out = Json::array();
  for (const Shape& shape : shapes) {
    Json each = shape_json(shape);
    each["color"] = color;
    out.push_back(std::move(each));
  }
  return out;
}

/// The shapes of a point cloud as one visual: six numbers for each box, its middle and its edges, in 0.1 mm.
Json cloud_json(const std::vector<Shape>& shapes, const Color& color) {
  Json boxes = Json::array();
  const auto add = [&](const Vec3& v) {
    for (const double x : {v.x, v.y, v.z}) boxes.push_back(std::round(x * 1e4) / 1e4);
  };
  for (const Shape& shape : shapes) add(shape.pose.position), add(shape.size);
  return Json::array({{{"shape", "boxes"}, {"origin", pose_json({})}, {"boxes", boxes}, {"color", color}}});
}

Json fixture_visuals(const std::vector<Shape>& shapes, const Color& color) {
  const bool is_cloud = !shapes.empty() && !description::cloud_of(shapes.front()).empty();
  return is_cloud ? cloud_json(shapes, color) : shapes_json(shapes, color);
}

bool drawable(const std::vector<Shape>& shapes) {
  for (const Shape& shape : shapes)
    if (shape.kind == ShapeKind::mesh && shape.mesh_path.empty()) return false;
  return !shapes.empty();
}

/// The shapes to draw for a link: its visuals, or its collision shapes if it has none that can be drawn.
const std::vector<Shape>& drawn(const description::Link& link) {
  return drawable(link.visuals) || link.collisions.empty() ? link.visuals : link.collisions;
}

/// Address of a robot's GLB, which holds its own meshes, or shapes that were generated for it.
std::string address_of(const description::RobotModel& model) {
  const std::string hash = shapes::has_no_look(model) ? shapes::shapes_hash(model) : meshes::mesh_hash(model);
  return hash.empty() ? hash : "/api/mesh/" + hash + ".glb";
}

/// A single mesh as a robot with one link, in the mesh's own frame and unscaled.
description::RobotModel model_of(const Shape& mesh) {
  description::RobotModel out;
  out.links.resize(1);
  out.links[0].name = "mesh";
  out.links[0].visuals = {mesh};
  out.links[0].visuals[0].pose = {};
  out.links[0].visuals[0].scale = {1, 1, 1};
  return out;
}

std::string mesh_address(const Shape& mesh) {
  return mesh.mesh_path.empty() ? std::string() : address_of(model_of(mesh));
}

Json node_json(const description::Link& link, const std::string& address, const Color& color) {
  return {
      {"shape", "mesh"}, {"mesh", address}, {"node", link.name}, {"origin", pose_json({})}, {"color", color}};
}

/// A link with a mesh is a node of its robot's GLB; its other shapes are added.
Json link_visuals_json(const description::Link& link, const std::string& address, const Color& color) {
  if (!meshes::has_mesh(link)) return shapes_json(drawn(link), color);
  std::vector<Shape> others;
  for (const Shape& shape : link.visuals)
    if (shape.kind != ShapeKind::mesh) others.push_back(shape);
  Json out = shapes_json(others, color);
  out.push_back(node_json(link, address, color));
  return out;
}

/// The visuals of each link of a robot.
std::vector<Json> visuals_json(const description::RobotModel& model) {
  const std::string address = address_of(model);
  const auto color = [&](std::size_t i) { return static_cast<int>(i) == model.root ? kBase : kLinks[i % 2]; };
  std::vector<Json> out(model.links.size(), Json::array());
  if (shapes::has_no_look(model)) {
    for (const int link : shapes::links_with_shapes(model)) {
      const auto i = static_cast<std::size_t>(link);
      out[i].push_back(node_json(model.links[i], address, color(i)));
    }
    return out;
  }
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = link_visuals_json(model.links[i], address, color(i));
  return out;
}

Json joint_json(const description::RobotModel& model, const description::Joint& joint) {
  Json out{{"name", joint.name},
           {"type", description::name(joint.type)},
           {"parent", model.links[static_cast<std::size_t>(joint.parent_link)].name},
           {"child", model.links[static_cast<std::size_t>(joint.child_link)].name},
           {"origin", pose_json(joint.origin)},
           {"axis", vec(joint.axis)},
           {"mimic", Json()}};
  if (joint.mimic)
    out["mimic"] = {{"joint", model.joints[static_cast<std::size_t>(joint.mimic->joint)].name},
                    {"multiplier", joint.mimic->multiplier},
                    {"offset", joint.mimic->offset}};
  return out;
}

/// Address of the GLB with the look of a gripper that has one.
std::string address_of(const description::Tool& tool) {
  return "/api/mesh/" + shapes::tool_shapes_hash(tool) + ".glb";
}

/// The visuals of a tool, in the frame of its flange. `slide`: how far one moves for each m between the pads.
Json tool_visuals(const description::Tool& tool) {
  const std::vector<shapes::ToolShape> look = shapes::tool_shapes(tool);
  if (look.empty()) return shapes_json(tool.body, kTool);
  const std::string address = address_of(tool);
  Json out = Json::array();
  for (const shapes::ToolShape& each : look) {
    Json one{{"shape", "mesh"}, {"mesh", address}, {"node", each.name}, {"origin", pose_json({})}};
    if (norm(each.slide) > 0) one["slide"] = vec(each.slide);
    out.push_back(std::move(one));
  }
  return out;
}

Json tool_json(const description::Tool& tool) {
  constexpr const char* kGrippers[] = {"none", "suction", "parallel"};
  return {{"name", tool.name},
          {"gripper", kGrippers[static_cast<std::size_t>(tool.gripper)]},
          {"stroke", tool.stroke},
          {"finger_length", tool.finger_length},
          {"finger_width", tool.finger_width},
          {"cup_radius", tool.cup_radius},
          {"mass", tool.mass},
          {"tcp", pose_json(tool.tcp)},
          {"visuals", tool_visuals(tool)}};
}

Json robot_joints_json(const cell::CellRobot& robot) {
  Json out = Json::array();
  const kinematics::Chain& chain = robot.facts->chain;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const std::string& whole = robot.joints[j].name;
    const int index = robot.model.actuated[j];
    const description::Joint& joint = robot.model.joints[static_cast<std::size_t>(index)];
    const auto& limits = robot.facts->limits[j];
    out.push_back({{"name", joint.name},
                   {"interface", whole},
                   {"type", description::name(joint.type)},
                   {"lower", number(chain.lower()[j])},
                   {"upper", number(chain.upper()[j])},
                   {"velocity", number(limits.velocity)},
                   {"unit", chain.slides(j) ? "m" : "rad"},
                   {"moves_tcp", chain.moves_tcp(j)}});
  }
  return out;
}

Json robot_json(cell::CellView& cell, const cell::CellRobot& robot) {
  const Vec3 rpy = to_rpy(robot.entry.base.rotation);
  Json out{
      {"name", robot.entry.name},
      {"id", robot.entry.model},
      {"title", robot.model.provenance.model.empty()
                    ? robot.entry.model
                    : robot.model.provenance.maker + " " + robot.model.provenance.model},
      {"base", {{"xyz", vec(robot.entry.base.position)}, {"rpy", vec(rpy)}}},
      {"tool", robot.entry.tool},
      {"driver", robot.driver},
      {"joints", robot_joints_json(robot)},
      {"home", robot.facts->home},
      {"reach", number(robot.facts->chain.reach())},
      {"payload_kg", robot.model.provenance.payload_kg ? Json(*robot.model.provenance.payload_kg) : Json()},
      {"groups", Json::array()},
      {"model", "/api/model/" + robot.entry.name}};
  out["base"].update(pose_json(robot.entry.base));
  for (const description::GroupInfo& group : robot.model.groups) {
    Json names = Json::array();
    for (const int j : group.joints) names.push_back(robot.model.joints[static_cast<std::size_t>(j)].name);
    out["groups"].push_back({{"name", group.name}, {"joints", names}});
  }
  Json zones = Json::array();
  for (const moves::WorkspaceZone& zone : robot.facts->workspace.zones()) zones.push_back(zone.name);
  out["zones"] = zones;
  Json gripper = Json::array();
  for (const std::string& command : cell.table().command_names())
    if (command.starts_with(robot.entry.name + "/tool/")) gripper.push_back(command);
  out["tool_commands"] = gripper;
  return out;
}

}  // namespace

std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json pose_json(const Pose& pose) {
  return {{"p", vec(pose.position)},
          {"q", {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w}}};
}

Json shape_json(const Shape& shape) {
  Json out{{"shape", name_of(shape.kind)}, {"origin", pose_json(shape.pose)}};
  if (shape.kind == ShapeKind::box) out["size"] = vec(shape.size);
  if (shape.kind == ShapeKind::cylinder || shape.kind == ShapeKind::capsule) out["length"] = shape.length;
  if (shape.kind != ShapeKind::box && shape.kind != ShapeKind::mesh) out["radius"] = shape.radius;
  if (shape.kind == ShapeKind::mesh) {
    const std::string address = mesh_address(shape);
    out["mesh"] = address.empty() ? Json() : Json(address);
    out["scale"] = vec(shape.scale);
  }
  return out;
}

Json cell_json(cell::CellView& cell) {
  Json robots = Json::array(), cameras = Json::array(), frames = Json::array();
  for (std::size_t i = 0; i < cell.robots().size(); ++i) {
    robots.push_back(robot_json(cell, *cell.robots()[i]));
    robots.back()["drives"] = cell.base(i).on_wheels();
  }
  for (const description::Camera& camera : cell.scene().cameras)
    cameras.push_back({{"name", camera.name},
                       {"eye", vec(camera.eye)},
                       {"lower", vec(camera.lower)},
                       {"upper", vec(camera.upper)}});
  for (const std::string& name : cell.store().names())
    if (const data::Point* point = cell.store().find(name)->as_point())
      frames.push_back({{"name", name}, {"in", point->frame()}, {"pose", pose_json(point->pose)}});
  return {{"name", cell.file().name},
          {"folder", resolved(cell.file().folder).string()},  // as the list of cells names it
          {"simulated", !cell.arming().needed()},
          {"real", cell.arming().needed()},
          {"rate_hz", 1 / seconds(cell.period())},
          {"program", cell.file().program},
          {"plc", cell.file().plc},
          {"robots", robots},
          {"cameras", cameras},
          {"frames", frames},
          {"scene", "/api/scene"}};
}

Json model_json(const cell::CellRobot& robot) {
  const description::RobotModel& model = robot.model;
  Json links = Json::array(), joints = Json::array();
  const std::vector<Json> visuals = visuals_json(model);
  for (std::size_t i = 0; i < model.links.size(); ++i)
    links.push_back({{"name", model.links[i].name}, {"visuals", visuals[i]}});
  for (const description::Joint& joint : model.joints) joints.push_back(joint_json(model, joint));
  const std::string tip = model.links[static_cast<std::size_t>(model.tool_link())].name;
  Json tcp = pose_json(robot.tool.tcp);
  tcp["link"] = tip;
  return {{"name", robot.entry.name},
          {"root", model.links[static_cast<std::size_t>(model.root)].name},
          {"links", links},
          {"joints", joints},
          {"tcp", tcp},
          {"tool", tool_json(robot.tool)}};
}

Json scene_json(const cell::CellView& cell) {
  const description::Scene& scene = cell.scene();
  Json fixtures = Json::array(), parts = Json::array(), bins = Json::array(), movers = Json::array(),
       zones = Json::array(), feeders = Json::array();
  for (const description::Fixture& each : scene.fixtures)
    fixtures.push_back({{"name", each.name},
                        {"pose", pose_json(each.pose)},
                        {"mover", each.mover},
                        {"visuals", fixture_visuals(each.shapes, kFixture)}});
  for (const description::Part& each : scene.parts) {
    const auto kind = std::find(scene.kinds.begin(), scene.kinds.end(), each.kind) - scene.kinds.begin();
    parts.push_back({{"name", each.name},
                     {"kind", each.kind},
                     {"pose", pose_json(each.start)},
                     {"feeder", each.feeder},
                     {"goal", each.goal ? Json{{"at", vec(each.goal->at)}, {"bin", each.goal->bin}} : Json()},
                     {"visuals", shapes_json({each.shape}, kind_color(static_cast<std::size_t>(kind)))}});
  }
  for (const description::Bin& each : scene.bins)
    bins.push_back(
        {{"name", each.name}, {"lower", vec(each.lower)}, {"upper", vec(each.upper)}, {"color", kBin}});
  for (const description::Mover& each : scene.movers)
    movers.push_back({{"name", each.name},
                      {"axis", vec(each.axis)},
                      {"lower", each.lower},
                      {"upper", each.upper},
                      {"interface", "scene/" + each.name + "/position"}});
  for (const description::Feeder& each : scene.feeders)
    feeders.push_back({{"name", each.name}, {"pose", pose_json(each.pose)}});
  for (const auto& robot : cell.robots())
    for (const moves::WorkspaceZone& zone : robot->facts->workspace.zones())
      zones.push_back({{"name", zone.name}, {"robot", robot->entry.name}});
  return {{"floor", scene.floor ? Json(scene.floor_height) : Json()},
          {"fixtures", fixtures},
          {"parts", parts},
          {"bins", bins},
          {"movers", movers},
          {"feeders", feeders},
          {"zones", zones}};
}

Json requests_json() {
  return protocol::any_of(protocol::help_rows()).json();
}

std::map<std::string, description::Tool> grippers_of(const cell::CellView& cell) {
  std::map<std::string, description::Tool> out;
  for (const auto& robot : cell.robots())
    if (!shapes::tool_shapes(robot->tool).empty()) out[address_of(robot->tool)] = robot->tool;
  return out;
}

std::map<std::string, description::RobotModel> meshes_of(const cell::CellView& cell) {
  std::map<std::string, description::RobotModel> out;
  const auto add = [&](const std::vector<Shape>& shapes) {
    for (const Shape& shape : shapes)
      if (shape.kind == ShapeKind::mesh && !shape.mesh_path.empty())
        out[mesh_address(shape)] = model_of(shape);
  };
  for (const auto& robot : cell.robots()) {
    if (const std::string address = address_of(robot->model); !address.empty()) out[address] = robot->model;
    add(robot->tool.body);
  }
  for (const description::Fixture& each : cell.scene().fixtures) add(each.shapes);
  for (const description::Part& each : cell.scene().parts) add({each.shape});
  return out;
}

}  // namespace polyarm::server
