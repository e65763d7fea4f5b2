#pragma once
/// Drives behind an adapter with SLCAN, on a pseudo-terminal: for tests, and for users without drives.
#include <functional>
#include <string>

#include "drivers/cia402/machine.hpp"
#include "drivers/wire/takes_orders.hpp"

namespace polyarm::cia402 {

struct FarSideOptions {
  MachineOptions machine;
  std::string link;  ///< a path that becomes a link to the pseudo-terminal; may be empty
  std::function<void(const std::string&)> report;  ///< what happens, for people; on its thread
};

/// Runs on a thread of its own. Any thread may call.
class FarSide : public wire::TakesOrders<FarSide> {
 public:
  /// Throws Error("fake-failed").
  explicit FarSide(FarSideOptions options);
  ~FarSide();

  /// The port of the adapter.
  const std::string& path() const { return path_; }
  /// One tick of the clocks of the drives.
  bool step(Nanoseconds patience = 0);
  std::pair<std::uint64_t, std::uint64_t> sent() {
    return locked([this] { return std::pair{sent_, sent_}; });
  }
  /// Frames that the master sent, in order; at most 4096, the oldest are dropped.
  std::vector<CanFrame> heard() {
    return locked([this] { return heard_; });
  }

 private:
  friend wire::TakesOrders<FarSide>;
  static constexpr const char* kOrderExample = "over_current=2@3 healthy@again";
  static std::span<const wire::OrderKind> order_kinds() { return Machine::order_kinds(); }
  void order_by_hand(const wire::Order& order);
  void order_on_wires(const wire::Order& order);
  void open_terminal();
  void make_link();
  void serve();
  void take_line();
  void take_frame();
  void tick();
  void send_all(const FarDrive::Frames& frames);
  void put(std::string text);
  void unplug();

  FarSideOptions options_;
  Machine machine_;
  FarDrive::Frames from_orders_;
  std::string path_, line_;
  int master_ = -1, slave_ = -1;
  bool channel_open_ = false, rate_set_ = false, bus_off_ = false, cut_ = false, other_master_ = false;
  int garbage_ = 0;
  std::uint64_t sent_ = 0;
  std::vector<CanFrame> heard_;
  wire::FarClock clock_;
};

}  // namespace polyarm::cia402
