#include "polyarm/server/jog_watch.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/controllers/diff_drive_controller.hpp"

namespace polyarm::server {

namespace {

using Json = nlohmann::json;

double number_of(const Json& request, const char* name, double fallback, double low, double high) {
  const auto found = request.find(name);
  if (found == request.end() || found->is_null()) return fallback;
  const double value = found->is_number() ? found->get<double>() : NAN;
  if (!(value >= low && value <= high))
    throw Error("bad-argument", std::string("'") + name + "' is " + found->dump() + ", not a number from " +
                                    format_number(low) + " to " + format_number(high));
  return value;
}

std::string text_of(const Json& request, const char* name, const std::string& fallback) {
  const auto found = request.find(name);
  if (found == request.end() || found->is_null()) return fallback;
  if (!found->is_string()) throw Error("bad-argument", std::string("'") + name + "' is no text");
  return found->get<std::string>();
}

/// The share of each of `count` axes that `axis` says: one axis by its number, or a number in [-1, 1] each.
std::vector<double> shares_of(const Json& request, std::size_t count) {
  std::vector<double> out(count, 0.0);
  const Json axis = request.value("axis", Json());
  if (axis.is_number_integer() && axis.get<std::int64_t>() >= 0 && axis.get<std::uint64_t>() < count) {
    out[axis.get<std::size_t>()] = number_of(request, "direction", 1, -1, 1);
    return out;
  }
  bool good = axis.is_array() && axis.size() == count;
  for (std::size_t i = 0; good && i < count; ++i) {
    good = axis[i].is_number() && std::abs(axis[i].get<double>()) <= 1;
    if (good) out[i] = axis[i].get<double>();
  }
  if (!good)
    throw Error("bad-argument", "'axis' is " + axis.dump(),
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

std::size_t JogWatch::robot_of(const Json& request) const {
  const std::string wanted = text_of(request, "robot", "");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < cell_.robots().size(); ++i) {
    names.push_back(cell_.robots()[i]->entry.name);
    if (names.back() == wanted) return i;
  }
  if (wanted.empty() && names.size() == 1) return 0;
  throw Error("unknown-robot", "there is no robot '" + wanted + "'" + did_you_mean(wanted, names),
              "there are: " + join(names, ", "));
}

/// The arguments of the cell's `jog`. `amount`: of a step, rad or m; else a share of the greatest speed.
Json JogWatch::wish_of(std::size_t i, const Json& request, double amount, bool by) const {
  const cell::CellRobot& robot = *cell_.robots()[i];
  const std::string mode = text_of(request, "mode", "joint");
  Json out{{"request", "jog"}, {"robot", robot.entry.name}};
  const jog::JogLimits limits = cell_.jog_limits();
  if (mode == "joint") {
    const std::vector<double> shares = shares_of(request, robot.joints.size());
    Json joints = Json::object();
    for (std::size_t j = 0; j < shares.size(); ++j) {
      if (shares[j] == 0) continue;
      const double full = by ? 1 : robot.facts->limits[j].velocity * limits.joint_share;
      joints[robot.joints[j].name.substr(robot.joints[j].name.find('/') + 1)] = shares[j] * amount * full;
    }
    out["joints"] = joints;
    return out;
  }
  if (mode != "tcp") throw Error("bad-argument", "there is no mode '" + mode + "'", "joint or tcp");
  const std::vector<double> shares = shares_of(request, 6);
  constexpr const char* kAxes[] = {"x", "y", "z", "rx", "ry", "rz"};
  const double way = by ? 1 : std::min(limits.tcp_speed, robot.facts->tcp.speed),
               turn = by ? 1 : std::min(limits.tcp_turning, robot.facts->tcp.turn_speed);
  Json tcp = Json::object();
  for (std::size_t k = 0; k < 6; ++k)
    if (shares[k] != 0) tcp[kAxes[k]] = shares[k] * amount * (k < 3 ? way : turn);
  out["tcp"] = tcp;
  const std::string frame = text_of(request, "frame", "base");
  out["frame"] = frame.starts_with("user:") ? frame.substr(5) : frame;
  return out;
}

Json JogWatch::step(const Json& request) const {
  const std::size_t robot = robot_of(request);
  const double amount = number_of(request, "amount", 0, -10, 10);
  Json out = wish_of(robot, request, amount, true);
  out["by"] = true;
  out["speed"] = number_of(request, "speed", 1, 0.001, 1);
  return out;
}

void JogWatch::begin(std::uint64_t client, const Json& request) {
  const std::size_t robot = robot_of(request);
  if (text_of(request, "mode", "joint") == "drive") return drive(client, robot, request);
  const Json wish = wish_of(robot, request, number_of(request, "speed", 1, 0.001, 1), false);
  const auto jog = begun_by(client, robot, request);
  jog->wish = wish;
  jog->wish["hold"] = kSilence;
  ask(jog);
}

/// By the twists that the controller of the wheels takes from anybody; it goes no faster than the profile's
/// TCP.
void JogWatch::drive(std::uint64_t client, std::size_t i, const Json& request) {
  constexpr double kAny = 1;  // m/s and rad/s, of what states no limit
  const std::string& robot = cell_.robots()[i]->entry.name;
  const Wheels wheels = wheels_of(cell_, robot);
  if (!wheels.controller)
    throw Error("no-base", "no diff_drive_controller drives '" + robot + "'", "jog its joints or its TCP");
  cell_.jogging().require_allowed(i);
  const std::vector<double> shares = shares_of(request, 2);
  const double speed = number_of(request, "speed", 1, 0.001, 1);
  const auto stated = [](double limit) { return std::isfinite(limit) && limit > 0 ? limit : kAny; };
  const jog::JogLimits limits = cell_.jog_limits();
  const double ahead = std::min(limits.tcp_speed, stated(wheels.controller->linear_limits().max_velocity)),
               turn = std::min(limits.tcp_turning, stated(wheels.controller->angular_limits().max_velocity));
  const auto twist = [&](double x, double z) -> Json {
    return {{"request", "send"},
            {"to", wheels.name + "/cmd_vel"},
            {"message", Json{{"linear", {{"x", x}}}, {"angular", {{"z", z}}}}.dump()}};
  };
  const auto jog = begun_by(client, i, request);
  jog->drives = true;
  jog->wish = twist(shares[0] * speed * ahead, shares[1] * speed * turn);
  jog->rest = twist(0, 0);
  ask(jog);
}

std::shared_ptr<JogWatch::Jog> JogWatch::begun_by(std::uint64_t client, std::size_t robot,
                                                  const Json& request) {
  auto jog = std::make_shared<Jog>();
  jog->robot = robot;
  jog->number = ++last_;
  jog->client = client;
  jog->id = request.value("id", Json());
  jog->beat = cell_.now();
  jogs_.push_back(jog);
  return jog;
}

void JogWatch::go_to(std::uint64_t client, const Json& request) {
  const std::size_t i = robot_of(request);
  const std::string kind = text_of(request, "kind", "joint");
  const double speed = number_of(request, "speed", 1, 0.001, 1);
  Json plan{{"request", "plan.preview"}, {"robot", cell_.robots()[i]->entry.name}, {"kind", kind}};
  for (const char* const what : {"joints", "pose"})
    if (request.contains(what)) plan[what] = request[what];
  const auto jog = begun_by(client, i, request);
  jog->goes = jog->planning = jog->asked = true;
  const std::weak_ptr<const bool> here = here_;
  cell_.requests().handle(plan.dump(),
                          [this, here, jog, speed, line = kind == "line"](const std::string& text) {
                            if (here.expired()) return true;  // the server has gone meanwhile
                            const Json answer = Json::parse(text, nullptr, false);
                            jog->planning = jog->asked = false;
                            if (!answer.value("ok", false))
                              jog->refused = answer.value("error", Json::object()).dump();
                            else
                              take_plan(*jog, answer["result"], line, speed);
                            return true;
                          });
}

/// Where the way ends is what is gone to: by the joints, or the TCP on its line.
void JogWatch::take_plan(Jog& jog, const Json& plan, bool line, double speed) {
  const cell::CellRobot& robot = *cell_.robots()[jog.robot];
  jog.wish = {{"request", "target"}, {"robot", robot.entry.name}, {"speed", speed}, {"hold", kSilence}};
  if (line) {
    const auto p = plan["pose"]["p"].get<std::vector<double>>(),
               q = plan["pose"]["q"].get<std::vector<double>>();
    jog.place = {{p[0], p[1], p[2]}, normalized(Quaternion{q[0], q[1], q[2], q[3]})};
    jog.wish["pose"] = {{"position", p}, {"orientation", q}};
    jog.wish["frame"] = "world";
  } else {
    jog.wish["joints"] = plan["joints"];
    for (const controllers::JointFacts& joint : robot.joints)
      jog.joints.push_back(plan["joints"].value(joint.name.substr(joint.name.find('/') + 1), NAN));
  }
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

/// Asks the cell, and notes what it says.
void JogWatch::ask(const std::shared_ptr<Jog>& jog) {
  if (jog->asked) {  // the answer to the one before has not come: the motion begins
    jog->beaten = true;
    return;
  }
  Json request = jog->wish;
  if (jog->session != 0 && !jog->drives) request["session"] = jog->session;
  jog->asked = true;
  cell_.requests().handle(request.dump(), [jog](const std::string& line) {
    const Json answer = Json::parse(line, nullptr, false);
    jog->asked = false;
    if (!answer.value("ok", false)) {
      jog->refused = answer.value("error", Json::object()).dump();
      return true;
    }
    jog->session = jog->drives ? 1 : answer["result"].value("session", std::uint32_t{0});
    const Json& now = answer["result"];
    const std::string held_back = now.value("held_back", "none");
    jog->held_back = held_back == "none" ? Json()
                                         : Json{{"why", word_of(held_back)},
                                                {"text", now.value("reason", "")},
                                                {"which", now.value("which", "")}};
    return true;
  });
}

void JogWatch::beat(std::uint64_t client, std::uint64_t number) {
  for (const auto& jog : jogs_) {
    if (jog->number != number || jog->client != client || jog->over) continue;
    if (seconds(cell_.now() - jog->beat) > kSilence) return;  // too late: tick() ends it
    jog->beat = cell_.now();
    ask(jog);
  }
}

void JogWatch::finish(Jog& jog, const std::string& why, const std::string& text) {
  if (std::exchange(jog.over, true)) return;
  if (jog.drives)
    cell_.requests().handle(jog.rest.dump(), [](const std::string&) { return true; });
  else if (jog.session != 0)
    cell_.jogging().end(jog.robot, jog.session);
  if (!jog.begun) {
    const Json error = Json::parse(text, nullptr, false);
    Json answer{{"ok", false},
                {"error", error.is_object() ? error
                                            : Json{{"code", why},
                                                   {"what", "the key was let go before it moved"},
                                                   {"advice", ""},
                                                   {"where", ""}}}};
    if (!jog.id.is_null()) answer["id"] = jog.id;
    return tell_(jog.client, answer);
  }
  const Json error = Json::parse(text, nullptr, false);
  tell_(jog.client, {{"event", "jog"},
                     {"jog", jog.number},
                     {"robot", cell_.robots()[jog.robot]->entry.name},
                     {"over", true},
                     {"why", why},
                     {"text", error.is_object() ? error.value("what", "") : text}});
}

void JogWatch::end(std::uint64_t client, std::uint64_t number, const char* why) {
  for (const auto& jog : jogs_)
    if (jog->number == number && jog->client == client) finish(*jog, why, "");
}

void JogWatch::end_all(std::uint64_t client, const char* why) {
  for (const auto& jog : jogs_)
    if (jog->client == client) finish(*jog, why, "");
}

/// Says that it moves, and what holds it back, when that changes.
void JogWatch::follow(Jog& jog) {
  if (!jog.refused.empty()) {
    const std::string code = Json::parse(jog.refused, nullptr, false).value("code", "refused");
    return finish(jog, code == "session-over" ? "stopped" : code, jog.refused);
  }
  if (jog.session == 0) return;
  if (!jog.begun) {
    jog.begun = true;
    Json answer{{"ok", true},
                {"result",
                 {{"jog", jog.number}, {"session", jog.session}, {"beat_s", 0.05}, {"silence_s", kSilence}}}};
    if (!jog.id.is_null()) answer["id"] = jog.id;
    tell_(jog.client, answer);
  }
  if (jog.drives) {
    if (cell_.snapshot().state != control::RunState::running)
      finish(jog, "stopped", "something stopped it: press again");
    return;
  }
  const jog::JogStatus status = cell_.jogging().status(jog.robot);
  if (status.ended >= jog.session) return finish(jog, "stopped", "something stopped it: press again");
  if (jog.goes && is_there(jog)) finish(jog, "arrived", "");
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
    follow(*jog);
    if (!jog->over && jog->begun && !jog->asked && std::exchange(jog->beaten, false)) ask(jog);
    if (jog->over || !jog->begun || jog->told == jog->held_back) continue;
    jog->told = jog->held_back;
    Json event{{"event", "jog"}, {"jog", jog->number}, {"robot", cell_.robots()[jog->robot]->entry.name},
               {"over", false},  {"why", ""},          {"text", ""},
               {"which", ""}};
    if (!jog->held_back.is_null()) event.update(jog->held_back);
    tell_(jog->client, event);
  }
  // One that is over stays until the cell has answered, since only then its session is known and can be
  // ended.
  for (const auto& jog : jogs_)
    if (jog->over && jog->session != 0 && !jog->drives) cell_.jogging().end(jog->robot, jog->session);
  std::erase_if(jogs_, [](const auto& jog) { return jog->over && !jog->asked; });
}

}  // namespace polyarm::server
