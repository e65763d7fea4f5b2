#include "polyarm/trajectory/timing_problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/trajectory/timing_grid.hpp"

namespace polyarm::trajectory {
namespace {

constexpr double kTighter = 1e-4;  // than what an excess asks for, so that it is gone at once

/// From a problem on a grid to the one on the grid with a node more in each piece of `halve`.
PointOrigins origins_of(const SpeedProblem& before, const SpeedProblem& now, const std::vector<char>& halve) {
  const std::size_t pieces = halve.size() - 1;
  std::vector<std::size_t> node, piece{0};  // of each node: the node before, or beyond them the middle
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
  for (std::size_t k = 0; k < count_; ++k) {
    const double way = s[k + 1] - s[k];
    for (const double part : {0.0, 0.25, 0.5, 0.75, 1 - 1e-9}) places.push_back(s[k] + part * way);
  }
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
  motion_.resize(count_ * kPlaces);
  for (std::size_t k = 1; k <= count_; ++k) places_of(m, pieces, k, &motion_[(k - 1) * kPlaces]);
  ratios(rows_, motion_, ratios_);
  out.assign(count_ + 1, {});
  for (std::size_t k = 1; k <= count_; ++k) {
    const Ratios* r = &ratios_[(k - 1) * kPlaces];
    for (std::size_t i = 0; i < kPlaces; ++i)
      for (std::size_t kind = 0; kind < 3; ++kind) {
        double peak = r[i].value[kind];
        if (i > 0 && i + 1 < kPlaces) {
          const double before = r[i - 1].value[kind], behind = r[i + 1].value[kind];
          const double bend = 2 * peak - before - behind, slope = behind - before;
          if (bend > 0 && std::abs(slope) <= 2 * bend) peak += slope * slope / (8 * bend);
        }
        double& most = out[k].most[r[i].row[kind] >= rows_.joints()][kind];
        most = std::max(most, peak);
      }
  }
}

/// The motion at the places of piece `k`.
void TimingProblem::places_of(const NodeMotion& m, const JerkPieces& pieces, std::size_t k,
                              PathMotion* out) const {
  const double v = std::sqrt(m.b[k - 1]), a = m.a[k - 1], j = pieces.piece(k).jerk,
               end = pieces.piece(k).time;
  double low = 0;
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const double way = double(i) / (kPlaces - 1) * (m.s[k] - m.s[k - 1]);
    double t = i == 0 ? 0 : i + 1 == kPlaces ? end : low;
    if (i > 0 && i + 1 < kPlaces) {
      double high = end;
      t = low + (end - low) / double(kPlaces - i);
      for (int n = 0; n < 4; ++n) {
        const double over = t * (v + t * (a / 2 + t * j / 6)) - way, speed = v + t * (a + t * j / 2);
        (over > 0 ? high : low) = t;
        const double newton = speed > 0 ? t - over / speed : t;
        t = newton > low && newton < high ? newton : (low + high) / 2;
      }
      low = t;
    }
    out[i] = {m.s[k - 1] + way, v + t * (a + t * j / 2), a + t * j, j};
  }
  if (k == count_) out[kPlaces - 1].speed = std::sqrt(m.b[k]);
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
  // At each node behind it; where rows jump there, before it too.
  std::vector<std::size_t> nodes, places;
  for (std::size_t k = 1; k < count_; ++k) {
    nodes.push_back(k), places.push_back(begin_of(k + 1));
    if (jumps(end_of(k), begin_of(k + 1))) nodes.push_back(k), places.push_back(end_of(k));
  }
  for (std::size_t k = 1; k <= count_; ++k) places.push_back(middle_of(k));
  fill(speeds_.acceleration, speeds_.norm_acceleration, places, LimitKind::acceleration);
  speeds_.acceleration.node = speeds_.norm_acceleration.node = nodes;
  for (std::size_t j = 0; j < rows_.joints(); ++j) {
    const MotionLimits& l = rows_.limits(j);
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

void TimingProblem::tighten(const std::vector<PieceUse>& use) {
  const std::size_t pieces = use.size() - 1;
  const auto less = [](double most) {
    return most > 1 ? 1 / std::min(1 + 1.2 * (most - 1) + kTighter, 2.0) : 1;
  };
  std::vector<double> by_piece[3];  // velocity, acceleration of joints, of norms
  for (auto& list : by_piece) list.assign(pieces + 1, 1.0);
  for (std::size_t k = 1; k <= pieces; ++k) {
    const double speed = less(use[k].most[0][0]), norm = less(use[k].most[1][0]);
    by_piece[0][k] = std::min(speed * speed, norm * norm);
    by_piece[1][k] = less(use[k].most[0][1]), by_piece[2][k] = less(use[k].most[1][1]);
  }
  LimitRows* const rows[] = {&speeds_.velocity, &speeds_.acceleration, &speeds_.norm_acceleration};
  for (std::size_t kind = 0; kind < 3; ++kind) {
    LimitRows& l = *rows[kind];
    const std::vector<double>& by = by_piece[kind];
    for (std::size_t i = 0; l.rows > 0 && i < l.points; ++i) {
      const std::size_t k = i < l.node.size() ? l.node[i] : i - l.node.size() + 1;
      const double factor = i < l.node.size() ? std::min(by[k], by[std::min(k + 1, pieces)]) : by[k];
      l.scale[i] = std::max(l.scale[i] * factor, 1e-3);
    }
  }
  for (std::size_t norm = 0; norm < 2; ++norm) {
    LimitRows& l = norm ? speeds_.norm_jerk : speeds_.jerk;
    for (std::size_t i = 0; l.rows > 0 && i < l.points; ++i)
      l.scale[i] = std::max(l.scale[i] * less(use[i % pieces + 1].most[norm][2]), 1e-3);
  }
}

}  // namespace polyarm::trajectory
