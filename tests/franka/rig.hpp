#pragma once
#include <thread>

#include "drivers/franka/fake.hpp"
#include "polyarm/base/error.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm::test {

using franka::Cause;
using franka::FarSide;
using franka::FarSideOptions;
using FaultRow = FaultOf<Cause>;

inline constexpr Nanoseconds kMillisecond = 1'000'000;

inline const description::RobotModel& franka_model(const char* name = "franka/fr3") {
  return catalogue_model(name);
}

inline hardware::ComponentContext franka_context(Parameters parameters = {}, const char* model = "franka/fr3",
                                                 Nanoseconds period = kMillisecond) {
  return wire_context(franka_model(model), {0.1, -0.8, 0.2, -2.2, 0.1, 1.6, 0.8}, period,
                      std::move(parameters));
}

inline FarSideOptions far_options(const char* model = "franka/fr3") {
  FarSideOptions options;
  options.machine.facts = franka::facts_of(franka_model(model));
  options.port = options.hand_port = 0;
  return options;
}

class FrankaRig : public WireRig<franka::FakeFranka, 4, 7> {
 public:
  explicit FrankaRig(Parameters parameters = {}, const char* model = "franka/fr3")
      : WireRig(franka_context(std::move(parameters), model)) {}
};

/// What a person does at the robot. Errors stay.
inline void mend(FarSide& far) {
  for (const char* order : {"release", "let_go", "open_brakes", "safety_off", "healthy"}) far.order(order);
}

/// A motion that speeds up smoothly in 80 cycles.
inline double travel(int i, double step) {
  return travel(i, step, 80);
}

/// The driver alone, as for a real robot: the far side ticks on its own thread.
class Alone {
 public:
  explicit Alone(FarSideOptions options = far_options(), Parameters more = {}) : far(options) {
    Parameters parameters{{"host", "127.0.0.1"},
                          {"port", std::to_string(far.port())},
                          {"hand_port", std::to_string(far.hand_port())},
                          {"silence_ms", "10000"},
                          {"loop_silence_ms", "10000"},
                          {"start_timeout", "60"},
                          {"connect_timeout", "60"}};
    more.merge(parameters);
    component.on_init(franka_context(more));
  }
  ~Alone() { component.on_shutdown(); }
  bool configure() { return component.on_configure() == CallbackReturn::success; }
  bool start() { return configure() && component.on_activate() == CallbackReturn::success; }

  FarSide far;
  franka::FrankaComponent component;
};

}  // namespace polyarm::test
