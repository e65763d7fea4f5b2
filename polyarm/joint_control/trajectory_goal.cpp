#include "polyarm/joint_control/trajectory_goal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/trajectory/point_chunks.hpp"

namespace polyarm::controllers {

namespace {

using trajectory::TrajectoryPoint;

constexpr std::size_t kCount = trajectory::Trajectory::kCoefficients;
constexpr double kAtOnce = 1e-3;  // s, of a first point at time 0
constexpr std::size_t kMostProblems = 10;

class Maker {
 public:
  Maker(const TrajectoryMessage& message, const TrajectoryRules& rules, Nanoseconds now, bool action)
      : message_(message), rules_(rules), now_(now), goal_(std::make_unique<TrajectoryGoal>()) {
    goal_->action = action;
    goal_->bridged = true;
  }

  std::unique_ptr<TrajectoryGoal> make() {
    joints();
    points_ = message_.points;
    upsample();
    integrate();
    problems_.throw_if_errors();
    check();
    check_limits();
    if (goal_->action) check_tolerances();
    problems_.throw_if_errors();
    timing();
    pieces();
    if (goal_->action) tolerances();
    return std::move(goal_);
  }

 private:
  int find(const std::string& name) const {
    for (std::size_t j = 0; j < rules_.joints.size(); ++j)
      if (name == rules_.joints[j] || name == rules_.whole[j]) return static_cast<int>(j);
    return -1;
  }

  void joints() {
    if (message_.joints.empty())
      throw Error("no-joints", "the trajectory names no joints", "its joint_names must not be empty");
    std::vector<char> seen(rules_.joints.size(), 0);
    for (const std::string& name : message_.joints) {
      const int j = find(name);
      if (j < 0)
        problems_.error("unknown-joint", {},
                        "the trajectory names the joint '" + name + "', which this controller does not move" +
                            did_you_mean(name, rules_.joints));
      else if (std::exchange(seen[static_cast<std::size_t>(j)], 1))
        problems_.error("unknown-joint", {}, "the trajectory names the joint '" + name + "' twice");
      else
        goal_->joints.push_back(static_cast<std::uint32_t>(j));
    }
    std::vector<std::string> missing;
    for (std::size_t j = 0; j < seen.size(); ++j)
      if (!seen[j]) missing.push_back(rules_.joints[j]);
    if (!missing.empty() && !rules_.partial)
      problems_.error("missing-joint", {}, "the trajectory leaves out " + join(missing, ", "),
                      "name all joints, or set allow_partial_joints_goal: true");
    problems_.throw_if_errors();
  }

  bool has(std::vector<double> TrajectoryPoint::*field) const {
    return std::any_of(points_.begin(), points_.end(),
                       [&](const TrajectoryPoint& p) { return !(p.*field).empty(); });
  }

  /// Points of positions alone that come in even steps from a policy: a smooth curve through all of them.
  void upsample() {
    if (rules_.upsampling <= 0 || goal_->action || points_.size() < 2 || has(&TrajectoryPoint::velocities))
      return;
    trajectory::upsample_positions(points_, rules_.upsampling);
  }

  void integrate() {
    if (has(&TrajectoryPoint::positions) || points_.empty()) return;
    if (!rules_.integrate) {
      problems_.error("no-positions", {}, "the trajectory has no positions",
                      "give positions, or set allow_integration_in_goal_trajectories: true");
      return;
    }
    trajectory::integrate_points(points_, message_.joints.size());
    goal_->relative = true;
  }

  void check() {
    trajectory::SplineOptions options;
    options.allow_nonzero_velocity_at_end = rules_.nonzero_end;
    TrajectoryPoint start;
    start.positions.assign(message_.joints.size(), 0.0);
    for (const Problem& problem : trajectory::check_points(start, points_, options)) problems_.add(problem);
    if (has(&TrajectoryPoint::effort) && !rules_.effort)
      problems_.error("no-effort", {},
                      "the trajectory has effort values, but the controller commands no effort",
                      "leave them out, or add effort to command_interfaces");
  }

  /// Of what was sent, before it is made smooth; where points have no positions, of where they lead.
  void check_limits() {
    if (!rules_.limits) return;
    const auto& points = goal_->relative ? points_ : message_.points;
    for (std::size_t i = 0; i < points.size() && problems_.list().size() < kMostProblems; ++i) {
      const TrajectoryPoint& p = points[i];
      const std::string at = " at point " + std::to_string(i + 1);
      const auto check = [&](Asked kind, const std::vector<double>& values) {
        for (std::size_t k = 0; k < std::min(values.size(), goal_->joints.size()); ++k) {
          const std::size_t j = goal_->joints[k];
          double shift = goal_->relative && kind == Asked::position ? rules_.limits->position(j) : 0;
          if (!std::isfinite(shift)) shift = 0;
          rules_.limits->check(problems_, j, kind, values[k] + shift, at);
        }
      };
      check(Asked::position, p.positions);
      check(Asked::velocity, p.velocities);
      check(Asked::acceleration, p.accelerations);
      check(Asked::effort, p.effort);
    }
  }

  void check_tolerances() {
    const auto check = [&](const std::string& of, double value) {
      if (!std::isfinite(value))
        problems_.error("not-a-number", {}, "the " + of + " is not a finite number",
                        "-1 switches a check off");
    };
    for (const auto& [list, name] :
         {std::pair{&message_.path_tolerance, "path"}, {&message_.goal_tolerance, "goal"}})
      for (const JointTolerance& t : *list)
        for (const double value : {t.position, t.velocity, t.acceleration})
          check(std::string(name) + " tolerance of '" + t.joint + "'", value);
    check("tolerance of the goal's time", message_.goal_time_tolerance.value_or(0));
  }

  void timing() {
    if (!message_.start) return;
    const Nanoseconds start = *message_.start;
    const double last = points_.back().time_from_start;
    if (start + nanoseconds(last) < now_)
      throw Error("in-the-past",
                  "the trajectory ended " + format_number(seconds(now_ - start) - last) + " s ago",
                  "its header.stamp is in cell time; 0 means now");
    goal_->start = start;
    if (start >= now_) return;
    // It has begun already: what lies behind is passed over, the bridge leads to the next point.
    const double into = seconds(now_ - start);
    std::erase_if(points_, [&](const TrajectoryPoint& p) { return p.time_from_start <= into; });
    for (TrajectoryPoint& p : points_) p.time_from_start -= into;
    goal_->start = -1;
  }

  /// Velocity with which the path leaves its first point, where the points have none.
  void leave() {
    goal_->leaving.assign(message_.joints.size(), 0.0);
    if (points_.size() < 2) return;
    const double dt = points_[1].time_from_start - points_[0].time_from_start;
    for (std::size_t k = 0; k < goal_->leaving.size(); ++k)
      goal_->leaving[k] = (points_[1].positions[k] - points_[0].positions[k]) / dt;
  }

  void pieces() {
    const std::size_t n = message_.joints.size();
    goal_->first = points_.front();
    if (goal_->first.time_from_start <= 0) goal_->first.time_from_start = kAtOnce;
    leave();
    goal_->trajectory = trajectory::Trajectory(n);
    goal_->trajectory.append(goal_->first.time_from_start, std::vector<double>(n * kCount, 0.0));
    trajectory::SplineOptions options;
    options.allow_nonzero_velocity_at_end = true;
    options.method =
        rules_.step ? trajectory::InterpolationMethod::none : trajectory::InterpolationMethod::splines;
    for (std::size_t i = 1; i < points_.size(); ++i) append(points_[i - 1], points_[i], options);
    if (rules_.step && points_.size() == 1) append_step_end();
    if (has(&TrajectoryPoint::effort)) efforts();
  }

  void append(const TrajectoryPoint& from, const TrajectoryPoint& to,
              const trajectory::SplineOptions& options) {
    const std::size_t n = message_.joints.size();
    const double duration = to.time_from_start - goal_->trajectory.duration();
    if (!(duration > 0)) return;
    std::vector<double> coefficients(n * kCount, 0.0);
    const bool steps = options.method == trajectory::InterpolationMethod::none;
    const int degree = from.velocities.empty() || to.velocities.empty()         ? 1
                       : from.accelerations.empty() || to.accelerations.empty() ? 3
                                                                                : 5;
    const auto at = [](const std::vector<double>& list, std::size_t k) {
      return list.empty() ? 0.0 : list[k];
    };
    for (std::size_t k = 0; k < n; ++k) {
      const trajectory::SplineEnd a{from.positions[k], at(from.velocities, k), at(from.accelerations, k)};
      const trajectory::SplineEnd b{to.positions[k], at(to.velocities, k), at(to.accelerations, k)};
      if (steps) {
        coefficients[k * kCount] = b.position;  // at once what the interval leads to
        continue;
      }
      const auto piece = trajectory::spline_piece(degree, a, b, duration);
      std::copy(piece.begin(), piece.end(), coefficients.begin() + static_cast<std::ptrdiff_t>(k * kCount));
    }
    goal_->trajectory.append(duration, coefficients);
  }

  /// Without interpolation the last point is a step at the very end.
  void append_step_end() {
    const std::size_t n = message_.joints.size();
    std::vector<double> coefficients(n * kCount, 0.0);
    for (std::size_t k = 0; k < n; ++k) coefficients[k * kCount] = points_.back().positions[k];
    goal_->trajectory.append(kAtOnce, coefficients);
  }

  void efforts() {
    const std::size_t n = message_.joints.size();
    goal_->effort = trajectory::Trajectory(n);
    std::vector<double> last(n, 0.0);
    double time = 0;
    for (const TrajectoryPoint& point : points_) {
      const std::vector<double>& to = point.effort.empty() ? last : point.effort;
      const double duration = std::max(point.time_from_start - time, 1e-9);
      std::vector<double> coefficients(n * kCount, 0.0);
      for (std::size_t k = 0; k < n; ++k) {
        const double from = time > 0 ? last[k] : to[k];
        coefficients[k * kCount] = from;
        coefficients[k * kCount + 1] = (to[k] - from) / duration;
      }
      goal_->effort.append(duration, coefficients);
      last = to;
      time = point.time_from_start;
    }
  }

  /// 0 takes the default, -1 switches off, anything else below zero or a joint that is not known makes all of
  /// them the defaults.
  bool merge(const std::vector<JointTolerance>& given, std::vector<Tolerances::Of>& out) const {
    const auto one = [](double value, double& into) {
      if (value > 0) into = value;
      if (value == -1) into = 0;
      return value >= 0 || value == -1;
    };
    for (const JointTolerance& t : given) {
      const int j = find(t.joint);
      if (j < 0) return false;
      Tolerances::Of& of = out[static_cast<std::size_t>(j)];
      if (!one(t.position, of.position) || !one(t.velocity, of.velocity) ||
          !one(t.acceleration, of.acceleration))
        return false;
    }
    return true;
  }

  void tolerances() {
    constexpr double kOwn = std::numeric_limits<double>::quiet_NaN();
    Tolerances& none = goal_->tolerances;
    none.path.assign(rules_.joints.size(), {kOwn, kOwn, kOwn});
    none.goal = none.path;
    none.goal_time = kOwn;
    Tolerances given = none;
    bool good = merge(message_.path_tolerance, given.path) && merge(message_.goal_tolerance, given.goal);
    if (message_.goal_time_tolerance) {
      const double t = *message_.goal_time_tolerance;
      if (t > 0) given.goal_time = t;
      if (t == -1) given.goal_time = 0;
      good = good && (t >= 0 || t == -1);
    }
    if (good) goal_->tolerances = std::move(given);
  }

  const TrajectoryMessage& message_;
  const TrajectoryRules& rules_;
  Nanoseconds now_;
  std::unique_ptr<TrajectoryGoal> goal_;
  std::vector<TrajectoryPoint> points_;
  Problems problems_;
};

}  // namespace

std::unique_ptr<TrajectoryGoal> make_goal(const TrajectoryMessage& message, const TrajectoryRules& rules,
                                          Nanoseconds now, bool action) {
  return Maker(message, rules, now, action).make();
}

}  // namespace polyarm::controllers
