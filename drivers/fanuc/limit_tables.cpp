#include "drivers/fanuc/limit_tables.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::fanuc {

namespace {

constexpr double kSpeedMargin = 1.2;

double lerp(double a, double b, double t) noexcept {
  return a + t * (b - a);
}

/// The smallest value of a table between two places among its steps.
double smallest(const std::array<float, kLimitSteps>& table, double from, double to) noexcept {
  const auto value = [&](double place) {
    const auto low = static_cast<std::size_t>(place);
    const std::size_t high = std::min(low + 1, kLimitSteps - 1);
    return lerp(table[low], table[high], place - static_cast<double>(low));
  };
  double out = std::min(value(from), value(to));
  for (auto i = static_cast<std::size_t>(std::ceil(from)); static_cast<double>(i) <= to; ++i)
    out = std::min(out, static_cast<double>(table[i]));
  return out;
}

}  // namespace

void LimitTables::set(const LimitTable& table) noexcept {
  if (table.axis < 1 || table.axis > 6) return;
  const std::size_t axis = table.axis - 1, kind = static_cast<std::size_t>(table.kind);
  tables_[axis][kind] = table;
  missing_ &= ~(1u << (3 * axis + kind));
}

AxisLimits LimitTables::at(double speed, double load) const noexcept {
  AxisLimits out;
  load = std::clamp(load, 0.0, 1.0);
  for (std::size_t axis = 0; axis < 6; ++axis)
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const LimitTable& table = tables_[axis][kind];
      const double last = kLimitSteps - 1, scale = last / table.max_speed;
      const double from = std::clamp(speed / kSpeedMargin * scale, 0.0, last);
      const double to = std::clamp(speed * kSpeedMargin * scale, 0.0, last);
      out.of[kind][axis] = lerp(smallest(table.empty, from, to), smallest(table.loaded, from, to), load);
    }
  return out;
}

}  // namespace polyarm::fanuc
