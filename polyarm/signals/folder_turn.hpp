#pragma once
/// How several processes of ours that rewrite files of one folder take turns, and how a file shows that it was
/// written in such a turn.
#include <filesystem>
#include <string>

#include "polyarm/base/descriptor.hpp"

namespace polyarm::signals {

/// The lock on a folder that all who change data in it by our rules hold meanwhile; none where the file
/// system has none. One thread.
class FolderTurn {
 public:
  explicit FolderTurn(const std::filesystem::path& folder);
  /// False where others have it for so long (20 ms) that they have to be left out of account.
  bool take();
  void give_back();

 private:
  Descriptor folder_;
};

/// A file that was written in the writer's turn says so: its writer had merged all that was in the file before.
/// The mark, an extended attribute, holds the hash of the text, so that it ends with the next rewrite of
/// others. Some file systems keep no marks.
void mark_as_merged(int file, const std::string& text);
bool is_merged(int file, const std::string& text);

}  // namespace polyarm::signals
