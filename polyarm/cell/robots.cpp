#include "polyarm/cell/robots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/hardware_names.hpp"
#include "polyarm/description/tools.hpp"
#include "polyarm/hardware/driver_loader.hpp"

namespace polyarm::cell {

namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Where a description states no more: a slow joint, up to speed in a quarter of a second.
constexpr double kDefaultVelocity = 1.0, kTimeToSpeed = 0.25, kTimeToAcceleration = 0.1;

double positive_or(const std::optional<double>& value, double fallback) {
  return value && *value > 0 && std::isfinite(*value) ? *value : fallback;
}

controllers::JointFacts facts_of(const std::string& robot, const description::Joint& joint) {
  controllers::JointFacts out;
  out.name = robot + "/" + joint.name;
  out.continuous = joint.type == description::JointType::continuous;
  out.lower = out.continuous ? -kInfinity : joint.limits.lower.value_or(-kInfinity);
  out.upper = out.continuous ? kInfinity : joint.limits.upper.value_or(kInfinity);
  out.velocity = positive_or(joint.limits.velocity, kDefaultVelocity);
  out.acceleration = positive_or(joint.limits.acceleration, out.velocity / kTimeToSpeed);
  out.jerk = positive_or(joint.limits.jerk, out.acceleration / kTimeToAcceleration);
  return out;
}

/// Joint states that the description gives for the start (`initial_value` of its position interfaces).
std::map<std::string, double> declared_start(const description::RobotModel& model) {
  std::map<std::string, double> out;
  for (const description::HardwareInfo& hardware : model.hardware)
    for (const description::ComponentInfo& component : hardware.components)
      for (const description::InterfaceInfo& state : component.state_interfaces)
        if (state.name == "position" && state.initial_value) out[component.name] = *state.initial_value;
  return out;
}

std::vector<double> start_of(const description::RobotModel& model,
                             const std::vector<controllers::JointFacts>& joints) {
  if (const auto home = model.named_states.find("home"); home != model.named_states.end())
    return home->second;
  const std::map<std::string, double> declared = declared_start(model);
  const std::vector<std::string> names = model.joint_names();
  std::vector<double> out;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto value = declared.find(names[j]);
    out.push_back(
        std::clamp(value == declared.end() ? 0.0 : value->second, joints[j].lower, joints[j].upper));
  }
  return out;
}

std::string driver_of(const CellRobot& robot, std::vector<std::string>& notes) {
  if (robot.entry.hardware != "declared") return robot.entry.hardware;
  std::string plugin;
  std::string component = robot.entry.name;
  if (!robot.model.hardware.empty()) {
    plugin = robot.model.hardware.front().plugin;
    component = robot.model.hardware.front().name;
  }
  const HardwareChoice choice = choose_hardware(plugin, component);
  if (!choice.note.empty()) notes.push_back(choice.note);
  if (plugin.empty())
    notes.push_back(robot.entry.name + ": the description declares no hardware, it is played by " +
                    choice.driver);
  return choice.driver;
}

std::unique_ptr<motion::RobotFacts> motion_facts(const CellRobot& robot) {
  std::vector<trajectory::JointMotionLimits> limits;
  for (const controllers::JointFacts& joint : robot.joints)
    limits.push_back({joint.velocity, joint.acceleration, joint.jerk});
  kinematics::Chain chain(robot.model, robot.model.tool_link(), robot.entry.base, robot.tool.tcp);
  return std::make_unique<motion::RobotFacts>(
      motion::RobotFacts{robot.entry.name, &robot.model, std::move(chain), std::move(limits), robot.start});
}

std::unique_ptr<CellRobot> resolve(const CellFile& file, const RobotEntry& entry,
                                   const description::Catalogue& catalogue, Problems& problems,
                                   std::vector<std::string>& notes) {
  auto robot = std::make_unique<CellRobot>();
  robot->entry = entry;
  const auto beside = file.folder / entry.model;
  const bool is_file = std::filesystem::is_regular_file(beside);
  robot->model = description::load_robot(is_file ? beside.string() : entry.model, catalogue, problems);
  robot->tool = description::find_tool(entry.tool, file.folder.string());
  for (const int joint : robot->model.actuated)
    robot->joints.push_back(facts_of(entry.name, robot->model.joints[static_cast<std::size_t>(joint)]));
  robot->start = start_of(robot->model, robot->joints);
  robot->driver = driver_of(*robot, notes);
  robot->facts = motion_facts(*robot);
  return robot;
}
}  // namespace

CellRobots resolve_robots(const CellFile& file, const description::Catalogue& catalogue, Problems& problems,
                          std::vector<std::string>& notes) {
  CellRobots out;
  for (const RobotEntry& entry : file.robots) {
    try {
      out.push_back(resolve(file, entry, catalogue, problems, notes));
    } catch (const Error& e) {
      for (Problem problem : e.problems()) {
        if (problem.where.file.empty()) problem.where = entry.where;
        problems.add(std::move(problem));
      }
    }
  }
  return out;
}

void add_components(hardware::Hardware& hardware, const CellRobots& robots, const description::Scene& scene,
                    Nanoseconds period) {
  std::map<std::string, hardware::ComponentContext> contexts;
  for (const auto& robot : robots) {
    hardware::ComponentContext& context = contexts[robot->driver];
    context.name = robot->driver;
    context.period = period;
    context.parameters.insert(robot->entry.parameters.begin(), robot->entry.parameters.end());
    for (const description::HardwareInfo& block : robot->model.hardware)
      if (robot->entry.hardware == "declared")
        context.parameters.insert(block.parameters.begin(), block.parameters.end());
    context.robots.push_back({robot->entry.name, &robot->model, &robot->tool, robot->entry.base, robot->start,
                              robot->entry.hardware == "declared"
                                  ? robot->model.hardware
                                  : std::vector<description::HardwareInfo>{}});
  }
  const std::string world = contexts.contains("mujoco") ? "mujoco"
                            : contexts.empty()          ? ""
                                                        : contexts.begin()->first;
  if (!world.empty()) contexts[world].scene = &scene;
  for (const auto& [driver, context] : contexts) hardware.add(hardware::make_driver(driver), context);
}

}  // namespace polyarm::cell
