#pragma once
/// The moves of the simulated controller: a queue as in the driver's program. rad, m, s. One thread.
#include "drivers/forward/path_player.hpp"
#include "drivers/ur/machine.hpp"
#include "drivers/ur/move_script.hpp"

namespace polyarm::ur {

inline constexpr double kStop = 4;  ///< rad/s², as in the driver's programs

/// The speed slider is the pace. A joint that exceeds its limit is a protective stop.
class FarMoves {
 public:
  explicit FarMoves(Machine& machine);
  /// A program begins.
  void begin();
  /// False: there is no room for the move.
  bool take(const MoveMessage& message);
  /// One step of the controller; the machine moves after it.
  void step(double dt);
  /// The program pauses: the move under way begins again from where the robot comes to rest.
  void interrupt() { player_.interrupt(); }
  /// The program ends: all moves are forgotten. The caller brakes the robot.
  void forget();

 private:
  Machine& machine_;
  forward::PathPlayer player_;
  int halting_ = 0;  ///< number of the halt that is under way; 0: none
};

}  // namespace polyarm::ur
