#include "drivers/servo_bus/watchdog.hpp"

#include <utility>

#include "drivers/watchdog/watch.hpp"

namespace polyarm::servo_bus {

using watchdog::Attempt;
using watchdog::read_number;

namespace {
constexpr int kWordsBeforeJoints = 7;
constexpr const char* kModes = "pvc";  // in the order of Mode

std::string word_of(const StandingJoint& joint) {
  return kModes[static_cast<std::size_t>(joint.mode)] + std::to_string(joint.id) + ":" +
         std::to_string(joint.slow);
}

bool joint_from(const std::string& word, StandingJoint& joint) {
  const std::string_view modes = kModes;
  const auto colon = word.find(':');
  if (word.empty() || colon == std::string::npos) return false;
  const auto mode = modes.find(word[0]);
  if (mode == std::string_view::npos) return false;
  joint.mode = static_cast<Mode>(mode);
  return read_number(word.substr(1, colon - 1).c_str(), joint.id) &&
         read_number(word.substr(colon + 1).c_str(), joint.slow);
}
}  // namespace

std::vector<std::string> words_of(const WatchdogSettings& s) {
  std::vector<std::string> out{s.family, s.port};
  for (const int number : {s.baud, s.answer_ms, s.timeout_ms, s.give_up_ms})
    out.push_back(std::to_string(number));
  for (const StandingJoint& joint : s.joints) out.push_back(word_of(joint));
  return out;
}

bool settings_from(int argc, char** argv, WatchdogSettings& s) {
  if (argc <= kWordsBeforeJoints) return false;
  s.family = argv[1];
  s.port = argv[2];
  s.joints.resize(static_cast<std::size_t>(argc - kWordsBeforeJoints));
  if (s.joints.size() > ServoBus::kMostServos) return false;
  for (std::size_t k = 0; k < s.joints.size(); ++k)
    if (!joint_from(argv[kWordsBeforeJoints + k], s.joints[k])) return false;
  return read_number(argv[3], s.baud) && read_number(argv[4], s.answer_ms) &&
         read_number(argv[5], s.timeout_ms) && read_number(argv[6], s.give_up_ms) && s.baud > 0 &&
         s.answer_ms > 0 && s.timeout_ms > 0;
}

int watch(const WatchdogSettings& settings, int socket, const Family& family,
          std::unique_ptr<Protocol> protocol) {
  ServoBus bus(family, std::move(protocol));
  bus.take(serial::Port::handed_over(socket + 1, socket + 2, settings.port), settings.baud,
           Nanoseconds{settings.answer_ms} * 1'000'000);
  watchdog::MakingSafe safe;
  safe.stop = [&] {
    const Outcome outcome = all_at_rest(bus, settings.joints);
    if (outcome == Outcome::gone) return Attempt::hopeless;
    return outcome == Outcome::ok ? Attempt::done : Attempt::again;
  };
  return watchdog::watch(socket, {settings.timeout_ms, settings.give_up_ms}, safe);
}

}  // namespace polyarm::servo_bus
