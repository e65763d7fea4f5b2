#pragma once
/// The line that a TCP is jogged along: how fast the joints may go on it, and where it ends. Metres, radians,
/// seconds; poses and twists in the world.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/jog/jog_axis.hpp"
#include "polyarm/jog/jog_hold.hpp"
#include "polyarm/jog/twist.hpp"
#include "polyarm/jog/twist_solver.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::jog {

/// A path of the TCP from one pose on: a straight line, a rotation about an axis, or both at once. The way
/// along it is in m, or in rad for a rotation alone. It follows the joints ahead as far as the robot needs to
/// brake, and changes the speed along the path so that the joints keep their velocities, accelerations, jerks
/// and ranges on it: the motion becomes slower, down to a stop, and never leaves the path. It stops before a
/// singularity on the path.
///
/// Method: time-optimal scaling of a given path (Bobrow, Dubowsky and Gibson 1985) with constant shares of
/// the joints' limits. Nodes ahead hold what the joints allow there, from their first three derivatives by
/// the way. A step is accepted if braking after it stays within all of that.
///
/// One thread; only the constructor allocates, and nothing locks, throws or reads a clock.
class JogLine {
 public:
  /// `chain` outlives it. `axes`: of all joints of the chain. `period`: of a cycle, s.
  JogLine(const kinematics::Chain& chain, std::span<const AxisLimits> axes, double period);

  bool on() const noexcept { return count_ > 0; }
  void end() noexcept { count_ = 0; }
  /// The path from the pose `tcp`; the joints `q` are there, or a little beside it. `unit`: the twist there,
  /// its linear part of length 1, or its angular part if there is no linear part. `turns`: the twist turns
  /// with the TCP. `speed` and `slope`: of the motion along it now. False in a singularity that the path needs to leave.
  bool begin(std::span<const double> q, const Pose& tcp, const Twist& unit, bool turns, double speed,
             double slope) noexcept;

  /// What else ends the path: `room` ahead of the present place.
  struct Stop {
    double room = 1e300;
    JogHold hold = JogHold::none;
    std::size_t which = 0;
  };
  /// The places that are known: the first one is at the present place or a little behind it.
  std::size_t places() const noexcept { return count_; }
  /// How far the place `k` is ahead.
  double ahead(std::size_t k) const noexcept { return nodes_[k].at - state_.position; }
  std::span<const double> joints_at(std::size_t k) const noexcept {
    return {places_.data() + k * joints_, joints_};
  }
  /// One cycle towards `goal`, a speed along the path of zero or more. `joint_share`: of the joints'
  /// velocities.
  void step(double goal, double joint_share, const Stop& stop) noexcept;
  /// Brakes in the last step instead, as hard as it may; take_back() mixes both: 1 is the step as it was.
  void brake_instead() noexcept;
  void take_back(double share) noexcept;
  /// For a TCP that is at `tcp` and moves by `twist`, behind its place or in front of it: goes on from the
  /// nearest place at the speed along the path.
  void fall_back(const Pose& tcp, const Twist& twist) noexcept;

  double speed() const noexcept { return state_.velocity; }
  bool stands() const noexcept { return state_.velocity == 0 && state_.acceleration == 0; }
  Pose pose() const noexcept { return pose_at(state_.position); }
  /// The direction at the present place: the twist per unit of the way.
  Twist direction() const noexcept { return direction_at(state_.position); }
  double slope() const noexcept { return state_.acceleration; }
  /// What made the last step slower than its goal.
  JogHold hold() const noexcept { return stop_.hold; }
  std::size_t which() const noexcept { return stop_.which; }

  /// Exact joint velocities for a twist. In an arm with spare joints, those near their limits do less and
  /// others do more. `solver` is at `q`, and keeps the weights. False if a singularity takes a part of the
  /// twist.
  bool rates_for(const Twist& twist, std::span<const double> q, TwistSolver& solver,
                 JogValues& rates) const noexcept;

 private:
  /// A place of the path, and what counts from the one before it to the one after it.
  struct Node {
    double at = 0;
    double velocity = 0;                ///< the highest speed, at full share of the joints' velocities
    double followed = 0;                ///< the highest speed that the joints can follow
    double acceleration = 0, jerk = 0;  ///< of the speed
    JogHold cause = JogHold::speed;     ///< of `followed`
  };
  static constexpr std::size_t kNodes = 64;

  Pose pose_at(double way) const noexcept;
  Twist direction_at(double way) const noexcept;
  bool tangent_at(std::span<const double> q, double way, JogValues& out) noexcept;
  void put_on_line() noexcept;
  void add(double at, const JogValues& tangent, double step) noexcept;
  void extend() noexcept;
  bool try_extend(double by) noexcept;
  void stop_at(double at, JogHold hold, std::size_t which) noexcept;
  double before_limits(const JogValues& from, const JogValues& to, std::size_t& which) const noexcept;
  Node between_nodes(std::size_t before) const noexcept;
  bool brakes_in_time(const AxisState& from, double joint_share, const Stop& stop) noexcept;

  TwistSolver solver_;
  std::vector<AxisLimits> axes_;
  std::size_t joints_;
  double dt_, length_;
  Pose start_;
  Twist unit_{};
  bool turns_ = false;
  AxisState state_, stepped_, braked_;  // along the path; after the last step, and if it brakes
  double goal_ = 0;
  std::array<Node, kNodes> nodes_;
  std::vector<double> places_;  // joints at the nodes
  std::size_t count_ = 0;
  Stop end_;  // of the path, as far as it is known: room is a place
  bool ends_ = false;
  bool from_rest_ = false, is_known_ = false;  // is_known_: as far as the motion needs to brake
  Stop stop_;                                  // room: unused
  double apart_ = 0;                    // the way to the next node that is to be tried; 0: by the speed
  double needed_ = 0;                   // the way to the place of rest of the last look ahead
  JogValues q_{}, tangent_{}, bend_{};  // at the last node; bend_: second derivative
};

}  // namespace polyarm::jog
