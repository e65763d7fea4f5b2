#pragma once
/// Changing a data set's file so that nothing is ever lost: one writer at a time, the file either old or new
/// at any moment, and what it was before kept in `.state/history/<file>/` beside it.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/data/import_format.hpp"

namespace polyarm::data {

/// How many earlier versions of a file are kept.
constexpr std::size_t kVersionsKept = 200;

/// Runs `change` on the set as it is in the file now (an empty one where there is no file) and writes it,
/// while no other program that changes sets this way can. `what` is noted with the version before. Nothing is
/// written where nothing changed. Throws Error: "in-use" when another writer does not end within
/// `patience_ms`; what is wrong with the file, which then stays as it is; "unwritable".
ImportFile edit_set(const std::filesystem::path& path, const std::string& what,
                    const std::function<void(ImportFile&)>& change, int patience_ms = 5000);

/// An earlier version of a file.
struct SetVersion {
  int number = 0;
  std::string when;  ///< local time at which it was replaced
  std::string what;  ///< the change that replaced it
  std::filesystem::path file;
  bool absent = false;  ///< there was no file then: the change made it
};
/// Oldest first.
std::vector<SetVersion> history(const std::filesystem::path& path);
/// Throws Error("no-history") where fewer than `steps` changes are known, and where `steps` is 0.
void require_history(const std::filesystem::path& path, std::size_t steps);
/// Takes the last `steps` changes back. What was there is kept in `.state/history/<file>/undone/`. Throws
/// Error("no-history") where fewer are known.
void undo(const std::filesystem::path& path, std::size_t steps, int patience_ms = 5000);
/// Deletes the file; undo brings it back.
void delete_set(const std::filesystem::path& path, int patience_ms = 5000);

/// The set without the name: its lines go, all others stay as they are. Throws Error("unknown-name").
ImportFile without(const ImportFile& set, const std::string& name);

}  // namespace polyarm::data
