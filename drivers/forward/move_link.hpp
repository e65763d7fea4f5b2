#pragma once
/// A link in forward mode whose controller is asked and answers, and gets the moves of a MoveQueue.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "drivers/forward/asking_link.hpp"
#include "drivers/forward/move_queue.hpp"

namespace polyarm::forward {

/// As an AskingLink; `Cause` also has off_target and halt_unconfirmed. moves() belongs to the control thread,
/// the rest to the link's.
template <class Base, class Cause, class Sample, class Outputs>
class MoveLink : public AskingLink<Base, Cause, Sample, Outputs> {
 public:
  MoveQueue& moves() noexcept { return moves_; }

 protected:
  /// How the controller takes moves; `slots`: those that it holds at a time.
  struct Moves {
    MoveFrame frame;
    std::size_t slots = 1;
    MoveQueue::Paces paces = MoveQueue::Paces::by_override;
  };
  template <class... Args>
  MoveLink(Moves moves, const AskingTimes& times, Args&&... args)
      : AskingLink<Base, Cause, Sample, Outputs>(times, std::forward<Args>(args)...),
        moves_(std::move(moves.frame), moves.slots, moves.paces) {}
  ~MoveLink() = default;

  /// A session begins, with the thread halted: nothing is left of an earlier one.
  void begin_queue(const MoveReport& last) {
    ordered_ = false;
    moves_.set_pace(0);
    moves_.begin(last);
  }
  /// What the robot did. It ends the link if the robot is not where a move ended, or does not stop.
  void follow_moves(const MoveReport& report) {
    moves_.take(report);
    if (const auto joint = moves_.off_target()) this->note(Cause::off_target, *joint);
    if (moves_.awaits_halt_too_long()) this->note(Cause::halt_unconfirmed);
  }
  /// Finds what to send next, unless an order still waits. The caller clears `ordered_` once it is sent.
  void find_order() {
    if (!ordered_) order_ = moves_.next();
    ordered_ = order_.kind != MoveOrder::Kind::nothing;
  }
  /// The override in whole per cent, 0 only at rest; nothing: it stays as it is.
  std::optional<int> wanted_percent() const {
    const auto share = moves_.slider();
    if (!share) return std::nullopt;
    return *share > 0 ? std::clamp(static_cast<int>(std::lround(100 * *share)), 1, 100) : 0;
  }

  MoveQueue moves_;
  // the thread's; others use them while it is halted
  MoveOrder order_;
  bool ordered_ = false;  ///< order_ is to be sent
};

}  // namespace polyarm::forward
