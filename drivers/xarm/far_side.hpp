#pragma once
/// A controller of UFACTORY, simulated down to its bytes: for tests, and for users without a robot.
#include <functional>
#include <string>
#include <vector>

#include "drivers/wire/takes_orders.hpp"
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
class FarSide : public wire::TakesOrders<FarSide> {
 public:
  /// Throws Error("no-port").
  explicit FarSide(FarSideOptions options);

  FarPorts ports() const { return ux_.ports(); }

  /// One cycle. While servo commands come, it waits for the next one, at most `patience` ns or 20 ms.
  bool step(Nanoseconds patience = 0);
  /// Reports for motion that went out, and the number of the newest one.
  std::pair<std::uint64_t, std::uint64_t> sent() {
    return locked([this] { return std::pair{ux_.reports(), ux_.newest()}; });
  }
  std::uint64_t requests() {
    return locked([this] { return ux_.requests(); });
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
  FarFaults faults_;
  FarUx ux_;
  wire::FarClock clock_;
};

}  // namespace polyarm::xarm
