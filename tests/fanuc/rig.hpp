#pragma once
#include "drivers/fanuc/fake.hpp"
#include "polyarm/base/error.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm::test {

using fanuc::Cause;
using fanuc::FarSide;
using fanuc::FarSideOptions;
using FaultRow = FaultOf<Cause>;

inline const description::RobotModel& fanuc_model(const std::string& name = "crx_10ia_l") {
  return catalogue_model("fanuc/" + name);
}

inline hardware::ComponentContext fanuc_context(Parameters parameters = {}) {
  return wire_context(fanuc_model(), {0.3, 0.2, -0.1, 0.1, -1.2, 0.4}, 8'000'000, std::move(parameters));
}

inline FarSideOptions far_options() {
  FarSideOptions options;
  options.machine.facts = fanuc::facts_of(fanuc_model());
  options.machine.start = {10, 10, -5, 0, -60, 20};
  options.stream = options.rmi = options.session = 0;
  return options;
}

class FanucRig : public WireRig<fanuc::FakeFanuc, 3> {
 public:
  explicit FanucRig(Parameters parameters = {})
      : WireRig(fanuc_context(with_outputs(std::move(parameters)))) {}

 private:
  static Parameters with_outputs(Parameters parameters) {
    parameters.try_emplace("digital_out", "1-8");
    return parameters;
  }
};

/// What a person does at the robot.
inline void mend(FarSide& far) {
  for (const char* order : {"release", "fence_closed", "auto", "reset", "healthy"}) far.order(order);
}

/// A motion that speeds up smoothly in 40 cycles.
inline double travel(int i, double step) {
  return travel(i, step, 40);
}

}  // namespace polyarm::test
