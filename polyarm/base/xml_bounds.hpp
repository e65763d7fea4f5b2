#pragma once
/// Checks the size of an XML text before parsing: the parser's time grows with the square of the number of
/// attributes of one element.
#include <cstddef>
#include <string>
#include <string_view>

#include "polyarm/base/bounds.hpp"

namespace polyarm {

/// Throws Error("too-large" | "xml-syntax") that names `file`.
void check_xml_bounds(std::string_view text, const std::string& file,
                      std::size_t most_bytes = bounds::kXmlBytes);

}  // namespace polyarm
