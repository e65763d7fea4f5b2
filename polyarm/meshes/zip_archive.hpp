#pragma once
/// Reads files out of a ZIP archive in memory, with libzip. Nothing is written to the disk, so paths, links
/// and modes in the archive mean nothing.
#include <cstddef>
#include <memory>
#include <string>

struct zip;

namespace polyarm::meshes {

class ZipArchive {
 public:
  /// `bytes` outlives the archive. `most`: of all files that are read, together, bytes. Throws
  /// Error("bad-mesh") that names the archive.
  ZipArchive(const std::string& bytes, std::string name, std::size_t most);

  bool has(const std::string& file) const;
  /// Throws Error("bad-mesh" | "large-mesh").
  std::string read(const std::string& file);

 private:
  struct Discard {
    void operator()(zip* archive) const;
  };
  [[noreturn]] void refuse(const std::string& why) const;

  const std::string name_;
  std::size_t left_;
  std::unique_ptr<zip, Discard> zip_;
};

}  // namespace polyarm::meshes
