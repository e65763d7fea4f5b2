/// What the link in forward mode does while it is open: the thread that asks, judges and sends.
#include "drivers/kuka/forward_link.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/kuka/move_shape.hpp"
#include "drivers/wire/six_axes.hpp"

namespace polyarm::kuka {

using forward::MoveOrder;

namespace {

constexpr int kAsksOfRound = 8;            // requests of one round
constexpr double kFarthestAngle = 36'000;  // degrees

}  // namespace

/// At least one answer: each of them has the whole state.
void ForwardLink::round() {
  for (int i = 0; i < kAsksOfRound && !gone_ && ask_next(i > 0); ++i) {
  }
}

/// False: nothing is to be asked, or there was no answer.
bool ForwardLink::ask_next(bool asked) {
  const Phase phase = phase_;
  if (phase == Phase::ending || (phase == Phase::active && fault_)) {
    if (!end_heard_ && ask_end()) return true;
  } else if (phase == Phase::active && cycles_seen_ > 0) {
    find_order();
    // The override goes out before the order: a move begins at its pace.
    if (ask_override() || ask_order() || ask_output()) return !fault_;
  }
  return !asked && ask(EkiDo::state);
}

bool ForwardLink::ask(EkiDo what, int number, int value, const std::optional<EkiMove>& move) {
  const auto reply = eki_.ask(what, number, value, move);
  if (!reply) {
    gone_ = true;
    note(eki_.failure().cause, 0, eki_.failure().text);
    return false;
  }
  take(*reply);
  if (reply->result == EkiResult::done || fault_ || phase_ != Phase::active) return true;
  const bool of_moves = what == EkiDo::move || what == EkiDo::halt || what == EkiDo::tool;
  if (of_moves) note(Cause::moves_refused, static_cast<int>(reply->result));
  if (what == EkiDo::output) note(Cause::output_refused, number);
  return true;
}

/// A person at the smartPAD may lower the override until the pace changes. While the robot slows down to
/// rest, one that is raised is set to 0 again.
bool ForwardLink::ask_override() {
  const auto wanted = wanted_percent();
  if (!wanted) return false;
  const bool raised = *wanted == 0 && percent_ == 0 && current_.state.speed_override > 0;
  if (*wanted == percent_ && !raised) return false;
  percent_ = *wanted;
  ask(EkiDo::speed_override, 0, percent_);
  return true;
}

bool ForwardLink::ask_order() {
  if (!ordered_) return false;
  ordered_ = false;
  switch (order_.kind) {
    case MoveOrder::Kind::move:
      ask(EkiDo::move, order_.number, session_, eki_move(order_, moves_.frame()));
      return true;
    case MoveOrder::Kind::halt:
      ask(EkiDo::halt, order_.number, session_);
      return true;
    case MoveOrder::Kind::tool:
      ask(EkiDo::tool, 0, session_, eki_tool(order_.tool));
      return true;
    case MoveOrder::Kind::nothing:
      return false;
  }
  return false;
}

/// Only what changed is written: somebody at the smartPAD may have switched the others.
bool ForwardLink::ask_output() {
  for (int i = 0; i < settings_.outputs.count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (!std::isfinite(wanted_.digital[at])) continue;
    const double wanted = wanted_.digital[at] > 0.5 ? 1.0 : 0.0;
    if (wanted == written_.digital[at]) continue;
    written_.digital[at] = wanted;
    ask(EkiDo::output, settings_.outputs.first + i, static_cast<int>(wanted));
    return true;
  }
  return false;
}

/// Whatever ended the link, nothing goes on by itself at the controller.
bool ForwardLink::ask_end() {
  if (!end_asked_) {
    end_asked_ = true;
    return ask(EkiDo::end, 0, session_);
  }
  if (current_.state.moves && current_.state.session == session_) return false;
  end_heard_ = true;
  over_ = true;
  if (fault_ || !percent_before_) return false;
  const int before = *percent_before_;
  percent_before_.reset();
  return ask(EkiDo::speed_override, 0, before);
}

void ForwardLink::take(const EkiReply& reply) {
  const EkiState& s = reply.state;
  Six q;
  for (std::size_t i = 0; i < 6; ++i) q[i] = s.axes[i] * wire::kRadians;
  if (std::any_of(s.axes.begin(), s.axes.end(), [](double a) { return std::abs(a) > kFarthestAngle; }))
    return note(Cause::eki_bad_data);
  const auto step = static_cast<std::int32_t>(static_cast<std::uint32_t>(s.time_ms) -
                                              static_cast<std::uint32_t>(current_.state.time_ms));
  if (current_.count == 0) time_ms_ = 0;
  if (current_.count > 0 && step > 0) {
    time_ms_ += step;
    for (std::size_t i = 0; i < 6; ++i) current_.dq[i] = (q[i] - current_.q[i]) * 1000 / step;
  }
  if (current_.count == 0 || step != 0) current_.q = q;
  current_.state = s;
  ++current_.count;
  if (phase_ == Phase::active && !fault_) {
    judge(s);
    follow_moves(report());
  }
  samples_.write(current_);
}

forward::MoveReport ForwardLink::report() const {
  return {static_cast<double>(time_ms_) / 1000, current_.q, current_.state.ended, current_.state.halted};
}

void ForwardLink::judge(const EkiState& state) {
  int detail = 0;
  Cause cause = safety_cause(state, detail);
  if (cause == Cause::none) cause = program_cause(state);
  if (cause == Cause::none && !(state.moves && state.session == session_)) cause = Cause::moves_ended;
  if (cause != Cause::none) note(cause, detail);
}

}  // namespace polyarm::kuka
