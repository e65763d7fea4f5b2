#include "polyarm/moves/path_zones.hpp"

#include <algorithm>
#include <utility>

namespace polyarm::moves {

using paths::PathDerivatives;

WeightedPath::WeightedPath(std::shared_ptr<const paths::Path> path, std::vector<Zone> zones)
    : path_(std::move(path)), zones_(std::move(zones)) {}

double WeightedPath::weight(double s) const noexcept {
  const double near = 1e-9 * length();
  const auto first = std::lower_bound(zones_.begin(), zones_.end(), s - near,
                                      [](const Zone& zone, double value) { return zone.to < value; });
  double most = 0;
  for (auto zone = first; zone != zones_.end() && zone->from <= s + near; ++zone)
    most = std::max(most, zone->weight);
  return most;
}

void WeightedPath::at(double s, const PathDerivatives& out) const noexcept {
  path_->at(s, out);
  const double w = weight(std::clamp(s, 0.0, length()));
  for (const std::span<double> values : {out.first, out.second, out.third})
    for (double& value : values) value *= w;
}

void ParameterPath::at(double s, const PathDerivatives& out) const noexcept {
  if (!out.q.empty()) out.q[0] = std::clamp(s, 0.0, length());
  if (!out.first.empty()) out.first[0] = 1;
  for (const std::span<double> values : {out.second, out.third})
    if (!values.empty()) values[0] = 0;
}

void PosePath::at(double s, const PathDerivatives& out) const noexcept {
  const paths::PoseDerivatives at = path_->at(s);
  const auto& rates = part_ == TcpPart::translation ? at.linear : at.angular;
  const Vec3 place = part_ == TcpPart::translation ? at.pose.position : Vec3{};
  const auto put = [](std::span<double> values, const Vec3& v) {
    if (!values.empty()) values[0] = v.x, values[1] = v.y, values[2] = v.z;
  };
  put(out.q, place);
  put(out.first, rates[0]);
  put(out.second, rates[1]);
  put(out.third, rates[2]);
}

void ZoneLimits::add(double from, double to, double most_speed, double most_acceleration, double most_jerk) {
  speed.push_back({from, to, 1 / most_speed});
  acceleration.push_back({from, to, 1 / most_acceleration});
  jerk = std::min(jerk, most_jerk / most_acceleration);
}

namespace {
bool bounded(const std::vector<Zone>& zones) {
  return std::any_of(zones.begin(), zones.end(), [](const Zone& zone) { return zone.weight > 0; });
}
bool uniform(const std::vector<Zone>& zones) {
  return std::all_of(zones.begin(), zones.end(),
                     [&](const Zone& zone) { return zone.weight == zones.front().weight; });
}
}  // namespace

void ZoneNorms::add(const std::shared_ptr<const paths::Path>& path, const ZoneLimits& limits,
                    const std::string& name) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  if (limits.speed.empty()) return;
  if (uniform(limits.speed) && uniform(limits.acceleration)) {
    const double v = limits.speed.front().weight, a = limits.acceleration.front().weight;
    if (v > 0 || a > 0) put(path, 1 / v, 1 / a, a > 0 ? limits.jerk / a : kInfinite, name);
    return;
  }
  if (bounded(limits.speed))
    put(std::make_shared<WeightedPath>(path, limits.speed), 1, kInfinite, kInfinite, name);
  if (bounded(limits.acceleration))
    put(std::make_shared<WeightedPath>(path, limits.acceleration), kInfinite, 1, limits.jerk, name);
}

void ZoneNorms::put(std::shared_ptr<const paths::Path> path, double speed, double acceleration, double jerk,
                    const std::string& name) {
  norms_.push_back({path.get(), speed, acceleration, jerk, name});
  paths_.push_back(std::move(path));
}

}  // namespace polyarm::moves
