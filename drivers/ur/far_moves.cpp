#include "drivers/ur/far_moves.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/ur/arm_kinematics.hpp"
#include "drivers/ur/near_joints.hpp"
#include "drivers/wire/arcs.hpp"

namespace polyarm::ur {

using wire::between;
using wire::Circle;

namespace {

constexpr double kStop = 4;          // rad/s², as in the driver's program
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

Pose FarMoves::tcp(const Six& q) const {
  std::array<double, 36> J;
  return flange_jacobian(machine_.options().facts.arm, q, J) * tool_;
}

void FarMoves::begin() {
  forget();
  tool_ = {};
  halting_ = 0;
  machine_.set_register("output_int_register_26", 0);
  machine_.set_register("output_int_register_27", 0);
}

void FarMoves::forget() {
  waiting_.clear();
  part_ = ahead_ = {};
  halting_ = 0;
}

bool FarMoves::take(const MoveMessage& message) {
  switch (message.work) {
    case Work::joint:
    case Work::line:
    case Work::arc:
      if (waiting_.size() >= kMoveSlots) return false;
      waiting_.push_back(message);
      return true;
    case Work::halt:
      forget();
      machine_.brake(kStop);
      halting_ = message.number;
      return true;
    case Work::tool: {
      const Six& p = message.goal;
      const Vec3 turn{p[3], p[4], p[5]};
      tool_ = {{p[0], p[1], p[2]}, from_axis_angle(normalized(turn), norm(turn))};
      return true;
    }
    default:
      return true;
  }
}

// --- the way of a move ----------------------------------------------------------------------------------

bool FarMoves::shape_path(const MoveMessage& move, const Six& from, std::vector<Six>& out) const {
  out.assign(1, from);
  if (move.work == Work::joint) {
    double most = 0;
    for (std::size_t i = 0; i < 6; ++i) most = std::max(most, std::abs(move.goal[i] - from[i]));
    const int steps = std::clamp(static_cast<int>(std::ceil(most / kJointStep)), 2, kMostSteps);
    for (int k = 1; k <= steps; ++k) out.push_back(mixed(from, move.goal, static_cast<double>(k) / steps));
    return true;
  }
  const Pose begin = tcp(from), end = tcp(move.goal);
  const double turn = angle_between(begin.rotation, end.rotation);
  std::optional<Circle> circle;
  double whole = 0, length = norm(end.position - begin.position);
  if (move.work == Work::arc) {
    circle = Circle::through(begin.position, tcp(move.via).position, end.position);
    if (!circle) return false;
    whole = circle->angle_of(end.position);
    length = whole * norm(circle->arm);
  }
  const int steps = steps_of(length, turn);
  const auto jacobian = [this](const Six& q, std::array<double, 36>& J) {
    return flange_jacobian(machine_.options().facts.arm, q, J);
  };
  for (int k = 1; k <= steps; ++k) {
    const double share = static_cast<double>(k) / steps;
    const Vec3 place =
        circle ? circle->point(share * whole) : begin.position + share * (end.position - begin.position);
    const Pose at{place, between(begin.rotation, end.rotation, share)};
    const auto q = near_joints(jacobian, at * inverse(tool_), out.back());
    if (!q) return false;
    for (std::size_t i = 0; i < 6; ++i)
      if (std::abs((*q)[i] - out.back()[i]) > kJump) return false;
    out.push_back(*q);
  }
  return true;
}

void FarMoves::set_speeds(const MoveMessage& move, Part& part) const {
  const double whole = part.length();
  part.limit.assign(part.q.size(), 0);
  if (move.work == Work::joint) {
    double most = 0;
    for (std::size_t i = 0; i < 6; ++i) most = std::max(most, std::abs(part.q.back()[i] - part.q.front()[i]));
    const double gear = most > kNothing ? whole / most : 1;
    part.acceleration = move.acceleration * gear;
    std::fill(part.limit.begin(), part.limit.end(), move.speed * gear);
    return;
  }
  if (move.time > 0) {  // time = way / speed + speed / acceleration
    const double a = kTurning, inside = a * a * move.time * move.time - 4 * a * whole;
    const double speed = inside > 0 ? (a * move.time - std::sqrt(inside)) / 2 : a * move.time / 2;
    part.acceleration = a;
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

bool FarMoves::shape(const MoveMessage& move, const Six& from, Part& out) const {
  out = {};
  if (!shape_path(move, from, out.q)) return false;
  out.at = ways(out.q);
  set_speeds(move, out);
  return out.acceleration > 0 && std::isfinite(out.acceleration);
}

/// Where the TCP is `blend` from the corner, the part ends.
void FarMoves::cut_end(const MoveMessage& move, Part& part) const {
  const Vec3 corner = tcp(part.q.back()).position;
  std::size_t keep = part.q.size() - 1;
  while (keep > 1 && norm(tcp(part.q[keep]).position - corner) < move.blend) --keep;
  const Six within = part.q[std::min(keep + 1, part.q.size() - 1)];
  const double near = norm(tcp(within).position - corner);
  const double far = norm(tcp(part.q[keep]).position - corner);
  const double share = far - near > kNothing ? std::clamp((far - move.blend) / (far - near), 0.0, 1.0) : 0;
  const Six last = mixed(part.q[keep], within, share);
  part.q.resize(keep + 1);
  part.limit.resize(keep + 1);
  part.q.push_back(last);
  part.limit.push_back(part.limit.back());
  part.at = ways(part.q);
}

/// `next` begins with a curve from the end of `before` to the place `blend` behind the corner.
bool FarMoves::round_corner(const Part& before, double blend, Part& next) const {
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
void FarMoves::slow_down(Part& part, double last) const {
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
bool FarMoves::prepare_end() {
  MoveMessage& move = waiting_.front();
  const bool rounds = move.blend > 0 && waiting_.size() > 1;
  if (!rounds) {
    move.blend = 0;
    slow_down(part_, 0);
    return true;
  }
  const Six corner = part_.q.back();
  cut_end(move, part_);
  if (!shape(waiting_[1], corner, ahead_)) return false;
  Part next = ahead_;
  if (!round_corner(part_, move.blend, next)) return false;
  slow_down(next, 0);
  slow_down(part_, next.limit.front());
  return true;
}

/// A move begins from rest.
bool FarMoves::start() {
  const bool ready = waiting_.size() > 1 || (waiting_.size() == 1 && waiting_.front().blend <= 0);
  if (!ready || !machine_.still()) return false;
  way_ = speed_ = 0;
  if (shape(waiting_.front(), machine_.q(), part_) && prepare_end()) return true;
  part_ = {};
  machine_.safety(protective_stop);  // a path that the arm cannot follow
  return false;
}

void FarMoves::end_part() {
  const MoveMessage ended = waiting_.front();
  waiting_.pop_front();
  machine_.set_register("output_int_register_26", ended.number);
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
  machine_.safety(protective_stop);
}

void FarMoves::step(double dt) {
  pace_ += std::clamp(machine_.speed_slider() - pace_, -dt / kSliderRamp, dt / kSliderRamp);
  if (halting_ != 0) {
    if (!machine_.still()) return;
    machine_.set_register("output_int_register_27", halting_);
    halting_ = 0;
  }
  if (!machine_.may_move()) return interrupt();
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
  way_ += std::max(speed_, change) * time;
  if (way_ >= part_.length()) {
    machine_.follow(part_.q.back());
    return end_part();
  }
  const auto after = std::upper_bound(part_.at.begin(), part_.at.end(), way_);
  const auto n =
      std::clamp<std::size_t>(static_cast<std::size_t>(after - part_.at.begin()), 1, part_.at.size() - 1);
  const double gap = part_.at[n] - part_.at[n - 1];
  machine_.follow(mixed(part_.q[n - 1], part_.q[n], gap > kNothing ? (way_ - part_.at[n - 1]) / gap : 1));
}

}  // namespace polyarm::ur
