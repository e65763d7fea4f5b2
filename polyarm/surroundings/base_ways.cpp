#include "polyarm/surroundings/base_ways.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>
#include <utility>

#include "polyarm/surroundings/base_ground.hpp"
#include "polyarm/surroundings/steered_ways.hpp"

namespace polyarm::surroundings {

namespace {

constexpr double kPi = std::numbers::pi;
/// Of the distance that start or goal leave, so much is kept.
constexpr double kRoom = 0.8;
/// A way is searched with so much more clearance first, m: guards stop a base that comes near to something
/// fast.
constexpr std::array kMore{0.05, 0.02};
/// Costs in metres: of a turn by 1 rad, and of a metre backwards.
constexpr double kTurnCost = 0.3, kBackwardsCost = 2;
constexpr int kDirections = 16;  ///< of places around an obstacle
constexpr std::size_t kMostCorners = 700, kSeries = 250;
constexpr std::size_t kMostChecks = 40'000;  ///< of edges in one search
/// Places from which one search of a base that steers goes on: with the least clearance, and with more.
constexpr std::size_t kMostSteered = 8'000, kMostSteeredWide = 1'500;
constexpr double kFarthestAxis = 4, kAround = 2;  ///< m: places on the axes; the region beyond start and goal

/// Halton's series: numbers that fill 0 to 1 evenly.
double halton(std::size_t index, std::size_t base) {
  double out = 0, share = 1;
  for (std::size_t i = index; i > 0; i /= base) {
    share /= static_cast<double>(base);
    out += share * static_cast<double>(i % base);
  }
  return out;
}

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
      const OtherBody& other = ground_.others()[k];
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
      out.legs.push_back({at, {at.x, at.y, heading}, false, 0, 0});
      at.heading = heading;
    };
    for (auto k = path.rbegin(); k != path.rend(); ++k) {
      const Node& node = nodes_[*k];
      const double length = std::hypot(node.x - at.x, node.y - at.y);
      if (length < kSamePlace) continue;
      turn(node.arrival);
      out.legs.push_back({at, {node.x, node.y, node.arrival}, node.backwards, 0, length});
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

BaseWay search(Ground& ground, double clearance, const BaseWayQuery& query, std::size_t most_steered) {
  ground.keep(clearance);
  BaseWay out = std::isfinite(query.sharpest) ? find_steered_way(ground, query, most_steered)
                                              : Search(ground, query).run();
  out.kept = clearance;
  return out;
}

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
    if (wider <= least || (std::isfinite(query.sharpest) && more != kMore.front())) continue;
    BaseWay way = search(ground, wider, query, kMostSteeredWide);
    if (way.outcome == BaseWayOutcome::found || (query.stop && query.stop())) return way;
  }
  return search(ground, least, query, kMostSteered);
}

}  // namespace polyarm::surroundings
