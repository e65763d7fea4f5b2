#pragma once
/// What holds a jogged motion back.
#include <cstdint>

namespace polyarm::jog {

/// The cause that holds a motion back.
enum class JogHold : std::uint8_t {
  none,
  speed,        ///< a speed limit of a joint or of the TCP
  singularity,  ///< damped, joint by joint, or blocked
  direction,    ///< the arm has too few joints for this direction
  joint_limit,  ///< which(): the joint
  workspace,    ///< which(): the zone
  body,         ///< something is near; which(): as the barrier says
};
inline constexpr int kJogHolds = 7;
/// "joint limit"
const char* name(JogHold hold);

}  // namespace polyarm::jog
