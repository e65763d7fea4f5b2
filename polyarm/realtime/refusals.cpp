#include "polyarm/realtime/refusals.hpp"

#include <thread>

namespace polyarm::realtime {

std::vector<std::string> refusals(unsigned refused, const ThreadOptions& asked, const std::string& who) {
  const auto is = [&](Refusal what) { return (refused & static_cast<unsigned>(what)) != 0; };
  std::vector<std::string> out;
  if (is(Refusal::cpu))
    out.push_back(who + " could not be pinned to processor " + std::to_string(asked.cpu) +
                  ": it runs on any; this machine has " +
                  std::to_string(std::thread::hardware_concurrency()));
  if (is(Refusal::priority))
    out.push_back(who + " was refused real-time priority " + std::to_string(asked.priority) +
                  ": it runs at ordinary priority; polyarm doctor names the command that permits it");
  if (is(Refusal::memory))
    out.push_back(who +
                  " could not lock its memory, and may wait for pages; polyarm doctor names the command that "
                  "permits it");
  return out;
}

}  // namespace polyarm::realtime
