#include "polyarm/moves/obstacles.hpp"

#include <algorithm>

namespace polyarm::moves {

MovePlan plan_moves_around(const RobotFacts& robot, std::span<const double> from, std::vector<Move>& moves,
                           Obstacles* obstacles, const MovePlanOptions& options) {
  const bool around = std::any_of(moves.begin(), moves.end(), [](const Move& move) { return move.around; });
  if (!around || !obstacles) return plan_moves(robot, from, moves, options);
  if (moves.size() == 1 && bends(moves.front())) {
    try {
      obstacles->find_way(robot, from, moves.front());
    } catch (const Error& why) {
      throw MoveError(why, 0);
    }
  }
  MovePlan out = plan_moves(robot, from, moves, options);
  obstacles->check(robot, out, moves);
  return out;
}

}  // namespace polyarm::moves
