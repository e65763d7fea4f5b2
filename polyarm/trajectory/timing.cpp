#include "polyarm/trajectory/timing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "polyarm/trajectory/timing_check.hpp"
#include "polyarm/trajectory/timing_grid.hpp"
#include "polyarm/trajectory/timing_rows.hpp"
#include "polyarm/trajectory/timing_solver.hpp"

namespace polyarm::trajectory {
namespace {

constexpr double kTooCoarse = 1.025;
constexpr double kEnough = 1.012;  // stretch of time that a round more would not be worth
constexpr std::size_t kSamples = 5, kFinalSamples = 12;  // of each piece
constexpr int kRounds = 9;                               // of solving and tightening
constexpr double kPrecision = 0.02;  // of the solver: the duration then differs by a tenth of that
constexpr double kMargin = 3e-7;     // to limits at the end, for rounding and peaks between samples

void check_request(const Path& path, std::span<const MotionLimits> limits, const TimingOptions& o) {
  if (limits.size() != path.joints())
    throw Error("wrong-size", "limits for " + std::to_string(limits.size()) + " joints, the path has " +
                                  std::to_string(path.joints()));
  if (!(path.length() > 0) || !std::isfinite(path.length()))
    throw Error("bad-path", "the path's length is " + std::to_string(path.length()), "it must be above zero");
  for (std::size_t j = 0; j < limits.size(); ++j) {
    const MotionLimits& l = limits[j];
    if (!(l.max_velocity > 0 && l.max_acceleration > 0 && l.max_jerk > 0 && l.min_velocity < 0 &&
          l.min_acceleration < 0))
      throw Error("bad-limit", "a limit of joint " + std::to_string(j + 1) + " is on the wrong side of zero");
  }
  for (const NormLimit& n : o.norms) {
    if (!(n.max_velocity > 0 && n.max_acceleration > 0 && n.max_jerk > 0))
      throw Error("bad-limit", "a limit of " + n.name + " is not above zero");
    if (std::abs(n.path->length() - path.length()) > 1e-9 * path.length())
      throw Error("wrong-size", "the rows of " + n.name + " have the length " +
                                    std::to_string(n.path->length()) + ", the path " +
                                    std::to_string(path.length()));
  }
  if (!(o.start_speed >= 0) || !(o.end_speed >= 0) || !(o.fineness > 0))
    throw Error("bad-limit", "a path speed is below zero or not a number");
}

/// The rows of a SpeedProblem from those of a path.
class Problem {
 public:
  Problem(PathRows& rows, const std::vector<double>& s) {
    problem.s = s;
    const std::size_t n = s.size() - 1;
    std::vector<double> middles(n);
    for (std::size_t k = 0; k < n; ++k) middles[k] = (s[k] + s[k + 1]) / 2;
    fill_nodes(rows, s);
    rows.look(middles);
    problem.acceleration.resize(rows.joints(), n);
    problem.norm_acceleration.resize(rows.rows() - rows.joints(), n);
    for (std::size_t k = 0; k < n; ++k) problem.acceleration.at[k] = problem.norm_acceleration.at[k] = k;
    for (std::size_t j = 0; j < rows.joints(); ++j) {
      const MotionLimits& l = rows.limits(j);
      const bool bounded = std::isfinite(l.max_acceleration);
      const double per = 1 / l.max_acceleration;
      problem.acceleration.low[j] = bounded ? l.min_acceleration * per : -1;
      for (std::size_t k = 0; k < n; ++k) {
        problem.acceleration.coefficient[0][j * n + k] = rows.first(j)[k] * per;
        problem.acceleration.coefficient[1][j * n + k] = rows.second(j)[k] * per;
      }
    }
    norms(rows, problem.norm_acceleration, [](const NormLimit& l) { return l.max_acceleration; }, {1, 1, 0});
  }

  SpeedProblem problem;

 private:
  void fill_nodes(PathRows& rows, const std::vector<double>& s) {
    std::vector<double> places = s;
    const std::size_t n = s.size();
    // The third derivative before each break.
    std::vector<std::size_t> at(n);
    for (std::size_t k = 0; k < n; ++k) at[k] = k;
    for (const double b : rows.path().breaks()) {
      const auto k = std::size_t(std::lower_bound(s.begin(), s.end(), b) - s.begin());
      if (k == 0 || k >= n || s[k] != b) continue;
      places.push_back(b - 1e-9 * (s[k] - s[k - 1])), at.push_back(k);
    }
    rows.look(places);
    problem.velocity.resize(1, n);
    for (std::size_t k = 0; k < n; ++k) {
      problem.velocity.coefficient[0][k] = 1 / velocity_ceiling(rows, k);
      problem.velocity.at[k] = k;
    }
    problem.velocity.low[0] = 0;
    const std::size_t points = places.size();
    problem.jerk.resize(rows.joints(), points), problem.norm_jerk.resize(rows.rows() - rows.joints(), points);
    problem.jerk.at = problem.norm_jerk.at = at;
    for (std::size_t j = 0; j < rows.joints(); ++j) {
      const double per = 1 / rows.limits(j).max_jerk;
      for (std::size_t i = 0; i < points; ++i) {
        problem.jerk.coefficient[0][j * points + i] = rows.first(j)[i] * per;
        problem.jerk.coefficient[1][j * points + i] = 3 * rows.second(j)[i] * per;
        problem.jerk.coefficient[2][j * points + i] = rows.third(j)[i] * per;
      }
    }
    norms(rows, problem.norm_jerk, [](const NormLimit& l) { return l.max_jerk; }, {1, 3, 1});
  }
  template <typename Limit>
  static void norms(const PathRows& rows, LimitRows& out, Limit limit, std::array<double, 3> factor) {
    if (out.rows == 0) return;
    const std::size_t from = rows.joints(), points = out.points;
    for (auto& c : out.component) c.resize((rows.components() - from) * points);
    for (std::size_t r = 0; r < out.rows; ++r) {
      const double per = 1 / limit(rows.norm(r));
      for (std::size_t c = rows.first_component(r); c < rows.first_component(r + 1); ++c)
        for (std::size_t i = 0; i < points; ++i) {
          out.component[0][(c - from) * points + i] = factor[0] * rows.first(c)[i] * per;
          out.component[1][(c - from) * points + i] = factor[1] * rows.second(c)[i] * per;
          out.component[2][(c - from) * points + i] = factor[2] * rows.third(c)[i] * per;
        }
      out.component_end.push_back(rows.first_component(r + 1) - from);
    }
  }
};

/// Pieces of constant jerk around the nodes: ṡ(t) is the quadratic spline with uniform-like knots midway in
/// time between nodes, whose control polygon has the corners (time of node, ṡ). It keeps the polygon's slopes
/// (accelerations), its end speeds, and stays above zero where the polygon does.
SpeedProfile profile_of(const std::vector<double>& s, const std::vector<double>& b) {
  const std::size_t last = s.size() - 1;
  std::vector<double> time(s.size()), speed(s.size());
  for (std::size_t k = 0; k <= last; ++k) speed[k] = std::sqrt(b[k]);
  for (std::size_t k = 1; k <= last; ++k) {
    const double step = 2 * (s[k] - s[k - 1]) / (speed[k] + speed[k - 1]);
    if (k == 1) time[0] = step / 2;
    time[k] = time[k - 1] + step;
  }
  std::vector<double> knot(s.size() + 1);
  for (std::size_t k = 1; k <= last; ++k) knot[k] = (time[k - 1] + time[k]) / 2;
  knot[last + 1] = time[last] + (time[last] - time[last - 1]) / 2;
  std::vector<double> control(s.size());
  for (std::size_t k = 0; k <= last; ++k) {
    const double at = (knot[k] + knot[k + 1]) / 2;
    const std::size_t to = at >= time[k] ? k + 1 : k;
    control[k] = to == 0 || to > last ? speed[k]
                                      : speed[to - 1] + (speed[to] - speed[to - 1]) * (at - time[to - 1]) /
                                                            (time[to] - time[to - 1]);
  }
  control.front() = speed.front(), control.back() = speed.back();
  // The spline's area is the way: each control point's basis function has the area (its support)/3.
  const double total = knot[last + 1];
  const auto straight = [&](std::size_t k) {
    const double at = (knot[k] + knot[k + 1]) / 2;
    return speed.front() + (speed.back() - speed.front()) * at / total;
  };
  const auto support = [&](std::size_t k) {
    return (knot[std::min(k + 2, last + 1)] - knot[k == 0 ? 0 : k - 1]) / 3;
  };
  double area = (speed.front() * knot[1] + speed.back() * (total - knot[last])) / 3;
  double base = area;
  for (std::size_t k = 0; k <= last; ++k) area += control[k] * support(k), base += straight(k) * support(k);
  if (std::abs(area - base) > 1e-9 * area) {
    const double factor = std::clamp((s[last] - base) / (area - base), 0.5, 2.0);
    for (std::size_t k = 1; k < last; ++k) control[k] = straight(k) + (control[k] - straight(k)) * factor;
  }
  SpeedProfile out({0, speed.front(), 0, 0});
  double acceleration = 0;
  for (std::size_t k = 0; k <= last; ++k) {
    const double duration = knot[k + 1] - knot[k];
    const double next = k == last ? 0 : (control[k + 1] - control[k]) / ((knot[k + 2] - knot[k]) / 2);
    out.append(duration, (next - acceleration) / duration);
    acceleration = next;
  }
  out.fit(s[last]);
  return out;
}

/// Jerk rows at the edges of pieces that exceed their limit there: nodes.size() flags per side.
class Edges {
 public:
  Edges(PathRows& rows, SpeedProblem& p) : rows_(rows), p_(p), known_(p.s.size(), 0) {
    p.edge_jerk.resize(rows.joints(), 0), p.norm_edge_jerk.resize(rows.rows() - rows.joints(), 0);
    std::size_t from = rows.joints();
    for (std::size_t n = 0; n < p.norm_edge_jerk.rows; ++n)
      p.norm_edge_jerk.component_end.push_back(rows.first_component(n + 1) - from);
  }
  /// The nodes in `wanted` that have none yet get both edges, and are struck from it.
  void add(std::vector<char>& wanted) {
    bool any = false;
    for (std::size_t k = 0; k < known_.size(); ++k) {
      const bool fresh = wanted[k] && !known_[k];
      wanted[k] = fresh, any |= fresh, known_[k] |= char(fresh);
    }
    if (!any) return;
    at_.clear(), side_.clear();
    std::vector<double> places;
    const auto edge = [&](std::size_t k, signed char side) {
      const std::size_t other = side < 0 ? k - 1 : k + 1;
      at_.push_back(k), side_.push_back(side), places.push_back((p_.s[k] + p_.s[other]) / 2);
    };
    for (std::size_t k = 0; k < known_.size(); ++k) {
      if (known_[k] && k > 0) edge(k, -1);
      if (known_[k] && k + 1 < known_.size()) edge(k, 1);
    }
    rows_.look(places);
    fill();
  }
  bool known(std::size_t node) const { return known_[node]; }

 private:
  void fill() {
    const std::size_t n = at_.size(), joints = rows_.joints();
    LimitRows &plain = p_.edge_jerk, &norm = p_.norm_edge_jerk;
    plain.resize(joints, n), norm.resize(norm.rows, n);
    plain.at = norm.at = at_, plain.side = norm.side = side_;
    for (auto& c : norm.component) c.assign((rows_.components() - joints) * n, 0.0);
    std::size_t row = 0;
    for (std::size_t c = 0; c < rows_.components(); ++c) {
      while (row + joints < rows_.rows() && c >= rows_.first_component(row + 1)) ++row;
      const double per = 1 / (c < joints ? rows_.limits(c).max_jerk : rows_.norm(row).max_jerk);
      auto& to = c < joints ? plain.coefficient : norm.component;
      const std::size_t from = (c < joints ? c : c - joints) * n;
      for (std::size_t i = 0; i < n; ++i) {
        to[0][from + i] = rows_.first(c)[i] * per;
        to[1][from + i] = 3 * rows_.second(c)[i] * per;
        to[2][from + i] = rows_.third(c)[i] * per;
      }
    }
  }

  PathRows& rows_;
  SpeedProblem& p_;
  std::vector<char> known_;
  std::vector<std::size_t> at_;
  std::vector<signed char> side_;
};

/// Watches what was above its limit more closely, or lowers its scale if that is done already; `slower`:
/// besides bounds the speed around jerks that stay too high, which always helps.
void tighten(const Check& check, const std::vector<double>& b, bool slower, SpeedProblem& p, Edges& edges) {
  const std::size_t nodes = p.s.size();
  auto most = check.most;  // [norm][kind], per node or interval
  for (auto& set : most)
    for (auto& list : set) list.resize(nodes, 1.0);
  std::vector<char> watch(nodes, 0);
  for (std::size_t k = 0; k < nodes; ++k) watch[k] = std::max(most[0][2][k], most[1][2][k]) > 1.02;
  edges.add(watch);
  for (std::size_t k = 0; k < nodes; ++k) {
    p.velocity.scale[k] /= most[0][0][k] * most[0][0][k];
    const double jerk = std::max(most[0][2][k], most[1][2][k]);
    if (watch[k] || slower) most[0][2][k] = most[1][2][k] = 1;
    if (!slower || jerk < 1.005) continue;
    const double less = std::pow(jerk, -2.0 / 3);
    for (std::size_t i = std::max<std::size_t>(k, 2) - 1; i <= std::min(k + 1, nodes - 2); ++i)
      p.velocity.scale[i] = std::min(p.velocity.scale[i], p.velocity.coefficient[0][i] * b[i] * less);
  }
  LimitRows* const rows[2][3] = {{&p.acceleration, &p.jerk, &p.edge_jerk},
                                 {&p.norm_acceleration, &p.norm_jerk, &p.norm_edge_jerk}};
  for (std::size_t norm = 0; norm < 2; ++norm)
    for (std::size_t i = 0; i < 3; ++i) {
      LimitRows& l = *rows[norm][i];
      for (std::size_t k = 0; k < l.points; ++k)
        l.scale[k] = std::max(l.scale[k] / std::min(most[norm][i == 0 ? 1 : 2][l.at[k]], 2.0), 1e-3);
    }
}

/// With every use as at `factor` times the time.
std::vector<ActiveLimit> active_limits(const Check& check, double length, double factor) {
  const double by[3] = {1 / factor, 1 / (factor * factor), 1 / (factor * factor * factor)};
  std::vector<ActiveLimit> out;
  for (const Check::Seen& seen : check.seen) {
    std::size_t kind = 0;
    double most = -1;
    for (std::size_t k = 0; k < 3; ++k)
      if (double(seen.use[k]) * by[k] > most) most = double(seen.use[k]) * by[k], kind = k;
    const ActiveLimit here{seen.s, length, seen.row[kind], LimitKind(kind)};
    if (!out.empty() && out.back().row == here.row && out.back().kind == here.kind) continue;
    if (!out.empty()) out.back().to = here.from;
    out.push_back(here);
    if (out.size() == 1) out.back().from = 0;
  }
  return out;
}

[[noreturn]] void too_fast(const PathRows& rows, const Check& check, const TimingOptions& o) {
  throw Error(
      "path-too-fast",
      "starting at path speed " + std::to_string(o.start_speed) + " and ending at " +
          std::to_string(o.end_speed) + " leaves " + rows.name(check.worst_row) + " " +
          std::to_string(check.worst_use) + " times its " + name(LimitKind(check.worst_kind)) +
          " limit at s = " + std::to_string(check.worst_s),
      "lower the speed there by " + std::to_string(check.stretch) + " or the other end's, or move further");
}

class Timer {
 public:
  Timer(const Path& path, std::span<const MotionLimits> limits, const TimingOptions& options)
      : o_(options), rows_(path, limits, options.norms) {}

  /// By how much the time of the last profile was stretched in the end.
  double stretch() const { return stretch_; }
  Timing run() {
    if (straight()) {
      checker_.look(timing_.profile, kFinalSamples, true, check_);
      return finish(1);
    }
    TimingGrid grid = timing_grid(rows_, o_.start_speed, o_.end_speed, o_.fineness);
    timing_.grid = grid.s, b_ = std::move(grid.b);
    Problem problem(rows_, timing_.grid);
    Edges edges(rows_, problem.problem);
    SpeedSolver solver(problem.problem, b_);
    double factor = 1;
    for (int tries = 0;; ++tries) {
      solve(problem.problem, edges, solver, factor);
      checker_.look(timing_.profile, kFinalSamples, true, check_);
      look_closely();
      if (o_.start_speed <= 0 && o_.end_speed <= 0) return finish(check_.stretch * (1 + kMargin));
      if (check_.stretch <= factor * (1 + 0.9 * kMargin)) return finish(factor);
      if (tries == 6) too_fast(rows_, check_, o_);
      factor = std::max(factor, check_.stretch) * (1 + 1e-4 * (1 << tries));
    }
  }

 private:
  /// Speeds on the grid, `factor` times faster than they will be, and the profile that belongs to them.
  void solve(SpeedProblem& problem, Edges& edges, SpeedSolver& solver, double factor) {
    b_.front() = o_.start_speed * o_.start_speed * factor * factor;
    b_.back() = o_.end_speed * o_.end_speed * factor * factor;
    const double precision = std::min(kPrecision, kPrecision / o_.fineness);
    double best = std::numeric_limits<double>::infinity();
    std::vector<double> safe = b_;
    for (int round = 0; round < kRounds; ++round) {
      timing_.iterations += solver.improve(precision, 60).iterations;
      SpeedProfile profile = profile_of(timing_.grid, b_);
      checker_.look(profile, kSamples, false, check_);
      const double duration = profile.duration() * check_.stretch;
      if (!std::isfinite(duration) || !(duration > 0)) {
        b_ = safe;
        break;
      }
      if (duration < best) best = duration, timing_.profile = std::move(profile), safe = b_;
      if (check_.stretch < kEnough) break;
      tighten(check_, b_, round >= 2, problem, edges);
    }
    if (!std::isfinite(best)) timing_.profile = profile_of(timing_.grid, b_);
  }
  /// Again, where the highest values may lie between samples.
  void look_closely() {
    std::vector<std::size_t> pieces;
    const double s = check_.stretch * 0.998, powers[3] = {s, s * s, s * s * s};
    for (const Check::Bent& b : check_.bent)
      if (b.peak > powers[b.kind] && (pieces.empty() || pieces.back() != b.piece)) pieces.push_back(b.piece);
    if (pieces.empty()) return;
    Check close;
    checker_.look(timing_.profile, 6 * kFinalSamples, false, close, pieces);
    check_.stretch = std::max(check_.stretch, close.stretch);
    for (std::size_t kind = 0; kind < 3; ++kind)
      check_.peak[kind] = std::max(check_.peak[kind], close.peak[kind]);
  }
  Timing finish(double stretch) {
    stretch_ = stretch;
    timing_.profile.stretch(stretch);
    timing_.excess = std::max(0.0, check_.excess(stretch));
    timing_.active = active_limits(check_, rows_.path().length(), stretch);
    return std::move(timing_);
  }
  /// A path whose tangent does not change has the motion of one axis as its fastest.
  bool straight() {
    const double length = rows_.path().length();
    std::vector<double> s;
    for (int i = 0; i <= 64; ++i) s.push_back(length * i / 64);
    for (const double b : rows_.path().breaks()) s.push_back(std::clamp(b + 1e-9 * length, 0.0, length));
    rows_.look(s);
    MotionLimits l{1e12 * length, 1e18 * length, 1e24 * length, -1e12 * length, -1e18 * length};
    for (std::size_t c = 0; c < rows_.components(); ++c) {
      const double first = rows_.first(c)[0];
      for (std::size_t i = 0; i < s.size(); ++i)
        if (std::abs(rows_.first(c)[i] - first) > 1e-12 * std::abs(first) ||
            std::abs(rows_.second(c)[i]) * length > 1e-10 * std::abs(first) ||
            std::abs(rows_.third(c)[i]) * length * length > 1e-10 * std::abs(first))
          return false;
    }
    for (std::size_t j = 0; j < rows_.joints(); ++j) narrow(rows_.limits(j), rows_.first(j)[0], l);
    for (std::size_t n = 0; n + rows_.joints() < rows_.rows(); ++n) {
      double square = 0;
      for (std::size_t c = rows_.first_component(n); c < rows_.first_component(n + 1); ++c)
        square += rows_.first(c)[0] * rows_.first(c)[0];
      const NormLimit& norm = rows_.norm(n);
      narrow(MotionLimits::symmetric(norm.max_velocity, norm.max_acceleration, norm.max_jerk),
             std::sqrt(square), l);
    }
    StateToState plan;
    const MotionState from{0, o_.start_speed, 0}, to{length, o_.end_speed, 0};
    if (plan.plan({&from, 1}, {&to, 1}, {&l, 1}) != MotionStatus::ok) return false;
    SpeedProfile profile({0, o_.start_speed, 0, 0});
    const AxisMotion& axis = plan.axis(0);
    for (std::size_t i = 0; i < axis.pieces(); ++i) {
      const double end = i + 1 < axis.pieces() ? axis.begin_of(i + 1) : axis.duration();
      profile.append(end - axis.begin_of(i), axis.jerk_of(i));
    }
    for (const SpeedProfile::Piece& p : profile.pieces())
      if (p.motion.speed < -1e-9 * l.max_velocity || p.motion.s > length * (1 + 1e-9)) return false;
    timing_.grid = {0, length};
    timing_.profile = std::move(profile);
    return true;
  }
  static void narrow(const MotionLimits& row, double first, MotionLimits& l) {
    if (first == 0) return;
    const bool back = first < 0;
    const double size = std::abs(first);
    l.max_velocity = std::min(l.max_velocity, (back ? -row.min_velocity : row.max_velocity) / size);
    l.max_acceleration =
        std::min(l.max_acceleration, (back ? -row.min_acceleration : row.max_acceleration) / size);
    l.min_acceleration =
        std::max(l.min_acceleration, (back ? -row.max_acceleration : row.min_acceleration) / size);
    l.max_jerk = std::min(l.max_jerk, row.max_jerk / size);
    l.min_velocity = -l.max_velocity;
  }

  const TimingOptions& o_;
  PathRows rows_;
  Checker checker_{rows_};
  Check check_;
  Timing timing_;
  double stretch_ = 1;
  std::vector<double> b_;
};

}  // namespace

const char* name(LimitKind kind) noexcept {
  constexpr const char* kNames[] = {"velocity", "acceleration", "jerk"};
  return kNames[std::size_t(kind)];
}

Timing time_path(const Path& path, std::span<const MotionLimits> limits, const TimingOptions& options) {
  check_request(path, limits, options);
  Timer timer(path, limits, options);
  Timing out = timer.run();
  // Where the grid was too coarse for tight curves, much of the time is stretch: again on a finer one.
  TimingOptions finer = options;
  for (double stretch = timer.stretch(); stretch > kTooCoarse && finer.fineness < 4 * options.fineness;) {
    finer.fineness *= 2;
    Timer again(path, limits, finer);
    Timing other = again.run();
    stretch = again.stretch(), other.iterations += out.iterations;
    if (other.profile.duration() < out.profile.duration()) out = std::move(other);
  }
  return out;
}

TimedPath timed(std::shared_ptr<const Path> path, std::span<const MotionLimits> limits,
                const TimingOptions& options) {
  SpeedProfile profile = time_path(*path, limits, options).profile;
  return TimedPath(std::move(path), std::move(profile));
}

}  // namespace polyarm::trajectory
