#pragma once
/// Numbers of text files, and lines of headers. Private to this room.
#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>

namespace polyarm::clouds {

/// The next line without its end; `text` begins after it.
inline std::string_view next_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

/// The next word; empty at the end.
inline std::string_view next_word(std::string_view& text) {
  std::size_t i = 0;
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (i < text.size() && blank(text[i])) ++i;
  std::size_t end = i;
  while (end < text.size() && !blank(text[end])) ++end;
  const std::string_view word = text.substr(i, end - i);
  text.remove_prefix(end);
  return word;
}

/// A word of a file for a message, at most 40 bytes of it.
inline std::string in_quotes(std::string_view word) {
  return "'" + std::string(word.substr(0, 40)) + "'";
}

/// False if the word is no number; "nan" is one.
inline bool read_number(std::string_view word, double& out) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  if (error == std::errc::result_out_of_range && end == word.data() + word.size()) {
    out = HUGE_VAL;
    return true;
  }
  return error == std::errc() && end == word.data() + word.size() && !word.empty();
}
inline bool read_count(std::string_view word, std::size_t& out) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  return error == std::errc() && end == word.data() + word.size() && !word.empty();
}

}  // namespace polyarm::clouds
