/// polyarm_link_modbus: the process that speaks Modbus TCP for a link of a cell.
#include "links/modbus/port.hpp"
#include "polyarm/signals/link_process.hpp"

int main(int argc, char** argv) {
  using namespace polyarm;
  return signals::serve_link(argc, argv, [](const signals::LinkEntry& entry) {
    return (entry.server ? modbus::make_server(entry) : modbus::make_client(entry)).release();
  });
}
