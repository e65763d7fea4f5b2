#pragma once
/// Edits the file of a data set without losing data: one writer at a time; at any moment the file is either
/// old or new; its former content is kept in `.state/history/<file>/` beside it. Reads and writes the disk,
/// and waits for other writers.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/data/import_format.hpp"

namespace polyarm::data {

/// The number of earlier versions that are kept for each file.
constexpr std::size_t kVersionsKept = 200;

/// Calls `change` with the present content of the file (an empty set if there is no file) and writes the
/// result. Other programs that use this function wait meanwhile. `what` is stored with the former version.
/// Writes nothing if nothing changed. Throws Error: "in-use" if another writer does not finish within
/// `wait_limit_ms`; the problems of the file, which then stays unchanged; "unwritable".
ImportFile edit_set(const std::filesystem::path& path, const std::string& what,
                    const std::function<void(ImportFile&)>& change, int wait_limit_ms = 5000);

/// The same for a text file of any kind: `change` gets the present text (empty if there is no file) and
/// returns the new one.
void edit_text(const std::filesystem::path& path, const std::string& what,
               const std::function<std::string(const std::string&)>& change, int wait_limit_ms = 5000);

/// An earlier version of a file.
struct SetVersion {
  int number = 0;
  std::string when;  ///< local time when it was replaced
  std::string what;  ///< the change that replaced it
  std::filesystem::path file;
  bool absent = false;  ///< the change created the file
};
/// Oldest first.
std::vector<SetVersion> history(const std::filesystem::path& path);
/// Throws Error("no-history") if fewer than `steps` changes are kept, or if `steps` is 0.
void require_history(const std::filesystem::path& path, std::size_t steps);
/// Undoes the last `steps` changes. The undone content is kept in `.state/history/<file>/undone/`. Throws
/// Error("no-history") if fewer changes are kept.
void undo(const std::filesystem::path& path, std::size_t steps, int wait_limit_ms = 5000);
/// Deletes the file; undo restores it.
void delete_set(const std::filesystem::path& path, int wait_limit_ms = 5000);

/// The set without the name: removes its lines, and leaves all others unchanged. Throws
/// Error("unknown-name").
ImportFile without(const ImportFile& set, const std::string& name);

}  // namespace polyarm::data
