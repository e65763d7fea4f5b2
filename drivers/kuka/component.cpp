#include "drivers/kuka/component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/wire/six_axes.hpp"
#include "drivers/wire/xml.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::kuka {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// RSI applies each correction as it is; these shares of the description's limits are for braking, and for
// commands that jump.
constexpr wire::LimitShares kLimits{
    .acceleration = 2, .jerk = 8, .acceleration_else = 400, .jerk_else = 20000};  // degrees, seconds
constexpr double kShownSpeed = 1;                             // rad/s, of a jog at the smartPAD

using hardware::DriverParameter;
using enum hardware::ParameterKind;
constexpr DriverParameter kParameters[] = {
    {"host", text, nullptr, "address of the controller in its network for EthernetKRL (KLI)"},
    {"eki", boolean, "true",
     "our program PolyarmEki answers there; false: without EthernetKRL, a person starts the program of RSI"},
    {"eki_port", number, "54600", "TCP port of PolyarmEki", 1, 65535},
    {"rsi_host", text, "", "address of the controller in its network for RSI; empty: `host`"},
    {"rsi_port", number, "59152", "UDP port of this computer that the file PolyarmRsi.xml names", 0, 65535},
    {"rsi_address", text, "", "address of this computer for RSI; else the one that reaches the controller"},
    {"sen_type", text, "Polyarm", "SENTYPE of the configuration of RSI; another one in your own context"},
    {"cycle_ms", number, "4", "ms, the cycle of RSI: 4 or 12; only without EthernetKRL, else it is read", 4,
     12},
    {"relative", boolean, "false",
     "RSI takes relative corrections; only without EthernetKRL, else it is read"},
    {"max_correction", number, "360",
     "degrees of each axis away from where RSI began, as in its context; only without EthernetKRL, else it "
     "is read",
     0.1, 720},
    {"pace", boolean, "true",
     "the control loop follows the controller's clock; one robot of a cell can do that"},
    {"drives_on", boolean, "true", "activating switches the drives on when they are off"},
    {"digital_in", text, "", "numbers of inputs that are read, such as 1-8; up to 32"},
    {"digital_out", text, "", "numbers of outputs that the driver writes while it is active; up to 32"},
    {"max_speed", number, "60", "degrees/s of each joint", 0.1, 1000},
    {"max_behind", number, "0.05", "rad that the sent command may be behind the loop's", 0.0001, 0.2},
    {"max_step", number, "0.1",
     "rad, between two position commands; beyond it nothing is sent and the robot stops", 0.001, 0.6},
    {"silence_ms", number, "100", "ms without a packet of RSI until the controller is asked why", 20, 10000},
    {"loop_silence_ms", number, "100", "ms without a command of the loop until the robot is braked", 10,
     10000},
    {"connect_timeout", number, "2", "s for each connection and answer of EthernetKRL", 0.05, 60},
    {"start_timeout", number, "10", "s for RSI to begin; without EthernetKRL for the person too", 0.05, 600},
    {"motion", text, "stream",
     "stream: this computer interpolates and streams corrections of RSI; forward: the controller makes the "
     "moves, over EthernetKRL alone",
     -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), "stream forward"},
    {"poll_ms", number, "20", "forward: ms between two readings of the joints", 4, 1000},
    {"answer_ms", number, "1000", "forward: ms without an answer until the link counts as lost", 50, 20000},
    {"watchdog_ms", number, "500",
     "forward: ms without a request until the program on the controller stops the robot", 100, 10000},
    {"line_acceleration", number, "2.3", "forward: m/s² of lines and arcs", 0.05, 20},
};
constexpr hardware::DriverFacts kFacts = {
    "system", "robots of KUKA with six axes: KR C4 and KR C5 with the Robot Sensor Interface or EthernetKRL",
    "a controller of our own, byte for byte, with faults on both wires; see docs/driver-kuka.md; never on "
    "hardware",
    kParameters};

constexpr const char* kPoseNames[] = {"position.x",    "position.y",    "position.z",   "orientation.x",
                                      "orientation.y", "orientation.z", "orientation.w"};
constexpr const char* kControllerStates[] = {"drives_on",    "automatic",      "running", "rsi",
                                             "guard_stop",   "emergency_stop", "message", "speed_override",
                                             "late_answers", "lost_packets",   "behind",  "shaped"};

/// KUKA's A, B, C turn about Z, then the new Y, then the new X.
std::array<double, 7> pose_of(const Sample& sample) noexcept {
  std::array<double, 7> out;
  out.fill(kNaN);
  if (!sample.with_pose) return out;
  const auto& p = sample.pose;
  const Quaternion q = from_rpy(p[5] * wire::kRadians, p[4] * wire::kRadians, p[3] * wire::kRadians);
  return {p[0] / 1000, p[1] / 1000, p[2] / 1000, q.x, q.y, q.z, q.w};
}

double bit(std::uint32_t word, int number) noexcept {
  return word >> (number - 1) & 1 ? 1.0 : 0.0;
}

}  // namespace

CallbackReturn KukaComponent::on_init(const hardware::ComponentContext& context) {
  name_ = context.name;
  period_ = context.period;
  hardware::DriverParameters p(kFacts, context);
  settings_.host = p.text("host");
  settings_.eki = p.boolean("eki");
  settings_.eki_port = static_cast<int>(p.number("eki_port"));
  settings_.rsi_host = p.text("rsi_host");
  settings_.rsi_address = p.text("rsi_address");
  settings_.rsi_port = static_cast<int>(p.number("rsi_port"));
  settings_.sen_type = p.text("sen_type");
  settings_.cycle_ms = static_cast<int>(p.number("cycle_ms"));
  settings_.relative = p.boolean("relative");
  settings_.correction_limit = p.number("max_correction");
  paced_ = p.boolean("pace");
  settings_.follows = paced_ || follows_;
  settings_.stepped = stepped_link_;
  settings_.drives_on = p.boolean("drives_on");
  settings_.read(p);
  steps_ = wire::StepCheck(p.number("max_step"));
  constexpr const char* kTakes[] = {"position"};
  joints_ = wire::driven_joints(context, kTakes, "robots of KUKA", p.problems());
  const bool forward = p.text("motion") == "forward";
  p.problems().throw_if_errors();
  if (settings_.cycle_ms != 4 && settings_.cycle_ms != 12)
    throw Error("bad-value", "RSI has a cycle of 4 or of 12 ms", "write `cycle_ms: 4` or `cycle_ms: 12`");
  if (settings_.sen_type.empty() || settings_.sen_type.size() > 32 ||
      wire::xml_text(settings_.sen_type) != settings_.sen_type)
    throw Error("bad-value", "`sen_type` is no name", "at most 32 letters, as SENTYPE in the file of RSI");
  robot_ = context.robots.front().name;
  settings_.limits =
      wire::stream_limits<6>(context.robots.front(), joints_, p.number("max_speed"), kLimits, wire::kDegrees);
  const auto signals = [&](const char* parameter) {
    return wire::signal_range(parameter, p.text(parameter), static_cast<int>(kMostSignals));
  };
  inputs_ = signals("digital_in");
  settings_.outputs = signals("digital_out");
  if (settings_.outputs.count > 0 && !settings_.eki)
    throw Error("bad-value", "`digital_out` needs EthernetKRL", "remove it, or `eki: false`");
  outputs_ = Outputs();
  forward_.reset(), link_.reset();
  if (forward)
    make_forward(context, p);
  else
    link_ = std::make_unique<Link>(settings_);
  return CallbackReturn::success;
}

std::vector<hardware::InterfaceDescription> KukaComponent::state_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  const auto add = [&](const std::string& name) { out.push_back({robot_ + "/" + name}); };
  for (const std::string& joint : joints_)
    for (const char* one : {"/position", "/velocity"}) add(joint + one);
  for (const char* one : kPoseNames) add(std::string("flange_pose/") + one);
  for (const char* one : kControllerStates) add(std::string("controller/") + one);
  for (int i = 0; i < inputs_.count; ++i) add("io/digital_in_" + std::to_string(inputs_.first + i));
  for (int i = 0; i < settings_.outputs.count; ++i)
    add("io/digital_out_" + std::to_string(settings_.outputs.first + i));
  return out;
}

std::vector<hardware::InterfaceDescription> KukaComponent::command_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  for (const std::string& joint : joints_) out.push_back({robot_ + "/" + joint + "/position"});
  if (!forward_) out.push_back({robot_ + "/controller/speed_override"});
  for (int i = 0; i < settings_.outputs.count; ++i)
    out.push_back({robot_ + "/io/digital_out_" + std::to_string(settings_.outputs.first + i)});
  return out;
}

CallbackReturn KukaComponent::on_configure() {
  guided_ = placed_ = false;
  return ForwardComponent::on_configure();
}

CallbackReturn KukaComponent::on_activate() {
  const CallbackReturn done = ForwardComponent::on_activate();
  if (done == CallbackReturn::success && !forward_) guided_ = true;
  return done;
}

CallbackReturn KukaComponent::on_deactivate() {
  const CallbackReturn done = ForwardComponent::on_deactivate();
  guided_ = false;
  return done;
}

/// EthernetKRL reports the joints a few times a second. Between two reports a person at the smartPAD can jog
/// the robot far. Such a step is shown as a motion.
const wire::Six& KukaComponent::shown_position(bool guided, double dt) noexcept {
  const double most = kShownSpeed * dt;
  for (std::size_t j = 0; j < 6; ++j) {
    const double at = guided ? link_->sample().q[j] : link_->panel().state.axes[j] * wire::kRadians;
    shown_[j] = guided || !placed_ ? at : shown_[j] + std::clamp(at - shown_[j], -most, most);
  }
  placed_ = true;
  return shown_;
}

void KukaComponent::add_signals(const EkiState& state, std::uint32_t inputs,
                                std::span<double> states) const noexcept {
  std::size_t at = 0;
  for (int i = 0; i < inputs_.count; ++i) states[at++] = bit(inputs, inputs_.first + i);
  for (int i = 0; i < settings_.outputs.count; ++i)
    states[at++] = bit(state.outputs, settings_.outputs.first + i);
}

ReturnType KukaComponent::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (forward_) return read_forward(cycle, states);
  link_->fetch();
  const Sample& sample = link_->sample();
  const EkiState& panel = link_->panel().state;
  const bool seen = link_->panel().count > 0;
  const bool guided = (guided_ || !settings_.eki) && sample.count > 0;
  const wire::Six& shown = shown_position(guided, seconds(cycle.period));
  const bool known = settings_.eki || guided;  // else nothing reports the position
  std::size_t at = 0;
  for (std::size_t j = 0; j < 6; ++j) {
    states[at++] = known ? shown[j] : kNaN;
    states[at++] = guided ? sample.dq[j] : 0;
  }
  for (const double value : pose_of(sample)) states[at++] = value;
  const bool automatic = panel.mode == OperatingMode::automatic || panel.mode == OperatingMode::external;
  const auto shows = [seen](bool on) { return !seen ? kNaN : on ? 1.0 : 0.0; };
  for (const double value :
       {shows(panel.drives), shows(automatic), shows(panel.program == ProgramState::active),
        guided ? 1.0 : 0.0, shows(panel.guard_stop), shows(panel.emergency_stop), shows(panel.message),
        seen ? panel.speed_override / 100.0 : kNaN, static_cast<double>(sample.delay),
        static_cast<double>(sample.lost), sample.behind, static_cast<double>(sample.shaped)})
    states[at++] = value;
  add_signals(panel, guided ? sample.inputs : panel.inputs, states.subspan(at));
  return link_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

ReturnType KukaComponent::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  if (forward_) return write_forward(commands);
  if (link_->cause() != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  outputs_.speed_override = commands[6];
  std::copy_n(commands.begin() + 7, settings_.outputs.count, outputs_.digital.begin());
  link_->outputs(outputs_);
  return write_joints(commands);
}

const hardware::DriverFacts* KukaComponent::facts() const noexcept {
  return &kFacts;
}

std::string KukaComponent::summary() const {
  if (forward_) return forward_summary();
  if (!link_) return {};
  if (!settings_.eki)
    return fmt::format("KUKA controller at {}, RSI at {:g} Hz, without EthernetKRL", settings_.host,
                       link_->rate());
  const EkiIdentity& identity = link_->identity();
  return fmt::format(
      "KUKA controller at {}, {}, RSI {} at {:g} Hz with {} corrections, which ends after {} late answers",
      settings_.host, identity.robot, identity.rsi, link_->rate(),
      identity.relative ? "relative" : "absolute", identity.late_limit);
}

}  // namespace polyarm::kuka
