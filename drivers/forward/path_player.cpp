#include "drivers/forward/path_player.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/forward/near_joints.hpp"
#include "drivers/wire/arcs.hpp"

namespace polyarm::forward {

using wire::between;
using wire::Circle;
using Kind = hardware::ForwardMove::Kind;

namespace {

constexpr double kJointStep = 0.02;  // rad between two places of a joint move
constexpr double kLineStep = 0.005;  // m, of a line or an arc
constexpr double kTurnStep = 0.03;   // rad
constexpr int kMostSteps = 1000;
constexpr int kCornerSteps = 12;
constexpr double kJump = 0.3;       // rad between two places: a change of the arm's configuration
constexpr double kTurning = 5;      // rad/s², of a move that states its time
constexpr double kHardBraking = 3;  // times the acceleration, where a blend begins too fast
constexpr double kNothing = 1e-9;

Six mixed(const Six& a, const Six& b, double share) {
  Six out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = a[i] + share * (b[i] - a[i]);
  return out;
}

double distance(const Six& a, const Six& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 6; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

int steps_of(double length, double turn) {
  return std::clamp(static_cast<int>(std::ceil(length / kLineStep + turn / kTurnStep)), 2, kMostSteps);
}

std::vector<double> ways(const std::vector<Six>& q) {
  std::vector<double> out(q.size(), 0);
  for (std::size_t k = 1; k < q.size(); ++k) out[k] = out[k - 1] + distance(q[k - 1], q[k]);
  return out;
}

}  // namespace

Pose PathPlayer::tcp(const Six& q) const {
  std::array<double, 36> J;
  return arm_.flange(q, J) * tool_;
}

void PathPlayer::forget() {
  waiting_.clear();
  part_ = ahead_ = {};
}

bool PathPlayer::take(const PlayedMove& move) {
  if (waiting_.size() >= slots_) return false;
  waiting_.push_back(move);
  return true;
}

void PathPlayer::end_last() {
  if (waiting_.empty() || (waiting_.size() == 1 && part_.under_way())) return;
  waiting_.back().blend = waiting_.back().blend_share = 0;
}

void PathPlayer::change_pace(double share, double dt) {
  pace_ += std::clamp(share - pace_, -dt / kPaceRamp, dt / kPaceRamp);
}

// --- the way of a move ----------------------------------------------------------------------------------

bool PathPlayer::shape_path(const PlayedMove& move, const Six& from, std::vector<Six>& out) const {
  out.assign(1, from);
  if (move.kind == Kind::joint) {
    double most = 0;
    for (std::size_t i = 0; i < 6; ++i) most = std::max(most, std::abs(move.goal[i] - from[i]));
    const int steps = std::clamp(static_cast<int>(std::ceil(most / kJointStep)), 2, kMostSteps);
    for (int k = 1; k <= steps; ++k) out.push_back(mixed(from, move.goal, static_cast<double>(k) / steps));
    return true;
  }
  const Pose begin = tcp(from), end = move.end ? *move.end : tcp(move.goal);
  const double turn = angle_between(begin.rotation, end.rotation);
  std::optional<Circle> circle;
  double whole = 0, length = norm(end.position - begin.position);
  if (move.kind == Kind::arc) {
    const Vec3 via = move.via_point ? *move.via_point : tcp(move.via).position;
    circle = Circle::through(begin.position, via, end.position);
    if (!circle) return false;
    whole = circle->angle_of(end.position);
    length = whole * norm(circle->arm);
  }
  const int steps = steps_of(length, turn);
  for (int k = 1; k <= steps; ++k) {
    const double share = static_cast<double>(k) / steps;
    const Vec3 place =
        circle ? circle->point(share * whole) : begin.position + share * (end.position - begin.position);
    const Pose at{place, between(begin.rotation, end.rotation, share)};
    const auto q = near_joints(arm_.flange, at * inverse(tool_), out.back());
    if (!q) return false;
    for (std::size_t i = 0; i < 6; ++i)
      if (std::abs((*q)[i] - out.back()[i]) > kJump) return false;
    out.push_back(*q);
  }
  return true;
}

/// At which a way takes this time: time = way / speed + speed / acceleration.
double PathPlayer::speed_for(double time, double way, double acceleration) {
  const double reached = acceleration * time, inside = reached * reached - 4 * acceleration * way;
  return inside > 0 ? (reached - std::sqrt(inside)) / 2 : reached / 2;
}

/// Of the joint that turns most; with a share, no joint exceeds that share of its speed.
void PathPlayer::set_joint_speeds(const PlayedMove& move, Part& part) const {
  const Six &from = part.q.front(), &to = part.q.back();
  double most = 0;
  for (std::size_t i = 0; i < 6; ++i) most = std::max(most, std::abs(to[i] - from[i]));
  double speed = move.speed, acceleration = move.acceleration;
  const double share = move.joint_time > 0 ? 1 : move.share;
  if (share > 0) {
    speed = acceleration = INFINITY;
    for (std::size_t i = 0; i < 6; ++i) {
      const double way = std::abs(to[i] - from[i]);
      const double gear = most > kNothing && way > kNothing ? most / way : most > kNothing ? INFINITY : 1;
      speed = std::min(speed, share * arm_.velocity[i] * gear);
      acceleration = std::min(acceleration, move.acceleration * arm_.acceleration[i] * gear);
    }
  }
  if (move.joint_time > 0) speed = std::min(speed, speed_for(move.joint_time, most, acceleration));
  const double gear = most > kNothing ? part.length() / most : 1;
  part.acceleration = acceleration * gear;
  std::fill(part.limit.begin(), part.limit.end(), speed * gear);
}

double PathPlayer::way_of_tcp(const Part& part) const {
  double out = 0;
  for (std::size_t k = 1; k < part.q.size(); ++k)
    out += norm(tcp(part.q[k]).position - tcp(part.q[k - 1]).position);
  return out;
}

void PathPlayer::set_speeds(const PlayedMove& move, Part& part) const {
  const double whole = part.length();
  part.limit.assign(part.q.size(), 0);
  if (move.kind == Kind::joint) return set_joint_speeds(move, part);
  double time = move.time;
  if (move.turn > 0)
    time = angle_between(tcp(part.q.front()).rotation, tcp(part.q.back()).rotation) / move.turn;
  if (time > 0) {
    const double speed = speed_for(time, whole, kTurning);
    part.acceleration = kTurning;
    std::fill(part.limit.begin(), part.limit.end(), std::max(speed, 1e-3));
    return;
  }
  double length = 0;
  for (std::size_t k = 1; k < part.q.size(); ++k) {
    const double way = norm(tcp(part.q[k]).position - tcp(part.q[k - 1]).position);
    length += way;
    part.limit[k] = way > kNothing ? move.speed * (part.at[k] - part.at[k - 1]) / way : 0.5;
  }
  part.limit[0] = part.limit[1];
  part.acceleration = length > kNothing ? move.acceleration * whole / length : kTurning;
}

bool PathPlayer::shape(const PlayedMove& move, const Six& from, Part& out) const {
  out = {};
  if (!shape_path(move, from, out.q)) return false;
  out.at = ways(out.q);
  set_speeds(move, out);
  return out.acceleration > 0 && std::isfinite(out.acceleration);
}

/// Where the TCP is `blend` from the corner, the part ends.
void PathPlayer::cut_end(double blend, Part& part) const {
  const Vec3 corner = tcp(part.q.back()).position;
  std::size_t keep = part.q.size() - 1;
  while (keep > 1 && norm(tcp(part.q[keep]).position - corner) < blend) --keep;
  const Six within = part.q[std::min(keep + 1, part.q.size() - 1)];
  const double near = norm(tcp(within).position - corner);
  const double far = norm(tcp(part.q[keep]).position - corner);
  const double share = far - near > kNothing ? std::clamp((far - blend) / (far - near), 0.0, 1.0) : 0;
  const Six last = mixed(part.q[keep], within, share);
  part.q.resize(keep + 1);
  part.limit.resize(keep + 1);
  part.q.push_back(last);
  part.limit.push_back(part.limit.back());
  part.at = ways(part.q);
}

/// `next` begins with a curve from the end of `before` to the place `blend` behind the corner.
bool PathPlayer::round_corner(const Part& before, double blend, Part& next) const {
  const Six corner = next.q.front();
  const Vec3 place = tcp(corner).position;
  std::size_t first = 1;
  while (first < next.q.size() && norm(tcp(next.q[first]).position - place) < blend) ++first;
  if (first >= next.q.size()) return false;
  const Six from = before.q.back(), to = next.q[first];
  std::vector<Six> q{from};
  for (int k = 1; k < kCornerSteps; ++k) {
    const double t = static_cast<double>(k) / kCornerSteps;
    q.push_back(mixed(mixed(from, corner, t), mixed(corner, to, t), t));
  }
  const double length = ways(q).back() + distance(q.back(), to);
  const double most = std::min({before.limit.back(), next.limit[first],
                                std::sqrt(std::min(before.acceleration, next.acceleration) * length)});
  std::vector<double> limit(q.size(), most);
  q.insert(q.end(), next.q.begin() + static_cast<std::ptrdiff_t>(first), next.q.end());
  limit.insert(limit.end(), next.limit.begin() + static_cast<std::ptrdiff_t>(first), next.limit.end());
  next.q = std::move(q);
  next.limit = std::move(limit);
  next.at = ways(next.q);
  return true;
}

/// Every speed from which the part still comes down to `last` at its end.
void PathPlayer::slow_down(Part& part, double last) const {
  part.limit.back() = std::min(part.limit.back(), last);
  for (std::size_t k = part.q.size() - 1; k-- > 0;) {
    const double reach =
        part.limit[k + 1] * part.limit[k + 1] + 2 * part.acceleration * (part.at[k + 1] - part.at[k]);
    part.limit[k] = std::min(part.limit[k], std::sqrt(reach));
  }
}

// --- time -----------------------------------------------------------------------------------------------

/// `part_` is the first waiting move: it ends at rest, or where its blend begins, at a speed from which the
/// next move still comes to rest.
bool PathPlayer::prepare_end() {
  PlayedMove& move = waiting_.front();
  if (move.blend_share > 0) move.blend = move.blend_share * way_of_tcp(part_) / 2;
  const bool rounds = move.blend > 0 && waiting_.size() > 1;
  if (!rounds) {
    move.blend = 0;
    slow_down(part_, 0);
    return true;
  }
  const Six corner = part_.q.back();
  cut_end(move.blend, part_);
  if (!shape(waiting_[1], corner, ahead_)) return false;
  Part next = ahead_;
  if (!round_corner(part_, move.blend, next)) return false;
  slow_down(next, 0);
  slow_down(part_, next.limit.front());
  return true;
}

/// A move begins from rest.
bool PathPlayer::start() {
  const bool ready = waiting_.size() > 1 || (waiting_.size() == 1 && waiting_.front().blend <= 0 &&
                                             waiting_.front().blend_share <= 0);
  if (!ready || !arm_.still()) return false;
  way_ = speed_ = 0;
  if (shape(waiting_.front(), arm_.q(), part_) && prepare_end()) return true;
  part_ = {};
  arm_.refuse();
  return false;
}

void PathPlayer::end_part() {
  const PlayedMove ended = waiting_.front();
  waiting_.pop_front();
  arm_.ended(ended.number);
  if (ended.blend <= 0) {
    part_ = {};
    return;
  }
  Part next = std::move(ahead_);
  round_corner(part_, ended.blend, next);
  part_ = std::move(next);
  way_ = 0;
  if (prepare_end()) return;
  part_ = {};
  arm_.refuse();
}

void PathPlayer::step(double dt) {
  if (!arm_.may_move()) return interrupt();
  if (!part_.under_way() && !start()) return;
  const double time = dt * pace_, change = part_.acceleration * time;
  const auto above = std::upper_bound(part_.at.begin(), part_.at.end(), way_);
  const auto k =
      std::clamp<std::size_t>(static_cast<std::size_t>(above - part_.at.begin()), 1, part_.at.size() - 1);
  const double span = part_.at[k] - part_.at[k - 1];
  const double share = span > kNothing ? std::clamp((way_ - part_.at[k - 1]) / span, 0.0, 1.0) : 1;
  const double most = std::sqrt((1 - share) * part_.limit[k - 1] * part_.limit[k - 1] +
                                share * part_.limit[k] * part_.limit[k]);
  speed_ = std::max(std::min(speed_ + change, most), speed_ - kHardBraking * change);
  // Never so slow that it does not arrive.
  const double cruise = std::max(part_.limit[k - 1], part_.limit[k]);
  way_ += std::max(speed_, cruise > 0 ? std::min(change, cruise) : change) * time;
  if (way_ >= part_.length()) {
    arm_.follow(part_.q.back());
    return end_part();
  }
  const auto after = std::upper_bound(part_.at.begin(), part_.at.end(), way_);
  const auto n =
      std::clamp<std::size_t>(static_cast<std::size_t>(after - part_.at.begin()), 1, part_.at.size() - 1);
  const double gap = part_.at[n] - part_.at[n - 1];
  arm_.follow(mixed(part_.q[n - 1], part_.q[n], gap > kNothing ? (way_ - part_.at[n - 1]) / gap : 1));
}

}  // namespace polyarm::forward
