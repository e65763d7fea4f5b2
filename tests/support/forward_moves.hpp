#pragma once
/// Moves for a driver in forward mode, from where the robot is or where the move before ends.
#include <algorithm>
#include <optional>

#include "drivers/forward/near_joints.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "tests/support/forward_calls.hpp"

namespace polyarm::test {

/// `Rig` has chain(), from the base to the flange, and q().
template <class Rig>
class ForwardMoveRig : public ForwardCalls<Rig> {
 public:
  using ForwardCalls<Rig>::ForwardCalls;
  /// A joint move by so much of joint 1.
  hardware::ForwardMove turn(double by, double blend = 0) {
    hardware::ForwardMove out;
    wire::Six q = target ? *target : this->q();
    q[0] += by;
    out.share = 0.5;
    return to(out, q, Rig::chain().forward(q), blend);
  }
  /// A line of the flange by so much.
  hardware::ForwardMove shift(const Vec3& by, double blend = 0) {
    hardware::ForwardMove out;
    out.kind = hardware::ForwardMove::Kind::line;
    const wire::Six from = target ? *target : this->q();
    Pose at = Rig::chain().forward(from);
    at.position = at.position + by;
    const auto jacobian = [](const wire::Six& one, std::array<double, 36>& J) {
      return Rig::chain().jacobian(one, J);
    };
    return to(out, *forward::near_joints(jacobian, at, from), at, blend);
  }
  /// Half a circle upwards, or to `by` past `via`.
  hardware::ForwardMove arc(const Vec3& by = {0, -0.2, 0}, const Vec3& via = {0, -0.1, 0.1}) {
    const Pose from = Rig::chain().forward(this->q());
    hardware::ForwardMove out = shift(by);
    out.kind = hardware::ForwardMove::Kind::arc;
    out.via = from;
    out.via.position = from.position + via;
    return out;
  }
  Vec3 place() { return Rig::chain().forward(this->q()).position; }
  std::optional<wire::Six> target;

 private:
  hardware::ForwardMove to(hardware::ForwardMove out, const wire::Six& q, const Pose& at, double blend) {
    target = q;
    std::copy(q.begin(), q.end(), out.joints.begin());
    out.id = ++this->id;
    out.at = at;
    out.speed = 0.25;
    out.blend = blend;
    out.stops = !(blend > 0);
    return out;
  }
};

}  // namespace polyarm::test
