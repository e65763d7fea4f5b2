#pragma once
#include <array>
#include <atomic>
#include <limits>
#include <optional>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/controllers/speed_limiter.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/wheels/odometry.hpp"

namespace polyarm::controllers {

/// What every controller of a wheeled base has: it takes twists, limits them, follows stops, and publishes
/// odometry. A class derived from it knows the wheels: it turns a twist into commands and measures odometry.
///
/// Inputs: twists on `cmd_vel` or `reference` (geometry_msgs/TwistStamped or Twist), `set_odometry` (x, y,
/// heading) and `reset_odometry`. References for a controller before it, in m/s and rad/s; while one writes
/// them, twists are ignored. Outputs: odometry and its transform.
///
/// A twist that is older than its time-out, or a stop, becomes a wanted speed of zero, reached within the
/// limits; what was commanded before a stop is forgotten, so that nothing moves again by itself.
class BaseController : public Controller {
 public:
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle& cycle) noexcept override;
  void on_parameters_changed() noexcept override;
  bool standing() const noexcept override { return standing_.load(std::memory_order_relaxed); }
  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;
  std::string refuse_changes(const std::vector<ParameterChange>& changes) const override;

  /// False of steered bases: they turn only while they drive.
  virtual bool turns_on_the_spot() const { return true; }
  /// Largest curvature that it drives, 1/m; infinite if it turns on the spot. As configured.
  virtual double sharpest() const noexcept { return std::numeric_limits<double>::infinity(); }
  /// The speed of the place that the odometry tracks, over that of the fastest wheel, on an arc.
  virtual double share_on(double /*curvature*/) const noexcept { return 1; }
  /// Curvature to which it steers now, as measured, 1/m; 0 if it turns on the spot. Any thread.
  double curvature() const noexcept { return curvature_.load(std::memory_order_relaxed); }
  /// Control thread.
  virtual const PlanarOdometry& odometry() const noexcept = 0;
  /// Null before it is configured.
  Output* odometry_output() const { return odom_; }
  /// As configured.
  virtual SpeedLimits linear_limits() const noexcept { return limits_[0]; }
  const SpeedLimits& angular_limits() const noexcept { return limits_[2]; }

 protected:
  /// Names and defaults that differ between the controllers of ros2_controllers.
  struct Style {
    const char* port = "cmd_vel";
    const char* timeout_key = "cmd_vel_timeout";
    double timeout = 0.5;               ///< default, s
    bool milliseconds = false;          ///< timeout_key is a whole number of ms
    bool zero_timeout_is_once = false;  ///< a time-out of 0: a twist counts for one update; else for ever
    bool lateral = false;               ///< it drives sideways: `linear.y`, and three references
    bool chains = true;                 ///< it offers references
    bool nan_stops = true;              ///< a reference of NaN stops; else the last one is kept
    bool limits_speed = true;           ///< reads linear.x.… and linear.y.…
    bool limits_turning = true;         ///< reads angular.z.…
    bool has_window = true;             ///< reads velocity_rolling_window_size
    bool has_position_feedback = true;  ///< reads position_feedback
    bool position_feedback = false;     ///< default
    bool has_open_loop = true;          ///< reads open_loop
    bool transform = true;              ///< default of enable_odom_tf
    const char* odometry = "odom";      ///< names of outputs
    const char* transforms = "tf";
    const char* pose_covariance = "pose_covariance_diagonal";
    const char* twist_covariance = "twist_covariance_diagonal";
    std::array<double, 6> covariance{};  ///< default of both
  };
  explicit BaseController(const Style& style) : style_(style) {}

  /// Reads the parameters that bases have in common, and makes references and outputs. Not real-time.
  void read_base(ControllerContext& context);
  /// Last step of on_configure.
  CallbackReturn finish_base(Parameters& p);
  /// "joint" → "robot/joint", where "before/joint" may be a reference of a controller that follows this one.
  static std::string whole_wheel(const ControllerContext& context, const std::string& written,
                                 const std::string& interface, const std::string& key);
  /// Claims the command and adds the problem where the same was claimed before.
  std::size_t claim_wheel(ControllerContext& context, const std::string& written,
                          const std::string& interface, const std::string& key);

  /// How far all of these joints turn to both sides from 0, rad; infinite where nobody states it.
  static double steering_limit(const ControllerContext& context, const std::vector<std::string>& joints);

  bool open_loop() const noexcept { return open_loop_; }
  bool position_feedback() const noexcept { return position_feedback_; }
  /// False: the odometry's message has a velocity and no pose.
  void set_publishes_pose(bool publishes) { publishes_pose_ = publishes; }
  std::size_t window() const noexcept { return static_cast<std::size_t>(window_); }
  /// Control thread: the supervisor has stopped everything; it must stop as fast as it can; s of this update,
  /// 0 at activation and deactivation.
  bool stopped() const noexcept { return stopped_; }
  bool at_once() const noexcept { return at_once_; }
  double step() const noexcept { return step_; }

  // Control thread, of the derived class:
  /// Commands the wheels. `limited`: the twist within limits. `wish`: the twist that is wanted; empty if
  /// nothing is commanded, after a time-out and during a stop.
  virtual void write(const PlanarTwist& limited, const std::optional<PlanarTwist>& wish) noexcept = 0;
  /// Measures the wheels and updates the odometry; false if a measurement is missing, which is an error.
  virtual bool track(const PlanarTwist& commanded, double dt) noexcept = 0;
  virtual PlanarOdometry& place() noexcept = 0;
  /// Odometry counts from here; the first command of a steering is its last one or where it is.
  virtual void begin() noexcept {}
  /// False while wheels still slow down after the twist has reached zero.
  virtual bool wheels_at_rest() const noexcept { return true; }
  virtual void publish_more(const Cycle& cycle) noexcept {}
  void set_curvature(double curvature) noexcept { curvature_.store(curvature, std::memory_order_relaxed); }

 private:
  struct Command {
    PlanarTwist twist;
    std::optional<Nanoseconds> stamp;
    bool once = false;  ///< counts for one update
  };
  struct Place {
    double x = 0, y = 0, heading = 0;
  };

  void read_behaviour(Parameters& p);
  void read_limits(Parameters& p, const std::string& axis, SpeedLimits& limits);
  void make_outputs(ControllerContext& context);
  void export_references(const std::string& name);

  void take_command(const Cycle& cycle) noexcept;
  std::optional<PlanarTwist> wanted(const Cycle& cycle, const Verdict& verdict) noexcept;
  std::optional<PlanarTwist> sent(const Cycle& cycle) noexcept;
  std::optional<PlanarTwist> referenced() noexcept;
  PlanarTwist references() const noexcept;
  void set_references(const PlanarTwist& twist) noexcept;
  void forget() noexcept;
  void drive(const std::optional<PlanarTwist>& wish, bool at_once, double dt) noexcept;
  PlanarTwist limited() const noexcept;
  void publish(const Cycle& cycle) noexcept;

  const Style style_;
  std::array<double, 6> pose_covariance_{}, twist_covariance_{};
  int window_ = 10;
  bool open_loop_ = false, position_feedback_ = true, publishes_pose_ = true;
  // changeable
  std::array<SpeedLimits, 3> limits_;  // x, y, angular
  bool publish_tf_ = true, report_limited_ = false;

  // between the threads
  realtime::Latest<Command> commands_inbox_;
  realtime::Latest<Place> place_inbox_;
  std::atomic<bool> standing_{true};
  std::atomic<double> curvature_{0};

  // control thread
  std::array<SpeedLimiter, 3> limiters_;
  PlanarTwist command_;
  bool once_ = false, stopped_ = false, at_once_ = true;
  double step_ = 0;
  Nanoseconds brief_until_ = 0;  // of a twist on cmd_vel where a time-out of 0 means once; 0: none
  PlanarTwist reference_;        // the last that was followed
  bool reference_old_ = true;    // it is from before a stop: not followed until it changes
  Output* odom_ = nullptr;
  Output* tf_ = nullptr;
  Output* limited_ = nullptr;
};

/// Where `key` is written, if it is.
Location place_in_file(const Parameters& parameters, const std::string& key);
/// Adds a problem unless `value` is finite and above 0 (`any_sign`: is finite and not 0).
void require_size(Parameters& parameters, const std::string& key, double value, bool any_sign = false);
/// Uses the value of an older key under its new names, with a warning; new names that are written win.
void rename_key(Parameters& parameters, const std::string& old, const std::vector<std::string>& today);

}  // namespace polyarm::controllers
