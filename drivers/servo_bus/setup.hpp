#pragma once
/// The user's settings for a bus and its joints: parameters of the component, of its joints, and a
/// calibration.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/servo_bus/registers.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::servo_bus {

enum class Mode : std::uint8_t { position, velocity, current };
const char* name(Mode mode);

struct JointSetup {
  std::string interface;  ///< "arm/elbow_flex"
  std::string name;       ///< "elbow_flex"
  std::uint8_t id = 0;
  Mode mode = Mode::position;
  int direction = 1;            ///< 1, or -1 if the joint turns against the servo
  double offset = 0;            ///< rad, angle of the joint when the servo shows `zero`
  int zero = 0;                 ///< steps
  std::optional<int> min, max;  ///< steps; empty: the servo's own limits
  std::optional<int> model;     ///< its number; empty: any of the family
  bool any_model = false;
  std::optional<double> torque_limit;     ///< fraction; empty: the servo's setting
  std::optional<double> max_temperature;  ///< °C; empty: the servo's own limit
  double effort_scale = 1;                ///< N·m at full load, or per ampere
  std::optional<double> stall_effort;     ///< in the units of the effort
  double stall_time = 2;                  ///< s; 0: disabled
  std::vector<std::string> states;        ///< "position", "temperature", …
};

struct BusSetup {
  std::string port;
  int baud = 0;
  Nanoseconds answer_timeout = 0;
  int lost_cycles = 5;
  bool lowers_on_shutdown = false;
  bool led_by_hand = false;  ///< torque off: the joints are moved by hand, and only measured
  Nanoseconds release_time = 0;
  bool fast_sync_read = false;
  int bus_watchdog_ms = 0;   ///< of the servos themselves; 0: disabled
  bool watched = false;      ///< a watchdog process stops the joints
  bool all_watched = false;  ///< including joints in position mode
  int watchdog_ms = 0;       ///< of that process
  double period = 0;         ///< s, between two writes
  std::vector<JointSetup> joints;
};

/// Throws Error with all missing, unknown or wrong parameters.
BusSetup read_setup(const hardware::ComponentContext& context, const Family& family);

}  // namespace polyarm::servo_bus
