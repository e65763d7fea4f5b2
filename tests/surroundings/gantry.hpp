#pragma once
/// A gantry whose ball goes anywhere, and scenes for it. Metres.
#include <string>

#include "polyarm/surroundings/sweep.hpp"

namespace polyarm::surroundings {

inline constexpr double kBall = 0.02;

/// Three slides along x, y and z that carry a ball; `tool`: its frame is the middle of the ball.
inline description::RobotModel gantry() {
  description::RobotModel out;
  out.name = "gantry";
  out.links.push_back({"base"});
  for (int i = 0; i < 3; ++i) {
    description::Joint joint;
    joint.name = std::string("slide_") + "xyz"[i];
    joint.parent_link = i, joint.child_link = i + 1;
    joint.type = description::JointType::prismatic;
    joint.axis = {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
    joint.limits.lower = -2, joint.limits.upper = 2;
    out.joints.push_back(joint);
    description::Link link{i == 2 ? "ball" : joint.name};
    link.parent_joint = i;
    out.links.push_back(link);
    out.actuated.push_back(i);
  }
  description::Shape ball;
  ball.kind = description::ShapeKind::sphere;
  ball.radius = kBall;
  out.links.back().collisions = {ball};
  return out;
}

inline description::Shape box(double x, double y, double z) {
  description::Shape out;
  out.size = {x, y, z};
  return out;
}

inline description::Fixture fixture(const std::string& name, const Vec3& size, const Vec3& at) {
  description::Fixture out;
  out.name = name;
  out.shapes = {box(size.x, size.y, size.z)};
  out.pose.position = at;
  return out;
}

inline Moment at(double x, double y, double z) {
  Moment out;
  out.robots = {{{}, {x, y, z}}};
  return out;
}

}  // namespace polyarm::surroundings
