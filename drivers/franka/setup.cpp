#include "drivers/franka/setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "drivers/franka/errors.hpp"
#include "drivers/franka/limits.hpp"
#include "drivers/wire/six_axes.hpp"
#include "drivers/wire/udp.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::franka {

namespace {

constexpr int kCounted = 1000;                 // states for their rate
constexpr double kFewLost = 0.01;              // of them
constexpr Nanoseconds kLateState = 2'000'000;  // between two states

const char* system_of(int version) {
  constexpr const char* kSystems[] = {"Panda, system 4.2",        "Research 3, system 5.2",
                                      "Research 3, system 5.5",   "Research 3, system 5.7",
                                      "Research 3, system 5.7.2", "Research 3, system 5.9"};
  return kSystems[std::clamp(version, kOldestVersion, kNewestVersion) - kOldestVersion];
}

class Setup {
 public:
  explicit Setup(SetupOptions& options) : o_(options), port_(options.host, options.port) {}
  bool run() {
    const bool found = look_for_robot();
    if (found) {
      look_at_state();
      look_at_rate();
      if (o_.hand) look_at_hand();
    }
    say_steps();
    const bool fine = found && fine_;
    o_.say(fine ? "Everything that can be seen from here is ready."
                : "Not everything is ready: see above. Then run this again.");
    return fine;
  }

 private:
  bool wrong(Cause cause, int detail = 0, const std::string& text = {}) {
    o_.say("  " + sentence(cause, detail, "the controller at " + o_.host, text));
    return fine_ = false;
  }
  bool look_for_robot() {
    o_.say(fmt::format("Looking for the robot at {}:{} …", o_.host, o_.port));
    Refusal why;
    const auto bind = [&](const std::string& address) {
      std::string failed;
      own_ = address;
      states_ = wire::bind_udp(address, 0, failed);
      if (!states_) why = {Cause::unreachable, 0, failed};
      return states_ ? wire::local_port(states_.number()) : 0;
    };
    if (!connect_robot(port_, version_, o_.timeout, bind, why)) return wrong(why.cause, why.detail, why.text);
    o_.say(fmt::format("  found: version {} of the Franka Control Interface ({})", version_,
                       system_of(version_)));
    return next_state();
  }
  /// The next state; false after the timeout.
  bool next_state() {
    const Nanoseconds deadline = realtime::monotonic_now() + o_.timeout;
    std::array<std::uint8_t, 2500> bytes;
    for (;;) {
      const wire::Received got = wire::receive_datagram(states_.number(), bytes);
      if (got.got == wire::Got::bytes) {
        const auto state = decode_state(Bytes(bytes).first(got.count), version_);
        if (!state) return wrong(Cause::bad_data);
        state_ = *state;
        return true;
      }
      const Nanoseconds left = deadline - realtime::monotonic_now();
      if (left <= 0)
        return wrong(Cause::silent, 0, own_ + ":" + std::to_string(wire::local_port(states_.number())));
      wire::wait_readable(states_.number(), left);
    }
  }
  void look_at_state() {
    Seven degrees = state_.q;
    for (double& one : degrees) one *= wire::kDegrees;
    o_.say(fmt::format("  mode: {}", name(state_.mode)));
    o_.say(fmt::format("  joints {:.3f} degrees", fmt::join(degrees, " ")));
    const double away =
        std::abs(*std::max_element(state_.tau_ext.begin(), state_.tau_ext.end(),
                                   [](double a, double b) { return std::abs(a) < std::abs(b); }));
    o_.say(fmt::format("  load {:.3f} kg; largest external torque {:.2f} N m{}", state_.load.mass, away,
                       away > 3 ? ": set end effector and load in Desk, as they are" : ""));
    const int error = first_error(state_.errors);
    if (state_.mode == RobotMode::user_stopped) wrong(Cause::user_stop);
    if (state_.mode == RobotMode::guiding) wrong(Cause::guiding);
    if (state_.mode == RobotMode::other) wrong(Cause::locked);
    if (error >= 0)
      o_.say("  error: " + error_names(state_.errors) + ": " + error_facts(error).words +
             "; activating recovers from it");
  }
  /// Whether states come every millisecond; nothing is commanded.
  void look_at_rate() {
    std::uint64_t lost = 0, id = state_.id;
    int late = 0;
    const Nanoseconds begin = realtime::monotonic_now();
    Nanoseconds before = begin;
    for (int i = 0; i < kCounted; ++i) {
      if (!next_state()) return;
      const Nanoseconds now = realtime::monotonic_now();
      late += now - before > kLateState;
      before = now;
      if (state_.id > id) lost += state_.id - id - 1;
      id = std::max(id, state_.id);
    }
    const double rate = kCounted / seconds(realtime::monotonic_now() - begin);
    o_.say(fmt::format("  states: {:.0f} a second, {} of {} lost, {} late", rate, lost, kCounted, late));
    if (static_cast<double>(lost + static_cast<std::uint64_t>(late)) <= kFewLost * kCounted) return;
    o_.say(
        "  the network or this computer is too slow for 1000 Hz: use a cable without a switch, and a "
        "real-time "
        "kernel");
    fine_ = false;
  }
  void look_at_hand() {
    HandSettings settings;
    settings.port = o_.hand_port;
    Hand hand(o_.host, settings);
    if (!hand.open(o_.timeout)) {
      wrong(hand.refusal().cause, hand.refusal().detail, hand.refusal().text);
      return;
    }
    o_.say(fmt::format("  hand: {:.1f} mm open of {:.1f} mm, {} °C{}", 1000 * hand.state().width,
                       1000 * hand.state().max_width, hand.state().temperature,
                       hand.state().max_width > 0 ? "" : "; it has not found its range (`tool/homing`)"));
  }
  void say_steps() {
    o_.say("In Desk (https://" + o_.host + "):");
    o_.say(
        "  - open the brakes, choose Execution, activate FCI; keep the control in this computer's browser");
    o_.say("  - choose the end effector that is mounted, with its mass and centre");
    o_.say("  - release the user stop; keep it in your hand");
  }

  SetupOptions& o_;
  Port port_;
  int version_ = kNewestVersion;
  Descriptor states_;
  std::string own_;
  RobotState state_;
  bool fine_ = true;
};

}  // namespace

bool set_up(SetupOptions options) {
  return Setup(options).run();
}

}  // namespace polyarm::franka
