#include "polyarm/recording/file_sink.hpp"

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
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

/// Named so that sweep_temporaries() removes what a kill leaves, and as no temporary file of base/file.
std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  static std::atomic<unsigned> count{0};
  return path.parent_path() / ("." + path.filename().string() + ".recording.tmp" +
                               std::to_string(::getpid()) + "." + std::to_string(count++));
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
  temporary_ = temporary_beside(path);
  fd_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NONBLOCK, 0600);
  if (fd_ < 0)
    throw Error("unwritable",
                "the recording " + path.string() + " cannot be created: " + std::strerror(errno),
                "name a file in a folder that you may write to");
}

FileSink::~FileSink() {
  if (fd_ >= 0) ::close(fd_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

/// A hard link never replaces a file that was made meanwhile. A file system without hard links gets a rename,
/// which does.
bool FileSink::publish() {
  const bool linked = ::link(temporary_.c_str(), path_.c_str()) == 0;
  if (!linked && errno != EEXIST && ::rename(temporary_.c_str(), path_.c_str()) == 0) {
    temporary_.clear();
    return true;
  }
  if (!linked) {
    problem_ = path_.string() + ": " + std::strerror(errno);
    return false;
  }
  ::unlink(temporary_.c_str());
  temporary_.clear();
  return true;
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
  return temporary_.empty() || publish();
}

void FileSink::flush() {
  [[maybe_unused]] const int done = ::fdatasync(fd_);
}

}  // namespace polyarm::recording
