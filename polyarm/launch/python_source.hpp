#pragma once
/// Python source as tokens, with indexes for the reader. Private to the room.
#include <cstddef>
#include <string_view>
#include <vector>

#include "polyarm/launch/python_text.hpp"

namespace polyarm::ros_files::python {

struct PythonSource {
  explicit PythonSource(std::string_view text);

  std::vector<PythonToken> tokens;
  std::vector<std::size_t> close;     ///< for an opening bracket: the closing one, or the end
  std::vector<std::size_t> loop;      ///< for an opening bracket: the first `for` in it; 0: none
  std::vector<std::size_t> line_end;  ///< the first token of the next line
};

/// True for a word that is not a name.
bool is_keyword(const std::string& word);

}  // namespace polyarm::ros_files::python
