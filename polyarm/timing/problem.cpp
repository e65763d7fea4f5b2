#include "polyarm/timing/problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/timing/grid.hpp"

namespace polyarm::timing {
namespace {

constexpr double kTighter = 1e-4;    // tightens more than the excess requires, so that one round removes it
constexpr double kMuchSlack = 0.97;  // use of a scale below which rows do not bind

/// Maps the points of a problem on a grid to the refined grid, which has one node more in each piece marked
/// in `halve`.
PointOrigins origins_of(const SpeedProblem& before, const SpeedProblem& now, const std::vector<char>& halve) {
  const std::size_t pieces = halve.size() - 1;
  std::vector<std::size_t> node, piece{0};  // for each node: the previous node, or beyond them the middle
  node.push_back(0);
  for (std::size_t k = 1; k <= pieces; ++k) {
    if (halve[k]) node.push_back(pieces + k), piece.push_back(k);
    node.push_back(k), piece.push_back(k);
  }
  PointOrigins out;
  const auto of = [&](const LimitRows& from, const LimitRows& to, std::vector<std::size_t>& list) {
    std::vector<std::size_t> first(2 * pieces + 1, PointOrigins::kNew);
    for (std::size_t i = from.node.size(); i-- > 0;) first[from.node[i]] = i;
    for (std::size_t k = 1; k <= pieces; ++k) first[pieces + k] = from.node.size() + k - 1;
    for (std::size_t i = 0; i < to.node.size(); ++i) {
      const std::size_t at = first[node[to.node[i]]];
      list.push_back(i > 0 && to.node[i] == to.node[i - 1] ? at + 1 : at);
    }
    for (std::size_t k = 1; k < piece.size(); ++k)
      list.push_back(halve[piece[k]] ? PointOrigins::kNew : first[pieces + piece[k]]);
  };
  of(before.velocity, now.velocity, out.velocity);
  of(before.acceleration, now.acceleration, out.acceleration);
  for (const std::size_t end : {std::size_t(0), pieces})
    for (std::size_t k = 1; k < piece.size(); ++k) out.jerk.push_back(end + piece[k] - 1);
  return out;
}

void carry_scales(const LimitRows& from, LimitRows& to, const std::vector<std::size_t>& origins) {
  for (std::size_t i = 0; to.rows > 0 && i < to.points; ++i)
    if (origins[i] != PointOrigins::kNew) to.scale[i] = from.scale[origins[i]];
}

}  // namespace

TimingProblem::TimingProblem(PathRows& rows, const std::vector<double>& s) : rows_(rows) {
  set_up(s);
}

void TimingProblem::set_up(const std::vector<double>& s) {
  count_ = s.size() - 1, speeds_ = {};
  std::vector<double> places;
  places.reserve(count_ * kPlaces);
  for (const double part : {0.0, 0.25, 0.5, 0.75, 1 - 1e-9})
    for (std::size_t k = 0; k < count_; ++k) places.push_back(s[k] + part * (s[k + 1] - s[k]));
  rows_.look(std::move(places));
  fill_velocity();
  fill_acceleration();
  fill_jerk();
}

PointOrigins TimingProblem::refine(const std::vector<double>& s, const std::vector<char>& halve) {
  const SpeedProblem before = std::move(speeds_);
  set_up(s);
  PointOrigins origins = origins_of(before, speeds_, halve);
  carry_scales(before.velocity, speeds_.velocity, origins.velocity);
  carry_scales(before.acceleration, speeds_.acceleration, origins.acceleration);
  carry_scales(before.norm_acceleration, speeds_.norm_acceleration, origins.acceleration);
  carry_scales(before.jerk, speeds_.jerk, origins.jerk);
  carry_scales(before.norm_jerk, speeds_.norm_jerk, origins.jerk);
  return origins;
}

void TimingProblem::look(const NodeMotion& m, const JerkPieces& pieces, std::vector<PieceUse>& out) {
  pass(m, pieces);
  for (auto& of : peaks_)
    for (Peaks& p : of)
      for (auto* list : {&p.most, &p.above, &p.rows, &p.row}) list->assign(count_, 0.0);
  for (auto& list : value_) list.resize(count_ * kPlaces);
  for (std::size_t j = 0; j < rows_.joints(); ++j) check_joint_in_detail(j);
  for (std::size_t n = 0; n + rows_.joints() < rows_.rows(); ++n) check_norm(n);
  out.assign(count_ + 1, {});
  for (std::size_t kind = 0; kind < 3; ++kind) {
    const Peaks &joints = peaks_[0][kind], &norms = peaks_[1][kind];
    for (std::size_t k = 1; k <= count_; ++k) {
      PieceUse& use = out[k];
      for (std::size_t norm = 0; norm < 2; ++norm) {
        use.most[norm][kind] = peaks_[norm][kind].most[k - 1];
        use.rows[norm][kind] = peaks_[norm][kind].rows[k - 1];
      }
      use.above[kind] = std::max(joints.above[k - 1], norms.above[k - 1]);
      use.row[kind] =
          std::size_t(norms.most[k - 1] > joints.most[k - 1] ? norms.row[k - 1] : joints.row[k - 1]);
    }
  }
}

/// Computes the path motion at the places of this motion.
void TimingProblem::pass(const NodeMotion& m, const JerkPieces& pieces) {
  Passing& p = passing_;
  for (auto* list : {&p.speed, &p.square, &p.cube, &p.acceleration, &p.product})
    list->resize(count_ * kPlaces);
  for (auto* list : {&p.jerk, &p.way, &p.end}) list->resize(count_);
  p.times.resize(3 * count_);
  for (std::size_t k = 0; k < count_; ++k) {
    p.jerk[k] = pieces.piece(k + 1).jerk, p.end[k] = pieces.piece(k + 1).time, p.way[k] = m.s[k + 1] - m.s[k];
    const std::size_t end = (kPlaces - 1) * count_ + k;
    p.speed[k] = pieces.speed(k), p.acceleration[k] = m.a[k];
    p.speed[end] = pieces.speed(k + 1), p.acceleration[end] = m.a[k + 1];
  }
  double* const times[3] = {&p.times[0], &p.times[count_], &p.times[2 * count_]};
  kernels::best().times(count_, p.speed.data(), p.acceleration.data(), p.jerk.data(), p.way.data(),
                        p.end.data(), times);
  for (std::size_t i = 1; i + 1 < kPlaces; ++i)
    for (std::size_t k = 0; k < count_; ++k) {
      const double t = times[i - 1][k], a = p.acceleration[k], j = p.jerk[k];
      p.speed[i * count_ + k] = p.speed[k] + t * (a + t * j / 2);
      p.acceleration[i * count_ + k] = a + t * j;
    }
  for (std::size_t i = 0; i < p.speed.size(); ++i) {
    const double v = p.speed[i];
    p.square[i] = v * v, p.cube[i] = v * v * v, p.product[i] = 3 * v * p.acceleration[i];
  }
}

/// Computes the values of one component of the rows, by kind.
void TimingProblem::values_of(std::size_t c) {
  kernels::Pieces m{.pieces = count_, .jerk = passing_.jerk.data()};
  kernels::PathRow row;
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const std::size_t at = i * count_;
    m.speed[i] = &passing_.speed[at], m.square[i] = &passing_.square[at], m.cube[i] = &passing_.cube[at];
    m.acceleration[i] = &passing_.acceleration[at], m.product[i] = &passing_.product[at];
    row.first[i] = rows_.first(c) + at, row.second[i] = rows_.second(c) + at,
    row.third[i] = rows_.third(c) + at;
  }
  kernels::best().values(m, row, value_[0].data(), value_[1].data(), value_[2].data());
}

void TimingProblem::peaks(std::size_t kind, const double* values, std::size_t row, double per_high,
                          double per_low) {
  Peaks& p = peaks_[row >= rows_.joints()][kind];
  kernels::best().peaks(count_, values, per_high, per_low, kind < 2, double(row),
                        {p.most.data(), p.above.data(), p.rows.data(), p.row.data()});
}

void TimingProblem::check_joint_in_detail(std::size_t j) {
  values_of(j);
  const trajectory::MotionLimits& l = rows_.limits(j);
  peaks(0, value_[0].data(), j, 1 / l.max_velocity, -1 / l.min_velocity);
  peaks(1, value_[1].data(), j, 1 / l.max_acceleration, -1 / l.min_acceleration);
  peaks(2, value_[2].data(), j, 1 / l.max_jerk, 1 / l.max_jerk);
}

void TimingProblem::check_norm(std::size_t n) {
  for (auto& list : norm_) list.assign(count_ * kPlaces, 0.0);
  for (std::size_t c = rows_.first_component(n); c < rows_.first_component(n + 1); ++c) {
    values_of(c);
    for (std::size_t kind = 0; kind < 3; ++kind)
      for (std::size_t i = 0; i < norm_[kind].size(); ++i)
        norm_[kind][i] += value_[kind][i] * value_[kind][i];
  }
  const NormLimit& norm = rows_.norm(n);
  const double limits[3] = {norm.max_velocity, norm.max_acceleration, norm.max_jerk};
  for (std::size_t kind = 0; kind < 3; ++kind) {
    for (double& x : norm_[kind]) x = std::sqrt(x);
    peaks(kind, norm_[kind].data(), rows_.joints() + n, 1 / limits[kind], 0);
  }
}

void TimingProblem::fill_velocity() {
  LimitRows& out = speeds_.velocity;
  out.resize(1, 2 * count_ + 1), out.low[0] = 0;
  for (std::size_t k = 0; k <= count_; ++k) {
    double ceiling = velocity_ceiling(rows_, k < count_ ? begin_of(k + 1) : end_of(k));
    if (k > 0) ceiling = std::min(ceiling, velocity_ceiling(rows_, end_of(k)));
    out.coefficient[0][k] = 1 / ceiling, out.node.push_back(k);
  }
  for (std::size_t k = 1; k <= count_; ++k)
    out.coefficient[0][count_ + k] = 1 / velocity_ceiling(rows_, middle_of(k));
}

void TimingProblem::fill_acceleration() {
  // Places after each node, and before it where rows jump.
  std::vector<std::size_t> nodes, places;
  for (std::size_t k = 1; k < count_; ++k) {
    nodes.push_back(k), places.push_back(begin_of(k + 1));
    if (jumps(end_of(k), begin_of(k + 1))) nodes.push_back(k), places.push_back(end_of(k));
  }
  for (std::size_t k = 1; k <= count_; ++k) places.push_back(middle_of(k));
  fill(speeds_.acceleration, speeds_.norm_acceleration, places, LimitKind::acceleration);
  speeds_.acceleration.node = speeds_.norm_acceleration.node = nodes;
  for (std::size_t j = 0; j < rows_.joints(); ++j) {
    const trajectory::MotionLimits& l = rows_.limits(j);
    if (std::isfinite(l.max_acceleration))
      speeds_.acceleration.low[j] = l.min_acceleration / l.max_acceleration;
  }
}

bool TimingProblem::jumps(std::size_t before, std::size_t behind) const {
  for (std::size_t c = rows_.joints(); c < rows_.components(); ++c)
    for (const double* list : {rows_.first(c), rows_.second(c)})
      if (std::abs(list[before] - list[behind]) > 1e-6 * (std::abs(list[before]) + std::abs(list[behind])))
        return true;
  return false;
}

void TimingProblem::fill_jerk() {
  std::vector<std::size_t> places;
  for (std::size_t k = 1; k <= count_; ++k) places.push_back(begin_of(k));
  for (std::size_t k = 1; k <= count_; ++k) places.push_back(end_of(k));
  fill(speeds_.jerk, speeds_.norm_jerk, places, LimitKind::jerk);
}

void TimingProblem::fill(LimitRows& plain, LimitRows& norm, const std::vector<std::size_t>& places,
                         LimitKind kind) {
  const bool jerk = kind == LimitKind::jerk;
  const std::size_t joints = rows_.joints(), n = places.size();
  plain.resize(joints, n), norm.resize(rows_.rows() - joints, n);
  for (auto& c : norm.component) c.resize((rows_.components() - joints) * n);
  std::size_t row = 0;
  for (std::size_t c = 0; c < rows_.components(); ++c) {
    const bool of_joint = c < joints;
    if (!of_joint && c == rows_.first_component(row)) norm.component_end.push_back(0);
    const double limit = of_joint ? jerk ? rows_.limits(c).max_jerk : rows_.limits(c).max_acceleration
                         : jerk   ? rows_.norm(row).max_jerk
                                  : rows_.norm(row).max_acceleration;
    auto& to = of_joint ? plain.coefficient : norm.component;
    const std::size_t from = (of_joint ? c : c - joints) * n;
    const double per = 1 / limit, *first = rows_.first(c), *second = rows_.second(c), *third = rows_.third(c);
    for (std::size_t i = 0; i < n; ++i) {
      to[0][from + i] = first[places[i]] * per;
      to[1][from + i] = (jerk ? 3 : 1) * second[places[i]] * per;
      if (jerk) to[2][from + i] = third[places[i]] * per;
    }
    if (!of_joint && c + 1 == rows_.first_component(row + 1))
      norm.component_end.back() = c + 1 - joints, ++row;
  }
}

/// How far the rows of a kind are below their scales in each piece, if the distance is large. There, a lower
/// scale changes nothing.
std::vector<double> TimingProblem::slacks(const LimitRows& rows, const std::vector<PieceUse>& use,
                                          std::size_t norm, std::size_t kind) const {
  const std::size_t pieces = use.size() - 1;
  std::vector<double> scale(pieces + 1, 0.0);
  const auto note = [&](std::size_t piece, double s) {
    if (piece >= 1 && piece <= pieces) scale[piece] = std::max(scale[piece], s);
  };
  for (std::size_t i = 0; rows.rows > 0 && i < rows.points; ++i) {
    const double s = kind == 0 ? std::sqrt(rows.scale[i]) : rows.scale[i];
    if (kind == 2) {
      note(i % pieces + 1, s);
    } else if (i < rows.node.size()) {
      note(rows.node[i], s), note(rows.node[i] + 1, s);
    } else {
      note(i - rows.node.size() + 1, s);
    }
  }
  std::vector<double> out(pieces + 1, 1.0);
  for (std::size_t k = 1; k <= pieces; ++k) {
    const double used = kind == 0 ? std::max(use[k].rows[0][0], use[k].rows[1][0]) : use[k].rows[norm][kind];
    if (scale[k] > 0) out[k] = std::clamp(used / (kMuchSlack * scale[k]), 0.5, 1.0);
  }
  return out;
}

void TimingProblem::tighten(const std::vector<PieceUse>& use) {
  const std::size_t pieces = use.size() - 1;
  const auto by_piece = [&](const LimitRows& rows, std::size_t norm, std::size_t kind) {
    const std::vector<double> slack = slacks(rows, use, norm, kind);
    std::vector<double> out(pieces + 1, 1.0);
    for (std::size_t k = 1; k <= pieces; ++k) {
      const double most = kind == 0 ? use[k].highest(0) : use[k].most[norm][kind];
      if (most > 1) out[k] = slack[k] / std::min(1 + 1.2 * (most - 1) + kTighter, 2.0);
      if (kind == 0) out[k] *= out[k];
    }
    return out;
  };
  LimitRows* const rows[] = {&speeds_.velocity, &speeds_.acceleration, &speeds_.norm_acceleration};
  for (std::size_t n = 0; n < 3; ++n) {
    LimitRows& l = *rows[n];
    const std::vector<double> by = by_piece(l, n == 2 ? 1 : 0, n > 0 ? 1 : 0);
    for (std::size_t i = 0; l.rows > 0 && i < l.points; ++i) {
      const std::size_t k = i < l.node.size() ? l.node[i] : i - l.node.size() + 1;
      const double factor = i < l.node.size() ? std::min(by[k], by[std::min(k + 1, pieces)]) : by[k];
      l.scale[i] = std::max(l.scale[i] * factor, 1e-3);
    }
  }
  for (std::size_t norm = 0; norm < 2; ++norm) {
    LimitRows& l = norm ? speeds_.norm_jerk : speeds_.jerk;
    const std::vector<double> by = by_piece(l, norm, 2);
    for (std::size_t i = 0; l.rows > 0 && i < l.points; ++i)
      l.scale[i] = std::max(l.scale[i] * by[i % pieces + 1], 1e-3);
  }
}

}  // namespace polyarm::timing
