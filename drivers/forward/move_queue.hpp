#pragma once
/// What a driver does with moves whose controller pauses on demand and forgets its moves on demand: it hands
/// them over one by one, follows what becomes of them, pauses on the path and sends again what a pause left
/// over. Metres, radians, seconds.
#include <atomic>
#include <cstdint>
#include <optional>

#include "drivers/forward/move_buffer.hpp"
#include "drivers/forward/move_frame.hpp"

namespace polyarm::forward {

/// What the controller says in one of its cycles, or in an answer.
struct MoveReport {
  double time = 0;  ///< s, the controller's
  Six q{};          ///< rad
  int ended = 0;    ///< number of the newest move that ended
  int halted = 0;   ///< number of the newest halt that is done
};

/// What is to be sent next.
struct MoveOrder {
  /// `halt`: the robot stops, and the controller forgets its moves; `tool`: the TCP becomes `tool`.
  enum class Kind : std::uint8_t { nothing, move, halt, tool };
  Kind kind = Kind::nothing;
  int number = 0;  ///< of a move or a halt; counts up
  hardware::ForwardMove move;
  Six from{};                                 ///< joints where the move begins
  std::optional<hardware::ForwardMove> next;  ///< the move after it, if there is one
  Pose tool;                                  ///< T_flange_tcp
  double pace = 1;                            ///< of the move, if its controller has no override
};

/// ForwardMoves belongs to the control thread, the rest to the link's.
///
/// A pause sets the controller's override to 0, so that the robot comes to rest on its path. Once it stands,
/// the controller forgets its moves: nobody can set it in motion at the pendant. Going on sends what is left
/// again, from where the robot stands.
///
/// A controller without an override gets each move with its pace, and slider() is 0 or 1. Another pace stops
/// the robot on its path, and goes on with what is left: a lower one at once, a higher one when it stays.
class MoveQueue final : public hardware::ForwardMoves {
 public:
  enum class Paces : std::uint8_t { by_override, in_moves };
  /// `slots`: moves that the controller holds at a time, with the one under way.
  MoveQueue(MoveFrame frame, std::size_t slots, Paces paces = Paces::by_override)
      : frame_(std::move(frame)), slots_(slots), paces_(paces) {}
  const MoveFrame& frame() const { return frame_; }

  bool accept(const hardware::ForwardMove& move) noexcept override { return buffer_.accept(move); }
  void set_pace(double share) noexcept override { pace_.store(share); }
  void clear() noexcept override { buffer_.clear(); }
  hardware::ForwardFlow flow() const noexcept override;

  /// A program began on the controller: all moves and halts of before are forgotten. `last`: the report of
  /// now. Its numbers may be those of an earlier program for one more cycle, so new ones count on from them.
  void begin(const MoveReport& last);
  /// In each cycle of the controller, before the control thread hears of it.
  void take(const MoveReport& report);
  /// What to send now.
  MoveOrder next();
  /// The override, as a share; nothing: it stays as it is.
  std::optional<double> slider() const { return slider_; }
  /// For the programs after this one.
  void leave_slider(double share) { slider_ = share; }
  /// The joint that is elsewhere though the controller says that the move ended.
  std::optional<int> off_target() const { return off_target_; }
  /// True if the controller does not say that it has stopped the robot and forgotten its moves.
  bool awaits_halt_too_long() const;

 private:
  enum class Phase : std::uint8_t { running, slowing, halting, halted };

  void change_phase(bool stops, MoveOrder& out);
  void watch_pace(double pace);
  bool wants_another_pace() const;
  bool is_steady(double time) const { return report_.time - pace_since_ >= time; }
  void send(MoveOrder& out);
  bool sets_tool(const hardware::ForwardMove& move, MoveOrder& out);
  void take_back();

  MoveFrame frame_;
  std::size_t slots_;
  Paces paces_;
  MoveBuffer buffer_;
  std::atomic<double> pace_{0};                   // the control thread writes
  std::atomic<bool> still_{false}, held_{false};  // the link's thread writes

  // the link's thread
  MoveReport report_;
  Phase phase_ = Phase::running;
  Six place_{};  ///< about where the robot has been since moved_at_
  double moved_at_ = 0, slowing_since_ = 0, halting_since_ = 0;
  double steady_pace_ = 0, pace_since_ = 0, pace_asked_at_ = 0, sent_pace_ = 1;
  bool led_ = false;  ///< next() was called: rest is judged from there on, so that runs repeat themselves
  int number_ = 0, halts_ = 0;
  std::optional<Pose> tool_;
  std::optional<double> slider_;
  std::optional<int> off_target_;
};

}  // namespace polyarm::forward
