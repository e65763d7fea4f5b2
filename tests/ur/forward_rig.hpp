#pragma once
#include <thread>

#include "polyarm/kinematics/chain.hpp"
#include "tests/support/forward_moves.hpp"
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

class UrMoveRig : public UrRig {
 public:
  using UrRig::UrRig;
  static const kinematics::Chain& chain() { return ur_chain(); }
};

/// The driver on its simulated controller, with moves for it.
class ForwardRig : public ForwardMoveRig<UrMoveRig> {
 public:
  using ForwardMoveRig::ForwardMoveRig;
  double slider() {
    return far().with([](ur::Machine& machine) { return machine.speed_slider(); });
  }
};
inline void expect_standing(ForwardRig& rig) {
  expect_standing_of(rig.far());
}

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
  FarSide far;
  ur::UrComponent component;
  std::vector<double> states, commands;
  hardware::Cycle cycle{0, 2'000'000, 0};
};

}  // namespace polyarm::test
