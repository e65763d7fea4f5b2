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

using Basis = std::array<double, 3>;
/// Values and their derivatives by three neighbouring nodes' b.
struct Bases {
  Basis value{};
  std::array<Basis, 3> gradient{};
};

/// Of one over twice the speed: the derivative of the speed by b. At rest, only at the fixed ends: 0.
double by_b(double speed) {
  return speed > 0 ? 0.5 / speed : 0;
}

/// What happens on the interval that ends at node k: duration, acceleration, and their derivatives by b.
struct Interval {
  double time = 0, acceleration = 0;
  double time_low = 0, time_high = 0;  // by b of both ends
  double slope = 0;                    // of the acceleration by b of the end; minus that by b of the begin
};

/// The speeds as they are now, and what happens on the interval before each node; one of nothing before the
/// first and after the last.
struct Speeds {
  Speeds(const std::vector<double>& s, std::vector<double>& squares)
      : b(squares), c(s.size()), per_c(s.size()), slope(s.size()), intervals(s.size() + 1) {
    for (std::size_t k = 1; k < s.size(); ++k) slope[k] = 0.5 / (s[k] - s[k - 1]);
  }
  void evaluate() {
    for (std::size_t k = 0; k < b.size(); ++k) c[k] = std::sqrt(b[k]), per_c[k] = by_b(c[k]);
    for (std::size_t k = 1; k < b.size(); ++k) {
      const double sum = c[k - 1] + c[k], time = 1 / (slope[k] * sum), less = -time / sum;
      intervals[k] = {time, (b[k] - b[k - 1]) * slope[k], less * per_c[k - 1], less * per_c[k], slope[k]};
    }
  }
  double duration() const {
    double sum = 0;
    for (const Interval& i : intervals) sum += i.time;
    return sum;
  }
  std::vector<double>& b;
  std::vector<double> c, per_c, slope;
  std::vector<Interval> intervals;
};

/// s⃛, ṡ·s̈ and ṡ³ at a node. Before the first and after the last interval one of equal time and no
/// acceleration is thought, for the profile begins and ends without acceleration.
Bases jerk_bases_at(const Speeds& now, std::size_t k) {
  const std::size_t last = now.c.size() - 1;
  const Interval& before = now.intervals[k];
  const Interval& behind = now.intervals[k + 1];
  const std::vector<double>&b = now.b, &c = now.c;
  const double share_before = k == last ? 1 : k == 0 ? 0 : 0.5, share_behind = 1 - share_before;
  const double time = share_before * before.time + share_behind * behind.time;
  const double jerk = (behind.acceleration - before.acceleration) / time;
  const double mean = (behind.acceleration + before.acceleration) / 2;
  Bases out;
  out.value = {jerk, c[k] * mean, c[k] * b[k]};
  const Basis up{before.slope, -before.slope - behind.slope, behind.slope};
  const Basis total{-before.slope, before.slope - behind.slope, behind.slope};
  const Basis longer{share_before * before.time_low,
                     share_before * before.time_high + share_behind * behind.time_low,
                     share_behind * behind.time_high};
  for (std::size_t i = 0; i < 3; ++i) {
    out.gradient[0][i] = (up[i] - jerk * longer[i]) / time;
    out.gradient[1][i] = c[k] * total[i] / 2;
  }
  out.gradient[1][1] += now.per_c[k] * mean;
  out.gradient[2][1] = 1.5 * c[k];
  return out;
}

/// The same where s⃛ of node k ends, midway to the node before or behind.
Bases edge_bases_at(const Speeds& now, std::size_t k, int side) {
  Bases out = jerk_bases_at(now, k);
  const std::size_t other = side < 0 ? k - 1 : k + 1;
  const Interval& i = now.intervals[side < 0 ? k : k + 1];
  const double speed = (now.c[k] + now.c[other]) / 2, a = i.acceleration;
  const std::size_t at = side < 0 ? 0 : 2;
  const double by_own = now.per_c[k] / 2, by_other = now.per_c[other] / 2;
  const double slope_own = side < 0 ? i.slope : -i.slope;
  out.value[1] = speed * a, out.value[2] = speed * speed * speed;
  out.gradient[1] = out.gradient[2] = {};
  out.gradient[1][1] = by_own * a + speed * slope_own, out.gradient[1][at] = by_other * a - speed * slope_own;
  out.gradient[2][1] = 3 * speed * speed * by_own, out.gradient[2][at] = 3 * speed * speed * by_other;
  return out;
}

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
  /// Solves for nodes 1..last-1 (at 2..last); the others are 0.
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

/// One kind of rows during the iterations: slacks and multipliers of both sides.
class Side {
 public:
  std::vector<double> slack, multiplier, slack_step, multiplier_step;
  void resize(std::size_t n) {
    slack.resize(n), multiplier.resize(n), slack_step.resize(n), multiplier_step.resize(n);
  }
};

struct Steps {
  double primal = 0, dual = 0;  // the reciprocals of the longest steps
};

class Rows {
 public:
  Rows(const LimitRows& limits, bool jerk) : limits_(limits), jerk_(jerk) { fit(); }
  /// To as many points as there are now; true if they have changed.
  bool fit() {
    if (bases_.size() == limits_.points) return false;
    const std::size_t n = limits_.rows * limits_.points;
    high_.resize(n), low_.resize(n), value_.resize(n);
    coefficient_ = limits_.coefficient;
    bases_.resize(limits_.points);
    for (auto* set : {&m_, &step_}) set->assign(9 * limits_.points, 0.0);
    return true;
  }
  std::size_t sides() const { return 2 * limits_.rows * limits_.points; }
  bool empty() const { return sides() == 0; }

  /// The rows at the speeds c = √b.
  void evaluate(const Speeds& now, bool velocity) {
    const std::vector<double>& b = now.b;
    for (std::size_t i = 0; i < limits_.points; ++i) {
      const std::size_t k = limits_.at[i];
      if (!limits_.side.empty())
        bases_[i] = edge_bases_at(now, k, limits_.side[i]);
      else if (jerk_)
        bases_[i] = jerk_bases_at(now, k);
      else if (velocity)
        bases_[i] = {{b[k], 0, 0}, {{{0, 1, 0}, {}, {}}}};
      else {
        const double slope = now.slope[k + 1];
        bases_[i] = {{now.intervals[k + 1].acceleration, (b[k + 1] + b[k]) / 2, 0},
                     {{{0, -slope, slope}, {0, 0.5, 0.5}, {}}}};
      }
    }
    aim_norms();
    for_rows([&](std::size_t, std::size_t begin) {
      for (std::size_t i = 0; i < limits_.points; ++i) {
        const Basis& v = bases_[i].value;
        value_[begin + i] = coefficient_[0][begin + i] * v[0] + coefficient_[1][begin + i] * v[1] +
                            coefficient_[2][begin + i] * v[2];
      }
    });
  }
  /// Slacks and multipliers that belong to the values; again: those there are, moved off zero.
  void begin(double complementarity, double least, bool again) {
    for_rows([&](std::size_t r, std::size_t begin) {
      for (std::size_t i = begin, k = 0; k < limits_.points; ++i, ++k) {
        const double floor = least * limits_.scale[k] * (1 - limits_.low[r]);
        high_.slack[i] = std::max(limits_.scale[k] - value_[i], floor);
        low_.slack[i] = std::max(value_[i] - limits_.scale[k] * limits_.low[r], floor);
        for (Side* side : {&high_, &low_}) {
          const double fresh = complementarity / side->slack[i];
          side->multiplier[i] = again ? std::max(side->multiplier[i], fresh) : fresh;
        }
      }
    });
  }
  double complementarity() const {
    double sum[4] = {0, 0, 0, 0};
    for (std::size_t i = 0; i < value_.size(); ++i)
      sum[i & 3] += high_.slack[i] * high_.multiplier[i] + low_.slack[i] * low_.multiplier[i];
    return sum[0] + sum[1] + sum[2] + sum[3];
  }
  double worst_residual() const {
    double most = 0;
    for_rows([&](std::size_t r, std::size_t begin) {
      for (std::size_t k = 0; k < limits_.points; ++k) {
        const double value = value_[begin + k], scale = limits_.scale[k], low = scale * limits_.low[r];
        const double over = value - scale > low - value ? value - scale : low - value;
        const double part = over / scale;
        most = most > part ? most : part;
      }
    });
    return most;
  }
  void assemble(double centre, FiveDiagonals& system) {
    const std::size_t n = limits_.points;
    std::fill(m_.begin(), m_.end(), 0.0);
    double *m0 = m_.data(), *m1 = m0 + n, *m2 = m1 + n, *m3 = m2 + n, *m4 = m3 + n, *m5 = m4 + n;
    double *v0 = m5 + n, *v1 = v0 + n, *v2 = v1 + n;
    for_rows([&](std::size_t r, std::size_t begin) {
      const double *q0 = &coefficient_[0][begin], *q1 = &coefficient_[1][begin],
                   *q2 = &coefficient_[2][begin];
      const double *value = &value_[begin], *sh = &high_.slack[begin], *lh = &high_.multiplier[begin];
      const double *sl = &low_.slack[begin], *ll = &low_.multiplier[begin], *scale = limits_.scale.data();
      const double low = limits_.low[r];
      POLYARM_INDEPENDENT
      for (std::size_t i = 0; i < n; ++i) {
        const double wh = 1 / sh[i], wl = 1 / sl[i];
        const double up = wh * (centre + lh[i] * (value[i] + sh[i] - scale[i]));
        const double down = wl * (centre + ll[i] * (sl[i] + low * scale[i] - value[i]));
        const double w = lh[i] * wh + ll[i] * wl, g = up - down;
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
      system.add(limits_.at[i],
                 {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)}, right);
    }
  }
  /// `db` counts from one before the first node.
  void direction(double centre, const std::vector<double>& db, Steps& steps) {
    const std::size_t n = limits_.points;
    double *d0 = step_.data(), *d1 = d0 + n, *d2 = d1 + n;
    for (std::size_t i = 0; i < n; ++i) {
      const double* x = &db[limits_.at[i]];
      const auto& J = bases_[i].gradient;
      d0[i] = J[0][0] * x[0] + J[0][1] * x[1] + J[0][2] * x[2];
      d1[i] = J[1][0] * x[0] + J[1][1] * x[1] + J[1][2] * x[2];
      d2[i] = J[2][0] * x[0] + J[2][1] * x[1] + J[2][2] * x[2];
    }
    double primal = steps.primal, dual = steps.dual;
    for_rows([&](std::size_t r, std::size_t begin) {
      const double *q0 = &coefficient_[0][begin], *q1 = &coefficient_[1][begin],
                   *q2 = &coefficient_[2][begin];
      const double *value = &value_[begin], *sh = &high_.slack[begin], *lh = &high_.multiplier[begin];
      const double *sl = &low_.slack[begin], *ll = &low_.multiplier[begin], *scale = limits_.scale.data();
      double *dsh = &high_.slack_step[begin], *dlh = &high_.multiplier_step[begin];
      double *dsl = &low_.slack_step[begin], *dll = &low_.multiplier_step[begin];
      const double low = limits_.low[r];
      POLYARM_INDEPENDENT
      for (std::size_t i = 0; i < n; ++i) {
        const double change = q0[i] * d0[i] + q1[i] * d1[i] + q2[i] * d2[i];
        dsh[i] = scale[i] - value[i] - sh[i] - change;
        dsl[i] = value[i] - low * scale[i] - sl[i] + change;
        dlh[i] = (centre - lh[i] * dsh[i]) / sh[i] - lh[i];
        dll[i] = (centre - ll[i] * dsl[i]) / sl[i] - ll[i];
      }
      for (std::size_t i = 0; i < n; ++i) {
        const double a = -dsh[i] / sh[i], b = -dsl[i] / sl[i], c = -dlh[i] / lh[i], d = -dll[i] / ll[i];
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
        side->slack[i] += primal * side->slack_step[i];
        side->multiplier[i] += dual * side->multiplier_step[i];
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
          coefficient_[a][r * limits_.points + i] = norm > 0 ? along[a] / norm : 0;
      }
  }
  /// A norm's curvature: |y| curves by (1 - n nᵀ)/|y|.
  void bend_norms() {
    const std::size_t n = limits_.points;
    std::size_t from = 0;
    for (std::size_t r = 0; r < limits_.component_end.size(); from = limits_.component_end[r++])
      for (std::size_t i = 0; i < n; ++i) {
        const double w = high_.multiplier[r * n + i] / std::max(value_[r * n + i], 0.1 * limits_.scale[i]);
        std::size_t at = 0;
        for (std::size_t a = 0; a < 3; ++a)
          for (std::size_t b = a; b < 3; ++b, ++at) {
            double sum = -coefficient_[a][r * n + i] * coefficient_[b][r * n + i];
            for (std::size_t c = from; c < limits_.component_end[r]; ++c)
              sum += limits_.component[a][c * n + i] * limits_.component[b][c * n + i];
            m_[at * n + i] += w * sum;
          }
      }
  }

  const LimitRows& limits_;
  bool jerk_;
  Side high_, low_;
  std::vector<double> value_, m_, step_;
  std::array<std::vector<double>, 3> coefficient_;
  std::vector<Bases> bases_;
};

}  // namespace

class SpeedSolver::Solver {
 public:
  Solver(const SpeedProblem& problem, std::vector<double>& b)
      : p_(problem), b_(b), now_(problem.s, b), db_(b.size() + 4), system_(b.size()) {
    rows_.emplace_back(p_.velocity, false);
    rows_.emplace_back(p_.acceleration, false);
    rows_.emplace_back(p_.norm_acceleration, false);
    rows_.emplace_back(p_.jerk, true);
    for (const LimitRows* jerk : {&p_.norm_jerk, &p_.edge_jerk, &p_.norm_edge_jerk})
      rows_.emplace_back(*jerk, true);
  }

  SpeedSolution run(double precision, int most) {
    SpeedSolution out;
    std::size_t sides = 0;
    std::vector<char> fresh;
    for (Rows& r : rows_) fresh.push_back(!again_ | r.fit()), sides += r.sides();
    if (sides == 0 || b_.size() < 3) return {0, true};
    evaluate();
    for (std::size_t i = 0; i < rows_.size(); ++i)
      rows_[i].begin((again_ ? 0.01 : 0.3) * duration() / double(sides), again_ ? 0.005 : 0.05, !fresh[i]);
    again_ = true;
    double keep = 0.2;
    for (; out.iterations < most; ++out.iterations) {
      double gap = 0, residual = 0;
      for (const Rows& r : rows_)
        gap += r.complementarity(), residual = std::max(residual, r.worst_residual());
      out.converged = gap < precision * duration() && residual < 0.006;
      if (out.converged) break;
      const double centre = keep * gap / double(sides);
      system_.clear();
      add_duration();
      for (Rows& r : rows_) r.assemble(centre, system_);
      system_.solve(b_.size() - 1, db_);
      keep = go(centre);
    }
    return out;
  }

 private:
  void evaluate() {
    now_.evaluate();
    for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].evaluate(now_, i == 0);
  }
  double duration() const { return now_.duration(); }
  void add_duration() {
    for (std::size_t k = 1; k < b_.size(); ++k) {
      const double sum = now_.c[k - 1] + now_.c[k], bend = now_.intervals[k].time / sum;
      const double low = now_.per_c[k - 1], high = now_.per_c[k];
      const auto own = [&](double by) { return bend * 2 * by * by * by; };
      system_.add(k,
                  {2 * bend / sum * low * low + own(low), 2 * bend / sum * low * high, 0,
                   2 * bend / sum * high * high + own(high), 0, 0},
                  {bend * low, bend * high, 0});
    }
  }
  /// Takes the step; returns how much of the complementarity to keep next.
  double go(double centre) {
    Steps longest;
    for (Rows& r : rows_) r.direction(centre, db_, longest);
    double primal = longest.primal > 0.98 ? 0.98 / longest.primal : 1;
    const double dual = longest.dual > 0.98 ? 0.98 / longest.dual : 1;
    for (std::size_t k = 1; k + 1 < b_.size(); ++k) {
      const double change = db_[k + 1] / b_[k];
      if (change * primal < -0.7) primal = -0.7 / change;
      if (change * primal > 3) primal = 3 / change;
    }
    for (std::size_t k = 1; k + 1 < b_.size(); ++k) b_[k] += primal * db_[k + 1];
    for (Rows& r : rows_) r.go(primal, dual);
    evaluate();
    const double least = std::min(primal, dual);
    return least > 0.9 ? 0.05 : least > 0.6 ? 0.15 : least > 0.3 ? 0.3 : 0.6;
  }

  const SpeedProblem& p_;
  std::vector<double>& b_;
  Speeds now_;
  std::vector<double> db_;
  FiveDiagonals system_;
  std::vector<Rows> rows_;
  bool again_ = false;
};

void LimitRows::resize(std::size_t new_rows, std::size_t new_points) {
  rows = new_rows, points = new_points;
  for (auto& c : coefficient) c.assign(rows * points, 0.0);
  low.assign(rows, -1.0);
  at.assign(points, 0);
  scale.assign(points, 1.0);
}

SpeedSolver::SpeedSolver(const SpeedProblem& problem, std::vector<double>& b)
    : solver_(std::make_unique<Solver>(problem, b)) {}
SpeedSolver::~SpeedSolver() = default;

SpeedSolution SpeedSolver::improve(double precision, int most_iterations) {
  return solver_->run(precision, most_iterations);
}

}  // namespace polyarm::trajectory
