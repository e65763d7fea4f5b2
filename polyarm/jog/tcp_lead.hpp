#pragma once
/// What the tool centre point (TCP) is to do in the next cycle, ahead of the joints that do it: ramps to a
/// velocity, and ways to a target that may move. Metres, radians, seconds, poses and twists in the world.
#include <array>
#include <cstddef>
#include <span>

#include "polyarm/base/pose.hpp"
#include "polyarm/jog/jog_axis.hpp"
#include "polyarm/jog/twist.hpp"
#include "polyarm/jog/twist_solver.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::jog {

/// A jerk-limited motion of the TCP that joints follow: where the TCP would be, and how fast, if nothing held
/// it back. It changes its velocity no quicker than a share of the joints' accelerations and jerks allows
/// where the arm is. One thread; no allocation, locks, exceptions or clock but in the constructor. Solvers
/// handed in are at the joints' state.
class TcpLead {
 public:
  /// A target that moves is followed in its own frame, with this share of the speed at most, so that some is
  /// left to catch up with; where it will be so much later, s, is the direction that matters.
  static constexpr double kFollows = 0.9, kAhead = 0.1;

  /// A pose that moves, and how fast it may be gone for.
  struct Target {
    Pose pose;
    Twist twist{};                  ///< its own velocity
    double speed = 0, turning = 0;  ///< m/s and rad/s at most
  };

  /// `axes`: of all joints of the chain; `period`: of a cycle, s.
  TcpLead(std::span<const AxisLimits> axes, double period);

  /// Does it lead?
  bool on() const noexcept { return on_; }
  void end() noexcept { on_ = false; }
  /// From a TCP that moves.
  void begin(const Pose& tcp, const Twist& twist) noexcept;
  const Pose& pose() const noexcept { return pose_; }
  const Twist& twist() const noexcept { return twist_; }

  /// One cycle towards a velocity: what begins or ends at rest is straight.
  void ramp(const Twist& wanted, const TwistSolver& solver) noexcept;
  /// The twist that leads to the target at the speed that is allowed.
  Twist way_to(const Target& target) const noexcept;
  /// One cycle towards the target, at `share` of its speeds. Is it reached, by the TCP, too?
  bool approach(const Target& target, double share, const TwistSolver& solver) noexcept;

  /// It goes on from where the TCP is.
  void return_to(const Pose& tcp) noexcept { pose_ = tcp; }
  /// The arm is held back: it stays with the arm, at `share` of the velocity. Where it hardly moves it does
  /// not gather speed against what holds it.
  void hold_back(const Pose& tcp, double share) noexcept;

 private:
  /// Bounds of the TCP's acceleration and jerk along its axes, first those of its place, then of turning.
  struct Pace {
    double acceleration[2] = {20, 200}, jerk[2] = {400, 4000};
  };
  /// How quickly a motion may change: along its way, and along any axis.
  struct Pull {
    double acceleration, jerk, any_acceleration, any_jerk;
  };
  void capability(const Twist& direction, const TwistSolver& solver, double& acceleration,
                  double& jerk) const noexcept;
  Pull pull_along(const Twist& ahead, std::size_t part, const TwistSolver& solver) const noexcept;

  std::size_t joints_;
  JogValues acceleration_{}, jerk_{};  // of joints, that the TCP may change its velocity with
  double dt_;
  trajectory::StateToState plan_;
  bool on_ = false;
  Pose pose_;
  Twist twist_{}, slope_{};
};

}  // namespace polyarm::jog
