#pragma once
/// The audit log: who changed what, and when. One JSON object a line, appended to audit.jsonl; full files are
/// renamed to audit.1.jsonl, audit.2.jsonl, … (1 is the newest of them), and the oldest is deleted.
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "polyarm/base/bounds.hpp"
#include "polyarm/protocol/request.hpp"

namespace polyarm::users {

inline constexpr std::size_t kAuditFileBytes = bounds::kAuditFileBytes, kAuditFiles = bounds::kAuditFiles,
                             kAuditQueue = bounds::kAuditQueue, kAuditArguments = bounds::kAuditArguments,
                             kAuditText = bounds::kAuditText;
/// Refusals that are written: so many a second, after a burst. Who may nothing cannot push the log of others
/// out of its files.
inline constexpr double kRefusalsASecond = 2, kRefusalsAtOnce = bounds::kAuditRefusals;

struct Actor {
  std::string name;              ///< of the user; else of the link or the local user
  std::string role, from, door;  ///< role of the link; address; pendant, local or fleet
  std::string client;            ///< name that the client gave itself
};

struct AuditEntry {
  std::string time;  ///< UTC; empty: the time of add()
  std::string cell;
  Actor actor;
  std::string request;
  std::string arguments;  ///< JSON without secrets and long texts
  std::string outcome;    ///< "done" or the code of the refusal
  std::string what;       ///< of a refusal
};

/// True if a request with these arguments changes something: it needs more than the role `watch`, or stops
/// motion, or passes control on.
bool is_audited(const protocol::RequestType& type, const protocol::Any& arguments);
/// The arguments as text of at most kAuditArguments bytes. Values of secrets are left out; a long text
/// becomes its size and SHA-256.
std::string arguments_text(const protocol::Any& arguments);
/// The same of a request. Of a message to a controller, which may come thousands of times a second, only the
/// receiver; of a repeated target or jog of speeds, only its session and robot.
std::string arguments_text(const protocol::Request& request);
/// One line without its end.
std::string line_of(const AuditEntry& entry, std::uint64_t times = 1);

/// A thread of its own writes; no caller waits for the disk. Equal entries within a second become one line
/// with a count. What does not fit into the queue, refusals that come too fast, and what cannot be written,
/// is counted in a later line.
class AuditLog {
 public:
  /// Throws Error("no-folder") if the folder cannot be used.
  explicit AuditLog(std::filesystem::path folder, std::size_t file_bytes = kAuditFileBytes,
                    std::size_t files = kAuditFiles);
  ~AuditLog();  ///< writes what is queued
  /// Any thread.
  void add(AuditEntry entry);
  /// Waits until everything added so far is written.
  void flush();

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

inline std::filesystem::path audit_folder(const std::filesystem::path& folder) {
  return folder / "audit";
}

/// The beginning of a span, as text that compares with the times of entries: "2h", "30min" or "7d" before
/// `now`, with or without a minus; or a date with as much of a time as is known, in UTC: "2026-11-28",
/// "2026-11-28T10:15", "2026-11-28 10:15:02". Empty if `text` is no such time.
std::optional<std::string> time_since(const std::string& text, std::time_t now);

/// Calls `take` with each line from the oldest to the newest; returns the number of lines that are not JSON
/// objects.
std::size_t read_audit(const std::filesystem::path& folder,
                       const std::function<void(const std::string&)>& take);

}  // namespace polyarm::users
