#include "polyarm/shapes/skeleton.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace polyarm::shapes {

using description::Joint;
using description::JointType;
using description::Link;
using description::RobotModel;
using description::Shape;
using description::ShapeKind;

namespace {

constexpr double kThin = 0.012;      // smallest radius, relative to the reach
constexpr double kCollar = 0.55;     // length of a housing whose body runs along the axis, relative to its
                                     // radius
constexpr double kCheek = 0.13;      // smallest thickness of a cheek, relative to the joint's width
constexpr double kMostLength = 4.5;  // of a housing, relative to its radius

struct Bounds {
  Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  bool empty() const { return low.x > high.x; }
  void add(const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void add_box(const Pose& pose, const Vec3& lower, const Vec3& upper) {
    for (int i = 0; i < 8; ++i)
      add(pose * Vec3{i & 1 ? lower.x : upper.x, i & 2 ? lower.y : upper.y, i & 4 ? lower.z : upper.z});
  }
};

void add_shape(Bounds& bounds, const Pose& pose, const Shape& shape) {
  if (shape.kind == ShapeKind::mesh) return;
  Vec3 half = 0.5 * shape.size;
  if (shape.kind != ShapeKind::box) half = {shape.radius, shape.radius, shape.radius};
  if (shape.kind == ShapeKind::cylinder) half.z = shape.length / 2;
  if (shape.kind != ShapeKind::capsule) return bounds.add_box(pose * shape.pose, -half, half);
  for (const double side : {-0.5, 0.5}) {
    const Vec3 center = (pose * shape.pose) * Vec3{0, 0, side * shape.length};
    bounds.add_box({center, {}}, -half, half);
  }
}

/// The extent of a body's box along a joint's axis, and its radius around that axis.
struct Around {
  double from = 0, to = 0, radius = 0;
};

Around around(const RigidBody& body, const Vec3& origin, const Vec3& axis) {
  Around out{1e9, -1e9, 0};
  std::array<Vec3, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    corners[i] = Vec3{i & 1 ? body.low.x : body.high.x, i & 2 ? body.low.y : body.high.y,
                      i & 4 ? body.low.z : body.high.z} -
                 origin;
    out.from = std::min(out.from, dot(corners[i], axis));
    out.to = std::max(out.to, dot(corners[i], axis));
  }
  std::vector<double> reaches;
  for (const Vec3& side : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
    if (std::abs(dot(side, axis)) > 0.6) continue;
    const Vec3 across = normalized(side - dot(side, axis) * axis);
    for (const double sign : {-1.0, 1.0}) {
      double most = -1e9;
      for (const Vec3& corner : corners) most = std::max(most, sign * dot(corner, across));
      reaches.push_back(most);
    }
  }
  std::sort(reaches.begin(), reaches.end());
  // The nearest side of the box gives the housing's radius, unless the axis lies outside the box or at its
  // edge.
  std::size_t k = 0;
  while (k + 1 < reaches.size() && reaches[k] < 0.3 * reaches[k + 1]) ++k;
  out.radius = reaches.empty() ? 0 : reaches[k];
  return out;
}

class Maker {
 public:
  Maker(const RobotModel& model, bool forks) : model_(model), forks_(forks) {}

  Skeleton make() {
    gather(model_.root, -1, {});
    add_flange();
    measure_reach();
    for (RigidBody& body : out_.bodies) complete(body);
    bound();
    center_slides();
    for (std::size_t b = 0; b < out_.bodies.size(); ++b)
      for (End& end : out_.bodies[b].out)
        if (end.joint >= 0) fit(out_.bodies[b], end, out_.bodies[child_.at(end.joint)]);
    for (RigidBody& body : out_.bodies)
      if (body.has_flange) fit_flange(body);
    return std::move(out_);
  }

 private:
  /// Walks the tree of links. `pose`: pose of `link` in the frame of the first link of its body.
  void gather(int link, int body, const Pose& pose) {
    if (body < 0) {
      body = static_cast<int>(out_.bodies.size());
      out_.bodies.emplace_back();
      members_.emplace_back();
    }
    members_[static_cast<std::size_t>(body)].push_back({link, pose});
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      if (joint.parent_link != link) continue;
      const Pose at = pose * joint.origin;
      if (joint.type == JointType::fixed) {
        gather(joint.child_link, body, at);
        continue;
      }
      End end;
      end.joint = static_cast<int>(j);
      end.origin = at.position;
      end.axis = normalized(at.rotation * joint.axis);
      end.slides = joint.type == JointType::prismatic;
      out_.bodies[static_cast<std::size_t>(body)].out.push_back(end);
      child_[end.joint] = out_.bodies.size();
      turn_[end.joint] = at.rotation;
      gather(joint.child_link, -1, {});
      RigidBody& child = out_.bodies[child_.at(end.joint)];
      child.has_in = true;
      child.in = end;
      child.in.origin = {};
      child.in.axis = normalized(joint.axis);
    }
  }

  void add_flange() {
    const int tool = model_.tool_link();
    if (tool < 0) return;
    for (std::size_t b = 0; b < members_.size(); ++b)
      for (const auto& [link, pose] : members_[b]) {
        if (link != tool || !out_.bodies[b].has_in) continue;
        End end;
        end.origin = pose.position;
        end.axis = normalized(pose.rotation * Vec3{0, 0, 1});
        out_.bodies[b].out.push_back(end);
        out_.bodies[b].has_flange = true;
      }
  }

  void measure_reach() {
    double longest = 0;
    std::vector<double> length(out_.bodies.size(), 0);
    for (std::size_t b = 0; b < out_.bodies.size(); ++b)
      for (const End& end : out_.bodies[b].out) {
        const double here = length[b] + norm(end.origin);
        longest = std::max(longest, here);
        if (end.joint >= 0) length[child_.at(end.joint)] = here;
      }
    out_.reach = std::clamp(longest, 0.05, 50.0);
  }

  /// Chooses the link that carries the shapes, and moves everything into its frame.
  void complete(RigidBody& body) {
    const auto& members = members_[static_cast<std::size_t>(&body - out_.bodies.data())];
    const auto rank = [&](const Link& link) { return link.outline ? 2 : !link.collisions.empty(); };
    std::size_t best = 0;
    for (std::size_t i = 1; i < members.size(); ++i)
      if (rank(link(members[i].first)) > rank(link(members[best].first))) best = i;
    body.link = members[best].first;
    const Pose& main = members[best].second;
    main_[&body - out_.bodies.data()] = main.rotation;
    const Pose back{inverse(main.rotation) * (-main.position), inverse(main.rotation)};
    const auto move = [&](End& end) {
      end.origin = back * end.origin;
      end.axis = back.rotation * end.axis;
    };
    if (body.has_in) move(body.in);
    for (End& end : body.out) move(end);
    Bounds bounds;
    const Link& carrier = link(body.link);
    if (carrier.outline && believable(*carrier.outline))
      bounds.add_box({}, carrier.outline->lower, carrier.outline->upper);
    body.measured = !bounds.empty();
    for (const auto& [index, pose] : members)
      for (const Shape& shape : link(index).collisions)
        if (!body.measured) add_shape(bounds, back * pose, shape);
    if (!bounds.empty() && !believable({bounds.low, bounds.high})) bounds = {};
    if (!bounds.empty()) {
      body.low = bounds.low;
      body.high = bounds.high;
    }
  }

  /// False for outlines that are far larger than the arm: they have another unit, or belong to something
  /// else.
  bool believable(const description::Outline& outline) const {
    return std::max(norm(outline.lower), norm(outline.upper)) < 1.5 * out_.reach + 0.3;
  }

  /// Gives bodies without any shape bounds around the positions of their joints.
  void bound() {
    for (RigidBody& body : out_.bodies) {
      const Vec3 size = body.high - body.low;
      if (std::max({size.x, size.y, size.z}) > 1e-4) continue;
      Bounds bounds;
      const double thick = 0.055 * out_.reach;
      const auto add = [&](const Vec3& p) {
        bounds.add_box({p, {}}, {-thick, -thick, -thick}, {thick, thick, thick});
      };
      add(body.has_in ? body.in.origin : Vec3{});
      for (const End& end : body.out) add(end.origin);
      body.low = bounds.low;
      body.high = bounds.high;
    }
  }

  /// A sliding joint says nothing about where its rod is: its frame may be anywhere. If it is outside of the
  /// box of what it moves, the rod is in the middle of this box.
  void center_slides() {
    for (std::size_t p = 0; p < out_.bodies.size(); ++p)
      for (End& end : out_.bodies[p].out) {
        if (!end.slides || end.joint < 0) continue;
        const std::size_t c = child_.at(end.joint);
        RigidBody& child = out_.bodies[c];
        const Vec3 to = 0.5 * (child.low + child.high) - child.in.origin;
        const Vec3 off = to - dot(to, child.in.axis) * child.in.axis, size = child.high - child.low;
        const Vec3 across = size - dot(size, child.in.axis) * child.in.axis;
        if (!child.measured || norm(off) < 0.5 * norm(across)) continue;
        child.in.origin = child.in.origin + off;
        end.origin =
            end.origin + inverse(main_.at(static_cast<std::ptrdiff_t>(p))) *
                             (turn_.at(end.joint) * (main_.at(static_cast<std::ptrdiff_t>(c)) * off));
      }
  }

  /// True if the direction from one end of the body to the other is closer to `axis` than to its normal
  /// plane.
  static bool runs_along(const RigidBody& body, const Vec3& origin, const Vec3& axis, double radius,
                         bool out) {
    Vec3 way{};
    double longest = -1;
    if (out) {
      if (!body.has_in) return true;
      way = body.in.origin - origin;
    } else {
      for (const End& end : body.out)
        if (norm(end.origin - origin) > longest) {
          way = end.origin - origin;
          longest = norm(way);
        }
      if (longest < 0) return true;
    }
    const double along = dot(way, axis);
    return std::abs(along) > std::max(1.15 * radius, 0.9 * norm(way - along * axis));
  }

  void fit(const RigidBody& parent, End& p, RigidBody& child) {
    End& c = child.in;
    const Around a = around(parent, p.origin, p.axis), b = around(child, c.origin, c.axis);
    const double least = kThin * out_.reach;
    p.radius = std::max({a.radius, 0.5 * b.radius, least});
    c.radius = std::max({b.radius, 0.42 * a.radius, least});
    // If the axis is at the edge of a long box, the box says little about the housing: limit the radius.
    p.radius = std::min(p.radius, 1.8 * c.radius);
    c.radius = std::min(c.radius, 1.8 * p.radius);
    p.other_radius = c.radius;
    c.other_radius = p.radius;
    p.along = runs_along(parent, p.origin, p.axis, p.radius, true);
    c.along = runs_along(child, c.origin, c.axis, c.radius, false);
    const double low = std::max(a.from, b.from), high = std::min(a.to, b.to);
    const double slim = std::min(a.to - a.from, b.to - b.from);
    const bool overlap = high - low > 0.35 * slim;
    // True if each body extends beyond the other one, on opposite sides.
    const bool shifted = (b.to - a.to) * (b.from - a.from) > 0 &&
                         std::min(std::abs(b.to - a.to), std::abs(b.from - a.from)) > 0.1 * slim;
    if (forks_ && overlap && !shifted && !p.along && !c.along && !p.slides)
      nest(p, c, a, b, parent, child);
    else
      stack(p, c, a, b, parent, child);
  }

  /// One body between the cheeks of the other. The wider body is outside; if both are about equally wide, the
  /// longer one.
  static void nest(End& p, End& c, const Around& a, const Around& b, const RigidBody& parent,
                   const RigidBody& child) {
    const double wide_p = a.to - a.from, wide_c = b.to - b.from;
    const auto length = [](const RigidBody& body) {
      double out = 0;
      for (const End& end : body.out) out = std::max(out, norm(end.origin - body.in.origin));
      return out;
    };
    const bool alike = std::abs(wide_p - wide_c) < 0.12 * std::max(wide_p, wide_c);
    const bool child_outside = alike ? length(child) > length(parent) : wide_c > wide_p;
    End& outer = child_outside ? c : p;
    End& inner = child_outside ? p : c;
    const Around& wide = child_outside ? b : a;
    const Around& slim = child_outside ? a : b;
    const double cheek = kCheek * (wide.to - wide.from);
    outer.fit = Fit::outer;
    inner.fit = Fit::inner;
    outer.from = wide.from;
    outer.to = wide.to;
    inner.from = std::max(slim.from, wide.from + cheek);
    inner.to = std::min(slim.to, wide.to - cheek);
    if (inner.to - inner.from < cheek) {
      inner.from = wide.from + cheek;
      inner.to = wide.to - cheek;
    }
    for (End* end : {&outer, &inner}) {
      end->inner_from = inner.from;
      end->inner_to = inner.to;
    }
  }

  /// Side by side. The bodies meet in the middle of their overlap, or of the gap between them.
  static void stack(End& p, End& c, const Around& a, const Around& b, const RigidBody& parent,
                    const RigidBody& child) {
    const double low = std::max(a.from, b.from), high = std::min(a.to, b.to);
    double side = b.from + b.to >= a.from + a.to ? 1 : -1;
    if (c.along && !child.out.empty()) {
      double far = 0;
      for (const End& end : child.out) {
        const double at = dot(end.origin - c.origin, c.axis);
        if (std::abs(at) > std::abs(far)) far = at;
      }
      if (std::abs(far) > 1e-6) side = far > 0 ? 1 : -1;
    }
    double meet = (low + high) / 2;
    // Across a gap, the two meet where the measured body ends.
    if (low > high && parent.measured != child.measured)
      meet = child.measured ? (side > 0 ? b.from : b.to) : (side > 0 ? a.to : a.from);
    // If the child's extent lies within that of a parent that runs along the axis, they meet where the child
    // begins.
    if (high > low && p.along && b.from >= a.from && b.to <= a.to) meet = side > 0 ? b.from : b.to;
    const auto housing = [&](End& end, double direction, const Around& box) {
      const double far = direction > 0 ? std::max(box.to, meet) : std::min(box.from, meet);
      const double whole = std::abs(far - meet);
      const double length = end.along ? std::min(kCollar * end.radius, std::max(whole, 0.2 * end.radius))
                                      : std::clamp(whole, 0.3 * end.radius, kMostLength * end.radius);
      end.meet = meet;
      end.from = std::min(meet, meet + direction * length);
      end.to = std::max(meet, meet + direction * length);
    };
    housing(c, side, b);
    housing(p, -side, a);
  }

  /// The plate for tools. It ends in the flange's plane.
  void fit_flange(RigidBody& body) const {
    End& end = body.out.back();
    const Around box = around(body, end.origin, end.axis);
    const double least = kThin * out_.reach;
    end.radius = std::clamp(box.radius, 0.55 * body.in.radius, std::max(0.95 * body.in.radius, least));
    end.radius = std::max(end.radius, least);
    end.other_radius = end.radius;
    end.along = true;
    end.meet = end.to = 0;
    end.from = -0.35 * end.radius;
  }

  const Link& link(int index) const { return model_.links[static_cast<std::size_t>(index)]; }

  const RobotModel& model_;
  const bool forks_;
  Skeleton out_;
  std::vector<std::vector<std::pair<int, Pose>>> members_;  // of each body: its links and their poses
  std::map<int, std::size_t> child_;                        // by joint: the body that it moves
  std::map<int, Quaternion> turn_;  // by joint: of its child link, in the first link of the parent's body
  std::map<std::ptrdiff_t, Quaternion> main_;  // by body: of the link with its shapes, in its first link
};

}  // namespace

Skeleton skeleton_of(const RobotModel& model, bool forks) {
  return Maker(model, forks).make();
}

}  // namespace polyarm::shapes
