#include "drivers/mock/mock_world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "polyarm/description/bodies.hpp"
#include "polyarm/description/shape_bounds.hpp"

namespace polyarm::drivers {

namespace {
constexpr double kGripTime = 0.1, kGripReach = 0.015;
constexpr double kNothing = -std::numeric_limits<double>::infinity();

bool on(std::span<const double> asked, int index) {
  return index >= 0 && asked[static_cast<std::size_t>(index)] >= 0.5;
}
int count(std::span<const double> asked, int index) {
  const double value = index < 0 ? 0 : asked[static_cast<std::size_t>(index)];
  return std::isfinite(value) ? static_cast<int>(std::clamp(value, 0.0, 1e6)) : 0;
}
bool inside(const Vec3& p, const Vec3& lower, const Vec3& upper) {
  return p.x >= lower.x && p.x <= upper.x && p.y >= lower.y && p.y <= upper.y && p.z >= lower.z &&
         p.z <= upper.z;
}
double top_of(const description::Shape& shape) {
  switch (shape.kind) {
    case description::ShapeKind::box:
      return shape.size.z / 2;
    case description::ShapeKind::cylinder:
      return shape.length / 2;
    case description::ShapeKind::capsule:
      return shape.length / 2 + shape.radius;
    default:
      return shape.radius;
  }
}
/// True if a vertical line through `p`, in the shape's frame, meets the shape.
bool is_over(const description::Shape& shape, const Vec3& p) {
  if (shape.kind == description::ShapeKind::box)
    return std::abs(p.x) <= shape.size.x / 2 && std::abs(p.y) <= shape.size.y / 2;
  return shape.kind == description::ShapeKind::cylinder && std::hypot(p.x, p.y) <= shape.radius;
}
/// True if a cup at `point` reaches the surface of the shape, from any side.
bool is_near(const description::Shape& shape, const Pose& pose, const Vec3& point) {
  const Vec3 p = inverse(pose * shape.pose) * point;
  const double r = std::hypot(p.x, p.y);
  switch (shape.kind) {
    case description::ShapeKind::box:
      return std::abs(p.x) <= shape.size.x / 2 + kGripReach &&
             std::abs(p.y) <= shape.size.y / 2 + kGripReach && std::abs(p.z) <= shape.size.z / 2 + kGripReach;
    case description::ShapeKind::cylinder:
      return r <= shape.radius + kGripReach && std::abs(p.z) <= shape.length / 2 + kGripReach;
    case description::ShapeKind::capsule:
      return std::hypot(r, std::max(0.0, std::abs(p.z) - shape.length / 2)) <= shape.radius + kGripReach;
    default:
      return norm(p) <= shape.radius + kGripReach;
  }
}
/// Half of the sizes of the rectangle within the underside of an upright shape, m; zero: it lies on a point.
Vec3 half_of_underside(const description::Shape& shape) {
  constexpr double kWithin = 0.9, kOfTheRadius = 0.63;  // not just the edge
  if (shape.kind == description::ShapeKind::box)
    return {kWithin * shape.size.x / 2, kWithin * shape.size.y / 2, 0};
  if (shape.kind == description::ShapeKind::cylinder)
    return {kOfTheRadius * shape.radius, kOfTheRadius * shape.radius, 0};
  return {};
}
bool is_upright(const Quaternion& rotation) {
  return (rotation * Vec3{0, 0, 1}).z > 0.999;
}
}  // namespace

MockWorld::MockWorld(const hardware::ComponentContext& context,
                     std::vector<hardware::InterfaceDescription>& states,
                     std::vector<hardware::InterfaceDescription>& commands) {
  const auto state = [&](const std::string& name, double initial) {
    states.push_back({name, initial});
    return static_cast<int>(states.size()) - 1;
  };
  const auto command = [&](const std::string& name) {
    commands.push_back({name});
    return static_cast<int>(commands.size()) - 1;
  };
  const auto find_state = [&](const std::string& name) {
    for (std::size_t i = 0; i < states.size(); ++i)
      if (states[i].name == name) return static_cast<int>(i);
    return -1;
  };
  for (const hardware::RobotInstance& robot : context.robots) {
    if (!robot.tool || robot.tool->gripper == description::GripperKind::none) continue;
    Arm arm;
    arm.robot = robot.number;
    arm.base = robot.base;
    arm.last = robot.tool->tcp;
    for (int link = robot.model->tool_link();
         robot.model->links[static_cast<std::size_t>(link)].parent_joint >= 0;) {
      const description::Joint& joint = robot.model->joints[static_cast<std::size_t>(
          robot.model->links[static_cast<std::size_t>(link)].parent_joint)];
      Step step{joint.origin, joint.axis, find_state(robot.name + "/" + joint.name + "/position"),
                joint.type == description::JointType::prismatic};
      arm.chain.push_back(step);
      link = joint.parent_link;
    }
    std::reverse(arm.chain.begin(), arm.chain.end());
    const bool suction = robot.tool->gripper == description::GripperKind::suction;
    const std::string tool = robot.name + "/tool/";
    arm.command = command(tool + (suction ? "vacuum" : "grip"));
    arm.level_state = state(tool + (suction ? "vacuum" : "width"), 0);
    arm.present_state = state(tool + "part_present", 0);
    arms_.push_back(std::move(arm));
  }
  if (!context.scene) return;
  scene_ = context.scene;
  state_.parts.resize(scene_->parts.size());
  for (std::size_t i = 0; i < scene_->parts.size(); ++i) {
    const bool here = scene_->parts[i].feeder.empty();
    state_.parts[i].pose = scene_->parts[i].start;
    state_.parts[i].entered = state_.parts[i].in_world = here;
    state_.parts[i].asleep = true;
    const auto kind = std::find(scene_->kinds.begin(), scene_->kinds.end(), scene_->parts[i].kind);
    kinds_.push_back(static_cast<int>(kind - scene_->kinds.begin()) + 1);
  }
  for (const description::Feeder& f : scene_->feeders) {
    const std::string name = "scene/" + f.name + "/";
    const auto parts = std::count_if(scene_->parts.begin(), scene_->parts.end(),
                                     [&](const description::Part& part) { return part.feeder == f.name; });
    Feeder feeder{command(name + "feed"),
                  state(name + "presented", 0),
                  state(name + "remaining", static_cast<double>(parts)),
                  state(name + "present", 0),
                  state(name + "count", 0),
                  state(name + "kind", 0),
                  {},
                  0,
                  f.pose};
    for (std::size_t i = 0; i < scene_->parts.size(); ++i)
      if (scene_->parts[i].feeder == f.name) feeder.parts.push_back(static_cast<int>(i));
    feeders_.push_back(std::move(feeder));
  }
  for (const description::Outfeed& o : scene_->outfeeds)
    regions_.push_back({command("scene/" + o.name + "/take"), state("scene/" + o.name + "/present", 0),
                        state("scene/" + o.name + "/taken", 0), o.lower, o.upper});
  for (const description::PresenceSensor& s : scene_->sensors)
    regions_.push_back({-1, state("scene/" + s.name + "/present", 0), -1, s.lower, s.upper});
  for (const description::Mover& m : scene_->movers)
    movers_.push_back({command("scene/" + m.name + "/position"), state("scene/" + m.name + "/position", 0), 0,
                       m.speed, m.lower, m.upper, m.axis});
  for (const description::Belt& b : scene_->belts) {  // their encoders count, and no part rides on them
    const std::string name = "scene/" + b.name + "/";
    belts_.push_back(
        {command(name + "speed"), state(name + "position", 0), state(name + "speed", 0), b.speed});
    state(name + "parts", 0), state(name + "latch", 0);
  }
  carried_by_.assign(state_.parts.size(), -1);
  add_supports();
  for (std::size_t i = 0; i < state_.parts.size(); ++i)
    if (state_.parts[i].in_world) top_below(i);
}

void MockWorld::add_supports() {
  for (const description::Fixture& fixture : scene_->fixtures) {
    if (!fixture.shapes.empty() && !description::cloud_of(fixture.shapes.front()).empty()) continue;
    int mover = -1;
    for (std::size_t m = 0; m < scene_->movers.size(); ++m)
      if (scene_->movers[m].name == fixture.mover) mover = static_cast<int>(m);
    for (const description::Shape& shape : fixture.shapes)
      if (const Pose at = fixture.pose * shape.pose; is_upright(at.rotation)) supports_.push_back({&shape, at, mover});
  }
}

MockWorld::Below MockWorld::below(std::size_t part, const Vec3& point, double bottom) const noexcept {
  Below out{scene_->floor ? scene_->floor_height : kNothing};
  const auto look = [&](const description::Shape& shape, const Pose& pose, int mover) {
    const double top = pose.position.z + top_of(shape);
    if (top > bottom + kGripReach || top <= out.top || !is_over(shape, inverse(pose) * point)) return;
    out = {top, mover};
  };
  for (const Support& support : supports_) {
    Pose pose = support.pose;
    if (support.mover >= 0) pose.position = pose.position + movers_[static_cast<std::size_t>(support.mover)].offset();
    look(*support.shape, pose, support.mover);
  }
  for (std::size_t i = 0; i < state_.parts.size(); ++i) {
    const hardware::PartState& other = state_.parts[i];
    if (i != part && other.in_world && other.held_by < 0 && is_upright(other.pose.rotation))
      look(scene_->parts[i].shape, other.pose, carried_by_[i]);
  }
  return out;
}

double MockWorld::top_below(std::size_t part) noexcept {
  const description::Shape& shape = scene_->parts[part].shape;
  const Pose& at = state_.parts[part].pose;
  const double bottom = at.position.z - top_of(shape);
  Below out = below(part, at.position, bottom);
  const Vec3 half = half_of_underside(shape);
  const Vec3 points[] = {{half.x, 0, 0}, {0, half.y, 0}, {half.x, half.y, 0}, {half.x, -half.y, 0}};
  for (const Vec3& point : points) {
    if (norm(half) == 0 || !is_upright(at.rotation)) break;
    const Below a = below(part, at * point, bottom), b = below(part, at * -point, bottom);
    if (std::min(a.top, b.top) > out.top) out = a.top < b.top ? a : b;
  }
  carried_by_[part] = out.mover;
  return out.top;
}

void MockWorld::carry(std::size_t mover, double by) noexcept {
  const Vec3 way = by * movers_[mover].axis;
  for (std::size_t i = 0; i < carried_by_.size(); ++i) {
    hardware::PartState& part = state_.parts[i];
    if (part.in_world && part.held_by < 0 && carried_by_[i] == static_cast<int>(mover))
      part.pose.position = part.pose.position + way;
  }
}

Pose MockWorld::tcp(const Arm& arm, std::span<const double> states) const noexcept {
  Pose at = arm.base;
  for (const Step& step : arm.chain) {
    at = at * step.fixed;
    if (step.position_state < 0) continue;
    const double q = states[static_cast<std::size_t>(step.position_state)];
    at = step.prismatic ? at * Pose{q * step.axis, {}} : at * Pose{{}, from_axis_angle(step.axis, q)};
  }
  return at * arm.last;
}

void MockWorld::release_now(Arm& arm) noexcept {
  const auto i = static_cast<std::size_t>(arm.held);
  hardware::PartState& part = state_.parts[i];
  const description::Part& fact = scene_->parts[i];
  part.held_by = -1;
  for (Arm& other : arms_)  // another cup may have come to it: the part changes hands
    if (std::exchange(other.touched, -1) == arm.held && other.held < 0) {
      other.held = static_cast<int>(i);
      other.grasp = inverse(other.at) * part.pose;
      part.held_by = other.robot;
      arm.held = -1;
      return;
    }
  const double top = top_below(i);
  if (top > kNothing)
    part.pose.position.z = top + top_of(fact.shape);
  else
    part.pose.position.z = fact.goal ? fact.goal->at.z : fact.start.position.z;
  arm.held = -1;
}

void MockWorld::grip(Arm& arm, double dt, std::span<const double> asked, std::span<double> states) noexcept {
  const bool wanted = on(asked, arm.command);
  arm.on_for = wanted ? arm.on_for + dt : 0;
  if (!wanted && arm.held >= 0) release_now(arm);
  const bool looks = wanted && arm.held < 0 && arm.on_for >= kGripTime && scene_;
  const Pose at = looks || arm.held >= 0 ? tcp(arm, states) : Pose{};
  arm.touched = -1;
  arm.at = at;
  if (looks) {
    for (std::size_t i = 0; i < state_.parts.size(); ++i) {
      hardware::PartState& part = state_.parts[i];
      if (part.in_world && part.held_by >= 0 && is_near(scene_->parts[i].shape, part.pose, at.position))
        arm.touched = static_cast<int>(i);
      const Vec3 top = part.pose * Vec3{0, 0, top_of(scene_->parts[i].shape)};
      if (!part.in_world || part.held_by >= 0 || norm(top - at.position) > kGripReach) continue;
      arm.held = static_cast<int>(i);
      arm.grasp = inverse(at) * part.pose;
      part.held_by = arm.robot;
      break;
    }
  }
  if (arm.held >= 0) state_.parts[static_cast<std::size_t>(arm.held)].pose = at * arm.grasp;
  states[static_cast<std::size_t>(arm.level_state)] = wanted ? 1 : 0;
  states[static_cast<std::size_t>(arm.present_state)] = arm.held >= 0 || arm.touched >= 0 ? 1 : 0;
}

/// As in physics: two parts in one place would push each other away.
bool MockWorld::is_free(const Feeder& feeder) const noexcept {
  constexpr double kOverlap = -1e-3;
  const auto bounds = [&](std::size_t part, const Pose& at) {
    return description::bounds_of(scene_->parts[part].shape, at);
  };
  const auto next = static_cast<std::size_t>(feeder.parts[static_cast<std::size_t>(feeder.presented)]);
  const description::Bounds there = bounds(next, feeder.pose);
  for (std::size_t i = 0; i < state_.parts.size(); ++i)
    if (state_.parts[i].in_world && there.near(bounds(i, state_.parts[i].pose), kOverlap)) return false;
  return true;
}

void MockWorld::feed(Feeder& feeder, std::span<const double> asked, std::span<double> states) noexcept {
  if (count(asked, feeder.command) > feeder.presented &&
      feeder.presented < static_cast<int>(feeder.parts.size()) && is_free(feeder)) {
    hardware::PartState& part =
        state_.parts[static_cast<std::size_t>(feeder.parts[static_cast<std::size_t>(feeder.presented++)])];
    part.pose = feeder.pose;
    part.entered = part.in_world = true;
    top_below(static_cast<std::size_t>(&part - state_.parts.data()));
  }
  int kind = 0;
  int here = 0;
  for (int k = 0; k < feeder.presented; ++k) {
    const auto i = static_cast<std::size_t>(feeder.parts[static_cast<std::size_t>(k)]);
    kind = kinds_[i];
    const hardware::PartState& part = state_.parts[i];
    if (part.in_world && part.held_by < 0 && norm(part.pose.position - feeder.pose.position) < 0.03) ++here;
  }
  states[static_cast<std::size_t>(feeder.presented_state)] = feeder.presented;
  states[static_cast<std::size_t>(feeder.remaining_state)] =
      static_cast<double>(feeder.parts.size()) - feeder.presented;
  states[static_cast<std::size_t>(feeder.present_state)] = here > 0 ? 1 : 0;
  states[static_cast<std::size_t>(feeder.count_state)] = here;
  states[static_cast<std::size_t>(feeder.kind_state)] = kind;
}

void MockWorld::watch(Region& region, std::span<const double> asked, std::span<double> states) noexcept {
  bool present = false;
  for (hardware::PartState& part : state_.parts) {
    if (!part.in_world || part.held_by >= 0 || !inside(part.pose.position, region.lower, region.upper))
      continue;
    if (region.command >= 0 && count(asked, region.command) > region.taken) {
      ++region.taken;
      part.in_world = false;
      continue;
    }
    present = true;
  }
  states[static_cast<std::size_t>(region.present_state)] = present ? 1 : 0;
  if (region.taken_state >= 0) states[static_cast<std::size_t>(region.taken_state)] = region.taken;
}

void MockWorld::step(const hardware::Cycle& cycle, std::span<const double> asked,
                     std::span<double> states) noexcept {
  const double dt = seconds(cycle.period);
  state_.at_rest = true;
  for (std::size_t m = 0; m < movers_.size(); ++m) {
    Mover& mover = movers_[m];
    const double wanted = asked[static_cast<std::size_t>(mover.command)];
    if (std::isfinite(wanted)) {
      const double to = std::clamp(wanted, mover.lower, mover.upper);
      if (std::abs(to - mover.at) > 1e-12) state_.at_rest = false;
      const double by = std::clamp(to - mover.at, -mover.speed * dt, mover.speed * dt);
      mover.at += by;
      if (by != 0) carry(m, by);
    }
    states[static_cast<std::size_t>(mover.state)] = mover.at;
  }
  for (Belt& belt : belts_) {
    const double wanted = asked[static_cast<std::size_t>(belt.command)];
    const double speed = std::isfinite(wanted) ? std::clamp(wanted, -belt.most, belt.most) : 0;
    belt.at += speed * dt;
    states[static_cast<std::size_t>(belt.position_state)] = belt.at;
    states[static_cast<std::size_t>(belt.speed_state)] = speed;
  }
  for (Feeder& feeder : feeders_) feed(feeder, asked, states);
  for (Arm& arm : arms_) grip(arm, dt, asked, states);
  for (Region& region : regions_) watch(region, asked, states);
}

}  // namespace polyarm::drivers
