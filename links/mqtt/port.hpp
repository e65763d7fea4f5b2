#pragma once
/// MQTT based on libmosquitto: one client of one broker.
#include <memory>

#include "polyarm/signals/link.hpp"

namespace polyarm::mqtt {

std::unique_ptr<signals::LinkPort> make_client(const signals::LinkEntry& entry);
/// The same as an edge node of Sparkplug B; make_client() calls it for a link `mqtt: sparkplug`.
std::unique_ptr<signals::LinkPort> make_sparkplug(const signals::LinkEntry& entry);

}  // namespace polyarm::mqtt
