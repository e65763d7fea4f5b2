#include "polyarm/motion/move_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "polyarm/motion/cartesian_joints.hpp"
#include "polyarm/motion/path_zones.hpp"
#include "polyarm/trajectory/path_hermite.hpp"
#include "polyarm/trajectory/path_joined.hpp"
#include "polyarm/trajectory/path_joint.hpp"
#include "polyarm/trajectory/path_polynomial.hpp"

namespace polyarm::motion {

using trajectory::CartesianPath;
using trajectory::CartesianPathBuilder;
using trajectory::Jet;
using trajectory::JoinedPath;
using trajectory::MotionLimits;
using trajectory::NormLimit;
using trajectory::Path;
using trajectory::PolynomialPath;

namespace {

using Values = std::vector<double>;
using PathPtr = std::shared_ptr<const Path>;
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr int kBisections = 30;  // for the place on a path that is a radius away from its end
constexpr int kSamples = 32;     // of a join, whose distances at the TCP are looked at
constexpr double kLess = 0.8;    // a join that is too wide is tried again with this share
constexpr int kTries = 40;
constexpr double kStandsStill = 0.03;  // of the derivative where a join begins: one that turns straight back
constexpr int kTorqueRounds = 4;       // of less acceleration for the joints' torques
constexpr double kTorqueRoom = 0.99;   // and a little less each time, since the times shift
constexpr double kJerkOf = 10;         // per s: of an acceleration that is stated without its jerk

Values at(const Path& path, double s) {
  Values q(path.joints());
  path.at(s, {q, {}, {}, {}});
  return q;
}

double norm_of(std::span<const double> v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

/// Where a move is on a part's own path.
struct Span {
  double from, to;
  std::size_t move;
};

/// A piece of a motion: a stretch of one path, with the TCP's way on it.
struct Part {
  PathPtr joints, translation, rotation;
  double from = 0, to = 0, scale = 1;
  std::vector<Span> moves;
  bool joins = false;  ///< two moves: both are on all of it
  bool curve = false;  ///< a spline of joint moves
};

/// Moves whose geometry comes from one builder.
struct Run {
  bool cartesian = false;
  std::size_t first = 0, last = 0;
  std::vector<Part> sections;
};

/// Parts from rest to rest.
using Draft = std::vector<Part>;

/// The way at the TCP of a path of joints, as three values of their own.
class NoPath final : public Path {
 public:
  explicit NoPath(PathPtr like) : like_(std::move(like)) {}
  std::size_t joints() const noexcept override { return 3; }
  double length() const noexcept override { return like_->length(); }
  void at(double, const trajectory::PathDerivatives& out) const noexcept override {
    for (const std::span<double> values : {out.q, out.first, out.second, out.third})
      std::fill(values.begin(), values.end(), 0.0);
  }
  std::span<const double> breaks() const noexcept override { return like_->breaks(); }

 private:
  PathPtr like_;
};

class Planner {
 public:
  Planner(const RobotFacts& robot, std::span<const Move> moves, const MovePlanOptions& options)
      : robot_(robot), moves_(moves), o_(options), distance_(tcp_distance(robot.chain)) {
    for (const trajectory::JointMotionLimits& l : robot.limits)
      plan_.limits.push_back(
          MotionLimits::symmetric(l.velocity * options.joint_share, l.acceleration, l.jerk));
  }

  MovePlan run(std::span<const double> from) {
    q_.assign(from.begin(), from.end());
    for (std::size_t i = 0; i < moves_.size();) {
      std::size_t last = i;
      while (last + 1 < moves_.size() && belong_together(i, last)) ++last;
      add(geometry(i, last), i > 0 && moves_[i - 1].blend > 0);
      i = last + 1;
    }
    close();
    plan_.end = q_;
    return std::move(plan_);
  }

 private:
  static bool is_cartesian(const Move& move) { return move.kind != MoveKind::joint; }
  static bool goes_through(const Move& move) { return move.through && !is_cartesian(move); }
  /// Is the move after `last` part of the geometry that begins with move `first`?
  bool belong_together(std::size_t first, std::size_t last) const {
    const Move& next = moves_[last + 1];
    if (is_cartesian(next) != is_cartesian(moves_[first])) return false;
    if (goes_through(moves_[first])) return goes_through(moves_[last]);
    return moves_[last].blend > 0 && !goes_through(next);
  }
  Pose pose_of(const MoveTarget& target) const {
    if (const Pose* pose = std::get_if<Pose>(&target.at)) return *pose;
    const Values& q = joints_of(target);
    return robot_.chain.forward(q);
  }
  const Values& joints_of(const MoveTarget& target) const {
    const Values& q = std::get<Values>(target.at);
    if (q.size() != robot_.chain.joints())
      throw Error("wrong-size", fmt::format("{} has {} joint values, {} has {} joints", target.name, q.size(),
                                            robot_.name, robot_.chain.joints()));
    check_joints(robot_, q, target.name);
    return q;
  }

  // --- geometry -------------------------------------------------------------------------------------------

  Run geometry(std::size_t first, std::size_t last) {
    Run out{is_cartesian(moves_[first]), first, last, {}};
    if (!out.cartesian) {
      joint_run(out);
    } else {
      try {
        cartesian_run(out, last);
      } catch (const Error& why) {
        throw MoveError(why, culprit(out));
      }
    }
    return out;
  }

  void joint_run(Run& run) {
    std::vector<trajectory::JointWaypoint> points{{q_, 0, "the start"}};
    std::vector<double> ends{0};
    for (std::size_t i = run.first; i <= run.last; ++i) {
      const MoveTarget& target = moves_[i].end();
      try {
        const Pose* pose = std::get_if<Pose>(&target.at);
        const Values q = pose ? joints_for(robot_, *pose, points.back().q, target.name) : joints_of(target);
        Values way(q.size());
        for (std::size_t j = 0; j < q.size(); ++j) way[j] = q[j] - points.back().q[j];
        ends.push_back(ends.back() + norm_of(way));
        points.push_back({q, i == run.last ? 0 : moves_[i].blend, target.name});
      } catch (const Error& why) {
        throw MoveError(why, i);
      }
    }
    trajectory::JointPathOptions options;
    options.tcp_distance = distance_;
    const bool curve = goes_through(moves_[run.first]) && points.size() > 2;
    auto path = curve ? trajectory::joint_spline(points, options) : trajectory::joint_lines(points, options);
    if (curve) pass_points(*path.sections.front(), run.first, points, ends);
    take_warnings(path.warnings, run);
    double begin = 0;
    for (auto& section : path.sections) {
      PathPtr joints(std::move(section));
      const double length = joints->length();
      const bool bounded = needs_tcp(run.first, run.last);
      Part part{joints, nullptr, nullptr, 0, length, 1, spans(run.first, ends, begin, begin + length)};
      part.curve = curve;
      tcp_of(part, bounded);
      run.sections.push_back(std::move(part));
      begin += length;
    }
    q_ = points.back().q;
  }

  /// Finds where a spline passes its points, and that it stays within the joints' limits between them.
  void pass_points(const Path& path, std::size_t first, std::span<const trajectory::JointWaypoint> points,
                   std::vector<double>& ends) const {
    std::size_t knot = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {  // points that repeat the one before have no knot
      if (knot + 1 < path.breaks().size() && is_at(path, path.breaks()[knot + 1], points[i].q)) ++knot;
      ends[i] = path.breaks()[knot];
      for (int k = 1; k < kSamples && ends[i] > ends[i - 1]; ++k) {
        const Values q = at(path, ends[i - 1] + (ends[i] - ends[i - 1]) * k / kSamples);
        try {
          check_joints(robot_, q, "the curve from " + points[i - 1].name + " to " + points[i].name);
        } catch (const Error& why) {
          throw MoveError(Error("limit", why.problems().front().what,
                                "put another point between them, or come to rest at one of them"),
                          first + i - 1);
        }
      }
    }
  }
  static bool is_at(const Path& path, double s, const Values& q) {
    const Values there = at(path, s);
    for (std::size_t j = 0; j < q.size(); ++j)
      if (!(std::abs(there[j] - q[j]) < 1e-9)) return false;
    return true;
  }

  /// Are there bounds at the TCP of joint moves?
  bool needs_tcp(std::size_t first, std::size_t last) const {
    if (o_.tcp_ceiling > 0) return true;
    for (std::size_t i = first; i <= last; ++i)
      if (moves_[i].tcp_speed > 0 || moves_[i].tcp_acceleration > 0 || moves_[i].turn_speed > 0 ||
          moves_[i].turn_acceleration > 0)
        return true;
    return false;
  }
  void tcp_of(Part& part, bool bounded) const {
    if (bounded) {
      part.translation = std::make_shared<TcpPath>(robot_.chain, part.joints, TcpPart::translation);
      part.rotation = std::make_shared<TcpPath>(robot_.chain, part.joints, TcpPart::rotation);
    } else {
      part.translation = part.rotation = std::make_shared<NoPath>(part.joints);
    }
  }

  void cartesian_run(Run& run, std::size_t last) {
    CartesianPathBuilder builder(robot_.chain.forward(q_));
    std::vector<double> ends{0};
    for (std::size_t i = run.first; i <= last; ++i) {
      add_to(builder, moves_[i], i == run.last ? 0 : moves_[i].blend);
      ends.push_back(builder.length());
    }
    trajectory::CartesianSections path = builder.build();
    trajectory::PathSections joints = joints_along(robot_.chain, path, q_);
    if (last < run.last) return;  // only to see whether it can be had
    take_warnings(path.warnings, run);
    double begin = 0;
    auto follow = joints.sections.begin();
    for (CartesianPath& section : path.sections) {
      const auto tcp = std::make_shared<const CartesianPath>(std::move(section));
      const double length = tcp->length();
      run.sections.push_back({PathPtr(std::move(*follow++)),
                              std::make_shared<PosePath>(tcp, TcpPart::translation),
                              std::make_shared<PosePath>(tcp, TcpPart::rotation), 0, length, 1,
                              spans(run.first, ends, begin, begin + length)});
      begin += length;
    }
    const Path& end = *run.sections.back().joints;
    q_ = at(end, end.length());
  }

  void add_to(CartesianPathBuilder& builder, const Move& move, double radius) const {
    const trajectory::Corner corner{radius, move.end().name};
    if (move.kind == MoveKind::line) {
      builder.line(pose_of(move.end()), corner);
    } else if (move.kind == MoveKind::arc) {
      if (move.targets.size() != 2)
        throw Error("no-arc", "an arc needs a point on its way and its end, here are " +
                                  std::to_string(move.targets.size()) + " points");
      builder.arc(pose_of(move.targets[0]).position, pose_of(move.end()), move.orientation, corner);
    } else {
      std::vector<Pose> through;
      for (const MoveTarget& target : move.targets) through.push_back(pose_of(target));
      builder.spline(through, corner);
    }
  }

  /// The first move that cannot be had after those before it.
  std::size_t culprit(const Run& run) {
    for (std::size_t last = run.first; last < run.last; ++last) {
      Run part = run;
      try {
        cartesian_run(part, last);
      } catch (const Error&) {
        return last;
      }
    }
    return run.last;
  }

  /// The moves between two parameters of a run, counted from the first of them.
  static std::vector<Span> spans(std::size_t first, const std::vector<double>& ends, double from, double to) {
    std::vector<Span> out;
    for (std::size_t i = 1; i < ends.size(); ++i) {
      const double low = std::max(ends[i - 1], from), high = std::min(ends[i], to);
      if (high - low > 1e-9 * (to - from)) out.push_back({low - from, high - from, first + i - 1});
    }
    if (!out.empty()) out.front().from = 0, out.back().to = to - from;
    return out;
  }

  /// Of the geometry of a run, which knows its moves by their names.
  void take_warnings(std::vector<Problem>& warnings, const Run& run) {
    for (Problem& warning : warnings) {
      if (warning.code == "waypoint-repeated") continue;  // a move to where it is already is none
      std::size_t move = run.first;
      while (move < run.last && warning.what.find(moves_[move].end().name + " is ") == std::string::npos)
        ++move;
      plan_.warnings.push_back({move, std::move(warning)});
    }
  }

  // --- joining --------------------------------------------------------------------------------------------

  void add(Run run, bool blended) {
    bool joins = blended && !draft_.empty();
    for (Part& part : run.sections) {
      if (!(part.to > part.from)) continue;
      if (!std::exchange(joins, false) || !join(part)) close();
      draft_.push_back(std::move(part));
    }
  }

  /// How far before its end, or behind its begin, a part is `radius` away from there, at most `most`.
  double away(const Part& part, bool before, double radius, double most) const {
    const Values corner = at(*part.joints, before ? part.to : part.from);
    const auto far = [&](double d) {
      return distance_(at(*part.joints, before ? part.to - d : part.from + d), corner);
    };
    if (far(most) <= radius) return most;
    double low = 0, high = most;
    for (int k = 0; k < kBisections; ++k) {
      const double middle = (low + high) / 2;
      (far(middle) <= radius ? low : high) = middle;
    }
    return low;
  }

  struct Ends {
    std::vector<Jet<double>> before, behind;
    double scale, length;
  };
  Ends ends_of(const Part& a, const Part& b, double da, double db) const {
    const std::size_t n = robot_.chain.joints();
    const auto jets = [&](const Path& path, double s) {
      std::vector<double> q(n), first(n), second(n), third(n);
      path.at(s, {q, first, second, third});
      std::vector<Jet<double>> out(n);
      for (std::size_t j = 0; j < n; ++j) out[j] = {q[j], first[j], second[j], third[j]};
      return out;
    };
    const auto rate = [](const std::vector<Jet<double>>& of) {
      double sum = 0;
      for (const Jet<double>& jet : of) sum += jet.first * jet.first;
      return std::sqrt(sum);
    };
    Ends out{jets(*a.joints, a.to - da), jets(*b.joints, b.from + db), 1, 0};
    out.scale = rate(out.behind) / rate(out.before);
    out.length = da + db * out.scale;
    for (Jet<double>& jet : out.behind)
      jet = {jet.value, jet.first / out.scale, jet.second / (out.scale * out.scale), 0};
    return out;
  }

  std::shared_ptr<const PolynomialPath> joining_path(const Ends& ends) const {
    const std::size_t n = ends.before.size();
    constexpr std::size_t kPowers = PolynomialPath::kCoefficients;
    Values start(n), c(n * kPowers, 0.0);
    for (std::size_t j = 0; j < n; ++j) {
      start[j] = ends.before[j].value;
      const auto one = trajectory::hermite5(ends.before[j], ends.behind[j], ends.length);
      std::copy(one.begin(), one.end(), c.begin() + static_cast<std::ptrdiff_t>(j * kPowers));
    }
    auto path = std::make_shared<PolynomialPath>(start);
    path->append(ends.length, c);
    return path;
  }

  bool stays(const Path& path, const Values& corner, double radius) const {
    Values q(path.joints()), first(path.joints());
    path.at(0, {q, first, {}, {}});
    const double least = kStandsStill * norm_of(first);
    for (int k = 0; k <= kSamples; ++k) {
      path.at(path.length() * k / kSamples, {q, first, {}, {}});
      if (!(norm_of(first) > least)) return false;
      if (!(distance_(q, corner) <= radius)) return false;
      for (std::size_t j = 0; j < q.size(); ++j)
        if (q[j] < robot_.chain.lower()[j] || q[j] > robot_.chain.upper()[j]) return false;
    }
    return true;
  }

  /// Rounds the corner between the last part of the draft and `b`, within the blend of the move before. False
  /// where there is no room at all.
  bool join(Part& b) {
    Part& a = draft_.back();
    const Span &before = a.moves.back(), &behind = b.moves.front();
    const Move& move = moves_[before.move];
    const double radius = move.blend * (1 - 1.0 / (kSamples * kSamples));
    const Values corner = at(*a.joints, a.to);
    const double most_a = (std::min(before.to, a.to) - std::max(before.from, a.from)) / 2;
    const double most_b = (std::min(behind.to, b.to) - behind.from) / 2;
    double da = away(a, true, radius, most_a), db = away(b, false, radius, most_b);
    bool wide = false;
    for (int k = 0;; ++k, da *= kLess, db *= kLess, wide = true) {
      if (k == kTries || !(da > 0) || !(db > 0)) {
        warn(before.move, 0, "there is no room for it");
        return false;
      }
      const Ends ends = ends_of(a, b, da, db);
      if (!std::isfinite(ends.scale) || !(ends.scale > 0)) continue;
      const auto path = joining_path(ends);
      if (!stays(*path, corner, radius)) continue;
      const double reached = std::max(distance_(at(*a.joints, a.to - da), corner),
                                      distance_(at(*b.joints, b.from + db), corner));
      if (reached < 0.98 * radius)
        warn(before.move, reached,
             wide ? "the curve would leave the ball of that radius" : "half of a move beside it");
      Part middle{path,
                  nullptr,
                  nullptr,
                  0,
                  path->length(),
                  a.scale,
                  {{0, path->length(), before.move}, {0, path->length(), behind.move}}};
      tcp_of(middle, true);
      a.to -= da;
      b.from += db;
      b.scale = a.scale * ends.scale;
      middle.joins = true;
      draft_.push_back(std::move(middle));
      return true;
    }
  }

  void warn(std::size_t index, double reached, const char* why) {
    const Move& move = moves_[index];
    plan_.warnings.push_back({index,
                              {"blend-shrunk",
                               {},
                               fmt::format("the blend of {:.6g} m at {} is shrunk to {:.6g} m: {}",
                                           move.blend, move.end().name, reached, why),
                               "give a smaller blend, or move the points apart",
                               Severity::warning}});
  }

  // --- time -----------------------------------------------------------------------------------------------

  /// What the joint limits allow the parameter of a joint move, and what is asked of it beyond.
  struct Pace {
    double speed = kInfinite, acceleration = kInfinite, jerk = kInfinite;
  };
  Pace pace_of(const Part& part, const Span& span) const {
    const Move& move = moves_[span.move];
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
    Values q(plan_.limits.size()), first(q.size());
    double speed = kInfinite, acceleration = kInfinite, jerk = kInfinite, fastest = 0;
    const double from = std::max(span.from, part.from), to = std::min(span.to, part.to);
    const int places = part.curve ? kSamples : 1;  // a line is the same everywhere
    for (int k = 0; k < places; ++k) {
      part.joints->at(from + (to - from) * (k + 0.5) / places, {q, first, {}, {}});
      for (std::size_t j = 0; j < first.size(); ++j) {
        const double rate = std::abs(first[j]) / part.scale;
        speed = std::min(speed, plan_.limits[j].max_velocity / rate);
        acceleration = std::min(acceleration, plan_.limits[j].max_acceleration / rate);
        jerk = std::min(jerk, plan_.limits[j].max_jerk / rate);
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
    for (const Part& part : draft_)
      for (const Span& span : part.moves)
        if (span.move != move) return false;
    return true;
  }

  /// Does the move say anything about the TCP on this part?
  bool is_bounded(const Part& part, std::size_t move) const {
    const bool says = is_cartesian(moves_[move]) || needs_tcp(move, move);
    return says || (!part.joins && part.translation != part.rotation);
  }
  void bound(std::size_t move, double from, double to, ZoneLimits& translation, ZoneLimits& rotation) const {
    const Move& m = moves_[move];
    const bool own = is_cartesian(m);
    const auto of = [&](double stated, double limit, double share) {
      return stated > 0 ? stated : own ? limit * share : kInfinite;
    };
    const TcpLimits& tcp = robot_.tcp;
    double speed = of(m.tcp_speed, tcp.speed, m.speed);
    if (o_.tcp_ceiling > 0) speed = std::min(speed, o_.tcp_ceiling);
    translation.add(from, to, speed, of(m.tcp_acceleration, tcp.acceleration, m.acceleration),
                    m.tcp_acceleration > 0 ? kJerkOf * m.tcp_acceleration : of(0, tcp.jerk, m.acceleration));
    rotation.add(
        from, to, of(m.turn_speed, tcp.turn_speed, m.speed),
        of(m.turn_acceleration, tcp.turn_acceleration, m.acceleration),
        m.turn_acceleration > 0 ? kJerkOf * m.turn_acceleration : of(0, tcp.turn_jerk, m.acceleration));
  }

  /// Neighbours that nothing tells apart but where they go, as one.
  std::vector<Span> alike(const std::vector<Span>& moves) const {
    const auto same = [](const Move& a, const Move& b) {
      return a.kind == b.kind && a.speed == b.speed && a.acceleration == b.acceleration &&
             a.tcp_speed == b.tcp_speed && a.tcp_acceleration == b.tcp_acceleration &&
             a.turn_speed == b.turn_speed && a.turn_acceleration == b.turn_acceleration &&
             a.joint_speed == b.joint_speed && a.joint_acceleration == b.joint_acceleration &&
             a.joint_pace == b.joint_pace && a.duration == 0 && b.duration == 0;
    };
    std::vector<Span> out{moves.front()};
    for (std::size_t i = 1; i < moves.size(); ++i)
      if (same(moves_[out.back().move], moves_[moves[i].move]))
        out.back().to = moves[i].to;
      else
        out.push_back(moves[i]);
    return out;
  }

  /// Times what is in the draft.
  void close() {
    if (draft_.empty()) return;
    const std::size_t n = robot_.chain.joints();
    auto joints = std::make_shared<JoinedPath>(n);
    auto translation = std::make_shared<JoinedPath>(3), rotation = std::make_shared<JoinedPath>(3);
    ZoneLimits on_translation, on_rotation, on_parameter;
    PlannedMotion motion;
    motion.first = draft_.front().moves.front().move;
    motion.last = draft_.back().moves.back().move;
    motion.ends.resize(motion.last - motion.first + 1);
    for (const Part& part : draft_) {
      const double begin = joints->length();
      const std::vector<Span> pieces = part.joins ? std::vector<Span>{part.moves.front()} : alike(part.moves);
      for (const Span& span : pieces) {  // where a bound changes is a break
        const double from = std::max(span.from, part.from), to = std::min(span.to, part.to);
        if (!(to > from)) continue;
        joints->append(part.joints, from, to, part.scale);
        translation->append(part.translation, from, to, part.scale);
        rotation->append(part.rotation, from, to, part.scale);
      }
      for (const Span& span : part.moves) {
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
    norms.add(std::make_shared<ParameterPath>(joints), on_parameter, "what the move says");
    time(std::move(joints), norms, motion);
    draft_.clear();
  }

  /// Does the TCP stay where it may be?
  void check_place(const Path& path, const PlannedMotion& motion) const {
    const auto found = first_violation(robot_.workspace, robot_.chain, path);
    if (!found) return;
    const auto [move, share] = place_of(motion, found->at);
    throw MoveError(leaves_workspace(*found, "the move to " + moves_[move].end().name, share), move);
  }

  /// The move that a place of a motion belongs to, and the share of it that lies before.
  static std::pair<std::size_t, double> place_of(const PlannedMotion& motion, double s) {
    const auto end = std::lower_bound(motion.ends.begin(), std::prev(motion.ends.end()), s);
    const double begin = end == motion.ends.begin() ? 0 : *std::prev(end);
    return {motion.first + static_cast<std::size_t>(end - motion.ends.begin()),
            *end > begin ? (s - begin) / (*end - begin) : 1};
  }

  void time(PathPtr joints, const ZoneNorms& norms, PlannedMotion& motion) {
    trajectory::TimingOptions options;
    options.norms = norms.list();
    std::vector<MotionLimits> limits = plan_.limits;
    trajectory::Timing timing;
    for (int round = 0;; ++round) {
      try {
        timing = trajectory::time_path(*joints, limits, options);
      } catch (const Error& why) {
        throw MoveError(why, motion.last);
      }
      if (!lighten(joints, timing.profile, round, limits, motion)) break;
    }
    const Move& move = moves_[motion.first];
    double wanted = motion.first == motion.last ? move.duration : 0;
    if (motion.first == motion.last && !is_cartesian(move))
      wanted = std::max(wanted, move.joint_pace * joints->length());
    if (wanted > timing.profile.duration()) timing.profile.stretch(wanted / timing.profile.duration());
    for (const NormLimit& norm : norms.list()) motion.bounds.push_back(norm.name);
    motion.active = std::move(timing.active);
    motion.path = trajectory::TimedPath(std::move(joints), std::move(timing.profile));
    plan_.motions.push_back(std::move(motion));
  }

  /// Are there torques beyond their limits? Then `limits` come down, for another round; after some rounds the
  /// profile takes longer.
  bool lighten(const PathPtr& joints, trajectory::SpeedProfile& profile, int round,
               std::vector<MotionLimits>& limits, PlannedMotion& motion) const {
    if (!robot_.torques) return false;
    const auto judged = robot_.torques->judge(trajectory::TimedPath(joints, profile));
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
  MoveError too_heavy(const TorqueLimits::Load& load, const trajectory::SpeedProfile& profile,
                      const PlannedMotion& motion) const {
    std::size_t hint = 0;
    const auto [move, share] = place_of(motion, profile.at(load.time, hint).s);
    return {
        Error("payload",
              fmt::format("the move to {}: after {:.1f} % of the way {} needs {:.4g} to hold the load of "
                          "{:.4g} kg still, its effort limit is {:.4g} (N m, or N of a joint that slides)",
                          moves_[move].end().name, 100 * share, robot_.chain.names()[load.joint],
                          std::abs(load.torque), robot_.torques->payload().mass, load.limit),
              "carry less, keep the load nearer to the base, or correct mass and centre of tool and payload"),
        move};
  }

  const RobotFacts& robot_;
  std::span<const Move> moves_;
  const MovePlanOptions& o_;
  trajectory::TcpDistance distance_;
  Values q_;  // where the moves so far end
  Draft draft_;
  MovePlan plan_;
};

void check(std::span<const Move> moves, const RobotFacts& robot) {
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const Move& m = moves[i];
    const auto refuse = [&](const char* what, double value, const char* advice) {
      throw MoveError(Error("bad-move",
                            fmt::format("the {} of the move to {} of {} is {}", what,
                                        m.targets.empty() ? "nowhere" : m.end().name, robot.name, value),
                            advice),
                      i);
    };
    if (m.targets.empty()) refuse("number of targets", 0, "a move needs a target");
    if (!(m.speed > 0 && m.speed <= 1)) refuse("share of speed", m.speed, "above 0, at most 1 (100 %)");
    if (!(m.acceleration > 0 && m.acceleration <= 1))
      refuse("share of acceleration", m.acceleration, "above 0, at most 1 (100 %)");
    for (const auto& [name, value] : {std::pair("blend", m.blend),
                                      {"speed", m.tcp_speed},
                                      {"acceleration", m.tcp_acceleration},
                                      {"turning speed", m.turn_speed},
                                      {"turning acceleration", m.turn_acceleration},
                                      {"joint speed", m.joint_speed},
                                      {"joint pace", m.joint_pace},
                                      {"joint acceleration", m.joint_acceleration},
                                      {"duration", m.duration}})
      if (!(value >= 0) || !std::isfinite(value)) refuse(name, value, "it has to be above 0");
  }
}

}  // namespace

double MovePlan::duration() const {
  double sum = 0;
  for (const PlannedMotion& motion : motions) sum += motion.path.duration();
  return sum;
}

MovePlan plan_moves(const RobotFacts& robot, std::span<const double> from, std::span<const Move> moves,
                    const MovePlanOptions& options) {
  check(moves, robot);
  return Planner(robot, moves, options).run(from);
}

}  // namespace polyarm::motion
