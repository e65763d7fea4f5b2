#pragma once
#include "drivers/forward/move_frame.hpp"
#include "tests/abb/rig.hpp"
#include "tests/support/forward_moves.hpp"

namespace polyarm::test {

/// The flange of an IRB 120, as the driver has it.
inline const kinematics::Chain& abb_chain() {
  static const kinematics::Chain chain(abb_model(), forward::tool_flange(abb_model(), 0));
  return chain;
}

class AbbMoveRig : public AbbRig {
 public:
  using AbbRig::AbbRig;
  static const kinematics::Chain& chain() { return abb_chain(); }
};

/// The driver on its simulated controller, with moves for it.
using ForwardRig = ForwardMoveRig<AbbMoveRig>;

}  // namespace polyarm::test
