#include "polyarm/trajectory/timing_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "polyarm/trajectory/timing.hpp"
#include "polyarm/trajectory/timing_kernels.hpp"

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
  void add_one(std::size_t at, double m, double right) { d0_[at] += m, right_[at] += right; }
  /// `at`: the first of two neighbours, counted likewise.
  void add_two(std::size_t at, double m00, double m01, double m11, double right0, double right1) {
    d0_[at] += m00, d1_[at] += m01, d0_[at + 1] += m11;
    right_[at] += right0, right_[at + 1] += right1;
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
class Rows {
 public:
  Rows(const LimitRows& limits, LimitKind kind) : limits_(limits), kind_(kind) { fit(); }
  /// To as many points as there are now; true if they have changed.
  bool fit() {
    if (room_ && points_ == limits_.points) return false;
    points_ = limits_.points;
    const std::size_t n = limits_.rows * points_;
    room_ = std::make_unique_for_overwrite<double[]>(5 * n);
    double* list = room_.get();
    for (double** to : {&value_, &high_slack_, &high_multiplier_, &low_slack_, &low_multiplier_})
      *to = std::exchange(list, list + n);
    if (!limits_.component_end.empty()) aimed_ = limits_.coefficient;
    if (kind_ == LimitKind::jerk) bases_.resize(points_);
    basis_.assign(3 * points_, 0.0);
    sums_.resize(9 * points_);
    return true;
  }
  std::size_t sides() const { return 2 * limits_.rows * limits_.points; }
  bool empty() const { return sides() == 0; }

  /// The rows at the speeds c = √b.
  void evaluate(const Speeds& now) {
    const std::size_t n = points_;
    double *v0 = basis_.data(), *v1 = v0 + n, *v2 = v1 + n;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t k = limits_.at[i];
      if (kind_ == LimitKind::velocity) {
        v0[i] = now.b[k];
      } else if (kind_ == LimitKind::acceleration) {
        v0[i] = now.intervals[k + 1].acceleration, v1[i] = (now.b[k + 1] + now.b[k]) / 2;
      } else {
        bases_[i] = limits_.side.empty() ? jerk_bases_at(now, k) : edge_bases_at(now, k, limits_.side[i]);
        v0[i] = bases_[i].value[0], v1[i] = bases_[i].value[1], v2[i] = bases_[i].value[2];
      }
    }
    aim_norms();
    for (std::size_t r = 0; r < limits_.rows; ++r) loops_.evaluate(row(r), v0, v1, v2);
  }
  /// Slacks and multipliers that belong to the values; again: those there are, moved off zero.
  void begin(double complementarity, double least, bool again) {
    const auto fresh = [&](double& multiplier, double slack) {
      const double value = complementarity / slack;
      multiplier = again ? std::max(multiplier, value) : value;
    };
    for (std::size_t r = 0; r < limits_.rows; ++r)
      for (std::size_t k = 0, i = r * limits_.points; k < limits_.points; ++i, ++k) {
        const double floor = least * limits_.scale[k] * (1 - limits_.low[r]);
        high_slack_[i] = std::max(limits_.scale[k] - value_[i], floor);
        low_slack_[i] = std::max(value_[i] - limits_.scale[k] * limits_.low[r], floor);
        fresh(high_multiplier_[i], high_slack_[i]), fresh(low_multiplier_[i], low_slack_[i]);
      }
  }
  /// Adds to the sum of slacks times multipliers; raises `residual` to the largest excess of any value.
  void measure(double& complementarity, double& residual) {
    for (std::size_t r = 0; r < limits_.rows; ++r) loops_.measure(row(r), complementarity, residual);
  }
  void assemble(double centre, const Speeds& now, FiveDiagonals& system) {
    if (empty()) return;
    const std::size_t n = points_;
    std::fill(sums_.begin(), sums_.end(), 0.0);
    double* sums[9];
    for (std::size_t k = 0; k < 9; ++k) sums[k] = sums_.data() + k * n;
    for (std::size_t r = 0; r < limits_.rows; ++r) loops_.assemble(row(r), centre, sums);
    bend_norms();
    if (kind_ == LimitKind::velocity)
      for (std::size_t i = 0; i < n; ++i) system.add_one(limits_.at[i] + 1, sums[0][i], -sums[6][i]);
    else if (kind_ == LimitKind::acceleration)
      add_accelerations(now, sums, system);
    else
      add_jerks(sums, system);
  }
  /// Along `db`, which counts from one before the first node: the bases' changes, and how far rows let it go.
  void direction(double centre, const std::vector<double>& db, const Speeds& now, kernels::Decrease& most) {
    const std::size_t n = points_;
    double *d0 = basis_.data(), *d1 = d0 + n, *d2 = d1 + n;
    for (std::size_t i = 0; i < n; ++i) {
      const double* x = &db[limits_.at[i]];
      if (kind_ == LimitKind::velocity) {
        d0[i] = x[1];
        continue;
      }
      if (kind_ == LimitKind::acceleration) {
        d0[i] = now.slope[limits_.at[i] + 1] * (x[2] - x[1]), d1[i] = (x[1] + x[2]) / 2;
        continue;
      }
      const auto& J = bases_[i].gradient;
      d0[i] = J[0][0] * x[0] + J[0][1] * x[1] + J[0][2] * x[2];
      d1[i] = J[1][0] * x[0] + J[1][1] * x[1] + J[1][2] * x[2];
      d2[i] = J[2][0] * x[0] + J[2][1] * x[1] + J[2][2] * x[2];
    }
    for (std::size_t r = 0; r < limits_.rows; ++r) loops_.decrease(row(r), centre, d0, d1, d2, most);
  }
  /// After direction().
  void go(double centre, double primal, double dual) {
    const std::size_t n = limits_.points;
    const double *d0 = basis_.data(), *d1 = d0 + n, *d2 = d1 + n;
    for (std::size_t r = 0; r < limits_.rows; ++r) loops_.step(row(r), centre, d0, d1, d2, primal, dual);
  }

 private:
  void add_accelerations(const Speeds& now, double* const* sums, FiveDiagonals& system) const {
    for (std::size_t i = 0; i < points_; ++i) {
      const double slope = now.slope[limits_.at[i] + 1];
      const double own = slope * slope * sums[0][i], half = slope * sums[1][i], mean = sums[3][i] / 4;
      const double change = slope * sums[6][i], middle = sums[7][i] / 2;
      system.add_two(limits_.at[i] + 1, own - half + mean, mean - own, own + half + mean, change - middle,
                     -change - middle);
    }
  }
  void add_jerks(double* const* sums, FiveDiagonals& system) const {
    const double *m0 = sums[0], *m1 = sums[1], *m2 = sums[2], *m3 = sums[3], *m4 = sums[4], *m5 = sums[5];
    const double *v0 = sums[6], *v1 = sums[7], *v2 = sums[8];
    for (std::size_t i = 0; i < points_; ++i) {
      const auto& J = bases_[i].gradient;
      const double M[3][3] = {{m0[i], m1[i], m2[i]}, {m1[i], m3[i], m4[i]}, {m2[i], m4[i], m5[i]}};
      double MJ[3][3];
      for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t k = 0; k < 3; ++k)
          MJ[a][k] = M[a][0] * J[0][k] + M[a][1] * J[1][k] + M[a][2] * J[2][k];
      const auto entry = [&](std::size_t a, std::size_t k) {
        return J[0][a] * MJ[0][k] + J[1][a] * MJ[1][k] + J[2][a] * MJ[2][k];
      };
      Basis right;
      for (std::size_t a = 0; a < 3; ++a) right[a] = -(J[0][a] * v0[i] + J[1][a] * v1[i] + J[2][a] * v2[i]);
      system.add(limits_.at[i],
                 {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)}, right);
    }
  }
  const std::array<std::vector<double>, 3>& coefficients() const {
    return limits_.component_end.empty() ? limits_.coefficient : aimed_;
  }
  kernels::Row row(std::size_t r) {
    const std::size_t begin = r * limits_.points;
    const auto& q = coefficients();
    return {limits_.points,       q[0].data() + begin,     q[1].data() + begin, q[2].data() + begin,
            limits_.scale.data(), value_ + begin,          high_slack_ + begin, high_multiplier_ + begin,
            low_slack_ + begin,   low_multiplier_ + begin, limits_.low[r]};
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
          for (std::size_t a = 0; a < 3; ++a) y += limits_.component[a][at] * basis_[a * points_ + i];
          square += y * y;
          for (std::size_t a = 0; a < 3; ++a) along[a] += y * limits_.component[a][at];
        }
        const double norm = std::sqrt(square);
        for (std::size_t a = 0; a < 3; ++a)
          aimed_[a][r * limits_.points + i] = norm > 0 ? along[a] / norm : 0;
      }
  }
  /// A norm's curvature: |y| curves by (1 - n nᵀ)/|y|.
  void bend_norms() {
    const std::size_t n = limits_.points;
    std::size_t from = 0;
    for (std::size_t r = 0; r < limits_.component_end.size(); from = limits_.component_end[r++])
      for (std::size_t i = 0; i < n; ++i) {
        const double w = high_multiplier_[r * n + i] / std::max(value_[r * n + i], 0.1 * limits_.scale[i]);
        std::size_t at = 0;
        for (std::size_t a = 0; a < 3; ++a)
          for (std::size_t b = a; b < 3; ++b, ++at) {
            double sum = -aimed_[a][r * n + i] * aimed_[b][r * n + i];
            for (std::size_t c = from; c < limits_.component_end[r]; ++c)
              sum += limits_.component[a][c * n + i] * limits_.component[b][c * n + i];
            sums_[at * n + i] += w * sum;
          }
      }
  }

  const LimitRows& limits_;
  LimitKind kind_;
  const kernels::Set& loops_ = kernels::best();
  std::size_t points_ = 0;
  std::unique_ptr<double[]> room_;  // of the five lists
  double *value_ = nullptr, *high_slack_ = nullptr, *high_multiplier_ = nullptr, *low_slack_ = nullptr,
         *low_multiplier_ = nullptr;
  std::vector<double> basis_, sums_;          // per point: three bases or their changes; nine sums
  std::array<std::vector<double>, 3> aimed_;  // of norms
  std::vector<Bases> bases_;                  // of jerks
};

}  // namespace

class SpeedSolver::Solver {
 public:
  Solver(const SpeedProblem& problem, std::vector<double>& b)
      : p_(problem), b_(b), now_(problem.s, b), db_(b.size() + 4), system_(b.size()) {
    rows_.emplace_back(p_.velocity, LimitKind::velocity);
    for (const LimitRows* rows : {&p_.acceleration, &p_.norm_acceleration})
      rows_.emplace_back(*rows, LimitKind::acceleration);
    for (const LimitRows* rows : {&p_.jerk, &p_.norm_jerk, &p_.edge_jerk, &p_.norm_edge_jerk})
      rows_.emplace_back(*rows, LimitKind::jerk);
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
      for (Rows& r : rows_) r.measure(gap, residual);
      out.converged = gap < precision * duration() && residual < 0.006;
      if (out.converged) break;
      const double centre = keep * gap / double(sides);
      system_.clear();
      add_duration();
      for (Rows& r : rows_) r.assemble(centre, now_, system_);
      system_.solve(b_.size() - 1, db_);
      keep = go(centre);
    }
    return out;
  }

 private:
  void evaluate() {
    now_.evaluate();
    for (Rows& r : rows_) r.evaluate(now_);
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
    kernels::Decrease longest;
    for (Rows& r : rows_) r.direction(centre, db_, now_, longest);
    double primal = longest.primal > 0.98 ? 0.98 / longest.primal : 1;
    const double dual = longest.dual > 0.98 ? 0.98 / longest.dual : 1;
    for (std::size_t k = 1; k + 1 < b_.size(); ++k) {
      const double change = db_[k + 1] / b_[k];
      if (change * primal < -0.7) primal = -0.7 / change;
      if (change * primal > 3) primal = 3 / change;
    }
    for (std::size_t k = 1; k + 1 < b_.size(); ++k) b_[k] += primal * db_[k + 1];
    for (Rows& r : rows_) r.go(centre, primal, dual);
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
