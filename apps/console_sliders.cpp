/// Joint sliders in the terminal, like the joint trajectory controller of rqt.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "apps/console_move.hpp"
#include "apps/jog_keys.hpp"
#include "apps/keyboard.hpp"
#include "apps/terminal.hpp"

namespace polyarm::apps {

namespace {
using Clock = std::chrono::steady_clock;

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::chrono::milliseconds kSendEvery{50};
constexpr std::size_t kBar = 26;
constexpr double kSpeeds[] = {0.05, 0.1, 0.25, 0.5, 1};
/// Within this distance the robot has reached its slider, rad or m.
constexpr double kThere = 1e-4;

constexpr const char* kKeys =
    "   up, down   choose a joint           left, right   move its slider (H, L: by ten)\n"
    "   + -        faster, slower           space         stop here\n"
    "   0          all sliders to the robot, and end (also Ctrl-C)\n";

class Sliders {
 public:
  explicit Sliders(ConsoleCell& cell) : cell_(cell) {
    look();
    joints_ = state_["names"].get<std::vector<std::string>>();
    to_robot();
  }

  void run() {
    fmt::print("\njoint sliders of {}: the robot follows them\n\n{}\n", cell_.robot(), kKeys);
    for (std::size_t i = 0; i < joints_.size() + 2; ++i) fmt::print("\n");
    while (!Keyboard::ended()) {
      show();
      take(Keyboard::wait(kSendEvery));
      if (moving_)
        follow();
      else
        look();
    }
    stop();
  }

 private:
  void look() { state_ = cell_.ask({{"request", "jog.state"}}); }
  bool slides(std::size_t i) const { return state_["slides"][i].get<bool>(); }
  double at(std::size_t i) const { return state_["joints"][joints_[i]].get<double>(); }

  void to_robot() {
    sliders_.clear();
    for (std::size_t i = 0; i < joints_.size(); ++i) sliders_.push_back(at(i));
  }

  void take(const std::string& keys) {
    for (std::size_t k = 0; k < keys.size(); ++k) {
      char key = keys[k];
      if (key == '\x1b' && k + 2 < keys.size() && (keys[k + 1] == '[' || keys[k + 1] == 'O')) {
        constexpr const char* kArrows = "ABCD";  // up, down, right, left
        constexpr const char* kLetters = "kjlh";
        for (int a = 0; a < 4; ++a)
          if (keys[k + 2] == kArrows[a]) key = kLetters[a];
        k += 2;
      }
      act(key);
    }
  }

  void act(char key) {
    const std::size_t last = joints_.size() - 1;
    if (key == '\x03' || key == '\x04' || key == '0' || key == 'q') return Keyboard::end();
    if (key == 'k') chosen_ -= chosen_ > 0 ? 1 : 0;
    if (key == 'j') chosen_ += chosen_ < last ? 1 : 0;
    if (key == 'l' || key == 'h') slide(key == 'l' ? 1 : -1);
    if (key == 'L' || key == 'H') slide(key == 'L' ? 10 : -10);
    if (key == '+' || key == '=') speed_ = std::min<std::size_t>(speed_ + 1, std::size(kSpeeds) - 1);
    if (key == '-') speed_ -= speed_ > 0 ? 1 : 0;
    if (key == ' ') stop();
  }

  void slide(int by) {
    double& slider = sliders_[chosen_];
    slider += by * (slides(chosen_) ? 1e-3 : kDegree);
    if (const Json& limits = state_["limits"][joints_[chosen_]]; limits.is_array())
      slider = std::clamp(slider, limits[0].get<double>(), limits[1].get<double>());
    moving_ = true;
    problem_.clear();
  }

  /// Sends the sliders as the target; the robot follows only while this is repeated.
  void follow() {
    Json joints = Json::object();
    for (std::size_t i = 0; i < joints_.size(); ++i) joints[joints_[i]] = sliders_[i];
    Json request{{"request", "target"}, {"joints", joints}, {"speed", kSpeeds[speed_]}};
    if (session_ != 0) request["session"] = session_;
    try {
      state_ = cell_.ask(std::move(request));
      session_ = state_["session"].get<std::uint32_t>();
      problem_ = state_["reason"].get<std::string>();
      bool there = !state_["moving"].get<bool>();
      for (std::size_t i = 0; i < joints_.size(); ++i)
        there = there && std::abs(at(i) - sliders_[i]) < kThere;
      if (there) end_session();
    } catch (const Error& e) {
      if (!cell_.runs()) throw;
      session_ = 0;
      moving_ = false;
      problem_ = e.problems().front().what;
      look();
      to_robot();
    }
  }

  void end_session() {
    if (session_ != 0) cell_.ask({{"request", "jog"}, {"end", true}, {"session", session_}});
    session_ = 0;
    moving_ = false;
  }

  void stop() {
    if (!moving_) return;
    end_session();
    do look();
    while (state_["moving"].get<bool>());
    to_robot();
  }

  void show() const {
    std::string out = own_return() + own_escape(fmt::format("[{}A", joints_.size() + 2));
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      const Json& limits = state_["limits"][joints_[i]];
      out += own_escape("[K") +
             fitting(fmt::format(" {}{:<22.22} {} {:>11}  at {:>11}", i == chosen_ ? '>' : ' ', joints_[i],
                                 range_bar(sliders_[i], limits, kBar), joint_text(sliders_[i], slides(i)),
                                 joint_text(at(i), slides(i)))) +
             "\n";
    }
    out += own_escape("[K") +
           fitting(fmt::format("at {:.0f} % of the speed limits, profile {}", 100 * kSpeeds[speed_],
                               shown(state_["profile"]))) +
           "\n" + own_escape("[K") + fitting(problem_.empty() ? "" : "held back: " + problem_) + "\n";
    std::fputs(out.c_str(), stdout);
    std::fflush(stdout);
  }

  ConsoleCell& cell_;
  Json state_;
  std::vector<std::string> joints_;
  std::vector<double> sliders_;
  std::size_t chosen_ = 0, speed_ = 2;
  std::uint32_t session_ = 0;
  bool moving_ = false;
  std::string problem_;
};

}  // namespace

void joint_sliders(ConsoleCell& cell) {
  Sliders sliders(cell);
  const Keyboard keyboard("the sliders", "from a script: polyarm jog --joint NAME --by 5deg");
  sliders.run();
}

}  // namespace polyarm::apps
