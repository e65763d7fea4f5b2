#pragma once
/// Moves of a wheeled base, one at a time: straight by a distance, on the spot by an angle, or to a place
/// around obstacles. Metres, radians, seconds.
#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
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
  /// T_world_goal of the frame that the odometry tracks: the base goes there around obstacles, and `turns`,
  /// `amount` and `duration` do not count. Only the position in the plane and the heading count.
  std::optional<Pose> to = {};
  double turn_speed = 0,
         turn_acceleration = 0;  ///< of turns on this way: rad/s and rad/s², maximum; 0: the limit
};

/// A piece of a way, in the world: a turn on the spot to the heading, a straight line, or an arc.
struct BaseLeg {
  bool turns = false;
  Vec3 from, to;
  double heading = 0;      ///< at its end
  bool backwards = false;  ///< of a line or an arc
  double curvature = 0;    ///< of an arc: 1/m, positive to the left
  double length = 0;       ///< m, of a line or an arc
  double kept = 0;         ///< m from everything else, along the leg, as it was planned
};

/// What a base knows of the cell. All but the search itself is called on the cell thread.
struct BaseSurroundings {
  std::function<Pose()> T_world_odometry;
  /// Looks at what is around now. The returned search runs on the planning thread; it throws Error if there
  /// is no way, and ends soon once `dropped` returns true.
  using Search = std::function<std::vector<BaseLeg>(const std::function<bool()>& dropped)>;
  std::function<Search(const Pose& goal)> look;
  std::function<void(std::function<void()>)> post;  ///< runs a job, immediately or on another thread
};

/// A base that steers does not turn on the spot: its ways have arcs, and it stands while it steers to the
/// next curvature. A base that leaves its way stops and looks for another one. Moves from rest to rest within
/// velocity, acceleration and jerk limits. Feedback comes from the odometry of the base's controller;
/// commands go through its cmd_vel. A straight move stays on its line. If the controller states no
/// acceleration, full speed takes half a second; if it states no jerk, full acceleration takes 0.2 s. On hold
/// the base stops; on resume it continues from where it is. Cell thread only.
class BaseMotion {
 public:
  enum class State { running, done, failed, discarded };

  /// The controller must outlive this object. `period`: of its updates, s.
  BaseMotion(controllers::BaseController& controller, double period);
  ~BaseMotion();
  BaseMotion(const BaseMotion&) = delete;
  BaseMotion& operator=(const BaseMotion&) = delete;
  const controllers::BaseController& controller() const { return controller_; }
  /// Without it there are no moves to a place.
  void set_surroundings(BaseSurroundings around) { around_ = std::move(around); }
  /// T_world_base of the frame that the odometry tracks, after set_surroundings().
  Pose pose();

  /// Largest curvature of its ways, 1/m; infinite: it turns on the spot. Smaller than that of the base, so
  /// that it can steer back to its way.
  double sharpest() const;
  /// Returns its id, which counts up from 1. Throws Error("busy") during another move,
  /// Error("no-odometry"), and Error("bad-move") for a turn of a base that steers.
  std::uint64_t start(const BaseMove& move);
  /// Call it in every tick. `running`: the loop is neither held nor in a fault. `share`: fraction of the
  /// planned speed, [0, 1].
  void tick(Nanoseconds now, bool running, double share);
  /// Discards the present move; the base stops within its limits.
  void drop();

  bool idle() const { return !active_; }
  /// What is left of the present move, or of the present leg of a way: m, and rad on the spot or along an
  /// arc, not negative. Zero while the base brakes at the end of a move or of a leg. Empty without a move,
  /// before a way is known, and while the base moves as the move does not explain: somebody else drives it.
  struct Left {
    double way = 0, turn = 0;
    double curvature = 0;    ///< of the arc, 1/m, positive to the left; 0: a line
    bool backwards = false;  ///< of a line or an arc; of a turn: to the right
    std::optional<double> kept = {};  ///< of a leg: m from everything else, as it was planned
    double braking = 0;               ///< most at its end: m/s², rad/s² of a turn; 0 after the end
  };
  std::optional<Left> left() const;
  /// The highest speed from now on, m/s along a line or an arc, rad/s of a turn; infinite: the limits alone.
  void set_most(double speed) { most_ = speed; }
  State state_of(std::uint64_t id) const;
  /// The reason why the last move failed.
  const std::optional<Problem>& problem() const { return problem_; }
  std::uint64_t last_id() const { return last_id_; }

 private:
  struct Place {
    double x = 0, y = 0, heading = 0;  ///< heading unbounded
  };
  struct Job {
    std::vector<BaseLeg> legs;
    std::optional<Problem> failure;
    std::atomic<bool> done{false}, dropped{false};
  };
  /// Of a base that comes to rest after a move or a leg.
  struct RollOut {
    Nanoseconds since = 0;
    Place from;
    double way = 0, turn = 0;               ///< no farther than this, m and rad
    std::optional<Nanoseconds> stood = {};  ///< since when
  };
  bool look();
  void begin_to_roll();
  void follow_roll(Nanoseconds now);
  bool is_silent(double dt);
  double covered() const;
  double beside() const;
  double strayed() const;
  bool plan(double from);
  void begin(bool turns, double amount, double curvature);
  bool steers() const { return move_.to && !controller_.turns_on_the_spot(); }
  bool has_leg();
  void begin_search();
  void drop_search();
  bool take_way();
  void begin_leg();
  void end_way();
  void look_again();
  bool begin_plan(double dt);
  bool has_steered(double dt);
  bool go_on();
  bool late(double off, double dt);
  void slow_down(const trajectory::MotionState& state, double dt);
  void fail(Problem problem);
  void send_speed(double speed);
  void send_steered(double speed, double astray);
  void send(double linear, double angular);
  void end(State outcome);

  controllers::BaseController& controller_;
  controllers::Output* odometry_ = nullptr;
  double gain_;  // 1/s: feedback gain for the distance to the plan
  BaseSurroundings around_;
  BaseMove move_;
  std::shared_ptr<Job> job_;                 // the search for a way; null: none
  std::optional<std::vector<BaseLeg>> way_;  // of a move to a place, once it is known
  std::size_t leg_ = 0;                      // the present one
  bool leg_begun_ = false;
  int ways_ = 0;          // that were begun for this move
  bool goes_on_ = false;  // a base that steers has just ended the leg before, at rest
  bool steered_ = false;  // it has the curvature of the leg
  double steering_ = 0;   // s since it began to steer
  double curvature_ = 0;  // of the present leg, 1/m
  bool turns_ = false;  // what it does now: a turn, else a straight line
  double amount_ = 0;   // of it: rad or m
  trajectory::MotionLimits limits_;
  trajectory::StateToState motion_;
  Place place_, begin_;  // begin_: where the turn or the line begins
  bool seen_ = false, active_ = false, planned_ = false;
  double time_ = 0, late_ = 0;  // s: time on the plan; time since its end
  double pace_ = 1;             // speed of the plan's time
  double slow_ = 1;             // the same, below most_
  double most_ = std::numeric_limits<double>::infinity();
  Nanoseconds last_ = -1, heard_ = 0;  ///< of the last tick with a move; stamp of the newest odometry
  double unheard_ = 0;                 ///< s since it came
  Nanoseconds now_ = 0;                ///< of the last tick
  std::optional<RollOut> rolls_out_;
  std::uint64_t last_id_ = 0;
  State outcome_ = State::done;
  std::optional<Problem> problem_;
};

}  // namespace polyarm::moves
