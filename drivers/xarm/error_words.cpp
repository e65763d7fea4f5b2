/// Error and warning codes of controllers of UFACTORY.
#include <algorithm>
#include <iterator>

#include "drivers/xarm/words.hpp"

namespace polyarm::xarm {

namespace {

struct Code {
  int code;
  Cause cause;
  const char* words;
};

using enum Cause;
constexpr Code kErrors[] = {
    {1, emergency_stop, "the button at the control box is pressed: look why, release it"},
    {2, emergency_stop, "the emergency input of the control box is open: close both channels (EI)"},
    {3, emergency_stop, "the button of the enabling switch is pressed: look why, release it"},
    {10, joint_error, "a motor has an error: restart the control box with its button"},
    {11, joint_error, "the motor of joint 1 has an error: restart the control box with its button"},
    {12, joint_error, "the motor of joint 2 has an error: restart the control box with its button"},
    {13, joint_error, "the motor of joint 3 has an error: restart the control box with its button"},
    {14, joint_error, "the motor of joint 4 has an error: restart the control box with its button"},
    {15, joint_error, "the motor of joint 5 has an error: restart the control box with its button"},
    {16, joint_error, "the motor of joint 6 has an error: restart the control box with its button"},
    {17, joint_error, "the motor of joint 7 has an error: restart the control box with its button"},
    {18, force_sensor, "the force sensor does not answer: check that it is mounted and connected"},
    {19, tool_error, "the device at the tool does not answer: check its cable and its baud rate"},
    {21, kinematics, "no joint positions lead there: change the target or the path"},
    {22, self_collision, "the robot would touch itself: change the path, or move it away in manual mode"},
    {23, joint_limit, "a joint is beyond its limit: move it back in UFACTORY Studio"},
    {24, speed_limit, "a joint would be too fast: lower the speed, keep away from singular places"},
    {25, planning, "it cannot plan this motion: change the path or lower its speed"},
    {26, controller_error, "its operating system missed its cycle: restart it; ask the maker if it repeats"},
    {27, controller_error, "a motor did not answer a command: try again, then restart the control box"},
    {28, tool_error, "the board at the tool does not answer: restart the control box with its button"},
    {30, speed_limit, "a joint was measured faster than it may be: ask the maker if it repeats"},
    {31, collision,
     "currents were those of a collision: clear the space, check the payload in UFACTORY "
     "Studio, and that the sensitivity fits the speed"},
    {32, planning, "three points make no circle: choose other ones"},
    {33, controller_error, "its board of inputs and outputs has an error: check its wiring, restart it"},
    {34, controller_error, "a recording was longer than 5 minutes: record less"},
    {35, boundary, "the robot left its safety boundary: move it back in manual mode"},
    {36, controller_error, "too many delayed commands wait (36 at most): use fewer"},
    {37, controller_error, "it drifted in manual mode: check payload and mounting in UFACTORY Studio"},
    {38, controller_error, "a joint angle is implausible: press the emergency stop, ask the maker"},
    {39, controller_error, "its power board does not answer: ask the maker"},
    {40, kinematics, "the joint path to the target has no solution: change the target"},
    {41, controller_error, "its file of friction is damaged: restart it, ask the maker if it repeats"},
    {42, controller_error, "its file of calibration is damaged: restart it, ask the maker if it repeats"},
    {50, force_sensor, "the force sensor cannot be read: check its cable"},
    {51, force_sensor, "the force sensor does not take its mode: check its cable"},
    {52, force_sensor, "the force sensor cannot be zeroed: take the load off"},
    {53, force_sensor, "the force sensor is overloaded: take the load off"},
    {60, speed_limit, "the tool would be too fast in servo mode: lower the speed"},
    {110, controller_error, "the board in the base of the arm does not answer: ask the maker"},
    {111, tool_error, "the device at the serial port of the control box does not answer: check its cable"},
};

struct Warning {
  int code;
  const char* words;
};
constexpr Warning kWarnings[] = {
    {11, "its queue of commands is full"},
    {12, "a command had wrong parameters"},
    {13, "it does not know a command: look for newer firmware"},
    {14, "a command had no solution"},
    {15, "its queue for the serial port is full"},
};

}  // namespace

Cause cause_of_error(int code) {
  const auto found =
      std::find_if(std::begin(kErrors), std::end(kErrors), [&](const Code& one) { return one.code == code; });
  return found == std::end(kErrors) ? controller_error : found->cause;
}

std::string error_words(int code) {
  const auto found =
      std::find_if(std::begin(kErrors), std::end(kErrors), [&](const Code& one) { return one.code == code; });
  return found == std::end(kErrors) ? "this driver does not know the code: look it up in UFACTORY Studio"
                                    : found->words;
}

std::string warning_words(int code) {
  const auto found = std::find_if(std::begin(kWarnings), std::end(kWarnings),
                                  [&](const Warning& one) { return one.code == code; });
  return found == std::end(kWarnings) ? "look it up in UFACTORY Studio" : found->words;
}

const char* mode_words(int mode) {
  constexpr const char* kModes[] = {"position",          "servo",
                                    "joint teach",       "Cartesian teach",
                                    "joint velocity",    "Cartesian velocity",
                                    "online joint path", "online Cartesian path"};
  return mode >= 0 && mode < static_cast<int>(std::size(kModes)) ? kModes[mode] : "unknown";
}

}  // namespace polyarm::xarm
