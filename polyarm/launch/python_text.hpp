#pragma once
/// Splits Python source into tokens: names, numbers, strings and signs.
#include <string>
#include <string_view>
#include <vector>

namespace polyarm::ros_files {

struct PythonToken {
  enum class Kind { end, name, number, string, sign } kind = Kind::end;
  std::string text;        ///< of a string: without quotes, escapes resolved
  bool formatted = false;  ///< f"…"
  int line = 0;
  bool first = false;  ///< first token of a logical line
  int column = 0;      ///< for the first token of a line: its indentation
};

/// Leaves out comments, blanks and line ends. At most 100,000 tokens from at most 1 MiB of text; the rest,
/// and an unterminated string, is left out.
std::vector<PythonToken> python_tokens(std::string_view text);

}  // namespace polyarm::ros_files
