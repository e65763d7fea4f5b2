/// What a link does while it is open: the thread that answers the packets of EGM.
#include "drivers/abb/link.hpp"

#include <poll.h>

#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::abb {

namespace {

constexpr Nanoseconds kLook = 20'000'000;    // between two judgements without an event
constexpr Nanoseconds kEnd = 2'000'000'000;  // for a motion to end
constexpr Nanoseconds kExplain = 1'000'000'000;  // for the controller to say why, beside its timeouts
constexpr int kMostBehind = 8;               // old packets in a row; more are a new start
constexpr int kErrorLasts_ms = 500;          // in the packets of a start, until it is not waited for
constexpr int kFadeIn_ms = 160;              // with the robot held; the RAPID module fades EGM in for 100

Six joints_of(const Values& values) {
  Six out{};
  for (std::size_t i = 0; i < 6; ++i) out[i] = values[i];
  return out;
}

Values values_of(const Six& joints) {
  Values out;
  out.count = 6;
  std::copy(joints.begin(), joints.end(), out.value.begin());
  return out;
}

}  // namespace

void Link::command(bool move, const Six& joints) noexcept {
  Wanted wanted{move, samples_.value().count, {}};
  for (std::size_t i = 0; i < 6; ++i) wanted.joints[i] = joints[i] / wire::kRadians;
  commands_.write(wanted);
  wake();
}

void Link::wait() {
  pollfd polled[2] = {{wake_.number(), POLLIN, 0}, {egm_.number(), POLLIN, 0}};
  const timespec time{0, static_cast<long>(kLook)};
  ::ppoll(polled, 2, &time, nullptr);
}

void Link::run() {
  while (!quit_) {
    wait();
    calm(wake_.number());
    const Nanoseconds now = realtime::monotonic_now();
    take_packets(now);
    take_command(now);
    judge(now);
    end(now);
  }
}

/// The first sender of a session is the controller; its address must be that of the services.
bool Link::is_controller(const wire::UdpAddress& from) {
  if (from.host == controller_ && (fresh_ || from == sender_)) {
    sender_ = from;
    return true;
  }
  ++current_.strangers;
  strange_ = true;
  return false;
}

/// One packet at a time: commands are looked at between two of them.
void Link::take_packets(Nanoseconds now) {
  std::array<std::uint8_t, bounds::kEgmDatagramBytes> bytes;
  wire::UdpAddress from;
  const wire::Received got = wire::receive_datagram(egm_.number(), bytes, &from);
  if (got.got != wire::Got::bytes || !is_controller(from)) return;
  const auto robot = decode_robot(Bytes(bytes).first(got.count));
  if (phase_ == Phase::idle) return;  // a program that is not ours gets no answer
  if (!robot || !robot->feedback || !robot->feedback->joints || robot->feedback->joints->count < 6)
    return robot && robot->feedback && robot->feedback->joints
               ? note(Cause::axes, static_cast<int>(robot->feedback->joints->count))
               : note(Cause::bad_data);
  take_packet(*robot, now);
}

/// False: the packet came twice, or behind a later one.
bool Link::take_sequence(const EgmRobot& robot) {
  const std::uint32_t steps = robot.header.sequence - current_.sequence;
  if (phase_ == Phase::starting && steps > 0x8000'0000u) {  // what came first was left of an earlier session
    fresh_ = true;
    steady_ = 0;
  }
  if (fresh_) return true;
  if (steps == 0 || steps > 0x8000'0000u) {
    ++current_.repeated;
    if (++behind_ > kMostBehind && phase_ == Phase::streaming && sign_ == Sign::none) sign_ = Sign::restart;
    return false;
  }
  behind_ = 0;
  current_.lost += steps - 1;
  return true;
}

void Link::fill_sample(const EgmRobot& robot) {
  const EgmPosition& at = *robot.feedback;
  const std::uint32_t steps = fresh_ ? 0 : robot.header.sequence - current_.sequence;
  for (std::size_t i = 0; i < 6; ++i) {
    const double q = (*at.joints)[i] * wire::kRadians;
    current_.dq[i] = steps > 0 ? (q - current_.q[i]) * 1000 / (steps * settings_.sampling_ms) : 0;
    current_.q[i] = q;
  }
  current_.with_pose = at.pose.has_value();
  if (at.pose) current_.pose = *at.pose;
  current_.with_force = robot.force && robot.force->count == 6;
  if (current_.with_force) std::copy_n(robot.force->value.begin(), 6, current_.force.begin());
  current_.motors = robot.motors;
  current_.state = robot.state;
  current_.rapid = robot.rapid;
  current_.converged = robot.converged.value_or(false);
  current_.collision = robot.collision.value_or(false);
  current_.utilization = robot.utilization.value_or(0);
  current_.sequence = robot.header.sequence;
  current_.time_ms = robot.header.time_ms;
  ++current_.count;
}

/// What makes EGM useless: another version, axes or clock than the driver's.
void Link::check_start(const EgmRobot& robot) {
  const auto useless = [this](Cause cause, int detail = 0) {
    const std::lock_guard lock(mutex_);
    unusable_ = cause;
    unusable_detail_ = detail;
    changed_.notify_all();
  };
  const std::size_t joints = robot.feedback->joints->count;
  const std::uint32_t steps = robot.header.sequence - current_.sequence;
  const std::uint32_t ms = robot.header.time_ms - current_.time_ms;
  errors_ = robot.state == EgmState::error ? errors_ + 1 : 0;
  if (errors_ * settings_.sampling_ms >= kErrorLasts_ms) useless(Cause::egm_error);
  if (!robot.feedback->time) useless(Cause::old_egm);
  if (joints > 6) useless(Cause::axes, static_cast<int>(joints));
  if (!fresh_ && steps == 1 && ms > 0 && ms < 1000 && ms != static_cast<std::uint32_t>(settings_.sampling_ms))
    useless(Cause::wrong_rate, static_cast<int>(std::lround(1000.0 / ms)));
}

void Link::take_packet(const EgmRobot& robot, Nanoseconds now) {
  heard_ = now;
  if (!take_sequence(robot)) {
    samples_.write(current_);
    return;
  }
  if (phase_ == Phase::starting) check_start(robot);
  // The loop's first command counts if it came before this packet. Looked at before the loop sees the packet,
  // so that a run repeats itself.
  if (phase_ == Phase::streaming && !brakes() && !commanded_) commanded_ = commands_.fetch();
  fill_sample(robot);
  fresh_ = false;
  if (phase_ == Phase::streaming && sign_ == Sign::none) sign_ = sign_of();
  samples_.write(current_);
  begin_cycle();
  answer(robot);
}

/// Holds the robot where EGM began to follow. Before that, the answers are what the controller plans.
void Link::answer_start(const EgmRobot& robot) {
  const Six measured = joints_of(*robot.feedback->joints);
  const bool runs = robot.state == EgmState::running && robot.motors == MotorState::on;
  if (!runs || steady_ == 0) shaper_.begin(measured);
  steady_ = runs ? steady_ + 1 : 0;
  send(shaper_.at(), {});
  if (steady_ * settings_.sampling_ms < kFadeIn_ms || unusable_ != Cause::none) return;
  commands_.fetch();  // what was commanded before counts no more
  pacer_.begin(realtime::monotonic_now());
  commanded_ = false;
  set_phase(Phase::streaming);
}

/// The loop's answer goes out when it comes; an answer that did not come is replaced by a step of a stop.
void Link::answer(const EgmRobot& robot) {
  if (phase_ == Phase::starting) return answer_start(robot);
  if (brakes()) return brake();
  if (!commanded_) return send(shaper_.at(), {});  // until the loop commands
  if (answered_ + 1 != current_.count) {
    late_ = late_ || current_.behind == 0;
    brake();
    answered_ = current_.count - 1;
  }
  pacer_.cycle();
}

void Link::brake() {
  const Six joints = shaper_.brake(settings_.limits);
  send(joints, shaper_.velocity());
}

void Link::send(const Six& joints, const Six& velocity) {
  EgmSensor out;
  out.header.sequence = sequence_++;
  out.header.time_ms = static_cast<std::uint32_t>((realtime::monotonic_now() - began_) / 1'000'000);
  out.header.type = MessageType::correction;
  out.planned.emplace().joints = values_of(joints);
  if (settings_.speed_reference) out.joint_speed = values_of(velocity);
  wire::send_datagram(egm_.number(), encode(out), sender_);
  answered_ = current_.count;
}

/// A command answers the packet that the loop had read. One that comes when that packet has its answer (at
/// the beginning, or too late) is not kept for the next one: the loop gives that one another command.
void Link::take_command(Nanoseconds now) {
  const bool fresh = commands_.fetch();
  if (fresh || !commanded_) pacer_.command(now);
  if (phase_ != Phase::streaming) return;
  if (fresh && !std::exchange(commanded_, true)) pacer_.sent();  // the position that is held
  if (!commanded_ || brakes()) return;
  const bool ours = commands_.value().count == current_.count;
  if (settings_.follows ? !is_open() || !ours : !pacer_.due()) return;
  const Wanted& wanted = commands_.value();
  const Six next =
      wanted.move ? shaper_.next(wanted.joints, settings_.limits) : shaper_.brake(settings_.limits);
  current_.behind = shaper_.behind() * wire::kRadians;
  late_ = late_ && current_.behind > 0;
  current_.shaped = shaper_.shaped();
  send(next, shaper_.velocity());
  pacer_.sent();
  // If it was late, what is behind was lost while no command came.
  judge_behind(shaper_, current_.behind, settings_.most_behind, late_ ? Cause::loop_silent : Cause::none);
}

Link::Sign Link::sign_of() const noexcept {
  if (current_.motors == MotorState::off) return Sign::motors;
  if (current_.rapid == RapidState::stopped) return Sign::program;
  if (current_.state == EgmState::error) return Sign::error;
  if (current_.state != EgmState::running) return Sign::egm;
  return Sign::none;
}

/// What EGM alone shows.
Cause Link::cause_of(Sign sign) const noexcept {
  switch (sign) {
    case Sign::motors:
      return Cause::motors_off;
    case Sign::program:
      return Cause::program_stopped;
    case Sign::error:
      return Cause::egm_error;
    case Sign::restart:
      return Cause::restarted;
    case Sign::egm:
      return Cause::egm_stopped;
    default:
      return strange_ ? Cause::other_sender : Cause::silent;
  }
}

void Link::judge(Nanoseconds now) {
  if (phase_ != Phase::streaming || fault_) return;
  if (current_.collision) return note(Cause::collision);
  if (sign_ == Sign::none && now - heard_ > settings_.silence) sign_ = Sign::silence;
  if (sign_ != Sign::none) {
    if (asked_ != sign_) sign_since_ = now;
    ask_why(sign_);
    // The other robots of the cell must not wait for a controller that does not say why.
    if (now - sign_since_ > 2 * settings_.rws.http.timeout + kExplain) note(cause_of(sign_));
    return;
  }
  if (commanded_ && pacer_.silent(now)) note(Cause::loop_silent);
}

void Link::end(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (phase_ == Phase::starting && stop_wanted_) phase_ = Phase::idle;
  if (phase_ == Phase::streaming && (stop_wanted_ || fault_)) {
    phase_ = Phase::ending;
    ending_since_ = now;
  }
  if (phase_ == Phase::ending) {
    if (is_open()) brake();  // the loop does not answer any more
    const bool stands = shaper_.still() && std::all_of(current_.dq.begin(), current_.dq.end(),
                                                       [](double v) { return std::abs(v) < 1e-4; });
    const bool follows = current_.state == EgmState::running && now - heard_ < settings_.silence;
    if (follows && !stands && now - ending_since_ < kEnd) return;
    phase_ = Phase::idle;
  }
  changed_.notify_all();
}

}  // namespace polyarm::abb
