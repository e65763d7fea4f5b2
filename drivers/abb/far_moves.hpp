#pragma once
/// The program PolyarmMoves of a simulated controller: its server, and a session of moves with MoveAbsJ,
/// MoveL, MoveC and their zones. One thread; nothing here waits.
#include <vector>

#include "drivers/abb/machine.hpp"
#include "drivers/abb/move_wire.hpp"
#include "drivers/forward/path_player.hpp"
#include "drivers/wire/far_packets.hpp"
#include "drivers/wire/service.hpp"

namespace polyarm::abb {

/// What goes wrong on purpose.
struct MoveFaults {
  bool mute = false;          ///< the program gives no answers
  bool nonsense = false;      ///< its answers are broken
  bool refuse = false;        ///< it takes no moves
  bool confirms_not = false;  ///< it never says that a halt is done
  bool other_version = false;
  bool other_base = false;  ///< its world frame is not the base of the robot
  bool fails = false;       ///< the next move cannot be made
  bool slow_stop = false;   ///< it answers nothing while the robot comes to rest
};

/// The session. The pace takes forward::PathPlayer::kPaceRamp from 0 to 1. A joint that exceeds its speed or
/// its range stops the program. A program that a person stops keeps its moves, and goes on with them at
/// Start, until its next look at the clock finds that the client was silent for too long.
class FarMoves {
 public:
  FarMoves(Machine& machine, const MoveFaults& faults);

  MoveReply carry_out(const MoveRequest& request);
  /// The client is gone: the robot stops.
  void leave();
  /// The program begins at its main: nothing is left.
  void restart();
  /// One cycle; the machine moves after it.
  void step(double dt);
  bool is_open() const { return session_ > 0 && !closing_; }
  /// The robot comes to rest.
  bool slows_down() const { return (stopping_ || pace_ == 0) && !machine_.still(); }
  const RapidLoad& load() const { return load_; }

 private:
  MoveResult result_of(const MoveRequest& request);
  MoveResult begin(int watchdog_ms);
  MoveResult take(const MoveRequest& request);
  void stop(bool closing);
  void finish();
  void fail();

  Machine& machine_;
  const MoveFaults& faults_;
  int sessions_ = 0, session_ = 0, ended_ = 0, halt_ = 0, halted_ = 0, error_ = 0, pace_ = 100;
  bool stopping_ = false, closing_ = false;
  double silence_ = 0, watchdog_ = 0, time_ = 0;
  RapidLoad load_;
  forward::PathPlayer player_;
};

/// Its port, which takes one client at a time: the program serves it while it runs.
class FarMovePort {
 public:
  FarMovePort(Machine& machine, const MoveFaults& faults)
      : machine_(machine), faults_(faults), moves_(machine, faults) {}
  /// Throws Error("no-port").
  void listen(const std::string& address, int port) { door_.listen(address, port); }
  int port() const { return door_.port(); }
  void descriptors(std::vector<int>& out);
  void serve();
  void step(double dt);
  void drop();
  const FarMoves& moves() const { return moves_; }
  std::uint64_t requests() const { return requests_; }

 private:
  struct Client {
    Descriptor socket;
    bool gone = false;
    std::vector<std::uint8_t> bytes;
  };
  bool take(Client& client);
  void follow_program();
  bool is_first(const Client& client);

  Machine& machine_;
  const MoveFaults& faults_;
  FarMoves moves_;
  wire::Service<Client> door_;
  std::uint64_t requests_ = 0, starts_ = 0;
};

}  // namespace polyarm::abb
