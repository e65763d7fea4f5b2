/// What the link in forward mode does while it is open: the rounds in which it asks, judges and sends.
#include "drivers/yaskawa/forward_link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"

namespace polyarm::yaskawa {

using forward::MoveOrder;

namespace {

constexpr double kStillWay = 5e-5;  // rad between readings of a robot that stands
constexpr int kStillReadings = 3;
constexpr int kUnread = 10;          // rounds without a state, after which an end is given up
constexpr int kRobotMoves = 0x2010;  // added status of a refusal
// Times of the loop or of this computer, s.
constexpr double kStarting = 1.0005;                   // until a job that was started counts as stopped
constexpr double kHolding = 2.0005;                    // for a hold to stop the job
constexpr double kSameTool = 0.005, kSameTurn = 0.02;  // m, rad between the TCP here and there
constexpr Nanoseconds kToStand = 3'000'000'000;        // for the robot to stand

}  // namespace

double ForwardLink::now() const {
  if (settings_.times.stepped && phase_ == Phase::active)
    return static_cast<double>(cycles_seen_) * seconds(settings_.period);
  return seconds(realtime::monotonic_now());
}

/// False after a failure, which is noted. A refusal leaves the connection as it is.
template <typename Answer>
bool ForwardLink::came(const Answer& answer) {
  if (answer) return true;
  const Hses::Failure failure = hses_.failure();
  if (failure.cause != Cause::hses_refused) gone_ = true;
  note(failure.cause, failure.detail, failure.text);
  return false;
}

void ForwardLink::round() {
  const auto active = [this] { return phase_ == Phase::active && !fault_; };
  if (active() && !beat()) return;
  const bool well = read();
  if (active()) return act();
  if (phase_ == Phase::idle || over_) return;
  unread_ = well ? 0 : unread_ + 1;
  if (unread_ >= kUnread) over_ = true;
  if (well) end();
}

// --- what the controller says ---------------------------------------------------------------------------

bool ForwardLink::write_beat() {
  const int byte = (beat_ ? kBeatBit : 0) | (session_open_ ? kSessionBit : 0);
  return hses_.set_signals(settings_.heartbeat_byte, static_cast<std::uint8_t>(byte));
}

bool ForwardLink::beat() {
  beat_ = !beat_;
  return came(write_beat());
}

bool ForwardLink::read_signals(bool inputs, const wire::SignalRange& range, std::uint32_t& into) {
  constexpr int kFirstInputs = 1, kFirstOutputs = 1001;
  if (range.count == 0) return true;
  const int first = (range.first - 1) / 8, last = (range.first + range.count - 2) / 8;
  for (int byte = first; byte <= last; ++byte) {
    const auto value = hses_.signals(byte + (inputs ? kFirstInputs : kFirstOutputs));
    if (!came(value)) return false;
    into = (into & ~(0xFFu << 8 * byte)) | static_cast<std::uint32_t>(*value) << 8 * byte;
  }
  return true;
}

bool ForwardLink::read() {
  const auto status = hses_.status();
  if (!came(status)) return false;
  const auto place = hses_.pulses();
  if (!came(place)) return false;
  const auto numbers = hses_.doubles(SharedDoubles::first, SharedDoubles::count);
  if (!came(numbers) || !read_signals(true, settings_.inputs, current_.inputs) ||
      !read_signals(false, settings_.outputs, current_.outputs))
    return false;
  take(*status, *place, *numbers);
  return true;
}

void ForwardLink::take(const HsesStatus& status, const HsesPosition& place,
                       const std::vector<std::int32_t>& shared) {
  const Six q = radians_of(place.values, settings_.pulses);
  const double time = now(), dt = time - read_at_;
  const bool moved = forward::largest_difference(q, current_.q) > kStillWay;
  still_readings_ = moved || status.running ? 0 : still_readings_ + 1;
  if (current_.count > 0 && dt > 0)
    for (std::size_t i = 0; i < 6; ++i) current_.dq[i] = (q[i] - current_.q[i]) / dt;
  read_at_ = time;
  current_.q = q;
  current_.status = status;
  ++current_.count;
  std::copy_n(shared.begin(), shared_.size(), shared_.begin());
  if (!forgotten_) ended_ = this->shared(SharedDoubles::ended);
  if (phase_ == Phase::active && !fault_) {
    judge();
    follow_moves({time, q, ended_, halted_});
  }
  samples_.write(current_);
}

/// The server has the number and name of an alarm.
void ForwardLink::note_alarm(Cause cause) {
  const auto alarm = hses_.alarm();
  note(cause, alarm ? static_cast<int>(alarm->code) : 0, alarm ? alarm->name : std::string());
}

void ForwardLink::judge() {
  const HsesStatus& s = current_.status;
  if (s.alarm) return note_alarm(Cause::alarm);
  if (s.error) return note_alarm(Cause::error);
  if (s.teach) return note(Cause::teach_mode);
  if (!s.remote) return note(Cause::not_remote);
  if (s.pendant_hold) return note(Cause::hold, 1);
  if (s.external_hold) return note(Cause::hold, 2);
  if (s.command_hold && !holding_) return note(Cause::hold, 3);
  if (!s.servo) return note(Cause::servo_off);
  if (!holding_ && !s.running && now() - started_at_ > kStarting) return note(Cause::job_stopped);
  if (holding_ && s.running && now() - held_at_ > kHolding) return note(Cause::hold_ignored);
  const bool own = shared(SharedDoubles::put) == put_ && shared(SharedDoubles::output) == output_asked_ &&
                   shared(SharedDoubles::ended) <= put_;
  if (!own) note(Cause::moves_changed);
}

// --- what is sent ---------------------------------------------------------------------------------------

void ForwardLink::act() {
  if (cycles_seen_ == 0) return;
  if (halting_ == 0) find_order();
  steer_hold();
  if (!fault_) write_output();
  if (ordered_ && !fault_) send_order();
  if (halting_ != 0 && !fault_) await_halt();
}

/// Held, the robot comes to rest on its path. After it, the job goes on with the line under way, unless its
/// moves were forgotten.
void ForwardLink::steer_hold() {
  const auto share = moves_.slider();
  const bool wanted = share && !(*share > 0);
  if (wanted == holding_ || (holding_ && !has_stopped())) return;
  if (wanted) {
    if (!came(hses_.hold(true))) return;
    held_at_ = now();
  } else {
    if (!came(hses_.hold(false)) || !came(hses_.start_job())) return;
    started_at_ = now();
  }
  holding_ = wanted;
}

bool ForwardLink::has_stopped() const {
  return still_readings_ >= kStillReadings;
}

/// The robot stands: the job begins again at its first line when it is started, and has no move. A very slow
/// robot can seem to stand while it still slows down: the controller refuses then, and is asked again.
void ForwardLink::await_halt() {
  if (!holding_ || !has_stopped()) return;
  forgotten_ = true;
  if (!came(hses_.set_double(SharedDoubles::ended, put_))) return;
  const bool selected = hses_.select_job(kMovesJob);
  const Hses::Failure& why = hses_.failure();
  if (!selected && why.cause == Cause::hses_refused && why.detail == kRobotMoves) return;
  if (!came(selected)) return;
  halted_ = halting_;
  halting_ = 0;
}

void ForwardLink::send_order() {
  switch (order_.kind) {
    case MoveOrder::Kind::halt:
      halting_ = order_.number;
      break;
    case MoveOrder::Kind::tool:
      if (!check_tool()) return;
      break;
    case MoveOrder::Kind::move:
      // An output that was wanted before the move is switched before it.
      if (output_asked_ != shared(SharedDoubles::output_done) && ended_ == put_) return;
      if (!send_move()) return;
      break;
    case MoveOrder::Kind::nothing:
      break;
  }
  ordered_ = false;
}

/// Its number goes out last: then everything else is there.
bool ForwardLink::send_move() {
  const JobMove move = job_move(order_, moves_.frame());
  const int odd = order_.number % 2;
  const int place = odd * SharedMove::places, integer = odd * SharedMove::integers;
  const auto set_place = [&](int number, const Six& q) {
    HsesPosition out;
    out.tool = static_cast<std::uint32_t>(settings_.tool_number);
    out.values = pulses_of(q, settings_.pulses);
    return came(hses_.set_place(number + place, out));
  };
  const bool arc = move.kind == JobMove::arc;
  const bool well =
      set_place(SharedMove::end, move.end) &&
      (!arc || (set_place(SharedMove::via, move.via) && set_place(SharedMove::begin, move.begin))) &&
      came(hses_.set_integer(SharedMove::kind + integer, move.kind)) &&
      came(hses_.set_integer(SharedMove::speed + integer, move.speed)) &&
      came(hses_.set_integer(SharedMove::ramp + integer, move.ramp)) &&
      came(hses_.set_double(SharedDoubles::put, order_.number));
  if (!well) return false;
  put_ = order_.number;
  forgotten_ = false;
  return true;
}

/// The controller cannot be given a tool: that of its file must be that of the cell. Where the TCP is also
/// shows wrong pulses and a wrong model.
bool ForwardLink::check_tool() {
  const auto position = hses_.pose();
  if (!came(position)) return false;
  if (static_cast<int>(position->tool) != settings_.tool_number) {
    note(Cause::tool_number, static_cast<int>(position->tool), std::to_string(settings_.tool_number));
    return false;
  }
  Pose there = pose_of(*position);
  there.position.z += settings_.base_height;
  const Pose here = forward::tcp_at(current_.q, order_.tool, moves_.frame());
  const Vec3 way = there.position - here.position;
  const double turn = angle_between(there.rotation, here.rotation);
  if (norm(way) < kSameTool && turn < kSameTurn) return true;
  note(Cause::tool_differs, static_cast<int>(std::lround(1000 * norm(way))),
       fmt::format("x {:.0f}, y {:.0f}, z {:.0f} mm, turned by {:.1f} degrees", 1000 * way.x, 1000 * way.y,
                   1000 * way.z, turn * wire::kDegrees));
  return false;
}

/// The job switches one output at a time, between two moves. Only what changed is written: somebody at the
/// pendant may have switched the others.
void ForwardLink::write_output() {
  if (output_asked_ != shared(SharedDoubles::output_done)) return;
  for (int k = 0; k < settings_.outputs.count; ++k) {
    const int i = (output_next_ + k) % settings_.outputs.count;
    const auto at = static_cast<std::size_t>(i);
    if (!std::isfinite(wanted_.digital[at])) continue;
    const double wanted = wanted_.digital[at] > 0.5 ? 1 : 0;
    if (wanted == written_.digital[at]) continue;
    if (!came(hses_.set_integer(kOutputNumber, settings_.outputs.first + i)) ||
        !came(hses_.set_integer(kOutputValue, static_cast<int>(wanted))) ||
        !came(hses_.set_double(SharedDoubles::output, output_asked_ + 1)))
      return;
    written_.digital[at] = wanted;
    ++output_asked_;
    output_next_ = i + 1;
    return;
  }
}

/// Whatever ended the link, nothing goes on by itself at the controller. What it refuses does not keep the
/// rest from being done. A robot that does not stop keeps its hold, and the heartbeat has ended.
void ForwardLink::end() {
  const Nanoseconds time = realtime::monotonic_now();
  if (end_ == End::hold) {
    hses_.hold(true);
    ending_since_ = time;
    still_readings_ = 0;
    end_ = End::standing;
    return;
  }
  over_ = time - ending_since_ > kToStand;
  if (!has_stopped() || !hses_.set_double(SharedDoubles::ended, shared(SharedDoubles::put)) ||
      !hses_.select_job(kMovesJob))
    return;
  session_open_ = holding_ = false;
  if (write_beat()) hses_.hold(false);
  end_ = End::over;
  over_ = true;
}

}  // namespace polyarm::yaskawa
