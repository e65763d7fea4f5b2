/// polyarm_link_mqtt: the process that speaks MQTT for a link of a cell.
#include "links/mqtt/port.hpp"
#include "polyarm/signals/link_process.hpp"

int main(int argc, char** argv) {
  using namespace polyarm;
  return signals::serve_link(
      argc, argv, [](const signals::LinkEntry& entry) { return mqtt::make_client(entry).release(); });
}
