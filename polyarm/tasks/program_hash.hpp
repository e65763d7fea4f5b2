#pragma once
/// Identifies the version of a program.
#include <string>

#include "polyarm/language/ast.hpp"

namespace polyarm::cell {

/// Hash of a program and all files that it includes: 16 hexadecimal digits; not for security. It changes with
/// any line.
std::string program_hash(const program::Program& program);

}  // namespace polyarm::cell
