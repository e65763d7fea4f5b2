/// Jogs a robot: with keys in a terminal, or by an amount of a joint or of the TCP.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "apps/client.hpp"
#include "apps/jog_keys.hpp"
#include "apps/keyboard.hpp"
#include "apps/verb.hpp"
#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/socket_door.hpp"

namespace polyarm::apps {

namespace {
using Clock = std::chrono::steady_clock;

struct JogArguments {
  ClientOptions client;
  std::vector<std::string> words;  // [CELL] [ROBOT]
  std::string robot, joint, tcp, by, speed, time, frame;
  double first = 0.7, hold = 0.3;  // s
};

/// One word names a running cell or a robot; two words name both.
void sort_words(JogArguments& a) {
  if (a.words.empty()) return;
  const auto running = cell::SocketDoor::running();
  const auto runs = [&](const std::string& name) {
    return std::any_of(running.begin(), running.end(), [&](const auto& path) { return path.stem() == name; });
  };
  if (a.words.size() == 2 || runs(a.words.front())) {
    a.client.cell = a.words.front();
    a.words.erase(a.words.begin());
  }
  if (!a.words.empty()) a.robot = a.words.front();
}

Json with_robot(const JogArguments& a, Json request) {
  if (!a.robot.empty()) request["robot"] = a.robot;
  return request;
}

// --- by an amount, for scripts --------------------------------------------------------------------------

void report(const JogArguments& a, const Json& state) {
  if (a.client.json) return fmt::print("{}\n", state.dump(1));
  fmt::print("{}\n{}\n", joints_line(state), tcp_line(state));
}

Json what_to_move(const JogArguments& a, const std::string& value) {
  Json out{{"request", "jog"}};
  if (!a.joint.empty()) {
    out["joints"] = {{a.joint, value}};
  } else {
    out["tcp"] = {{a.tcp, value}};
    if (!a.frame.empty()) out["frame"] = a.frame;
  }
  if (const auto number = parse_number(value))
    (a.joint.empty() ? out["tcp"][a.tcp] : out["joints"][a.joint]) = *number;
  return with_robot(a, std::move(out));
}

int jog_by(Client& client, const JogArguments& a) {
  Json request = what_to_move(a, a.by);
  request["by"] = true;
  if (!a.speed.empty()) {
    const auto share = parse_quantity(a.speed, Dimension::none);
    if (!share)
      throw Error("bad-value", "--speed is '" + a.speed + "', of a step it is a share", "--speed 20%");
    request["speed"] = *share;
  }
  client.send(request);
  for (;;) {
    const Json answer = client.receive(kTimeout);
    if (interrupted()) return kStopped;  // the cell stops the motion, because the client has gone
    if (answer.is_null())
      throw Error("no-answer", "the cell has not answered for two seconds", "is its process stopped?");
    const Json state = Client::result_of(answer);
    if (flag_of(part(answer, {"more"}))) continue;
    report(a, state);
    if (flag_of(state["done"])) return kOk;
    fmt::print(stderr, "polyarm jog: not the whole distance: {}\n", shown(state["reason"]));
    return kFailed;
  }
}

int jog_for(Client& client, const JogArguments& a) {
  const auto time = parse_quantity(a.time, Dimension::time);
  if (!time || !(*time > 0))
    throw Error("bad-value", "--for is '" + a.time + "', not a time above zero", "--for 1.5s");
  Json request = what_to_move(a, a.speed), state;
  const auto end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*time));
  std::string reason;
  while (Clock::now() < end && !interrupted()) {
    client.send(request);
    const Json answer = client.receive(kTimeout);
    if (answer.is_null()) break;
    state = Client::result_of(answer);
    request["session"] = state["session"];
    if (const std::string now = state["reason"]; !now.empty()) reason = now;
    Keyboard::pause(
        std::min(std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()), kSendEvery));
  }
  state = client.ask(with_robot(a, {{"request", "jog"}, {"end", true}, {"session", request["session"]}}));
  report(a, state);
  if (!reason.empty()) fmt::print(stderr, "polyarm jog: held back: {}\n", reason);
  return interrupted() ? kStopped : kOk;
}

}  // namespace

int run_jog(int argc, char** argv) {
  CommandLine app("Moves a robot of a running cell by hand", "polyarm jog");
  JogArguments a;
  app.add_option("names", a.words, "[CELL] [ROBOT], if there are several")->expected(0, 2);
  auto* joint = app.add_option("--joint", a.joint, "this joint (without keys)");
  auto* tcp = app.add_option("--tcp", a.tcp, "the TCP along x, y or z, or about rx, ry or rz (without keys)");
  auto* by = app.add_option("--by", a.by, "distance: 5deg, -20mm; numbers without a unit are rad or m");
  auto* speed = app.add_option("--speed", a.speed, "with --by a share (20%); with --for 10deg/s, 50mm/s");
  auto* time = app.add_option("--for", a.time, "duration at this speed: 1.5s");
  app.add_option("--frame", a.frame, "base, world, tool, or the name of a point of the cell");
  app.add_option("--hold", a.hold, "s without a repeat of the key until the robot stops")
      ->range(0.05, 1.0)
      ->capture_default_str();
  app.add_option("--first", a.first, "s until the first repeat of a key, as the keyboard is set")
      ->range(0.05, 2.0)
      ->capture_default_str();
  a.client.add_to(app);
  joint->excludes(tcp);
  by->excludes(time);
  time->needs(speed);
  app.footer(
      examples({"polyarm jog", "polyarm jog pick_and_place arm", "polyarm jog --joint elbow_joint --by 5deg",
                "polyarm jog --tcp z --by -20mm --frame tool",
                "polyarm jog --tcp x --speed 50mm/s --for 2s"}) +
      "\n" + kJogKeys);
  if (const auto code = app.parse(argc, argv)) return *code;
  const bool alone = !a.joint.empty() || !a.tcp.empty();
  if (alone == (a.by.empty() && a.time.empty())) {
    fmt::print(stderr,
               "polyarm jog: --joint or --tcp goes with --by AMOUNT, or with --speed and --for TIME\n");
    return kUsage;
  }
  sort_words(a);
  Client client(a.client.cell);
  if (alone) {
    catch_interrupts();
    return a.by.empty() ? jog_for(client, a) : jog_by(client, a);
  }
  JogScreen screen;
  screen.robot = a.robot;
  screen.frame = a.frame;
  screen.first = a.first;
  screen.hold = a.hold;
  jog_by_keys(client, screen);
  return kOk;
}

}  // namespace polyarm::apps
