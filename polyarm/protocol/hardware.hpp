#pragma once
/// Requests about hardware components, arming, interfaces, the control loop and its limits.
#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/motion.hpp"

namespace polyarm::protocol {

/// A joint of real hardware before arming, rad or m; null: unknown.
struct ExpectedJoint {
  std::string joint;
  OrNull<double> measured, expected;
  POLYARM_MEMBERS(ExpectedJoint, joint, measured, expected)
};

struct ControlArm {
  static constexpr Facts kFacts{
      .name = "control.arm",
      .role = Role::operate,
      .text =
          "Without `confirmed`: returns the measured and the expected position of each real joint. With "
          "`confirmed`, a person confirms that both agree: the cell activates the hardware and starts "
          "its controllers.",
      .moves = true,
      .watch_without = "confirmed"};
  bool confirmed = false;
  struct Answer {
    static constexpr const char* kOf = "ControlArm";
    bool armed = false;
    std::optional<std::vector<ExpectedJoint>> joints;
    std::optional<std::vector<std::string>> started;  ///< names of controllers
    POLYARM_MEMBERS(Answer, armed, joints, started)
  };
  POLYARM_MEMBERS(ControlArm, confirmed)
};

struct ClaimedCommand {
  std::string name, claimed_by;
  POLYARM_MEMBERS(ClaimedCommand, name, claimed_by)
};

struct ListedHardware {
  std::string name, type, plugin, group, state;
  std::string being;  ///< while a callback runs, the state that it leads to: "configured"
  double rate = 0;    ///< reads and writes per second
  bool async = false;
  std::uint64_t missed = 0;
  std::vector<std::string> states;
  std::vector<ClaimedCommand> commands;
  POLYARM_MEMBERS(ListedHardware, name, type, plugin, group, state, being, rate, async, missed, states,
                  commands)
};

struct HardwareList {
  static constexpr Facts kFacts{.name = "hardware.list",
                                .role = Role::watch,
                                .text = "Lists the hardware components with their states and interfaces."};
  using Answer = std::vector<ListedHardware>;
  POLYARM_MEMBERS(HardwareList)
};

struct HardwareState {
  static constexpr Facts kFacts{
      .name = "hardware.state",
      .role = Role::administer,
      .text =
          "Brings a component to the state unconfigured, inactive, active or finalized. The cell first "
          "stops the controllers that use it, and their chains. `with` lists components that share its "
          "physics and change with it.",
      .moves = true};
  std::string name, state;
  struct Answer {
    static constexpr const char* kOf = "HardwareState";
    std::string name, state;
    std::vector<std::string> stopped;  ///< names of controllers
    std::optional<std::vector<std::string>> with;
    POLYARM_MEMBERS(Answer, name, state, stopped, with)
  };
  POLYARM_MEMBERS(HardwareState, name, state)
};

struct HardwareRecover {
  static constexpr Facts kFacts{
      .name = "hardware.recover",
      .role = Role::operate,
      .text =
          "Configures and activates a failed component again; without `name` all that take commands and "
          "are not active. With `controllers` it then starts the controllers that stopped with them; if none "
          "did and there is no `name`, those with which the cell began. Otherwise the answer only lists them "
          "in `fallen`.",
      .moves = true};
  std::optional<std::string> name;
  bool controllers = false;
  struct Answer {
    static constexpr const char* kOf = "HardwareRecover";
    std::string name, state;
    std::vector<std::string> fallen;  ///< names of controllers
    std::optional<std::vector<std::string>> started;
    std::string next;
    POLYARM_MEMBERS(Answer, name, state, fallen, started, next)
  };
  POLYARM_MEMBERS(HardwareRecover, name, controllers)
};

struct HardwareReload {
  static constexpr Facts kFacts{
      .name = "hardware.reload",
      .role = Role::administer,
      .text =
          "Creates a component anew from its present description, with the same interfaces. Controllers "
          "that use it are stopped, and not started again.",
      .moves = true};
  std::string name;
  struct Answer {
    static constexpr const char* kOf = "HardwareReload";
    std::string name, state;
    std::vector<std::string> stopped, warnings;
    std::string next;
    POLYARM_MEMBERS(Answer, name, state, stopped, warnings, next)
  };
  POLYARM_MEMBERS(HardwareReload, name)
};

struct StateValue {
  std::string name;
  OrNull<double> value;
  POLYARM_MEMBERS(StateValue, name, value)
};
struct CommandValue {
  std::string name;
  OrNull<double> value;
  std::string claimed_by;
  POLYARM_MEMBERS(CommandValue, name, value, claimed_by)
};

struct InterfacesList {
  static constexpr Facts kFacts{.name = "interfaces",
                                .role = Role::watch,
                                .text = "Lists every state and command interface with its value."};
  struct Answer {
    static constexpr const char* kOf = "InterfacesList";
    std::vector<StateValue> states;
    std::vector<CommandValue> commands;
    POLYARM_MEMBERS(Answer, states, commands)
  };
  POLYARM_MEMBERS(InterfacesList)
};

struct Bucket {
  std::int64_t to_ns = 0;  ///< upper end of the bucket
  std::uint64_t count = 0;
  POLYARM_MEMBERS(Bucket, to_ns, count)
};
struct Times {
  std::int64_t p50_ns = 0, p99_ns = 0, max_ns = 0;
  POLYARM_MEMBERS(Times, p50_ns, p99_ns, max_ns)
};
struct Distribution {
  std::int64_t p50_ns = 0, p99_ns = 0, max_ns = 0;
  std::vector<Bucket> buckets;
  POLYARM_MEMBERS(Distribution, p50_ns, p99_ns, max_ns, buckets)
};

/// A component or controller that runs in the control loop.
struct LoopPart {
  std::optional<std::string> component, controller;
  double rate_hz = 0;
  std::uint64_t turns = 0;
  Times cost, period;
  POLYARM_MEMBERS(LoopPart, component, controller, rate_hz, turns, cost, period)
};
/// A component or controller that has its own thread.
struct PartThread {
  std::optional<std::string> component, controller;
  double rate_hz = 0;
  bool own_clock = false;
  std::uint64_t runs = 0, late = 0, missed = 0;
  Times cost, wake_up, period;
  POLYARM_MEMBERS(PartThread, component, controller, rate_hz, own_clock, runs, late, missed, cost, wake_up,
                  period)
};
struct FailedComponent {
  std::string component, cause, cause_code;
  std::vector<std::string> controllers;  ///< names of those that stopped with it, and start with it again
  POLYARM_MEMBERS(FailedComponent, component, cause, cause_code, controllers)
};

struct LoopHealth {
  static constexpr Facts kFacts{.name = "health",
                                .role = Role::watch,
                                .text = "Reports cycles, late cycles and times of the control loop."};
  struct Answer {
    static constexpr const char* kOf = "LoopHealth";
    std::string state, cause, cause_code;
    bool standing = false;
    double time_s = 0, rate_hz = 0;
    std::uint64_t cycles = 0, late = 0;
    Distribution cost, wake_up, period;
    std::uint64_t clamps = 0;
    double override_percent = 100, allowed_percent = 100;
    OrNull<StopFacts> last_stop;
    std::vector<LoopPart> parts;
    std::vector<PartThread> threads;
    std::vector<FailedComponent> fallen;
    POLYARM_MEMBERS(Answer, state, cause, cause_code, standing, time_s, rate_hz, cycles, late, cost, wake_up,
                    period, clamps, override_percent, allowed_percent, last_stop, parts, threads, fallen)
  };
  POLYARM_MEMBERS(LoopHealth)
};

/// A limit that has clamped commands.
struct ClampedCommand {
  std::string interface, claimed_by, limit;
  std::uint64_t count = 0;
  OrNull<double> asked, given;  ///< of the last clamp
  double time_s = 0;
  POLYARM_MEMBERS(ClampedCommand, interface, claimed_by, limit, count, asked, given, time_s)
};

struct LimitsList {
  static constexpr Facts kFacts{
      .name = "limits",
      .role = Role::watch,
      .text =
          "Lists which limits changed commands, how often, the requested and the given value of the "
          "last time, and the present source of the command."};
  using Answer = std::vector<ClampedCommand>;
  POLYARM_MEMBERS(LimitsList)
};

}  // namespace polyarm::protocol
