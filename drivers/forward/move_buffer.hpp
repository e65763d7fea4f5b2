#pragma once
/// The moves of the runtime in a driver whose controller interpolates (forward mode): from accept() until the
/// robot is where each one ends. Radians, seconds.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>

#include "drivers/wire/shaper.hpp"
#include "polyarm/hardware/forward_moves.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::forward {

using wire::Six;

Six end_of(const hardware::ForwardMove& move) noexcept;
double largest_difference(const Six& a, const Six& b) noexcept;

/// The control thread hands moves over; the link's thread sends them in their order and finds out when each
/// one has ended. Between the two there is no lock.
class MoveBuffer {
 public:
  struct Sent {
    int number = 0;  ///< at the controller; counts up
    hardware::ForwardMove move;
    Six from{};
  };

  // --- control thread; nothing waits, locks or allocates ---
  /// False: there is no room, or a clear() is not done.
  bool accept(const hardware::ForwardMove& move) noexcept;
  void clear() noexcept { clear_wanted_.fetch_add(1); }
  /// Nothing is left to do: moves, or clear().
  bool idle() const noexcept { return accepted_ == finished_ && clear_wanted_ == clear_done_; }
  /// Id of the newest move that has ended.
  std::uint64_t done() const noexcept { return done_; }

  // --- the link's thread ---
  bool clearing() const noexcept { return clear_wanted_.load(std::memory_order_acquire) != clear_done_; }
  /// Takes over what was accepted.
  void collect();
  const std::deque<hardware::ForwardMove>& waiting() const noexcept { return waiting_; }
  const std::deque<Sent>& sent() const noexcept { return sent_; }
  /// The first waiting move was sent as `number`, and begins at the joints `from` (kept in Sent).
  void send(int number, const Six& from);
  /// True if the first waiting move may be sent: fewer than `most` moves are sent and not over, the last of
  /// them does not end at rest, and if the waiting one blends, the move after it waits too.
  bool may_send(std::size_t most) const noexcept;
  /// The controller says that all moves up to this number have ended.
  void end_up_to(int number) noexcept { ended_ = std::max(ended_, number); }
  /// Finds the moves that are over: ended at the controller, and if a move ends at rest, the robot stands
  /// within 0.01 rad of that end. Returns the joint that is farthest from it once the robot has stood
  /// elsewhere for 3 s. `time`: s, of any one clock.
  std::optional<int> land(const Six& q, bool still, double time);
  /// The controller has forgotten its moves: what it did not end waits again, and the first of them begins
  /// somewhere on its path.
  void take_back();
  Sent* first_sent() noexcept { return sent_.empty() ? nullptr : &sent_.front(); }
  /// All moves are forgotten, and every clear() up to now is done.
  void forget();

 private:
  realtime::Queue<hardware::ForwardMove> queue_{64};
  // the control thread writes
  std::atomic<std::uint64_t> accepted_{0};
  std::atomic<std::uint32_t> clear_wanted_{0};
  // the link's thread writes
  std::atomic<std::uint64_t> finished_{0}, done_{0};
  std::atomic<std::uint32_t> clear_done_{0};
  // the link's thread
  std::deque<hardware::ForwardMove> waiting_;
  std::deque<Sent> sent_;
  int ended_ = 0;
  bool off_ = false;
  double off_since_ = 0;
};

}  // namespace polyarm::forward
