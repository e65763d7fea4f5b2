#include "polyarm/setup/controllers_start.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {

namespace {

/// A controller that cannot be configured is left out; the others start, as in ros2_control.
void tell_unconfigured(const std::string& name, Problem problem, Problems& problems) {
  if (problem.severity == Severity::error && name != kIoController) {
    problem.what = "the controller '" + name + "' is left unconfigured: " + problem.what;
    problem.severity = Severity::warning;
  }
  problems.add(std::move(problem));
}

/// Configures all controllers that can be; one that is chained to another is retried after that one. Returns
/// those that cannot be configured.
std::vector<std::string> configure(control::ControllerManager& manager, std::vector<std::string> names,
                                   Problems& problems) {
  for (bool again = true; again && !names.empty();) {
    again = false;
    std::vector<std::pair<std::string, Problem>> found;
    std::vector<std::string> left;
    for (const std::string& name : names) {
      try {
        manager.configure_only(name);
        again = true;
      } catch (const Error& e) {
        for (const Problem& problem : e.problems()) found.emplace_back(name, problem);
        left.push_back(name);
      }
    }
    if (!again || left.empty())
      for (auto& [name, problem] : found) tell_unconfigured(name, std::move(problem), problems);
    names = std::move(left);
  }
  manager.refresh();
  return names;
}

/// Adds a controller's findings about its parameters that the file's reader has not reported.
void report_findings(const std::vector<Problem>& findings, Problems& problems) {
  const auto told = [&](const Problem& problem) {
    return std::any_of(problems.list().begin(), problems.list().end(), [&](const Problem& other) {
      return other.where.line > 0 && other.where.line == problem.where.line &&
             other.where.file == problem.where.file;
    });
  };
  for (const Problem& problem : findings)
    if (problem.severity == Severity::warning && !told(problem)) problems.add(problem);
}

/// The controllers of the plan that should start if nothing prevents it.
std::vector<std::string> wanted_controllers(const std::vector<PlannedController>& plan,
                                            const CellFile& file) {
  std::vector<std::string> out;
  for (const PlannedController& planned : plan) {
    const std::string& name = planned.context.name;
    const bool asked = file.activate.empty() || name == kIoController ||
                       std::find(file.activate.begin(), file.activate.end(), name) != file.activate.end();
    if (planned.start && asked) out.push_back(name);
  }
  return out;
}

/// Applies to controllers that nobody chose. If two of them command the same joint through different
/// interfaces, only one starts, because hardware follows one interface; trajectory controllers take
/// precedence. (If they want the same interface, the switch refuses the later one.)
std::vector<std::string> one_way_for_each_joint(const std::vector<std::string>& asked,
                                                const control::ControllerManager& manager,
                                                const CellRobots& robots, Observer& observer) {
  std::map<std::string, std::string> holders;  // by joint
  std::set<std::string> held;
  for (const auto& robot : robots)
    for (const controllers::JointFacts& joint : robot->joints) holders[joint.name];
  std::vector<control::ListedController> order = manager.list();
  std::stable_partition(order.begin(), order.end(), [](const control::ListedController& c) {
    return c.type.find("TrajectoryController") != std::string::npos;
  });
  std::vector<std::string> out = asked;
  for (const control::ListedController& c : order) {
    if (std::find(asked.begin(), asked.end(), c.name) == asked.end()) continue;
    const auto holder_of = [&](const std::string& command) {
      const auto joint = holders.find(command.substr(0, command.rfind('/')));
      return joint == holders.end() ? nullptr : &joint->second;
    };
    std::string other;
    for (const std::string& command : c.required_commands)
      if (const std::string* holder = holder_of(command);
          holder && !holder->empty() && !held.contains(command))
        other = *holder;
    if (!other.empty()) {
      observer.on_note("the controller '" + c.name + "' commands joints of '" + other +
                       "' in another way; it stays inactive");
      std::erase(out, c.name);
      continue;
    }
    for (const std::string& command : c.required_commands)
      if (std::string* holder = holder_of(command)) *holder = c.name, held.insert(command);
  }
  return out;
}

/// True if a controllers' file contains it; it was then left out with a warning, and the others start.
bool is_described(const ros_files::ControllersFile& described, const std::string& name) {
  return std::any_of(described.controllers.begin(), described.controllers.end(),
                     [&](const auto& entry) { return entry.name == name || entry.full_name() == name; });
}
}  // namespace

std::vector<std::string> start_controllers(std::vector<PlannedController> plan, const CellFile& file,
                                           const ros_files::ControllersFile& described,
                                           const CellRobots& robots, control::ControlLoop& loop,
                                           Observer& observer, Problems& problems) {
  control::ControllerManager& manager = loop.controllers();
  std::vector<std::string> names;
  control::SwitchRequest request;
  request.strictness = control::Strictness::best_effort;
  const std::vector<std::string> wanted = wanted_controllers(plan, file);
  for (PlannedController& planned : plan) {
    const std::string name = planned.context.name;
    collect(problems, [&] {
      manager.load(std::move(planned.controller), std::move(planned.context), std::move(planned.options));
      names.push_back(name);
      if (std::find(wanted.begin(), wanted.end(), name) != wanted.end()) request.activate.push_back(name);
    });
  }
  for (const std::string& name : file.activate)
    if (std::find(names.begin(), names.end(), name) == names.end() && !is_described(described, name))
      problems.error(
          "unknown-controller", {},
          "'activate' names the controller '" + name + "', which does not exist" + did_you_mean(name, names));
  for (const std::string& name : configure(manager, names, problems)) std::erase(request.activate, name);
  for (const std::string& name : names) report_findings(manager.findings(name), problems);
  if (problems.has_errors()) return {};
  if (file.activate.empty() && !file.launched)
    request.activate = one_way_for_each_joint(request.activate, manager, robots, observer);
  const control::SwitchPlan planned = manager.plan(request);
  for (const std::string& left_out : planned.left_out) observer.on_note(left_out + "; it stays inactive");
  collect(problems, [&] { manager.switch_now(request); });
  return request.activate;
}

controllers::JointTrajectoryController* trajectory_controller_of(const CellRobot& robot,
                                                                 const control::ControllerManager& manager,
                                                                 bool or_inactive) {
  using hardware::LifecycleState;
  std::vector<std::string> wanted;
  for (const controllers::JointFacts& joint : robot.joints) wanted.push_back(joint.name);
  for (const auto& [controller, state] : manager.loaded()) {
    auto* follower = dynamic_cast<controllers::JointTrajectoryController*>(controller);
    if (follower && follower->joints() == wanted &&
        (state == LifecycleState::active || (or_inactive && state == LifecycleState::inactive)))
      return follower;
  }
  return nullptr;
}

controllers::BaseController* base_controller_of(const CellRobot& robot,
                                                const control::ControllerManager& manager) {
  const std::string own = robot.entry.name + "/";
  for (const auto& [controller, state] : manager.loaded()) {
    auto* wheels = dynamic_cast<controllers::BaseController*>(controller);
    if (wheels && !wheels->command_interfaces().empty() &&
        wheels->command_interfaces().front().starts_with(own))
      return wheels;
  }
  return nullptr;
}

std::optional<Problem> late_wheels(const std::string& controller, const CellRobots& robots,
                                   const control::ControllerManager& manager) {
  const auto* wheels = dynamic_cast<const controllers::BaseController*>(manager.find(controller));
  if (!wheels) return std::nullopt;
  for (const auto& robot : robots) {
    const std::string own = robot->entry.name + "/";
    for (const std::string& command : wheels->command_interfaces()) {
      if (!command.starts_with(own)) continue;
      const std::string joint = command.substr(own.size(), command.rfind('/') - own.size());
      const int index = robot->model.find_joint(joint.substr(joint.rfind('/') + 1));
      const std::vector<int>& known = robot->wheel_joints;
      if (index < 0 || std::find(known.begin(), known.end(), index) != known.end()) continue;
      return Problem{"late-wheels",
                     {},
                     "'" + joint + "' of '" + robot->entry.name +
                         "' was no wheel when the cell started: guards do not "
                         "watch this base, and 'drive' does not use '" +
                         controller + "'",
                     "name a controllers file with '" + controller + "' in cell.yaml, and restart the cell",
                     Severity::warning};
    }
  }
  return std::nullopt;
}

}  // namespace polyarm::cell
