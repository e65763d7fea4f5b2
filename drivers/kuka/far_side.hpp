#pragma once
/// A controller of KUKA, simulated down to its bytes: for tests, and for users without a robot.
#include <functional>
#include <string>
#include <vector>

#include "drivers/kuka/far_services.hpp"
#include "drivers/wire/takes_orders.hpp"

namespace polyarm::kuka {

struct FarSideOptions {
  MachineOptions machine;
  std::string address = "127.0.0.1";
  int eki = 54600;                     ///< port of EthernetKRL; 0: any
  std::string rsi_host = "127.0.0.1";  ///< of the computer that answers
  int rsi = 59152;                     ///< its port; 0: send_rsi_to() says it later
  std::string sen_type = kSenType;     ///< SENTYPE of its configuration
  bool running = false;                ///< RSI runs from the beginning, as if a person had started it
  Nanoseconds patience = 0;            ///< longest wait of the clock for the answer to a packet, ns
  std::function<void(const std::string&)> report;  ///< what happens, for people; on its thread
};

/// Runs on a thread of its own. Any thread may call.
class FarSide : public wire::TakesOrders<FarSide> {
 public:
  /// Throws Error("no-port"), Error("bad-value").
  explicit FarSide(FarSideOptions options);

  int eki_port() const { return eki_.port(); }
  void send_rsi_to(const std::string& host, int port);

  /// One cycle. Waits until the last packet is answered, at most `patience` ns; false if no answer came.
  bool step(Nanoseconds patience = 0);
  /// Packets that went out, and the clock of the newest one.
  std::pair<std::uint64_t, std::uint64_t> sent() {
    return locked([this] { return std::pair{rsi_.packets(), rsi_.sent_clock()}; });
  }
  std::uint64_t answers() {
    return locked([this] { return rsi_.answers(); });
  }
  std::uint64_t requests() {
    return locked([this] { return eki_.requests(); });
  }
  /// A session of moves is open.
  bool takes_moves() {
    return locked([this] { return moves_.is_open(); });
  }

 private:
  friend wire::TakesOrders<FarSide>;
  static constexpr const char* kOrderExample = "e_stop@3";
  static std::span<const wire::OrderKind> order_kinds();
  void serve();
  void order_by_hand(const wire::Order& order);
  void order_on_wires(const wire::Order& order);
  void make_healthy();

  FarSideOptions options_;
  Machine machine_;
  FarMoves moves_;
  FarFaults faults_;
  FarRsi rsi_;
  FarEki eki_;
  wire::FarClock clock_;
};

}  // namespace polyarm::kuka
