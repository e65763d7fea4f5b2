#pragma once
/// The data that the steps of planning exchange: geometry (MoveGeometry), joins (MoveJoins) and time
/// (MoveTiming). Private to this room; not for the control cycle.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/moves/move_plan.hpp"
#include "polyarm/moves/robot_facts.hpp"
#include "polyarm/paths/joint_path.hpp"
#include "polyarm/paths/path.hpp"

namespace polyarm::moves {

/// The range of a move on a part's own path.
struct MoveSpan {
  double from, to;
  std::size_t move;
};

/// A piece of a motion: a section of one path, with the TCP's way on it.
struct MovePart {
  std::shared_ptr<const paths::Path> joints, translation, rotation;
  double from = 0, to = 0, scale = 1;
  std::vector<MoveSpan> moves;
  bool joins = false;  ///< belongs to two moves along its whole length
  bool curve = false;  ///< a spline of joint moves
};

/// Moves with geometry from one builder.
struct MoveRun {
  bool cartesian = false;
  std::size_t first = 0, last = 0;
  std::vector<MovePart> sections;
};

/// Parts from rest to rest.
using MoveDraft = std::vector<MovePart>;

/// The input of every step of a plan.
struct PlanRequest {
  const RobotFacts& robot;
  std::span<const Move> moves;
  const MovePlanOptions& options;
  paths::TcpDistance distance;
};

inline bool is_cartesian(const Move& move) {
  return move.kind != MoveKind::joint;
}
inline bool goes_through(const Move& move) {
  return move.through && !is_cartesian(move);
}

/// The joints at a place on a path.
std::vector<double> joints_at(const paths::Path& path, double s);
double norm_of(std::span<const double> v);
/// True if joint moves have bounds at the TCP.
bool needs_tcp(const PlanRequest& request, std::size_t first, std::size_t last);
/// Adds the TCP's way to a part; null if nothing bounds it.
void give_tcp(const PlanRequest& request, MovePart& part, bool bounded);

}  // namespace polyarm::moves
