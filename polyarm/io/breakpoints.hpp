#pragma once
/// Keeps the breakpoints of a file at their lines while its text changes.

#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm::cell {

using TextLines = std::vector<std::string>;

/// The line number in `after` of each line of `before`, counted from 1: [0] belongs to line 1; 0: the line
/// was deleted. Ignores blanks around a line. A line changed in place keeps its place.
std::vector<int> where_lines_are(const TextLines& before, const TextLines& after);

/// The breakpoints of one file, for its newest known text: a draft or the saved file.
struct FileBreakpoints {
  std::string file;
  std::vector<int> lines = {};  ///< ascending, each once
  std::optional<TextLines> text =
      std::nullopt;  ///< the text that the lines belong to; empty: the text of the program with this file

  void add(int line);
  void drop(int line);
  /// The file now reads `now`: breakpoints move with their lines; those of deleted lines are removed.
  void follow(TextLines now);
};

/// Breakpoints of files, by file name relative to the cell's folder, in order of addition.
class Breakpoints {
 public:
  /// Null if the file has no breakpoints and no known text.
  FileBreakpoints* find(const std::string& file);
  /// The same; creates an entry if there is none.
  FileBreakpoints& of(const std::string& file);
  std::vector<FileBreakpoints>& files() { return files_; }
  const std::vector<FileBreakpoints>& files() const { return files_; }
  std::vector<Location> all() const;

 private:
  std::vector<FileBreakpoints> files_;
};

}  // namespace polyarm::cell
