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

/// The payload of a message in JSON. What is left out is zero, false or empty, null as a number is no number,
/// a time or duration may be a number of seconds, and keys that the type does not have are left out. Throws
/// Error("bad-message") that names the field whose value does not fit.
std::vector<std::byte> from_json(const TypeInfo& type, const nlohmann::json& message);

}  // namespace polyarm::messages
