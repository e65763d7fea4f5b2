#pragma once
/// The register map and units of a servo family. Const: any thread.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/servo_bus/protocol.hpp"

namespace polyarm::servo_bus {

enum class Sign : std::uint8_t { none, twos_complement, magnitude };

/// A number in a servo's table, low byte first. Size 0: the family does not have it.
struct Register {
  std::uint16_t address = 0;
  std::uint8_t size = 0;
  Sign sign = Sign::none;
  std::uint8_t sign_bit = 15;  ///< of Sign::magnitude
  explicit operator bool() const noexcept { return size > 0; }
};
/// `bytes` holds at least `size` bytes.
std::int32_t decode(const Register& reg, Bytes bytes) noexcept;
void encode(const Register& reg, std::int32_t value, std::span<std::uint8_t> bytes) noexcept;

struct NamedRegister {
  const char* name;
  Register reg;
};
struct Model {
  int number;
  const char* name;
  double current_unit;  ///< A per count; 0: it reports its load instead of a current
};

/// One family ("feetech", "dynamixel").
struct Family {
  const char* name;
  int default_baud;
  std::vector<int> bauds;  ///< indexed by the value of the baud register
  int highest_id;
  std::vector<Model> models;
  int steps_per_turn;
  double velocity_unit, voltage_unit;              ///< rad/s, V per count
  double load_unit;                                ///< fraction of full load per count
  int mode_position, mode_velocity, mode_current;  ///< -1: no such mode
  double homing_sign;                              ///< measured = raw + homing_sign × homing
  int homing_limit;                                ///< largest homing in either direction
  double soft_limit_full;                          ///< value of soft_limit for full torque

  Register model, firmware, id, baud, min_limit, max_limit, max_temperature, max_voltage, min_voltage, homing,
      mode, phase, lock;
  Register torque, goal_position, goal_velocity, goal_current, soft_limit, watchdog, status;
  std::uint16_t present_address, present_length;  ///< one block with all measured values
  Register present_position, present_velocity, present_load, present_current, present_voltage,
      present_temperature, present_status;
  std::vector<NamedRegister> lasting;  ///< persistent registers, for backups; without the id

  /// Names of the bits of a status or hardware error byte.
  const char* status_bit[8];
};

const Model* find_model(const Family& family, int number);
/// "overload and overheating"; empty for 0.
std::string status_names(const Family& family, unsigned bits);

}  // namespace polyarm::servo_bus
