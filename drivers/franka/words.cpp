#include "drivers/franka/words.hpp"

#include <fmt/format.h>

#include <iterator>

#include "drivers/franka/errors.hpp"
#include "drivers/wire/words.hpp"

namespace polyarm::franka {

const char* name(Cause cause) {
  constexpr const char* kNames[] = {"none",
                                    "unreachable",
                                    "no-session",
                                    "command-silent",
                                    "silent",
                                    "bad-data",
                                    "closed",
                                    "other-version",
                                    "other-sender",
                                    "wrong-rate",
                                    "user-stop",
                                    "guiding",
                                    "locked",
                                    "safety",
                                    "collision",
                                    "self-collision",
                                    "joint-limit",
                                    "speed-limit",
                                    "discontinuity",
                                    "start-pose",
                                    "deviation",
                                    "communication",
                                    "controller-error",
                                    "reflex-pending",
                                    "recovery-refused",
                                    "motion-refused",
                                    "motion-ended",
                                    "setting-refused",
                                    "low-success",
                                    "position-limit",
                                    "hand-unreachable",
                                    "hand-silent",
                                    "hand-failed",
                                    "hand-version",
                                    "too-fast",
                                    "loop-silent",
                                    "jump"};
  static_assert(std::size(kNames) == static_cast<std::size_t>(Cause::jump) + 1);
  return kNames[static_cast<std::size_t>(cause)];
}

namespace {

constexpr const char* kRecover = "; then recover here";

std::string status_words(int status) {
  const bool known = status >= 0 && status <= static_cast<int>(Status::unknown);
  return name(known ? static_cast<Status>(status) : Status::unknown);
}

/// Connections and their data.
std::string wire_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::unreachable:
      return where + ": " + text + "; activate FCI in Desk; `polyarm setup franka` looks for the robot";
    case Cause::no_session:
      return where +
             " closed the connection at once: activate FCI in Desk, end other programs that use the robot "
             "(it "
             "takes one client), and give this computer the control in Desk";
    case Cause::command_silent:
      return where + " does not answer a request: check cable and power, restart the robot if it stays so";
    case Cause::silent:
      return where + " sends no states" + (text.empty() ? "" : " to " + text) +
             ": check cable and power, and that a firewall lets UDP in from the robot";
    case Cause::bad_data:
      return where +
             " sent data that does not belong to the Franka Control Interface: check address and `port`";
    case Cause::closed:
      return where +
             " closed the connection: FCI was switched off in Desk, or the robot restarts; activate FCI" +
             kRecover;
    case Cause::other_version:
      return where + fmt::format(
                         " speaks version {} of the Franka Control Interface; this driver speaks {} to {}: "
                         "change the robot's system version in Desk",
                         detail, kOldestVersion, kNewestVersion);
    case Cause::other_sender:
      return where + ": states come from " + text + " instead: check `host`, and look for a second simulator";
    case Cause::wrong_rate:
      return where + " works at " + std::to_string(detail) +
             " Hz, and the cell has another rate: write `rate: " + std::to_string(detail) +
             "`, or `pace: false`";
    case Cause::setting_refused:
      return where +
             fmt::format(" refused '{}' ({}): check the parameters of the driver, and that the robot stands",
                         name(static_cast<Request>(detail / 16)), status_words(detail % 16));
    case Cause::low_success:
      return where + fmt::format(
                         " got {} % of the last 100 commands in time, less than `least_success`: use a "
                         "cable without a switch, a real-time kernel, and fewer programs on this computer",
                         detail);
    default:
      return {};
  }
}

/// Modes, people, motion.
std::string mode_sentence(Cause cause, int detail, const std::string& where) {
  switch (cause) {
    case Cause::user_stop:
      return where + ": somebody pressed the user stop; release it" + kRecover;
    case Cause::guiding:
      return where + ": somebody guides the robot by hand; let go of the buttons at its wrist" + kRecover;
    case Cause::locked:
      return where +
             " is in no mode for motion: open the brakes in Desk, choose Execution, and activate FCI" +
             kRecover;
    case Cause::safety:
      return where + ": a safety function of the robot is active; look which one in Desk or Watchman" +
             kRecover;
    case Cause::recovery_refused:
      return where + " did not recover from its error (" + status_words(detail) +
             "): look into Desk, guide the robot by hand if a joint is at its limit" + kRecover;
    case Cause::motion_refused:
      return where + " did not start the motion (" + status_words(detail) +
             "): look into Desk, and end other programs that move the robot";
    case Cause::motion_ended:
      return where + " ended the motion (" + status_words(detail) +
             "): look which other program or person stopped it" + kRecover;
    case Cause::position_limit:
      return where + fmt::format(
                         ": the next command would lead joint {} out of its range; the robot was stopped "
                         "before it: change the path",
                         detail + 1);
    default:
      return {};
  }
}

/// "… stopped for a collision (joint_reflex): a joint felt …; then recover here".
std::string error_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  const ErrorFacts& facts = error_facts(detail);
  const std::string what =
      fmt::format(" ({}): {}{}", text.empty() ? std::string(facts.name) : text, facts.words, kRecover);
  switch (cause) {
    case Cause::collision:
      return where + " stopped for a collision" + what;
    case Cause::self_collision:
      return where + " stopped before a collision of the robot with itself" + what;
    case Cause::joint_limit:
      return where + " stopped at a limit of its space" + what;
    case Cause::speed_limit:
      return where + " stopped because a motion was too fast" + what;
    case Cause::discontinuity:
      return where + " stopped because commands were not smooth" + what;
    case Cause::start_pose:
      return where + " did not take the first command" + what;
    case Cause::deviation:
      return where + " stopped because it was not where it was commanded" + what;
    case Cause::communication:
      return where + " stopped because commands were missing" + what;
    case Cause::controller_error:
      return where + " stopped for an error of its own" + what;
    case Cause::reflex_pending:
      return where + " has an error, and `recover` is false" + what;
    default:
      return {};
  }
}

std::string hand_sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  switch (cause) {
    case Cause::hand_unreachable:
      return where + ", the hand: " + text + "; check in Desk that the hand is chosen as end effector";
    case Cause::hand_silent:
      return where + ", the hand does not answer: check its cable, and restart it in Desk";
    case Cause::hand_failed:
      return where + ", the hand could not " + text +
             ": look what is between its fingers, let it find its range (`tool/homing`)" + kRecover;
    case Cause::hand_version:
      return where + fmt::format(
                         ", the hand speaks version {} of its interface; this driver speaks 3: update the "
                         "robot's system in Desk",
                         detail);
    default:
      return {};
  }
}

}  // namespace

std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  if (cause == Cause::none) return {};
  if (cause == Cause::too_fast) return wire::too_fast_sentence(detail, where) + ", or raise `max_speed`";
  if (cause == Cause::loop_silent) return wire::loop_silent_sentence(where);
  if (cause == Cause::jump) return wire::jump_sentence(detail, where);
  for (std::string out :
       {wire_sentence(cause, detail, where, text), mode_sentence(cause, detail, where),
        error_sentence(cause, detail, where, text), hand_sentence(cause, detail, where, text)})
    if (!out.empty()) return out;
  return where + " failed";
}

}  // namespace polyarm::franka
