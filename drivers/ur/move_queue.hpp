#pragma once
/// What the driver does with the moves of the runtime: it hands them to the controller one by one, follows
/// what becomes of them, pauses on the path and sends again what a pause left over. The link calls it.
#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>

#include "drivers/ur/move_shape.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::ur {

/// What the controller says in one of its cycles.
struct MoveReport {
  double time = 0;            ///< s, the controller's
  Six q{};                    ///< rad
  int ended = 0, halted = 0;  ///< numbers of the registers
};

/// ForwardMoves belongs to the control thread, the rest to the link's.
///
/// A pause sets the speed slider to 0, so that the robot comes to rest on its path. Once it stands, the
/// program forgets its moves: nobody can set it in motion at the pendant. Going on sends what is left again,
/// from where the robot stands.
class MoveQueue final : public hardware::ForwardMoves {
 public:
  explicit MoveQueue(MoveFrame frame) : frame_(std::move(frame)) {}

  bool accept(const hardware::ForwardMove& move) noexcept override;
  void set_pace(double share) noexcept override { pace_.store(share); }
  void clear() noexcept override { clear_wanted_.fetch_add(1); }
  hardware::ForwardFlow flow() const noexcept override;

  /// A program began on the controller: nothing is left of what was wanted before. `last`: what the registers
  /// have from an earlier program, perhaps for one more cycle.
  void begin(const MoveReport& last);
  /// In each cycle of the controller, before the control thread hears of it.
  void take(const MoveReport& report);
  /// What to send now; its sequence and time-out are left open.
  MoveMessage next();
  /// The speed slider, as a share; nothing: it stays as it is.
  std::optional<double> slider() const { return slider_; }
  /// For the programs after this one.
  void leave_slider(double share) { slider_ = share; }
  /// The joint that is elsewhere though the controller says that the move ended.
  std::optional<int> off_target() const { return off_target_; }
  /// True if the program does not say that it has stopped the robot and forgotten its moves.
  bool awaits_halt_too_long() const;

 private:
  enum class Phase : std::uint8_t { running, slowing, halting, halted };
  struct Sent {
    int number = 0;
    hardware::ForwardMove move;
    Six from{};
  };

  void land();
  void change_phase(bool stops, MoveMessage& out);
  void send(MoveMessage& out);
  bool sets_tool(const hardware::ForwardMove& move, MoveMessage& out);
  void take_back();
  void forget();

  MoveFrame frame_;
  realtime::Queue<hardware::ForwardMove> queue_{64};
  // the control thread writes
  std::atomic<double> pace_{0};
  std::atomic<std::uint64_t> accepted_{0};
  std::atomic<std::uint32_t> clear_wanted_{0};
  // the link's thread writes
  std::atomic<std::uint64_t> finished_{0}, done_{0};
  std::atomic<std::uint32_t> clear_done_{0};
  std::atomic<bool> still_{false}, held_{false};

  // the link's thread
  std::deque<hardware::ForwardMove> moves_;
  std::deque<Sent> sent_;
  MoveReport report_;
  Phase phase_ = Phase::running;
  Six place_{};  ///< about where the robot has been since moved_at_
  double moved_at_ = 0, slowing_since_ = 0, halting_since_ = 0, off_since_ = 0;
  bool led_ = false;  ///< the loop has commanded: what counts begins there, and so in each run alike
  bool off_ = false;
  int number_ = 0, halts_ = 0;
  std::optional<Pose> tool_;
  std::optional<double> slider_;
  std::optional<int> off_target_;
};

}  // namespace polyarm::ur
