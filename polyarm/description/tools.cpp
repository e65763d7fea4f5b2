#include "polyarm/description/tools.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/description/shape_yaml.hpp"

namespace polyarm::description {

namespace {

Shape cylinder_along_z(double from, double to, double radius) {
  Shape out;
  out.kind = ShapeKind::cylinder;
  out.radius = radius;
  out.length = to - from;
  out.pose.position.z = (from + to) / 2;
  return out;
}

/// A slim vacuum cup: a 24 mm wide body that ends 4 mm above the lip, whose centre is the TCP, 0.10 m out.
Tool suction_cup() {
  Tool tool;
  tool.name = "suction_cup";
  tool.tcp.position.z = 0.10;
  tool.mass = 0.15;
  tool.center = {0, 0, 0.04};
  tool.gripper = GripperKind::suction;
  tool.cup_radius = 0.009;
  tool.body = {cylinder_along_z(0.0, 0.02, 0.025), cylinder_along_z(0.02, 0.096, 0.012)};
  return tool;
}

/// A parallel gripper: 50 mm between the open pads, which end at the TCP, 0.10 m out.
Tool parallel_gripper() {
  Tool tool;
  tool.name = "parallel_gripper";
  tool.tcp.position.z = 0.10;
  tool.mass = 0.4;
  tool.center = {0, 0, 0.03};
  tool.gripper = GripperKind::parallel;
  tool.stroke = 0.05;
  tool.finger_length = 0.035;
  tool.finger_width = 0.018;
  tool.body = {cylinder_along_z(0.0, 0.055, 0.03)};
  return tool;
}

Shape box_along_z(double from, double to, double x, double y) {
  Shape out;
  out.kind = ShapeKind::box;
  out.size = {x, y, to - from};
  out.pose.position.z = (from + to) / 2;
  return out;
}

/// Robotiq 2F-85 with its coupling. Stroke, height to the closed fingertips, mass, force and speed are
/// recalled from the maker's manual; the shapes are estimates.
Tool robotiq_2f_85() {
  Tool tool;
  tool.name = "robotiq_2f_85";
  tool.tcp.position.z = 0.1628;
  tool.mass = 0.925;
  tool.center = {0, 0, 0.058};
  tool.gripper = GripperKind::parallel;
  tool.stroke = 0.085;
  tool.grip_force = 100;
  tool.finger_length = 0.0375;
  tool.finger_width = 0.022;
  tool.closing_speed = 0.075;
  tool.body = {cylinder_along_z(0, 0.05, 0.0375), box_along_z(0.05, 0.1, 0.036, 0.086)};
  return tool;
}

/// Robotiq Hand-E with its coupling and basic fingertips. The sources are those of the 2F-85.
Tool robotiq_hand_e() {
  Tool tool;
  tool.name = "robotiq_hand_e";
  tool.tcp.position.z = 0.157;
  tool.mass = 1.07;
  tool.center = {0, 0, 0.056};
  tool.gripper = GripperKind::parallel;
  tool.stroke = 0.05;
  tool.grip_force = 100;
  tool.finger_length = 0.022;
  tool.finger_width = 0.022;
  tool.closing_speed = 0.075;
  tool.body = {cylinder_along_z(0, 0.075, 0.0375), box_along_z(0.075, 0.116, 0.044, 0.074)};
  return tool;
}

double positive(const Yaml& yaml, Dimension dimension, double fallback) {
  const double value = yaml.number(dimension, fallback);
  if (!(value > 0))
    throw Error(Problem{"bad-value", yaml.where(), "'" + yaml.text() + "' must be above zero", {}});
  return value;
}

GripperKind gripper_of(const Yaml& yaml) {
  const std::string kind = yaml.text("none");
  if (kind == "none") return GripperKind::none;
  if (kind == "suction") return GripperKind::suction;
  if (kind == "parallel") return GripperKind::parallel;
  throw Error(
      Problem{"bad-value", yaml.where(), "'" + kind + "' is not a gripper", "none, suction or parallel"});
}

}  // namespace

const std::vector<std::string>& built_in_tools() {
  static const std::vector<std::string> names = {"none", "suction_cup", "parallel_gripper", "robotiq_2f_85",
                                                 "robotiq_hand_e"};
  return names;
}

Tool read_tool(const Yaml& yaml, const std::string& name) {
  Problems problems;
  yaml.check_keys({"polyarm", "tcp", "mass", "center", "body", "gripper", "cup_radius", "holding_force",
                   "reach", "stroke", "grip_force", "finger_length", "finger_width", "closing_speed"},
                  problems);
  if (const std::string kind = yaml["polyarm"].text("tool/1"); kind != "tool/1")
    problems.error("wrong-kind", yaml["polyarm"].where(),
                   "this is a '" + kind + "' file, a tool/1 was expected");
  problems.throw_if_errors();
  Tool tool;
  tool.name = name;
  if (yaml.has("tcp")) tool.tcp = yaml["tcp"].pose();
  tool.mass = positive(yaml["mass"], Dimension::mass, 0.1);
  if (yaml.has("center")) tool.center = yaml["center"].vec3();
  for (const Yaml& entry : yaml["body"].items()) {
    Shape shape = read_shape_or_mesh(entry);
    shape.pose = entry.pose();
    tool.body.push_back(shape);
  }
  tool.gripper = gripper_of(yaml["gripper"]);
  tool.cup_radius = positive(yaml["cup_radius"], Dimension::length, tool.cup_radius);
  tool.holding_force = positive(yaml["holding_force"], Dimension::force, tool.holding_force);
  tool.reach = positive(yaml["reach"], Dimension::length, tool.reach);
  tool.stroke = positive(yaml["stroke"], Dimension::length, tool.stroke);
  tool.grip_force = positive(yaml["grip_force"], Dimension::force, tool.grip_force);
  tool.finger_length = positive(yaml["finger_length"], Dimension::length, tool.finger_length);
  tool.finger_width = positive(yaml["finger_width"], Dimension::length, tool.finger_width);
  tool.closing_speed = positive(yaml["closing_speed"], Dimension::speed, tool.closing_speed);
  return tool;
}

std::optional<Problem> missing_in_tool(const std::string& name, const std::string& folder) {
  if (name.empty() ||
      std::find(built_in_tools().begin(), built_in_tools().end(), name) != built_in_tools().end())
    return std::nullopt;
  for (const std::string& file : {name, name + ".yaml"}) {
    const auto path = std::filesystem::path(folder) / file;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) continue;
    if (Yaml::load(path.string()).has("mass")) return std::nullopt;
    return Problem{
        "no-mass",
        {path.string()},
        "the tool '" + name + "' states no mass: 0.1 kg is taken",
        "add mass: 0.8kg and center: [x, y, z] in tool0; joint torques and payloads depend on them",
        Severity::warning};
  }
  return std::nullopt;
}

Tool find_tool(const std::string& name, const std::string& folder) {
  if (name.empty() || name == "none") return Tool{};
  if (name == "suction_cup") return suction_cup();
  if (name == "parallel_gripper") return parallel_gripper();
  if (name == "robotiq_2f_85") return robotiq_2f_85();
  if (name == "robotiq_hand_e") return robotiq_hand_e();
  for (const std::string& file : {name, name + ".yaml"}) {
    const auto path = std::filesystem::path(folder) / file;
    std::error_code error;
    if (std::filesystem::is_regular_file(path, error)) return read_tool(Yaml::load(path.string()), name);
  }
  std::vector<std::string> known = built_in_tools();
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    if (at->path().extension() == ".yaml")
      known.insert(known.end(), {at->path().stem().string(), at->path().filename().string()});
  throw Error("unknown-tool", "there is no tool '" + name + "'" + did_you_mean(name, known),
              "known are: " + join(built_in_tools(), ", ") + ", or a tool file beside the cell");
}

}  // namespace polyarm::description
