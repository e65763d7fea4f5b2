#pragma once
/// A robot that follows a moving frame, such as a conveyor belt, while it moves along its paths. SI units.
#include <array>
#include <atomic>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/joint_control/motion_shift.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/trajectory/joint_move.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::moves {

/// A frame that moves in one way: along its x axis (a belt), or about its z axis (a turntable).
struct MovingFrame {
  bool turns = false;
  Pose at_zero;  ///< T_world_frame where its encoder reads zero
  /// The motion in the world that has moved it by `travel`, m or rad.
  Pose motion(double travel) const noexcept;
  /// T_world_frame.
  Pose at(double travel) const noexcept { return motion(travel) * at_zero; }
};

/// What is known of the motion of a frame at a time: m or rad, per s, per s².
struct FrameTravel {
  double travel = 0, velocity = 0, acceleration = 0;
  Nanoseconds time = -1;  ///< cell time; < 0: nothing is known
  /// Where it will be `ahead` s later.
  FrameTravel after(double ahead) const noexcept {
    return {travel + ahead * (velocity + 0.5 * ahead * acceleration), velocity + ahead * acceleration,
            acceleration, time};
  }
};

/// Adds the motion of a frame to the paths of one robot. A path is planned as if the frame stood where it was
/// at the begin of the ride. In each cycle the pose of the path is moved by what the frame has moved since
/// then, and converted to joints; the joints approach them by a motion between any two states, so that no
/// limit of velocity, acceleration or jerk is exceeded. The error decays to zero and stays zero while the
/// frame moves smoothly.
///
/// A ride ends at rest. While the loop stops, the robot comes to rest, too, and catches up afterwards.
class FrameRide : public controllers::MotionShift {
 public:
  /// The chain must outlive this object. `limits`: of its joints.
  FrameRide(const kinematics::Chain& chain, std::span<const trajectory::JointMotionLimits> limits);

  // Cell thread.
  /// Only when over(). `at`: where the joints are. `lead`: the robot is where it was commanded this time
  /// later, s, in addition to the period.
  void begin(const MovingFrame& frame, double travel, std::span<const double> at, double lead);
  /// Call it in each tick of a ride with the newest travel.
  void feed(const FrameTravel& travel) { travel_.write(travel); }
  /// Comes to rest and ends.
  void release() noexcept { wanted_.store(false, std::memory_order_release); }
  bool over() const noexcept { return !active(); }
  /// True if the robot can no longer follow: out of reach, at a joint limit, or without news of the frame. It
  /// comes to rest and waits for release().
  bool lost() const noexcept { return state_.load(std::memory_order_acquire) == State::lost; }
  /// True if the robot is on its path in the moving frame.
  bool synchronised() const noexcept { return synchronised_.load(std::memory_order_acquire); }
  /// Where the joints came to rest. Valid when over().
  std::span<const double> joints() const noexcept { return last_; }
  /// The motion of the frame since the begin of the ride, as the robot follows it; valid while the ride
  /// lasts.
  Pose moved() const noexcept { return frame_.motion(moved_.load(std::memory_order_relaxed)); }

  // Control thread.
  bool active() const noexcept override {
    return wanted_.load(std::memory_order_acquire) || state_.load(std::memory_order_acquire) != State::off;
  }
  Outcome apply(const Request& request, const Joints& joints) noexcept override;
  bool standing() const noexcept override { return standing_; }
  void drop() noexcept override;

 private:
  enum class State { off, riding, lost };
  using States = std::vector<trajectory::MotionState>;

  void start(const Request& request, const Joints& joints) noexcept;
  bool follow_frame(const Request& request) noexcept;
  bool aim(const Request& request, const Joints& path) noexcept;
  bool solve(const Pose& target) noexcept;
  void solve_velocity(const Joints& path, const Pose& moved, const Pose& tcp) noexcept;
  void least_squares(const std::array<double, 6>& twist, std::span<double> out) noexcept;
  trajectory::MotionState brake(std::size_t joint, const Request& request) noexcept;
  trajectory::MotionState approach(std::size_t joint, const Request& request) noexcept;
  trajectory::MotionState towards_velocity(std::size_t joint, double velocity, double period,
                                           const trajectory::MotionLimits& limits) noexcept;
  void derive_acceleration(double period) noexcept;
  double allowed_jerk(std::size_t joint, double jerk, double period) const noexcept;
  trajectory::MotionLimits left_limits(std::size_t joint, double speed) const noexcept;
  bool is_at_end_of_range(std::size_t joint) const noexcept;
  void end() noexcept;

  const kinematics::Chain& chain_;
  std::vector<trajectory::MotionLimits> limits_;
  realtime::Latest<FrameTravel> travel_;

  // Written by the cell before wanted_.
  MovingFrame frame_;
  double from_ = 0, lead_ = 0;
  std::atomic<bool> wanted_{false}, synchronised_{false};
  std::atomic<State> state_{State::off};
  std::atomic<double> moved_{0};
  std::vector<double> last_;

  // Control thread.
  States now_, aim_, before_;  ///< commanded; of the path in the moving frame, in this cycle and the last
  std::vector<double> path_, jacobian_, solved_, guess_, step_;
  std::vector<double> earlier_;     ///< velocities of aim_ two cycles ago
  std::array<double, 3> smooth_{};  ///< travel of the frame, its velocity and acceleration, without steps
  int aimed_ = 0;                   ///< cycles in a row with an aim, at most 2
  bool standing_ = true;
  trajectory::StateToState planner_;
};

}  // namespace polyarm::moves
