#include "drivers/servo_bus/component.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <utility>

#include "drivers/servo_bus/parameters.hpp"
#include "drivers/servo_bus/standstill.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::servo_bus {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kAttempts = 3;
constexpr int kOutsideTolerance = 20;  // steps, 1.8°: play, and the sag of a joint below its stop
constexpr int kStallDistance = 20;     // steps from the goal at which a joint without motion counts as stuck
constexpr Nanoseconds kLoweringStep = 20'000'000;

constexpr const char* kQuantities[] = {"position", "velocity", "effort", "current", "temperature", "voltage"};

std::uint32_t bit(std::size_t joint) {
  return 1u << joint;
}
}  // namespace

CallbackReturn ServoComponent::on_init(const hardware::ComponentContext& context) {
  setup_ = read_setup(context, family_);
  name_ = context.name;
  servos_.assign(setup_.joints.size(), {});
  block_.assign(setup_.joints.size() * family_.present_length, 0);
  for (std::size_t j = 0; j < setup_.joints.size(); ++j) {
    ids_.push_back(setup_.joints[j].id);
    servos_[j].values.fill(kNone);
    for (const std::string& state : setup_.joints[j].states)
      for (std::size_t q = 0; q < std::size(kQuantities); ++q)
        if (state == kQuantities[q]) places_.push_back({j, static_cast<Quantity>(q)});
  }
  return CallbackReturn::success;
}

std::vector<hardware::InterfaceDescription> ServoComponent::state_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  for (const Place& place : places_)
    out.push_back(
        {setup_.joints[place.joint].interface + "/" + kQuantities[static_cast<std::size_t>(place.quantity)]});
  return out;
}

std::vector<hardware::InterfaceDescription> ServoComponent::command_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  if (setup_.led_by_hand) return out;
  for (const JointSetup& joint : setup_.joints) out.push_back({joint.interface + "/" + name(joint.mode)});
  return out;
}

std::string ServoComponent::who(std::size_t joint) const {
  return setup_.joints[joint].name + " (servo " + std::to_string(setup_.joints[joint].id) + " on " +
         setup_.port + ")";
}

CallbackReturn ServoComponent::refuse(const Problems& problems) {
  refusal_ = Error(problems.list()).what();
  return CallbackReturn::failure;
}

bool ServoComponent::fetch(std::size_t joint, const Register& reg, std::int32_t& value) {
  for (int attempt = 0; attempt < kAttempts; ++attempt)
    if (bus_.read(setup_.joints[joint].id, reg, value) == Outcome::ok) return true;
  return false;
}

bool ServoComponent::identify(std::size_t j, Problems& problems) {
  const JointSetup& joint = setup_.joints[j];
  Servo& servo = servos_[j];
  Outcome answer = Outcome::lost;
  for (int attempt = 0; attempt < kAttempts && answer == Outcome::lost; ++attempt)
    answer = bus_.ping(joint.id);
  std::int32_t model = 0, firmware = 0;
  if (answer != Outcome::ok || !fetch(j, family_.model, model) || !fetch(j, family_.firmware, firmware)) {
    problems.error("no-servo", {}, who(j) + " does not answer",
                   "check power, cable, id and baud rate: `polyarm setup " + std::string(family_.name) +
                       "` shows which servos answer");
    return false;
  }
  servo.model = model;
  servo.firmware = firmware;
  const Model* known = find_model(family_, model);
  const bool expected = joint.model ? *joint.model == model : known != nullptr;
  if (!expected && !joint.any_model) {
    problems.error(
        "wrong-model", {},
        who(j) + " reports model " + std::to_string(model) +
            (joint.model ? ", not " + std::to_string(*joint.model) : ", which is not known here"),
        "if that is right, set " + joint.name + ".model to " + std::to_string(model) + " or to any");
    return false;
  }
  servo.current_unit = known ? known->current_unit : family_.models.front().current_unit;
  if (joint.mode == Mode::current && servo.current_unit == 0)
    problems.error("no-current-mode", {}, who(j) + " measures no current, so it has no current mode");
  return true;
}

void ServoComponent::find_limits(std::size_t j, Problems& problems) {
  const JointSetup& joint = setup_.joints[j];
  Servo& servo = servos_[j];
  std::int32_t min = 0, max = 0, hot = 0, low = 0, high = 0, phase = 4, soft = 0;
  const bool there = fetch(j, family_.min_limit, min) && fetch(j, family_.max_limit, max) &&
                     fetch(j, family_.max_temperature, hot) && fetch(j, family_.min_voltage, low) &&
                     fetch(j, family_.max_voltage, high) && fetch(j, family_.soft_limit, soft) &&
                     (!family_.phase || fetch(j, family_.phase, phase));
  if (!there) {
    problems.error("no-servo", {}, who(j) + " stopped answering while its limits were read");
    return;
  }
  if (min >= max) {  // both 0: no limits, several turns
    min = -32767;
    max = 32767;
  }
  servo.min = std::max(joint.min.value_or(min), min);
  servo.max = std::min(joint.max.value_or(max), max);
  if (servo.min >= servo.max)
    problems.error("bad-limits", {},
                   who(j) + " has no range left between min and max of the parameters and its own");
  servo.max_temperature = joint.max_temperature.value_or(hot);
  servo.min_voltage = low * family_.voltage_unit;
  servo.max_voltage = high * family_.voltage_unit;
  servo.velocity_unit = family_.velocity_unit * (family_.phase && !(phase & 4) ? 50 : 1);
  servo.soft_limit = soft;
  const bool load = family_.present_load || servo.current_unit == 0;
  servo.stall_effort =
      joint.stall_effort.value_or(load ? 0.95 * joint.effort_scale : std::numeric_limits<double>::infinity());
}

bool ServoComponent::measure_all() {
  std::size_t here = 0;
  std::array<bool, kMost> had{};
  for (int attempt = 0; attempt < kAttempts && here < ids_.size(); ++attempt) {
    if (bus_.sync_read(ids_, family_.present_address, family_.present_length, block_, replies_) !=
        Outcome::ok)
      return false;
    for (std::size_t j = 0; j < ids_.size(); ++j) {
      if (!replies_[j].here) continue;
      take(j, Bytes(block_).subspan(j * family_.present_length, family_.present_length), replies_[j].error);
      here += !std::exchange(had[j], true);
    }
  }
  return here == ids_.size();
}

CallbackReturn ServoComponent::on_configure() {
  const std::lock_guard guard(mutex_);
  watchdog_.stop();  // ends one that has not finished; this process takes over
  refusal_.clear();
  fault_ = 0;
  active_ = false;
  Problems problems;
  try {
    serial::PortOptions options;
    options.path = setup_.port;
    options.baud = setup_.baud;
    options.holder = "component " + name_;
    bus_.open(options, setup_.answer_timeout);
  } catch (const Error& e) {
    refusal_ = e.what();
    return CallbackReturn::failure;
  }
  for (std::size_t j = 0; j < ids_.size(); ++j)
    if (identify(j, problems)) find_limits(j, problems);
  if (!problems.has_errors() && !measure_all())
    problems.error("no-servo", {}, "not all servos on " + setup_.port + " answer a common request",
                   "a servo whose firmware has no sync read needs an update by its maker's tool");
  if (!problems.has_errors()) return CallbackReturn::success;
  bus_.close();
  return refuse(problems);
}

void ServoComponent::check_before_torque(std::size_t j, Problems& problems) const {
  const Servo& servo = servos_[j];
  if (servo.status)
    problems.error("servo-alarm", {}, who(j) + " reports " + status_names(family_, servo.status),
                   "mend the cause, then switch its power off and on");
  const double volts = servo.values[static_cast<std::size_t>(Quantity::voltage)];
  if (volts < servo.min_voltage || volts > servo.max_voltage)
    problems.error("wrong-voltage", {},
                   who(j) + " has " + format_number(std::round(volts * 10) / 10) + " V, it takes " +
                       format_number(servo.min_voltage) + " to " + format_number(servo.max_voltage) + " V",
                   "check the power supply");
  const int outside = std::max(servo.min - servo.steps, servo.steps - servo.max);
  if (setup_.joints[j].mode == Mode::position && outside > kOutsideTolerance)
    problems.error(
        "outside-range", {},
        who(j) + " is at " + std::to_string(servo.steps) + ", " + std::to_string(outside) +
            " steps outside its range of " + std::to_string(servo.min) + " to " + std::to_string(servo.max),
        "move it by hand, or calibrate again with `polyarm setup " + std::string(family_.name) + "`");
}

bool ServoComponent::set_mode(std::size_t j, Problems& problems) {
  const JointSetup& joint = setup_.joints[j];
  const int wanted = joint.mode == Mode::position   ? family_.mode_position
                     : joint.mode == Mode::velocity ? family_.mode_velocity
                                                    : family_.mode_current;
  std::int32_t is = 0, torque = 0;
  if (!fetch(j, family_.mode, is) || !fetch(j, family_.torque, torque)) {
    problems.error("no-servo", {}, who(j) + " stopped answering");
    return false;
  }
  if (is == wanted) return true;
  if (torque) {
    problems.error("torque-on", {}, who(j) + " holds in another mode, and changing it would let the joint go",
                   "support the arm, switch its power off and on, and activate again");
    return false;
  }
  if (family_.lock && bus_.write_checked(joint.id, family_.lock, 0) != Outcome::ok) return false;
  const Outcome changed = bus_.write_checked(joint.id, family_.mode, wanted);
  if (family_.lock && bus_.write_checked(joint.id, family_.lock, 1) != Outcome::ok) return false;
  if (changed == Outcome::ok) return true;
  problems.error("mode-refused", {}, who(j) + " does not take the mode " + name(joint.mode));
  return false;
}

bool ServoComponent::enable(std::size_t j, Problems& problems) {
  const JointSetup& joint = setup_.joints[j];
  Servo& servo = servos_[j];
  if (!set_mode(j, problems)) return false;
  if (joint.torque_limit)
    servo.soft_limit = static_cast<int>(std::lround(*joint.torque_limit * family_.soft_limit_full));
  else if (servo.soft_limit == 0)
    servo.soft_limit = static_cast<int>(family_.soft_limit_full);
  servo.goal = joint.mode == Mode::position ? std::clamp(servo.steps, servo.min, servo.max) : 0;
  servo.lost = 0;
  servo.stalled_for = 0;
  bool done = true;
  const auto set = [&](const Register& reg, std::int32_t value) {
    done = done && bus_.write_checked(joint.id, reg, value) == Outcome::ok;
  };
  if (family_.watchdog) set(family_.watchdog, 0);
  set(goal_register(family_, joint.mode), servo.goal);
  set(family_.soft_limit, servo.soft_limit);
  set(family_.torque, 1);
  if (family_.watchdog && setup_.bus_watchdog_ms > 0 && joint.mode != Mode::position)
    set(family_.watchdog, std::max(1, setup_.bus_watchdog_ms / 20));
  if (!done)
    problems.error("torque-refused", {},
                   who(j) + " could not be set up to hold: its answers were wrong or did not come",
                   "check cable and power; joints before it in the list may hold already");
  return done;
}

CallbackReturn ServoComponent::on_activate() {
  const std::lock_guard guard(mutex_);
  refusal_.clear();
  fault_ = 0;
  Problems problems;
  if (!measure_all())
    problems.error("no-servo", {}, "not all servos on " + setup_.port + " answer", "check cables and power");
  else
    for (std::size_t j = 0; j < ids_.size(); ++j) check_before_torque(j, problems);
  if (setup_.led_by_hand) return let_go(problems);
  if (!problems.has_errors() && !start_watchdog(problems)) return refuse(problems);
  // Goal = measured, and only then torque.
  for (std::size_t j = 0; j < ids_.size() && !problems.has_errors(); ++j)
    if (!enable(j, problems) && !problems.has_errors())
      problems.error("torque-refused", {}, who(j) + " could not be enabled");
  if (problems.has_errors()) return refuse(problems);
  if (setup_.watched && !fine(watchdog_.arm())) return CallbackReturn::error;
  last_written_ = 0;
  active_ = true;
  return CallbackReturn::success;
}

/// Joints that are moved by hand: those that still hold are let go slowly.
CallbackReturn ServoComponent::let_go(Problems& problems) {
  bool holds = false;
  for (std::size_t j = 0; j < ids_.size() && !problems.has_errors(); ++j) {
    std::int32_t torque = 0;
    if (!fetch(j, family_.torque, torque)) problems.error("no-servo", {}, who(j) + " stopped answering");
    holds = holds || torque != 0;
  }
  if (problems.has_errors()) return refuse(problems);
  if (holds) lower();
  return CallbackReturn::success;
}

/// Stops the joints in place; torque stays on. True if all joints have confirmed it.
bool ServoComponent::hold() noexcept {
  if (setup_.led_by_hand) return true;
  bool all = true;
  for (std::size_t j = 0; j < ids_.size(); ++j) {
    const Outcome outcome = stand(bus_, ids_[j], setup_.joints[j].mode, servos_[j].min, servos_[j].max);
    all = all && outcome == Outcome::ok;
    if (outcome == Outcome::gone || outcome == Outcome::failed) break;
  }
  return all;
}

/// Reduces the torque gradually, then switches it off.
void ServoComponent::lower() noexcept {
  std::array<std::int32_t, kMost> limits{};
  realtime::Periodic pace(kLoweringStep);
  pace.start();
  const std::int64_t steps = std::max<std::int64_t>(1, setup_.release_time / kLoweringStep);
  for (std::int64_t k = 1; k <= steps; ++k) {
    for (std::size_t j = 0; j < ids_.size(); ++j)
      limits[j] = static_cast<std::int32_t>(servos_[j].soft_limit * (steps - k) / steps);
    if (bus_.sync_write(ids_, family_.soft_limit, std::span(limits).first(ids_.size())) == Outcome::gone)
      return;
    pace.wait();
  }
  for (std::size_t j = 0; j < ids_.size(); ++j) {
    if (bus_.write_checked(ids_[j], family_.torque, 0) == Outcome::gone) return;
    bus_.write_checked(ids_[j], family_.soft_limit, servos_[j].soft_limit);
  }
}

CallbackReturn ServoComponent::on_deactivate() {
  const std::lock_guard guard(mutex_);
  active_ = false;
  held_ = !bus_.is_open() || hold();
  if (!watchdog_.running()) return CallbackReturn::success;
  return held_ && fine(watchdog_.disarm()) ? CallbackReturn::success : CallbackReturn::error;
}

CallbackReturn ServoComponent::on_cleanup() {
  const std::lock_guard guard(mutex_);
  if (held_) watchdog_.stop();
  bus_.close();
  return CallbackReturn::success;
}

CallbackReturn ServoComponent::on_shutdown() {
  const std::lock_guard guard(mutex_);
  if (active_ && bus_.is_open()) held_ = hold();
  active_ = false;
  leave_watchdog();
  if (bus_.is_open() && setup_.lowers_on_shutdown) lower();
  bus_.close();
  return CallbackReturn::success;
}

CallbackReturn ServoComponent::on_error() {
  const std::lock_guard guard(mutex_);
  active_ = false;
  if (!bus_.is_open()) return CallbackReturn::success;
  watchdog_.disarm();  // only one process uses the line at a time
  held_ = hold();
  if (held_)
    watchdog_.stop();
  else
    watchdog_.make_safe();
  bus_.close();
  return CallbackReturn::success;
}

ServoComponent::~ServoComponent() {
  const std::lock_guard guard(mutex_);
  if (active_ && bus_.is_open()) held_ = hold();
  leave_watchdog();
}

void ServoComponent::fault(FaultKind kind, std::uint32_t joints, unsigned detail) noexcept {
  std::uint64_t none = 0;  // the first cause is kept
  const std::uint64_t code =
      static_cast<std::uint64_t>(kind) << 56 | static_cast<std::uint64_t>(detail & 0xFFFF) << 32 | joints;
  fault_.compare_exchange_strong(none, code);
}

void ServoComponent::take(std::size_t j, Bytes block, std::uint8_t error) noexcept {
  const JointSetup& joint = setup_.joints[j];
  Servo& servo = servos_[j];
  const auto at = [&](const Register& reg) {
    return decode(reg, block.subspan(static_cast<std::size_t>(reg.address - family_.present_address)));
  };
  const auto value = [&](Quantity quantity) -> double& {
    return servo.values[static_cast<std::size_t>(quantity)];
  };
  const double step = 2 * std::numbers::pi / family_.steps_per_turn;
  servo.steps = at(family_.present_position);
  value(Quantity::position) = joint.offset + joint.direction * (servo.steps - joint.zero) * step;
  value(Quantity::velocity) = joint.direction * at(family_.present_velocity) * servo.velocity_unit;
  const double current = joint.direction * at(family_.present_current) * servo.current_unit;
  const bool has_current = servo.current_unit > 0;
  value(Quantity::current) = has_current ? current : kNone;
  if (family_.present_load)
    value(Quantity::effort) =
        joint.direction * at(family_.present_load) * family_.load_unit * joint.effort_scale;
  else
    value(Quantity::effort) =
        (has_current ? current : joint.direction * at(family_.present_current) * family_.load_unit) *
        joint.effort_scale;
  value(Quantity::voltage) = at(family_.present_voltage) * family_.voltage_unit;
  value(Quantity::temperature) = at(family_.present_temperature);
  servo.status = 0;
  if (family_.present_status) {
    servo.status = static_cast<unsigned>(at(family_.present_status)) | error;
  } else if (error & 0x80) {  // a separate register has the cause
    std::int32_t bits = 0;
    servo.status =
        bus_.read(joint.id, family_.status, bits) == Outcome::ok ? static_cast<unsigned>(bits) : 0x100;
  }
}

void ServoComponent::watch(std::size_t j, double dt) noexcept {
  const JointSetup& joint = setup_.joints[j];
  Servo& servo = servos_[j];
  const auto value = [&](Quantity quantity) { return servo.values[static_cast<std::size_t>(quantity)]; };
  if (servo.status) fault(FaultKind::alarm, bit(j), servo.status);
  if (value(Quantity::temperature) >= servo.max_temperature)
    fault(FaultKind::hot, bit(j), static_cast<unsigned>(value(Quantity::temperature)));
  const bool wants = joint.mode == Mode::position   ? std::abs(servo.goal - servo.steps) > kStallDistance
                     : joint.mode == Mode::velocity ? servo.goal != 0
                                                    : false;
  const bool stuck = active_ && joint.stall_time > 0 && wants &&
                     std::abs(value(Quantity::velocity)) < kStandstill &&
                     std::abs(value(Quantity::effort)) >= servo.stall_effort;
  servo.stalled_for = stuck ? servo.stalled_for + dt : 0;
  if (stuck && servo.stalled_for >= joint.stall_time) fault(FaultKind::stalled, bit(j), 0);
}

ReturnType ServoComponent::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  const std::lock_guard guard(mutex_);
  const Outcome outcome = bus_.sync_read(ids_, family_.present_address, family_.present_length, block_,
                                         replies_, setup_.fast_sync_read);
  const auto all = static_cast<std::uint32_t>((std::uint64_t{1} << ids_.size()) - 1);
  if (outcome == Outcome::gone) fault(FaultKind::gone, all, 0);
  if (outcome == Outcome::failed) fault(FaultKind::failed, all, 0);
  std::uint32_t lost = 0;
  for (std::size_t j = 0; outcome == Outcome::ok && j < ids_.size(); ++j) {
    Servo& servo = servos_[j];
    if (!replies_[j].here) {
      if (++servo.lost >= setup_.lost_cycles) lost |= bit(j);
      continue;
    }
    servo.lost = 0;
    take(j, Bytes(block_).subspan(j * family_.present_length, family_.present_length), replies_[j].error);
    watch(j, seconds(cycle.period));
  }
  if (lost) fault(FaultKind::lost, lost, static_cast<unsigned>(setup_.lost_cycles));
  for (std::size_t i = 0; i < places_.size(); ++i)
    states[i] = servos_[places_[i].joint].values[static_cast<std::size_t>(places_[i].quantity)];
  return fault_.load(std::memory_order_relaxed) ? ReturnType::error : ReturnType::ok;
}

int ServoComponent::goal_of(std::size_t j, double command) const noexcept {
  const JointSetup& joint = setup_.joints[j];
  const Servo& servo = servos_[j];
  const double step = 2 * std::numbers::pi / family_.steps_per_turn;
  double goal = 0, lower = -32767, upper = 32767;
  switch (joint.mode) {
    case Mode::position:
      goal = joint.zero + joint.direction * (command - joint.offset) / step;
      lower = servo.min;
      upper = servo.max;
      break;
    case Mode::velocity:
      goal = joint.direction * command / servo.velocity_unit;
      break;
    case Mode::current:
      goal = joint.direction * command / servo.current_unit;
      break;
  }
  return static_cast<int>(std::lround(std::clamp(goal, lower, upper)));
}

bool ServoComponent::send_goals(std::span<const double> commands) noexcept {
  for (const Mode mode : {Mode::position, Mode::velocity, Mode::current}) {
    std::array<std::uint8_t, kMost> ids{};
    std::array<std::int32_t, kMost> goals{};
    std::size_t count = 0;
    for (std::size_t j = 0; j < ids_.size(); ++j) {
      if (setup_.joints[j].mode != mode || !std::isfinite(commands[j])) continue;
      servos_[j].goal = goal_of(j, commands[j]);
      ids[count] = ids_[j];
      goals[count++] = servos_[j].goal;
    }
    const Outcome outcome = bus_.sync_write(std::span(ids).first(count), goal_register(family_, mode),
                                            std::span(goals).first(count));
    if (outcome == Outcome::ok) continue;
    const auto all = static_cast<std::uint32_t>((std::uint64_t{1} << ids_.size()) - 1);
    fault(outcome == Outcome::gone ? FaultKind::gone : FaultKind::failed, all, 0);
    return false;
  }
  return true;
}

ReturnType ServoComponent::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  const std::lock_guard guard(mutex_);
  if (!active_ || fault_.load(std::memory_order_relaxed)) return fault_ ? ReturnType::error : ReturnType::ok;
  // First checks the watchdog: after a hang the commands are old.
  if (!fine(watchdog_.running() ? watchdog_.listen() : watchdog::Health::fine) || servos_have_waited() ||
      !send_goals(commands))
    return ReturnType::error;
  last_written_ = realtime::monotonic_now();
  if (!watchdog_.running()) return ReturnType::ok;
  // Checks again: this process may have hung between the check and the goals.
  if (fine(watchdog_.listen())) return fine(watchdog_.beat()) ? ReturnType::ok : ReturnType::error;
  std::array<double, kMost> zero{};
  for (std::size_t j = 0; j < ids_.size(); ++j)
    if (setup_.joints[j].mode == Mode::position) zero[j] = kNone;
  send_goals(std::span(zero).first(ids_.size()));
  return ReturnType::error;
}

std::string ServoComponent::reason() const {
  const std::uint64_t code = fault_.load();
  if (code == 0) return refusal_;
  const auto kind = static_cast<FaultKind>(code >> 56);
  const auto detail = static_cast<unsigned>(code >> 32 & 0xFFFF);
  std::vector<std::string> names;
  for (std::size_t j = 0; j < setup_.joints.size(); ++j)
    if (code >> j & 1) names.push_back(who(j));
  const std::string joints = join(names, ", ");
  switch (kind) {
    case FaultKind::lost:
      return joints + ": no answer in " + std::to_string(detail) +
             " cycles, the last goal is still held there; check the cable before the first of them, and "
             "power";
    case FaultKind::gone:
      return setup_.port + " is gone and with it " + joints +
             ": the adapter was unplugged or has lost its power; plug it in and activate again";
    case FaultKind::failed:
      return "the system refused to read or write " + setup_.port + " for " + joints +
             "; plug the adapter in again and activate";
    case FaultKind::alarm:
      return joints + " reports " +
             (detail & 0x100 ? std::string("an unspecified alarm") : status_names(family_, detail)) +
             "; mend the cause, switch its power off and on, and activate again";
    case FaultKind::hot:
      return joints + " is at " + std::to_string(detail) +
             " °C, its limit; let it cool, and take load off it, before it is activated again";
    case FaultKind::stalled:
      return joints +
             " pushes with all it has and does not move: something is in its way; free it and activate again";
    case FaultKind::watchdog:
      return watchdog::sentence(static_cast<watchdog::Health>(detail), watchdog_names());
    case FaultKind::stood_still:
      return setup_.port + " was silent for more than " + std::to_string(setup_.bus_watchdog_ms) +
             " ms, since this process stood still or waited for answers, and the servos have stopped by "
             "themselves; see that nothing is in the way, then configure and activate it "
             "again";
    case FaultKind::none:
      break;
  }
  return refusal_;
}

const hardware::DriverFacts* ServoComponent::facts() const noexcept {
  return &facts_of(family_);
}

std::string ServoComponent::summary() const {
  return std::string(family_.name) + " servos on " + setup_.port + " at " + std::to_string(setup_.baud) +
         " bit/s: " + std::to_string(setup_.joints.size()) + " joints";
}

}  // namespace polyarm::servo_bus
