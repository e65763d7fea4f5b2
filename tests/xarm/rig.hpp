#pragma once
#include <thread>

#include "drivers/xarm/fake.hpp"
#include "polyarm/base/error.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm::test {

using xarm::Cause;
using xarm::FarSide;
using xarm::FarSideOptions;
using FaultRow = FaultOf<Cause>;

inline const description::RobotModel& xarm_model() {
  return catalogue_model("ufactory/xarm_6");
}

inline hardware::ComponentContext xarm_context(Parameters parameters = {}, Nanoseconds period = 4'000'000) {
  return wire_context(xarm_model(), {0.3, -0.5, -0.6, 0.1, 0.8, 0.4}, period, std::move(parameters));
}

inline FarSideOptions far_options() {
  FarSideOptions options;
  options.machine.facts = xarm::facts_of(xarm_model());
  options.machine.start = {10, -30, -35, 5, 40, 20, 0};
  options.ports = {0, 0, 0, 0};
  return options;
}

class XarmRig : public WireRig<xarm::FakeXarm, 3> {
 public:
  explicit XarmRig(Parameters parameters = {}, Nanoseconds period = 4'000'000)
      : WireRig(xarm_context(with_signals(std::move(parameters)), period)) {}

 private:
  static Parameters with_signals(Parameters parameters) {
    parameters.try_emplace("digital_out", "0-1");
    parameters.try_emplace("digital_in", "0-3");
    return parameters;
  }
};

inline constexpr double kRounding = 1e-6;  // rad, of single-precision numbers on the wire

/// A motion that speeds up smoothly in 80 cycles.
inline double travel(int i, double step) {
  return travel(i, step, 80);
}

/// The driver alone, as for a real controller: the far side ticks on its own thread, with reports at 100 Hz.
class Alone {
 public:
  explicit Alone(FarSideOptions options = far_options(), Parameters more = {}) : far(options) {
    Parameters parameters{{"host", "127.0.0.1"},
                          {"command_port", std::to_string(far.ports().command)},
                          {"report_port", std::to_string(far.ports().real)},
                          {"silence_ms", "10000"},
                          {"loop_silence_ms", "10000"},
                          {"start_timeout", "60"},
                          {"connect_timeout", "60"}};
    more.merge(parameters);
    component.on_init(xarm_context(more));
  }
  ~Alone() { component.on_shutdown(); }
  bool configure() { return component.on_configure() == CallbackReturn::success; }
  bool start() { return configure() && component.on_activate() == CallbackReturn::success; }
  /// One cycle of the controller whose clock stands still, when it has `commands` servo commands.
  void step(std::uint64_t commands) {
    while (component.cause() == Cause::none &&
           far.with([](xarm::Machine& m) { return m.servo_commands(); }) < commands)
      std::this_thread::yield();
    far.step();
  }
  FarSide far;
  xarm::XarmComponent component;
};

}  // namespace polyarm::test
