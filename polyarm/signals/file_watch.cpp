#include "polyarm/signals/file_watch.hpp"

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <limits>
#include <utility>

namespace polyarm::signals {

namespace {
constexpr std::uint32_t kRewrites = IN_MODIFY | IN_CLOSE_WRITE;
constexpr std::uint32_t kReplaces = IN_MOVED_TO | IN_CREATE;
/// Stands for what somebody wrote until it has been looked at.
constexpr std::uint64_t kUnseen = std::numeric_limits<std::uint64_t>::max();
}  // namespace

FileWatch::FileWatch(const std::filesystem::path& path, std::uint64_t version)
    : name_{path.filename().string()}, standing_{version} {
  const auto folder = path.parent_path().empty() ? std::filesystem::path(".") : path.parent_path();
  fd_ = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (fd_ >= 0 && ::inotify_add_watch(fd_, folder.c_str(), IN_OPEN | IN_ACCESS | kRewrites | kReplaces) < 0) {
    ::close(fd_);
    fd_ = -1;
  }
}

FileWatch::~FileWatch() {
  if (fd_ >= 0) ::close(fd_);
}

template <class Each>
void FileWatch::drain(Each each) {
  alignas(inotify_event) std::array<char, 16384> buffer;
  for (;;) {
    const ssize_t size = fd_ >= 0 ? ::read(fd_, buffer.data(), buffer.size()) : -1;
    if (size <= 0) return;
    for (ssize_t at = 0; at < size;) {
      inotify_event event;
      std::memcpy(&event, buffer.data() + at, sizeof event);
      const char* name = buffer.data() + at + sizeof event;
      if (event.mask & IN_Q_OVERFLOW) rewritten_ = true;
      if (event.len > 0 && name_ == name) each(event.mask);
      at += static_cast<ssize_t>(sizeof event + event.len);
    }
  }
}

void FileWatch::take(std::uint32_t mask) {
  if ((mask & IN_OPEN) && own_opens_ > 0) {
    --own_opens_;
  } else if (mask & IN_OPEN) {
    read_before_ = std::exchange(last_read_, standing_);
    opened_ = true;
    accessed_ = false;
  }
  if ((mask & IN_ACCESS) && own_accesses_ > 0) {
    --own_accesses_;
  } else if (mask & IN_ACCESS) {
    accessed_ = true;
  }
  if (mask & (kRewrites | kReplaces)) take_rewrite();
}

void FileWatch::take_rewrite() {
  if (opened_ && !accessed_) last_read_ = read_before_;  // it was opened to be written, not read
  opened_ = false;
  rewritten_ = true;
  if (standing_ != kUnseen && !base_) base_ = last_read_;
  standing_ = kUnseen;
  last_read_ = kUnseen;  // who wrote it knows it
}

void FileWatch::collect() {
  drain([&](std::uint32_t mask) { take(mask); });
}

void FileWatch::collect_replaced(std::uint64_t version) {
  bool replaced = false;
  drain([&](std::uint32_t mask) {
    if (replaced || !(mask & IN_MOVED_TO)) return take(mask);
    replaced = true;
    standing_ = version;
    opened_ = false;
  });
  if (!replaced) standing_ = version;
}

void FileWatch::expect_own_read() {
  own_opens_ = 1;
  own_accesses_ = 1;
}

void FileWatch::resolve(std::uint64_t version, bool stands) {
  if (stands || standing_ == kUnseen) standing_ = version;
  for (auto* read : {&last_read_, &read_before_, &base_})
    if (*read == kUnseen) *read = version;
}

std::optional<std::uint64_t> FileWatch::take_base() {
  const auto base = std::exchange(base_, std::nullopt);
  if (base || last_read_ == kUnseen) return base;
  return last_read_;
}

bool FileWatch::take_rewritten() {
  return std::exchange(rewritten_, false);
}

}  // namespace polyarm::signals
