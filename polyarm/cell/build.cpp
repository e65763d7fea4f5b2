#include "polyarm/cell/build.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/controllers/forward_command_controller.hpp"
#include "polyarm/controllers/joint_state_broadcaster.hpp"
#include "polyarm/controllers/types.hpp"
#include "polyarm/description/packages.hpp"
#include "polyarm/description/xacro.hpp"
#include "polyarm/plugins/plugins.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/program/parser.hpp"
#include "polyarm/ros_files/controllers_file.hpp"

namespace polyarm::cell {

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
  Planner(const CellFile& file, const CellRobots& robots, control::ControlLoop& loop, bool lock_step,
          Observer& observer, Problems& problems)
      : file_(file),
        robots_(robots),
        loop_(loop),
        lock_step_(lock_step),
        observer_(observer),
        problems_(problems) {
    base_.joints = all_joints(robots);
    base_.period = loop.options().period;
    if (!robots.empty()) base_.robot = robots.front()->entry.name;
  }

  ControllerPlan plan(const std::vector<std::string>& io_commands) {
    const bool described = !file_.controllers.empty() || file_.launched;
    if (described) from_files();
    const bool moves = std::any_of(plan_.controllers.begin(), plan_.controllers.end(),
                                   [](const PlannedController& p) { return !is_broadcaster(*p.controller); });
    if (!moves) defaults();
    const bool tells = std::any_of(plan_.controllers.begin(), plan_.controllers.end(),
                                   [](const PlannedController& p) { return is_broadcaster(*p.controller); });
    if (!tells)
      add("joint_state_broadcaster/JointStateBroadcaster", "joint_state_broadcaster", base_.robot, {});
    if (!io_commands.empty()) {
      controllers::Parameters parameters;
      parameters.set("interfaces", io_commands);
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
    planned.options.lock_step = lock_step_;
    planned.options.budget = file_.budget;
    if (const double rate = robots_rate(planned.context); rate > 0) pace(planned.options, rate);
    plan_.controllers.push_back(std::move(planned));
    return plan_.controllers.back();
  }

  /// The rate, Hz, of the robot whose joints the controller names first, else of the one it belongs to; 0:
  /// that of the loop.
  double robots_rate(const controllers::ControllerContext& context) const {
    std::string owner = context.robot;
    bool names_any = false;
    for (const char* key : {"joints", "joint", "dof_names", "left_wheel_names"}) {
      if (names_any || !context.parameters.has(key)) continue;
      const std::vector<std::string> joints = context.parameters.list(key);
      if (joints.empty()) continue;
      try {
        owner = context.whole_joint(joints.front());
        owner.erase(owner.find('/'));
        names_any = true;
      } catch (const Error&) {  // told when it is configured
      }
    }
    for (const auto& robot : robots_)
      if (names_any && robot->entry.name == owner) return robot->entry.rate;
    return 0;
  }

  void from_files() {
    const ros_files::ControllersFile controllers = read_cell_controllers(file_, problems_);
    plan_.manager = controllers.manager;
    for (const ros_files::ControllerEntry& entry : controllers.controllers) from_entry(entry);
  }

  /// Interfaces without a robot's name belong to the robot that the namespace is called after, if any.
  std::string robot_of(const ros_files::ControllerEntry& entry) const {
    const std::string ns = entry.ns.substr(entry.ns.rfind('/') + 1);
    for (const auto& robot : robots_)
      if (robot->entry.name == ns) return ns;
    return base_.robot;
  }

  std::string name_of(const ros_files::ControllerEntry& entry) const {
    for (const PlannedController& other : plan_.controllers)
      if (other.context.name == entry.name) return entry.full_name().substr(1);
    return entry.name;
  }

  /// Every so many cycles, or where that is no whole number at times of its own.
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
      rate = parameters.number("publish_rate", 0);  // ros_control's name of it
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

  /// Hardware that plays another's part may offer fewer interfaces than the file asks for.
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
          return;  // told when it is configured
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
          joints.push_back(joint.name.substr(robot->entry.name.size() + 1));  // its own robot's
      if (joints.empty()) continue;
      parameters.set("joints", joints);
      const std::string prefix = robots_.size() == 1 ? "" : robot->entry.name + "_";
      add("joint_trajectory_controller/JointTrajectoryController", prefix + "joint_trajectory_controller",
          robot->entry.name, std::move(parameters));
    }
  }

  const CellFile& file_;
  const CellRobots& robots_;
  control::ControlLoop& loop_;
  bool lock_step_;
  Observer& observer_;
  Problems& problems_;
  controllers::ControllerContext base_;
  ControllerPlan plan_;
};

/// What stands in the way of a controller that the cell can do without: one that nobody asked for, where some
/// are named; that tells of a sensor which this hardware (often a simulated one) does not have; or that
/// commands a joint in a way which it does not offer, where another controller moves something.
bool can_be_left_out(const std::string& name, const Problem& problem, const CellFile& file, bool moves) {
  if (!file.activate.empty())
    return std::find(file.activate.begin(), file.activate.end(), name) == file.activate.end();
  return problem.code == "unknown-sensor" || (moves && problem.code == "interface-not-offered");
}

/// Is there a controller that commands something, and is configured?
bool anything_moves(const control::ControllerManager& manager) {
  const auto all = manager.list();
  return std::any_of(all.begin(), all.end(), [](const control::ListedController& c) {
    return c.state != hardware::LifecycleState::unconfigured && !c.required_commands.empty();
  });
}

void tell_unconfigured(const std::string& name, Problem problem, const CellFile& file, bool moves,
                       Problems& problems) {
  if (problem.severity == Severity::error && can_be_left_out(name, problem, file, moves)) {
    problem.severity = Severity::warning;
    problem.what = "the controller '" + name + "' is left unconfigured: " + problem.what;
  }
  problems.add(std::move(problem));
}

/// Configures all that can be: one that is chained to another is tried again when that one stands. Those that
/// cannot be.
std::vector<std::string> configure(control::ControllerManager& manager, std::vector<std::string> names,
                                   const CellFile& file, Problems& problems) {
  for (bool again = true; again && !names.empty();) {
    again = false;
    std::vector<std::pair<std::string, Problem>> found;
    std::vector<std::string> left;
    for (const std::string& name : names) {
      try {
        manager.configure(name);
        again = true;
      } catch (const Error& e) {
        for (const Problem& problem : e.problems()) found.emplace_back(name, problem);
        left.push_back(name);
      }
    }
    if (!again || left.empty())
      for (auto& [name, problem] : found)
        tell_unconfigured(name, std::move(problem), file, anything_moves(manager), problems);
    names = std::move(left);
  }
  return names;
}

/// What a controller found in its parameters and the file's reader has not told already.
void tell_findings(const std::vector<Problem>& findings, Problems& problems) {
  const auto told = [&](const Problem& problem) {
    return std::any_of(problems.list().begin(), problems.list().end(), [&](const Problem& other) {
      return other.where.line > 0 && other.where.line == problem.where.line &&
             other.where.file == problem.where.file;
    });
  };
  for (const Problem& problem : findings)
    if (problem.severity == Severity::warning && !told(problem)) problems.add(problem);
}

/// Is this file a script, or a script-information file?
bool is_script(const std::filesystem::path& path) {
  return path.extension() == ".script";
}

}  // namespace

void load_plugins(const CellFile& file, Problems& problems) {
  for (const std::string& written : file.plugins) {
    const std::filesystem::path folder = file.folder / written;  // an absolute one stays as it is
    std::error_code error;
    if (std::filesystem::is_directory(folder, error))
      plugins::load_folder(folder);
    else
      problems.warning("no-folder", file.plugins_where, "'" + written + "' is no folder with plugins",
                       "build your plugin, or mend 'plugins:'; folders are relative to the file");
  }
  plugins::load_default_folders();
  for (const plugins::Refusal& refusal : plugins::refused())
    problems.warning("plugin-refused", {refusal.file.string()}, refusal.reason, refusal.advice);
}

namespace {
/// $(var NAME) is what the cell or the command says, else what the description takes for its argument NAME.
std::optional<std::string> argument_of(const CellFile& file, const std::string& name) {
  for (const RobotEntry& robot : file.robots)
    if (const auto found = robot.arguments.find(name); found != robot.arguments.end()) return found->second;
  for (const RobotEntry& robot : file.robots) {
    const std::filesystem::path model = file.folder / robot.model;
    std::error_code error;
    if (!std::filesystem::is_regular_file(model, error) || !description::uses_xacro(read_file(model)))
      continue;
    Problems told;  // where the description is read
    description::XacroReport report;
    collect(told, [&] { description::expand_xacro(model, {robot.arguments, {}}, told, &report); });
    if (const auto found = report.arguments.find(name); found != report.arguments.end()) return found->second;
  }
  return std::nullopt;
}

ros_files::ParameterSubstitution substitution_of(const CellFile& file, const std::filesystem::path& from) {
  return {[&file](const std::string& name) { return argument_of(file, name); },
          description::packages_near(from)};
}
}  // namespace

ros_files::ControllersFile read_cell_controllers(const CellFile& file, Problems& problems) {
  if (file.launched) return *file.launched;
  std::vector<std::filesystem::path> paths;
  for (const std::string& written : file.controllers) {
    const std::filesystem::path path = written;
    paths.push_back(path.is_absolute() ? path : file.folder / path);
  }
  if (paths.empty()) return {};
  return ros_files::read_controllers_files(paths, problems, substitution_of(file, paths.front()));
}

double rate_of(const CellFile& file, Problems& problems) {
  if (file.rate_stated) return file.rate;
  double rate = file.rate;
  collect(problems, [&] {
    Problems later;  // told again where the controllers are made
    const double stated = read_cell_controllers(file, later).update_rate;
    if (stated >= 1 && stated <= 10000) rate = stated;
  });
  return rate;
}

ControllerPlan plan_controllers(const CellFile& file, const CellRobots& robots, control::ControlLoop& loop,
                                const std::vector<std::string>& io_commands, bool lock_step,
                                Observer& observer, Problems& problems) {
  return Planner(file, robots, loop, lock_step, observer, problems).plan(io_commands);
}

namespace {
/// Those of the plan that would be started if nothing were in their way.
std::vector<std::string> wanted_controllers(const ControllerPlan& plan, const CellFile& file) {
  std::vector<std::string> out;
  for (const PlannedController& planned : plan.controllers) {
    const std::string& name = planned.context.name;
    const bool asked = file.activate.empty() || name == kIoController ||
                       std::find(file.activate.begin(), file.activate.end(), name) != file.activate.end();
    if (planned.start && asked) out.push_back(name);
  }
  return out;
}

/// Of controllers that nobody chose, those stay inactive that command a joint which another that starts
/// commands by another interface: hardware follows one of them. Who follows trajectories goes before others.
/// (Of those that want the same interface the later one is refused when they are switched.)
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
}  // namespace

std::vector<std::string> start_controllers(ControllerPlan plan, const CellFile& file,
                                           const CellRobots& robots, control::ControlLoop& loop,
                                           Observer& observer, Problems& problems) {
  control::ControllerManager& manager = loop.controllers();
  std::vector<std::string> names;
  control::SwitchRequest request;
  request.strictness = control::Strictness::best_effort;
  const std::vector<std::string> wanted = wanted_controllers(plan, file);
  for (PlannedController& planned : plan.controllers) {
    const std::string name = planned.context.name;
    collect(problems, [&] {
      manager.load(std::move(planned.controller), std::move(planned.context), std::move(planned.options));
      names.push_back(name);
      if (std::find(wanted.begin(), wanted.end(), name) != wanted.end()) request.activate.push_back(name);
    });
  }
  for (const std::string& name : file.activate)
    if (std::find(names.begin(), names.end(), name) == names.end())
      problems.error(
          "unknown-controller", {},
          "'activate' names the controller '" + name + "', which there is not" + did_you_mean(name, names));
  for (const std::string& name : configure(manager, names, file, problems))
    std::erase(request.activate, name);
  for (const std::string& name : names) tell_findings(manager.findings(name), problems);
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
  for (const auto& listed : manager.list()) {
    auto* follower = dynamic_cast<controllers::JointTrajectoryController*>(manager.find(listed.name));
    if (follower && follower->joints() == wanted &&
        (listed.state == LifecycleState::active || (or_inactive && listed.state == LifecycleState::inactive)))
      return follower;
  }
  return nullptr;
}

controllers::DiffDriveController* base_controller_of(const CellRobot& robot,
                                                     const control::ControllerManager& manager) {
  const std::string own = robot.entry.name + "/";
  for (const auto& listed : manager.list()) {
    auto* wheels = dynamic_cast<controllers::DiffDriveController*>(manager.find(listed.name));
    if (wheels && !wheels->command_interfaces().empty() &&
        wheels->command_interfaces().front().starts_with(own))
      return wheels;
  }
  return nullptr;
}

namespace {
/// What a script loads is there from the start, as with a script-information file, so that everything beside
/// it knows the names. Files that there are not the checker complains of.
void load_data_of(const program::Program& program, const CellFile& file, DataFiles& files,
                  Problems& problems) {
  for (const program::Statement* load : program::loads(program)) {
    const Location where = program.at(load->name_place);
    try {
      data::find_file(load->name, file.folder, where);
    } catch (const Error&) {
      continue;
    }
    collect(problems, [&] { files.load_now(load->name, where); });
  }
}
}  // namespace

Programs load_programs(const CellFile& file, DataFiles& files, data::DataStore& store, Problems& problems,
                       const std::function<void()>& more_names, const program::ReadPrograms& read) {
  Programs out;
  std::size_t checked = 0;  // who had read them has checked them, too
  const auto load_script = [&](const std::filesystem::path& path) -> std::optional<program::Program> {
    std::optional<program::Program> loaded = read ? read(path) : std::nullopt;
    if (loaded)
      ++checked;
    else
      collect(problems, [&] { loaded = program::load_program(path.string()); });
    return loaded;
  };
  if (!file.program.empty())
    collect(problems, [&] {
      std::filesystem::path path = data::find_file(file.program, file.folder, file.program_where);
      if (!is_script(path))
        path = files.load_now(path.stem().string() == file.program ? file.program : path.filename().string(),
                              file.program_where);
      if (path.empty())
        throw Error(Problem{"no-script", file.program_where, "'" + file.program + "' names no ScriptFile",
                            "add 'Name: ScriptFile' and 'Text: <script>' to it"});
      const bool bare = is_script(path) && path.stem() == std::filesystem::path(file.program).stem();
      out.program = load_script(path);
      if (bare && out.program) load_data_of(*out.program, file, files, problems);
    });
  if (!file.plc.empty())
    collect(problems, [&] {
      out.plc = load_script(data::find_file(file.plc, file.folder, file.plc_where));
      if (out.plc) load_data_of(*out.plc, file, files, problems);
    });
  if (more_names) more_names();
  program::KnownNames known;
  known.add(store);
  known.folder = file.folder;
  for (const auto* loaded : {&out.program, &out.plc})
    if (*loaded && checked == 0) program::check(**loaded, known, problems);
  return out;
}

}  // namespace polyarm::cell
