#pragma once
/// Reads files out of a ZIP archive in memory. Nothing is written to the disk, so paths, links and modes in
/// the archive mean nothing. Source: PKWARE's APPNOTE 6.3, 4.3 and 4.4, without ZIP64, encryption and parts.
#include <cstddef>
#include <map>
#include <string>

namespace polyarm::meshes {

class ZipArchive {
 public:
  /// `bytes` outlives the archive. `most`: of all files that are read, together, bytes. Throws Error("bad-mesh")
  /// that names the archive.
  ZipArchive(const std::string& bytes, std::string name, std::size_t most);

  bool has(const std::string& file) const { return entries_.contains(file); }
  /// Throws Error("bad-mesh" | "large-mesh").
  std::string read(const std::string& file);

 private:
  struct Entry {
    std::size_t header = 0, packed = 0, size = 0;
    unsigned method = 0, flags = 0, checksum = 0;
  };
  [[noreturn]] void refuse(const std::string& why) const;
  std::size_t number(std::size_t at, std::size_t count) const;
  std::size_t directory() const;

  const std::string& bytes_;
  const std::string name_;
  std::size_t left_;
  std::map<std::string, Entry> entries_;
};

}  // namespace polyarm::meshes
