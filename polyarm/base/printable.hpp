#pragma once
/// Makes foreign text safe to print: characters that control the terminal or change the text direction become
/// visible escapes.
#include <string>
#include <string_view>

namespace polyarm {

/// Keeps line feeds and tabs. Other control characters (C0, DEL, C1, in UTF-8 or as single bytes), characters
/// that change the text direction and invalid UTF-8 become escapes: \x1b, \x9b, \u202e.
std::string printable(std::string_view text);

/// The same for one line: it also escapes line feeds and tabs, so that a name cannot imitate a separate line.
std::string printable_line(std::string_view text);

/// `text` for quoting in a message: at most 200 bytes, cut between characters.
std::string shortened(std::string_view text);

/// The length of the longest prefix of `text` that does not end inside a character.
std::size_t whole_characters(std::string_view text);

}  // namespace polyarm
