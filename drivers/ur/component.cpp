#include "drivers/ur/component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::ur {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {

using hardware::DriverParameter;
using enum hardware::ParameterKind;
constexpr DriverParameter kParameters[] = {
    {"host", text, nullptr, "address of the controller, as its network settings show it"},
    {"own_address", text, "",
     "address of this computer that the robot reaches; else the one that reaches the robot"},
    {"own_port", number, "0", "port for the robot's program to connect to; 0: any free one", 0, 65535},
    {"rtde_port", number, "30004", "of the controller", 1, 65535},
    {"primary_port", number, "30001", "of the controller", 1, 65535},
    {"dashboard_port", number, "29999", "of the controller", 1, 65535},
    {"dashboard", boolean, "true", "false: PolyScope X, which has no dashboard server"},
    {"rate", number, "0", "Hz; 0: 500, or 125 before software 5", 0, 500},
    {"pace", boolean, "true",
     "the control loop follows the controller's clock; one robot of a cell can do that"},
    {"io", boolean, "true", "writes outputs and the speed slider; false leaves them to another program"},
    {"watchdog_ms", number, "100", "ms without a command until the robot's program stops the robot", 10,
     5000},
    {"silence_ms", number, "200", "ms without a package of the controller until the link counts as lost", 20,
     10000},
    {"connect_timeout", number, "2", "s for each connection and answer", 0.05, 60},
    {"start_timeout", number, "5", "s for the program on the robot to connect", 0.05, 60},
    {"lookahead", number, "0.03", "s, of servoj: more is smoother and later", 0.03, 0.2},
    {"gain", number, "2000", "of servoj: less is softer", 100, 2000},
    {"stop_deceleration", number, "4", "rad/s², when commands end", 0.5, 40},
    {"acceleration", number, "15", "rad/s², of velocity commands", 0.5, 40},
    {"max_step", number, "0.1",
     "rad, between two position commands; beyond it nothing is sent and the robot stops", 0.001, 0.6},
    {"motion", text, "stream",
     "stream: this computer interpolates and streams commands; forward: the controller makes the moves",
     -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), "stream forward"},
    {"line_acceleration", number, "1.2", "forward: m/s² of lines and arcs", 0.05, 20},
};
constexpr hardware::DriverFacts kFacts = {"system",
                                          "robots of Universal Robots: CB3 from 3.5, e-Series, PolyScope X",
                                          "a controller of our own, byte for byte, with faults on every "
                                          "wire; see docs/driver-ur.md for peers; never on hardware",
                                          kParameters};

constexpr const char* kPoseNames[] = {"position.x",    "position.y",    "position.z",   "orientation.x",
                                      "orientation.y", "orientation.z", "orientation.w"};
constexpr const char* kWrenchNames[] = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};
constexpr std::pair<const char*, Field> kControllerStates[] = {
    {"robot_mode", kRobotMode},       {"safety_mode", kSafetyMode},   {"program_state", kRuntimeState},
    {"speed_scaling", kSpeedScaling}, {"speed_slider", kSpeedSlider}, {"payload", kPayload}};
constexpr Field kAnalogs[] = {kAnalogIn0, kAnalogIn1, kAnalogOut0, kAnalogOut1};

std::array<double, 7> pose_of(const double* vector) noexcept {
  const double angle = std::hypot(vector[3], vector[4], vector[5]);
  const double s = angle > 0 ? std::sin(angle / 2) / angle : 0.5;
  return {vector[0], vector[1], vector[2], s * vector[3], s * vector[4], s * vector[5], std::cos(angle / 2)};
}

/// The controller gives forces and torques in the axes of its base.
std::array<double, 6> in_axes_of(const std::array<double, 7>& tcp, const double* wrench) noexcept {
  const Quaternion turn = inverse(Quaternion{tcp[3], tcp[4], tcp[5], tcp[6]});
  const Vec3 force = turn * Vec3{wrench[0], wrench[1], wrench[2]},
             torque = turn * Vec3{wrench[3], wrench[4], wrench[5]};
  return {force.x, force.y, force.z, torque.x, torque.y, torque.z};
}

bool ends_with(const std::string& name, const char* tail) {
  return std::string_view(name).ends_with(tail);
}
}  // namespace

void UrComponent::find_joints(const hardware::ComponentContext& context, Problems& problems) {
  if (context.robots.size() != 1) {
    problems.error("bad-hardware", {}, "'" + context.name + "' drives one robot",
                   "give each robot its own hardware");
    return;
  }
  const hardware::RobotInstance& robot = context.robots.front();
  robot_ = robot.name;
  bool position = false, velocity = false;
  for (const description::HardwareInfo& block : robot.hardware)
    for (const description::ComponentInfo& part : block.components) {
      if (part.kind != "joint") continue;
      joints_.push_back(part.name);
      for (const description::InterfaceInfo& one : part.command_interfaces) {
        position = position || one.name == "position";
        velocity = velocity || one.name == "velocity";
        if (one.name != "position" && one.name != "velocity")
          problems.error("unknown-interface", one.where,
                         "'" + part.name + "' takes no command '" + one.name + "'",
                         "it takes position or velocity");
      }
    }
  if (robot.model && joints_.empty()) {
    joints_ = robot.model->joint_names();
    position = true;
    if (joints_.size() > 6) joints_.resize(6);  // a gripper behind the arm has its own hardware
  }
  positions_ = position || !velocity;
  velocities_ = velocity;
  if (joints_.size() != 6)
    problems.error("bad-hardware", {},
                   "'" + context.name + "' has " + std::to_string(joints_.size()) +
                       " joints; a robot of Universal Robots has six",
                   "name them in the order from base to tool");
  velocity_limits_.assign(6, 2 * std::numbers::pi);
  if (!robot.model) return;
  for (std::size_t i = 0; i < joints_.size() && i < 6; ++i)
    for (const description::Joint& joint : robot.model->joints)
      if (joint.name == joints_[i]) {
        velocity_limits_[i] = joint.limits.velocity.value_or(velocity_limits_[i]);
        described_.push_back({joint.origin, joint.axis});
      }
}

CallbackReturn UrComponent::on_init(const hardware::ComponentContext& context) {
  name_ = context.name;
  period_ = context.period;
  hardware::DriverParameters p(kFacts, context);
  settings_.host = p.text("host");
  settings_.own_address = p.text("own_address");
  settings_.own_port = static_cast<int>(p.number("own_port"));
  settings_.rtde_port = static_cast<int>(p.number("rtde_port"));
  settings_.primary_port = static_cast<int>(p.number("primary_port"));
  settings_.dashboard_port = static_cast<int>(p.number("dashboard_port"));
  settings_.dashboard = p.boolean("dashboard");
  settings_.rate = p.number("rate");
  settings_.io = p.boolean("io");
  settings_.watchdog_ms = static_cast<int>(p.number("watchdog_ms"));
  settings_.silence = nanoseconds(p.number("silence_ms") / 1000);
  settings_.connect_timeout = nanoseconds(p.number("connect_timeout"));
  settings_.start_timeout = nanoseconds(p.number("start_timeout"));
  settings_.script.lookahead = p.number("lookahead");
  settings_.script.gain = p.number("gain");
  settings_.script.stop_deceleration = p.number("stop_deceleration");
  settings_.script.acceleration = p.number("acceleration");
  paced_ = p.boolean("pace");
  steps_ = wire::StepCheck(p.number("max_step"));
  find_joints(context, p.problems());
  p.problems().throw_if_errors();
  settings_.forward.reset();
  if (p.text("motion") == "forward") make_forward(context, p);
  mode_ = positions_ ? Mode::position : Mode::velocity;
  outputs_ = written_ = Outputs();
  link_ = std::make_unique<Link>(settings_);
  return CallbackReturn::success;
}

std::vector<hardware::InterfaceDescription> UrComponent::state_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  const auto add = [&](const std::string& name) { out.push_back({robot_ + "/" + name}); };
  for (const std::string& joint : joints_)
    for (const char* one : {"/position", "/velocity", "/current", "/effort"}) add(joint + one);
  for (const char* one : kPoseNames) add(std::string("tcp_pose/") + one);
  for (const char* one : kWrenchNames) add(std::string("tcp_wrench/") + one);
  for (const auto& [name, field] : kControllerStates) add(std::string("controller/") + name);
  add("controller/lost_packages");
  add("controller/command_age");
  for (const char* side : {"digital_in_", "digital_out_"})
    for (std::size_t i = 0; i < Outputs::kDigital; ++i) add("io/" + (side + std::to_string(i)));
  for (const char* one : {"analog_in_0", "analog_in_1", "analog_out_0", "analog_out_1"})
    add(std::string("io/") + one);
  return out;
}

std::vector<hardware::InterfaceDescription> UrComponent::command_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  for (const std::string& joint : joints_)
    out.push_back({robot_ + "/" + joint + (positions_ ? "/position" : "/velocity")});
  if (positions_ && velocities_)
    for (const std::string& joint : joints_) out.push_back({robot_ + "/" + joint + "/velocity"});
  if (!settings_.io) return out;
  if (!settings_.forward) out.push_back({robot_ + "/controller/speed_slider"});
  for (std::size_t i = 0; i < Outputs::kDigital; ++i)
    out.push_back({robot_ + "/io/digital_out_" + std::to_string(i)});
  for (std::size_t i = 0; i < Outputs::kAnalog; ++i)
    out.push_back({robot_ + "/io/analog_out_" + std::to_string(i)});
  return out;
}

ReturnType UrComponent::prepare_command_mode_switch(std::span<const std::string> start,
                                                    std::span<const std::string>) {
  const auto any = [&](const char* tail) {
    return std::any_of(start.begin(), start.end(),
                       [&](const std::string& name) { return ends_with(name, tail); });
  };
  return any("/position") && any("/velocity") ? ReturnType::error : ReturnType::ok;
}

ReturnType UrComponent::perform_command_mode_switch(std::span<const std::string> start,
                                                    std::span<const std::string>) noexcept {
  for (const std::string& name : start) {
    if (ends_with(name, "/position")) mode_ = Mode::position;
    if (ends_with(name, "/velocity")) mode_ = Mode::velocity;
  }
  steps_.begin();
  return ReturnType::ok;
}

CallbackReturn UrComponent::on_configure() {
  active_ = false;
  if (!link_->open()) return CallbackReturn::failure;
  const double cell = 1 / seconds(period_);
  if (paced_ && std::abs(cell - link_->rate()) > 0.01 * link_->rate()) {
    link_->fail(Cause::wrong_rate, static_cast<int>(std::lround(link_->rate())));
    link_->close();
    return CallbackReturn::failure;
  }
  return CallbackReturn::success;
}

CallbackReturn UrComponent::on_activate() {
  steps_.begin();
  watch_.begin();
  last_command_ = 0;
  if (!link_->start()) return CallbackReturn::failure;
  active_ = true;
  return CallbackReturn::success;
}

CallbackReturn UrComponent::on_deactivate() {
  active_ = false;
  link_->stop();
  return CallbackReturn::success;
}

CallbackReturn UrComponent::on_cleanup() {
  active_ = false;
  link_->close();
  return CallbackReturn::success;
}

CallbackReturn UrComponent::on_shutdown() {
  return on_cleanup();
}
CallbackReturn UrComponent::on_error() {
  return on_cleanup();
}

ReturnType UrComponent::read(const hardware::Cycle&, std::span<double> states) noexcept {
  link_->fetch();
  const Sample& sample = link_->sample();
  const double* values = sample.values.data();
  std::size_t at = 0;
  for (std::size_t j = 0; j < 6; ++j)
    for (const Field field : {kPosition, kVelocity, kCurrent, kTorque})
      states[at++] = values[place_of(field) + j];
  const std::array<double, 7> tcp = pose_of(values + place_of(kPose));
  for (const double value : tcp) states[at++] = value;
  for (const double value : in_axes_of(tcp, values + place_of(kWrench))) states[at++] = value;
  for (const auto& [name, field] : kControllerStates) states[at++] = sample[field];
  states[at++] = static_cast<double>(sample.lost);
  states[at++] = last_command_ > 0 ? last_command_ - sample[kSequence] : 0;
  for (const Field field : {kDigitalIn, kDigitalOut}) {
    const double word = sample[field];
    const bool valid = word >= 0 && word < 0x1p64;  // a conversion outside of it is undefined
    const auto bits = valid ? static_cast<std::uint64_t>(word) : 0;
    for (std::size_t i = 0; i < Outputs::kDigital; ++i) states[at++] = static_cast<double>(bits >> i & 1);
  }
  for (const Field field : kAnalogs) states[at++] = sample[field];
  return link_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

void UrComponent::write_outputs(std::span<const double> commands) noexcept {
  std::size_t at = 0;
  if (!settings_.forward) outputs_.speed_slider = commands[at++];
  for (double& value : outputs_.digital) value = commands[at++];
  for (double& value : outputs_.analog) value = commands[at++];
  const auto bytes = [](const Outputs& outputs) { return std::as_bytes(std::span(&outputs, 1)); };
  if (std::ranges::equal(bytes(outputs_), bytes(written_))) return;  // as bytes: NaN is NaN
  link_->outputs(outputs_);
  written_ = outputs_;
}

ReturnType UrComponent::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  if (link_->cause() != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  const Mode mode = mode_.load(std::memory_order_relaxed);
  const bool both = positions_ && velocities_;
  const auto joints = commands.subspan(both && mode == Mode::velocity ? 6 : 0, 6);
  if (settings_.io) write_outputs(commands.subspan(both ? 12 : 6));
  wire::Six measured;
  std::copy_n(link_->sample().values.begin() + place_of(kPosition), 6, measured.begin());
  if (settings_.forward) return write_moves(joints, measured);
  std::array<double, 6> values{};
  for (std::size_t j = 0; j < 6; ++j) {
    if (!std::isfinite(joints[j])) {  // without a command for one joint the whole arm holds
      last_command_ = link_->command(Mode::hold, {});
      steps_.begin();
      return ReturnType::ok;
    }
    values[j] =
        mode == Mode::velocity ? std::clamp(joints[j], -velocity_limits_[j], velocity_limits_[j]) : joints[j];
  }
  if (mode == Mode::position) {
    if (const auto joint = steps_.jumps(values, measured)) {
      link_->fail(Cause::jump, *joint);
      return ReturnType::error;
    }
  }
  last_command_ = link_->command(mode, values);
  return ReturnType::ok;
}

std::string UrComponent::reason() const {
  return link_ ? link_->reason() : std::string();
}

const hardware::DriverFacts* UrComponent::facts() const noexcept {
  return &kFacts;
}

std::string UrComponent::summary() const {
  if (!link_) return {};
  std::string out = fmt::format("Universal Robots controller {} at {}, {:g} Hz{}", link_->version(),
                                settings_.host, link_->rate(), settings_.forward ? ", its own motion" : "");
  if (const auto k = link_->kinematics(); k && described_.size() == 6) {
    const double off = flange_difference(*k, described_);
    out += off > 0.02
               ? fmt::format("; its arm is not the described one: the flange differs by up to {:.0f} mm",
                             1000 * off)
               : fmt::format("; its flange differs from the description by at most {:.2f} mm", 1000 * off);
  }
  return out;
}

}  // namespace polyarm::ur
