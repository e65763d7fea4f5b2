#include "polyarm/collision/check_data.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/collision/separation.hpp"
#include "polyarm/hulls/hull.hpp"

namespace polyarm::collision {

using description::ShapeKind;

namespace {

constexpr double kSnap = 1e-9;  // rad
constexpr double kUnlimitedReach =
    100;  // m, where a sliding joint has no limits: for bounds on rounding only

std::size_t at(int index) {
  return static_cast<std::size_t>(index);
}
float rounded_up(double v) {
  return std::nextafter(static_cast<float>(v), INFINITY);
}
Quaternion about_z(double angle) {
  return {0, 0, std::sin(angle / 2), std::cos(angle / 2)};
}
void write(const Vec3& v, float* to) {
  to[0] = static_cast<float>(v.x), to[1] = static_cast<float>(v.y), to[2] = static_cast<float>(v.z);
}

// --- joints
// ---------------------------------------------------------------------------------------------------

/// R = Rz(before) Rx(angle) Rz(after).
struct Turns {
  double before = 0, angle = 0, after = 0;
};
Turns turns_of(const Quaternion& r) {
  const Vec3 x = r * Vec3{1, 0, 0}, y = r * Vec3{0, 1, 0}, z = r * Vec3{0, 0, 1};
  const double across = std::hypot(z.x, z.y);
  if (across > kSnap) return {std::atan2(z.x, -z.y), std::atan2(across, z.z), std::atan2(x.z, y.z)};
  if (z.z > 0) return {0, 0, std::atan2(x.y, x.x)};
  return {0, std::numbers::pi, std::atan2(-x.y, x.x)};
}

void write_twist(double angle, CheckStep& step) {
  const double s = std::sin(angle), c = std::cos(angle);
  step.cosine = static_cast<float>(c), step.sine = static_cast<float>(s);
  if (std::abs(s) < kSnap)
    step.twist = c > 0 ? Twist::none : Twist::half;
  else if (std::abs(c) < kSnap)
    step.twist = s > 0 ? Twist::quarter : Twist::back_quarter;
  else
    step.twist = Twist::angle;
}

/// Chooses the direction of each frame's x axis so that the way to its first child needs no turn about z:
/// then most joints need a turn about x by a quarter, or none. Returns the turn of each frame about its z.
std::vector<double> add_steps(const RobotBody& robot, CheckData& out) {
  const std::vector<JointFrame>& frames = robot.frames();
  std::vector<double> turn(frames.size(), 0), offsets;
  std::vector<bool> fixed(frames.size(), false);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const JointFrame& frame = frames[k];
    Pose rest = frame.at;
    CheckStep step;
    step.parent = frame.parent;
    step.variable = static_cast<std::uint32_t>(frame.variable);
    step.slides = frame.slides;
    offsets.push_back(frame.offset);
    if (frame.parent >= 0) {
      const std::size_t parent = at(frame.parent);
      if (!frames[parent].slides && !fixed[parent] && !frame.slides) {
        turn[parent] = turns_of(rest.rotation).before;
        offsets[parent] += turn[parent];
      }
      fixed[parent] = true;
      rest = Pose{{}, about_z(-turn[parent])} * rest;
      const Turns own = turns_of(rest.rotation);
      if (!frame.slides && std::abs(own.before) < kSnap) {
        offsets[k] += own.after;
        write_twist(own.angle, step);
      }
    }
    step.ratio = static_cast<float>(frame.ratio);
    write(rest.rotation * Vec3{1, 0, 0}, step.r);
    write(rest.rotation * Vec3{0, 1, 0}, step.r + 3);
    write(rest.rotation * Vec3{0, 0, 1}, step.r + 6);
    write(rest.position, step.t);
    out.steps.push_back(step);
  }
  for (std::size_t k = 0; k < frames.size(); ++k)
    out.steps[k].offset =
        static_cast<float>(frames[k].slides ? offsets[k] : std::remainder(offsets[k], 2 * std::numbers::pi));
  return turn;
}

// --- links
// ----------------------------------------------------------------------------------------------------

CheckSphere sphere_of(const Ball& ball, const Quaternion& into) {
  const Vec3 c = into * ball.center;
  return {static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z), rounded_up(ball.radius)};
}

/// How many joints lie between the base and a link.
int depth_of(const RobotBody& robot, const LinkBody& link) {
  int out = 0;
  for (int k = link.frame; k >= 0; k = robot.frames()[at(k)].parent) ++out;
  return out;
}

/// Moving links, far ones first, then those that do not move: they only meet other links.
std::vector<std::size_t> order_of(const RobotBody& robot) {
  std::vector<std::size_t> out(robot.links().size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = i;
  std::stable_sort(out.begin(), out.end(), [&](std::size_t a, std::size_t b) {
    return depth_of(robot, robot.links()[a]) > depth_of(robot, robot.links()[b]);
  });
  return out;
}

void add_links(const RobotBody& robot, const std::vector<double>& turn, CheckData& out) {
  for (const std::size_t body : order_of(robot)) {
    const LinkBody& from = robot.links()[body];
    const Quaternion into = from.frame < 0 ? Quaternion{} : about_z(-turn[at(from.frame)]);
    CheckLink link;
    link.step = from.frame;
    link.row = static_cast<std::uint32_t>(out.links.size());
    link.first = static_cast<std::uint32_t>(out.spheres.size());
    link.count = static_cast<std::uint32_t>(from.spheres.size());
    link.around = sphere_of(from.around, into);
    for (const Ball& ball : from.spheres) out.spheres.push_back(sphere_of(ball, into));
    out.links.push_back(link);
    out.body_of_link.push_back(body);
  }
}

// --- obstacles
// ------------------------------------------------------------------------------------------------

struct Rounding {
  double reach;     ///< of the robot, m; infinite if unknown
  double relative;  ///< error of a point's position over its size
  double error(double size) const {
    return relative * (std::isfinite(reach) ? reach + size : kUnlimitedReach + size);
  }
};

/// The part of a box with this pose and half edges that is near enough to be touched; in its own axes. The
/// distance of each point within reach to the part is that to the whole.
void clip(double reach, Pose& pose, Vec3& half) {
  if (!std::isfinite(reach)) return;
  const Vec3 base = inverse(pose.rotation) * -pose.position;
  const auto part = [&](double own, double h, double& middle, double& extent) {
    const double lower = std::max(-h, own - reach), upper = std::min(h, own + reach);
    middle = upper > lower ? (lower + upper) / 2 : std::clamp(own, -h, h);
    extent = upper > lower ? (upper - lower) / 2 : 0;
  };
  Vec3 middle, extent;
  part(base.x, half.x, middle.x, extent.x);
  part(base.y, half.y, middle.y, extent.y);
  part(base.z, half.z, middle.z, extent.z);
  pose.position = pose * middle;
  half = extent;
}

/// True if the axes are those of the base in another order; then `half` is along the axes of the base.
bool align(const Pose& pose, Vec3& half) {
  const std::array<Vec3, 3> axes{pose.rotation * Vec3{1, 0, 0}, pose.rotation * Vec3{0, 1, 0},
                                 pose.rotation * Vec3{0, 0, 1}};
  const std::array<double, 3> lengths{half.x, half.y, half.z};
  Vec3 out;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 a{std::abs(axes[i].x), std::abs(axes[i].y), std::abs(axes[i].z)};
    if (std::max({a.x, a.y, a.z}) < 1 - 1e-14 && lengths[i] > 0) return false;
    out = out + lengths[i] * a;
  }
  half = out;
  return true;
}

CheckBox box_of(const Pose& pose, const Vec3& half, double radius) {
  CheckBox out{};
  write(pose.position, out.c);
  write(half, out.h);
  out.r = rounded_up(radius);
  write(pose.rotation * Vec3{1, 0, 0}, out.axes);
  write(pose.rotation * Vec3{0, 1, 0}, out.axes + 3);
  write(pose.rotation * Vec3{0, 0, 1}, out.axes + 6);
  return out;
}

/// A compiled obstacle: its kind and its index among those of the kind.
struct Compiled {
  ObstacleKind kind = ObstacleKind::aligned;
  std::uint32_t index = 0;
};

template <class T>
Compiled append(ObstacleKind kind, std::vector<T>& to, const T& what) {
  to.push_back(what);
  return {kind, static_cast<std::uint32_t>(to.size() - 1)};
}

Compiled add_box(Pose pose, Vec3 half, double radius, double clearance, const Rounding& rounding,
                 CheckData& out) {
  clip(rounding.reach, pose, half);
  const double grown = radius + clearance + rounding.error(norm(pose.position) + norm(half));
  if (align(pose, half))
    return append(ObstacleKind::aligned, out.aligned, box_of({pose.position, {}}, half, grown));
  return append(ObstacleKind::turned, out.turned, box_of(pose, half, grown));
}

Quaternion turn_of(const std::array<Vec3, 3>& axes) {
  const Quaternion first = rotation_between({1, 0, 0}, axes[0]);
  const Vec3 y = first * Vec3{0, 1, 0};
  const double angle = std::atan2(dot(cross(y, axes[1]), axes[0]), dot(y, axes[1]));
  return normalized(from_axis_angle(axes[0], angle) * first);
}

Compiled add_convex(const ConvexBody& body, double clearance, const Rounding& rounding, CheckData& out) {
  const hulls::Axes axes = hulls::principal_axes(body.points);
  Pose pose{{}, turn_of(axes.direction)};
  Vec3 lower{INFINITY, INFINITY, INFINITY}, upper = -lower;
  double size = 0;
  for (const Vec3& p : body.points) {
    const Vec3 l = inverse(pose.rotation) * p;
    lower = {std::min(lower.x, l.x), std::min(lower.y, l.y), std::min(lower.z, l.z)};
    upper = {std::max(upper.x, l.x), std::max(upper.y, l.y), std::max(upper.z, l.z)};
    size = std::max(size, norm(p));
  }
  pose.position = pose.rotation * (0.5 * (lower + upper));
  const double grown = body.radius + clearance + rounding.error(size);
  CheckConvex piece{box_of(pose, 0.5 * (upper - lower), grown), static_cast<std::uint32_t>(out.faces.size()),
                    0, rounded_up(grown)};
  const hulls::Hull hull = hulls::convex_hull(body.points);
  std::vector<Vec3> normals;
  for (const auto& face : hull.faces) {
    const Vec3 &a = hull.corners[face[0]], &b = hull.corners[face[1]], &c = hull.corners[face[2]];
    const Vec3 n = cross(b - a, c - a);
    if (norm(n) < 1e-14) continue;
    const Vec3 normal = normalized(n);
    if (std::any_of(normals.begin(), normals.end(), [&](const Vec3& o) { return dot(o, normal) > 1 - 1e-9; }))
      continue;  // without a plane the piece is larger
    normals.push_back(normal);
    double offset = -INFINITY;
    for (const Vec3& p : body.points) offset = std::max(offset, dot(normal, p));
    CheckPlane plane{};
    write(normal, plane.n);
    plane.d = rounded_up(offset);
    out.faces.push_back(plane);
    ++piece.count;
  }
  return append(ObstacleKind::convex, out.convex, piece);
}

Compiled add_obstacle(const Obstacle& o, double clearance, const Rounding& rounding, CheckData& out) {
  if (o.is_half_space) {
    CheckPlane plane{};
    write(o.half_space.normal, plane.n);
    plane.d = rounded_up(o.half_space.offset + clearance + rounding.error(std::abs(o.half_space.offset)));
    return append(ObstacleKind::plane, out.planes, plane);
  }
  switch (o.kind) {
    case ShapeKind::box:
      return add_box(o.pose, o.half, 0, clearance, rounding, out);
    case ShapeKind::sphere:
      return add_box({o.pose.position, {}}, {}, o.body.radius, clearance, rounding, out);
    case ShapeKind::capsule:
      return add_box(o.pose, {0, 0, norm(o.body.points[1] - o.body.points[0]) / 2}, o.body.radius, clearance,
                     rounding, out);
    case ShapeKind::cylinder: {
      CheckCylinder c{};
      const double half = norm(o.body.points[1] - o.body.points[0]) / 2;
      write(o.pose.position, c.c);
      write(o.body.axis, c.axis);
      c.half = rounded_up(half), c.radius = rounded_up(o.body.disc);
      c.r = rounded_up(clearance + rounding.error(norm(o.pose.position) + half + o.body.disc));
      return append(ObstacleKind::cylinder, out.cylinders, c);
    }
    case ShapeKind::mesh:
      break;
  }
  return add_convex(o.body, clearance, rounding, out);
}

double distance_from_base(const Obstacle& o) {
  if (o.is_half_space) return -o.half_space.offset;
  return separation({{{}}, 0, 0, {0, 0, 1}}, {}, o.body).lower;
}

/// So many boxes of one link get a tree.
constexpr std::size_t kTreeFrom = 40;

Bounds bounds_of_box(const CheckBox& box, bool turned) {
  Vec3 half{box.h[0], box.h[1], box.h[2]};
  if (turned) {
    const float* a = box.axes;
    const auto extent = [&](int k) {
      return std::abs(a[k]) * half.x + std::abs(a[3 + k]) * half.y + std::abs(a[6 + k]) * half.z;
    };
    half = {extent(0), extent(1), extent(2)};
  }
  const Vec3 middle{box.c[0], box.c[1], box.c[2]};
  return {middle - half, middle + half};
}

/// A tree over the boxes that are listed from `begin` to the end of `out.reachable`, which then leave the
/// list.
void plant(CheckLink& link, std::size_t kind, std::size_t begin, CheckData& out) {
  const std::vector<CheckBox>& boxes = kind == 0 ? out.aligned : out.turned;
  const std::vector<std::uint32_t> listed(out.reachable.begin() + static_cast<std::ptrdiff_t>(begin),
                                          out.reachable.end());
  out.reachable.resize(begin);
  std::vector<Bounds> bounds;
  float radius = 0;
  for (const std::uint32_t i : listed) {
    bounds.push_back(bounds_of_box(boxes[i], kind == 1));
    radius = std::max(radius, boxes[i].r);
  }
  const BoxTree tree(bounds);
  const auto first = static_cast<std::uint32_t>(out.nodes.size());
  for (const BoxTree::Node& node : tree.nodes()) {
    const Vec3 middle = 0.5 * (node.bounds.lower + node.bounds.upper);
    CheckNode made{};
    // A box in single precision is not smaller than that in double precision.
    made.box = box_of({middle, {}}, 0.5 * (node.bounds.upper - node.bounds.lower),
                      radius + 1e-6 * (1 + norm(middle)));
    made.next = first + node.next;
    made.leaf = node.leaf == BoxTree::kInner ? kNoLeaf : listed[node.leaf];
    out.nodes.push_back(made);
  }
  link.tree[kind] = first;
  link.tree_end[kind] = static_cast<std::uint32_t>(out.nodes.size());
}

CheckData::Nearby nearby(const std::vector<std::size_t>& listed, const std::vector<Obstacle>& obstacles) {
  CheckData::Nearby out;
  std::vector<Bounds> bounds;
  for (const std::size_t i : listed) {
    if (obstacles[i].is_half_space || listed.size() < kTreeFrom) {
      out.always.push_back(i);
      continue;
    }
    out.obstacle.push_back(i);
    bounds.push_back(bounds_of(obstacles[i].body));
  }
  out.tree = BoxTree(bounds);
  return out;
}

void add_reachable(const RobotBody& robot, const std::vector<Obstacle>& obstacles, double clearance,
                   const std::vector<char>& allowed, const std::vector<Compiled>& compiled, CheckData& out) {
  std::vector<double> distance;
  for (const Obstacle& o : obstacles) distance.push_back(distance_from_base(o));
  out.obstacles_of_link.resize(out.links.size());
  out.measured_of_link.resize(out.links.size());
  for (std::size_t l = 0; l < out.links.size(); ++l) {
    CheckLink& link = out.links[l];
    const std::size_t body = out.body_of_link[l];
    for (std::size_t kind = 0; kind < kObstacleKinds; ++kind) {
      link.begin[kind] = static_cast<std::uint32_t>(out.reachable.size());
      for (std::size_t i = 0; link.step >= 0 && i < obstacles.size(); ++i) {
        if (static_cast<std::size_t>(compiled[i].kind) != kind) continue;
        if (!allowed.empty() && allowed[body * obstacles.size() + i]) continue;
        out.measured_of_link[l].push_back(i);
        if (distance[i] > robot.reach(body) + clearance + 1e-3) continue;
        out.reachable.push_back(compiled[i].index);
        out.obstacles_of_link[l].push_back(i);
      }
      if (kind < 2 && out.reachable.size() - link.begin[kind] >= kTreeFrom)
        plant(link, kind, link.begin[kind], out);
    }
    link.begin[kObstacleKinds] = static_cast<std::uint32_t>(out.reachable.size());
    out.reachable_near.push_back(nearby(out.obstacles_of_link[l], obstacles));
    out.measured_near.push_back(nearby(out.measured_of_link[l], obstacles));
  }
}

}  // namespace

void make_check_data(const RobotBody& robot, const std::vector<Obstacle>& obstacles, double clearance,
                     const std::vector<char>& allowed, CheckData& out) {
  const std::vector<double> turn = add_steps(robot, out);
  add_links(robot, turn, out);
  double reach = 0;
  for (std::size_t i = 0; i < robot.links().size(); ++i) reach = std::max(reach, robot.reach(i));
  const Rounding rounding{reach, 4e-7 * double(robot.frames().size() + 4)};
  std::vector<Compiled> compiled;
  for (const Obstacle& o : obstacles) compiled.push_back(add_obstacle(o, clearance, rounding, out));
  add_reachable(robot, obstacles, clearance, allowed, compiled, out);
  std::vector<std::uint32_t> place(robot.links().size());
  for (std::size_t l = 0; l < out.links.size(); ++l)
    place[out.body_of_link[l]] = static_cast<std::uint32_t>(l);
  for (const LinkPairBody& pair : robot.pairs())
    out.pairs.push_back({place[pair.first], place[pair.second], rounded_up(rounding.error(0) * 2)});
  out.model = {out.steps.data(),     out.links.data(),   out.spheres.data(), out.pairs.data(),
               out.reachable.data(), out.aligned.data(), out.turned.data(),  out.cylinders.data(),
               out.convex.data(),    out.faces.data(),   out.planes.data(),  out.nodes.data(),
               robot.variables(),    out.steps.size(),   out.links.size(),   out.spheres.size(),
               out.pairs.size()};
}

}  // namespace polyarm::collision
