#include "drivers/cia402/watchdog.hpp"

#include "drivers/cia402/drive.hpp"
#include "drivers/cia402/sdo.hpp"
#include "drivers/watchdog/watch.hpp"

namespace polyarm::cia402 {

using watchdog::Attempt;
using watchdog::read_number;

namespace {
constexpr int kWordsBeforeNodes = 5;
constexpr std::size_t kMostNodes = 32;
}  // namespace

std::vector<std::string> words_of(const WatchdogSettings& s) {
  std::vector<std::string> out{s.bus, std::to_string(s.answer_ms), std::to_string(s.timeout_ms),
                               std::to_string(s.give_up_ms)};
  for (const int node : s.nodes) out.push_back(std::to_string(node));
  return out;
}

bool settings_from(int argc, char** argv, WatchdogSettings& s) {
  if (argc <= kWordsBeforeNodes) return false;
  s.bus = argv[1];
  s.nodes.resize(static_cast<std::size_t>(argc - kWordsBeforeNodes));
  if (s.bus.empty() || s.nodes.size() > kMostNodes) return false;
  for (std::size_t k = 0; k < s.nodes.size(); ++k)
    if (!read_number(argv[kWordsBeforeNodes + k], s.nodes[k]) || s.nodes[k] < 1 || s.nodes[k] > kMostNode)
      return false;
  return read_number(argv[2], s.answer_ms) && read_number(argv[3], s.timeout_ms) &&
         read_number(argv[4], s.give_up_ms) && s.answer_ms > 0 && s.timeout_ms > 0;
}

/// First the order to all of them, then the questions: a drive that does not answer delays no other one.
bool stop_all(CanBus& bus, const std::vector<int>& nodes, Nanoseconds answer, BusState& state) {
  state = BusState::ok;
  constexpr std::array<std::uint8_t, 2> kQuickStop{control::kQuickStop, 0};
  for (const int node : nodes) {
    state = bus.send(download_request(node, object::kControlword, kQuickStop));
    if (state == BusState::gone) return false;
  }
  bool all = true;
  SdoClient sdo(bus, answer);
  for (const int node : nodes) {
    std::uint64_t word = 0;
    const SdoDone done = sdo.read(node, object::kStatusword, 2, word);
    if (done.result == SdoResult::bus) state = done.state;
    if (state == BusState::gone) return false;
    const DriveState now = state_of(static_cast<std::uint16_t>(word));
    all = all && done && now != DriveState::enabled && now != DriveState::fault_reaction;
  }
  return all;
}

int watch(const WatchdogSettings& settings, int socket) {
  const std::unique_ptr<CanBus> bus = take_bus(settings.bus, socket + 1, socket + 2);
  const Nanoseconds answer = Nanoseconds{settings.answer_ms} * 1'000'000;
  watchdog::MakingSafe safe;
  safe.stop = [&] {
    BusState state = BusState::ok;
    if (stop_all(*bus, settings.nodes, answer, state)) return Attempt::done;
    return state == BusState::gone ? Attempt::hopeless : Attempt::again;
  };
  return watchdog::watch(socket, {settings.timeout_ms, settings.give_up_ms}, safe);
}

}  // namespace polyarm::cia402
