#pragma once
/// A file that grows by whole records.
#include <filesystem>
#include <string>

#include "polyarm/recording/mcap_writer.hpp"

namespace polyarm::recording {

/// Writes without a buffer in this process, so data that was written survives a kill. A failed write is
/// rolled back, so the file always ends with a whole record. The file has its name from the first write on:
/// a reader that finds it finds its header. One thread at a time.
class FileSink : public ByteSink {
 public:
  /// Creates the file, under a temporary name, and its folders; an earlier recording with this name is
  /// removed. Throws Error("unwritable" | "not-a-file" | "not-a-recording").
  explicit FileSink(const std::filesystem::path& path);
  ~FileSink() override;
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  bool write(std::span<const std::byte> bytes) override;
  /// Waits until the data is on the disk.
  void flush();
  /// The reason why the last write failed.
  const std::string& problem() const { return problem_; }

 private:
  bool publish();

  std::filesystem::path path_;
  std::filesystem::path temporary_;  ///< the file's name before the first write, then empty
  int fd_ = -1;
  std::uint64_t size_ = 0;
  std::string problem_;
};

}  // namespace polyarm::recording
