#pragma once
/// What stands in a message: plain text, or JSON.
#include <optional>
#include <string>

#include "polyarm/signals/link.hpp"

namespace polyarm::mqtt {

/// Bytes of a message; a longer one is refused.
inline constexpr std::size_t kLongestMessage = 65536;

/// The message that tells `value`.
std::string payload_of(const signals::LinkTag& tag, const data::Value& value);
/// The value in a message; nothing, and why, where it may not be taken. A message may be anything.
std::optional<data::Value> value_of_payload(const signals::LinkTag& tag, const std::string& payload,
                                            std::string& why);

}  // namespace polyarm::mqtt
