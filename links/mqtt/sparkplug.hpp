#pragma once
/// Payloads of Sparkplug B (version 3.0 of its specification): metrics as protocol buffers. Pure.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "polyarm/base/bounds.hpp"

namespace polyarm::mqtt {

inline constexpr std::size_t kMostMetrics = bounds::kSparkplugMetrics,
                             kMostMetricName = bounds::kSparkplugNameBytes,
                             kMostMetricText = bounds::kSparkplugTextBytes;

/// Data types of the specification that are used here; a received metric may have any.
enum class MetricType : std::uint32_t {
  int32 = 3,
  int64 = 4,
  uint64 = 8,
  real = 9,
  number = 10,
  boolean = 11,
  text = 12
};

struct Metric {
  std::string name;  ///< may be empty if there is an alias
  std::optional<std::uint64_t> alias;
  std::uint32_t type = 0;  ///< MetricType; 0: not sent
  std::optional<std::uint64_t> time_ms;
  /// monostate: null
  std::variant<std::monostate, bool, double, std::uint64_t, std::string> value;
};

struct SparkplugPayload {
  std::uint64_t time_ms = 0;
  std::optional<std::uint64_t> seq;
  std::vector<Metric> metrics;
};

std::string encoded(const SparkplugPayload& payload);
/// Nothing for bytes that are no payload, or exceed the limits above. Values of other types than Metric has
/// (data sets, templates, bytes) become null.
std::optional<SparkplugPayload> decoded(std::string_view bytes);

/// The value of a STATE message of a primary host: {"online": true, "timestamp": 123}. Nothing if it is
/// malformed.
struct HostState {
  bool online = false;
  std::uint64_t time_ms = 0;
};
std::optional<HostState> host_state(std::string_view json);

}  // namespace polyarm::mqtt
