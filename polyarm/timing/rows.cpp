#include "polyarm/timing/rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::timing {

PathRows::PathRows(const paths::Path& path, std::span<const trajectory::MotionLimits> limits,
                   std::span<const NormLimit> norms)
    : path_(path), limits_(limits), norms_(norms), components_(limits.size()) {
  for (const NormLimit& n : norms) {
    component_begin_.push_back(components_);
    components_ += n.path->joints();
  }
  component_begin_.push_back(components_);
  one_.resize(3 * components_);
}

void PathRows::look(const std::vector<double>& s) {
  s_.assign(s.begin(), s.end());
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

constexpr std::size_t kBlock = 64;

/// Evaluates a few places at a time: the motion there, and for each kind the highest use and its row.
struct Block {
  std::size_t count = 0;
  double speed[kBlock], square[kBlock], cube[kBlock], acceleration[kBlock], product[kBlock], jerk[kBlock];
  double value[3][kBlock], row[3][kBlock];

  void begin(std::span<const PathMotion> motion) {
    count = motion.size();
    for (std::size_t i = 0; i < count; ++i) {
      const PathMotion& m = motion[i];
      speed[i] = m.speed, square[i] = m.speed * m.speed, cube[i] = square[i] * m.speed;
      acceleration[i] = m.acceleration, product[i] = 3 * m.speed * m.acceleration, jerk[i] = m.jerk;
      for (std::size_t kind = 0; kind < 3; ++kind) value[kind][i] = row[kind][i] = 0;
    }
  }
  void joint(const PathRows& rows, std::size_t j, std::size_t at) {
    const trajectory::MotionLimits& l = rows.limits(j);
    const double *first = rows.first(j) + at, *second = rows.second(j) + at, *third = rows.third(j) + at;
    const double v_high = 1 / l.max_velocity, v_low = 1 / l.min_velocity, a_high = 1 / l.max_acceleration;
    const double a_low = 1 / l.min_acceleration, j_high = 1 / l.max_jerk, j_low = -j_high;
    const double number = double(j);
    for (std::size_t i = 0; i < count; ++i) {
      const double v = first[i] * speed[i];
      take(0, i, number, v * v_high, v * v_low);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const double a = first[i] * acceleration[i] + second[i] * square[i];
      take(1, i, number, a * a_high, a * a_low);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const double x = first[i] * jerk[i] + second[i] * product[i] + third[i] * cube[i];
      take(2, i, number, x * j_high, x * j_low);
    }
  }
  void norm(const PathRows& rows, std::size_t n, std::size_t at) {
    const NormLimit& l = rows.norm(n);
    const double number = double(rows.joints() + n);
    for (std::size_t i = 0; i < count; ++i) {
      double v = 0, a = 0, x = 0;
      for (std::size_t c = rows.first_component(n); c < rows.first_component(n + 1); ++c) {
        const double x1 = rows.first(c)[at + i], x2 = rows.second(c)[at + i], x3 = rows.third(c)[at + i];
        const double one = x1 * speed[i], two = x1 * acceleration[i] + x2 * square[i];
        const double three = x1 * jerk[i] + x2 * product[i] + x3 * cube[i];
        v += one * one, a += two * two, x += three * three;
      }
      take(0, i, number, std::sqrt(v) / l.max_velocity, 0);
      take(1, i, number, std::sqrt(a) / l.max_acceleration, 0);
      take(2, i, number, std::sqrt(x) / l.max_jerk, 0);
    }
  }

 private:
  void take(std::size_t kind, std::size_t i, double number, double high, double low) {
    const double ratio = high > low ? high : low, before = value[kind][i];
    value[kind][i] = ratio > before ? ratio : before;
    row[kind][i] = ratio > before ? number : row[kind][i];
  }
};

}  // namespace

void ratios(const PathRows& rows, std::span<const PathMotion> motion, std::vector<Ratios>& out) {
  out.resize(motion.size());
  Block block;
  for (std::size_t at = 0; at < motion.size(); at += kBlock) {
    block.begin(motion.subspan(at, std::min(kBlock, motion.size() - at)));
    for (std::size_t j = 0; j < rows.joints(); ++j) block.joint(rows, j, at);
    for (std::size_t n = 0; n + rows.joints() < rows.rows(); ++n) block.norm(rows, n, at);
    for (std::size_t i = 0; i < block.count; ++i)
      for (std::size_t kind = 0; kind < 3; ++kind) {
        out[at + i].value[kind] = block.value[kind][i];
        out[at + i].row[kind] = std::size_t(block.row[kind][i]);
      }
  }
}

}  // namespace polyarm::timing
