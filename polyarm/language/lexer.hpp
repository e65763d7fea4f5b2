#pragma once
/// Splits the text of a program into statements of tokens. It reports no errors: a fault becomes a token of
/// kind bad, so that a statement with a rest of text may contain anything. Any thread.
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/language/token.hpp"

namespace polyarm::program {

/// The lines of `text` without line endings, and without a byte order mark.
std::vector<std::string> split_lines(std::string_view text);

/// The statements of `lines`, which are file `file` of their program; empty lines and comments give none.
std::vector<SourceLine> read_source(const std::vector<std::string>& lines, int file = 0);

/// The tokens of a piece of source that starts at `place`, for expressions in texts.
std::vector<Token> read_tokens(std::string_view text, Place place);

/// The number of bytes of `line` before its comment; all if it has none.
std::size_t end_of_code(std::string_view line);
/// `set NAME rest of the line`, without '=': the rest is text with any content.
bool takes_rest_as_text(const std::vector<Token>& tokens);

}  // namespace polyarm::program
