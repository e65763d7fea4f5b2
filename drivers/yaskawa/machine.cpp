#include "drivers/yaskawa/machine.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/forward/move_frame.hpp"
#include "drivers/wire/six_axes.hpp"
#include "drivers/yaskawa/inform.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::yaskawa {

namespace {

constexpr double kEndless = 36000;            // degrees, of a joint without limits
constexpr double kFollows = 0.6;              // of the way to the command, in each cycle
constexpr double kThere = 0.5;                // pulses
constexpr std::size_t kQueue = 200;           // steps, as in MotoROS
constexpr std::int64_t kStartDeviation = 30;  // pulses, as in MotoROS
constexpr float kMostTime = 14400;            // s, the same
constexpr const char* kJob = "INIT_ROS";
constexpr std::size_t kHistory = 100;

std::uint32_t mask(int number) {
  return 1u << (number - 1);
}
bool is_signal(int number) {
  return number >= 1 && number <= kMostSignals;
}

}  // namespace

MachineFacts facts_of(const description::RobotModel& model) {
  const wire::AxisFacts axes = wire::axis_facts(model, "yaskawa/gp7", wire::kDegrees);
  MachineFacts out;
  out.model = axes.model;
  out.lower = axes.lower;
  out.upper = axes.upper;
  out.velocity = axes.velocity;
  out.chain = std::make_shared<const kinematics::Chain>(model, forward::tool_flange(model, axes.flange));
  return out;
}

Machine::Machine(MachineOptions options) : options_(std::move(options)) {
  command_ = planned_ = pulses_of(options_.start);
  for (std::size_t i = 0; i < 6; ++i) feedback_[i] = static_cast<double>(command_[i]);
  options_.application = options_.facts.model;
}

Pulses Machine::pulses_of(const Six& degrees) const {
  Pulses out;
  for (std::size_t i = 0; i < 6; ++i)
    out[i] = static_cast<std::int64_t>(std::llround(degrees[i] * options_.facts.pulses[i]));
  return out;
}

Six Machine::q() const {
  Six out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = std::round(feedback_[i]) / options_.facts.pulses[i];
  return out;
}

// --- people -----------------------------------------------------------------------------------------------

/// The job ends or stands, and MotoROS clears its buffer.
void Machine::stop_all() {
  running_ = waiting_ = false;
  data_ = segment_ = false;
  queue_.clear();
}

void Machine::emergency(bool on) {
  emergency_ = on;
  if (!on) return;
  servo_on_ = false;
  stop_all();
}

void Machine::turn_key(KeySwitch key) {
  if (key != key_) stop_all();
  if (key == KeySwitch::teach && key != key_) servo_on_ = false;
  key_ = key;
}

void Machine::switch_servo(bool on) {
  servo_on_ = on;
  if (!on) stop_all();
}

void Machine::hold(int which, bool on) {
  holds_.at(static_cast<std::size_t>(which - 1)) = on;
  if (on && !(deaf_hold && which == 3)) stop_all();
}

void Machine::stop_job() {
  stop_all();
}

void Machine::raise_alarm(std::uint32_t code, const std::string& name) {
  alarm_ = {code, 1, 0, "2026/11/28 12:00", name};
  history_.insert(history_.begin(), alarm_);
  history_.resize(std::min(history_.size(), kHistory));
  servo_on_ = false;
  stop_all();
}

void Machine::raise_error() {
  error_ = true;
  stop_all();
}

bool Machine::reset() {
  if (emergency_) return false;
  alarm_ = {};
  error_ = false;
  return true;
}

void Machine::touch(bool on) {
  pfl_ = on;
  if (!on) return;
  data_ = segment_ = false;
  queue_.clear();
}

void Machine::push_by_hand(const Six& change) {
  const Pulses by = pulses_of(change);
  for (std::size_t i = 0; i < 6; ++i) {
    command_[i] += by[i];
    feedback_[i] = static_cast<double>(command_[i]);
  }
}

// --- MotoROS ----------------------------------------------------------------------------------------------

bool Machine::ready() const {
  return waiting_ && operating() && key_ == KeySwitch::remote && !pfl_ && !step_error_;
}

int Machine::not_ready() const {
  const auto why = [&] {
    if (alarm_.code != 0) return NotReady::alarm;
    if (error_) return NotReady::error;
    if (emergency_) return NotReady::e_stop;
    if (key_ == KeySwitch::teach) return NotReady::not_play;
    if (key_ != KeySwitch::remote) return NotReady::not_remote;
    if (!servo_on_) return NotReady::servo_off;
    if (holds()) return NotReady::hold;
    if (pfl_) return NotReady::pfl_active;
    if (step_error_) return NotReady::increment_error;
    if (!operating()) return NotReady::not_started;
    if (!waiting_) return NotReady::waiting_ros;
    return NotReady::unspecified;
  };
  return static_cast<int>(why());
}

/// As MotoROS does it: it cancels errors, resets alarms and switches the servos on by itself.
bool Machine::start_trajectory() {
  step_error_ = false;
  if (ready()) return true;
  if (operating() || emergency_ || holds() || key_ != KeySwitch::remote || pfl_) return false;
  reset();
  if (!servo_on_ && !servo(true)) return false;
  job_ = kJob;
  running_ = true;
  waiting_ = false;
  since_start_ = 0;
  planned_ = command_;
  return true;
}

bool Machine::stop_trajectory() {
  if (!queue_.empty()) return false;
  stop_motion();
  running_ = waiting_ = false;
  return true;
}

bool Machine::stop_motion() {
  data_ = segment_ = false;
  queue_.clear();
  return true;
}

bool Machine::servo(bool on) {
  if (on && (refuse_servo || emergency_ || key_ == KeySwitch::teach || alarm_.code != 0)) return false;
  if (on != servo_on_) switch_servo(on);
  return true;
}

Machine::Answer Machine::begin(const Motion& first) {
  planned_ = command_;
  const Pulses wanted = pulses_of(first.position);
  for (std::size_t i = 0; i < 6; ++i)
    if (std::abs(wanted[i] - command_[i]) > kStartDeviation)
      return {MotoResult::invalid, static_cast<int>(Invalid::start_position)};
  now_ = first;
  leftover_ = 0;
  queue_time_ = first.time;
  return {MotoResult::success, 0};
}

Machine::Answer Machine::take(const MotoPoint& point) {
  const auto invalid = [](Invalid why) { return Answer{MotoResult::invalid, static_cast<int>(why)}; };
  if (!ready()) return {MotoResult::not_ready, not_ready()};
  if (point.group != options_.group) return invalid(Invalid::group);
  if ((point.valid & 7) != 7) return invalid(Invalid::insufficient);
  if (!(point.time >= 0 && point.time < kMostTime)) return invalid(Invalid::time);
  if (point.sequence < 0) return invalid(Invalid::sequence);
  Motion next;
  next.time = static_cast<int>(point.time * 1000);
  for (std::size_t i = 0; i < 6; ++i) {
    next.position[i] = point.position[i] * wire::kDegrees;
    next.velocity[i] = point.velocity[i] * wire::kDegrees;
    if (!(std::abs(next.position[i]) < 2 * kEndless)) return invalid(Invalid::position);
    if (refuse_speed || std::abs(next.velocity[i]) > options_.facts.velocity[i])
      return invalid(Invalid::speed);
  }
  if (point.sequence == 0) return begin(next);
  if (data_ || busy > 0) {
    busy = std::max(0, busy - 1);
    return {MotoResult::busy, 0};
  }
  to_ = next;
  data_ = true;
  segment_ = false;
  ++points_;
  return {MotoResult::success, 0};
}

/// Cuts the way to the new point into steps of one interpolation cycle, as long as they have room. A point
/// that is not at a whole cycle leaves the rest of that cycle to the next one.
void Machine::interpolate() {
  if (!data_) return;
  if (!segment_) {
    from_ = now_;
    calculated_ = from_.time;
    segment_ = true;
  }
  const double whole = (to_.time - from_.time) / 1000.0;
  while (now_.time < to_.time) {
    if (queue_.size() >= kQueue) return;
    const int advance = leftover_ != 0 ? leftover_ : options_.interpolation_ms;
    calculated_ += advance;
    leftover_ = 0;
    if (calculated_ < to_.time) {
      const double t = (calculated_ - from_.time) / 1000.0;
      now_.time = calculated_;
      for (std::size_t i = 0; i < 6; ++i) {
        const double way = to_.position[i] - from_.position[i];
        const double a = 6 * way / (whole * whole) - 2 * (to_.velocity[i] + 2 * from_.velocity[i]) / whole;
        const double j =
            -12 * way / (whole * whole * whole) + 6 * (to_.velocity[i] + from_.velocity[i]) / (whole * whole);
        now_.position[i] = from_.position[i] + from_.velocity[i] * t + a * t * t / 2 + j * t * t * t / 6;
        now_.velocity[i] = from_.velocity[i] + a * t + j * t * t / 2;
      }
    } else {
      leftover_ = calculated_ - to_.time;
      now_ = to_;
    }
    const Pulses next = pulses_of(now_.position);
    Step step{now_.time, {}};
    for (std::size_t i = 0; i < 6; ++i) step.way[i] = next[i] - planned_[i];
    planned_ = next;
    queue_.push_back(step);
  }
  data_ = segment_ = false;
}

/// One cycle of motion: steps of the same cycle go together.
void Machine::move() {
  Pulses way{};
  if (ready() && !queue_.empty()) {
    int time = 0;
    bool first = true;
    while (!queue_.empty() && (first || (queue_.front().time >= queue_time_ &&
                                         queue_.front().time - queue_time_ <= options_.interpolation_ms))) {
      for (std::size_t i = 0; i < 6; ++i) way[i] += queue_.front().way[i];
      time = queue_.front().time;
      first = false;
      queue_.pop_front();
    }
    queue_time_ = time;
    if (std::exchange(refuse_step, false)) {
      step_error_ = true;
      stop_motion();
      way = {};
    }
  }
  if (driven_)
    for (std::size_t i = 0; i < 6; ++i) way[i] += (*driven_)[i] - command_[i];
  driven_.reset();
  if (other_moves) way[0] += 40;
  for (std::size_t i = 0; i < 6; ++i) {
    command_[i] += way[i];
    jump_ = std::max(jump_, std::abs(static_cast<double>(way[i])) / options_.facts.pulses[i]);
  }
}

void Machine::follow() {
  for (std::size_t i = 0; i < 6; ++i) {
    const double before = feedback_[i];
    const auto goal = static_cast<double>(command_[i]);
    feedback_[i] += kFollows * (goal - feedback_[i]);
    if (std::abs(goal - feedback_[i]) < kThere) feedback_[i] = goal;
    speed_[i] = (feedback_[i] - before) / period();
    fastest_ = std::max(fastest_, std::abs(speed_[i]) / options_.facts.pulses[i]);
  }
}

void Machine::step() {
  interpolate();
  move();
  follow();
  if (starting() && job_ == kJob && (since_start_ += period()) >= options_.begin) waiting_ = true;
  for (const auto& [output, input] : wires_) set_input(input, outputs_ & mask(output));
}

MotoFeedback Machine::feedback() const {
  MotoFeedback out;
  out.group = options_.group;
  out.valid = 6;
  for (std::size_t i = 0; i < 6; ++i) {
    const double radians = options_.facts.pulses[i] * wire::kDegrees;
    out.position[i] = static_cast<float>(std::round(feedback_[i]) / radians);
    out.velocity[i] = static_cast<float>(speed_[i] / radians);
  }
  return out;
}

MotoStatus Machine::status() const {
  MotoStatus out;
  out.drives = servo_on_;
  out.e_stopped = emergency_;
  out.alarm_code = static_cast<std::int32_t>(alarm_.code);
  out.in_error = alarm_.code != 0;
  const bool lags = [&] {
    for (std::size_t i = 0; i < 6; ++i)
      if (std::abs(feedback_[i] - static_cast<double>(command_[i])) > kStartDeviation) return true;
    return false;
  }();
  out.in_motion = !queue_.empty() || lags;
  out.mode = key_ == KeySwitch::teach ? 1 : 2;
  out.motion_possible = ready();
  return out;
}

// --- the Ethernet server ----------------------------------------------------------------------------------

HsesStatus Machine::panel() const {
  HsesStatus out;
  out.step = cycle_mode == 1;
  out.one_cycle = cycle_mode == 2;
  out.continuous = cycle_mode == 3;
  out.running = running_;
  out.teach = key_ == KeySwitch::teach;
  out.play = !out.teach;
  out.remote = key_ == KeySwitch::remote;
  out.pendant_hold = holds_[0];
  out.external_hold = holds_[1];
  out.command_hold = holds_[2];
  out.alarm = alarm_.code != 0;
  out.error = error_;
  out.servo = servo_on_;
  return out;
}

HsesPosition Machine::pulses() const {
  HsesPosition out;
  for (std::size_t i = 0; i < 6; ++i) out.values[i] = static_cast<std::int32_t>(std::llround(feedback_[i]));
  return out;
}

HsesPosition Machine::pose() const {
  HsesPosition out;
  out.type = 16;
  if (!options_.facts.chain) return out;
  Six joints = q();
  for (double& one : joints) one /= wire::kDegrees;
  Pose flange = options_.facts.chain->forward(joints) * tool;
  flange.position.z -= base_height(*options_.facts.chain);
  const Vec3 angles = to_rpy(flange.rotation);
  const double values[] = {flange.position.x * 1e6,         flange.position.y * 1e6,
                           flange.position.z * 1e6,         angles.x * wire::kDegrees * 1e4,
                           angles.y * wire::kDegrees * 1e4, angles.z * wire::kDegrees * 1e4};
  for (std::size_t i = 0; i < 6; ++i) out.values[i] = static_cast<std::int32_t>(std::lround(values[i]));
  return out;
}

/// Of speeds alone: the machine has no masses.
std::array<std::int32_t, 8> Machine::torque() const {
  std::array<std::int32_t, 8> out{};
  for (std::size_t i = 0; i < 6; ++i)
    out[i] =
        static_cast<std::int32_t>(1000 * speed_[i] / options_.facts.pulses[i] / options_.facts.velocity[i]);
  return out;
}

std::array<std::int32_t, 8> Machine::error() const {
  std::array<std::int32_t, 8> out{};
  for (std::size_t i = 0; i < 6; ++i)
    out[i] = static_cast<std::int32_t>(static_cast<double>(command_[i]) - feedback_[i]);
  return out;
}

Six Machine::setpoint() const {
  Six out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = static_cast<double>(command_[i]) / options_.facts.pulses[i];
  return out;
}

bool Machine::still() const {
  for (std::size_t i = 0; i < 6; ++i)
    if (feedback_[i] != static_cast<double>(command_[i])) return false;
  return true;
}

bool Machine::select_job(const std::string& name) {
  if (running_ || !still()) return false;
  job_ = name;
  ++selections_;
  return true;
}

bool Machine::start_job() {
  if (emergency_ || alarm_.code != 0 || error_ || holds() || key_ != KeySwitch::remote || !servo_on_)
    return false;
  running_ = true;
  waiting_ = false;
  since_start_ = 0;
  return true;
}

void Machine::set_input(int number, bool on) {
  if (is_signal(number)) inputs_ = on ? inputs_ | mask(number) : inputs_ & ~mask(number);
}

void Machine::set_output(int number, bool on) {
  if (is_signal(number)) outputs_ = on ? outputs_ | mask(number) : outputs_ & ~mask(number);
}

}  // namespace polyarm::yaskawa
