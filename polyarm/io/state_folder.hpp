#pragma once
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "polyarm/data/file_lookup.hpp"

namespace polyarm::cell {

/// Held by the one process that runs a cell; the system gives it back if that is killed.
class StateLock {
 public:
  /// `file`: the lock of the cell, made if it is not there. Waits so long for another process. Throws
  /// Error("cell-in-use") with the process that has it.
  StateLock(const std::filesystem::path& file, int patience_ms);
  ~StateLock();
  StateLock(const StateLock&) = delete;
  StateLock& operator=(const StateLock&) = delete;

 private:
  int fd_ = -1;
};

/// Where a run keeps what it writes to its data files: copies in `DIR/.state/`, so that every run starts from
/// the files as the user wrote them and git sees no change. A data set that is live is bound to its own file
/// instead. Reads and writes disk: not for the cell thread, except in lock-step.
class StateFolder {
 public:
  /// Empties the folder unless `keep`, and removes temporary files that killed runs left. `elsewhere`: kept
  /// there instead, in a folder for this alone. `cell`: the file of the cell; two cells of one folder may run
  /// side by side, one cell twice may not. Throws Error("cell-in-use" | "outside-cell" | "bad-state").
  StateFolder(std::filesystem::path cell_folder, std::set<std::string> live, bool keep,
              const std::filesystem::path& elsewhere = {}, int patience_ms = 500,
              const std::string& cell = "cell.yaml");

  /// The data file called `name` as it is now, with its points; copied into the folder at first sight.
  data::LoadedFiles load(const std::string& name, const Location& where) const;
  /// The same as the user has it now. Throws as load().
  data::LoadedFiles original(const std::string& name, const Location& where) const {
    return data::load_files(name, folder_, where);
  }
  /// Replaces the copies of what `name` names by the files as the user has them now. Throws as load().
  void renew(const std::string& name, const Location& where) const;
  /// Where the set called `name` is read and written.
  std::filesystem::path folder_of(const std::string& name) const;
  bool is_live(const std::string& set) const { return live_.contains(set); }
  bool has_live() const { return !live_.empty(); }
  const std::filesystem::path& path() const { return state_; }

 private:
  void bring(const std::filesystem::path& original, bool again = false) const;

  std::filesystem::path folder_, state_;
  std::set<std::string> live_;
  std::shared_ptr<const StateLock> lock_;  // copies are of one run
  std::shared_ptr<ReachGrant> grant_;      ///< to `elsewhere`
};

}  // namespace polyarm::cell
