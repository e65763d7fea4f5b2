#include "apps/picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "polyarm/catalogue/kinematic_table.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::apps {

namespace {

using description::RobotModel;
using description::Shape;
using description::ShapeKind;

constexpr double kWidth = 260;  // of the picture, px

/// Where the eye is: in front of the robot (x), to its right, above. Orthographic.
struct View {
  Vec3 to_eye, right, up;
  double scale = 1, left = 0, top = 0;

  View() {
    const double azimuth = -0.87, elevation = 0.38;
    to_eye = {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
              std::sin(elevation)};
    right = {-std::sin(azimuth), std::cos(azimuth), 0};
    up = cross(to_eye, right);
  }
  double x(const Vec3& p) const { return dot(p, right) * scale - left; }
  double y(const Vec3& p) const { return -dot(p, up) * scale - top; }
};

struct Color {
  double r, g, b;
};
constexpr Color kBase{0.46, 0.49, 0.53}, kJoint{0.20, 0.42, 0.66}, kTool{0.30, 0.32, 0.35};
constexpr std::array<Color, 2> kLinks{{{0.97, 0.97, 0.96}, {0.84, 0.87, 0.90}}};

/// A round body from `a` to `b`: with ball ends (a capsule), or flat ones (a cylinder).
struct Body {
  Vec3 a, b;
  double radius = 0;
  bool flat = false;
  Color color{};
};

/// A part of a body that is drawn at once.
struct Piece {
  Vec3 a, b;
  std::size_t body = 0;
  double depth = 0;  ///< towards the eye
};

double brightness(const Vec3& normal) {
  static const Vec3 light = normalized(Vec3{0.35, -0.35, 0.9});
  return 0.52 + 0.50 * std::max(0.0, dot(normal, light)) - 0.10 * std::max(0.0, -dot(normal, light));
}

std::string hex(const Color& color, double light) {
  const auto byte = [&](double c) {
    return static_cast<int>(std::lround(255 * std::clamp(c * light, 0.0, 1.0)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(color.r), byte(color.g), byte(color.b));
}

/// The capsule nearest to a shape, in its link; nothing for a mesh.
std::optional<Body> body_of(const Shape& shape) {
  Body out;
  double half = shape.length / 2;
  Vec3 axis{0, 0, 1};
  out.radius = shape.radius;
  if (shape.kind == ShapeKind::mesh) return std::nullopt;
  if (shape.kind == ShapeKind::box) {
    const Vec3 s = shape.size;
    axis = s.x >= s.y && s.x >= s.z ? Vec3{1, 0, 0} : s.y >= s.z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    const double longest = std::max({s.x, s.y, s.z}), shortest = std::min({s.x, s.y, s.z});
    out.radius = (s.x + s.y + s.z - longest - shortest) / 2;
    half = std::max(0.0, longest / 2 - out.radius);
  }
  if (shape.kind == ShapeKind::sphere) half = 0;
  if (shape.kind == ShapeKind::cylinder) half = std::max(0.0, half - out.radius / 2);
  out.a = shape.pose * (-half * axis);
  out.b = shape.pose * (half * axis);
  return out;
}

Vec3 nearest_on(const Body& body, const Vec3& p) {
  const Vec3 along = body.b - body.a;
  const double length2 = dot(along, along);
  const double t = length2 > 1e-12 ? std::clamp(dot(p - body.a, along) / length2, 0.0, 1.0) : 0;
  return body.a + t * along;
}

/// All bodies of a robot, in the world.
class Bodies {
 public:
  Bodies(const RobotModel& model, std::span<const double> q) : model_(model), poses_(model.links.size()) {
    kinematics::Chain(model, model.tool_link()).link_poses(q, poses_);
    first_.assign(model.links.size(), -1);
    add_links();
    for (const description::Joint& joint : model.joints)
      if (joint.moves()) add_joint(joint);
    add_flange();
    add_foot();
  }
  std::vector<Body> all;

 private:
  void add_links() {
    for (std::size_t i = 0; i < model_.links.size(); ++i) {
      const auto& link = model_.links[i];
      for (const Shape& shape : link.collisions.empty() ? link.visuals : link.collisions)
        if (auto body = body_of(shape)) {
          if (first_[i] < 0) first_[i] = static_cast<int>(all.size());
          body->a = poses_[i] * body->a;
          body->b = poses_[i] * body->b;
          body->color = static_cast<int>(i) == model_.root ? kBase : kLinks[i % 2];
          all.push_back(*body);
        }
    }
  }
  /// The first body of the link, or of the nearest one before it that has one.
  int body_before(int link) const {
    while (link >= 0) {
      if (const int found = first_[static_cast<std::size_t>(link)]; found >= 0) return found;
      const int joint = model_.links[static_cast<std::size_t>(link)].parent_joint;
      link = joint < 0 ? -1 : model_.joints[static_cast<std::size_t>(joint)].parent_link;
    }
    return -1;
  }
  /// What joins a body to a point when its shape does not come near it.
  void connect(std::size_t body, const Vec3& point) {
    const Body known = all[body];
    const Vec3 from = nearest_on(known, point);
    if (norm(point - from) < 0.9 * known.radius) return;
    all.push_back({from, point, 0.62 * known.radius, false, known.color});
  }
  /// A barrel where the two links of a turning joint meet: frames often stand elsewhere on the axis.
  void add_joint(const description::Joint& joint) {
    const Pose at = poses_[static_cast<std::size_t>(joint.child_link)];
    const int before = body_before(joint.parent_link);
    const int behind = first_[static_cast<std::size_t>(joint.child_link)];
    if (before < 0 || behind < 0 || joint.type == description::JointType::prismatic) return;
    const auto b = static_cast<std::size_t>(before), c = static_cast<std::size_t>(behind);
    const Vec3 axis = at.rotation * joint.axis;
    const Vec3 p = nearest_on(all[b], nearest_on(all[c], at.position)), q = nearest_on(all[c], p);
    const Vec3 center = at.position + dot(0.5 * (p + q) - at.position, axis) * axis;
    const double thin = std::min(all[b].radius, all[c].radius);
    const double thick = std::min(std::max(all[b].radius, all[c].radius), 1.5 * thin);
    connect(b, center);
    connect(c, center);
    all.push_back({center - 1.02 * thick * axis, center + 1.02 * thick * axis, 0.72 * thin, true, kJoint});
  }
  /// A plate on the floor, and a column where the base's shape does not reach down to it.
  void add_foot() {
    const int base = first_[static_cast<std::size_t>(model_.root)];
    const Pose& root = poses_[static_cast<std::size_t>(model_.root)];
    if (base < 0) return;
    const Body body = all[static_cast<std::size_t>(base)];
    const Vec3 lowest = body.a.z < body.b.z ? body.a : body.b;
    const double radius =
        std::min(body.radius, 0.25 * (std::abs(body.a.z) + std::abs(body.b.z)) + body.radius / 2);
    all.push_back({root.position, root.position + Vec3{0, 0, 0.25 * radius}, 1.05 * radius, true, kBase});
    if (lowest.z > body.radius)
      all.push_back({{lowest.x, lowest.y, 0}, lowest, 0.8 * body.radius, true, kBase});
  }
  void add_flange() {
    const int tool = model_.tool_link(), last = body_before(tool);
    if (last < 0) return;
    const Pose at = poses_[static_cast<std::size_t>(tool)];
    const double radius = 0.55 * all[static_cast<std::size_t>(last)].radius;
    connect(static_cast<std::size_t>(last), at.position - 0.35 * radius * (at.rotation * Vec3{0, 0, 1}));
    all.push_back(
        {at.position - 0.35 * radius * (at.rotation * Vec3{0, 0, 1}), at.position, radius, true, kTool});
  }

  const RobotModel& model_;
  std::vector<Pose> poses_;
  std::vector<int> first_;  ///< first body of each link; -1 where it has none
};

class Drawing {
 public:
  explicit Drawing(std::vector<Body> bodies) : bodies_(std::move(bodies)) {
    lay_floor();
    fit();
  }

  std::string svg() {
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 "
        "{0:.0f} "
        "{1:.0f}\">\n",
        kWidth, height_);
    out += "<defs>\n" + gradients() + "</defs>\n" + floor() + shadow();
    for (const Piece& piece : sorted()) out += draw(piece);
    return out + scale_bar() + "</svg>\n";
  }

 private:
  /// The floor: what lies under the robot and its base, and somewhat more.
  void lay_floor() {
    low_ = high_ = {};
    for (const Body& body : bodies_)
      for (const Vec3& p : {body.a, body.b}) {
        low_ = {std::min(low_.x, p.x - body.radius), std::min(low_.y, p.y - body.radius), 0};
        high_ = {std::max(high_.x, p.x + body.radius), std::max(high_.y, p.y + body.radius), 0};
      }
    const double margin = std::max(0.14 * std::max(high_.x - low_.x, high_.y - low_.y), 0.01);
    low_ = low_ - Vec3{margin, margin, 0};
    high_ = high_ + Vec3{margin, margin, 0};
  }
  void fit() {
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    const auto take = [&](const Vec3& p, double margin) {
      left = std::min(left, view_.x(p) - margin);
      right = std::max(right, view_.x(p) + margin);
      top = std::min(top, view_.y(p) - margin);
      bottom = std::max(bottom, view_.y(p) + margin);
    };
    for (const Body& body : bodies_)
      for (const Vec3& p : {body.a, body.b}) take(p, body.radius);
    for (const double x : {low_.x, high_.x})
      for (const double y : {low_.y, high_.y}) take({x, y, 0}, 0);
    const double size = std::max(right - left, 1e-3);
    view_.scale = std::min((kWidth - 16) / size, 1.25 * kWidth / std::max(bottom - top, 1e-3));
    view_.left = (left + right) / 2 * view_.scale - kWidth / 2;
    view_.top = top * view_.scale - 8;
    height_ = std::ceil((bottom - top) * view_.scale + 22);
  }

  std::string at(const Vec3& p) const { return fmt::format("{:.1f} {:.1f}", view_.x(p), view_.y(p)); }

  static double nice_length(double most) {
    double out = 1e-3;
    for (const double step : {2.0, 2.5, 2.0, 2.0, 2.5, 2.0, 2.0, 2.5, 2.0, 2.0, 2.5, 2.0})
      if (out * step <= most) out *= step;
    return out;
  }

  std::string floor() const {
    const Vec3 l = low_, h = high_;
    std::string lines = fmt::format("M{}L{}L{}L{}Z", at(l), at({h.x, l.y, 0}), at(h), at({l.x, h.y, 0}));
    const std::string edge = lines;
    const double step = nice_length(std::max(h.x - l.x, h.y - l.y) / 4);
    for (double x = std::ceil(l.x / step) * step; x < h.x; x += step)
      lines += "M" + at({x, l.y, 0}) + "L" + at({x, h.y, 0});
    for (double y = std::ceil(l.y / step) * step; y < h.y; y += step)
      lines += "M" + at({l.x, y, 0}) + "L" + at({h.x, y, 0});
    return "<path d=\"" + edge + "\" fill=\"#eef1f4\"/>\n<path d=\"" + lines +
           "\" stroke=\"#d0d7de\" stroke-width=\".6\" fill=\"none\"/>\n";
  }

  /// What lies straight above the floor darkens it.
  std::string shadow() const {
    std::string out = "<g opacity=\".13\" stroke=\"#000\" stroke-linecap=\"round\">\n";
    for (const Body& body : bodies_) {
      if (body.flat) continue;
      const Vec3 a{body.a.x, body.a.y, 0}, b{body.b.x, body.b.y, 0};
      out += fmt::format("<path d=\"M{}L{}\" stroke-width=\"{:.1f}\"/>\n", at(a), at(b),
                         1.5 * body.radius * view_.scale);
    }
    return out + "</g>\n";
  }

  /// The direction of a body, and the one across it on the screen.
  struct Across {
    Vec3 along, across, towards;
  };
  Across across(const Body& body) const {
    Across out;
    const double length = norm(body.b - body.a);
    out.along = length > 1e-6 ? (1 / length) * (body.b - body.a) : view_.right;
    if (std::abs(dot(out.along, view_.to_eye)) > 0.999) out.along = view_.right;
    out.towards = normalized(view_.to_eye - dot(view_.to_eye, out.along) * out.along);
    out.across = cross(out.along, out.towards);
    return out;
  }

  /// Light across each body, from one edge to the other.
  std::string gradients() const {
    std::string out;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      const Across a = across(body);
      const Vec3 edge = body.radius * a.across;
      out += fmt::format(
          "<linearGradient id=\"{}\" gradientUnits=\"userSpaceOnUse\" x1=\"{:.1f}\" y1=\"{:.1f}\" "
          "x2=\"{:.1f}\" y2=\"{:.1f}\">",
          i, view_.x(body.a - edge), view_.y(body.a - edge), view_.x(body.a + edge), view_.y(body.a + edge));
      for (const double t : {-1.0, -0.4, 0.4, 1.0}) {
        const Vec3 normal = t * a.across + std::sqrt(1 - t * t) * a.towards;
        const double rim = std::abs(t) == 1 ? 0.82 : 1;
        out += fmt::format("<stop offset=\"{:.2g}\" stop-color=\"{}\"/>", (t + 1) / 2,
                           hex(body.color, rim * brightness(normal)));
      }
      out += "</linearGradient>\n";
    }
    return out;
  }

  std::vector<Piece> sorted() const {
    std::vector<Piece> out;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      const double length = norm(body.b - body.a);
      const int parts =
          body.flat ? 1 : std::clamp(static_cast<int>(std::ceil(length / (2.2 * body.radius))), 1, 3);
      for (int k = 0; k < parts; ++k) {
        Piece piece{body.a + (static_cast<double>(k) / parts) * (body.b - body.a),
                    body.a + ((k + 1.0) / parts) * (body.b - body.a), i, 0};
        const double front = dot(0.5 * (piece.a + piece.b), view_.to_eye) + 0.5 * body.radius;
        piece.depth = std::round(front * 1e6) / 1e6;  // so that rounding never changes the order
        out.push_back(piece);
      }
    }
    std::stable_sort(out.begin(), out.end(),
                     [](const Piece& a, const Piece& b) { return a.depth < b.depth; });
    return out;
  }

  std::string draw(const Piece& piece) const {
    return bodies_[piece.body].flat ? cylinder(piece) : capsule(piece);
  }

  /// Two half circles and the lines between: the outline of a capsule seen without perspective.
  std::string capsule(const Piece& piece) const {
    const Body& body = bodies_[piece.body];
    const double dx = view_.x(piece.b) - view_.x(piece.a), dy = view_.y(piece.b) - view_.y(piece.a);
    const double length = std::hypot(dx, dy), r = body.radius * view_.scale;
    if (length < 0.05)
      return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"url(#{})\"/>\n",
                         view_.x(piece.a), view_.y(piece.a), r, piece.body);
    const double nx = -dy / length * r, ny = dx / length * r;
    const double ax = view_.x(piece.a), ay = view_.y(piece.a), bx = view_.x(piece.b), by = view_.y(piece.b);
    return fmt::format(
        "<path d=\"M{:.1f} {:.1f}A{r:.1f} {r:.1f} 0 0 1 {:.1f} {:.1f}L{:.1f} {:.1f}A{r:.1f} "
        "{r:.1f} 0 0 1 {:.1f} {:.1f}Z\" fill=\"url(#{})\"/>\n",
        ax + nx, ay + ny, ax - nx, ay - ny, bx - nx, by - ny, bx + nx, by + ny, piece.body, fmt::arg("r", r));
  }

  /// A cylinder: its mantle, and the end that faces the eye.
  std::string cylinder(const Piece& piece) const {
    const Body& body = bodies_[piece.body];
    Vec3 axis = normalized(piece.b - piece.a), far = piece.a, near = piece.b;
    if (dot(axis, view_.to_eye) < 0) {
      std::swap(far, near);
      axis = -axis;
    }
    const double tilt = dot(axis, view_.to_eye), r = body.radius * view_.scale;
    const double dx = dot(axis, view_.right), dy = -dot(axis, view_.up), length = std::hypot(dx, dy);
    const double nx = length > 1e-6 ? -dy / length * r : r, ny = length > 1e-6 ? dx / length * r : 0;
    const double turn = std::atan2(ny, nx) * 180 / M_PI;
    const double fx = view_.x(far), fy = view_.y(far), hx = view_.x(near), hy = view_.y(near);
    std::string out = fmt::format(
        "<path d=\"M{:.1f} {:.1f}A{r:.1f} {k:.1f} {t:.0f} 0 1 {:.1f} {:.1f}L{:.1f} {:.1f}A{r:.1f} {k:.1f} "
        "{t:.0f} 0 "
        "1 {:.1f} {:.1f}Z\" fill=\"url(#{})\"/>\n",
        fx + nx, fy + ny, fx - nx, fy - ny, hx - nx, hy - ny, hx + nx, hy + ny, piece.body, fmt::arg("r", r),
        fmt::arg("k", r * tilt), fmt::arg("t", turn));
    return out + fmt::format(
                     "<ellipse rx=\"{:.1f}\" ry=\"{:.1f}\" transform=\"translate({:.1f} {:.1f}) "
                     "rotate({:.0f})\" fill=\"{}\"/>\n",
                     r, r * tilt, hx, hy, turn, hex(body.color, 1.08 * brightness(axis)));
  }

  std::string scale_bar() const {
    const double length = nice_length(0.7 * (high_.x - low_.x)), y = low_.y, x = low_.x;
    const Vec3 a{x, y, 0}, b{x + length, y, 0};
    const double ax = view_.x(a), ay = view_.y(a) + 6, bx = view_.x(b), by = view_.y(b) + 6;
    return fmt::format(
        "<path d=\"M{0:.1f} {1:.1f}v-5M{0:.1f} {2:.1f}L{3:.1f} {4:.1f}M{3:.1f} {5:.1f}v-5\" "
        "stroke=\"#333\" fill=\"none\"/>\n"
        "<text x=\"{6:.1f}\" y=\"{7:.1f}\" font-family=\"sans-serif\" font-size=\"9\" "
        "fill=\"#333\" text-anchor=\"middle\">{8:g} m</text>\n",
        ax, ay + 2.5, ay, bx, by, by + 2.5, (ax + bx) / 2 - 6, (ay + by) / 2 + 10, length);
  }

  std::vector<Body> bodies_;
  View view_;
  double height_ = kWidth;
  Vec3 low_, high_;  ///< corners of the floor
};

bool has_shape(const RobotModel& model) {
  return std::any_of(model.links.begin(), model.links.end(), [](const description::Link& link) {
    const auto drawn = [](const Shape& shape) { return shape.kind != ShapeKind::mesh; };
    return std::any_of(link.collisions.begin(), link.collisions.end(), drawn) ||
           std::any_of(link.visuals.begin(), link.visuals.end(), drawn);
  });
}

}  // namespace

std::string picture_of(const RobotModel& given, std::span<const double> q) {
  if (has_shape(given)) return Drawing(Bodies(given, q).all).svg();
  RobotModel model = given;
  description::derive_shapes(model);
  return Drawing(Bodies(model, q).all).svg();
}

}  // namespace polyarm::apps
