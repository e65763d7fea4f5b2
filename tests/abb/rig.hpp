#pragma once
#include "drivers/abb/fake.hpp"
#include "polyarm/base/error.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm::test {

using abb::Cause;
using abb::FarSide;
using abb::FarSideOptions;
using FaultRow = FaultOf<Cause>;

inline const description::RobotModel& abb_model() {
  return catalogue_model("abb/irb_120");
}

inline hardware::ComponentContext abb_context(Parameters parameters = {}) {
  return wire_context(abb_model(), {0.3, 0.2, -0.1, 0.1, 0.8, 0.4}, 4'000'000, std::move(parameters));
}

inline FarSideOptions far_options(int version = 2) {
  FarSideOptions options;
  options.machine.facts = abb::facts_of(abb_model());
  options.machine.start = {10, 10, -5, 0, 40, 20};
  options.machine.signals = {{"doA", false}, {"diA", false}};
  if (version == 1) options.machine.software = "6.16.02.00";
  options.rws_version = version;
  options.rws = options.egm = options.moves = 0;
  return options;
}

class AbbRig : public WireRig<abb::FakeAbb> {
 public:
  explicit AbbRig(Parameters parameters = {}) : WireRig(abb_context(with_signals(std::move(parameters)))) {}

 private:
  static Parameters with_signals(Parameters parameters) {
    parameters.try_emplace("digital_out", "doA doB");
    parameters.try_emplace("digital_in", "diA");
    return parameters;
  }
};

/// A motion that speeds up smoothly in 80 cycles.
inline double travel(int i, double step) {
  return travel(i, step, 80);
}

}  // namespace polyarm::test
