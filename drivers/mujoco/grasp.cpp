#include "drivers/mujoco/grasp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace polyarm::drivers {

using description::Shape;
using description::ShapeKind;

namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFacing = 0.9397;  // cosine of 20 degrees

/// The cup on a flat face: `n` is the outward normal, `height` the position of the face along it, `inside`
/// tests whether a point is on the face.
template <typename Inside>
double on_face(const Vec3& lip, const Vec3& axis, const Vec3& n, double height, Inside inside) {
  if (-dot(axis, n) < kFacing) return kInfinity;
  const double distance = dot(lip, n) - height;
  const Vec3 foot = lip - distance * n;
  return inside(foot) ? distance : kInfinity;
}
}  // namespace

double cup_distance(const Shape& shape, const Pose& pose, const Vec3& lip_world,
                    const Vec3& axis_world) noexcept {
  const Pose at = inverse(pose * shape.pose);
  const Vec3 lip = at * lip_world, axis = at.rotation * axis_world;
  double best = kInfinity;
  const auto better = [&](double d) {
    if (std::abs(d) < std::abs(best)) best = d;
  };
  if (shape.kind == ShapeKind::mesh) return kInfinity;
  if (shape.kind == ShapeKind::box) {
    const double half[3] = {shape.size.x / 2, shape.size.y / 2, shape.size.z / 2};
    for (int k = 0; k < 3; ++k)
      for (const double sign : {1.0, -1.0}) {
        const Vec3 n{k == 0 ? sign : 0, k == 1 ? sign : 0, k == 2 ? sign : 0};
        better(on_face(lip, axis, n, half[k], [&](const Vec3& p) {
          return std::abs(p.x) <= half[0] + 1e-9 && std::abs(p.y) <= half[1] + 1e-9 &&
                 std::abs(p.z) <= half[2] + 1e-9;
        }));
      }
    return best;
  }
  if (shape.kind == ShapeKind::sphere) {
    const double r = norm(lip);
    if (r > 1e-9 && -dot(axis, (1 / r) * lip) >= kFacing) return r - shape.radius;
    return kInfinity;
  }
  for (const double sign : {1.0, -1.0})
    if (shape.kind == ShapeKind::cylinder)
      better(on_face(lip, axis, {0, 0, sign}, shape.length / 2,
                     [&](const Vec3& p) { return std::hypot(p.x, p.y) <= shape.radius; }));
  const double r = std::hypot(lip.x, lip.y);
  if (r > 1e-9 && std::abs(lip.z) <= shape.length / 2 && -(axis.x * lip.x + axis.y * lip.y) / r >= kFacing)
    better(r - shape.radius);
  return best;
}

namespace {
/// Where the line from `from` along `way` meets the triangle from outside, within 20 degrees of its normal;
/// infinity if it does not. Source: Möller and Trumbore 1997.
double meets(const Vec3& from, const Vec3& way, const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  const Vec3 ab = b - a, ac = c - a, normal = cross(ab, ac), to = from - a;
  const double facing = -dot(way, normal);
  if (!(facing >= kFacing * norm(normal)) || !(facing > 0)) return kInfinity;
  const Vec3 turn = cross(way, to);
  const double u = -dot(ac, turn) / facing, v = dot(ab, turn) / facing;
  if (u < -1e-9 || v < -1e-9 || u + v > 1 + 1e-9) return kInfinity;
  return dot(to, normal) / facing;
}
}  // namespace

double cup_distance(const ModelView& view, std::size_t i, const Pose& pose, const Vec3& lip_world,
                    const Vec3& axis_world) noexcept {
  const mjModel* m = view.m();
  double best = kInfinity;
  for (int k = 0; k < view.twin_pieces[i]; ++k) {
    const int geom = view.twin_geom[i] + k, mesh = m->geom_dataid[geom];
    if (mesh < 0) continue;
    const Pose at = inverse(pose * Pose{vec3(m->geom_pos + 3 * geom), quaternion(m->geom_quat + 4 * geom)});
    const Vec3 lip = at * lip_world, axis = at.rotation * axis_world;
    if (norm(lip) > m->geom_rbound[geom] + 0.05) continue;
    const float* corners = m->mesh_vert + 3 * m->mesh_vertadr[mesh];
    const auto corner = [&](int index) {
      return Vec3{corners[3 * index], corners[3 * index + 1], corners[3 * index + 2]};
    };
    const int* faces = m->mesh_face + 3 * m->mesh_faceadr[mesh];
    for (int f = 0; f < m->mesh_facenum[mesh]; ++f) {
      const double d =
          meets(lip, axis, corner(faces[3 * f]), corner(faces[3 * f + 1]), corner(faces[3 * f + 2]));
      if (std::abs(d) < std::abs(best)) best = d;
    }
  }
  return best;
}

/// A part that another robot holds is only touched. This cup takes it over in the step after that robot lets
/// go.
void Gripper::take_hold(const ModelView& view, const Pose& tool, Parts& parts,
                        ContactReader& contacts) noexcept {
  const Pose tcp = tool * tool_->tcp;
  const Vec3 axis = tcp.rotation * Vec3{0, 0, 1};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!parts.in_world(i)) continue;
    const bool is_mesh = parts.fact(i).shape.kind == ShapeKind::mesh;
    const double distance = is_mesh ? cup_distance(view, i, parts[i].pose, tcp.position, axis)
                                    : cup_distance(parts.fact(i).shape, parts[i].pose, tcp.position, axis);
    if (!(distance <= tool_->reach && distance >= -2e-3)) continue;
    if (parts[i].robot >= 0) {
      touches_ = true;
      continue;
    }
    held_ = static_cast<int>(i);
    fresh_ = true;
    parts.hold(i, static_cast<int>(robot_), inverse(tool) * parts[i].pose);
    contacts.forgive(robot_);
    return;
  }
}

void Gripper::carry(const Pose& tool, Parts& parts, const Vec3& gravity, const Vec3& contact_force,
                    double timestep) noexcept {
  Parts::Part& part = parts[static_cast<std::size_t>(held_)];
  part.pose = tool * part.grasp;
  if (fresh_) {
    last_position_ = part.pose.position;
    velocity_ = acceleration_ = {};
    fresh_ = false;
  }
  constexpr double kFilter = 0.005;  // s
  const double share = timestep / (timestep + kFilter);
  const Vec3 v = (1 / timestep) * (part.pose.position - last_position_);
  const Vec3 smooth = velocity_ + share * (v - velocity_);
  acceleration_ = acceleration_ + share * ((1 / timestep) * (smooth - velocity_) - acceleration_);
  velocity_ = smooth;
  last_position_ = part.pose.position;
  part.velocity = {velocity_.x, velocity_.y, velocity_.z, 0, 0, 0};
  part.speed = norm(velocity_);
  // The force that the cup must apply for the present motion of the part.
  const double mass = parts.fact(static_cast<std::size_t>(held_)).mass;
  const Vec3 pull = mass * (acceleration_ - gravity) - contact_force;
  // Pressing the part against the cup does not loosen it, and increases the sideways force that it can carry.
  const Vec3 axis = tool.rotation * (tool_->tcp.rotation * Vec3{0, 0, 1});
  const double away = -dot(pull, axis), sideways = norm(pull + away * axis);
  const bool holds =
      away > 0 ? std::hypot(away, sideways) <= tool_->holding_force : sideways <= tool_->holding_force - away;
  if (holds) return;
  parts.release_now(static_cast<std::size_t>(held_));
  pulled_off_ = true;
  held_ = -1;
}

void Gripper::update(ModelView& view, Parts& parts, ContactReader& contacts, const Vec3& gravity,
                     double timestep) noexcept {
  if (!tool_) return;
  if (parallel()) {
    const int gripped = on_ ? contacts.between_fingers(robot_) : -1;
    if (gripped != held_) {
      if (held_ >= 0 && parts[static_cast<std::size_t>(held_)].robot == static_cast<int>(robot_))
        parts[static_cast<std::size_t>(held_)].robot = -1;  // else another gripper has taken it over
      if (gripped >= 0) {
        parts.wake_neighbours(static_cast<std::size_t>(gripped));
        parts[static_cast<std::size_t>(gripped)].robot = static_cast<int>(robot_);
        contacts.forgive(robot_);
      }
      held_ = gripped;
    }
    return;
  }
  if (!suction()) return;
  touches_ = false;
  level_ += ((on_ ? 1.0 : 0.0) - level_) * timestep / kLag;
  const Pose tool = body_pose(view.d(), view.robots[robot_].tool_body);
  if (level_ < 0.5) pulled_off_ = false;
  if (held_ >= 0 && level_ < 0.5) {
    parts.release_now(static_cast<std::size_t>(held_));
    held_ = -1;
    return;
  }
  if (held_ < 0 && level_ >= 0.5 && !pulled_off_) take_hold(view, tool, parts, contacts);
  if (held_ >= 0) carry(tool, parts, gravity, contacts.force_on_held(robot_), timestep);
}

void Gripper::push(const ModelView& view) const noexcept {
  if (!parallel()) return;
  const ModelView::Robot& r = view.robots[robot_];
  mjData* d = view.d();
  constexpr double kDamping =
      400;  // N s/m: reaches its speed immediately, pushes with the full force against a part
  for (std::size_t side = 0; side < 2; ++side) {
    const double wanted = (on_ ? 1 : -1) * tool_->closing_speed;
    const double force =
        std::clamp(kDamping * (wanted - d->qvel[r.finger_dof[side]]), -tool_->grip_force, tool_->grip_force);
    d->qfrc_applied[r.finger_dof[side]] = force + d->qfrc_bias[r.finger_dof[side]];
  }
}

double Gripper::width(const ModelView& view) const noexcept {
  if (!parallel()) return 0;
  const ModelView::Robot& r = view.robots[robot_];
  return tool_->stroke - view.d()->qpos[r.finger_qpos[0]] - view.d()->qpos[r.finger_qpos[1]];
}

bool Gripper::moving(const ModelView& view) const noexcept {
  if (!parallel()) return suction() && std::abs(level_ - (on_ ? 1.0 : 0.0)) > 0.05;
  const ModelView::Robot& r = view.robots[robot_];
  return std::abs(view.d()->qvel[r.finger_dof[0]]) > 1e-3 || std::abs(view.d()->qvel[r.finger_dof[1]]) > 1e-3;
}

}  // namespace polyarm::drivers
