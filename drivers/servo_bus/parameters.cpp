#include "drivers/servo_bus/parameters.hpp"

#include <iterator>
#include <string_view>
#include <vector>

namespace polyarm::servo_bus {

namespace {
using hardware::DriverParameter;
using enum hardware::ParameterKind;

constexpr DriverParameter kOfBus[] = {
    {"port", text, nullptr, "serial port, for example /dev/serial/by-id/usb-…"},
    {"calibration", text, "", "file from `polyarm setup`"},
    {"answer_timeout_ms", number, "10", "ms beyond the time the bytes take", 1, 10'000},
    {"lost_cycles", number, "5", "cycles in a row without an answer of a joint until it is an error", 1,
     10'000},
    {"torque_off", text, "never", "on_shutdown: lowers slowly at the end of a run", 0, 0,
     "never on_shutdown"},
    {"release_time", number, "3", "s, for that", 0, 60},
    {"by_hand", boolean, "false",
     "torque off: the joints are moved by hand and only measured, as a leader of another arm"},
    {"watchdog", text, "auto",
     "a process that stops joints when this one dies or hangs: on, off; auto: for joints in velocity whose "
     "servos cannot do so themselves",
     0, 0, "auto on off"},
    {"watchdog_ms", number, "250", "ms without a write until it does; two cycles at least", 20, 5000},
};
constexpr DriverParameter kOfDynamixel[] = {
    {"fast_sync_read", boolean, "false", "one answer for all; not for old firmware"},
    {"bus_watchdog_ms", number, "200",
     "ms without traffic until the servos stop velocity and current joints themselves; 0: never", 0, 2540},
};
constexpr DriverParameter kOfJoints[] = {
    {"JOINT.mode", text, "", "position, velocity, with dynamixel current; else as its command interface"},
    {"JOINT.direction", number, "1", "-1: the joint turns against the servo", -1, 1},
    {"JOINT.zero", number, "2048", "steps where the joint's angle is `offset`", -32767, 32767},
    {"JOINT.offset", number, "0", "rad", -100, 100},
    {"JOINT.min", number, "", "steps; else the servo's limit", -32767, 32767},
    {"JOINT.max", number, "", "steps; else the servo's limit", -32767, 32767},
    {"JOINT.model", text, "", "number the servo must have, or any; else one that is known", 0, 65'535},
    {"JOINT.torque_limit", number, "", "share of full; else as the servo is set", 0.01, 1},
    {"JOINT.max_temperature", number, "", "°C; else the servo's limit", 20, 100},
    {"JOINT.effort_scale", number, "1", "N·m at full load, or for each ampere", 1e-6, 1e3},
    {"JOINT.stall_effort", number, "", "what counts as pushing with all it has", 0, 1e3},
    {"JOINT.stall_time", number, "2", "s of pushing without moving until it is an error; 0: never", 0, 3600},
};

std::vector<DriverParameter> table_of(const char* baud, int highest_id, bool dynamixel) {
  std::vector<DriverParameter> out(std::begin(kOfBus), std::end(kOfBus));
  out.insert(out.begin() + 1, {"baud", number, baud, "bit/s", 1200, 10'000'000});
  if (dynamixel) out.insert(out.end(), std::begin(kOfDynamixel), std::end(kOfDynamixel));
  out.push_back({"JOINT.id", number, nullptr, "of the servo", 0, static_cast<double>(highest_id)});
  out.insert(out.end(), std::begin(kOfJoints), std::end(kOfJoints));
  return out;
}
constexpr const char* kProof =
    "a byte-exact servo on a pty, with echo, garbage, lost and late bytes; never on hardware";
}  // namespace

const hardware::DriverFacts& facts_of(const Family& family) {
  static const auto kFeetech = table_of("1000000", 253, false), kDynamixel = table_of("57600", 252, true);
  static const hardware::DriverFacts kFeetechFacts{"system", "Feetech bus servos, STS series", kProof,
                                                   kFeetech};
  static const hardware::DriverFacts kDynamixelFacts{"system", "Dynamixel bus servos, X series, protocol 2.0",
                                                     kProof, kDynamixel};
  return std::string_view(family.name) == "feetech" ? kFeetechFacts : kDynamixelFacts;
}

}  // namespace polyarm::servo_bus
