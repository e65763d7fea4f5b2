#include "polyarm/trajectory/timing_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>

// Before a loop whose arrays do not overlap.
#ifdef __clang__
#define POLYARM_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define POLYARM_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace polyarm::trajectory {
namespace {

constexpr double kCentre = 0.7;        // of the gap asked for, to which products are led
constexpr double kLeastSlack = 0.001;  // when going on, per the width between the limits
// Of the products of other rows that those of velocity keep, so that a stated speed is met closely.
constexpr double kVelocityShare = 0.3;
constexpr double kSlackOfExcess = 0.3;  // with which a row that is above its limit begins

using Basis = std::array<double, 3>;
/// Values and their derivatives by three neighbouring nodes' b.
struct Bases {
  Basis value{};
  std::array<Basis, 3> gradient{};
};

/// How b and a at both ends of a piece change along the three directions that touch it.
using Moves = std::array<Basis, 4>;
Moves moves_at(const JerkPieces& p, std::size_t k) {
  const ByNodes &before = k > 1 ? p.direction(k - 2) : p.direction(0), &own = p.direction(k - 1),
                &behind = p.direction(k);
  return {{{before[2], own[0], 0}, {before[3], own[1], 0}, {0, own[2], behind[0]}, {0, own[3], behind[1]}}};
}

/// s⃛, ṡ·s̈ and ṡ³ at an end of piece k.
Bases jerk_bases_at(const NodeMotion& m, const JerkPieces& p, std::size_t k, bool end, const Moves& moves) {
  const std::size_t node = end ? k : k - 1, at = end ? 2 : 0;
  const double v = p.speed(node), a = m.a[node], by = p.speed_by(node);
  const JerkPiece& piece = p.piece(k);
  Bases out;
  out.value = {piece.jerk, v * a, v * m.b[node]};
  for (std::size_t i = 0; i < 3; ++i) {
    const double db = moves[at][i], da = moves[at + 1][i];
    out.gradient[0][i] = piece.jerk_by[0] * moves[0][i] + piece.jerk_by[1] * moves[1][i] +
                         piece.jerk_by[2] * moves[2][i] + piece.jerk_by[3] * moves[3][i];
    out.gradient[1][i] = v * da + a * by * db;
    out.gradient[2][i] = 1.5 * v * db;
  }
  return out;
}

/// b at a node, and before it s̈ if that is asked for.
Bases node_bases_at(const NodeMotion& m, const JerkPieces& p, std::size_t node, bool acceleration) {
  const ByNodes &before = node > 0 ? p.direction(node - 1) : p.direction(0), &behind = p.direction(node);
  const Basis b{before[2], behind[0], 0};
  if (!acceleration) return {{m.b[node], 0, 0}, {b, {}, {}}};
  return {{m.a[node], m.b[node], 0}, {{{before[3], behind[1], 0}, b, {}}}};
}

/// The same where half of piece k's way is done: of the cubic b(s) through both ends.
Bases middle_bases_at(const NodeMotion& m, std::size_t k, bool acceleration, const Moves& moves) {
  const double way = m.s[k] - m.s[k - 1], per = 0.75 / way, share = way / 4;
  const double b = (m.b[k] + m.b[k - 1]) / 2 + share * (m.a[k - 1] - m.a[k]);
  Basis by_b, by_a;
  for (std::size_t i = 0; i < 3; ++i) {
    by_b[i] = (moves[0][i] + moves[2][i]) / 2 + share * (moves[1][i] - moves[3][i]);
    by_a[i] = per * (moves[2][i] - moves[0][i]) - (moves[1][i] + moves[3][i]) / 4;
  }
  if (!acceleration) return {{b, 0, 0}, {by_b, {}, {}}};
  return {{per * (m.b[k] - m.b[k - 1]) - (m.a[k] + m.a[k - 1]) / 4, b, 0}, {by_a, by_b, {}}};
}

enum class RowKind { velocity, acceleration, jerk };

/// A symmetric system with five diagonals.
class FiveDiagonals {
 public:
  explicit FiveDiagonals(std::size_t n) : d0_(n + 4), d1_(n + 4), d2_(n + 4), right_(n + 4) {}
  void clear() {
    for (auto* v : {&d0_, &d1_, &d2_, &right_}) std::fill(v->begin(), v->end(), 0.0);
  }
  /// `at`: the first of three neighbours, counted from one before the first node.
  void add(std::size_t at, const std::array<double, 6>& m, const Basis& right) {
    d0_[at] += m[0], d1_[at] += m[1], d2_[at] += m[2];
    d0_[at + 1] += m[3], d1_[at + 1] += m[4], d0_[at + 2] += m[5];
    for (std::size_t i = 0; i < 3; ++i) right_[at + i] += right[i];
  }
  /// Solves for 2..last; the others are 0.
  void solve(std::size_t last, std::vector<double>& x) {
    for (std::size_t i = 2; i <= last; ++i) {
      const double pivot = d0_[i] *= 1 + 1e-13;
      const double l1 = i + 1 <= last ? d1_[i] / pivot : 0, l2 = i + 2 <= last ? d2_[i] / pivot : 0;
      if (i + 1 <= last) {
        d0_[i + 1] -= l1 * d1_[i], d1_[i + 1] -= l1 * d2_[i] * (i + 2 <= last);
        right_[i + 1] -= l1 * right_[i];
      }
      if (i + 2 <= last) d0_[i + 2] -= l2 * d2_[i], right_[i + 2] -= l2 * right_[i];
      d1_[i] = l1, d2_[i] = l2, right_[i] /= pivot;
    }
    std::fill(x.begin(), x.end(), 0.0);
    for (std::size_t i = last; i >= 2; --i) {
      x[i] = right_[i];
      if (i + 1 <= last) x[i] -= d1_[i] * x[i + 1];
      if (i + 2 <= last) x[i] -= d2_[i] * x[i + 2];
    }
  }

 private:
  std::vector<double> d0_, d1_, d2_, right_;
};

/// Of rows: steps need not be exact, and twice as many numbers go into a register.
using Real = float;

/// One kind of rows during the iterations: slacks and multipliers of both sides.
class Side {
 public:
  std::vector<Real> slack, multiplier, slack_step, multiplier_step;
  void resize(std::size_t n) {
    slack.resize(n), multiplier.resize(n), slack_step.resize(n), multiplier_step.resize(n);
  }
};

struct Steps {
  double primal = 0, dual = 0;  // the reciprocals of the longest steps
};

class Rows {
 public:
  Rows(const LimitRows& limits, RowKind kind) : limits_(limits), kind_(kind) {
    if (kind == RowKind::velocity) weight_ = kVelocityShare;
    const std::size_t n = limits_.rows * limits_.points;
    high_.resize(n), low_.resize(n), value_.resize(n);
    for (std::size_t i = 0; i < 3; ++i)
      coefficient_[i].assign(limits_.coefficient[i].begin(), limits_.coefficient[i].end());
    bases_.resize(limits_.points), at_.resize(limits_.points);
    for (auto* set : {&m_, &step_}) set->assign(9 * limits_.points, Real(0));
    for (std::size_t i = 0; i < at_.size(); ++i)
      at_[i] = kind == RowKind::jerk     ? i % (limits_.points / 2)
               : i < limits_.node.size() ? limits_.node[i]
                                         : i - limits_.node.size();
  }
  std::size_t sides() const { return 2 * limits_.rows * limits_.points; }
  bool empty() const { return sides() == 0; }

  /// The rows at the motion as it is now.
  void evaluate(const NodeMotion& m, const JerkPieces& p) {
    if (empty()) return;
    const std::size_t pieces = p.count();
    if (kind_ == RowKind::jerk) {
      for (std::size_t k = 1; k <= pieces; ++k) {
        const Moves moves = moves_at(p, k);
        bases_[k - 1] = jerk_bases_at(m, p, k, false, moves);
        bases_[pieces + k - 1] = jerk_bases_at(m, p, k, true, moves);
      }
    } else {
      const bool acceleration = kind_ == RowKind::acceleration;
      const std::size_t nodes = limits_.node.size();
      for (std::size_t i = 0; i < nodes; ++i) bases_[i] = node_bases_at(m, p, limits_.node[i], acceleration);
      for (std::size_t k = 1; k <= limits_.points - nodes; ++k)
        bases_[nodes + k - 1] = middle_bases_at(m, k, acceleration, moves_at(p, k));
    }
    aim_norms();
    const std::size_t n = limits_.points;
    Real *v0 = step_.data(), *v1 = v0 + n, *v2 = v1 + n;
    for (std::size_t i = 0; i < n; ++i) {
      const Basis& v = bases_[i].value;
      v0[i] = Real(v[0]), v1[i] = Real(v[1]), v2[i] = Real(v[2]);
    }
    for_rows([&](std::size_t, std::size_t begin) {
      const Real *q0 = &coefficient_[0][begin], *q1 = &coefficient_[1][begin], *q2 = &coefficient_[2][begin];
      Real* value = &value_[begin];
      POLYARM_INDEPENDENT
      for (std::size_t i = 0; i < n; ++i) value[i] = q0[i] * v0[i] + q1[i] * v1[i] + q2[i] * v2[i];
    });
  }
  /// Slacks and multipliers that belong to the values; again: those there are, moved off zero.
  void begin(double complementarity, double least, bool again) {
    scale_.assign(limits_.scale.begin(), limits_.scale.end());
    for_rows([&](std::size_t r, std::size_t begin) {
      for (std::size_t i = begin, k = 0; k < limits_.points; ++i, ++k) {
        const double floor = least * weight_ * limits_.scale[k] * (1 - limits_.low[r]);
        const double up = limits_.scale[k] - value_[i], down = value_[i] - limits_.scale[k] * limits_.low[r];
        high_.slack[i] = Real(std::max(up, up > 0 ? floor : floor - kSlackOfExcess * up));
        low_.slack[i] = Real(std::max(down, down > 0 ? floor : floor - kSlackOfExcess * down));
        for (Side* side : {&high_, &low_}) {
          const double fresh = complementarity * weight_ / side->slack[i];
          side->multiplier[i] = Real(again ? std::max(double(side->multiplier[i]), fresh) : fresh);
        }
      }
    });
  }
  void inherit(const Rows& before, const std::vector<std::size_t>& origins) {
    const std::size_t points = before.at_.size();
    for_rows([&](std::size_t r, std::size_t begin) {
      for (std::size_t i = 0; i < limits_.points; ++i) {
        if (origins[i] == PointOrigins::kNew) continue;
        const std::size_t from = r * points + origins[i];
        high_.multiplier[begin + i] = before.high_.multiplier[from];
        low_.multiplier[begin + i] = before.low_.multiplier[from];
      }
    });
  }
  double complementarity() const {
    Real sum[8] = {0, 0, 0, 0, 0, 0, 0, 0};
    const Real *sh = high_.slack.data(), *lh = high_.multiplier.data();
    const Real *sl = low_.slack.data(), *ll = low_.multiplier.data();
    std::size_t i = 0;
    for (; i + 8 <= value_.size(); i += 8)
      for (std::size_t k = 0; k < 8; ++k) sum[k] += sh[i + k] * lh[i + k] + sl[i + k] * ll[i + k];
    for (; i < value_.size(); ++i) sum[0] += sh[i] * lh[i] + sl[i] * ll[i];
    double all = 0;
    for (const Real x : sum) all += x;
    return all;
  }
  double worst_residual() const {
    Real most = 0;
    for_rows([&](std::size_t r, std::size_t begin) {
      const Real low = Real(limits_.low[r]), *value = &value_[begin], *scale = scale_.data();
      for (std::size_t i = 0; i < limits_.points; ++i) {
        const Real up = value[i] / scale[i] - 1, down = low - value[i] / scale[i];
        const Real over = up > down ? up : down;
        most = most > over ? most : over;
      }
    });
    return most;
  }
  void assemble(double complementarity, FiveDiagonals& system) {
    if (empty()) return;
    const std::size_t n = limits_.points;
    const Real centre = Real(complementarity * weight_);
    std::fill(m_.begin(), m_.end(), Real(0));
    Real *m0 = m_.data(), *m1 = m0 + n, *m2 = m1 + n, *m3 = m2 + n, *m4 = m3 + n, *m5 = m4 + n;
    Real *v0 = m5 + n, *v1 = v0 + n, *v2 = v1 + n;
    for_rows([&](std::size_t r, std::size_t begin) {
      const Real *q0 = &coefficient_[0][begin], *q1 = &coefficient_[1][begin], *q2 = &coefficient_[2][begin];
      const Real *value = &value_[begin], *sh = &high_.slack[begin], *lh = &high_.multiplier[begin];
      const Real *sl = &low_.slack[begin], *ll = &low_.multiplier[begin], *scale = scale_.data();
      const Real low = Real(limits_.low[r]);
      POLYARM_INDEPENDENT
      for (std::size_t i = 0; i < n; ++i) {
        const Real wh = 1 / sh[i], wl = 1 / sl[i];
        const Real up = wh * (centre + lh[i] * (value[i] + sh[i] - scale[i]));
        const Real down = wl * (centre + ll[i] * (sl[i] + low * scale[i] - value[i]));
        const Real w = lh[i] * wh + ll[i] * wl, g = up - down;
        m0[i] += w * q0[i] * q0[i], m1[i] += w * q0[i] * q1[i], m2[i] += w * q0[i] * q2[i];
        m3[i] += w * q1[i] * q1[i], m4[i] += w * q1[i] * q2[i], m5[i] += w * q2[i] * q2[i];
        v0[i] += g * q0[i], v1[i] += g * q1[i], v2[i] += g * q2[i];
      }
    });
    bend_norms();
    for (std::size_t i = 0; i < n; ++i) {
      const auto& J = bases_[i].gradient;
      const double M[3][3] = {{m0[i], m1[i], m2[i]}, {m1[i], m3[i], m4[i]}, {m2[i], m4[i], m5[i]}};
      double MJ[3][3];
      for (int a = 0; a < 3; ++a)
        for (int k = 0; k < 3; ++k)
          MJ[a][k] = M[a][0] * J[0][std::size_t(k)] + M[a][1] * J[1][std::size_t(k)] +
                     M[a][2] * J[2][std::size_t(k)];
      const auto entry = [&](std::size_t a, int k) {
        return J[0][a] * MJ[0][k] + J[1][a] * MJ[1][k] + J[2][a] * MJ[2][k];
      };
      Basis right;
      for (std::size_t a = 0; a < 3; ++a) right[a] = -(J[0][a] * v0[i] + J[1][a] * v1[i] + J[2][a] * v2[i]);
      system.add(at_[i], {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)},
                 right);
    }
  }
  void direction(double complementarity, const std::vector<double>& db, Steps& steps) {
    if (empty()) return;
    const std::size_t n = limits_.points;
    const Real centre = Real(complementarity * weight_);
    Real *d0 = step_.data(), *d1 = d0 + n, *d2 = d1 + n;
    for (std::size_t i = 0; i < n; ++i) {
      const double* x = &db[at_[i]];
      const auto& J = bases_[i].gradient;
      d0[i] = Real(J[0][0] * x[0] + J[0][1] * x[1] + J[0][2] * x[2]);
      d1[i] = Real(J[1][0] * x[0] + J[1][1] * x[1] + J[1][2] * x[2]);
      d2[i] = Real(J[2][0] * x[0] + J[2][1] * x[1] + J[2][2] * x[2]);
    }
    Real primal = Real(steps.primal), dual = Real(steps.dual);
    for_rows([&](std::size_t r, std::size_t begin) {
      const Real *q0 = &coefficient_[0][begin], *q1 = &coefficient_[1][begin], *q2 = &coefficient_[2][begin];
      const Real *value = &value_[begin], *sh = &high_.slack[begin], *lh = &high_.multiplier[begin];
      const Real *sl = &low_.slack[begin], *ll = &low_.multiplier[begin], *scale = scale_.data();
      Real *dsh = &high_.slack_step[begin], *dlh = &high_.multiplier_step[begin];
      Real *dsl = &low_.slack_step[begin], *dll = &low_.multiplier_step[begin];
      const Real low = Real(limits_.low[r]);
      POLYARM_INDEPENDENT
      for (std::size_t i = 0; i < n; ++i) {
        const Real change = q0[i] * d0[i] + q1[i] * d1[i] + q2[i] * d2[i];
        dsh[i] = scale[i] - value[i] - sh[i] - change;
        dsl[i] = value[i] - low * scale[i] - sl[i] + change;
        dlh[i] = (centre - lh[i] * dsh[i]) / sh[i] - lh[i];
        dll[i] = (centre - ll[i] * dsl[i]) / sl[i] - ll[i];
      }
      for (std::size_t i = 0; i < n; ++i) {
        const Real a = -dsh[i] / sh[i], b = -dsl[i] / sl[i], c = -dlh[i] / lh[i], d = -dll[i] / ll[i];
        primal = primal > a ? primal : a;
        primal = primal > b ? primal : b;
        dual = dual > c ? dual : c;
        dual = dual > d ? dual : d;
      }
    });
    steps = {primal, dual};
  }
  void go(double primal, double dual) {
    for (Side* side : {&high_, &low_})
      for (std::size_t i = 0; i < value_.size(); ++i) {
        side->slack[i] += Real(primal) * side->slack_step[i];
        side->multiplier[i] += Real(dual) * side->multiplier_step[i];
      }
  }

 private:
  template <typename Each>
  void for_rows(Each each) const {
    for (std::size_t r = 0; r < limits_.rows; ++r) each(r, r * limits_.points);
  }
  /// A norm's row: the components along where their vector points now.
  void aim_norms() {
    std::size_t from = 0;
    for (std::size_t r = 0; r < limits_.component_end.size(); from = limits_.component_end[r++])
      for (std::size_t i = 0; i < limits_.points; ++i) {
        Basis along{};
        double square = 0;
        for (std::size_t c = from; c < limits_.component_end[r]; ++c) {
          const std::size_t at = c * limits_.points + i;
          double y = 0;
          for (std::size_t a = 0; a < 3; ++a) y += limits_.component[a][at] * bases_[i].value[a];
          square += y * y;
          for (std::size_t a = 0; a < 3; ++a) along[a] += y * limits_.component[a][at];
        }
        const double norm = std::sqrt(square);
        for (std::size_t a = 0; a < 3; ++a)
          coefficient_[a][r * limits_.points + i] = Real(norm > 0 ? along[a] / norm : 0);
      }
  }
  /// A norm's curvature: |y| curves by (1 - n nᵀ)/|y|.
  void bend_norms() {
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
            m_[at * n + i] += Real(w * sum);
          }
      }
  }

  const LimitRows& limits_;
  RowKind kind_;
  double weight_ = 1;  // of the product of slack and multiplier
  Side high_, low_;
  std::vector<Real> value_, scale_, m_, step_;
  std::array<std::vector<Real>, 3> coefficient_;
  std::vector<Bases> bases_;
  std::vector<std::size_t> at_;  // the place in the system of the first direction
};

}  // namespace

class SpeedSolver::Solver {
 public:
  Solver(const SpeedProblem& problem, NodeMotion& motion)
      : motion_(motion), pieces_(motion), step_(motion.s.size() + 4), system_(motion.s.size()) {
    rows_.emplace_back(problem.velocity, RowKind::velocity);
    for (const LimitRows* rows : {&problem.acceleration, &problem.norm_acceleration})
      rows_.emplace_back(*rows, RowKind::acceleration);
    for (const LimitRows* rows : {&problem.jerk, &problem.norm_jerk})
      rows_.emplace_back(*rows, RowKind::jerk);
    pieces_.evaluate();
  }

  void inherit(const Solver& before, const PointOrigins& origins) {
    rows_[0].inherit(before.rows_[0], origins.velocity);
    for (const std::size_t i : {1, 2}) rows_[i].inherit(before.rows_[i], origins.acceleration);
    for (const std::size_t i : {3, 4}) rows_[i].inherit(before.rows_[i], origins.jerk);
    again_ = true;
  }
  SpeedSolution run(double precision, double allowed, int most) {
    SpeedSolution out;
    std::size_t sides = 0;
    for (Rows& r : rows_) sides += r.sides();
    for (int i = 0; i < 9 && pieces_.worst_gap() > 1e-6; ++i) pieces_.close();
    evaluate();
    for (Rows& r : rows_)
      r.begin((again_ ? kCentre * precision : 0.3) * pieces_.duration() / double(sides),
              again_ ? kLeastSlack : 0.05, again_);
    again_ = true;
    double keep = 0.2, last_residual = 1e9;
    damping_ = 1, stuck_ = 0;
    for (; out.iterations < most; ++out.iterations) {
      double gap = 0, residual = 0;
      for (const Rows& r : rows_)
        gap += r.complementarity(), residual = std::max(residual, r.worst_residual());
      out.converged = gap < precision * pieces_.duration() && residual < allowed;
      if (out.converged) break;
      // Steps that overshoot time and again: the rows' own curvature, which is left out.
      if (residual > 2 * last_residual && residual > 0.1 * allowed)
        damping_ = std::max(0.25, damping_ / 2);
      else
        damping_ = std::min(1.0, 1.3 * damping_);
      last_residual = residual;
      // Never nearer to the limits than asked for: what is best within that moves little with the scales.
      const double centre = std::max(keep * gap, kCentre * precision * pieces_.duration()) / double(sides);
      system_.clear();
      add_duration();
      for (Rows& r : rows_) r.assemble(centre, system_);
      system_.solve(pieces_.count() - 1, step_);
      keep = go(centre);
      if (stuck_ > 2) break;
    }
    for (int i = 0; i < 6 && pieces_.worst_gap() > 1e-13; ++i) pieces_.close();
    return out;
  }
  const JerkPieces& pieces() const { return pieces_; }

 private:
  void evaluate() {
    pieces_.find_directions();
    for (Rows& r : rows_) r.evaluate(motion_, pieces_);
  }
  void add_duration() {
    for (std::size_t k = 1; k <= pieces_.count(); ++k) {
      const JerkPiece& p = pieces_.piece(k);
      const Moves moves = moves_at(pieces_, k);
      const double low = pieces_.speed_by(k - 1), high = pieces_.speed_by(k);
      const double sum = pieces_.speed(k - 1) + pieces_.speed(k), bend = p.time / sum;
      // The curvature by b of 2Δs/(v₀ + v₁), which is that of the time but for what changes along a piece.
      const double c00 = bend * (2 * low * low / sum + 2 * low * low * low),
                   c01 = bend * 2 * low * high / sum;
      const double c11 = bend * (2 * high * high / sum + 2 * high * high * high);
      Basis right{}, one{}, two{};
      for (std::size_t i = 0; i < 3; ++i) {
        one[i] = c00 * moves[0][i] + c01 * moves[2][i], two[i] = c01 * moves[0][i] + c11 * moves[2][i];
        for (std::size_t n = 0; n < 4; ++n) right[i] -= p.time_by[n] * moves[n][i];
      }
      const auto entry = [&](std::size_t i, std::size_t j) {
        return moves[0][i] * one[j] + moves[2][i] * two[j];
      };
      system_.add(k - 1, {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)},
                  right);
    }
  }
  /// Takes the step; returns how much of the complementarity to keep next.
  double go(double centre) {
    Steps longest;
    for (Rows& r : rows_) r.direction(centre, step_, longest);
    double primal = longest.primal > 0.98 ? 0.98 / longest.primal : 1;
    const double dual = longest.dual > 0.98 ? 0.98 / longest.dual : 1;
    const std::size_t last = pieces_.count();
    for (std::size_t k = 1; k < last; ++k) {
      const double change = pieces_.change_of_b(k, &step_[1]) / motion_.b[k];
      if (change * primal < -0.7) primal = -0.7 / change;
      if (change * primal > 3) primal = 3 / change;
    }
    primal *= damping_;
    before_ = motion_;
    for (int tries = 0;; ++tries, primal *= 0.3) {
      for (std::size_t k = 1; k < last; ++k) {
        motion_.b[k] = before_.b[k] + primal * pieces_.change_of_b(k, &step_[1]);
        motion_.a[k] = before_.a[k] + primal * pieces_.change_of_a(k, &step_[1]);
      }
      pieces_.evaluate();
      for (int i = 0; i < 3 && pieces_.worst_gap() > 1e-6; ++i) pieces_.close();
      if (pieces_.sound()) {
        stuck_ = 0;
        break;
      }
      if (tries < 9) continue;
      ++stuck_;
      motion_ = before_, primal = 0;
      pieces_.evaluate();
      break;
    }
    for (Rows& r : rows_) r.go(primal, dual);
    evaluate();
    const double least = std::min(primal, dual);
    return least > 0.9 ? 0.05 : least > 0.6 ? 0.15 : least > 0.3 ? 0.3 : 0.6;
  }

  NodeMotion& motion_;
  NodeMotion before_;
  JerkPieces pieces_;
  std::vector<double> step_;
  FiveDiagonals system_;
  std::vector<Rows> rows_;
  double damping_ = 1;  // of steps
  int stuck_ = 0;       // steps that led nowhere
  bool again_ = false;
};

void LimitRows::resize(std::size_t new_rows, std::size_t new_points) {
  rows = new_rows, points = new_points;
  for (auto& c : coefficient) c.assign(rows * points, 0.0);
  low.assign(rows, -1.0);
  scale.assign(points, 1.0);
}

SpeedSolver::SpeedSolver(const SpeedProblem& problem, NodeMotion& motion)
    : solver_(std::make_unique<Solver>(problem, motion)) {}
SpeedSolver::SpeedSolver(const SpeedProblem& problem, NodeMotion& motion, const SpeedSolver& before,
                         const PointOrigins& origins)
    : SpeedSolver(problem, motion) {
  solver_->inherit(*before.solver_, origins);
}
SpeedSolver::~SpeedSolver() = default;

SpeedSolution SpeedSolver::improve(double precision, double residual, int most_iterations) {
  return solver_->run(precision, residual, most_iterations);
}
const JerkPieces& SpeedSolver::pieces() const {
  return solver_->pieces();
}

}  // namespace polyarm::trajectory
