#include "drivers/xarm/watchdog.hpp"

#include "drivers/watchdog/watch.hpp"
#include "drivers/xarm/ux_port.hpp"

namespace polyarm::xarm {

using watchdog::Attempt;
using watchdog::read_number;

std::vector<std::string> words_of(const WatchdogSettings& s) {
  return {s.host, std::to_string(s.command_port), std::to_string(s.timeout_ms), std::to_string(s.answer_ms),
          std::to_string(s.give_up_ms)};
}

bool settings_from(int argc, char** argv, WatchdogSettings& s) {
  if (argc != 6) return false;
  s.host = argv[1];
  return !s.host.empty() && read_number(argv[2], s.command_port) && read_number(argv[3], s.timeout_ms) &&
         read_number(argv[4], s.answer_ms) && read_number(argv[5], s.give_up_ms) && s.command_port > 0 &&
         s.timeout_ms > 0 && s.answer_ms > 0;
}

/// Until the controller says that its queue is empty.
int watch(const WatchdogSettings& settings, int socket) {
  const Nanoseconds answer = static_cast<Nanoseconds>(settings.answer_ms) * 1'000'000;
  UxPort port(settings.host, settings.command_port);
  if (!port.open(answer)) return watchdog::watch_nothing(socket);
  watchdog::MakingSafe safe;
  safe.stop = [&] {
    if (!port.is_open() && !port.open(answer)) return Attempt::again;
    if (!port.ask(Register::set_state, UxData().u8(static_cast<unsigned>(State::stopped)), answer))
      return Attempt::again;
    const auto queue = port.ask(Register::queue_length, {}, answer);
    const bool empty = queue && queue->data.size() >= 2 && queue->data[0] == 0 && queue->data[1] == 0;
    return empty ? Attempt::done : Attempt::again;
  };
  return watchdog::watch(socket, {settings.timeout_ms, settings.give_up_ms}, safe);
}

}  // namespace polyarm::xarm
