#include "apps/jog_keys.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <numbers>
#include <vector>

#include "apps/keyboard.hpp"
#include "apps/terminal.hpp"

namespace polyarm::apps {

const char* const kJogKeys =
    "   q w e r t y u i   up: joints 1, 2, …; or x y z and turning about x y z\n"
    "   a s d f g h j k   down. Hold a key to move, release it to stop; space stops\n"
    "   Tab joints or TCP   TCP along: b base  n world  m tool  v your frame\n"
    "   + - faster, slower (or longer, shorter steps)   p by steps, or by holding\n";

namespace {
using Clock = std::chrono::steady_clock;

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::chrono::milliseconds kShowEvery{200};
constexpr const char* kUp = "qwertyui";
constexpr const char* kDown = "asdfghjk";
constexpr const char* kAxes[] = {"x", "y", "z", "rx", "ry", "rz"};
constexpr const char* kTcpNames[] = {"x", "y", "z", "roll", "pitch", "yaw"};
constexpr std::size_t kBar = 14;  // width of a joint's range bar, columns
constexpr std::size_t kJointColumn = 42 + kBar;
/// Speeds of the TCP (m/s) and of joints (rad/s), and steps (m, rad) for + and -.
constexpr double kSpeeds[] = {0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.15, 0.25, 0.5, 1};
constexpr double kSteps[] = {0.0001, 0.0005, 0.001, 0.005, 0.01, 0.05};

class Keys {
 public:
  Keys(Client& client, const JogScreen& a) : client_(client), a_(a), of_joints_(!a.tcp) {
    state_ = ask({{"request", "jog.state"}});
    joints_ = state_["names"].get<std::vector<std::string>>();
    own_frame_ = a.frame;
    if (!a.frame.empty()) frame_ = a.frame, of_joints_ = false;
  }

  /// Runs until the user ends it (false) or wants to store the position (true).
  bool run() {
    begin();
    keeps_ = false;
    Clock::time_point due = Clock::now(), show_due = due;
    while (!Keyboard::ended() && !keeps_) {
      const auto wait = std::chrono::ceil<std::chrono::milliseconds>(due - Clock::now());
      for (const char key : Keyboard::wait(wait)) take(key);
      if (axis_ >= 0 && Clock::now() >= until_) release_now();
      if (Clock::now() < due) continue;
      due = Clock::now() + kSendEvery;
      if (axis_ >= 0) move();
      if (Clock::now() < show_due) continue;
      show_due = Clock::now() + kShowEvery;
      if (axis_ < 0) state_ = ask({{"request", "jog.state"}});
      show();
    }
    release_now();
    return keeps_ && !Keyboard::ended();
  }

  /// Stores the position and prints what was stored.
  void keep() {
    state_ = ask({{"request", "jog.state"}});
    announced_ = a_.keep(state_);
  }

 private:
  Json ask(Json request) {
    client_.send(with_robot(std::move(request)));
    const auto end = Clock::now() + std::chrono::milliseconds(kTimeout);
    while (Clock::now() < end) {
      const Json answer = client_.receive(100);
      if (!answer.is_null()) return Client::result_of(answer);
    }
    throw Error("no-answer", "the cell has not answered for two seconds", "is its process stopped?");
  }

  Json with_robot(Json request) const {
    if (!a_.robot.empty()) request["robot"] = a_.robot;
    return request;
  }

  void take(char key) {
    if (key == '\x03' || key == '\x04' || key == '\x1c' || key == '0') return Keyboard::end();
    if ((key == '\r' || key == '\n') && a_.keep) {
      keeps_ = true;
      return;
    }
    announced_.clear();
    if (choose(key)) {
      release_now();
      return show();
    }
    int axis = -1, sign = 0;
    for (int k = 0; k < 8; ++k)
      if (key == kUp[k] || key == kDown[k]) axis = k, sign = key == kUp[k] ? 1 : -1;
    const int count = of_joints_ ? static_cast<int>(joints_.size()) : 6;
    if (axis < 0 || axis >= count) return release_now();
    if (by_steps_) return step(axis, sign);
    // The first repeat of a key comes late, the others follow quickly.
    const bool repeats = axis == axis_ && sign == sign_;
    until_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                std::chrono::duration<double>(repeats ? a_.hold : a_.first));
    if (repeats) return;
    if (axis_ >= 0) release_now();
    if (refused_) refused_ = false, problem_.clear();
    axis_ = axis;
    sign_ = sign;
    move();
  }

  /// Keys that select what the other keys move.
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

  /// Scales rotation: 1 m of the TCP counts as 2 rad, so 50 mm/s corresponds to 0.1 rad/s.
  double scaled(double value) const {
    const bool slides = of_joints_ ? flag_of(state_["slides"][static_cast<std::size_t>(axis_)]) : axis_ < 3;
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
      session_ = static_cast<std::uint32_t>(number_of(state_["session"]));
      problem_ = text_of(state_["reason"]);
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
    std::string typed;  // keys typed during the motion
    try {
      client_.send(with_robot(std::move(wanted)));
      bool requested_to_end = false;
      for (auto last = Clock::now(); Clock::now() - last < std::chrono::milliseconds(kTimeout);) {
        for (const char key : Keyboard::wait(std::chrono::milliseconds(0))) {
          if (key == '\x03' || key == '\x04') Keyboard::end();
          requested_to_end = true;
          typed += key;
        }
        if (requested_to_end || Keyboard::ended()) {
          client_.send(with_robot({{"request", "jog"}, {"end", true}}));
          requested_to_end = false;
          awaited_ += 1;
        }
        const Json answer = client_.receive(20);
        if (answer.is_null()) continue;
        last = Clock::now();
        state_ = Client::result_of(answer);
        problem_ = text_of(state_["reason"]);
        show();
        if (!flag_of(part(answer, {"more"})) && state_.contains("done")) break;
      }
      for (; awaited_ > 0; --awaited_) client_.receive(kTimeout);
    } catch (const Error& e) {
      if (e.problems().front().code == "cell-gone") throw;
      for (; awaited_ > 0; --awaited_) client_.receive(kTimeout);
      refuse(e);
    }
    // A key ends the step; a selection by the key applies to the next step.
    for (const char key : typed)
      if (choose(key)) show();
  }

  void release_now() {
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

  std::size_t rows() const { return std::max<std::size_t>(joints_.size(), 6); }

  /// Prints empty lines that show() overwrites.
  void begin() const {
    fmt::print("\njogging {}\n\n{}   {}0 or Ctrl-C ends\n\n", shown(state_["robot"]), kJogKeys,
               a_.keep ? "Enter stores this position under a name   " : "");
    for (std::size_t i = 0; i < rows() + 3; ++i) fmt::print("\n");
    show();
  }

  std::string keys_of(std::size_t i, bool here) const {
    return here && i < 8 ? fmt::format("{} {}", kUp[i], kDown[i]) : "   ";
  }
  std::string joint_column(std::size_t i) const {
    if (i >= joints_.size()) return std::string(kJointColumn, ' ');
    const Json value = state_["joints"][joints_[i]];
    const bool slides = flag_of(state_["slides"][i]), moves = of_joints_ && axis_ == static_cast<int>(i);
    return fmt::format("{} {}{:<22.22} {:>11}  {} ", keys_of(i, of_joints_), moves ? '>' : ' ', joints_[i],
                       joint_text(number_of(value), slides),
                       range_bar(number_of(value), state_["limits"][joints_[i]], kBar));
  }
  std::string tcp_column(std::size_t i) const {
    if (i >= 6) return "";
    const double value = number_of(state_[i < 3 ? "position" : "rpy"][i % 3]);
    const bool moves = !of_joints_ && axis_ == static_cast<int>(i);
    return fmt::format("{} {}{:<5} {:>11}", keys_of(i, !of_joints_), moves ? '>' : ' ', kTcpNames[i],
                       joint_text(value, i < 3));
  }

  void show() const {
    std::string out = own_return() + own_escape(fmt::format("[{}A", rows() + 3));
    out += fmt::format("{}{:<{}}{}\n", own_escape("[K"), "     joints", kJointColumn + 5, "TCP in the world");
    for (std::size_t i = 0; i < rows(); ++i)
      out += own_escape("[K") + fitting(joint_column(i) + tcp_column(i)) + "\n";
    out += own_escape("[K") + fitting(what_moves()) + "\n";
    out += own_escape("[K") + fitting(!problem_.empty() ? "held back: " + problem_ : announced_) + "\n";
    std::fputs(out.c_str(), stdout);
    std::fflush(stdout);
  }

  Client& client_;
  const JogScreen& a_;
  Json state_;
  std::vector<std::string> joints_;
  std::string frame_ = "base", own_frame_, problem_, announced_;
  bool of_joints_, by_steps_ = false, refused_ = false, keeps_ = false;
  int speed_ = 4, step_ = 2, axis_ = -1, sign_ = 0, awaited_ = 0;
  std::uint32_t session_ = 0;
  Clock::time_point until_;
};

}  // namespace

void jog_by_keys(Client& client, const JogScreen& screen) {
  Keys keys(client, screen);
  for (bool keeps_going = true; keeps_going;) {
    {
      const Keyboard keyboard("jog", "from a script: polyarm jog --joint NAME --by 5deg");
      keeps_going = keys.run();
    }
    fmt::print("\n");
    if (keeps_going) keys.keep();
  }
}

/// Rounds to hundredths; a result of zero has no sign.
static double hundredths(double value) {
  return std::round(100 * value) / 100 + 0.0;
}

std::string joint_text(double value, bool slides) {
  return fmt::format("{:.2f}{}", hundredths(value / (slides ? 1e-3 : kDegree)), slides ? " mm" : "°");
}

std::string range_bar(double value, const Json& limits, std::size_t width) {
  if (!limits.is_array() || limits.size() != 2) return std::string(width, ' ');
  const double low = number_of(limits[0]), high = number_of(limits[1]);
  const double share = high > low ? std::clamp((value - low) / (high - low), 0.0, 1.0) : 0;
  std::string out = "[" + std::string(width - 2, '-') + "]";
  out[1 + static_cast<std::size_t>(std::lround(share * static_cast<double>(width - 3)))] = '|';
  return out;
}

int terminal_columns() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string fitting(const std::string& line) {
  int columns = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if ((static_cast<unsigned char>(line[i]) & 0xC0) == 0x80) continue;  // inside a UTF-8 character
    if (++columns >= terminal_columns()) return line.substr(0, i);
  }
  return line;
}

std::string joints_line(const Json& state) {
  std::string out;
  for (std::size_t i = 0; i < state["names"].size(); ++i) {
    const std::string name = state["names"][i];
    out += fmt::format("{}{} {}", out.empty() ? "" : "  ", name,
                       joint_text(number_of(state["joints"][name]), flag_of(state["slides"][i])));
  }
  return out;
}

std::string tcp_line(const Json& state) {
  const auto at = [&](const char* key, std::size_t k, double unit) {
    return hundredths(number_of(state[key][k]) / unit);
  };
  return fmt::format("x {:.2f} y {:.2f} z {:.2f} mm   roll {:.2f} pitch {:.2f} yaw {:.2f}°",
                     at("position", 0, 1e-3), at("position", 1, 1e-3), at("position", 2, 1e-3),
                     at("rpy", 0, kDegree), at("rpy", 1, kDegree), at("rpy", 2, kDegree));
}

}  // namespace polyarm::apps
