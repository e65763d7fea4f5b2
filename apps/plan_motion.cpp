#include "apps/plan_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/moves/tcp_rates.hpp"

namespace polyarm::apps {

using timing::TimedPath;
using trajectory::Trajectory;

namespace {

constexpr std::size_t kExtremeSamples = 4000;  // samples of a motion to find its extremes
constexpr double kRounding = 1e-3;             // rounding of numbers and times in files

std::span<double> part(PlanState& state, std::size_t quantity) {
  return state.value[quantity];
}

/// Fills in the TCP's position and speed.
void with_tcp(const moves::TcpRates& rates, PlanState& state) {
  const auto& v = state.value;
  const paths::PoseDerivatives tcp = rates.at(v[0], v[1], v[2], v[3]);
  state.tcp = tcp.pose.position;
  state.tcp_speed = norm(tcp.linear[0]);
}

}  // namespace

std::string unit_of(const PlanJoint& joint, std::size_t quantity) {
  static constexpr const char* kPer[] = {"", "/s", "/s²", "/s³"};
  return std::string(joint.slides ? "m" : "rad") + kPer[quantity];
}

bool PlannedMotion::has_errors() const {
  return std::any_of(problems.begin(), problems.end(),
                     [](const Problem& p) { return p.severity == Severity::error; });
}

void add_section(PlannedMotion& motion, std::string name, std::shared_ptr<const TimedPath> timed,
                 const std::vector<timing::ActiveLimit>& active, const std::vector<std::string>& bounds) {
  const double begin = motion.duration;
  const std::size_t joints = motion.joints.size();
  std::vector<std::size_t> rows;
  for (const std::string& bound : bounds) {
    const auto same = std::find(motion.bounds.begin(), motion.bounds.end(), bound);
    rows.push_back(joints + std::size_t(same - motion.bounds.begin()));
    if (same == motion.bounds.end()) motion.bounds.push_back(bound);
  }
  for (const timing::ActiveLimit& a : active)
    motion.bands.push_back({begin + timed->profile().time_at(a.from), begin + timed->profile().time_at(a.to),
                            a.row < joints ? a.row : rows[a.row - joints], a.kind});
  motion.duration += timed->duration();
  motion.sections.push_back({std::move(name), begin, motion.duration});
  motion.timed.push_back(std::move(timed));
}

namespace {

/// Adds a sentence for each joint that leaves its limits.
void check_positions(PlannedMotion& motion) {
  const std::vector<PlanPeaks> peaks = peaks_of(motion, nullptr);
  for (std::size_t j = 0; j < peaks.size(); ++j) {
    const PlanJoint& joint = motion.joints[j];
    const double reached = peaks[j].low[0] < joint.lower - 1e-6 ? peaks[j].low[0] : peaks[j].high[0];
    if (reached >= joint.lower - 1e-6 && reached <= joint.upper + 1e-6) continue;
    motion.problems.push_back({"limit",
                               {},
                               fmt::format("{} goes to {:.4f} {}, its limits are {:.4f} and {:.4f}",
                                           joint.name, reached, unit_of(joint, 0), joint.lower, joint.upper),
                               "move the points away from the limit, or go straight between them"});
  }
}

}  // namespace

void finish(PlannedMotion& motion, const kinematics::Chain& chain) {
  motion.at = [rates = moves::TcpRates(chain), timed = motion.timed, sections = motion.sections,
               hint = std::size_t(0)](double t, PlanState& state) mutable {
    std::size_t i = 0;
    while (i + 1 < sections.size() && t >= sections[i].end) ++i;
    timed[i]->sample(t - sections[i].begin, part(state, 0), part(state, 1), part(state, 2), part(state, 3),
                     hint);
    with_tcp(rates, state);
  };
  check_positions(motion);
}

namespace {

/// Checks a trajectory that has times of its own.
class TimeCheck {
 public:
  TimeCheck(PlannedMotion& motion, const std::vector<double>& points) : motion_(motion), points_(points) {}

  void judge(const std::vector<trajectory::JointUse>& uses) {
    const double factor = trajectory::stretch_needed(uses);
    for (std::size_t j = 0; j < uses.size(); ++j) {
      const trajectory::JointUse& u = uses[j];
      beyond(j, 1, u.velocity, u.velocity_use, factor);
      beyond(j, 2, u.acceleration, u.acceleration_use, factor);
      beyond(j, 3, u.jerk, u.jerk_use, factor);
    }
    steps(uses, 1, &trajectory::JointUse::velocity_step, &trajectory::JointUse::velocity_steps,
          "no acceleration does that: give velocities at every point, or plan without --keep-times");
    steps(uses, 2, &trajectory::JointUse::acceleration_step, &trajectory::JointUse::acceleration_steps,
          "there the jerk has no limit: give accelerations at every point, or plan without --keep-times");
  }

 private:
  /// "between points 3 and 4 (1.532 s)", counted from 1.
  std::string place(double t) const {
    const auto next = std::upper_bound(points_.begin(), points_.end(), t + 1e-9);
    const auto i = std::size_t(next - points_.begin());
    for (std::size_t k = i > 0 ? i - 1 : 0; k < std::min(i + 1, points_.size()); ++k)
      if (std::abs(points_[k] - t) < 1e-6) return fmt::format("at point {} ({:.3f} s)", k + 1, t);
    if (i == 0) return fmt::format("on the way to point 1 ({:.3f} s)", t);
    if (i == points_.size()) return fmt::format("after the last point ({:.3f} s)", t);
    return fmt::format("between points {} and {} ({:.3f} s)", i, i + 1, t);
  }
  double limit(std::size_t j, std::size_t quantity, bool below) const {
    const trajectory::MotionLimits& l = motion_.joints[j].limits;
    if (quantity == 3) return l.max_jerk;
    if (quantity == 1) return below ? -l.min_velocity : l.max_velocity;
    return below ? -l.min_acceleration : l.max_acceleration;
  }
  void add(const char* code, std::string what, std::string advice, Severity severity) {
    motion_.problems.push_back({code, {}, std::move(what), std::move(advice), severity});
  }
  void beyond(std::size_t j, std::size_t quantity, const trajectory::Peak& peak, double use, double factor) {
    if (use <= 1 + kRounding) return;
    const PlanJoint& joint = motion_.joints[j];
    add("limit",
        fmt::format("{} would have a{} {} of {:.4g} {} {}, its limit is {:.4g}", joint.name,
                    quantity == 2 ? "n" : "", kQuantities[quantity], std::abs(peak.value),
                    unit_of(joint, quantity), place(peak.time), limit(j, quantity, peak.value < 0)),
        fmt::format("take {:.2f} times the time for all limits, or plan without --keep-times", factor),
        Severity::error);
  }
  /// One sentence for all joints, about the step with the largest share of its limit. A step in velocity is
  /// an error; one in acceleration, which cubic splines have at every point, is a warning.
  void steps(const std::vector<trajectory::JointUse>& uses, std::size_t quantity,
             trajectory::Peak trajectory::JointUse::*step, int trajectory::JointUse::*count,
             const char* advice) {
    std::size_t worst = 0;
    double most = 0;
    int points = 0;
    for (std::size_t j = 0; j < uses.size(); ++j) {
      const double share = std::abs((uses[j].*step).value) / limit(j, quantity, false);
      if (share > most) most = share, worst = j;
      points = std::max(points, uses[j].*count);
    }
    if (points == 0) return;
    const trajectory::Peak& peak = uses[worst].*step;
    const std::string more = points > 1 ? fmt::format("; it jumps at {} points", points) : std::string();
    add("step",
        fmt::format("the {} of {} jumps by {:.4g} {} {}{}", kQuantities[quantity], motion_.joints[worst].name,
                    std::abs(peak.value), unit_of(motion_.joints[worst], quantity), place(peak.time), more),
        advice, quantity == 1 ? Severity::error : Severity::warning);
  }

  PlannedMotion& motion_;
  const std::vector<double>& points_;
};

}  // namespace

void take_trajectory(PlannedMotion& motion, const kinematics::Chain& chain, Trajectory trajectory,
                     const std::vector<double>& points) {
  std::vector<trajectory::MotionLimits> limits;
  for (const PlanJoint& joint : motion.joints) limits.push_back(joint.limits);
  const std::vector<trajectory::JointUse> uses = limit_use(trajectory, limits);
  motion.duration = trajectory.duration();
  motion.sections = {{"as it is timed", 0, motion.duration}};
  motion.at = [rates = moves::TcpRates(chain), trajectory = std::move(trajectory), hint = std::size_t(0),
               before = PlanState(chain.joints()),
               after = PlanState(chain.joints())](double t, PlanState& state) mutable {
    trajectory.sample(t, part(state, 0), part(state, 1), part(state, 2), hint);
    // The acceleration is cubic within a segment, so this difference gives the jerk with a relative error of
    // 1e-6.
    const double begin = hint == 0 ? 0 : trajectory.end_of(hint - 1), end = trajectory.end_of(hint);
    const double h = 1e-4 * (end - begin), middle = std::clamp(t, begin + h, end - 2 * h);
    std::size_t same = hint;
    trajectory.sample(middle - h, {}, {}, part(before, 2), same);
    trajectory.sample(middle + h, {}, {}, part(after, 2), same);
    for (std::size_t j = 0; j < state.value[3].size(); ++j)
      state.value[3][j] = (after.value[2][j] - before.value[2][j]) / (2 * h);
    with_tcp(rates, state);
  };
  check_positions(motion);
  TimeCheck(motion, points).judge(uses);
}

std::vector<PlanPeaks> peaks_of(const PlannedMotion& motion, double* tcp_speed) {
  std::vector<PlanPeaks> out(motion.joints.size());
  for (PlanPeaks& p : out) p.low.fill(INFINITY), p.high.fill(-INFINITY);
  PlanState state(motion.joints.size());
  for (std::size_t i = 0; i <= kExtremeSamples; ++i) {
    motion.at(motion.duration * double(i) / double(kExtremeSamples), state);
    for (std::size_t j = 0; j < out.size(); ++j)
      for (std::size_t k = 0; k < 4; ++k) {
        out[j].low[k] = std::min(out[j].low[k], state.value[k][j]);
        out[j].high[k] = std::max(out[j].high[k], state.value[k][j]);
      }
    if (tcp_speed) *tcp_speed = i == 0 ? state.tcp_speed : std::max(*tcp_speed, state.tcp_speed);
  }
  return out;
}

std::vector<PlanBand> merged(const std::vector<PlanBand>& bands, double shortest) {
  std::vector<PlanBand> out;
  for (const PlanBand& b : bands) {
    const bool same = !out.empty() && out.back().row == b.row && out.back().kind == b.kind;
    if (same || (!out.empty() && b.to - b.from < shortest))
      out.back().to = b.to;
    else
      out.push_back(b);
  }
  if (out.size() > 1 && out[0].to - out[0].from < shortest) {
    out[1].from = out[0].from;
    out.erase(out.begin());
  }
  return out;
}

}  // namespace polyarm::apps
