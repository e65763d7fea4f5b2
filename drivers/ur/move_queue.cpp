#include "drivers/ur/move_queue.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::ur {

using hardware::ForwardMove;

namespace {

constexpr double kStill = 2e-4;  // rad: a robot that moves by less in kStillFor stands
// Times of the controller, s; none is a whole number of its cycles, so that rounding decides nothing.
constexpr double kStillFor = 0.0495;
constexpr double kPatience = 2.0005;  // for the slider to bring the robot to rest; then it is stopped
constexpr double kHalting = 15.0005;  // for `stopj` from full speed with the least deceleration
constexpr double kLanding = 3.0005;   // for the robot to be where a move ends
constexpr double kThere = 0.01;       // rad
constexpr int kMostNumber = 1'000'000'000;

double largest_difference(const Six& a, const Six& b) {
  double out = 0;
  for (std::size_t i = 0; i < 6; ++i) out = std::max(out, std::abs(a[i] - b[i]));
  return out;
}

Six end_of(const ForwardMove& move) {
  Six out;
  std::copy_n(move.joints.begin(), 6, out.begin());
  return out;
}

bool same(const Pose& a, const Pose& b) {
  return norm(a.position - b.position) < 1e-6 && angle_between(a.rotation, b.rotation) < 1e-6;
}

}  // namespace

// --- control thread -------------------------------------------------------------------------------------

bool MoveQueue::accept(const ForwardMove& move) noexcept {
  if (clear_wanted_.load(std::memory_order_relaxed) != clear_done_.load(std::memory_order_acquire))
    return false;
  accepted_.fetch_add(1);  // first: what is in the queue counts as left
  if (queue_.push(move)) return true;
  accepted_.fetch_sub(1);
  return false;
}

hardware::ForwardFlow MoveQueue::flow() const noexcept {
  hardware::ForwardFlow out;
  out.idle = accepted_.load() == finished_.load() && clear_wanted_.load() == clear_done_.load();
  out.done = done_.load();
  out.standing = still_.load() && (out.idle || (!(pace_.load() > 0) && held_.load()));
  return out;
}

// --- the link's thread ----------------------------------------------------------------------------------

void MoveQueue::begin(const MoveReport& last) {
  forget();
  phase_ = Phase::running;
  led_ = off_ = false;
  still_ = held_ = false;
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
  land();
}

/// A move that ends at rest is over when the robot is there, whenever the controller says so.
void MoveQueue::land() {
  while (!sent_.empty() && sent_.front().number <= report_.ended) {
    const ForwardMove& move = sent_.front().move;
    if (move.stops) {
      const Six end = end_of(move);
      const bool there = largest_difference(report_.q, end) < kThere;
      if (!there && (!off_ || !still_)) off_since_ = report_.time;
      off_ = !there;
      if (off_ && report_.time - off_since_ > kLanding) {
        int joint = 0;
        for (int i = 1; i < 6; ++i) {
          const auto off = [&](int j) {
            const auto at = static_cast<std::size_t>(j);
            return std::abs(report_.q[at] - end[at]);
          };
          if (off(i) > off(joint)) joint = i;
        }
        off_target_ = joint;
      }
      if (off_ || !still_) return;
    }
    done_ = move.id;
    sent_.pop_front();
    finished_.fetch_add(1);
  }
}

MoveMessage MoveQueue::next() {
  if (!std::exchange(led_, true)) place_ = report_.q, moved_at_ = report_.time;
  held_ = false;  // cleared before the pace is read, because the robot may move from here on
  for (ForwardMove move; queue_.pop(move);) moves_.push_back(move);
  const double pace = pace_.load();
  const bool clears = clear_wanted_.load(std::memory_order_acquire) != clear_done_.load();
  MoveMessage out;
  change_phase(clears || !(pace > 0), out);
  if (phase_ == Phase::halted) {
    if (clears) forget();
    held_ = !(pace > 0);
    if (pace > 0) phase_ = Phase::running;
  }
  if (phase_ == Phase::running) {
    slider_ = std::clamp(pace, 0.0, 1.0);
    send(out);
  } else if (phase_ == Phase::slowing) {
    slider_ = 0;
  }
  return out;
}

void MoveQueue::change_phase(bool stops, MoveMessage& out) {
  switch (phase_) {
    case Phase::running:
      if (!stops) return;
      slowing_since_ = report_.time;
      phase_ = sent_.empty() ? Phase::halted : Phase::slowing;
      return;
    case Phase::slowing:
      if (!stops) {
        phase_ = Phase::running;
      } else if (still_ || report_.time - slowing_since_ > kPatience) {
        out.work = Work::halt;
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

bool MoveQueue::awaits_halt_too_long() const {
  return phase_ == Phase::halting && report_.halted != halts_ && report_.time - halting_since_ > kHalting;
}

/// True if the TCP has to be set first; then it is set once the robot stands.
bool MoveQueue::sets_tool(const ForwardMove& move, MoveMessage& out) {
  const Pose tool = tool_of(move, frame_);
  if (tool_ && same(*tool_, tool)) return false;
  if (!sent_.empty() || !still_) return true;
  out = tool_message(tool);
  tool_ = tool;
  return true;
}

void MoveQueue::send(MoveMessage& out) {
  if (moves_.empty() || sent_.size() >= kMoveSlots) return;
  if (!sent_.empty() && sent_.back().move.stops) return;  // only when the robot was seen there
  const ForwardMove& next = moves_.front();
  if (!next.stops && moves_.size() < 2) return;  // the next move says how this one ends
  if (sets_tool(next, out)) return;
  const Six from = sent_.empty() ? report_.q : end_of(sent_.back().move);
  out = message_of(next, from, moves_.size() > 1 ? &moves_[1] : nullptr, frame_);
  out.number = ++number_;
  sent_.push_back({number_, next, from});
  moves_.pop_front();
}

/// The program has forgotten its moves; what it did not end is to be sent again, from where the robot stands.
void MoveQueue::take_back() {
  if (!sent_.empty() && sent_.front().move.kind == ForwardMove::Kind::arc)
    shorten_arc(sent_.front().move, sent_.front().from, report_.q, frame_);
  for (; !sent_.empty(); sent_.pop_back()) moves_.push_front(sent_.back().move);
  off_ = false;
}

void MoveQueue::forget() {
  const std::uint32_t wanted = clear_wanted_.load(std::memory_order_acquire);
  for (ForwardMove move; queue_.pop(move);) moves_.push_back(move);
  finished_.fetch_add(moves_.size() + sent_.size());
  moves_.clear();
  sent_.clear();
  off_ = false;
  clear_done_.store(wanted, std::memory_order_release);
}

}  // namespace polyarm::ur
