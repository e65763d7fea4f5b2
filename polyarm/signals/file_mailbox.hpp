#pragma once
/// A data file as the mailbox between the runtime and a program outside that reads and rewrites it.
///
/// The cell thread posts values and takes events; it never waits for the disk. An I/O thread writes, looks
/// for rewrites every few milliseconds, and merges them (mailbox_merge.hpp). In lock-step there is no thread
/// and step() does the same inline.
///
/// Nothing is lost on the way: a write of ours exchanges the file for its new version in one step and looks
/// at what it displaced, and displaced files are watched for a while, since the other side may still be
/// writing into one. Where the system tells who opens files in the folder, the version that the other side
/// read is known; else (network drives) the nearest version is taken, and a rewrite that only undoes what the
/// runtime had just set cannot be told from one that had not seen it. Two of our kind, and `polyarm data`,
/// take turns by a lock on the folder: each sees what the other wrote before it writes. With programs that
/// know nothing of that, two limits remain. A rewrite that comes in the instant between our last look and our
/// write is undone for one round and then merged: a program that reads just then may do again what it had
/// done. And where several programs read the file, the last reading before a rewrite counts as its origin.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/data/import_format.hpp"

namespace polyarm::signals {

struct MailboxEvent {
  enum class Kind {
    changed,   ///< the other side changed values
    problem,   ///< the file cannot be read or written; said once, tried again
    recovered  ///< it can again
  } kind = Kind::changed;
  std::vector<std::pair<std::string, data::Value>> values;
  std::vector<Problem> problems;
  std::vector<std::pair<std::string, std::string>> groups;  ///< that names have now; empty: none
};

struct MailboxOptions {
  bool thread = true;               ///< false: step() does the work
  Nanoseconds period = 10'000'000;  ///< between two looks at the file, wall time
  std::size_t versions_kept = 64;
  int looks_until_settled =
      100;  ///< in a row that find a file incomplete and untouched; then it counts as it is
};

class FileMailbox {
 public:
  /// `start` is the file as it was loaded; a rewrite since then is merged like any other.
  explicit FileMailbox(const data::ImportFile& start, MailboxOptions options = {});
  /// Writes what was posted, then ends.
  ~FileMailbox();
  FileMailbox(const FileMailbox&) = delete;
  FileMailbox& operator=(const FileMailbox&) = delete;

  const std::string& path() const;
  /// Cell thread. Throws Error("cannot-keep") at once for a value that the file cannot hold.
  void post(const std::string& name, const data::Value& value);
  /// The same for several, which the other side then gets together. What can be kept is, if another cannot.
  void post(std::span<const std::pair<std::string, data::Value>> values);
  /// Cell thread. The group that the file is to have for a name, which is no value: nobody merges it, and a
  /// rewrite from outside that had not seen it may leave it out.
  void post_group(const std::string& name, const std::string& group);
  /// Cell thread. What happened since the last call. A change from outside to a name that was posted later
  /// than the merge is left out: the runtime's value is the newer one.
  std::vector<MailboxEvent> take_events();

  /// Counts posts, and of them those that stand in the file.
  std::uint64_t posted() const;
  std::uint64_t written() const;
  /// A full look at the file that starts after this call has number look_from_now() or more; `load` waits
  /// until looks() has reached it.
  std::uint64_t look_from_now() const;
  std::uint64_t looks() const;

  /// Does one round of I/O on the calling thread; for lock-step, where there is no I/O thread.
  void step();

 private:
  class Io;
  std::unique_ptr<Io> io_;
};

}  // namespace polyarm::signals
