#pragma once
#include <array>
#include <atomic>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/controllers/speed_limiter.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/wheels/odometry.hpp"

namespace polyarm::controllers {

/// Drives a base with wheels on two sides, as ros2_control's DiffDriveController does: a twist becomes
/// velocities of the wheels, within limits, and where the base has come to is told as odometry.
///
/// Inputs: `cmd_vel` (with stamp or without; `cmd_vel_unstamped` is the same), `set_odometry` (x, y,
/// heading). References for a controller before it: `<name>/linear/velocity` (m/s), `<name>/angular/velocity`
/// (rad/s); while one writes them, cmd_vel is not used. Outputs: `odom`, `tf`, `cmd_vel_out`.
///
/// A command that is older than cmd_vel_timeout, or a stop, becomes a wanted speed of zero, reached within
/// the limits; what was commanded before a stop is forgotten, so that nothing moves again by itself.
class DiffDriveController : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle& cycle) noexcept override;
  void on_parameters_changed() noexcept override;
  bool standing() const noexcept override { return standing_.load(std::memory_order_relaxed); }
  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;
  std::string refuse_changes(const std::vector<ParameterChange>& changes) const override;

  const Odometry& odometry() const noexcept { return odometry_; }  ///< control thread
  /// As configured.
  const SpeedLimits& linear_limits() const noexcept { return linear_limits_; }
  const SpeedLimits& angular_limits() const noexcept { return angular_limits_; }

 private:
  struct Speeds {
    double linear = 0, angular = 0;  // m/s, rad/s
    bool operator==(const Speeds&) const = default;
  };
  struct Command {
    Speeds speeds;
    std::optional<Nanoseconds> stamp;
  };
  struct Place {
    double x = 0, y = 0, heading = 0;
  };

  // configuration
  void read_wheels(ControllerContext& context);
  void read_size(Parameters& p);
  void read_limits(Parameters& p, const std::string& axis, SpeedLimits& limits);
  void read_behaviour(Parameters& p);
  void make_outputs(ControllerContext& context);

  // control thread
  void take_command(const Cycle& cycle) noexcept;
  Speeds wanted(const Cycle& cycle, const Verdict& verdict) noexcept;
  Speeds referenced() noexcept;
  void forget() noexcept;
  void drive(const Speeds& wanted, bool at_once, double dt) noexcept;
  bool track(double dt) noexcept;
  double mean_feedback(const std::vector<std::size_t>& side) const noexcept;
  void publish(const Cycle& cycle) noexcept;

  std::vector<std::size_t> left_, right_;                    // commands
  std::vector<std::size_t> left_feedback_, right_feedback_;  // states
  double separation_ = 1, left_radius_ = 1, right_radius_ = 1;
  std::array<double, 6> pose_covariance_{}, twist_covariance_{};
  std::string prefix_, odom_frame_, base_frame_;
  int window_ = 10;
  bool open_loop_ = false, position_feedback_ = true;
  // changeable
  SpeedLimits linear_limits_, angular_limits_;
  bool tell_tf_ = true, tell_limited_ = false;

  // between the threads
  realtime::Latest<Command> commands_inbox_;
  realtime::Latest<Place> place_inbox_;
  std::atomic<bool> standing_{true};

  // control thread
  SpeedLimiter linear_, angular_;
  Odometry odometry_;
  Speeds command_;
  Speeds reference_;           // the last that was followed
  bool reference_old_ = true;  // it is from before a stop: not followed until it changes
  Output* odom_ = nullptr;
  Output* tf_ = nullptr;
  Output* limited_ = nullptr;
};

}  // namespace polyarm::controllers
