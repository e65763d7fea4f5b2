/// Builds the hardware components of a cell's robots, with their rates and threads.
#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/hardware/force_sensor.hpp"
#include "polyarm/hardware/transmitted_component.hpp"
#include "polyarm/plugins/built.hpp"
#include "polyarm/setup/bodies.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::cell {

namespace {
/// Collects the components of a cell.
class Components {
 public:
  Components(const CellRobots& robots, const description::Scene& scene, Nanoseconds period, bool lock_step,
             const ros_files::ManagerParameters& manager)
      : robots_(robots), scene_(scene), period_(period), lock_step_(lock_step), manager_(manager) {}

  void add_to(hardware::Hardware& hardware, Problems& problems) {
    for (const auto& robot : robots_) take(*robot);
    for (const auto& robot : robots_) collect(problems, [&] { divisor_of(*robot, period_, problems); });
    give_the_scene();
    name_physics();
    for (Planned& planned : planned_) collect(problems, [&] { add(hardware, planned); });
    const std::vector<std::string> played = names_of_component(robots_, physics_name(robots_));
    for (const auto* names : {&manager_.unconfigured, &manager_.inactive})
      for (const std::string& name : *names)
        if (hardware.find(name) < 0 && std::find(played.begin(), played.end(), name) == played.end())
          problems.warning("unknown-component", {},
                           "hardware_components_initial_state names '" + name + "', which does not exist");
  }

  void make_one(const std::string& name, Remade& out) {
    for (const auto& robot : robots_) take(*robot);
    give_the_scene();
    name_physics();
    for (Planned& planned : planned_)
      if (planned.context.name == name) {
        out.component = make(planned);
        out.context = std::move(planned.context);
        return;
      }
    throw Error("unknown-component", "no description declares '" + name + "' any more",
                "start the cell again to run without it");
  }

 private:
  struct Planned {
    std::string driver;
    hardware::ComponentContext context;
    hardware::HostOptions options;
  };

  void add(hardware::Hardware& hardware, Planned& planned) {
    auto component = make(planned);
    if (component->real() && lock_step_)
      throw Error("real-and-fast",
                  "'" + planned.context.name + "' is real hardware, which cannot run in lock-step",
                  "leave --fast out");
    if (component->real() && planned.options.initial == hardware::LifecycleState::active)
      planned.options.initial = hardware::LifecycleState::inactive;  // until it is armed
    contain(planned);
    hardware.add(std::move(component), planned.context, planned.options);
  }

  /// Limits a fault to its robot if the cell says so and another robot can continue. All hardware of such a
  /// robot is one group.
  void contain(Planned& planned) const {
    if (robots_.size() < 2 || planned.driver == "mujoco" || planned.context.robots.empty()) return;
    const std::string& name = planned.context.robots.front().name;
    for (const hardware::RobotInstance& played : planned.context.robots)
      if (played.name != name) return;
    for (const auto& robot : robots_)
      if (robot->entry.name == name && robot->entry.fault_of_group) {
        planned.options.contained = true;
        planned.options.group = name;
      }
  }

  static std::unique_ptr<hardware::Component> make(const Planned& planned) {
    auto component = hardware::make_driver(planned.driver);
    if (planned.driver == "mujoco") return component;  // physics knows joints alone
    if (plugins::is_built(planned.driver)) return component;  // as in ros2_control: its own transmissions
    return hardware::through_transmissions(std::move(component), planned.context);
  }

  Planned& component(const std::string& driver, const std::string& name) {
    for (Planned& planned : planned_)
      if (planned.driver == driver && planned.context.name == name) return planned;
    Planned planned;
    planned.driver = driver;
    planned.context.name = name;
    planned.context.period = period_;
    planned.options.lock_step = lock_step_;
    planned.options.plugin = driver;
    planned.options.type = "system";
    planned.options.initial = initial(name);
    planned_.push_back(std::move(planned));
    return planned_.back();
  }

  hardware::LifecycleState initial(const std::string& name) const {
    const auto in = [&](const std::vector<std::string>& list) {
      return std::find(list.begin(), list.end(), name) != list.end();
    };
    if (in(manager_.unconfigured)) return hardware::LifecycleState::unconfigured;
    return in(manager_.inactive) ? hardware::LifecycleState::inactive : hardware::LifecycleState::active;
  }

  hardware::RobotInstance instance(const CellRobot& robot) const {
    const auto at =
        std::find_if(robots_.begin(), robots_.end(), [&](const auto& each) { return each.get() == &robot; });
    const int number = static_cast<int>(at - robots_.begin());
    return {robot.entry.name, &robot.model, nullptr,        robot.entry.base,
            robot.start,      {},           robot.entry.on, number};
  }

  /// Physics measures the wrench between the tool and the robot if the cell asks for it.
  static void add_force_sensor(const CellRobot& robot, hardware::RobotInstance& made) {
    const int link = robot.model.tool_link();
    if (!robot.entry.force_sensor || link == robot.model.root) return;
    description::ComponentInfo sensor;
    sensor.name = "force_sensor";
    sensor.kind = "sensor";
    sensor.parameters["frame_id"] = robot.model.links[static_cast<std::size_t>(link)].name;
    for (const char* axis : {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"})
      sensor.state_interfaces.push_back({axis});
    hardware::set_force_sensor_errors(robot.entry.sensor_errors, sensor);
    description::HardwareInfo block;
    block.components.push_back(std::move(sensor));
    made.hardware.push_back(std::move(block));
  }

  /// Physics lets the wheels touch the floor.
  static void add_wheels(const CellRobot& robot, hardware::RobotInstance& made) {
    if (robot.wheel_joints.empty()) return;
    std::vector<std::string> indices;
    for (const int joint : robot.wheel_joints) indices.push_back(std::to_string(joint));
    description::HardwareInfo block;
    block.parameters["wheel_joints"] = join(indices, " ");
    made.hardware.push_back(std::move(block));
  }

  void take(const CellRobot& robot) {
    bool tool_given = false;
    const auto with_tool = [&](hardware::RobotInstance& made) {
      if (!std::exchange(tool_given, true)) made.tool = &robot.tool;
    };
    if (robot.blocks.empty()) {
      const bool own =
          robot.driver != "mujoco" && (robot.entry.rate > 0 || robot.entry.thread ||
                                       robot.entry.fault_of_group || has_a_device_of_its_own(robot));
      Planned& planned = component(robot.driver, own ? robot.entry.name : robot.driver);
      budget(planned, robot);
      pace(planned, robot);
      planned.context.parameters.insert(robot.entry.parameters.begin(), robot.entry.parameters.end());
      planned.context.robots.push_back(instance(robot));
      with_tool(planned.context.robots.back());
      if (robot.driver == "mujoco") add_force_sensor(robot, planned.context.robots.back());
      if (robot.driver == "mujoco") add_wheels(robot, planned.context.robots.back());
      return;
    }
    for (const HardwareBlock& block : robot.blocks) take_block(robot, block, with_tool);
  }

  /// True if both name a device, and not the same: each needs a component of its own.
  static bool on_other_devices(const CellRobot& a, const CellRobot& b) {
    for (const char* key : {"port", "host"}) {
      const auto one = a.entry.parameters.find(key), other = b.entry.parameters.find(key);
      if (one != a.entry.parameters.end() && other != b.entry.parameters.end() &&
          one->second != other->second)
        return true;
    }
    return false;
  }
  bool has_a_device_of_its_own(const CellRobot& robot) const {
    return robot.driver != "mock" && std::any_of(robots_.begin(), robots_.end(), [&](const auto& other) {
             return other->blocks.empty() && other->driver == robot.driver && on_other_devices(*other, robot);
           });
  }

  template <typename WithTool>
  void take_block(const CellRobot& robot, const HardwareBlock& block, WithTool with_tool) {
    const bool physics = block.driver == "mujoco";
    description::HardwareInfo joints = *block.info, rest = *block.info;
    const auto played = [&](const auto& c) {
      return c.kind == "joint" || hardware::force_sensor_link(robot.model, c) >= 0;
    };
    std::erase_if(rest.components, played);
    std::erase_if(joints.components, [&](const auto& c) { return !played(c); });
    if (!physics || !joints.components.empty()) {
      Planned& planned =
          physics ? component(block.driver, block.driver)
                  : component(block.driver, name_beside_others(block.driver, block.info->name, robot));
      budget(planned, robot);
      describe(planned, *block.info);
      pace(planned, robot);
      planned.context.parameters.insert(robot.entry.parameters.begin(), robot.entry.parameters.end());
      if (!block.flag.empty()) planned.context.parameters.emplace(block.flag, "true");
      std::vector<hardware::RobotInstance>& instances = planned.context.robots;
      if (!physics || instances.empty() || instances.back().name != robot.entry.name) {
        instances.push_back(instance(robot));
        with_tool(instances.back());
        if (physics) add_force_sensor(robot, instances.back());
        if (physics) add_wheels(robot, instances.back());
      }
      instances.back().hardware.push_back(physics ? joints : *block.info);
    }
    if (physics && !rest.components.empty()) {  // inputs that physics lacks keep their initial values
      Planned& planned =
          component("mock", joints.components.empty() ? block.info->name : block.info->name + "_io");
      describe(planned, *block.info);
      planned.context.robots.push_back(instance(robot));
      planned.context.robots.back().hardware.push_back(rest);
    }
  }

  /// A component of several robots uses the smallest of their budgets.
  static void budget(Planned& planned, const CellRobot& robot) {
    Nanoseconds& now = planned.options.budget;
    if (robot.entry.budget > 0 && (now == 0 || robot.entry.budget < now)) now = robot.entry.budget;
  }

  static bool run_alike(const CellRobot& a, const CellRobot& b) {
    return a.entry.rate == b.entry.rate && a.entry.thread == b.entry.thread &&
           a.entry.on_thread == b.entry.on_thread && !a.entry.fault_of_group && !b.entry.fault_of_group;
  }

  /// Robots with hardware of the same name share a component, unless they run at different rates or a fault
  /// must stop only one of them.
  std::string name_beside_others(const std::string& driver, const std::string& name,
                                 const CellRobot& robot) const {
    for (const Planned& planned : planned_) {
      if (planned.driver != driver || planned.context.name != name) continue;
      for (const auto& other : robots_)
        if (other.get() != &robot && other->entry.name == planned.context.robots.front().name &&
            (!run_alike(*other, robot) || (driver != "mock" && on_other_devices(*other, robot))))
          return robot.entry.name + "_" + name;
    }
    return name;
  }

  /// Applies the robot's rate and thread, which override those of its description. Physics has one rate for
  /// all robots.
  void pace(Planned& planned, const CellRobot& robot) const {
    if (planned.driver == "mujoco") return;
    if (robot.entry.thread) planned.options.async = true;
    if (robot.entry.on_thread) {
      planned.options.thread.priority = robot.entry.on_thread->priority;
      planned.options.thread.cpu = robot.entry.on_thread->cpu;
      planned.options.when_late = robot.entry.on_thread->overrun;
      planned.options.late_after = robot.entry.on_thread->overrun_after;
    }
    if (robot.entry.rate <= 0) return;
    Problems told;  // reported once per robot elsewhere
    planned.options.divisor = divisor_of(robot, period_, told);
    if (planned.options.async || waits_for_a_device(planned.driver))
      planned.options.period = static_cast<Nanoseconds>(std::llround(1e9 / robot.entry.rate));
  }

  void describe(Planned& planned, const description::HardwareInfo& info) {
    planned.options.plugin = info.plugin;
    planned.options.type = info.type;
    if (planned.driver == "mujoco") {
      planned.context.parameters.insert(info.parameters.begin(), info.parameters.end());
      return;
    }
    planned.context.parameters.insert(info.parameters.begin(), info.parameters.end());
    planned.options.group = info.group;
    host_options(info, planned.options);
  }

  void host_options(const description::HardwareInfo& info, hardware::HostOptions& options) const {
    const double rate = 1 / seconds(period_);
    if (info.rw_rate > 0)  // at most the loop's rate
      options.divisor = static_cast<unsigned>(std::clamp(std::round(rate / info.rw_rate), 1.0, 1e6));
    options.async = info.is_async;
    if (info.rw_rate > 0 && info.is_async)
      options.period = static_cast<Nanoseconds>(std::llround(1e9 / info.rw_rate));
    options.thread.priority = info.thread_priority;
    if (!info.affinity.empty()) options.thread.cpu = info.affinity.front();
  }

  /// A component keeps the name from its description, whatever driver runs it. If physics stands for several
  /// names, the initial state of any of them applies to all.
  void name_physics() {
    for (Planned& planned : planned_) {
      if (planned.driver != kPhysics) continue;
      planned.context.name = physics_name(robots_);
      for (const std::string& name : names_of_component(robots_, planned.context.name))
        planned.options.initial = std::min(planned.options.initial, initial(name));
    }
  }

  /// Parts and machines are simulated only once: by physics if there is any.
  void give_the_scene() {
    if (planned_.empty()) return;
    Planned* world = &planned_.front();
    for (Planned& planned : planned_)
      if (planned.driver == "mujoco") world = &planned;
    world->context.scene = &scene_;
  }

  const CellRobots& robots_;
  const description::Scene& scene_;
  Nanoseconds period_;
  bool lock_step_;
  const ros_files::ManagerParameters& manager_;
  std::vector<Planned> planned_;
};

}  // namespace

void add_components(hardware::Hardware& hardware, const CellRobots& robots, const description::Scene& scene,
                    Nanoseconds period, bool lock_step, const ros_files::ManagerParameters& manager,
                    Problems& problems) {
  Components(robots, scene, period, lock_step, manager).add_to(hardware, problems);
}

Remade make_again(const std::string& name, const CellFile& file, const description::Catalogue& catalogue,
                  bool real, const description::Scene& scene, Nanoseconds period) {
  Remade out;
  std::vector<std::string> notes;
  out.robots = resolve_robots(file, catalogue, real, out.warnings, notes);
  add_hardware_faults(out.robots, Severity::error, out.warnings);
  make_robot_bodies(out.robots, out.warnings);
  out.warnings.throw_if_errors();
  const ros_files::ManagerParameters manager;
  Components(out.robots, scene, period, false, manager).make_one(name, out);
  return out;
}

}  // namespace polyarm::cell
