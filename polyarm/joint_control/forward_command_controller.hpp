#pragma once
#include "polyarm/joint_control/asked_limits.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::controllers {

/// Writes the numbers it was sent to its command interfaces, as ros2_control's ForwardCommandController and
/// MultiInterfaceForwardCommandController do, and the forwarding single and group controllers of ros_control.
/// Parameters: `joints` and `interface_name`, or `joint` with `interface_name` or `interface_names`, or
/// `interfaces` (whole names). Until something is sent it holds: a position at the last command, else where
/// it is; all else at zero. With `command_timeout` (s) what was sent ends when nothing more comes:
/// velocities, accelerations and efforts of joints become 0, positions hold where they have been commanded to
/// so far. With `keep_outputs`, interfaces that are not of a joint begin at each activation with what was
/// sent last, also while it was not active: an output that was on is on again, without a cycle in between.
/// Input: `commands` (and `command`, as ros_control calls it).
class ForwardCommandController : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;

  /// From one other thread: the values for all interfaces, in the order of command_interfaces(). Values that
  /// are not finite leave their interface as it is. Sizes must match.
  void send(std::span<const double> values) noexcept;

 private:
  void let_expire() noexcept;
  double first_command(std::size_t i) noexcept;
  bool asks() const noexcept;

  std::vector<int> position_of_;     // per command: index of the position state, or -1
  std::vector<char> stops_at_zero_;  // velocity-like: a stop means zero
  std::vector<char> pushes_;         // effort-like: a stop leaves it
  std::vector<char> outputs_;        // not of a joint
  bool keep_outputs_ = false;
  std::vector<Asked> kinds_;
  RequestedLimits asked_;
  std::vector<double> wanted_;
  realtime::Latest<std::vector<double>> inbox_;
};

}  // namespace polyarm::controllers
