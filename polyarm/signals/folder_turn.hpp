#pragma once
/// Lets several Polyarm processes take turns in rewriting files of a folder, and marks files that were
/// written during such a turn.
#include <filesystem>
#include <string>

#include "polyarm/base/descriptor.hpp"

namespace polyarm::signals {

/// A lock on a folder that every process holds while it changes data there. It has no effect on file systems
/// without locks. One thread.
class FolderTurn {
 public:
  explicit FolderTurn(const std::filesystem::path& folder);
  /// Takes the lock. Returns false if others hold it for longer than 20 ms; the caller then continues without
  /// it.
  bool take();
  void give_back();

 private:
  Descriptor folder_;
};

/// Marks a file that was written during a turn: its writer had merged the former content. The mark is an
/// extended attribute with the hash of the text, so it becomes invalid when others rewrite the file. Some
/// file systems do not store marks.
void mark_as_merged(int file, const std::string& text);
bool is_merged(int file, const std::string& text);

}  // namespace polyarm::signals
