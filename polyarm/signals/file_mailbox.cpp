#include "polyarm/signals/file_mailbox.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <thread>
#include <unordered_map>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/signals/file_watch.hpp"
#include "polyarm/signals/folder_turn.hpp"
#include "polyarm/signals/mailbox_merge.hpp"

namespace polyarm::signals {

namespace {
namespace fs = std::filesystem;

/// Identifies a state of a file without reading its content.
struct Identity {
  dev_t device = 0;
  ino_t inode = 0;
  std::int64_t modified = 0;
  off_t size = -1;
  friend bool operator==(const Identity&, const Identity&) = default;
};

Identity identity(const struct stat& s) {
  return {s.st_dev, s.st_ino, s.st_mtim.tv_sec * 1'000'000'000 + s.st_mtim.tv_nsec, s.st_size};
}

std::optional<Identity> identity_of(int fd) {
  struct stat s {};
  if (::fstat(fd, &s) != 0) return std::nullopt;
  return identity(s);
}

constexpr std::size_t kMostBytes = bounds::kDataBytes;

std::optional<std::string> read_through(int fd) {
  std::string out;
  char buffer[16384];
  for (off_t at = 0;;) {
    const ssize_t n = ::pread(fd, buffer, sizeof buffer, at);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return std::nullopt;
    out.append(buffer, static_cast<std::size_t>(n));
    if (out.size() > kMostBytes) return std::nullopt;
    if (n < static_cast<ssize_t>(sizeof buffer)) return out;  // read in one piece, so it cannot mix two
                                                              // versions
    at += n;
  }
}

/// Copies `size` bytes of a mapping that another process may truncate at any time. The kernel copies; if the
/// file is too short, the copy ends early instead of killing this process.
std::string copied(const char* mapping, std::size_t size) {
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC | O_NONBLOCK) != 0) return {};
  const Descriptor out(pipe[0]), in(pipe[1]);
  std::string content(size, '\0');
  std::size_t done = 0;
  while (done < size) {
    const ssize_t n = ::write(in.number(), mapping + done, std::min<std::size_t>(size - done, 65536));
    if (n <= 0 || ::read(out.number(), content.data() + done, static_cast<std::size_t>(n)) != n) break;
    done += static_cast<std::size_t>(n);
  }
  content.resize(done);
  return content;
}

/// The content of a file, read through a mapping; none of a file that is too large. Unlike a read, this causes no
/// event, so every read event belongs to another process.
std::optional<std::string> content_of(int fd) {
  const auto found = identity_of(fd);
  if (!found) return std::nullopt;
  if (found->size == 0) return std::string{};
  const auto size = static_cast<std::size_t>(found->size);
  if (size > kMostBytes) return std::nullopt;
  void* const mapping = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, fd, 0);
  if (mapping == MAP_FAILED) return read_through(fd);
  std::string content = copied(static_cast<const char*>(mapping), size);
  ::munmap(mapping, size);
  return content;
}

Values values_of(const data::ImportFile& file) {
  Values out;
  for (const data::Entry& entry : file.values().entries()) out.emplace(entry.name, entry.value);
  return out;
}

/// A file that our write displaced; another process may still write into it.
struct Displaced {
  Descriptor file;
  std::string content;          ///< content at the last check
  Identity seen;                ///< its state then, if that distinguishes it from every later state
  std::set<std::string> names;  ///< the names it contained
  FileWatch::Label label = 0;
  std::optional<std::uint64_t> base;  ///< the version on which its writer is based
  bool settled = true;                ///< the content is merged or our own
  int looks_left = 0;
};

/// Checks (20 ms each) that are skipped in a row while another process holds the lock. After that the holder
/// counts as stuck. A disk with many writers may block one for a second.
constexpr int kMostLeftOut = 150;
/// Number of checks of a displaced file.
constexpr int kLooksAtDisplaced = 500;
/// After this many checks the file is read even if nothing indicates a change.
constexpr int kLooksUntilRead = 50;
constexpr std::size_t kMostDisplaced = 64;
/// Limit for postponed writes: a writer that never stops must not prevent ours.
constexpr int kMostPostponed = 4;
/// Number of names tried for a temporary file.
constexpr int kTakenNames = 1000;
/// A file that changed this recently may change again without a new time stamp, ns.
constexpr std::int64_t kStampResolution = 50'000'000;
}  // namespace

class FileMailbox::Io {
 public:
  Io(const data::ImportFile& start, const MailboxOptions& options)
      : options_{options},
        path_{fs::weakly_canonical(start.file()).string()},
        image_{start},
        merge_{values_of(start), options.versions_kept},
        watch_{path_, merge_.current()},
        turn_{fs::path(path_).parent_path()},
        known_text_{start.text()},
        names_in_file_{names_of(start)} {
    if (options_.thread) thread_ = std::thread([this] { run(); });
  }

  ~Io() {
    if (thread_.joinable()) {
      {
        const std::lock_guard lock(mutex_);
        ending_ = true;
      }
      wake_.notify_all();
      thread_.join();
    }
    for (int i = 0; i < 3 * options_.looks_until_settled && (i == 0 || written() < posted()); ++i) look();
  }

  const std::string& path() const { return path_; }

  void post(std::span<const std::pair<std::string, data::Value>> values) {
    std::optional<Error> refused;
    {
      const std::lock_guard lock(mutex_);  // one check takes all of them
      for (const auto& [name, value] : values) try {
          data::check_can_keep(name, value, path_);
          posts_.emplace_back(name, value);
          last_post_[name] = ++posted_;
        } catch (const Error& e) {
          if (!refused) refused = e;
        }
    }
    if (refused) throw *refused;
  }

  void post_group(const std::string& name, const std::string& group) {
    data::check_group(group);
    const std::lock_guard lock(mutex_);
    groups_.emplace_back(name, group);
  }

  std::vector<MailboxEvent> take_events() {
    std::vector<MailboxEvent> out;
    const std::lock_guard lock(mutex_);
    for (auto& [event, applied] : events_) {
      const std::uint64_t known = applied;
      std::erase_if(event.values, [&](const auto& value) {
        const auto at = last_post_.find(value.first);
        return at != last_post_.end() && at->second > known;
      });
      const bool says = !event.values.empty() || !event.groups.empty();
      if (says || event.kind != MailboxEvent::Kind::changed) out.push_back(std::move(event));
    }
    events_.clear();
    return out;
  }

  std::uint64_t posted() const { return locked(posted_); }
  std::uint64_t written() const { return locked(written_); }
  std::uint64_t check_from_now() const { return locked(looks_started_) + 1; }
  std::uint64_t looks() const { return locked(looks_ended_); }

  /// One round: takes posts, checks displaced files and the file, and writes the file if it is out of date.
  void look() {
    const bool ours = turn_.take();
    if (!ours && ++omitted_ < kMostLeftOut) return;
    omitted_ = 0;
    in_turn_ = ours;
    look_in_turn();
    if (ours) turn_.give_back();
  }

 private:
  void look_in_turn() {
    begin_look();
    look_at_displaced();
    check_file();
    const bool behind = needs_write_ || merge_.differs_from_file();
    if (behind && !held_) write();
    const std::lock_guard lock(mutex_);
    if (!needs_write_ && !merge_.differs_from_file()) written_ = applied_;
    ++looks_ended_;
  }

  static std::set<std::string> names_of(const data::ImportFile& file) {
    const auto names = file.values().names();
    return {names.begin(), names.end()};
  }

  template <class T>
  T locked(const T& value) const {
    const std::lock_guard lock(mutex_);
    return value;
  }

  void run() {
    std::unique_lock lock(mutex_);
    while (!ending_) {
      lock.unlock();
      look();
      lock.lock();
      wake_.wait_for(lock, std::chrono::nanoseconds(options_.period), [this] { return ending_; });
    }
  }

  void begin_look() {
    std::vector<std::pair<std::string, data::Value>> posts;
    std::vector<std::pair<std::string, std::string>> groups;
    {
      const std::lock_guard lock(mutex_);
      ++looks_started_;
      posts.swap(posts_);
      groups.swap(groups_);
      applied_ += posts.size();
    }
    for (const auto& [name, value] : posts) {
      image_.set(name, value);
      merge_.set(name, *image_.values().value(name));  // the value that a reader of the text gets
    }
    for (const auto& [name, group] : groups) {
      const data::Entry* entry = image_.values().find(name);
      if (!entry || entry->group == group) continue;
      image_.set_group(name, group);
      needs_write_ = true;
    }
  }

  void report(MailboxEvent event) {
    const std::lock_guard lock(mutex_);
    events_.emplace_back(std::move(event), applied_);
  }

  void complain(Problem problem) {
    if (complained_) return;
    complained_ = true;
    report({MailboxEvent::Kind::problem, {}, {std::move(problem)}});
  }

  void all_is_well() {
    if (std::exchange(complained_, false)) report({MailboxEvent::Kind::recovered, {}, {}});
  }

  // --- what others wrote ---

  void check_file() {
    watch_.collect();
    const bool told = watch_.take_rewritten();
    if (told) last_found_ = {};
    const FileWatch::Label label = watch_.standing();
    struct stat now {};
    if (::stat(path_.c_str(), &now) != 0) return missing();
    if (auto foreign = not_ours(now)) return displaced_by(std::move(*foreign));
    const Identity found = identity(now);
    if (!told && !held_ && found == known_ && !may_be_stale(found)) return;
    if (auto outside = out_of_reach(Reach::Use::read)) return displaced_by(std::move(*outside));
    const auto content = read_path(found);
    if (!content) return missing();
    if (*content != known_text_) return consider(*content, found, label);
    watch_.take_base(label);
    watch_.resolve(label, file_version_);
    settle(found);
  }

  /// Reads the file through the open descriptor if it is the same file, because opening causes an event.
  std::optional<std::string> read_path(const Identity& found) {
    const auto held = standing_ ? identity_of(standing_.number()) : std::nullopt;
    const bool same = held && held->inode == found.inode && held->device == found.device;
    watch_.expect_own_open(!same);
    if (!same) standing_ = Descriptor(::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
    if (!same && standing_ && !may_read(standing_.number())) standing_ = Descriptor{};  // a link came in between
    auto content = standing_ ? content_of(standing_.number()) : std::nullopt;
    watch_.collect();
    watch_.expect_own_open(false);
    return content;
  }

  /// Why what now has the file's name is not read; nothing for an ordinary file.
  std::optional<Problem> not_ours(const struct stat& now) const {
    const char* const advice = "its values stay as they were; put the file back";
    if (!S_ISREG(now.st_mode)) return Problem{"not-a-file", {path_}, "this is not an ordinary file any more", advice};
    if (static_cast<std::uintmax_t>(now.st_size) > kMostBytes)
      return Problem{"too-large", {path_}, "the file has more than " + std::to_string(kMostBytes) + " bytes", advice};
    return std::nullopt;
  }

  /// Links on the way are followed: after the start, another process may have put one there. It costs some system
  /// calls, so a file that is the same as at the last check is not asked about.
  std::optional<Problem> out_of_reach(Reach::Use use) const {
    if (!reach().confined()) return std::nullopt;
    try {
      reach().check(path_, use);
      return std::nullopt;
    } catch (const Error& e) {
      return e.problems().front();
    }
  }

  bool may_read(int fd) const {
    std::error_code error;
    const fs::path place = fs::read_symlink("/proc/self/fd/" + std::to_string(fd), error);
    return error || reach().allows(path_, place, Reach::Use::read) || !reach().confined();
  }

  /// Nothing is written while it stands there.
  void displaced_by(Problem what) {
    held_ = true;
    same_looks_ = 0;
    complain(std::move(what));
  }

  bool may_be_stale(const Identity& found) const {
    timespec now{};
    ::clock_gettime(CLOCK_REALTIME, &now);
    return now.tv_sec * 1'000'000'000 + now.tv_nsec - found.modified < kStampResolution;
  }

  void settle(const Identity& found) {
    known_ = found;
    held_ = false;
    same_looks_ = 0;
    all_is_well();
  }

  /// The file is missing: another process may be replacing it; after a while it is written again.
  void missing() {
    held_ = ++same_looks_ < options_.looks_until_settled;
    if (!held_) needs_write_ = true;
  }

  void consider(const std::string& content, const Identity& found, FileWatch::Label label) {
    Problems problems;
    data::ImportFile file = data::ImportFile::parse(content, path_, problems);
    same_looks_ = content == last_seen_ && found == last_found_ ? same_looks_ + 1 : 0;
    last_seen_ = content;
    last_found_ = found;
    const bool settled = same_looks_ >= options_.looks_until_settled;
    if (settled && file.values().empty() && !problems.has_errors()) return missing();
    if (problems.has_errors() || (!settled && !plausible(content, file, names_in_file_))) {
      held_ = true;
      if (settled) complain(problems.list().front());
      return;
    }
    known_text_ = content;
    settle(found);
    names_in_file_ = names_of(file);
    const auto base = watch_.take_base(label);
    const bool merged = in_turn_ && standing_ && is_merged(standing_.number(), content);
    file_version_ = absorb(std::move(file), merged ? file_version_ : base);
    watch_.resolve(label, file_version_);
  }

  /// True if `content` is complete: every name is present, and the last line ends or is unchanged at a second
  /// check.
  bool plausible(const std::string& content, const data::ImportFile& file,
                 const std::set<std::string>& names) const {
    const bool ended = !content.empty() && (content.back() == '\n' || same_looks_ >= 2);
    return ended && std::all_of(names.begin(), names.end(),
                                [&](const std::string& name) { return file.values().find(name) != nullptr; });
  }

  /// Merges a rewrite and returns the number of its version.
  std::uint64_t absorb(data::ImportFile file, std::optional<std::uint64_t> read) {
    const auto result =
        merge_.outside(values_of(file), read ? std::span(&*read, 1) : std::span<const std::uint64_t>{});
    needs_write_ = needs_write_ || result.write_back;
    auto groups = regrouped(image_.values(), file.values());
    image_ = std::move(file);
    for (const auto& [name, value] : merge_.present()) image_.set(name, value);
    if (!result.changes.empty() || !groups.empty())
      report({MailboxEvent::Kind::changed, result.changes, {}, std::move(groups)});
    return merge_.current();
  }

  void look_at_displaced() {
    for (Displaced& old : displaced_) look_at(old);
    std::erase_if(displaced_, [](Displaced& old) { return --old.looks_left <= 0; });
    if (displaced_.size() > kMostDisplaced) displaced_.erase(displaced_.begin());
  }

  /// There may be many displaced files; an unchanged one costs one system call.
  void look_at(Displaced& old) {
    const auto now = identity_of(old.file.number());
    if (now && old.settled && *now == old.seen && old.looks_left % kLooksUntilRead != 0) return;
    old.seen = now && !may_be_stale(*now) ? *now : Identity{};
    auto content = content_of(old.file.number());
    if (!content || (*content == old.content && old.settled)) return;
    const bool stands = *content == old.content && old.looks_left < kLooksAtDisplaced / 2;
    old.content = *content;
    Problems problems;
    data::ImportFile file = data::ImportFile::parse(*content, path_, problems);
    const bool whole = plausible(*content, file, old.names) || (stands && !file.values().empty());
    old.settled = whole && !problems.has_errors();
    if (!old.settled) return;
    old.base = absorb(std::move(file), old.base);
    watch_.resolve(old.label, *old.base);
    needs_write_ = true;
  }

  // --- what we write ---

  void write() {
    if (auto why = out_of_reach(Reach::Use::write)) return complain(std::move(*why));
    const std::string text = image_.text();
    std::string temporary = temporary_path();
    Descriptor made = written_file(temporary, text);
    for (int i = 0; !made && errno == EEXIST && i < kTakenNames; ++i) {  // left by a killed run, or planted
      temporary = temporary_path();
      made = written_file(temporary, text);
    }
    if (!made) return complain(unwritable());
    watch_.collect();
    if (watch_.rewritten() && ++postponed_ < kMostPostponed) {  // it would be overwritten before it is merged
      ::unlink(temporary.c_str());
      return;
    }
    postponed_ = 0;
    if (!exchange(temporary)) {
      const Problem problem = unwritable();
      ::unlink(temporary.c_str());
      return complain(problem);
    }
    file_version_ = merge_.wrote();
    const FileWatch::Label displaced = watch_.collect_replaced(
        file_version_, fs::path(temporary).filename().string(), std::exchange(opened_displaced_, false));
    const auto base = watch_.take_base(displaced);
    needs_write_ = false;
    all_is_well();
    known_ = identity_of(made.number()).value_or(Identity{});
    std::set<std::string> names = std::exchange(names_in_file_, names_of(image_));
    Displaced old{std::exchange(standing_, std::move(made)),
                  std::exchange(known_text_, text),
                  {},
                  std::move(names),
                  displaced,
                  base,
                  true,
                  kLooksAtDisplaced};
    if (!old.file) return;
    look_at(old);
    displaced_.push_back(std::move(old));
  }

  std::string temporary_path() {
    const fs::path path(path_);
    const std::string name = "." + path.filename().string() + ".tmp" + std::to_string(::getpid()) + "." +
                             std::to_string(++temporaries_);
    return (path.parent_path() / name).string();
  }

  /// Writes the new file and opens it for reading. It is closed for writing before it gets its name, because
  /// closing causes an event.
  Descriptor written_file(const std::string& temporary, const std::string& text) const {
    struct stat old {};
    const mode_t mode = ::stat(path_.c_str(), &old) == 0 ? old.st_mode & 07777 : 0644;
    Descriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
    if (!file) return file;  // the file with this name belongs to another process
    bool good = ::fchmod(file.number(), mode) == 0;
    for (std::size_t at = 0; good && at < text.size();) {
      const ssize_t n = ::write(file.number(), text.data() + at, text.size() - at);
      if (n < 0 && errno == EINTR) continue;
      good = n > 0;
      if (good) at += static_cast<std::size_t>(n);
    }
    if (good && in_turn_) mark_as_merged(file.number(), text);
    if (good && ::fdatasync(file.number()) == 0)
      return Descriptor(::open(temporary.c_str(), O_RDONLY | O_CLOEXEC));
    const int error = errno;
    ::unlink(temporary.c_str());
    errno = error;
    return Descriptor{};
  }

  /// Exchanges the new file with the old one. Then standing_ is the old file.
  bool exchange(const std::string& temporary) {
    if (::renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, path_.c_str(), RENAME_EXCHANGE) == 0) {
      struct stat displaced {};
      const bool there = ::stat(temporary.c_str(), &displaced) == 0;
      const auto held = standing_ ? identity_of(standing_.number()) : std::nullopt;
      const bool same = there && held && held->inode == displaced.st_ino && held->device == displaced.st_dev;
      if (!same) standing_ = Descriptor(::open(temporary.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
      opened_displaced_ = !same;
      ::unlink(temporary.c_str());
      return true;
    }
    return ::rename(temporary.c_str(), path_.c_str()) == 0;  // a file system without exchange, or no old file
  }

  Problem unwritable() const {
    return {"unwritable",
            {path_},
            std::string("cannot be written: ") + std::strerror(errno),
            "it is tried again; check permissions and free space"};
  }

  const MailboxOptions options_;
  const std::string path_;

  // Used by the I/O thread, or by the caller of step().
  data::ImportFile image_;  ///< the present values as text, with the file's comments and order
  MailboxMerge merge_;
  FileWatch watch_;
  FolderTurn turn_;
  int omitted_ = 0;        ///< checks skipped in a row
  bool in_turn_ = false;    ///< true if this check holds the lock
  std::string known_text_;  ///< the file's content as far as known
  std::set<std::string> names_in_file_;
  Identity known_;
  Descriptor standing_;  ///< the open file, to read it again
  bool opened_displaced_ = false;
  std::uint64_t file_version_ = 0;
  std::vector<Displaced> displaced_;
  std::string last_seen_;  ///< content of a file that may be incomplete
  Identity last_found_;
  int same_looks_ = 0;
  bool held_ = false;  ///< the file looks incomplete; do not write now
  bool needs_write_ = false;
  bool complained_ = false;
  int postponed_ = 0;
  unsigned temporaries_ = 0;

  // Both threads; protected by the mutex.
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::pair<std::string, data::Value>> posts_;
  std::vector<std::pair<std::string, std::string>> groups_;
  std::vector<std::pair<MailboxEvent, std::uint64_t>> events_;
  std::unordered_map<std::string, std::uint64_t> last_post_;
  std::uint64_t posted_ = 0, applied_ = 0, written_ = 0, looks_started_ = 0, looks_ended_ = 0;
  bool ending_ = false;
  std::thread thread_;
};

FileMailbox::FileMailbox(const data::ImportFile& start, MailboxOptions options)
    : io_{std::make_unique<Io>(start, options)} {}
FileMailbox::~FileMailbox() = default;
const std::string& FileMailbox::path() const {
  return io_->path();
}
void FileMailbox::post(const std::string& name, const data::Value& value) {
  const std::pair<std::string, data::Value> one(name, value);
  io_->post({&one, 1});
}
void FileMailbox::post(std::span<const std::pair<std::string, data::Value>> values) {
  io_->post(values);
}
void FileMailbox::post_group(const std::string& name, const std::string& group) {
  io_->post_group(name, group);
}
std::vector<MailboxEvent> FileMailbox::take_events() {
  return io_->take_events();
}
std::uint64_t FileMailbox::posted() const {
  return io_->posted();
}
std::uint64_t FileMailbox::written() const {
  return io_->written();
}
std::uint64_t FileMailbox::check_from_now() const {
  return io_->check_from_now();
}
std::uint64_t FileMailbox::looks() const {
  return io_->looks();
}
void FileMailbox::step() {
  io_->look();
}

}  // namespace polyarm::signals
