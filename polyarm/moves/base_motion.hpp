#pragma once
/// Moves of a wheeled base, one at a time: straight by a distance, or on the spot by an angle. Metres,
/// radians, seconds.
#include <cstdint>
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/trajectory/state_to_state.hpp"
#include "polyarm/wheels/base_controller.hpp"

namespace polyarm::moves {

struct BaseMove {
  bool turns = false;       ///< on the spot; else straight
  double amount = 0;        ///< m, negative backwards; or rad, positive to the left
  double share = 1;         ///< fraction of the controller's velocity limit, (0, 1]
  double speed = 0;         ///< m/s or rad/s, maximum; 0: the limit
  double acceleration = 0;  ///< m/s² or rad/s², maximum; 0: the limit
  double duration = 0;      ///< s, minimum
};

/// A base that steers only drives straight.
/// Moves from rest to rest within velocity, acceleration and jerk limits. Feedback comes from the odometry of
/// the base's controller; commands go through its cmd_vel. A straight move stays on its line. If the
/// controller states no acceleration, full speed takes half a second; if it states no jerk, full acceleration
/// takes 0.2 s. On hold the base stops; on resume it continues from where it is. Cell thread only.
class BaseMotion {
 public:
  enum class State { running, done, failed, discarded };

  /// The controller must outlive this object. `period`: of its updates, s.
  BaseMotion(controllers::BaseController& controller, double period);
  const controllers::BaseController& controller() const { return controller_; }

  /// Returns its id, which counts up from 1. Throws Error("busy") during another move,
  /// Error("no-odometry"), and Error("bad-move") for a turn of a base that steers.
  std::uint64_t start(const BaseMove& move);
  /// Call it in every tick. `running`: the loop is neither held nor in a fault. `share`: fraction of the
  /// planned speed, [0, 1].
  void tick(Nanoseconds now, bool running, double share);
  /// Discards the present move; the base stops within its limits.
  void drop();

  bool idle() const { return !active_; }
  /// What is left of the present move: m straight, or rad on the spot, not negative. No move: nothing.
  struct Left {
    double way = 0, turn = 0;
  };
  std::optional<Left> left() const;
  State state_of(std::uint64_t id) const;
  /// The reason why the last move failed.
  const std::optional<Problem>& problem() const { return problem_; }
  std::uint64_t last_id() const { return last_id_; }

 private:
  struct Place {
    double x = 0, y = 0, heading = 0;  ///< heading unbounded
  };
  bool look();
  bool is_silent(double dt);
  double covered() const;
  bool plan(double from);
  void send(double linear, double angular);
  void end(State outcome);

  controllers::BaseController& controller_;
  controllers::Output* odometry_ = nullptr;
  double gain_;  // 1/s: feedback gain for the distance to the plan
  BaseMove move_;
  trajectory::MotionLimits limits_;
  trajectory::StateToState motion_;
  Place place_, begin_;
  bool seen_ = false, active_ = false, planned_ = false;
  double time_ = 0, late_ = 0;  // s: time on the plan; time since its end
  double pace_ = 1;             // speed of the plan's time
  Nanoseconds last_ = -1, heard_ = 0;  ///< of the last tick; stamp of the newest odometry
  double unheard_ = 0;                 ///< s since it came
  std::uint64_t last_id_ = 0;
  State outcome_ = State::done;
  std::optional<Problem> problem_;
};

}  // namespace polyarm::moves
