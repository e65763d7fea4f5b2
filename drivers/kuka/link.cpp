/// What a link does while it is open: the thread that answers the packets of RSI.
#include "drivers/kuka/link.hpp"

#include <arpa/inet.h>
#include <poll.h>

#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::kuka {

namespace {

constexpr Nanoseconds kLook = 20'000'000;        // between two judgements without an event
constexpr Nanoseconds kEnd = 2'000'000'000;      // for a motion to end
constexpr Nanoseconds kQuiet = 300'000'000;      // without a packet, while it ends
constexpr Nanoseconds kOver = 2'000'000'000;     // the same: RSI has ended though nobody asked it to
constexpr Nanoseconds kExplain = 1'000'000'000;  // for the controller to say why, beside its timeouts
constexpr double kAnswerShare = 0.6;   // of the cycle, for the loop's command; then the driver brakes
constexpr int kMostBehind = 8;         // old packets in a row; more are a new start
constexpr int kSteady = 5;             // packets with the robot held, before the loop commands
constexpr double kStopCycles = 2;      // until a stop begins
constexpr std::uint64_t kAnew = 1000;  // ms that the clock goes back when RSI begins anew
constexpr int kSlow = 3;               // packets of another cycle in a row

}  // namespace

void Link::command(bool move, const Six& joints) noexcept {
  Wanted wanted{move, samples_.value().count, {}};
  for (std::size_t i = 0; i < 6; ++i) wanted.joints[i] = joints[i] / wire::kRadians;
  commands_.write(wanted);
  wake();
}

void Link::wait(Nanoseconds now) {
  pollfd polled[2] = {{wake_.number(), POLLIN, 0}, {rsi_.number(), POLLIN, 0}};
  const bool answers = phase_ == Phase::streaming && commanded_ && is_open() && !settings_.stepped;
  const auto share = static_cast<Nanoseconds>(settings_.cycle_ms * 1e6 * kAnswerShare);
  const Nanoseconds left = answers ? std::clamp<Nanoseconds>(heard_ + share - now, 0, kLook) : kLook;
  const timespec time{0, static_cast<long>(left)};
  ::ppoll(polled, 2, &time, nullptr);
}

void Link::run() {
  while (!quit_) {
    wait(realtime::monotonic_now());
    calm(wake_.number());
    const Nanoseconds now = realtime::monotonic_now();
    if (renew_) begin_session(now);
    take_packets(now);
    take_command(now);
    judge(now);
    end(now);
  }
}

/// What is left of an earlier session counts no more.
void Link::begin_session(Nanoseconds now) {
  std::array<std::uint8_t, 64> dropped;
  for (int i = 0; i < 4096; ++i)
    if (wire::receive_datagram(rsi_.number(), dropped).got == wire::Got::nothing) break;
  const Sample before = current_;
  current_ = {};
  current_.q = before.q;
  samples_.write(current_);
  shaper_ = wire::Shaper(settings_.cycle_ms / 1000.0);
  fresh_ = true;
  commanded_ = late_ = ended_ = streamed_ = false;
  answered_ = 0;
  steady_ = behind_ = slow_ = 0;
  heard_ = commanded_at_ = now;
  silent_ = stands_ = rsi_off_ = false;
  late_answers_ = 0;
  most_correction_ = 0;
  const std::lock_guard lock(mutex_);
  unusable_ = Cause::none;
  stranger_.clear();
  renewed();
}

/// The first sender of a session is the controller; its address must be that of its RSI network.
bool Link::is_controller(const wire::UdpAddress& from) {
  if (from.host == sender_host_ && (fresh_ || from == sender_)) {
    sender_ = from;
    return true;
  }
  if (++current_.strangers == 1) {
    const std::lock_guard lock(mutex_);
    stranger_ = wire::host_text(from);
  }
  return false;
}

/// One packet at a time: commands are looked at between two of them.
void Link::take_packets(Nanoseconds now) {
  std::array<std::uint8_t, bounds::kRsiDatagramBytes> bytes;
  wire::UdpAddress from;
  const wire::Received got = wire::receive_datagram(rsi_.number(), bytes, &from);
  if (got.got != wire::Got::bytes || phase_ == Phase::idle) return;  // what is not ours gets no answer
  if (displaced_ && !streamed_) return void(heard_ = now);
  if (!is_controller(from)) return;
  const auto robot = decode_robot({reinterpret_cast<const char*>(bytes.data()), got.count});
  if (!robot) return note(Cause::bad_data);
  take_packet(*robot, now);
}

/// False: the packet came twice, or behind a later one.
bool Link::take_clock(const RsiRobot& robot) {
  if (phase_ == Phase::starting && robot.ipoc < current_.sequence) {
    fresh_ = true;
    steady_ = 0;
  }
  if (fresh_) return true;
  if (robot.ipoc <= current_.sequence) {
    ++current_.repeated;
    const bool anew = robot.ipoc + kAnew < current_.sequence || ++behind_ > kMostBehind;
    if (anew && phase_ == Phase::streaming) note(Cause::restarted);
    return false;
  }
  behind_ = 0;
  const std::uint64_t step = robot.ipoc - current_.sequence;
  const auto cycle = static_cast<std::uint64_t>(settings_.cycle_ms);
  if (step > cycle) current_.lost += step / cycle - 1;
  return true;
}

/// RSI has two cycles, and the driver must know which one; other steps of the clock are gaps.
void Link::check_cycle(std::uint64_t step) {
  const bool other = (step == 4 || step == 12) && step != static_cast<std::uint64_t>(settings_.cycle_ms);
  slow_ = other ? slow_ + 1 : 0;
  if (slow_ < kSlow) return;
  const std::lock_guard lock(mutex_);
  unusable_ = Cause::wrong_rate;
  unusable_detail_ = static_cast<int>(std::lround(1000.0 / static_cast<double>(step)));
  changed_.notify_all();
}

void Link::fill_sample(const RsiRobot& robot) {
  const std::uint64_t step = fresh_ ? 0 : robot.ipoc - current_.sequence;
  for (std::size_t i = 0; i < 6; ++i) {
    const double q = robot.axes[i] * wire::kRadians;
    current_.dq[i] = step > 0 ? (q - current_.q[i]) * 1000 / static_cast<double>(step) : 0;
    current_.q[i] = q;
  }
  current_.with_pose = robot.pose.has_value();
  if (robot.pose) current_.pose = *robot.pose;
  current_.delay = robot.delay.value_or(0);
  late_answers_ = current_.delay;
  current_.inputs = robot.inputs;
  current_.sequence = robot.ipoc;
  ++current_.count;
}

void Link::take_packet(const RsiRobot& robot, Nanoseconds now) {
  heard_ = now;
  silent_ = false;
  const std::uint64_t before = current_.sequence;
  if (!take_clock(robot)) return samples_.write(current_);
  if (phase_ == Phase::starting && !fresh_) check_cycle(robot.ipoc - before);
  // The loop's first command counts if it came before this packet. Looked at before the loop sees the packet,
  // so that a run repeats itself.
  if (phase_ == Phase::streaming && !brakes() && !commanded_) commanded_ = commands_.fetch();
  fill_sample(robot);
  fresh_ = false;
  samples_.write(current_);
  begin_cycle();
  answer(now);
}

/// While RSI begins, corrections are zero: the robot stands where RSI began. Later the loop's answer goes out
/// when it comes.
void Link::answer(Nanoseconds now) {
  const Phase phase = phase_;  // another thread may change it
  if (displaced_ && phase == Phase::starting) return;
  // Also the first packet of a start that was given up: its answer holds the robot where it stands.
  if (phase == Phase::starting || current_.count == 1) {
    for (std::size_t i = 0; i < 6; ++i) base_[i] = sent_[i] = current_.q[i] / wire::kRadians;
    shaper_.begin(base_);
  }
  if (phase == Phase::starting) {
    send(base_);
    if (++steady_ < kSteady || !go_ || renew_ || slow_ > 0 || unusable_ != Cause::none) return;
    commands_.fetch();  // what was commanded before counts no more
    commanded_at_ = now;
    commanded_ = false;
    return set_phase(Phase::streaming);
  }
  if (phase == Phase::ending || fault_) return brake();
  if (!commanded_) return send(shaper_.at());  // until the loop commands
  if (!settings_.follows) go_on();
}

/// A step of a stop; at rest the robot is held, and RSI is asked to end if the session does.
void Link::brake() {
  if (shaper_.still()) {
    ended_ = phase_ == Phase::ending;
    return send(shaper_.at(), ended_);
  }
  send(shaper_.brake(settings_.limits));
}

void Link::send(const Six& joints, bool stop) {
  RsiSensor out;
  out.ipoc = current_.sequence;
  out.stop = stop;
  double most = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    const double from = settings_.relative ? sent_[i] : base_[i];
    out.correction[i] = std::round((joints[i] - from) * 1e6) / 1e6;
    sent_[i] = from + out.correction[i];
    if (const double away = std::abs(sent_[i] - base_[i]); away > most) {
      most = away;
      most_axis_ = static_cast<int>(i);
    }
  }
  most_correction_ = most;
  const std::string text = encode(out, settings_.sen_type);
  wire::send_datagram(rsi_.number(), {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()},
                      sender_);
  answered_ = current_.count;
}

/// The way of a stop from the present speed, degrees.
double Link::stopping_way(std::size_t axis) const noexcept {
  return wire::stopping_way(
      shaper_.velocity()[axis], settings_.limits.at(wire::LimitKind::acceleration, axis),
      settings_.limits.at(wire::LimitKind::jerk, axis), kStopCycles * settings_.cycle_ms / 1000.0);
}

/// What the controller would end RSI for is not sent: the robot comes to rest before it.
bool Link::allowed(const Wanted& wanted) {
  for (std::size_t i = 0; i < 6; ++i) {
    const double way = std::copysign(stopping_way(i), shaper_.velocity()[i]);
    const double at = wanted.joints[i] + way;
    const bool limited = identity_.lower[i] < identity_.upper[i];
    if (std::abs(at - base_[i]) > identity_.correction_limit)
      note(Cause::correction_limit, static_cast<int>(i));
    else if (limited && (at < identity_.lower[i] || at > identity_.upper[i]))
      note(Cause::soft_limit, static_cast<int>(i));
  }
  return !fault_;
}

/// The next step towards what the loop wants.
void Link::go_on() {
  const Wanted& wanted = commands_.value();
  if (wanted.move && !allowed(wanted)) return brake();
  const Six next =
      wanted.move ? shaper_.next(wanted.joints, settings_.limits) : shaper_.brake(settings_.limits);
  current_.behind = shaper_.behind() * wire::kRadians;
  late_ = late_ && current_.behind > 0;
  current_.shaped = shaper_.shaped();
  send(next);
  // If it was late, what is behind was lost while no command came.
  judge_behind(shaper_, current_.behind, settings_.most_behind, late_ ? Cause::loop_silent : Cause::none);
}

/// A command answers the packet that the loop had read. If it does not come within its share of the cycle, a
/// step of a stop goes out instead: the controller counts late answers.
void Link::take_command(Nanoseconds now) {
  const bool fresh = commands_.fetch();
  if (fresh || !commanded_) commanded_at_ = now;
  if (phase_ != Phase::streaming) return;
  commanded_ = commanded_ || fresh;
  if (!commanded_ || !settings_.follows || !is_open()) return;
  if (brakes()) return brake();  // the loop does not answer any more
  if (commands_.value().count == current_.count) return go_on();
  const auto share = static_cast<Nanoseconds>(settings_.cycle_ms * 1e6 * kAnswerShare);
  if (settings_.stepped || now - heard_ < share) return;
  late_ = late_ || current_.behind == 0;
  brake();
}

void Link::judge(Nanoseconds now) {
  if (phase_ != Phase::streaming || fault_) return;
  if (settings_.relative && current_.delay > 0) return note(Cause::relative_late);
  if (now - heard_ > settings_.silence) {
    if (!silent_.exchange(true)) ::eventfd_write(services_wake_.number(), 1);
    // The other robots of the cell must not wait for a controller that does not say why.
    const Nanoseconds patience = settings_.eki ? 2 * settings_.timeout + kExplain : 0;
    if (now - heard_ > settings_.silence + patience) {
      const std::string from = stranger();
      return from.empty() ? note(Cause::silent) : note(Cause::other_sender, 0, from);
    }
    return;
  }
  if (commanded_ && now - commanded_at_ > settings_.loop_silence) note(Cause::loop_silent);
}

void Link::end(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (phase_ == Phase::streaming) {
    streamed_ = true;
    displaced_ = !settings_.eki && !settings_.relative;
  } else if (now - heard_ > (ended_ ? kQuiet : kOver)) {
    displaced_ = false;
  }
  if (phase_ == Phase::streaming && fault_) phase_ = Phase::ending;
  if (phase_ != Phase::ending) {
    ending_since_ = now;
    quiet_ = false;
    return;
  }
  if (is_open()) brake();  // the loop does not answer any more
  const bool still = shaper_.still() && std::all_of(current_.dq.begin(), current_.dq.end(),
                                                    [](double v) { return std::abs(v) < 1e-4; });
  quiet_ = rsi_off_ || now - heard_ > kQuiet;
  stands_ = stands_ || (still && ended_) || quiet_ || now - ending_since_ > kEnd;
  if (!stands_) return;
  changed_.notify_all();
}

}  // namespace polyarm::kuka
