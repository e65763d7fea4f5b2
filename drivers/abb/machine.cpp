#include "drivers/abb/machine.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/forward/move_frame.hpp"
#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::abb {

namespace {

constexpr double kStopRamp = 0.1;                   // s, of the safety system's stops
constexpr double kOverspeed = 1.05;                 // of a joint's limit
constexpr double kConverged = 0.05, kStill = 1e-9;  // degrees; degrees/s

}  // namespace

MachineFacts facts_of(const description::RobotModel& model) {
  const wire::AxisFacts axes = wire::axis_facts(model, "abb/irb_120", wire::kDegrees);
  MachineFacts out;
  out.model = axes.model;
  out.lower = axes.lower;
  out.upper = axes.upper;
  out.velocity = axes.velocity;
  out.chain = std::make_shared<const kinematics::Chain>(model, axes.flange);
  out.tool_flange =
      std::make_shared<const kinematics::Chain>(model, forward::tool_flange(model, axes.flange));
  return out;
}

Machine::Machine(MachineOptions options) : options_(std::move(options)), q_(options_.start), reference_(q_) {
  event(10011, 1, "Motors ON state");
}

void Machine::event(int code, int kind, const std::string& title) {
  RwsEvent entry;
  entry.sequence = ++sequence_;
  entry.kind = kind;
  entry.code = code;
  entry.title = title;
  events_.push_front(std::move(entry));
  if (events_.size() > bounds::kEventLogEntries) events_.pop_back();
}

std::string Machine::control() const {
  if (failed_) return "sysfail";
  if (emergency_) return "emergencystop";
  if (guard_) return "guardstop";
  return motors_ ? "motoron" : "motoroff";
}

std::string Machine::mode_text() const {
  constexpr const char* kModes[] = {"AUTO", "MANR", "MANF"};
  return kModes[static_cast<std::size_t>(mode_)];
}

EgmState Machine::egm_state() const {
  return egm_ == Egm::running ? EgmState::running : EgmState::stopped;
}

/// Comes to rest on a straight ramp, whatever moved it.
void Machine::stop_motion(double ramp) {
  if (egm_ == Egm::running || moves_) ramp_ = std::max(ramp, 1e-3);
  next_.reset();
  egm_ = egm_ == Egm::running ? Egm::ending : Egm::none;
}

void Machine::stop_program(const std::string& why) {
  if (running_) event(10125, 1, "Program stopped" + (why.empty() ? "" : ": " + why));
  running_ = false;
  stop_motion(options_.rapid.ramp_out);
}

void Machine::emergency(bool on) {
  if (on && !emergency_) {
    event(10013, 2, "Emergency stop state");
    stop_program("emergency stop");
    ramp_ = kStopRamp;
    motors_ = false;
  }
  emergency_ = on;
}

void Machine::guard(bool open) {
  if (open && !guard_) {
    event(10012, 2, "Safety guard stop state");
    stop_program("guard");
    ramp_ = kStopRamp;
    motors_ = false;
  }
  guard_ = open;
}

void Machine::set_mode(Mode mode) {
  if (mode != mode_) {
    const bool manual = mode != Mode::automatic;
    event(manual ? 10015 : 10017, 1, manual ? "Manual mode selected" : "Automatic mode confirmed");
    stop_program("change of mode");
    motors_ = false;
  }
  mode_ = mode;
}

void Machine::fail() {
  event(10014, 3, "System failure state");
  stop_program("system failure");
  motors_ = false;
  failed_ = true;
}

void Machine::restart() {
  failed_ = collided_ = running_ = moves_ = false;
  next_.reset();
  egm_ = Egm::none;
  v_ = {};
}

void Machine::collide() {
  event(50204, 3, "Motion supervision");
  collided_ = egm_moves() || may_move();
  stop_program("motion supervision");
}

void Machine::stop_egm() {
  stop_motion(options_.rapid.ramp_out);
}

void Machine::stop_with(int code, const std::string& title) {
  event(code, 3, title);
  stop_program("an error");
}

void Machine::push_by_hand(const Six& change) {
  for (std::size_t i = 0; i < 6; ++i) q_[i] += change[i];
}

std::string Machine::switch_motors(bool on) {
  if (!on) {
    stop_program("motors off");
    if (motors_) event(10010, 1, "Motors OFF state");
    motors_ = false;
    return {};
  }
  if (failed_ || emergency_ || guard_ || mode_ != Mode::automatic)
    return "Operation not allowed in this state";
  if (!motors_) event(10011, 1, "Motors ON state");
  motors_ = true;
  return {};
}

std::string Machine::reset_pointer() {
  if (running_) return "Operation not allowed while the program runs";
  event(10002, 1, "Program pointer has been reset");
  pointer_at_main_ = true;
  return {};
}

std::string Machine::start_program(bool once) {
  if (running_) return "The program runs already";
  if (!motors_ || mode_ != Mode::automatic) return "Motors are not on in automatic mode";
  if (!options_.modules.contains(kModuleName) && !options_.modules.contains(kMovesModule))
    return "Unknown procedure main";
  once_ = once;
  return begin_at_main() ? "" : "The program pointer is not set";
}

void Machine::end_cycle() {
  if (!once_ || !running_) return;
  stop_program("the cycle ended");
  pointer_at_main_ = true;
}

bool Machine::begin_at_main() {
  if (!std::exchange(pointer_at_main_, false)) return false;
  event(10151, 1, "Program started");
  running_ = true;
  ++starts_;
  collided_ = referenced_ = converged_ = false;
  moves_ = options_.modules.contains(kMovesModule);
  egm_ = moves_ ? Egm::none : Egm::beginning;
  since_begin_ = since_message_ = since_run_ = 0;
  return true;
}

void Machine::press_start() {
  if (running_ || !motors_ || mode_ != Mode::automatic || begin_at_main()) return;
  running_ = moves_;
  if (running_) event(10151, 1, "Program started");
}

void Machine::brake_moves() {
  next_.reset();
  ramp_ = std::max(options_.rapid.ramp_out, 1e-3);
}

bool Machine::still() const {
  return std::all_of(v_.begin(), v_.end(), [](double v) { return v == 0; });
}

std::string Machine::set_signal(const std::string& name, bool on) {
  const auto found = options_.signals.find(name);
  if (found == options_.signals.end()) return "Unknown signal";
  if (locked_signals) return "The access level does not allow it";
  found->second = on;
  return {};
}

/// The controller takes every number; one that is not finite ends it, as a user of ABB's driver reported.
void Machine::take(const EgmSensor& message) {
  if (egm_ != Egm::beginning && egm_ != Egm::running) return;
  if (!message.planned || !message.planned->joints || message.planned->joints->count < 6) return;
  since_message_ = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    const double next = (*message.planned->joints)[i];
    jump_ = std::max(jump_, std::abs(next - (referenced_ ? reference_[i] : q_[i])));
    reference_[i] = next;
    speed_[i] = message.joint_speed && message.joint_speed->count >= 6 ? (*message.joint_speed)[i] : 0;
  }
  referenced_ = true;
}

/// The position loop with its feed-forward, the low-pass filter, the ramp at the beginning, the limit of the
/// speed.
void Machine::follow(double dt) {
  const RapidSettings& rapid = options_.rapid;
  since_run_ += dt;
  const double ramp = rapid.ramp_in > 0 ? std::min(1.0, since_run_ / rapid.ramp_in) : 1;
  const double share = rapid.filter > 0 ? 1 - std::exp(-2 * std::numbers::pi * rapid.filter * dt) : 1;
  converged_ = true;
  for (std::size_t i = 0; i < 6; ++i) {
    const double error = referenced_ ? reference_[i] - q_[i] : 0;
    const double most = std::min(rapid.max_speed, options_.facts.velocity[i]);
    const double wanted =
        std::clamp(ramp * (options_.gain * error + (referenced_ ? speed_[i] : 0)), -most, most);
    v_[i] += (wanted - v_[i]) * share;
    converged_ = converged_ && std::abs(error) < kConverged;
  }
}

void Machine::move(double dt) {
  if (egm_ == Egm::running) {
    follow(dt);
  } else if (next_) {
    for (std::size_t i = 0; i < 6; ++i) v_[i] = ((*next_)[i] - q_[i]) / dt;
    ramp_ = 0;  // what is left of an earlier stop
  } else {
    for (double& v : v_) v = ramp_ > dt ? v * (1 - dt / ramp_) : 0;
    ramp_ = std::max(0.0, ramp_ - dt);
    if (egm_ == Egm::ending && ramp_ <= 0) egm_ = Egm::none;
  }
  for (std::size_t i = 0; i < 6; ++i) {
    if (std::abs(v_[i]) < kStill) v_[i] = 0;
    q_[i] += v_[i] * dt;
    fastest_ = std::max(fastest_, std::abs(v_[i]));
    if (moves_) jump_ = std::max(jump_, std::abs(v_[i] * dt));
  }
  judge_speed();
}

/// Of moves; EGM has a limit of its own.
void Machine::judge_speed() {
  if (!std::exchange(next_, std::nullopt)) return;
  for (std::size_t i = 0; i < 6; ++i)
    if (std::abs(v_[i]) > kOverspeed * options_.facts.velocity[i])
      return stop_with(50052, "Joint speed error: rob1_" + std::to_string(i + 1));
}

void Machine::judge_range() {
  for (std::size_t i = 0; i < 6; ++i) {
    const double inside = std::clamp(q_[i], options_.facts.lower[i], options_.facts.upper[i]);
    if (inside == q_[i]) continue;
    q_[i] = inside;
    v_[i] = 0;
    if (egm_moves() || may_move()) stop_with(50027, "Joint Out of Range: rob1_" + std::to_string(i + 1));
  }
}

void Machine::step(double dt) {
  time_ += dt;
  if (egm_ == Egm::beginning && (since_begin_ += dt) >= options_.begin) egm_ = Egm::running;
  if (egm_ == Egm::beginning || egm_ == Egm::running) {
    since_message_ += dt;
    if (since_message_ > options_.rapid.comm_timeout) stop_with(41822, "No data from the UdpUc device");
  }
  move(dt);
  judge_range();
  for (const auto& [output, input] : wires_) options_.signals[input] = options_.signals[output];
}

double Machine::utilization() const {
  double out = 0;
  for (std::size_t i = 0; i < 6; ++i)
    out = std::max(out, 100 * std::abs(v_[i]) / std::max(1.0, options_.facts.velocity[i]));
  return out;
}

Pose Machine::pose_of(const kinematics::Chain* chain) const {
  if (!chain) return {};
  Six q;
  for (std::size_t i = 0; i < 6; ++i) q[i] = q_[i] / wire::kDegrees;
  return chain->forward(q);
}

Pose Machine::flange() const {
  return pose_of(options_.facts.chain.get());
}

Pose Machine::tool0() const {
  return pose_of(options_.facts.tool_flange.get());
}

}  // namespace polyarm::abb
