#pragma once
#include "polyarm/controllers/controller.hpp"
#include "polyarm/controllers/pid.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::controllers {

/// A PID for each degree of freedom, as ros2_control's PidController is: parameters `dof_names`,
/// `reference_and_state_dof_names`, `command_interface`, `reference_and_state_interfaces` (one, or two of
/// which the second is the derivative), `gains.<dof>`. Chainable: references
/// `<controller>/<dof>/<interface>`; exported state
/// `<controller>/<dof>/pid_error`. Input `reference` (MultiDOFCommand: values, and values_dot), which is not
/// used while another controller writes the references; `measured_state` with `use_external_measured_states`.
class PidController : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle& cycle) noexcept override;
  void on_parameters_changed() noexcept override;
  std::string refuse_changes(const std::vector<ParameterChange>& changes) const override;
  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;

 private:
  struct Dof {
    std::string name;
    std::size_t command = 0;
    std::vector<std::size_t> states, references;  // value, and derivative where there are two
    std::size_t told_error = 0;
    double feed_forward = 0;
    bool wraps = false, keeps_integral = true;
    bool pushes = true;  // a velocity or an effort: nothing is asked for by 0
    Pid pid;
  };
  void set_first_references() noexcept;
  std::vector<double> read_values(const Input& message) const;

  std::vector<Dof> dofs_;
  std::vector<PidGains> gains_;
  std::size_t width_ = 1;  // values for each dof
  bool external_ = false, start_here_ = true;
  double period_s_ = 1e-3;
  std::vector<double> measured_;  // from outside
  realtime::Latest<std::vector<double>> references_, external_states_;
  Output* output_ = nullptr;
};

}  // namespace polyarm::controllers
