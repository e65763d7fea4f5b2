#pragma once
/// What a user sets: the bus, its drives, and how they are watched. Read from the parameters of a component
/// and of its joints. Any thread; throws Error with all that is wrong.
#include <optional>
#include <string>
#include <vector>

#include "drivers/cia402/drive.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::cia402 {

inline constexpr std::size_t kMostDrives = 12;

enum class VelocityUnit : std::uint8_t { difference, counts, rpm, mrpm };
enum class QuickStop : std::uint8_t { hold, off, as_set };
enum class Watched : std::uint8_t { automatic, on, off };

struct JointSettings {
  std::string name;
  int node = 0;
  Scale scale;
  VelocityUnit velocity_unit = VelocityUnit::difference;
  std::optional<double> rated_torque;     ///< N·m of the motor; empty: the drive's 0x6076
  std::optional<double> max_torque;       ///< share of the rated one
  std::optional<double> max_motor_speed;  ///< rpm
  std::optional<double> following_error;  ///< rad of the joint
  std::optional<double> min, max;         ///< rad of the joint, for the drive's own limits
};

struct Settings {
  BusOptions bus;
  std::vector<JointSettings> joints;
  Nanoseconds cycle = 10'000'000;
  int master = 127;
  int heartbeat_ms = 100;
  QuickStop quick_stop = QuickStop::hold;
  bool fault_reset = true;
  bool off_on_shutdown = false;
  int lost_cycles = 5;
  Watched watched = Watched::automatic;
  int watchdog_ms = 250;
  std::string watchdog;  ///< the path of the program
  Nanoseconds answer = 500'000'000, start_timeout = 10'000'000'000, loop_silence = 100'000'000;
  double max_step = 0.1;
  bool pace = true;
};

const hardware::DriverFacts& facts();
Settings read_settings(const hardware::ComponentContext& context);
/// The share of the bus that a cycle with `drives` drives takes, with all stuff bits.
double bus_load(std::size_t drives, int bit_rate, Nanoseconds cycle) noexcept;

}  // namespace polyarm::cia402
