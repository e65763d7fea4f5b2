#pragma once
/// Converts messages between JSON and CDR, using their type information. Any thread.
#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "polyarm/messages/cdr.hpp"
#include "polyarm/messages/type_info.hpp"

namespace polyarm::messages {

/// The payload as JSON in the shape of its message. NaN and infinity become null. On an error `out` holds
/// what was read before the error.
CdrError to_json(const TypeInfo& type, std::span<const std::byte> payload, nlohmann::json& out);

/// The payload of a JSON message. A missing field is zero, false or empty; null for a number is NaN; a time
/// or duration may be a number of seconds; unknown keys are ignored. Throws Error("bad-message") with the
/// field whose value does not fit.
std::vector<std::byte> from_json(const TypeInfo& type, const nlohmann::json& message);

}  // namespace polyarm::messages
