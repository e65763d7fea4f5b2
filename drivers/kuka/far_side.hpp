#pragma once
/// A controller of KUKA, simulated down to its bytes: for tests, and for users without a robot.
#include <functional>
#include <string>
#include <vector>

#include "drivers/kuka/far_services.hpp"
#include "drivers/wire/far_clock.hpp"
#include "drivers/wire/orders.hpp"

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
class FarSide {
 public:
  /// Throws Error("no-port"), Error("bad-value").
  explicit FarSide(FarSideOptions options);
  FarSide(const FarSide&) = delete;
  FarSide& operator=(const FarSide&) = delete;

  int eki_port() const { return eki_.port(); }
  void send_rsi_to(const std::string& host, int port);

  /// Lets a fault happen, or an event that ends one: `KIND` or `KIND=NUMBER`. Throws Error("bad-value") with
  /// the kinds.
  void order(const std::string& fault);
  /// The kinds with their meaning, one a line.
  static std::string kinds();
  /// The parameter `faults` of a driver with a controller of its own. Throws Error("bad-value").
  static std::vector<wire::TimedOrder> timed_orders(const std::string& text);

  /// The controller's clock stands still; step() moves it.
  void hold_clock(bool on);
  /// One cycle. Waits until the last packet is answered, at most `patience` ns; false if no answer came.
  bool step(Nanoseconds patience = 0);
  /// Packets that went out, and the clock of the newest one.
  std::pair<std::uint64_t, std::uint64_t> sent();
  std::uint64_t packets() { return sent().first; }
  std::uint64_t answers();
  std::uint64_t requests();
  /// A session of moves is open.
  bool takes_moves();
  /// Looks at the machine, or changes it, between two cycles.
  template <typename Use>
  auto with(Use use) {
    const auto lock = clock_.lock();
    return use(machine_);
  }

 private:
  void serve();
  void report(const std::string& text) const;
  void order_by_hand(const std::string& kind);
  void order_on_wires(const std::string& kind, int number);
  void make_healthy();

  FarSideOptions options_;
  Machine machine_;
  FarMoves moves_;
  FarFaults faults_;
  FarRsi rsi_;
  FarEki eki_;
  bool ran_ = false;
  wire::FarClock clock_;
};

}  // namespace polyarm::kuka
