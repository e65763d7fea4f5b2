#pragma once
/// `polyarm setup cia402`: lists the nodes of a CAN bus, what they are, and where they stand. It reads only.
#include <functional>
#include <string>

#include "drivers/cia402/can_bus.hpp"

namespace polyarm::cia402 {

struct SetupOptions {
  BusOptions bus;
  int first = 1, last = 127;  ///< nodes that are asked
  Nanoseconds answer = 50'000'000;
  std::function<void(const std::string&)> say;  ///< a line for a person
};

/// True if there is a drive that this driver can use. Throws as open_bus().
bool set_up(const SetupOptions& options);

}  // namespace polyarm::cia402
