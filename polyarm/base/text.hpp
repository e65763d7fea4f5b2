#pragma once
/// Small things done with text everywhere: trimming, splitting, comparing without case, the nearest name.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace polyarm {

std::string_view trim(std::string_view s);
std::string lower(std::string_view s);
bool equal_ignoring_case(std::string_view a, std::string_view b);
/// Split at any of `separators`, empty fields dropped.
std::vector<std::string> split_words(std::string_view s, std::string_view separators = " \t\r\n");
/// Split at every `separator`, empty fields kept, fields trimmed.
std::vector<std::string> split_fields(std::string_view s, char separator);
/// A number that fills all of `s` (surrounding blanks allowed), finite; locale plays no part.
std::optional<double> parse_number(std::string_view s);
/// The shortest text that parses back to exactly `value`.
std::string format_number(double value);
/// The candidate that `wrong` was most likely meant to be, case ignored: by edit distance of the whole name, in
/// which swapped neighbours count as one, or the name that `wrong` is the beginning of; nothing where none is
/// near.
std::optional<std::string> nearest_name(std::string_view wrong, std::span<const std::string> candidates);
/// "; did you mean 'X'?" or nothing.
std::string did_you_mean(std::string_view wrong, std::span<const std::string> candidates);
std::string join(std::span<const std::string> items, std::string_view separator);

}  // namespace polyarm
