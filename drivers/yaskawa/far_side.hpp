#pragma once
/// A controller of Yaskawa, simulated down to its bytes: for tests, and for users without a robot.
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "drivers/wire/far_clock.hpp"
#include "drivers/wire/orders.hpp"
#include "drivers/yaskawa/far_services.hpp"

namespace polyarm::yaskawa {

struct FarSideOptions {
  MachineOptions machine;
  std::string address = "127.0.0.1";
  int motion = kMotionPort, state = kStatePort, io = kIoPort, hses = kHsesPort;  ///< 0: any
  ByteOrder order = ByteOrder::little;                                           ///< of MotoROS
  int state_ms = 25;                               ///< between two states of MotoROS
  double watchdog = 0.6;  ///< s, of the ladder that hears the heartbeat of forward mode
  Pose tool;              ///< T_flange_tcp of the selected tool
  std::function<void(const std::string&)> report;  ///< what happens, for people; on its thread
};

/// Runs on a thread of its own. Any thread may call.
class FarSide {
 public:
  /// Throws Error("no-port").
  explicit FarSide(FarSideOptions options);
  FarSide(const FarSide&) = delete;
  FarSide& operator=(const FarSide&) = delete;

  int motion_port() const { return moto_.motion_port(); }
  int state_port() const { return moto_.state_port(); }
  int io_port() const { return moto_.io_port(); }
  int hses_port() const { return hses_.port(); }

  /// Lets a fault happen, or an event that ends one: `KIND` or `KIND=NUMBER`. Throws Error("bad-value") with
  /// the kinds.
  void order(const std::string& fault);
  /// The kinds with their meaning, one a line.
  static std::string kinds();
  /// The parameter `faults` of a driver with a controller of its own. Throws Error("bad-value").
  static std::vector<wire::TimedOrder> timed_orders(const std::string& text);

  /// The controller's clock stands still; step() moves it.
  void hold_clock(bool on) { clock_.hold(on); }
  /// One interpolation cycle; nothing is waited for.
  bool step(Nanoseconds patience = 0);
  /// While the driver begins or ends, each step waits for a request, at most its patience.
  void step_by_requests(bool on) { by_requests_ = on; }
  /// States that went out, and the number of the newest one.
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
  Variables variables_;
  FarJob job_;
  FarMoto moto_;
  FarHses hses_;
  bool ready_ = false;
  std::atomic<bool> by_requests_{false};
  std::uint64_t stepped_at_ = 0;  ///< requests
  wire::FarClock clock_;
};

}  // namespace polyarm::yaskawa
