#pragma once
/// A slow optimiser of the time on a path, to judge the fast one. The two share nothing: here b = ṡ² is a
/// quadratic B-spline over s (there: ṡ is one over time), the rows are enforced at several places of every
/// interval, and a primal barrier method starts from a slow motion and keeps all rows throughout.
///
/// With s̈ = b'/2 and s⃛ = √b b''/2 the rows of velocity and acceleration are linear in b, and that of jerk
/// is |q' b''/2 + 3/2 q'' b' + q''' b| ≤ J/√b, whose right side is convex. Replacing it by its tangent gives
/// convex problems within the true one (Yuille and Rangarajan, The Concave-Convex Procedure, 2003; Boyd and
/// Vandenberghe, Convex Optimization, 2004, chapter 11). From rest to the first knot, and from the last knot
/// to rest, the jerk is constant: s ~ t³, so b = 3/4 s b' there.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "polyarm/paths/path.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::test {

struct SlowOptions {
  std::size_t intervals = 500;
  double precision = 1e-4;  ///< relative precision of the duration at which the barrier method ends
  int rounds = 3;           ///< number of rounds that place the knots evenly in time and solve again
};

class SlowTiming {
 public:
  SlowTiming(const paths::Path& path, std::span<const trajectory::MotionLimits> limits,
             const SlowOptions& options = {})
      : path_(path), limits_(limits.begin(), limits.end()), o_(options), n_(path.joints()) {
    for (auto& list : d_) list.resize(n_);
  }

  /// The duration from rest to rest, s, stretched to remove every excess between the places.
  double duration() {
    double best = std::numeric_limits<double>::infinity();
    std::vector<double> even;
    for (std::size_t k = 0; k <= o_.intervals; ++k) {
      const double x = double(k) / double(o_.intervals);
      even.push_back(path_.length() * x * x * x * (10 - 15 * x + 6 * x * x));
    }
    set_knots(even);
    for (int round = 0; round < o_.rounds; ++round) {
      solve();
      best = std::min(best, time() * stretch());
      set_knots(even_in_time());
    }
    return best;
  }

 private:
  static constexpr std::size_t kPlaces = 5;  // places of rows in each interval
  static constexpr std::size_t kQuadrature = 4;

  /// A row at a place: k · c must be within [low, high], for three coefficients c; for jerk, within that
  /// range times 1/√b.
  struct Row {
    std::array<double, 3> k;
    double low, high;
    bool jerk;
  };
  struct Place {
    std::size_t interval;
    std::array<double, 3> b;  // weights of the coefficients
    double ceiling;           // largest b that the velocity limits allow
    std::vector<Row> rows;
  };

  std::array<double, 3> value(std::size_t i, double x) const {
    const double h0 = knot_[i + 1] - knot_[i];
    const double before = i > 0 ? knot_[i] - knot_[i - 1] : 0;
    const double behind = i + 2 < knot_.size() ? knot_[i + 2] - knot_[i + 1] : 0;
    const double y = 1 - x;
    const double first = y * y * h0 / (h0 + before), last = x * x * h0 / (h0 + behind);
    return {first, 1 - first - last, last};
  }
  std::array<double, 3> slope(std::size_t i, double x) const {
    const double h0 = knot_[i + 1] - knot_[i];
    const double before = i > 0 ? knot_[i] - knot_[i - 1] : 0;
    const double behind = i + 2 < knot_.size() ? knot_[i + 2] - knot_[i + 1] : 0;
    const double first = -2 * (1 - x) / (h0 + before), last = 2 * x / (h0 + behind);
    return {first, -first - last, last};
  }
  std::array<double, 3> bend(std::size_t i) const {
    const double h0 = knot_[i + 1] - knot_[i];
    const double before = i > 0 ? knot_[i] - knot_[i - 1] : 0;
    const double behind = i + 2 < knot_.size() ? knot_[i + 2] - knot_[i + 1] : 0;
    const double first = 2 / (h0 * (h0 + before)), last = 2 / (h0 * (h0 + behind));
    return {first, -first - last, last};
  }
  std::size_t intervals() const { return knot_.size() - 1; }
  /// The dot product with the coefficients of interval i: c_[i], c_[i + 1], c_[i + 2].
  double dot(const std::array<double, 3>& k, const std::vector<double>& c, std::size_t i) const {
    return k[0] * c[i] + k[1] * c[i + 1] + k[2] * c[i + 2];
  }

  void look(double s) { path_.at(s, {d_[0], d_[1], d_[2], d_[3]}); }

  /// Sets the knots to the nodes and the breaks of the path. The first and the last interval have constant
  /// jerk.
  void set_knots(std::vector<double> nodes) {
    const double length = path_.length();
    for (const double b : path_.breaks())
      if (b > 2 * nodes[1] && b < length - 2 * (length - nodes[nodes.size() - 2])) nodes.push_back(b);
    std::sort(nodes.begin(), nodes.end());
    std::vector<double> apart{nodes.front()};
    for (const double s : nodes)
      if (s - apart.back() > 1e-9 * length) apart.push_back(s);
    first_ = apart[1], last_ = length - apart[apart.size() - 2];
    knot_.assign(apart.begin() + 1, apart.end() - 1);
    const double r0 = 1.5 * first_ / (knot_[1] - knot_[0]);
    const double r1 = 1.5 * last_ / (knot_.back() - knot_[knot_.size() - 2]);
    front_ = r0 / (1 + r0), back_ = r1 / (1 + r1);
    make_places();
  }
  void make_places() {
    places_.clear();
    for (std::size_t i = 0; i < intervals(); ++i)
      for (std::size_t p = 0; p < kPlaces; ++p) {
        const double x = std::clamp(double(p) / double(kPlaces - 1), 1e-6, 1 - 1e-6);
        look(knot_[i] + x * (knot_[i + 1] - knot_[i]));
        places_.push_back(place(i, x));
      }
    ends_[0] = end_ceiling(0, first_), ends_[1] = end_ceiling(1, last_);
  }
  Place place(std::size_t i, double x) const {
    Place out{i, value(i, x), std::numeric_limits<double>::infinity(), {}};
    const std::array<double, 3>&b = out.b, up = slope(i, x), bent = bend(i);
    for (std::size_t j = 0; j < n_; ++j) {
      const trajectory::MotionLimits& l = limits_[j];
      const double v = d_[1][j] > 0 ? l.max_velocity / d_[1][j] : l.min_velocity / d_[1][j];
      out.ceiling = std::min(out.ceiling, v * v);
      Row a{{}, l.min_acceleration, l.max_acceleration, false}, u{{}, -l.max_jerk, l.max_jerk, true};
      for (std::size_t k = 0; k < 3; ++k) {
        a.k[k] = d_[1][j] * up[k] / 2 + d_[2][j] * b[k];
        u.k[k] = d_[1][j] * bent[k] / 2 + 1.5 * d_[2][j] * up[k] + d_[3][j] * b[k];
      }
      out.rows.push_back(a), out.rows.push_back(u);
    }
    return out;
  }
  /// The highest b at the end of the constant-jerk way from rest.
  double end_ceiling(int end, double way) {
    double most = std::numeric_limits<double>::infinity();
    const double sign = end == 0 ? 1 : -1;
    for (int k = 0; k <= 40; ++k) {
      const double x = k / 40.0, s = way * x * x * x;
      look(end == 0 ? s : path_.length() - s);
      for (std::size_t j = 0; j < n_; ++j) {
        const trajectory::MotionLimits& l = limits_[j];
        const double v = d_[1][j] * x * x;
        const double a = sign * d_[1][j] * x / (1.5 * way) + d_[2][j] * x * x * x * x;
        const double u =
            d_[1][j] / (4.5 * way * way) + sign * 2 * d_[2][j] * x * x * x / way + d_[3][j] * std::pow(x, 6);
        if (v != 0)
          most = std::min(most, std::pow(std::min(std::abs(l.min_velocity), l.max_velocity) / v, 2));
        most = std::min(most, a > 0 ? l.max_acceleration / a : l.min_acceleration / std::min(a, -1e-300));
        most = std::min(most, std::pow(l.max_jerk / std::max(std::abs(u), 1e-300), 2.0 / 3));
      }
    }
    return most;
  }

  void tie(std::vector<double>& c) const {
    c.front() = front_ * c[1];
    c.back() = back_ * c[c.size() - 2];
  }
  double time_of(const std::vector<double>& c) const {
    const auto root = [](double b) {
      return b > 0 ? std::sqrt(b) : 0.0;  // zero speed: the duration is infinite
    };
    double sum = 3 * first_ / root(c.front()) + 3 * last_ / root(c.back());
    for (std::size_t i = 0; i < intervals(); ++i)
      for (std::size_t q = 0; q < kQuadrature; ++q)
        sum += kWeight[q] * (knot_[i + 1] - knot_[i]) / root(dot(quadrature_[i * kQuadrature + q], c, i));
    return sum;
  }
  double time() const { return time_of(c_); }

  /// The barrier function: infinite outside the rows. `weight`: of the time.
  double barrier(const std::vector<double>& c, double weight) const {
    constexpr double kOut = std::numeric_limits<double>::infinity();
    double sum = weight * time_of(c);
    if (!std::isfinite(sum)) return kOut;
    const auto slack = [&](double x) {
      if (!(x > 0)) return false;
      sum -= std::log(x);
      return true;
    };
    if (!slack(1 - c.front() / ends_[0]) || !slack(1 - c.back() / ends_[1])) return kOut;
    for (const Place& p : places_) {
      const double b = dot(p.b, c, p.interval), root = b > 0 ? 1 / std::sqrt(b) : 0;
      if (!(b > 0) || !slack(1 - b / p.ceiling)) return kOut;
      for (const Row& r : p.rows) {
        const double v = dot(r.k, c, p.interval), by = r.jerk ? root : 1;
        if (!slack((r.high * by - v) / r.high) || !slack((v - r.low * by) / -r.low)) return kOut;
      }
    }
    return sum;
  }

  /// Gradient and Hessian (five diagonals, without its non-convex part) of the free coefficients.
  void derivatives(double weight) {
    for (auto* v : {&g_, &h0_, &h1_, &h2_}) v->assign(c_.size(), 0.0);
    const auto add = [&](std::size_t i, const std::array<double, 3>& k, double slope, double curve) {
      for (std::size_t a = 0; a < 3; ++a) g_[i + a] += slope * k[a], h0_[i + a] += curve * k[a] * k[a];
      h1_[i] += curve * k[0] * k[1], h1_[i + 1] += curve * k[1] * k[2], h2_[i] += curve * k[0] * k[2];
    };
    const auto one = [&](std::size_t at, double slope, double curve) { g_[at] += slope, h0_[at] += curve; };
    const auto end = [&](std::size_t at, double way, double ceiling) {
      const double b = c_[at], left = ceiling - b;
      one(at, -1.5 * weight * way / (b * std::sqrt(b)) + 1 / left,
          2.25 * weight * way / (b * b * std::sqrt(b)) + 1 / (left * left));
    };
    end(0, first_, ends_[0]), end(c_.size() - 1, last_, ends_[1]);
    for (std::size_t i = 0; i < intervals(); ++i)
      for (std::size_t q = 0; q < kQuadrature; ++q) {
        const auto& k = quadrature_[i * kQuadrature + q];
        const double b = dot(k, c_, i), w = weight * kWeight[q] * (knot_[i + 1] - knot_[i]);
        add(i, k, -0.5 * w / (b * std::sqrt(b)), 0.75 * w / (b * b * std::sqrt(b)));
      }
    for (const Place& p : places_) {
      const double b = dot(p.b, c_, p.interval), root = 1 / std::sqrt(b), fall = -0.5 * root / b;
      add(p.interval, p.b, 1 / (p.ceiling - b), 1 / ((p.ceiling - b) * (p.ceiling - b)));
      for (const Row& r : p.rows) {
        const double v = dot(r.k, c_, p.interval), by = r.jerk ? root : 1;
        for (const double limit : {r.high, r.low}) {
          const double sign = limit > 0 ? 1 : -1, left = sign * (limit * by - v);
          std::array<double, 3> k;  // gradient of -left
          for (std::size_t a = 0; a < 3; ++a) k[a] = sign * (r.k[a] - (r.jerk ? limit * fall * p.b[a] : 0));
          add(p.interval, k, 1 / left, 1 / (left * left));
        }
      }
    }
    fold();
  }
  /// Eliminates the end coefficients, which follow their neighbours.
  void fold() {
    const std::size_t n = c_.size();
    g_[1] += front_ * g_[0];
    h0_[1] += 2 * front_ * h1_[0] + front_ * front_ * h0_[0], h1_[1] += front_ * h2_[0];
    g_[n - 2] += back_ * g_[n - 1];
    h0_[n - 2] += 2 * back_ * h1_[n - 2] + back_ * back_ * h0_[n - 1], h1_[n - 3] += back_ * h2_[n - 3];
  }
  /// Solves H x = -g for the free coefficients by LDLᵀ.
  std::vector<double> newton() {
    const std::size_t n = c_.size(), last = n - 2;
    std::vector<double> x(n, 0.0), d = h0_, l1 = h1_, l2 = h2_;
    for (std::size_t i = 1; i <= last; ++i) x[i] = -g_[i];
    for (std::size_t i = 1; i <= last; ++i) {
      d[i] *= 1 + 1e-12;
      const double a = i + 1 <= last ? l1[i] / d[i] : 0, b = i + 2 <= last ? l2[i] / d[i] : 0;
      if (i + 1 <= last) d[i + 1] -= a * l1[i], x[i + 1] -= a * x[i];
      if (i + 2 <= last) l1[i + 1] -= a * l2[i], d[i + 2] -= b * l2[i], x[i + 2] -= b * x[i];
      l1[i] = a, l2[i] = b;
    }
    for (std::size_t i = last; i >= 1; --i) {
      x[i] /= d[i];
      if (i + 1 <= last) x[i] -= l1[i] * x[i + 1];
      if (i + 2 <= last) x[i] -= l2[i] * x[i + 2];
    }
    x.front() = front_ * x[1], x.back() = back_ * x[n - 2];
    return x;
  }

  void solve() {
    quadrature_.clear();
    for (std::size_t i = 0; i < intervals(); ++i)
      for (const double x : kAbscissa) quadrature_.push_back(value(i, x));
    begin();
    std::size_t count = 2;
    for (const Place& p : places_) count += 1 + 2 * p.rows.size();
    double weight = double(count) / time();
    const double end = double(count) / (o_.precision * time() * 0.5);
    for (;; weight = std::min(weight * 4, end)) {
      for (int step = 0; step < 60; ++step)
        if (!go(weight)) break;
      if (weight >= end) break;
    }
  }
  /// Sets b for a motion from rest to rest that is slow enough for all rows.
  void begin() {
    const std::size_t n = knot_.size() + 1;
    c_.assign(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      const double s = i == 0       ? knot_[0]
                       : i == n - 1 ? knot_.back()
                                    : (knot_[i - 1] + knot_[std::min(i, n - 2)]) / 2;
      c_[i] = std::pow(s * (path_.length() - s), 4.0 / 3);
    }
    tie(c_);
    while (!std::isfinite(barrier(c_, 0)))
      for (double& x : c_) x *= 0.25;
  }
  bool go(double weight) {
    derivatives(weight);
    const std::vector<double> x = newton();
    double fall = 0;
    for (std::size_t i = 1; i + 1 < c_.size(); ++i) fall -= g_[i] * x[i];
    if (!(fall > 1e-2)) return false;
    const double now = barrier(c_, weight);
    std::vector<double> next(c_.size());
    for (double t = 1; t > 1e-9; t /= 2) {
      for (std::size_t i = 0; i < c_.size(); ++i) next[i] = c_[i] + t * x[i];
      if (barrier(next, weight) <= now - 0.05 * t * fall) {
        c_ = next;
        return true;
      }
    }
    return false;
  }

  /// The factor of time that removes the excess of rows between the places.
  double stretch() {
    double most = 0;
    for (std::size_t i = 0; i < intervals(); ++i)
      for (int p = 0; p <= 40; ++p) {
        const double x = std::clamp(p / 40.0, 1e-6, 1 - 1e-6);
        look(knot_[i] + x * (knot_[i + 1] - knot_[i]));
        const double b = dot(value(i, x), c_, i), a = dot(slope(i, x), c_, i) / 2;
        const double speed = std::sqrt(b), u = dot(bend(i), c_, i) / 2 * speed;
        for (std::size_t j = 0; j < n_; ++j) {
          const trajectory::MotionLimits& l = limits_[j];
          const double v1 = d_[1][j] * speed, v2 = d_[1][j] * a + d_[2][j] * b;
          const double v3 = d_[1][j] * u + 3 * d_[2][j] * speed * a + d_[3][j] * b * speed;
          most = std::max({most, v1 / l.max_velocity, v1 / l.min_velocity,
                           std::sqrt(std::max(v2 / l.max_acceleration, v2 / l.min_acceleration)),
                           std::cbrt(std::abs(v3) / l.max_jerk)});
        }
      }
    return std::max(most, 1e-9);
  }

  /// Nodes with equal times between them.
  std::vector<double> even_in_time() const {
    std::vector<double> at{0, first_}, when{0, 3 * first_ / std::sqrt(c_.front())};
    for (std::size_t i = 0; i < intervals(); ++i) {
      double sum = 0;
      for (std::size_t q = 0; q < kQuadrature; ++q)
        sum +=
            kWeight[q] * (knot_[i + 1] - knot_[i]) / std::sqrt(dot(quadrature_[i * kQuadrature + q], c_, i));
      at.push_back(knot_[i + 1]), when.push_back(when.back() + sum);
    }
    const double rest = 3 * last_ / std::sqrt(c_.back()), total = when.back() + rest;
    std::vector<double> out;
    for (std::size_t k = 0; k <= o_.intervals; ++k) {
      const double t = total * double(k) / double(o_.intervals);
      if (t <= when[1]) {
        out.push_back(first_ * std::pow(t / when[1], 3));
      } else if (t >= when.back()) {
        out.push_back(path_.length() - last_ * std::pow((total - t) / rest, 3));
      } else {
        const auto i = std::size_t(std::upper_bound(when.begin(), when.end(), t) - when.begin());
        out.push_back(at[i - 1] + (at[i] - at[i - 1]) * (t - when[i - 1]) / (when[i] - when[i - 1]));
      }
    }
    out.front() = 0, out.back() = path_.length();
    return out;
  }

  // Gauss-Legendre quadrature with four points.
  static constexpr std::array<double, kQuadrature> kAbscissa = {0.06943184420297371, 0.33000947820757187,
                                                                0.66999052179242813, 0.93056815579702629};
  static constexpr std::array<double, kQuadrature> kWeight = {0.17392742256872693, 0.32607257743127307,
                                                              0.32607257743127307, 0.17392742256872693};

  const paths::Path& path_;
  std::vector<trajectory::MotionLimits> limits_;
  SlowOptions o_;
  std::size_t n_;
  std::array<std::vector<double>, 4> d_;
  std::vector<double> knot_, c_;
  double first_ = 0, last_ = 0, front_ = 0, back_ = 0;
  std::array<double, 2> ends_{};
  std::vector<Place> places_;
  std::vector<std::array<double, 3>> quadrature_;
  std::vector<double> g_, h0_, h1_, h2_;
};

}  // namespace polyarm::test
