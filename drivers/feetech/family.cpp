#include "drivers/feetech/family.hpp"

#include <numbers>

namespace polyarm::feetech {

using servo_bus::Register;
using servo_bus::Sign;

const servo_bus::Family& sts_family() {
  static const servo_bus::Family family = [] {
    servo_bus::Family f{};
    f.name = "feetech";
    f.default_baud = 1'000'000;
    f.bauds = {1'000'000, 500'000, 250'000, 128'000, 115'200, 76'800, 57'600, 38'400};
    f.highest_id = 253;
    f.models = {{777, "STS3215", 0.0065}, {2825, "STS3250", 0.0065}};
    f.steps_per_turn = 4096;
    f.velocity_unit = 2 * std::numbers::pi / 4096;  // 1 step/s; 50 steps/s if bit 2 of `phase` is clear
    f.voltage_unit = 0.1;
    f.load_unit = 0.001;
    f.mode_position = 0;
    f.mode_velocity = 1;
    f.mode_current = -1;
    f.homing_sign = -1;
    f.homing_limit = 2047;
    f.soft_limit_full = 1000;
    f.model = {3, 2};
    f.firmware = {0, 2};  // major, minor
    f.id = {5, 1};
    f.baud = {6, 1};
    f.min_limit = {9, 2};
    f.max_limit = {11, 2};
    f.max_temperature = {13, 1};
    f.max_voltage = {14, 1};
    f.min_voltage = {15, 1};
    f.phase = {18, 1};
    f.homing = {31, 2, Sign::magnitude, 11};
    f.mode = {33, 1};
    f.torque = {40, 1};
    f.goal_position = {42, 2, Sign::magnitude, 15};
    f.goal_velocity = {46, 2, Sign::magnitude, 15};
    f.soft_limit = {48, 2};
    f.lock = {55, 1};
    f.status = {65, 1};
    f.present_address = 56;
    f.present_length = 15;
    f.present_position = {56, 2, Sign::magnitude, 15};
    f.present_velocity = {58, 2, Sign::magnitude, 15};
    f.present_load = {60, 2, Sign::magnitude, 10};
    f.present_voltage = {62, 1};
    f.present_temperature = {63, 1};
    f.present_status = {65, 1};
    f.present_current = {69, 2, Sign::magnitude, 15};
    f.lasting = {{"return_delay", {7, 1}},
                 {"response_level", {8, 1}},
                 {"min_limit", f.min_limit},
                 {"max_limit", f.max_limit},
                 {"max_temperature", f.max_temperature},
                 {"max_voltage", f.max_voltage},
                 {"min_voltage", f.min_voltage},
                 {"max_torque", {16, 2}},
                 {"phase", f.phase},
                 {"unload_conditions", {19, 1}},
                 {"led_conditions", {20, 1}},
                 {"p_gain", {21, 1}},
                 {"d_gain", {22, 1}},
                 {"i_gain", {23, 1}},
                 {"starting_force", {24, 2}},
                 {"cw_dead_zone", {26, 1}},
                 {"ccw_dead_zone", {27, 1}},
                 {"protection_current", {28, 2}},
                 {"angular_resolution", {30, 1}},
                 {"homing", f.homing},
                 {"mode", f.mode},
                 {"protective_torque", {34, 1}},
                 {"protection_time", {35, 1}},
                 {"overload_torque", {36, 1}},
                 {"speed_p_gain", {37, 1}},
                 {"overcurrent_time", {38, 1}},
                 {"speed_i_gain", {39, 1}}};
    f.status_bit[0] = "input voltage";
    f.status_bit[1] = "position sensor";
    f.status_bit[2] = "overheating";
    f.status_bit[3] = "overcurrent";
    f.status_bit[5] = "overload";
    return f;
  }();
  return family;
}

}  // namespace polyarm::feetech
