#pragma once
#include "drivers/forward/move_frame.hpp"
#include "tests/kuka/rig.hpp"
#include "tests/support/forward_moves.hpp"

namespace polyarm::test {

/// The flange of a KR 10, as the driver has it.
inline const kinematics::Chain& kuka_chain() {
  static const kinematics::Chain chain(kuka_model(), forward::tool_flange(kuka_model(), 0));
  return chain;
}

class KukaMoveRig : public KukaRig {
 public:
  using KukaRig::KukaRig;
  static const kinematics::Chain& chain() { return kuka_chain(); }
};

/// The driver on its simulated controller, with moves for it.
class ForwardRig : public ForwardMoveRig<KukaMoveRig> {
 public:
  using ForwardMoveRig::ForwardMoveRig;
  int override_percent() {
    return far().with([](kuka::Machine& machine) { return machine.speed_override(); });
  }
};

}  // namespace polyarm::test
