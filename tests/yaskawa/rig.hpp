#pragma once
#include <thread>

#include "drivers/yaskawa/fake.hpp"
#include "polyarm/base/error.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm::test {

using yaskawa::Cause;
using yaskawa::FarSide;
using yaskawa::FarSideOptions;
using FaultRow = FaultOf<Cause>;

inline const description::RobotModel& yaskawa_model() {
  return catalogue_model("yaskawa/gp7");
}

inline hardware::ComponentContext yaskawa_context(Parameters parameters = {},
                                                  Nanoseconds period = 4'000'000) {
  return wire_context(yaskawa_model(), {0.3, 0.2, 0.1, 0.1, -0.8, 0.4}, period, std::move(parameters));
}

inline FarSideOptions far_options() {
  FarSideOptions options;
  options.machine.facts = yaskawa::facts_of(yaskawa_model());
  options.machine.start = {10, 8, 7, 5, -40, 20};
  options.motion = options.state = options.io = options.hses = 0;
  return options;
}

class YaskawaRig : public WireRig<yaskawa::FakeYaskawa, 3> {
 public:
  explicit YaskawaRig(Parameters parameters = {}, Nanoseconds period = 4'000'000)
      : WireRig(yaskawa_context(with_signals(std::move(parameters)), period)) {}

 private:
  static Parameters with_signals(Parameters parameters) {
    parameters.try_emplace("digital_out", "1-2");
    parameters.try_emplace("digital_in", "1-4");
    return parameters;
  }
};

inline constexpr double kPulse = 2e-5;  // rad, of the simulated motors

/// A motion that speeds up smoothly in 80 cycles.
inline double travel(int i, double step) {
  return travel(i, step, 80);
}

/// The driver alone, as for a real controller: the far side ticks on its own thread, with states at 40 Hz.
class Alone {
 public:
  explicit Alone(FarSideOptions options = far_options(), Parameters more = {}) : far(options) {
    Parameters parameters{{"host", "127.0.0.1"},
                          {"motion_port", std::to_string(far.motion_port())},
                          {"state_port", std::to_string(far.state_port())},
                          {"io_port", std::to_string(far.io_port())},
                          {"hses_port", std::to_string(far.hses_port())},
                          {"silence_ms", "10000"},
                          {"loop_silence_ms", "10000"},
                          {"start_timeout", "60"},
                          {"connect_timeout", "60"}};
    more.merge(parameters);
    component.on_init(yaskawa_context(more));
  }
  ~Alone() { component.on_shutdown(); }
  bool configure() { return component.on_configure() == CallbackReturn::success; }
  bool start() { return configure() && component.on_activate() == CallbackReturn::success; }
  /// One cycle of the controller whose clock stands still, for cycle `i` of the loop: when it has the points
  /// of the cycles before.
  void step(int i) {
    while (component.cause() == Cause::none &&
           far.with([](yaskawa::Machine& m) { return static_cast<int>(m.points()); }) < i / 5 - 1)
      std::this_thread::yield();
    far.step();
  }
  FarSide far;
  yaskawa::YaskawaComponent component;
};

}  // namespace polyarm::test
