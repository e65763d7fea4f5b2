#include "drivers/kuka/machine.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/forward/move_frame.hpp"
#include "drivers/wire/six_axes.hpp"

namespace polyarm::kuka {

namespace {

constexpr double kStopRamp = 0.1;   // s, of every stop
constexpr double kFollows = 0.6;    // of the way to the setpoint, in each cycle
constexpr double kStill = 1e-9;     // degrees
constexpr double kTooFast = 1.05;   // of an axis' velocity, until the controller stops it
constexpr double kTooFastMove = 1.1;  // the same, of a move: the corners of blends are ours

std::uint32_t mask(int number) {
  return 1u << (number - 1);
}
bool is_signal(int number) {
  return number >= 1 && number <= static_cast<int>(kMostSignals);
}

}  // namespace

MachineFacts facts_of(const description::RobotModel& model) {
  const wire::AxisFacts axes = wire::axis_facts(model, "kuka/kr_10_r1100_3", wire::kDegrees);
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

Machine::Machine(MachineOptions options) : options_(std::move(options)), q_(options_.start), setpoint_(q_) {
  options_.identity.robot = options_.facts.model;
  options_.identity.lower = options_.facts.lower;
  options_.identity.upper = options_.facts.upper;
}

/// Comes to rest on a straight ramp.
void Machine::stop_motion() {
  stop_moves();
  if (rsi_ == Rsi::running) {
    ramp_ = kStopRamp;
    rsi_ = Rsi::braking;
  } else if (rsi_ == Rsi::beginning) {
    rsi_ = Rsi::off;
  }
}

void Machine::stop_moves() {
  next_.reset();
  if (std::exchange(driving_, false)) ramp_ = kStopRamp;
}

bool Machine::still() const {
  for (std::size_t i = 0; i < 6; ++i)
    if (q_[i] != setpoint_[i] || velocity_[i] != 0) return false;
  return true;
}

void Machine::press_start() {
  if (program_ == ProgramState::stopped && ready() == EkiResult::done) program_ = ProgramState::active;
}

void Machine::emergency(bool on) {
  if (on && !emergency_) {
    stop_with_message();
    drives_ = false;
  }
  emergency_ = on;
}

void Machine::guard(bool open) {
  if (open && !guard_) {
    stop_with_message();
    drives_ = false;
  }
  guard_ = open;
}

void Machine::set_mode(Mode mode) {
  if (mode != mode_) {
    stop_program();
    drives_ = false;
  }
  mode_ = mode;
}

void Machine::switch_drives(bool on) {
  if (!on) stop_program();
  drives_ = on;
}

void Machine::stop_program() {
  if (program_ == ProgramState::active) program_ = ProgramState::stopped;
  stop_motion();
}

void Machine::cancel_program() {
  stop_motion();
  program_ = ProgramState::free;
}

void Machine::end_rsi() {
  stop_motion();
}

void Machine::stop_with_message() {
  message_ = true;
  stop_program();
}

void Machine::acknowledge() {
  if (!emergency_ && !guard_) message_ = false;
}

void Machine::push_by_hand(const Six& change) {
  for (std::size_t i = 0; i < 6; ++i) q_[i] = setpoint_[i] = q_[i] + change[i];
}

/// Of a program to be started.
EkiResult Machine::ready() const {
  if (refuse_start) return EkiResult::busy;
  if (mode_ == Mode::t1 || mode_ == Mode::t2) return EkiResult::mode;
  return emergency_ || guard_ || message_ || !drives_ ? EkiResult::not_ready : EkiResult::done;
}

EkiResult Machine::begin_moves() {
  if (rsi_ != Rsi::off) return EkiResult::busy;
  if (mode_ == Mode::automatic && program_ != ProgramState::active) return EkiResult::mode;
  const EkiResult out = ready();
  if (out == EkiResult::done) program_ = ProgramState::active;
  return out;
}

EkiResult Machine::start() {
  if (rsi_ != Rsi::off) return EkiResult::busy;
  if (refuse_start) return EkiResult::busy;
  if (mode_ == Mode::automatic && program_ != ProgramState::active) return EkiResult::mode;
  if (const EkiResult out = ready(); out != EkiResult::done) return out;
  program_ = ProgramState::active;
  rsi_return_ = rsi_error;
  if (rsi_error != 0) return EkiResult::done;  // the program shows it
  rsi_ = Rsi::beginning;
  since_begin_ = 0;
  return EkiResult::done;
}

EkiResult Machine::drives_on() {
  if (emergency_ || guard_ || mode_ != Mode::external || refuse_drives) return EkiResult::not_ready;
  drives_ = true;
  return EkiResult::done;
}

EkiResult Machine::set_override(int percent) {
  override_ = std::clamp(percent, 0, 100);
  return EkiResult::done;
}

EkiResult Machine::set_output(int number, bool on) {
  if (!is_signal(number) || locked_outputs) return EkiResult::not_ready;
  outputs_ = on ? outputs_ | mask(number) : outputs_ & ~mask(number);
  return EkiResult::done;
}

void Machine::set_input(int number, bool on) {
  if (is_signal(number)) inputs_ = on ? inputs_ | mask(number) : inputs_ & ~mask(number);
}

/// RSI takes the answer to its newest packet only; any other one is late.
void Machine::take(const RsiSensor& answer) {
  if (rsi_ != Rsi::running || answered_ || answer.ipoc != ipoc_) return;
  answered_ = true;
  late_ = 0;
  for (std::size_t i = 0; i < 6; ++i)
    correction_[i] =
        options_.identity.relative ? correction_[i] + answer.correction[i] : answer.correction[i];
  if (answer.stop && !no_stop) end_rsi();
}

/// A move goes on to its next setpoint; an axis that is too fast or beyond its limit stops it. False: there
/// is no move.
bool Machine::follow_move() {
  if (!next_) return false;
  for (std::size_t i = 0; i < 6; ++i) {
    const double step = (*next_)[i] - setpoint_[i];
    const bool fast = std::abs(step) > kTooFastMove * options_.facts.velocity[i] * period();
    const bool outside = (*next_)[i] < options_.facts.lower[i] || (*next_)[i] > options_.facts.upper[i];
    if (!fast && !outside) continue;
    stop_with_message();
    return false;
  }
  driving_ = true;
  return true;
}

/// What the controller ends RSI for.
void Machine::judge() {
  if (rsi_ != Rsi::running) return;
  late_ = answered_ ? 0 : late_ + 1;
  if (late_ >= options_.identity.late_limit) return stop_with_message();
  for (std::size_t i = 0; i < 6; ++i) {
    const double next = base_[i] + correction_[i];
    const bool far = std::abs(correction_[i]) > options_.identity.correction_limit - hidden_limit;
    const bool outside = next < options_.facts.lower[i] || next > options_.facts.upper[i];
    const bool fast = std::abs(next - setpoint_[i]) > kTooFast * options_.facts.velocity[i] * period();
    if (far || outside || fast) return stop_with_message();
  }
}

/// RSI applies a correction as it is, and a move its setpoint; a stop ends on a ramp.
void Machine::follow() {
  const double dt = period();
  const bool moves = follow_move();
  if (!moves && std::exchange(driving_, false)) velocity_ = {};  // the last move has ended at rest
  const double left = ramp_ > dt ? 1 - dt / ramp_ : 0;
  if (rsi_ != Rsi::running && !moves) ramp_ = std::max(0.0, ramp_ - dt);
  for (std::size_t i = 0; i < 6; ++i) {
    const double before = setpoint_[i];
    const double wanted = moves ? (*next_)[i] : base_[i] + correction_[i];
    if (rsi_ == Rsi::running || moves)
      velocity_[i] = (wanted - setpoint_[i]) / dt;
    else
      velocity_[i] *= left;
    setpoint_[i] = rsi_ == Rsi::running || moves ? wanted : setpoint_[i] + velocity_[i] * dt;
    jump_ = std::max(jump_, std::abs(setpoint_[i] - before));
    const double at = q_[i];
    q_[i] += kFollows * (setpoint_[i] - q_[i]);
    if (std::abs(setpoint_[i] - q_[i]) < kStill) q_[i] = setpoint_[i];
    fastest_ = std::max(fastest_, std::abs(q_[i] - at) / dt);
  }
  next_.reset();
  if (rsi_ == Rsi::braking && ramp_ <= 0) rsi_ = Rsi::off;
}

void Machine::step() {
  judge();
  follow();
  if (rsi_ == Rsi::beginning && (since_begin_ += period()) >= options_.begin) {
    rsi_ = Rsi::running;
    ++sessions_;
    base_ = setpoint_;
    correction_ = {};
    late_ = 0;
  }
  const auto cycle = static_cast<std::uint64_t>(options_.identity.cycle_ms);
  ipoc_ = std::exchange(renew_clock, false) ? 0 : ipoc_ + (slow ? 16 - cycle : cycle);
  ipoc_ += std::exchange(skip, 0);
  answered_ = false;
  for (const auto& [output, input] : wires_) set_input(input, outputs_ & mask(output));
}

RsiRobot Machine::packet() const {
  RsiRobot out;
  out.ipoc = ipoc_;
  out.axes = q_;
  out.setpoint = setpoint_;
  out.delay = late_;
  out.inputs = inputs_;
  out.pose = flange(q_);
  out.target = flange(setpoint_);
  return out;
}

/// X Y Z in mm, A B C in degrees.
std::optional<Six> Machine::flange(const Six& joints) const {
  if (!options_.facts.chain) return std::nullopt;
  Six q;
  for (std::size_t i = 0; i < 6; ++i) q[i] = joints[i] / wire::kDegrees;
  const Pose flange = options_.facts.chain->forward(q);
  const Vec3 angles = to_rpy(flange.rotation);
  return Six{1000 * flange.position.x,  1000 * flange.position.y,  1000 * flange.position.z,
             angles.z * wire::kDegrees, angles.y * wire::kDegrees, angles.x * wire::kDegrees};
}

EkiReply Machine::reply() const {
  EkiReply out;
  out.identity = options_.identity;
  EkiState& s = out.state;
  s.mode = mode_;
  s.emergency_stop = emergency_;
  s.guard_stop = guard_;
  s.drives = drives_;
  s.message = message_;
  s.program = program_;
  s.rsi = rsi_ != Rsi::off;
  s.rsi_return = rsi_return_;
  s.speed_override = override_;
  s.inputs = inputs_;
  s.outputs = outputs_;
  s.axes = q_;
  return out;
}

}  // namespace polyarm::kuka
