#pragma once
/// Whose commands the joints of a robot follow while people jog it: the states of a robot and what leads from
/// one to the next, and the dead-man rule. Pure.
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
  asked,     ///< somebody wants to jog the robot
  switched,  ///< the switch that was begun is done
  refused,   ///< it cannot be done
  expired,   ///< nothing renews the motion any more, and the robot stands
  lost       ///< somebody else has switched off or unloaded the jog controller
};

/// The state after `step`. A step that means nothing in a state changes nothing.
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

/// The joints follow the jog controller.
constexpr bool has_joints(JogPhase state) noexcept {
  return state == JogPhase::moving || state == JogPhase::releasing;
}

/// Motion by hand goes on only while it is renewed: each command is good for `hold`.
class DeadMan {
 public:
  void renew(Nanoseconds now, Nanoseconds hold) { renewed_ = now, hold_ = hold; }
  /// As if it had been renewed `ago`, and not since.
  void let_go(Nanoseconds now, Nanoseconds ago) { renewed_ = now - ago, hold_ = 0; }
  /// Nothing has renewed it for `hold`, and for `more` after that.
  bool expired(Nanoseconds now, Nanoseconds more = 0) const { return now - renewed_ > hold_ + more; }

 private:
  Nanoseconds renewed_ = 0, hold_ = 0;
};

}  // namespace polyarm::cell
