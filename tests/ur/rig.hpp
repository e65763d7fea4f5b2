#pragma once
#include "drivers/ur/fake.hpp"
#include "polyarm/base/error.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm::test {

using ur::Cause;
using ur::FarSide;

inline const description::RobotModel& ur_model(const std::string& name = "ur5e") {
  return catalogue_model("universal_robots/" + name);
}

inline hardware::ComponentContext ur_context(Parameters parameters = {}, const std::string& robot = "ur5e") {
  return wire_context(ur_model(robot), {0.3, -1.2, 1.1, -1.5, -1.57, 0.2}, 2'000'000, std::move(parameters));
}

/// What a person does at the pendant.
inline void mend(FarSide& far) {
  for (const char* order : {"normal", "power_on", "healthy", "program_stop", "remote"}) far.order(order);
}

/// The driver on its simulated controller, called as a cell calls it.
class UrRig : public WireRig<ur::FakeUr, 4> {
 public:
  explicit UrRig(Parameters parameters = {}) : WireRig(ur_context(std::move(parameters))) {}
  /// This machine counts in radians.
  ur::Six q() {
    return far().with([](ur::Machine& machine) { return machine.q(); });
  }
  double largest_jump() {
    return far().with([](ur::Machine& machine) { return machine.largest_jump(); });
  }
};

/// The robot comes to a standstill, and stays there whatever happens next.
inline void expect_standing_of(FarSide& far) {
  const auto at = [&] { return far.with([](ur::Machine& machine) { return machine.q(); }); };
  for (int i = 0; i < 500; ++i) far.step();
  const ur::Six stopped = at();
  for (int i = 0; i < 200; ++i) far.step();
  EXPECT_EQ(at(), stopped);
}
inline void expect_standing(UrRig& rig) {
  expect_standing_of(rig.far());
}

}  // namespace polyarm::test
