#pragma once
/// State machine of jogging for one robot, and the dead-man rule. The state says which controllers the joints
/// follow. Pure functions.
#include <cstdint>

#include "polyarm/base/time.hpp"

namespace polyarm::cell {

enum class JogPhase : std::uint8_t {
  idle,       ///< the joints follow their usual controllers
  switching,  ///< the jog controller is being switched in
  moving,     ///< the joints follow the jog controller
  releasing   ///< the usual controllers are being switched back in
};

enum class JogChange : std::uint8_t {
  asked,     ///< a client wants to jog the robot
  switched,  ///< the controller switch is done
  refused,   ///< the controller switch was refused
  expired,   ///< no command renews the motion, and the robot is at rest
  lost       ///< the jog controller was deactivated or unloaded from outside
};

/// The state after `step`. A step without meaning in the current state changes nothing.
constexpr JogPhase next(JogPhase state, JogChange step) noexcept {
  switch (state) {
    case JogPhase::idle:
      return step == JogChange::asked ? JogPhase::switching : state;
    case JogPhase::switching:
      if (step == JogChange::switched) return JogPhase::moving;
      return step == JogChange::refused || step == JogChange::lost ? JogPhase::idle : state;
    case JogPhase::moving:
      if (step == JogChange::expired) return JogPhase::releasing;
      return step == JogChange::lost ? JogPhase::idle : state;
    case JogPhase::releasing:
      return step == JogChange::asked || step == JogChange::expired ? state : JogPhase::idle;
  }
  return state;
}

/// True while the joints follow the jog controller.
constexpr bool has_joints(JogPhase state) noexcept {
  return state == JogPhase::moving || state == JogPhase::releasing;
}

/// Dead-man rule: jogging continues only while it is renewed; each command is valid for `hold`.
class DeadMan {
 public:
  void renew(Nanoseconds now, Nanoseconds hold) { renewed_ = now, hold_ = hold; }
  /// Sets the last renewal to `ago` before now, with a hold time of 0.
  void release_now(Nanoseconds now, Nanoseconds ago) { renewed_ = now - ago, hold_ = 0; }
  /// True if the last renewal is older than `hold` plus `more`.
  bool expired(Nanoseconds now, Nanoseconds more = 0) const { return now - renewed_ > hold_ + more; }

 private:
  Nanoseconds renewed_ = 0, hold_ = 0;
};

}  // namespace polyarm::cell
