#pragma once
/// The reference motion of the tool centre point (TCP) ahead of the joints: ramps to a velocity, and paths to
/// a target that may move. Metres, radians, seconds; poses and twists in the world.
#include <array>
#include <cstddef>
#include <span>

#include "polyarm/base/pose.hpp"
#include "polyarm/jog/jog_axis.hpp"
#include "polyarm/jog/twist.hpp"
#include "polyarm/jog/twist_solver.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::jog {

/// A jerk-limited motion of the TCP that the joints follow: the pose and velocity that the TCP would have if
/// nothing held it back. Its velocity changes within a share of the joints' accelerations and jerks in the
/// present pose of the arm. One thread; only the constructor allocates, and nothing locks, throws or reads a
/// clock. A solver argument must be set to the joints' state.
class TcpLead {
 public:
  /// A moving target is followed in its own frame with at most kFollows of the speed; the rest is for
  /// catching up. The path aims at the target's position kAhead seconds later.
  static constexpr double kFollows = 0.9, kAhead = 0.1;

  /// A moving pose, and the allowed speed towards it.
  struct Target {
    Pose pose;
    Twist twist{};                  ///< its velocity
    double speed = 0, turning = 0;  ///< m/s and rad/s, maximum
  };

  /// `axes`: of all joints of the chain; `period`: of a cycle, s.
  TcpLead(std::span<const AxisLimits> axes, double period);

  /// True while a lead exists.
  bool on() const noexcept { return on_; }
  void end() noexcept { on_ = false; }
  /// Starts from a moving TCP.
  void begin(const Pose& tcp, const Twist& twist) noexcept;
  const Pose& pose() const noexcept { return pose_; }
  const Twist& twist() const noexcept { return twist_; }

  /// One cycle towards a velocity; a motion that begins or ends at rest is straight.
  void ramp(const Twist& wanted, const TwistSolver& solver) noexcept;
  /// The twist towards the target at the allowed speed.
  Twist way_to(const Target& target) const noexcept;
  /// One cycle towards the target, at `share` of its speeds. True if lead and TCP have reached it.
  bool approach(const Target& target, double share, const TwistSolver& solver) noexcept;

  /// Is where another motion leads: at `pose`, with its twist and the change of that per s.
  void set(const Pose& pose, const Twist& twist, const Twist& slope) noexcept {
    pose_ = pose;
    twist_ = twist;
    slope_ = slope;
  }
  const Twist& slope() const noexcept { return slope_; }
  /// Continues from the present pose of the TCP.
  void return_to(const Pose& tcp) noexcept { pose_ = tcp; }
  /// For an arm that is held back: keeps the lead at the arm's pose with `share` of the velocity. If the arm
  /// hardly moves, the lead does not accelerate.
  void hold_back(const Pose& tcp, double share) noexcept;

 private:
  /// Bounds of the TCP's acceleration and jerk along its axes, first for translation, then for rotation.
  struct Pace {
    double acceleration[2] = {20, 200}, jerk[2] = {400, 4000};
  };
  /// The allowed rate of change of a motion: along its path, and along any axis.
  struct Pull {
    double acceleration, jerk, any_acceleration, any_jerk;
  };
  void capability(const Twist& direction, const TwistSolver& solver, double& acceleration,
                  double& jerk) const noexcept;
  Pull pull_along(const Twist& ahead, std::size_t part, const TwistSolver& solver) const noexcept;

  std::size_t joints_;
  JogValues acceleration_{}, jerk_{};  // of joints, for changes of the TCP's velocity
  double dt_;
  trajectory::StateToState plan_;
  bool on_ = false;
  Pose pose_;
  Twist twist_{}, slope_{};
};

}  // namespace polyarm::jog
