#pragma once
/// Moves of a base with wheels, one at a time: so far ahead, so far around.
#include <cstdint>
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/controllers/diff_drive_controller.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::moves {

struct BaseMove {
  bool turns = false;       ///< on the spot; else straight on
  double amount = 0;        ///< m, backwards below 0; or rad, to the left above 0
  double share = 1;         ///< of the controller's velocity limit, (0, 1]
  double speed = 0;         ///< m/s or rad/s, at most; 0: the limit
  double acceleration = 0;  ///< m/s² or rad/s², at most; 0: the limit
  double duration = 0;      ///< s, at least
};

/// From rest to rest within velocity, acceleration and jerk, by the odometry of the base's controller, which
/// is commanded through its cmd_vel; a straight way is held on its line. Where the controller states no
/// acceleration, full speed is reached in half a second; where it states no jerk, full acceleration in 0.2 s.
/// Held, it stands; going on, it goes the rest from where it stands. Cell thread only.
class BaseMotion {
 public:
  enum class State { running, done, failed, discarded };

  /// The controller outlives this. `period`: of its updates, s.
  BaseMotion(controllers::DiffDriveController& controller, double period);
  const controllers::DiffDriveController& controller() const { return controller_; }

  /// Returns its id, which counts up from 1. Throws Error("busy") while another is under way, and
  /// Error("no-odometry").
  std::uint64_t start(const BaseMove& move);
  /// Every tick. `running`: the loop is neither held nor in a fault. `share`: of the planned speed, [0, 1].
  void tick(Nanoseconds now, bool running, double share);
  /// Gives up what is under way; the base comes to rest within its limits.
  void drop();

  bool idle() const { return !active_; }
  State state_of(std::uint64_t id) const;
  /// Why the last move failed.
  const std::optional<Problem>& problem() const { return problem_; }
  std::uint64_t last_id() const { return last_id_; }

 private:
  struct Place {
    double x = 0, y = 0, heading = 0;  ///< heading unbounded
  };
  bool look();
  double covered() const;
  bool plan(double from);
  void send(double linear, double angular);
  void end(State outcome);

  controllers::DiffDriveController& controller_;
  controllers::Output* odometry_ = nullptr;
  double gain_;  // 1/s: of what is left behind the plan
  BaseMove move_;
  trajectory::MotionLimits limits_;
  trajectory::StateToState motion_;
  Place place_, begin_;
  bool seen_ = false, active_ = false, planned_ = false;
  double time_ = 0, late_ = 0;  // s: of the plan; since its end
  double pace_ = 1;             // of the plan's time
  Nanoseconds last_ = -1;
  std::uint64_t last_id_ = 0;
  State outcome_ = State::done;
  std::optional<Problem> problem_;
};

}  // namespace polyarm::moves
