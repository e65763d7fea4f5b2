#pragma once
#include <memory>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::controllers {

/// Writes the numbers it was sent to its command interfaces, as ros2_control's ForwardCommandController does.
/// Parameters: `joints` and `interface_name`, or `joint` and `interface_names`, or `interfaces` (whole
/// names). Until something is sent it holds: a position at the last command, else where it is; all else at
/// zero.
class ForwardCommandController : public Controller {
 public:
  CallbackReturn on_configure(const ControllerContext& context) override;
  std::vector<std::string> command_interfaces() const override { return names_; }
  std::vector<std::string> state_interfaces() const override { return position_states_; }
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

  /// From one other thread: the values for all interfaces, in the order of command_interfaces(). Values that
  /// are not finite leave their interface as it is. Sizes must match.
  void send(std::span<const double> values) noexcept;

 private:
  std::vector<std::string> names_, position_states_;
  std::vector<int> position_of_;     // per command: index into position_states_, or -1
  std::vector<bool> stops_at_zero_;  // velocity-like: a stop means zero
  std::vector<double> wanted_;
  realtime::Latest<std::vector<double>> inbox_;
};

}  // namespace polyarm::controllers
