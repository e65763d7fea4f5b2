#pragma once
/// A controller of FANUC, simulated down to its bytes: for tests, and for users without a robot.
#include <functional>
#include <string>
#include <vector>

#include "drivers/fanuc/far_services.hpp"
#include "drivers/wire/takes_orders.hpp"

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
class FarSide : public wire::TakesOrders<FarSide> {
 public:
  /// Throws Error("no-port").
  explicit FarSide(FarSideOptions options);

  int stream_port() const { return stream_.port(); }
  int rmi_port() const { return rmi_.port(); }
  double period() const { return options_.sampling_ms / 1000.0; }

  /// One cycle. Waits until the last packet is answered, at most `patience` ns; false if no answer came.
  bool step(Nanoseconds patience = 0);
  /// Packets of this session of Stream Motion that went out, and the sequence of the newest one.
  std::pair<std::uint64_t, std::uint64_t> sent() {
    return locked([this] {
      return std::pair<std::uint64_t, std::uint64_t>(stream_.sent_sequence(), stream_.sent_sequence());
    });
  }
  /// The sequence of the newest packet that went out.
  std::uint32_t sent_sequence() {
    return locked([this] { return stream_.sent_sequence(); });
  }
  std::uint64_t commands() {
    return locked([this] { return stream_.commands(); });
  }
  bool program_runs() {
    return locked([this] { return stream_.program_runs(); });
  }
  /// Instructions of the Remote Motion Interface that are done.
  std::uint64_t instructions_done() {
    return locked([this] { return rmi_.done(); });
  }

 private:
  friend wire::TakesOrders<FarSide>;
  static constexpr const char* kOrderExample = "e_stop@3 release@again reset@again";
  static std::span<const wire::OrderKind> order_kinds();
  void serve();
  void cycle();
  void order_by_hand(const wire::Order& order);
  void order_on_wires(const wire::Order& order);

  FarSideOptions options_;
  Machine machine_;
  FarFaults faults_;
  FarStream stream_;
  FarRmi rmi_;
  wire::FarClock clock_;
};

}  // namespace polyarm::fanuc
