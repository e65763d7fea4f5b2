#pragma once
/// What is around a robot when its moves are planned. A cell implements it; this room knows no scene.
#include <functional>
#include <memory>
#include <span>

#include "polyarm/moves/move_plan.hpp"

namespace polyarm::moves {

/// Everything around a robot at one moment. Made on the cell thread, used once, on the thread that plans.
class Obstacles {
 public:
  virtual ~Obstacles() = default;
  /// Of a joint move with `around`: fills `over` and makes its target a joint state. Throws
  /// Error("start-in-contact" | "goal-in-contact" | "no-way" | "out-of-time" | "unreachable" | "limit").
  virtual void find_way(const RobotFacts& robot, std::span<const double> from, Move& move) = 0;
  /// Throws MoveError("contact") if a planned motion hits something.
  virtual void check(const RobotFacts& robot, const MovePlan& plan, std::span<const Move> moves) = 0;
};

/// Looks around now. Cell thread.
using LookAround = std::function<std::shared_ptr<Obstacles>()>;

/// Plans moves of which some have `around`: finds their ways, plans, and checks all of them. `obstacles` may be
/// null where no move has `around`. Errors as those of plan_moves() and Obstacles, as MoveError.
MovePlan plan_moves_around(const RobotFacts& robot, std::span<const double> from, std::vector<Move>& moves,
                           Obstacles* obstacles, const MovePlanOptions& options = {});

/// A joint move that goes around obstacles: it begins and ends at rest, and is planned alone.
inline bool bends(const Move& move) {
  return move.around && move.kind == MoveKind::joint;
}

}  // namespace polyarm::moves
