#include "drivers/mock/mock_world.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::drivers {

namespace {
constexpr double kGripTime = 0.1, kGripReach = 0.015;

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
    Feeder feeder{command(name + "feed"),
                  state(name + "presented", 0),
                  state(name + "remaining", 0),
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
                       m.speed, m.lower, m.upper});
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

void MockWorld::let_go(Arm& arm) noexcept {
  const auto i = static_cast<std::size_t>(arm.held);
  hardware::PartState& part = state_.parts[i];
  const description::Part& fact = scene_->parts[i];
  part.pose.position.z = fact.goal ? fact.goal->at.z : fact.start.position.z;
  part.held_by = -1;
  arm.held = -1;
}

void MockWorld::grip(Arm& arm, double dt, std::span<const double> asked, std::span<double> states) noexcept {
  const bool wanted = on(asked, arm.command);
  arm.on_for = wanted ? arm.on_for + dt : 0;
  if (!wanted && arm.held >= 0) let_go(arm);
  const bool looks = wanted && arm.held < 0 && arm.on_for >= kGripTime && scene_;
  const Pose at = looks || arm.held >= 0 ? tcp(arm, states) : Pose{};
  if (looks) {
    for (std::size_t i = 0; i < state_.parts.size(); ++i) {
      hardware::PartState& part = state_.parts[i];
      const Vec3 top = part.pose * Vec3{0, 0, top_of(scene_->parts[i].shape)};
      if (!part.in_world || part.held_by >= 0 || norm(top - at.position) > kGripReach) continue;
      arm.held = static_cast<int>(i);
      arm.grasp = inverse(at) * part.pose;
      part.held_by = static_cast<int>(&arm - arms_.data());
      break;
    }
  }
  if (arm.held >= 0) state_.parts[static_cast<std::size_t>(arm.held)].pose = at * arm.grasp;
  states[static_cast<std::size_t>(arm.level_state)] = wanted ? 1 : 0;
  states[static_cast<std::size_t>(arm.present_state)] = arm.held >= 0 ? 1 : 0;
}

void MockWorld::feed(Feeder& feeder, std::span<const double> asked, std::span<double> states) noexcept {
  if (count(asked, feeder.command) > feeder.presented &&
      feeder.presented < static_cast<int>(feeder.parts.size())) {
    hardware::PartState& part =
        state_.parts[static_cast<std::size_t>(feeder.parts[static_cast<std::size_t>(feeder.presented++)])];
    part.pose = feeder.pose;
    part.entered = part.in_world = true;
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
  for (Mover& mover : movers_) {
    const double wanted = asked[static_cast<std::size_t>(mover.command)];
    if (std::isfinite(wanted)) {
      const double to = std::clamp(wanted, mover.lower, mover.upper);
      if (std::abs(to - mover.at) > 1e-12) state_.at_rest = false;
      mover.at += std::clamp(to - mover.at, -mover.speed * dt, mover.speed * dt);
    }
    states[static_cast<std::size_t>(mover.state)] = mover.at;
  }
  for (Feeder& feeder : feeders_) feed(feeder, asked, states);
  for (Arm& arm : arms_) grip(arm, dt, asked, states);
  for (Region& region : regions_) watch(region, asked, states);
}

}  // namespace polyarm::drivers
