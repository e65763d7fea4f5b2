#pragma once
/// Texts that the reader and the writer of data files share. Any thread.
#include <string>
#include <string_view>

#include "polyarm/data/import_format.hpp"

namespace polyarm::data {

/// The first 60 bytes of a text in quotes, without control characters.
std::string quote(std::string_view text);

/// The line that sets the format of points; empty for none.
std::string header(const PointFormat& format);

/// Where a comment outside quotes starts; npos without a comment.
std::size_t comment_at(std::string_view line);

}  // namespace polyarm::data
