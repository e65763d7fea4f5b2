#pragma once
#include <string>

#include "polyarm/language/ast.hpp"

namespace polyarm::cell {

/// Tells a program with all that it includes from others, and from itself before it was changed: 16 hexadecimal
/// digits, not for security.
std::string program_hash(const program::Program& program);

}  // namespace polyarm::cell
