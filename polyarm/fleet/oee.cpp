#include "polyarm/fleet/oee.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace polyarm::fleet {

namespace {

using Json = nlohmann::json;

double number_at(const Json& map, const char* key) {
  if (!map.is_object()) return 0;
  const auto found = map.find(key);
  if (found == map.end() || !found->is_number()) return 0;
  const double value = found->get<double>();
  return std::isfinite(value) && value > 0 ? value : 0;
}

double sum_of(const Json& map) {
  double out = 0;
  if (map.is_object())
    for (const auto& [key, value] : map.items()) out += number_at(map, key.c_str());
  return out;
}

}  // namespace

Oee oee_of(const Json& summary, double ideal_cycle_s) {
  Oee out;
  if (!summary.is_object()) return out;
  const double working = number_at(summary, "working_s"), passes = number_at(summary, "passes");
  const double there = sum_of(summary.value("state_s", Json::object())) + number_at(summary, "no_cell_s");
  if (there > 0) out.availability = std::min(1.0, working / there);
  if (ideal_cycle_s > 0 && working > 0) out.performance = std::min(1.0, ideal_cycle_s * passes / working);
  const Json parts = summary.value("parts", Json::object());
  const double good = number_at(parts, "good"), all = good + number_at(parts, "bad");
  if (all > 0) out.quality = good / all;
  if (out.availability && out.performance && out.quality)
    out.whole = *out.availability * *out.performance * *out.quality;
  return out;
}

}  // namespace polyarm::fleet
