#pragma once
/// A temporary folder of a verb that runs cells.
#include <stdlib.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "polyarm/base/error.hpp"

namespace polyarm::apps {

/// Made now, deleted with all that is in it at the end.
class Scratch {
 public:
  /// `verb`: part of its name. Throws Error("no-folder").
  explicit Scratch(const std::string& verb) {
    std::string name = (std::filesystem::temp_directory_path() / ("polyarm-" + verb + "-XXXXXX")).string();
    if (!::mkdtemp(name.data())) throw Error("no-folder", "no folder can be made in " + name);
    path_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// The folder for the data files of one run.
  std::filesystem::path of(std::uint64_t which) const { return path_ / std::to_string(which) / "data"; }
  /// Deletes what a run has left.
  void drop(std::uint64_t which) const {
    std::error_code ignored;
    std::filesystem::remove_all(path_ / std::to_string(which), ignored);
  }

 private:
  std::filesystem::path path_;
};

}  // namespace polyarm::apps
