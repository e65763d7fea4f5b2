#pragma once
/// Parts of guards: a planned path in time, how long a path takes to brake, how fast joints move whose plan
/// is not known, and the limits and zones of a cell. Private to this room. Metres, radians, seconds.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/jog/jog_axis.hpp"
#include "polyarm/machine/motions.hpp"
#include "polyarm/moves/move_plan.hpp"
#include "polyarm/moves/robot_facts.hpp"
#include "polyarm/setup/cell_setup.hpp"
#include "polyarm/surroundings/look_ahead.hpp"

namespace polyarm::cell {

/// A planned motion of one robot, with the most that its joints may accelerate.
class PathOfMove : public surroundings::PlannedWay {
 public:
  void set(const moves::PlannedMotion& motion, const moves::RobotFacts& robot) {
    motion_ = &motion;
    hint_ = 0;
    acceleration_.clear();
    for (const trajectory::JointMotionLimits& limits : robot.limits)
      acceleration_.push_back(limits.acceleration);
  }
  double duration() const noexcept override { return motion_->path.duration(); }
  void at(double time, std::span<double> position, std::span<double> velocity) noexcept override {
    motion_->path.sample(time, position, velocity, {}, {}, hint_);
  }
  std::span<const double> acceleration() const noexcept override { return acceleration_; }

 private:
  const moves::PlannedMotion* motion_ = nullptr;
  std::size_t hint_ = 0;
  std::vector<double> acceleration_;
};

/// A trajectory of points that moves a robot. What it does not lead stays where it is.
class PathOfPoints : public surroundings::PlannedWay {
 public:
  void set(const controllers::TrajectoryGoal& goal, std::span<const double> joints,
           std::span<const jog::AxisLimits> axes) {
    still(goal);
    rest_.assign(joints.begin(), joints.end());
    led_.assign(goal.trajectory.joints(), 0);
    rates_.assign(led_.size(), 0);
    acceleration_.clear();
    for (const jog::AxisLimits& axis : axes) acceleration_.push_back(axis.acceleration);
    // Its points may ask for more than the robot's limits, and for jumps of the velocity.
    constexpr int kPlaces = 256;
    const double h = std::max(duration() / kPlaces, 1e-3);
    std::vector<double> before(led_.size(), 0.0);
    for (int k = 0; k <= kPlaces; ++k) {
      goal.trajectory.sample(h * k, led_, rates_, {}, hint_);
      for (std::size_t i = 0; i < led_.size(); ++i) {
        double& most = acceleration_[joint(i)];
        most = std::max(most, std::abs(rates_[i] - before[i]) / h);
      }
      before = rates_;
    }
    hint_ = 0;
  }
  /// The same trajectory in a later tick.
  void still(const controllers::TrajectoryGoal& goal) { goal_ = &goal; }
  double duration() const noexcept override { return goal_->trajectory.duration(); }
  void at(double time, std::span<double> position, std::span<double> velocity) noexcept override {
    goal_->trajectory.sample(time, led_, rates_, {}, hint_);
    std::copy(rest_.begin(), rest_.end(), position.begin());
    std::fill(velocity.begin(), velocity.end(), 0.0);
    for (std::size_t i = 0; i < led_.size(); ++i) {
      position[joint(i)] = led_[i];
      if (!velocity.empty()) velocity[joint(i)] = rates_[i];
    }
  }
  std::span<const double> acceleration() const noexcept override { return acceleration_; }

 private:
  std::size_t joint(std::size_t i) const noexcept { return goal_->joints.empty() ? i : goal_->joints[i]; }

  const controllers::TrajectoryGoal* goal_ = nullptr;
  std::size_t hint_ = 0;
  std::vector<double> rest_, led_, rates_, acceleration_;
};

/// Until when a way stays in the workspace. It is looked at piece by piece, each place once.
class ZonesAhead {
 public:
  /// A new way, or none.
  void begin() { until_ = -1; }
  /// The time at which the way leaves the workspace, at most `until`; infinite: it does not. What is outside
  /// when the look begins may return, not go deeper.
  double look(const moves::Workspace& workspace, const kinematics::Chain& chain,
              surroundings::PlannedWay& way, double now, double until, bool reduced) {
    if (until_ < 0 || reduced_ != reduced) {
      leaves_ = std::numeric_limits<double>::infinity();
      reduced_ = reduced;
      until_ = now;
      q_.assign(chain.joints(), 0);
      find(workspace, chain, way, now);
      allowed_.clear();
      for (const double distance : distances_) allowed_.push_back(std::min(0.0, distance));
    }
    until = std::min(until, way.duration());
    while (until_ < until && !std::isfinite(leaves_)) {
      const double next = std::min(until, until_ + kStep);
      if (crossed(workspace, chain, way, next) >= 0) refine(workspace, chain, way, until_, next);
      until_ = next;
    }
    return leaves_;
  }
  const std::string& crossing() const { return crossing_; }

 private:
  static constexpr double kStep = 0.004;  // s
  static constexpr double kTolerance = 1e-6;

  void find(const moves::Workspace& workspace, const kinematics::Chain& chain, surroundings::PlannedWay& way,
            double time) {
    way.at(time, q_, {});
    tcp_ = chain.forward(q_);
    distances_.assign(workspace.boundaries(), 0);
    for (std::size_t i = 0; i < distances_.size(); ++i)
      distances_[i] = workspace.counts(i, reduced_) ? workspace.distance(i, tcp_, q_).distance : 0;
  }
  /// The boundary that is crossed at a time; -1: none.
  int crossed(const moves::Workspace& workspace, const kinematics::Chain& chain,
              surroundings::PlannedWay& way, double time) {
    find(workspace, chain, way, time);
    for (std::size_t i = 0; i < distances_.size(); ++i)
      if (distances_[i] < allowed_[i] - kTolerance) return static_cast<int>(i);
    return -1;
  }
  void refine(const moves::Workspace& workspace, const kinematics::Chain& chain,
              surroundings::PlannedWay& way, double inside, double outside) {
    for (int i = 0; i < 12; ++i) {
      const double middle = (inside + outside) / 2;
      (crossed(workspace, chain, way, middle) >= 0 ? outside : inside) = middle;
    }
    leaves_ = inside;
    crossing_ =
        workspace.crossing(static_cast<std::size_t>(crossed(workspace, chain, way, outside)), tcp_, q_);
  }

  double until_ = -1;  // it was looked at as far as this; < 0: not at all
  double leaves_ = 0;
  bool reduced_ = false;
  std::string crossing_;
  Pose tcp_;
  std::vector<double> q_, distances_, allowed_;
};

/// How the braking of a path grows with its speed: at pace p it takes less than `square` p² + `plain` p
/// seconds of the plan, twice what the joints need when the plan asks nothing else of them.
struct Braking {
  double square = 0, plain = 0;
  double at(double pace) const { return (square * pace + plain) * pace; }
  /// The pace that leaves `room` s of the plan; `longer`: s in which it slows down in addition.
  double pace_for(double room, double longer) const {
    const double a = square + longer;
    if (a < 1e-9) return room >= plain ? 1 : room / plain;
    return std::min(1.0, (std::sqrt(plain * plain + 4 * a * std::max(0.0, room)) - plain) / (2 * a));
  }
};

/// The velocities of joints over the last ticks: commands may come less often than ticks. Allocates in the
/// constructor alone.
class JointRates {
 public:
  explicit JointRates(std::size_t joints) : rates_(joints, 0.0) {
    past_.fill({-1, std::vector<double>(joints)});
  }

  /// Call it in each tick; a gap begins anew.
  void add(Nanoseconds now, std::span<const double> joints) noexcept {
    constexpr Nanoseconds kGap = 50'000'000;
    const Past& newest = past_[(next_ + kTicks - 1) % kTicks];
    if (newest.time < 0 || now <= newest.time || now - newest.time > kGap)
      for (Past& past : past_) past.time = -1;
    const Past* oldest = nullptr;
    for (std::size_t k = 0; k < kTicks && !oldest; ++k)
      if (past_[(next_ + k) % kTicks].time >= 0) oldest = &past_[(next_ + k) % kTicks];
    const Past& middle = past_[(next_ + kTicks / 2) % kTicks];
    for (std::size_t j = 0; j < rates_.size(); ++j) {
      rates_[j] = oldest ? (joints[j] - oldest->joints[j]) / seconds(now - oldest->time) : 0;
      if (!oldest || oldest == &middle || middle.time <= oldest->time) continue;
      // A joint that becomes faster is judged by what it will have when it begins to brake.
      const double half = seconds(now - middle.time), whole = seconds(now - oldest->time);
      const double recent = (joints[j] - middle.joints[j]) / half;
      const double earlier = (middle.joints[j] - oldest->joints[j]) / (whole - half);
      const double coming = recent + (recent - earlier) / (whole / 2) * (half / 2 + kAhead);
      if (std::abs(coming) > std::abs(rates_[j]) && coming * rates_[j] > 0) rates_[j] = coming;
    }
    past_[next_].time = now;
    std::copy_n(joints.begin(), rates_.size(), past_[next_].joints.begin());
    next_ = (next_ + 1) % kTicks;
  }
  /// Earlier ticks do not count.
  void forget() noexcept {
    for (Past& past : past_) past.time = -1;
  }
  /// False for a robot that hardly moves: measured joints are never quite still.
  bool move() const noexcept {
    return std::any_of(rates_.begin(), rates_.end(), [](double rate) { return std::abs(rate) > kStands; });
  }
  /// How far the joints go until they stand if they begin to brake now, `latency` s after it.
  void stopping(std::span<const jog::AxisLimits> axes, double latency, std::span<double> way) const noexcept {
    double time = 0, rise = kHalfRamp;  // s for which they go on at their present speed
    for (std::size_t j = 0; j < rates_.size(); ++j) {
      way[j] = std::clamp(rates_[j], -axes[j].velocity, axes[j].velocity);
      time = std::max(time, std::abs(way[j]) / (2 * axes[j].acceleration));
      rise = std::max(rise, axes[j].acceleration / (2 * axes[j].jerk));
    }
    for (double& by : way) by *= time + rise + latency + kLag;
  }

 private:
  static constexpr std::size_t kTicks = 10;
  static constexpr double kStands = 2e-3;  // rad/s or m/s
  static constexpr double kHalfRamp =
      0.025;                              // half of the shortest time in which a trajectory comes to rest, s
  static constexpr double kAhead = 0.01;  // s between the newest joints and the begin of braking
  static constexpr double kLag = 0.01;    // of a mean over that many ticks, s
  struct Past {
    Nanoseconds time;  // -1: none
    std::vector<double> joints;
  };
  std::array<Past, kTicks> past_;
  std::size_t next_ = 0;
  std::vector<double> rates_;
};

inline std::vector<jog::AxisLimits> axes_of(const CellRobot& robot) {
  std::vector<jog::AxisLimits> out;
  for (const controllers::JointFacts& joint : robot.joints)
    out.push_back({joint.lower, joint.upper, joint.velocity, std::min(joint.acceleration, joint.deceleration),
                   joint.jerk});
  return out;
}

/// True if zones of bodies depend on the profile.
inline bool has_zones_of_profiles(const CellSetup& setup) {
  for (const auto& robot : setup.robots)
    for (const moves::WorkspaceZone& zone : robot->facts->workspace.zones())
      if (zone.bodies && zone.profile != moves::ZoneProfile::any) return true;
  return false;
}

/// The zones that count for bodies in a profile.
inline std::vector<surroundings::GuardZone> zones_of(const CellSetup& setup, bool reduced) {
  std::vector<surroundings::GuardZone> out;
  for (std::size_t r = 0; r < setup.robots.size(); ++r)
    for (const moves::WorkspaceZone& zone : setup.robots[r]->facts->workspace.zones()) {
      if (!zone.bodies) continue;
      if (zone.profile != moves::ZoneProfile::any && (zone.profile == moves::ZoneProfile::reduced) != reduced)
        continue;
      const int robot = static_cast<int>(r);
      if (zone.kind == moves::ZoneKind::plane)
        out.push_back({zone.name, robot, false, zone.point, zone.normal, {}, {}});
      if (zone.kind == moves::ZoneKind::outside)
        out.push_back({zone.name, robot, true, {}, {}, zone.low, zone.high});
      if (zone.kind != moves::ZoneKind::inside) continue;
      for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        out.push_back({zone.name, robot, false, zone.low, axis, {}, {}});
        out.push_back({zone.name, robot, false, zone.high, -axis, {}, {}});
      }
    }
  return out;
}

}  // namespace polyarm::cell
