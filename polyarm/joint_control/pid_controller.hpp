#pragma once
#include "polyarm/controllers/pid.hpp"
#include "polyarm/joint_control/asked_limits.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::controllers {

/// Values by place that come in messages, of which each may bring some: messages of one cycle add up, and
/// none brings a value twice. reset(): while nobody else runs; post(): the cell thread; the rest: the control
/// thread.
class ValueInbox {
 public:
  void reset(std::size_t size);
  /// `places[k]` takes `values[k]`.
  void post(const std::vector<std::size_t>& places, const std::vector<double>& values);
  /// Forgets what has come so far.
  void forget() noexcept;
  /// Calls take(place, value) for what is new.
  template <typename Take>
  void fetch(Take take) noexcept {
    if (!box_.fetch()) return;
    const Sent& sent = box_.value();
    for (std::size_t i = 0; i < sent.values.size(); ++i)
      if (sent.message[i] > seen_) take(i, sent.values[i]);
    seen_ = sent.count;
  }

 private:
  struct Sent {
    std::uint64_t count = 0;
    std::vector<double> values;
    std::vector<std::uint64_t> message;  // that brought each value
  };
  Sent sent_;
  std::uint64_t seen_ = 0;
  realtime::Latest<Sent> box_;
};

/// A PID for each degree of freedom, as ros2_control's PidController is: parameters `dof_names`,
/// `reference_and_state_dof_names`, `command_interface`, `reference_and_state_interfaces` (one, or two of
/// which the second is the derivative), `gains.<dof>`. Chainable: references
/// `<controller>/<dof>/<interface>`; exported states of the same names are what is measured. Input
/// `reference` (MultiDOFCommand: values, and values_dot), which is not used while another controller writes
/// the references; `measured_state` with `use_external_measured_states`. A stop holds a position where it is
/// and asks for a velocity of 0; what was asked for before does not come back.
class PidController : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle& cycle) noexcept override;
  void on_parameters_changed() noexcept override;
  void set_chained(bool chained) noexcept override;
  std::string refuse_changes(const std::vector<ParameterChange>& changes) const override;
  bool standing() const noexcept override { return standing_; }
  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;

 private:
  enum class Quantity { position, velocity, other };
  struct Dof {
    std::string name;
    std::size_t command = 0;
    double feed_forward = 0;
    bool wraps = false, keeps_integral = true, saturates = true;
    bool joint = false;     // a stop of motion concerns it
    bool pushes = true;     // a velocity or an effort: nothing is asked for by 0
    bool velocity = false;  // is what is commanded
    double rests_at = 0, rests_for = 0;
    Pid pid;
  };
  void read_dofs(ControllerContext& context, const std::vector<std::string>& names,
                 const std::vector<std::string>& interfaces, const std::string& command);
  void read_gains(Parameters& parameters, const std::string& prefix, std::size_t dof);
  PidGains gains_of(std::size_t dof) const noexcept;
  std::size_t place(std::size_t dof, std::size_t interface) const noexcept {
    return interface * dofs_.size() + dof;
  }
  void ask(std::size_t place, double value) noexcept {
    wanted_[place] = value;
    set_reference(place, value);
  }
  Asked kind_of(bool derivative) const noexcept;
  void forget_values() noexcept;
  void measure() noexcept;
  void take_references(bool stop, Nanoseconds now) noexcept;
  void hold() noexcept;
  void control(std::size_t dof, bool stop) noexcept;
  bool rests(std::size_t dof) noexcept;
  void publish(const Cycle& cycle) noexcept;
  void send(ValueInbox& inbox, const Input& message, const RequestedLimits* limits) const;

  // Values, references and exported states stand in the order of ros2_control: the first interface of every
  // dof, then the second.
  std::vector<Dof> dofs_;
  std::vector<PidGains> gains_;
  Quantity quantity_ = Quantity::position;  // of the first interface
  bool measures_speed_ = false;             // the second interface is the velocity
  std::size_t width_ = 1;                   // values for each dof
  bool external_ = false, start_here_ = true, forward_ = true;
  bool stopped_ = false, released_ = false, standing_ = true;
  double period_s_ = 1e-3;
  std::vector<double> measured_, wanted_;
  RequestedLimits asked_;
  ValueInbox references_, external_states_;
  Output* output_ = nullptr;
};

}  // namespace polyarm::controllers
