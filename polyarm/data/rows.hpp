#pragma once
/// A table as text, such as a CSV of a spreadsheet or of a camera, as a list of rows.
#include <string>
#include <string_view>

#include "polyarm/data/value.hpp"

namespace polyarm::data {

inline constexpr std::size_t kMostRowBytes = std::size_t{1} << 20;
inline constexpr std::size_t kMostRows = 10'000, kMostColumns = 64;

/// Columns are separated by semicolons, tabs or commas: by the first of these that the first line has. A
/// field may be quoted ("a ""b"""). Empty lines and lines that begin with # are left out. Fields are numbers
/// ("12.5", "12.5mm"), true or false, or texts. If the first line has only different texts, it names the
/// columns, and each row is a record; else each row is a list. Throws Error("bad-value") with the line: rows
/// of different lengths, an open quote, or too much of anything. `file`: for messages.
List read_rows(std::string_view text, const std::string& file);

}  // namespace polyarm::data
