#pragma once
/// Paths, under the names that rcpputils had before std::filesystem.
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>

#include "polyarm_ros/standard.hpp"

namespace rcpputils::fs {
class path : public std::filesystem::path {
 public:
  using std::filesystem::path::path;
  path(const std::filesystem::path& other) : std::filesystem::path(other) {}  // NOLINT
  bool exists() const { return std::filesystem::exists(*this); }
  bool is_directory() const { return std::filesystem::is_directory(*this); }
  bool is_regular_file() const { return std::filesystem::is_regular_file(*this); }
  std::uint64_t file_size() const { return std::filesystem::file_size(*this); }
  path parent_path() const { return std::filesystem::path::parent_path(); }
  path filename() const { return std::filesystem::path::filename(); }
  path extension() const { return std::filesystem::path::extension(); }
  path operator/(const path& other) const {
    return static_cast<const std::filesystem::path&>(*this) /
           static_cast<const std::filesystem::path&>(other);
  }
  path operator/(const std::string& other) const { return *this / path(other); }
  path operator/(const char* other) const { return *this / path(other); }
};
inline bool exists(const path& p) {
  return p.exists();
}
inline bool is_directory(const path& p) {
  return p.is_directory();
}
inline bool is_regular_file(const path& p) {
  return p.is_regular_file();
}
inline path temp_directory_path() {
  return std::filesystem::temp_directory_path();
}
inline path current_path() {
  return std::filesystem::current_path();
}
inline bool create_directories(const path& p) {
  std::error_code error;
  std::filesystem::create_directories(p, error);
  return std::filesystem::is_directory(p, error);
}
inline bool remove(const path& p) {
  std::error_code error;
  return std::filesystem::remove(p, error);
}
inline bool remove_all(const path& p) {
  std::error_code error;
  return std::filesystem::remove_all(p, error) > 0;
}
inline path remove_extension(const path& p, int times = 1) {
  std::filesystem::path out = p;
  for (int i = 0; i < times; ++i) out.replace_extension();
  return out;
}
}  // namespace rcpputils::fs
