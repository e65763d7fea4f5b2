#pragma once
/// A controller of FANUC, simulated down to its bytes: for tests, and for users without a robot.
#include <functional>
#include <string>
#include <vector>

#include "drivers/fanuc/far_services.hpp"
#include "drivers/wire/far_clock.hpp"
#include "drivers/wire/orders.hpp"

namespace polyarm::fanuc {

struct FarSideOptions {
  MachineOptions machine;
  std::string address = "127.0.0.1";
  int stream = 60015, rmi = 16001, session = 16002;  ///< ports; 0: any
  int sampling_ms = 8;
  std::uint32_t version = 3;  ///< of Stream Motion, 3 or 4
  Nanoseconds patience = 0;   ///< longest wait of the clock for the answer to a packet, ns
  std::function<void(const std::string&)> report;  ///< what happens, for people; on its thread
};

/// Runs on a thread of its own. Any thread may call.
class FarSide {
 public:
  /// Throws Error("no-port").
  explicit FarSide(FarSideOptions options);
  FarSide(const FarSide&) = delete;
  FarSide& operator=(const FarSide&) = delete;

  int stream_port() const { return stream_.port(); }
  int rmi_port() const { return rmi_.port(); }
  double period() const { return options_.sampling_ms / 1000.0; }

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
  /// The sequence of the newest packet that went out.
  std::uint32_t sent_sequence();
  /// Looks at the machine, or changes it, between two cycles.
  template <typename Use>
  auto with(Use use) {
    const auto lock = clock_.lock();
    return use(machine_);
  }
  std::uint64_t commands();
  bool program_runs();
  /// Instructions of the Remote Motion Interface that are done.
  std::uint64_t instructions_done();

 private:
  void serve();
  void cycle();
  void report(const std::string& text) const;
  void order_by_hand(const std::string& kind);
  void order_on_wires(const std::string& kind, int number);

  FarSideOptions options_;
  Machine machine_;
  FarFaults faults_;
  FarStream stream_;
  FarRmi rmi_;
  bool ran_ = false;
  wire::FarClock clock_;
};

}  // namespace polyarm::fanuc
