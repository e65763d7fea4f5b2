#include "polyarm/trajectory/timing_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::trajectory {

PathRows::PathRows(const Path& path, std::span<const MotionLimits> limits, std::span<const NormLimit> norms)
    : path_(path), limits_(limits), norms_(norms), components_(limits.size()) {
  for (const NormLimit& n : norms) {
    component_begin_.push_back(components_);
    components_ += n.path->joints();
  }
  component_begin_.push_back(components_);
  one_.resize(3 * components_);
}

void PathRows::look(std::vector<double> s) {
  s_ = std::move(s);
  const std::size_t n = s_.size();
  for (auto* v : {&first_, &second_, &third_}) v->resize(components_ * n);
  const std::span<double> all(one_);
  for (std::size_t i = 0; i < n; ++i) {
    const auto part = [&](std::size_t which, std::size_t from, std::size_t count) {
      return all.subspan(which * components_ + from, count);
    };
    const std::size_t joint_count = limits_.size();
    path_.at(s_[i], {{}, part(0, 0, joint_count), part(1, 0, joint_count), part(2, 0, joint_count)});
    for (std::size_t k = 0; k < norms_.size(); ++k) {
      const std::size_t from = component_begin_[k], count = component_begin_[k + 1] - from;
      norms_[k].path->at(s_[i], {{}, part(0, from, count), part(1, from, count), part(2, from, count)});
    }
    double sum = 0;
    for (std::size_t c = 0; c < components_; ++c) {
      first_[c * n + i] = one_[c];
      second_[c * n + i] = one_[components_ + c];
      third_[c * n + i] = one_[2 * components_ + c];
      sum += one_[c] + one_[components_ + c] + one_[2 * components_ + c];
    }
    if (!std::isfinite(sum))
      throw Error("bad-path", "a derivative of the path is not finite at s = " + std::to_string(s_[i]),
                  "the path must be smooth to the third derivative between its breaks");
  }
}

std::string PathRows::name(std::size_t row) const {
  return row < joints() ? "joint " + std::to_string(row + 1) : norms_[row - joints()].name;
}

namespace {

/// Takes the highest of `value` over `high` and of its negative over `low`.
void take(Ratios& r, std::size_t kind, std::size_t row, double ratio) {
  if (ratio > r.value[kind]) r.value[kind] = ratio, r.row[kind] = row;
}

void joint_ratios(const PathRows& rows, std::span<const PathMotion> motion, std::size_t j,
                  std::vector<Ratios>& out) {
  const MotionLimits& l = rows.limits(j);
  const double *first = rows.first(j), *second = rows.second(j), *third = rows.third(j);
  const double v_high = 1 / l.max_velocity, v_low = 1 / l.min_velocity, a_high = 1 / l.max_acceleration;
  const double a_low = 1 / l.min_acceleration, j_high = 1 / l.max_jerk;
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const PathMotion& m = motion[i];
    const double v = first[i] * m.speed, a = first[i] * m.acceleration + second[i] * m.speed * m.speed;
    const double jerk =
        first[i] * m.jerk + 3 * second[i] * m.speed * m.acceleration + third[i] * m.speed * m.speed * m.speed;
    take(out[i], 0, j, std::max(v * v_high, v * v_low));
    take(out[i], 1, j, std::max(a * a_high, a * a_low));
    take(out[i], 2, j, std::abs(jerk) * j_high);
  }
}

void norm_ratios(const PathRows& rows, std::span<const PathMotion> motion, std::size_t n,
                 std::vector<Ratios>& out) {
  const NormLimit& l = rows.norm(n);
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const PathMotion& m = motion[i];
    double v = 0, a = 0, jerk = 0;
    for (std::size_t c = rows.first_component(n); c < rows.first_component(n + 1); ++c) {
      const double x1 = rows.first(c)[i], x2 = rows.second(c)[i], x3 = rows.third(c)[i];
      const double one = x1 * m.speed, two = x1 * m.acceleration + x2 * m.speed * m.speed;
      const double three = x1 * m.jerk + 3 * x2 * m.speed * m.acceleration + x3 * m.speed * m.speed * m.speed;
      v += one * one, a += two * two, jerk += three * three;
    }
    const std::size_t row = rows.joints() + n;
    take(out[i], 0, row, std::sqrt(v) / l.max_velocity);
    take(out[i], 1, row, std::sqrt(a) / l.max_acceleration);
    take(out[i], 2, row, std::sqrt(jerk) / l.max_jerk);
  }
}

}  // namespace

void ratios(const PathRows& rows, std::span<const PathMotion> motion, std::vector<Ratios>& out) {
  out.assign(motion.size(), {});
  for (std::size_t j = 0; j < rows.joints(); ++j) joint_ratios(rows, motion, j, out);
  for (std::size_t n = 0; n + rows.joints() < rows.rows(); ++n) norm_ratios(rows, motion, n, out);
}

}  // namespace polyarm::trajectory
