#pragma once
/// The standard layout of a program: two blanks per block, one between words and around operators. Any
/// thread.
#include <string>
#include <string_view>

namespace polyarm::program {

/// The same program in that layout; every comment and every word stays on its line. Lines with a rest of text
/// (`set NAME text`, `load FILE`) keep it unchanged; several empty lines become one. The text must parse
/// without errors. Formatting twice changes nothing.
std::string format(std::string_view text);

}  // namespace polyarm::program
