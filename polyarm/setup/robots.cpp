#include "polyarm/setup/robots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/base/there.hpp"
#include "polyarm/calibration/arm_errors.hpp"
#include "polyarm/description/arm_calibration.hpp"
#include "polyarm/description/branch.hpp"
#include "polyarm/description/tools.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/ros_files/hardware_names.hpp"
#include "polyarm/ros_files/joint_limits.hpp"
#include "polyarm/setup/bodies.hpp"
#include "polyarm/setup/cell_reach.hpp"
#include "polyarm/setup/controllers_plan.hpp"
#include "polyarm/wheels/wheel_names.hpp"

namespace polyarm::cell {

namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Defaults for descriptions without limits: a slow joint that reaches its speed in a quarter of a second.
constexpr double kDefaultVelocity = 1.0, kTimeToSpeed = 0.25, kTimeToAcceleration = 0.1;

double positive_or(const std::optional<double>& value, double fallback) {
  return value && *value > 0 && std::isfinite(*value) ? *value : fallback;
}

controllers::JointFacts facts_of(const std::string& robot, const description::Joint& joint) {
  controllers::JointFacts out;
  out.name = robot + "/" + joint.name;
  out.continuous = joint.type == description::JointType::continuous;
  out.lower = out.continuous ? -kInfinity : joint.limits.lower.value_or(-kInfinity);
  out.upper = out.continuous ? kInfinity : joint.limits.upper.value_or(kInfinity);
  out.velocity = positive_or(joint.limits.velocity, kInfinity);
  out.effort = positive_or(joint.limits.effort, kInfinity);
  out.states_velocity = std::isfinite(out.velocity);
  if (joint.soft_limits && joint.soft_limits->k_position > 0)  // otherwise ignored, as in ros2_control
    out.soft = {std::max(joint.soft_limits->lower.value_or(out.lower), out.lower),
                std::min(joint.soft_limits->upper.value_or(out.upper), out.upper),
                joint.soft_limits->k_position, joint.soft_limits->k_velocity};
  return out;
}

/// Sets default limits for planning only.
void assume_what_is_missing(const description::Joint& joint, controllers::JointFacts& facts) {
  facts.states_velocity = std::isfinite(facts.velocity);
  if (!facts.states_velocity) facts.velocity = kDefaultVelocity;
  if (!facts.states_acceleration)
    facts.acceleration = positive_or(joint.limits.acceleration, facts.velocity / kTimeToSpeed);
  if (!facts.states_jerk)
    facts.jerk = positive_or(joint.limits.jerk, facts.acceleration / kTimeToAcceleration);
}

/// The model's start state, within limits that controllers' files may have narrowed.
std::vector<double> start_of(const description::RobotModel& model,
                             const std::vector<controllers::JointFacts>& joints) {
  std::vector<double> out = model.start();
  if (model.named_states.contains("home")) return out;
  for (std::size_t j = 0; j < joints.size(); ++j)
    out[j] = std::clamp(out[j], joints[j].lower, joints[j].upper);
  return out;
}

bool drives_real_hardware(const std::string& driver) {
  if (driver == "mock" || driver == "mujoco") return false;
  return hardware::make_driver(driver)->real();
}

/// Replaces a driver of real hardware unless real hardware was requested.
std::string unless_real(const std::string& driver, const std::string& who, bool real,
                        std::vector<std::string>& notes) {
  if (real || driver == "declared" || !drives_real_hardware(driver)) return driver;
  const std::string simulated = hardware::driver_available("mujoco") ? "mujoco" : "mock";
  notes.push_back(who + ": " + driver + " drives real hardware; it is simulated by " +
                  (simulated == "mujoco" ? "physics (mujoco)" : simulated) + " unless --real is given");
  return simulated;
}

/// The real driver that a robot's file or its description's plugin names.
std::string real_driver_of(const std::string& hardware, const description::HardwareInfo& info) {
  if (hardware != "declared") return hardware;
  const ros_files::HardwareChoice choice = ros_files::choose_hardware(info.plugin, info.name);
  return choice.real.empty() ? choice.driver : choice.real;
}

bool has_joints(const description::HardwareInfo& info) {
  return std::any_of(info.components.begin(), info.components.end(),
                     [](const auto& c) { return c.kind == "joint"; });
}

/// Physics simulates all joints of a robot or none, because they are coupled.
void all_or_none_by_physics(CellRobot& robot, std::vector<std::string>& notes) {
  bool physics = false, others = false;
  for (const HardwareBlock& block : robot.blocks) {
    if (!has_joints(*block.info)) continue;
    physics |= block.driver == "mujoco";
    others |= block.driver != "mujoco" && block.driver != "mock";
  }
  if (!physics) return;
  for (HardwareBlock& block : robot.blocks) {
    if (!has_joints(*block.info) || block.driver != (others ? "mujoco" : "mock")) continue;
    notes.push_back(block.info->name +
                    (others ? ": simulated by mock, because physics simulates all joints of a robot or none"
                            : ": simulated by physics, like the other joints of the robot"));
    block = {block.info, others ? "mock" : "mujoco", ""};
  }
}

/// Chooses the drivers: one per block of the description, or one for the whole robot.
void choose_drivers(CellRobot& robot, bool real, std::vector<std::string>& notes) {
  const std::string asked = unless_real(robot.entry.hardware, robot.entry.name, real, notes);
  for (const description::HardwareInfo& info : robot.model.hardware) {
    ros_files::HardwareChoice choice{asked, "", "", ""};
    if (asked == "declared") choice = ros_files::choose_hardware(info.plugin, info.name);
    if (real && !choice.real.empty()) choice = {choice.real, "", "", ""};
    choice.driver = unless_real(choice.driver, info.name, real, notes);
    if (!choice.note.empty()) notes.push_back(choice.note);
    robot.blocks.push_back({&info, choice.driver, choice.flag});
  }
  all_or_none_by_physics(robot, notes);
  robot.driver = asked;
  if (!robot.blocks.empty()) robot.driver = robot.blocks.front().driver;
  for (const HardwareBlock& block : robot.blocks)
    if (block.info->type != "sensor") {
      robot.driver = block.driver;
      break;
    }
  if (asked != "declared" || !robot.blocks.empty()) return;
  robot.driver = ros_files::choose_hardware("", robot.entry.name).driver;
  notes.push_back(robot.entry.name + ": the description declares no hardware; it is simulated by " +
                  robot.driver);
}

std::unique_ptr<moves::RobotFacts> motion_facts(const CellRobot& robot, const moves::TcpLimits& tcp,
                                                moves::Workspace workspace) {
  std::vector<trajectory::JointMotionLimits> limits;
  for (const controllers::JointFacts& joint : robot.joints)
    limits.push_back({joint.velocity, joint.acceleration, joint.jerk});
  kinematics::Chain chain(robot.model, robot.model.tool_link(), robot.entry.base, robot.tool.tcp);
  auto solver = std::make_unique<const ik::InverseKinematics>(chain);
  std::vector<double> effort;
  for (const controllers::JointFacts& joint : robot.joints) effort.push_back(joint.effort);
  auto torques = moves::torque_limits_of(robot.model, robot.entry.base, load_of(robot), std::move(effort));
  return std::make_unique<moves::RobotFacts>(moves::RobotFacts{robot.entry.name,
                                                               &robot.model,
                                                               std::move(chain),
                                                               std::move(limits),
                                                               {},
                                                               robot.start,
                                                               std::move(solver),
                                                               std::move(workspace),
                                                               std::move(torques)});
}

/// Reads limits from the description and from joint_limits of the controllers' files.
void read_joints(CellRobot& robot, const std::vector<ros_files::JointLimitsSource>& files,
                 Problems& problems) {
  std::vector<controllers::JointFacts*> joints;
  for (const int index : robot.model.actuated) {
    const description::Joint& joint = robot.model.joints[static_cast<std::size_t>(index)];
    robot.joints.push_back(facts_of(robot.entry.name, joint));
    ros_files::narrow_by_hardware(robot.model, joint.name, robot.joints.back(), problems);
  }
  for (controllers::JointFacts& facts : robot.joints) joints.push_back(&facts);
  for (const ros_files::JointLimitsSource& source : files)
    collect(problems, [&] { ros_files::narrow_by_file(source, joints, problems); });
  for (std::size_t j = 0; j < robot.joints.size(); ++j)
    assume_what_is_missing(robot.model.joints[static_cast<std::size_t>(robot.model.actuated[j])],
                           robot.joints[j]);
}

/// Reports a joint range that excludes the start state; otherwise it would be a fault in the first cycle.
void check_start(const CellRobot& robot, Problems& problems) {
  const std::vector<std::string> names = robot.model.joint_names();
  for (const RangeEntry& range : robot.entry.ranges)
    for (std::size_t j = 0; j < robot.start.size(); ++j)
      if (names[j] == range.joint && (robot.start[j] < range.lower || robot.start[j] > range.upper))
        problems.error("bad-range", range.where,
                       "'" + robot.entry.name + "' starts with " + range.joint + " at " +
                           format_number(robot.start[j]) + ", outside of its range",
                       "widen the range so that the start is inside");
}

/// A carried robot is fixed to its carrier and cannot have a free base.
void check_carried(const CellRobot& robot, Problems& problems) {
  if (robot.entry.on.empty()) return;
  for (const HardwareBlock& block : robot.blocks)
    if (const auto base = block.info->parameters.find("base");
        base != block.info->parameters.end() && base->second == "free")
      problems.error(
          "bad-carrier", robot.entry.place_of("on"),
          "'" + robot.entry.name + "' is on '" + robot.entry.on + "', and by its description it stands free",
          "remove 'on', or remove <param name=\"base\">free</param> from its description");
}

/// One arm of a description cannot take a base with it that the others stand on, too.
void check_branch_base(const CellRobot& robot, Problems& problems) {
  if (robot.entry.branch.empty()) return;
  for (const HardwareBlock& block : robot.blocks)
    if (const auto base = block.info->parameters.find("base");
        base != block.info->parameters.end() && base->second == "free")
      problems.error("bad-branch", robot.entry.place_of("branch"),
                     "'" + robot.entry.name + "' is one branch of a description that stands free or drives",
                     "remove <param name=\"base\">free</param> and put the robot on a carrier with 'on', or "
                     "remove 'branch'");
}

/// Refuses a payload above the robot's rating, like a program's `payload`; warns of a tool above it.
void refuse_overload(const CellRobot& robot, Problems& problems) {
  const std::optional<double>& rated = robot.model.provenance.payload_kg;
  const double payload = robot.entry.payload.mass;
  if (rated && robot.tool.mass > *rated)
    problems.warning("payload", robot.entry.place_of("tool"),
                     fmt::format("the tool {} has {:g} kg, more than the {:g} kg that {} may carry",
                                 robot.entry.tool, robot.tool.mass, *rated, robot.model.name),
                     "correct its 'mass' (a number without a unit is in kilograms), or choose a robot that "
                     "carries it");
  if (!rated || !(payload > *rated)) return;
  problems.error("payload", robot.entry.place_of("payload"),
                 fmt::format("a payload of {:g} kg is more than the {:g} kg that {} may carry", payload,
                             *rated, robot.model.name),
                 "carry less, or choose a robot that carries it");
}

/// Notes the controllers that a description for Gazebo names itself; here they are given separately.
void tell_of_controllers(const CellRobot& robot, std::vector<std::string>& notes) {
  std::error_code error;
  for (const std::string& controllers : robot.model.controller_files)
    if (std::filesystem::is_regular_file(controllers, error))
      notes.push_back(robot.entry.name +
                      ": its <gazebo> names a controllers file, start it with --controllers " + controllers);
}

/// Runs `step`; an error without a location gets the location of this key.
template <typename Step>
void at_key(const RobotEntry& entry, const std::string& key, Step step) {
  try {
    step();
  } catch (const Error& e) {
    std::vector<Problem> problems = e.problems();
    for (Problem& problem : problems)
      if (problem.where.file.empty()) problem.where = entry.place_of(key);
    throw Error(std::move(problems));
  }
}

/// Catalogue robots read so far, by name, because a cell may have a thousand of one model.
using ReadRobots = std::map<std::string, description::RobotModel>;

description::RobotModel read_model(const CellFile& file, const RobotEntry& entry,
                                   const description::Catalogue& catalogue, ReadRobots& read,
                                   Problems& found) {
  if (!entry.text.empty())
    return description::read_urdf(entry.text, entry.model, found,
                                  {description::packages_near(file.folder / "cell.yaml")});
  const auto beside = file.folder / entry.model;
  if (is_file(beside)) return description::load_robot(beside.string(), catalogue, found, entry.arguments);
  if (const auto known = read.find(entry.model); known != read.end()) return known->second;
  if (!catalogue.find(entry.model))
    return description::load_robot(entry.model, catalogue, found, entry.arguments);
  return read.emplace(entry.model, catalogue.load(entry.model)).first->second;
}

/// Replaces the geometry of the description by the measured one, and says how far the tool moves by that.
void calibrate(const CellFile& file, const RobotEntry& entry, description::RobotModel& model,
               std::vector<std::string>& notes) {
  if (entry.calibration.empty()) return;
  const description::RobotModel described = model;
  description::apply(description::read_arm_calibration(file.folder / entry.calibration), model,
                     entry.place_of("calibration"));
  const calibration::Residual moved = calibration::difference_of(described, model, model.tool_link());
  notes.push_back(
      fmt::format("{}: with the calibration {} the tool is up to {:.2f} mm and {:.3f} degrees from where "
                  "the description has it",
                  entry.name, entry.calibration, 1e3 * moved.position, moved.rotation * 180 / M_PI));
}

std::unique_ptr<CellRobot> resolve(const CellFile& file,
                                   const std::vector<ros_files::JointLimitsSource>& limits,
                                   const RobotEntry& entry, const description::Catalogue& catalogue,
                                   ReadRobots& read, bool real, Problems& problems,
                                   std::vector<std::string>& notes) {
  auto robot = std::make_unique<CellRobot>();
  robot->entry = entry;
  Problems found;
  at_key(entry, "model", [&] { robot->model = read_model(file, entry, catalogue, read, found); });
  for (const Problem& problem : found.list())
    if (problem.severity == Severity::error)
      robot->hardware_faults.push_back(problem);
    else
      problems.add(problem);
  at_key(entry, "branch", [&] { description::keep_branch(robot->model, entry.branch); });
  description::set_tip(robot->model, entry.tip, entry.where);
  at_key(entry, "calibration", [&] { calibrate(file, entry, robot->model, notes); });
  narrow_ranges(entry.ranges, robot->model, problems);
  check_collision_torques(entry.collision_torques, robot->model, problems);
  std::vector<moves::WorkspaceZone> zones = file.workspace;
  zones.insert(zones.end(), entry.workspace.begin(), entry.workspace.end());
  robot->slow_zones = moves::Workspace(take_slow_zones(zones));
  find_joints(zones, robot->model, problems);
  moves::Workspace workspace(std::move(zones));
  at_key(entry, "tool", [&] { robot->tool = description::find_tool(entry.tool, file.folder.string()); });
  refuse_overload(*robot, problems);
  if (auto missing = description::missing_in_tool(entry.tool, file.folder.string()))
    problems.add(std::move(*missing));
  read_joints(*robot, limits, problems);
  robot->start = start_of(robot->model, robot->joints);
  check_start(*robot, problems);
  at_key(entry, "hardware", [&] { choose_drivers(*robot, real, notes); });
  if (file.controllers.empty() && !file.launched) tell_of_controllers(*robot, notes);
  check_carried(*robot, problems);
  check_branch_base(*robot, problems);
  robot->facts = motion_facts(*robot, file.motion.tcp, std::move(workspace));
  return robot;
}
}  // namespace

std::vector<NamedHardware> named_real_hardware(const CellRobots& robots) {
  std::vector<NamedHardware> out;
  const auto add = [&](const RobotEntry& entry, const description::HardwareInfo& info) {
    const std::string driver = real_driver_of(entry.hardware, info);
    if (!hardware::driver_available(driver) || !drives_real_hardware(driver)) return;
    NamedHardware named{entry.name, info.name, driver, info.parameters};
    for (const auto& [key, value] : entry.parameters) named.parameters[key] = value;
    out.push_back(std::move(named));
  };
  for (const auto& robot : robots) {
    for (const HardwareBlock& block : robot->blocks) add(robot->entry, *block.info);
    if (!robot->blocks.empty()) continue;
    description::HardwareInfo whole;
    whole.name = robot->entry.name;
    add(robot->entry, whole);
  }
  return out;
}

std::vector<std::string> notes_of_arms(const CellRobots& robots) {
  std::vector<std::string> out;
  for (const auto& robot : robots)
    if (const std::string hint = description::hint_of_arms(robot->model); !hint.empty())
      out.push_back(robot->entry.name + ": " + hint);
  return out;
}

void add_hardware_faults(const CellRobots& robots, Severity as, Problems& problems) {
  for (const auto& robot : robots)
    for (Problem fault : robot->hardware_faults) {
      fault.severity = as;
      problems.add(std::move(fault));
    }
}

CellRobots resolve_robots(const CellFile& file, const description::Catalogue& catalogue, bool real,
                          Problems& problems, std::vector<std::string>& notes) {
  ros_files::ControllersFile described;
  collect(problems, [&] {
    Problems other;  // only limits and wheels of these files are needed
    described = read_cell_controllers(file, other);
  });
  return resolve_robots(file, described, catalogue, real, problems, notes);
}

namespace {
/// Physics only knows the robots that it simulates.
void check_carriers(const CellRobots& robots, Problems& problems) {
  for (const auto& robot : robots) {
    const auto carries = [&](const auto& each) { return each->entry.name == robot->entry.on; };
    const auto carrier = std::find_if(robots.begin(), robots.end(), carries);
    if (carrier == robots.end() || !checks_contacts(*robot) || checks_contacts(**carrier)) continue;
    problems.warning("bad-carrier", robot->entry.place_of("on"),
                     "'" + robot->entry.name + "' is on '" + robot->entry.on +
                         "', which is not in physics: it stays where '" + robot->entry.on + "' begins",
                     "give both the same hardware, for example hardware: mujoco");
  }
}

/// Two branches of one description at one place share what is fixed, but a joint is moved by one robot.
void check_branches(const CellRobots& robots, Problems& problems) {
  for (std::size_t a = 0; a < robots.size(); ++a)
    for (std::size_t b = a + 1; b < robots.size(); ++b) {
      const CellRobot &one = *robots[a], &other = *robots[b];
      if (one.entry.on != other.entry.on || (one.entry.branch.empty() && other.entry.branch.empty()))
        continue;
      if (description::shared_links(one.model, one.entry.base, other.model, other.entry.base).empty())
        continue;
      std::vector<std::string> both;
      for (const std::string& joint : one.model.joint_names())
        if (other.model.find_joint(joint) >= 0) both.push_back(joint);
      if (both.empty()) continue;
      const bool whole = one.entry.branch.empty() || other.entry.branch.empty();
      problems.error(
          "shared-joint", other.entry.place_of("branch"),
          "'" + one.entry.name + "' and '" + other.entry.name + "' are at the same place and both have " +
              (both.size() == 1 ? "the joint " : "the joints ") + join(both, ", "),
          whole ? "give each of them a 'branch' with a link of another arm"
                : "choose branches without a joint in common; if one joint carries both arms, write a "
                  "description in which it is fixed, or use the description as one robot, without "
                  "'branch'");
    }
}

/// The robot that has the joint, as controllers find it: "robot/joint", else a joint of the robot to which
/// the controller belongs, else of the only robot that has it.
std::pair<CellRobot*, int> owner_of(const std::string& written, const std::string& ns,
                                    const CellRobots& robots) {
  std::pair<CellRobot*, int> only{nullptr, -1};
  std::size_t count = 0;
  for (const auto& robot : robots) {
    const std::string prefix = robot->entry.name + "/";
    if (written.starts_with(prefix))
      if (const int joint = robot->model.find_joint(written.substr(prefix.size())); joint >= 0)
        return {robot.get(), joint};
  }
  for (const auto& robot : robots) {
    const int joint = robot->model.find_joint(written);
    if (joint < 0) continue;
    if (robot->entry.name == ns) return {robot.get(), joint};
    if (count++ == 0 || robot == robots.front()) only = {robot.get(), joint};
  }
  return count == 1 || only.first == robots.front().get() ? only : std::pair<CellRobot*, int>{nullptr, -1};
}

/// Controllers of bases say which joints are wheels, whatever these look like.
void find_wheels(const ros_files::ControllersFile& described, const CellRobots& robots) {
  if (robots.empty()) return;
  for (const ros_files::ControllerEntry& entry : described.controllers) {
    const std::string ns = entry.ns.substr(entry.ns.rfind('/') + 1);
    for (const std::string& written : controllers::wheel_names(entry.parameters)) {
      auto [robot, joint] = owner_of(written, ns, robots);
      if (!robot)  // "pid_left/left_wheel_joint": a controller between this one and the joint
        std::tie(robot, joint) = owner_of(written.substr(written.rfind('/') + 1), ns, robots);
      if (robot && std::find(robot->wheel_joints.begin(), robot->wheel_joints.end(), joint) ==
                       robot->wheel_joints.end())
        robot->wheel_joints.push_back(joint);
    }
  }
}
}  // namespace

CellRobots resolve_robots(const CellFile& file, const ros_files::ControllersFile& described,
                          const description::Catalogue& catalogue, bool real, Problems& problems,
                          std::vector<std::string>& notes) {
  CellRobots out;
  ReadRobots read;
  for (const RobotEntry& entry : file.robots) {
    try {
      out.push_back(resolve(file, described.joint_limits, entry, catalogue, read, real, problems, notes));
    } catch (const Error& e) {
      for (Problem problem : e.problems()) {
        if (problem.where.file.empty()) problem.where = entry.where;
        problems.add(std::move(problem));
      }
    }
  }
  find_wheels(described, out);
  check_carriers(out, problems);
  check_branches(out, problems);
  if (real) admit_robots(file, problems);
  return out;
}

bool waits_for_a_device(const std::string& driver) {
  return driver != kPhysics && driver != "mock" && hardware::make_driver(driver)->blocks();
}

bool on_threads(const CellRobot& robot) {
  if (robot.entry.thread) return true;
  if (robot.blocks.empty()) return waits_for_a_device(robot.driver);
  return std::all_of(robot.blocks.begin(), robot.blocks.end(), [](const HardwareBlock& block) {
    return block.driver != "mujoco" && (block.info->is_async || waits_for_a_device(block.driver));
  });
}

unsigned divisor_of(const CellRobot& robot, Nanoseconds period, Problems& problems) {
  const RobotEntry& entry = robot.entry;
  if (entry.rate <= 0) return 1;
  const double loop = 1 / seconds(period), exact = loop / entry.rate;
  const double whole = std::clamp(std::round(exact), 1.0, 1e6);
  if (std::abs(exact - whole) <= 1e-6 * exact) return static_cast<unsigned>(whole);
  const double below = std::max(1.0, std::floor(exact));
  if (!on_threads(robot))
    problems.error("bad-rate", entry.where,
                   "'" + entry.name + "' is to run at " + format_number(entry.rate) +
                       " Hz in the control loop, which is not a part of its " + format_number(loop) + " Hz",
                   (exact < 1 ? "the loop runs at least as fast as what it calls: raise the cell's rate"
                              : "choose " + format_number(loop / std::ceil(exact)) + " or " +
                                    format_number(loop / below) + ", or another rate of the cell") +
                       "; with 'thread: true' its hardware has a thread of its own, which runs at any rate");
  return static_cast<unsigned>(below);
}

std::vector<PlayedBlock> played_by_physics(const CellRobots& robots) {
  std::vector<PlayedBlock> out;
  for (const auto& robot : robots)
    for (const HardwareBlock& block : robot->blocks)
      if (block.driver == kPhysics && has_joints(*block.info)) out.push_back({robot.get(), block.info});
  return out;
}

std::string physics_name(const CellRobots& robots) {
  for (const auto& robot : robots)
    if (robot->blocks.empty() && robot->driver == kPhysics) return kPhysics;
  const std::vector<PlayedBlock> played = played_by_physics(robots);
  return played.empty() || played.front().info->name.empty() ? kPhysics : played.front().info->name;
}

std::vector<std::string> names_of_component(const CellRobots& robots, const std::string& component) {
  std::vector<std::string> out{component};
  if (component != physics_name(robots)) return out;
  for (const PlayedBlock& played : played_by_physics(robots))
    if (std::find(out.begin(), out.end(), played.info->name) == out.end()) out.push_back(played.info->name);
  return out;
}

moves::Payload load_of(const CellRobot& robot) {
  return moves::joined(
      {robot.tool.mass, robot.tool.center},
      {robot.entry.payload.mass, robot.entry.payload.center.value_or(robot.tool.tcp.position)});
}

data::JointState joint_state(const description::RobotModel& model, std::vector<double> positions) {
  data::JointState out{model.joint_names(), std::move(positions)};
  for (std::size_t j = 0; j < model.actuated.size(); ++j)
    out.note_given(
        j, model.joints[static_cast<std::size_t>(model.actuated[j])].type == description::JointType::prismatic
               ? Dimension::length
               : Dimension::angle);
  return out;
}

}  // namespace polyarm::cell
