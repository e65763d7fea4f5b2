#pragma once
/// What every simulated controller offers, whatever it speaks: faults that a person orders, a clock that can
/// be held, and its machine between two cycles.
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/wire/far_clock.hpp"
#include "drivers/wire/orders.hpp"

namespace polyarm::wire {

/// `Far` derives from TakesOrders<Far> and lets it in as a friend. It has `order_kinds()`, `kOrderExample`,
/// `order_by_hand(order)`, `order_on_wires(order)`, `options_.report`, `machine_`, and `clock_` as its last
/// member: the thread of the clock ends before what it uses. Any thread may call.
template <class Far>
class TakesOrders {
 public:
  TakesOrders(const TakesOrders&) = delete;
  TakesOrders& operator=(const TakesOrders&) = delete;

  /// Lets a fault happen, or an event that ends one: `KIND` or `KIND=NUMBER`. Throws Error("bad-value") with
  /// the kinds.
  void order(const std::string& text) {
    const Order order = parse_order(text, Far::order_kinds());
    const auto lock = self().clock_.lock();
    self().order_by_hand(order);
    self().order_on_wires(order);
    report("ordered: " + text);
  }
  /// The kinds with their meaning, one a line.
  static std::string kinds() { return order_list(Far::order_kinds()); }
  /// The parameter `faults` of a driver with a controller of its own. Throws Error("bad-value").
  static std::vector<TimedOrder> timed_orders(const std::string& text) {
    return parse_timed_orders(text, Far::kOrderExample, Far::order_kinds());
  }

  /// The controller's clock stands still; step() moves it.
  void hold_clock(bool on) { self().clock_.hold(on); }
  /// Waits until everything is taken that had come before.
  void settle() { self().clock_.settle(); }
  /// Packets that went out.
  std::uint64_t packets() { return self().sent().first; }
  /// Looks at the machine, or changes it, between two cycles.
  template <typename Use>
  auto with(Use use) {
    return locked([&] { return use(self().machine_); });
  }

 protected:
  TakesOrders() = default;
  ~TakesOrders() = default;
  template <typename Use>
  auto locked(Use use) {
    const auto lock = self().clock_.lock();
    return use();
  }
  void report(const std::string& text) {
    if (self().options_.report) self().options_.report(text);
  }
  /// Reports that something began or ended.
  void report_change(bool on, const char* began, const char* ended) {
    if (on == reported_) return;
    reported_ = on;
    report(on ? began : ended);
  }

 private:
  Far& self() { return static_cast<Far&>(*this); }
  bool reported_ = false;
};

}  // namespace polyarm::wire
