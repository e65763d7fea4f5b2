#pragma once
/// Modbus TCP over libmodbus.
#include <memory>

#include "polyarm/signals/link.hpp"

namespace polyarm::modbus {

/// Reads and writes the tables of a server, a block of neighbouring addresses in one request each.
std::unique_ptr<signals::LinkPort> make_client(const signals::LinkEntry& entry);
/// Offers its own tables to whoever asks, as many at a time as want to.
std::unique_ptr<signals::LinkPort> make_server(const signals::LinkEntry& entry);

}  // namespace polyarm::modbus
