/// What the link in forward mode does while it is open: the thread that asks the program, judges and sends.
#include "drivers/abb/forward_link.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::abb {

using forward::MoveOrder;

namespace {

constexpr int kAsksOfRound = 8;                   // requests of one round
constexpr Nanoseconds kSuspicious = 100'000'000;  // without an answer, until the controller is asked why
constexpr double kMostArc = 235;                  // degrees, of MoveC: recalled is 240
constexpr Nanoseconds kLeastLook = 1'000'000;     // the least, at a socket where an answer may wait
constexpr std::chrono::milliseconds kOthers(300);  // for Robot Web Services to be free, to ask them why

/// A program that runs may be slow; warnings in the event log do not stop it.
bool stands_still(const RwsState& state) {
  return state.program != "running" || cause_of_state(state.control, state.mode) != Cause::none;
}

}  // namespace

/// At least one answer: each of them has the whole state.
void ForwardLink::round() {
  const Phase phase = phase_;
  if (phase == Phase::idle) return;
  if (phase == Phase::ending || fault_) return end_round();
  for (int i = 0; i < kAsksOfRound && !fault_ && ask_next(i > 0); ++i) {
  }
  if (fault_) end_round();
}

/// False: nothing more is to be asked.
bool ForwardLink::ask_next(bool asked) {
  if (cycles_seen_ > 0) {
    find_order();
    // The pace goes out before the order: a move begins at its pace.
    if (ask_pace() || ask_order()) return !fault_;
  }
  return !asked && ask({});
}

bool ForwardLink::ask(const MoveRequest& request) {
  const auto reply = port_.send(request) ? await_reply() : std::nullopt;
  if (!reply) {
    lose(port_.failure().cause == Cause::none ? Cause::moves_silent : port_.failure().cause);
    return false;
  }
  take(*reply);
  const bool refused = reply->result != MoveResult::done;
  if (refused && phase_ == Phase::active) note(Cause::moves_refused, static_cast<int>(reply->result));
  return !fault_;
}

/// A program that was stopped does not answer: the controller says so sooner than the time is over. An answer
/// that came while the controller was asked counts, however long that took.
std::optional<MoveReply> ForwardLink::await_reply() {
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.answer;
  while (true) {
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (auto reply = port_.await_reply(std::clamp(left, kLeastLook, kSuspicious))) return reply;
    if (port_.failure().cause != Cause::none || left <= 0 || is_stopped()) return std::nullopt;
  }
}

/// False also if Robot Web Services do not answer, or if others use them now.
bool ForwardLink::is_stopped() {
  const std::unique_lock lock(rws_mutex_, std::try_to_lock);
  RwsState state;
  return lock && rws_.read_state(state) && stands_still(state);
}

/// What the controller itself says of a program that stopped is more than that the program is gone.
void ForwardLink::lose(Cause otherwise) {
  Rws::Failure why;
  {
    const std::unique_lock lock(rws_mutex_, kOthers);
    RwsState state;
    const bool reached = lock && rws_.read_state(state);
    if (lock && !reached && otherwise != Cause::moves_bad_data) why = rws_.failure();
    if (reached && stands_still(state)) why = find_why(Sign::silence);
  }
  if (why.cause == Cause::none) why = {otherwise, 0, ""};
  note(why.cause, why.detail, why.text);
  port_.close();
}

bool ForwardLink::ask_pace() {
  const auto wanted = wanted_percent();
  if (!wanted || *wanted == percent_) return false;
  percent_ = *wanted;
  ask({0, MoveDo::pace, percent_, session_, {}, {}});
  return true;
}

bool ForwardLink::ask_order() {
  if (!ordered_) return false;
  ordered_ = false;
  MoveRequest request;
  request.value = session_;
  request.number = order_.number;
  switch (order_.kind) {
    case MoveOrder::Kind::move:
      request.what = MoveDo::move;
      request.move = rapid_move(order_, moves_.frame());
      if (request.move.angle > kMostArc) {
        note(Cause::arc_too_long, static_cast<int>(std::lround(request.move.angle)));
        return true;
      }
      break;
    case MoveOrder::Kind::halt:
      request.what = MoveDo::halt;
      break;
    case MoveOrder::Kind::tool:
      request.what = MoveDo::tool;
      request.move.end = frame_of(order_.tool);
      request.load = settings_.load;
      break;
    case MoveOrder::Kind::nothing:
      return false;
  }
  ask(request);
  return true;
}

/// Whatever ended the link, nothing goes on by itself at the controller.
void ForwardLink::end_round() {
  if (over_) return;
  if (port_.is_open()) {
    MoveRequest request;
    request.what = end_asked_ ? MoveDo::state : MoveDo::end;
    end_asked_ = true;
    const auto reply = port_.send(request) ? port_.await_reply(settings_.answer) : std::nullopt;
    if (reply) take(*reply);
    const bool heard = reply && reply->result == MoveResult::done;
    if (heard && reply->session == session_) return;  // the robot stops
    if (!heard) port_.close();
  }
  over_ = true;
}

void ForwardLink::take(const MoveReply& reply) {
  const int step = (reply.time_ms - newest_.time_ms + kMovesClock) % kMovesClock;
  const bool later = current_.count > 0 && step > 0 && step < kMovesClock / 2;
  const Six q = wire::scaled(reply.joints, wire::kRadians);
  if (later) {
    time_ms_ += step;
    for (std::size_t i = 0; i < 6; ++i) current_.dq[i] = (q[i] - current_.q[i]) * 1000 / step;
  }
  if (current_.count == 0 || step != 0) current_.q = q;
  newest_ = reply;
  ++current_.count;
  if (phase_ == Phase::active && !fault_) {
    judge(reply);
    follow_moves(report());
  }
  samples_.write(current_);
}

forward::MoveReport ForwardLink::report() const {
  return {static_cast<double>(time_ms_) / 1000, current_.q, newest_.ended, newest_.halted};
}

void ForwardLink::judge(const MoveReply& reply) {
  if (reply.version != kMovesVersion) return note(Cause::moves_version, reply.version);
  if (reply.error != 0) return note(Cause::move_failed, reply.error);
  if (reply.session != session_) note(Cause::moves_ended);
}

}  // namespace polyarm::abb
