#pragma once
/// libmodbus's connection object, shared by the client and the server.
#include <modbus.h>

#include <string>

#include "polyarm/signals/link.hpp"

namespace polyarm::modbus {

/// Makes libmodbus's context for the entry's address and unit, not connected yet. The caller frees it. Throws
/// Error("link-lost").
inline modbus_t* new_context(const signals::LinkEntry& entry) {
  modbus_t* const context = modbus_new_tcp_pi(entry.host.c_str(), std::to_string(entry.port).c_str());
  if (!context) throw Error("link-lost", "out of memory");
  modbus_set_slave(context, entry.unit);
  return context;
}

}  // namespace polyarm::modbus
