#include "polyarm/timing/solver_rows.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace polyarm::timing {
namespace {

// Velocity rows keep this fraction of the products of other rows, so that a stated speed is met closely.
constexpr double kVelocityShare = 0.3;
constexpr double kSlackOfExcess = 0.3;  // initial slack of a row that exceeds its limit
constexpr std::size_t kLists = 9;       // lists of a symmetric 3 × 3 matrix and a right side, or of a
                                        // gradient

template <typename T>
std::array<T*, kLists> lists(std::vector<std::remove_const_t<T>>& all, std::size_t length) {
  std::array<T*, kLists> out{};
  for (std::size_t i = 0; i < kLists; ++i) out[i] = all.data() + i * length;
  return out;
}

}  // namespace

Moves moves_at(const JerkPieces& p, std::size_t k) {
  const ByNodes &before = k > 1 ? p.direction(k - 2) : p.direction(0), &own = p.direction(k - 1),
                &behind = p.direction(k);
  return {{{before[2], own[0], 0}, {before[3], own[1], 0}, {0, own[2], behind[0]}, {0, own[3], behind[1]}}};
}

void FiveDiagonals::clear() {
  for (auto* v : {&d0_, &d1_, &d2_, &right_}) std::fill(v->begin(), v->end(), 0.0);
}

void FiveDiagonals::add(std::size_t at, const std::array<double, 6>& m, const Basis& right) {
  d0_[at] += m[0], d1_[at] += m[1], d2_[at] += m[2];
  d0_[at + 1] += m[3], d1_[at + 1] += m[4], d0_[at + 2] += m[5];
  for (std::size_t i = 0; i < 3; ++i) right_[at + i] += right[i];
}

void FiveDiagonals::add(std::size_t at, std::size_t count, const std::array<const double*, 9>& m) {
  const auto sum = [count](double* to, const double* from) {
    for (std::size_t i = 0; i < count; ++i) to[i] += from[i];
  };
  sum(&d0_[at], m[0]), sum(&d0_[at + 1], m[3]), sum(&d0_[at + 2], m[5]);
  sum(&d1_[at], m[1]), sum(&d1_[at + 1], m[4]), sum(&d2_[at], m[2]);
  for (std::size_t i = 0; i < 3; ++i) sum(&right_[at + i], m[6 + i]);
}

void FiveDiagonals::solve(std::size_t last, std::vector<double>& x) {
  d1_[last] = d2_[last] = d2_[last - 1] = 0;
  for (std::size_t i = 2; i <= last; ++i) {
    const double per = 1 / (d0_[i] * (1 + 1e-13)), l1 = d1_[i] * per, l2 = d2_[i] * per;
    d0_[i + 1] -= l1 * d1_[i], d1_[i + 1] -= l1 * d2_[i], right_[i + 1] -= l1 * right_[i];
    d0_[i + 2] -= l2 * d2_[i], right_[i + 2] -= l2 * right_[i];
    d1_[i] = l1, d2_[i] = l2, right_[i] *= per;
  }
  std::fill(x.begin(), x.end(), 0.0);
  for (std::size_t i = last; i >= 2; --i) x[i] = right_[i] - d1_[i] * x[i + 1] - d2_[i] * x[i + 2];
}

SolverRows::SolverRows(const LimitRows& limits, RowKind kind)
    : limits_(limits), kind_(kind), points_(limits.points) {
  if (kind == RowKind::velocity) weight_ = kVelocityShare;
  if (empty()) return;
  const std::size_t n = limits_.points, all = limits_.rows * n;
  value_.resize(all);
  for (Side* side : {&high_, &low_}) side->slack.resize(all), side->multiplier.resize(all);
  for (std::size_t i = 0; i < 3; ++i)
    coefficient_[i].assign(limits_.coefficient[i].begin(), limits_.coefficient[i].end());
  m_.resize(kLists * n), basis_.resize(3 * n), turn_.resize(3 * n);
  gradient_.resize(kLists * n), projected_.resize(kLists * n);
  std::vector<std::size_t> at(n);
  for (std::size_t i = 0; i < n; ++i)
    at[i] = kind == RowKind::jerk     ? i % (n / 2)
            : i < limits_.node.size() ? limits_.node[i]
                                      : i - limits_.node.size();
  find_runs(at);
}

void SolverRows::find_runs(const std::vector<std::size_t>& at) {
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (i > 0 && at[i] == at[i - 1] + 1)
      ++runs_.back().count;
    else
      runs_.push_back({i, 1, at[i]});
  }
}

kernels::Row SolverRows::row(std::size_t r) const {
  const std::size_t begin = r * limits_.points;
  return {limits_.points,     &coefficient_[0][begin], &coefficient_[1][begin], &coefficient_[2][begin],
          scale_.data(),      &value_[begin],          &high_.slack[begin],     &high_.multiplier[begin],
          &low_.slack[begin], &low_.multiplier[begin], Real(limits_.low[r])};
}

/// The bases s⃛, ṡ·s̈ and ṡ³ at both ends of each piece.
void SolverRows::jerk_bases(const NodeMotion& m, const JerkPieces& p) {
  const std::size_t pieces = p.count();
  for (std::size_t k = 1; k <= pieces; ++k) {
    const Moves moves = moves_at(p, k);
    const JerkPiece& piece = p.piece(k);
    const auto& by = piece.jerk_by;
    const double change[3] = {
        by[0] * moves[0][0] + by[1] * moves[1][0],
        by[0] * moves[0][1] + by[1] * moves[1][1] + by[2] * moves[2][1] + by[3] * moves[3][1],
        by[2] * moves[2][2] + by[3] * moves[3][2]};
    for (const std::size_t end : {0, 1}) {
      const std::size_t node = k - 1 + end, i = end * pieces + k - 1;
      const double v = p.speed(node), a = m.a[node], bend = a * p.speed_by(node);
      basis(0)[i] = Real(piece.jerk), basis(1)[i] = Real(v * a), basis(2)[i] = Real(v * m.b[node]);
      for (std::size_t n = 0; n < 3; ++n) {
        const double db = moves[2 * end][n], da = moves[2 * end + 1][n];
        gradient(0, n)[i] = change[n], gradient(1, n)[i] = v * da + bend * db,
                    gradient(2, n)[i] = 1.5 * v * db;
      }
    }
  }
}

/// The basis b at nodes; for acceleration rows, s̈ comes before it.
void SolverRows::node_bases(const NodeMotion& m, const JerkPieces& p) {
  const std::size_t of_b = kind_ == RowKind::acceleration ? 1 : 0;
  for (std::size_t i = 0; i < limits_.node.size(); ++i) {
    const std::size_t node = limits_.node[i];
    const ByNodes &before = node > 0 ? p.direction(node - 1) : p.direction(0), &behind = p.direction(node);
    basis(of_b)[i] = Real(m.b[node]), gradient(of_b, 0)[i] = before[2], gradient(of_b, 1)[i] = behind[0];
    if (of_b == 0) continue;
    basis(0)[i] = Real(m.a[node]), gradient(0, 0)[i] = before[3], gradient(0, 1)[i] = behind[1];
  }
}

/// The same at the middle of a piece's way, from the cubic b(s) through both ends.
void SolverRows::middle_bases(const NodeMotion& m, const JerkPieces& p) {
  const std::size_t nodes = limits_.node.size(), of_b = kind_ == RowKind::acceleration ? 1 : 0;
  for (std::size_t k = 1; k <= limits_.points - nodes; ++k) {
    const Moves moves = moves_at(p, k);
    const std::size_t i = nodes + k - 1;
    const double way = m.s[k] - m.s[k - 1], per = 0.75 / way, share = way / 4;
    basis(of_b)[i] = Real((m.b[k] + m.b[k - 1]) / 2 + share * (m.a[k - 1] - m.a[k]));
    for (std::size_t n = 0; n < 3; ++n)
      gradient(of_b, n)[i] = (moves[0][n] + moves[2][n]) / 2 + share * (moves[1][n] - moves[3][n]);
    if (of_b == 0) continue;
    basis(0)[i] = Real(per * (m.b[k] - m.b[k - 1]) - (m.a[k] + m.a[k - 1]) / 4);
    for (std::size_t n = 0; n < 3; ++n)
      gradient(0, n)[i] = per * (moves[2][n] - moves[0][n]) - (moves[1][n] + moves[3][n]) / 4;
  }
}

void SolverRows::evaluate(const NodeMotion& m, const JerkPieces& p) {
  if (empty()) return;
  if (kind_ == RowKind::jerk)
    jerk_bases(m, p);
  else
    node_bases(m, p), middle_bases(m, p);
  aim_norms();
  for_rows(
      [&](std::size_t r, std::size_t) { kernels::best().evaluate(row(r), basis(0), basis(1), basis(2)); });
}

void SolverRows::begin(double complementarity, double least, bool again) {
  scale_.assign(limits_.scale.begin(), limits_.scale.end());
  for_rows([&](std::size_t r, std::size_t begin) {
    const Real width = Real(least * weight_ * (1 - limits_.low[r])), low = Real(limits_.low[r]);
    const Real product = Real(complementarity * weight_), of_excess = Real(kSlackOfExcess);
    for (std::size_t k = 0; k < limits_.points; ++k) {
      const std::size_t i = begin + k;
      const Real floor = width * scale_[k], up = scale_[k] - value_[i], down = value_[i] - scale_[k] * low;
      high_.slack[i] = std::max(up, up > 0 ? floor : floor - of_excess * up);
      low_.slack[i] = std::max(down, down > 0 ? floor : floor - of_excess * down);
      for (Side* side : {&high_, &low_}) {
        const Real fresh = product / side->slack[i];
        side->multiplier[i] = again ? std::max(side->multiplier[i], fresh) : fresh;
      }
    }
  });
}

void SolverRows::inherit(const SolverRows& before, const std::vector<std::size_t>& origins) {
  const std::size_t points = before.points_;
  for_rows([&](std::size_t r, std::size_t begin) {
    for (std::size_t i = 0; i < limits_.points; ++i) {
      if (origins[i] == PointOrigins::kNew) continue;
      const std::size_t from = r * points + origins[i];
      high_.multiplier[begin + i] = before.high_.multiplier[from];
      low_.multiplier[begin + i] = before.low_.multiplier[from];
    }
  });
}

void SolverRows::measure(double& complementarity, double& residual) const {
  Real sums[16] = {}, most = 0;
  for_rows([&](std::size_t r, std::size_t) { kernels::best().measure(row(r), sums, most); });
  for (const Real x : sums) complementarity += x;
  residual = std::max(residual, double(most));
}

void SolverRows::assemble(double complementarity, FiveDiagonals& system) {
  if (empty()) return;
  const std::size_t n = limits_.points;
  std::fill(m_.begin(), m_.end(), Real(0));
  const auto sums = lists<Real>(m_, n);
  for_rows([&](std::size_t r, std::size_t) {
    kernels::best().assemble(row(r), Real(complementarity * weight_), sums.data());
  });
  bend_norms();
  kernels::best().project(n, lists<const Real>(m_, n).data(), lists<const double>(gradient_, n).data(),
                          lists<double>(projected_, n).data());
  for (const Run& run : runs_) {
    std::array<const double*, kLists> from = lists<const double>(projected_, n);
    for (const double*& list : from) list += run.begin;
    system.add(run.at, run.count, from);
  }
}

void SolverRows::direction(double complementarity, const std::vector<double>& db, Steps& steps) {
  if (empty()) return;
  const std::size_t n = limits_.points;
  double* const x[3] = {&projected_[0], &projected_[n], &projected_[2 * n]};
  for (const Run& run : runs_)
    for (std::size_t i = 0; i < 3; ++i) std::copy_n(&db[run.at + i], run.count, x[i] + run.begin);
  Real* const d[3] = {&turn_[0], &turn_[n], &turn_[2 * n]};
  kernels::best().turn(n, lists<const double>(gradient_, n).data(), x, d);
  for_rows([&](std::size_t r, std::size_t) {
    kernels::best().decrease(row(r), Real(complementarity * weight_), d[0], d[1], d[2], steps);
  });
}

void SolverRows::go(double complementarity, double primal, double dual) {
  const std::size_t n = limits_.points;
  for_rows([&](std::size_t r, std::size_t) {
    kernels::best().step(row(r), Real(complementarity * weight_), &turn_[0], &turn_[n], &turn_[2 * n],
                         Real(primal), Real(dual));
  });
}

/// Sets a norm's row to the components along the present direction of its vector.
void SolverRows::aim_norms() {
  std::size_t from = 0;
  for (std::size_t r = 0; r < limits_.component_end.size(); from = limits_.component_end[r++])
    for (std::size_t i = 0; i < limits_.points; ++i) {
      Basis along{};
      double square = 0;
      for (std::size_t c = from; c < limits_.component_end[r]; ++c) {
        const std::size_t at = c * limits_.points + i;
        double y = 0;
        for (std::size_t a = 0; a < 3; ++a) y += limits_.component[a][at] * double(basis(a)[i]);
        square += y * y;
        for (std::size_t a = 0; a < 3; ++a) along[a] += y * limits_.component[a][at];
      }
      const double norm = std::sqrt(square);
      for (std::size_t a = 0; a < 3; ++a)
        coefficient_[a][r * limits_.points + i] = Real(norm > 0 ? along[a] / norm : 0);
    }
}

/// Adds a norm's curvature: the second derivative of |y| is (1 - n nᵀ)/|y|.
void SolverRows::bend_norms() {
  const std::size_t n = limits_.points;
  std::size_t from = 0;
  for (std::size_t r = 0; r < limits_.component_end.size(); from = limits_.component_end[r++])
    for (std::size_t i = 0; i < n; ++i) {
      const double w =
          high_.multiplier[r * n + i] / std::max(double(value_[r * n + i]), 0.1 * limits_.scale[i]);
      std::size_t at = 0;
      for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = a; b < 3; ++b, ++at) {
          double sum = -double(coefficient_[a][r * n + i]) * double(coefficient_[b][r * n + i]);
          for (std::size_t c = from; c < limits_.component_end[r]; ++c)
            sum += limits_.component[a][c * n + i] * limits_.component[b][c * n + i];
          sums(at)[i] += Real(w * sum);
        }
    }
}

}  // namespace polyarm::timing
