#pragma once
#include <algorithm>
#include <optional>

#include "drivers/forward/move_frame.hpp"
#include "drivers/forward/near_joints.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "tests/kuka/rig.hpp"
#include "tests/support/forward_calls.hpp"

namespace polyarm::test {

/// The flange of a KR 10, as the driver has it.
inline const kinematics::Chain& kuka_chain() {
  static const kinematics::Chain chain(kuka_model(), forward::tool_flange(kuka_model(), 0));
  return chain;
}

/// The driver on its simulated controller, with moves for it.
class ForwardRig : public ForwardCalls<KukaRig> {
 public:
  using ForwardCalls::ForwardCalls;
  /// A joint move to where the robot is, with joint 1 moved by so much.
  hardware::ForwardMove turn(double by, double blend = 0) {
    hardware::ForwardMove out;
    Six q = target ? *target : this->q();
    q[0] += by;
    out.share = 0.5;
    return to(out, q, kuka_chain().forward(q), blend);
  }
  /// A line of the flange by so much.
  hardware::ForwardMove shift(const Vec3& by, double blend = 0) {
    hardware::ForwardMove out;
    out.kind = hardware::ForwardMove::Kind::line;
    const Six from = target ? *target : q();
    Pose at = kuka_chain().forward(from);
    at.position = at.position + by;
    const auto jacobian = [](const Six& one, std::array<double, 36>& J) {
      return kuka_chain().jacobian(one, J);
    };
    return to(out, *forward::near_joints(jacobian, at, from), at, blend);
  }
  /// Half a circle upwards.
  hardware::ForwardMove arc() {
    const Pose from = kuka_chain().forward(q());
    hardware::ForwardMove out = shift({0, -0.2, 0});
    out.kind = hardware::ForwardMove::Kind::arc;
    out.via = from;
    out.via.position = from.position + Vec3{0, -0.1, 0.1};
    return out;
  }
  Vec3 place() { return kuka_chain().forward(q()).position; }
  int override_percent() {
    return far().with([](kuka::Machine& machine) { return machine.speed_override(); });
  }
  std::optional<Six> target;

 private:
  hardware::ForwardMove to(hardware::ForwardMove out, const Six& q, const Pose& at, double blend) {
    target = q;
    std::copy(q.begin(), q.end(), out.joints.begin());
    out.id = ++id;
    out.at = at;
    out.speed = 0.25;
    out.blend = blend;
    out.stops = !(blend > 0);
    return out;
  }
};

}  // namespace polyarm::test
