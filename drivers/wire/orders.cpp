#include "drivers/wire/orders.hpp"

#include <algorithm>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::wire {

std::string order_list(std::span<const OrderKind> kinds) {
  std::string out;
  for (const OrderKind& kind : kinds) {
    std::string name = kind.name;
    name.resize(18, ' ');
    out += "  " + name + kind.meaning + "\n";
  }
  return out;
}

void Order::switch_on(std::initializer_list<Switch> switches) const {
  for (const Switch& one : switches)
    if (is(one.name)) *one.on = true;
}

void Order::set_count(std::initializer_list<Count> counts) const {
  for (const Count& one : counts)
    if (is(one.name)) *one.count = number_or(one.otherwise);
}

Order parse_order(const std::string& text, std::span<const OrderKind> kinds) {
  const std::size_t equals = text.find('=');
  Order out{std::string(trim(text.substr(0, equals)))};
  const bool has_number = equals != std::string::npos;
  const double number = has_number ? parse_number(text.substr(equals + 1)).value_or(-1) : 0;
  std::vector<std::string> names;
  for (const OrderKind& kind : kinds) names.emplace_back(kind.name);
  if (std::find(names.begin(), names.end(), out.kind) == names.end() || !(number >= 0 && number <= 1e6))
    throw Error("bad-value",
                "'" + text + "' is not a fault of this controller" + did_you_mean(out.kind, names),
                "KIND or KIND=NUMBER; the kinds are " + join(names, ", "));
  if (has_number) out.number = static_cast<int>(number);
  return out;
}

std::vector<TimedOrder> parse_timed_orders(const std::string& text, const std::string& example,
                                           std::span<const OrderKind> kinds) {
  std::vector<TimedOrder> out;
  for (const std::string& order : split_words(text, " ,;")) {
    const std::size_t at = order.find('@');
    const std::string when = at == std::string::npos ? std::string() : order.substr(at + 1);
    const auto time = parse_number(when);
    if (!time && when != "again")
      throw Error("bad-value", "'" + order + "' in `faults` is neither KIND@SECONDS nor KIND@again",
                  "for example " + example);
    parse_order(order.substr(0, at), kinds);
    out.push_back({order.substr(0, at), time.value_or(0), !time});
  }
  return out;
}

}  // namespace polyarm::wire
