#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/options.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::apps {

namespace {

using description::RobotModel;
using nlohmann::json;

json optional(const std::optional<double>& value) {
  return value ? json(*value) : json();
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
              {"reach_m", optional(model.provenance.reach_m)},
              {"payload_kg", optional(model.provenance.payload_kg)}};
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
                             {"jerk", optional(l.jerk)}});
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

void print(const RobotModel& model) {
  const description::Provenance& p = model.provenance;
  fmt::print("{}{}{}\n", model.name, p.maker.empty() ? "" : "  —  " + p.maker + " ", p.model);
  if (p.reach_m) fmt::print("  reach {:g} m", *p.reach_m);
  if (p.payload_kg) fmt::print("  payload {:g} kg", *p.payload_kg);
  if (p.reach_m || p.payload_kg) fmt::print("\n");
  fmt::print("  base {}, tool on {}\n\n  {:<28}{:<12}{:>10}{:>10}{:>10}{:>10}\n",
             model.links[static_cast<std::size_t>(model.root)].name,
             model.links[static_cast<std::size_t>(model.tool_link())].name, "joint", "type", "lower", "upper",
             "max v", "effort");
  const auto text = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.4g}", *value) : std::string("-");
  };
  for (const description::Joint& joint : model.joints)
    if (joint.moves())
      fmt::print("  {:<28}{:<12}{:>10}{:>10}{:>10}{:>10}\n", joint.name, name(joint.type),
                 text(joint.limits.lower), text(joint.limits.upper), text(joint.limits.velocity),
                 text(joint.limits.effort));
  if (const auto home = model.named_states.find("home"); home != model.named_states.end()) {
    fmt::print("\n  home:");
    for (const double q : home->second) fmt::print(" {:.4f}", q);
    const Pose tool = kinematics::Chain(model, model.tool_link()).forward(home->second);
    const Vec3 rpy = to_rpy(tool.rotation);
    fmt::print("\n  tool0 at home: xyz {:.4f} {:.4f} {:.4f}  rpy {:.4f} {:.4f} {:.4f}\n", tool.position.x,
               tool.position.y, tool.position.z, rpy.x, rpy.y, rpy.z);
  }
  for (const description::HardwareInfo& hardware : model.hardware)
    fmt::print("\n  ros2_control {}: {} ({})", hardware.name, hardware.plugin, hardware.type);
  if (!model.hardware.empty()) fmt::print("\n");
  if (!p.source.empty()) fmt::print("\n  source: {}\n  licence of the source: {}\n", p.source, p.licence);
  for (const std::string& note : p.notes) fmt::print("  note: {}\n", note);
}

}  // namespace

int run_describe(int argc, char** argv) {
  CLI::App app("Says what a robot is", "polyarm describe");
  std::string robot;
  bool json_wanted = false, urdf = false;
  app.add_option("robot", robot, "catalogue name (universal_robots/ur3), or a URDF or robot file")
      ->required();
  app.add_flag("--json", json_wanted, "everything as one JSON object");
  app.add_flag("--urdf", urdf, "the robot as URDF, which reads back equal");
  app.footer(examples({"polyarm describe universal_robots/ur3", "polyarm describe my_robot.urdf --json",
                       "polyarm describe abb/irb_120 --urdf > irb_120.urdf"}));
  if (const auto code = parse(app, argc, argv)) return *code;
  Problems warnings;
  const RobotModel model = description::load_robot(robot, open_catalogue(), warnings);
  for (const Problem& problem : warnings.list()) fmt::print(stderr, "{}\n", problem.text());
  if (urdf)
    fmt::print("{}", description::write_urdf(model));
  else if (json_wanted)
    fmt::print("{}\n", json_of(model).dump(1));
  else
    print(model);
  return kOk;
}

}  // namespace polyarm::apps
