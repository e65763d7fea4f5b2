#pragma once
/// Text functions: trim, split, compare without case, find the nearest name.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace polyarm {

std::string_view trim(std::string_view s);
std::string lower(std::string_view s);
bool equal_ignoring_case(std::string_view a, std::string_view b);
/// Splits at any of `separators` and drops empty fields.
std::vector<std::string> split_words(std::string_view s, std::string_view separators = " \t\r\n");
/// Splits at every `separator`, keeps empty fields and trims all fields.
std::vector<std::string> split_fields(std::string_view s, char separator);
/// Parses all of `s` (surrounding blanks allowed) as a finite number, independent of the locale.
std::optional<double> parse_number(std::string_view s);
/// The shortest text that parses back to exactly `value`.
std::string format_number(double value);
/// The candidate that `wrong` most likely means, ignoring case: the nearest by edit distance (swapped
/// neighbours count as one edit), or the name that starts with `wrong`. Empty if no candidate is near.
std::optional<std::string> nearest_name(std::string_view wrong, std::span<const std::string> candidates);
/// Returns "; did you mean 'X'?" or "".
std::string did_you_mean(std::string_view wrong, std::span<const std::string> candidates);
std::string join(std::span<const std::string> items, std::string_view separator);

}  // namespace polyarm
