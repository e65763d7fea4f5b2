#include "polyarm/jog/jog_line.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::jog {
namespace {

/// Shares of the joints' limits: of accelerations and jerks for changes of the speed, and for the bends of
/// the joints' paths at steady speed. The rest is for following.
constexpr double kPull = 0.35, kSnap = 0.25, kBend = 0.25, kBendSnap = 0.2, kBoth = 0.25;
/// Braking takes up to this many times as much when the way is shorter than expected.
constexpr double kHarder = 1.8;
/// No joint goes faster than it can stop in about twice this time, s.
constexpr double kStopsIn = 0.1;
/// Time between nodes at the highest speed there, and steps of a look ahead, s.
constexpr double kApart = 0.02, kLookStep = 0.008;
constexpr int kMostLooks = 300, kBisections = 8;
/// Nodes that one cycle adds, at most.
constexpr int kAdds = 4;
/// The shortest way between nodes, m or rad.
constexpr double kShortest = 1e-8;
/// A joint stays this far from its limits, rad or m.
constexpr double kOffLimit = 5e-5;
/// The path may begin this far beside the joints, rad or m.
constexpr double kBesideIt = 0.01;
/// What rounding leaves beside the path, in reaches and radians: a singularity would make much of it.
constexpr double kOnIt = 1e-9;
/// A joint that does less than this share of what others do has no limit here.
constexpr double kStill = 1e-6;
/// A singularity that takes more than this share of the wish ends the path.
constexpr double kLostAtMost = 1e-4;
/// Spare joints do less within this distance of their limits, rad or m.
constexpr double kSpareFrom = 0.25;
/// Joints that turn this much faster than the TCP, in reaches and radians, are near a singularity.
constexpr double kManyTimes = 8;

Vec3 part(const Twist& t, std::size_t k) {
  return {t[k], t[k + 1], t[k + 2]};
}

}  // namespace

JogLine::JogLine(const kinematics::Chain& chain, std::span<const AxisLimits> axes, double period)
    : solver_(chain),
      axes_(axes.begin(), axes.end()),
      joints_(axes.size()),
      dt_(period),
      length_(std::isfinite(chain.reach()) && chain.reach() > 1e-3 ? chain.reach() : 1.0),
      places_(kNodes * axes.size()) {}

Pose JogLine::pose_at(double way) const noexcept {
  const Vec3 v = part(unit_, 0), w = part(unit_, 3);
  const double rate = norm(w);
  Pose out = start_;
  Vec3 by = way * v;
  if (rate > 0) {
    const Vec3 axis = (1 / rate) * w;
    out.rotation = normalized(from_axis_angle(axis, way * rate) * start_.rotation);
    if (turns_) {  // a helix
      const Vec3 along = dot(v, axis) * axis, across = v - along;
      const double angle = way * rate;
      by = way * along + (std::sin(angle) / rate) * across + ((1 - std::cos(angle)) / rate) * cross(axis, v);
    }
  }
  out.position = start_.position + by;
  return out;
}

Twist JogLine::direction_at(double way) const noexcept {
  const Vec3 w = part(unit_, 3);
  const double rate = norm(w);
  if (!turns_ || rate == 0) return unit_;
  const Vec3 v = from_axis_angle((1 / rate) * w, way * rate) * part(unit_, 0);
  return {v.x, v.y, v.z, w.x, w.y, w.z};
}

/// Weights of spare joints: those that go towards a limit near by do less (Chan and Dubey 1995).
bool JogLine::rates_for(const Twist& twist, std::span<const double> q, TwistSolver& solver,
                        JogValues& rates) const noexcept {
  double lost = solver.exact(twist, rates);
  if (solver.spare() > 0 && lost <= kLostAtMost) {
    bool any = false;
    for (std::size_t j = 0; j < joints_; ++j) {
      const double room = rates[j] > 0 ? axes_[j].upper - q[j] : q[j] - axes_[j].lower;
      if (rates[j] == 0 || room >= kSpareFrom) continue;
      const double x = std::max(room - kOffLimit, 0.0) / kSpareFrom;
      solver.weigh(j, x * (2 - x));
      any = true;
    }
    if (any) {
      solver.decompose_again();
      lost = solver.exact(twist, rates);
    }
  }
  return lost <= kLostAtMost;
}

bool JogLine::tangent_at(std::span<const double> q, double way, JogValues& out) noexcept {
  return rates_for(direction_at(way), q, solver_, out);
}

bool JogLine::begin(std::span<const double> q, const Pose& tcp, const Twist& unit, bool turns, double speed,
                    double slope) noexcept {
  count_ = 0;
  start_ = tcp;
  unit_ = unit;
  turns_ = turns;
  state_ = {0, speed, slope};
  goal_ = speed;
  needed_ = apart_ = 0;
  ends_ = false;
  from_rest_ = is_known_ = speed == 0;
  end_ = {};
  stop_ = {};
  std::copy_n(q.begin(), joints_, q_.begin());
  solver_.at(q);
  put_on_line();
  if (!tangent_at({q_.data(), joints_}, 0, tangent_)) return false;
  bend_ = {};
  add(0, tangent_, 0);
  return true;
}

/// Joints that are a little beside the beginning of the path come onto it. The solver is at them.
void JogLine::put_on_line() noexcept {
  Twist error = between({solver_.position(), solver_.rotation()}, start_);
  if (solver_.columns() < 6) error[3] = error[4] = error[5] = 0;
  if (linear(error) / length_ + angular(error) < kOnIt) return;
  JogValues back;
  solver_.exact(error, back);
  for (std::size_t j = 0; j < joints_; ++j)
    if (std::abs(back[j]) > kBesideIt) return;
  for (std::size_t j = 0; j < joints_; ++j) q_[j] += back[j];
  solver_.at({q_.data(), joints_});
}

/// `step`: from the last node; 0: it is the first one.
void JogLine::add(double at, const JogValues& tangent, double step) noexcept {
  Node node;
  node.at = at;
  node.velocity = node.followed = node.acceleration = node.jerk = 1e300;
  double fastest = 0;
  JogValues bend{};
  for (std::size_t j = 0; j < joints_; ++j) {
    const AxisLimits& a = axes_[j];
    const double t = std::max(std::abs(tangent[j]), 1e-12);
    fastest = std::max(fastest, t);
    node.velocity = std::min(node.velocity, a.velocity / t);
    node.followed = std::min(node.followed, kStopsIn * a.acceleration / t);
    node.acceleration = std::min(node.acceleration, kPull * a.acceleration / t);
    node.jerk = std::min(node.jerk, kSnap * a.jerk / t);
  }
  for (std::size_t j = 0; step > 0 && j < joints_; ++j) {
    const AxisLimits& a = axes_[j];
    bend[j] = (tangent[j] - tangent_[j]) / step;
    const double b = std::max(std::abs(bend[j]), 1e-12);
    const bool has_two = count_ > 1 || from_rest_;
    const double c = has_two ? std::max(std::abs(bend[j] - bend_[j]) / step, 1e-12) : 1e-12;
    node.followed =
        std::min({node.followed, std::sqrt(kBend * a.acceleration / b), std::cbrt(kBendSnap * a.jerk / c),
                  kBoth * a.jerk / (3 * b * node.acceleration)});
  }
  // A translation by one reach, or a turn by a radian, takes about as much of a joint.
  const double needs = norm(part(unit_, 0)) / length_ + norm(part(unit_, 3));
  node.cause = fastest > kManyTimes * needs ? JogHold::singularity : JogHold::speed;
  if (step > 0) bend_ = bend;
  tangent_ = tangent;
  std::copy_n(q_.begin(), joints_, places_.begin() + static_cast<std::ptrdiff_t>(count_ * joints_));
  nodes_[count_++] = node;
}

void JogLine::stop_at(double at, JogHold hold, std::size_t which) noexcept {
  ends_ = true;
  end_ = {at, hold, which};
}

/// The share of a step of the joints that stays within their ranges.
double JogLine::before_limits(const JogValues& from, const JogValues& to, std::size_t& which) const noexcept {
  double share = 1, most = 0;
  for (std::size_t j = 0; j < joints_; ++j) most = std::max(most, std::abs(to[j] - from[j]));
  for (std::size_t j = 0; j < joints_; ++j) {
    const double by = to[j] - from[j];
    if (std::abs(by) <= kStill * most) continue;
    const double room = (by > 0 ? axes_[j].upper - from[j] : from[j] - axes_[j].lower) - kOffLimit;
    if (room >= std::abs(by)) continue;
    const double here = std::max(room, 0.0) / std::abs(by);
    if (here < share) share = here, which = j;
  }
  return share;
}

/// A node this far after the last one; false if the step is too long for the bend there.
bool JogLine::try_extend(double by) noexcept {
  const double from = nodes_[count_ - 1].at, at = from + by;
  JogValues q = q_, tangent, back;
  double most = 0, off = 0, turn = 0, size = 0;
  for (std::size_t j = 0; j < joints_; ++j) {
    q[j] += by * tangent_[j] + by * by / 2 * bend_[j];
    most = std::max(most, by * std::abs(tangent_[j]));
  }
  solver_.at({q.data(), joints_});
  Twist error = between({solver_.position(), solver_.rotation()}, pose_at(at));
  if (solver_.columns() < 6) error[3] = error[4] = error[5] = 0;
  const double lost = solver_.exact(error, back);
  for (std::size_t j = 0; j < joints_; ++j) {
    q[j] += back[j];
    off = std::max(off, std::abs(back[j]));
  }
  if (off > 0.05 * most + 1e-9) return false;
  if (lost > 0.5 && linear(error) / length_ + angular(error) > 1e-7) return false;
  solver_.at({q.data(), joints_});
  const bool is_exact = tangent_at({q.data(), joints_}, at, tangent);
  for (std::size_t j = 0; j < joints_; ++j) {
    turn = std::max(turn, std::abs(tangent[j] - tangent_[j]));
    size = std::max(size, std::abs(tangent_[j]));
  }
  if (!is_exact || turn > 0.3 * size + 1e-9) return false;
  std::size_t which = 0;
  const double share = before_limits(q_, q, which);
  if (share < 1) stop_at(from + share * by, JogHold::joint_limit, which);
  q_ = q;
  add(at, tangent, by);
  return true;
}

void JogLine::extend() noexcept {
  for (int k = 0; k < kAdds && !ends_ && count_ < kNodes; ++k) {
    const Node& last = nodes_[count_ - 1];
    const double fast = std::max(kApart * std::min({goal_, last.velocity, last.followed}), 10 * kShortest);
    if (last.at > state_.position + 1.2 * needed_ + 3 * fast) {
      is_known_ = true;
      return;
    }
    const double by = apart_ > 0 ? apart_ : fast;
    apart_ = try_extend(by) ? 0 : by / 2;
    if (apart_ > 0 && apart_ < kShortest) stop_at(last.at, JogHold::singularity, 0);
  }
}

/// What counts between a node and the next one.
JogLine::Node JogLine::between_nodes(std::size_t before) const noexcept {
  const Node& a = nodes_[before];
  if (before + 1 >= count_) return a;
  const Node& b = nodes_[before + 1];
  Node out = b.followed < a.followed ? b : a;
  out.velocity = std::min(a.velocity, b.velocity);
  out.acceleration = std::min(a.acceleration, b.acceleration);
  out.jerk = std::min(a.jerk, b.jerk);
  return out;
}

/// Goes along the path while it brakes. Sets stop_ if it is too fast somewhere.
bool JogLine::brakes_in_time(const AxisState& from, double joint_share, const Stop& stop) noexcept {
  double at = from.position, v = from.velocity, a = from.acceleration;
  std::size_t before = 0;
  Node here;
  int looks = 0;
  for (; looks < kMostLooks; ++looks) {
    while (before + 1 < count_ && nodes_[before + 1].at <= at) ++before;
    here = between_nodes(before);
    const double A = here.acceleration, J = here.jerk;
    if (v > std::min(joint_share * here.velocity, here.followed)) {
      stop_ = {0, joint_share * here.velocity < here.followed ? JogHold::speed : here.cause, 0};
      return false;
    }
    const bool rests = a <= 0 && v <= a * a / (2 * J) * 1.0001;
    if (rests || v <= 0) {  // the rest of the way with the jerk back
      at += std::abs(a) * a * a / (6 * J * J);
      break;
    }
    double next = std::max(a - J * kLookStep, -A), t = kLookStep;
    if (a < -A) next = std::min(a + J * kLookStep, -A);
    // It begins to release the brake within this step.
    if (const double after = v + t * (a + next) / 2; after <= next * next / (2 * J))
      t = kLookStep / 8, next = std::max(a - J * t, -A);
    at += t * (v + t * (2 * a + next) / 6);
    v += t * (a + next) / 2;
    a = next;
  }
  needed_ = std::max(0.0, at - state_.position);
  if (looks == kMostLooks) {  // it rests farther away than it looks
    stop_ = {0, JogHold::speed, 0};
    return false;
  }
  if (!ends_ && is_known_ && at > nodes_[count_ - 1].at) {
    stop_ = {0, JogHold::speed, 0};
    return false;
  }
  if (ends_ && at > end_.room) {
    stop_ = {0, end_.hold, end_.which};
    return false;
  }
  if (at > stop.room) {
    stop_ = {0, stop.hold, stop.which};
    return false;
  }
  return true;
}

void JogLine::step(double goal, double joint_share, const Stop& stop) noexcept {
  goal_ = std::max(goal, state_.velocity);
  while (count_ > 2 && nodes_[1].at < state_.position) {
    std::copy(nodes_.begin() + 1, nodes_.begin() + static_cast<std::ptrdiff_t>(count_), nodes_.begin());
    std::copy(places_.begin() + static_cast<std::ptrdiff_t>(joints_),
              places_.begin() + static_cast<std::ptrdiff_t>(count_ * joints_), places_.begin());
    --count_;
  }
  extend();
  std::size_t before = 0;
  while (before + 1 < count_ && nodes_[before + 1].at <= state_.position) ++before;
  const Node here = between_nodes(before);
  const Stop there{state_.position + stop.room, stop.hold, stop.which};
  stop_ = {};
  const auto braked_with = [&](double harder) {
    AxisState out = AxisBrake(state_, harder * here.acceleration, harder * here.jerk).at(dt_);
    if (out.velocity < 0) out = {state_.position, 0, 0};
    return out;
  };
  AxisLimits own;
  own.acceleration = here.acceleration;
  own.jerk = here.jerk;
  const AxisState wanted = towards_velocity(state_, goal, 0, own, dt_);
  braked_ = braked_with(kHarder);
  if (brakes_in_time(wanted, joint_share, there)) {
    stop_ = {};
    state_ = stepped_ = wanted;
    return;
  }
  const Stop why = stop_;
  const AxisState braked = braked_with(1);
  double low = 0, high = 1;
  if (brakes_in_time(braked, joint_share, there)) {
    for (int i = 0; i < kBisections; ++i) {
      const double middle = (low + high) / 2;
      (brakes_in_time(mixed(braked, wanted, middle), joint_share, there) ? low : high) = middle;
    }
    state_ = mixed(braked, wanted, low);
  } else {
    state_ = braked_;
  }
  stop_ = why;
  stepped_ = state_;
}

void JogLine::brake_instead() noexcept {
  state_ = braked_;
}

void JogLine::take_back(double share) noexcept {
  state_ = mixed(braked_, stepped_, share);
}

void JogLine::fall_back(const Pose& tcp, const Twist& twist) noexcept {
  const Twist along = direction(), error = between(pose(), tcp);
  double off = 0, speed = 0, size = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    const double weight = (k < 3 ? 1 : length_ * length_) * along[k];
    off += weight * error[k];
    speed += weight * twist[k];
    size += weight * along[k];
  }
  state_ = {state_.position + off / size, std::max(0.0, speed / size), 0};
}

}  // namespace polyarm::jog
