#include "polyarm/paths/joint_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/paths/hermite.hpp"
#include "polyarm/paths/polynomial_path.hpp"
#include "polyarm/paths/spline.hpp"

namespace polyarm::paths {
namespace {

constexpr double kSameWaypoint = 1e-9;   // in the joint norm: nearer waypoints are the same
constexpr double kTurnsBack = 1e-3;      // length of the sum of unit directions at which they count as
                                         // opposite
constexpr double kStraight = 1e-12;      // length of the difference at which directions count as equal
constexpr double kLineRounding = 1e-13;  // relative: a line that is shorter than this between its two corners
                                         // is omitted
constexpr int kBisections = 16;          // steps to convert a radius at the TCP into one of joints
constexpr int kSamples = 16;             // points of a corner at which the distance at the TCP is measured
constexpr std::size_t kPowers = PolynomialPath::kCoefficients;

std::string name_of(const JointWaypoint& waypoint, std::size_t index) {
  return waypoint.name.empty() ? fmt::format("waypoint {}", index) : waypoint.name;
}

void check(std::span<const JointWaypoint> waypoints, const JointPathOptions& options) {
  Problems found;
  if (waypoints.empty()) throw Error("no-waypoints", "a path needs at least one waypoint");
  const std::size_t joints = waypoints.front().q.size();
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const JointWaypoint& w = waypoints[i];
    const std::string name = name_of(w, i);
    if (w.q.size() != joints || joints == 0)
      found.error("wrong-size", {},
                  fmt::format("{} has {} joint values, the first waypoint has {}", name, w.q.size(), joints));
    for (std::size_t j = 0; j < w.q.size(); ++j)
      if (!std::isfinite(w.q[j]))
        found.error("bad-number", {}, fmt::format("joint {} of {} is {}", j, name, w.q[j]));
    if (!std::isfinite(w.radius) || w.radius < 0)
      found.error("bad-radius", {}, fmt::format("the radius of {} is {}", name, w.radius),
                  "a radius is 0 (stop there) or more");
  }
  if (!options.weights.empty() && options.weights.size() != joints)
    found.error("wrong-size", {}, fmt::format("{} weights for {} joints", options.weights.size(), joints));
  for (const double weight : options.weights)
    if (!std::isfinite(weight) || weight <= 0)
      found.error("bad-weight", {}, fmt::format("a weight of the joint norm is {}", weight),
                  "weights are above 0");
  found.throw_if_errors();
}

struct Point {
  std::vector<double> q;
  double radius = 0;
  std::string name;
  std::size_t waypoint = 0;
};

/// The line from a point to the next.
struct Line {
  std::vector<double> direction;  ///< of norm 1
  double length = 0;
};

class Lines {
 public:
  Lines(std::span<const JointWaypoint> waypoints, const JointPathOptions& options)
      : options_(options), joints_(waypoints.front().q.size()) {
    for (std::size_t i = 0; i < waypoints.size(); ++i) add(waypoints[i], i, i + 1 == waypoints.size());
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) lines_.push_back(line(i));
  }

  PathSections rounded() {
    std::vector<double> trims(points_.size(), 0.0);
    for (std::size_t i = 1; i + 1 < points_.size(); ++i) trims[i] = trim(i);
    auto path = std::make_unique<PolynomialPath>(points_.front().q);
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      append_line(*path, i, trims[i], trims[i + 1]);
      if (i + 1 == lines_.size()) break;
      if (trims[i + 1] > 0) {
        append_corner(*path, i + 1, trims[i + 1]);
      } else if (!straight_at(i + 1)) {
        out_.sections.push_back(std::move(path));
        path = std::make_unique<PolynomialPath>(points_[i + 1].q);
      }
    }
    out_.sections.push_back(std::move(path));
    return std::move(out_);
  }

  PathSections spline() {
    auto path = std::make_unique<PolynomialPath>(points_.front().q);
    if (points_.size() > 1) append_spline(*path);
    out_.sections.push_back(std::move(path));
    return std::move(out_);
  }

 private:
  double weight(std::size_t j) const { return options_.weights.empty() ? 1.0 : options_.weights[j]; }
  double norm_of(std::span<const double> q) const {
    double sum = 0;
    for (std::size_t j = 0; j < q.size(); ++j) sum += weight(j) * weight(j) * q[j] * q[j];
    return std::sqrt(sum);
  }
  std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) const {
    std::vector<double> out(joints_);
    for (std::size_t j = 0; j < joints_; ++j) out[j] = b[j] - a[j];
    return out;
  }

  void add(const JointWaypoint& waypoint, std::size_t index, bool last) {
    const std::string name = name_of(waypoint, index);
    const double way = points_.empty() ? 1 : norm_of(difference(points_.back().q, waypoint.q));
    // A path of one very small move is still a move.
    if (way <= kSameWaypoint && !(last && way > 0 && points_.size() == 1)) {
      warn("waypoint-repeated", index,
           fmt::format("{} is where {} is; they count once", name, points_.back().name), {});
      points_.back().radius = std::min(points_.back().radius, waypoint.radius);
      if (last && points_.size() > 1) points_.back().q = waypoint.q;
      return;
    }
    points_.push_back({waypoint.q, waypoint.radius, name, index});
  }

  Line line(std::size_t i) const {
    Line out{difference(points_[i].q, points_[i + 1].q), 0};
    out.length = norm_of(out.direction);
    for (double& value : out.direction) value /= out.length;
    return out;
  }

  bool straight_at(std::size_t i) const {
    return norm_of(difference(lines_[i - 1].direction, lines_[i].direction)) <= kStraight;
  }

  /// A corner where the path reverses must be a stop: its curve would stop in the middle.
  bool turns_back(std::size_t i) const {
    std::vector<double> sum(joints_);
    for (std::size_t j = 0; j < joints_; ++j) sum[j] = lines_[i - 1].direction[j] + lines_[i].direction[j];
    return norm_of(sum) <= kTurnsBack;
  }
  void warn_of_turning_back(std::size_t i, double radius) {
    warn("blend-shrunk", points_[i].waypoint,
         fmt::format("the radius {:.6g} at {} is shrunk to 0: the way turns straight back there", radius,
                     points_[i].name),
         "move to the point exactly, or a little aside of the way back");
  }

  std::vector<double> on_line(std::size_t i, double s) const {
    std::vector<double> out(points_[i].q);
    for (std::size_t j = 0; j < joints_; ++j) out[j] += s * lines_[i].direction[j];
    return out;
  }

  /// The corner's curve at point `i`, of joint `j`.
  std::array<double, 6> corner(std::size_t i, std::size_t j, double d) const {
    const double u = lines_[i - 1].direction[j], v = lines_[i].direction[j], at = points_[i].q[j];
    return hermite5<double>({at - d * u, u}, {at + d * v, v}, 2 * d);
  }

  /// The largest distance at the TCP between point `i` and its corner.
  double tcp_radius(std::size_t i, double d) const {
    double most = 0;
    std::vector<double> q(joints_);
    for (int k = 0; k <= kSamples; ++k) {
      for (std::size_t j = 0; j < joints_; ++j)
        q[j] = polynomial_at(corner(i, j, d).data(), 6, static_cast<double>(k) / kSamples, 2 * d).value;
      most = std::max(most, options_.tcp_distance(q, points_[i].q));
    }
    // Adds a margin, because the distance may be slightly larger between the samples.
    return most * (1 + 1.0 / (kSamples * kSamples));
  }

  /// The distance before and after point `i` at which the path leaves its lines.
  double trim(std::size_t i) {
    const double radius = points_[i].radius;
    if (radius <= 0 || straight_at(i)) return 0;
    if (turns_back(i)) {
      warn_of_turning_back(i, radius);
      return 0;
    }
    const double before = lines_[i - 1].length, after = lines_[i].length, half = std::min(before, after) / 2;
    if (!options_.tcp_distance) {
      if (radius > half * (1 + 1e-9)) warn_of_shrinking(i, radius, half, "");
      return std::min(radius, half);
    }
    if (const double reached = tcp_radius(i, half); reached <= radius) {
      if (reached < radius * (1 - 2e-2)) warn_of_shrinking(i, radius, reached, " m");
      return half;
    }
    double low = 0, high = half;
    for (int k = 0; k < kBisections; ++k) {
      const double middle = (low + high) / 2;
      (tcp_radius(i, middle) <= radius ? low : high) = middle;
    }
    return low;
  }

  void warn(const char* code, std::size_t waypoint, std::string what, std::string advice) {
    out_.warnings.push_back({{code, {}, std::move(what), std::move(advice), Severity::warning}, waypoint});
  }
  void warn_of_shrinking(std::size_t i, double radius, double shrunk, const char* unit) {
    const bool before = lines_[i - 1].length <= lines_[i].length;
    warn("blend-shrunk", points_[i].waypoint,
         fmt::format(
             "the radius {:.6g}{} at {} is shrunk to {:.6g}{}: half of the way {} {}, which is {:.6g} long",
             radius, unit, points_[i].name, shrunk, unit, before ? "from" : "to",
             points_[before ? i - 1 : i + 1].name, lines_[before ? i - 1 : i].length),
         "give a smaller radius, or move the waypoints apart");
  }

  void append_line(PolynomialPath& path, std::size_t i, double from, double to) const {
    const double length = lines_[i].length - from - to;
    if (length <= kLineRounding * lines_[i].length) return;
    std::vector<double> c(joints_ * kPowers, 0.0);
    const std::vector<double> begin = on_line(i, from);
    for (std::size_t j = 0; j < joints_; ++j) {
      c[j * kPowers] = begin[j];
      c[j * kPowers + 1] = length * lines_[i].direction[j];
    }
    path.append(length, c, straight_at_begin(i) ? PieceJoin::third_continues : PieceJoin::third_jumps);
  }
  bool straight_at_begin(std::size_t i) const { return i > 0 && straight_at(i); }

  void append_corner(PolynomialPath& path, std::size_t i, double d) const {
    std::vector<double> c(joints_ * kPowers, 0.0);
    for (std::size_t j = 0; j < joints_; ++j) {
      const auto one = corner(i, j, d);
      std::copy(one.begin(), one.end(), c.begin() + static_cast<std::ptrdiff_t>(j * kPowers));
    }
    path.append(2 * d, c);
  }

  void append_spline(PolynomialPath& path) const {
    std::vector<double> flat;
    for (const Point& point : points_) flat.insert(flat.end(), point.q.begin(), point.q.end());
    const CubicSpline spline = cubic_spline(flat, joints_, options_.weights);
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
      const double gap = spline.knots[i + 1] - spline.knots[i];
      std::vector<double> c(joints_ * kPowers, 0.0);
      for (std::size_t j = 0; j < joints_; ++j) {
        const std::size_t a = i * joints_ + j, b = a + joints_;
        c[j * kPowers] = spline.value[a];
        c[j * kPowers + 1] = gap * spline.first[a];
        c[j * kPowers + 2] = gap * gap / 2 * spline.second[a];
        c[j * kPowers + 3] = gap * gap / 6 * (spline.second[b] - spline.second[a]);
      }
      path.append(gap, c);
    }
  }

  const JointPathOptions& options_;
  std::size_t joints_;
  std::vector<Point> points_;
  std::vector<Line> lines_;
  PathSections out_;
};

}  // namespace

PathSections joint_lines(std::span<const JointWaypoint> waypoints, const JointPathOptions& options) {
  check(waypoints, options);
  return Lines(waypoints, options).rounded();
}

PathSections joint_spline(std::span<const JointWaypoint> waypoints, const JointPathOptions& options) {
  check(waypoints, options);
  return Lines(waypoints, options).spline();
}

}  // namespace polyarm::paths
