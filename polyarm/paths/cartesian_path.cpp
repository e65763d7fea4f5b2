#include "polyarm/paths/cartesian_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "polyarm/paths/spline.hpp"

namespace polyarm::paths {
namespace {

constexpr double kSame = 1e-9;      // m or rad: nearer poses are the same
constexpr double kSameLine = 1e-9;  // sine of the angle at which points of an arc count as collinear
constexpr double kMostTurn = 3;     // rad, between poses of a spline
constexpr double kInfinite = std::numeric_limits<double>::infinity();

bool finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool finite(const Quaternion& q) {
  const double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  return std::isfinite(square) && std::abs(square - 1) < 1e-3;
}

/// The parameter length between two poses: metres, or radians if the TCP only rotates; 0 if the poses are
/// equal.
double measure(const Pose& a, const Pose& b) {
  const double metres = norm(b.position - a.position), turn = angle_between(a.rotation, b.rotation);
  if (metres <= kSame && turn <= kSame) return 0;
  return metres >= CartesianPath::kTurning * turn ? metres : turn;
}

/// Center of the circle through `a`, `b` and the origin.
Vec3 circle_center(const Vec3& a, const Vec3& b) {
  const Vec3 normal = cross(a, b);
  return 0.5 / dot(normal, normal) * cross(dot(a, a) * b - dot(b, b) * a, normal);
}

Vec3 at_most(const Vec3& v, double length) {
  const double n = norm(v);
  return n > length ? length / n * v : v;
}

/// The rates and their derivatives at every pose, from the parabola through the pose and its neighbours. The
/// parabola overshoots if the neighbours rotate by very different amounts for their distance. Therefore no
/// rate exceeds 1.5 times the slower mean rate beside it, and no change of rate exceeds twice the slower rate
/// per interval.
std::vector<BodyRate> spline_rates(std::span<const Vec3> turns, std::span<const double> gaps) {
  const std::size_t last = turns.size();
  std::vector<BodyRate> out(last + 1);
  const auto mean = [&](std::size_t i) { return 1 / gaps[i] * turns[i]; };
  for (std::size_t i = 1; i < last; ++i) {
    const double sum = gaps[i - 1] + gaps[i], before = norm(mean(i - 1)), after = norm(mean(i));
    const Vec3 rate = gaps[i] / sum * mean(i - 1) + gaps[i - 1] / sum * mean(i);
    out[i].value = at_most(rate, 1.5 * std::min(before, after));
    out[i].first =
        at_most(2 / sum * (mean(i) - mean(i - 1)), 2 * std::min(before / gaps[i - 1], after / gaps[i]));
  }
  out[0].value = last > 1 ? 1.5 * mean(0) - 0.5 * out[1].value : mean(0);
  out[last].value = last > 1 ? 1.5 * mean(last - 1) - 0.5 * out[last - 1].value : mean(0);
  return out;
}

std::vector<PosePiece> spline_pieces(const std::vector<Pose>& poses) {
  std::vector<double> points, shortest;
  std::vector<Vec3> turns;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vec3& p = poses[i].position;
    points.insert(points.end(), {p.x, p.y, p.z});
    if (i == 0) continue;
    shortest.push_back(measure(poses[i - 1], poses[i]));
    turns.push_back(to_rotation_vector(inverse(poses[i - 1].rotation) * poses[i].rotation));
  }
  const CubicSpline curve = cubic_spline(points, 3, {}, shortest);
  std::vector<double> gaps;
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) gaps.push_back(curve.knots[i + 1] - curve.knots[i]);
  const std::vector<BodyRate> rates = spline_rates(turns, gaps);
  const auto node = [&](std::size_t i) {
    const auto vector = [&](const std::vector<double>& of) {
      return Vec3{of[3 * i], of[3 * i + 1], of[3 * i + 2]};
    };
    const Quaternion& r = poses[i].rotation;
    return PoseDerivatives{poses[i],
                           {vector(curve.first), vector(curve.second), {}},
                           {r * rates[i].value, r * rates[i].first, {}}};
  };
  std::vector<PosePiece> out;
  for (std::size_t i = 0; i < gaps.size(); ++i)
    out.push_back(joining_piece(node(i), node(i + 1), poses[i].rotation, gaps[i]));
  return out;
}

}  // namespace

PoseDerivatives CartesianPath::on_piece(std::size_t i, double s) const noexcept {
  return parts_[i].piece.at(parts_[i].offset + (s - breaks_[i]));
}

PoseDerivatives CartesianPath::at(double s) const noexcept {
  if (parts_.empty()) return {start_, {}, {}};
  s = std::clamp(s, 0.0, length());
  const auto after = std::upper_bound(breaks_.begin() + 1, breaks_.end() - 1, s);
  return on_piece(static_cast<std::size_t>(after - breaks_.begin()) - 1, s);
}

void CartesianPath::append(const PosePiece& piece, double offset, double length) {
  if (!parts_.empty()) breaks_.push_back(breaks_.back());
  breaks_.back() += length;
  parts_.push_back({piece, offset});
}

PoseDerivatives CartesianPathBuilder::Segment::at(double x) const noexcept {
  const auto after = std::upper_bound(begins.begin() + 1, begins.end(), x);
  const std::size_t i = static_cast<std::size_t>(after - begins.begin()) - 1;
  return pieces[i].at(std::min(x - begins[i], pieces[i].length));
}

CartesianPathBuilder::CartesianPathBuilder(const Pose& start) : start_(start), end_(start) {
  if (!finite(start.position) || !finite(start.rotation))
    problems_.error("bad-number", {},
                    "the start of the path is not a pose: a number is NaN or infinite, or the quaternion is "
                    "not of length 1");
  start_.rotation = end_.rotation = normalized(start.rotation);
}

std::string CartesianPathBuilder::next_name(const Corner& corner) const {
  return corner.name.empty() ? fmt::format("waypoint {}", waypoints_) : corner.name;
}

bool CartesianPathBuilder::fine(const Pose& pose, const Corner& corner) {
  const std::size_t before = problems_.list().size();
  if (!finite(pose.position) || !finite(pose.rotation))
    problems_.error(
        "bad-number", {},
        fmt::format("{} is not a pose: a number is NaN or infinite, or the quaternion is not of length 1",
                    next_name(corner)));
  if (!std::isfinite(corner.radius) || corner.radius < 0)
    problems_.error("bad-radius", {},
                    fmt::format("the radius of {} is {} m", next_name(corner), corner.radius),
                    "a radius is 0 (stop there) or more");
  const bool ok = problems_.list().size() == before;
  if (!ok) ++waypoints_;
  return ok;
}

void CartesianPathBuilder::add(std::vector<PosePiece> pieces, double curve_radius, const Pose& end,
                               const Corner& corner) {
  Segment out{std::move(pieces), {}, 0, curve_radius, {corner.radius, next_name(corner)}, end, waypoints_};
  for (const PosePiece& piece : out.pieces) {
    out.begins.push_back(out.length);
    out.length += piece.length;
  }
  ++waypoints_;
  end_ = end;
  segments_.push_back(std::move(out));
}

double CartesianPathBuilder::length() const noexcept {
  double sum = 0;
  for (const Segment& segment : segments_) sum += segment.length;
  return sum;
}

CartesianPathBuilder& CartesianPathBuilder::line(const Pose& to, const Corner& corner) {
  if (!fine(to, corner)) return *this;
  const Pose target{to.position, normalized(to.rotation)};
  const double length = measure(end_, target);
  if (length > 0) {
    add({line_piece(end_, target, length)}, kInfinite, target, corner);
    return *this;
  }
  repeated_.push_back({{"waypoint-repeated",
                        {},
                        fmt::format("{} is where the path is already; they count once", next_name(corner)),
                        {},
                        Severity::warning},
                       waypoints_});
  if (!segments_.empty())
    segments_.back().corner.radius = std::min(segments_.back().corner.radius, corner.radius);
  ++waypoints_;
  return *this;
}

void CartesianPathBuilder::add_arc(const Vec3& center, const Vec3& axis, double angle,
                                   ArcOrientation orientation, const std::optional<Quaternion>& end,
                                   const std::optional<Vec3>& end_point, const Corner& corner) {
  const double radius = norm(end_.position - center);
  if (!(radius > kSame) || !(radius * std::abs(angle) > kSame)) {
    problems_.error("no-arc", {},
                    fmt::format("the arc to {} has radius {:.3g} m and {:.3g} rad: nothing to follow",
                                next_name(corner), radius, angle),
                    "use a line");
    ++waypoints_;
    return;
  }
  Vec3 turn;
  if (orientation == ArcOrientation::tangent)
    turn = (angle < 0 ? -1 : 1) / radius * (inverse(end_.rotation) * axis);
  if (orientation == ArcOrientation::interpolated && end)
    turn = 1 / (radius * std::abs(angle)) * to_rotation_vector(inverse(end_.rotation) * normalized(*end));
  const PosePiece piece = arc_piece(end_, center, axis, angle, turn);
  Pose target = piece.at(piece.length).pose;
  if (end_point) target.position = *end_point;
  add({piece}, radius, target, corner);
}

CartesianPathBuilder& CartesianPathBuilder::arc(const Vec3& via, const Pose& to, ArcOrientation orientation,
                                                const Corner& corner) {
  if (!fine({via, to.rotation}, corner) || !fine(to, corner)) return *this;
  const Vec3 a = via - end_.position, b = to.position - end_.position, normal = cross(a, b);
  if (!(norm(normal) > kSameLine * norm(a) * norm(b)) || norm(b - a) <= kSame) {
    problems_.error(
        "no-arc", {},
        fmt::format("the arc to {} has its start, via point and end on a line", next_name(corner)),
        "move the via point aside, or use a line; a whole circle is given by two more points");
    ++waypoints_;
    return *this;
  }
  const Vec3 center = end_.position + circle_center(a, b), axis = normalized(normal);
  const Vec3 across = end_.position - center, out = to.position - center;
  double angle = std::atan2(dot(out, cross(axis, across)), dot(out, across));
  if (angle <= 0) angle += 2 * std::numbers::pi;
  add_arc(center, axis, angle, orientation, to.rotation, to.position, corner);
  return *this;
}

CartesianPathBuilder& CartesianPathBuilder::arc_about(const Vec3& center, const Vec3& axis, double angle,
                                                      ArcOrientation orientation, const Corner& corner,
                                                      std::optional<Quaternion> end_rotation) {
  if (!fine({center, end_rotation.value_or(Quaternion{})}, corner)) return *this;
  if (!finite(axis) || !(norm(axis) > 0) || !std::isfinite(angle)) {
    problems_.error("no-axis", {}, fmt::format("the arc to {} has no axis, or no angle", next_name(corner)));
    ++waypoints_;
    return *this;
  }
  const Vec3 unit = normalized(axis);
  const Vec3 middle = center + dot(end_.position - center, unit) * unit;
  add_arc(middle, unit, angle, orientation, end_rotation, {}, corner);
  return *this;
}

CartesianPathBuilder& CartesianPathBuilder::circle(const Vec3& via, const Vec3& second,
                                                   ArcOrientation orientation, const Corner& corner) {
  if (!fine({via, {}}, corner) || !fine({second, {}}, corner)) return *this;
  const Vec3 a = via - end_.position, b = second - end_.position, normal = cross(a, b);
  if (!(norm(normal) > kSameLine * norm(a) * norm(b))) {
    problems_.error("no-arc", {}, fmt::format("the circle to {} has its points on a line", next_name(corner)),
                    "give two further points of the circle, apart from the start and from each other");
    ++waypoints_;
    return *this;
  }
  add_arc(end_.position + circle_center(a, b), normalized(normal), 2 * std::numbers::pi, orientation, {},
          end_.position, corner);
  return *this;
}

CartesianPathBuilder& CartesianPathBuilder::spline(std::span<const Pose> through, const Corner& corner) {
  std::vector<Pose> poses{end_};
  for (const Pose& pose : through) {
    if (!fine(pose, corner)) return *this;
    const Pose next{pose.position, normalized(pose.rotation)};
    if (measure(poses.back(), next) == 0) continue;
    if (const double turn = angle_between(poses.back().rotation, next.rotation); turn > kMostTurn)
      problems_.error(
          "turn-too-large", {},
          fmt::format("the spline to {} turns by {:.3g} rad between two of its poses, at most {} are "
                      "clear in their direction",
                      next_name(corner), turn, kMostTurn),
          "put a pose between them");
    poses.push_back(next);
  }
  if (poses.size() < 2) {
    problems_.error("no-waypoints", {},
                    fmt::format("the spline to {} has no pose to go to", next_name(corner)));
    ++waypoints_;
    return *this;
  }
  const Pose end = poses.back();
  add(spline_pieces(poses), kInfinite, end, corner);
  return *this;
}

}  // namespace polyarm::paths
