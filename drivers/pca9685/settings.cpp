#include "drivers/pca9685/settings.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>

#include "drivers/pca9685/chip.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::drivers {

namespace {
constexpr const char* kEach[] = {"speed_scale", "trim",     "direction", "dead_band",
                                 "least_duty",  "max_duty", "stop"};
constexpr const char* kPins[] = {"pin_enable", "pin_pos", "pin_neg"};
// Without a stated time the watchdog waits for four writes, and a quarter of a second at least.
constexpr double kWatchdogCycles = 4, kLeastWatchdog = 0.25, kMostWatchdog = 5;

class Reader {
 public:
  explicit Reader(const hardware::ComponentContext& context) : context_(context) {}

  BoardSettings read() {
    wheels();
    board();
    for (std::size_t k = 0; k < out_.wheels.size(); ++k) motor(k);
    pins();
    watchdog();
    superfluous();
    problems_.throw_if_errors();
    return std::move(out_);
  }

 private:
  void bad(const std::string& what, const std::string& advice) {
    const std::string whole = context_.name + ": " + what;
    for (const Problem& told : problems_.list())  // one parameter may be wrong for several motors
      if (told.what == whole) return;
    problems_.error("bad-value", where_, whole, advice);
  }

  // --- what the description offers

  void wheels() {
    for (const hardware::RobotInstance& robot : context_.robots) {
      if (robot.hardware.empty())
        for (const std::string& joint : robot.model->joint_names())
          add_wheel(robot.name, joint, {"velocity"}, {"position", "velocity"});
      for (const description::HardwareInfo& block : robot.hardware) declared(robot.name, block);
    }
    if (out_.wheels.empty()) bad("there is no joint with a velocity command", "a board drives one to five");
    if (out_.wheels.size() > 5)
      bad(std::to_string(out_.wheels.size()) + " motors need more than 16 channels", "leave some out");
  }

  void declared(const std::string& robot, const description::HardwareInfo& block) {
    if (where_.file.empty()) where_ = block.where;
    rate_ = block.rw_rate;
    for (const description::ComponentInfo& part : block.components) {
      if (part.kind != "joint") {
        bad("the " + part.kind + " '" + part.name + "' is not something the board has", "leave it out");
        continue;
      }
      std::vector<std::string> commands, states;
      for (const auto& c : part.command_interfaces) commands.push_back(c.name);
      for (const auto& s : part.state_interfaces) states.push_back(s.name);
      add_wheel(robot, part.name, commands, states);
    }
  }

  void add_wheel(const std::string& robot, const std::string& joint, const std::vector<std::string>& commands,
                 const std::vector<std::string>& states) {
    const std::size_t wheel = out_.wheels.size();
    out_.wheels.push_back({joint, {}});
    if (commands != std::vector<std::string>{"velocity"})
      bad("the joint '" + joint + "' must have one command interface, velocity",
          "a motor without encoder "
          "knows no other");
    out_.commands.push_back({robot + "/" + joint + "/velocity"});
    out_.wheel_of_command.push_back(wheel);
    for (const std::string& state : states) {
      if (state != "velocity" && state != "position") {
        bad("the joint '" + joint + "' has no state '" + state + "'", "there are velocity and position");
        continue;
      }
      out_.states.push_back({robot + "/" + joint + "/" + state, 0});
      out_.state_of.push_back({wheel, state == "position"});
    }
  }

  // --- parameters

  std::optional<std::string> text(const std::string& key) const {
    const auto found = context_.parameters.find(key);
    if (found == context_.parameters.end()) return std::nullopt;
    return std::string(trim(found->second));
  }

  /// Of motor k: key_k, else key.
  std::optional<std::string> text(const std::string& key, std::size_t k) const {
    const auto own = text(key + "_" + std::to_string(k));
    return own ? own : text(key);
  }

  double number(const std::string& key, const std::optional<std::string>& given, double fallback, double low,
                double high, const char* unit) {
    if (!given) return fallback;
    const auto value = parse_number(*given);
    if (value && *value >= low && *value <= high) return *value;
    bad(key + " = '" + *given + "' is not a number from " + format_number(low) + " to " +
            format_number(high) + unit,
        "the usual value is " + format_number(fallback));
    return fallback;
  }

  /// A whole number of few digits, decimal or with 0x.
  static std::optional<int> integer(const std::string& given) {
    const bool hex = given.starts_with("0x") || given.starts_with("0X");
    const std::string digits = given.substr(hex ? 2 : 0);
    const auto is_digit = [&](unsigned char c) { return hex ? std::isxdigit(c) : std::isdigit(c); };
    if (digits.empty() || digits.size() > 4 || !std::all_of(digits.begin(), digits.end(), is_digit))
      return std::nullopt;
    return std::stoi(digits, nullptr, hex ? 16 : 10);
  }

  void board() {
    if (const auto bus = text("bus"))
      out_.bus = integer(*bus) ? "/dev/i2c-" + std::to_string(*integer(*bus)) : *bus;
    if (out_.bus.empty()) bad("bus is empty", "name it: /dev/i2c-1; `ls /dev/i2c-*` shows what there is");
    if (const auto given = text("address")) {
      const auto value = integer(*given);
      if (value && *value >= 0x40 && *value <= 0x7F)
        out_.address = static_cast<std::uint8_t>(*value);
      else
        bad("address = '" + *given + "' is no address of a PCA9685",
            "they are 0x40 to 0x7F; a JetBot's is "
            "0x60");
    }
    out_.frequency = number("frequency", text("frequency"), 1600, 24, 1743, " Hz");
    out_.prescale = prescale_for(out_.frequency).value_or(out_.prescale);
  }

  void motor(std::size_t k) {
    MotorSettings& m = out_.wheels[k].motor;
    const std::string tail = "_" + std::to_string(k);
    int* const channels[] = {&m.enable, &m.positive, &m.negative};
    for (int p = 0; p < 3; ++p) {
      const std::string key = kPins[p] + tail;
      const auto given = text(key);
      const auto value = given ? integer(*given) : std::nullopt;
      *channels[p] = -1;
      if (!given)
        bad(key + " is not stated, the channel of the motor of '" + out_.wheels[k].joint + "'",
            "channels are 0 to 15");
      else if (!value || *value > 15)
        bad(key + " = '" + *given + "' is no channel", "channels are 0 to 15");
      else
        *channels[p] = *value;
    }
    const auto of = [&](const char* key) { return text(key, k); };
    const auto called = [&](const char* key) {
      return context_.parameters.contains(key + tail) ? key + tail : std::string(key);
    };
    m.speed_scale = number(called("speed_scale"), of("speed_scale"), 1, 1e-3, 100, " per rad/s");
    m.trim = number(called("trim"), of("trim"), 1, 0.1, 10, "");
    m.dead_band = number(called("dead_band"), of("dead_band"), 0.001, 0, 100, " rad/s");
    m.least_duty = number(called("least_duty"), of("least_duty"), 0, 0, 0.95, "");
    m.most_duty = number(called("max_duty"), of("max_duty"), 1, 0, 1, "");
    if (m.most_duty < m.least_duty)
      bad("max_duty of motor " + std::to_string(k) + " is below its least_duty", "the motor never turns so");
    const std::string direction = of("direction").value_or("1");
    if (direction != "1" && direction != "-1" && direction != "+1")
      bad(called("direction") + " = '" + direction + "' is neither 1 nor -1", "-1 turns the motor round");
    m.direction = direction == "-1" ? -1 : 1;
    const std::string stop = of("stop").value_or("coast");
    if (stop != "coast" && stop != "brake")
      bad(called("stop") + " = '" + stop + "' is neither coast nor brake", "coast rolls out");
    m.brake = stop == "brake";
  }

  void pins() {
    std::map<int, std::size_t> taken;
    for (std::size_t k = 0; k < out_.wheels.size(); ++k) {
      const MotorSettings& m = out_.wheels[k].motor;
      for (const int channel : {m.enable, m.positive, m.negative})
        if (channel >= 0 && !taken.emplace(channel, k).second)
          bad("channel " + std::to_string(channel) + " is used twice, by motors " +
                  std::to_string(taken[channel]) + " and " + std::to_string(k),
              "each motor has three channels of its own");
    }
  }

  void watchdog() {
    out_.period = seconds(context_.period);
    if (rate_ > 0) out_.period = std::max(out_.period, 1.0 / rate_);
    const double usual = std::max(kLeastWatchdog, kWatchdogCycles * out_.period);
    const double least = std::ceil(2 * out_.period * 1e3);
    out_.watchdog_ms =
        static_cast<int>(number("watchdog_ms", text("watchdog_ms"), std::ceil(usual * 1e3),
                                std::max(least, 20.0), kMostWatchdog * 1e3, " ms (at least two writes)"));
  }

  /// A motor that there is not, or a key with a slip of the pen: what is silently ignored would drive
  /// wrongly.
  void superfluous() {
    std::vector<std::string> known = {"bus", "address", "frequency", "watchdog_ms"};
    for (const char* key : kEach) known.emplace_back(key);
    for (std::size_t k = 0; k < out_.wheels.size(); ++k) {
      for (const char* key : kEach) known.push_back(key + ("_" + std::to_string(k)));
      for (const char* key : kPins) known.push_back(key + ("_" + std::to_string(k)));
    }
    for (const auto& [key, value] : context_.parameters)
      if (std::find(known.begin(), known.end(), key) == known.end())
        bad("there is no parameter '" + key + "'" + did_you_mean(key, known),
            std::to_string(out_.wheels.size()) + " motors are counted from 0 in the order of their joints");
  }

  const hardware::ComponentContext& context_;
  BoardSettings out_;
  Problems problems_;
  Location where_;
  int rate_ = 0;
};
}  // namespace

BoardSettings read_settings(const hardware::ComponentContext& context) {
  return Reader(context).read();
}

}  // namespace polyarm::drivers
