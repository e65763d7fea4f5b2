#pragma once
/// Requests and replies as text: one JSON object per line, as sockets carry them.
#include <optional>
#include <string>

#include "polyarm/protocol/request.hpp"

namespace polyarm::protocol {

/// True if brackets outside texts are nested deeper (64) than any request needs. Copying and printing JSON is
/// recursive, so this bounds the stack.
bool nested_too_deep(const std::string& line);

/// Throws Error("bad-request") if the line is not a JSON object.
Any parse_request(const std::string& line);
/// The `id` of a request; null if it has none. Throws Error("bad-request") if it is too long.
Any request_id(const Any& fields);
/// The cell's request named by `request`. Throws Error("bad-argument" | "unknown-request").
const RequestType& request_type_of(const Any& fields);
/// Throws Error("bad-argument") if an argument is missing, unknown or of the wrong type.
Request read_request(const RequestType& type, const Any& fields);
/// The arguments of a request, with its name and id.
std::string request_line(const Request& request, const Any& id = {});

/// {"id", "ok": true, "result", "more"?} or {"id", "ok": false, "error": {code, what, advice, where, facts?, all?}}.
std::string reply_line(const Reply& reply, const Any& id);
/// The same for a result that is already JSON.
std::string result_line(const Any& result, const Any& id);
std::string refusal_line(const Error& error, const Any& id);

}  // namespace polyarm::protocol
