#include "polyarm/cell/build.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/controllers_file.hpp"
#include "polyarm/controllers/forward_command_controller.hpp"
#include "polyarm/controllers/joint_state_broadcaster.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/program/parser.hpp"

namespace polyarm::cell {

namespace {

enum class ControllerKind { trajectory, broadcaster, forward, unknown };

/// The names under which users of ROS know these controllers.
ControllerKind kind_of(const std::string& type) {
  static const std::vector<std::pair<const char*, ControllerKind>> table = {
      {"joint_trajectory_controller/JointTrajectoryController", ControllerKind::trajectory},
      {"position_controllers/JointTrajectoryController", ControllerKind::trajectory},
      {"ros2_control_demo_example_7/RobotController", ControllerKind::trajectory},
      {"joint_state_broadcaster/JointStateBroadcaster", ControllerKind::broadcaster},
      {"joint_state_controller/JointStateController", ControllerKind::broadcaster},
      {"forward_command_controller/ForwardCommandController", ControllerKind::forward},
      {"forward_command_controller/MultiInterfaceForwardCommandController", ControllerKind::forward},
      {"position_controllers/JointGroupPositionController", ControllerKind::forward},
      {"velocity_controllers/JointGroupVelocityController", ControllerKind::forward},
  };
  for (const auto& [name, kind] : table)
    if (type == name) return kind;
  return ControllerKind::unknown;
}

std::unique_ptr<controllers::Controller> make(ControllerKind kind, control::ControlLoop& loop) {
  switch (kind) {
    case ControllerKind::trajectory:
      return std::make_unique<controllers::JointTrajectoryController>();
    case ControllerKind::broadcaster:
      return std::make_unique<controllers::JointStateBroadcaster>();
    case ControllerKind::forward:
      return std::make_unique<controllers::ForwardCommandController>();
    case ControllerKind::unknown:
      break;
  }
  return nullptr;
}

std::vector<controllers::JointFacts> all_joints(const CellRobots& robots) {
  std::vector<controllers::JointFacts> out;
  for (const auto& robot : robots) out.insert(out.end(), robot->joints.begin(), robot->joints.end());
  return out;
}

class Planner {
 public:
  Planner(const CellFile& file, const CellRobots& robots, control::ControlLoop& loop, Observer& observer,
          Problems& problems)
      : file_(file), robots_(robots), loop_(loop), observer_(observer), problems_(problems) {
    base_.joints = all_joints(robots);
    base_.period = loop.options().period;
    if (!robots.empty()) base_.robot = robots.front()->entry.name;
  }

  ControllerPlan plan(const std::vector<std::string>& io_commands) {
    if (!file_.controllers.empty()) from_file();
    if (!has(ControllerKind::trajectory) && !has(ControllerKind::forward)) defaults();
    if (!has(ControllerKind::broadcaster))
      add(ControllerKind::broadcaster, "joint_state_broadcaster", base_.robot, {});
    if (!io_commands.empty()) {
      controllers::Parameters parameters;
      parameters.entries["interfaces"].values = io_commands;
      add(ControllerKind::forward, kIoController, base_.robot, std::move(parameters));
    }
    return std::move(plan_);
  }

 private:
  bool has(ControllerKind kind) const { return std::count(kinds_.begin(), kinds_.end(), kind) > 0; }

  void add(ControllerKind kind, const std::string& name, const std::string& robot,
           controllers::Parameters parameters) {
    PlannedController planned{make(kind, loop_), base_};
    planned.context.name = name;
    planned.context.robot = robot;
    planned.context.parameters = std::move(parameters);
    plan_.controllers.push_back(std::move(planned));
    kinds_.push_back(kind);
  }

  void from_file() {
    Problems warnings;
    const std::filesystem::path written = file_.controllers;
    const ControllersFile controllers =
        read_controllers_file(written.is_absolute() ? written : file_.folder / written, warnings);
    for (const Problem& problem : warnings.list()) problems_.add(problem);
    for (const ControllerEntry& entry : controllers.controllers) from_entry(entry);
  }

  void from_entry(const ControllerEntry& entry) {
    const ControllerKind kind = kind_of(entry.type);
    if (kind == ControllerKind::unknown) {
      problems_.warning("unknown-controller", entry.where,
                        "the controller '" + entry.name + "' is of type " + entry.type +
                            ", which is not available; it is left out");
      return;
    }
    controllers::Parameters parameters = entry.parameters;
    if (kind == ControllerKind::forward && entry.type.starts_with("velocity_controllers/"))
      parameters.entries["interface_name"].values = {"velocity"};
    if (kind == ControllerKind::trajectory) keep_what_is_offered(entry, parameters);
    add(kind, entry.name, base_.robot, std::move(parameters));
  }

  /// Hardware that plays another's part may offer fewer interfaces than the file asks for.
  void keep_what_is_offered(const ControllerEntry& entry, controllers::Parameters& parameters) {
    const std::vector<std::string> joints = parameters.list("joints");
    if (joints.empty()) return;
    for (const char* key : {"command_interfaces", "state_interfaces"}) {
      std::vector<std::string> kept;
      for (const std::string& interface : parameters.list(key)) {
        const std::string name = base_.robot + "/" + joints.front() + "/" + interface;
        const bool command = std::string_view(key) == "command_interfaces";
        if (command ? loop_.table().find_command(name).has_value()
                    : loop_.table().find_state(name).has_value())
          kept.push_back(interface);
        else
          observer_.on_note(entry.name + ": the hardware offers no " + interface + " to " +
                            (command ? "command" : "read") + "; left out");
      }
      if (parameters.has(key)) parameters.entries[key].values = kept;
    }
  }

  void defaults() {
    for (const auto& robot : robots_) {
      controllers::Parameters parameters;
      for (const controllers::JointFacts& joint : robot->joints)
        if (loop_.table().find_command(joint.name + "/position"))
          parameters.entries["joints"].values.push_back(joint.name);
      if (!parameters.has("joints")) continue;
      const std::string prefix = robots_.size() == 1 ? "" : robot->entry.name + "_";
      add(ControllerKind::trajectory, prefix + "joint_trajectory_controller", robot->entry.name,
          std::move(parameters));
    }
  }

  const CellFile& file_;
  const CellRobots& robots_;
  control::ControlLoop& loop_;
  Observer& observer_;
  Problems& problems_;
  controllers::ControllerContext base_;
  std::vector<ControllerKind> kinds_;
  ControllerPlan plan_;
};

/// Is this file a script, or a script-information file?
bool is_script(const std::filesystem::path& path) {
  return path.extension() == ".script";
}

}  // namespace

double rate_of(const CellFile& file, Problems& problems) {
  const bool from_description =
      file.path.filename() != "cell.yaml" && file.robots.front().hardware == "declared";
  if (!from_description || file.controllers.empty()) return file.rate;
  double rate = file.rate;
  collect(problems, [&] {
    Problems later;  // told again where the controllers are made
    const double stated = read_controllers_file(file.controllers, later).update_rate;
    if (stated >= 1 && stated <= 10000) rate = stated;
  });
  return rate;
}

ControllerPlan plan_controllers(const CellFile& file, const CellRobots& robots, control::ControlLoop& loop,
                                const std::vector<std::string>& io_commands, Observer& observer,
                                Problems& problems) {
  return Planner(file, robots, loop, observer, problems).plan(io_commands);
}

controllers::JointTrajectoryController* trajectory_controller_of(const CellRobot& robot,
                                                                 const control::ControllerManager& manager) {
  std::vector<std::string> wanted;
  for (const controllers::JointFacts& joint : robot.joints) wanted.push_back(joint.name);
  for (const auto& listed : manager.list()) {
    auto* follower = dynamic_cast<controllers::JointTrajectoryController*>(manager.find(listed.name));
    if (follower && follower->joints() == wanted) return follower;
  }
  return nullptr;
}

Programs load_programs(const CellFile& file, DataFiles& files, data::DataStore& store, Problems& problems) {
  Programs out;
  const auto load_script = [&](const std::filesystem::path& path) -> std::optional<program::Program> {
    std::optional<program::Program> loaded;
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
      out.program = load_script(path);
    });
  if (!file.plc.empty())
    collect(problems, [&] { out.plc = load_script(data::find_file(file.plc, file.folder, file.plc_where)); });
  program::KnownNames known;
  known.add(store);
  known.folder = file.folder;
  for (const auto* loaded : {&out.program, &out.plc})
    if (*loaded) program::check(**loaded, known, problems);
  return out;
}

}  // namespace polyarm::cell
