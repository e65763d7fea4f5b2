/// Drives a base from the keyboard, with the keys of ROS's teleop_twist_keyboard.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "apps/client.hpp"
#include "apps/keyboard.hpp"
#include "apps/terminal.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {
using Clock = std::chrono::steady_clock;

constexpr double kFaster = 1.1, kSlower = 0.9;
constexpr std::chrono::milliseconds kSendEvery{50}, kTimeout{2000};

constexpr const char* kKeys =
    "   u    i    o      hold a key to drive, release it to stop\n"
    "   j    k    l      k or any other key stops\n"
    "   m    ,    .\n"
    "   q/z all speeds, w/x speed, e/c turning: 10 % more or less     Ctrl-C ends\n";

/// Direction of a key: forward and left, -1 to 1.
struct Direction {
  double forward = 0, left = 0;
  bool stands() const { return forward == 0 && left == 0; }
};

Direction direction_of(char key) {
  switch (key) {
    case 'i':
      return {1, 0};
    case 'o':
      return {1, -1};
    case 'j':
      return {0, 1};
    case 'l':
      return {0, -1};
    case 'u':
      return {1, 1};
    case ',':
      return {-1, 0};
    case '.':
      return {-1, 1};
    case 'm':
      return {-1, -1};
    default:
      return {};
  }
}

// --- the base -------------------------------------------------------------------------------------------

bool takes_twist(const Json& input) {
  for (const Json& type : input["types"])
    if (type == "geometry_msgs/Twist" || type == "geometry_msgs/TwistStamped") return true;
  return false;
}

struct Base {
  std::string controller, port;
  bool active = false;
};

/// All controllers that accept a twist, with their first such input.
std::vector<Base> bases_of(Client& client) {
  std::vector<Base> out;
  for (const Json& c : client.ask({{"request", "control.list"}}))
    for (const Json& input : c["inputs"])
      if (takes_twist(input)) {
        out.push_back({c["name"], input["name"], c["state"] == "active"});
        break;
      }
  return out;
}

/// `given`: a controller, or a topic (/jetbot_base_controller/cmd_vel); empty: the only base.
Base choose_base(std::vector<Base> bases, const std::string& given) {
  std::vector<std::string> names;
  for (const Base& base : bases) names.push_back(base.controller);
  if (bases.empty())
    throw Error("no-base", "no controller of this cell takes a twist, so there is no base to drive",
                "polyarm control list shows the controllers");
  if (!given.empty()) {
    const std::string topic = "/" + given + "/";
    std::erase_if(bases, [&](const Base& base) {
      return topic.find("/" + base.controller + "/") == std::string::npos && given != "/" + base.port &&
             given != base.port;
    });
    if (bases.empty())
      throw Error("no-base", "no base is driven by '" + given + "'" + did_you_mean(given, names),
                  "there are: " + join(names, ", "));
  }
  if (std::any_of(bases.begin(), bases.end(), [](const Base& b) { return b.active; }))
    std::erase_if(bases, [](const Base& b) { return !b.active; });
  if (!bases.front().active)
    throw Error("not-active", "the controller '" + bases.front().controller + "' is not active",
                "start it: polyarm control state " + bases.front().controller + " active");
  if (bases.size() > 1)
    throw Error("which-base", "there are several bases: " + join(names, ", "),
                "choose one: polyarm teleop " + bases.front().controller);
  return bases.front();
}

/// The controller's limit; `usual` if the limit is higher or not stated.
double limit_of(Client& client, const Base& base, const char* key, double usual) {
  try {
    const Json value =
        client.ask({{"request", "param.get"}, {"name", base.controller}, {"key", key}})["value"];
    const auto number = value.is_number()   ? std::optional(value.get<double>())
                        : value.is_string() ? parse_number(value.get<std::string>())
                                            : std::nullopt;
    return number && *number > 0 ? std::min(*number, usual) : usual;
  } catch (const Error&) {
    return usual;  // another type of base
  }
}

// --- driving --------------------------------------------------------------------------------------------

struct TeleopArguments {
  ClientOptions client;
  std::string name;
  double speed = 0, turn = 0;      // m/s, rad/s; 0: the controller's limit
  double first = 0.7, hold = 0.3;  // s
};

class Teleop {
 public:
  Teleop(Client& client, const Base& base, const TeleopArguments& a) : client_(client), base_(base), a_(a) {
    speed_ = a.speed > 0 ? a.speed : limit_of(client, base, "linear.x.max_velocity", 0.5);
    turn_ = a.turn > 0 ? a.turn : limit_of(client, base, "angular.z.max_velocity", 1.0);
  }

  void run() {
    fmt::print("driving {}\n\n{}\n", base_.controller, kKeys);
    show();
    Clock::time_point due = Clock::now();
    while (!Keyboard::ended()) {
      const auto wait = std::chrono::ceil<std::chrono::milliseconds>(due - Clock::now());
      for (const char key : Keyboard::wait(wait)) take(key);
      if (!direction_.stands() && Clock::now() >= until_) stand();
      if (Clock::now() < due && !told_late()) continue;
      due = Clock::now() + kSendEvery;
      send();
    }
    stand();
    send();
  }

 private:
  void take(char key) {
    if (key == '\x03' || key == '\x04' || key == '\x1c') Keyboard::end();
    if (pace(key)) return show();
    const Direction wanted = direction_of(key);
    if (wanted.stands()) return stand();
    // The first repeat of a key comes late, the others follow quickly.
    const bool repeats = key == key_;
    until_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                std::chrono::duration<double>(repeats ? a_.hold : a_.first));
    key_ = key;
    const bool same = wanted.forward == direction_.forward && wanted.left == direction_.left;
    direction_ = wanted;
    if (!same) show();
  }

  bool pace(char key) {
    const double factor = key == 'q' || key == 'w' || key == 'e'   ? kFaster
                          : key == 'z' || key == 'x' || key == 'c' ? kSlower
                                                                   : 1;
    if (factor == 1) return false;
    if (key != 'e' && key != 'c') speed_ *= factor;
    if (key != 'w' && key != 'x') turn_ *= factor;
    return true;
  }

  void stand() {
    key_ = 0;
    if (direction_.stands()) return;
    direction_ = {};
    zeros_ = 3;
    show();
  }

  /// True if the direction changed; a change is sent at once.
  bool told_late() const { return direction_.forward != sent_.forward || direction_.left != sent_.left; }

  /// While no key is held nothing is sent: after the last zero messages the stream ends, so other clients can
  /// drive.
  void send() {
    if (direction_.stands() && zeros_ == 0) return;
    if (direction_.stands()) --zeros_;
    sent_ = direction_;
    client_.send({{"request", "send"},
                  {"to", base_.controller + "/" + base_.port},
                  {"message",
                   {{"linear", {{"x", direction_.forward * speed_}, {"y", 0.0}, {"z", 0.0}}},
                    {"angular", {{"x", 0.0}, {"y", 0.0}, {"z", direction_.left * turn_}}}}}});
    expect_answer();
  }

  /// Waits a limited time for an answer; a cell that has hung must not block the terminal.
  void expect_answer() {
    for (const auto end = Clock::now() + kTimeout; Clock::now() < end;) {
      const Json answer = client_.receive(100);
      if (!answer.is_null()) return (void)Client::result_of(answer);
    }
    throw Error("no-answer", "the cell has not answered for two seconds", "is its process stopped?");
  }

  void show() const {
    fmt::print("{}{}speed {:.3g} m/s  turn {:.3g} rad/s   {}", own_return(), own_escape("[K"), speed_, turn_,
               direction_.stands() ? "standing"
                                   : fmt::format("driving {:+.3g} m/s {:+.3g} rad/s",
                                                 direction_.forward * speed_, direction_.left * turn_));
    std::fflush(stdout);
  }

  Client& client_;
  const Base& base_;
  const TeleopArguments& a_;
  double speed_ = 0, turn_ = 0;
  Direction direction_, sent_;
  char key_ = 0;
  int zeros_ = 0;
  Clock::time_point until_;
};

}  // namespace

int run_teleop(int argc, char** argv) {
  CommandLine app("Drives a base of a running cell from the keyboard", "polyarm teleop");
  TeleopArguments a;
  app.add_option("controller", a.name, "the base's controller, or its topic, if there are several");
  app.add_option("--speed", a.speed, "initial speed, m/s (the controller's limit, at most 0.5)")->positive();
  app.add_option("--turn", a.turn, "initial speed, rad/s (the controller's limit, at most 1)")->positive();
  app.add_option("--hold", a.hold, "s without a repeat of the key until the base stops")
      ->range(0.05, 1.0)
      ->capture_default_str();
  app.add_option("--first", a.first, "s until the first repeat of a key, as the keyboard is set")
      ->range(0.05, 2.0)
      ->capture_default_str();
  app.add_option("--cell", a.client.cell, "which cell, where several run");
  app.footer(examples({"polyarm teleop", "polyarm teleop jetbot_base_controller --speed 0.01",
                       "polyarm teleop --cell lab"}) +
             "\n" + kKeys);
  if (const auto code = app.parse(argc, argv)) return *code;
  Client client(a.client.cell);
  const Base base = choose_base(bases_of(client), a.name);
  Teleop teleop(client, base, a);
  {
    const Keyboard keyboard(
        "teleop", "to send a twist from a script: polyarm send CONTROLLER '{linear: {x: 0.1}}' --rate 10");
    try {
      teleop.run();
    } catch (const Error&) {
      fmt::print("\n");
      throw;
    }
  }
  fmt::print("\n");
  return kOk;
}

}  // namespace polyarm::apps
