#include "drivers/wire/words.hpp"

namespace polyarm::wire {

std::string address_in(const std::string& where) {
  return where.substr(where.rfind(' ') + 1);
}

std::string too_fast_sentence(int detail, const std::string& where) {
  constexpr const char* kKinds[] = {"velocity", "acceleration", "jerk"};
  return "joint " + std::to_string(detail / 3 + 1) + " was commanded beyond the " + kKinds[detail % 3] +
         " limit of the driver for longer than it can be made up for; the robot at " + address_in(where) +
         " was stopped: lower the limits of the robot in the cell";
}

std::string loop_silent_sentence(const std::string& where) {
  return "the control loop gave no command in time; the robot at " + address_in(where) +
         " was braked: look for what delays the loop on this computer";
}

std::string jump_sentence(int joint, const std::string& where) {
  return "the command for joint " + std::to_string(joint + 1) + " of " + where +
         " is too far away for one cycle; it was not sent, and the robot was stopped: check controllers and "
         "limits";
}

std::string joint_commands_sentence(int joint, const std::string& where) {
  return "a controller of this cell commands joint " + std::to_string(joint + 1) + " of " + where +
         ", which takes only moves (`motion: forward`); the robot was stopped: stop that controller, or set "
         "`motion: stream`";
}

}  // namespace polyarm::wire
