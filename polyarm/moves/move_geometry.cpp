#include "polyarm/moves/move_geometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "polyarm/moves/cartesian_joints.hpp"
#include "polyarm/moves/path_zones.hpp"
#include "polyarm/moves/rounded_poses.hpp"
#include "polyarm/paths/cartesian_path.hpp"
#include "polyarm/paths/joint_path.hpp"

namespace polyarm::moves {

using paths::CartesianPath;
using paths::CartesianPathBuilder;
using paths::Path;

namespace {

using Values = std::vector<double>;
using PathPtr = std::shared_ptr<const Path>;
constexpr int kSamples = 32;  // per interval between two points of a spline

class Geometry {
 public:
  Geometry(const PlanRequest& request, Values& q, std::vector<MovePlan::Warning>& warnings)
      : r_(request), q_(q), warnings_(warnings) {}

  MoveRun run(std::size_t first, std::size_t last) {
    MoveRun out{is_cartesian(r_.moves[first]), first, last, {}};
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

 private:
  Pose pose_of(const MoveTarget& target) const {
    if (const Pose* pose = std::get_if<Pose>(&target.at)) return reached_pose(r_.robot, *pose, q_);
    const Values& q = joints_of(target);
    return r_.robot.chain.forward(q);
  }
  const Values& joints_of(const MoveTarget& target) const {
    const Values& q = std::get<Values>(target.at);
    if (q.size() != r_.robot.chain.joints())
      throw Error("wrong-size", fmt::format("{} has {} joint values, {} has {} joints", target.name, q.size(),
                                            r_.robot.name, r_.robot.chain.joints()));
    check_joints(r_.robot, q, target.name);
    return q;
  }

  static double distance_of(const Values& a, const Values& b) {
    Values way(a.size());
    for (std::size_t j = 0; j < a.size(); ++j) way[j] = b[j] - a[j];
    return norm_of(way);
  }

  void joint_run(MoveRun& run) {
    std::vector<paths::JointWaypoint> points{{q_, 0, "the start"}};
    std::vector<double> ends{0};
    std::vector<std::size_t> moves;
    for (std::size_t i = run.first; i <= run.last; ++i) {
      const MoveTarget& target = r_.moves[i].end();
      try {
        const Pose* pose = std::get_if<Pose>(&target.at);
        const Values q = pose ? joints_for(r_.robot, *pose, points.back().q, target.name) : joints_of(target);
        Values before = points.back().q;
        double length = 0;
        for (const Move::Corner& corner : r_.moves[i].over) {
          check_joints(r_.robot, corner.at, target.name);
          points.push_back({corner.at, corner.radius, {}});
          length += distance_of(before, corner.at);
          before = corner.at;
        }
        ends.push_back(ends.back() + length + distance_of(before, q));
        points.push_back({q, i == run.last ? 0 : r_.moves[i].blend, target.name});
        moves.resize(points.size() - 1, i);
      } catch (const Error& why) {
        throw MoveError(why, i);
      }
    }
    paths::JointPathOptions options;
    // Corners of a way around obstacles have radii in joint space; such a move stands alone.
    if (r_.moves[run.first].over.empty()) options.tcp_distance = r_.distance;
    const bool curve = goes_through(r_.moves[run.first]) && points.size() > 2;
    auto path = curve ? paths::joint_spline(points, options) : paths::joint_lines(points, options);
    if (curve) pass_points(*path.sections.front(), run.first, points, ends);
    take_warnings(path.warnings, moves);
    double begin = 0;
    for (auto& section : path.sections) {
      PathPtr joints(std::move(section));
      const double length = joints->length();
      const bool bounded = needs_tcp(r_, run.first, run.last);
      MovePart part{joints, nullptr, nullptr, 0, length, 1, spans(run.first, ends, begin, begin + length)};
      part.curve = curve;
      give_tcp(r_, part, bounded);
      run.sections.push_back(std::move(part));
      begin += length;
    }
    q_ = points.back().q;
  }

  /// Finds where a spline passes its points, and checks the joints' limits between them.
  void pass_points(const Path& path, std::size_t first, std::span<const paths::JointWaypoint> points,
                   std::vector<double>& ends) const {
    std::size_t knot = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {  // a point that repeats the previous one has no knot
      if (knot + 1 < path.breaks().size() && is_at(path, path.breaks()[knot + 1], points[i].q)) ++knot;
      ends[i] = path.breaks()[knot];
      for (int k = 1; k < kSamples && ends[i] > ends[i - 1]; ++k) {
        const Values q = joints_at(path, ends[i - 1] + (ends[i] - ends[i - 1]) * k / kSamples);
        try {
          check_joints(r_.robot, q, "the curve from " + points[i - 1].name + " to " + points[i].name);
        } catch (const Error& why) {
          throw MoveError(Error("limit", why.problems().front().what,
                                "put another point between them, or come to rest at one of them"),
                          first + i - 1);
        }
      }
    }
  }
  static bool is_at(const Path& path, double s, const Values& q) {
    const Values there = joints_at(path, s);
    for (std::size_t j = 0; j < q.size(); ++j)
      if (!(std::abs(there[j] - q[j]) < 1e-9)) return false;
    return true;
  }

  void cartesian_run(MoveRun& run, std::size_t last) {
    CartesianPathBuilder builder(r_.robot.chain.forward(q_));
    std::vector<double> ends{0};
    std::vector<std::size_t> moves;
    for (std::size_t i = run.first; i <= last; ++i) {
      add_to(builder, r_.moves[i], i == run.last ? 0 : r_.moves[i].blend);
      moves.push_back(i);
      ends.push_back(builder.length());
    }
    paths::CartesianSections path = builder.build();
    paths::PathSections joints = joints_along(r_.robot.chain, path, q_);
    if (last < run.last) return;  // called only to check whether the moves are possible
    take_warnings(path.warnings, moves);
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
    q_ = joints_at(end, end.length());
  }

  void add_to(CartesianPathBuilder& builder, const Move& move, double radius) const {
    const paths::Corner corner{radius, move.end().name};
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

  /// The first move that is impossible after the moves before it.
  std::size_t culprit(const MoveRun& run) {
    for (std::size_t last = run.first; last < run.last; ++last) {
      MoveRun part = run;
      try {
        cartesian_run(part, last);
      } catch (const Error&) {
        return last;
      }
    }
    return run.last;
  }

  /// The moves between two parameters of a run, relative to the first of them.
  static std::vector<MoveSpan> spans(std::size_t first, const std::vector<double>& ends, double from,
                                     double to) {
    std::vector<MoveSpan> out;
    for (std::size_t i = 1; i < ends.size(); ++i) {
      const double low = std::max(ends[i - 1], from), high = std::min(ends[i], to);
      if (high - low > 1e-9 * (to - from)) out.push_back({low - from, high - from, first + i - 1});
    }
    if (!out.empty()) out.front().from = 0, out.back().to = to - from;
    return out;
  }

  /// Assigns the warnings of a path to its moves. `moves` has the move that ends at each waypoint, from the
  /// second on.
  void take_warnings(std::vector<paths::PathWarning>& warnings, std::span<const std::size_t> moves) {
    for (paths::PathWarning& warning : warnings) {
      if (warning.code == "waypoint-repeated") continue;  // a move to the present position is not a fault
      warnings_.push_back({moves[warning.waypoint - 1], std::move(static_cast<Problem&>(warning))});
    }
  }

  const PlanRequest& r_;
  Values& q_;
  std::vector<MovePlan::Warning>& warnings_;
};

}  // namespace

MoveRun move_geometry(const PlanRequest& request, std::size_t first, std::size_t last, Values& q,
                      std::vector<MovePlan::Warning>& warnings) {
  return Geometry(request, q, warnings).run(first, last);
}

}  // namespace polyarm::moves
