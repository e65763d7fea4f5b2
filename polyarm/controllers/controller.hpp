#pragma once
/// What a controller is: from states to commands, once each cycle. The words and the life cycle are those of
/// ros2_control. Standard types only: plugins include this.
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/command_watch.hpp"
#include "polyarm/controllers/messages.hpp"
#include "polyarm/controllers/parameters.hpp"
#include "polyarm/controllers/shared_list.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::controllers {

using hardware::CallbackReturn;
using hardware::Cycle;
using hardware::LifecycleState;
using hardware::ReturnType;

/// What the supervisor allows this cycle. A stop is followed by controllers, on their paths, not done to
/// them.
struct Verdict {
  double speed = 1;        ///< share of the planned speed to aim for; 0 asks for a stop on the path
  bool immediate = false;  ///< stop as fast as the joints can, path or not
  bool discard = false;    ///< forget what is left of the motion and hold here
  bool cut = false;        ///< leave the path, brake each joint by itself as hard as it can, forget the motion
  /// Above 0: go back along the path at this share of the planned speed, by `back_time` s of the plan or
  /// `back_way` along the path (in its parameter), the shorter of both, and stand there. `speed` is 0 then.
  double back = 0, back_time = 0, back_way = 0;
  bool held = false;       ///< everything stands after a stop: only what a person moves by hand may move
  /// Stops so far: of anybody who asked (StopLatch::count), and with all other causes. Who moves by hand
  /// ends when they change, in `held` too, where a stop changes nothing else.
  std::uint32_t stop_requests = 0, stops = 0;
};

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Bounds that a joint is slowed down before, as joint_limits_interface and ros2_control have them.
struct SoftLimits {
  double lower = -kUnlimited, upper = kUnlimited, k_position = 0, k_velocity = 0;
};

/// What a controller needs to know of a joint. Limits are infinite where nobody states them.
struct JointFacts {
  std::string name;  ///< whole: "arm/elbow_joint"
  bool continuous = false;
  double lower, upper;  ///< rad or m
  double velocity, acceleration, jerk;
  double deceleration = kUnlimited;
  double effort = kUnlimited;  ///< N m or N
  std::optional<SoftLimits> soft = {};
  /// velocity, acceleration and jerk are stated by the description, not assumed for planning
  bool states_velocity = true, states_acceleration = false, states_jerk = false;
};

inline const std::string& name_in_list(const JointFacts& joint) {
  return joint.name;
}

struct ControllerContext {
  std::string name;
  std::string type;                ///< as the user wrote it
  std::string robot;               ///< interfaces named without a robot belong to this one
  SharedList<JointFacts> joints;  ///< of all robots of the cell
  Parameters parameters;
  Nanoseconds period = 1'000'000;       ///< of this controller's updates
  Nanoseconds loop_period = 1'000'000;  ///< of the control loop
  /// Interfaces that exist when the controller is configured, references of other controllers among them.
  SharedList<std::string> state_names, command_names;

  const JointFacts* find_joint(std::string_view whole_name) const;
  bool has_state(std::string_view name) const;
  bool has_command(std::string_view name) const;
  /// "joint/interface" → "arm/joint/interface" where that is what is meant; names that exist stay as they
  /// are.
  std::string whole_name(const std::string& written) const;
  /// "elbow_joint" → "arm/elbow_joint". Throws Error("unknown-joint") with the place of the key `key` when no
  /// robot has such a joint.
  std::string whole_joint(const std::string& written, const std::string& key = "joints") const;
};

/// Where a controller finds its numbers: the values of the table, and the indices of what it named.
struct Bindings {
  std::span<const double> states;      ///< the whole table
  std::span<double> commands;          ///< the whole table; only indices of claimed interfaces may be written
  std::vector<std::size_t> state;      ///< index of each claimed state, in order
  std::vector<std::size_t> command;    ///< index of each claimed command, in order
  std::vector<std::size_t> reference;  ///< commands that other controllers write for this one
  std::span<double> own_states;        ///< the whole table of states, for those that this controller exports
  std::vector<std::size_t> exported;
};

/// All calls from one thread at a time: configure and receive from the cell thread; activate, update and
/// deactivate from the control thread, where nothing may block, allocate, throw or log.
class Controller {
 public:
  virtual ~Controller() = default;

  /// Reads its parameters and names its interfaces. May throw Error.
  virtual CallbackReturn on_configure(ControllerContext& context) = 0;
  virtual CallbackReturn on_cleanup() { return CallbackReturn::success; }
  virtual CallbackReturn on_error() { return CallbackReturn::success; }

  /// Starts from the last command where there is one, else from the measured state: becoming active never
  /// jumps.
  virtual CallbackReturn on_activate(const Cycle& cycle) noexcept { return CallbackReturn::success; }
  virtual ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept = 0;
  virtual void on_deactivate(const Cycle& cycle) noexcept {}
  /// Between two cycles, after changeable parameters have been written.
  virtual void on_parameters_changed() noexcept {}
  /// Before activation: whether another controller writes this one's references, which replaces its inputs.
  virtual void set_chained(bool chained) noexcept { chained_ = chained; }

  /// True when it asks for no motion now (nothing under way, or slowed down to rest).
  virtual bool standing() const noexcept { return true; }

  /// Cell thread. The messages that it takes; receive() throws Error for what it cannot use. Returns the
  /// number of a goal where the port is an action, else 0.
  virtual std::vector<InputPort> inputs() const { return {}; }
  virtual std::uint64_t receive(const std::string& port, const Input& message, bool goal = false);
  /// Cell thread: asks to end a goal. False when it is not under way.
  virtual bool cancel(std::uint64_t goal) { return false; }
  /// Cell thread: the next thing that became of a goal.
  virtual std::optional<GoalEvent> next_goal_event() { return std::nullopt; }
  /// Cell thread: why these changes of parameters cannot be; empty when they can.
  virtual std::string refuse_changes(const std::vector<ParameterChange>& changes) const { return {}; }
  /// What comes out; addresses stay while the controller is configured.
  const std::vector<std::unique_ptr<Output>>& outputs() const { return outputs_; }
  Output* find_output(std::string_view name) const;

  /// Whether what is streamed to it still comes; of a controller that does not use it nothing grows old.
  CommandWatch& command_watch() noexcept { return command_watch_; }
  const CommandWatch& command_watch() const noexcept { return command_watch_; }

  // What it named in on_configure.
  const std::vector<std::string>& command_interfaces() const { return commands_; }
  const std::vector<std::string>& state_interfaces() const { return states_; }
  const std::vector<std::string>& reference_interfaces() const { return references_; }
  const std::vector<std::string>& exported_states() const { return exported_; }

  void bind(Bindings bindings) { bindings_ = std::move(bindings); }
  /// Before on_configure: forgets what an earlier configuration named.
  void forget_interfaces();

 protected:
  // For on_configure; each returns the index for the functions below. The same name twice gives the same
  // index.
  std::size_t claim_command(const std::string& whole_name);
  std::size_t claim_state(const std::string& whole_name);
  /// References are commands named "<controller>/<name>", which controllers before this one may claim.
  std::size_t export_reference(const std::string& whole_name);
  std::size_t export_state(const std::string& whole_name);
  Output& add_output(std::string name, std::string type, std::vector<std::string> fields);
  /// Declares `command_timeout` and reads it into the command watch; off unless it is stated.
  void read_command_timeout(Parameters& parameters);

  /// For loops over many of them.
  const Bindings& bindings() const noexcept { return bindings_; }
  double state(std::size_t i) const noexcept { return bindings_.states[bindings_.state[i]]; }
  double command(std::size_t i) const noexcept { return bindings_.commands[bindings_.command[i]]; }
  void set_command(std::size_t i, double value) noexcept { bindings_.commands[bindings_.command[i]] = value; }
  double reference(std::size_t i) const noexcept { return bindings_.commands[bindings_.reference[i]]; }
  void set_reference(std::size_t i, double value) noexcept {
    bindings_.commands[bindings_.reference[i]] = value;
  }
  void set_exported(std::size_t i, double value) noexcept {
    bindings_.own_states[bindings_.exported[i]] = value;
  }
  bool chained() const noexcept { return chained_; }

 private:
  std::vector<std::string> commands_, states_, references_, exported_;
  std::vector<std::unique_ptr<Output>> outputs_;
  Bindings bindings_;
  CommandWatch command_watch_;
  bool chained_ = false;
};

/// Everything that passes between the runtime and a controller of a plugin.
inline constexpr std::uint32_t kControllerLayout =
    hardware::layout_of<Controller, ControllerContext, JointFacts, Parameters, ParameterNote, Declared,
                        ParameterChange, Bindings, Verdict, Cycle, Input, InputPort, Output, GoalEvent,
                        Problem>();

}  // namespace polyarm::controllers
