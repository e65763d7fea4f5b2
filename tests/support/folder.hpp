#pragma once
/// A temporary folder for a test.
#include <stdlib.h>

#include <filesystem>
#include <string>

#include "polyarm/base/file.hpp"

namespace polyarm::test {

/// Creates a new folder and deletes it at the end.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "polyarm_XXXXXX").string();
    if (!::mkdtemp(pattern.data())) throw Error("no-folder", "no folder can be made like " + pattern);
    path_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::string write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    write_file_atomically(path_ / name, text);
    return (path_ / name).string();
  }

 private:
  std::filesystem::path path_;
};

}  // namespace polyarm::test
