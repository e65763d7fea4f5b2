#include "polyarm/server/jog_watch.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/controllers/diff_drive_controller.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/protocol/status.hpp"
#include "polyarm/protocol/wire.hpp"

namespace polyarm::server {

namespace {

using protocol::Any;

double number_of(const std::optional<double>& given, const char* name, double fallback, double low, double high) {
  const double value = given.value_or(fallback);
  if (value >= low && value <= high) return value;
  throw Error("bad-argument", std::string("'") + name + "' is " + format_number(value) + ", not a number from " +
                                  format_number(low) + " to " + format_number(high));
}

/// The share of each of `count` axes that `axis` says: one axis by its number, or a number in [-1, 1] each.
std::vector<double> shares_of(const Any& given, const std::optional<double>& direction, std::size_t count) {
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

struct Wheels {
  std::string name;
  const controllers::DiffDriveController* controller = nullptr;
};

/// What drives the base of a robot; a null controller: nothing does.
Wheels wheels_of(cell::Cell& cell, const std::string& robot) {
  for (const control::ListedController& listed : cell.loop().controllers().list()) {
    const auto* wheels =
        dynamic_cast<const controllers::DiffDriveController*>(cell.loop().controllers().find(listed.name));
    if (wheels && !wheels->command_interfaces().empty() &&
        wheels->command_interfaces().front().starts_with(robot + "/"))
      return {listed.name, wheels};
  }
  return {};
}

/// What holds a motion back, in one word for programs.
std::string word_of(const std::string& held_back) {
  if (held_back == "joint limit") return "limit";
  if (held_back == "singularity") return "singular";
  return held_back;
}

}  // namespace

protocol::PlanPreview way_of(const protocol::JogGoto& request) {
  protocol::PlanPreview out;
  out.to = request.to;
  out.joints = request.joints;
  out.pose = request.pose;
  out.kind = request.kind;
  out.robot = request.robot;
  out.speed = request.speed;
  return out;
}

std::size_t JogWatch::robot_of(const std::optional<std::string>& name) const {
  const std::string wanted = name.value_or("");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < cell_.robots().size(); ++i) {
    names.push_back(cell_.robots()[i]->entry.name);
    if (names.back() == wanted) return i;
  }
  if (wanted.empty() && names.size() == 1) return 0;
  throw Error("unknown-robot", "there is no robot '" + wanted + "'" + did_you_mean(wanted, names),
              "there are: " + join(names, ", "));
}

/// The cell's `jog`. `amount`: of a step, rad or m; else a share of the greatest speed.
template <class Keys>
protocol::JogMotion JogWatch::wish_of(std::size_t i, const Keys& request, double amount, bool by) const {
  const cell::CellRobot& robot = *cell_.robots()[i];
  const std::string mode = request.mode.value_or("joint");
  protocol::JogMotion out;
  out.robot = robot.entry.name;
  const jog::JogLimits limits = cell_.jog_limits();
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

protocol::JogMotion JogWatch::step(const protocol::JogStep& request) const {
  const std::size_t robot = robot_of(request.robot);
  protocol::JogMotion out = wish_of(robot, request, number_of(request.amount, "amount", 0, -10, 10), true);
  out.by = true;
  out.speed = number_of(request.speed, "speed", 1, 0.001, 1);
  return out;
}

void JogWatch::begin(std::uint64_t client, const Any& id, const protocol::JogBegin& request) {
  const std::size_t robot = robot_of(request.robot);
  if (request.mode == "drive") return drive(client, id, robot, request);
  protocol::JogMotion wish = wish_of(robot, request, number_of(request.speed, "speed", 1, 0.001, 1), false);
  wish.hold = kSilence;
  const auto jog = begun_by(client, id, robot);
  jog->wish = std::move(wish);
  ask(jog);
}

/// By the twists that the controller of the wheels takes from anybody; no faster than the profile's TCP.
void JogWatch::drive(std::uint64_t client, const Any& id, std::size_t i, const protocol::JogBegin& request) {
  constexpr double kAny = 1;  // m/s and rad/s, of what states no limit
  const std::string& robot = cell_.robots()[i]->entry.name;
  const Wheels wheels = wheels_of(cell_, robot);
  if (!wheels.controller)
    throw Error("no-base", "no diff_drive_controller drives '" + robot + "'", "jog its joints or its TCP");
  cell_.jogging().require_allowed(i);
  const std::vector<double> shares = shares_of(request.axis, request.direction, 2);
  const double speed = number_of(request.speed, "speed", 1, 0.001, 1);
  const auto stated = [](double limit) { return std::isfinite(limit) && limit > 0 ? limit : kAny; };
  const jog::JogLimits limits = cell_.jog_limits();
  const double ahead = std::min(limits.tcp_speed, stated(wheels.controller->linear_limits().max_velocity)),
               turn = std::min(limits.tcp_turning, stated(wheels.controller->angular_limits().max_velocity));
  const auto twist = [&](double x, double z) {
    protocol::SendMessage out;
    out.to = wheels.name + "/cmd_vel";
    out.message =
        protocol::Message(nlohmann::json{{"linear", {{"x", x}}}, {"angular", {{"z", z}}}}.dump());
    return out;
  };
  const auto jog = begun_by(client, id, i);
  jog->wish = twist(shares[0] * speed * ahead, shares[1] * speed * turn);
  jog->rest = twist(0, 0);
  ask(jog);
}

std::shared_ptr<JogWatch::Jog> JogWatch::begun_by(std::uint64_t client, const Any& id, std::size_t robot) {
  auto jog = std::make_shared<Jog>();
  jog->robot = robot;
  jog->number = ++last_;
  jog->client = client;
  jog->id = id;
  jog->pressed = jog->beat = cell_.now();
  jogs_.push_back(jog);
  return jog;
}

void JogWatch::go_to(std::uint64_t client, const Any& id, const protocol::JogGoto& request) {
  const std::size_t i = robot_of(request.robot);
  const bool line = request.kind == protocol::MoveKind::line;
  const double speed = number_of(request.speed, "speed", 1, 0.001, 1);
  protocol::PlanPreview plan;
  plan.robot = cell_.robots()[i]->entry.name;
  plan.kind = request.kind;
  plan.joints = request.joints;
  plan.pose = request.pose;
  const auto jog = begun_by(client, id, i);
  jog->goes = jog->planning = jog->asked = true;
  const std::weak_ptr<const bool> here = here_;
  cell_.requests().ask(std::move(plan), [this, here, jog, speed, line](const protocol::Reply& reply) {
    if (here.expired()) return true;  // the server has gone meanwhile
    jog->planning = jog->asked = false;
    if (reply.refusal)
      jog->refused = reply.refusal;
    else
      take_plan(*jog, reply.answer->as<protocol::PlanPreview>(), line, speed);
    return true;
  });
}

/// The end of the way is the target: of the joints, or of the TCP on its line.
void JogWatch::take_plan(Jog& jog, const protocol::PlanPreview::Answer& plan, bool line, double speed) {
  const cell::CellRobot& robot = *cell_.robots()[jog.robot];
  protocol::FollowTarget target;
  target.robot = robot.entry.name;
  target.speed = speed;
  target.hold = kSilence;
  if (line) {
    const Vec3& p = plan.pose.p;
    const Quaternion& q = plan.pose.q;
    jog.place = {p, normalized(q)};
    target.pose = protocol::Map{{"position", nlohmann::json{p.x, p.y, p.z}},
                                {"orientation", nlohmann::json{q.x, q.y, q.z, q.w}}};
    target.frame = "world";
  } else {
    target.joints.emplace();
    for (const auto& [name, value] : plan.joints) (*target.joints)[name] = value;
    for (const controllers::JointFacts& joint : robot.joints) {
      const auto found = plan.joints.find(joint.name.substr(joint.name.find('/') + 1));
      jog.joints.push_back(found == plan.joints.end() ? NAN : found->second);
    }
  }
  jog.wish = std::move(target);
  jog.planned = true;
}

bool JogWatch::is_there(const Jog& jog) const {
  constexpr double kNear = 1e-4;  // rad, m
  constexpr double kSlow = 1e-3;  // m/s; as long as it is told where to go it never counts as standing
  const jog::JogStatus status = cell_.jogging().status(jog.robot);
  if (status.tcp_speed > kSlow || status.session != jog.session) return false;
  if (jog.joints.empty())
    return norm(status.tcp.position - jog.place.position) < kNear &&
           angle_between(status.tcp.rotation, jog.place.rotation) < kNear;
  for (std::size_t j = 0; j < jog.joints.size(); ++j)
    if (std::isfinite(jog.joints[j]) && std::abs(status.joints[j] - jog.joints[j]) > kNear) return false;
  return true;
}

namespace {
/// The same with the session that goes on.
protocol::Request with_session(const protocol::Request& request, std::uint32_t session) {
  if (&request.facts() == &protocol::JogMotion::kFacts) {
    protocol::JogMotion out = request.as<protocol::JogMotion>();
    out.session = session;
    return out;
  }
  if (&request.facts() == &protocol::FollowTarget::kFacts) {
    protocol::FollowTarget out = request.as<protocol::FollowTarget>();
    out.session = session;
    return out;
  }
  return request;
}
}  // namespace

/// Asks the cell, and notes what it answers.
void JogWatch::ask(const std::shared_ptr<Jog>& jog) {
  if (jog->asked) {  // the answer to the one before has not come: the motion begins
    jog->beaten = true;
    return;
  }
  jog->asked = true;
  cell_.requests().ask(jog->session != 0 ? with_session(*jog->wish, jog->session) : *jog->wish,
                       [this, here = std::weak_ptr(here_), jog](const protocol::Reply& reply) {
                         if (!here.expired()) take_reply(*jog, reply);
                         return true;
                       });
}

void JogWatch::take_reply(Jog& jog, const protocol::Reply& reply) const {
  jog.asked = false;
  if (reply.refusal) {
    jog.refused = reply.refusal;
    return;
  }
  if (jog.rest) {
    jog.session = 1;
    return;
  }
  const auto& answer = reply.answer->as<protocol::JogMotion>();  // of `target` as well
  jog.session = answer.session.value_or(0);
  jog.held_back = {};
  if (answer.held_back != "none") jog.held_back = {answer.held_back, answer.reason, answer.which};
}

void JogWatch::beat(std::uint64_t client, std::uint64_t number) {
  for (const auto& jog : jogs_) {
    if (jog->number != number || jog->client != client || jog->over) continue;
    if (seconds(cell_.now() - jog->beat) > kSilence) return;  // too late: tick() ends it
    jog->beat = cell_.now();
    ask(jog);
  }
}

void JogWatch::report(const Jog& jog, bool over, const std::string& why, const std::string& text,
                      const std::string& which) const {
  protocol::JogEvent event;
  event.jog = jog.number;
  event.robot = cell_.robots()[jog.robot]->entry.name;
  event.over = over;
  event.why = why;
  event.text = text;
  event.which = which;
  tell_(jog.client, protocol::any_of(event).dump());
}

void JogWatch::finish(Jog& jog, const std::string& why, const std::string& text) {
  if (std::exchange(jog.over, true)) return;
  if (jog.rest)
    cell_.requests().ask(*jog.rest, [](const protocol::Reply&) { return true; });
  else if (jog.session != 0)
    cell_.jogging().end(jog.robot, jog.session);
  if (jog.begun) return report(jog, true, why, jog.refused ? jog.refused->problems().front().what : text);
  tell_(jog.client, protocol::refusal_line(
                        jog.refused ? *jog.refused : Error(why, "the key was let go before it moved"), jog.id));
}

void JogWatch::end(std::uint64_t client, std::uint64_t number, const char* why) {
  for (const auto& jog : jogs_)
    if (jog->number == number && jog->client == client) finish(*jog, why, "");
}

void JogWatch::end_all(std::uint64_t client, const char* why) {
  for (const auto& jog : jogs_)
    if (jog->client == client) finish(*jog, why, "");
}

/// Reports that it moves, and what holds it back, when that changes.
void JogWatch::follow(Jog& jog) {
  if (jog.refused) {
    const std::string& code = jog.refused->problems().front().code;
    return finish(jog, code == "session-over" ? "stopped" : code, "");
  }
  if (jog.session == 0) return;
  if (!jog.begun) {
    jog.begun = true;
    const protocol::JogBegun begun{jog.number, jog.session, 0.05, kSilence};
    tell_(jog.client, protocol::result_line(protocol::any_of(begun), jog.id));
  }
  if (jog.rest) {
    if (cell_.snapshot().state != control::RunState::running)
      finish(jog, "stopped", "something stopped it: press again");
    return;
  }
  const jog::JogStatus status = cell_.jogging().status(jog.robot);
  if (status.ended >= jog.session) return finish(jog, "stopped", "something stopped it: press again");
  if (jog.goes && is_there(jog)) finish(jog, "arrived", "");
}

/// A key that is pressed while the joints settle from the motion before begins when they stand.
bool JogWatch::waits_for_rest(const std::shared_ptr<Jog>& jog) {
  constexpr double kPatience = 0.3;  // s
  if (!jog->refused || jog->begun || jog->refused->problems().front().code != "moving") return false;
  if (seconds(cell_.now() - jog->pressed) > kPatience) return false;
  jog->refused.reset();
  ask(jog);
  return true;
}

void JogWatch::tick() {
  const std::vector<std::shared_ptr<Jog>> all = jogs_;
  for (const auto& jog : all) {
    if (jog->over) continue;
    if (!jog->begun) jog->beat = cell_.now();  // a client beats once its motion has begun
    if (std::exchange(jog->planned, false)) ask(jog);
    if (seconds(cell_.now() - jog->beat) > kSilence) {
      finish(*jog, "lost", "no heartbeat came: press again");
      continue;
    }
    if (waits_for_rest(jog)) continue;
    follow(*jog);
    if (!jog->over && jog->begun && !jog->asked && std::exchange(jog->beaten, false)) ask(jog);
    if (jog->over || !jog->begun || jog->reported == jog->held_back) continue;
    jog->reported = jog->held_back;
    report(*jog, false, word_of(jog->held_back.by), jog->held_back.reason, jog->held_back.which);
  }
  // One that is over stays until the cell has answered, since only then its session is known and can be
  // ended.
  for (const auto& jog : jogs_)
    if (jog->over && jog->session != 0 && !jog->rest) cell_.jogging().end(jog->robot, jog->session);
  std::erase_if(jogs_, [](const auto& jog) { return jog->over && !jog->asked; });
}

}  // namespace polyarm::server
