#pragma once
/// What an XML text needs before parsing: bounds, as the parser's time grows with the square of the number of
/// attributes of one element; and no processing instructions, as the parser takes them at the beginning only.
#include <cstddef>
#include <string>
#include <string_view>

#include "polyarm/base/bounds.hpp"

namespace polyarm {

/// Throws Error("too-large" | "xml-syntax") that names `file`.
void check_xml_bounds(std::string_view text, const std::string& file,
                      std::size_t most_bytes = bounds::kXmlBytes);

/// The text with blanks instead of processing instructions such as <?python import math ?>; lines stay.
std::string without_instructions(std::string_view text);

}  // namespace polyarm
