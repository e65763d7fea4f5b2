#pragma once
/// Converts values of tags to MQTT payloads (plain text or JSON) and back.
#include <optional>
#include <string>

#include "polyarm/base/bounds.hpp"
#include "polyarm/signals/link.hpp"

namespace polyarm::mqtt {

/// Largest payload, bytes; a longer one is refused.
inline constexpr std::size_t kLongestMessage = bounds::kMqttMessageBytes;

/// The payload for `value`.
std::string payload_of(const signals::LinkTag& tag, const data::Value& value);
/// The value in a payload, which may be any bytes. Nothing if it is refused, with the reason in `why`.
std::optional<data::Value> value_of_payload(const signals::LinkTag& tag, const std::string& payload,
                                            std::string& why);

}  // namespace polyarm::mqtt
