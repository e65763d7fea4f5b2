#include "drivers/wire/signals.hpp"

#include <cmath>
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::wire {

SignalRange signal_range(const std::string& parameter, const std::string& text, int most, int least) {
  if (trim(text).empty()) return {};
  const std::size_t dash = text.find('-');
  const auto first = parse_number(text.substr(0, dash));
  const auto last = dash == std::string::npos ? first : parse_number(text.substr(dash + 1));
  const auto fits = [&](const std::optional<double>& n) {
    return n && *n >= least && *n <= most && *n == std::floor(*n);
  };
  if (!fits(first) || !fits(last) || *last < *first)
    throw Error(
        "bad-value", "`" + parameter + ": " + text + "` is no range of signals",
        "numbers from " + std::to_string(least) + " to " + std::to_string(most) + ", for example 1-8");
  return {static_cast<int>(*first), static_cast<int>(*last - *first) + 1};
}

std::pair<int, int> signal_wire(const std::string& text, int most, int least) {
  const std::size_t equals = text.find('=');
  const auto output = parse_number(text.substr(0, equals));
  const auto input = parse_number(equals == std::string::npos ? "" : text.substr(equals + 1));
  const auto fits = [&](const std::optional<double>& n) { return n && *n >= least && *n <= most; };
  if (!fits(output) || !fits(input))
    throw Error(
        "bad-value", "'" + text + "' in `wires` is not OUTPUT=INPUT",
        "numbers from " + std::to_string(least) + " to " + std::to_string(most) + ", for example 1=1");
  return {static_cast<int>(*output), static_cast<int>(*input)};
}

}  // namespace polyarm::wire
