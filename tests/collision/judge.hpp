#pragma once
/// A slow exact judge of contacts that shares no code with the checker: poses from kinematics::Chain,
/// distances by Frank and Wolfe's method from the shapes themselves. Also random robots and worlds.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "polyarm/collision/robot_body.hpp"
#include "polyarm/collision/world.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/random.hpp"

namespace polyarm::collision {

using description::RobotModel;
using description::Shape;
using description::ShapeKind;
using kinematics::Random;

/// A shape or a convex piece at a pose; `pose` includes the shape's own.
struct Placed {
  const Shape* shape;
  std::size_t piece = 0;
  Pose pose;
};

inline Vec3 farthest(const Placed& p, const Vec3& direction) {
  const Vec3 d = inverse(p.pose.rotation) * direction;
  const Shape& s = *p.shape;
  Vec3 out;
  switch (s.kind) {
    case ShapeKind::box:
      out = {std::copysign(s.size.x / 2, d.x), std::copysign(s.size.y / 2, d.y),
             std::copysign(s.size.z / 2, d.z)};
      break;
    case ShapeKind::sphere:
      out = s.radius * normalized(d);
      break;
    case ShapeKind::capsule:
      out = Vec3{0, 0, std::copysign(s.length / 2, d.z)} + s.radius * normalized(d);
      break;
    case ShapeKind::cylinder: {
      const double across = std::hypot(d.x, d.y);
      out = {across > 0 ? s.radius * d.x / across : 0, across > 0 ? s.radius * d.y / across : 0,
             std::copysign(s.length / 2, d.z)};
      break;
    }
    case ShapeKind::mesh: {
      const auto& points = s.pieces[p.piece];
      out = points.front();
      for (const Vec3& q : points)
        if (dot(q, d) > dot(out, d)) out = q;
    }
  }
  return p.pose * out;
}

/// An interval that contains the distance of two placed shapes.
struct Bracket {
  double lower = 0, upper = 0;
};
/// Ends early when the distance exceeds `enough`.
inline Bracket slow_distance(const Placed& a, const Placed& b, double enough = 1e9, int steps = 400) {
  Vec3 v = farthest(a, {1, 0, 0}) - farthest(b, {-1, 0, 0});
  Bracket out{0, norm(v)};
  for (int i = 0; i < steps && out.upper > 1e-9; ++i) {
    const Vec3 w = farthest(a, -v) - farthest(b, v), step = w - v;
    out.lower = std::max(out.lower, dot(v, w) / norm(v));
    const double length = dot(step, step);
    if (length < 1e-24) break;
    const double t = std::clamp(-dot(v, step) / length, 0.0, 1.0);
    v = v + t * step;
    out.upper = norm(v);
    if (out.upper - out.lower < 1e-7 || out.lower > enough) break;
  }
  return out;
}

inline std::vector<Placed> placed(const std::vector<Shape>& shapes, const Pose& frame) {
  std::vector<Placed> out;
  for (const Shape& shape : shapes)
    for (std::size_t k = 0; k < (shape.kind == ShapeKind::mesh ? shape.pieces.size() : 1); ++k)
      out.push_back({&shape, k, frame * shape.pose});
  return out;
}

struct NamedShape {
  std::string name;
  Shape shape;
};

inline Vec3 random_vector(Random& random, double size) {
  return {random.between(-size, size), random.between(-size, size), random.between(-size, size)};
}
inline Quaternion random_turn(Random& random) {
  return normalized(
      Quaternion{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)});
}
inline Shape random_shape(Random& random, double size) {
  Shape out;
  out.kind = static_cast<ShapeKind>(static_cast<int>(random.between(0, 4.999)));
  out.size = {random.between(0.05, 1) * size, random.between(0.05, 1) * size, random.between(0.05, 1) * size};
  out.radius = random.between(0.1, 0.5) * size;
  out.length = random.between(0.1, 1) * size;
  if (out.kind == ShapeKind::mesh)
    for (int k = 0; k < 2; ++k) {
      std::vector<Vec3> piece;
      const Vec3 middle = random_vector(random, size / 2);
      for (int i = 0; i < 9; ++i) piece.push_back(middle + random_vector(random, size / 2));
      out.pieces.push_back(piece);
    }
  out.pose = {random_vector(random, size / 2), random.unit() < 0.3 ? Quaternion{} : random_turn(random)};
  return out;
}

/// Obstacles around a robot of this reach.
inline std::vector<NamedShape> random_world(Random& random, double reach, int count) {
  std::vector<NamedShape> out;
  for (int i = 0; i < count; ++i) {
    Shape shape = random_shape(random, 0.35 * reach);
    shape.pose.position = random_vector(random, reach);
    out.push_back({"obstacle " + std::to_string(i), shape});
  }
  return out;
}
inline World world_from(const std::vector<NamedShape>& shapes) {
  World out;
  for (const NamedShape& s : shapes) out.add(s.name, s.shape);
  return out;
}

/// A chain with a side branch, a mimic joint and a sliding joint.
inline RobotModel random_robot(Random& random, int joints) {
  RobotModel out;
  out.name = "random";
  out.links.push_back({"base"});
  for (int i = 0; i < joints; ++i) {
    description::Joint joint;
    joint.name = "joint" + std::to_string(i);
    joint.parent_link = i == joints - 1 ? i / 2 : i;  // the last one branches off
    joint.child_link = i + 1;
    joint.type = i == 2 ? description::JointType::prismatic : description::JointType::revolute;
    joint.origin = {random_vector(random, 0.25),
                    random.unit() < 0.5 ? from_rpy(M_PI / 2, 0, 0) : random_turn(random)};
    joint.axis = random.unit() < 0.5 ? Vec3{0, 0, 1} : normalized(random_vector(random, 1));
    joint.limits.lower = i == 2 ? -0.3 : -3.0;
    joint.limits.upper = i == 2 ? 0.4 : 3.0;
    if (i == 4) joint.mimic = description::Mimic{1, -0.5, 0.3};
    out.joints.push_back(joint);
    description::Link link{"link" + std::to_string(i)};
    link.parent_joint = i;
    link.collisions.push_back(random_shape(random, 0.2));
    if (random.unit() < 0.4) link.collisions.push_back(random_shape(random, 0.15));
    out.links.push_back(link);
    if (!joint.mimic) out.actuated.push_back(i);
  }
  return out;
}

inline std::vector<double> random_state(const RobotModel& model, Random& random) {
  std::vector<double> out;
  for (const int i : model.actuated) {
    const auto& limits = model.joints[static_cast<std::size_t>(i)].limits;
    out.push_back(random.between(std::max(-3.14159, limits.lower.value_or(-3.14)),
                                 std::min(3.14159, limits.upper.value_or(3.14))));
  }
  return out;
}

/// A bracket of the smallest distance over all pairs that `robot` checks.
class Judge {
 public:
  Judge(const RobotModel& model, const RobotBody& robot, const std::vector<NamedShape>& world)
      : model_(model),
        robot_(robot),
        world_(world),
        chain_(model, static_cast<int>(model.links.size()) - 1),
        poses_(model.links.size()) {}

  /// `own`: also between the links of the robot.
  Bracket distance(const std::vector<double>& q, bool own = true) {
    chain_.link_poses(q, poses_);
    Bracket out{1e9, 1e9};
    const auto take = [&](const std::vector<Placed>& a, const std::vector<Placed>& b) {
      for (const Placed& x : a)
        for (const Placed& y : b) {
          const Bracket d = slow_distance(x, y, out.upper);
          out = {std::min(out.lower, d.lower), std::min(out.upper, d.upper)};
        }
    };
    for (const LinkBody& link : robot_.links()) {
      if (link.frame < 0) continue;
      for (const NamedShape& o : world_) take(of(link), at_rest(o));
    }
    for (const LinkPairBody& pair : robot_.pairs())
      if (own) take(of(robot_.links()[pair.first]), of(robot_.links()[pair.second]));
    return out;
  }

 private:
  std::vector<Placed> of(const LinkBody& link) const {
    return collision::placed(model_.links[static_cast<std::size_t>(link.link)].collisions,
                             poses_[static_cast<std::size_t>(link.link)]);
  }
  static std::vector<Placed> at_rest(const NamedShape& named) {
    std::vector<Placed> out;
    for (std::size_t k = 0; k < (named.shape.kind == ShapeKind::mesh ? named.shape.pieces.size() : 1); ++k)
      out.push_back({&named.shape, k, named.shape.pose});
    return out;
  }
  const RobotModel& model_;
  const RobotBody& robot_;
  const std::vector<NamedShape>& world_;
  kinematics::Chain chain_;
  std::vector<Pose> poses_;
};

}  // namespace polyarm::collision
