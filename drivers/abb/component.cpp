#include "drivers/abb/component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/secrets.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::abb {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// The controller judges no acceleration or jerk of EGM; these shares of the description's limits are for
// braking, and for commands that jump.
constexpr wire::LimitShares kLimits{
    .acceleration = 2, .jerk = 8, .acceleration_else = 400, .jerk_else = 20000};  // degrees, seconds
constexpr double kShownSpeed = 1;  // rad/s, of a jog at the FlexPendant

using hardware::DriverParameter;
using enum hardware::ParameterKind;
constexpr DriverParameter kParameters[] = {
    {"host", text, nullptr, "address of the controller, as its network settings show it"},
    {"rws", number, "2", "version of Robot Web Services: 1 (IRC5, RobotWare 6) or 2 (OmniCore, RobotWare 7)",
     1, 2},
    {"rws_port", number, "0", "of Robot Web Services; 0: 80 (version 1) or 443 (version 2)", 0, 65535},
    {"user", text, "Default User", "of Robot Web Services"},
    {"password_file", text, "",
     "file with the password, or secret:NAME; empty: the maker's default password"},
    {"fingerprint", text, "",
     "SHA-256 of the controller's certificate, as the first line of a run shows it; empty: any"},
    {"egm_port", number, "6510", "UDP port of this computer that the controller's UDPUC device names", 0,
     65535},
    {"egm_address", text, "", "address of this computer for EGM; else the one that reaches the controller"},
    {"sampling_ms", number, "4", "ms, the sample rate of the RAPID module; a multiple of 4", 4, 48},
    {"task", text, "T_ROB1", "RAPID task with the module PolyarmEGM"},
    {"pace", boolean, "true",
     "the control loop follows the controller's clock; one robot of a cell can do that"},
    {"motors_on", boolean, "true", "activating switches the motors on when they are off in automatic mode"},
    {"digital_in", text, "", "names of signals that are read, at most 32"},
    {"digital_out", text, "", "names of signals that the driver writes while it is active, at most 32"},
    {"speed_reference", boolean, "true", "commands carry the velocity too: less delay"},
    {"max_speed", number, "60", "degrees/s of each joint, not above MaxSpeedDeviation of the RAPID module",
     0.1, 1000},
    {"max_behind", number, "0.05", "rad that the sent command may be behind the loop's", 0.0001, 0.2},
    {"max_step", number, "0.1",
     "rad, between two position commands; beyond it nothing is sent and the robot stops", 0.001, 0.6},
    {"silence_ms", number, "200", "ms without a packet of the controller until the link counts as lost", 20,
     10000},
    {"loop_silence_ms", number, "100", "ms without a command of the loop until the robot is braked", 10,
     10000},
    {"connect_timeout", number, "2", "s for each connection and answer", 0.05, 60},
    {"start_timeout", number, "10", "s for EGM to begin", 0.05, 60},
    {"motion", text, "stream",
     "stream: this computer interpolates and streams joint positions over EGM; forward: the controller makes "
     "the moves, with the RAPID module PolyarmMoves",
     -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), "stream forward"},
    {"moves_port", number, "54700", "forward: TCP port of PolyarmMoves", 1, 65535},
    {"poll_ms", number, "20", "forward: ms between two readings of the joints", 4, 1000},
    {"answer_ms", number, "1000", "forward: ms without an answer until the link counts as lost", 50, 20000},
    {"watchdog_ms", number, "500",
     "forward: ms without a request until the program on the controller stops the robot", 100, 10000},
    {"line_acceleration", number, "2", "forward: m/s² of lines and arcs", 0.1, 20},
    {"tool_mass", number, "0.5", "forward: kg, of the tool and what it carries", 0.001, 1000},
    {"tool_centre", text, "0 0 0.05", "forward: m, the centre of that mass in tool0: x y z"},
};
constexpr hardware::DriverFacts kFacts = {
    "system", "robots of ABB with six axes: IRC5 and OmniCore with Externally Guided Motion",
    "a controller of our own, byte for byte, with faults on both wires; see docs/driver-abb.md; never on "
    "hardware",
    kParameters};

constexpr const char* kPoseNames[] = {"position.x",    "position.y",    "position.z",   "orientation.x",
                                      "orientation.y", "orientation.z", "orientation.w"};
constexpr const char* kForceNames[] = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};
constexpr const char* kControllerStates[] = {
    "motors_on", "automatic",   "running",     "egm",          "guard_stop", "emergency_stop", "collision",
    "converged", "speed_ratio", "utilization", "lost_packets", "behind",     "shaped"};

std::array<double, 7> pose_of(const Sample& sample) noexcept {
  std::array<double, 7> out;
  out.fill(kNaN);
  if (!sample.with_pose) return out;
  const auto& [p, o] = sample.pose;
  return {p[0] / 1000, p[1] / 1000, p[2] / 1000, o[1], o[2], o[3], o[0]};
}

std::vector<std::string> signals_of(const std::string& parameter, const std::string& text) {
  std::vector<std::string> out = split_words(text, " ,;");
  for (const std::string& name : out)
    if (name.size() > 128 || out.size() > kMostSignals || std::count(out.begin(), out.end(), name) > 1)
      throw Error("bad-value", "`" + parameter + "` is no list of signals", "at most 32 different names");
  return out;
}

/// "a/b/doValve" → "doValve"
std::string short_name(const std::string& signal) {
  return signal.substr(signal.rfind('/') + 1);
}

/// Inputs and outputs have one list of interfaces.
void check_names(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
  std::set<std::string> seen;
  for (const auto* list : {&inputs, &outputs})
    for (const std::string& signal : *list)
      if (!seen.insert(short_name(signal)).second)
        throw Error("bad-value", "two signals would have the interface 'io/" + short_name(signal) + "'",
                    "name each signal once: a signal of `digital_out` can be read too");
}

std::string password_of(const std::string& file) {
  if (file.empty()) return "robotics";  // the maker's default, which its manuals print
  const bool secret = file.starts_with(kSecretPrefix);
  const auto path = secret ? secret_file(file.substr(kSecretPrefix.size())) : std::filesystem::path(file);
  mark_secret(path);
  return std::string(trim(read_file(path)));
}

}  // namespace

CallbackReturn AbbComponent::on_init(const hardware::ComponentContext& context) {
  name_ = context.name;
  period_ = context.period;
  hardware::DriverParameters p(kFacts, context);
  wire::HttpSettings& http = settings_.rws.http;
  settings_.rws.version = static_cast<int>(p.number("rws"));
  http.host = p.text("host");
  http.tls = settings_.rws.version == 2;
  http.port = static_cast<int>(p.number("rws_port"));
  if (http.port == 0) http.port = http.tls ? 443 : 80;
  http.user = p.text("user");
  http.fingerprint = p.text("fingerprint");
  http.timeout = nanoseconds(p.number("connect_timeout"));
  settings_.egm_port = static_cast<int>(p.number("egm_port"));
  settings_.egm_address = p.text("egm_address");
  settings_.sampling_ms = static_cast<int>(p.number("sampling_ms"));
  settings_.task = p.text("task");
  paced_ = p.boolean("pace");
  settings_.follows = paced_ || follows_;
  settings_.stepped = stepped_services_;
  if (stepped_services_) settings_.rws.interval = 0;
  settings_.motors_on = p.boolean("motors_on");
  settings_.speed_reference = p.boolean("speed_reference");
  settings_.read(p);
  steps_ = wire::StepCheck(p.number("max_step"));
  constexpr const char* kTakes[] = {"position"};
  joints_ = wire::driven_joints(context, kTakes, "robots of ABB", p.problems());
  const bool forward = p.text("motion") == "forward";
  p.problems().throw_if_errors();
  robot_ = context.robots.front().name;
  settings_.limits =
      wire::stream_limits<6>(context.robots.front(), joints_, p.number("max_speed"), kLimits, wire::kDegrees);
  http.password = password_of(p.text("password_file"));
  settings_.inputs = signals_of("digital_in", p.text("digital_in"));
  settings_.outputs = signals_of("digital_out", p.text("digital_out"));
  check_names(settings_.inputs, settings_.outputs);
  outputs_ = Outputs();
  forward_.reset(), link_.reset();
  if (forward)
    make_forward(context, p);
  else
    link_ = std::make_unique<Link>(settings_);
  return CallbackReturn::success;
}

std::vector<hardware::InterfaceDescription> AbbComponent::state_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  const auto add = [&](const std::string& name) { out.push_back({robot_ + "/" + name}); };
  for (const std::string& joint : joints_)
    for (const char* one : {"/position", "/velocity"}) add(joint + one);
  for (const char* one : kPoseNames) add(std::string("flange_pose/") + one);
  for (const char* one : kForceNames) add(std::string("force/") + one);
  for (const char* one : kControllerStates) add(std::string("controller/") + one);
  for (const std::string& name : settings_.inputs) add("io/" + short_name(name));
  for (const std::string& name : settings_.outputs) add("io/" + short_name(name));
  return out;
}

std::vector<hardware::InterfaceDescription> AbbComponent::command_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  for (const std::string& joint : joints_) out.push_back({robot_ + "/" + joint + "/position"});
  out.push_back({robot_ + "/controller/speed_ratio"});
  for (const std::string& name : settings_.outputs) out.push_back({robot_ + "/io/" + short_name(name)});
  return out;
}

CallbackReturn AbbComponent::on_configure() {
  guided_ = placed_ = false;
  return ForwardComponent::on_configure();
}

CallbackReturn AbbComponent::on_activate() {
  const CallbackReturn done = ForwardComponent::on_activate();
  if (done == CallbackReturn::success) guided_ = true;
  return done;
}

CallbackReturn AbbComponent::on_deactivate() {
  const CallbackReturn done = ForwardComponent::on_deactivate();
  guided_ = false;
  return done;
}

/// Robot Web Services report the joints a few times a second. Between two reports a person at the FlexPendant can
/// jog the robot far. Such a step is shown as a motion.
const wire::Six& AbbComponent::shown_position(const wire::Six& at, bool guided, double dt) noexcept {
  const double most = kShownSpeed * dt;
  for (std::size_t j = 0; j < 6; ++j)
    shown_[j] = guided || !placed_ ? at[j] : shown_[j] + std::clamp(at[j] - shown_[j], -most, most);
  placed_ = true;
  return shown_;
}

ReturnType AbbComponent::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  if (forward_) return read_forward(cycle, states);
  link_->fetch();
  const Sample& sample = link_->sample();
  const Panel& panel = link_->panel();
  const bool guided = guided_ && sample.count > 0;
  const wire::Six& shown = shown_position(guided ? sample.q : panel.joints, guided, seconds(cycle.period));
  std::size_t at = 0;
  for (std::size_t j = 0; j < 6; ++j) {
    states[at++] = shown[j];
    states[at++] = guided ? sample.dq[j] : 0;
  }
  for (const double value : pose_of(sample)) states[at++] = value;
  for (const double value : sample.force) states[at++] = sample.with_force ? value : kNaN;
  const bool motors = guided ? sample.motors == MotorState::on : panel.control == Panel::Control::motors_on;
  const bool running = guided ? sample.rapid == RapidState::running : panel.running;
  for (const double value :
       {motors ? 1.0 : 0.0, panel.automatic ? 1.0 : 0.0, running ? 1.0 : 0.0,
        guided && sample.state == EgmState::running ? 1.0 : 0.0,
        panel.control == Panel::Control::guard_stop ? 1.0 : 0.0,
        panel.control == Panel::Control::emergency_stop ? 1.0 : 0.0, sample.collision ? 1.0 : 0.0,
        sample.converged ? 1.0 : 0.0, panel.speed_ratio, sample.utilization, static_cast<double>(sample.lost),
        sample.behind, static_cast<double>(sample.shaped)})
    states[at++] = value;
  show_signals(panel, states.subspan(at));
  return link_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

void AbbComponent::show_signals(const Panel& panel, std::span<double> states) const noexcept {
  std::size_t at = 0;
  for (std::size_t i = 0; i < settings_.inputs.size(); ++i) states[at++] = panel.inputs[i];
  for (std::size_t i = 0; i < settings_.outputs.size(); ++i) states[at++] = panel.outputs[i];
}

void AbbComponent::take_outputs(std::span<const double> commands) noexcept {
  outputs_.speed_ratio = commands[6];
  std::copy_n(commands.begin() + 7, settings_.outputs.size(), outputs_.digital.begin());
}

ReturnType AbbComponent::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  if (forward_) return write_forward(commands);
  if (link_->cause() != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  take_outputs(commands);
  link_->outputs(outputs_);
  return write_joints(commands);
}

const hardware::DriverFacts* AbbComponent::facts() const noexcept {
  return &kFacts;
}

std::string AbbComponent::summary() const {
  const RwsLink* link = forward_ ? static_cast<const RwsLink*>(forward_.get()) : link_.get();
  if (!link) return {};
  std::string out = fmt::format("ABB controller at {}, RobotWare {}, Robot Web Services {}, ",
                                settings_.rws.http.host, link->identity().software, settings_.rws.version);
  out += forward_ ? "its own motion by the RAPID program PolyarmMoves"
                  : fmt::format("EGM at {:g} Hz", link_->rate());
  if (settings_.rws.version == 2 && settings_.rws.http.fingerprint.empty())
    out += "; any certificate is accepted: write `fingerprint: " + link->fingerprint() +
           "` to accept only this one";
  return out;
}

}  // namespace polyarm::abb
