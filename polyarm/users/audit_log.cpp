#include "polyarm/users/audit_log.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <deque>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/sha256.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/protocol/jog.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/protocol/session.hpp"
#include "polyarm/users/user_list.hpp"

namespace polyarm::users {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr auto kMergeFor = std::chrono::seconds(1);
constexpr std::size_t kLongestLine = bounds::kAuditLineBytes;

/// "2026-11-28T10:15:02"
std::string utc_text(std::time_t seconds) {
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  char text[80];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
  return text;
}

std::string utc_now() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
  char part[16];
  std::snprintf(part, sizeof part, ".%03dZ", static_cast<int>(ms % 1000));
  return utc_text(static_cast<std::time_t>(ms / 1000)) + part;
}

bool is_secret_key(const std::string& key) {
  const std::string low = lower(key);
  for (const char* word : {"password", "passwd", "token", "secret", "api_key"})
    if (low.find(word) != std::string::npos) return true;
  return false;
}

/// Replaces secrets and long texts.
void shorten(Json& value, std::size_t depth = 0) {
  if (value.is_string()) {
    const std::string& text = value.get_ref<const std::string&>();
    if (text.size() > kAuditText) value = Json{{"bytes", text.size()}, {"sha256", sha256(text)}};
    return;
  }
  if (!value.is_structured()) return;
  if (depth > 16) {
    value = "…";
    return;
  }
  for (auto each = value.begin(); each != value.end(); ++each) {
    if (value.is_object() && is_secret_key(each.key()))
      *each = "(left out)";
    else
      shorten(*each, depth + 1);
  }
}

std::string dumped(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool same(const AuditEntry& a, const AuditEntry& b) {
  return a.cell == b.cell && a.actor.name == b.actor.name && a.actor.from == b.actor.from &&
         a.request == b.request && a.arguments == b.arguments && a.outcome == b.outcome &&
         a.actor.client == b.actor.client;
}

fs::path numbered(const fs::path& folder, std::size_t n) {
  return folder / (n == 0 ? "audit.jsonl" : "audit." + std::to_string(n) + ".jsonl");
}

}  // namespace

bool is_audited(const protocol::RequestType& type, const protocol::Any& arguments) {
  const protocol::Facts* const facts = type.facts;
  if (facts == &protocol::SessionTake::kFacts || facts == &protocol::SessionRelease::kFacts ||
      facts == &protocol::SessionAnswer::kFacts)
    return true;
  if (protocol::role_needed(type, arguments) > protocol::Role::watch) return true;
  return facts->role == protocol::Role::watch && facts->moves;
}

std::string arguments_text(const protocol::Any& arguments) {
  Json copy = arguments.json();
  if (copy.is_object()) copy.erase("request"), copy.erase("id");
  shorten(copy);
  std::string out = dumped(copy);
  if (out.size() > kAuditArguments) out = dumped(Json{{"bytes", out.size()}, {"sha256", sha256(out)}});
  return out;
}

std::string arguments_text(const protocol::Request& request) {
  if (&request.facts() == &protocol::SendMessage::kFacts)
    if (const auto& sent = request.as<protocol::SendMessage>(); !sent.goal)
      return dumped(Json{{"to", sent.to}});
  // Repeats in a session of motion come a hundred times a second; each has other values. A jog by a distance
  // is a motion of its own.
  const auto repeat = [&](const auto& motion) {
    Json out{{"session", *motion.session}};
    if (motion.robot) out["robot"] = *motion.robot;
    return dumped(out);
  };
  if (&request.facts() == &protocol::FollowTarget::kFacts)
    if (const auto& target = request.as<protocol::FollowTarget>(); target.session) return repeat(target);
  if (&request.facts() == &protocol::JogMotion::kFacts)
    if (const auto& jog = request.as<protocol::JogMotion>(); jog.session && !jog.end && !jog.by)
      return repeat(jog);
  return arguments_text(request.arguments());
}

std::string line_of(const AuditEntry& entry, std::uint64_t times) {
  nlohmann::ordered_json out{{"time", entry.time.empty() ? utc_now() : entry.time}};
  const auto put = [&](const char* key, const std::string& text) {
    if (!text.empty()) out[key] = text;
  };
  put("cell", entry.cell);
  put("who", entry.actor.name);
  put("client", entry.actor.client);
  put("role", entry.actor.role);
  put("from", entry.actor.from);
  put("door", entry.actor.door);
  put("request", entry.request);
  if (!entry.arguments.empty()) {
    auto arguments = nlohmann::ordered_json::parse(entry.arguments, nullptr, false);
    if (arguments.is_object() && !arguments.empty()) out["arguments"] = std::move(arguments);
  }
  put("outcome", entry.outcome);
  put("what", entry.what);
  if (times > 1) out["times"] = times;
  return out.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

class AuditLog::Work {
 public:
  Work(fs::path folder, std::size_t file_bytes, std::size_t files)
      : folder_(std::move(folder)), file_bytes_(file_bytes), files_(files) {
    make_private_folder(folder_.parent_path());
    make_private_folder(folder_);
    thread_ = std::thread([this] { run(); });
  }
  ~Work() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    wake_.notify_all();
    thread_.join();
  }

  void add(AuditEntry entry) {
    if (entry.time.empty()) entry.time = utc_now();
    {
      const std::lock_guard lock(mutex_);
      if (queue_.size() >= kAuditQueue || !has_room_for(entry))
        ++lost_;
      else
        queue_.push_back(std::move(entry));
    }
    wake_.notify_all();
  }

  void flush() {
    std::unique_lock lock(mutex_);
    const std::uint64_t until = ++flush_asked_;
    wake_.notify_all();
    flushed_.wait(lock, [&] { return flush_done_ >= until; });
  }

 private:
  struct Recent {
    AuditEntry entry;
    std::uint64_t repeats = 0;
    Clock::time_point until;
  };
  static constexpr std::size_t kRecent =
      16;  ///< different entries whose repeats are counted at the same time

  /// What was done, or may have been, always has room; equal refusals in a row are one line, and need room
  /// once.
  bool has_room_for(const AuditEntry& entry) {
    if (entry.outcome == "done" || entry.outcome == "ended" ||
        (!queue_.empty() && same(entry, queue_.back())))
      return true;
    const Clock::time_point now = Clock::now();
    const double passed = std::chrono::duration<double>(now - refilled_).count();
    refusals_ = std::min(kRefusalsAtOnce, refusals_ + passed * kRefusalsASecond);
    refilled_ = now;
    if (refusals_ < 1) return false;
    refusals_ -= 1;
    return true;
  }

  void run() {
    std::unique_lock lock(mutex_);
    for (;;) {
      const auto work = [&] { return over_ || !queue_.empty() || lost_ > 0 || flush_asked_ != flush_done_; };
      if (!recent_.empty())
        wake_.wait_until(lock, recent_.front().until, work);
      else
        wake_.wait(lock, work);
      std::deque<AuditEntry> taken;
      taken.swap(queue_);
      const std::uint64_t lost = std::exchange(lost_, 0);
      const std::uint64_t flush = flush_asked_;
      const bool over = over_, all = over || flush != flush_done_;
      lock.unlock();
      for (AuditEntry& entry : taken) take(std::move(entry));
      if (lost > 0) unwritten_ += lost;
      while (!recent_.empty() && (all || Clock::now() >= recent_.front().until)) write_oldest();
      if (all || Clock::now() >= lost_told_ + kMergeFor) write_lost();
      taken.clear();
      lock.lock();
      if (flush != flush_done_) {
        flush_done_ = flush;
        flushed_.notify_all();
      }
      if (over && queue_.empty()) return;
    }
  }

  /// The first of equal entries is written at once, so that it survives a kill. Those of others may come
  /// between.
  void take(AuditEntry entry) {
    for (Recent& recent : recent_)
      if (Clock::now() < recent.until && same(entry, recent.entry)) {
        ++recent.repeats;
        recent.entry.time = std::move(entry.time);
        return;
      }
    if (recent_.size() == kRecent) write_oldest();
    write(line_of(entry));
    recent_.push_back({std::move(entry), 0, Clock::now() + kMergeFor});
  }

  void write_oldest() {
    const Recent oldest = std::move(recent_.front());
    recent_.pop_front();
    if (oldest.repeats > 0) write(line_of(oldest.entry, oldest.repeats));
  }

  void write_lost() {
    if (unwritten_ == 0 || just_failed_) {
      just_failed_ = false;
      return;
    }
    AuditEntry entry;
    entry.outcome = "lost";
    entry.what = std::to_string(unwritten_) + " entries before this one could not be written";
    const std::uint64_t before = unwritten_;
    lost_told_ = Clock::now();
    if (write(line_of(entry))) unwritten_ -= before;
  }

  /// Other processes of this user append to the same file: each line is one write, and files are renamed
  /// under a lock.
  bool write(const std::string& line) {
    const std::string text = line + "\n";
    const int lock = ::open((folder_ / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (lock >= 0) ::flock(lock, LOCK_EX);
    struct stat status {};
    const fs::path file = numbered(folder_, 0);
    if (::lstat(file.c_str(), &status) == 0 && status.st_size > 0 &&
        static_cast<std::size_t>(status.st_size) + text.size() > file_bytes_)
      rotate();
    const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0600);
    const bool there = fd >= 0 && ::fstat(fd, &status) == 0;
    const ssize_t n = there ? ::write(fd, text.data(), text.size()) : -1;
    const bool good = n == static_cast<ssize_t>(text.size());
    // A full disk took a part of it: the next line must not follow in the middle of this one.
    if (n > 0 && !good && ::ftruncate(fd, status.st_size) != 0) just_failed_ = true;
    if (fd >= 0) ::close(fd);
    if (lock >= 0) ::close(lock);
    if (!good) ++unwritten_, just_failed_ = true;
    return good;
  }

  void rotate() const {
    std::error_code ignored;
    fs::remove(numbered(folder_, files_ - 1), ignored);
    for (std::size_t n = files_ - 1; n > 0; --n)
      fs::rename(numbered(folder_, n - 1), numbered(folder_, n), ignored);
  }

  const fs::path folder_;
  const std::size_t file_bytes_, files_;
  std::mutex mutex_;  // guards the next eight
  std::condition_variable wake_, flushed_;
  std::deque<AuditEntry> queue_;
  std::uint64_t lost_ = 0, flush_asked_ = 0, flush_done_ = 0;
  bool over_ = false;
  double refusals_ = kRefusalsAtOnce;
  Clock::time_point refilled_ = Clock::now();
  // the writer's own
  std::deque<Recent> recent_;  // the oldest first; equal entries are counted there
  bool just_failed_ = false;
  std::uint64_t unwritten_ = 0;
  Clock::time_point lost_told_{};
  std::thread thread_;
};

AuditLog::AuditLog(fs::path folder, std::size_t file_bytes, std::size_t files)
    : work_(std::make_unique<Work>(std::move(folder), file_bytes, std::max<std::size_t>(2, files))) {}
AuditLog::~AuditLog() = default;
void AuditLog::add(AuditEntry entry) {
  work_->add(std::move(entry));
}
void AuditLog::flush() {
  work_->flush();
}

namespace {
/// True for "2026-11-28", and for that with hours, minutes, seconds or milliseconds behind it.
bool is_time(const std::string& text) {
  constexpr std::string_view kForm = "dddd-dd-ddTdd:dd:dd.ddd";
  const std::size_t size = text.size();
  if (size != 10 && size != 13 && size != 16 && size != 19 && size != 23) return false;
  for (std::size_t i = 0; i < size; ++i)
    if (kForm[i] == 'd' ? !std::isdigit(static_cast<unsigned char>(text[i])) : text[i] != kForm[i])
      return false;
  const auto part = [&](std::size_t at, std::size_t digits) {
    return at < size ? static_cast<int>(*parse_number(text.substr(at, digits))) : 0;
  };
  const std::chrono::year_month_day date(std::chrono::year(part(0, 4)),
                                         std::chrono::month(static_cast<unsigned>(part(5, 2))),
                                         std::chrono::day(static_cast<unsigned>(part(8, 2))));
  return date.ok() && part(11, 2) < 24 && part(14, 2) < 60 && part(17, 2) < 60;
}
}  // namespace

std::optional<std::string> time_since(const std::string& text, std::time_t now) {
  std::string time = text.ends_with('Z') ? text.substr(0, text.size() - 1) : text;
  if (time.size() > 10 && time[10] == ' ') time[10] = 'T';
  if (is_time(time)) return time;
  const std::string span = text.starts_with('-') ? text.substr(1) : text;
  const std::size_t digits = std::min(span.find_first_not_of("0123456789."), span.size());
  const auto number = parse_number(span.substr(0, digits));
  const std::string unit = span.substr(digits);
  const double each = unit == "s" ? 1 : unit == "min" ? 60 : unit == "h" ? 3600 : unit == "d" ? 86400 : 0;
  constexpr double kLongest = 1e10;  // s, about 300 years
  if (!number || each == 0 || *number * each > kLongest) return std::nullopt;
  return utc_text(now - static_cast<std::time_t>(*number * each));
}

std::size_t read_audit(const fs::path& folder, const std::function<void(const std::string&)>& take) {
  std::size_t damaged = 0;
  for (std::size_t n = kAuditFiles; n-- > 0;) {
    std::ifstream in(numbered(folder, n));
    for (std::string line; std::getline(in, line);) {
      if (line.size() > kLongestLine || !Json::parse(line, nullptr, false).is_object())
        ++damaged;
      else
        take(line);
    }
  }
  return damaged;
}

}  // namespace polyarm::users
