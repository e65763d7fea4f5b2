#pragma once
/// Breakpoints of a file go with their lines while its text is changed.

#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm::cell {

using TextLines = std::vector<std::string>;

/// Where each line of `before` is in `after`, both counted from 1: [0] is where line 1 is; 0: it is gone.
/// Blanks around a line do not count. A line that was changed in its place is the line in that place.
std::vector<int> where_lines_are(const TextLines& before, const TextLines& after);

/// The breakpoints of one file, in the newest text of it that anybody has told: a draft, or what is saved.
struct FileBreakpoints {
  std::string file;
  std::vector<int> lines = {};  ///< ascending, each once
  std::optional<TextLines> text =
      std::nullopt;  ///< what they are lines of; none: the program's that has the file

  void add(int line);
  void drop(int line);
  /// The file reads `now`: each stays with its line, and goes where that is gone.
  void follow(TextLines now);
};

/// Of files by their names in the cell's folder, in the order in which they came.
class Breakpoints {
 public:
  /// Null where the file has none and its text is not known.
  FileBreakpoints* find(const std::string& file);
  /// The same, made where there is none.
  FileBreakpoints& of(const std::string& file);
  std::vector<FileBreakpoints>& files() { return files_; }
  const std::vector<FileBreakpoints>& files() const { return files_; }
  std::vector<Location> all() const;

 private:
  std::vector<FileBreakpoints> files_;
};

}  // namespace polyarm::cell
