#include "drivers/fanuc/component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::fanuc {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {

using hardware::DriverParameter;
using enum hardware::ParameterKind;
constexpr DriverParameter kParameters[] = {
    {"host", text, nullptr, "address of the controller, as its network settings show it"},
    {"stream_port", number, "60015", "of Stream Motion, UDP", 1, 65535},
    {"rmi_port", number, "16001", "of the Remote Motion Interface, TCP", 1, 65535},
    {"motion", text, "stream",
     "stream: this computer interpolates and streams joint positions; forward: the controller interpolates, "
     "over the Remote Motion Interface alone",
     -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), "stream forward"},
    {"pace", boolean, "true",
     "the control loop follows the controller's clock; one robot of a cell can do that"},
    {"digital_in", text, "1-16", "range of digital inputs that are read, at most 64; empty: none"},
    {"digital_out", text, "",
     "range of digital outputs that the driver writes while it is active, at most 64; empty: none"},
    {"load", number, "1", "share of the full load, from 0 to 1, for the controller's limit tables", 0, 1},
    {"max_behind", number, "0.05",
     "rad that the sent command may be behind the loop's when the limit tables hold it back", 0.0001, 0.2},
    {"max_step", number, "0.1",
     "rad, between two position commands; beyond it nothing is sent and the robot stops", 0.001, 0.6},
    {"silence_ms", number, "200", "ms without a packet of the controller until the link counts as lost", 20,
     10000},
    {"loop_silence_ms", number, "100", "ms without a command of the loop until the robot is braked", 10,
     10000},
    {"settle", number, "2", "s that the controller must stay ready before the robot counts as active", 0, 20},
    {"poll_ms", number, "20", "forward: ms between two readings of the joints", 4, 1000},
    {"answer_ms", number, "1000", "forward: ms without an answer until the link counts as lost", 50, 20000},
    {"window", number, "8", "forward: most instructions that the controller has at a time", 2, 8},
    {"ramp", number, "0.2", "forward: s in which the robot speeds up, for CNT", 0.02, 2},
    {"tool_number", number, "9", "forward: the controller's tool frame that the driver writes", 1, 29},
    {"connect_timeout", number, "2", "s for each connection and answer", 0.05, 60},
    {"start_timeout", number, "5", "s for the streaming program to become ready", 0.05, 60},
};
constexpr hardware::DriverFacts kFacts = {
    "system", "robots of FANUC with six axes: R-30iB Plus and newer, options J519 and R912 (S636)",
    "a controller of our own, byte for byte, with faults on both wires; see docs/driver-fanuc.md; never on "
    "hardware",
    kParameters};

constexpr const char* kPoseNames[] = {"position.x",    "position.y",    "position.z",   "orientation.x",
                                      "orientation.y", "orientation.z", "orientation.w"};
constexpr const char* kForceNames[] = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};
constexpr const char* kControllerStates[] = {
    "ready",        "moving",       "error",        "teach_pendant", "emergency_stop",
    "contact_stop", "safety_scale", "lost_packets", "behind",        "shaped"};

std::array<double, 7> pose_of(const Status& status) noexcept {
  const auto& p = status.pose;
  const Quaternion q = from_rpy(p[3] / wire::kDegrees, p[4] / wire::kDegrees, p[5] / wire::kDegrees);
  return {p[0] / 1000, p[1] / 1000, p[2] / 1000, q.x, q.y, q.z, q.w};
}

}  // namespace

IoRange io_range(const std::string& parameter, const std::string& text) {
  const std::string trimmed(trim(text));
  if (trimmed.empty()) return {1, 0};
  const std::size_t dash = trimmed.find('-', 1);
  const auto first = parse_number(trimmed.substr(0, dash));
  const auto last = dash == std::string::npos ? first : parse_number(trimmed.substr(dash + 1));
  const auto whole = [](std::optional<double> n) {
    return n && *n >= 1 && *n <= 32767 && *n == std::floor(*n);
  };
  if (!whole(first) || !whole(last) || *last < *first || *last - *first >= kMostDigital)
    throw Error("bad-value", "'" + text + "' in `" + parameter + "` is no range of inputs or outputs",
                "at most 64 numbers from 1, for example 1-16");
  return {static_cast<int>(*first), static_cast<int>(*last - *first) + 1};
}

void FanucComponent::find_limits(const description::RobotModel& model) {
  for (std::size_t i = 0; i < 6; ++i)
    for (const description::Joint& joint : model.joints)
      if (joint.name == joints_[i]) {
        described_[0][i] = joint.limits.velocity.value_or(0) * wire::kDegrees;
        described_[1][i] = joint.limits.acceleration.value_or(0) * wire::kDegrees;
        described_[2][i] = joint.limits.jerk.value_or(0) * wire::kDegrees;
      }
}

CallbackReturn FanucComponent::on_init(const hardware::ComponentContext& context) {
  name_ = context.name;
  period_ = context.period;
  hardware::DriverParameters p(kFacts, context);
  settings_.host = p.text("host");
  settings_.stream_port = static_cast<int>(p.number("stream_port"));
  settings_.rmi_port = static_cast<int>(p.number("rmi_port"));
  paced_ = p.boolean("pace");
  settings_.follows = paced_ || follows_;
  settings_.load = p.number("load");
  settings_.most_behind = p.number("max_behind");
  steps_ = wire::StepCheck(p.number("max_step"));
  settings_.silence = nanoseconds(p.number("silence_ms") / 1000);
  settings_.loop_silence = nanoseconds(p.number("loop_silence_ms") / 1000);
  settings_.settle = nanoseconds(p.number("settle"));
  settings_.connect_timeout = nanoseconds(p.number("connect_timeout"));
  settings_.start_timeout = nanoseconds(p.number("start_timeout"));
  constexpr const char* kTakes[] = {"position"};
  joints_ = wire::driven_joints(context, kTakes, "robots of FANUC", p.problems());
  p.problems().throw_if_errors();
  robot_ = context.robots.front().name;
  if (context.robots.front().model) find_limits(*context.robots.front().model);
  settings_.inputs = io_range("digital_in", p.text("digital_in"));
  settings_.outputs = io_range("digital_out", p.text("digital_out"));
  outputs_ = Outputs();
  forward_.reset(), link_.reset();
  if (p.text("motion") == "forward")
    make_forward(context, p);
  else
    link_ = std::make_unique<Link>(settings_);
  return CallbackReturn::success;
}

std::vector<hardware::InterfaceDescription> FanucComponent::state_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  const auto add = [&](const std::string& name) { out.push_back({robot_ + "/" + name}); };
  for (const std::string& joint : joints_)
    for (const char* one : {"/position", "/velocity", "/current"}) add(joint + one);
  for (const char* one : kPoseNames) add(std::string("flange_pose/") + one);
  for (const char* one : kForceNames) add(std::string("force/") + one);
  for (const char* one : kControllerStates) add(std::string("controller/") + one);
  for (int i = 0; i < settings_.inputs.count; ++i)
    add("io/digital_in_" + std::to_string(settings_.inputs.first + i));
  for (int i = 0; i < settings_.outputs.count; ++i)
    add("io/digital_out_" + std::to_string(settings_.outputs.first + i));
  return out;
}

std::vector<hardware::InterfaceDescription> FanucComponent::command_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  for (const std::string& joint : joints_) out.push_back({robot_ + "/" + joint + "/position"});
  for (int i = 0; i < settings_.outputs.count; ++i)
    out.push_back({robot_ + "/io/digital_out_" + std::to_string(settings_.outputs.first + i)});
  return out;
}

ReturnType FanucComponent::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (forward_) return read_forward(cycle, states);
  link_->fetch();
  const Sample& sample = link_->sample();
  const Status& status = sample.status;
  std::size_t at = 0;
  for (std::size_t j = 0; j < 6; ++j)
    for (const double value : {sample.q[j], sample.dq[j], static_cast<double>(status.current[j])})
      states[at++] = value;
  for (const double value : pose_of(status)) states[at++] = value;
  for (const float value : status.force)
    states[at++] = status.with_force ? value : std::numeric_limits<double>::quiet_NaN();
  const auto bit = [](std::uint8_t word, std::uint8_t one) { return word & one ? 1.0 : 0.0; };
  for (const double value :
       {bit(status.status, ready_bit), bit(status.status, moving_bit), bit(status.robot, error_bit),
        bit(status.robot, teach_bit), bit(status.robot, emergency_bit),
        static_cast<double>(status.contact_stop), static_cast<double>(status.safety_scale),
        static_cast<double>(sample.lost), sample.behind, static_cast<double>(sample.shaped)})
    states[at++] = value;
  const auto inputs = static_cast<std::size_t>(settings_.inputs.count);
  const std::size_t behind = 4 * ((inputs + 31) / 32);
  for (std::size_t i = 0; i < inputs; ++i) states[at++] = digital(status.io, 0, i);
  for (std::size_t i = 0; i < static_cast<std::size_t>(settings_.outputs.count); ++i)
    states[at++] = digital(status.io, behind, i);
  return link_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

ReturnType FanucComponent::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  if (forward_) return write_forward(commands);
  if (link_->cause() != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  if (settings_.outputs.count > 0) {
    std::copy_n(commands.begin() + 6, settings_.outputs.count, outputs_.digital.begin());
    link_->outputs(outputs_);
  }
  return write_joints(commands);
}

const hardware::DriverFacts* FanucComponent::facts() const noexcept {
  return &kFacts;
}

std::string FanucComponent::summary() const {
  if (forward_)
    return fmt::format("FANUC controller at {}, its own motion over Remote Motion {}", settings_.host,
                       forward_->rmi_version());
  if (!link_) return {};
  std::string out = fmt::format("FANUC controller at {}, Stream Motion {} at {:g} Hz, Remote Motion {}",
                                settings_.host, link_->version(), link_->rate(), link_->rmi_version());
  if (!link_->limits().complete()) return out;
  constexpr const char* kKinds[] = {"velocity", "acceleration", "jerk"};
  const AxisLimits limits = link_->limits().at(0, settings_.load);
  for (std::size_t kind = 0; kind < 3; ++kind)
    for (std::size_t i = 0; i < 6; ++i) {
      const double own = limits.of[kind][i];
      if (described_[kind][i] > own * 1.001)
        return out + fmt::format(
                         "; its {} limit of {} is {:.4g}, the description's {:.4g} (degrees, seconds): "
                         "lower the description's",
                         kKinds[kind], joints_[i], own, described_[kind][i]);
    }
  return out + "; its limits allow those of the description";
}

}  // namespace polyarm::fanuc
