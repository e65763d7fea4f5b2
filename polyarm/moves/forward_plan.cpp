#include "polyarm/moves/forward_plan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "polyarm/hardware/forward_moves.hpp"

namespace polyarm::moves {

using hardware::ForwardMove;

namespace {

using Values = std::vector<double>;
constexpr int kSamples = 48;       // of a move
constexpr double kNoTime = 1e-6;   // s; shorter moves are left out
constexpr double kNoSpeed = 1e-4;  // m/s: the TCP only turns
constexpr double kLeastShare = 0.01;

class ForwardPlan {
 public:
  ForwardPlan(const RobotFacts& robot, std::span<const Move> moves, const PlannedMotion& motion, double begin,
              double tcp_ceiling)
      : robot_(robot),
        moves_(moves),
        motion_(motion),
        begin_(begin),
        tcp_ceiling_(tcp_ceiling),
        q_(motion.path.joints()),
        dq_(q_.size()) {}

  std::vector<ForwardMove> run() {
    double from = begin_;
    for (std::size_t i = motion_.first; i <= motion_.last; ++i) {
      const double to = time_of_end(i);
      if (to - from < kNoTime) continue;
      if (moves_[i].over.empty())
        add(i, from, to);
      else
        add_corners(i, from, to);
      from = to;
    }
    if (!out_.empty()) out_.back().stops = true;
    shrink_blends();
    return std::move(out_);
  }

 private:
  double time_of_end(std::size_t move) const {
    const std::size_t k = move - motion_.first;
    if (move >= motion_.last || k >= motion_.ends.size()) return motion_.path.duration();
    return motion_.path.profile().time_at(motion_.ends[k]);
  }

  void sample(double time) {
    std::size_t hint = 0;
    motion_.path.sample(time, q_, dq_, {}, {}, hint);
  }

  /// The joints at the end of a move; with a blend, the path does not pass them.
  Values corner(std::size_t move, double time) {
    sample(time);
    if (move == motion_.last) return q_;
    const MoveTarget& target = moves_[move].end();
    if (const Values* joints = std::get_if<Values>(&target.at)) return *joints;
    return joints_for(robot_, std::get<Pose>(target.at), q_, target.name);
  }

  ForwardMove made(std::size_t move, double from, double to, const Values& end) {
    ForwardMove out;
    const Move& of = moves_[move];
    out.kind = of.kind == MoveKind::joint  ? ForwardMove::Kind::joint
               : of.kind == MoveKind::line ? ForwardMove::Kind::line
                                           : ForwardMove::Kind::arc;
    std::copy_n(end.begin(), std::min(end.size(), out.joints.size()), out.joints.begin());
    out.at = robot_.chain.forward(end);
    sample((from + to) / 2);
    out.via = robot_.chain.forward(q_);
    out.acceleration = std::clamp(of.acceleration, kLeastShare, 1.0);
    out.duration = to - from;
    double most = of.tcp_speed;
    if (tcp_ceiling_ > 0) most = most > 0 ? std::min(most, tcp_ceiling_) : tcp_ceiling_;
    measure(from, to, most, out);
    return out;
  }

  /// The highest speeds of the plan between two times. The plan slows down only where the TCP is fast; a
  /// robot has one speed for a joint move, so it gets the one with which the TCP stays below `most` (m/s; 0:
  /// unlimited) everywhere.
  void measure(double from, double to, double most, ForwardMove& out) {
    double share = kLeastShare, speed = 0,
           reach = 0;  // reach: m/s of the TCP at the full speed of the joints
    Vec3 before;
    Values last;
    const double step = (to - from) / kSamples;
    for (int k = 0; k <= kSamples; ++k) {
      sample(from + k * step);
      for (std::size_t j = 0; j < q_.size(); ++j)
        share = std::max(share, std::abs(dq_[j]) / robot_.limits[j].velocity);
      const Vec3 here = robot_.chain.forward(q_).position;
      if (k > 0) {
        const double way = norm(here - before);
        speed = std::max(speed, way / step);
        double turned = 0;  // s, at the full speed of the joints
        for (std::size_t j = 0; j < q_.size(); ++j)
          turned = std::max(turned, std::abs(q_[j] - last[j]) / robot_.limits[j].velocity);
        if (turned > kNoTime * kNoTime) reach = std::max(reach, way / turned);
      }
      before = here;
      last = q_;
    }
    if (out.kind == ForwardMove::Kind::joint && most > 0 && reach > 0) share = std::min(share, most / reach);
    out.share = std::clamp(share, kLeastShare, 1.0);
    out.speed = speed < kNoSpeed ? 0 : speed;
  }

  void add(std::size_t move, double from, double to) {
    ForwardMove one = made(move, from, to, corner(move, to));
    one.blend = move == motion_.last ? 0 : moves_[move].blend;
    one.stops = !(one.blend > 0);
    out_.push_back(one);
  }

  /// Joint moves over the corners that are still ahead, with a stop at each.
  void add_corners(std::size_t move, double from, double to) {
    double last = from;
    for (const Move::Corner& corner : moves_[move].over) {
      const double time = nearest(corner.at, from, to);
      if (time <= from + kNoTime) continue;
      out_.push_back(made(move, std::min(last, time), std::max(last, time), corner.at));
      last = time;
    }
    out_.push_back(made(move, std::min(last, to), to, corner(move, to)));
  }

  double nearest(const Values& joints, double from, double to) {
    constexpr int kPlaces = 400;
    double best = from, least = INFINITY;
    for (int k = 0; k <= kPlaces; ++k) {
      const double time = from + (to - from) * k / kPlaces;
      sample(time);
      double sum = 0;
      for (std::size_t j = 0; j < q_.size(); ++j) sum += (q_[j] - joints[j]) * (q_[j] - joints[j]);
      if (sum < least) least = sum, best = time;
    }
    return best;
  }

  void shrink_blends() {
    sample(begin_);
    Vec3 before = robot_.chain.forward(q_).position;
    for (std::size_t i = 0; i < out_.size(); ++i) {
      const Vec3 here = out_[i].at.position;
      const double way = norm(here - before);
      if (i > 0 && out_[i - 1].blend > 0) out_[i - 1].blend = std::min(out_[i - 1].blend, way / 2);
      if (out_[i].blend > 0) out_[i].blend = std::min(out_[i].blend, way / 2);
      before = here;
    }
  }

  const RobotFacts& robot_;
  std::span<const Move> moves_;
  const PlannedMotion& motion_;
  double begin_, tcp_ceiling_;
  Values q_, dq_;
  std::vector<ForwardMove> out_;
};

}  // namespace

std::optional<Problem> refuse_forward(const Move& move, const std::string& robot) {
  const auto no = [&](const char* what, const char* advice) {
    return Problem{"forward-mode",
                   {},
                   "'" + robot + "' has `motion: forward`, and its controller takes no " + what,
                   advice};
  };
  if (move.kind == MoveKind::spline)
    return no("curves through several poses (`smooth`)", "write movel with a blend, or set `motion: stream`");
  if (move.through)
    return no("curves through joint states", "give each point a blend, or set `motion: stream`");
  return std::nullopt;
}

std::unique_ptr<controllers::ForwardMotion> forward_motion(const RobotFacts& robot,
                                                           std::span<const Move> moves,
                                                           const PlannedMotion& motion, double begin,
                                                           double tcp_ceiling) {
  return std::make_unique<controllers::ForwardMotion>(
      motion.path, ForwardPlan(robot, moves, motion, begin, tcp_ceiling).run(), begin);
}

}  // namespace polyarm::moves
