#include "drivers/mujoco/machines.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::drivers {

namespace {
int count(double value) {
  return std::isfinite(value) ? static_cast<int>(std::clamp(value, 0.0, 1e6)) : 0;
}

int kind_number(const description::Scene& scene, std::size_t part) {
  const auto found = std::find(scene.kinds.begin(), scene.kinds.end(), scene.parts[part].kind);
  return static_cast<int>(found - scene.kinds.begin()) + 1;
}
}  // namespace

Machines::Machines(const description::Scene* scene, std::vector<hardware::InterfaceDescription>& states,
                   std::vector<hardware::InterfaceDescription>& commands)
    : scene_(scene) {
  if (!scene) return;
  const auto state = [&](const std::string& name, double initial = 0) {
    states.push_back({"scene/" + name, initial});
    return static_cast<int>(states.size()) - 1;
  };
  const auto command = [&](const std::string& name) {
    commands.push_back({"scene/" + name});
    return static_cast<int>(commands.size()) - 1;
  };
  for (const description::Feeder& f : scene->feeders) {
    const auto parts = std::count_if(scene->parts.begin(), scene->parts.end(),
                                     [&](const description::Part& part) { return part.feeder == f.name; });
    Feeder feeder{command(f.name + "/feed"),
                  state(f.name + "/presented"),
                  state(f.name + "/remaining", static_cast<double>(parts)),
                  state(f.name + "/present"),
                  state(f.name + "/count"),
                  state(f.name + "/kind"),
                  {},
                  0,
                  0,
                  f.pose,
                  &f};
    for (std::size_t i = 0; i < scene->parts.size(); ++i)
      if (scene->parts[i].feeder == f.name) feeder.parts.push_back(static_cast<int>(i));
    feeders_.push_back(std::move(feeder));
  }
  for (const description::Outfeed& o : scene->outfeeds)
    regions_.push_back({command(o.name + "/take"),
                        state(o.name + "/present"),
                        state(o.name + "/taken"),
                        {o.lower, o.upper},
                        0,
                        0,
                        true});
  for (const description::PresenceSensor& s : scene->sensors)
    regions_.push_back({-1, state(s.name + "/present"), -1, {s.lower, s.upper}});
  for (const description::Belt& b : scene->belts) {
    Belt belt{command(b.name + "/speed"), state(b.name + "/position"), state(b.name + "/speed"),
              state(b.name + "/parts"),   state(b.name + "/latch"),    &b};
    for (const description::Fixture& f : scene->fixtures)
      if (f.belt == b.name) belt.surface = bounds_of(f.shapes.front(), f.pose);
    belt.before.assign(scene->parts.size(), NAN);
    belts_.push_back(std::move(belt));
  }
  for (const description::Mover& m : scene->movers) {
    Mover mover{command(m.name + "/position"), state(m.name + "/position"), 0, 0, 0, &m, {}};
    for (const description::Fixture& f : scene->fixtures)
      if (f.mover == m.name) mover.fixtures.push_back(&f);
    movers_.push_back(std::move(mover));
  }
}

void Machines::command(std::span<const double> commands) noexcept {
  for (Feeder& f : feeders_)
    f.asked = std::max(f.asked, count(commands[static_cast<std::size_t>(f.command)]));
  for (Region& r : regions_)
    if (r.command >= 0) r.asked = std::max(r.asked, count(commands[static_cast<std::size_t>(r.command)]));
  for (Mover& m : movers_)
    if (const double target = commands[static_cast<std::size_t>(m.command)]; std::isfinite(target))
      m.target = std::clamp(target, m.fact->lower, m.fact->upper);
  for (Belt& b : belts_)
    if (const double target = commands[static_cast<std::size_t>(b.command)]; std::isfinite(target))
      b.target = std::clamp(target, -b.fact->speed, b.fact->speed);
}

/// Along the belt, or about the turntable; NaN if it is not above it.
double Machines::place_on(const Belt& belt, const Vec3& position) noexcept {
  constexpr double kHighest = 0.5;  // m above the surface
  const Vec3 p = inverse(belt.fact->pose) * position;
  if (p.z < 0 || p.z > kHighest) return NAN;
  if (!belt.fact->turns) return std::abs(p.y) <= belt.fact->half_width ? p.x : NAN;
  return std::hypot(p.x, p.y) <= belt.fact->half_width ? std::atan2(p.y, p.x) : NAN;
}

/// The belt has moved at its velocity in this step; its barrier counts the parts whose middle passes it.
void Machines::advance(Belt& belt, Parts& parts, double dt) noexcept {
  belt.at += belt.velocity * dt;
  const double most = belt.fact->acceleration * dt;
  belt.velocity += std::clamp(belt.target - belt.velocity, -most, most);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool there = parts.in_world(i) && parts[i].mode != Parts::Mode::held;
    const double place = there ? place_on(belt, parts[i].pose.position) : NAN;
    const double before = std::exchange(belt.before[i], place), from = belt.fact->sensor_at;
    const bool wrapped = std::abs(place - before) > 1;  // a turntable, from pi to -pi
    if (before < from && place >= from && !wrapped) {
      ++belt.seen;
      belt.latch = belt.at - (place - from);
    }
    if (belt.velocity != 0 && there && parts[i].mode == Parts::Mode::asleep &&
        belt.surface.near(parts.bounds(i), 1e-3))
      parts.wake(i);
  }
}

void Machines::advance(std::size_t index, Mover& mover, ModelView& view, Parts& parts, double dt) noexcept {
  if (!mover.moves()) return;
  // The highest speed from which it can still stop at the target with the mover's acceleration.
  const double left = mover.target - mover.at, a = mover.fact->acceleration;
  const double stoppable = std::sqrt(2 * a * std::abs(left));
  const double wanted = std::copysign(std::min(mover.fact->speed, stoppable), left);
  mover.velocity += std::clamp(wanted - mover.velocity, -a * dt, a * dt);
  double moved = mover.velocity * dt;
  if (std::abs(left) <= std::max(std::abs(moved), 1e-9)) {
    moved = left;
    mover.velocity = 0;
  }
  mover.at = moved == left ? mover.target : mover.at + moved;
  const Vec3 shift = moved * mover.fact->axis;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    Parts::Part& part = parts[i];
    if (!parts.in_world(i) || part.mode == Parts::Mode::held) continue;
    if (part.mover == static_cast<int>(index)) {
      part.pose.position = part.pose.position + shift;
      if (part.mode == Parts::Mode::asleep)
        parts.place_twin(view, i);
      else if (part.slot >= 0)
        put(view.d()->qpos + view.slot[static_cast<std::size_t>(part.slot)].qpos, part.pose.position);
      continue;
    }
    if (part.mode != Parts::Mode::asleep) continue;
    for (const description::Fixture* fixture : mover.fixtures)
      for (const description::Shape& shape : fixture->shapes)
        if (bounds_of(shape, Pose{mover.at * mover.fact->axis, {}} * fixture->pose)
                .near(parts.bounds(i), 1e-3))
          parts.wake(i);
  }
}

void Machines::lay_out(ModelView& view) const noexcept {
  for (std::size_t k = 0; k < movers_.size(); ++k)
    put(view.d()->mocap_pos + 3 * view.mover_mocap[k], movers_[k].at * movers_[k].fact->axis);
  for (std::size_t k = 0; k < belts_.size(); ++k) {
    view.d()->qpos[view.belt_qpos[k]] = 0;
    view.d()->qvel[view.belt_dof[k]] = belts_[k].velocity;
  }
}

/// True if no part is at the place of the next one: two parts in one place would push each other away.
bool Machines::is_free(const Feeder& feeder, const Parts& parts) const noexcept {
  constexpr double kOverlap = -1e-3;
  const auto next = static_cast<std::size_t>(feeder.parts[static_cast<std::size_t>(feeder.presented)]);
  const Bounds there = bounds_of(scene_->parts[next].shape, place_of_next(feeder));
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (parts.in_world(i) && there.near(parts.bounds(i), kOverlap)) return false;
  return true;
}

Pose Machines::place_of_next(const Feeder& feeder) const noexcept {
  return feeder.fact->place(static_cast<std::size_t>(feeder.presented));
}

bool Machines::step(ModelView& view, Parts& parts, double timestep) noexcept {
  bool moves = moving();
  for (Belt& belt : belts_) {
    advance(belt, parts, timestep);
    moves = moves || belt.velocity != 0;
  }
  for (std::size_t k = 0; k < movers_.size(); ++k) advance(k, movers_[k], view, parts, timestep);
  lay_out(view);
  for (Feeder& f : feeders_)
    if (f.asked > f.presented && f.presented < static_cast<int>(f.parts.size()) && is_free(f, parts)) {
      const Pose place = place_of_next(f);
      parts.present(static_cast<std::size_t>(f.parts[static_cast<std::size_t>(f.presented++)]), place);
    }
  for (Region& r : regions_)
    for (std::size_t i = 0; r.command >= 0 && r.asked > r.taken && i < parts.size(); ++i)
      if (parts[i].mode == Parts::Mode::asleep && r.bounds.contains(parts[i].pose.position)) {
        parts.take_away(i);
        ++r.taken;
      }
  return moves;
}

void Machines::read(const Parts& parts, std::span<double> states) const noexcept {
  const auto set = [&](int index, double value) {
    if (index >= 0) states[static_cast<std::size_t>(index)] = value;
  };
  for (const Feeder& f : feeders_) {
    int here = 0;
    for (int k = 0; k < f.presented; ++k) {
      const auto i = static_cast<std::size_t>(f.parts[static_cast<std::size_t>(k)]);
      if (parts.in_world(i) && parts[i].robot < 0 && norm(parts[i].pose.position - f.pose.position) < 0.02)
        ++here;
    }
    set(f.presented_state, f.presented);
    set(f.remaining_state, static_cast<double>(f.parts.size()) - f.presented);
    set(f.present_state, here > 0 ? 1 : 0);
    set(f.count_state, here);
    set(f.kind_state, f.presented > 0
                          ? kind_number(*scene_, static_cast<std::size_t>(
                                                     f.parts[static_cast<std::size_t>(f.presented - 1)]))
                          : 0);
  }
  for (const Region& r : regions_) {
    bool present = false;
    for (std::size_t i = 0; i < parts.size(); ++i)
      present |= parts.in_world(i) && r.bounds.contains(parts[i].pose.position) &&
                 (!r.needs_rest || parts[i].mode == Parts::Mode::asleep);
    set(r.present_state, present ? 1 : 0);
    set(r.taken_state, r.taken);
  }
  for (const Mover& m : movers_) set(m.state, m.at);
  for (const Belt& b : belts_) {
    set(b.position_state, b.at);
    set(b.speed_state, b.velocity);
    set(b.parts_state, b.seen);
    set(b.latch_state, b.latch);
  }
}

bool Machines::moving() const noexcept {
  return std::any_of(movers_.begin(), movers_.end(), [](const Mover& m) { return m.moves(); });
}

}  // namespace polyarm::drivers
