// Corners of Cartesian paths: how far each may be rounded, and the resulting paths.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/paths/cartesian_path.hpp"

namespace polyarm::paths {
namespace {

constexpr double kRounding = 1e-13;    // relative: a segment that is shorter than this between its two
                                       // corners is omitted
constexpr double kEqual = 1e-9;        // relative difference at which derivatives count as equal
constexpr double kBack = 1e-3;         // length of the sum of unit derivatives at which they count as
                                       // opposite
constexpr double kWidestCorner = 2.5;  // rad, from a corner's middle to its ends
constexpr double kLess = 0.8;          // factor for the next attempt after a corner that is too wide
constexpr int kTries = 60;

bool equal(const Vec3& a, const Vec3& b) {
  return norm(a - b) <= kEqual * (1 + norm(a) + norm(b));
}
bool keeps_going(const PoseDerivatives& a, const PoseDerivatives& b) {
  return equal(a.linear[0], b.linear[0]) && equal(a.linear[1], b.linear[1]) &&
         equal(a.angular[0], b.angular[0]) && equal(a.angular[1], b.angular[1]);
}

}  // namespace

class CartesianPathBuilder::Assembly {
 public:
  explicit Assembly(const CartesianPathBuilder& from) : from_(from), segments_(from.segments_) {}

  CartesianSections make() {
    out_.warnings = from_.repeated_;
    out_.sections.emplace_back(from_.start_);
    double trimmed = 0;
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      const bool last = i + 1 == segments_.size();
      const double d = last ? 0 : trim(i);
      append(segments_[i], trimmed, segments_[i].length - d);
      trimmed = d;
      if (d > 0)
        out_.sections.back().append(corner(i, d), 0, 2 * d);
      else if (!last && !passes(i))
        out_.sections.emplace_back(segments_[i].end);
    }
    return std::move(out_);
  }

 private:
  bool passes(std::size_t i) const {
    return keeps_going(segments_[i].at(segments_[i].length), segments_[i + 1].at(0));
  }
  PosePiece corner(std::size_t i, double d) const {
    return joining_piece(segments_[i].at(segments_[i].length - d), segments_[i + 1].at(d),
                         segments_[i].end.rotation, 2 * d);
  }

  /// True if the path reverses without a rotation of the TCP: the corner's curve would stop in its middle.
  bool turns_back(std::size_t i) const {
    const PoseDerivatives a = segments_[i].at(segments_[i].length), b = segments_[i + 1].at(0);
    return norm(a.linear[0] + b.linear[0]) <= kBack && norm(a.angular[0] + b.angular[0]) <= kBack;
  }

  /// The distance before and after the end of segment `i` at which the path leaves it.
  double trim(std::size_t i) {
    const Segment &before = segments_[i], &after = segments_[i + 1];
    const double radius = before.corner.radius;
    if (radius <= 0 || passes(i)) return 0;
    if (turns_back(i)) {
      warn(i, 0, "the way turns straight back there");
      return 0;
    }
    const double half = std::min(before.length, after.length) / 2;
    const double curve = std::min(before.curve_radius, after.curve_radius);
    double d = std::min({radius, half, curve});
    bool wide = false;
    for (int k = 0; k < kTries && !stays_within(i, d, radius); ++k) {
      d *= kLess;
      wide = true;
    }
    if (d < radius * (1 - 1e-9)) {
      const char* side = before.length <= after.length ? "before" : "after";
      warn(i, d,
           wide            ? std::string("the curve would leave the ball of that radius, or turn too far")
           : half <= curve ? fmt::format("half of the segment {} it, which is {:.6g} m long", side,
                                         std::min(before.length, after.length))
                           : fmt::format("the radius of the arc beside it"));
    }
    return d;
  }

  bool stays_within(std::size_t i, double d, double radius) const {
    const PosePiece piece = corner(i, d);
    for (const Vec3& point : hull(piece.position))
      if (norm(point - segments_[i].end.position) > radius * (1 + 1e-9)) return false;
    for (const Vec3& vector : hull(piece.vector))
      if (norm(vector) > kWidestCorner) return false;
    return true;
  }

  void warn(std::size_t i, double d, const std::string& why) {
    const Corner& at = segments_[i].corner;
    out_.warnings.push_back(
        {{"blend-shrunk",
          {},
          fmt::format("the radius {:.6g} m at {} is shrunk to {:.6g} m: {}", at.radius, at.name, d, why),
          "give a smaller radius, or move the waypoints apart",
          Severity::warning},
         segments_[i].waypoint});
  }

  /// The part of a segment from `begin` to `end`.
  void append(const Segment& segment, double begin, double end) {
    for (std::size_t i = 0; i < segment.pieces.size(); ++i) {
      const double from = std::max(begin - segment.begins[i], 0.0);
      const double to = std::min(end - segment.begins[i], segment.pieces[i].length);
      if (to - from > kRounding * segment.length)
        out_.sections.back().append(segment.pieces[i], from, to - from);
    }
  }

  const CartesianPathBuilder& from_;
  const std::vector<Segment>& segments_;
  CartesianSections out_;
};

CartesianSections CartesianPathBuilder::build() const {
  problems_.throw_if_errors();
  return Assembly(*this).make();
}

}  // namespace polyarm::paths
