#include "polyarm/moves/frame_ride.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::moves {

using trajectory::MotionLimits;
using trajectory::MotionState;

namespace {
/// The share of what a joint has left that it uses to catch up.
constexpr double kCatchUp = 0.6;
/// A joint has at least this share of its limits to catch up.
constexpr double kLeastShare = 0.05;
/// The travel of the frame is smoothed by three equal poles, 1/s: slower than its noise, faster than its
/// changes.
constexpr double kSmoothing = 60;
/// The poles are at most this far apart from one cycle to the next.
constexpr double kPolePerCycle = 0.2;
/// Without news of the frame for this long nobody knows where it is.
constexpr Nanoseconds kStale = 100'000'000;
/// A ride is synchronised within these errors of each joint: rad or m, per s, per s².
constexpr double kNear = 2e-5, kSlow = 2e-3, kSteady = 0.2;
/// Near the path three equal poles of the sampled error, at 1 - kPull, hold a joint on it.
constexpr double kPull = 0.3;
constexpr double kPullPosition = kPull * kPull * kPull, kPullVelocity = 3 * kPull * kPull - kPullPosition,
                 kPullAcceleration = 3 * kPull - 1.5 * kPull * kPull + kPullPosition / 3;
/// They do so while they need at most this share of the jerk.
constexpr double kNearShare = 0.3;
/// A path that is this much faster than a joint can move is out of reach: it passes a singularity.
constexpr double kTooFast = 2;
constexpr double kRest = 1e-9;
constexpr int kMostSteps = 20;
constexpr double kSolved = 1e-11, kNearEnough = 1e-6;  // m and rad
constexpr double kDamping = 1e-10;
/// Joints that would move farther in one cycle, rad or m, change the configuration of the arm.
constexpr double kJump = 0.2;
constexpr int kBisections = 40;
constexpr double kHarder = 3;  // an immediate stop
}  // namespace

Pose MovingFrame::motion(double travel) const noexcept {
  const Pose own = turns ? Pose{{}, from_axis_angle({0, 0, 1}, travel)} : Pose{{travel, 0, 0}, {}};
  return at_zero * own * inverse(at_zero);
}

FrameRide::FrameRide(const kinematics::Chain& chain, std::span<const trajectory::JointMotionLimits> limits)
    : chain_(chain) {
  for (const trajectory::JointMotionLimits& l : limits)
    limits_.push_back(MotionLimits::symmetric(l.velocity, l.acceleration, l.jerk));
  const std::size_t n = chain.joints();
  for (States* states : {&now_, &aim_, &before_}) states->assign(n, {});
  for (auto* values : {&last_, &path_, &solved_, &guess_, &step_, &earlier_}) values->assign(n, 0.0);
  jacobian_.assign(6 * n, 0.0);
}

void FrameRide::begin(const MovingFrame& frame, double travel, std::span<const double> at, double lead) {
  frame_ = frame, from_ = travel, lead_ = lead;
  std::copy_n(at.begin(), std::min(at.size(), last_.size()),
              last_.begin());  // it may end before its first cycle
  moved_.store(0, std::memory_order_relaxed);
  synchronised_.store(false, std::memory_order_relaxed);
  wanted_.store(true, std::memory_order_release);
}

void FrameRide::drop() noexcept {
  wanted_.store(false, std::memory_order_release);
  end();
}

void FrameRide::end() noexcept {
  if (state_.load(std::memory_order_relaxed) != State::off)
    for (std::size_t j = 0; j < now_.size(); ++j) last_[j] = now_[j].position;
  synchronised_.store(false, std::memory_order_relaxed);
  standing_ = true;
  state_.store(State::off, std::memory_order_release);
}

void FrameRide::start(const Request& request, const Joints& joints) noexcept {
  for (std::size_t j = 0; j < now_.size(); ++j)
    now_[j] = {joints.position[j], joints.velocity[j], joints.acceleration[j]};
  travel_.fetch();
  const FrameTravel known = travel_.value();
  smooth_ = known.time < 0
                ? std::array<double, 3>{from_, 0, 0}
                : std::array<double, 3>{known.after(seconds(request.now - known.time) + lead_).travel,
                                        known.velocity, 0};
  aimed_ = 0;
  state_.store(State::riding, std::memory_order_release);
}

/// The travel that the joints follow: the known one at the end of this cycle, without steps of its
/// acceleration.
bool FrameRide::follow_frame(const Request& request) noexcept {
  travel_.fetch();
  const FrameTravel& known = travel_.value();
  if (known.time < 0 || request.now - known.time > kStale) return false;
  const double dt = request.period;
  const FrameTravel then = known.after(seconds(request.now - known.time) + dt + lead_);
  const double w = std::min(kSmoothing, kPolePerCycle / dt);
  auto& [y, v, a] = smooth_;
  // Errors at the end of the cycle if the jerk were zero.
  const double ahead_y = y + dt * (v + 0.5 * dt * a), ahead_v = v + dt * a;
  const double jerk = w * w * w * (then.travel - ahead_y) + 3 * w * w * (then.velocity - ahead_v) +
                      3 * w * (then.acceleration - a);
  y = ahead_y + jerk * dt * dt * dt / 6, v = ahead_v + 0.5 * jerk * dt * dt, a += jerk * dt;
  moved_.store(y - from_, std::memory_order_relaxed);
  return true;
}

/// The smallest joint step that moves the TCP by `twist`, with a little damping.
void FrameRide::least_squares(const std::array<double, 6>& twist, std::span<double> out) noexcept {
  const std::size_t n = out.size();
  std::array<std::array<double, 6>, 6> l{};  // J Jᵀ, then its Cholesky factor
  for (std::size_t r = 0; r < 6; ++r)
    for (std::size_t c = 0; c <= r; ++c) {
      double sum = r == c ? kDamping : 0;
      for (std::size_t j = 0; j < n; ++j) sum += jacobian_[r * n + j] * jacobian_[c * n + j];
      for (std::size_t k = 0; k < c; ++k) sum -= l[r][k] * l[c][k];
      l[r][c] = r == c ? std::sqrt(std::max(sum, kDamping)) : sum / l[c][c];
    }
  std::array<double, 6> x = twist;
  for (std::size_t r = 0; r < 6; ++r) {
    for (std::size_t k = 0; k < r; ++k) x[r] -= l[r][k] * x[k];
    x[r] /= l[r][r];
  }
  for (std::size_t r = 6; r-- > 0;) {
    for (std::size_t k = r + 1; k < 6; ++k) x[r] -= l[k][r] * x[k];
    x[r] /= l[r][r];
  }
  for (std::size_t j = 0; j < n; ++j) {
    out[j] = 0;
    for (std::size_t r = 0; r < 6; ++r) out[j] += jacobian_[r * n + j] * x[r];
  }
}

/// Moves solved_ to the joints at `target`; leaves the Jacobian there.
bool FrameRide::solve(const Pose& target) noexcept {
  double position = 0, angle = 0;
  for (int i = 0; i < kMostSteps; ++i) {
    const Pose tcp = chain_.jacobian(solved_, jacobian_);
    const Vec3 p = target.position - tcp.position;
    const Vec3 r = to_rotation_vector(target.rotation * inverse(tcp.rotation));
    position = norm(p), angle = norm(r);
    if (position < kSolved && angle < kSolved) return true;
    least_squares({p.x, p.y, p.z, r.x, r.y, r.z}, step_);
    for (std::size_t j = 0; j < step_.size(); ++j) solved_[j] += step_[j];
  }
  return position < kNearEnough && angle < kNearEnough;
}

/// The joint velocities in aim_: those of the path, turned with the frame, and those of the frame itself.
void FrameRide::solve_velocity(const Joints& path, const Pose& moved, const Pose& tcp) noexcept {
  const std::size_t n = aim_.size();
  std::array<double, 6> twist{};
  for (std::size_t r = 0; r < 6; ++r)
    for (std::size_t j = 0; j < n; ++j) twist[r] -= jacobian_[r * n + j] * path.velocity[j];
  std::array<double, 6> own{};  // of the path, where it was planned
  chain_.jacobian(path.position, jacobian_);
  for (std::size_t r = 0; r < 6; ++r)
    for (std::size_t j = 0; j < n; ++j) own[r] += jacobian_[r * n + j] * path.velocity[j];
  Vec3 linear = moved.rotation * Vec3{own[0], own[1], own[2]};
  Vec3 angular = moved.rotation * Vec3{own[3], own[4], own[5]};
  const double v = smooth_[1];
  if (frame_.turns) {
    const Vec3 axis = v * (frame_.at_zero.rotation * Vec3{0, 0, 1});
    linear = linear + cross(axis, tcp.position - frame_.at_zero.position);
    angular = angular + axis;
  } else {
    linear = linear + v * (frame_.at_zero.rotation * Vec3{1, 0, 0});
  }
  twist = {twist[0] + linear.x,  twist[1] + linear.y,  twist[2] + linear.z,
           twist[3] + angular.x, twist[4] + angular.y, twist[5] + angular.z};
  chain_.jacobian(solved_, jacobian_);
  least_squares(twist, step_);
  for (std::size_t j = 0; j < n; ++j) aim_[j].velocity = path.velocity[j] + step_[j];
}

/// The joint states of the path in the moving frame at the end of this cycle, in aim_.
bool FrameRide::aim(const Request& request, const Joints& path) noexcept {
  const bool known = follow_frame(request);
  const std::size_t n = aim_.size();
  for (std::size_t j = 0; j < n; ++j) {
    solved_[j] = aimed_ > 0 ? aim_[j].position + path.position[j] - path_[j] : now_[j].position;
    path_[j] = path.position[j];
  }
  guess_ = solved_;
  const Pose moved = frame_.motion(smooth_[0] - from_);
  const Pose target = moved * chain_.forward(path.position);
  if (!known || !solve(target)) return false;
  for (std::size_t j = 0; j < n; ++j)
    if (aimed_ > 0 && std::abs(solved_[j] - guess_[j]) > kJump) return false;
  for (std::size_t j = 0; j < n; ++j) earlier_[j] = before_[j].velocity;
  before_ = aim_;
  for (std::size_t j = 0; j < n; ++j) aim_[j].position = solved_[j];
  solve_velocity(path, moved, target);
  derive_acceleration(request.period);
  for (std::size_t j = 0; j < n; ++j)
    if (std::abs(aim_[j].velocity) > kTooFast * limits_[j].max_velocity) return false;
  return true;
}

/// From as many of the last three velocities as there are.
void FrameRide::derive_acceleration(double period) noexcept {
  for (std::size_t j = 0; j < aim_.size(); ++j) {
    MotionState &to = aim_[j], &from = before_[j];
    if (aimed_ == 0) from = {to.position - to.velocity * period, to.velocity, 0};
    to.acceleration = aimed_ < 2 ? (to.velocity - from.velocity) / period
                                 : (3 * to.velocity - 4 * from.velocity + earlier_[j]) / (2 * period);
    if (aimed_ == 1) from.acceleration = to.acceleration;
  }
  aimed_ = std::min(aimed_ + 1, 2);
}

MotionState FrameRide::towards_velocity(std::size_t j, double velocity, double period,
                                        const MotionLimits& limits) noexcept {
  const MotionState target{0, velocity, 0};
  const trajectory::MotionOptions options{trajectory::Synchronization::none, trajectory::TargetKind::velocity,
                                          0};
  if (planner_.plan({&now_[j], 1}, {&target, 1}, {&limits, 1}, options) != trajectory::MotionStatus::ok)
    return {now_[j].position, 0, 0};
  return planner_.axis(0).at(period);
}

MotionState FrameRide::brake(std::size_t j, const Request& request) noexcept {
  MotionLimits limits = limits_[j];
  if (request.immediate)
    limits = MotionLimits::symmetric(limits.max_velocity, kHarder * limits.max_acceleration,
                                     kHarder * kHarder * limits.max_jerk);
  return towards_velocity(j, 0, request.period, limits);
}

/// The jerk of this cycle that is nearest to `jerk` and lets the joint keep its limits in this cycle and
/// afterwards.
double FrameRide::allowed_jerk(std::size_t j, double jerk, double period) const noexcept {
  const MotionLimits& l = limits_[j];
  const MotionState& now = now_[j];
  const double most = l.max_velocity - 0.25 * l.max_jerk * period * period;  // a cycle does not end at a peak
  // The velocity at which the acceleration could be zero again: it rises with the jerk.
  const auto coming = [&](double u) {
    const double a = now.acceleration + u * period;
    return now.velocity + (now.acceleration + 0.5 * u * period) * period + a * std::abs(a) / (2 * l.max_jerk);
  };
  const auto limit = [&](double u) {
    const double low = (-l.max_acceleration - now.acceleration) / period;
    const double high = (l.max_acceleration - now.acceleration) / period;
    return std::clamp(std::clamp(u, low, high), -l.max_jerk, l.max_jerk);
  };
  const double asked = limit(jerk);
  const double at = coming(asked);
  if (std::abs(at) <= most) return asked;
  // Between the asked jerk and the one that brakes hardest.
  double over = asked, within = limit(at > 0 ? -l.max_jerk : l.max_jerk);
  const double bound = std::copysign(most, at);
  if ((coming(within) - bound) * at > 0) return within;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (over + within);
    ((coming(middle) - bound) * at > 0 ? over : within) = middle;
  }
  return within;
}

/// What is left for the error beside the motion of the path. At a lower speed it decays more slowly. The jerk
/// does not change with the path: an error that brakes would overshoot if it became less.
MotionLimits FrameRide::left_limits(std::size_t j, double speed) const noexcept {
  const MotionLimits& l = limits_[j];
  const MotionState& to = aim_[j];
  const double share = kCatchUp * std::min(speed, 1.0);
  const auto left = [&](double most, double used) {
    return std::max(share * (most - used), kLeastShare * most);
  };
  return {left(l.max_velocity, to.velocity), left(l.max_acceleration, to.acceleration),
          std::max(share, kLeastShare) * l.max_jerk, -left(l.max_velocity, -to.velocity),
          -left(l.max_acceleration, -to.acceleration)};
}

/// Towards aim_ at one jerk in the cycle. So the limits hold whatever aim_ does.
MotionState FrameRide::approach(std::size_t j, const Request& request) noexcept {
  const double dt = request.period;
  const MotionState &from = before_[j], &to = aim_[j], &now = now_[j];
  const MotionState error{now.position - from.position, now.velocity - from.velocity,
                          now.acceleration - from.acceleration};
  const double feed = (to.acceleration - from.acceleration) / dt;
  const double p = kPullPosition * error.position / (dt * dt * dt),
               v = kPullVelocity * error.velocity / (dt * dt),
               a = kPullAcceleration * error.acceleration / dt;
  double jerk = -(p + v + a);
  if (std::max({std::abs(p), std::abs(v), std::abs(a)}) > kNearShare * limits_[j].max_jerk) {
    const MotionLimits left = left_limits(j, request.speed);
    const MotionState zero;
    const trajectory::MotionOptions options{trajectory::Synchronization::none,
                                            trajectory::TargetKind::position, 0};
    if (planner_.plan({&error, 1}, {&zero, 1}, {&left, 1}, options) == trajectory::MotionStatus::ok)
      jerk = (planner_.axis(0).at(dt).acceleration - error.acceleration) / dt;
  }
  jerk = allowed_jerk(j, feed + jerk, dt);
  return {now.position + dt * (now.velocity + dt * (now.acceleration / 2 + dt * jerk / 6)),
          now.velocity + dt * (now.acceleration + dt * jerk / 2), now.acceleration + dt * jerk};
}

/// True if the joint could not come to rest before the end of its range.
bool FrameRide::is_at_end_of_range(std::size_t j) const noexcept {
  const MotionLimits& l = limits_[j];
  const double v = now_[j].velocity, speed = std::abs(v);
  const double way = speed * (speed / (2 * l.max_acceleration) + 2 * l.max_acceleration / l.max_jerk);
  return now_[j].position + std::copysign(way, v) > chain_.upper()[j] ||
         now_[j].position + std::copysign(way, v) < chain_.lower()[j];
}

controllers::MotionShift::Outcome FrameRide::apply(const Request& request, const Joints& joints) noexcept {
  if (state_.load(std::memory_order_relaxed) == State::off) start(request, joints);
  const bool wanted = wanted_.load(std::memory_order_acquire);
  const bool aims = wanted && state_.load(std::memory_order_relaxed) == State::riding && aim(request, joints);
  if (wanted && !aims) state_.store(State::lost, std::memory_order_release);
  const bool rides = wanted && request.speed > 0 && state_.load(std::memory_order_relaxed) == State::riding;
  bool near = rides, rests = true;
  for (std::size_t j = 0; j < now_.size(); ++j) {
    now_[j] = rides ? approach(j, request) : brake(j, request);
    near = near && std::abs(now_[j].position - aim_[j].position) < kNear &&
           std::abs(now_[j].velocity - aim_[j].velocity) < kSlow &&
           std::abs(now_[j].acceleration - aim_[j].acceleration) < kSteady;
    if (std::abs(now_[j].velocity) < kRest && std::abs(now_[j].acceleration) < kRest && !rides)
      now_[j].velocity = now_[j].acceleration = 0;
    rests = rests && now_[j].velocity == 0 && now_[j].acceleration == 0;
    if (rides && is_at_end_of_range(j)) state_.store(State::lost, std::memory_order_release);
    joints.position[j] = now_[j].position;
    joints.velocity[j] = now_[j].velocity;
    joints.acceleration[j] = now_[j].acceleration;
  }
  standing_ = rests;
  synchronised_.store(near, std::memory_order_release);
  if (wanted || !rests) return Outcome::shifted;
  end();
  return Outcome::ended;
}

}  // namespace polyarm::moves
