#pragma once
#include "drivers/forward/move_frame.hpp"
#include "tests/support/forward_moves.hpp"
#include "tests/yaskawa/rig.hpp"

namespace polyarm::test {

inline constexpr Nanoseconds kForwardPeriod = 16'000'000;

/// The flange of a GP7, as the driver has it.
inline const kinematics::Chain& yaskawa_chain() {
  static const kinematics::Chain chain(yaskawa_model(), forward::tool_flange(yaskawa_model(), 0));
  return chain;
}

class YaskawaMoveRig : public YaskawaRig {
 public:
  explicit YaskawaMoveRig(Parameters parameters = {}) : YaskawaRig(std::move(parameters), kForwardPeriod) {}
  static const kinematics::Chain& chain() { return yaskawa_chain(); }
};

/// The driver on its simulated controller, with moves for it.
using YaskawaForwardRig = ForwardMoveRig<YaskawaMoveRig>;

}  // namespace polyarm::test
