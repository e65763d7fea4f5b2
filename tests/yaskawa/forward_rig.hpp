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

inline constexpr double kStandsWithin = 2e-4;  // rad: a robot that moves by less counts as standing

/// What a person does at the controller. The servos stay off.
inline void repair(FarSide& far) {
  for (const char* order : {"release", "reset", "unhold", "remote", "healthy"}) far.order(order);
}

inline void expect_at(YaskawaForwardRig& rig, const Six& q, double within) {
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], q[j], within) << "joint " << j;
}

}  // namespace polyarm::test
