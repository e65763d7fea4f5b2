#include "drivers/servo_bus/setup.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/yaml.hpp"

namespace polyarm::servo_bus {

namespace {
using Values = std::map<std::string, std::string>;

const std::vector<std::string> kJointParameters = {
    "id",    "mode",         "direction",       "offset",       "zero",         "min",       "max",
    "model", "torque_limit", "max_temperature", "effort_scale", "stall_effort", "stall_time"};
const std::vector<std::string> kStates = {"position", "velocity",    "effort",
                                          "current",  "temperature", "voltage"};

/// Takes values out of a map and collects what is wrong with them.
class Reader {
 public:
  Reader(const Values& values, std::string prefix, Location where, Problems& problems)
      : values_(values), prefix_(std::move(prefix)), where_(std::move(where)), problems_(problems) {}

  std::optional<std::string> text(const std::string& key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) return std::nullopt;
    return std::string(trim(found->second));
  }
  std::optional<double> number(const std::string& key, double lower, double upper) const {
    const auto given = text(key);
    if (!given) return std::nullopt;
    const auto value = parse_number(*given);
    if (value && *value >= lower && *value <= upper) return value;
    wrong(key, *given, "a number from " + format_number(lower) + " to " + format_number(upper));
    return std::nullopt;
  }
  std::optional<int> integer(const std::string& key, int lower, int upper) const {
    const auto value = number(key, lower, upper);
    if (!value) return std::nullopt;
    if (*value == std::floor(*value)) return static_cast<int>(*value);
    wrong(key, *text(key), "a whole number");
    return std::nullopt;
  }
  bool flag(const std::string& key) const {
    const auto given = text(key);
    if (!given || equal_ignoring_case(*given, "false")) return false;
    if (!equal_ignoring_case(*given, "true")) wrong(key, *given, "true or false");
    return true;
  }
  void wrong(const std::string& key, const std::string& value, const std::string& wanted) const {
    problems_.error("bad-value", where_, prefix_ + key + " = '" + value + "' is not " + wanted);
  }
  void missing(const std::string& key, const std::string& advice) const {
    problems_.error("missing-parameter", where_, "the parameter " + prefix_ + key + " is missing", advice);
  }

 private:
  const Values& values_;
  std::string prefix_;
  Location where_;
  Problems& problems_;
};

/// Beside the description, or where the process stands; empty: nowhere.
std::filesystem::path find_calibration(const std::string& given, const hardware::ComponentContext& context) {
  std::error_code ignored;
  for (const hardware::RobotInstance& robot : context.robots)
    for (const description::HardwareInfo& info : robot.hardware) {
      const auto beside = std::filesystem::path(info.where.file).parent_path() / given;
      if (!info.where.file.empty() && std::filesystem::exists(beside, ignored)) return beside;
    }
  return std::filesystem::exists(given, ignored) ? std::filesystem::path(given) : std::filesystem::path();
}

/// joint → its values, from the file that `polyarm setup` has written.
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
    const Yaml yaml = Yaml::load(path.string());
    if (yaml["polyarm"].text("") != "servo_calibration/1")
      problems.error("wrong-kind", yaml.where(), "this is no servo_calibration/1 file",
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

/// A joint as the description or the robot has it.
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
    read.missing("mode", "the joint has several command interfaces and a servo takes one: say which");
  return chosen == "position" ? Mode::position : chosen == "velocity" ? Mode::velocity : Mode::current;
}

JointSetup read_joint(const Declared& joint, const Family& family, Problems& problems) {
  const Reader read(joint.values, joint.name + ".", joint.where, problems);
  JointSetup out;
  out.interface = joint.robot + "/" + joint.name;
  out.name = joint.name;
  out.mode = read_mode(joint, family, read);
  if (!joint.values.contains("id"))
    read.missing("id", std::string("`polyarm setup ") + family.name + "` writes it into a calibration file");
  out.id = static_cast<std::uint8_t>(read.integer("id", 0, family.highest_id).value_or(0));
  out.direction = read.integer("direction", -1, 1).value_or(1);
  if (out.direction == 0) read.wrong("direction", "0", "1 or -1");
  out.offset = read.number("offset", -100, 100).value_or(0);
  out.zero = read.integer("zero", -32767, 32767).value_or(family.steps_per_turn / 2);
  out.min = read.integer("min", -32767, 32767);
  out.max = read.integer("max", -32767, 32767);
  if (out.min && out.max && *out.min >= *out.max)
    problems.error("bad-value", joint.where, joint.name + ".min is not below " + joint.name + ".max");
  if (const auto model = read.text("model"); model && *model == "any")
    out.any_model = true;
  else
    out.model = read.integer("model", 0, 65535);
  out.torque_limit = read.number("torque_limit", 0.01, 1);
  out.max_temperature = read.number("max_temperature", 20, 100);
  out.effort_scale = read.number("effort_scale", 1e-6, 1e3).value_or(1);
  out.stall_effort = read.number("stall_effort", 0, 1e3);
  out.stall_time = read.number("stall_time", 0, 3600).value_or(2);
  for (const std::string& state : joint.states) {
    if (std::find(kStates.begin(), kStates.end(), state) == kStates.end())
      problems.error("unknown-interface", joint.where,
                     joint.name + " has no state '" + state + "'" + did_you_mean(state, kStates),
                     "a servo tells " + join(kStates, ", "));
    out.states.push_back(state);
  }
  return out;
}

/// Puts the cell's `joint.parameter` and the calibration where they belong; the cell has the last word.
void merge(std::vector<Declared>& joints, const Values& bus, const std::map<std::string, Values>& calibration,
           Problems& problems) {
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
  for (const Declared& joint : joints)
    for (const auto& [key, value] : joint.values)
      if (std::find(kJointParameters.begin(), kJointParameters.end(), key) == kJointParameters.end() &&
          bus.contains(joint.name + "." + key))
        problems.error(
            "unknown-parameter", joint.where,
            "there is no parameter " + joint.name + "." + key + did_you_mean(key, kJointParameters));
}
}  // namespace

const char* name(Mode mode) {
  return mode == Mode::position ? "position" : mode == Mode::velocity ? "velocity" : "current";
}

BusSetup read_setup(const hardware::ComponentContext& context, const Family& family) {
  Problems problems;
  BusSetup out;
  const Reader read(context.parameters, "", {}, problems);
  out.port = read.text("port").value_or("");
  if (out.port.empty())
    read.missing(
        "port", std::string("for example /dev/serial/by-id/…; `polyarm setup ") + family.name + "` finds it");
  out.baud = read.integer("baud", 1200, 10'000'000).value_or(family.default_baud);
  out.answer_timeout = nanoseconds(read.number("answer_timeout_ms", 1, 10'000).value_or(10) / 1000);
  out.lost_cycles = read.integer("lost_cycles", 1, 10'000).value_or(5);
  const std::string off = read.text("torque_off").value_or("never");
  if (off != "never" && off != "on_shutdown") read.wrong("torque_off", off, "never or on_shutdown");
  out.lowers_on_shutdown = off == "on_shutdown";
  out.release_time = nanoseconds(read.number("release_time", 0, 60).value_or(3));
  out.fast_sync_read = read.flag("fast_sync_read");
  out.watchdog_ms = read.integer("bus_watchdog_ms", 0, 2540).value_or(family.watchdog ? 200 : 0);

  std::vector<Declared> joints = declared_joints(context);
  merge(joints, context.parameters, read_calibration(context, family, context.parameters, problems),
        problems);
  for (const Declared& joint : joints) out.joints.push_back(read_joint(joint, family, problems));
  if (out.joints.empty()) problems.error("no-joints", {}, context.name + " has no joints to drive");
  if (out.joints.size() > 32) problems.error("too-many-joints", {}, "a bus takes 32 joints at most");
  for (std::size_t i = 0; i < out.joints.size(); ++i)
    for (std::size_t j = i + 1; j < out.joints.size(); ++j)
      if (out.joints[i].id == out.joints[j].id && joints[i].values.contains("id") &&
          joints[j].values.contains("id"))
        problems.error("same-id", joints[j].where,
                       out.joints[i].name + " and " + out.joints[j].name + " have the same servo id " +
                           std::to_string(out.joints[i].id));
  problems.throw_if_errors();
  return out;
}

}  // namespace polyarm::servo_bus
