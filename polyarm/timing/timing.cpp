#include "polyarm/timing/timing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "polyarm/paths/joined_path.hpp"
#include "polyarm/timing/check.hpp"
#include "polyarm/timing/grid.hpp"
#include "polyarm/timing/jerk_pieces.hpp"
#include "polyarm/timing/problem.hpp"
#include "polyarm/timing/rows.hpp"
#include "polyarm/timing/solver.hpp"

namespace polyarm::timing {
namespace {

// Excess that stretching the time removes; more is accepted with each round. It is smaller with norms,
// because their speeds may be stated by the user.
constexpr double kEnough = 1e-4, kEnoughOfNorms = 2e-5;
constexpr double kHalve = 0.03;  // excess above which a piece is halved instead of slowed down
constexpr std::size_t kFinalSamples = 60, kCloseSamples = 32;  // of each piece
constexpr double kUnsure = 3e-5;          // of a limit: a place with a larger uncertainty is checked again
constexpr double kUneven = 0.3;           // ratio of the squared speeds at the ends of a piece
constexpr double kFailed = 1.05;          // stretch above which another first guess is worth its time
constexpr double kFailedStretch = 1.005;  // the same for stretches between stops, which are short
// Iterations times nodes above which another guess is not worth its time, unless the motion is unusable
// (kHopeless).
constexpr double kDear = 3e4, kHopeless = 2;
constexpr int kTightenings = 12;     // rounds of solving and tightening
constexpr double kPrecision = 0.04;  // of the solver; the duration is then within a fiftieth of this value
constexpr double kMargin = 3e-7;     // distance from limits at the end, for rounding and peaks between
                                     // samples

void check_request(const paths::Path& path, std::span<const trajectory::MotionLimits> limits,
                   const TimingOptions& o) {
  if (limits.size() != path.joints())
    throw Error("wrong-size", "limits for " + std::to_string(limits.size()) + " joints, the path has " +
                                  std::to_string(path.joints()));
  if (!(path.length() > 0) || !std::isfinite(path.length()))
    throw Error("bad-path", "the path's length is " + std::to_string(path.length()), "it must be above zero");
  for (std::size_t j = 0; j < limits.size(); ++j) {
    const trajectory::MotionLimits& l = limits[j];
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

[[noreturn]] void too_fast(const PathRows& rows, const Check& check, const TimingOptions& o) {
  const Ratios& r = check.worst_ratio;
  throw Error(
      "path-too-fast",
      "starting at path speed " + std::to_string(o.start_speed) + " and ending at " +
          std::to_string(o.end_speed) + " leaves " + rows.name(r.row[check.worst_kind]) + " " +
          std::to_string(r.value[check.worst_kind]) + " times its " + name(LimitKind(check.worst_kind)) +
          " limit at s = " + std::to_string(check.worst.s),
      "lower the speed there by " + std::to_string(check.stretch) + " or the other end's, or move further");
}

class Timer {
 public:
  /// `may_stop`: if no guess gives a sound motion, a motion that stops on the way is accepted.
  Timer(const paths::Path& path, std::span<const trajectory::MotionLimits> limits,
        const TimingOptions& options, bool may_stop = true)
      : o_(options), rows_(path, limits, options.norms), limits_(limits), may_stop_(may_stop) {}

  Timing run() {
    if (straight()) {
      checker_.look(timing_.profile, kFinalSamples, check_);
      return finish(1);
    }
    first_guess({});
    double factor = 1;
    for (int tries = 0;; ++tries) {
      solve(factor);
      if (o_.start_speed <= 0 && o_.end_speed <= 0) {
        guess_again();
        Timing out = finish(check_.stretch * (1 + kMargin));
        if (!(stopping_.duration() < out.profile.duration())) return out;
        stopping_.timing.iterations += out.iterations;
        return std::move(stopping_.timing);
      }
      if (check_.stretch <= factor * (1 + 0.9 * kMargin)) return finish(factor);
      if (tries == 6 || check_.stretch > 3 * factor) too_fast(rows_, check_, o_);
      factor = std::max(factor, check_.stretch) * (1 + 1e-4 * (1 << tries));
    }
  }

 private:
  /// Tries other guesses while they are worth their time. Keeps the best result.
  void guess_again() {
    if (check_.stretch > kFailed && may_stop_) stop_at_slow_places();
    const bool known = std::isfinite(stopping_.duration());
    const Guess others[] = {{.slow_places = true},
                            {.rounded = false},
                            {.slow_places = true, .fineness = 2},
                            {.rounded = false, .slow_places = true, .fineness = 2},
                            {.slow_places = true, .fineness = 4},
                            {.rounded = false, .slow_places = true, .fineness = 4}};
    const double failed = may_stop_ ? kFailed : kFailedStretch;
    for (const Guess& guess : others) {
      const bool dear = double(timing_.iterations) * double(timing_.grid.size()) > kDear;
      if (check_.stretch <= failed || (dear && (known || check_.stretch < kHopeless))) return;
      const Check check = check_;
      Timing timing = timing_;
      first_guess(guess);
      solve(1);
      timing.iterations = timing_.iterations;
      if (timing_.profile.duration() * check_.stretch < timing.profile.duration() * check.stretch) continue;
      timing_ = std::move(timing), check_ = check;
    }
  }
  /// A motion that comes to rest on its way.
  struct Stopping {
    Timing timing;
    double duration() const {
      return timing.grid.empty() ? std::numeric_limits<double>::infinity() : timing.profile.duration();
    }
  };
  /// Stops at places that the path must pass very slowly anyway. Each stretch then goes from rest to rest.
  void stop_at_slow_places() {
    std::vector<double> places = slow_places(rows_);
    if (places.empty()) return;
    places.insert(places.begin(), 0), places.push_back(rows_.path().length());
    for (std::size_t i = 0; i + 1 < places.size(); ++i) add_stretch(places[i], places[i + 1]);
    Timing& all = stopping_.timing;
    Check check;
    checker_.look(all.profile, kFinalSamples, check);
    const double stretch = std::max(1.0, check.stretch * (1 + kMargin));
    all.profile.stretch(stretch);
    all.excess = std::max(0.0, check.excess(stretch));
  }
  void add_stretch(double from, double to) {
    const auto part = [&](const paths::Path& path) {
      paths::JoinedPath out(path.joints());
      out.append(std::shared_ptr<const paths::Path>(std::shared_ptr<const paths::Path>(), &path), from, to);
      return out;
    };
    TimingOptions options = o_;
    std::vector<NormLimit> norms(o_.norms.begin(), o_.norms.end());
    std::vector<paths::JoinedPath> paths;
    paths.reserve(norms.size());
    for (NormLimit& norm : norms) norm.path = &paths.emplace_back(part(*norm.path));
    options.norms = norms;
    const paths::JoinedPath path = part(rows_.path());
    const Timing timing = Timer(path, limits_, options, false).run();
    Timing& all = stopping_.timing;
    const auto pieces = timing.profile.pieces();
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const bool last = i + 1 == pieces.size();
      PathMotion end = last ? PathMotion{to - from, 0, 0, 0} : pieces[i + 1].motion;
      end.s += from;
      all.profile.append((last ? timing.profile.duration() : pieces[i + 1].begin) - pieces[i].begin,
                         pieces[i].motion.jerk, end);
    }
    for (ActiveLimit active : timing.active) {
      active.from += from, active.to += from;
      all.active.push_back(active);
    }
    for (const double s : timing.grid)
      if (all.grid.empty() || s > 0) all.grid.push_back(from + s);
    all.iterations += timing.iterations;
  }
  struct Guess {
    bool rounded = true, slow_places = false;
    double fineness = 1;
  };
  void first_guess(const Guess& guess) {
    TimingGrid grid = timing_grid(rows_, {o_.start_speed, o_.end_speed, guess.fineness * o_.fineness,
                                          guess.rounded, guess.slow_places});
    motion_.s = std::move(grid.s), motion_.b = std::move(grid.b);
    motion_.a.assign(motion_.s.size(), 0.0);
    for (std::size_t k = 1; k + 1 < motion_.s.size(); ++k)
      motion_.a[k] = (motion_.b[k + 1] - motion_.b[k - 1]) / (motion_.s[k + 1] - motion_.s[k - 1]) / 2;
  }
  /// Computes the motion on the grid, `factor` times faster than the result, its profile and its check.
  void solve(double factor) {
    motion_.b.front() = o_.start_speed * o_.start_speed * factor * factor;
    motion_.b.back() = o_.end_speed * o_.end_speed * factor * factor;
    PathRows rows = rows_;
    TimingProblem problem(rows, motion_.s);
    auto solver = std::make_unique<SpeedSolver>(problem.speeds(), motion_);
    Found best;
    const std::size_t most_nodes = 2 * motion_.s.size();
    for (int round = 0; round < kTightenings; ++round) {
      const SpeedSolution solution = solver->improve(std::min(kPrecision, kPrecision / o_.fineness),
                                                     round > 0 ? 2e-5 : 2e-3, round > 0 ? 25 : 150);
      timing_.iterations += solution.iterations;
      problem.look(motion_, solver->pieces(), use_);
      double stretch = stretch_of(use_);
      const bool sound = std::isfinite(stretch) && solver->pieces().sound();
      if (!sound) break;
      const double enough = 1 + (o_.norms.empty() ? kEnough : kEnoughOfNorms) * (1 + round);
      if (stretch < enough) {
        check_closely(profile_of(motion_, rows_.path().breaks()));
        stretch = stretch_of(use_);
      }
      const double duration = solver->pieces().duration() * stretch;
      if (duration < best.duration) best = {duration, motion_, use_};
      if (stretch < enough) break;
      if (!solution.converged && (stretch > 1.3 || round > 4)) break;
      halve_worst(problem, solver, most_nodes);
      problem.tighten(use_);
    }
    if (std::isfinite(best.duration)) {
      motion_ = std::move(best.motion), use_ = std::move(best.use);
      timing_.grid = motion_.s;
      timing_.profile = profile_of(motion_, rows_.path().breaks());
      check_closely(timing_.profile);
      sum_up();
      look_at_all();
    } else {
      timing_.grid = motion_.s;
      timing_.profile = plain_profile();
      checker_.look(timing_.profile, kCloseSamples, check_);
    }
  }
  struct Found {
    double duration = std::numeric_limits<double>::infinity();
    NodeMotion motion;
    std::vector<PieceUse> use;
  };
  /// Adds a node in each piece with a large excess.
  void halve_worst(TimingProblem& problem, std::unique_ptr<SpeedSolver>& solver, std::size_t most_nodes) {
    std::vector<char> halve(use_.size(), 0);
    for (std::size_t k = 1; k < use_.size(); ++k) halve[k] = use_[k].all() > 1 + kHalve;
    if (motion_.s.size() >= most_nodes || std::find(halve.begin(), halve.end(), 1) == halve.end()) return;
    motion_ = halved(motion_, solver->pieces(), halve);
    const PointOrigins origins = problem.refine(motion_.s, halve);
    auto finer = std::make_unique<SpeedSolver>(problem.speeds(), motion_, *solver, origins);
    solver = std::move(finer);
    std::vector<PieceUse> use(1);
    for (std::size_t k = 1; k < use_.size(); ++k)
      use.insert(use.end(), halve[k] ? 2 : 1, halve[k] ? PieceUse{} : use_[k]);
    use_ = std::move(use);
  }
  /// The fallback for any path: slowly from rest to rest with four jerks.
  SpeedProfile plain_profile() const {
    SpeedProfile out({0, o_.start_speed, 0, 0});
    for (const double sign : {1, -1, -1, 1}) out.append(1, sign * rows_.path().length() / 2);
    out.fit(rows_.path().length());
    return out;
  }
  /// The factor of time that brings a value of this kind to its limit.
  static double root(double value, std::size_t kind) {
    return kind == 0 ? value : kind == 1 ? std::sqrt(value) : std::cbrt(value);
  }
  static double stretch_of(const std::vector<PieceUse>& use) {
    double most[3] = {0, 0, 0};
    for (const PieceUse& u : use)
      for (std::size_t kind = 0; kind < 3; ++kind) {
        const double here = u.highest(kind);
        if (!(here <= most[kind])) most[kind] = here;
      }
    return std::max({most[0], root(most[1], 1), root(most[2], 2)});
  }
  /// Checks again where the uncertainty between places is larger than a stretch of time can correct, and
  /// assumes the worst case for the rest.
  void check_closely(const SpeedProfile& profile) {
    const double limit = stretch_of(use_), powers[3] = {limit, limit * limit, limit * limit * limit};
    std::vector<std::size_t> pieces;
    for (std::size_t k = 1; k < use_.size(); ++k) {
      bool unsure = false;
      for (std::size_t kind = 0; kind < 3; ++kind) {
        const bool more = use_[k].above[kind] > powers[kind];
        unsure = unsure || (more && use_[k].above[kind] > use_[k].highest(kind) + kUnsure);
      }
      // Places are evenly spaced in s. Where the speed changes much, that is far from even in time.
      const double b = motion_.b[k - 1], next = motion_.b[k];
      if (unsure || std::min(b, next) < kUneven * std::max(b, next)) pieces.push_back(k - 1);
    }
    Check close;
    checker_.look(profile, kCloseSamples, close, pieces);
    for (const std::size_t i : pieces) {
      use_[i + 1].most = close.use[i].most;
      for (std::size_t kind = 0; kind < 3; ++kind) use_[i + 1].above[kind] = use_[i + 1].highest(kind);
    }
    for (std::size_t k = 1; k < use_.size(); ++k)
      for (std::size_t kind = 0; kind < 3; ++kind) {
        double& most = use_[k].most[use_[k].most[1][kind] > use_[k].most[0][kind]][kind];
        if (use_[k].above[kind] > powers[kind]) most = std::max(most, use_[k].above[kind]);
      }
  }
  /// Summarises the use of all pieces.
  void sum_up() {
    check_ = {};
    for (std::size_t k = 1; k < use_.size(); ++k) {
      const PieceUse& u = use_[k];
      std::size_t nearest = 0;
      for (std::size_t kind = 0; kind < 3; ++kind) {
        const double here = u.highest(kind);
        if (here > u.highest(nearest)) nearest = kind;
        check_.peak[kind] = std::max(check_.peak[kind], here);
        if (!(root(here, kind) > check_.stretch)) continue;
        check_.stretch = root(here, kind), check_.worst_kind = kind, check_.worst.s = motion_.s[k - 1];
        check_.worst_ratio.row[kind] = u.row[kind], check_.worst_ratio.value[kind] = here;
      }
      const ActiveLimit active{motion_.s[k - 1], motion_.s[k], u.row[nearest], LimitKind(nearest)};
      if (!check_.active.empty() && check_.active.back().row == active.row &&
          check_.active.back().kind == active.kind)
        check_.active.back().to = active.to;
      else
        check_.active.push_back(active);
    }
  }
  /// A piece that begins within rounding of a break may have been evaluated on the wrong side of the break.
  /// The evaluation of every piece between its breaks is final.
  void look_at_all() {
    Check all;
    checker_.look(timing_.profile, kCloseSamples, all);
    if (all.stretch > check_.stretch) check_ = std::move(all);
  }
  Timing finish(double stretch) {
    timing_.profile.stretch(stretch);
    timing_.excess = std::max(0.0, check_.excess(stretch));
    timing_.active = std::move(check_.active);
    return std::move(timing_);
  }
  /// If the tangent of the path is constant, the fastest motion is that of a single axis. Returns false
  /// otherwise.
  bool straight() {
    const double length = rows_.path().length();
    std::vector<double> s;
    for (int i = 0; i <= 64; ++i) s.push_back(length * i / 64);
    for (const double b : rows_.path().breaks()) s.push_back(std::clamp(b + 1e-9 * length, 0.0, length));
    rows_.look(s);
    trajectory::MotionLimits l{1e12 * length, 1e18 * length, 1e24 * length, -1e12 * length, -1e18 * length};
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
      narrow(trajectory::MotionLimits::symmetric(norm.max_velocity, norm.max_acceleration, norm.max_jerk),
             std::sqrt(square), l);
    }
    trajectory::StateToState plan;
    const trajectory::MotionState from{0, o_.start_speed, 0}, to{length, o_.end_speed, 0};
    if (plan.plan({&from, 1}, {&to, 1}, {&l, 1}) != trajectory::MotionStatus::ok) return false;
    SpeedProfile profile({0, o_.start_speed, 0, 0});
    const trajectory::AxisMotion& axis = plan.axis(0);
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
  static void narrow(const trajectory::MotionLimits& row, double first, trajectory::MotionLimits& l) {
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
  std::span<const trajectory::MotionLimits> limits_;
  bool may_stop_;
  Stopping stopping_;
  Checker checker_{rows_};
  Check check_;
  Timing timing_;
  NodeMotion motion_;
  std::vector<PieceUse> use_;
};

}  // namespace

const char* name(LimitKind kind) noexcept {
  constexpr const char* kNames[] = {"velocity", "acceleration", "jerk"};
  return kNames[std::size_t(kind)];
}

Timing time_path(const paths::Path& path, std::span<const trajectory::MotionLimits> limits,
                 const TimingOptions& options) {
  check_request(path, limits, options);
  return Timer(path, limits, options).run();
}

TimedPath timed(std::shared_ptr<const paths::Path> path, std::span<const trajectory::MotionLimits> limits,
                const TimingOptions& options) {
  SpeedProfile profile = time_path(*path, limits, options).profile;
  return TimedPath(std::move(path), std::move(profile));
}

}  // namespace polyarm::timing
