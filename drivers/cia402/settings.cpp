#include "drivers/cia402/settings.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::cia402 {

namespace {

using hardware::DriverParameter;
using enum hardware::ParameterKind;
constexpr std::string_view kOfJoint = "JOINT.";
constexpr double kMostLoad = 0.8;

constexpr DriverParameter kParameters[] = {
    {"bus", text, nullptr, "CAN interface (can0), or the serial port of an adapter with SLCAN"},
    {"bit_rate", number, "1000000", "bit/s of the CAN bus; that of can0 is set by `ip link`", 10'000,
     1'000'000},
    {"baud", number, "1000000", "bit/s of the serial port", 1200, 10'000'000},
    {"cycle_ms", number, "0", "ms between two SYNC; 0: the cycle of the cell", 0, 100},
    {"pace", boolean, "true", "the control loop follows the SYNC; one component of a cell can do that"},
    {"master", number, "127", "node number of this computer", 1, 127},
    {"heartbeat_ms", number, "100", "ms until a missing heartbeat counts, on both sides", 20, 5000},
    {"quick_stop", text, "hold",
     "after a stop: hold (torque stays), off (torque off, for joints with brakes), as_set (as the drive is)",
     0, 0, "hold off as_set"},
    {"fault_reset", boolean, "true", "activating resets faults of drives"},
    {"torque_off", text, "never", "on_shutdown: the drives are switched off at the end of a run", 0, 0,
     "never on_shutdown"},
    {"lost_cycles", number, "5", "cycles in a row without a position of a drive until it is an error", 1,
     1000},
    {"watchdog", text, "auto",
     "a process that stops the drives when this one dies or hangs: on, off; auto: for drives that do not "
     "watch the heartbeat themselves",
     0, 0, "auto on off"},
    {"watchdog_ms", number, "250", "ms without a sign of life until it does", 20, 5000},
    {"answer_ms", number, "500", "ms for an answer to an SDO", 10, 10'000},
    {"start_timeout", number, "10", "s until all drives are enabled", 0.1, 120},
    {"loop_silence_ms", number, "100", "ms without a command of the loop until the arm is stopped", 10,
     10'000},
    {"max_step", number, "0.1", "rad between two commands; beyond it nothing is sent and the arm stops",
     0.001, 3},
    {"JOINT.node", number, nullptr, "node number of its drive", 1, 127},
    {"JOINT.counts_per_turn", number, nullptr, "counts of the drive for one turn of the motor", 1, 1e9},
    {"JOINT.gear", number, "1", "turns of the motor for one of the joint", 1e-3, 1e5},
    {"JOINT.direction", number, "1", "-1: the joint turns against the motor", -1, 1},
    {"JOINT.offset", number, "0", "rad, of the joint where the drive counts 0", -1000, 1000},
    {"JOINT.velocity_unit", text, "difference",
     "of 0x606C: counts (per s), rpm or mrpm of the motor; difference: from the positions instead", 0, 0,
     "difference counts rpm mrpm"},
    {"JOINT.rated_torque", number, "", "N m of the motor; else 0x6076 of the drive", 1e-6, 1e6},
    {"JOINT.max_torque", number, "", "share of the rated torque; else as the drive is set", 0.01, 10},
    {"JOINT.max_motor_speed", number, "", "rpm; else as the drive is set", 1, 1e6},
    {"JOINT.following_error", number, "", "rad; else as the drive is set", 1e-6, 100},
    {"JOINT.min", number, "", "rad, for the drive's own limit; with max", -1000, 1000},
    {"JOINT.max", number, "", "rad, for the drive's own limit; with min", -1000, 1000},
};
constexpr hardware::DriverFacts kFacts = {
    "system", "CANopen servo drives with CiA 402, over SocketCAN or SLCAN",
    "drives of our own on a pseudo-terminal, byte for byte, with faults of drives and bus; see "
    "docs/driver-cia402.md; never on hardware",
    kParameters};

constexpr std::size_t kOfBus = 17;  // the rows before those of joints
static_assert(std::string_view(kParameters[kOfBus].name).starts_with(kOfJoint) &&
              !std::string_view(kParameters[kOfBus - 1].name).starts_with(kOfJoint));
constexpr hardware::DriverFacts kFactsOfBus = {kFacts.kind, kFacts.drives, kFacts.proof,
                                               std::span(kParameters).first(kOfBus)};

using Values = std::map<std::string, std::string>;

struct Declared {
  std::string name;
  Values values;
  Location where;
};

/// The joints of the <ros2_control> block, else those of the model.
std::vector<Declared> declared_joints(const hardware::RobotInstance& robot, Problems& problems) {
  std::vector<Declared> out;
  for (const description::HardwareInfo& block : robot.hardware)
    for (const description::ComponentInfo& part : block.components) {
      if (part.kind != "joint") continue;
      out.push_back({part.name, part.parameters, part.where});
      for (const description::InterfaceInfo& one : part.command_interfaces)
        if (one.name != "position")
          problems.error("unknown-interface", one.where,
                         "'" + part.name + "' takes no command '" + one.name + "'", "it takes position");
    }
  if (robot.model && out.empty())
    for (const std::string& name : robot.model->joint_names()) out.push_back({name, {}, {}});
  return out;
}

/// Parameters "elbow.node" of the component go to the joint; they have priority.
void merge(std::vector<Declared>& joints, const Values& of_component, Problems& problems) {
  std::vector<std::string> keys, names;
  for (const DriverParameter& row : kParameters)
    if (std::string_view(row.name).starts_with(kOfJoint)) keys.emplace_back(row.name + kOfJoint.size());
  for (const Declared& joint : joints) names.push_back(joint.name);
  for (const auto& [key, value] : of_component) {
    const auto dot = key.rfind('.');
    if (dot == std::string::npos) continue;
    const std::string joint = key.substr(0, dot), parameter = key.substr(dot + 1);
    const auto found =
        std::find_if(joints.begin(), joints.end(), [&](const Declared& j) { return j.name == joint; });
    if (found == joints.end())
      problems.error("unknown-joint", {},
                     key + ": there is no joint '" + joint + "'" + did_you_mean(joint, names));
    else if (std::find(keys.begin(), keys.end(), parameter) == keys.end())
      problems.error("unknown-parameter", {}, "there is no parameter " + key + did_you_mean(parameter, keys),
                     "those of a joint are: " + join(keys, ", "));
    else
      found->values[parameter] = value;
  }
}

/// The values of one joint by the table.
class OfJoint {
 public:
  OfJoint(const Declared& joint, Problems& problems) : joint_(joint), problems_(problems) {}

  std::optional<double> given(const char* key) const {
    const auto found = joint_.values.find(key);
    if (found == joint_.values.end() || trim(found->second).empty()) return std::nullopt;
    const DriverParameter& r = row(key);
    const auto value = parse_number(trim(found->second));
    if (value && *value >= r.least && *value <= r.most) return value;
    wrong(key, found->second, "a number from " + format_number(r.least) + " to " + format_number(r.most));
    return std::nullopt;
  }
  /// Else the default; a missing one is an error.
  double number(const char* key) const {
    const DriverParameter& r = row(key);
    if (!r.fallback && !joint_.values.contains(key))
      problems_.error("missing-parameter", joint_.where,
                      "the parameter " + joint_.name + "." + key + " is missing", r.meaning);
    return given(key).value_or(r.fallback ? parse_number(r.fallback).value_or(0) : 1);
  }
  std::size_t choice(const char* key) const {
    const DriverParameter& r = row(key);
    const auto found = joint_.values.find(key);
    const std::string value = found == joint_.values.end() ? r.fallback : std::string(trim(found->second));
    const std::vector<std::string> all = split_words(r.one_of);
    const auto place = std::find(all.begin(), all.end(), value);
    if (place != all.end()) return static_cast<std::size_t>(place - all.begin());
    wrong(key, value, "one of " + join(all, ", "));
    return 0;
  }
  void wrong(const char* key, const std::string& value, const std::string& wanted) const {
    problems_.error("bad-value", joint_.where,
                    joint_.name + "." + key + " = '" + value + "' is not " + wanted);
  }

 private:
  static const DriverParameter& row(std::string_view key) {
    return *std::find_if(std::begin(kParameters), std::end(kParameters), [&](const DriverParameter& r) {
      return std::string_view(r.name).starts_with(kOfJoint) && key == r.name + kOfJoint.size();
    });
  }
  const Declared& joint_;
  Problems& problems_;
};

JointSettings read_joint(const Declared& joint, Problems& problems) {
  const OfJoint read(joint, problems);
  JointSettings out;
  out.name = joint.name;
  const double node = read.number("node"), direction = read.number("direction");
  out.node = static_cast<int>(node);
  if (node != std::floor(node)) read.wrong("node", format_number(node), "a whole number");
  if (std::abs(direction) != 1) read.wrong("direction", format_number(direction), "1 or -1");
  out.scale = {read.number("counts_per_turn"), read.number("gear"), read.number("offset"),
               direction < 0 ? -1 : 1};
  out.velocity_unit = static_cast<VelocityUnit>(read.choice("velocity_unit"));
  out.rated_torque = read.given("rated_torque");
  out.max_torque = read.given("max_torque");
  out.max_motor_speed = read.given("max_motor_speed");
  out.following_error = read.given("following_error");
  out.min = read.given("min");
  out.max = read.given("max");
  if (out.min.has_value() != out.max.has_value() || (out.min && *out.min >= *out.max))
    problems.error("bad-value", joint.where,
                   joint.name + ".min and " + joint.name + ".max do not make a range", "give both");
  return out;
}

void check_nodes(const Settings& settings, Problems& problems) {
  for (std::size_t i = 0; i < settings.joints.size(); ++i) {
    const JointSettings& joint = settings.joints[i];
    if (joint.node == settings.master)
      problems.error("same-node", {},
                     joint.name + " and this computer have the node number " + std::to_string(joint.node),
                     "set another `master`");
    for (std::size_t j = i + 1; j < settings.joints.size(); ++j)
      if (joint.node == settings.joints[j].node)
        problems.error("same-node", {},
                       joint.name + " and " + settings.joints[j].name + " have the same node number " +
                           std::to_string(joint.node),
                       "give each drive its own, at the drive and here");
  }
}

}  // namespace

const hardware::DriverFacts& facts() {
  return kFacts;
}

double bus_load(std::size_t drives, int bit_rate, Nanoseconds cycle) noexcept {
  // A classic frame with `n` bytes: 47 bits with the space behind it, and a stuff bit for each four of 34.
  const auto bits = [](int n) { return 47 + 8 * n + (33 + 8 * n) / 4; };
  const double all = bits(0) + static_cast<double>(drives) * (bits(6) + bits(7) + bits(6));
  return all / bit_rate / seconds(cycle);
}

Settings read_settings(const hardware::ComponentContext& context) {
  // Those of joints have names of their own ("elbow.node"), and are checked below.
  hardware::ComponentContext of_bus = context;
  std::erase_if(of_bus.parameters, [](const auto& one) { return one.first.find('.') != std::string::npos; });
  hardware::DriverParameters p(kFactsOfBus, of_bus);
  Settings out;
  out.bus = {p.text("bus"), static_cast<int>(p.number("bit_rate")), static_cast<int>(p.number("baud")),
             "component " + context.name};
  const double cycle = p.number("cycle_ms");
  out.cycle = cycle > 0 ? nanoseconds(cycle / 1000) : context.period;
  out.pace = p.boolean("pace");
  out.master = static_cast<int>(p.number("master"));
  out.heartbeat_ms = static_cast<int>(p.number("heartbeat_ms"));
  const std::string quick_stop = p.text("quick_stop");
  out.quick_stop = quick_stop == "hold"  ? QuickStop::hold
                   : quick_stop == "off" ? QuickStop::off
                                         : QuickStop::as_set;
  out.fault_reset = p.boolean("fault_reset");
  out.off_on_shutdown = p.text("torque_off") == "on_shutdown";
  out.lost_cycles = static_cast<int>(p.number("lost_cycles"));
  const std::string watched = p.text("watchdog");
  out.watched = watched == "auto" ? Watched::automatic : watched == "on" ? Watched::on : Watched::off;
  out.watchdog_ms = static_cast<int>(p.number("watchdog_ms"));
  out.answer = nanoseconds(p.number("answer_ms") / 1000);
  out.start_timeout = nanoseconds(p.number("start_timeout"));
  out.loop_silence = nanoseconds(p.number("loop_silence_ms") / 1000);
  out.max_step = p.number("max_step");

  Problems& problems = p.problems();
  if (context.robots.size() != 1) {
    problems.error("bad-hardware", {}, "'" + context.name + "' drives one robot",
                   "give each robot its own bus and hardware");
    problems.throw_if_errors();
  }
  std::vector<Declared> joints = declared_joints(context.robots.front(), problems);
  merge(joints, context.parameters, problems);
  if (joints.empty() || joints.size() > kMostDrives)
    problems.error("bad-hardware", {},
                   "'" + context.name + "' has " + std::to_string(joints.size()) + " joints",
                   "this driver takes 1 to " + std::to_string(kMostDrives) +
                       "; name a description whose <ros2_control> block has them");
  for (const Declared& joint : joints) out.joints.push_back(read_joint(joint, problems));
  problems.throw_if_errors();
  check_nodes(out, problems);
  if (const double load = bus_load(joints.size(), out.bus.bit_rate, out.cycle); load > kMostLoad)
    problems.error("too-fast", {},
                   std::to_string(joints.size()) + " drives at " + format_number(1 / seconds(out.cycle)) +
                       " Hz need " + std::to_string(std::lround(100 * load)) + " % of a bus with " +
                       std::to_string(out.bus.bit_rate) + " bit/s",
                   "lower the rate, or raise the bit rate: 80 % is the most");
  problems.throw_if_errors();
  return out;
}

}  // namespace polyarm::cia402
