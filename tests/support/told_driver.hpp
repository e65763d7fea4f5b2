#pragma once
/// The other end of a DrivingProcess: a driver that obeys commands on standard input, line by line.
#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "polyarm/hardware/component.hpp"

namespace polyarm::test {

inline void tell(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

/// Configures and activates a component, and reports `working` or the reason of the refusal.
inline bool start(hardware::Component& component, const std::string& working) {
  using hardware::CallbackReturn;
  const bool works = component.on_configure() == CallbackReturn::success &&
                     component.on_activate() == CallbackReturn::success;
  tell(works ? working : "refused: " + component.reason());
  return works;
}

/// The next command if it arrives within one period of the loop, else empty. This wait sets the pace of the
/// loop.
inline std::string heard(int period_ms) {
  pollfd waiting{STDIN_FILENO, POLLIN, 0};
  if (poll(&waiting, 1, period_ms) <= 0) return {};
  char buffer[64];
  const ssize_t n = ::read(STDIN_FILENO, buffer, sizeof buffer);
  if (n <= 0) std::_Exit(9);  // the test has ended
  std::string line(buffer, static_cast<std::size_t>(n));
  if (line.back() == '\n') line.pop_back();
  return line;
}

/// Ends the process in the way that the word names. Returns true for "return": the caller must then return.
inline bool is_to_return(const std::string& word) {
  if (word == "exit") std::exit(0);  // without destructors of the caller
  if (word == "abort") std::abort();
  if (word == "throw") throw std::runtime_error("nobody catches this");
  if (word == "crash") *static_cast<volatile int*>(nullptr) = 1;
  if (word == "spin")
    for (volatile bool for_ever = true; for_ever;) {
    }
  return word == "return";
}

}  // namespace polyarm::test
