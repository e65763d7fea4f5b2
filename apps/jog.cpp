/// Moving a robot by hand: keys in a terminal, or so much of a joint or of the TCP.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include "apps/client.hpp"
#include "apps/keyboard.hpp"
#include "apps/verb.hpp"
#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/socket_door.hpp"

namespace polyarm::apps {

namespace {
using Clock = std::chrono::steady_clock;

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::chrono::milliseconds kSendEvery{50}, kShowEvery{200};
constexpr int kPatience = 2000;  // ms
constexpr const char* kUp = "qwertyui";
constexpr const char* kDown = "asdfghjk";
constexpr const char* kAxes[] = {"x", "y", "z", "rx", "ry", "rz"};
/// Speeds of the TCP (m/s) and of joints (rad/s), and steps (m, rad), that + and - go through.
constexpr double kSpeeds[] = {0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.15, 0.25, 0.5, 1};
constexpr double kSteps[] = {0.0001, 0.0005, 0.001, 0.005, 0.01, 0.05};

constexpr const char* kKeys =
    "   q w e r t y u i   up: joints 1, 2, …, or x y z and turning about x y z   hold a key to move\n"
    "   a s d f g h j k   down                                                  let it go to stop\n"
    "   Tab joints or TCP   b base  n world  m tool  v your frame   space stop   Ctrl-C ends\n"
    "   + and - speed (or step)   p moves by steps, or as long as a key is held\n";

struct JogArguments {
  ClientOptions client;
  std::vector<std::string> words;  // [CELL] [ROBOT]
  std::string robot, joint, tcp, by, speed, time, frame;
  double first = 0.7, hold = 0.3;  // s
};

/// One word is a running cell or a robot; two are both.
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

std::string joints_line(const Json& state) {
  std::string out;
  for (std::size_t i = 0; i < state["names"].size(); ++i) {
    const std::string name = state["names"][i];
    const bool slides = state["slides"][i].get<bool>();
    out += fmt::format("{}{} {:.2f}{}", out.empty() ? "" : "  ", name,
                       state["joints"][name].get<double>() / (slides ? 1e-3 : kDegree), slides ? " mm" : "°");
  }
  return out;
}

std::string tcp_line(const Json& state) {
  const auto at = [&](const char* key, std::size_t k, double unit) {
    return state[key][k].get<double>() / unit;
  };
  return fmt::format("x {:.2f} y {:.2f} z {:.2f} mm   roll {:.2f} pitch {:.2f} yaw {:.2f}°",
                     at("position", 0, 1e-3), at("position", 1, 1e-3), at("position", 2, 1e-3),
                     at("rpy", 0, kDegree), at("rpy", 1, kDegree), at("rpy", 2, kDegree));
}

// --- by keys ----------------------------------------------------------------------------------------------

class Keys {
 public:
  Keys(Client& client, const JogArguments& a) : client_(client), a_(a) {
    state_ = ask({{"request", "jog.state"}});
    joints_ = state_["names"].get<std::vector<std::string>>();
    own_frame_ = a.frame;
    if (!a.frame.empty()) frame_ = a.frame, of_joints_ = false;
  }

  void run() {
    fmt::print("jogging {}\n\n{}\n\n\n\n", shown(state_["robot"]), kKeys);
    show();
    Clock::time_point due = Clock::now(), show_due = due;
    while (!Keyboard::ended()) {
      const auto wait = std::chrono::ceil<std::chrono::milliseconds>(due - Clock::now());
      for (const char key : Keyboard::wait(wait)) take(key);
      if (axis_ >= 0 && Clock::now() >= until_) let_go();
      if (Clock::now() < due) continue;
      due = Clock::now() + kSendEvery;
      if (axis_ >= 0) move();
      if (Clock::now() < show_due) continue;
      show_due = Clock::now() + kShowEvery;
      if (axis_ < 0) state_ = ask({{"request", "jog.state"}});
      show();
    }
    let_go();
  }

 private:
  Json ask(Json request) {
    client_.send(with_robot(a_, std::move(request)));
    const auto end = Clock::now() + std::chrono::milliseconds(kPatience);
    while (Clock::now() < end) {
      const Json answer = client_.receive(100);
      if (!answer.is_null()) return Client::result_of(answer);
    }
    throw Error("no-answer", "the cell has not answered for two seconds", "is its process stopped?");
  }

  void take(char key) {
    if (key == '\x03' || key == '\x04' || key == '\x1c') return Keyboard::end();
    if (choose(key)) {
      let_go();
      return show();
    }
    int axis = -1, sign = 0;
    for (int k = 0; k < 8; ++k)
      if (key == kUp[k] || key == kDown[k]) axis = k, sign = key == kUp[k] ? 1 : -1;
    const int count = of_joints_ ? static_cast<int>(joints_.size()) : 6;
    if (axis < 0 || axis >= count) return let_go();
    if (by_steps_) return step(axis, sign);
    // The first repeat of a key comes late, the others follow quickly.
    const bool repeats = axis == axis_ && sign == sign_;
    until_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                std::chrono::duration<double>(repeats ? a_.hold : a_.first));
    if (repeats) return;
    if (axis_ >= 0) let_go();
    if (refused_) refused_ = false, problem_.clear();
    axis_ = axis;
    sign_ = sign;
    move();
  }

  /// Keys that choose what the others move.
  bool choose(char key) {
    const auto frame = [&](const std::string& name) {
      frame_ = name;
      of_joints_ = false;
      return true;
    };
    switch (key) {
      case '\t':
        of_joints_ = !of_joints_;
        return true;
      case 'b':
        return frame("base");
      case 'n':
        return frame("world");
      case 'm':
        return frame("tool");
      case 'v':
        if (own_frame_.empty())
          problem_ = "start with --frame NAME to move along a frame of yours";
        else
          frame(own_frame_);
        return true;
      case 'p':
        by_steps_ = !by_steps_;
        return true;
      case '+':
      case '=':
        change(1);
        return true;
      case '-':
        change(-1);
        return true;
      default:
        return false;
    }
  }

  void change(int by) {
    const auto move = [by](int& i, int count) { i = std::clamp(i + by, 0, count - 1); };
    if (by_steps_)
      move(step_, static_cast<int>(std::size(kSteps)));
    else
      move(speed_, static_cast<int>(std::size(kSpeeds)));
  }

  /// A metre of the TCP counts as two radians: 50 mm/s go with 0.1 rad/s.
  double scaled(double value) const {
    const bool slides =
        of_joints_ ? state_["slides"][static_cast<std::size_t>(axis_)].get<bool>() : axis_ < 3;
    return slides ? value : 2 * value;
  }

  Json request(double value) const {
    Json out{{"request", "jog"}};
    const auto i = static_cast<std::size_t>(axis_);
    if (of_joints_)
      out["joints"] = {{joints_[i], value}};
    else
      out["tcp"] = {{kAxes[i], value}}, out["frame"] = frame_;
    return out;
  }

  void move() {
    try {
      Json wanted = request(sign_ * scaled(kSpeeds[speed_]));
      if (session_ != 0) wanted["session"] = session_;
      state_ = ask(std::move(wanted));
      session_ = state_["session"].get<std::uint32_t>();
      problem_ = state_["reason"].get<std::string>();
    } catch (const Error& e) {
      if (e.problems().front().code == "no-answer" || e.problems().front().code == "cell-gone") throw;
      refuse(e);
    }
  }

  void refuse(const Error& e) {
    axis_ = -1;
    session_ = 0;
    refused_ = true;
    problem_ = e.problems().front().what;
    if (!e.problems().front().advice.empty()) problem_ += " (" + e.problems().front().advice + ")";
    show();
  }

  void step(int axis, int sign) {
    axis_ = axis;
    Json wanted = request(sign * scaled(kSteps[step_]));
    axis_ = -1;
    wanted["by"] = true;
    problem_.clear();
    std::string typed;  // while it moved
    try {
      client_.send(with_robot(a_, std::move(wanted)));
      bool asked_to_end = false;
      for (auto last = Clock::now(); Clock::now() - last < std::chrono::milliseconds(kPatience);) {
        for (const char key : Keyboard::wait(std::chrono::milliseconds(0))) {
          if (key == '\x03' || key == '\x04') Keyboard::end();
          asked_to_end = true;
          typed += key;
        }
        if (asked_to_end || Keyboard::ended()) {
          client_.send(with_robot(a_, {{"request", "jog"}, {"end", true}}));
          asked_to_end = false;
          awaited_ += 1;
        }
        const Json answer = client_.receive(20);
        if (answer.is_null()) continue;
        last = Clock::now();
        state_ = Client::result_of(answer);
        problem_ = state_["reason"].get<std::string>();
        show();
        if (!answer.value("more", false) && state_.contains("done")) break;
      }
      for (; awaited_ > 0; --awaited_) client_.receive(kPatience);
    } catch (const Error& e) {
      if (e.problems().front().code == "cell-gone") throw;
      for (; awaited_ > 0; --awaited_) client_.receive(kPatience);
      refuse(e);
    }
    // A key ends the step; what it chooses holds for the next one.
    for (const char key : typed)
      if (choose(key)) show();
  }

  void let_go() {
    if (axis_ < 0) return;
    axis_ = -1;
    if (session_ != 0) state_ = ask({{"request", "jog"}, {"end", true}, {"session", session_}});
    session_ = 0;
    show();
  }

  std::string what_moves() const {
    const double value = by_steps_ ? kSteps[step_] : kSpeeds[speed_];
    const char* per = by_steps_ ? "" : "/s";
    std::string out = of_joints_ ? fmt::format("joints, {:.3g}°{}", 2 * value / kDegree, per)
                                 : fmt::format("TCP along {}, {:.3g} mm{} and {:.3g}°{}", frame_, 1e3 * value,
                                               per, 2 * value / kDegree, per);
    if (by_steps_) out += " by step";
    return out + ", profile " + shown(state_["profile"]);
  }

  void show() const {
    fmt::print("\r\x1b[3A\x1b[K{}\n\x1b[K{}\n\x1b[K{}{}{}\n", joints_line(state_), tcp_line(state_),
               what_moves(), problem_.empty() ? "" : "   held back: ", problem_);
    std::fflush(stdout);
  }

  Client& client_;
  const JogArguments& a_;
  Json state_;
  std::vector<std::string> joints_;
  std::string frame_ = "base", own_frame_, problem_;
  bool of_joints_ = true, by_steps_ = false, refused_ = false;
  int speed_ = 4, step_ = 2, axis_ = -1, sign_ = 0, awaited_ = 0;
  std::uint32_t session_ = 0;
  Clock::time_point until_;
};

// --- by so much, for scripts ------------------------------------------------------------------------------

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
    const Json answer = client.receive(kPatience);
    if (interrupted()) return kStopped;  // and the cell stops, as nobody is there any more
    if (answer.is_null())
      throw Error("no-answer", "the cell has not answered for two seconds", "is its process stopped?");
    const Json state = Client::result_of(answer);
    if (answer.value("more", false)) continue;
    report(a, state);
    if (state["done"].get<bool>()) return kOk;
    fmt::print(stderr, "polyarm jog: not all of the way: {}\n", shown(state["reason"]));
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
    const Json answer = client.receive(kPatience);
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
  CLI::App app("Moves a robot of a running cell by hand", "polyarm jog");
  JogArguments a;
  app.add_option("names", a.words, "[CELL] [ROBOT], where there are several")->expected(0, 2);
  auto* joint = app.add_option("--joint", a.joint, "this joint (without keys)");
  auto* tcp = app.add_option("--tcp", a.tcp, "the TCP along x, y or z, or about rx, ry or rz (without keys)");
  auto* by = app.add_option("--by", a.by, "by so much: 5deg, -20mm; bare numbers are rad or m");
  auto* speed = app.add_option("--speed", a.speed, "with --by a share (20%); with --for 10deg/s, 50mm/s");
  auto* time = app.add_option("--for", a.time, "at this speed for so long: 1.5s");
  app.add_option("--frame", a.frame, "base, world, tool, or the name of a point of the cell");
  app.add_option("--hold", a.hold, "s without a repeat of the key until the robot stops")
      ->check(CLI::Range(0.05, 1.0))
      ->capture_default_str();
  app.add_option("--first", a.first, "s until the first repeat of a key, as the keyboard is set")
      ->check(CLI::Range(0.05, 2.0))
      ->capture_default_str();
  a.client.add_to(app);
  joint->excludes(tcp);
  by->excludes(time);
  time->needs(speed);
  app.footer(
      examples({"polyarm jog", "polyarm jog pick_and_place arm", "polyarm jog --joint elbow_joint --by 5deg",
                "polyarm jog --tcp z --by -20mm --frame tool",
                "polyarm jog --tcp x --speed 50mm/s --for 2s"}) +
      "\n" + kKeys);
  if (const auto code = parse(app, argc, argv)) return *code;
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
  Keys keys(client, a);
  {
    const Keyboard keyboard("jog", "from a script: polyarm jog --joint NAME --by 5deg");
    keys.run();
  }
  fmt::print("\n");
  return kOk;
}

}  // namespace polyarm::apps
