#pragma once
/// What a path leads to, for names that users write. A name that the system cannot look up (too long, a part without
/// permission, a loop of links) leads to nothing; no function throws. Any thread.
#include <filesystem>
#include <system_error>

namespace polyarm {

inline bool is_there(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}
/// An ordinary file.
inline bool is_file(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}
inline bool is_folder(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

}  // namespace polyarm
