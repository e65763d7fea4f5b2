#include "polyarm/setup/cell_file.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/shell_word.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/there.hpp"
#include "polyarm/setup/cell_reach.hpp"
#include "polyarm/setup/door_kinds.hpp"
#include "polyarm/setup/teleop_entries.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::cell {

namespace {
Nanoseconds read_budget(const Yaml& yaml, Problems& problems) {
  if (!yaml.defined()) return 0;
  double out = 0;
  collect(problems, [&] {
    out = yaml.number(Dimension::time);
    if (!(out >= 1e-6 && out <= 1))
      throw Error(Problem{"bad-value", yaml.where(), "a budget is a time from 1e-6 s to 1 s", "0.2ms"});
  });
  return nanoseconds(out);
}

int whole(const Yaml& yaml, const char* key, int fallback, int lowest, int highest, Problems& problems) {
  double value = fallback;
  collect(problems, [&] { value = yaml[key].number(Dimension::none, fallback); });
  if (value >= lowest && value <= highest && value == std::floor(value)) return static_cast<int>(value);
  problems.error("bad-value", yaml[key].where(),
                 std::string(key) + " is a whole number from " + format_number(lowest) + " to " +
                     format_number(highest));
  return fallback;
}

/// Parses report, hold or fault as 0 to 2.
int read_overrun(const Yaml& yaml, Problems& problems) {
  std::string overrun = "report";
  collect(problems, [&] { overrun = yaml["overrun"].text("report"); });
  const std::vector<std::string> known = {"report", "hold", "fault"};
  const auto found = std::find(known.begin(), known.end(), overrun);
  if (found != known.end()) return static_cast<int>(found - known.begin());
  problems.error("bad-value", yaml["overrun"].where(),
                 "overrun is '" + overrun + "'" + did_you_mean(overrun, known), "report, hold or fault");
  return 0;
}

/// Parses `thread: true`, or a map of its options.
void read_thread(const Yaml& yaml, RobotEntry& robot, Problems& problems) {
  if (!yaml.defined()) return;
  if (!yaml.is_map()) return collect(problems, [&] { robot.thread = yaml.boolean(); });
  yaml.check_keys({"priority", "cpu", "overrun", "overrun_after"}, problems);
  robot.thread = true;
  robot.on_thread =
      ThreadEntry{whole(yaml, "priority", 0, 0, 99, problems), whole(yaml, "cpu", -1, -1, 1023, problems),
                  static_cast<hardware::WhenLate>(read_overrun(yaml, problems)),
                  static_cast<unsigned>(whole(yaml, "overrun_after", 10, 1, 1'000'000, problems))};
}

void read_on_fault(const Yaml& yaml, RobotEntry& robot, Problems& problems) {
  const std::vector<std::string> known = {"cell", "group"};
  std::string whom = known.front();
  collect(problems, [&] { whom = yaml.text(known.front()); });
  robot.fault_of_group = whom == "group";
  if (std::find(known.begin(), known.end(), whom) == known.end())
    problems.error("bad-value", yaml.where(), "on_fault is '" + whom + "'" + did_you_mean(whom, known),
                   "cell: a fault of its hardware stops everything; group: this robot alone");
}

/// Parses `force_sensor: true`, or a map of its errors.
void read_force_sensor(const Yaml& yaml, RobotEntry& robot, Problems& problems) {
  if (!yaml.defined()) return;
  if (!yaml.is_map()) return collect(problems, [&] { robot.force_sensor = yaml.boolean(false); });
  robot.force_sensor = true;
  hardware::ForceSensorErrors& out = robot.sensor_errors;
  yaml.check_keys({"noise", "torque_noise", "bias", "drift", "torque_drift", "seed"}, problems);
  const std::pair<const char*, std::pair<double*, Dimension>> deviations[] = {
      {"noise", {&out.noise, Dimension::force}},
      {"torque_noise", {&out.torque_noise, Dimension::torque}},
      {"drift", {&out.drift, Dimension::force}},
      {"torque_drift", {&out.torque_drift, Dimension::torque}}};
  for (const auto& [key, to] : deviations) {
    if (!yaml.has(key)) continue;
    collect(problems, [&, place = to.first, dimension = to.second] { *place = yaml[key].number(dimension); });
    if (!(*to.first >= 0) || !std::isfinite(*to.first))
      problems.error("bad-value", yaml[key].where(), std::string(key) + " of the force sensor is below zero",
                     "write a standard deviation, such as 0.2N or 0.01Nm");
  }
  out.seed = static_cast<std::uint32_t>(whole(yaml, "seed", 1, 0, 2'000'000'000, problems));
  if (!yaml.has("bias")) return;
  collect(problems, [&] {
    const std::vector<Yaml> items = yaml["bias"].items();
    if (items.size() != out.bias.size())
      throw Error(Problem{
          "bad-value", yaml["bias"].where(),
          "the bias of the force sensor has " + std::to_string(items.size()) + " values, 6 were expected",
          "write force x y z, then torque x y z: [1N, 0N, -2N, 0Nm, 0.1Nm, 0Nm]"});
    for (std::size_t i = 0; i < items.size(); ++i)
      out.bias[i] = items[i].number(i < 3 ? Dimension::force : Dimension::torque);
  });
}

/// Parses `on:`. An empty value is an error; a robot on the ground has no such key.
std::string read_carrier(const std::string& name, const Yaml& yaml) {
  const std::vector<std::string> keys = yaml.keys();
  if (std::find(keys.begin(), keys.end(), "on") == keys.end()) return {};
  std::string carrier = yaml["on"].text("");
  if (carrier.empty())
    throw Error(Problem{"bad-carrier", yaml.key_location("on"), "'on' of '" + name + "' names no robot",
                        "name the robot that carries it, or remove 'on'"});
  return carrier;
}

RobotEntry read_robot(const std::string& name, const Yaml& yaml, Problems& problems) {
  RobotEntry robot;
  robot.name = name;
  robot.where = yaml.where();
  if (!yaml.is_map()) {
    const std::string model = yaml.is_list() ? std::string() : yaml.text("");
    problems.error("bad-type", yaml.where(), "the robot '" + name + "' is not described",
                   "write '" + name + ": {model: " + (model.empty() ? "universal_robots/ur3" : model) + "}'");
    return robot;
  }
  for (const std::string& key : yaml.keys()) robot.places[key] = yaml.key_location(key);
  yaml.check_keys({"model",       "arguments",
                   "at",          "xyz",
                   "rpy",         "quaternion",
                   "hardware",    "tool",
                   "parameters",  "accept_unverified",
                   "budget",      "rate",
                   "thread",      "on_fault",
                   "workspace",   "joint_ranges",
                   "payload",     "tip",
                   "on",          "force_sensor",
                   "calibration", "collision_torque",
                   "branch"},
                  problems);
  robot.payload = read_payload(yaml["payload"], problems);
  robot.workspace = read_workspace(yaml["workspace"], problems);
  robot.ranges = read_ranges(yaml["joint_ranges"], problems);
  robot.collision_torques = read_collision_torques(yaml["collision_torque"], problems);
  for (const std::string& key : yaml["arguments"].keys())
    collect(problems, [&] { robot.arguments[key] = yaml["arguments"][key].text(); });
  collect(problems, [&] { robot.model = yaml.required("model").text(); });
  collect(problems, [&] { robot.base = yaml.pose(); });
  collect(problems, [&] { robot.hardware = yaml["hardware"].text("mock"); });
  collect(problems, [&] {
    if (yaml.has("accept_unverified")) robot.accept_unverified = yaml["accept_unverified"].boolean();
  });
  collect(problems, [&] { robot.tool = yaml["tool"].text("none"); });
  collect(problems, [&] { robot.tip = yaml["tip"].text(""); });
  collect(problems, [&] { robot.branch = yaml["branch"].text(""); });
  collect(problems, [&] { robot.calibration = yaml["calibration"].text(""); });
  collect(problems, [&] { robot.on = read_carrier(name, yaml); });
  read_thread(yaml["thread"], robot, problems);
  read_on_fault(yaml["on_fault"], robot, problems);
  collect(problems, [&] {
    if (!yaml.has("rate")) return;
    robot.rate = yaml["rate"].number();
    if (!(robot.rate > 0 && robot.rate <= 10000))
      problems.error("bad-rate", yaml["rate"].where(),
                     "the rate of '" + name + "' does not lie above zero and at most at 10000 Hz",
                     "write how often per second it is read and commanded, Hz");
  });
  read_force_sensor(yaml["force_sensor"], robot, problems);
  robot.budget = read_budget(yaml["budget"], problems);
  for (const std::string& key : yaml["parameters"].keys())
    collect(problems, [&] { robot.parameters[key] = yaml["parameters"][key].text(); });
  if (name.find_first_of("/ \t") != std::string::npos)
    problems.error("bad-name", robot.where, "a robot's name may hold no '/' and no blanks: '" + name + "'");
  return robot;
}

/// Requires the pose of a carried robot in its carrier's root link.
void place_carried(std::vector<RobotEntry>& robots, Problems& problems) {
  for (RobotEntry& robot : robots) {
    if (robot.on.empty()) continue;
    std::vector<std::string> others;
    for (const RobotEntry& other : robots)
      if (other.name != robot.name) others.push_back(other.name);
    const auto carrier = std::find_if(robots.begin(), robots.end(),
                                      [&](const RobotEntry& each) { return each.name == robot.on; });
    if (carrier == robots.end())
      problems.error("unknown-robot", robot.place_of("on"),
                     "'" + robot.name + "' is on '" + robot.on + "', and the cell has no robot of that name" +
                         did_you_mean(robot.on, others),
                     "name another robot; fixtures and movers of the scene carry no robot");
    else if (carrier->name == robot.name)
      problems.error("bad-carrier", robot.place_of("on"), "'" + robot.name + "' is on itself",
                     "name another robot, or remove 'on'");
    else if (!carrier->on.empty())
      problems.error("bad-carrier", robot.place_of("on"),
                     "'" + robot.name + "' is on '" + robot.on + "', which is on '" + carrier->on + "'",
                     "choose a robot that is on the ground");
    else
      robot.base = carrier->base * robot.base;
  }
}

LoopEntry read_loop(const Yaml& yaml, Problems& problems) {
  LoopEntry out;
  if (!yaml.defined()) return out;
  yaml.check_keys({"priority", "cpu", "lock_memory", "overrun", "overrun_after", "stall"}, problems);
  if (yaml.has("priority")) out.priority = whole(yaml, "priority", 0, 0, 99, problems);
  if (yaml.has("cpu")) out.cpu = whole(yaml, "cpu", -1, -1, 1023, problems);
  out.overrun_after = static_cast<unsigned>(whole(yaml, "overrun_after", 10, 1, 1'000'000, problems));
  collect(problems, [&] {
    if (yaml.has("lock_memory")) out.lock_memory = yaml["lock_memory"].boolean();
  });
  out.overrun = static_cast<control::Overrun>(read_overrun(yaml, problems));
  if (yaml.has("stall"))
    collect(problems, [&] {
      const std::string stall = yaml["stall"].text();
      if (stall != "hold" && stall != "report")
        problems.error("bad-value", yaml["stall"].where(), "stall is '" + shortened(stall) + "'",
                       "hold or report");
      out.stall_holds = stall == "hold";
    });
  return out;
}

MotionEntry read_motion(const Yaml& yaml, Problems& problems) {
  MotionEntry motion;
  if (!yaml.defined()) return motion;
  yaml.check_keys({"speed", "seconds", "thesis_scale", "tcp_speed", "tcp_acceleration", "tcp_jerk",
                   "turn_speed", "turn_acceleration", "turn_jerk", "around"},
                  problems);
  collect(problems, [&] { motion.around = yaml["around"].boolean(false); });
  if (yaml.has("seconds"))
    collect(problems, [&] { motion.seconds = yaml["seconds"].number(Dimension::time); });
  collect(problems, [&] { motion.speed = yaml["speed"].number(Dimension::none, 1); });
  if (yaml.has("thesis_scale"))
    collect(problems, [&] { motion.thesis_scale = yaml["thesis_scale"].number(Dimension::none); });
  const std::pair<const char*, std::pair<double*, Dimension>> of_tcp[] = {
      {"tcp_speed", {&motion.tcp.speed, Dimension::speed}},
      {"tcp_acceleration", {&motion.tcp.acceleration, Dimension::acceleration}},
      {"tcp_jerk", {&motion.tcp.jerk, Dimension::none}},
      {"turn_speed", {&motion.tcp.turn_speed, Dimension::angular_speed}},
      {"turn_acceleration", {&motion.tcp.turn_acceleration, Dimension::angular_acceleration}},
      {"turn_jerk", {&motion.tcp.turn_jerk, Dimension::none}}};
  for (const auto& [key, to] : of_tcp) {
    const Yaml value = yaml[key];
    if (!value.defined()) continue;
    collect(problems, [&, place = to.first, dimension = to.second] { *place = value.number(dimension); });
    if (!(*to.first > 0) || !std::isfinite(*to.first))
      problems.error("bad-value", value.where(), std::string(key) + " is not above 0", {});
    constexpr double kMost = 20;  // m/s, far above any robot arm
    if (to.second == Dimension::speed && *to.first > kMost)
      problems.error("bad-value", value.where(),
                     std::string(key) + " is " + value.text() + ", faster than any robot",
                     "this looks like mm/s: write such as 500mm/s; speeds without a unit are m/s");
  }
  if (!(motion.speed > 0 && motion.speed <= 1))
    problems.error("bad-value", yaml["speed"].where(),
                   "speed is a share of the limits, above 0 and at most 1 (100%)");
  return motion;
}

void check_kind(const Yaml& yaml, Problems& problems) {
  const std::string kind = yaml["polyarm"].text("");
  if (kind == "cell/1") return;
  const std::vector<std::string> keys = yaml.keys();
  const bool parameters = std::any_of(keys.begin(), keys.end(), [&](const std::string& key) {
    return key == "/**" || yaml[key].has("ros__parameters");
  });
  if (parameters)
    throw Error(Problem{"no-cell",
                        {yaml.where().file, 1, 1},
                        "this is a controllers file of ROS, not a cell",
                        "polyarm run --description ROBOT --controllers " + shell_word(yaml.where().file)});
  if (kind.empty())
    problems.error("missing-key", {yaml.where().file, 1, 1},
                   "this is not a cell file: the line 'polyarm: cell/1' is missing",
                   "write that as its first line");
  else if (kind.starts_with("cell/"))
    problems.error("newer-file", yaml["polyarm"].where(),
                   "this is a " + kind + " file, newer than this program reads",
                   "it reads cell/1; install a newer Polyarm");
  else
    problems.error("wrong-kind", yaml["polyarm"].where(),
                   "this is a '" + kind + "' file, a cell/1 was expected");
}

bool is_robot(const CellFile& cell, const std::string& name) {
  return std::any_of(cell.robots.begin(), cell.robots.end(),
                     [&](const RobotEntry& robot) { return robot.name == name; });
}

void apply(const Overrides& overrides, CellFile& cell, Problems& problems) {
  if (overrides.budget > 0) cell.budget = overrides.budget;
  for (RobotEntry& robot : cell.robots) {
    if (!overrides.hardware.empty()) robot.hardware = overrides.hardware;
    if (robot.budget == 0 || overrides.budget > 0) robot.budget = cell.budget;
  }
  if (!overrides.program.empty()) {
    const std::filesystem::path given = overrides.program;
    const bool beside = !given.is_absolute() && is_there(cell.folder / given);
    cell.program = beside || !is_there(given) ? overrides.program : std::filesystem::absolute(given).string();
    cell.program_where = {"--program"};
    if (!beside) cell.grant->allow_reading(resolved(cell.folder / cell.program).parent_path());
  }
  if (overrides.robot.empty()) return;
  const auto equals = overrides.robot.find('=');
  const std::filesystem::path model = overrides.robot.substr(equals == std::string::npos ? 0 : equals + 1);
  std::error_code error;  // a description named by the user may read meshes and includes beside it
  if (std::filesystem::is_regular_file(model, error))
    cell.grant->allow_reading(resolved(model).parent_path());
  if (equals == std::string::npos) {
    if (cell.robots.size() == 1)
      cell.robots.front().model = overrides.robot;
    else
      problems.error(
          "which-robot", {cell.path.string()},
          "the cell has " + std::to_string(cell.robots.size()) + " robots",
          is_robot(cell, overrides.robot)
              ? "'" + overrides.robot + "' is one of them; --robot NAME=MODEL gives one another model"
              : "choose one: --robot NAME=MODEL");
    return;
  }
  const std::string name = overrides.robot.substr(0, equals);
  const auto found = std::find_if(cell.robots.begin(), cell.robots.end(),
                                  [&](const RobotEntry& r) { return r.name == name; });
  if (found != cell.robots.end())
    found->model = overrides.robot.substr(equals + 1);
  else
    problems.error("which-robot", {cell.path.string()}, "the cell has no robot '" + name + "'");
}

/// Parses `NAME: true`, or a map of the door's options.
void read_door(const DoorKind& kind, const Yaml& yaml, CellFile& cell, Problems& problems) {
  if (!yaml.defined() || (!yaml.is_map() && !yaml.boolean())) return;
  DoorOptions& options = cell.doors[kind.name];
  if (!yaml.is_map()) return;
  yaml.check_keys(kind.keys, problems);
  for (const std::string& key : yaml.keys())
    options[key] = yaml[key].is_list() ? join(yaml[key].texts(), ",") : yaml[key].text();
}

/// Parses `true`, a file name, or `{file, rate}`.
std::optional<RecordOptions> read_record(const Yaml& yaml, const std::filesystem::path& folder,
                                         Problems& problems) {
  if (!yaml.defined()) return std::nullopt;
  RecordOptions out;
  std::string file;
  if (yaml.is_map()) {
    yaml.check_keys({"file", "rate"}, problems);
    file = yaml["file"].text("");
    out.rate = yaml["rate"].number(Dimension::rate, out.rate);
    if (!(out.rate > 0))
      problems.error("bad-value", yaml["rate"].where(), "a recording needs a rate above 0 Hz");
  } else if (const std::string text = yaml.text(); text == "true" || text == "false") {
    if (text == "false") return std::nullopt;
  } else {
    file = text;
  }
  if (!file.empty()) out.file = folder / file;
  return out;
}
}  // namespace

CellFile read_cell_file(const std::filesystem::path& given, const Overrides& overrides) {
  CellFile cell;
  cell.path = is_folder(given) ? given / "cell.yaml" : given;
  cell.folder = cell.path.parent_path().empty() ? "." : cell.path.parent_path();
  std::error_code unknown;
  cell.name = std::filesystem::weakly_canonical(cell.folder, unknown).filename().string();
  if (is_folder(given) && !is_there(cell.path))
    throw Error(Problem{"no-cell",
                        {given.string()},
                        "there is no cell.yaml in this folder",
                        "name a folder with a cell.yaml, a cell file, or use --description FILE.urdf"});
  if (cell.path.extension() == ".script")
    throw Error(Problem{"no-cell",
                        {given.string()},
                        "this is a program, but a cell is needed",
                        "polyarm run CELL --program " + shell_word(given.string())});
  cell.grant = reach().open_cell(cell.folder);
  allow_remembered(cell);
  const Yaml yaml = Yaml::load(cell.path.string());
  Problems problems;
  check_kind(yaml, problems);
  std::vector<std::string> keys{"polyarm",  "rate",    "robots",  "scene",    "controllers", "activate",
                                "send",     "plugins", "budget",  "signals",  "program",     "plc",
                                "motion",   "loop",    "profile", "profiles", "workspace",   "record",
                                "contacts", "guards",  "seed",    "belts",    "streams",     "teleop"};
  for (const DoorKind& kind : door_kinds()) keys.push_back(kind.name);
  yaml.check_keys(keys, problems);
  cell.profiles = read_profiles(yaml, problems);
  cell.workspace = read_workspace(yaml["workspace"], problems);
  cell.rate_stated = yaml.has("rate");
  collect(problems, [&] { cell.rate = yaml["rate"].number(Dimension::rate, 1000); });
  if (!(cell.rate >= 1 && cell.rate <= 10000))
    problems.error("bad-value", yaml["rate"].where(), "the control rate must lie between 1 and 10000 Hz");
  if (yaml.has("robots") && !yaml["robots"].is_map())
    throw Error(Problem{"bad-type", yaml["robots"].where(), "'robots' has no names of robots",
                        "write 'robots: {arm: {model: universal_robots/ur3}}'"});
  if (yaml["robots"].keys().size() > bounds::kRobots)
    throw Error(Problem{"too-many", yaml["robots"].where(),
                        "the cell has more than " + std::to_string(bounds::kRobots) + " robots",
                        "divide it into several cells"});
  for (const std::string& name : yaml["robots"].keys())
    cell.robots.push_back(read_robot(name, yaml["robots"][name], problems));
  place_carried(cell.robots, problems);
  if (cell.robots.empty() && !yaml.has("plc"))  // a PLC alone may be the far side of a link
    problems.error("missing-key", yaml.where(), "the cell has no robots",
                   "add 'robots: {arm: {model: universal_robots/ur3}}'");
  const auto file = [&](const char* key, std::string& name, Location& where) {
    collect(problems, [&] { name = yaml[key].text(""); });
    where = yaml[key].where();
  };
  file("scene", cell.scene, cell.scene_where);
  collect(problems, [&] { cell.controllers = yaml["controllers"].texts(); });
  cell.controllers_where = yaml["controllers"].where();
  for (const std::string& to : yaml["send"].keys())
    collect(problems, [&] { cell.send.emplace_back(to, yaml["send"][to].text()); });
  collect(problems, [&] { cell.activate = yaml["activate"].texts(); });
  collect(problems, [&] { cell.plugins = yaml["plugins"].texts(); });
  cell.plugins_where = yaml["plugins"].where();
  cell.budget = read_budget(yaml["budget"], problems);
  file("signals", cell.signals, cell.signals_where);
  file("program", cell.program, cell.program_where);
  file("plc", cell.plc, cell.plc_where);
  cell.motion = read_motion(yaml["motion"], problems);
  cell.loop = read_loop(yaml["loop"], problems);
  cell.seed = static_cast<std::uint64_t>(whole(yaml, "seed", 0, 0, 1'000'000'000, problems));
  cell.belts = read_belts(yaml["belts"], problems);
  cell.streams = read_streams(yaml["streams"], problems);
  cell.contact_stop = read_contact_stop(yaml["contacts"], problems);
  cell.clearance = read_clearance(yaml["contacts"], problems);
  cell.guards = read_guards(yaml["guards"], cell.clearance, problems);
  collect(problems, [&] { cell.teleop = read_teleop(yaml["teleop"], yaml["robots"].keys(), problems); });
  for (const DoorKind& kind : door_kinds())
    collect(problems, [&] { read_door(kind, yaml[kind.name], cell, problems); });
  collect(problems, [&] { cell.record = read_record(yaml["record"], cell.folder, problems); });
  apply(overrides, cell, problems);
  problems.throw_if_errors();
  return cell;
}

CellFile cell_from_description(const std::filesystem::path& description,
                               const std::vector<std::string>& controllers, const Overrides& overrides) {
  CellFile cell;
  cell.path = description;
  cell.folder = ".";
  cell.name = description.stem().string();
  RobotEntry robot;
  robot.model = description.string();
  robot.hardware = "declared";
  robot.where = {description.string()};
  cell.robots.push_back(robot);
  cell.controllers = controllers;
  if (!controllers.empty()) cell.controllers_where = {controllers.front()};
  Problems problems;
  apply(overrides, cell, problems);
  problems.throw_if_errors();
  return cell;
}

}  // namespace polyarm::cell
