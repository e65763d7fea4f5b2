#pragma once
#include "drivers/kuka/fake.hpp"
#include "polyarm/base/error.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm::test {

using kuka::Cause;
using kuka::FarSide;
using kuka::FarSideOptions;
using FaultRow = FaultOf<Cause>;

inline const description::RobotModel& kuka_model() {
  return catalogue_model("kuka/kr_10_r1100_3");
}

inline hardware::ComponentContext kuka_context(Parameters parameters = {}, Nanoseconds period = 4'000'000) {
  return wire_context(kuka_model(), {0.3, -1.2, 1.1, 0.1, 0.8, 0.4}, period, std::move(parameters));
}

inline FarSideOptions far_options() {
  FarSideOptions options;
  options.machine.facts = kuka::facts_of(kuka_model());
  options.machine.start = {10, -80, 70, 5, 40, 20};
  options.eki = options.rsi = 0;
  return options;
}

class KukaRig : public WireRig<kuka::FakeKuka> {
 public:
  explicit KukaRig(Parameters parameters = {}, Nanoseconds period = 4'000'000)
      : WireRig(kuka_context(with_signals(std::move(parameters)), period)) {}

 private:
  static Parameters with_signals(Parameters parameters) {
    parameters.try_emplace("digital_out", "1-2");
    parameters.try_emplace("digital_in", "1-4");
    return parameters;
  }
};

/// What a person does at the controller. The drives stay off.
inline void mend(FarSide& far) {
  for (const char* order : {"release", "guard_closed", "acknowledge", "ext", "healthy"}) far.order(order);
}

/// A motion that speeds up smoothly in 80 cycles.
inline double travel(int i, double step) {
  return travel(i, step, 80);
}

/// The driver alone, as for a real controller: the far side ticks on its own thread.
class Alone {
 public:
  explicit Alone(FarSideOptions options = far_options(), Parameters more = {}) : far(options) {
    Parameters parameters{{"host", "127.0.0.1"},
                          {"eki_port", std::to_string(far.eki_port())},
                          {"rsi_port", "0"},
                          {"silence_ms", "10000"},
                          {"loop_silence_ms", "10000"},
                          {"start_timeout", "60"},
                          {"connect_timeout", "60"}};
    more.merge(parameters);
    component.on_init(kuka_context(more));
  }
  ~Alone() { component.on_shutdown(); }
  class Driver : public kuka::KukaComponent {
   public:
    int rsi_port() { return link()->rsi_port(); }
  };
  bool configure() {
    if (component.on_configure() != CallbackReturn::success) return false;
    far.send_rsi_to("127.0.0.1", component.rsi_port());
    return true;
  }
  bool start() { return configure() && component.on_activate() == CallbackReturn::success; }
  FarSide far;
  Driver component;
};

}  // namespace polyarm::test
