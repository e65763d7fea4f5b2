#pragma once
/// State machine of one leader and its follower. Pure functions.
#include <cmath>
#include <cstdint>

namespace polyarm::teleop {

enum class TeleopPhase : std::uint8_t {
  blocked,      ///< the clutch must be released first: at the start, and after the motion has ended by itself
  waiting,      ///< the clutch is released
  engaging,     ///< the clutch is held; the follower is being taken over
  approaching,  ///< the follower moves slowly to the leader's pose
  following
};
inline constexpr const char* kTeleopPhases[] = {"blocked", "waiting", "engaging", "approaching", "following"};

/// What one tick has seen.
struct TeleopSeen {
  bool held = false;     ///< the clutch
  bool leader = false;   ///< the leader's values are there and plausible
  bool allowed = true;   ///< the follower may be moved, and nobody has stopped it
  bool taken = false;    ///< the follower has been taken over
  bool matches = false;  ///< the follower is at the leader's pose, or need not be
};

/// The phase after a tick. Only a clutch that is pressed while everything is well begins a motion.
constexpr TeleopPhase next(TeleopPhase phase, const TeleopSeen& seen) noexcept {
  if (!seen.held) return TeleopPhase::waiting;
  if (phase == TeleopPhase::blocked || !seen.leader || !seen.allowed) return TeleopPhase::blocked;
  switch (phase) {
    case TeleopPhase::waiting:
      return TeleopPhase::engaging;
    case TeleopPhase::engaging:
      if (!seen.taken) return phase;
      return seen.matches ? TeleopPhase::following : TeleopPhase::approaching;
    case TeleopPhase::approaching:
      return seen.matches ? TeleopPhase::following : phase;
    default:
      return phase;
  }
}

constexpr bool moves(TeleopPhase phase) noexcept {
  return phase == TeleopPhase::approaching || phase == TeleopPhase::following;
}

/// A switch with play: on below `on`, off above `off`, else as before.
constexpr bool closed_with_play(bool was, double value, double on, double off) noexcept {
  return value < on || (was && value <= off);
}

/// Judges values of a leader that come in once a tick: they are plausible while they are finite and do not
/// jump.
class LeaderWatch {
 public:
  /// rad or m between two looks: more than a hand does.
  static constexpr double kJump = 0.35;
  void reset() noexcept { known_ = false; }
  /// Begins a look; then see() each joint.
  void begin() noexcept { good_ = true, jumped_ = false; }
  void see(double before, double now) noexcept {
    if (!std::isfinite(now)) good_ = false;
    if (known_ && std::abs(now - before) > kJump) jumped_ = true;
  }
  /// True if the values may be followed.
  bool end() noexcept {
    known_ = good_;
    return good_ && !jumped_;
  }
  bool finite() const noexcept { return good_; }
  bool jumped() const noexcept { return jumped_; }

 private:
  bool known_ = false, good_ = true, jumped_ = false;
};

}  // namespace polyarm::teleop
