#pragma once
/// The program PolyarmMoves of a simulated controller: a session of moves, with PTP, LIN and CIRC and their
/// approximation. Degrees, millimetres, seconds. One thread.
#include "drivers/forward/path_player.hpp"
#include "drivers/kuka/machine.hpp"

namespace polyarm::kuka {

/// The override is the pace; it takes forward::PathPlayer::kPaceRamp from 0 to 1. An axis that exceeds its
/// speed or its software limit stops the program with a message. A program that a person stops keeps its
/// moves, and goes on with them at Start, unless its session has ended.
class FarMoves {
 public:
  explicit FarMoves(Machine& machine);

  EkiResult begin(int watchdog_ms);
  EkiResult take(const EkiRequest& request);
  EkiResult halt(int session, int number);
  EkiResult set_tool(int session, const EkiMove& tool);
  /// The session ends: the robot stops, and its moves are forgotten.
  EkiResult end();
  /// A request came, whatever it asks for.
  void hear() { silence_ = 0; }
  /// One cycle; the machine moves after it.
  void step(double dt);
  void fill(EkiState& state) const;
  /// A session is open, and does not end.
  bool is_open() const { return on_ && !ending_; }

  bool refuse = false;        ///< takes no moves
  bool confirms_not = false;  ///< never says that a halt is done

 private:
  bool of_session(int session) const { return is_open() && session == session_; }
  void stop();

  Machine& machine_;
  int session_ = 0, ended_ = 0, halted_ = 0, halting_ = 0;
  forward::PathPlayer player_;
  bool on_ = false, ending_ = false;
  double silence_ = 0, watchdog_ = 0, time_ = 4208;
};

}  // namespace polyarm::kuka
