#include "polyarm/paths/joined_path.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace polyarm::paths {

void JoinedPath::append(std::shared_ptr<const Path> path, double from, double to, double scale) {
  assert(path->joints() == joints_ && to > from && scale > 0);
  const double begin = breaks_.back();
  if (parts_.empty()) breaks_.pop_back();
  const std::span<const double> inner = path->breaks();
  for (const double s : inner)
    if (s > from && s < to) breaks_.push_back(begin + (s - from) * scale);
  breaks_.push_back(begin + (to - from) * scale);
  parts_.push_back({std::move(path), begin, from, to, scale});
}

void JoinedPath::at(double s, const PathDerivatives& out) const noexcept {
  if (parts_.empty()) {
    for (const std::span<double> values : {out.q, out.first, out.second, out.third})
      std::fill(values.begin(), values.end(), 0.0);
    return;
  }
  s = std::clamp(s, 0.0, length());
  const auto after = std::upper_bound(parts_.begin() + 1, parts_.end(), s,
                                      [](double value, const Part& part) { return value < part.begin; });
  const Part& part = *(after - 1);
  part.path->at(std::min(part.from + (s - part.begin) / part.scale, part.to), out);
  if (part.scale == 1) return;
  double per = 1;
  for (const std::span<double> values : {out.first, out.second, out.third}) {
    per /= part.scale;
    for (double& value : values) value *= per;
  }
}

}  // namespace polyarm::paths
