#include "polyarm/moves/move_timing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "polyarm/moves/path_zones.hpp"
#include "polyarm/paths/joined_path.hpp"

namespace polyarm::moves {

using paths::JoinedPath;
using paths::Path;
using timing::NormLimit;
using trajectory::MotionLimits;

namespace {

using Values = std::vector<double>;
using PathPtr = std::shared_ptr<const Path>;
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr int kSamples = 32;          // for a spline of joint moves
constexpr int kTorqueRounds = 4;      // rounds of reducing the acceleration because of torques
constexpr double kTorqueRoom = 0.99;  // a margin in each round, because the times shift
constexpr double kJerkOf = 10;        // per s: jerk per acceleration, if only the acceleration is stated

class MoveTimer {
 public:
  MoveTimer(const PlanRequest& request, const MoveDraft& draft, std::span<const MotionLimits> limits)
      : r_(request), draft_(draft), limits_(limits) {}

  PlannedMotion run() {
    const std::size_t n = r_.robot.chain.joints();
    auto joints = std::make_shared<JoinedPath>(n);
    auto translation = std::make_shared<JoinedPath>(3), rotation = std::make_shared<JoinedPath>(3);
    ZoneLimits on_translation, on_rotation, on_parameter;
    PlannedMotion motion;
    motion.first = draft_.front().moves.front().move;
    motion.last = draft_.back().moves.back().move;
    motion.ends.resize(motion.last - motion.first + 1);
    for (const MovePart& part : draft_) {
      const double begin = joints->length();
      const std::vector<MoveSpan> pieces =
          part.joins ? std::vector<MoveSpan>{part.moves.front()} : alike(part.moves);
      for (const MoveSpan& span : pieces) {  // a bound can only change at a break
        const double from = std::max(span.from, part.from), to = std::min(span.to, part.to);
        if (!(to > from)) continue;
        joints->append(part.joints, from, to, part.scale);
        translation->append(part.translation, from, to, part.scale);
        rotation->append(part.rotation, from, to, part.scale);
      }
      for (const MoveSpan& span : part.moves) {
        const double from = begin + (std::max(span.from, part.from) - part.from) * part.scale;
        const double to = begin + (std::min(span.to, part.to) - part.from) * part.scale;
        if (is_bounded(part, span.move)) bound(span.move, from, to, on_translation, on_rotation);
        const Pace pace = pace_of(part, span);
        on_parameter.add(from, to, pace.speed, pace.acceleration, pace.jerk);
        motion.ends[span.move - motion.first] = to;
      }
    }
    check_place(*joints, motion);
    ZoneNorms norms;
    norms.add(translation, on_translation, "the TCP's way");
    norms.add(rotation, on_rotation, "the TCP's turn");
    norms.add(std::make_shared<ParameterPath>(joints), on_parameter, "the limits of the move");
    time(std::move(joints), norms, motion);
    return motion;
  }

 private:
  /// The parameter speeds that the joint limits allow in a joint move, and additional bounds of the move.
  struct Pace {
    double speed = kInfinite, acceleration = kInfinite, jerk = kInfinite;
  };
  Pace pace_of(const MovePart& part, const MoveSpan& span) const {
    const Move& move = r_.moves[span.move];
    Pace out;
    const double length = (span.to - span.from) * part.scale;
    if (!alone(span.move)) {
      if (move.duration > 0) out.speed = length / move.duration;
      if (move.joint_pace > 0 && !is_cartesian(move))
        out.speed = std::min(out.speed, part.scale / move.joint_pace);
    }
    if (is_cartesian(move) ||
        (move.speed >= 1 && move.acceleration >= 1 && move.joint_speed <= 0 && move.joint_acceleration <= 0))
      return out;
    Values q(limits_.size()), first(q.size());
    double speed = kInfinite, acceleration = kInfinite, jerk = kInfinite, fastest = 0;
    const double from = std::max(span.from, part.from), to = std::min(span.to, part.to);
    const int places = part.curve ? kSamples : 1;  // a line has the same derivatives everywhere
    for (int k = 0; k < places; ++k) {
      part.joints->at(from + (to - from) * (k + 0.5) / places, {q, first, {}, {}});
      for (std::size_t j = 0; j < first.size(); ++j) {
        const double rate = std::abs(first[j]) / part.scale;
        speed = std::min(speed, limits_[j].max_velocity / rate);
        acceleration = std::min(acceleration, limits_[j].max_acceleration / rate);
        jerk = std::min(jerk, limits_[j].max_jerk / rate);
        fastest = std::max(fastest, rate);
      }
    }
    out.speed = std::min(out.speed, move.speed * speed);
    if (move.joint_speed > 0) out.speed = std::min(out.speed, move.joint_speed / fastest);
    double share = move.acceleration;
    if (move.joint_acceleration > 0)
      share = std::min(share, move.joint_acceleration / (fastest * acceleration));
    if (share < 1) out.acceleration = share * acceleration, out.jerk = share * jerk;
    return out;
  }
  bool alone(std::size_t move) const {
    for (const MovePart& part : draft_)
      for (const MoveSpan& span : part.moves)
        if (span.move != move) return false;
    return true;
  }

  /// True if the move states a bound of the TCP on this part.
  bool is_bounded(const MovePart& part, std::size_t move) const {
    const bool says = is_cartesian(r_.moves[move]) || needs_tcp(r_, move, move);
    return says || (!part.joins && part.translation != part.rotation);
  }
  void bound(std::size_t move, double from, double to, ZoneLimits& translation, ZoneLimits& rotation) const {
    const Move& m = r_.moves[move];
    const bool own = is_cartesian(m);
    const auto of = [&](double stated, double limit, double share) {
      return stated > 0 ? stated : own ? limit * share : kInfinite;
    };
    const TcpLimits& tcp = r_.robot.tcp;
    double speed = of(m.tcp_speed, tcp.speed, m.speed);
    if (r_.options.tcp_ceiling > 0) speed = std::min(speed, r_.options.tcp_ceiling);
    translation.add(from, to, speed, of(m.tcp_acceleration, tcp.acceleration, m.acceleration),
                    m.tcp_acceleration > 0 ? kJerkOf * m.tcp_acceleration : of(0, tcp.jerk, m.acceleration));
    rotation.add(
        from, to, of(m.turn_speed, tcp.turn_speed, m.speed),
        of(m.turn_acceleration, tcp.turn_acceleration, m.acceleration),
        m.turn_acceleration > 0 ? kJerkOf * m.turn_acceleration : of(0, tcp.turn_jerk, m.acceleration));
  }

  /// Merges neighbours with the same bounds.
  std::vector<MoveSpan> alike(const std::vector<MoveSpan>& moves) const {
    const auto same = [](const Move& a, const Move& b) {
      return a.kind == b.kind && a.speed == b.speed && a.acceleration == b.acceleration &&
             a.tcp_speed == b.tcp_speed && a.tcp_acceleration == b.tcp_acceleration &&
             a.turn_speed == b.turn_speed && a.turn_acceleration == b.turn_acceleration &&
             a.joint_speed == b.joint_speed && a.joint_acceleration == b.joint_acceleration &&
             a.joint_pace == b.joint_pace && a.duration == 0 && b.duration == 0;
    };
    std::vector<MoveSpan> out{moves.front()};
    for (std::size_t i = 1; i < moves.size(); ++i)
      if (same(r_.moves[out.back().move], r_.moves[moves[i].move]))
        out.back().to = moves[i].to;
      else
        out.push_back(moves[i]);
    return out;
  }

  /// Checks the workspace.
  void check_place(const Path& path, const PlannedMotion& motion) const {
    const auto found = first_violation(r_.robot.workspace, r_.robot.chain, path, r_.options.reduced);
    if (!found) return;
    const auto [move, share] = place_of(motion, found->at);
    throw MoveError(leaves_workspace(*found, "the move to " + r_.moves[move].end().name, share), move);
  }

  /// The move at a place of a motion, and the fraction of it before that place.
  static std::pair<std::size_t, double> place_of(const PlannedMotion& motion, double s) {
    const auto end = std::lower_bound(motion.ends.begin(), std::prev(motion.ends.end()), s);
    const double begin = end == motion.ends.begin() ? 0 : *std::prev(end);
    return {motion.first + static_cast<std::size_t>(end - motion.ends.begin()),
            *end > begin ? (s - begin) / (*end - begin) : 1};
  }

  void time(PathPtr joints, const ZoneNorms& norms, PlannedMotion& motion) {
    timing::TimingOptions options;
    options.norms = norms.list();
    std::vector<MotionLimits> limits(limits_.begin(), limits_.end());
    timing::Timing timing;
    for (int round = 0;; ++round) {
      try {
        timing = timing::time_path(*joints, limits, options);
      } catch (const Error& why) {
        throw MoveError(why, motion.last);
      }
      if (!lighten(joints, timing.profile, round, limits, motion)) break;
    }
    const Move& move = r_.moves[motion.first];
    double wanted = motion.first == motion.last ? move.duration : 0;
    if (motion.first == motion.last && !is_cartesian(move))
      wanted = std::max(wanted, move.joint_pace * joints->length());
    if (wanted > timing.profile.duration()) timing.profile.stretch(wanted / timing.profile.duration());
    for (const NormLimit& norm : norms.list()) motion.bounds.push_back(norm.name);
    motion.active = std::move(timing.active);
    motion.path = timing::TimedPath(std::move(joints), std::move(timing.profile));
  }

  /// Checks torques. If some exceed their limits, reduces `limits` for another round. After some rounds it
  /// stretches the profile instead.
  bool lighten(const PathPtr& joints, timing::SpeedProfile& profile, int round,
               std::vector<MotionLimits>& limits, PlannedMotion& motion) const {
    if (!r_.robot.torques) return false;
    const auto judged = r_.robot.torques->judge(timing::TimedPath(joints, profile));
    if (judged.too_heavy) throw too_heavy(*judged.too_heavy, profile, motion);
    if (!judged.most) return false;
    motion.torque_joint = judged.most->joint;
    if (round >= kTorqueRounds) {
      profile.stretch(judged.slower);
      motion.torque_share /= judged.slower * judged.slower;
      return false;
    }
    const double share = kTorqueRoom * judged.acceleration;
    motion.torque_share *= share;
    for (MotionLimits& l : limits)
      l.max_acceleration *= share, l.min_acceleration *= share, l.max_jerk *= share;
    return true;
  }
  MoveError too_heavy(const TorqueLimits::Load& load, const timing::SpeedProfile& profile,
                      const PlannedMotion& motion) const {
    std::size_t hint = 0;
    const auto [move, share] = place_of(motion, profile.at(load.time, hint).s);
    return {
        Error("payload",
              fmt::format("the move to {}: after {:.1f} % of the way {} needs {:.4g} to hold the load of "
                          "{:.4g} kg still, its effort limit is {:.4g} (N m, or N of a joint that slides)",
                          r_.moves[move].end().name, 100 * share, r_.robot.chain.names()[load.joint],
                          std::abs(load.torque), r_.robot.torques->payload().mass, load.limit),
              "carry less, keep the load nearer to the base, or correct mass and centre of tool and payload"),
        move};
  }

  const PlanRequest& r_;
  const MoveDraft& draft_;
  std::span<const MotionLimits> limits_;
};

}  // namespace

PlannedMotion time_moves(const PlanRequest& request, const MoveDraft& draft,
                         std::span<const MotionLimits> limits) {
  return MoveTimer(request, draft, limits).run();
}

}  // namespace polyarm::moves
