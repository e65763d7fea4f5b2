#include "polyarm/base/printable.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/shell_word.hpp"

namespace polyarm {

namespace {

/// Bytes of a character by its first one; 0: none begins so.
std::size_t length_of(unsigned char first) {
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF) return 2;
  if (first >= 0xE0 && first <= 0xEF) return 3;
  return first >= 0xF0 && first <= 0xF4 ? 4 : 0;
}

bool continues(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

/// Whether a whole character of `length` bytes stands at the front.
bool is_whole(std::string_view text, std::size_t length) {
  if (length == 0 || text.size() < length) return false;
  for (std::size_t i = 1; i < length; ++i)
    if (!continues(text[i])) return false;
  return true;
}

std::uint32_t code_of(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first;
  std::uint32_t out = first & (0xFFu >> (character.size() + 1));
  for (const char c : character.substr(1)) out = out << 6 | (static_cast<unsigned char>(c) & 0x3Fu);
  return out;
}

/// Overlong forms and halves of pairs are no characters.
bool is_character(std::uint32_t code, std::size_t length) {
  if (length == 3) return code >= 0x800 && !(code >= 0xD800 && code <= 0xDFFF);
  return length != 4 || (code >= 0x10000 && code <= 0x10FFFF);
}

bool steers(std::uint32_t code, bool one_line) {
  if (code < 0x20) return one_line || (code != '\n' && code != '\t');
  return (code >= 0x7F && code <= 0x9F) || code == 0x061C || code == 0x200E || code == 0x200F ||
         (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
}

/// "\x1b" of a byte, "\u202e" of a character. Without fmt: the kit for plugins links without it.
std::string escaped(std::uint32_t code) {
  std::array<char, 16> out{};
  const int size = std::snprintf(out.data(), out.size(), code < 0x100 ? "\\x%02x" : "\\u%04x", code);
  return {out.data(), static_cast<std::size_t>(size)};
}

std::string shown(std::string_view text, bool one_line) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = length_of(static_cast<unsigned char>(text[0]));
    const bool whole = is_whole(text, length) && is_character(code_of(text.substr(0, length)), length);
    const std::string_view character = text.substr(0, whole ? length : 1);
    text.remove_prefix(character.size());
    const std::uint32_t code = whole ? code_of(character) : static_cast<unsigned char>(character[0]);
    if (whole && !steers(code, one_line))
      out += character;
    else
      out += escaped(code);
  }
  return out;
}

}  // namespace

std::string printable(std::string_view text) {
  return shown(text, false);
}

std::string printable_line(std::string_view text) {
  return shown(text, true);
}

std::string shortened(std::string_view text) {
  constexpr std::size_t kLongest = bounds::kQuotedBytes;
  if (text.size() <= kLongest) return std::string(text);
  const std::string_view cut = text.substr(0, kLongest);
  return std::string(cut.substr(0, whole_characters(cut))) + "…";
}

std::size_t whole_characters(std::string_view text) {
  for (std::size_t back = 1; back <= 3 && back <= text.size(); ++back) {
    const char c = text[text.size() - back];
    if (continues(c)) continue;
    return length_of(static_cast<unsigned char>(c)) > back ? text.size() - back : text.size();
  }
  return text.size();
}

std::string shell_word(std::string_view text) {
  const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) || std::string_view("/._-:=+,@%").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (plain) return std::string(text);
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace polyarm
