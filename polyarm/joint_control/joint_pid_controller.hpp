#pragma once
#include "polyarm/controllers/pid.hpp"
#include "polyarm/controllers/pid_parameters.hpp"
#include "polyarm/joint_control/asked_limits.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::controllers {

/// Turns one quantity of joints into another through a PID, as ros_control's controllers between different
/// quantities do: effort_controllers/JointPositionController, velocity_controllers/JointPositionController,
/// effort_controllers/JointVelocityController and their groups. `reference` (position or velocity) and
/// `command_interface` come with the type's name. Parameters: `joint` or `joints`; the gains under `pid`, or
/// `gains.<joint>`, `<joint>.pid` for several, which may also share one `pid`. They are gains as ros_control
/// has them: the present error enters the integral first, and without `i_clamp` the integral has no share.
/// When it starts, and when what was sent has become older than `command_timeout`, it holds: a position where
/// the joint is, a velocity of zero. Inputs `commands`, `command`;
/// output `state`.
class JointPidController : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle& cycle) noexcept override;
  void on_parameters_changed() noexcept override;
  std::string refuse_changes(const std::vector<ParameterChange>& changes) const override;
  bool standing() const noexcept override { return standing_; }
  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;

 private:
  struct Joint {
    std::size_t position = 0, velocity = 0, command = 0;
    bool continuous = false;
    double lower = 0, upper = 0;
    std::size_t gains = 0;  // which of gains_
    double set_point = 0, error = 0;
    Pid pid;
  };
  double measured(const Joint& joint) const noexcept {
    return state(position_ ? joint.position : joint.velocity);
  }
  std::size_t read_gains(Parameters& parameters, const std::string& prefix);
  void hold(Joint& joint) noexcept;
  void publish(const Cycle& cycle) noexcept;

  bool position_ = true;  // what is controlled; else the velocity
  bool stopped_ = false, standing_ = true;
  double period_s_ = 1e-3;
  std::vector<Joint> joints_;
  std::vector<RosControlParameters> gains_;  // of each `pid` that is stated
  std::vector<std::string> prefixes_;        // where each stands
  RequestedLimits asked_;
  realtime::Latest<std::vector<double>> inbox_;
  Output* output_ = nullptr;
};

}  // namespace polyarm::controllers
