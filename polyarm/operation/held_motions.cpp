#include "polyarm/operation/held_motions.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "polyarm/base/text.hpp"
#include "polyarm/operation/jog_commands.hpp"
#include "polyarm/operation/way_planning.hpp"
#include "polyarm/protocol/session.hpp"
#include "polyarm/ros_files/message_forms.hpp"
#include "polyarm/wheels/base_controller.hpp"

namespace polyarm::cell {

namespace {

double number_of(const std::optional<double>& given, const char* name, double fallback, double low,
                 double high) {
  const double value = given.value_or(fallback);
  if (value >= low && value <= high) return value;
  throw Error("bad-argument", std::string("'") + name + "' is " + format_number(value) +
                                  ", not a number from " + format_number(low) + " to " + format_number(high));
}

/// The share of maximum speed for each of `count` axes. `axis` is an axis number, or a list of numbers in
/// [-1, 1].
std::vector<double> shares_of(const protocol::Any& given, const std::optional<double>& direction,
                              std::size_t count) {
  const nlohmann::json& axis = given.json();
  std::vector<double> out(count, 0.0);
  if (axis.is_number_integer() && axis.get<std::int64_t>() >= 0 && axis.get<std::uint64_t>() < count) {
    out[axis.get<std::size_t>()] = number_of(direction, "direction", 1, -1, 1);
    return out;
  }
  bool good = axis.is_array() && axis.size() == count;
  for (std::size_t i = 0; good && i < count; ++i) {
    good = axis[i].is_number() && std::abs(axis[i].get<double>()) <= 1;
    if (good) out[i] = axis[i].get<double>();
  }
  if (!good)
    throw Error("bad-argument", "'axis' is " + given.dump(),
                "the number of an axis below " + std::to_string(count) + ", or a share in [-1, 1] of each");
  return out;
}

/// The controller that drives the robot's base; empty if there is none.
std::string wheels_of(const Machine& machine, const std::string& robot) {
  for (const control::ListedController& listed : machine.controllers().list()) {
    const auto* wheels =
        dynamic_cast<const controllers::BaseController*>(machine.controllers().find(listed.name));
    if (wheels && !wheels->command_interfaces().empty() &&
        wheels->command_interfaces().front().starts_with(robot + "/"))
      return listed.name;
  }
  return {};
}

/// The reason that holds a motion back, as one word for programs.
std::string word_of(jog::JogHold hold) {
  if (hold == jog::JogHold::none) return {};
  const std::string name = jog::name(hold);
  if (name == "joint limit") return "limit";
  return name == "singularity" ? "singular" : name;
}

}  // namespace

/// A base is driven with twists, an arm with commands of its jog controller.
struct HeldMotions::Motion {
  enum class Phase { planning, switching, moving, over };
  /// What holds a motion back now; all are empty if nothing does.
  struct HeldBack {
    std::string why, text, which;
    bool operator==(const HeldBack&) const = default;
  };
  struct Twist {
    std::string controller;
    double ahead = 0, turn = 0;  // m/s, rad/s
    double share = 1;            // that a guard leaves
  };
  std::uint64_t number = 0;
  std::size_t robot = 0;
  Phase phase = Phase::switching;
  DeadMan dead_man;
  jog::JogCommand command;
  std::uint32_t session = 0;
  std::optional<Twist> twist;
  std::shared_ptr<const PlannedWay> way;
  bool line = false;  // true: the planned path is followed as a straight line
  double speed = 1;
  std::variant<std::monostate, std::vector<double>, Pose> goal;  // joints or TCP pose
  HeldBack reported;
};

HeldMotions::HeldMotions(const JogOwners& cell, Worker& worker) : cell_(cell), worker_(worker) {}
HeldMotions::~HeldMotions() = default;

std::size_t HeldMotions::robot_of(const std::optional<std::string>& name) const {
  const std::string wanted = name.value_or("");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < cell_.setup.robots.size(); ++i) {
    names.push_back(cell_.setup.robots[i]->entry.name);
    if (names.back() == wanted) return i;
  }
  if (wanted.empty() && names.size() == 1) return 0;
  throw Error("unknown-robot", "there is no robot '" + wanted + "'" + did_you_mean(wanted, names),
              "there are: " + join(names, ", "));
}

/// `amount`: size of a step, rad or m; for continuous motion the share of the maximum speed.
template <class Keys>
protocol::JogMotion HeldMotions::jog_motion_of(std::size_t i, const Keys& request, double amount, bool by) const {
  const CellRobot& robot = *cell_.setup.robots[i];
  const std::string mode = request.mode.value_or("joint");
  protocol::JogMotion out;
  out.robot = robot.entry.name;
  const jog::JogLimits limits = cell_.motions.jog_limits();
  if (mode == "joint") {
    const std::vector<double> shares = shares_of(request.axis, request.direction, robot.joints.size());
    out.joints.emplace();
    for (std::size_t j = 0; j < shares.size(); ++j) {
      if (shares[j] == 0) continue;
      const double full = by ? 1 : robot.facts->limits[j].velocity * limits.joint_share;
      const std::string& name = robot.joints[j].name;
      (*out.joints)[name.substr(name.find('/') + 1)] = shares[j] * amount * full;
    }
    return out;
  }
  if (mode != "tcp") throw Error("bad-argument", "there is no mode '" + mode + "'", "joint or tcp");
  const std::vector<double> shares = shares_of(request.axis, request.direction, 6);
  constexpr const char* kAxes[] = {"x", "y", "z", "rx", "ry", "rz"};
  const double way = by ? 1 : std::min(limits.tcp_speed, robot.facts->tcp.speed),
               turn = by ? 1 : std::min(limits.tcp_turning, robot.facts->tcp.turn_speed);
  out.tcp.emplace();
  for (std::size_t k = 0; k < 6; ++k)
    if (shares[k] != 0) (*out.tcp)[kAxes[k]] = shares[k] * amount * (k < 3 ? way : turn);
  const std::string frame = request.frame.value_or("base");
  out.frame = frame.starts_with("user:") ? frame.substr(5) : frame;
  return out;
}

protocol::JogMotion HeldMotions::step(const protocol::JogStep& request) const {
  const std::size_t robot = robot_of(request.robot);
  protocol::JogMotion out = jog_motion_of(robot, request, number_of(request.amount, "amount", 0, -10, 10), true);
  out.by = true;
  out.speed = number_of(request.speed, "speed", 1, 0.001, 1);
  return out;
}

HeldMotions::Motion& HeldMotions::add(std::size_t robot) {
  Motion& out = *all_.emplace_back(std::make_unique<Motion>());
  out.number = ++last_;
  out.robot = robot;
  out.dead_man.renew(cell_.machine.now(), nanoseconds(kSilence));
  return out;
}

HeldMotions::Motion* HeldMotions::find(std::uint64_t motion) const {
  for (const auto& each : all_)
    if (each->number == motion && each->phase != Motion::Phase::over) return each.get();
  return nullptr;
}

std::uint64_t HeldMotions::begin(const protocol::JogBegin& request) {
  const std::size_t i = robot_of(request.robot);
  if (request.mode == "drive") {
    Motion driven;
    drive(driven, request);
    cell_.jogging.require_allowed(i);
    Motion& motion = add(i);
    motion.twist = driven.twist;
    advance(motion);
    return motion.number;
  }
  protocol::JogMotion wish = jog_motion_of(i, request, number_of(request.speed, "speed", 1, 0.001, 1), false);
  wish.hold = kSilence;
  const jog::JogCommand command = jog_command(cell_, *cell_.setup.robots[i], wish);
  cell_.jogging.require_allowed(i);
  Motion& motion = add(i);
  motion.command = command;
  advance(motion);
  return motion.number;
}

/// Limits the speed to the profile's TCP speed.
void HeldMotions::drive(Motion& motion, const protocol::JogBegin& request) {
  constexpr double kAny = 1;  // for a base without speed limits, m/s and rad/s
  const std::string& robot = cell_.setup.robots[robot_of(request.robot)]->entry.name;
  const std::string name = wheels_of(cell_.machine, robot);
  if (name.empty())
    throw Error("no-base", "no controller of wheels drives '" + robot + "'", "jog its joints or its TCP");
  const auto& wheels =
      dynamic_cast<const controllers::BaseController&>(*cell_.machine.controllers().find(name));
  const std::vector<double> shares = shares_of(request.axis, request.direction, 2);
  const double speed = number_of(request.speed, "speed", 1, 0.001, 1);
  const auto stated = [](double limit) { return std::isfinite(limit) && limit > 0 ? limit : kAny; };
  const jog::JogLimits limits = cell_.motions.jog_limits();
  const double ahead = std::min(limits.tcp_speed, stated(wheels.linear_limits().max_velocity)),
               turn = std::min(limits.tcp_turning, stated(wheels.angular_limits().max_velocity));
  motion.twist = Motion::Twist{name, shares[0] * speed * ahead, shares[1] * speed * turn};
}

/// Sends the twist; a share of 0 stops the base. Throws Error if the controller does not accept it.
void HeldMotions::push(const Motion& motion, double share) const {
  const Motion::Twist& twist = *motion.twist;
  controllers::Controller* const wheels = cell_.machine.controllers().find(twist.controller);
  if (!wheels) throw Error("unloaded", "the controller was removed");
  for (const control::ListedController& c : cell_.machine.controllers().list())
    if (c.name == twist.controller && c.state != hardware::LifecycleState::active)
      throw Error("not-active",
                  "the controller '" + twist.controller + "' is " + hardware::name(c.state) +
                      " and takes no messages",
                  "start it: polyarm control state " + twist.controller + " active");
  const std::string message =
      nlohmann::json{{"linear", {{"x", share * twist.ahead}}}, {"angular", {{"z", share * twist.turn}}}}
          .dump();
  for (const controllers::InputPort& port : wheels->inputs())
    if (port.name == "cmd_vel")
      wheels->receive(port.name, ros_files::read_message(message, "the twist", port.types), false);
}

std::uint64_t HeldMotions::go_to(const protocol::JogGoto& request) {
  const std::size_t i = robot_of(request.robot);
  const double speed = number_of(request.speed, "speed", 1, 0.001, 1);
  protocol::PlanPreview wanted;
  wanted.kind = request.kind;
  wanted.joints = request.joints;
  wanted.pose = request.pose;
  std::shared_ptr<const PlannedWay> way =
      plan_way({cell_.setup, cell_.machine, cell_.data, cell_.motions, worker_}, i, wanted);
  Motion& motion = add(i);
  motion.phase = Motion::Phase::planning;
  motion.way = std::move(way);
  motion.line = request.kind == protocol::MoveKind::line;
  motion.speed = speed;
  return motion.number;
}

/// The end of the planned path becomes the target: of the joints, or of the TCP on its line.
void HeldMotions::take_plan(Motion& motion) {
  if (!motion.way->done.load(std::memory_order_acquire)) return;
  if (motion.way->error) return finish(motion, "", "", &*motion.way->error);
  const CellRobot& robot = *cell_.setup.robots[motion.robot];
  const std::vector<double>& end = motion.way->plan->end;
  motion.command.hold = nanoseconds(kSilence);
  motion.command.wish.speed = motion.speed;
  if (motion.line) {
    const Pose tcp = robot.facts->chain.forward(end);
    motion.command.wish.kind = jog::JogSetpoint::Kind::tcp_target;
    motion.command.wish.target = motion.goal.emplace<Pose>(Pose{tcp.position, normalized(tcp.rotation)});
  } else {
    motion.command.wish.kind = jog::JogSetpoint::Kind::joint_target;
    motion.command.wish.joints.fill(NAN);
    std::copy(end.begin(), end.end(), motion.command.wish.joints.begin());
    motion.goal = end;
  }
  motion.phase = Motion::Phase::switching;
  cell_.jogging.require_allowed(motion.robot);
}

void HeldMotions::start(Motion& motion) {
  if (motion.twist) {
    motion.twist->share =
        cell_.jogging.base_share(motion.robot, motion.twist->ahead, motion.twist->turn).share;
    push(motion, motion.twist->share);
    motion.session = 1;
  } else {
    if (!cell_.jogging.engage(motion.robot)) return;
    motion.session = cell_.jogging.session(motion.robot, 0);
    cell_.jogging.send(motion.robot, motion.session, motion.command);
  }
  motion.phase = Motion::Phase::moving;
  events_.push_back(event(motion, HeldEvent::What::begun));
}

bool HeldMotions::is_there(const Motion& motion, const jog::JogStatus& status) const {
  constexpr double kNear = 1e-4;  // rad, m
  constexpr double kSlow = 1e-3;  // m/s; the robot never counts as standing while it has a target
  if (motion.goal.index() == 0 || status.tcp_speed > kSlow || status.session != motion.session) return false;
  if (const Pose* place = std::get_if<Pose>(&motion.goal))
    return norm(status.tcp.position - place->position) < kNear &&
           angle_between(status.tcp.rotation, place->rotation) < kNear;
  const auto& joints = std::get<std::vector<double>>(motion.goal);
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (std::isfinite(joints[j]) && std::abs(status.joints[j] - joints[j]) > kNear) return false;
  return true;
}

void HeldMotions::report_hold(Motion& motion, const jog::JogStatus& status) {
  const bool going = status.session == motion.session && !status.standing;
  const jog::JogHold hold = going ? status.hold : jog::JogHold::none;
  const Motion::HeldBack now{word_of(hold), reason_text(cell_, motion.robot, hold, status.which),
                             which_text(cell_, motion.robot, hold, status.which)};
  if (motion.reported == now) return;
  motion.reported = now;
  HeldEvent out = event(motion, HeldEvent::What::held_back);
  out.why = now.why;
  out.text = now.text;
  out.which = now.which;
  events_.push_back(std::move(out));
}

void HeldMotions::follow(Motion& motion) {
  if (motion.twist) {
    if (cell_.machine.snapshot().state != control::RunState::running)
      return finish(motion, "stopped", "something stopped it: press again");
    return follow_base(motion);
  }
  const jog::JogStatus status = cell_.jogging.status(motion.robot);
  if (status.ended >= motion.session) return finish(motion, "stopped", "something stopped it: press again");
  if (is_there(motion, status)) finish(motion, "arrived", "");
}

/// A base slows down and stops before what is in its way.
void HeldMotions::follow_base(Motion& motion) {
  const BaseShare now = cell_.jogging.base_share(motion.robot, motion.twist->ahead, motion.twist->turn);
  try {
    if (now.share < 1 || motion.twist->share < 1) push(motion, now.share);
  } catch (const Error& e) {  // the controller was stopped or removed
    return finish(motion, e.problems().front().code, e.problems().front().what);
  }
  motion.twist->share = now.share;
  Motion::HeldBack held;
  if (!now.near.empty()) held = {word_of(jog::JogHold::body), "near " + now.near, now.near};
  if (motion.reported == held) return;
  motion.reported = held;
  HeldEvent out = event(motion, HeldEvent::What::held_back);
  out.why = held.why;
  out.text = held.text;
  out.which = held.which;
  events_.push_back(std::move(out));
}

void HeldMotions::advance(Motion& motion) {
  try {
    if (motion.phase != Motion::Phase::moving)  // a client sends heartbeats only after its motion has begun
      motion.dead_man.renew(cell_.machine.now(), nanoseconds(kSilence));
    if (motion.phase == Motion::Phase::planning) take_plan(motion);
    if (motion.phase == Motion::Phase::switching) start(motion);
  } catch (const Error& e) {
    finish(motion, "", "", &e);
  }
}

void HeldMotions::renew(std::uint64_t number) {
  Motion* const motion = find(number);
  if (!motion || motion->dead_man.expired(cell_.machine.now())) return;  // too late: tick() ends it
  motion->dead_man.renew(cell_.machine.now(), nanoseconds(kSilence));
  if (motion->phase != Motion::Phase::moving) return;
  try {
    if (motion->twist) return push(*motion, motion->twist->share);
    cell_.jogging.require_allowed(motion->robot);
    cell_.jogging.session(motion->robot, motion->session);  // throws if the session has ended
    cell_.jogging.send(motion->robot, motion->session, motion->command);
    report_hold(*motion, cell_.jogging.status(motion->robot));
  } catch (const Error& e) {
    const std::string& code = e.problems().front().code;
    finish(*motion, code == "session-over" ? "stopped" : code, e.problems().front().what);
  }
}

void HeldMotions::end(std::uint64_t number, const std::string& why) {
  if (Motion* const motion = find(number)) finish(*motion, why, "");
}

HeldEvent HeldMotions::event(const Motion& motion, HeldEvent::What what) const {
  HeldEvent out;
  out.motion = motion.number;
  out.what = what;
  out.robot = cell_.setup.robots[motion.robot]->entry.name;
  out.session = motion.session;
  return out;
}

/// Ends the motion. `why` and `text` apply to a motion that has begun; otherwise `refusal` does.
void HeldMotions::finish(Motion& motion, const std::string& why, const std::string& text,
                         const Error* refusal) {
  const bool had_begun = motion.phase == Motion::Phase::moving;
  motion.phase = Motion::Phase::over;
  if (motion.twist && had_begun) {
    Problems ignored;  // a controller that no longer accepts commands has stopped by itself
    collect(ignored, [&] { push(motion, 0); });
  }
  if (!motion.twist && motion.session != 0) cell_.jogging.end(motion.robot, motion.session);
  HeldEvent out = event(motion, had_begun ? HeldEvent::What::over : HeldEvent::What::refused);
  out.why = why;
  out.text = text;
  if (!had_begun)
    out.refusal = refusal ? *refusal : Error(why, "the key was released before the robot moved");
  events_.push_back(std::move(out));
}

void HeldMotions::tick() {
  for (const auto& motion : all_) {
    if (motion->phase == Motion::Phase::over) continue;
    advance(*motion);
    if (motion->phase == Motion::Phase::over) continue;
    if (motion->dead_man.expired(cell_.machine.now())) {
      finish(*motion, "lost", "no heartbeat came: press again");
    } else if (motion->phase == Motion::Phase::moving) {
      follow(*motion);
    }
  }
  std::erase_if(all_, [](const auto& motion) { return motion->phase == Motion::Phase::over; });
}

std::vector<HeldEvent> HeldMotions::take_events() {
  return std::exchange(events_, {});
}

}  // namespace polyarm::cell
