#pragma once
#include <algorithm>
#include <optional>
#include <thread>

#include "drivers/forward/near_joints.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "tests/support/forward_calls.hpp"
#include "tests/ur/rig.hpp"

namespace polyarm::test {

/// The flange of a UR5e, as the driver has it.
inline const kinematics::Chain& ur_chain() {
  static const kinematics::Chain chain = [] {
    const description::RobotModel& model = ur_model();
    int tip = 0;
    for (std::size_t i = 0; i < model.links.size(); ++i)
      if (model.links[i].name == "tool0") tip = static_cast<int>(i);
    return kinematics::Chain(model, tip);
  }();
  return chain;
}

inline void expect_standing_of(FarSide& far) {
  const auto at = [&] { return far.with([](ur::Machine& machine) { return machine.q(); }); };
  for (int i = 0; i < 500; ++i) far.step();
  const ur::Six stopped = at();
  for (int i = 0; i < 200; ++i) far.step();
  EXPECT_EQ(at(), stopped);
}

/// The driver on its simulated controller, with moves for it.
class ForwardRig : public ForwardCalls<UrRig> {
 public:
  using ForwardCalls::ForwardCalls;
  /// A joint move to where the robot is, with joint 1 moved by so much.
  hardware::ForwardMove turn(double by, double blend = 0) {
    hardware::ForwardMove out;
    ur::Six q = target ? *target : this->q();
    q[0] += by;
    out.share = 0.5;
    return to(out, q, ur_chain().forward(q), blend);
  }
  /// A line of the flange by so much.
  hardware::ForwardMove shift(const Vec3& by, double blend = 0) {
    hardware::ForwardMove out;
    out.kind = hardware::ForwardMove::Kind::line;
    const ur::Six from = target ? *target : q();
    Pose at = ur_chain().forward(from);
    at.position = at.position + by;
    const auto jacobian = [](const ur::Six& one, std::array<double, 36>& J) {
      return ur_chain().jacobian(one, J);
    };
    return to(out, *forward::near_joints(jacobian, at, from), at, blend);
  }
  /// Half a circle downwards.
  hardware::ForwardMove arc() {
    const Pose from = ur_chain().forward(q());
    hardware::ForwardMove out = shift({0, 0.2, 0});
    out.kind = hardware::ForwardMove::Kind::arc;
    out.via = from;
    out.via.position = from.position + Vec3{0, 0.1, -0.1};
    return out;
  }
  Vec3 place() { return ur_chain().forward(q()).position; }
  double slider() {
    return far().with([](ur::Machine& machine) { return machine.speed_slider(); });
  }
  void forget_jumps() {
    far().with([](ur::Machine& machine) { return machine.forget_jumps(), 0; });
  }
  double largest_jump() {
    return far().with([](ur::Machine& machine) { return machine.largest_jump(); });
  }
  /// The robot comes to a standstill, and stays there whatever happens next.
  void expect_standing() { expect_standing_of(far()); }
  std::optional<ur::Six> target;

 private:
  hardware::ForwardMove to(hardware::ForwardMove out, const ur::Six& q, const Pose& at, double blend) {
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

inline ur::FarSideOptions far_options() {
  ur::FarSideOptions options;
  options.machine.facts = ur::facts_of(ur_model());
  options.machine.start = {0.3, -1.2, 1.1, -1.5, -1.57, 0.2};
  options.rtde = options.dashboard = options.primary = options.secondary = 0;
  return options;
}

/// The driver itself, against a controller whose clock runs.
class ForwardAlone {
 public:
  explicit ForwardAlone(Parameters parameters) : far(far_options()) {
    parameters["host"] = "127.0.0.1";
    parameters["motion"] = "forward";
    parameters["rtde_port"] = std::to_string(far.rtde_port());
    parameters["primary_port"] = std::to_string(far.primary_port());
    parameters["dashboard_port"] = std::to_string(far.dashboard_port());
    component.on_init(ur_context(parameters));
    states.resize(component.state_interfaces().size());
    commands.assign(component.command_interfaces().size(), std::nan(""));
  }
  ~ForwardAlone() { component.on_shutdown(); }
  bool start() {
    if (component.on_configure() != CallbackReturn::success) return false;
    if (component.on_activate() != CallbackReturn::success) return false;
    component.await_cycle(1'000'000'000);
    return component.read(cycle, states) == ReturnType::ok;
  }
  hardware::ForwardMove turn(double by) {
    hardware::ForwardMove out;
    out.id = 1;
    for (std::size_t j = 0; j < 6; ++j) out.joints[j] = states[4 * j];
    out.joints[0] += by;
    out.at = ur_chain().forward(std::span(out.joints).first(6));
    return out;
  }

  FarSide far;
  ur::UrComponent component;
  std::vector<double> states, commands;
  hardware::Cycle cycle{0, 2'000'000, 0};
};

}  // namespace polyarm::test
