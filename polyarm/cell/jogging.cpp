#include "polyarm/cell/jogging.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/controller_switch.hpp"
#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

using hardware::LifecycleState;

struct Jogging::Robot {
  std::size_t index = 0;
  std::string name;                             // of the controller
  jog::JogController* controller = nullptr;  // the manager's
  std::vector<std::string> displaced;           // who has the joints otherwise
  Poll<control::SwitchPlan> switching;                               // to the controller, or back
  bool engaged = false, returning = false;
  std::uint32_t session = 0, over = 0, stops = 0;  // over: the newest that was ended
  Nanoseconds renewed = 0, hold = 0;
  jog::JogWish target;  // streamed last
  std::uint32_t target_session = 0;
  Nanoseconds targeted = 0;
};

namespace {
/// Targets further apart than this, s, say nothing about a velocity; and how much the newest says.
constexpr double kTogether = 0.1, kNewest = 0.3;
/// What moves faster than this, m/s and rad/s, or a joint faster than so many times what it can, has jumped:
/// that says nothing about a velocity either.
constexpr double kJump = 2, kJumpTurned = 6, kJumpOfJoint = 2;
}  // namespace

Jogging::Jogging(Cell& cell) : cell_(cell) {
  for (std::size_t i = 0; i < cell.robots().size(); ++i) {
    robots_.push_back(std::make_unique<Robot>());
    robots_.back()->index = i;
  }
}
Jogging::~Jogging() = default;

namespace {
/// A component that takes commands of the robot's joints and is not active; empty: there is none.
std::string inactive_component(Cell& cell, std::size_t robot) {
  control::ControlLoop& loop = cell.loop();
  for (const controllers::JointFacts& joint : cell.robots()[robot]->joints)
    for (const char* what : {"/position", "/velocity", "/effort"}) {
      const auto command = loop.table().find_command(joint.name + what);
      const int component = command ? loop.hardware().component_of_command(*command) : -1;
      if (component < 0) continue;
      const auto c = static_cast<std::size_t>(component);
      if (loop.hardware().state_of(c) != LifecycleState::active) return loop.hardware().component_name(c);
    }
  return {};
}
}  // namespace

void Jogging::require_allowed(std::size_t i) const {
  if (auto why = why_not(i)) throw Error(std::move(*why));
}

std::optional<Problem> Jogging::why_not(std::size_t i) const {
  const std::string& name = cell_.robots()[i]->entry.name;
  const auto no = [&name](const char* code, const std::string& why, const char* advice, Facts facts = {}) {
    facts.push_back({"robot", name});
    return Problem{
        code, {}, "'" + name + "' is not jogged: " + why, advice, Severity::error, std::move(facts)};
  };
  if (!cell_.arming().armed())
    return no("disarmed", "real hardware that nobody has armed", "polyarm control arm");
  const control::Snapshot& snapshot = cell_.snapshot();
  if (snapshot.state == control::RunState::fault)
    return no("fault", "the cell is in a fault", "polyarm control recover",
              {{"cause", control::code(snapshot.cause)}});
  if (snapshot.state == control::RunState::stopping)
    return no("stopping", "the cell is stopping", "ask again when it stands");
  if (const std::string component = inactive_component(cell_, i); !component.empty())
    return no("not-active", "the hardware component '" + component + "' is not active",
              "polyarm hardware recover NAME, or polyarm hardware state NAME active",
              {{"component", component}});
  const bool running = snapshot.state == control::RunState::running;
  if (running && cell_.program_runs())
    return no("program-runs", "the program is running and holds control",
              "hold it first: polyarm control hold");
  if (!running && !robot(i).engaged && !cell_.idle(i))
    return no("motion-held", "a motion is held half way along its path",
              "go on: polyarm control resume; or forget it: polyarm control discard");
  if (running && !robot(i).engaged && !snapshot.standing)
    for (const controllers::JointFacts& joint : cell_.robots()[i]->joints) {
      const std::string holder = cell_.loop().controllers().holder_of(joint.name + "/position");
      const controllers::Controller* mover =
          holder.empty() ? nullptr : cell_.loop().controllers().find(holder);
      if (mover && holder != robot(i).name &&
          dynamic_cast<const controllers::JointTrajectoryController*>(mover))
        return no("moving", holder + " is moving it",
                  "wait until it has arrived, or hold it: polyarm control hold", {{"controller", holder}});
    }
  return std::nullopt;
}

void Jogging::load(std::size_t i) {
  Robot& robot = *robots_[i];
  control::ControllerManager& manager = cell_.loop().controllers();
  if (controller(robot)) return;
  robot.controller = nullptr;
  const CellRobot& of = *cell_.robots()[i];
  robot.name = cell_.robots().size() == 1 ? "jog" : of.entry.name + "_jog";
  while (manager.find(robot.name)) robot.name = "polyarm_" + robot.name;
  auto made = std::make_unique<jog::JogController>(of.facts->chain, of.joints, of.facts->workspace);
  jog::JogController* const jog = made.get();
  controllers::ControllerContext context;
  context.name = robot.name;
  context.type = jog::JogController::kType;
  context.robot = of.entry.name;
  context.joints = of.joints;
  context.period = cell_.loop().options().period;
  control::LoadOptions options;
  options.budget = cell_.file().budget;
  Problems told;  // with the hardware
  options.divisor = divisor_of(of, context.period, told);
  manager.load(std::move(made), std::move(context), std::move(options));
  try {
    manager.configure(robot.name);
  } catch (const Error&) {
    manager.unload(robot.name);
    throw;
  }
  robot.controller = jog;
  jog->set_limits(cell_.jog_limits());
}

bool Jogging::engage(std::size_t i) {
  Robot& robot = *robots_[i];
  if (robot.returning) return false;  // tick() goes on with that
  if (robot.switching) {
    const Progress<control::SwitchPlan> progress = [&] {
      try {
        return robot.switching();
      } catch (...) {
        robot.switching = nullptr;
        throw;
      }
    }();
    if (!progress.over) return false;
    robot.switching = nullptr;
    robot.engaged = true;
    return true;
  }
  if (robot.engaged) return true;
  require_allowed(i);
  load(i);
  control::ControllerManager& manager = cell_.loop().controllers();
  robot.displaced.clear();
  for (const std::string& command : robot.controller->command_interfaces()) {
    const std::string holder = manager.holder_of(command);
    if (!holder.empty() &&
        std::find(robot.displaced.begin(), robot.displaced.end(), holder) == robot.displaced.end())
      robot.displaced.push_back(holder);
  }
  robot.renewed = cell_.now();
  robot.switching = switch_controllers(cell_, {{robot.name}, robot.displaced, control::Strictness::automatic});
  return engage(i);
}

bool Jogging::alive(const Robot& robot) const {
  if (robot.session <= robot.over || cell_.now() - robot.renewed > robot.hold + kLinger) return false;
  jog::JogController* const jog = controller(robot);
  return jog && jog->status().ended < robot.session;
}

std::uint32_t Jogging::session(std::size_t i, std::uint32_t wanted) {
  Robot& robot = *robots_[i];
  if (wanted != 0) {
    if (wanted == robot.session && wanted > robot.over && status(i).ended < wanted) return wanted;
    throw Error("session-over",
                "jogging as session " + std::to_string(wanted) + " is over: something stopped it",
                "let the key go and press it again");
  }
  if (alive(robot))
    throw Error("jogged", "somebody else jogs '" + cell_.robots()[i]->entry.name + "' now",
                "one at a time: wait until they let go, or stop them: polyarm control hold");
  // Numbers only rise, for any robot.
  std::uint32_t next = 0;
  for (const auto& each : robots_) next = std::max(next, each->session);
  robot.session = next + 1;
  robot.stops = cell_.loop().supervisor().latch().count();
  robot.renewed = cell_.now();
  robot.hold = 0;
  return robot.session;
}

void Jogging::send(std::size_t i, std::uint32_t session, jog::JogCommand command) {
  Robot& robot = *robots_[i];
  command.session = session;
  command.stops = robot.stops;
  robot.renewed = cell_.now();
  robot.hold = command.hold;
  if (jog::JogController* const jog = controller(robot)) jog->send(command);
}

void Jogging::estimate(std::size_t i, std::uint32_t session, jog::JogWish& wish) {
  Robot& robot = *robots_[i];
  const double dt = seconds(cell_.now() - robot.targeted);
  const bool goes_on = session != 0 && session == robot.session && robot.target.kind == wish.kind &&
                       robot.target_session != 0 && dt < kTogether;
  if (goes_on && dt < 1e-3) {  // with the one before, as far as anybody knows
    wish.joint_speed = robot.target.joint_speed;
    wish.twist = robot.target.twist;
    robot.target = wish;
    return;
  }
  const auto blend = [&](double old, double change) { return old + kNewest * (change / dt - old); };
  const auto& joints = cell_.robots()[i]->joints;
  for (std::size_t j = 0; goes_on && j < joints.size() && j < wish.joints.size(); ++j) {
    const double change = wish.joints[j] - robot.target.joints[j], old = robot.target.joint_speed[j];
    const bool jumped = std::abs(change) > kJumpOfJoint * joints[j].velocity * dt;
    const double v = jumped ? old : blend(old, change);
    wish.joint_speed[j] = std::isfinite(v) ? v : 0;
  }
  if (goes_on && wish.kind == jog::JogWish::Kind::tcp_target) {
    const Pose &now = wish.target, &before = robot.target.target;
    const Vec3 d = now.position - before.position,
               r = to_rotation_vector(now.rotation * inverse(before.rotation));
    const double change[6] = {d.x, d.y, d.z, r.x, r.y, r.z};
    const bool jumped = norm(d) > kJump * dt || norm(r) > kJumpTurned * dt;
    for (std::size_t k = 0; k < 6; ++k)
      wish.twist[k] = jumped ? robot.target.twist[k] : blend(robot.target.twist[k], change[k]);
  }
  robot.target = wish;
  robot.target_session = goes_on ? session : 1;
  robot.targeted = cell_.now();
}

Pose Jogging::last_target(std::size_t i, std::uint32_t session) const {
  const Robot& r = robot(i);
  if (session != 0 && session == r.session && r.target.kind == jog::JogWish::Kind::tcp_target)
    return r.target.target;
  return r.engaged ? status(i).tcp : cell_.tcp(i);
}

void Jogging::end(std::size_t i, std::uint32_t session) {
  Robot& robot = *robots_[i];
  if (session != 0 && session != robot.session) return;
  if (jog::JogController* const jog = controller(robot)) jog->let_go(robot.session);
  robot.over = robot.session;
  robot.hold = 0;
  robot.renewed = cell_.now() - kLinger;
}

void Jogging::end_all() {
  for (std::size_t i = 0; i < robots_.size(); ++i) end(i);
}

jog::JogStatus Jogging::status(std::size_t i) const {
  jog::JogController* const jog = controller(robot(i));
  return jog ? jog->status() : jog::JogStatus{};
}

/// Null before it is loaded, and when somebody has unloaded it.
jog::JogController* Jogging::controller(const Robot& robot) const {
  if (!robot.controller || cell_.loop().controllers().find(robot.name) != robot.controller) return nullptr;
  return robot.controller;
}

bool Jogging::engaged(std::size_t i) const {
  return robots_[i]->engaged || robots_[i]->switching;
}

bool Jogging::engaged() const {
  return std::any_of(robots_.begin(), robots_.end(),
                     [](const auto& robot) { return robot->engaged || robot->switching; });
}

/// Goes back, a step each tick. What cannot be started again is told; the robot is free then.
void Jogging::give_back(Robot& robot) {
  try {
    if (!robot.returning) {
      robot.returning = true;
      std::vector<std::string> back;
      for (const std::string& name : robot.displaced)
        if (cell_.loop().controllers().find(name)) back.push_back(name);
      robot.switching =
          switch_controllers(cell_, {back, {robot.name}, control::Strictness::automatic});
    }
    if (!robot.switching().over) return;
  } catch (const Error& e) {
    cell_.tell("after jogging " + join(robot.displaced, ", ") + " could not be started again: " + e.what());
  }
  robot.switching = nullptr;
  robot.engaged = robot.returning = false;
}

void Jogging::tick(Nanoseconds now) {
  const control::RunState state = cell_.snapshot().state;
  // Who resumes what is held takes the robots back from who jogs meanwhile.
  if (std::exchange(was_held_, state == control::RunState::held) && state == control::RunState::running)
    end_all();
  const jog::JogLimits limits = cell_.jog_limits();
  for (const auto& each : robots_) {
    Robot& robot = *each;
    jog::JogController* const jog = controller(robot);
    if (!jog) robot.engaged = false;
    if (!jog) continue;
    jog->set_limits(limits);
    if (robot.switching && !robot.returning) {  // whoever asked for it may be gone
      try {
        engage(robot.index);
      } catch (const Error&) {  // told to who asked, when asked again
      }
      continue;
    }
    if (robot.returning) {
      give_back(robot);
      continue;
    }
    if (!robot.engaged) continue;
    bool active = false;
    for (const control::ListedController& c : cell_.loop().controllers().list())
      active = active || (c.name == robot.name && c.state == LifecycleState::active);
    if (!active) {  // somebody else switched it off, or its hardware failed
      robot.engaged = false;
      continue;
    }
    if (jog->status().standing && now - robot.renewed >= robot.hold + kLinger) give_back(robot);
  }
}

}  // namespace polyarm::cell
