#include "polyarm/description/plain_urdf.hpp"

#include <utility>
#include <vector>

#include "polyarm/description/urdf.hpp"

namespace polyarm::description {

namespace {

std::vector<Shape> without_capsules(const std::vector<Shape>& shapes) {
  std::vector<Shape> out;
  for (const Shape& shape : shapes) {
    out.push_back(shape);
    if (shape.kind != ShapeKind::capsule) continue;
    out.back().kind = ShapeKind::cylinder;
    for (const double end : {-0.5, 0.5}) {
      Shape ball = shape;
      ball.kind = ShapeKind::sphere;
      ball.pose = shape.pose * Pose{{0, 0, end * shape.length}, {}};
      out.push_back(std::move(ball));
    }
  }
  return out;
}

}  // namespace

std::string write_plain_urdf(const RobotModel& model) {
  RobotModel plain = model;
  for (Link& link : plain.links) {
    link.visuals = without_capsules(link.visuals);
    link.collisions = without_capsules(link.collisions);
    if (link.inertial) link.inertial->estimated = false;
  }
  plain.provenance = {};
  plain.named_states.clear();
  plain.groups.clear();
  plain.end_effectors.clear();
  plain.controller_axes.clear();
  plain.allowed_collisions.clear();
  return write_urdf(plain);
}

}  // namespace polyarm::description
