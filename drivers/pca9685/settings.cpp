#include "drivers/pca9685/settings.hpp"

#include <algorithm>
#include <cassert>
#include <cctype>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/pca9685/chip.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::drivers {

namespace {
using hardware::DriverParameter;
using enum hardware::ParameterKind;

constexpr DriverParameter kParameters[] = {
    {"bus", text, "/dev/i2c-1", "the bus, or its number"},
    {"address", text, "0x60", "0x40 to 0x7F"},
    {"frequency", number, "1600", "Hz of the pulses", 24, 1743},
    {"watchdog_ms", number, "", "ms without a heartbeat until motors are turned off; 4 writes, at least 250"},
    {"pin_enable_K", number, nullptr, "channel of motor K, 0 to 15; also pin_pos_K and pin_neg_K", 0, 15},
    // For all motors; with _K, for motor K only.
    {"speed_scale", number, "1", "duty per rad/s of the wheel", 1e-3, 100},
    {"trim", number, "1", "factor on the duty", 0.1, 10},
    {"direction", text, "1", "-1 for a motor that turns the wrong way", 0, 0, "1 -1 +1"},
    {"dead_band", number, "0.001", "rad/s; slower is a stop", 0, 100},
    {"least_duty", number, "0", "the duty at which a motor begins to turn", 0, 0.95},
    {"max_duty", number, "1", "never more", 0, 1},
    {"stop", text, "coast", "or brake: what a motor does at speed 0", 0, 0, "coast brake"},
};
constexpr std::span<const DriverParameter> kAll = kParameters;
constexpr auto kOfBoard = kAll.first(4), kOfMotors = kAll.last(7);
constexpr hardware::DriverFacts kFacts = {
    "system", "DC motors on a PCA9685 board at I2C: the JetBot, motor HATs",
    "a register-exact chip, with its watchdog under SIGKILL and SIGSTOP; never on hardware", kParameters};
constexpr const char* kPins[] = {"pin_enable", "pin_pos", "pin_neg"};
// By default the watchdog waits for four writes, and at least a quarter of a second.
constexpr double kWatchdogCycles = 4, kLeastWatchdog = 0.25, kMostWatchdog = 5;

const DriverParameter& row(std::string_view name) {
  const auto found = std::find_if(std::begin(kParameters), std::end(kParameters),
                                  [&](const auto& r) { return name == r.name; });
  assert(found != std::end(kParameters) && "a parameter that is not in the table");
  return *found;
}

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
    if (out_.wheels.empty())
      bad("there is no joint with a velocity command",
          "a board drives one to five; name a description that has them (drivers test: --description FILE)");
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

  /// For motor k: key_k, else key.
  std::optional<std::string> text(const std::string& key, std::size_t k) const {
    const auto own = text(key + "_" + std::to_string(k));
    return own ? own : text(key);
  }

  double number(const std::string& key, const std::optional<std::string>& given, double fallback, double low,
                double high, const char* unit = "") {
    if (!given) return fallback;
    const auto value = parse_number(*given);
    if (value && *value >= low && *value <= high) return *value;
    bad(key + " = '" + *given + "' is not a number from " + format_number(low) + " to " +
            format_number(high) + unit,
        "the usual value is " + format_number(fallback));
    return fallback;
  }

  // The value of the table for motor k, or for all.

  double number(const char* name, std::size_t k) {
    const DriverParameter& r = row(name);
    return number(called(name, k), text(name, k), parse_number(r.fallback).value_or(0), r.least, r.most);
  }
  std::string choice(const char* name, std::size_t k) {
    const DriverParameter& r = row(name);
    const std::string value = text(name, k).value_or(r.fallback);
    const std::vector<std::string> all = split_words(r.one_of);
    if (std::find(all.begin(), all.end(), value) != all.end()) return value;
    bad(called(name, k) + " = '" + value + "' is not one of " + join(all, ", "), r.meaning);
    return r.fallback;
  }
  std::string called(const char* name, std::size_t k) const {
    const std::string own = name + ("_" + std::to_string(k));
    return context_.parameters.contains(own) ? own : name;
  }

  /// An integer of few digits, decimal or with 0x.
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
        bad("address = '" + *given + "' is not an address of a PCA9685",
            "they are 0x40 to 0x7F; a JetBot's is "
            "0x60");
    }
    const DriverParameter& f = row("frequency");
    out_.frequency = number("frequency", text("frequency"), out_.frequency, f.least, f.most, " Hz");
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
        bad(key + " = '" + *given + "' is not a channel", "channels are 0 to 15");
      else
        *channels[p] = *value;
    }
    m.speed_scale = number("speed_scale", k);
    m.trim = number("trim", k);
    m.dead_band = number("dead_band", k);
    m.least_duty = number("least_duty", k);
    m.most_duty = number("max_duty", k);
    if (m.most_duty < m.least_duty)
      bad("max_duty of motor " + std::to_string(k) + " is below its least_duty", "the motor never turns so");
    m.direction = choice("direction", k) == "-1" ? -1 : 1;
    m.brake = choice("stop", k) == "brake";
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

  /// Reports parameters of motors that do not exist and misspelt keys: silently ignoring one would cause
  /// wrong motion.
  void superfluous() {
    std::vector<std::string> known;
    for (const DriverParameter& r : kOfBoard) known.emplace_back(r.name);
    for (const DriverParameter& r : kOfMotors) known.emplace_back(r.name);
    for (std::size_t k = 0; k < out_.wheels.size(); ++k) {
      const std::string tail = "_" + std::to_string(k);
      for (const DriverParameter& r : kOfMotors) known.push_back(r.name + tail);
      for (const char* key : kPins) known.push_back(key + tail);
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

const hardware::DriverFacts& board_facts() {
  return kFacts;
}

BoardSettings read_settings(const hardware::ComponentContext& context) {
  return Reader(context).read();
}

}  // namespace polyarm::drivers
