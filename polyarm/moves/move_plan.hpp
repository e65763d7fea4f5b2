#pragma once
/// From moves as people think of them to timed paths. Not for the control cycle (it allocates, throws and
/// takes milliseconds); any thread, as long as the robot's facts stay. Metres, radians, seconds; poses of the
/// TCP in the world.
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

/// joint: straight in joint space. line, arc and spline: the TCP's way.
enum class MoveKind { joint, line, arc, spline };

struct MoveTarget {
  std::variant<std::vector<double>, Pose> at;  ///< a joint state of the robot, or where the TCP goes
  std::string name;                            ///< as messages call it
};

struct Move {
  MoveKind kind = MoveKind::joint;
  /// Where it ends; of an arc the point on the way before it, of a spline all poses to pass through.
  std::vector<MoveTarget> targets;
  paths::ArcOrientation orientation = paths::ArcOrientation::interpolated;
  /// m at the TCP: how far from its end the path may leave this move and be on the next; 0: it comes to rest
  /// there. Of no meaning for the last.
  double blend = 0;
  /// The path goes exactly through the end and on to the next move without a stop. Joint moves alone; so many
  /// in a row, with the one after them, are one natural cubic spline in joint space. Of no meaning for the
  /// last.
  bool through = false;
  double speed = 1;               ///< share of the joints' velocity limits, or of the TCP's, (0, 1]
  double acceleration = 1;        ///< share likewise, of acceleration and jerk
  double tcp_speed = 0;           ///< m/s, at most; 0: what TcpLimits say (of a joint move: any)
  double tcp_acceleration = 0;    ///< m/s², likewise; the jerk goes with it
  double turn_speed = 0;          ///< rad/s of the TCP, likewise
  double turn_acceleration = 0;   ///< rad/s²
  double joint_speed = 0;         ///< rad/s (or m/s) of every joint, at most; 0: its limit
  double joint_acceleration = 0;  ///< rad/s² likewise; the jerk goes with it
  double duration = 0;            ///< s, at least
  double joint_pace = 0;  ///< s for each rad (or m) of the joint-space distance, at least; joint moves

  const MoveTarget& end() const { return targets.back(); }
};

/// One motion from rest to rest.
struct PlannedMotion {
  timing::TimedPath path;
  std::size_t first = 0, last = 0;          ///< of the moves; one that is split belongs to two motions
  std::vector<double> ends;                 ///< s at which moves end: of first, first + 1, …
  std::vector<timing::ActiveLimit> active;  ///< what bounds it where; rows beyond the joints: `bounds`
  std::vector<std::string> bounds;
  /// Accelerations of the joints are this share of their limits, so that no torque is beyond its limit: that
  /// of `torque_joint` would be.
  double torque_share = 1;
  std::size_t torque_joint = 0;
};

struct MovePlan {
  std::vector<PlannedMotion> motions;            ///< none where every move ends where it began
  std::vector<double> end;                       ///< joint state
  std::vector<trajectory::MotionLimits> limits;  ///< of the joints, that the paths keep
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
  /// No path is faster at the TCP than this, m/s, whatever the move says; 0: no such bound.
  double tcp_ceiling = 0;
  /// Joints' velocity limits are this share of the robot's, (0, 1].
  double joint_share = 1;
  bool operator==(const MovePlanOptions&) const = default;
};

/// Moves one after the other, each from where the one before ends, the first from the joint state `from`.
/// Neighbours with a blend between them are one path, whatever their kinds: between moves of the same kind by
/// paths::joint_lines and CartesianPathBuilder, else by a polynomial in joint space that is continuous
/// to the second derivative and stays within the radius at the TCP; joint moves through their ends are one
/// paths::joint_spline. Each path is then timed within the limits of joints and TCP. Deterministic.
/// Throws MoveError with the codes of those parts, of joints_for() and check_joints(), which holds between
/// the points of a spline too, "workspace" where the TCP would leave the robot's, and "payload" where a joint
/// cannot hold the load.
MovePlan plan_moves(const RobotFacts& robot, std::span<const double> from, std::span<const Move> moves,
                    const MovePlanOptions& options = {});

}  // namespace polyarm::moves
