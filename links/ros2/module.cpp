#include "links/ros2/port.hpp"

extern "C" __attribute__((visibility("default"))) polyarm::signals::LinkPort* polyarm_link_1(
    const polyarm::signals::LinkEntry& entry) {
  return polyarm::ros2::make_port(entry).release();
}
