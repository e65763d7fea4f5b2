#pragma once
/// Moves that a robot's own controller interpolates (forward mode): what the runtime hands over, and what it
/// reads back. Metres, radians, seconds. Standard types only, because plugins include this file.
#include <array>
#include <cstddef>
#include <cstdint>

#include "polyarm/base/pose.hpp"
#include "polyarm/hardware/plugin.hpp"

namespace polyarm::hardware {

/// One move, from where the move before it ends. `joints` and `at` are the same place.
struct ForwardMove {
  static constexpr std::size_t kMostJoints = 8;
  enum class Kind : std::uint8_t { joint, line, arc };
  Kind kind = Kind::joint;
  bool stops = true;     ///< the robot comes to rest at the end; no move may follow before that
  std::uint64_t id = 0;  ///< counts up
  std::array<double, kMostJoints> joints{};  ///< the end, in the order of the robot's joints
  Pose at;                                   ///< T_world_tcp at the end
  Pose via;                                  ///< T_world_tcp on the way; of an arc
  double share = 1;         ///< the highest speed of a joint, as a share of its limit, (0, 1]
  double speed = 0;         ///< the highest speed of the TCP, m/s; 0: the TCP only turns
  double acceleration = 1;  ///< share of the controller's own, (0, 1]
  double duration = 0;      ///< s that the runtime planned for the move
  double blend = 0;         ///< m: the path may leave the move this far before its end; 0 if it stops
};
inline constexpr std::uint32_t kForwardLayout = layout_of<ForwardMove, Pose>();

/// What became of the moves.
struct ForwardFlow {
  std::uint64_t done = 0;  ///< id of the newest move that has ended
  bool idle = true;        ///< nothing is left to do: moves, or clear()
  bool standing = true;    ///< the robot is at rest, and moves no more before the next call
};

/// A controller that takes moves. Control thread; nothing blocks, allocates or throws.
class ForwardMoves {
 public:
  /// Adds a move behind the others. False: there is no room now, or clear() is not done; try again.
  virtual bool accept(const ForwardMove& move) noexcept = 0;
  /// Speed of all motion as a share of what the moves ask for, [0, 1]. 0: the robot comes to rest on its
  /// path, and goes on when the share rises. Call it in each cycle: a controller that is called no more
  /// stops.
  virtual void set_pace(double share) noexcept = 0;
  /// The robot comes to rest, and all moves are forgotten.
  virtual void clear() noexcept = 0;
  virtual ForwardFlow flow() const noexcept = 0;

 protected:
  ~ForwardMoves() = default;
};

/// A component that may take moves also derives from this class. Decision 0030.
class TakesMoves {
 public:
  virtual ~TakesMoves() = default;
  /// Null: it takes joint commands only, or was built with another `layout`. Valid from on_init() until the
  /// component is replaced. While it returns an object, the component ignores the joints' commands.
  virtual ForwardMoves* forward_moves(std::uint32_t layout) noexcept = 0;
};

}  // namespace polyarm::hardware
