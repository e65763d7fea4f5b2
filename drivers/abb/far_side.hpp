#pragma once
/// A controller of ABB, simulated down to its bytes: for tests, and for users without a robot.
#include <functional>
#include <string>
#include <vector>

#include "drivers/abb/far_moves.hpp"
#include "drivers/abb/far_services.hpp"
#include "drivers/wire/takes_orders.hpp"

namespace polyarm::abb {

struct FarSideOptions {
  MachineOptions machine;
  std::string address = "127.0.0.1";
  int rws_version = 2, rws = 8443;     ///< port; 0: any
  std::string egm_host = "127.0.0.1";  ///< of the computer that guides the robot
  int egm = 6510;                      ///< its port; 0: send_egm_to() says it later
  int moves = kMovesPort;              ///< port of the program PolyarmMoves; 0: any
  std::string user = "Default User", password = "robotics";
  Nanoseconds request_time = 0;  ///< see FarRws::set_request_time(); 0: its default
  Nanoseconds patience = 0;      ///< longest wait of the clock for the answer to a packet, ns
  std::function<void(const std::string&)> report;  ///< what happens, for people; on its thread
};

/// Runs on a thread of its own. Any thread may call.
class FarSide : public wire::TakesOrders<FarSide> {
 public:
  /// Throws Error("no-port"), Error("bad-value").
  explicit FarSide(FarSideOptions options);

  int rws_port() const { return rws_.port(); }
  int moves_port() const { return move_port_.port(); }
  void send_egm_to(const std::string& host, int port);
  double period() const { return options_.machine.rapid.sampling_ms / 1000.0; }

  /// One cycle. Waits until the last packet is answered, at most `patience` ns; false if no answer came.
  bool step(Nanoseconds patience = 0);
  /// Packets that went out, and the sequence of the newest one.
  std::pair<std::uint64_t, std::uint32_t> sent() {
    return locked([this] { return std::pair{egm_.packets(), egm_.sent_sequence()}; });
  }
  std::uint64_t messages() {
    return locked([this] { return egm_.messages(); });
  }
  /// A session of moves is open, and does not end.
  bool takes_moves() {
    return locked([this] { return move_port_.moves().is_open(); });
  }
  RapidLoad tool_load() {
    return locked([this] { return move_port_.moves().load(); });
  }
  std::uint64_t requests() {
    return locked([this] { return rws_.requests(); });
  }

 private:
  friend wire::TakesOrders<FarSide>;
  static constexpr const char* kOrderExample = "e_stop@3";
  static std::span<const wire::OrderKind> order_kinds();
  void serve();
  void cycle();
  void order_by_hand(const wire::Order& order);
  void order_on_wires(const wire::Order& order);

  FarSideOptions options_;
  Machine machine_;
  FarFaults faults_;
  FarEgm egm_;
  FarRws rws_;
  MoveFaults move_faults_;
  FarMovePort move_port_;
  wire::FarClock clock_;
};

}  // namespace polyarm::abb
