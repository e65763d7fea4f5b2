#include "polyarm/motion/path_zones.hpp"

#include <algorithm>
#include <utility>

namespace polyarm::motion {

using trajectory::PathDerivatives;

WeightedPath::WeightedPath(std::shared_ptr<const trajectory::Path> path, std::vector<Zone> zones)
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
  const trajectory::PoseDerivatives at = path_->at(s);
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

}  // namespace polyarm::motion
