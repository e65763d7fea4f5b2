#pragma once
/// The folder in which a run keeps copies of its data files, and the lock that reserves it.
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "polyarm/base/reach.hpp"
#include "polyarm/data/file_lookup.hpp"

namespace polyarm::cell {

/// A lock held by the process that runs a cell. The kernel releases it if the process is killed.
class StateLock {
 public:
  /// `file`: lock file of the cell, created if needed. Waits up to `wait_limit_ms` for another process. Throws
  /// Error("cell-in-use") that names the process.
  StateLock(const std::filesystem::path& file, int wait_limit_ms);
  ~StateLock();
  StateLock(const StateLock&) = delete;
  StateLock& operator=(const StateLock&) = delete;

 private:
  int fd_ = -1;
};

/// A run keeps copies of its data files in `DIR/.state/`, so every run starts from the user's files and git
/// sees no changes. A live data set is bound to the user's own file instead. Accesses the disk: do not use on
/// the cell thread, except in lock-step.
class StateFolder {
 public:
  /// Empties the folder unless `keep`, and removes temporary files of killed runs. `elsewhere`: a private
  /// folder to use instead. `cell`: file of the cell; two cells of one folder may run at the same time, but
  /// one cell only once. Throws Error("cell-in-use" | "outside-cell" | "bad-state").
  StateFolder(std::filesystem::path cell_folder, std::set<std::string> live, bool keep,
              const std::filesystem::path& elsewhere = {}, int wait_limit_ms = 500,
              const std::string& cell = "cell.yaml");

  /// Loads the data file `name` and its points in their present state; copies them into the folder at first
  /// use.
  data::LoadedFiles load(const std::string& name, const Location& where) const;
  /// The same from the user's own files. Throws like load().
  data::LoadedFiles original(const std::string& name, const Location& where) const {
    return data::load_files(name, folder_, where);
  }
  /// Replaces the copies of the data file `name` and its points by the user's present files. Throws like
  /// load().
  void renew(const std::string& name, const Location& where) const;
  /// Folder in which the set `name` is read and written.
  std::filesystem::path folder_of(const std::string& name) const;
  bool is_live(const std::string& set) const { return live_.contains(set); }
  bool has_live() const { return !live_.empty(); }
  const std::filesystem::path& path() const { return state_; }

 private:
  void bring(const std::filesystem::path& original, bool again = false) const;

  std::filesystem::path folder_, state_;
  std::set<std::string> live_;
  std::shared_ptr<const StateLock> lock_;  // copies belong to one run
  std::shared_ptr<ReachGrant> grant_;      ///< for `elsewhere`
};

}  // namespace polyarm::cell
