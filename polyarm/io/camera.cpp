#include "polyarm/io/camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/description/shape_bounds.hpp"

namespace polyarm::cell {

using description::ShapeKind;

double height_above_origin(const description::Shape& shape, const Quaternion& rotation) {
  if (shape.kind == ShapeKind::mesh) return description::bounds_of(shape, {{}, rotation}).upper.z;
  const Vec3 z = inverse(rotation) * Vec3{0, 0, 1};  // world's up direction in the part's frame
  switch (shape.kind) {
    case ShapeKind::sphere:
      return shape.radius;
    case ShapeKind::capsule:
      return shape.radius + std::abs(z.z) * shape.length / 2;
    case ShapeKind::cylinder:
      return std::abs(z.z) * shape.length / 2 + std::hypot(z.x, z.y) * shape.radius;
    case ShapeKind::box:
    case ShapeKind::mesh:
      break;
  }
  return (std::abs(z.x) * shape.size.x + std::abs(z.y) * shape.size.y + std::abs(z.z) * shape.size.z) / 2;
}

Camera::Camera(Setup setup, const description::Scene& scene)
    : setup_(std::move(setup)), scene_(&scene), random_(setup_.seed) {
  for (const description::Camera& camera : scene.cameras)
    if (camera.name == setup_.name) view_ = &camera;
}

bool Camera::sees(const Vec3& p, const Pose& eye) const {
  if (setup_.robot.empty())
    return p.x >= view_->lower.x && p.x <= view_->upper.x && p.y >= view_->lower.y && p.y <= view_->upper.y &&
           p.z >= view_->lower.z && p.z <= view_->upper.z;
  const Vec3 from_eye = inverse(eye) * p;
  return norm(from_eye) <= setup_.reach &&
         std::atan2(std::hypot(from_eye.x, from_eye.y), from_eye.z) <= setup_.view;
}

int Camera::nearest(const hardware::WorldState& world, const Pose& eye) const {
  int best = -1;
  double best_distance = 1e300;
  for (std::size_t i = 0; i < world.parts.size(); ++i) {
    const hardware::PartState& part = world.parts[i];
    const Vec3& p = part.pose.position;
    const double distance = norm(p - eye.position);
    if (!part.in_world || part.held_by >= 0 || !sees(p, eye) || distance >= best_distance) continue;
    best = static_cast<int>(i);
    best_distance = distance;
  }
  return best;
}

Pose Camera::grasp_of(const description::Part& part, const Pose& at) {
  Pose out{at.position, from_rpy(std::numbers::pi, 0, 0)};
  out.position.z += height_above_origin(part.shape, at.rotation);
  if (!setup_.noise) return out;
  const auto within = [&](double most) {
    return most * (2 * (static_cast<double>(random_() >> 11) * 0x1p-53) - 1);
  };
  constexpr double kMillimetres = 2e-3, kRadians = 2 * std::numbers::pi / 180;
  out.position = out.position + Vec3{within(kMillimetres), within(kMillimetres), within(kMillimetres)};
  out.rotation = out.rotation * from_rpy(within(kRadians), within(kRadians), within(kRadians));
  return out;
}

bool Camera::tick(const hardware::WorldState& world, data::DataStore& store, const Pose& tool0) {
  const data::Value* request = store.find(setup_.request);
  const bool carried = !setup_.robot.empty();
  if ((!view_ && !carried) || !request || !request->as_boolean() || !*request->as_boolean()) return false;
  const int part = nearest(world, carried ? tool0 * setup_.mount : Pose{view_->eye, {}});
  if (part < 0) return false;  // no part in view: try again next tick
  const auto i = static_cast<std::size_t>(part);
  const std::string who = "camera " + setup_.name;
  store.set(setup_.point, data::Point{grasp_of(scene_->parts[i], world.parts[i].pose), false}, who);
  store.set(setup_.request, false, who);
  if (!setup_.done.empty()) store.set(setup_.done, true, who);
  return true;
}

}  // namespace polyarm::cell
