#pragma once
/// Makes the reference of requests: for `help`, for the docs and for TypeScript.
#include <string>

#include "polyarm/protocol/projects.hpp"

namespace polyarm::protocol {

/// The answer of `help`: the requests of a cell.
Help::Answer help_rows();
/// All requests by family with arguments and answers as Markdown, for docs/requests.md.
std::string request_reference();
/// The requests by required role as Markdown, for docs/pendant.md.
std::string role_reference();
/// Arguments and answers of all requests as TypeScript, for pendant/src/wire/requests.ts.
std::string request_typescript();

}  // namespace polyarm::protocol
