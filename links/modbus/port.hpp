#pragma once
/// Modbus TCP clients and servers, based on libmodbus.
#include <memory>

#include "polyarm/signals/link.hpp"

namespace polyarm::modbus {

/// Reads and writes the tables of a server. One request reads a block of neighbouring addresses.
std::unique_ptr<signals::LinkPort> make_client(const signals::LinkEntry& entry);
/// Offers its own tables to several clients at a time.
std::unique_ptr<signals::LinkPort> make_server(const signals::LinkEntry& entry);

}  // namespace polyarm::modbus
