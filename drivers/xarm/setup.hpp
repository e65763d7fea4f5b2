#pragma once
/// `polyarm setup xarm`: looks at a controller and says what to set in UFACTORY Studio. Nothing moves.
#include <functional>
#include <string>

#include "drivers/xarm/report.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::xarm {

struct SetupOptions {
  std::string host;
  int command_port = kCommandPort, rich_port = kRichPort, real_port = kRealPort;
  Nanoseconds timeout = 3'000'000'000;
  std::function<void(const std::string&)> say;  ///< a line for a person
};

/// True if everything that the driver needs is there.
bool set_up(SetupOptions options);

}  // namespace polyarm::xarm
