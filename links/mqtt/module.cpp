#include "links/mqtt/port.hpp"

extern "C" __attribute__((visibility("default"))) polyarm::signals::LinkPort* polyarm_link_1(
    const polyarm::signals::LinkEntry& entry) {
  return polyarm::mqtt::make_client(entry).release();
}
