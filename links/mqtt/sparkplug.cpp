#include "links/mqtt/sparkplug.hpp"

#include <bit>
#include <nlohmann/json.hpp>

#include "drivers/wire/proto.hpp"

namespace polyarm::mqtt {

namespace {

using wire::ProtoReader;
using wire::ProtoWriter;

// Numbers of fields in the specification's payload.
constexpr std::uint32_t kTime = 1, kMetrics = 2, kSeq = 3;
constexpr std::uint32_t kName = 1, kAlias = 2, kMetricTime = 3, kType = 4, kIsNull = 7, kInt = 10, kLong = 11,
                        kFloat = 12, kDouble = 13, kBoolean = 14, kString = 15;

ProtoWriter written(const Metric& metric) {
  ProtoWriter out;
  if (!metric.name.empty()) out.text(kName, metric.name);
  if (metric.alias) out.number(kAlias, *metric.alias);
  if (metric.time_ms) out.number(kMetricTime, *metric.time_ms);
  if (metric.type != 0) out.number(kType, metric.type);
  if (const bool* flag = std::get_if<bool>(&metric.value))
    out.number(kBoolean, *flag ? 1 : 0);
  else if (const double* number = std::get_if<double>(&metric.value))
    out.f64(kDouble, *number);
  else if (const std::uint64_t* whole = std::get_if<std::uint64_t>(&metric.value))
    out.number(kLong, *whole);
  else if (const std::string* text = std::get_if<std::string>(&metric.value))
    out.text(kString, *text);
  else
    out.number(kIsNull, 1);
  return out;
}

std::string text_of(wire::Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Whole numbers are sent as unsigned; the type says how to read them.
double signed_value(std::uint32_t type, std::uint64_t bits, bool is_long) {
  const bool has_sign = type >= 1 && type <= 4;
  if (!has_sign) return static_cast<double>(bits);
  return is_long ? static_cast<double>(static_cast<std::int64_t>(bits))
                 : static_cast<double>(static_cast<std::int32_t>(static_cast<std::uint32_t>(bits)));
}

/// Nothing if the bytes are no metric.
std::optional<Metric> read_metric(wire::Bytes bytes) {
  Metric out;
  std::optional<std::pair<std::uint64_t, bool>> whole;
  bool null = false;
  ProtoReader in(bytes);
  while (in.next()) switch (in.field()) {
      case kName:
        out.name = text_of(in.bytes());
        if (out.name.size() > kMostMetricName) return std::nullopt;
        break;
      case kAlias:
        out.alias = in.number();
        break;
      case kMetricTime:
        out.time_ms = in.number();
        break;
      case kType:
        out.type = static_cast<std::uint32_t>(in.number());
        break;
      case kIsNull:
        null = in.number() != 0;
        break;
      case kInt:
        whole = {in.number(), false};
        break;
      case kLong:
        whole = {in.number(), true};
        break;
      case kFloat:
        out.value = static_cast<double>(in.f32());
        break;
      case kDouble:
        out.value = in.f64();
        break;
      case kBoolean:
        out.value = in.number() != 0;
        break;
      case kString:
        out.value = text_of(in.bytes());
        if (std::get<std::string>(out.value).size() > kMostMetricText) return std::nullopt;
        break;
      default:
        break;
    }
  if (!in.ok()) return std::nullopt;
  if (whole) {
    const bool exact = out.type == static_cast<std::uint32_t>(MetricType::uint64);
    if (exact)
      out.value = whole->first;
    else
      out.value = signed_value(out.type, whole->first, whole->second);
  }
  if (null) out.value = std::monostate{};
  return out;
}

}  // namespace

std::string encoded(const SparkplugPayload& payload) {
  ProtoWriter out;
  out.number(kTime, payload.time_ms);
  for (const Metric& metric : payload.metrics) out.message(kMetrics, written(metric));
  if (payload.seq) out.number(kSeq, *payload.seq);
  return text_of(out.bytes());
}

std::optional<SparkplugPayload> decoded(std::string_view bytes) {
  SparkplugPayload out;
  ProtoReader in({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  while (in.next()) switch (in.field()) {
      case kTime:
        out.time_ms = in.number();
        break;
      case kSeq:
        out.seq = in.number();
        break;
      case kMetrics: {
        auto metric = read_metric(in.bytes());
        if (!in.ok() || !metric || out.metrics.size() >= kMostMetrics) return std::nullopt;
        out.metrics.push_back(std::move(*metric));
        break;
      }
      default:
        break;
    }
  if (!in.ok()) return std::nullopt;
  return out;
}

std::optional<HostState> host_state(std::string_view json) {
  if (json.size() > 1024) return std::nullopt;
  const auto parsed = nlohmann::json::parse(json, nullptr, false);
  if (!parsed.is_object() || !parsed.contains("online") || !parsed["online"].is_boolean())
    return std::nullopt;
  HostState out;
  out.online = parsed["online"].get<bool>();
  if (parsed.contains("timestamp") && parsed["timestamp"].is_number_unsigned())
    out.time_ms = parsed["timestamp"].get<std::uint64_t>();
  return out;
}

}  // namespace polyarm::mqtt
