#pragma once
/// A controller of UFACTORY, simulated down to its bytes: for tests, and for users without a robot.
#include <functional>
#include <string>
#include <vector>

#include "drivers/wire/far_clock.hpp"
#include "drivers/wire/orders.hpp"
#include "drivers/xarm/far_ux.hpp"

namespace polyarm::xarm {

struct FarSideOptions {
  MachineOptions machine;
  std::string address = "127.0.0.1";
  FarPorts ports;
  int real_ms = 10;                                ///< between two reports for motion
  int slow_ms = 200;                               ///< between two reports for people
  std::function<void(const std::string&)> report;  ///< what happens, for people; on its thread
};

/// Runs on a thread of its own. Any thread may call.
class FarSide {
 public:
  /// Throws Error("no-port").
  explicit FarSide(FarSideOptions options);
  FarSide(const FarSide&) = delete;
  FarSide& operator=(const FarSide&) = delete;

  FarPorts ports() const { return ux_.ports(); }

  /// Lets a fault happen, or an event that ends one: `KIND` or `KIND=NUMBER`. Throws Error("bad-value") with
  /// the kinds.
  void order(const std::string& fault);
  /// The kinds with their meaning, one a line.
  static std::string kinds();
  /// The parameter `faults` of a driver with a controller of its own. Throws Error("bad-value").
  static std::vector<wire::TimedOrder> timed_orders(const std::string& text);

  /// The controller's clock stands still; step() moves it.
  void hold_clock(bool on) { clock_.hold(on); }
  /// One cycle. While servo commands come, it waits for the next one, at most `patience` ns or 20 ms.
  bool step(Nanoseconds patience = 0);
  /// Reports for motion that went out, and the number of the newest one.
  std::pair<std::uint64_t, std::uint64_t> sent();
  std::uint64_t packets() { return sent().first; }
  std::uint64_t requests();
  /// Looks at the machine, or changes it, between two cycles.
  template <typename Use>
  auto with(Use use) {
    const auto lock = clock_.lock();
    return use(machine_);
  }

 private:
  void serve();
  void report(const std::string& text) const;
  void order_by_hand(const std::string& kind, int number);
  void order_on_wires(const std::string& kind, int number);
  void make_healthy();

  FarSideOptions options_;
  Machine machine_;
  FarFaults faults_;
  FarUx ux_;
  bool ready_ = false;
  wire::FarClock clock_;
};

}  // namespace polyarm::xarm
