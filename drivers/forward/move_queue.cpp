#include "drivers/forward/move_queue.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::forward {

using hardware::ForwardMove;

namespace {

constexpr double kStill = 2e-4;  // rad: a robot that moves by less in kStillFor stands
// Times of the controller, s; none is a whole number of its cycles, so that rounding decides nothing.
constexpr double kStillFor = 0.0495;
constexpr double kPatience = 2.0005;  // for the override to bring the robot to rest; then it is stopped
constexpr double kHalting = 15.0005;  // for a stop from full speed with the least deceleration
// Of a pace that moves are sent with.
constexpr double kSteady = 0.0995, kRaised = 0.2995;  // that it stays, for a move, and to go faster
constexpr double kUnsteady = 1.0005;                  // after that a move is sent with any pace
constexpr double kSamePace = 0.02, kLower = 0.9, kHigher = 1.1;
constexpr int kMostNumber = 1'000'000'000;

bool same(const Pose& a, const Pose& b) {
  return norm(a.position - b.position) < 1e-6 && angle_between(a.rotation, b.rotation) < 1e-6;
}

}  // namespace

hardware::ForwardFlow MoveQueue::flow() const noexcept {
  hardware::ForwardFlow out;
  out.idle = buffer_.idle();
  out.done = buffer_.done();
  out.standing = still_.load() && (out.idle || (!(pace_.load() > 0) && held_.load()));
  return out;
}

void MoveQueue::begin(const MoveReport& last) {
  buffer_.forget();
  phase_ = Phase::running;
  led_ = false;
  still_ = held_ = false;
  steady_pace_ = 0;
  pace_since_ = pace_asked_at_ = last.time;
  number_ = std::clamp(last.ended, 0, kMostNumber);
  halts_ = std::clamp(last.halted, 0, kMostNumber);
  report_ = last;
  tool_.reset(), slider_.reset(), off_target_.reset();
}

void MoveQueue::take(const MoveReport& report) {
  report_ = report;
  if (!led_) return;
  if (largest_difference(report.q, place_) > kStill) {
    place_ = report.q;
    moved_at_ = report.time;
  }
  still_ = report.time - moved_at_ >= kStillFor;
  buffer_.end_up_to(report.ended);
  if (const auto joint = buffer_.land(report.q, still_, report.time)) off_target_ = joint;
}

MoveOrder MoveQueue::next() {
  if (!std::exchange(led_, true)) place_ = report_.q, moved_at_ = report_.time;
  held_ = false;  // cleared before the pace is read, because the robot may move from here on
  buffer_.collect();
  const double pace = pace_.load();
  const bool clears = buffer_.clearing();
  MoveOrder out;
  watch_pace(pace);
  change_phase(clears || !(pace > 0) || wants_another_pace(), out);
  if (phase_ == Phase::halted) {
    if (clears) buffer_.forget();
    held_ = !(pace > 0);
    if (pace > 0) phase_ = Phase::running;
  }
  if (phase_ == Phase::running) {
    slider_ = paces_ == Paces::in_moves ? 1 : std::clamp(pace, 0.0, 1.0);
    send(out);
  } else if (phase_ == Phase::slowing) {
    slider_ = 0;
  }
  return out;
}

void MoveQueue::change_phase(bool stops, MoveOrder& out) {
  switch (phase_) {
    case Phase::running:
      if (!stops) return;
      slowing_since_ = report_.time;
      phase_ = buffer_.sent().empty() ? Phase::halted : Phase::slowing;
      return;
    case Phase::slowing:
      if (!stops) {
        phase_ = Phase::running;
      } else if (still_ || report_.time - slowing_since_ > kPatience) {
        out.kind = MoveOrder::Kind::halt;
        out.number = ++halts_;
        halting_since_ = report_.time;
        phase_ = Phase::halting;
      }
      return;
    case Phase::halting:
      if (report_.halted != halts_ || !still_) return;
      take_back();
      phase_ = Phase::halted;
      return;
    case Phase::halted:
      return;
  }
}

void MoveQueue::watch_pace(double pace) {
  if (!(steady_pace_ > 0) && pace > 0) pace_asked_at_ = report_.time;
  if (pace > 0 && std::abs(pace - steady_pace_) <= kSamePace * pace) return;
  steady_pace_ = std::clamp(pace, 0.0, 1.0);
  pace_since_ = report_.time;
}

bool MoveQueue::wants_another_pace() const {
  if (paces_ != Paces::in_moves || buffer_.sent().empty()) return false;
  return steady_pace_ < kLower * sent_pace_ || (steady_pace_ > kHigher * sent_pace_ && is_steady(kRaised));
}

bool MoveQueue::awaits_halt_too_long() const {
  return phase_ == Phase::halting && report_.halted != halts_ && report_.time - halting_since_ > kHalting;
}

/// True if the TCP has to be set first; then it is set once the robot stands.
bool MoveQueue::sets_tool(const ForwardMove& move, MoveOrder& out) {
  const Pose tool = tool_of(move, frame_);
  if (tool_ && same(*tool_, tool)) return false;
  if (!buffer_.sent().empty() || !still_) return true;
  out.kind = MoveOrder::Kind::tool;
  out.tool = tool;
  tool_ = tool;
  return true;
}

void MoveQueue::send(MoveOrder& out) {
  if (!buffer_.may_send(slots_)) return;
  if (paces_ == Paces::in_moves && !is_steady(kSteady) && report_.time - pace_asked_at_ < kUnsteady) return;
  if (sets_tool(buffer_.waiting().front(), out)) return;
  out.kind = MoveOrder::Kind::move;
  out.pace = sent_pace_ = steady_pace_;
  out.number = ++number_;
  out.move = buffer_.waiting().front();
  out.from = buffer_.sent().empty() ? report_.q : end_of(buffer_.sent().back().move);
  if (buffer_.waiting().size() > 1) out.next = buffer_.waiting()[1];
  buffer_.send(number_, out.from);
}

/// What the controller did not end is to be sent again, from where the robot stands.
void MoveQueue::take_back() {
  if (MoveBuffer::Sent* first = buffer_.first_sent(); first && first->move.kind == ForwardMove::Kind::arc)
    shorten_arc(first->move, first->from, report_.q, frame_);
  buffer_.take_back();
}

}  // namespace polyarm::forward
