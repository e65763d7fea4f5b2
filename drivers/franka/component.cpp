#include "drivers/franka/component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/franka/errors.hpp"
#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::franka {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {

// Commands within these multiples of the description's limits are sent as they are, among them the loop's
// hardest stop, which is three times as hard as a move. The robot's own limits hold in any case.
constexpr double kAcceleration = 4, kJerk = 24;
constexpr double kAccelerationElse = 5, kJerkElse = 500;  // rad, seconds; without limits there
constexpr double kNoSpeedLimit = 1000;                    // degrees/s, above that of any joint

using hardware::DriverParameter;
using enum hardware::ParameterKind;
constexpr DriverParameter kParameters[] = {
    {"host", text, nullptr, "address of the robot's controller (not that of its arm)"},
    {"port", number, "1337", "TCP port of the Franka Control Interface", 1, 65535},
    {"version", number, "0", "version of the interface that is tried first, 5 to 10; 0: the newest", 0, 10},
    {"command", text, "position", "`position` or `velocity`: what the joints are commanded with"},
    {"controller", text, "joint_impedance",
     "`joint_impedance` or `cartesian_impedance`: the robot's own controller that follows the commands"},
    {"pace", boolean, "true",
     "the control loop follows the robot's clock (1000 Hz); one robot of a cell can do that"},
    {"recover", boolean, "true", "activating recovers from an error whose cause is gone"},
    {"contact_torque", text, "", "N m above which a joint reports a contact; one number or seven"},
    {"collision_torque", text, "", "N m above which a joint stops the robot; one number or seven"},
    {"contact_force", text, "",
     "N and N m above which the end effector reports a contact; one number or six"},
    {"collision_force", text, "",
     "N and N m above which the end effector stops the robot; one number or six"},
    {"joint_stiffness", text, "", "N m/rad of the robot's controller; one number or seven"},
    {"cartesian_stiffness", text, "", "N/m and N m/rad of the robot's controller; six numbers"},
    {"guiding", text, "", "what hand guiding may move, such as `x y z rx ry rz elbow`"},
    {"load_mass", number, "0", "kg at the flange beside the end effector that Desk knows; with `load_center`",
     0, 20},
    {"load_center", text, "", "m, centre of the load in the flange, three numbers; with it the load is set"},
    {"load_inertia", text, "", "kg m² of the load about its centre: nine numbers, by columns"},
    {"hand", boolean, "false", "the Franka Hand is used as the tool"},
    {"hand_port", number, "1338", "TCP port of the hand", 1, 65535},
    {"hand_force", number, "0", "N of a grasp; 0: that of the cell's tool, else 40", 0, 140},
    {"hand_speed", number, "0.1", "m/s of the fingers", 0.001, 0.2},
    {"hand_open", number, "0", "m between the fingers when they open; 0: that of the cell's tool, else all",
     0, 0.2},
    {"max_speed", number, "0", "degrees/s of each joint; 0: what the robot allows", 0, 300},
    {"max_behind", number, "0.05", "rad that the sent command may be behind the loop's", 0.0001, 0.2},
    {"max_step", number, "0.1",
     "rad, between two position commands; beyond it nothing is sent and the robot stops", 0.001, 0.6},
    {"least_success", number, "0",
     "share of the last 100 commands that must be in time, else the link ends; 0: it is not judged", 0, 1},
    {"silence_ms", number, "100", "ms without a state until the link ends", 10, 10000},
    {"loop_silence_ms", number, "100", "ms without a command of the loop until the robot is braked", 5,
     10000},
    {"connect_timeout", number, "2", "s for each connection and answer", 0.05, 60},
    {"start_timeout", number, "10", "s for a motion to begin and to end, and for a recovery", 0.05, 600},
};
constexpr hardware::DriverFacts kFacts = {"system",
                                          "robots of Franka: Research 3 and Panda, with the Franka Hand",
                                          "a controller of our own, byte for byte, with faults on each wire, "
                                          "which the maker's library accepts; see "
                                          "docs/driver-franka.md; never on hardware",
                                          kParameters};

constexpr const char* kPoseNames[] = {"position.x",    "position.y",    "position.z",   "orientation.x",
                                      "orientation.y", "orientation.z", "orientation.w"};
constexpr const char* kWrenchNames[] = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};
constexpr const char* kControllerStates[] = {"mode",         "ready",       "guiding", "user_stop", "error",
                                             "success_rate", "lost_states", "behind",  "shaped"};
constexpr const char* kHandStates[] = {"width", "max_width", "part_present", "busy", "temperature"};
constexpr const char* kHandCommands[] = {"grip", "width", "homing"};
constexpr const char* kGuidingNames[] = {"x", "y", "z", "rx", "ry", "rz", "elbow"};

[[noreturn]] void refuse(const char* parameter, const std::string& given, const std::string& expected) {
  throw Error("bad-value", fmt::format("`{}` is '{}'", parameter, given), "write " + expected);
}

/// As many numbers as `Values` has, or one for all of them; nothing for an empty text.
template <class Values>
std::optional<Values> values_of(hardware::DriverParameters& p, const char* parameter,
                                bool one_for_all = true) {
  const std::string given = p.text(parameter);
  const auto words = split_words(given, " ,;");
  if (words.empty()) return std::nullopt;
  Values out;
  const bool single = one_for_all && words.size() == 1;
  if (!single && words.size() != out.size())
    refuse(parameter, given, fmt::format("{}{} numbers", one_for_all ? "one or " : "", out.size()));
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto value = parse_number(words[single ? 0 : i]);
    if (!value || !std::isfinite(*value)) refuse(parameter, given, "numbers, such as 20");
    out[i] = *value;
  }
  return out;
}

/// Thresholds of which only some are given follow from the others.
template <class Values>
void complete(const std::optional<Values>& lower, const std::optional<Values>& upper, Values& low,
              Values& high, double otherwise) {
  high.fill(2 * otherwise);
  low.fill(otherwise);
  if (upper) high = *upper;
  if (lower) low = *lower;
  for (std::size_t i = 0; i < low.size(); ++i) {
    if (!lower) low[i] = high[i] / 2;
    if (!upper) high[i] = std::max(high[i], 2 * low[i]);
  }
}

}  // namespace

void FrankaComponent::read_robot_settings(hardware::DriverParameters& p) {
  RobotSettings& out = settings_.robot;
  out = {};
  const auto low_torque = values_of<Seven>(p, "contact_torque"),
             torque = values_of<Seven>(p, "collision_torque");
  const auto low_force = values_of<Six>(p, "contact_force"), force = values_of<Six>(p, "collision_force");
  if (low_torque || torque || low_force || force) {
    out.collision.emplace();
    complete(low_torque, torque, out.collision->lower_torque, out.collision->upper_torque, 20);
    complete(low_force, force, out.collision->lower_force, out.collision->upper_force, 20);
    if (!decode_collision(encode(*out.collision)))
      throw Error(
          "bad-value", "a contact's threshold is negative, or above that of a collision",
          "make `contact_torque` and `contact_force` smaller than `collision_torque` and `collision_force`");
  }
  out.joint_stiffness = values_of<Seven>(p, "joint_stiffness");
  out.cartesian_stiffness = values_of<Six>(p, "cartesian_stiffness", false);
  if (const std::string given = p.text("guiding"); !given.empty()) {
    out.guiding.emplace();
    out.guiding->fill(false);
    for (const std::string& word : split_words(given, " ,;")) {
      const auto* const at = std::find(std::begin(kGuidingNames), std::end(kGuidingNames), word);
      if (at == std::end(kGuidingNames)) refuse("guiding", given, "some of x y z rx ry rz elbow");
      (*out.guiding)[static_cast<std::size_t>(at - std::begin(kGuidingNames))] = true;
    }
  }
  const auto center = values_of<std::array<double, 3>>(p, "load_center", false);
  const auto inertia = values_of<std::array<double, 9>>(p, "load_inertia", false);
  const double mass = p.number("load_mass");
  if (!center && (mass > 0 || inertia))
    throw Error("bad-value", "a load needs its centre",
                "write `load_center: \"0 0 0.05\"` beside `load_mass`");
  if (center) out.load = Load{mass, *center, inertia.value_or(std::array<double, 9>{})};
}

void FrankaComponent::read_hand(hardware::DriverParameters& p, const hardware::RobotInstance& robot) {
  HandSettings& hand = settings_.hand;
  hand.used = p.boolean("hand");
  hand.port = static_cast<int>(p.number("hand_port"));
  hand.speed = p.number("hand_speed");
  const bool gripper = robot.tool && robot.tool->gripper == description::GripperKind::parallel;
  const auto choose = [&](const char* parameter, double of_tool, double otherwise) {
    const double given = p.number(parameter);
    return given > 0 ? given : gripper ? of_tool : otherwise;
  };
  hand.force = choose("hand_force", gripper ? robot.tool->grip_force : 0, 40);
  hand.open_width = choose("hand_open", gripper ? robot.tool->stroke : 0, 0.08);
}

void FrankaComponent::find_limits(const hardware::RobotInstance& robot, double max_speed) {
  auto& [velocity, acceleration, jerk] = settings_.limits.of;
  velocity.fill((max_speed > 0 ? max_speed : kNoSpeedLimit) * wire::kRadians);
  acceleration.fill(kAccelerationElse);
  jerk.fill(kJerkElse);
  settings_.lower = settings_.upper = {};
  if (!robot.model) return;
  for (std::size_t i = 0; i < joints_.size(); ++i)
    for (const description::Joint& joint : robot.model->joints)
      if (joint.name == joints_[i]) {
        if (const auto a = joint.limits.acceleration) acceleration[i] = kAcceleration * *a;
        if (const auto j = joint.limits.jerk) jerk[i] = kJerk * *j;
        if (joint.limits.lower && joint.limits.upper) {
          settings_.lower[i] = *joint.limits.lower;
          settings_.upper[i] = *joint.limits.upper;
        }
      }
}

CallbackReturn FrankaComponent::on_init(const hardware::ComponentContext& context) {
  period_ = context.period;
  hardware::DriverParameters p(kFacts, context);
  settings_.host = p.text("host");
  settings_.port = static_cast<int>(p.number("port"));
  settings_.version = static_cast<int>(p.number("version"));
  const std::string command = p.text("command"), controller = p.text("controller");
  paced_ = p.boolean("pace");
  settings_.follows = paced_ || follows_;
  settings_.stepped = stepped_link_;
  settings_.recover = p.boolean("recover");
  settings_.least_success = p.number("least_success");
  settings_.read(p);
  steps_ = wire::StepCheckOf<7>(p.number("max_step"));
  const bool by_velocity = command == "velocity";
  const char* const takes[] = {by_velocity ? "velocity" : "position"};
  joints_ = wire::driven_joints(context, takes, "robots of Franka", p.problems(), 7, 7);
  p.problems().throw_if_errors();
  if (!by_velocity && command != "position") refuse("command", command, "`position` or `velocity`");
  if (controller != "joint_impedance" && controller != "cartesian_impedance")
    refuse("controller", controller, "`joint_impedance` or `cartesian_impedance`");
  if (settings_.version != 0 && settings_.version < kOldestVersion)
    refuse("version", std::to_string(settings_.version), "0, or 5 to 10");
  settings_.generator = by_velocity ? Generator::joint_velocity : Generator::joint_position;
  settings_.controller =
      controller == "joint_impedance" ? Controller::joint_impedance : Controller::cartesian_impedance;
  const hardware::RobotInstance& robot = context.robots.front();
  robot_ = robot.name;
  read_robot_settings(p);
  read_hand(p, robot);
  find_limits(robot, p.number("max_speed"));
  link_ = std::make_unique<Link>(settings_);
  return CallbackReturn::success;
}

std::vector<hardware::InterfaceDescription> FrankaComponent::state_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  const auto add = [&](const std::string& name) { out.push_back({robot_ + "/" + name}); };
  for (const std::string& joint : joints_)
    for (const char* one : {"/position", "/velocity", "/effort", "/external_torque"}) add(joint + one);
  for (const char* one : kPoseNames) add(std::string("tcp_pose/") + one);
  for (const char* frame : {"force/", "force_base/"})
    for (const char* one : kWrenchNames) add(std::string(frame) + one);
  for (const char* one : kControllerStates) add(std::string("controller/") + one);
  if (settings_.hand.used)
    for (const char* one : kHandStates) add(std::string("tool/") + one);
  return out;
}

std::vector<hardware::InterfaceDescription> FrankaComponent::command_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  const char* const kind = settings_.generator == Generator::joint_velocity ? "/velocity" : "/position";
  for (const std::string& joint : joints_) out.push_back({robot_ + "/" + joint + kind});
  if (settings_.hand.used)
    for (const char* one : kHandCommands) out.push_back({robot_ + "/tool/" + one});
  return out;
}

ReturnType FrankaComponent::read(const hardware::Cycle&, std::span<double> states) noexcept {
  link_->fetch();
  const Sample& sample = link_->sample();
  const RobotState& robot = sample.state;
  std::size_t at = 0;
  for (std::size_t j = 0; j < joints_.size(); ++j)
    for (const double value : {robot.q[j], robot.dq[j], robot.tau_J[j], robot.tau_ext[j]})
      states[at++] = value;
  for (const double value : pose_of(robot.O_T_EE)) states[at++] = value;
  for (const Six& wrench : {robot.K_F_ext, robot.O_F_ext})
    for (const double value : wrench) states[at++] = value;
  const auto bit = [](bool on) { return on ? 1.0 : 0.0; };
  const bool ready = robot.mode == RobotMode::move && robot.generator == settings_.generator;
  for (const double value :
       {static_cast<double>(robot.mode), bit(ready), bit(robot.mode == RobotMode::guiding),
        bit(robot.mode == RobotMode::user_stopped), static_cast<double>(first_error(robot.errors)),
        robot.success_rate, static_cast<double>(sample.lost), sample.behind,
        static_cast<double>(sample.shaped)})
    states[at++] = value;
  if (settings_.hand.used) {
    const auto& [hand, busy] = link_->panel();
    for (const double value :
         {hand.width, hand.max_width, bit(hand.grasped), bit(busy), static_cast<double>(hand.temperature)})
      states[at++] = value;
  }
  return link_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

/// Without a command for one joint the whole arm comes to rest.
ReturnType FrankaComponent::write_velocities(std::span<const double> commands) noexcept {
  Seven wanted{};
  std::copy_n(commands.begin(), wanted.size(), wanted.begin());
  const bool all = std::all_of(wanted.begin(), wanted.end(), [](double v) { return std::isfinite(v); });
  link_->command(all, all ? wanted : Seven{});
  return ReturnType::ok;
}

ReturnType FrankaComponent::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  if (link_->cause() != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  if (settings_.hand.used) {
    HandWish wish;
    wish.grip = commands[7], wish.width = commands[8], wish.homing = commands[9];
    link_->hand_wish(wish);
  }
  return settings_.generator == Generator::joint_velocity ? write_velocities(commands)
                                                          : write_joints(commands);
}

const hardware::DriverFacts* FrankaComponent::facts() const noexcept {
  return &kFacts;
}

std::string FrankaComponent::summary() const {
  if (!link_) return {};
  return fmt::format("Franka controller at {}, interface version {} ({}), joint {} at {:g} Hz{}",
                     settings_.host, link_->version(), link_->version() <= 5 ? "Panda" : "Research 3",
                     settings_.generator == Generator::joint_velocity ? "velocities" : "positions",
                     link_->rate(), settings_.hand.used ? ", with its hand" : "");
}

}  // namespace polyarm::franka
