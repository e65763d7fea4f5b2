#include "polyarm/setup/controllers_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/broadcasters/joint_state_broadcaster.hpp"
#include "polyarm/force/robot_user.hpp"
#include "polyarm/plugins/types.hpp"
#include "polyarm/wheels/wheel_names.hpp"
#include "polyarm/xacro/packages.hpp"
#include "polyarm/xacro/xacro.hpp"

namespace polyarm::cell {

namespace {

/// Resolves $(var NAME): the value from the cell or command line, otherwise that of the argument NAME in a
/// description. Expands descriptions at most once, and only when needed.
class Arguments {
 public:
  explicit Arguments(const CellFile& file) : file_(file) {}

  std::optional<std::string> value(const std::string& name) {
    for (const RobotEntry& robot : file_.robots)
      if (const auto found = robot.arguments.find(name); found != robot.arguments.end()) return found->second;
    if (!declared_) declared_ = declared();
    const auto found = declared_->find(name);
    return found == declared_->end() ? std::nullopt : std::optional(found->second);
  }

 private:
  /// Arguments of all descriptions; the first robot that declares a name wins.
  std::map<std::string, std::string> declared() const {
    std::map<std::string, std::string> out;
    for (const RobotEntry& robot : file_.robots) {
      const std::filesystem::path model = file_.folder / robot.model;
      std::error_code error;
      if (!std::filesystem::is_regular_file(model, error)) continue;
      Problems told;  // reported where the description is read
      description::XacroReport report;
      collect(told, [&] {
        if (description::uses_xacro(read_file(model)))
          description::expand_xacro(model, {robot.arguments, {}}, told, &report);
      });
      out.insert(report.arguments.begin(), report.arguments.end());
    }
    return out;
  }

  const CellFile& file_;
  std::optional<std::map<std::string, std::string>> declared_;
};

}  // namespace

ros_files::ControllersFile read_cell_controllers(const CellFile& file, Problems& problems) {
  if (file.launched) return *file.launched;
  std::vector<std::filesystem::path> paths;
  for (const std::string& written : file.controllers) {
    const std::filesystem::path path = written;
    paths.push_back(path.is_absolute() ? path : file.folder / path);
  }
  if (paths.empty()) return {};
  Arguments arguments(file);
  return ros_files::read_controllers_files(
      paths, problems,
      {[&arguments](const std::string& name) { return arguments.value(name); },
       description::packages_near(paths.front())});
}

double rate_of(const CellFile& file, const ros_files::ControllersFile& described) {
  const double stated = described.update_rate;
  return !file.rate_stated && stated >= 1 && stated <= 10000 ? stated : file.rate;
}

namespace {

std::vector<controllers::JointFacts> all_joints(const CellRobots& robots) {
  std::vector<controllers::JointFacts> out;
  for (const auto& robot : robots) out.insert(out.end(), robot->joints.begin(), robot->joints.end());
  return out;
}

bool is_broadcaster(const controllers::Controller& controller) {
  return dynamic_cast<const controllers::JointStateBroadcaster*>(&controller) != nullptr;
}

class Planner {
 public:
  Planner(const CellRobots& robots, control::ControlLoop& loop, const PlanOptions& options,
          Observer& observer, Problems& problems)
      : robots_(robots), loop_(loop), options_(options), observer_(observer), problems_(problems) {
    base_.joints = all_joints(robots);
    base_.period = loop.options().period;
    if (!robots.empty()) base_.robot = robots.front()->entry.name;
  }

  std::vector<PlannedController> plan(const ros_files::ControllersFile& described) {
    for (const ros_files::ControllerEntry& entry : described.controllers) {
      Problems own;  // of one controller; the others are still planned
      collect(own, [&] { from_entry(entry); });
      for (Problem problem : own.list()) {
        problem.what = "the controller '" + entry.name + "' is left out: " + problem.what;
        problem.severity = Severity::warning;
        if (problem.where.file.empty()) problem.where = entry.where;
        problems_.add(std::move(problem));
      }
    }
    const bool moves = std::any_of(plan_.begin(), plan_.end(),
                                   [](const PlannedController& p) { return !is_broadcaster(*p.controller); });
    if (!moves) defaults();
    const bool tells = std::any_of(plan_.begin(), plan_.end(),
                                   [](const PlannedController& p) { return is_broadcaster(*p.controller); });
    if (!tells)
      add("joint_state_broadcaster/JointStateBroadcaster", "joint_state_broadcaster", base_.robot, {});
    if (!options_.io_commands.empty()) {
      controllers::Parameters parameters;
      parameters.set("interfaces", options_.io_commands);
      parameters.set("keep_outputs", {"true"});
      add("forward_command_controller/ForwardCommandController", kIoController, base_.robot,
          std::move(parameters));
    }
    return std::move(plan_);
  }

 private:
  PlannedController& add(const std::string& type, const std::string& name, const std::string& robot,
                         controllers::Parameters parameters) {
    PlannedController planned;
    planned.context = base_;
    planned.context.name = name;
    planned.context.type = type;
    planned.context.robot = robot;
    planned.context.parameters = std::move(parameters);
    planned.controller = controllers::make_controller(type, planned.context.parameters);
    hand_models(*planned.controller, robots_);
    planned.options.lock_step = options_.lock_step;
    planned.options.budget = options_.budget;
    if (const double rate = robots_rate(planned.context); rate > 0) pace(planned.options, rate);
    plan_.push_back(std::move(planned));
    return plan_.back();
  }

  /// The rate, Hz, of the robot whose joints the controller names first, otherwise of the robot that it
  /// belongs to; 0: the loop's rate.
  double robots_rate(const controllers::ControllerContext& context) const {
    std::vector<std::string> joints;
    for (const char* key : {"joints", "joint", "dof_names"})
      if (const auto found = context.parameters.entries.find(key); found != context.parameters.entries.end())
        joints.insert(joints.end(), found->second.values.begin(), found->second.values.end());
    for (std::string& name : controllers::wheel_names(context.parameters)) joints.push_back(std::move(name));
    std::string owner = context.robot;
    bool names_any = false;
    for (const std::string& joint : joints) {
      if (names_any) break;
      try {
        owner = context.whole_joint(joint);
        owner.erase(owner.find('/'));
        names_any = true;
      } catch (const Error&) {  // reported when it is configured
      }
    }
    for (const auto& robot : robots_)
      if (names_any && robot->entry.name == owner) return robot->entry.rate;
    return 0;
  }

  /// Interfaces without a robot's name belong to the robot with the name of the namespace, if any.
  std::string robot_of(const ros_files::ControllerEntry& entry) const {
    const std::string ns = entry.ns.substr(entry.ns.rfind('/') + 1);
    for (const auto& robot : robots_)
      if (robot->entry.name == ns) return ns;
    return base_.robot;
  }

  std::string name_of(const ros_files::ControllerEntry& entry) const {
    for (const PlannedController& other : plan_)
      if (other.context.name == entry.name) return entry.full_name().substr(1);
    return entry.name;
  }

  /// Sets a divisor of the loop's rate, or a period of its own if the rate does not divide it.
  void pace(control::LoadOptions& options, double rate) const {
    const double exact = 1 / seconds(loop_.options().period) / rate;
    options.divisor = static_cast<unsigned>(std::clamp(std::round(exact), 1.0, 1e6));
    const bool whole = std::abs(exact - options.divisor) <= 1e-6 * exact;
    options.period = whole || exact < 1 ? 0 : static_cast<Nanoseconds>(std::llround(1e9 / rate));
  }

  void pace(control::LoadOptions& options, double rate, const ros_files::ControllerEntry& entry) {
    const double loop_rate = 1 / seconds(loop_.options().period);
    if (rate > loop_rate * (1 + 1e-6))
      observer_.on_note(
          fmt::format("{}: {} Hz is more than the {} Hz of the control loop; it is updated at {} Hz",
                      entry.name, format_number(rate), format_number(loop_rate), format_number(loop_rate)));
    pace(options, rate);
  }

  void from_entry(const ros_files::ControllerEntry& entry) {
    if (!entry.spawned) return observer_.on_note(entry.name + ": no launch file starts it; it is left out");
    if (!controllers::find_controller_type(entry.type)) {
      problems_.warning(
          "unknown-controller", entry.where,
          "the controller '" + entry.name + "' is of type " + entry.type + ", which is not available" +
              did_you_mean(entry.type, controllers::controller_type_names()) + "; it is left out");
      return;
    }
    controllers::Parameters parameters = entry.parameters;
    double rate = entry.update_rate;
    const auto published = parameters.entries.find("publish_rate");
    if (published != parameters.entries.end() && controllers::is_publisher(entry.type)) {
      rate = parameters.number("publish_rate", 0);  // the name in ros_control
      parameters.entries.erase(published);
    }
    if (entry.type.find("JointTrajectoryController") != std::string::npos)
      keep_what_is_offered(entry, parameters);
    PlannedController& planned = add(entry.type, name_of(entry), robot_of(entry), std::move(parameters));
    if (rate > 0) pace(planned.options, rate, entry);
    planned.options.async = entry.is_async;
    planned.options.fallback = entry.fallback_controllers;
    planned.options.thread.priority = 0;
    planned.start = !entry.stopped;
  }

  /// Simulated hardware may offer fewer interfaces than the file requires; keeps the offered ones.
  void keep_what_is_offered(const ros_files::ControllerEntry& entry, controllers::Parameters& parameters) {
    const std::vector<std::string> joints = parameters.list("joints");
    if (joints.empty() || parameters.has("command_joints")) return;
    controllers::ControllerContext context = base_;
    context.robot = robot_of(entry);
    for (const char* key : {"command_interfaces", "state_interfaces"}) {
      std::vector<std::string> kept;
      for (const std::string& interface : parameters.list(key)) {
        const bool command = std::string_view(key) == "command_interfaces";
        std::string name;
        try {
          name = context.whole_joint(joints.front()) + "/" + interface;
        } catch (const Error&) {
          return;  // reported when it is configured
        }
        if (command ? loop_.table().find_command(name).has_value()
                    : loop_.table().find_state(name).has_value())
          kept.push_back(interface);
        else
          observer_.on_note(entry.name + ": the hardware offers no " + interface + " to " +
                            (command ? "command" : "read") + "; left out");
      }
      if (parameters.has(key) && !kept.empty()) parameters.entries[key].values = kept;
    }
  }

  void defaults() {
    for (const auto& robot : robots_) {
      controllers::Parameters parameters;
      std::vector<std::string> joints;
      for (const controllers::JointFacts& joint : robot->joints)
        if (loop_.table().find_command(joint.name + "/position"))
          joints.push_back(joint.name.substr(robot->entry.name.size() + 1));  // without the robot's name
      if (joints.empty()) continue;
      parameters.set("joints", joints);
      const std::string prefix = robots_.size() == 1 ? "" : robot->entry.name + "_";
      add("joint_trajectory_controller/JointTrajectoryController", prefix + "joint_trajectory_controller",
          robot->entry.name, std::move(parameters));
    }
  }

  const CellRobots& robots_;
  control::ControlLoop& loop_;
  const PlanOptions& options_;
  Observer& observer_;
  Problems& problems_;
  controllers::ControllerContext base_;
  std::vector<PlannedController> plan_;
};

}  // namespace

void hand_models(controllers::Controller& controller, const CellRobots& robots) {
  auto* user = dynamic_cast<controllers::RobotUser*>(&controller);
  if (!user) return;
  controllers::RobotUser::Models models;
  for (const auto& robot : robots) models[robot->entry.name] = &robot->model;
  user->set_models(std::move(models));
}

std::vector<PlannedController> plan_controllers(const ros_files::ControllersFile& described,
                                                const CellRobots& robots, control::ControlLoop& loop,
                                                const PlanOptions& options, Observer& observer,
                                                Problems& problems) {
  return Planner(robots, loop, options, observer, problems).plan(described);
}

}  // namespace polyarm::cell
