#pragma once
/// What a person orders from a simulated robot controller: faults, and events that end them. Throws
/// Error("bad-value") for texts that are not understood.
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace polyarm::wire {

struct OrderKind {
  const char* name;
  const char* meaning;
};

/// The kinds with their meaning, one a line.
std::string order_list(std::span<const OrderKind> kinds);

struct Order {
  std::string kind;
  int number = -1;  ///< -1: not given
  bool is(std::string_view name) const { return kind == name; }
  int number_or(int otherwise) const { return number >= 0 ? number : otherwise; }
  struct Switch {
    const char* name;
    bool* on;
  };
  /// Switches on what has the name of this kind.
  void switch_on(std::initializer_list<Switch> switches) const;
  struct Count {
    const char* name;
    int* count;
    int otherwise;
  };
  /// Sets what has the name of this kind to the number, or to `otherwise`.
  void set_count(std::initializer_list<Count> counts) const;
};
/// `KIND` or `KIND=NUMBER`, with a number up to 10⁶.
Order parse_order(const std::string& text, std::span<const OrderKind> kinds);

struct TimedOrder {
  std::string order;   ///< empty once it was given
  double at = 0;       ///< s; unused if `again`
  bool again = false;  ///< given when the driver starts again after the orders before it
};
/// `KIND@SECONDS …`, the parameter `faults` of a simulated controller inside a driver. `KIND@again` ends a
/// fault: it is given when the driver starts again.
std::vector<TimedOrder> parse_timed_orders(const std::string& text, const std::string& example,
                                           std::span<const OrderKind> kinds);

}  // namespace polyarm::wire
