#pragma once
/// Plans timed paths for moves. It allocates, throws and takes milliseconds: not for the control cycle. Any
/// thread, while the robot's facts stay valid. Metres, radians, seconds; poses of the TCP in the world.
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/moves/robot_facts.hpp"
#include "polyarm/paths/cartesian_path.hpp"
#include "polyarm/timing/timed_path.hpp"
#include "polyarm/timing/timing.hpp"

namespace polyarm::moves {

/// joint: straight in joint space. line, arc and spline: geometry of the TCP.
enum class MoveKind { joint, line, arc, spline };

struct MoveTarget {
  std::variant<std::vector<double>, Pose> at;  ///< a joint state of the robot, or a pose of the TCP
  std::string name;                            ///< for messages
};

struct Move {
  MoveKind kind = MoveKind::joint;
  /// The end of the move. An arc has its via point before it; a spline has all poses to pass.
  std::vector<MoveTarget> targets;
  paths::ArcOrientation orientation = paths::ArcOrientation::interpolated;
  /// m at the TCP: the largest distance from the end at which the path may leave this move for the next; 0:
  /// it stops there. Ignored for the last move.
  double blend = 0;
  /// The path passes exactly through the end and continues with the next move without a stop. Only for joint
  /// moves: consecutive ones, with the move after them, form one natural cubic spline in joint space. Ignored
  /// for the last move.
  bool through = false;
  /// A joint move that goes around obstacles. It begins and ends at rest. RobotMotion has `over` filled before it
  /// plans.
  bool around = false;
  struct Corner {
    std::vector<double> at;  ///< a joint state on the way
    double radius = 0;       ///< in the norm of joint space, rad or m: how far the path may leave it
  };
  std::vector<Corner> over;  ///< of a move around obstacles, in order; its target is not among them
  double speed = 1;               ///< fraction of the joints' velocity limits, or of the TCP's, (0, 1]
  double acceleration = 1;        ///< the same for acceleration and jerk
  double tcp_speed = 0;           ///< m/s, maximum; 0: as TcpLimits (a joint move: unlimited)
  double tcp_acceleration = 0;    ///< m/s², the same; the jerk scales with it
  double turn_speed = 0;          ///< rad/s of the TCP, the same
  double turn_acceleration = 0;   ///< rad/s²
  double joint_speed = 0;         ///< rad/s (or m/s) of every joint, maximum; 0: its limit
  double joint_acceleration = 0;  ///< rad/s², the same; the jerk scales with it
  double duration = 0;            ///< s, minimum
  double joint_pace = 0;          ///< s per rad (or m) of joint-space distance, minimum; for joint moves

  const MoveTarget& end() const { return targets.back(); }
};

/// One motion from rest to rest.
struct PlannedMotion {
  timing::TimedPath path;
  std::size_t first = 0, last = 0;          ///< indices of moves; a move that is split belongs to two motions
  std::vector<double> ends;                 ///< s at which moves end: first, first + 1, …
  std::vector<timing::ActiveLimit> active;  ///< the limiting rows along the path; rows beyond the joints:
                                            ///< `bounds`
  std::vector<std::string> bounds;
  /// To keep all torques within their limits, the joints' accelerations are reduced to this fraction of their
  /// limits. Without that, the torque of `torque_joint` would be too high.
  double torque_share = 1;
  std::size_t torque_joint = 0;
};

struct MovePlan {
  std::vector<PlannedMotion> motions;            ///< empty if every move ends where it begins
  std::vector<double> end;                       ///< joint state
  std::vector<trajectory::MotionLimits> limits;  ///< limits of the joints, which the paths keep
  struct Warning {
    std::size_t move;
    Problem problem;  ///< "blend-shrunk"
  };
  std::vector<Warning> warnings;
  double duration() const;
};

/// A move that cannot be planned. `move`: its index.
class MoveError : public Error {
 public:
  MoveError(const Error& why, std::size_t at) : Error(why), move(at) {}
  std::size_t move;
};

struct MovePlanOptions {
  /// The highest speed of the TCP on any path, m/s, for every move; 0: unlimited.
  double tcp_ceiling = 0;
  /// The fraction of the robot's joint velocity limits that applies, (0, 1].
  double joint_share = 1;
  /// Zones of the reduced profile count, not those of the full one.
  bool reduced = false;
  bool operator==(const MovePlanOptions&) const = default;
};

/// Plans a sequence of moves; each starts at the end of the previous one, the first at the joint state
/// `from`. Neighbours with a blend between them form one path. Moves of the same kind are joined by
/// paths::joint_lines and CartesianPathBuilder, others by a polynomial in joint space that is continuous to
/// the second derivative and stays within the radius at the TCP. Joint moves with `through` form one
/// paths::joint_spline. Each path is then timed within the limits of joints and TCP. Deterministic.
/// Throws MoveError with the codes of those parts, of joints_for() and of check_joints() (also for places
/// between the points of a spline); "workspace" if the TCP would leave the robot's workspace; "payload" if a
/// joint cannot hold the load.
MovePlan plan_moves(const RobotFacts& robot, std::span<const double> from, std::span<const Move> moves,
                    const MovePlanOptions& options = {});

}  // namespace polyarm::moves
