#include "polyarm/surroundings/steered_ways.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <queue>
#include <unordered_map>
#include <utility>

#include "polyarm/surroundings/car_ways.hpp"

namespace polyarm::surroundings {

namespace {

/// Costs in metres: of a metre backwards, and of a stop to steer.
constexpr double kBackwardsCost = 1.2, kStopCost = 0.2;
/// Length of a step of the search, in radii, and its bounds, m.
constexpr double kStep = 0.3, kShortestStep = 0.1, kLongestStep = 0.5;
/// Places that are equal for the search: in steps, and in rad.
constexpr double kSamePosition = 0.6, kSameDirection = 10 * std::numbers::pi / 180;
constexpr std::size_t kMostShots =
    4;  ///< ways to the goal that are tried from the start; half of them elsewhere
/// Far from the goal they are tried less often: from one place in so many, by radii to the goal.
constexpr double kShotsEvery = 0.5, kMostEvery = 8;
/// The rest of a way weighs more, so that few places are tried; the result is made shorter afterwards.
constexpr double kWeight = 1.5;
/// The region of the search around start, goal and obstacles, m, and around start and goal, where obstacles
/// are far.
constexpr double kAround = 2, kFarthest = 25;
/// Cells of the map that guides the search: m, and their number along a side.
constexpr double kCell = 0.1;
constexpr int kMostCells = 250;
/// If the map shows no way, few places are tried: it is not exact.
constexpr std::size_t kMostWithoutMap = 1500;
constexpr int kPasses = 3;  ///< of making a way shorter
/// A way is replaced if the other one costs so much less, m.
constexpr double kShorter = 1e-3;
/// A piece is tried in parts of this length for other ways, in steps.
constexpr double kPart = 2;

using Pieces = std::vector<CarPiece>;

bool is_straight(double curvature) {
  return std::abs(curvature) < 1e-9;
}

double cost_of(const CarPiece& piece) {
  return std::abs(piece.length) * (piece.length < 0 ? kBackwardsCost : 1);
}

/// Between two pieces the base stands if the steering or the direction changes.
bool joins(const CarPiece& a, const CarPiece& b) {
  return std::abs(a.curvature - b.curvature) < 1e-9 && (a.length < 0) == (b.length < 0);
}

/// Of pieces after `before`; its length 0: there is nothing before.
double cost_of(const CarPiece* first, std::size_t count, CarPiece before) {
  double out = 0;
  for (std::size_t k = 0; k < count; ++k) {
    out += cost_of(first[k]);
    if (before.length != 0 && !joins(before, first[k])) out += kStopCost;
    before = first[k];
  }
  return out;
}

struct Region {
  double left, right, below, above;
  bool contains(const BasePlace& at) const {
    return at.x >= left && at.x <= right && at.y >= below && at.y <= above;
  }
};

Region region_of(const Ground& ground, const BasePlace& goal, double radius) {
  const BasePlace& start = ground.start();
  const double more = kAround + std::min(4 * radius, kFarthest) + 2 * ground.farthest();
  const Region ends{std::min(start.x, goal.x), std::max(start.x, goal.x), std::min(start.y, goal.y),
                    std::max(start.y, goal.y)};
  Region out = ends;
  for (const OtherBody& other : ground.others()) {
    const collision::Bounds bounds = collision::bounds_of(other.body);
    out = {std::min(out.left, bounds.lower.x), std::max(out.right, bounds.upper.x),
           std::min(out.below, bounds.lower.y), std::max(out.above, bounds.upper.y)};
  }
  return {
      std::max(out.left, ends.left - kFarthest) - more, std::min(out.right, ends.right + kFarthest) + more,
      std::max(out.below, ends.below - kFarthest) - more, std::min(out.above, ends.above + kFarthest) + more};
}

/// Lengths of ways to the goal of something round that is inside the base: they guide the search where
/// obstacles are.
class DistanceMap {
 public:
  DistanceMap(const Ground& ground, const BasePlace& goal, const Region& region) : region_(region) {
    const double width = region.right - region.left, depth = region.above - region.below;
    cell_ = std::max(kCell, std::max(width, depth) / kMostCells);
    columns_ = static_cast<int>(std::ceil(width / cell_));
    rows_ = static_cast<int>(std::ceil(depth / cell_));
    length_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), kUnknown);
    fill(ground, goal);
  }
  /// True where the map shows something in the way.
  bool is_taken(const BasePlace& at) const {
    const int cell = cell_at(at);
    return cell < 0 || length_[static_cast<std::size_t>(cell)] == kTaken;
  }
  double cell() const { return cell_; }
  /// Infinite: there is no way, as far as the map shows.
  double length(const BasePlace& at) const {
    const int cell = cell_at(at);
    return cell < 0 || length_[static_cast<std::size_t>(cell)] < 0 ? std::numeric_limits<double>::infinity()
                                                                   : length_[static_cast<std::size_t>(cell)];
  }

 private:
  static constexpr double kUnknown = -1, kTaken = -2;

  int cell_at(const BasePlace& at) const {
    const int x = static_cast<int>((at.x - region_.left) / cell_);
    const int y = static_cast<int>((at.y - region_.below) / cell_);
    return x < 0 || y < 0 || x >= columns_ || y >= rows_ ? -1 : y * columns_ + x;
  }

  /// Dijkstra's search from the goal. The cells of the goal, of the start and around them count as free.
  void fill(const Ground& ground, const BasePlace& goal) {
    const Ground::Core core = ground.core();
    const double within = ground.clearance() - cell_;
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    const int first = cell_at(goal);
    if (first < 0) return;
    open.push({0, first});
    std::vector<char> seen(length_.size());
    while (!open.empty()) {
      const auto [length, cell] = open.top();
      open.pop();
      double& known = length_[static_cast<std::size_t>(cell)];
      if (known != kUnknown) continue;
      const int x = cell % columns_, y = cell / columns_;
      const double at_x = region_.left + (x + 0.5) * cell_, at_y = region_.below + (y + 0.5) * cell_;
      const double from_start = std::hypot(at_x - ground.start().x, at_y - ground.start().y);
      if (length > 2 * cell_ && from_start > 2 * cell_ && ground.is_beside(core, at_x, at_y, within)) {
        known = kTaken;
        continue;
      }
      known = length;
      for (int dx = -1; dx <= 1; ++dx)
        for (int dy = -1; dy <= 1; ++dy) {
          const int nx = x + dx, ny = y + dy;
          if (nx < 0 || ny < 0 || nx >= columns_ || ny >= rows_) continue;
          const int next = ny * columns_ + nx;
          if (length_[static_cast<std::size_t>(next)] == kUnknown)
            open.push({length + cell_ * std::hypot(dx, dy), next});
        }
    }
  }

  Region region_;
  double cell_ = kCell;
  int columns_ = 0, rows_ = 0;
  std::vector<double> length_;
};

class SteeredSearch {
 public:
  SteeredSearch(const Ground& ground, const BaseWayQuery& query)
      : ground_(ground),
        query_(query),
        radius_(1 / query.sharpest),
        step_(std::clamp(kStep * radius_, kShortestStep, kLongestStep)),
        region_(region_of(ground, query.goal, radius_)) {}

  BaseWay run(std::size_t most) {
    nodes_.push_back({ground_.start(), {}, 0, 0});
    if (is_there()) return {BaseWayOutcome::found, {}, {}, {}};
    shoot(0, kMostShots);
    if (!take_shots()) {
      map_.emplace(ground_, query_.goal, region_);
      if (!std::isfinite(map_->length(ground_.start()))) most = std::min(most, kMostWithoutMap);
      open_.push({0, 0, 0});
      const BaseWayOutcome outcome = search(most);
      if (outcome != BaseWayOutcome::found) return {outcome, {}, {}, {}};
    }
    shorten();
    return way();
  }

 private:
  struct Node {
    BasePlace at;
    CarPiece by;  ///< the piece that leads there; its length is 0 at the start
    std::size_t parent;
    double cost;
  };
  /// A place to go on from, or a shot from it to the goal.
  struct Entry {
    double estimate;
    std::size_t node;
    std::size_t shot;  ///< 0: none; else one more than its index
    bool operator<(const Entry& other) const {
      return estimate != other.estimate ? estimate > other.estimate : node > other.node;
    }
  };
  struct Shot {
    std::size_t node;
    CarWay way;
  };

  bool is_there() const {
    const BasePlace &a = ground_.start(), &b = query_.goal;
    return std::hypot(a.x - b.x, a.y - b.y) < kSamePlace &&
           std::abs(wrapped(a.heading - b.heading)) < kSamePlace;
  }

  /// A lower bound of the rest, except where only the map knows.
  double left(const BasePlace& at) const {
    const double free = shortest_car_way(at, query_.goal, radius_);
    const double around = map_ ? map_->length(at) : 0;
    return std::isfinite(around) ? std::max(free, around) : 2 * free;
  }

  /// The cheapest ways without obstacles from a node to the goal.
  void shoot(std::size_t node, std::size_t most) {
    std::vector<std::pair<double, CarWay>> all;
    for (const CarWay& way : car_ways(nodes_[node].at, query_.goal, radius_))
      all.emplace_back(cost_of(way.pieces.data(), way.count, nodes_[node].by), way);
    const std::size_t count = std::min(all.size(), most);
    std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end(),
                      [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t k = 0; k < count; ++k) {
      shots_.push_back({node, all[k].second});
      open_.push({nodes_[node].cost + kWeight * all[k].first, node, shots_.size()});
    }
  }

  bool is_free(BasePlace at, const CarPiece* pieces, std::size_t count) const {
    for (std::size_t k = 0; k < count; ++k) {
      if (!ground_.arc_is_free(at, pieces[k].curvature, pieces[k].length)) return false;
      at = along(at, pieces[k].curvature, pieces[k].length);
    }
    return true;
  }

  /// A quick look that spares most exact ones.
  bool meets_map(BasePlace at, const CarWay& way) const {
    for (std::size_t k = 0; k < way.count; ++k) {
      const auto& [curvature, length] = way.pieces[k];
      const int steps = 1 + static_cast<int>(std::abs(length) / map_->cell());
      for (int i = 0; i <= steps; ++i)
        if (map_->is_taken(along(at, curvature, length * i / steps))) return true;
      at = along(at, curvature, length);
    }
    return false;
  }

  /// True if the shot is free: it ends the search.
  bool take(std::size_t shot) {
    const auto& [node, way] = shots_[shot];
    if (map_ && meets_map(nodes_[node].at, way)) return false;
    if (!is_free(nodes_[node].at, way.pieces.data(), way.count)) return false;
    for (std::size_t k = node; k != 0; k = nodes_[k].parent) pieces_.push_back(nodes_[k].by);
    std::reverse(pieces_.begin(), pieces_.end());
    pieces_.insert(pieces_.end(), way.pieces.begin(),
                   way.pieces.begin() + static_cast<std::ptrdiff_t>(way.count));
    return true;
  }

  bool take_shots() {
    for (; !open_.empty(); open_.pop())
      if (take(open_.top().shot - 1)) return true;
    return false;
  }

  std::uint64_t key_of(const BasePlace& at) const {
    constexpr std::uint64_t kMiddle = 1 << 20;
    const auto part = [](double value) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value)) +
                                        static_cast<std::int64_t>(kMiddle)) &
             (2 * kMiddle - 1);
    };
    const double cell = kSamePosition * step_;
    return part(at.x / cell) << 42 | part(at.y / cell) << 21 | part(wrapped(at.heading) / kSameDirection);
  }

  BaseWayOutcome search(std::size_t most) {
    std::size_t expanded = 0;
    while (!open_.empty()) {
      const Entry entry = open_.top();
      open_.pop();
      if (query_.stop && query_.stop()) return BaseWayOutcome::out_of_time;
      if (entry.shot != 0) {
        if (take(entry.shot - 1)) return BaseWayOutcome::found;
        continue;
      }
      if (!closed_.emplace(key_of(nodes_[entry.node].at), entry.node).second) continue;
      if (++expanded > most) return BaseWayOutcome::no_way;
      const double every = std::min(kMostEvery, 1 + kShotsEvery * left(nodes_[entry.node].at) / radius_);
      if (entry.node != 0 && expanded % static_cast<std::size_t>(every) == 0)
        shoot(entry.node, kMostShots / 2);
      expand(entry.node);
    }
    return BaseWayOutcome::no_way;
  }

  void expand(std::size_t node) {
    for (const double length : {step_, -step_})
      for (const double side : {-1.0, 0.0, 1.0}) {
        const CarPiece piece{side / radius_, length};
        const BasePlace to = along(nodes_[node].at, piece.curvature, length);
        if (!region_.contains(to) || map_->is_taken(to) || closed_.contains(key_of(to))) continue;
        if (!ground_.arc_is_free(nodes_[node].at, piece.curvature, length)) continue;
        const double cost = nodes_[node].cost + cost_of(&piece, 1, nodes_[node].by);
        nodes_.push_back({to, piece, node, cost});
        open_.push({cost + kWeight * left(to), nodes_.size() - 1, 0});
      }
  }

  /// Joins pieces that need no stop between them.
  void join() {
    Pieces out;
    for (const CarPiece& piece : pieces_)
      if (!out.empty() && joins(out.back(), piece))
        out.back().length += piece.length;
      else
        out.push_back(piece);
    pieces_ = std::move(out);
  }

  /// Replaces parts of the way by cheaper ones without obstacles.
  void shorten() {
    join();
    for (int pass = 0; pass < kPasses && pieces_.size() > 1; ++pass)
      if (!shorten_once()) return;
  }

  bool shorten_once() {
    split();
    std::vector<BasePlace> places{ground_.start()};
    for (const CarPiece& piece : pieces_)
      places.push_back(along(places.back(), piece.curvature, piece.length));
    Pieces out;
    bool shorter = false;
    for (std::size_t i = 0; i < pieces_.size();) {
      std::size_t j = pieces_.size();
      for (; j > i + 1; --j)
        if (const auto way = cheaper(places[i], places[j], i, j, out)) {
          out.insert(out.end(), way->pieces.begin(),
                     way->pieces.begin() + static_cast<std::ptrdiff_t>(way->count));
          shorter = true;
          break;
        }
      if (j == i + 1) out.push_back(pieces_[i]);
      i = j;
      if (query_.stop && query_.stop()) {
        out.insert(out.end(), pieces_.begin() + static_cast<std::ptrdiff_t>(i), pieces_.end());
        break;
      }
    }
    pieces_ = std::move(out);
    join();
    return shorter;
  }

  /// Long pieces are cut, so that other ways may begin and end within them.
  void split() {
    Pieces out;
    for (const CarPiece& piece : pieces_) {
      const int parts = std::max(1, static_cast<int>(std::abs(piece.length) / (kPart * step_)));
      for (int k = 0; k < parts; ++k) out.push_back({piece.curvature, piece.length / parts});
    }
    pieces_ = std::move(out);
  }

  std::optional<CarWay> cheaper(const BasePlace& from, const BasePlace& to, std::size_t i, std::size_t j,
                                const Pieces& before) const {
    const CarPiece last = before.empty() ? CarPiece{} : before.back();
    const auto cost_with_next = [&](const CarPiece* pieces, std::size_t count) {
      double cost = cost_of(pieces, count, last);
      if (j < pieces_.size() && count > 0 && !joins(pieces[count - 1], pieces_[j])) cost += kStopCost;
      return cost;
    };
    double least = cost_with_next(pieces_.data() + i, j - i) - kShorter;
    if (shortest_car_way(from, to, radius_) > least) return std::nullopt;
    std::optional<CarWay> out;
    for (const CarWay& way : car_ways(from, to, radius_)) {
      if (way.count == 0) continue;
      const double cost = cost_with_next(way.pieces.data(), way.count);
      if (cost >= least || !is_free(from, way.pieces.data(), way.count)) continue;
      least = cost;
      out = way;
    }
    return out;
  }

  BaseWay way() const {
    BaseWay out;
    out.outcome = BaseWayOutcome::found;
    BasePlace at = ground_.start();
    for (const CarPiece& piece : pieces_) {
      const BasePlace to = along(at, piece.curvature, piece.length);
      out.legs.push_back({at, to, piece.length < 0, is_straight(piece.curvature) ? 0 : piece.curvature,
                          std::abs(piece.length)});
      at = to;
    }
    return out;
  }

  const Ground& ground_;
  const BaseWayQuery& query_;
  const double radius_, step_;
  const Region region_;
  std::optional<DistanceMap> map_;
  std::vector<Node> nodes_;
  std::vector<Shot> shots_;
  std::priority_queue<Entry> open_;
  std::unordered_map<std::uint64_t, std::size_t> closed_;
  Pieces pieces_;
};

}  // namespace

BaseWay find_steered_way(const Ground& ground, const BaseWayQuery& query, std::size_t most) {
  return SteeredSearch(ground, query).run(most);
}

}  // namespace polyarm::surroundings
