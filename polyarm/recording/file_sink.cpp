#include "polyarm/recording/file_sink.hpp"

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>
#include <system_error>

#include "polyarm/base/error.hpp"
#include "polyarm/base/reach.hpp"

namespace polyarm::recording {

namespace {

/// Removes an earlier recording; its hard links stay. Throws Error("not-a-recording").
void remove_recording(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0 && errno == ENOENT) return;
  constexpr std::string_view kMagic = "\x89MCAP0\r\n";  // https://mcap.dev/spec, "Magic"
  char begin[8] = {};
  const ssize_t n = fd < 0 ? -1 : ::read(fd, begin, sizeof begin);
  if (fd >= 0) ::close(fd);
  if (n != 0 && (n < 0 || std::string_view(begin, static_cast<std::size_t>(n)) != kMagic))
    throw Error("not-a-recording", path.string() + " exists and is not a recording: it is not overwritten",
                "name another file, or remove this one");
  ::unlink(path.c_str());
}

}  // namespace

FileSink::FileSink(const std::filesystem::path& path) : path_(path) {
  if (reach().confined()) reach().check(path, Reach::Use::write);
  std::error_code ignored;
  const auto there = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there))
    throw Error("not-a-file", path.string() + " is not an ordinary file, and cannot be recorded into",
                "name another file");
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), ignored);
  remove_recording(path);
  fd_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NONBLOCK, 0600);
  if (fd_ < 0)
    throw Error("unwritable",
                "the recording " + path.string() + " cannot be created: " + std::strerror(errno),
                "name a file in a folder that you may write to");
}

FileSink::~FileSink() {
  if (fd_ >= 0) ::close(fd_);
}

bool FileSink::write(std::span<const std::byte> bytes) {
  const std::uint64_t whole = size_;
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      problem_ = path_.string() + ": " + std::strerror(n < 0 ? errno : ENOSPC);
      [[maybe_unused]] const int cut = ::ftruncate(fd_, static_cast<off_t>(whole));
      size_ = whole;
      return false;
    }
    size_ += static_cast<std::uint64_t>(n);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

void FileSink::flush() {
  [[maybe_unused]] const int done = ::fdatasync(fd_);
}

}  // namespace polyarm::recording
