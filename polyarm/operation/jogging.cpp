#include "polyarm/operation/jogging.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/machine/motions.hpp"
#include "polyarm/tasks/programs.hpp"

namespace polyarm::cell {

using hardware::LifecycleState;

struct Jogging::Robot {
  std::size_t index = 0;
  JogPhase state = JogPhase::idle;
  std::string name;                             // of the controller
  jog::JogController* controller = nullptr;  // owned by the controller manager
  std::vector<std::string> displaced;        // the usual controllers of the joints
  std::optional<ControllerSwitch> switching;       // to the jog controller, or back
  std::uint32_t session = 0, over = 0, stops = 0;  // over: the newest session that was ended
  Nanoseconds first_requested = 0, asked = 0;          // while idle: when a client first and last asked to jog
  DeadMan dead_man;
  jog::JogSetpoint target;  // last streamed target
  std::uint32_t target_session = 0;
  Nanoseconds targeted = 0;
  std::vector<std::size_t> command_places;  // of its joints' positions
  std::vector<double> commanded;            // as last seen
  Nanoseconds changed = 0;                  // when they last changed

  /// Call once each tick.
  void see(const control::Snapshot& snapshot, Nanoseconds now) {
    commanded.resize(command_places.size(), NAN);
    for (std::size_t j = 0; j < command_places.size(); ++j) {
      const double q = snapshot.commands[command_places[j]];
      if (q != commanded[j] && std::isfinite(q)) changed = now;
      commanded[j] = q;
    }
  }
};

namespace {
/// s; streamed targets further apart give no velocity estimate. kNewest: weight of the newest sample.
constexpr double kTogether = 0.1, kNewest = 0.3;
/// A target that moves faster than this, m/s and rad/s, or a joint faster than this factor times its limit,
/// has jumped and gives no velocity estimate either.
constexpr double kJump = 2, kJumpTurned = 6, kJumpOfJoint = 2;
/// Longest wait for a robot that settles from its last motion; and the longest interval between requests that
/// count as one attempt.
constexpr Nanoseconds kSettling = 300'000'000, kAskedAgain = 20'000'000;
/// A robot whose commands have not changed for this long is at rest, while others may move.
constexpr Nanoseconds kUnchanged = 20'000'000;
}  // namespace

Jogging::Jogging(const CellSetup& setup, Machine& machine, const Arming& arming, const Motions& motions,
                 const Programs& programs, Observer& observer)
    : setup_(setup),
      machine_(machine),
      arming_(arming),
      motions_(motions),
      programs_(programs),
      observer_(observer) {
  for (std::size_t i = 0; i < setup.robots.size(); ++i) {
    robots_.push_back(std::make_unique<Robot>());
    robots_.back()->index = i;
  }
}
Jogging::~Jogging() = default;

namespace {
/// An inactive component that takes commands of the robot's joints; empty if there is none.
std::string inactive_component(const Machine& machine, const CellRobot& robot) {
  const hardware::Hardware& hardware = machine.hardware();
  for (const controllers::JointFacts& joint : robot.joints)
    for (const char* what : {"/position", "/velocity", "/effort"}) {
      const auto command = machine.table().find_command(joint.name + what);
      const int component = command ? hardware.component_of_command(*command) : -1;
      if (component < 0) continue;
      const auto c = static_cast<std::size_t>(component);
      if (hardware.state_of(c) != LifecycleState::active) return hardware.component_name(c);
    }
  return {};
}

bool follows_something(const controllers::JointTrajectoryController& controller) {
  return controller.status().active.load(std::memory_order_acquire) != 0;
}

Problem problem_of(const std::string& robot, const char* code, const std::string& why, const char* advice,
                   Facts facts = {}) {
  facts.push_back({"robot", robot});
  return {code, {}, "'" + robot + "' is not jogged: " + why, advice, Severity::error, std::move(facts)};
}

Problem problem_of_moving(const std::string& robot, const std::string& controller) {
  return problem_of(robot, "moving", controller + " is moving it",
                    "wait until it has arrived, or hold it: polyarm control hold",
                    {{"controller", controller}});
}
}  // namespace

void Jogging::require_allowed(std::size_t i) const {
  if (auto why = why_not(i)) throw Error(std::move(*why));
}

std::optional<Problem> Jogging::why_not(std::size_t i) const {
  const std::string& name = setup_.robots[i]->entry.name;
  if (!arming_.armed())
    return problem_of(name, "disarmed", "the real hardware is not armed", "polyarm control arm");
  if (motions_.forward_moves(i))
    return problem_of(name, "forward-mode",
                      "its own controller interpolates (`motion: forward`) and takes only moves",
                      "jog it at the pendant of its own controller, or move it with a program, such as "
                      "`moveto offset(here(), z = 50mm)`; or set `motion: stream` at the robot");
  const control::Snapshot& snapshot = machine_.snapshot();
  if (snapshot.state == control::RunState::fault)
    return problem_of(name, "fault", "the cell is in a fault", "polyarm control recover",
                      {{"cause", control::code(snapshot.cause)}});
  if (snapshot.state == control::RunState::stopping)
    return problem_of(name, "stopping", "the cell is stopping", "try again when it is at rest");
  if (const std::string component = inactive_component(machine_, *setup_.robots[i]); !component.empty())
    return problem_of(name, "not-active", "the hardware component '" + component + "' is not active",
                      "polyarm hardware recover NAME, or polyarm hardware state NAME active",
                      {{"component", component}});
  const bool running = snapshot.state == control::RunState::running;
  if (running && programs_.runs())
    return problem_of(name, "program-runs", "the program is running and has control",
                      "hold it first: polyarm control hold");
  if (!running && !has_joints(robot(i).state) && !motions_.idle(i))
    return problem_of(name, "motion-held", "a motion is held halfway along its path",
                      "continue: polyarm control resume; or discard it: polyarm control discard");
  const std::string mover = mover_of(i);
  if (mover.empty()) return std::nullopt;
  const auto* follower =
      dynamic_cast<const controllers::JointTrajectoryController*>(machine_.controllers().find(mover));
  if (motions_.idle(i) && follower && !follows_something(*follower)) return std::nullopt;  // it only settles
  return problem_of_moving(name, mover);
}

/// The trajectory controller that moves the robot now, or lets it settle; empty if the robot is at rest or
/// follows no such controller.
std::string Jogging::mover_of(std::size_t i) const {
  const control::Snapshot& snapshot = machine_.snapshot();
  if (snapshot.state != control::RunState::running || has_joints(robot(i).state) || snapshot.standing)
    return {};
  for (const controllers::JointFacts& joint : setup_.robots[i]->joints) {
    const std::string holder = machine_.controllers().holder_of(joint.name + "/position");
    if (holder.empty() || holder == robot(i).name) continue;
    const auto* const mover =
        dynamic_cast<const controllers::JointTrajectoryController*>(machine_.controllers().find(holder));
    if (!mover) continue;
    const bool rests = !follows_something(*mover) && machine_.now() - robot(i).changed > kUnchanged;
    if (!rests) return holder;
  }
  return {};
}

/// Waits for a robot that settles from its last motion, up to kSettling after the first request.
bool Jogging::has_come_to_rest(Robot& robot) {
  const Nanoseconds now = machine_.now();
  if (now - robot.asked > kAskedAgain) robot.first_requested = now;
  robot.asked = now;
  const std::string mover = mover_of(robot.index);
  if (mover.empty()) return true;
  if (now - robot.first_requested > kSettling)
    throw Error(problem_of_moving(setup_.robots[robot.index]->entry.name, mover));
  return false;
}

void Jogging::load(std::size_t i) {
  Robot& robot = *robots_[i];
  control::ControllerManager& manager = machine_.controllers();
  if (controller(robot)) return;
  robot.controller = nullptr;
  const CellRobot& of = *setup_.robots[i];
  robot.name = setup_.robots.size() == 1 ? "jog" : of.entry.name + "_jog";
  while (manager.find(robot.name)) robot.name = "polyarm_" + robot.name;
  auto made = std::make_unique<jog::JogController>(of.facts->chain, of.joints, of.facts->workspace);
  jog::JogController* const jog = made.get();
  controllers::ControllerContext context;
  context.name = robot.name;
  context.type = jog::JogController::kType;
  context.robot = of.entry.name;
  context.joints = of.joints;
  context.period = machine_.period();
  control::LoadOptions options;
  options.budget = setup_.file.budget;
  Problems reported_already;  // by the hardware
  options.divisor = divisor_of(of, context.period, reported_already);
  manager.load(std::move(made), std::move(context), std::move(options));
  try {
    manager.configure(robot.name);
  } catch (const Error&) {
    manager.unload(robot.name);
    throw;
  }
  robot.controller = jog;
  jog->set_limits(motions_.jog_limits());
}

JogPhase Jogging::state(std::size_t i) const {
  return robots_[i]->state;
}

bool Jogging::engaged() const {
  return std::any_of(robots_.begin(), robots_.end(),
                     [](const auto& robot) { return robot->state != JogPhase::idle; });
}

void Jogging::take(Robot& robot, JogChange step) {
  robot.state = next(robot.state, step);
  if (robot.state == JogPhase::idle || robot.state == JogPhase::moving) robot.switching.reset();
}

/// Starts to replace the controllers that command the joints by the jog controller.
void Jogging::begin_switch(Robot& robot) {
  const control::ControllerManager& manager = machine_.controllers();
  robot.displaced.clear();
  for (const std::string& command : robot.controller->command_interfaces()) {
    const std::string holder = manager.holder_of(command);
    if (!holder.empty() &&
        std::find(robot.displaced.begin(), robot.displaced.end(), holder) == robot.displaced.end())
      robot.displaced.push_back(holder);
  }
  robot.dead_man.release_now(machine_.now(), 0);
  robot.switching.emplace(
      machine_, control::SwitchRequest{{robot.name}, robot.displaced, control::Strictness::automatic});
  take(robot, JogChange::asked);
}

/// Starts to switch back to the usual controllers.
void Jogging::begin_release(Robot& robot) {
  std::vector<std::string> back;
  for (const std::string& name : robot.displaced)
    if (machine_.controllers().find(name)) back.push_back(name);
  robot.switching.emplace(machine_,
                          control::SwitchRequest{back, {robot.name}, control::Strictness::automatic});
  take(robot, JogChange::expired);
}

/// Advances the current switch; true when done. Throws the reason of a refusal.
bool Jogging::advance(Robot& robot) {
  try {
    if (!robot.switching->advance()) return false;
  } catch (...) {
    take(robot, JogChange::refused);
    throw;
  }
  take(robot, JogChange::switched);
  return true;
}

bool Jogging::engage(std::size_t i) {
  Robot& robot = *robots_[i];
  switch (robot.state) {
    case JogPhase::moving:
      return true;
    case JogPhase::releasing:
      return false;  // tick() continues it
    case JogPhase::switching:
      return advance(robot);
    case JogPhase::idle:
      require_allowed(i);
      if (!has_come_to_rest(robot)) return false;
      load(i);
      begin_switch(robot);
      return advance(robot);
  }
  return false;
}

bool Jogging::alive(const Robot& robot) const {
  if (robot.session <= robot.over || robot.dead_man.expired(machine_.now(), kLinger)) return false;
  jog::JogController* const jog = controller(robot);
  return jog && jog->status().ended < robot.session;
}

std::uint32_t Jogging::session(std::size_t i, std::uint32_t wanted) {
  Robot& robot = *robots_[i];
  if (wanted != 0) {
    if (wanted == robot.session && wanted > robot.over && status(i).ended < wanted) return wanted;
    throw Error("session-over",
                "jogging as session " + std::to_string(wanted) + " is over: something stopped it",
                "release the key and press it again");
  }
  if (alive(robot))
    throw Error("jogged", "another client jogs '" + setup_.robots[i]->entry.name + "' now",
                "one at a time: wait until that has ended, or stop it: polyarm control hold");
  // Session numbers only increase, over all robots.
  std::uint32_t next = 0;
  for (const auto& each : robots_) next = std::max(next, each->session);
  robot.session = next + 1;
  robot.stops = machine_.supervisor().latch().count();
  robot.dead_man.renew(machine_.now(), 0);
  return robot.session;
}

void Jogging::send(std::size_t i, std::uint32_t session, jog::JogCommand command) {
  Robot& robot = *robots_[i];
  command.session = session;
  command.stops = robot.stops;
  robot.dead_man.renew(machine_.now(), command.hold);
  if (jog::JogController* const jog = controller(robot)) jog->send(command);
}

void Jogging::estimate(std::size_t i, std::uint32_t session, jog::JogSetpoint& wish) {
  Robot& robot = *robots_[i];
  const double dt = seconds(machine_.now() - robot.targeted);
  const bool keeps_going = session != 0 && session == robot.session && robot.target.kind == wish.kind &&
                       robot.target_session != 0 && dt < kTogether;
  if (keeps_going && dt < 1e-3) {  // too close to the previous target for an estimate
    wish.joint_speed = robot.target.joint_speed;
    wish.twist = robot.target.twist;
    robot.target = wish;
    return;
  }
  const auto blend = [&](double old, double change) { return old + kNewest * (change / dt - old); };
  const auto& joints = setup_.robots[i]->joints;
  for (std::size_t j = 0; keeps_going && j < joints.size() && j < wish.joints.size(); ++j) {
    const double change = wish.joints[j] - robot.target.joints[j], old = robot.target.joint_speed[j];
    const bool jumped = std::abs(change) > kJumpOfJoint * joints[j].velocity * dt;
    const double v = jumped ? old : blend(old, change);
    wish.joint_speed[j] = std::isfinite(v) ? v : 0;
  }
  if (keeps_going && wish.kind == jog::JogSetpoint::Kind::tcp_target) {
    const Pose &now = wish.target, &before = robot.target.target;
    const Vec3 d = now.position - before.position,
               r = to_rotation_vector(now.rotation * inverse(before.rotation));
    const double change[6] = {d.x, d.y, d.z, r.x, r.y, r.z};
    const bool jumped = norm(d) > kJump * dt || norm(r) > kJumpTurned * dt;
    for (std::size_t k = 0; k < 6; ++k)
      wish.twist[k] = jumped ? robot.target.twist[k] : blend(robot.target.twist[k], change[k]);
  }
  robot.target = wish;
  robot.target_session = keeps_going ? session : 1;
  robot.targeted = machine_.now();
}

Pose Jogging::last_target(std::size_t i, std::uint32_t session) const {
  const Robot& r = robot(i);
  if (session != 0 && session == r.session && r.target.kind == jog::JogSetpoint::Kind::tcp_target)
    return r.target.target;
  return has_joints(r.state) ? status(i).tcp : motions_.tcp(i);
}

void Jogging::end(std::size_t i, std::uint32_t session) {
  Robot& robot = *robots_[i];
  if (session != 0 && session != robot.session) return;
  if (jog::JogController* const jog = controller(robot)) jog->release_now(robot.session);
  robot.over = robot.session;
  robot.dead_man.release_now(machine_.now(), kLinger);
}

void Jogging::end_all() {
  for (std::size_t i = 0; i < robots_.size(); ++i) end(i);
}

jog::JogStatus Jogging::status(std::size_t i) const {
  jog::JogController* const jog = controller(robot(i));
  return jog ? jog->status() : jog::JogStatus{};
}

jog::Barriers* Jogging::draft_barriers(std::size_t i) {
  jog::JogController* const jog = has_joints(state(i)) ? controller(robot(i)) : nullptr;
  return jog ? &jog->draft_barriers() : nullptr;
}

void Jogging::publish_barriers(std::size_t i) {
  if (jog::JogController* const jog = controller(robot(i))) jog->publish_barriers();
}

/// Null before the controller is loaded, and after somebody has unloaded it.
jog::JogController* Jogging::controller(const Robot& robot) const {
  if (!robot.controller || machine_.controllers().find(robot.name) != robot.controller) return nullptr;
  return robot.controller;
}

bool Jogging::is_active(const Robot& robot) const {
  const auto all = machine_.controllers().list();
  return std::any_of(all.begin(), all.end(), [&](const control::ListedController& c) {
    return c.name == robot.name && c.state == LifecycleState::active;
  });
}

void Jogging::tick(Robot& robot) {
  jog::JogController* const jog = controller(robot);
  if (!jog) return take(robot, JogChange::lost);
  jog->set_limits(motions_.jog_limits());
  switch (robot.state) {
    case JogPhase::idle:
      return;
    case JogPhase::switching:
      try {
        advance(robot);         // the client that asked for it may be gone
      } catch (const Error&) {  // reported when the client asks again
      }
      return;
    case JogPhase::moving:
      if (!is_active(robot)) return take(robot, JogChange::lost);  // deactivated, or its hardware failed
      if (!jog->status().standing || !robot.dead_man.expired(machine_.now(), kLinger - 1)) return;
      [[fallthrough]];
    case JogPhase::releasing:
      try {
        if (robot.state == JogPhase::moving) begin_release(robot);
        advance(robot);
      } catch (const Error& e) {
        robot.state = JogPhase::idle;
        observer_.on_note("after jogging " + join(robot.displaced, ", ") +
                          " could not be started again: " + e.what());
      }
      return;
  }
}

void Jogging::tick() {
  const control::RunState state = machine_.snapshot().state;
  // A resume ends all jogging that began while the cell was held.
  if (std::exchange(was_held_, state == control::RunState::held) && state == control::RunState::running)
    end_all();
  for (const auto& robot : robots_) {
    if (robot->command_places.empty())
      for (const controllers::JointFacts& joint : setup_.robots[robot->index]->joints)
        if (const auto place = machine_.table().find_command(joint.name + "/position"))
          robot->command_places.push_back(*place);
    robot->see(machine_.snapshot(), machine_.now());
    tick(*robot);
  }
}

}  // namespace polyarm::cell
