#include "polyarm/surroundings/base_ways.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>
#include <utility>

#include "polyarm/collision/separation.hpp"
#include "polyarm/surroundings/sweep_bodies.hpp"

namespace polyarm::surroundings {

using collision::ConvexBody;

namespace {

constexpr double kPi = std::numbers::pi;
/// Bodies that end this far above the lowest point of the base are ground that it drives on, m.
constexpr double kGround = 5e-3;
/// A part this near to the base lies on it, m.
constexpr double kLiesOn = 2e-3;
/// Of the distance that start or goal leave, so much is kept.
constexpr double kRoom = 0.8;
/// A way is searched with so much more clearance first, m: guards stop a base that comes near to something
/// fast.
constexpr std::array kMore{0.05, 0.02};
/// Partial turns are checked in steps of this angle.
constexpr double kTurnStep = 10 * kPi / 180;
/// A turn beyond this may be done by either side, because the base is not exactly where it should be.
constexpr double kEitherSide = 170 * kPi / 180;
/// What turns less, or drives less, does not move.
constexpr double kSameHeading = 1e-6, kSamePlace = 1e-4;
/// Costs in metres: of a turn by 1 rad, and of a metre backwards.
constexpr double kTurnCost = 0.3, kBackwardsCost = 2;
constexpr int kDirections = 16;  ///< of places around an obstacle
constexpr std::size_t kMostCorners = 700, kSeries = 250;
constexpr std::size_t kMostChecks = 40'000;       ///< of edges in one search
constexpr double kFarthestAxis = 4, kAround = 2;  ///< m: places on the axes; the region beyond start and goal

double wrapped(double angle) {
  return std::remainder(angle, 2 * kPi);
}

Pose pose_of(const BasePlace& place) {
  return {{place.x, place.y, 0}, from_rpy(0, 0, place.heading)};
}

double heading_of(const Pose& pose) {
  const Vec3 ahead = pose.rotation * Vec3{1, 0, 0};
  return std::atan2(ahead.y, ahead.x);
}

ConvexBody hull_of(ConvexBody a, const ConvexBody& b) {
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  return a;
}

/// A body of the base, in its frame on the plane z = 0 of the world.
struct Own {
  ConvexBody body;  ///< without discs
  std::string name;
  double low = 0, high = 0;  ///< along z
  double farthest = 0;       ///< of its points from the axis about which the base turns
};

struct Other {
  ConvexBody body;  ///< in the world
  std::string name;
  double low = 0, high = 0;
};

/// Halton's series: numbers that fill 0 to 1 evenly.
double halton(std::size_t index, std::size_t base) {
  double out = 0, share = 1;
  for (std::size_t i = index; i > 0; i /= base) {
    share /= static_cast<double>(base);
    out += share * static_cast<double>(i % base);
  }
  return out;
}

/// The bodies of the cell, sorted into those that the base takes along and those that are in its way.
class Ground : private SweepBodies {
 public:
  Ground(const std::vector<Robot>& robots, const description::Scene& scene, const Moment& moment,
         const BaseWayQuery& query)
      : SweepBodies(robots, scene), moment_(moment), query_(query) {
    const Pose base = moment.robots[query.robot].base * query.T_root_base;
    start_ = {base.position.x, base.position.y, heading_of(base)};
    frames_.resize(robots_.size());
    for (std::size_t r = 0; r < robots_.size(); ++r) {
      frames_[r].resize(models_[r]->frames().size());
      models_[r]->place(moment.robots[r].joints, frames_[r]);
    }
    for (const SweptBody& body : bodies_)
      if (is_own(body)) add_own(body);
    for (const Own& own : own_) low_ = std::min(low_, own.low);
    add_loads();
    for (const Own& own : own_) {
      high_ = std::max(high_, own.high);
      farthest_ = std::max(farthest_, own.farthest);
    }
    for (const SweptBody& body : bodies_)
      if (!is_own(body) && !is_load(body) && body.kind != BodyKind::floor) add_other(body);
    std::vector<collision::Bounds> bounds;
    for (const Other& other : others_) bounds.push_back(collision::bounds_of(other.body));
    if (!bounds.empty()) tree_ = collision::BoxTree(bounds);
  }

  const BasePlace& start() const { return start_; }
  const std::vector<Other>& others() const { return others_; }
  double farthest() const { return farthest_; }
  double farthest_beside(const Other& other) const {
    double out = 0;
    for (const Own& own : own_)
      if (own.low < other.high + clearance_ && own.high > other.low - clearance_)
        out = std::max(out, own.farthest);
    return out;
  }
  void keep(double clearance) { clearance_ = clearance; }
  double clearance() const { return clearance_; }

  /// What is nearest to the base at a place, as far as it is nearer than `within`.
  struct Nearest {
    double distance = std::numeric_limits<double>::infinity();
    std::string mine, other;
  };
  Nearest nearest(const BasePlace& place, double within) const {
    Nearest out;
    for (const Own& own : own_)
      each_near(moved(pose_of(place), own.body), within, [&](const Other& other, double distance) {
        if (distance < out.distance) out = {distance, own.name, other.name};
        return false;
      });
    return out;
  }

  bool line_is_free(const BasePlace& from, const BasePlace& to) const {
    return std::all_of(own_.begin(), own_.end(), [&](const Own& own) {
      return is_free(hull_of(moved(pose_of(from), own.body), moved(pose_of(to), own.body)));
    });
  }

  /// By a whole turn.
  bool turns_freely(double x, double y) const {
    return std::all_of(own_.begin(), own_.end(), [&](const Own& own) {
      ConvexBody swept;
      swept.points = {{x, y, own.low}, {x, y, own.high}};
      swept.disc = own.farthest;
      return is_free(swept);
    });
  }

  bool turn_is_free(const BasePlace& at, double heading) const {
    const double turn = wrapped(heading - at.heading);
    if (std::abs(turn) < kSameHeading || turns_freely(at.x, at.y)) return true;
    if (std::abs(turn) > kEitherSide) return false;
    const int steps = static_cast<int>(std::ceil(std::abs(turn) / kTurnStep));
    const double step = turn / steps;
    for (int k = 0; k < steps; ++k) {
      const Pose from = pose_of({at.x, at.y, at.heading + k * step});
      const Pose to = pose_of({at.x, at.y, at.heading + (k + 1) * step});
      for (const Own& own : own_) {
        ConvexBody swept = hull_of(moved(from, own.body), moved(to, own.body));
        swept.radius += own.farthest * (1 - std::cos(step / 2));  // points go along arcs
        if (!is_free(swept)) return false;
      }
    }
    return true;
  }

 private:
  /// The robot and those on it.
  bool is_carried(int robot) const {
    for (std::size_t steps = 0; robot >= 0 && steps <= robots_.size(); ++steps) {
      if (robot == static_cast<int>(query_.robot)) return true;
      robot = robots_[static_cast<std::size_t>(robot)].on;
    }
    return false;
  }

  bool is_own(const SweptBody& body) const {
    if (body.part < 0) return body.robot >= 0 && is_carried(body.robot);
    const auto part = static_cast<std::size_t>(body.part);
    return part < moment_.parts.size() && moment_.parts[part].in_world && moment_.parts[part].held_by >= 0 &&
           is_carried(moment_.parts[part].held_by);
  }

  /// Empty: it is not in the world.
  std::optional<Pose> place_of(const SweptBody& body) const {
    if (body.part >= 0) {
      const auto part = static_cast<std::size_t>(body.part);
      if (part >= moment_.parts.size() || !moment_.parts[part].in_world) return std::nullopt;
      return moment_.parts[part].pose;
    }
    if (body.fixture >= 0)
      return surroundings::pose_of(scene_.fixtures[static_cast<std::size_t>(body.fixture)], scene_, moment_);
    const auto robot = static_cast<std::size_t>(body.robot);
    const Pose& base = moment_.robots[robot].base;
    return body.frame < 0 ? base : base * frames_[robot][static_cast<std::size_t>(body.frame)];
  }

  static double top(const ConvexBody& body) { return body.core_support({0, 0, 1}).z + body.radius; }
  static double bottom(const ConvexBody& body) { return body.core_support({0, 0, -1}).z - body.radius; }

  void add_own(const SweptBody& body) {
    const std::optional<Pose> place = place_of(body);
    if (!place) return;
    const Pose T_plane = inverse(pose_of(start_)) * *place;
    for (const ConvexBody& piece : body.pieces) {
      Own own{without_discs(moved(T_plane, piece)), body.name};
      own.low = bottom(own.body), own.high = top(own.body);
      for (const Vec3& point : own.body.points)
        own.farthest = std::max(own.farthest, std::hypot(point.x, point.y) + own.body.radius);
      own_.push_back(std::move(own));
    }
  }

  bool is_load(const SweptBody& body) const {
    return body.part >= 0 && static_cast<std::size_t>(body.part) < is_load_.size() &&
           is_load_[static_cast<std::size_t>(body.part)] != 0;
  }

  /// Parts that nobody holds and that lie on the base, or on each other there.
  void add_loads() {
    is_load_.assign(moment_.parts.size(), 0);
    for (bool more = true; std::exchange(more, false);)
      for (const SweptBody& body : bodies_) {
        if (body.part < 0 || is_load(body)) continue;
        const std::optional<Pose> place = place_of(body);
        const auto part = static_cast<std::size_t>(body.part);
        if (!place || moment_.parts[part].held_by >= 0 || !lies_on_base(body, *place)) continue;
        is_load_[part] = 1;
        add_own(body);
        more = true;
      }
  }

  void add_other(const SweptBody& body) {
    const std::optional<Pose> place = place_of(body);
    if (!place) return;
    for (const ConvexBody& piece : body.pieces) {
      Other other{moved(*place, piece), body.name};
      other.low = bottom(other.body), other.high = top(other.body);
      if (other.high > low_ + kGround && other.low < high_ + query_.clearance)
        others_.push_back(std::move(other));
    }
  }

  /// What stands on the ground beside the base does not lie on it.
  bool lies_on_base(const SweptBody& part, const Pose& place) const {
    for (const ConvexBody& piece : part.pieces)
      if (bottom(moved(place, piece)) <= low_ + kGround) return false;
    const Pose T_world_plane = pose_of(start_);
    for (const ConvexBody& piece : part.pieces)
      for (const Own& own : own_)
        if (separation(own.body, inverse(place) * T_world_plane, piece).distance < kLiesOn) return true;
    return false;
  }

  /// Calls take(other, distance) until it returns true.
  template <typename Take>
  bool each_near(const ConvexBody& swept, double within, const Take& take) const {
    if (tree_.empty()) return false;
    const collision::Ball ball = collision::bounding_ball(swept);
    bool done = false;
    tree_.each_near(
        ball.center, [&] { return done ? -1 : ball.radius + within; },
        [&](std::size_t k) {
          if (done) return;
          const double distance = separation(swept, Pose{}, others_[k].body).distance;
          if (distance < within) done = take(others_[k], distance);
        });
    return done;
  }

  bool is_free(const ConvexBody& swept) const {
    return !each_near(swept, clearance_, [](const Other&, double) { return true; });
  }

  const Moment& moment_;
  const BaseWayQuery& query_;
  BasePlace start_;
  std::vector<std::vector<Pose>> frames_;
  std::vector<Own> own_;
  std::vector<char> is_load_;  // by part
  std::vector<Other> others_;
  collision::BoxTree tree_;
  double low_ = std::numeric_limits<double>::infinity(), high_ = -low_, farthest_ = 0;
  double clearance_ = 0;
};

/// The search itself. Node 0 is the start, node 1 the goal.
class Search {
 public:
  Search(const Ground& ground, const BaseWayQuery& query) : ground_(ground), query_(query) {
    add(ground.start());
    add(query.goal);
    if (ground.line_is_free(ground.start(), ground.start())) add_axis(ground.start());
    add_axis(query.goal);
    add_corners();
    add_series();
  }

  BaseWay run() {
    expand(0);
    std::size_t checks = 0;
    while (!open_.empty()) {
      const Entry entry = open_.top();
      open_.pop();
      Node& node = nodes_[entry.to];
      if (node.closed) continue;
      if (++checks > kMostChecks || (query_.stop && query_.stop()))
        return {BaseWayOutcome::out_of_time, {}, {}, {}};
      if (!is_possible(entry)) continue;
      node.closed = true;
      node.cost = entry.cost, node.parent = entry.from;
      node.arrival = entry.heading, node.backwards = entry.backwards;
      if (entry.to == 1) return way();
      expand(entry.to);
    }
    return {};
  }

 private:
  struct Node {
    double x = 0, y = 0;
    double arrival = 0;  ///< heading in which the base comes there
    double cost = 0;
    std::size_t parent = 0;
    bool closed = false, backwards = false;
    std::optional<bool> turns;  ///< freely, by a whole turn
  };
  struct Entry {
    double estimate, cost, heading;
    std::size_t from, to;
    bool backwards;
    bool operator<(const Entry& other) const {
      return estimate != other.estimate ? estimate > other.estimate
                                        : std::pair(to, from) > std::pair(other.to, other.from);
    }
  };

  void add(const BasePlace& place) {
    Node node;
    node.x = place.x, node.y = place.y, node.arrival = place.heading;
    nodes_.push_back(node);
  }

  /// Places ahead and behind to which the base can drive without a turn, and where it can turn.
  void add_axis(const BasePlace& place) {
    constexpr double kFirst = 0.02, kGrowth = 1.1;
    for (const double side : {-1.0, 1.0}) {
      int found = 0;
      for (double d = kFirst; d < kFarthestAxis && found<4; d *= found> 0 ? 2 : kGrowth) {
        const BasePlace at{place.x + side * d * std::cos(place.heading),
                           place.y + side * d * std::sin(place.heading), place.heading};
        if (!ground_.line_is_free(place, at)) break;
        if (!ground_.turns_freely(at.x, at.y)) continue;
        add(at);
        ++found;
      }
    }
  }

  void add_corners() {
    std::vector<std::pair<double, std::size_t>> nearest;
    const BasePlace &a = ground_.start(), &b = query_.goal;
    for (std::size_t k = 0; k < ground_.others().size(); ++k) {
      const Vec3 middle = collision::bounding_ball(ground_.others()[k].body).center;
      nearest.emplace_back(
          std::hypot(middle.x - a.x, middle.y - a.y) + std::hypot(middle.x - b.x, middle.y - b.y), k);
    }
    std::sort(nearest.begin(), nearest.end());
    const double round = 1.03 / std::cos(kPi / kDirections);
    std::size_t count = 0;
    for (const auto& [distance, k] : nearest) {
      if (count >= kMostCorners) return;
      const Other& other = ground_.others()[k];
      const double away = round * (ground_.farthest_beside(other) + ground_.clearance() + 1e-3);
      for (int side = 0; side < kDirections; ++side, ++count) {
        const double angle = 2 * kPi * side / kDirections;
        const Vec3 out{std::cos(angle), std::sin(angle), 0};
        const Vec3 at = other.body.core_support(out) + (other.body.radius + away) * out;
        add({at.x, at.y, 0});
      }
    }
  }

  void add_series() {
    const BasePlace &a = ground_.start(), &b = query_.goal;
    const double more = kAround + 2 * ground_.farthest();
    const double x = std::min(a.x, b.x) - more, y = std::min(a.y, b.y) - more;
    const double width = std::abs(a.x - b.x) + 2 * more, depth = std::abs(a.y - b.y) + 2 * more;
    for (std::size_t i = 1; i <= kSeries; ++i) add({x + width * halton(i, 2), y + depth * halton(i, 3), 0});
  }

  void expand(std::size_t from) {
    for (std::size_t to = 1; to < nodes_.size(); ++to) {
      if (nodes_[to].closed || to == from) continue;
      push(from, to, false);
      if (from == 0 || to == 1) push(from, to, true);
    }
  }

  void push(std::size_t from, std::size_t to, bool backwards) {
    const Node &a = nodes_[from], &b = nodes_[to];
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    const bool stays = length < kSamePlace;
    if (stays && (from != 0 || to != 1 || backwards)) return;
    const double along = std::atan2(b.y - a.y, b.x - a.x);
    const double heading = stays ? a.arrival : wrapped(backwards ? along + kPi : along);
    double cost = a.cost + length * (backwards ? kBackwardsCost : 1) +
                  kTurnCost * std::abs(wrapped(heading - a.arrival));
    if (to == 1) cost += kTurnCost * std::abs(wrapped(query_.goal.heading - heading));
    const double left = to == 1 ? 0 : std::hypot(query_.goal.x - b.x, query_.goal.y - b.y);
    open_.push({cost + left, cost, heading, from, to, backwards});
  }

  bool turns(Node& node) const {
    if (!node.turns) node.turns = ground_.turns_freely(node.x, node.y);
    return *node.turns;
  }

  bool is_possible(const Entry& entry) {
    Node &a = nodes_[entry.from], &b = nodes_[entry.to];
    if (entry.to != 1 && !turns(b)) return false;
    if (entry.from == 0 && !ground_.turn_is_free(ground_.start(), entry.heading)) return false;
    if (entry.to == 1 && !ground_.turn_is_free(query_.goal, entry.heading)) return false;
    return ground_.line_is_free({a.x, a.y, entry.heading}, {b.x, b.y, entry.heading});
  }

  BaseWay way() const {
    std::vector<std::size_t> path;
    for (std::size_t k = 1; k != 0; k = nodes_[k].parent) path.push_back(k);
    BaseWay out;
    out.outcome = BaseWayOutcome::found;
    BasePlace at = ground_.start();
    const auto turn = [&](double heading) {
      if (std::abs(wrapped(heading - at.heading)) < kSameHeading) return;
      out.legs.push_back({at, {at.x, at.y, heading}});
      at.heading = heading;
    };
    for (auto k = path.rbegin(); k != path.rend(); ++k) {
      const Node& node = nodes_[*k];
      if (std::hypot(node.x - at.x, node.y - at.y) < kSamePlace) continue;
      turn(node.arrival);
      out.legs.push_back({at, {node.x, node.y, node.arrival}, node.backwards});
      at = {node.x, node.y, node.arrival};
    }
    turn(query_.goal.heading);
    return out;
  }

  const Ground& ground_;
  const BaseWayQuery& query_;
  std::vector<Node> nodes_;
  std::priority_queue<Entry> open_;
};

}  // namespace

BaseWay find_base_way(const std::vector<Robot>& robots, const description::Scene& scene, const Moment& moment,
                      const BaseWayQuery& query) {
  Ground ground(robots, scene, moment, query);
  double least = query.clearance, room = std::numeric_limits<double>::infinity();
  const std::array<std::pair<BasePlace, BaseWayOutcome>, 2> ends{
      {{ground.start(), BaseWayOutcome::start_touches}, {query.goal, BaseWayOutcome::goal_touches}}};
  for (const auto& [place, outcome] : ends) {
    const Ground::Nearest near = ground.nearest(place, query.clearance + kMore.front());
    if (near.distance <= 0) return {outcome, {}, near.mine, near.other};
    if (near.distance < query.clearance) least = std::min(least, kRoom * near.distance);
    room = std::min(room, near.distance);
  }
  for (const double more : kMore) {
    const double wider = std::min(query.clearance + more, kRoom * room);
    if (wider <= least) continue;
    ground.keep(wider);
    if (BaseWay way = Search(ground, query).run(); way.outcome == BaseWayOutcome::found) return way;
  }
  ground.keep(least);
  return Search(ground, query).run();
}

}  // namespace polyarm::surroundings
