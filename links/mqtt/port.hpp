#pragma once
/// MQTT based on libmosquitto: one client of one broker.
#include <memory>

#include "polyarm/signals/link.hpp"

namespace polyarm::mqtt {

std::unique_ptr<signals::LinkPort> make_client(const signals::LinkEntry& entry);

}  // namespace polyarm::mqtt
