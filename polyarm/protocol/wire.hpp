#pragma once
/// Requests and replies as text: one JSON object a line, as sockets carry them.
#include <optional>
#include <string>

#include "polyarm/protocol/request.hpp"

namespace polyarm::protocol {

/// Brackets outside texts that are nested deeper (64) than those of any request: copying and printing JSON
/// recurses.
bool nested_too_deep(const std::string& line);

/// Throws Error("bad-request") for what is no JSON object.
Any parse_request(const std::string& line);
/// The `id` of a request; null where it has none. Throws Error("bad-request") for one that is too long.
Any request_id(const Any& fields);
/// The request of a cell that the text `request` names. Throws Error("bad-argument" | "unknown-request").
const RequestType& request_type_of(const Any& fields);
/// Throws Error("bad-argument") for an argument that is missing, unknown or of the wrong type.
Request read_request(const RequestType& type, const Any& fields);
/// The arguments of a request, with its name and the id.
std::string request_line(const Request& request, const Any& id = {});

/// {"id", "ok": true, "result", "more"?} or {"id", "ok": false, "error": {code, what, advice, where, facts?, all?}}.
std::string reply_line(const Reply& reply, const Any& id);
/// The same for a result that is at hand as JSON.
std::string result_line(const Any& result, const Any& id);
std::string refusal_line(const Error& error, const Any& id);

}  // namespace polyarm::protocol
