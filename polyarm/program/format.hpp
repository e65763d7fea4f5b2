#pragma once
/// One way to write a program: two blanks for each block, one between words and around operators.
#include <string>
#include <string_view>

namespace polyarm::program {

/// The same program in that form: every comment and every word stays, in its line. Lines that take their rest
/// as text (`set NAME text`, `load FILE`) keep it as it is; more than one empty line becomes one. For a text
/// that parses without errors; formatting twice changes nothing.
std::string format(std::string_view text);

}  // namespace polyarm::program
