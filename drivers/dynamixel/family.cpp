#include "drivers/dynamixel/family.hpp"

#include <numbers>

namespace polyarm::dynamixel {

using servo_bus::Register;
using servo_bus::Sign;

const servo_bus::Family& x_family() {
  static const servo_bus::Family family = [] {
    servo_bus::Family f{};
    f.name = "dynamixel";
    f.default_baud = 57'600;
    f.bauds = {9'600, 57'600, 115'200, 1'000'000, 2'000'000, 3'000'000, 4'000'000, 4'500'000};
    f.highest_id = 252;
    f.models = {{1060, "XL430-W250", 0},       {1090, "2XL430-W250", 0},      {1190, "XL330-M077", 0.001},
                {1200, "XL330-M288", 0.001},   {1070, "XC430-W150", 0},       {1080, "XC430-W240", 0},
                {1030, "XM430-W210", 0.00269}, {1020, "XM430-W350", 0.00269}, {1130, "XM540-W150", 0.00269},
                {1120, "XM540-W270", 0.00269}, {1010, "XH430-W210", 0.00269}, {1000, "XH430-W350", 0.00269},
                {1110, "XH540-W150", 0.00269}, {1100, "XH540-W270", 0.00269}, {1220, "XC330-T288", 0.001},
                {1210, "XC330-T181", 0.001},   {1230, "XC330-M181", 0.001},   {1240, "XC330-M288", 0.001}};
    f.steps_per_turn = 4096;
    f.velocity_unit = 0.229 * 2 * std::numbers::pi / 60;
    f.voltage_unit = 0.1;
    f.load_unit = 0.001;
    f.mode_position = 3;
    f.mode_velocity = 1;
    f.mode_current = 0;
    f.homing_sign = 1;
    f.homing_limit = 1024;
    f.soft_limit_full = 885;
    f.model = {0, 2};
    f.firmware = {6, 1};
    f.id = {7, 1};
    f.baud = {8, 1};
    f.min_limit = {52, 4, Sign::twos_complement};
    f.max_limit = {48, 4, Sign::twos_complement};
    f.max_temperature = {31, 1};
    f.max_voltage = {32, 2};
    f.min_voltage = {34, 2};
    f.homing = {20, 4, Sign::twos_complement};
    f.mode = {11, 1};
    f.torque = {64, 1};
    f.status = {70, 1};
    f.watchdog = {98, 1};
    f.soft_limit = {100, 2, Sign::twos_complement};
    f.goal_current = {102, 2, Sign::twos_complement};
    f.goal_velocity = {104, 4, Sign::twos_complement};
    f.goal_position = {116, 4, Sign::twos_complement};
    f.present_address = 126;
    f.present_length = 21;
    f.present_current = {126, 2, Sign::twos_complement};
    f.present_velocity = {128, 4, Sign::twos_complement};
    f.present_position = {132, 4, Sign::twos_complement};
    f.present_voltage = {144, 2};
    f.present_temperature = {146, 1};
    f.lasting = {{"return_delay", {9, 1}},
                 {"drive_mode", {10, 1}},
                 {"mode", f.mode},
                 {"homing", f.homing},
                 {"moving_threshold", {24, 4}},
                 {"max_temperature", f.max_temperature},
                 {"max_voltage", f.max_voltage},
                 {"min_voltage", f.min_voltage},
                 {"pwm_limit", {36, 2}},
                 {"current_limit", {38, 2}},
                 {"velocity_limit", {44, 4}},
                 {"max_limit", f.max_limit},
                 {"min_limit", f.min_limit},
                 {"shutdown", {63, 1}}};
    f.status_bit[0] = "input voltage";
    f.status_bit[2] = "overheating";
    f.status_bit[3] = "motor encoder";
    f.status_bit[4] = "electrical shock";
    f.status_bit[5] = "overload";
    return f;
  }();
  return family;
}

}  // namespace polyarm::dynamixel
