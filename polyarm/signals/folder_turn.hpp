#pragma once
/// Lets several Polyarm processes take turns in rewriting files of one folder, and marks files that were
/// written in such a turn.
#include <filesystem>
#include <string>

#include "polyarm/base/descriptor.hpp"

namespace polyarm::signals {

/// The lock on a folder that every process holds while it changes data there; without effect on file systems
/// without locks. One thread.
class FolderTurn {
 public:
  explicit FolderTurn(const std::filesystem::path& folder);
  /// False if others hold it for longer than 20 ms; the caller then proceeds without it.
  bool take();
  void give_back();

 private:
  Descriptor folder_;
};

/// Marks a file that was written in the writer's turn: its writer had merged the former content. The mark, an
/// extended attribute, holds the hash of the text, so it becomes invalid with the next rewrite by others.
/// Some file systems do not store marks.
void mark_as_merged(int file, const std::string& text);
bool is_merged(int file, const std::string& text);

}  // namespace polyarm::signals
