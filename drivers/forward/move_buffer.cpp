#include "drivers/forward/move_buffer.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::forward {

using hardware::ForwardMove;

namespace {

// Not a whole number of any controller's cycles, so that rounding decides nothing.
constexpr double kLanding = 3.0005;  // s, for the robot to be where a move ends
constexpr double kThere = 0.01;      // rad

}  // namespace

Six end_of(const ForwardMove& move) noexcept {
  Six out;
  std::copy_n(move.joints.begin(), 6, out.begin());
  return out;
}

double largest_difference(const Six& a, const Six& b) noexcept {
  double out = 0;
  for (std::size_t i = 0; i < 6; ++i) out = std::max(out, std::abs(a[i] - b[i]));
  return out;
}

bool MoveBuffer::accept(const ForwardMove& move) noexcept {
  if (clear_wanted_.load(std::memory_order_relaxed) != clear_done_.load(std::memory_order_acquire))
    return false;
  accepted_.fetch_add(1);  // first: what is in the queue counts as left
  if (queue_.push(move)) return true;
  accepted_.fetch_sub(1);
  return false;
}

void MoveBuffer::collect() {
  for (ForwardMove move; queue_.pop(move);) waiting_.push_back(move);
}

bool MoveBuffer::may_send(std::size_t most) const noexcept {
  if (waiting_.empty() || sent_.size() >= most) return false;
  if (!sent_.empty() && sent_.back().move.stops) return false;  // only when the robot was seen there
  return waiting_.front().stops || waiting_.size() > 1;         // the next move says how this one ends
}

void MoveBuffer::send(int number, const Six& from) {
  sent_.push_back({number, waiting_.front(), from});
  waiting_.pop_front();
}

/// A move that ends at rest is over when the robot is there, whenever the controller says so.
std::optional<int> MoveBuffer::land(const Six& q, bool still, double time) {
  while (!sent_.empty() && sent_.front().number <= ended_) {
    const ForwardMove& move = sent_.front().move;
    if (move.stops) {
      const Six end = end_of(move);
      const bool there = largest_difference(q, end) < kThere;
      if (!there && (!off_ || !still)) off_since_ = time;
      off_ = !there;
      if (off_ && time - off_since_ > kLanding) {
        std::size_t joint = 0;
        for (std::size_t i = 1; i < 6; ++i)
          if (std::abs(q[i] - end[i]) > std::abs(q[joint] - end[joint])) joint = i;
        return static_cast<int>(joint);
      }
      if (off_ || !still) return std::nullopt;
    }
    done_ = move.id;
    sent_.pop_front();
    finished_.fetch_add(1);
  }
  return std::nullopt;
}

void MoveBuffer::take_back() {
  for (; !sent_.empty(); sent_.pop_back()) waiting_.push_front(sent_.back().move);
  off_ = false;
}

void MoveBuffer::forget() {
  const std::uint32_t wanted = clear_wanted_.load(std::memory_order_acquire);
  collect();
  finished_.fetch_add(waiting_.size() + sent_.size());
  waiting_.clear();
  sent_.clear();
  off_ = false;
  ended_ = 0;
  clear_done_.store(wanted, std::memory_order_release);
}

}  // namespace polyarm::forward
