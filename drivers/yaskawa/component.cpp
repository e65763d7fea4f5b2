#include "drivers/yaskawa/component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::yaskawa {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// The controller follows its points as they are; these shares of the description's limits are for braking,
// and for commands that jump.
constexpr double kAcceleration = 2, kJerk = 8;
constexpr double kAccelerationElse = 400, kJerkElse = 20000;  // degrees, seconds; without limits there
constexpr double kServoLag = 10;  // ms, of the robot behind its controller, until an output is switched
constexpr int kMostCycles = 200;  // of the loop, for one point

using hardware::DriverParameter;
using enum hardware::ParameterKind;
constexpr DriverParameter kParameters[] = {
    {"host", text, nullptr, "address of the controller"},
    {"motion_port", number, "50240", "TCP port of MotoROS for motion", 1, 65535},
    {"state_port", number, "50241", "TCP port of MotoROS for states", 1, 65535},
    {"io_port", number, "50242", "TCP port of MotoROS for signals", 1, 65535},
    {"hses", boolean, "true",
     "the High-Speed Ethernet Server is asked for modes, alarms, pose and torques; false: without it"},
    {"hses_port", number, "10040", "UDP port of the Ethernet server", 1, 65535},
    {"group", number, "0", "control group of the robot, from 0", 0, 3},
    {"point_ms", number, "20", "ms between two points at least; a whole number of cycles", 4, 200},
    {"lead_ms", number, "120", "ms of motion in the controller's buffer; the robot is so much behind", 40,
     700},
    {"interpolation_ms", number, "4", "ms of a step in the controller's buffer", 1, 20},
    {"servo_on", boolean, "true", "activating switches the servos on when they are off"},
    {"digital_in", text, "", "numbers of general inputs that are read, such as 1-8; up to 32"},
    {"digital_out", text, "",
     "numbers of general outputs that the driver writes while it is active; up to 32"},
    {"max_speed", number, "60", "degrees/s of each joint", 0.1, 1000},
    {"max_behind", number, "0.05", "rad that the sent command may be behind the loop's", 0.0001, 0.2},
    {"max_step", number, "0.1",
     "rad, between two position commands; beyond it nothing is sent and the robot stops", 0.001, 0.6},
    {"silence_ms", number, "500", "ms without a state of MotoROS until the link ends", 100, 10000},
    {"loop_silence_ms", number, "100", "ms without a command of the loop until the robot is braked", 10,
     10000},
    {"connect_timeout", number, "2", "s for each connection and answer", 0.05, 60},
    {"start_timeout", number, "10", "s for servos and the job INIT_ROS or POLYARM", 0.05, 600},
    {"motion", text, "stream",
     "stream: this computer interpolates and sends points to MotoROS; forward: the controller makes the "
     "moves, over the Ethernet server alone",
     -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), "stream forward"},
    {"pulses", text, "",
     "forward: pulses for a degree of each axis, six numbers; below 0: the axis turns the other way"},
    {"base_height", number, "0",
     "forward: m, of the controller's base coordinates above the base of the model; 0: the height of the "
     "second axis",
     0, 10},
    {"tool_number", number, "0", "forward: the tool file at the pendant that has the TCP of the cell", 0, 63},
    {"heartbeat_byte", number, "2701",
     "forward: the network inputs that the ladder watches; 2701: 27010 and 27011", 2501, 2956},
    {"watchdog_ms", number, "600", "forward: ms of the timer in that ladder", 100, 10000},
    {"poll_ms", number, "20", "forward: ms between two readings at least", 4, 1000},
    {"answer_ms", number, "900", "forward: ms without an answer until the link counts as lost", 50, 60000},
    {"line_acceleration", number, "2.5", "forward: m/s² of lines and arcs, for the plan", 0.05, 20},
};
constexpr hardware::DriverFacts kFacts = {
    "system",
    "robots of Yaskawa with six axes: YRC1000, YRC1000micro, DX200, DX100, FS100 with MotoROS or the "
    "Ethernet "
    "server",
    "a controller of our own, byte for byte, with faults on both wires; see docs/driver-yaskawa.md; never on "
    "hardware",
    kParameters};

constexpr const char* kPoseNames[] = {"position.x",    "position.y",    "position.z",   "orientation.x",
                                      "orientation.y", "orientation.z", "orientation.w"};
constexpr const char* kControllerStates[] = {"servo_on", "play",  "remote", "running",        "ready",
                                             "hold",     "alarm", "error",  "emergency_stop", "alarm_code",
                                             "buffered", "busy",  "behind", "shaped"};

std::array<double, 7> shown_pose(const Panel& panel) noexcept {
  std::array<double, 7> out;
  out.fill(kNaN);
  if (!panel.seen) return out;
  const auto [p, q] = pose_of(panel.pose);
  return {p.x, p.y, p.z, q.x, q.y, q.z, q.w};
}

double bit(std::uint32_t word, int number) noexcept {
  return word >> (number - 1) & 1 ? 1.0 : 0.0;
}

}  // namespace

int cycles_of_point(Nanoseconds period, double least_ms) {
  const double cycle = seconds(period) * 1000;
  for (int n = std::max(1, static_cast<int>(std::ceil(least_ms / cycle - 1e-6))); n <= kMostCycles; ++n) {
    const double ms = n * cycle;
    if (std::abs(ms - std::round(ms)) < 1e-3 && ms <= 400) return n;
  }
  throw Error("bad-value", "no number of cycles of the loop lasts whole milliseconds",
              "choose a rate such as 250, 125 or 100");
}

void YaskawaComponent::find_limits(const hardware::RobotInstance& robot, double max_speed) {
  auto& [velocity, acceleration, jerk] = settings_.limits.of;
  velocity.fill(max_speed);
  acceleration.fill(kAccelerationElse);
  jerk.fill(kJerkElse);
  if (!robot.model) return;
  for (std::size_t i = 0; i < joints_.size(); ++i)
    for (const description::Joint& joint : robot.model->joints)
      if (joint.name == joints_[i]) {
        if (const auto a = joint.limits.acceleration) acceleration[i] = kAcceleration * *a * wire::kDegrees;
        if (const auto j = joint.limits.jerk) jerk[i] = kJerk * *j * wire::kDegrees;
      }
}

CallbackReturn YaskawaComponent::on_init(const hardware::ComponentContext& context) {
  period_ = context.period;
  paced_ = false;  // states come at about 40 Hz: no clock for a loop
  hardware::DriverParameters p(kFacts, context);
  settings_.host = p.text("host");
  settings_.hses_port = static_cast<int>(p.number("hses_port"));
  settings_.hses = p.boolean("hses");
  settings_.stepped = stepped_link_;
  settings_.servo_on = p.boolean("servo_on");
  settings_.loop_silence = nanoseconds(p.number("loop_silence_ms") / 1000);
  settings_.timeout = nanoseconds(p.number("connect_timeout"));
  settings_.start_timeout = nanoseconds(p.number("start_timeout"));
  constexpr const char* kTakes[] = {"position"};
  joints_ = wire::driven_joints(context, kTakes, "robots of Yaskawa", p.problems());
  const bool forward = p.text("motion") == "forward";
  p.problems().throw_if_errors();
  robot_ = context.robots.front().name;
  const auto signals = [&](const char* parameter) {
    return wire::signal_range(parameter, p.text(parameter), kMostSignals);
  };
  settings_.inputs = signals("digital_in");
  settings_.outputs = signals("digital_out");
  forward_.reset(), link_.reset();
  if (forward)
    make_forward(context, p);
  else
    make_stream(context, p);
  return CallbackReturn::success;
}

void YaskawaComponent::make_stream(const hardware::ComponentContext& context, hardware::DriverParameters& p) {
  const auto whole = [&](const char* parameter) { return static_cast<int>(p.number(parameter)); };
  settings_.motion_port = whole("motion_port");
  settings_.state_port = whole("state_port");
  settings_.io_port = whole("io_port");
  settings_.group = whole("group");
  settings_.lead_ms = whole("lead_ms");
  settings_.interpolation_ms = whole("interpolation_ms");
  settings_.most_behind = p.number("max_behind");
  settings_.silence = nanoseconds(p.number("silence_ms") / 1000);
  steps_ = wire::StepCheck(p.number("max_step"));
  const double point_ms = p.number("point_ms"), max_speed = p.number("max_speed");
  p.problems().throw_if_errors();
  settings_.cycles = cycles_of_point(period_, point_ms);
  settings_.point_ms = static_cast<int>(std::lround(settings_.cycles * seconds(period_) * 1000));
  if (settings_.lead_ms < 2 * settings_.point_ms)
    throw Error("bad-value", "`lead_ms` is shorter than two points",
                fmt::format("write `lead_ms: {}`, or a shorter `point_ms`", 2 * settings_.point_ms));
  find_limits(context.robots.front(), max_speed);
  const double behind_ms = settings_.lead_ms + kServoLag;
  const auto cycles =
      static_cast<std::size_t>(std::lround(behind_ms * settings_.cycles / settings_.point_ms));
  outputs_.assign(cycles + 1, Outputs());
  link_ = std::make_unique<Link>(settings_);
}

CallbackReturn YaskawaComponent::on_activate() {
  outputs_.assign(outputs_.size(), Outputs());
  return ForwardComponent::on_activate();
}

/// Outputs that waited for the robot are switched when it stands.
CallbackReturn YaskawaComponent::on_deactivate() {
  if (forward_) return ForwardComponent::on_deactivate();
  const bool well = active_ && link_->cause() == Cause::none;
  const CallbackReturn done = StreamComponent::on_deactivate();
  if (!well || link_->cause() != Cause::none) return done;
  Outputs last;
  for (std::size_t k = 1; k <= outputs_.size(); ++k) {
    const Outputs& next = outputs_[(newest_ + k) % outputs_.size()];  // the oldest first
    for (std::size_t i = 0; i < last.digital.size(); ++i)
      if (std::isfinite(next.digital[i])) last.digital[i] = next.digital[i];
  }
  link_->outputs(last);
  link_->serve_services();
  return done;
}

std::vector<hardware::InterfaceDescription> YaskawaComponent::state_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  const auto add = [&](const std::string& name) { out.push_back({robot_ + "/" + name}); };
  for (const std::string& joint : joints_)
    for (const char* one : {"/position", "/velocity", "/torque_share"}) add(joint + one);
  for (const char* one : kPoseNames) add(std::string("flange_pose/") + one);
  for (const char* one : kControllerStates) add(std::string("controller/") + one);
  for (int i = 0; i < settings_.inputs.count; ++i)
    add("io/digital_in_" + std::to_string(settings_.inputs.first + i));
  for (int i = 0; i < settings_.outputs.count; ++i)
    add("io/digital_out_" + std::to_string(settings_.outputs.first + i));
  return out;
}

std::vector<hardware::InterfaceDescription> YaskawaComponent::command_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  for (const std::string& joint : joints_) out.push_back({robot_ + "/" + joint + "/position"});
  for (int i = 0; i < settings_.outputs.count; ++i)
    out.push_back({robot_ + "/io/digital_out_" + std::to_string(settings_.outputs.first + i)});
  return out;
}

void YaskawaComponent::add_signals(std::uint32_t inputs, std::uint32_t outputs,
                                   std::span<double> states) const noexcept {
  std::size_t at = 0;
  for (int i = 0; i < settings_.inputs.count; ++i) states[at++] = bit(inputs, settings_.inputs.first + i);
  for (int i = 0; i < settings_.outputs.count; ++i) states[at++] = bit(outputs, settings_.outputs.first + i);
}

ReturnType YaskawaComponent::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (forward_) return read_forward(cycle, states);
  link_->fetch();
  const Sample& sample = link_->sample();
  const MotoStatus& moto = sample.status;
  const Panel& panel = link_->panel();
  std::size_t at = 0;
  for (std::size_t j = 0; j < 6; ++j) {
    states[at++] = sample.q[j];
    states[at++] = sample.dq[j];
    states[at++] = panel.seen ? panel.torque[j] * 1e-4 : kNaN;  // of 0.01 %
  }
  for (const double value : shown_pose(panel)) states[at++] = value;
  const auto flag = [](std::int32_t value) { return value < 0 ? kNaN : value == 1 ? 1.0 : 0.0; };
  const auto shows = [&](bool on) { return !panel.seen ? kNaN : on ? 1.0 : 0.0; };
  for (const double value :
       {flag(moto.drives), moto.mode == 2 ? 1.0 : 0.0, shows(panel.status.remote),
        shows(panel.status.running), flag(moto.motion_possible), shows(panel.status.holds()),
        flag(moto.in_error), shows(panel.status.error), flag(moto.e_stopped),
        static_cast<double>(moto.alarm_code), sample.buffered_ms / 1000.0, static_cast<double>(sample.busy),
        sample.behind, static_cast<double>(sample.shaped)})
    states[at++] = value;
  add_signals(panel.inputs, panel.outputs, states.subspan(at));
  return link_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

ReturnType YaskawaComponent::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  if (forward_) return write_forward(commands);
  if (link_->cause() != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  newest_ = (newest_ + 1) % outputs_.size();
  std::copy_n(commands.begin() + 6, settings_.outputs.count, outputs_[newest_].digital.begin());
  link_->outputs(outputs_[(newest_ + 1) % outputs_.size()]);
  return write_joints(commands);
}

const hardware::DriverFacts* YaskawaComponent::facts() const noexcept {
  return &kFacts;
}

std::string YaskawaComponent::summary() const {
  if (forward_)
    return fmt::format(
        "Yaskawa controller at {}{}{}, its own motion over the Ethernet server, a stop at each move",
        settings_.host, forward_->system().empty() ? "" : ", ", forward_->system());
  if (!link_) return {};
  return fmt::format("Yaskawa controller at {}{}{}, MotoROS group {}, a point every {} ms, {} ms ahead",
                     settings_.host, link_->system().empty() ? "" : ", ", link_->system(), settings_.group,
                     settings_.point_ms, settings_.lead_ms);
}

}  // namespace polyarm::yaskawa
