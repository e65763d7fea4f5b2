#include "drivers/mujoco/parts.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::drivers {

using description::Shape;
using description::ShapeKind;

namespace {
double radius_of(const Shape& s) {
  switch (s.kind) {
    case ShapeKind::box:
      return norm(s.size) / 2;
    case ShapeKind::cylinder:
      return std::hypot(s.radius, s.length / 2);
    case ShapeKind::capsule:
      return s.radius + s.length / 2;
    case ShapeKind::mesh: {
      double out = 0;
      for (const auto& piece : s.pieces)
        for (const Vec3& corner : piece) out = std::max(out, norm(corner));
      return out;
    }
    default:
      return s.radius;
  }
}
}  // namespace

Parts::Parts(const description::Scene* scene) : scene_(scene) {
  if (!scene) return;
  for (const description::Part& fact : scene->parts) {
    Part part;
    part.radius = radius_of(fact.shape);
    if (fact.feeder.empty()) {
      part.mode = Mode::awake;  // settles from its position in the scene
      part.pose = fact.start;
      part.entered = true;
      part.still_for = kSleepAfter - 0.1;
    }
    parts_.push_back(part);
  }
}

std::size_t Parts::awake() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(parts_.begin(), parts_.end(), [](const Part& p) { return p.mode == Mode::awake; }));
}

void Parts::wake(std::size_t i) noexcept {
  if (parts_[i].mode != Mode::asleep) return;
  parts_[i].mode = Mode::awake;
  parts_[i].velocity.fill(0);
  parts_[i].still_for = 0;
  changed_ = true;
}

void Parts::put_to_sleep(std::size_t i) noexcept {
  parts_[i].mode = Mode::asleep;
  parts_[i].velocity.fill(0);
  parts_[i].speed = 0;
  changed_ = true;
}

void Parts::present(std::size_t i, const Pose& at) noexcept {
  Part& part = parts_[i];
  part.mode = Mode::awake;
  part.entered = true;
  part.pose = at;
  part.velocity.fill(0);
  part.still_for = 0;
  part.mover = -1;
  changed_ = true;
}

void Parts::take_away(std::size_t i) noexcept {
  wake_neighbours(i);
  parts_[i].mode = Mode::taken;
  parts_[i].speed = 0;
  changed_ = true;
}

void Parts::hold(std::size_t i, int robot, const Pose& grasp) noexcept {
  wake_neighbours(i);
  Part& part = parts_[i];
  part.mode = Mode::held;
  part.robot = robot;
  part.grasp = grasp;
  part.mover = -1;
  part.velocity.fill(0);
  changed_ = true;
}

void Parts::release_now(std::size_t i) noexcept {
  Part& part = parts_[i];
  part.mode = Mode::awake;
  part.robot = -1;
  part.still_for = 0;
  changed_ = true;
}

void Parts::wake_neighbours(std::size_t i) noexcept {
  constexpr double kTouching = 2e-3, kHigher = 1e-3;
  const Bounds own = bounds(i);
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    if (k == i || parts_[k].mode != Mode::asleep) continue;
    const Bounds other = bounds(k);
    if (!other.near(own, kTouching)) continue;
    // The origin of a mesh may be anywhere: what lies in a tray is lower than the tray's rim.
    if (other.lower.z > own.lower.z + kHigher ||
        parts_[k].pose.position.z > parts_[i].pose.position.z + kHigher)
      wake(k);
  }
}

void Parts::pull(const ModelView& view, double timestep) noexcept {
  const mjData* d = view.d();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    if (part.wake_requested) wake(i);
    part.wake_requested = false;
    if (part.mode != Mode::awake || part.slot < 0 || static_cast<std::size_t>(part.slot) >= view.slots)
      continue;
    const ModelView::Slot& slot = view.slot[static_cast<std::size_t>(part.slot)];
    part.pose = {vec3(d->qpos + slot.qpos), normalized(quaternion(d->qpos + slot.qpos + 3))};
    std::copy_n(d->qvel + slot.dof, 6, part.velocity.begin());
    const double turning = std::hypot(part.velocity[3], part.velocity[4], part.velocity[5]);
    part.speed = std::hypot(part.velocity[0], part.velocity[1], part.velocity[2]) + turning * part.radius;
    part.still_for = part.speed < kStill && part.robot < 0 ? part.still_for + timestep : 0;
    if (part.still_for >= kSleepAfter) put_to_sleep(i);
  }
}

void Parts::place_twin(const ModelView& view, std::size_t i) const noexcept {
  mjData* d = view.d();
  const bool here = parts_[i].mode == Mode::asleep;
  put(d->mocap_pos + 3 * view.twin_mocap[i],
      here ? parts_[i].pose.position : Vec3{0, 0, -50.0 - static_cast<double>(i)});
  put(d->mocap_quat + 4 * view.twin_mocap[i], here ? parts_[i].pose.rotation : Quaternion{});
}

void Parts::lay_out(const ModelSet& models, ModelView& view) noexcept {
  mjModel* m = view.m();
  mjData* d = view.d();
  std::size_t next = 0;
  for (std::size_t r = 0; r < view.robots.size(); ++r) models.shape_held(view, r, -1, {});
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    const bool asleep = part.mode == Mode::asleep;
    view.let_touch(view.twin_geom[i], view.twin_pieces[i], i, asleep);
    place_twin(view, i);
    part.slot = -1;
    if (part.mode == Mode::held)
      models.shape_held(view, static_cast<std::size_t>(part.robot), static_cast<int>(i), part.grasp);
    if (part.mode != Mode::awake || next >= view.slots) continue;
    const ModelView::Slot& slot = view.slot[next];
    models.shape_slot(view, next, i);
    view.let_touch(slot.geom, view.slot_geoms, i, true);
    put(d->qpos + slot.qpos, part.pose.position);
    put(d->qpos + slot.qpos + 3, part.pose.rotation);
    std::copy(part.velocity.begin(), part.velocity.end(), d->qvel + slot.dof);
    std::fill_n(d->qacc_warmstart + slot.dof, 6, 0.0);
    std::fill_n(d->xfrc_applied + 6 * slot.body, 6, 0.0);
    part.slot = static_cast<int>(next++);
  }
  for (; next < view.slots; ++next) {  // empty slots are placed in the air and touch nothing
    const ModelView::Slot& slot = view.slot[next];
    view.let_touch(slot.geom, view.slot_geoms, 0, false);
    put(d->qpos + slot.qpos, Vec3{0, 0, 50.0 + static_cast<double>(next)});
    put(d->qpos + slot.qpos + 3, Quaternion{});
    std::fill_n(d->qvel + slot.dof, 6, 0.0);
    std::fill_n(d->qacc_warmstart + slot.dof, 6, 0.0);
    const double mass = m->body_mass[slot.body];
    for (int k = 0; k < 3; ++k) d->xfrc_applied[6 * slot.body + k] = -mass * m->opt.gravity[k];
    for (int k = 3; k < 6; ++k) d->xfrc_applied[6 * slot.body + k] = 0;
  }
  changed_ = false;
}

}  // namespace polyarm::drivers
