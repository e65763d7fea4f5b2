#include "links/modbus/port.hpp"

extern "C" __attribute__((visibility("default"))) polyarm::signals::LinkPort* polyarm_link_1(
    const polyarm::signals::LinkEntry& entry) {
  using namespace polyarm::modbus;
  return (entry.server ? make_server(entry) : make_client(entry)).release();
}
