#pragma once
#include <algorithm>

#include "drivers/forward/move_frame.hpp"
#include "tests/support/forward_moves.hpp"
#include "tests/xarm/rig.hpp"

namespace polyarm::test {

/// The flange of an xArm 6, as the driver has it.
inline const kinematics::Chain& xarm_chain() {
  static const kinematics::Chain chain(xarm_model(), forward::tool_flange(xarm_model(), 0));
  return chain;
}

class XarmMoveRig : public XarmRig {
 public:
  using XarmRig::XarmRig;
  static const kinematics::Chain& chain() { return xarm_chain(); }
  wire::Six q() {
    const auto all = XarmRig::q();
    wire::Six out;
    std::copy_n(all.begin(), out.size(), out.begin());
    return out;
  }
};

/// The driver on its simulated controller, with moves for it.
class ForwardRig : public ForwardMoveRig<XarmMoveRig> {
 public:
  using ForwardMoveRig::ForwardMoveRig;
  int queued() {
    return far().with([](xarm::Machine& machine) { return machine.report().queued; });
  }
};

}  // namespace polyarm::test
