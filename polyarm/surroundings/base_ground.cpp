#include "polyarm/surroundings/base_ground.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/collision/separation.hpp"

namespace polyarm::surroundings {

using collision::ConvexBody;

namespace {

constexpr double kPi = std::numbers::pi;
/// Bodies that end this far above the lowest point of the base are ground that it drives on, m.
constexpr double kGround = 5e-3;
/// A part this near to the base lies on it, m.
constexpr double kLiesOn = 2e-3;
/// Partial turns and arcs are checked in steps of this angle; along arcs points leave the swept hull by at
/// most kSagitta, m.
constexpr double kTurnStep = 10 * kPi / 180, kSagitta = 5e-3;
/// A turn beyond this may be done by either side, because the base is not exactly where it should be.
constexpr double kEitherSide = 170 * kPi / 180;
constexpr double kStraight = 1e-9;  ///< 1/m

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

/// A ball around the body: larger than bounding_ball(), but quick.
collision::Ball quick_ball(const ConvexBody& body) {
  Vec3 lower = body.points.front(), upper = lower;
  for (const Vec3& point : body.points) {
    lower = {std::min(lower.x, point.x), std::min(lower.y, point.y), std::min(lower.z, point.z)};
    upper = {std::max(upper.x, point.x), std::max(upper.y, point.y), std::max(upper.z, point.z)};
  }
  return {0.5 * (lower + upper), 0.5 * norm(upper - lower) + body.disc + body.radius};
}

double top(const ConvexBody& body) {
  return body.core_support({0, 0, 1}).z + body.radius;
}

double bottom(const ConvexBody& body) {
  return body.core_support({0, 0, -1}).z - body.radius;
}

}  // namespace

BasePlace along(const BasePlace& from, double curvature, double length) {
  if (std::abs(curvature) < kStraight)
    return {from.x + length * std::cos(from.heading), from.y + length * std::sin(from.heading), from.heading};
  const double heading = from.heading + curvature * length;
  return {from.x + (std::sin(heading) - std::sin(from.heading)) / curvature,
          from.y - (std::cos(heading) - std::cos(from.heading)) / curvature, heading};
}

Ground::Ground(const std::vector<Robot>& robots, const description::Scene& scene, const Moment& moment,
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
  for (const OwnBody& own : own_) low_ = std::min(low_, own.low);
  add_loads();
  for (const OwnBody& own : own_) {
    high_ = std::max(high_, own.high);
    farthest_ = std::max(farthest_, own.farthest);
  }
  for (const SweptBody& body : bodies_)
    if (!is_own(body) && !is_load(body) && body.kind != BodyKind::floor) add_other(body);
  std::vector<collision::Bounds> bounds;
  for (const OtherBody& other : others_) bounds.push_back(collision::bounds_of(other.body));
  if (!bounds.empty()) tree_ = collision::BoxTree(bounds);
}

double Ground::farthest_beside(const OtherBody& other) const {
  double out = 0;
  for (const OwnBody& own : own_)
    if (own.low < other.high + clearance_ && own.high > other.low - clearance_)
      out = std::max(out, own.farthest);
  return out;
}

Ground::Nearest Ground::nearest(const BasePlace& place, double within) const {
  Nearest out;
  for (const OwnBody& own : own_)
    each_near(moved(pose_of(place), own.body), within, [&](const OtherBody& other, double distance) {
      if (distance < out.distance) out = {distance, own.name, other.name};
      return false;
    });
  return out;
}

bool Ground::is_beside(const Core& core, double x, double y, double within) const {
  ConvexBody line;
  line.points = {{x, y, core.low}, {x, y, core.high}};
  return each_near(line, core.radius + within, [](const OtherBody&, double) { return true; });
}

/// The cylinder is taken from the body that extends farthest to all sides of the axis, without its upper and
/// its lower quarter, which may be narrower.
Ground::Core Ground::core() const {
  constexpr int kDirections = 16;
  Core out{0, (low_ + high_) / 2, (low_ + high_) / 2};
  for (const OwnBody& own : own_) {
    double radius = std::numeric_limits<double>::infinity();
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2 * kPi * k / kDirections;
      const Vec3 side{std::cos(angle), std::sin(angle), 0};
      radius = std::min(radius, dot(side, own.body.core_support(side)) + own.body.radius);
    }
    if (radius <= out.radius) continue;
    const double quarter = (own.high - own.low) / 4;
    out = {radius, own.low + quarter, own.high - quarter};
  }
  return out;
}

bool Ground::line_is_free(const BasePlace& from, const BasePlace& to) const {
  return std::all_of(own_.begin(), own_.end(), [&](const OwnBody& own) {
    return is_free(hull_of(moved(pose_of(from), own.body), moved(pose_of(to), own.body)));
  });
}

/// True if nothing can be near to the base there, and up to `more` m from there.
bool Ground::is_empty_around(const BasePlace& at, double more) const {
  bool empty = true;
  const double half = (high_ - low_) / 2;
  const double radius = std::hypot(farthest_, half) + more + clearance_;
  tree_.each_near(
      {at.x, at.y, low_ + half}, [&] { return empty ? radius : -1; }, [&](std::size_t) { empty = false; });
  return empty;
}

/// Between two poses that are a turn about a vertical axis apart, with no point farther than `radius` from it
/// beyond the extent of the base.
bool Ground::turned_is_free(const Pose& from, const Pose& to, double turn, double radius) const {
  return std::all_of(own_.begin(), own_.end(), [&](const OwnBody& own) {
    ConvexBody swept = hull_of(moved(from, own.body), moved(to, own.body));
    swept.radius += (radius + own.farthest) * (1 - std::cos(turn / 2));  // points go along arcs
    return is_free(swept);
  });
}

bool Ground::arc_is_free(const BasePlace& from, double curvature, double length) const {
  if (std::abs(curvature) < kStraight) return line_is_free(from, along(from, 0, length));
  const double radius = 1 / std::abs(curvature), turn = std::abs(curvature * length);
  const double finest = 2 * std::acos(1 - std::min(1.0, kSagitta / (radius + farthest_)));
  const int steps = std::max(1, static_cast<int>(std::ceil(turn / std::min(kTurnStep, finest))));
  const double step = length / steps;
  for (int k = 0; k < steps; ++k) {
    const BasePlace begin = along(from, curvature, k * step), end = along(from, curvature, (k + 1) * step);
    if (is_empty_around(begin, turn / steps * (radius + farthest_))) continue;
    if (!turned_is_free(pose_of(begin), pose_of(end), turn / steps, radius)) return false;
  }
  return true;
}

bool Ground::turns_freely(double x, double y) const {
  return std::all_of(own_.begin(), own_.end(), [&](const OwnBody& own) {
    ConvexBody swept;
    swept.points = {{x, y, own.low}, {x, y, own.high}};
    swept.disc = own.farthest;
    return is_free(swept);
  });
}

bool Ground::turn_is_free(const BasePlace& at, double heading) const {
  const double turn = wrapped(heading - at.heading);
  if (std::abs(turn) < kSameHeading || turns_freely(at.x, at.y)) return true;
  if (std::abs(turn) > kEitherSide) return false;
  const int steps = static_cast<int>(std::ceil(std::abs(turn) / kTurnStep));
  const double step = turn / steps;
  for (int k = 0; k < steps; ++k)
    if (!turned_is_free(pose_of({at.x, at.y, at.heading + k * step}),
                        pose_of({at.x, at.y, at.heading + (k + 1) * step}), step, 0))
      return false;
  return true;
}

/// The robot and those on it.
bool Ground::is_carried(int robot) const {
  for (std::size_t steps = 0; robot >= 0 && steps <= robots_.size(); ++steps) {
    if (robot == static_cast<int>(query_.robot)) return true;
    robot = robots_[static_cast<std::size_t>(robot)].on;
  }
  return false;
}

bool Ground::is_own(const SweptBody& body) const {
  if (body.part < 0) return body.robot >= 0 && is_carried(body.robot);
  const auto part = static_cast<std::size_t>(body.part);
  return part < moment_.parts.size() && moment_.parts[part].in_world && moment_.parts[part].held_by >= 0 &&
         is_carried(moment_.parts[part].held_by);
}

/// Empty: it is not in the world.
std::optional<Pose> Ground::place_of(const SweptBody& body) const {
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

void Ground::add_own(const SweptBody& body) {
  const std::optional<Pose> place = place_of(body);
  if (!place) return;
  const Pose T_plane = inverse(pose_of(start_)) * *place;
  for (const ConvexBody& piece : body.pieces) {
    OwnBody own{without_discs(moved(T_plane, piece)), body.name};
    own.low = bottom(own.body), own.high = top(own.body);
    for (const Vec3& point : own.body.points)
      own.farthest = std::max(own.farthest, std::hypot(point.x, point.y) + own.body.radius);
    own_.push_back(std::move(own));
  }
}

bool Ground::is_load(const SweptBody& body) const {
  return body.part >= 0 && static_cast<std::size_t>(body.part) < is_load_.size() &&
         is_load_[static_cast<std::size_t>(body.part)] != 0;
}

/// Parts that nobody holds and that lie on the base, or on each other there.
void Ground::add_loads() {
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

void Ground::add_other(const SweptBody& body) {
  const std::optional<Pose> place = place_of(body);
  if (!place) return;
  for (const ConvexBody& piece : body.pieces) {
    OtherBody other{moved(*place, piece), body.name};
    other.low = bottom(other.body), other.high = top(other.body);
    if (other.high > low_ + kGround && other.low < high_ + query_.clearance)
      others_.push_back(std::move(other));
  }
}

/// A part on the ground beside the base does not lie on the base.
bool Ground::lies_on_base(const SweptBody& part, const Pose& place) const {
  for (const ConvexBody& piece : part.pieces)
    if (bottom(moved(place, piece)) <= low_ + kGround) return false;
  const Pose T_world_plane = pose_of(start_);
  for (const ConvexBody& piece : part.pieces)
    for (const OwnBody& own : own_)
      if (separation(own.body, inverse(place) * T_world_plane, piece).distance < kLiesOn) return true;
  return false;
}

/// Calls take(other, distance) until it returns true.
template <typename Take>
bool Ground::each_near(const ConvexBody& swept, double within, const Take& take) const {
  if (tree_.empty()) return false;
  const collision::Ball ball = quick_ball(swept);
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

bool Ground::is_free(const ConvexBody& swept) const {
  return !each_near(swept, clearance_, [](const OtherBody&, double) { return true; });
}

}  // namespace polyarm::surroundings
