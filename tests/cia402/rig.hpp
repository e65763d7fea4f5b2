#pragma once
#include <memory>

#include "drivers/cia402/fake.hpp"
#include "polyarm/base/error.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm::test {

using cia402::Cause;
using cia402::FarSide;
using cia402::FarSideOptions;
using FaultRow = FaultOf<Cause>;

inline constexpr Nanoseconds kCycle = 10'000'000;
inline constexpr const char* kArm = "abb/irb_120";  // six joints in a chain
inline const std::vector<double> kStart{0.1, -0.2, 0.3, 0.4, -0.5, 0.6};

/// Six drives on an arm; joint 2 turns against its motor, joint 3 has an offset.
inline hardware::ComponentContext cia402_context(Parameters parameters = {}, Nanoseconds period = kCycle) {
  for (int j = 1; j <= 6; ++j) {
    const std::string joint = "joint_" + std::to_string(j);
    parameters.try_emplace(joint + ".gear", "100");
  }
  parameters.try_emplace("joint_2.direction", "-1");
  parameters.try_emplace("joint_3.offset", "0.25");
  return wire_context(catalogue_model(kArm), kStart, period, std::move(parameters));
}

class Cia402Rig : public WireRig<cia402::FakeCia402, 3, 6> {
 public:
  explicit Cia402Rig(Parameters parameters = {}) : WireRig(cia402_context(std::move(parameters))) {}
  std::string device() { return far().path(); }
};

/// Two drives with the nodes 1 and 2 on a far side that ticks by itself.
inline FarSideOptions two_drives() {
  FarSideOptions out;
  for (const int node : {1, 2}) {
    cia402::FarDriveOptions drive;
    drive.node = node;
    out.machine.drives.push_back(drive);
  }
  return out;
}

/// The driver alone, as for real drives: the far side ticks on its own thread.
class Alone {
 public:
  explicit Alone(Parameters more = {}) : far(options()) {
    Parameters parameters{{"bus", far.path()},      {"loop_silence_ms", "10000"}, {"start_timeout", "60"},
                          {"heartbeat_ms", "5000"}, {"lost_cycles", "500"},       {"answer_ms", "5000"},
                          {"watchdog", "off"}};
    for (int j = 1; j <= 6; ++j) {
      const std::string joint = "joint_" + std::to_string(j);
      parameters[joint + ".node"] = std::to_string(j);
      parameters[joint + ".counts_per_turn"] = "4096";
    }
    more.merge(parameters);
    component.on_init(cia402_context(more));
  }
  ~Alone() { component.on_shutdown(); }
  bool configure() { return component.on_configure() == CallbackReturn::success; }
  bool start() { return configure() && component.on_activate() == CallbackReturn::success; }

  static FarSideOptions options() {
    FarSideOptions out;
    for (int node = 1; node <= 6; ++node) {
      cia402::FarDriveOptions drive;
      drive.node = node;
      out.machine.drives.push_back(drive);
    }
    return out;
  }
  FarSide far;
  cia402::Cia402Component component;
};

}  // namespace polyarm::test
