#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/options.hpp"
#include "polyarm/description/bodies.hpp"
#include "polyarm/description/branch.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/hulls/robot_bodies.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/shapes/robot_shapes.hpp"

namespace polyarm::apps {

namespace {

using description::RobotModel;
using nlohmann::json;

json optional(const std::optional<double>& value) {
  return value ? json(*value) : json();
}

/// The arm's closed-form solution, or why it has none; for a robot without a chain, why there is no chain.
std::string way_to_solve(const RobotModel& model) {
  try {
    const ik::InverseKinematics arm(kinematics::Chain(model, model.tool_link()));
    return arm ? "closed form: " + arm.report() : arm.report();
  } catch (const Error& e) {
    return e.what();
  }
}

double mass_of(const RobotModel& model) {
  double out = 0;
  for (const description::Link& link : model.links)
    if (link.inertial) out += link.inertial->mass;
  return out;
}

/// The links whose masses are estimates.
std::vector<std::string> estimated_masses(const RobotModel& model) {
  std::vector<std::string> out;
  for (const description::Link& link : model.links)
    if (link.inertial && link.inertial->estimated) out.push_back(link.name);
  return out;
}

/// "-J3 + J2 + 0.5": how a controller displays a joint.
std::string formula(const description::ControllerAxis& axis, const std::vector<std::string>& names,
                    std::size_t at) {
  std::string out = (axis.sign < 0 ? "-" : "") + names[at];
  for (const auto& [joint, factor] : axis.coupling) {
    out += factor < 0 ? " - " : " + ";
    if (std::abs(factor) != 1) out += fmt::format("{:g} ", std::abs(factor));
    out += names[static_cast<std::size_t>(joint)];
  }
  if (axis.offset != 0) out += fmt::format(" {} {:g}", axis.offset < 0 ? "-" : "+", std::abs(axis.offset));
  return out;
}

json controller_axes(const RobotModel& model) {
  if (model.controller_axes.empty()) return nullptr;
  json out = {{"source", model.provenance.controller_axes}};
  const std::vector<std::string> names = model.joint_names();
  for (std::size_t i = 0; i < model.controller_axes.size(); ++i)
    out["display"][names[i]] = formula(model.controller_axes[i], names, i);
  return out;
}

void print_controller_axes(const RobotModel& model) {
  if (model.controller_axes.empty()) {
    fmt::print("  what the maker's controller shows: not known; signs, zeros and couplings may differ\n");
    return;
  }
  const std::vector<std::string> names = model.joint_names();
  std::string differing;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (const std::string shown = formula(model.controller_axes[i], names, i); shown != names[i])
      differing += fmt::format("{}{} as {}", differing.empty() ? "" : ", ", names[i], shown);
  fmt::print("  what the maker's controller shows: {}\n    {}\n",
             differing.empty() ? "these joint values" : differing + "; the others as they are",
             model.provenance.controller_axes);
}

/// What a joint with <mimic> follows: "-1 * left_finger_joint + 0.02"; empty for an independent joint.
std::string mimic_text(const RobotModel& model, const description::Joint& joint) {
  if (!joint.mimic) return "";
  const description::Mimic& m = *joint.mimic;
  std::string out = model.joints[static_cast<std::size_t>(m.joint)].name;
  if (m.multiplier != 1) out = fmt::format("{:g} * ", m.multiplier) + out;
  if (m.offset != 0) out += fmt::format(" {} {:g}", m.offset < 0 ? "-" : "+", std::abs(m.offset));
  return out;
}

json mimic_json(const RobotModel& model, const description::Joint& joint) {
  if (!joint.mimic) return nullptr;
  const description::Mimic& m = *joint.mimic;
  return {{"joint", model.joints[static_cast<std::size_t>(m.joint)].name},
          {"multiplier", m.multiplier},
          {"offset", m.offset}};
}

json json_of(const RobotModel& model) {
  json out = {{"name", model.name},
              {"maker", model.provenance.maker},
              {"model", model.provenance.model},
              {"source", model.provenance.source},
              {"licence", model.provenance.licence},
              {"notes", model.provenance.notes},
              {"root", model.links[static_cast<std::size_t>(model.root)].name},
              {"tool_link", model.links[static_cast<std::size_t>(model.tool_link())].name},
              {"inverse_kinematics", way_to_solve(model)},
              {"mass_kg", mass_of(model)},
              {"controller_axes", controller_axes(model)},
              {"reach_m", optional(model.provenance.reach_m)},
              {"payload_kg", optional(model.provenance.payload_kg)},
              {"without_body", description::links_without_body(model)},
              {"placeholders", description::placeholders(model)},
              {"arms", description::arms_of(model).tools},
              {"joints", json::array()}};
  for (const description::Joint& joint : model.joints) {
    const auto& l = joint.limits;
    out["joints"].push_back({{"name", joint.name},
                             {"type", name(joint.type)},
                             {"parent", model.links[static_cast<std::size_t>(joint.parent_link)].name},
                             {"child", model.links[static_cast<std::size_t>(joint.child_link)].name},
                             {"lower", optional(l.lower)},
                             {"upper", optional(l.upper)},
                             {"velocity", optional(l.velocity)},
                             {"effort", optional(l.effort)},
                             {"acceleration", optional(l.acceleration)},
                             {"jerk", optional(l.jerk)},
                             {"mimic", mimic_json(model, joint)}});
  }
  for (const description::Link& link : model.links)
    out["links"].push_back({{"name", link.name},
                            {"mass", link.inertial ? json(link.inertial->mass) : json()},
                            {"estimated", link.inertial && link.inertial->estimated}});
  for (const auto& [state, values] : model.named_states) out["named_states"][state] = values;
  for (const description::HardwareInfo& hardware : model.hardware)
    out["ros2_control"].push_back(
        {{"name", hardware.name}, {"type", hardware.type}, {"plugin", hardware.plugin}});
  return out;
}

json bodies_json(const hulls::BodiesMade& bodies) {
  json out = json::array();
  for (const hulls::BodyReport& each : bodies.reports)
    out.push_back({{"mesh", each.mesh},
                   {"triangles", each.triangles},
                   {"pieces", each.pieces},
                   {"size_m", each.size},
                   {"mean_excess_m", each.mean_excess},
                   {"largest_excess_m", each.largest_excess}});
  return out;
}

json described(const RobotModel& model, const hulls::BodiesMade& bodies) {
  json out = json_of(model);
  out["bodies"] = bodies_json(bodies);
  return out;
}

void print_bodies(const hulls::BodiesMade& bodies) {
  if (bodies.reports.empty()) return;
  fmt::print("\n  {:<28}{:>12}{:>8}{:>16}{:>14}\n", "collision mesh", "triangles", "pieces", "mean excess", "largest");
  for (const hulls::BodyReport& each : bodies.reports)
    fmt::print("  {:<28}{:>12}{:>8}{:>13.2f} mm{:>11.1f} mm\n", std::filesystem::path(each.mesh).filename().string(),
               each.triangles, each.pieces, 1e3 * each.mean_excess, 1e3 * each.largest_excess);
}

void print(const RobotModel& model) {
  const description::Provenance& p = model.provenance;
  fmt::print("{}{}{}\n", model.name, p.maker.empty() ? "" : "  —  " + p.maker + " ", p.model);
  if (p.reach_m) fmt::print("  reach {:g} m", *p.reach_m);
  if (p.payload_kg) fmt::print("  payload {:g} kg", *p.payload_kg);
  fmt::print("  mass {:.4g} kg\n", mass_of(model));
  fmt::print("  base {}, tool on {}\n\n  {:<28}{:<12}{:>10}{:>10}{:>10}{:>10}\n",
             model.links[static_cast<std::size_t>(model.root)].name,
             model.links[static_cast<std::size_t>(model.tool_link())].name, "joint", "type", "lower", "upper",
             "max v", "effort");
  const auto text = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.4g}", *value) : std::string("-");
  };
  for (const description::Joint& joint : model.joints)
    if (joint.moves())
      fmt::print("  {:<28}{:<12}{:>10}{:>10}{:>10}{:>10}{}\n", joint.name, name(joint.type),
                 text(joint.limits.lower), text(joint.limits.upper), text(joint.limits.velocity),
                 text(joint.limits.effort), joint.mimic ? "  = " + mimic_text(model, joint) : "");
  if (const auto home = model.named_states.find("home"); home != model.named_states.end()) {
    fmt::print("\n  home:");
    for (const double q : home->second) fmt::print(" {:.4f}", q);
    const Pose tool = kinematics::Chain(model, model.tool_link()).forward(home->second);
    const Vec3 rpy = to_rpy(tool.rotation);
    fmt::print("\n  tool0 at home: xyz {:.4f} {:.4f} {:.4f}  rpy {:.4f} {:.4f} {:.4f}\n", tool.position.x,
               tool.position.y, tool.position.z, rpy.x, rpy.y, rpy.z);
  }
  fmt::print("  inverse kinematics: {}\n", way_to_solve(model));
  print_controller_axes(model);
  for (const description::HardwareInfo& hardware : model.hardware)
    fmt::print("\n  ros2_control {}: {} ({})", hardware.name, hardware.plugin, hardware.type);
  if (!model.hardware.empty()) fmt::print("\n");
  if (!p.source.empty()) fmt::print("\n  source: {}\n  licence of the source: {}\n", p.source, p.licence);
  for (const std::string& note : p.notes) fmt::print("  note: {}\n", note);
  if (const auto links = estimated_masses(model); !links.empty())
    fmt::print("  estimated masses: {}\n", fmt::join(links, ", "));
  if (const auto links = description::links_without_body(model); !links.empty())
    fmt::print("  contacts are not detected, no <collision> or its mesh could not be read: {}\n", fmt::join(links, ", "));
  for (const std::string& text : description::placeholders(model)) fmt::print("  note: {}\n", text);
  if (const std::string hint = description::hint_of_arms(model); !hint.empty())
    fmt::print("  note: {}\n", hint);
}

}  // namespace

int run_describe(int argc, char** argv) {
  CommandLine app("Says what a robot is", "polyarm describe");
  RobotOption robot;
  bool json_wanted = false, urdf = false;
  robot.add_to(app)->required();
  app.add_flag("--json", json_wanted, "everything as one JSON object");
  app.add_flag("--urdf", urdf, "the robot as URDF, which reads back equal");
  app.footer(examples({"polyarm describe universal_robots/ur3", "polyarm describe my_robot.urdf --json",
                       "polyarm describe ur.urdf.xacro name:=ur ur_type:=ur5e",
                       "polyarm describe abb/irb_120 --urdf > irb_120.urdf"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  Problems warnings;
  RobotModel model = robot.load(warnings, open_catalogue());
  hulls::BodiesMade bodies;
  if (!urdf) bodies = hulls::make_bodies(model, hulls::bodies_cache());
  for (Problem& problem : bodies.warnings) warnings.add(std::move(problem));
  shapes::check_look(model, warnings);
  for (const Problem& problem : warnings.list()) fmt::print(stderr, "{}\n", problem.text());
  if (urdf)
    fmt::print("{}", description::write_urdf(model));
  else if (json_wanted)
    fmt::print("{}\n", described(model, bodies).dump(1));
  else {
    print(model);
    print_bodies(bodies);
  }
  return kOk;
}

}  // namespace polyarm::apps
