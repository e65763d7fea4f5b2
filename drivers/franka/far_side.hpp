#pragma once
/// A robot of Franka with its controller and its hand, simulated down to the bytes: for tests, and for users
/// without a robot.
#include <functional>
#include <string>

#include "drivers/franka/far_hand.hpp"
#include "drivers/wire/takes_orders.hpp"

namespace polyarm::franka {

struct FarSideOptions {
  MachineOptions machine;
  std::string address = "127.0.0.1";
  int port = kRobotPort, hand_port = kHandPort;    ///< 0: any
  Nanoseconds patience = 0;                        ///< longest wait of the clock for an answer, ns
  std::function<void(const std::string&)> report;  ///< what happens, for people; on its thread
};

/// Runs on a thread of its own. Any thread may call.
class FarSide : public wire::TakesOrders<FarSide> {
 public:
  /// Throws Error("no-port").
  explicit FarSide(FarSideOptions options);

  int port() const { return fci_.port(); }
  int hand_port() const { return hand_.port(); }

  /// One millisecond. Waits until the last state is answered, at most `patience` ns; false if no answer came.
  bool step(Nanoseconds patience = 0);
  /// States that went out, and the id of the newest one.
  std::pair<std::uint64_t, std::uint64_t> sent() {
    return locked([this] { return std::pair{fci_.states(), fci_.newest()}; });
  }
  std::uint64_t answers() {
    return locked([this] { return fci_.answers(); });
  }
  std::uint64_t requests() {
    return locked([this] { return fci_.requests(); });
  }
  std::uint32_t hand_state() {
    return locked([this] { return hand_.newest(); });
  }
  template <typename Use>
  auto with_fingers(Use use) {
    const auto lock = clock_.lock();
    return use(fingers_);
  }

 private:
  friend wire::TakesOrders<FarSide>;
  static constexpr const char* kOrderExample = "user_stop@3 release@again";
  static std::span<const wire::OrderKind> order_kinds();
  void serve();
  void order_by_hand(const wire::Order& order);
  void order_on_wires(const wire::Order& order);
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
