#pragma once
/// Text of others on a terminal: what would steer the terminal, or turn the order of what is read, is shown
/// instead of obeyed.
#include <string>
#include <string_view>

namespace polyarm {

/// Line feeds and tabs stay; other control characters (C0, DEL, C1, in UTF-8 or as single bytes), what turns
/// the direction of text, and bytes that are no UTF-8 become their numbers: \x1b, \x9b, \u202e.
std::string printable(std::string_view text);

/// The same for what must stay on one line: line feeds and tabs become numbers, too, so that a name cannot look
/// like a line of its own.
std::string printable_line(std::string_view text);

/// `text` as it is quoted in a message: at most 200 bytes of it, cut between characters.
std::string shortened(std::string_view text);

/// The length of the longest beginning of `text` that does not end within a character.
std::size_t whole_characters(std::string_view text);

}  // namespace polyarm
