#pragma once
/// A file that grows by whole records.
#include <filesystem>
#include <string>

#include "polyarm/recording/mcap_writer.hpp"

namespace polyarm::recording {

/// Written at once, without a buffer of this process: what has been written is there after a kill. A write
/// that fails takes back what of it was written, so that the file ends with a whole record. One thread at a
/// time.
class FileSink : public ByteSink {
 public:
  /// Makes the file and its folders anew. Throws Error("unwritable").
  explicit FileSink(const std::filesystem::path& path);
  ~FileSink() override;
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  bool write(std::span<const std::byte> bytes) override;
  /// To the disk itself.
  void flush();
  /// Why the last write failed.
  const std::string& problem() const { return problem_; }

 private:
  std::filesystem::path path_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
  std::string problem_;
};

}  // namespace polyarm::recording
