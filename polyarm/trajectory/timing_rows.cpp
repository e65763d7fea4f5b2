#include "polyarm/trajectory/timing_rows.hpp"

#include <cmath>

#include "polyarm/trajectory/timing_kernels.hpp"

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

void PathRows::look(std::span<const double> s) {
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

void Passings::clear() {
  for (auto* list : {&s, &speed, &acceleration, &jerk, &square, &cube}) list->clear();
}
void Passings::add(const PathMotion& m) {
  s.push_back(m.s), speed.push_back(m.speed), acceleration.push_back(m.acceleration);
  jerk.push_back(m.jerk), square.push_back(m.speed * m.speed), cube.push_back(m.speed * m.speed * m.speed);
}

namespace {

kernels::PathRow joint_row(const PathRows& rows, std::size_t j) {
  const MotionLimits& l = rows.limits(j);
  return {rows.places(),      rows.first(j),      rows.second(j),         rows.third(j),
          1 / l.max_velocity, 1 / l.min_velocity, 1 / l.max_acceleration, 1 / l.min_acceleration,
          1 / l.max_jerk,     double(j)};
}

void norm_uses(const PathRows& rows, const Passings& m, std::size_t n, Uses& out) {
  const NormLimit& l = rows.norm(n);
  const double limit[3] = {l.max_velocity, l.max_acceleration, l.max_jerk};
  for (std::size_t i = 0; i < m.size(); ++i) {
    double square[3] = {0, 0, 0};
    for (std::size_t c = rows.first_component(n); c < rows.first_component(n + 1); ++c) {
      const double x1 = rows.first(c)[i], x2 = rows.second(c)[i], x3 = rows.third(c)[i];
      const double one = x1 * m.speed[i], two = x1 * m.acceleration[i] + x2 * m.square[i];
      const double three = x1 * m.jerk[i] + 3 * x2 * m.speed[i] * m.acceleration[i] + x3 * m.cube[i];
      square[0] += one * one, square[1] += two * two, square[2] += three * three;
    }
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const double use = std::sqrt(square[kind]) / limit[kind];
      if (use > out.value[kind][i]) out.value[kind][i] = use, out.row[kind][i] = double(rows.joints() + n);
    }
  }
}

}  // namespace

void find_uses(const PathRows& rows, const Passings& m, Uses& out) {
  kernels::Use use;
  for (std::size_t kind = 0; kind < 3; ++kind) {
    out.value[kind].assign(m.size(), 0.0), out.row[kind].assign(m.size(), 0.0);
    use.value[kind] = out.value[kind].data(), use.row[kind] = out.row[kind].data();
  }
  const kernels::Passing passing{m.speed.data(), m.acceleration.data(), m.jerk.data(), m.square.data(),
                                 m.cube.data()};
  for (std::size_t j = 0; j < rows.joints(); ++j) kernels::best().use(joint_row(rows, j), passing, use);
  for (std::size_t n = 0; n + rows.joints() < rows.rows(); ++n) norm_uses(rows, m, n, out);
}

}  // namespace polyarm::trajectory
