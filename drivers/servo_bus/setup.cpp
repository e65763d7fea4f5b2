#include "drivers/servo_bus/setup.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/servo_bus/parameters.hpp"
#include "drivers/servo_bus/progress.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::servo_bus {

namespace {
using Values = std::map<std::string, std::string>;

// For a loop whose cycle is too slow for the default time of the watchdog.
constexpr double kWatchdogWrites = 4;

const std::vector<std::string> kStates = {"position", "velocity",    "effort",
                                          "current",  "temperature", "voltage"};

std::vector<std::string> joint_parameters(const Family& family) {
  std::vector<std::string> out;
  for (const hardware::DriverParameter& row : facts_of(family).parameters)
    if (std::string_view(row.name).starts_with(kOfJoint)) out.emplace_back(row.name + kOfJoint.size());
  return out;
}

/// Reads values from a map by the table, and collects their faults.
class Reader {
 public:
  /// `group`: "" or kOfJoint. `prefix`: the group's name in messages.
  Reader(const Family& family, std::string_view group, const Values& values, std::string prefix,
         Location where, Problems& problems)
      : rows_(facts_of(family).parameters),
        group_(group),
        values_(values),
        prefix_(std::move(prefix)),
        where_(std::move(where)),
        problems_(problems) {}

  std::optional<std::string> text(const std::string& key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) return std::nullopt;
    return std::string(trim(found->second));
  }
  /// The given value, if it is valid.
  std::optional<double> given(const std::string& key) const {
    const auto given = text(key);
    if (!given) return std::nullopt;
    const hardware::DriverParameter& r = row(key);
    const auto value = parse_number(*given);
    if (value && *value >= r.least && *value <= r.most) return value;
    wrong(key, *given, "a number from " + format_number(r.least) + " to " + format_number(r.most));
    return std::nullopt;
  }
  std::optional<int> given_whole(const std::string& key) const {
    const auto value = given(key);
    if (!value) return std::nullopt;
    if (*value == std::floor(*value)) return static_cast<int>(*value);
    wrong(key, *text(key), "a whole number");
    return std::nullopt;
  }
  /// The given value, else the default.
  double number(const std::string& key) const { return given(key).value_or(fallback(key)); }
  int whole(const std::string& key) const {
    return given_whole(key).value_or(static_cast<int>(fallback(key)));
  }
  std::string choice(const std::string& key) const {
    const hardware::DriverParameter& r = row(key);
    const std::string value = text(key).value_or(r.fallback);
    const std::vector<std::string> all = split_words(r.one_of);
    if (std::find(all.begin(), all.end(), value) != all.end()) return value;
    wrong(key, value, "one of " + join(all, ", "));
    return r.fallback;
  }
  bool flag(const std::string& key) const {
    const std::string value = text(key).value_or(row(key).fallback);
    if (equal_ignoring_case(value, "false")) return false;
    if (!equal_ignoring_case(value, "true")) wrong(key, value, "true or false");
    return true;
  }
  void wrong(const std::string& key, const std::string& value, const std::string& wanted) const {
    problems_.error("bad-value", where_, prefix_ + key + " = '" + value + "' is not " + wanted);
  }
  void missing(const std::string& key, const std::string& advice) const {
    problems_.error("missing-parameter", where_, "the parameter " + prefix_ + key + " is missing", advice);
  }

 private:
  const hardware::DriverParameter& row(const std::string& key) const {
    const std::string name = std::string(group_) + key;
    const auto found =
        std::find_if(rows_.begin(), rows_.end(), [&](const auto& r) { return name == r.name; });
    assert(found != rows_.end() && "a parameter that is not in the table");
    return *found;
  }
  double fallback(const std::string& key) const {
    return row(key).fallback ? parse_number(row(key).fallback).value_or(0) : 0;
  }

  std::span<const hardware::DriverParameter> rows_;
  std::string_view group_;
  const Values& values_;
  std::string prefix_;
  Location where_;
  Problems& problems_;
};

/// Finds the calibration file beside the description or in the working directory; empty: not found.
std::filesystem::path find_calibration(const std::string& given, const hardware::ComponentContext& context) {
  std::error_code ignored;
  for (const hardware::RobotInstance& robot : context.robots)
    for (const description::HardwareInfo& info : robot.hardware) {
      const auto beside = std::filesystem::path(info.where.file).parent_path() / given;
      if (!info.where.file.empty() && std::filesystem::exists(beside, ignored)) return beside;
    }
  return std::filesystem::exists(given, ignored) ? std::filesystem::path(given) : std::filesystem::path();
}

/// The values of each joint, from the file that `polyarm setup` has written.
std::map<std::string, Values> read_calibration(const hardware::ComponentContext& context,
                                               const Family& family, const Values& bus, Problems& problems) {
  std::map<std::string, Values> out;
  const auto given = bus.find("calibration");
  if (given == bus.end() || trim(given->second).empty()) return out;
  collect(problems, [&] {
    const auto path = find_calibration(std::string(trim(given->second)), context);
    if (path.empty())
      throw Error("no-calibration",
                  "there is no calibration '" + given->second + "' beside the description, nor here",
                  std::string("make it with `polyarm setup ") + family.name + " --calibration FILE`");
    if (const auto unfinished = read_progress(path, family);
        unfinished && unfinished->stage == Progress::Stage::writing)
      throw Error(Problem{"unfinished-calibration",
                          {progress_file(path).string()},
                          "a new calibration has been measured, and is only partly in the servos",
                          std::string("run `polyarm setup ") + family.name + " --calibration " +
                              path.string() + "` again: it continues"});
    const Yaml yaml = Yaml::load(path.string());
    if (yaml["polyarm"].text("") != "servo_calibration/1")
      problems.error("wrong-kind", yaml.where(), "this is not a servo_calibration/1 file",
                     std::string("make one with `polyarm setup ") + family.name + "`");
    if (const std::string made_for = yaml["family"].text(family.name); made_for != family.name)
      problems.error("wrong-kind", yaml["family"].where(),
                     "this calibration is of " + made_for + " servos, not of " + family.name);
    for (const std::string& joint : yaml["joints"].keys())
      for (const std::string& key : yaml["joints"][joint].keys())
        out[joint][key] = yaml["joints"][joint][key].text();
  });
  return out;
}

/// A joint from the description or the robot.
struct Declared {
  std::string robot, name;
  Values values;
  std::vector<std::string> states, commands;
  Location where;
};

std::vector<Declared> declared_joints(const hardware::ComponentContext& context) {
  std::vector<Declared> out;
  for (const hardware::RobotInstance& robot : context.robots) {
    for (const description::HardwareInfo& info : robot.hardware)
      for (const description::ComponentInfo& part : info.components) {
        if (part.kind != "joint") continue;
        Declared joint{robot.name, part.name, part.parameters, {}, {}, part.where};
        for (const auto& state : part.state_interfaces) joint.states.push_back(state.name);
        for (const auto& command : part.command_interfaces) joint.commands.push_back(command.name);
        out.push_back(std::move(joint));
      }
    if (robot.hardware.empty() && robot.model)
      for (const std::string& name : robot.model->joint_names())
        out.push_back({robot.name, name, {}, kStates, {}, {}});
  }
  return out;
}

Mode read_mode(const Declared& joint, const Family& family, const Reader& read) {
  std::vector<std::string> modes{"position", "velocity"};
  if (family.mode_current >= 0) modes.emplace_back("current");
  const auto asked = read.text("mode");
  std::string chosen = asked.value_or("position");
  if (!asked && joint.commands.size() == 1) chosen = joint.commands.front();
  if (chosen == "effort" && family.mode_current >= 0) chosen = "current";
  if (std::find(modes.begin(), modes.end(), chosen) == modes.end()) {
    read.wrong("mode", chosen, "one of " + join(modes, ", "));
    return Mode::position;
  }
  if (!asked && joint.commands.size() > 1)
    read.missing("mode", "the joint has several command interfaces and a servo takes one: choose one");
  return chosen == "position" ? Mode::position : chosen == "velocity" ? Mode::velocity : Mode::current;
}

JointSetup read_joint(const Declared& joint, const Family& family, Problems& problems) {
  const Reader read(family, kOfJoint, joint.values, joint.name + ".", joint.where, problems);
  JointSetup out;
  out.interface = joint.robot + "/" + joint.name;
  out.name = joint.name;
  out.mode = read_mode(joint, family, read);
  if (!joint.values.contains("id"))
    read.missing("id", std::string("`polyarm setup ") + family.name + "` writes it into a calibration file");
  out.id = static_cast<std::uint8_t>(read.whole("id"));
  out.direction = read.whole("direction");
  if (out.direction == 0) read.wrong("direction", "0", "1 or -1");
  out.offset = read.number("offset");
  out.zero = read.whole("zero");
  out.min = read.given_whole("min");
  out.max = read.given_whole("max");
  if (out.min && out.max && *out.min >= *out.max)
    problems.error("bad-value", joint.where, joint.name + ".min is not below " + joint.name + ".max");
  if (const auto model = read.text("model"); model && *model == "any")
    out.any_model = true;
  else
    out.model = read.given_whole("model");
  out.torque_limit = read.given("torque_limit");
  out.max_temperature = read.given("max_temperature");
  out.effort_scale = read.number("effort_scale");
  out.stall_effort = read.given("stall_effort");
  out.stall_time = read.number("stall_time");
  for (const std::string& state : joint.states) {
    if (std::find(kStates.begin(), kStates.end(), state) == kStates.end())
      problems.error("unknown-interface", joint.where,
                     joint.name + " has no state '" + state + "'" + did_you_mean(state, kStates),
                     "a servo reports " + join(kStates, ", "));
    out.states.push_back(state);
  }
  return out;
}

/// Merges the cell's `joint.parameter` values and the calibration; the cell has priority.
void merge(std::vector<Declared>& joints, const Values& bus, const std::map<std::string, Values>& calibration,
           const Family& family, Problems& problems) {
  for (Declared& joint : joints)
    if (const auto found = calibration.find(joint.name); found != calibration.end())
      joint.values.insert(found->second.begin(), found->second.end());
  for (const auto& [key, value] : bus) {
    const auto dot = key.rfind('.');
    if (dot == std::string::npos) continue;
    const std::string name = key.substr(0, dot), parameter = key.substr(dot + 1);
    const auto joint =
        std::find_if(joints.begin(), joints.end(), [&](const Declared& j) { return j.name == name; });
    std::vector<std::string> names;
    for (const Declared& j : joints) names.push_back(j.name);
    if (joint == joints.end())
      problems.error("unknown-joint", {},
                     key + ": there is no joint '" + name + "'" + did_you_mean(name, names));
    else
      joint->values[parameter] = value;
  }
  const std::vector<std::string> known = joint_parameters(family);
  for (const Declared& joint : joints)
    for (const auto& [key, value] : joint.values)
      if (std::find(known.begin(), known.end(), key) == known.end() && bus.contains(joint.name + "." + key))
        problems.error("unknown-parameter", joint.where,
                       "there is no parameter " + joint.name + "." + key + did_you_mean(key, known));
}

/// The time between two writes, s.
double write_period(const hardware::ComponentContext& context) {
  double out = seconds(context.period);
  for (const hardware::RobotInstance& robot : context.robots)
    for (const description::HardwareInfo& info : robot.hardware)
      if (info.rw_rate > 0) out = std::max(out, 1.0 / info.rw_rate);
  return out;
}
}  // namespace

const char* name(Mode mode) {
  return mode == Mode::position ? "position" : mode == Mode::velocity ? "velocity" : "current";
}

BusSetup read_setup(const hardware::ComponentContext& context, const Family& family) {
  Problems problems;
  BusSetup out;
  const Reader read(family, "", context.parameters, "", {}, problems);
  out.port = read.text("port").value_or("");
  if (out.port.empty())
    read.missing(
        "port", std::string("for example /dev/serial/by-id/…; `polyarm setup ") + family.name + "` finds it");
  out.baud = read.whole("baud");
  out.answer_timeout = nanoseconds(read.number("answer_timeout_ms") / 1000);
  out.lost_cycles = read.whole("lost_cycles");
  out.lowers_on_shutdown = read.choice("torque_off") == "on_shutdown";
  out.release_time = nanoseconds(read.number("release_time"));
  out.led_by_hand = read.flag("by_hand");
  if (family.watchdog) {
    out.fast_sync_read = read.flag("fast_sync_read");
    out.bus_watchdog_ms = read.whole("bus_watchdog_ms");
  }
  out.period = write_period(context);
  out.watchdog_ms = read.whole("watchdog_ms");
  if (out.watchdog_ms * 1e-3 < 2 * out.period) {
    if (read.text("watchdog_ms"))
      read.wrong("watchdog_ms", *read.text("watchdog_ms"),
                 "long enough for two writes, which are " + format_number(out.period * 1e3) + " ms apart");
    out.watchdog_ms = static_cast<int>(std::ceil(kWatchdogWrites * out.period * 1e3));
  }

  std::vector<Declared> joints = declared_joints(context);
  merge(joints, context.parameters, read_calibration(context, family, context.parameters, problems), family,
        problems);
  for (const Declared& joint : joints) out.joints.push_back(read_joint(joint, family, problems));
  if (out.joints.empty())
    problems.error(
        "no-joints", {}, context.name + " has no joints to drive",
        "name a description whose <ros2_control> block has them (drivers test: --description FILE)");
  if (out.joints.size() > 32) problems.error("too-many-joints", {}, "a bus takes 32 joints at most");
  for (std::size_t i = 0; i < out.joints.size(); ++i)
    for (std::size_t j = i + 1; j < out.joints.size(); ++j)
      if (out.joints[i].id == out.joints[j].id && joints[i].values.contains("id") &&
          joints[j].values.contains("id"))
        problems.error("same-id", joints[j].where,
                       out.joints[i].name + " and " + out.joints[j].name + " have the same servo id " +
                           std::to_string(out.joints[i].id));
  const std::string watchdog = read.choice("watchdog");
  const bool turns = std::any_of(out.joints.begin(), out.joints.end(),
                                 [](const JointSetup& joint) { return joint.mode == Mode::velocity; });
  out.all_watched = watchdog == "on";
  out.watched = out.all_watched || (watchdog == "auto" && turns && !family.watchdog);
  problems.throw_if_errors();
  return out;
}

}  // namespace polyarm::servo_bus
