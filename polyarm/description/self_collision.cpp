#include "polyarm/description/self_collision.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <utility>

namespace polyarm::description {

namespace {

/// A ball that contains something.
struct Ball {
  Vec3 center;
  double radius = 0;
};

/// A convex body in its link's frame: the hull of its points, expanded by its radius.
struct Body {
  std::vector<Vec3> points;
  double radius = 0;
  Ball around;
};

Ball ball_around(const Body& body) {
  Vec3 lower = body.points.front(), upper = lower;
  for (const Vec3& p : body.points) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  Ball out{0.5 * (lower + upper), 0};
  for (const Vec3& p : body.points) out.radius = std::max(out.radius, norm(p - out.center));
  out.radius += body.radius;
  return out;
}

Ball ball_around(const std::vector<Body>& bodies) {
  Ball out;
  for (const Body& body : bodies)
    out.center = out.center + (1.0 / static_cast<double>(bodies.size())) * body.around.center;
  for (const Body& body : bodies)
    out.radius = std::max(out.radius, norm(body.around.center - out.center) + body.around.radius);
  return out;
}

/// True if the balls are apart. Most pairs of links are: this is much cheaper than the exact answer.
bool are_apart(const Ball& a, const Pose& pose_a, const Ball& b, const Pose& pose_b) {
  const Vec3 between = pose_a * a.center - pose_b * b.center;
  const double reach = a.radius + b.radius + 1e-9;
  return dot(between, between) > reach * reach;
}

Vec3 support(const Body& body, const Pose& pose, const Vec3& direction) {
  const Vec3 local = inverse(pose.rotation) * direction;
  const Vec3* best = &body.points.front();
  for (const Vec3& p : body.points)
    if (dot(p, local) > dot(*best, local)) best = &p;
  return pose * *best + body.radius * normalized(direction);
}

bool same_way(const Vec3& a, const Vec3& b) {
  return dot(a, b) > 0;
}

/// The simplex of the search, newest point first. Each function keeps the part nearest to the origin and the
/// direction to it; true if the origin is inside. Gilbert, Johnson, Keerthi 1988, in the form without
/// distances (Muratori 2006).
struct Simplex {
  std::array<Vec3, 4> at{};
  int size = 0;
  Vec3 direction{1, 0, 0};

  void push(const Vec3& point) {
    for (int i = std::min(size, 3); i > 0; --i)
      at[static_cast<std::size_t>(i)] = at[static_cast<std::size_t>(i - 1)];
    at[0] = point;
    size = std::min(size + 1, 4);
  }
  bool nearest() { return size == 2 ? line() : size == 3 ? triangle() : size == 4 ? tetrahedron() : false; }

  bool line() {
    const Vec3 ab = at[1] - at[0], ao = -at[0];
    if (same_way(ab, ao)) {
      direction = cross(cross(ab, ao), ab);
    } else {
      size = 1;
      direction = ao;
    }
    return false;
  }

  bool triangle() {
    const Vec3 a = at[0], b = at[1], c = at[2], ao = -a, abc = cross(b - a, c - a);
    if (same_way(cross(abc, c - a), ao)) {
      if (same_way(c - a, ao)) {
        at = {a, c};
        size = 2;
        direction = cross(cross(c - a, ao), c - a);
        return false;
      }
      at = {a, b};
      size = 2;
      return line();
    }
    if (same_way(cross(b - a, abc), ao)) {
      at = {a, b};
      size = 2;
      return line();
    }
    if (same_way(abc, ao)) {
      direction = abc;
    } else {
      at = {a, c, b};
      direction = -abc;
    }
    return false;
  }

  bool tetrahedron() {
    const Vec3 a = at[0], b = at[1], c = at[2], d = at[3], ao = -a;
    for (const auto& [p, q] : {std::pair{b, c}, {c, d}, {d, b}})
      if (same_way(cross(p - a, q - a), ao)) {
        at = {a, p, q};
        size = 3;
        return triangle();
      }
    return true;
  }
};

bool touch(const Body& a, const Pose& pose_a, const Body& b, const Pose& pose_b) {
  const auto difference = [&](const Vec3& d) { return support(a, pose_a, d) - support(b, pose_b, -d); };
  Simplex simplex;
  simplex.direction = pose_b.position - pose_a.position + Vec3{1e-9, 2e-9, 3e-9};
  simplex.push(difference(simplex.direction));
  simplex.direction = -simplex.at[0];
  for (int i = 0; i < 64; ++i) {
    if (dot(simplex.direction, simplex.direction) < 1e-24) return true;  // the origin lies on it
    const Vec3 point = difference(simplex.direction);
    if (dot(point, simplex.direction) < 0) return false;
    simplex.push(point);
    if (simplex.nearest()) return true;
  }
  return true;  // round bodies that just touch
}

/// The rims of a cylinder as polygons outside the circle.
std::vector<Vec3> rims(double radius, double length) {
  constexpr int kCorners = 24;
  const double outer = radius / std::cos(std::numbers::pi / kCorners);
  std::vector<Vec3> out;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    for (const double z : {-length / 2, length / 2})
      out.push_back({outer * std::cos(angle), outer * std::sin(angle), z});
  }
  return out;
}

/// Adds the convex bodies of a shape; none for a mesh without pieces.
void add_bodies(const Shape& shape, std::vector<Body>& to) {
  const std::size_t before = to.size();
  switch (shape.kind) {
    case ShapeKind::box: {
      Body box;
      for (int corner = 0; corner < 8; ++corner)
        box.points.push_back({(corner & 1 ? 0.5 : -0.5) * shape.size.x,
                              (corner & 2 ? 0.5 : -0.5) * shape.size.y,
                              (corner & 4 ? 0.5 : -0.5) * shape.size.z});
      to.push_back(std::move(box));
      break;
    }
    case ShapeKind::sphere:
      to.push_back({{{}}, shape.radius, {}});
      break;
    case ShapeKind::capsule:
      to.push_back({{{0, 0, -shape.length / 2}, {0, 0, shape.length / 2}}, shape.radius, {}});
      break;
    case ShapeKind::cylinder:
      to.push_back({rims(shape.radius, shape.length), 0, {}});
      break;
    case ShapeKind::mesh:
      for (const std::vector<Vec3>& piece : shape.pieces) to.push_back({piece, 0, {}});
  }
  for (std::size_t i = before; i < to.size(); ++i)
    for (Vec3& point : to[i].points) point = shape.pose * point;
}

class Bodies {
 public:
  explicit Bodies(const RobotModel& model)
      : model_{model}, of_link_(model.links.size()), known_(model.links.size(), true) {
    for (std::size_t i = 0; i < model.links.size(); ++i)
      for (const Shape& shape : model.links[i].collisions) {
        const std::size_t before = of_link_[i].size();
        add_bodies(shape, of_link_[i]);
        if (of_link_[i].size() == before) known_[i] = false;
      }
    for (std::vector<Body>& bodies : of_link_) {
      for (Body& body : bodies) body.around = ball_around(body);
      around_.push_back(ball_around(bodies));
    }
  }

  bool any(int link) const { return !model_.links[at(link)].collisions.empty(); }
  bool known(int link) const { return known_[at(link)]; }

  std::vector<Pose> poses(std::span<const double> q) const {
    std::vector<double> values(model_.joints.size(), 0);
    for (std::size_t i = 0; i < model_.actuated.size() && i < q.size(); ++i)
      values[at(model_.actuated[i])] = q[i];
    std::vector<Pose> out(model_.links.size());
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      const Joint& joint = model_.joints[i];
      if (joint.mimic)
        values[i] = joint.mimic->multiplier * values[at(joint.mimic->joint)] + joint.mimic->offset;
      out[at(joint.child_link)] = out[at(joint.parent_link)] * joint.origin * moved(joint, values[i]);
    }
    return out;
  }

  bool touch(int first, int second, const std::vector<Pose>& poses) const {
    const Pose &pose_a = poses[at(first)], &pose_b = poses[at(second)];
    if (are_apart(around_[at(first)], pose_a, around_[at(second)], pose_b)) return false;
    for (const Body& a : of_link_[at(first)]) {
      if (are_apart(a.around, pose_a, around_[at(second)], pose_b)) continue;
      for (const Body& b : of_link_[at(second)])
        if (!are_apart(a.around, pose_a, b.around, pose_b) && description::touch(a, pose_a, b, pose_b))
          return true;
    }
    return false;
  }

 private:
  static std::size_t at(int index) { return static_cast<std::size_t>(index); }
  static Pose moved(const Joint& joint, double q) {
    if (!joint.moves()) return {};
    if (joint.type == JointType::prismatic) return {q * joint.axis, {}};
    const double s = std::sin(q / 2);
    return {{}, {joint.axis.x * s, joint.axis.y * s, joint.axis.z * s, std::cos(q / 2)}};
  }

  const RobotModel& model_;
  std::vector<std::vector<Body>> of_link_;
  std::vector<Ball> around_;  ///< by link: all its bodies
  std::vector<bool> known_;
};

/// The next link towards the root that has a shape; -1 if there is none.
int above(const RobotModel& model, const Bodies& bodies, int link) {
  for (;;) {
    const int joint = model.links[static_cast<std::size_t>(link)].parent_joint;
    if (joint < 0) return -1;
    link = model.joints[static_cast<std::size_t>(joint)].parent_link;
    if (bodies.any(link)) return link;
  }
}

std::vector<double> random_state(const RobotModel& model, std::mt19937& random) {
  std::vector<double> q;
  for (const int index : model.actuated) {
    const Joint& joint = model.joints[static_cast<std::size_t>(index)];
    const double wide = joint.type == JointType::prismatic ? 1 : std::numbers::pi;
    const double lower = joint.limits.lower.value_or(-wide), upper = joint.limits.upper.value_or(wide);
    q.push_back(lower + (upper - lower) * (static_cast<double>(random()) / 4294967296.0));
  }
  return q;
}

}  // namespace

std::string_view name(PairReason reason) {
  constexpr std::string_view kNames[] = {"Adjacent", "Default", "Always", "Never"};
  return kNames[static_cast<std::size_t>(reason)];
}

std::optional<bool> links_touch(const RobotModel& model, int first, int second, std::span<const double> q) {
  const Bodies bodies(model);
  if (!bodies.known(first) || !bodies.known(second)) return std::nullopt;
  return bodies.touch(first, second, bodies.poses(q));
}

std::vector<LinkPair> needless_pairs(const RobotModel& model, int samples, std::uint32_t seed) {
  const Bodies bodies(model);
  std::vector<LinkPair> out, open;
  const auto home = model.named_states.find("home");
  const auto at_home = bodies.poses(home == model.named_states.end() ? std::vector<double>{} : home->second);
  const int count = static_cast<int>(model.links.size());
  for (int a = 0; a < count; ++a)
    for (int b = a + 1; b < count; ++b) {
      if (!bodies.any(a) || !bodies.any(b)) continue;
      if (above(model, bodies, b) == a || above(model, bodies, a) == b)
        out.push_back({a, b, PairReason::adjacent});
      else if (!bodies.known(a) || !bodies.known(b))
        continue;
      else if (bodies.touch(a, b, at_home))
        out.push_back({a, b, PairReason::default_state});
      else
        open.push_back({a, b, PairReason::never});
    }
  std::vector<int> touches(open.size(), 0);
  std::mt19937 random(seed);
  for (int i = 0; i < samples; ++i) {
    const auto poses = bodies.poses(random_state(model, random));
    for (std::size_t k = 0; k < open.size(); ++k)
      touches[k] += bodies.touch(open[k].first, open[k].second, poses) ? 1 : 0;
  }
  for (std::size_t k = 0; k < open.size(); ++k) {
    if (touches[k] > samples * 0.95) open[k].reason = PairReason::always;
    if (touches[k] == 0 || open[k].reason == PairReason::always) out.push_back(open[k]);
  }
  std::sort(out.begin(), out.end(), [](const LinkPair& x, const LinkPair& y) {
    return std::pair(x.first, x.second) < std::pair(y.first, y.second);
  });
  return out;
}

}  // namespace polyarm::description
