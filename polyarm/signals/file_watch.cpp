#include "polyarm/signals/file_watch.hpp"

#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace polyarm::signals {

namespace {
constexpr std::uint32_t kRewrites = IN_MODIFY | IN_CLOSE_WRITE;
constexpr std::uint32_t kReplaces = IN_MOVED_TO | IN_CREATE;
/// Labels of versions with unknown content start here; version numbers are smaller.
constexpr std::uint64_t kFirstUnseen = std::uint64_t{1} << 63;
constexpr std::size_t kMostRewrites = 10000;
bool is_unseen(std::uint64_t label) {
  return label >= kFirstUnseen;
}
}  // namespace

FileWatch::FileWatch(const std::filesystem::path& path, std::uint64_t version)
    : name_{path.filename().string()}, standing_{version}, next_label_{kFirstUnseen} {
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
      if (event.mask & IN_Q_OVERFLOW) lose_track();
      if (event.len > 0 && name_ == name) each(event.mask, false);
      if (event.len > 0 && displaced_name_ == name) each(event.mask, true);
      at += static_cast<ssize_t>(sizeof event + event.len);
    }
  }
}

void FileWatch::lose_track() {
  rewritten_ = true;
  last_read_ = read_before_ = std::nullopt;
  rewrites_.clear();
}

void FileWatch::take(std::uint32_t mask) {
  if ((mask & IN_OPEN) && !std::exchange(own_open_, false)) {
    if (in_doubt_ && opened_ && !accessed_) last_read_ = std::nullopt;
    take_open(standing_);
    in_doubt_ = std::exchange(just_replaced_, false);
  }
  if (mask & IN_ACCESS) {
    accessed_ = true;
    in_doubt_ = false;
  }
  if (mask & (kRewrites | kReplaces)) take_rewrite((mask & kReplaces) != 0);
}

void FileWatch::take_open(std::optional<Label> label) {
  read_before_ = std::exchange(last_read_, label);
  opened_ = true;
  accessed_ = false;
}

/// Handles events of the file that we have just displaced.
void FileWatch::take_late(std::uint32_t mask) {
  if ((mask & IN_OPEN) && !std::exchange(own_late_open_, false)) take_open(displaced_);
  if ((mask & IN_ACCESS) && in_doubt_ && opened_ && !accessed_) {
    last_read_ = std::nullopt;  // it may have been the displaced file or the new one
    accessed_ = true;
    in_doubt_ = false;
  }
  if ((mask & IN_ACCESS) && last_read_ == displaced_) accessed_ = true;
  if (!(mask & kRewrites) || !opened_ || accessed_) return;
  last_read_ = read_before_;  // it was opened for writing
  opened_ = false;
}

void FileWatch::take_rewrite(bool replaced) {
  // It was opened for writing, not for reading. A process that replaces the file does not open it for that: a
  // file that was opened but not read has been mapped, as by another Polyarm process.
  if (opened_ && !accessed_ && !replaced) last_read_ = read_before_;
  opened_ = false;
  rewritten_ = true;
  standing_ = next_label_++;
  if (rewrites_.size() < kMostRewrites) rewrites_.push_back({standing_, last_read_});
  last_read_ = standing_;  // its writer knows its content
}

void FileWatch::collect() {
  drain([&](std::uint32_t mask, bool displaced) { displaced ? take_late(mask) : take(mask); });
}

FileWatch::Label FileWatch::collect_replaced(std::uint64_t version, const std::string& displaced_name,
                                             bool own_open) {
  displaced_name_ = displaced_name;
  displaced_ = standing_;
  own_late_open_ = own_open;
  bool replaced = false;
  const auto replace = [&] {
    replaced = just_replaced_ = true;
    displaced_ = std::exchange(standing_, version);
  };
  drain([&](std::uint32_t mask, bool displaced) {
    if (displaced) return take_late(mask);
    if (!replaced && (mask & IN_MOVED_TO)) return replace();
    take(mask);
    // The exchange event comes after the exchange: an open event just before it may belong to either file.
    if (!replaced && (mask & IN_OPEN)) last_read_ = std::nullopt;
  });
  if (!replaced) replace();
  return displaced_;
}

void FileWatch::resolve(Label label, std::uint64_t version) {
  const auto settle = [&](Label& known) {
    if (is_unseen(known) && known <= label) known = version;
  };
  settle(standing_);
  settle(displaced_);
  if (last_read_) settle(*last_read_);
  if (read_before_) settle(*read_before_);
  for (Rewrite& rewrite : rewrites_)
    if (rewrite.base) settle(*rewrite.base);
}

std::optional<std::uint64_t> FileWatch::take_base(Label label) {
  const bool writing = opened_ && !accessed_;  // the content may be seen before the write event
  std::optional<Label> base = writing ? read_before_ : last_read_;
  const auto later =
      std::find_if(rewrites_.begin(), rewrites_.end(), [&](const Rewrite& r) { return r.label > label; });
  if (later != rewrites_.begin()) base = rewrites_.front().base;
  rewrites_.erase(rewrites_.begin(), later);
  return base && is_unseen(*base) ? std::nullopt : base;
}

bool FileWatch::take_rewritten() {
  return std::exchange(rewritten_, false);
}

}  // namespace polyarm::signals
