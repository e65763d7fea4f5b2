#pragma once
/// What a controller is: from states to commands, once each cycle. The words and the life cycle are those of
/// ros2_control. Standard types only: plugins include this.
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
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
};

/// What a controller needs to know of a joint. Empty limits are infinite.
struct JointFacts {
  std::string name;  ///< whole: "arm/elbow_joint"
  bool continuous = false;
  double lower, upper;  ///< rad or m
  double velocity, acceleration, jerk;
};

/// The parameters of one controller as its file has them, flattened: "gains.elbow_joint.p" → {"100"}.
class Parameters {
 public:
  struct Entry {
    std::vector<std::string> values;
    Location where;
  };
  std::map<std::string, Entry> entries;

  bool has(std::string_view key) const;
  /// These throw Error("bad-value") with the entry's place.
  std::string text(std::string_view key, std::string fallback = {}) const;
  double number(std::string_view key, double fallback) const;
  bool boolean(std::string_view key, bool fallback) const;
  std::vector<std::string> list(std::string_view key) const;
};

struct ControllerContext {
  std::string name;
  std::string robot;               ///< interfaces named without a robot belong to this one
  std::vector<JointFacts> joints;  ///< of all robots of the cell
  Parameters parameters;
  Nanoseconds period = 1'000'000;  ///< of this controller's updates
  const JointFacts* find_joint(std::string_view whole_name) const;
};

/// Where a controller finds its numbers: the values of the table, and the indices of what it named.
struct Bindings {
  std::span<const double> states;    ///< the whole table
  std::span<double> commands;        ///< the whole table; only indices of claimed interfaces may be written
  std::vector<std::size_t> state;    ///< index of each name of state_interfaces(), in order
  std::vector<std::size_t> command;  ///< index of each name of command_interfaces(), in order
};

/// All calls from one thread at a time: configure from the thread that builds; activate, update and
/// deactivate from the control thread, where nothing may block, allocate, throw or log.
class Controller {
 public:
  virtual ~Controller() = default;

  /// May throw Error. After it, the interface lists are valid.
  virtual CallbackReturn on_configure(const ControllerContext& context) = 0;
  virtual std::vector<std::string> command_interfaces() const = 0;
  virtual std::vector<std::string> state_interfaces() const = 0;

  /// Starts from the last command where there is one, else from the measured state: becoming active never
  /// jumps.
  virtual CallbackReturn on_activate(const Cycle& cycle) noexcept = 0;
  virtual ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept = 0;
  virtual void on_deactivate(const Cycle& cycle) noexcept {}

  /// True when it asks for no motion now (nothing under way, or slowed down to rest).
  virtual bool standing() const noexcept { return true; }

  void bind(Bindings bindings) { bindings_ = std::move(bindings); }

 protected:
  double state(std::size_t i) const noexcept { return bindings_.states[bindings_.state[i]]; }
  double command(std::size_t i) const noexcept { return bindings_.commands[bindings_.command[i]]; }
  void set_command(std::size_t i, double value) noexcept { bindings_.commands[bindings_.command[i]] = value; }

 private:
  Bindings bindings_;
};

}  // namespace polyarm::controllers
