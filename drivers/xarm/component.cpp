#include "drivers/xarm/component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::xarm {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// The controller follows its targets as they are; these shares of the description's limits are for braking,
// and for commands that jump.
constexpr wire::LimitShares kLimits{
    .acceleration = 2, .jerk = 8, .acceleration_else = 600, .jerk_else = 20000};  // degrees, seconds
constexpr double kSlowest = 0.05;                             // s, between two servo commands

using hardware::DriverParameter;
using enum hardware::ParameterKind;
constexpr DriverParameter kParameters[] = {
    {"host", text, nullptr, "address of the controller"},
    {"command_port", number, "502", "TCP port for commands", 1, 65535},
    {"report_port", number, "30003", "TCP port for reports at a high rate", 1, 65535},
    {"servo_ms", number, "4", "ms between two servo commands at least", 4, 50},
    {"clear_errors", boolean, "true", "activating clears an error whose cause is gone"},
    {"digital_in", text, "", "numbers of inputs of the control box that are read, such as 0-7; up to 15"},
    {"digital_out", text, "",
     "numbers of outputs of the control box that the driver writes while it is active; up to 15"},
    {"tool_io", boolean, "false", "two inputs and two outputs of the tool are read and written"},
    {"force_sensor", boolean, "false", "the reports have forces of the maker's sensor"},
    {"max_speed", number, "60", "degrees/s of each joint", 0.1, 360},
    {"max_behind", number, "0.05", "rad that the sent command may be behind the loop's", 0.0001, 0.2},
    {"max_step", number, "0.1",
     "rad, between two position commands; beyond it nothing is sent and the robot stops", 0.001, 0.6},
    {"silence_ms", number, "300", "ms without a report until the link ends", 50, 10000},
    {"loop_silence_ms", number, "100", "ms without a command of the loop until the link ends", 10, 10000},
    {"connect_timeout", number, "2", "s for each connection and answer", 0.05, 60},
    {"start_timeout", number, "10", "s for motors, mode and state", 0.05, 600},
    {"motion", text, "stream",
     "stream: this computer interpolates and streams positions; forward: the controller makes the moves; for "
     "arms with six joints",
     -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), "stream forward"},
    {"poll_ms", number, "20", "forward: ms between two readings", 4, 1000},
    {"answer_ms", number, "1000", "forward: ms without an answer until the link counts as lost", 50, 20000},
    {"watchdog_ms", number, "2000",
     "forward: ms for which the driving process may hang before a process of its own stops the robot; more "
     "than `answer_ms`; 0: none",
     0, 60000},
    {"line_acceleration", number, "2", "forward: m/s² of lines and arcs", 0.05, 50},
};
constexpr hardware::DriverFacts kFacts = {"system", "robots of UFACTORY: xArm 5, 6 and 7, Lite 6, 850",
                                          "a controller of our own, byte for byte, with faults on both "
                                          "wires, which the maker's client accepts; see "
                                          "docs/driver-xarm.md; never on hardware",
                                          kParameters};

constexpr const char* kPoseNames[] = {"position.x",    "position.y",    "position.z",   "orientation.x",
                                      "orientation.y", "orientation.z", "orientation.w"};
constexpr const char* kWrenchNames[] = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};
constexpr const char* kControllerStates[] = {"state",  "mode",   "ready",  "error",   "warning",
                                             "queued", "behind", "shaped", "replaced"};

/// Roll, pitch, yaw turn about the fixed axes x, y, z.
std::array<double, 7> pose_of(const Six& pose) noexcept {
  const Quaternion q = from_rpy(pose[3], pose[4], pose[5]);
  return {pose[0] * 1e-3, pose[1] * 1e-3, pose[2] * 1e-3, q.x, q.y, q.z, q.w};
}

double bit(std::uint32_t word, int number) noexcept {
  return word >> number & 1 ? 1.0 : 0.0;
}

}  // namespace

int cycles_of_command(Nanoseconds period, double least_ms) {
  const double cycle = seconds(period);
  if (cycle > kSlowest)
    throw Error("bad-value", "the loop is too slow for servo mode", "choose a rate of 100 to 250 Hz");
  return std::max(1, static_cast<int>(std::ceil(least_ms / 1000 / cycle - 1e-6)));
}

CallbackReturn XarmComponent::on_init(const hardware::ComponentContext& context) {
  period_ = context.period;
  paced_ = false;  // reports come at 100 Hz at most: too slow a clock for a loop
  hardware::DriverParameters p(kFacts, context);
  settings_.host = p.text("host");
  settings_.command_port = static_cast<int>(p.number("command_port"));
  settings_.report_port = static_cast<int>(p.number("report_port"));
  settings_.clear_errors = p.boolean("clear_errors");
  settings_.signals.tool = p.boolean("tool_io");
  force_sensor_ = p.boolean("force_sensor");
  settings_.stepped = stepped_link_;
  settings_.read(p);
  steps_ = wire::StepCheckOf<kWireJoints>(p.number("max_step"));
  const double servo_ms = p.number("servo_ms");
  constexpr const char* kTakes[] = {"position"};
  joints_ = wire::driven_joints(context, kTakes, "robots of UFACTORY", p.problems(), 5, kWireJoints);
  const bool forward = p.text("motion") == "forward";
  p.problems().throw_if_errors();
  settings_.axes = joints_.size();
  settings_.cycles = cycles_of_command(period_, servo_ms);
  settings_.period = seconds(period_) * settings_.cycles;
  if (stepped_link_) settings_.report_period = seconds(period_);
  robot_ = context.robots.front().name;
  settings_.limits =
      wire::stream_limits<7>(context.robots.front(), joints_, p.number("max_speed"), kLimits, wire::kDegrees);
  const auto signals = [&](const char* parameter) {
    return wire::signal_range(parameter, p.text(parameter), kMostSignals - 1, 0);
  };
  settings_.signals.inputs = signals("digital_in");
  settings_.signals.outputs = signals("digital_out");
  forward_.reset(), link_.reset();
  if (forward)
    make_forward(context, p);
  else
    link_ = std::make_unique<Link>(settings_);
  return CallbackReturn::success;
}

void XarmComponent::add_signals(std::vector<hardware::InterfaceDescription>& out, bool inputs) const {
  const auto add = [&](const char* name, int number) {
    out.push_back({robot_ + "/io/" + name + std::to_string(number)});
  };
  const UsedSignals& used = settings_.signals;
  for (int i = 0; inputs && i < used.inputs.count; ++i) add("digital_in_", used.inputs.first + i);
  for (int i = 0; i < used.outputs.count; ++i) add("digital_out_", used.outputs.first + i);
  if (!used.tool) return;
  if (inputs)
    for (int i = 0; i < kMostToolSignals; ++i) add("tool_in_", i);
  for (int i = 0; i < kMostToolSignals; ++i) add("tool_out_", i);
}

std::vector<hardware::InterfaceDescription> XarmComponent::state_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  const auto add = [&](const std::string& name) { out.push_back({robot_ + "/" + name}); };
  for (const std::string& joint : joints_)
    for (const char* one : {"/position", "/velocity", "/effort"}) add(joint + one);
  for (const char* one : kPoseNames) add(std::string("tcp_pose/") + one);
  for (const char* one : kControllerStates) add(std::string("controller/") + one);
  if (force_sensor_)
    for (const char* one : kWrenchNames) add(std::string("tcp_wrench/") + one);
  add_signals(out, true);
  return out;
}

std::vector<hardware::InterfaceDescription> XarmComponent::command_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  for (const std::string& joint : joints_) out.push_back({robot_ + "/" + joint + "/position"});
  add_signals(out, false);
  return out;
}

void XarmComponent::show_controller(const Report& report, const Panel& panel,
                                    const std::array<double, 3>& streaming, Mode mode,
                                    std::span<double> states) const noexcept {
  std::size_t at = 0;
  for (const double value : pose_of(report.pose)) states[at++] = value;
  const bool ready = report.mode == mode && report.state <= State::standing;
  for (const double value :
       {static_cast<double>(report.state), static_cast<double>(report.mode), ready ? 1.0 : 0.0,
        static_cast<double>(panel.error), static_cast<double>(panel.warning),
        static_cast<double>(report.queued), streaming[0], streaming[1], streaming[2]})
    states[at++] = value;
  if (force_sensor_)
    for (const double value : report.force) states[at++] = report.has_force ? value : kNaN;
  const UsedSignals& used = settings_.signals;
  for (int i = 0; i < used.inputs.count; ++i) states[at++] = bit(panel.inputs, used.inputs.first + i);
  for (int i = 0; i < used.outputs.count; ++i) states[at++] = bit(panel.outputs, used.outputs.first + i);
  for (const std::uint32_t word : {panel.tool_inputs, panel.tool_outputs})
    for (int i = 0; used.tool && i < kMostToolSignals; ++i) states[at++] = bit(word, i);
}

ReturnType XarmComponent::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (forward_) return read_forward(cycle, states);
  link_->fetch();
  const Sample& sample = link_->sample();
  std::size_t at = 0;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    states[at++] = sample.q[j];
    states[at++] = sample.dq[j];
    states[at++] = sample.report.torque[j];
  }
  show_controller(sample.report, link_->panel(),
                  {sample.behind, static_cast<double>(sample.shaped), static_cast<double>(sample.replaced)},
                  Mode::servo, states.subspan(at));
  return link_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

Outputs XarmComponent::outputs_of(std::span<const double> commands) const noexcept {
  Outputs out;
  const UsedSignals& used = settings_.signals;
  std::size_t at = joints_.size();
  for (int i = 0; i < used.outputs.count; ++i)
    out.digital[static_cast<std::size_t>(used.outputs.first + i)] = commands[at++];
  for (std::size_t i = 0; used.tool && i < kMostToolSignals; ++i)
    out.digital[kMostSignals + i] = commands[at++];
  return out;
}

ReturnType XarmComponent::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  if ((forward_ ? forward_->cause() : link_->cause()) != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  if (forward_) {
    forward_->cycle(outputs_of(commands));
    return judge_joints(commands);
  }
  link_->outputs(outputs_of(commands));
  return write_joints(commands, joints_.size());
}

const hardware::DriverFacts* XarmComponent::facts() const noexcept {
  return &kFacts;
}

std::string XarmComponent::summary() const {
  if (!link_ && !forward_) return {};
  const Version& version = forward_ ? forward_->version() : link_->version();
  const std::string device =
      fmt::format("UFACTORY controller at {}{}, {} axes", settings_.host,
                  version.text.empty() ? "" : ", firmware " + version.firmware(), settings_.axes);
  if (forward_) return device + ", its own motion";
  return fmt::format("{}, a servo command every {:g} ms", device, settings_.period * 1000);
}

}  // namespace polyarm::xarm
