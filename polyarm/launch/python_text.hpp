#pragma once
/// Python source as a list of words: names, numbers, strings, signs. For reading launch files as text.
#include <string>
#include <string_view>
#include <vector>

namespace polyarm::ros_files {

struct PythonToken {
  enum class Kind { end, name, number, string, sign } kind = Kind::end;
  std::string text;        ///< of a string without quotes, its escapes resolved
  bool formatted = false;  ///< f"…"
  int line = 0;
  bool first = false;  ///< of a line that is not within brackets and continues no other
  int column = 0;      ///< blanks before it, of the first one of a line
};

/// Comments, blanks and line ends are left out. At most 100,000 tokens of at most 1 MiB of text; what lies
/// beyond, and a string that does not end, is left out.
std::vector<PythonToken> python_tokens(std::string_view text);

}  // namespace polyarm::ros_files
