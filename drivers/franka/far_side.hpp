#pragma once
/// A robot of Franka with its controller and its hand, simulated down to the bytes: for tests, and for users
/// without a robot.
#include <functional>
#include <string>

#include "drivers/franka/far_hand.hpp"
#include "drivers/wire/far_clock.hpp"
#include "drivers/wire/orders.hpp"

namespace polyarm::franka {

struct FarSideOptions {
  MachineOptions machine;
  std::string address = "127.0.0.1";
  int port = kRobotPort, hand_port = kHandPort;    ///< 0: any
  Nanoseconds patience = 0;                        ///< longest wait of the clock for an answer, ns
  std::function<void(const std::string&)> report;  ///< what happens, for people; on its thread
};

/// Runs on a thread of its own. Any thread may call.
class FarSide {
 public:
  /// Throws Error("no-port").
  explicit FarSide(FarSideOptions options);
  FarSide(const FarSide&) = delete;
  FarSide& operator=(const FarSide&) = delete;

  int port() const { return fci_.port(); }
  int hand_port() const { return hand_.port(); }

  /// Lets a fault happen, or an event that ends one: `KIND` or `KIND=NUMBER`. Throws Error("bad-value") with
  /// the kinds.
  void order(const std::string& fault);
  /// The kinds with their meaning, one a line.
  static std::string kinds();
  /// The parameter `faults` of a driver with a robot of its own. Throws Error("bad-value").
  static std::vector<wire::TimedOrder> timed_orders(const std::string& text);

  /// The robot's clock stands still; step() moves it.
  void hold_clock(bool on) { clock_.hold(on); }
  /// One millisecond. Waits until the last state is answered, at most `patience` ns; false if no answer came.
  bool step(Nanoseconds patience = 0);
  /// States that went out, and the id of the newest one.
  std::pair<std::uint64_t, std::uint64_t> sent();
  std::uint64_t packets() { return sent().first; }
  std::uint64_t answers();
  std::uint64_t requests();
  std::uint32_t hand_state();
  /// Looks at the machine, or changes it, between two cycles.
  template <typename Use>
  auto with(Use use) {
    const auto lock = clock_.lock();
    return use(machine_);
  }
  template <typename Use>
  auto with_fingers(Use use) {
    const auto lock = clock_.lock();
    return use(fingers_);
  }

 private:
  void serve();
  void report(const std::string& text) const;
  void order_by_hand(const std::string& kind, int number);
  void order_on_wires(const std::string& kind, int number);
  void make_healthy();

  FarSideOptions options_;
  Machine machine_;
  Fingers fingers_;
  FarFaults faults_;
  FarFci fci_;
  FarHand hand_;
  RobotMode mode_ = RobotMode::idle;
  wire::FarClock clock_;
};

}  // namespace polyarm::franka
