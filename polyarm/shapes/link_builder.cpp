#include "polyarm/shapes/link_builder.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace polyarm::shapes {

namespace {

constexpr double kSeam = 0.025;    // half the gap between two housings, relative to the radius
constexpr std::size_t kSteps = 6;  // of a loft

double extent(const End& end, const Vec3& across) {
  const double c = std::min(1.0, std::abs(dot(across, end.axis)));
  return c * (end.to - end.from) / 2 + std::sqrt(1 - c * c) * end.radius;
}

double ease(double s) {
  return s * s * (3 - 2 * s);
}

/// One end of the skin that connects two housings.
struct Mouth {
  Vec3 at;
  Vec3 way;           ///< unit, in the loft's direction at this end
  double across = 0;  ///< half the size along the loft's x
  double other = 0;   ///< half the size along its y
  double corner = 1;
};

class LinkBuilder {
 public:
  LinkBuilder(const RigidBody& body, const Style& style, const Rank& rank, double travel)
      : body_(body),
        style_(style),
        rank_(rank),
        travel_(travel),
        paint_(paint_of(style, rank)),
        housing_(style.housing ? *style.housing : paint_) {}

  meshes::Mesh build() {
    if (!body_.has_in) {
      base();
    } else if (body_.in.slides) {
      slider();
    } else {
      housing(body_.in, true);
    }
    for (const End& end : body_.out) {
      const bool flange = body_.has_flange && &end == &body_.out.back();
      if (flange && has_jaws(end)) {
        jaws(end);
        continue;
      }
      if (flange)
        plate(end);
      else if (end.slides)
        sleeve(end);
      else
        housing(end, false);
      if (body_.has_in && !body_.in.slides) connect(body_.in, end);
    }
    if (body_.out.empty() && body_.has_in) finger();
    return solid_.take();
  }

 private:
  Pose frame(const End& end) const { return frame_along(end.origin, end.axis); }

  /// Adds the housing of a joint: a drum, or cheeks around the other body's drum.
  void housing(const End& end, bool in) {
    const double r = end.radius;
    if (end.fit == Fit::outer) {
      const double gap = kSeam * r;
      cheek(end, end.from, end.inner_from - gap, -1);
      cheek(end, end.inner_to + gap, end.to, 1);
      return;
    }
    if (end.fit == Fit::inner) {
      const double tight = 0.02 * r, into = 0.45 * (end.to - end.from);
      if (style_.build == Build::servo)
        servo(end, end.from + tight, end.to - tight);
      else
        solid_.drum(frame(end), end.from + tight, end.to - tight, r, style_.edge * r * 0.6,
                    style_.edge * r * 0.6, housing_);
      // The axle reaches into the cheeks, so that no gap is visible.
      const double axle = 0.72 * std::min(r, end.other_radius),
                   cheek = std::min(into, 0.16 * (end.to - end.from));
      solid_.drum(frame(end), end.from - cheek * 0.5, end.to + cheek * 0.5, axle, 0, 0, style_.joint);
      return;
    }
    stacked(end, in);
  }

  void stacked(const End& end, bool in) {
    const double r = end.radius, gap = kSeam * std::min(r, end.other_radius);
    const bool ends_at_meet = std::abs(end.to - end.meet) < std::abs(end.from - end.meet);
    const double side = ends_at_meet ? -1 : 1;  // direction along the axis from the meeting plane into this
                                                // body
    const double far = ends_at_meet ? end.from : end.to, length = end.to - end.from;
    const bool covered = !end.along && style_.build != Build::servo;
    const double dome = covered ? std::min(style_.dome * r, 0.3 * length) : 0;
    const double begin = end.meet + side * gap, stop = far - side * dome;
    const double edge = end.along ? 0.04 * r : style_.edge * r;
    if (style_.build == Build::servo && !in)
      servo(end, begin, stop);
    else
      solid_.drum(frame(end), begin, stop, r, 0.05 * r, edge, housing_);
    if (covered) cover(end, stop, side, dome);
    if (in) return;
    // The dark ring between the two housings. It belongs to this body and reaches into the other one.
    const double slim = 0.955 * std::min(r, end.other_radius);
    solid_.drum(frame(end), end.meet - 2.5 * gap, end.meet + 2.5 * gap, slim, 0, 0, style_.joint);
  }

  /// The cover on the free face of a housing at `at`; `side` points outwards.
  void cover(const End& end, double at, double side, double height) {
    const double r = style_.cap_size * end.radius;
    if (height < 1e-4) return;
    const double sunk = at - side * 0.4 * height;
    // The top cover of a cast turret has the colour of the casting.
    const bool turret = style_.build == Build::cast && rank_.depth == 1 && &end == &body_.in;
    solid_.drum(frame(end), sunk, at + side * height, r, 0, std::min(0.75 * height, 0.3 * r),
                turret ? paint_ : style_.cap);
  }

  void cheek(const End& end, double from, double to, double side) {
    if (to - from < 1e-4) return;
    const double r = end.radius, dome = std::min(0.3 * style_.dome * r, 0.3 * (to - from));
    const double edge = std::min(style_.edge * r, 0.45 * (to - from));
    const double outer = side > 0 ? to - dome : from + dome;
    solid_.drum(frame(end), side > 0 ? from : to, outer, r, 0.02 * r, edge, paint_);
    cover(end, outer, side, dome);
  }

  void servo(const End& end, double begin, double stop) {
    const double r = end.radius;
    const Vec3 to_in = (body_.has_in ? body_.in.origin : Vec3{0, 0, -1}) - end.origin;
    const Pose at = frame_along(end.at((begin + stop) / 2), end.axis, to_in);
    solid_.box(at, {2.5 * r, 2 * r, std::abs(stop - begin)}, 0.12 * r, style_.cap);
  }

  // --- the skin that connects two housings

  Mouth mouth(const End& end, const Vec3& way, const Vec3& x, bool begins) const {
    Mouth out;
    out.way = way;
    const double r = end.radius;
    if (end.along) {
      const bool ends_at_meet = std::abs(end.to - end.meet) < std::abs(end.from - end.meet);
      const double far = ends_at_meet ? end.from : end.to;
      const double inward = ends_at_meet ? 1.0 : -1.0;  // towards the joint
      out.at = end.at(far + inward * std::min(0.3 * (end.to - end.from), 0.1 * r));
      const double sign = ((far - end.meet) * (begins ? 1 : -1)) >= 0 ? 1 : -1;
      out.way = sign * end.axis;
      out.across = out.other = 0.975 * r;
      return out;
    }
    out.at = end.at(end.fit == Fit::outer ? (end.inner_from + end.inner_to) / 2 : end.middle());
    const Vec3 y = normalized(cross(way, x));
    out.across = style_.tube * extent(end, x);
    out.other = style_.tube * extent(end, y);
    out.corner = style_.corner;
    if (style_.build == Build::cobot || style_.build == Build::soft) {
      // almost round: a tube
      const double round = std::min(out.across, out.other);
      out.across = std::min(out.across, 1.15 * round);
      out.other = std::min(out.other, 1.15 * round);
    }
    if (end.fit == Fit::outer) {
      out.across = 0.97 * extent(end, x);
      out.at = out.at + (begins ? 1 : -1) * clearance(end) * way;
    }
    return out;
  }

  static double clearance(const End& end) { return 1.12 * std::max(end.other_radius, 0.8 * end.radius); }

  Vec3 place_of(const End& end) const {
    return end.at(end.fit == Fit::outer ? (end.inner_from + end.inner_to) / 2 : end.middle());
  }

  void connect(const End& in, const End& out) {
    const Vec3 from = place_of(in), to = place_of(out);
    const double length = norm(to - from);
    const double small = 0.3 * std::min(in.radius, out.radius);
    if (length < small) return;
    const Vec3 way = (1 / length) * (to - from);
    const bool flange = body_.has_flange && &out == &body_.out.back();
    const double room =
        (in.fit == Fit::outer ? clearance(in) : 0) + (out.fit == Fit::outer ? clearance(out) : 0);
    const Vec3 x = across_of(in, out, way);
    if (room > 0.9 * length) return bridge(in, out, way, length);
    Mouth a = mouth(in, way, x, true), b = mouth(out, way, x, false);
    if (flange) shrink_to_flange(b, out, in);
    if (dot(b.at - a.at, way) < 0.05 * length && norm(b.at - a.at) < small) return;
    skin(a, b, x);
    if (in.fit == Fit::outer) cheek_arms(in, way, length, a);
    if (out.fit == Fit::outer) cheek_arms(out, -way, length, b);
  }

  /// The loft's x direction: the joint axis of an end that the body runs across.
  static Vec3 across_of(const End& in, const End& out, const Vec3& way) {
    for (const End* end : {&in, &out})
      if (!end->along && std::abs(dot(end->axis, way)) < 0.9) return end->axis;
    for (const Vec3& x : {Vec3{0, 1, 0}, Vec3{1, 0, 0}})
      if (std::abs(dot(x, way)) < 0.9) return x;
    return {0, 0, 1};
  }

  void shrink_to_flange(Mouth& mouth, const End& out, const End& in) const {
    mouth.at = out.at(out.from + 0.1 * out.radius);
    mouth.across = mouth.other = std::min(1.04 * out.radius, in.radius);
  }

  void skin(const Mouth& a, const Mouth& b, const Vec3& x) {
    const double chord = norm(b.at - a.at);
    if (chord < 1e-4) return;
    // The length of the curve's end tangents. Short at a sharp bend, so that the skin stays within the
    // housings.
    const double length = chord * std::max(0.35, 0.5 + 0.5 * dot(a.way, b.way));
    std::vector<Section> sections;
    for (std::size_t k = 0; k <= kSteps; ++k) {
      const double s = static_cast<double>(k) / kSteps, t = ease(s);
      const double s2 = s * s, s3 = s2 * s;
      const Vec3 at = (2 * s3 - 3 * s2 + 1) * a.at + (s3 - 2 * s2 + s) * length * a.way +
                      (3 * s2 - 2 * s3) * b.at + (s3 - s2) * length * b.way;
      Vec3 tangent = (6 * s2 - 6 * s) * a.at + (3 * s2 - 4 * s + 1) * length * a.way +
                     (6 * s - 6 * s2) * b.at + (3 * s2 - 2 * s) * length * b.way;
      if (norm(tangent) < 0.05 * chord) tangent = b.at - a.at;
      const Vec3 side = std::abs(dot(normalized(tangent), x)) < 0.95 ? x : cross(tangent, {0.3, 0.5, 0.8});
      const double waist = 1 - waist_depth() * 4 * s * (1 - s);
      Section section{frame_along(at, tangent, side), waist * (a.across + t * (b.across - a.across)),
                      waist * (a.other + t * (b.other - a.other)), 0};
      section.corner = (a.corner + t * (b.corner - a.corner)) * std::min(section.half_x, section.half_y);
      sections.push_back(section);
    }
    solid_.loft(sections, paint_);
  }

  double waist_depth() const {
    return style_.build == Build::cast ? 0.07 : style_.build == Build::soft ? 0.04 : 0;
  }

  /// The two arms of a fork, from the cheeks at `end` to the web that begins at `web`.
  void cheek_arms(const End& end, const Vec3& way, double length, const Mouth& web) {
    const double reach = std::min(clearance(end) + 0.45 * end.radius, 0.75 * length);
    for (const auto& [from, to] : {std::pair{end.from, end.inner_from}, std::pair{end.inner_to, end.to}}) {
      const double half = 0.5 * (to - from) * 0.94;
      if (half < 1e-4) continue;
      arm(end.at((from + to) / 2), way, end.axis, reach, half, 0.97 * end.radius,
          std::min(0.82 * web.other, 0.97 * end.radius));
    }
  }

  /// For bodies without room for a web between the cheeks: extends the arms to the other end.
  void bridge(const End& in, const End& out, const Vec3& way, double length) {
    for (const End* end : {&in, &out}) {
      if (end->fit != Fit::outer) continue;
      const End& other = end == &in ? out : in;
      for (const auto& [from, to] :
           {std::pair{end->from, end->inner_from}, std::pair{end->inner_to, end->to}}) {
        const double half = 0.5 * (to - from) * 0.94;
        if (half < 1e-4) continue;
        const Vec3 y = normalized(cross(way, end->axis));
        arm(end->at((from + to) / 2), (end == &in ? 1 : -1) * way, end->axis, length, half,
            0.97 * end->radius, std::min(0.97 * end->radius, extent(other, y)));
      }
    }
  }

  void arm(const Vec3& at, const Vec3& way, const Vec3& axis, double length, double thick, double begin,
           double end) {
    std::vector<Section> sections;
    for (std::size_t k = 0; k <= kSteps; ++k) {
      const double s = static_cast<double>(k) / kSteps, wide = begin + ease(s) * (end - begin);
      sections.push_back(
          {frame_along(at + s * length * way, way, axis), thick, wide, 0.8 * std::min(thick, wide)});
    }
    solid_.loft(sections, paint_);
  }

  // --- ends of the arm

  void plate(const End& end) {
    const double r = end.radius;
    solid_.drum(frame(end), end.from, end.to - 0.06 * r, r, 0.05 * r, 0.04 * r, style_.flange);
    solid_.drum(frame(end), end.to - 0.1 * r, end.to, 0.82 * r, 0, 0.03 * r, style_.flange);
    solid_.drum(frame(end), end.to - 0.05 * r, end.to + 0.004 * r, 0.4 * r, 0, 0, style_.joint);
  }

  /// The last body of an arm of servos is its gripper, if it is long and has no joints of its own.
  bool has_jaws(const End& end) const {
    return style_.build == Build::servo && body_.has_in && body_.measured && body_.out.size() == 1 &&
           norm(end.origin - body_.in.origin) > 1.8 * body_.in.radius;
  }

  /// A servo in a frame, a fixed jaw and a moving one, closed at the tool's point.
  void jaws(const End& end) {
    const Vec3 from = body_.in.origin, to = end.origin - from;
    const double length = norm(to), r = std::min(body_.in.radius, 0.32 * length);
    const Vec3 way = (1 / length) * to;
    const Vec3 x = std::abs(dot(way, Vec3{1, 0, 0})) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Pose at = frame_along(from, way, x);
    const double palm = 0.42 * length;
    solid_.box(at * Pose{{0, 0, palm / 2}, {}}, {1.7 * r, 1.2 * r, palm}, 0.1 * r, paint_);
    solid_.box(at * Pose{{0.25 * r, 0, 0.72 * palm}, {}}, {1.6 * r, 1.34 * r, 0.5 * palm}, 0.08 * r,
               style_.cap);
    for (const double side : {-1.0, 1.0}) {
      std::vector<Section> sections;
      for (std::size_t k = 0; k <= kSteps; ++k) {
        const double s = static_cast<double>(k) / kSteps, place = 0.75 * palm + s * (length - 0.75 * palm);
        const double away =
            side * r * ((side > 0 ? 0.75 : 0.5) * std::cos(0.5 * std::numbers::pi * s) + 0.07);
        const double thick = 0.06 * r + 0.09 * r * (1 - s);
        sections.push_back({at * Pose{{away, 0, place}, {}}, thick, 0.55 * r * (1 - 0.45 * s), 0.8 * thick});
      }
      solid_.loft(sections, side > 0 ? style_.body : paint_);
    }
  }

  /// A body without outgoing joints: a finger or a jaw.
  void finger() {
    const Vec3 size = body_.high - body_.low;
    const double edge = 0.25 * std::min({size.x, size.y, size.z});
    const Vec3 least{1e-3, 1e-3, 1e-3};
    solid_.box({0.5 * (body_.low + body_.high), {}},
               {std::max(size.x, least.x), std::max(size.y, least.y), std::max(size.z, least.z)}, edge,
               paint_);
  }

  /// A rod that is long enough for the joint's travel.
  void slider() {
    const End& in = body_.in;
    double tip = 0;
    for (const End& end : body_.out) {
      const double at = dot(end.origin - in.origin, in.axis);
      if (std::abs(at) > std::abs(tip)) tip = at;
    }
    if (body_.out.empty()) return;  // no rod: it is a finger
    const double side = tip > 0 ? -1 : 1;
    const double back = side * (std::min(travel_, 3.0) + 1.6 * in.radius) + (std::abs(tip) < 1e-6 ? 0 : tip);
    const double slim = std::min(in.radius, 0.6 * in.other_radius);
    solid_.drum(frame(in), tip, back, slim, 0.05 * slim, 0.05 * slim, style_.flange);
  }

  void sleeve(const End& end) {
    const double r = std::max(end.radius, 1.25 * end.other_radius),
                 half = std::max((end.to - end.from) / 2, 0.8 * r);
    solid_.drum(frame(end), end.middle() - half, end.middle() + half, r, 0.1 * r, style_.edge * r, paint_);
  }

  // --- the base

  /// Plinth and pedestal, and the box for the connectors if the outline is longer on one side.
  void base() {
    if (body_.out.empty()) return finger();
    const End& end = body_.out.front();
    const bool up = std::abs(end.to - end.meet) < std::abs(end.from - end.meet);
    const Vec3 axis = up ? end.axis : -end.axis;
    const Vec3 collar = end.at(up ? end.from : end.to);
    const Foot foot = foot_of(end, axis);
    const double height = dot(collar - foot.at, axis);
    if (height < 0.02 * end.radius) return;
    const bool round = style_.build == Build::cobot || style_.build == Build::soft;
    const double r = end.radius;
    const double plate = std::min(0.14 * height, 0.25 * r);
    const double wide = std::max(foot.half, r);
    pedestal(frame_along(foot.at, axis, foot.x), height, plate, wide, r, round);
    if (foot.rear > 1.2 * wide && height > 0.5 * wide) connectors(foot, axis, height, wide);
  }

  struct Foot {
    Vec3 at;          ///< on the joint's axis, at the bottom of the body
    Vec3 x;           ///< towards the longer side
    double half = 0;  ///< how far the outline reaches on every side
    double rear = 0;  ///< how far the outline reaches on the longer side
  };

  Foot foot_of(const End& end, const Vec3& axis) const {
    double lowest = 1e9;
    for (int i = 0; i < 8; ++i) {
      const Vec3 corner{i & 1 ? body_.low.x : body_.high.x, i & 2 ? body_.low.y : body_.high.y,
                        i & 4 ? body_.low.z : body_.high.z};
      lowest = std::min(lowest, dot(corner - end.origin, axis));
    }
    // Without a measured outline the base begins in the frame of its link at the latest.
    if (!body_.measured) lowest = std::min(lowest, dot(-end.origin, axis));
    Foot out{end.origin + lowest * axis, {1, 0, 0}, 1e9, 0};
    for (const Vec3& side : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      if (std::abs(dot(side, axis)) > 0.6) continue;
      for (const double sign : {-1.0, 1.0}) {
        const Vec3 edge = sign > 0 ? body_.high : body_.low;
        const double reaches = sign * dot(edge - end.origin, side);
        out.half = std::min(out.half, std::max(reaches, end.radius));
        if (reaches > out.rear) {
          out.rear = reaches;
          out.x = sign * side;
        }
      }
    }
    out.half = std::min(out.half, 1.7 * end.radius);
    out.rear = std::min(out.rear, 2.5 * end.radius);
    return out;
  }

  void pedestal(const Pose& foot, double height, double plate, double wide, double r, bool round) {
    if (round) {
      const std::vector<Ring> rings{{0, 0},
                                    {0.97 * wide, 0},
                                    {wide, 0.03 * wide},
                                    {wide, plate},
                                    {0.97 * wide, plate + 0.02 * wide},
                                    {0.9 * r + 0.05 * wide, plate + 0.06 * wide},
                                    {0.94 * r, 0.45 * height},
                                    {0.97 * r, height},
                                    {0, height}};
      solid_.turn(foot, rings, paint_);
      return;
    }
    solid_.box(foot * Pose{{0, 0, plate / 2}, {}}, {2 * wide, 2 * wide, plate}, 0.12 * wide, paint_);
    std::vector<Section> sections;
    for (std::size_t k = 0; k <= kSteps; ++k) {
      const double s = static_cast<double>(k) / kSteps,
                   half = 0.92 * wide + ease(s) * (0.97 * r - 0.92 * wide);
      sections.push_back({foot * Pose{{0, 0, 0.5 * plate + s * (height - 0.5 * plate)}, {}}, half, half,
                          (0.3 + 0.7 * ease(s)) * half});
    }
    solid_.loft(sections, paint_);
  }

  void connectors(const Foot& foot, const Vec3& axis, double height, double wide) {
    const double tall = 0.62 * height, length = foot.rear - 0.3 * wide;
    const Vec3 center = foot.at + (0.3 * wide + length / 2) * foot.x + (tall / 2) * axis;
    solid_.box(frame_along(center, axis, foot.x), {length, 1.35 * wide, tall}, 0.1 * std::min(wide, tall),
               paint_);
  }

  const RigidBody& body_;
  const Style& style_;
  const Rank& rank_;
  const double travel_;
  const Paint& paint_;
  const Paint& housing_;  ///< of the drums around the joints
  Solid solid_;
};

}  // namespace

const Paint& paint_of(const Style& style, const Rank& rank) {
  if (rank.depth == 0) return style.base;
  const int left = rank.most - rank.depth;
  if (rank.most >= 5 && left <= 1) return style.wrist;
  if (rank.most < 5 && left == 0) return style.wrist;
  return rank.depth > rank.most / 2 - 1 ? style.fore : style.body;
}

meshes::Mesh build_link(const RigidBody& body, const Style& style, const Rank& rank, double travel) {
  return LinkBuilder(body, style, rank, travel).build();
}

}  // namespace polyarm::shapes
