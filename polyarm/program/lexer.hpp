#pragma once
/// From the text of a program to its statements as tokens. Nothing fails here: what is wrong becomes a token
/// of kind bad, so that a statement that takes the rest of its line as text may hold anything.
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/program/token.hpp"

namespace polyarm::program {

/// The lines of `text` without their endings, a byte order mark dropped.
std::vector<std::string> split_lines(std::string_view text);

/// The statements of `lines`, which are file `file` of their program; empty lines and comments leave none.
std::vector<SourceLine> read_source(const std::vector<std::string>& lines, int file = 0);

/// The tokens of a piece of source that starts at `place`, for expressions inside texts.
std::vector<Token> read_tokens(std::string_view text, Place place);

/// How many bytes of `line` stand before its comment; all of them where it has none.
std::size_t end_of_code(std::string_view line);
/// `set NAME rest of the line`, without '=': its rest is text, whatever it holds.
bool takes_rest_as_text(const std::vector<Token>& tokens);

}  // namespace polyarm::program
