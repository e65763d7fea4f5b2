#pragma once
/// `polyarm setup franka`: looks at a robot and says what to set in Desk. Nothing moves.
#include <functional>
#include <string>

#include "drivers/franka/hand.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::franka {

struct SetupOptions {
  std::string host;
  int port = kRobotPort, hand_port = kHandPort;
  bool hand = false;  ///< looks for the hand too
  Nanoseconds timeout = 3'000'000'000;
  std::function<void(const std::string&)> say;  ///< a line for a person
};

/// True if everything that the driver needs is there.
bool set_up(SetupOptions options);

}  // namespace polyarm::franka
