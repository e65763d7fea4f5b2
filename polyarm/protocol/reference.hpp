#pragma once
/// The list of requests for people and other languages.
#include <string>

#include "polyarm/protocol/projects.hpp"

namespace polyarm::protocol {

/// The answer of `help`: the requests of a cell.
Help::Answer help_rows();
/// The same as Markdown: the table of docs/control.md.
std::string request_reference();
/// The requests by the role that they need, as Markdown: the table of docs/pendant.md.
std::string role_reference();
/// Arguments and answers of all requests as TypeScript: pendant/src/wire/requests.ts.
std::string request_typescript();

}  // namespace polyarm::protocol
