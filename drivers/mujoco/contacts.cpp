#include "drivers/mujoco/contacts.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::drivers {

namespace {
using Kind = Owner::Kind;
bool stiff(Kind kind) {
  return kind == Kind::link || kind == Kind::tool;
}

/// The speed of a geometry's body, m/s plus rad/s.
double body_speed(const mjModel* m, const mjData* d, int geom) {
  const mjtNum* v = d->cvel + 6 * m->geom_bodyid[geom];
  return std::sqrt(mju_dot(v, v, 6));
}

bool is_on_floor(const Owner& robot, const Owner& floor) {
  return floor.kind == Kind::floor && robot.kind == Kind::link && robot.stands;
}
}  // namespace

ContactReader::ContactReader(std::size_t robots, std::size_t parts)
    : robots_(robots),
      gripped_(robots, -1),
      touched_(robots, {-1, -1}),
      held_force_(robots),
      part_name_(parts, -1) {}

void ContactReader::forgive(std::size_t robot) noexcept {
  robots_[robot].since = step_;
  for (Forgiven& f : robots_[robot].list) f = {};
}

int ContactReader::name_of(const Owner& owner, const Parts& parts) const noexcept {
  if (owner.kind != Kind::held) return owner.name;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (parts[i].mode == Parts::Mode::held && parts[i].robot == owner.index)
      return part_name_[i] >= 0 ? part_name_[i] : owner.name;
  return owner.name;
}

bool ContactReader::held_may_touch(std::size_t robot, const Owner& other, const mjContact& c,
                                   bool other_second) noexcept {
  Robot& r = robots_[robot];
  Forgiven* free = nullptr;
  for (Forgiven& f : r.list) {
    if (f.name == other.name) {
      if (step_ - f.last <= kClearSteps) {
        f.last = step_;
        return true;
      }
      f.name = -1;
    }
    if (f.name < 0) free = &f;
  }
  if (step_ - r.since <= kForgiveSteps && free) {
    *free = {other.name, step_};
    return true;
  }
  // The normal points from the first geometry to the second; up means: from the support to the part.
  const double up = other_second ? -c.frame[2] : c.frame[2];
  return up > kPlacingNormal && -c.dist < kPlacingDepth;
}

bool ContactReader::is_finding(const Owner& a, const Owner& b, const mjContact& c,
                               const Parts& parts) noexcept {
  if (stiff(a.kind) || stiff(b.kind)) return true;
  for (const bool swapped : {false, true}) {
    const Owner& one = swapped ? b : a;
    const Owner& other = swapped ? a : b;
    if (one.kind == Kind::held)
      return !held_may_touch(static_cast<std::size_t>(one.index), other, c, !swapped);
    if (one.kind == Kind::finger && other.kind != Kind::part && other.kind != Kind::finger) return true;
    if (one.kind == Kind::part && parts[static_cast<std::size_t>(one.index)].robot >= 0 &&
        other.kind != Kind::finger)
      return !held_may_touch(static_cast<std::size_t>(parts[static_cast<std::size_t>(one.index)].robot),
                             other, c, !swapped);
  }
  return false;
}

/// The finding of a touching pair; null if newer findings have overwritten it.
hardware::Contact* ContactReader::finding_of(const Pair& pair, hardware::WorldState& out) noexcept {
  constexpr int kMost = hardware::WorldState::kMaxFindings;
  if (pair.finding < 0 || pair.finding + kMost < out.finding_count) return nullptr;
  return &out.findings[static_cast<std::size_t>(pair.finding % kMost)];
}

int ContactReader::add(const hardware::Contact& contact, hardware::WorldState& out) noexcept {
  const int number = out.finding_count++;
  out.findings[static_cast<std::size_t>(number % hardware::WorldState::kMaxFindings)] = contact;
  return number;
}

void ContactReader::note(const Owner& a, const Owner& b, double depth, const Vec3& at, Nanoseconds now,
                         hardware::WorldState& out) noexcept {
  Pair* free = nullptr;
  for (Pair& pair : pairs_) {
    if (pair.finding >= 0 && pair.a == a.name && pair.b == b.name) {
      const bool deepest = pair.last != step_ || depth > pair.depth;
      pair.last = step_;
      if (!deepest) return;
      pair.depth = depth;
      if (hardware::Contact* found = finding_of(pair, out)) {
        found->depth = std::max(found->depth, depth);
        found->position = at;
      }
      return;
    }
    if (!free && pair.finding < 0) free = &pair;
  }
  const int number = add({now, a.name, b.name, depth, at, true}, out);
  if (free) *free = {a.name, b.name, step_, number, depth};
}

/// Ends the findings of pairs that have separated. Call it after all contacts of a step.
void ContactReader::drop_clear_pairs(hardware::WorldState& out) noexcept {
  for (Pair& pair : pairs_) {
    if (pair.finding < 0 || step_ - pair.last <= kClearSteps) continue;
    if (hardware::Contact* found = finding_of(pair, out)) found->now = false;
    pair = {};
  }
}

void ContactReader::wake(const Owner& sleeper, const Owner& other, const mjContact& c, double other_speed,
                         Parts& parts) const noexcept {
  if (sleeper.kind != Kind::part) return;
  Parts::Part& part = parts[static_cast<std::size_t>(sleeper.index)];
  if (part.mode != Parts::Mode::asleep) return;
  const bool robot = stiff(other.kind) || other.kind == Kind::finger || other.kind == Kind::held;
  bool moves = robot && (other_speed > kWakeSpeed || -c.dist > kWakeDepth);
  if (other.kind == Kind::part) {
    const Parts::Part& pusher = parts[static_cast<std::size_t>(other.index)];
    moves = pusher.mode == Parts::Mode::awake && (pusher.speed > kWakeSpeed || -c.dist > kWakeDepth);
  }
  part.wake_requested |= moves;
}

void ContactReader::rest(const Owner& owner, const Owner& other, const mjContact& c,
                         Parts& parts) const noexcept {
  if (owner.kind != Kind::part || other.kind != Kind::mover || std::abs(c.frame[2]) < kPlacingNormal) return;
  parts[static_cast<std::size_t>(owner.index)].mover = other.index;
}

void ContactReader::read(const ModelView& view, Parts& parts, Nanoseconds now,
                         hardware::WorldState& out) noexcept {
  ++step_;
  const mjModel* m = view.m();
  const mjData* d = view.d();
  out.contacts = d->ncon;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].mode == Parts::Mode::awake) parts[i].mover = -1;
    part_name_[i] = view.owner[static_cast<std::size_t>(view.twin_geom[i])].name;
  }
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    held_force_[r] = {};
    touched_[r] = {-1, -1};
    gripped_[r] = -1;
  }
  for (int i = 0; i < d->ncon; ++i) {
    const mjContact& c = d->contact[i];
    const Owner& a = view.owner[static_cast<std::size_t>(c.geom1)];
    const Owner& b = view.owner[static_cast<std::size_t>(c.geom2)];
    if (c.dist >= 0) continue;
    wake(a, b, c, body_speed(m, d, c.geom2), parts);
    wake(b, a, c, body_speed(m, d, c.geom1), parts);
    rest(a, b, c, parts);
    rest(b, a, c, parts);
    for (const bool swapped : {false, true}) {
      const Owner& one = swapped ? b : a;
      const Owner& other = swapped ? a : b;
      const int geom = swapped ? c.geom2 : c.geom1;
      if (one.kind == Kind::finger && other.kind == Kind::part) {
        auto& touched = touched_[static_cast<std::size_t>(one.index)];
        // The two fingers are two bodies of the tool; the one with the lower number is the first.
        const bool first =
            m->geom_bodyid[geom] ==
            m->jnt_bodyid[m->dof_jntid[view.robots[static_cast<std::size_t>(one.index)].finger_dof[0]]];
        touched[first ? 0 : 1] = other.index;
      }
      if (one.kind == Kind::held) {
        mjtNum force[6];
        mj_contactForce(m, d, i, force);
        const double sign = swapped ? 1 : -1;  // the force acts on the second geometry along the normal
        held_force_[static_cast<std::size_t>(one.index)] =
            held_force_[static_cast<std::size_t>(one.index)] + (sign * force[0]) * vec3(c.frame);
      }
    }
    if (is_on_floor(a, b) || is_on_floor(b, a)) continue;
    if (!is_finding(a, b, c, parts)) continue;
    Owner first = a, second = b;
    first.name = name_of(a, parts);
    second.name = name_of(b, parts);
    const bool robot_second = stiff(second.kind) && !stiff(first.kind);
    note(robot_second ? second : first, robot_second ? first : second, -c.dist, vec3(c.pos), now, out);
  }
  drop_clear_pairs(out);
  for (std::size_t r = 0; r < robots_.size(); ++r)
    if (touched_[r][0] >= 0 && touched_[r][0] == touched_[r][1]) gripped_[r] = touched_[r][0];
}

}  // namespace polyarm::drivers
