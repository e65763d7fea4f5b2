#pragma once
/// Python's words with what a reader looks up in them. Private to the room.
#include <cstddef>
#include <string_view>
#include <vector>

#include "polyarm/launch/python_text.hpp"

namespace polyarm::ros_files::python {

struct PythonSource {
  explicit PythonSource(std::string_view text);

  std::vector<PythonToken> tokens;
  std::vector<std::size_t> close;     ///< of a bracket that opens: the one that closes it, or the end
  std::vector<std::size_t> loop;      ///< of a bracket that opens: the first `for` in it; 0: there is none
  std::vector<std::size_t> line_end;  ///< the first token of the next line
};

/// A word that is no name.
bool is_keyword(const std::string& word);

}  // namespace polyarm::ros_files::python
