#pragma once
/// The interface between the runtime and hardware, simulated or real. A superset of ros2_control's hardware
/// component interface, with the same terms: states are read and commands are written once each cycle. Uses
/// standard types only, because plugins include this file.
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/description/scene.hpp"
#include "polyarm/hardware/driver_facts.hpp"
#include "polyarm/hardware/plugin.hpp"
#include "polyarm/hardware/world_state.hpp"

namespace polyarm::hardware {

enum class CallbackReturn { success, failure, error };
enum class ReturnType { ok, error, deactivate };
enum class LifecycleState { unconfigured, inactive, active, finalized };
const char* name(LifecycleState state);

/// The moment of a control cycle, on the cell's clock.
struct Cycle {
  Nanoseconds time = 0;    ///< start of the cycle
  Nanoseconds period = 0;  ///< always the nominal period of the loop
  std::uint64_t index = 0;
};

/// One robot that a component drives, with its pose and its tool. `model` and `tool` must outlive the
/// component.
struct RobotInstance {
  std::string name;  ///< in the cell, first part of its interface names
  const description::RobotModel* model = nullptr;
  const description::Tool* tool = nullptr;  ///< may be null
  Pose base;                                ///< T_world_base
  std::vector<double> initial_positions;    ///< of the actuated joints, rad or m
  std::vector<description::HardwareInfo>
      hardware;    ///< the <ros2_control> blocks that this component implements; may be empty
  std::string on;  ///< the robot whose root link carries this one; empty: it is fixed in the world
  int number = 0;  ///< its place among all robots of the cell, for PartState::held_by
};

/// All information that a component gets when it is created.
struct ComponentContext {
  std::string name;
  std::vector<RobotInstance> robots;
  const description::Scene* scene = nullptr;  ///< may be null
  std::map<std::string, std::string> parameters;
  Nanoseconds period = 1'000'000;  ///< of the control loop
};

/// A named number in the interface table. `name` is the full name: "arm/elbow_joint/position".
struct InterfaceDescription {
  std::string name;
  double initial = std::numeric_limits<double>::quiet_NaN();
};

/// An actuator, sensor or system. The on_… and prepare calls are made one at a time, from different threads,
/// and may block; read, write and perform are called on the control thread and must never block, allocate,
/// throw or log. An inactive component is read while it is being activated.
class Component {
 public:
  virtual ~Component() = default;

  /// Stores the context and checks parameters. The only function that may throw polyarm::Error.
  virtual CallbackReturn on_init(const ComponentContext& context) = 0;
  virtual CallbackReturn on_configure() { return CallbackReturn::success; }
  virtual CallbackReturn on_activate() { return CallbackReturn::success; }
  virtual CallbackReturn on_deactivate() { return CallbackReturn::success; }
  virtual CallbackReturn on_cleanup() { return CallbackReturn::success; }
  virtual CallbackReturn on_shutdown() { return CallbackReturn::success; }
  virtual CallbackReturn on_error() { return CallbackReturn::success; }

  /// Valid after on_init; their order is the order of the spans passed to read and write.
  virtual std::vector<InterfaceDescription> state_interfaces() const = 0;
  virtual std::vector<InterfaceDescription> command_interfaces() const = 0;

  /// Checks whether the named command interfaces ("robot/joint/interface") can be started and stopped
  /// together.
  virtual ReturnType prepare_command_mode_switch(std::span<const std::string> start,
                                                 std::span<const std::string> stop) {
    return ReturnType::ok;
  }
  virtual ReturnType perform_command_mode_switch(std::span<const std::string> start,
                                                 std::span<const std::string> stop) noexcept {
    return ReturnType::ok;
  }

  /// Writes what the hardware measured into `states`.
  virtual ReturnType read(const Cycle& cycle, std::span<double> states) noexcept = 0;
  /// Sends `commands` to the hardware. NaN means: no command.
  virtual ReturnType write(const Cycle& cycle, std::span<const double> commands) noexcept = 0;

  /// The simulated world, for components that simulate one; updated by each read. Otherwise null.
  virtual const WorldState* world() const noexcept { return nullptr; }
  /// Names for Contact::a and b.
  virtual std::vector<std::string> world_names() const { return {}; }
  /// True if it drives real hardware. A person must arm such a component before it may move. Valid after
  /// construction, because a cell asks before it decides whether to run the component.
  virtual bool real() const noexcept { return false; }
  /// True if read and write wait for a device (a bus, a socket). Such a component runs on a thread of its own
  /// unless its description says otherwise. Valid after construction.
  virtual bool blocks() const noexcept { return false; }
  /// True if the device has a clock that the control loop follows. await_cycle() then paces the loop while
  /// the component is active; the loop's rate must equal the device's. Valid after construction.
  virtual bool paces() const noexcept { return false; }
  /// Waits until the device begins its next cycle, at most `timeout` ns; false after a timeout. Control
  /// thread; the only call there that may wait.
  virtual bool await_cycle(Nanoseconds timeout) noexcept { return false; }
  /// Why the last callback, read or write failed: one sentence that names joint and device, and what to do;
  /// may be empty. Called from the thread that builds or switches while the control thread may be in read or
  /// write: store the reason as an atomic number and make the text here.
  virtual std::string reason() const { return {}; }
  /// The driver's description of itself, for lists; null: none. Valid after construction.
  virtual const DriverFacts* facts() const noexcept { return nullptr; }
  /// One line for the start of a run ("MuJoCo 2.2.2, step 1 ms"); may be empty.
  virtual std::string summary() const { return {}; }
};

/// Layout of all types that the runtime and a plugin's component exchange.
inline constexpr std::uint32_t kComponentLayout =
    layout_of<Component, ComponentContext, RobotInstance, InterfaceDescription, Cycle, WorldState,
              description::RobotModel, description::Link, description::Joint, description::HardwareInfo,
              description::ComponentInfo, description::InterfaceInfo, description::TransmissionInfo,
              description::Tool, description::Scene, DriverFacts>();

}  // namespace polyarm::hardware
