#pragma once
/// A data file as a mailbox between the runtime and an outside program that reads and rewrites it.
///
/// The cell thread posts values and takes events; it never waits for the disk. An I/O thread writes the file,
/// looks for rewrites every few milliseconds, and merges them (mailbox_merge.hpp). In lock-step mode there is
/// no thread; step() does the same inline.
///
/// Nothing is lost: a write replaces the file by its new version in one step and then checks what it
/// displaced. Displaced files are watched for a while, because the other side may still be writing into one.
/// If the system reports who opens files in the folder, the version that the other side read is known. Else
/// (network drives) the nearest version is assumed, and a rewrite that only undoes the runtime's last change
/// looks the same as one that had not seen it. Several Polyarm processes, and `polyarm data`, take turns by a
/// lock on the folder: each sees what the others wrote before it writes.
///
/// With other programs two limits remain. A rewrite between our last check and our write is undone for one
/// round and then merged; a program that reads in that moment may repeat its action. If several programs read
/// the file, the last reading before a rewrite counts as its origin.
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
    problem,   ///< the file cannot be read or written; reported once, then retried
    recovered  ///< it works again
  } kind = Kind::changed;
  std::vector<std::pair<std::string, data::Value>> values;
  std::vector<Problem> problems;
  std::vector<std::pair<std::string, std::string>> groups;  ///< new groups of names; an empty text means no
                                                            ///< group
};

struct MailboxOptions {
  bool thread = true;               ///< false: step() does the work
  Nanoseconds period = 10'000'000;  ///< between two checks of the file, wall time
  std::size_t versions_kept = 64;
  int looks_until_settled =
      100;  ///< consecutive checks that find an incomplete file unchanged, before it is used as it is
};

class FileMailbox {
 public:
  /// `start`: the file as loaded. A rewrite since then is merged like any other. What takes its place and is no
  /// ordinary file, is too large, or is a link that leads out of the cell (base/reach.hpp) is a problem, and is neither
  /// read nor replaced.
  explicit FileMailbox(const data::ImportFile& start, MailboxOptions options = {});
  /// Writes what was posted, then stops.
  ~FileMailbox();
  FileMailbox(const FileMailbox&) = delete;
  FileMailbox& operator=(const FileMailbox&) = delete;

  const std::string& path() const;
  /// Cell thread. Throws Error("cannot-keep") at once for a value that the file cannot hold.
  void post(const std::string& name, const data::Value& value);
  /// The same for several values, which the other side sees together. If one cannot be kept, the others are
  /// still posted.
  void post(std::span<const std::pair<std::string, data::Value>> values);
  /// Cell thread. Sets the group of a name in the file. A group is not a value: it is not merged, and an
  /// outside rewrite that had not seen it may drop it.
  void post_group(const std::string& name, const std::string& group);
  /// Cell thread. The events since the last call. An outside change of a name that was posted after the merge
  /// is left out, because the runtime's value is newer.
  std::vector<MailboxEvent> take_events();

  /// Count of posts, and count of those that are in the file.
  std::uint64_t posted() const;
  std::uint64_t written() const;
  /// Number of the next full check of the file. `load` waits until looks() reaches it.
  std::uint64_t check_from_now() const;
  std::uint64_t looks() const;

  /// One round of I/O on the calling thread; for lock-step mode without an I/O thread.
  void step();

 private:
  class Io;
  std::unique_ptr<Io> io_;
};

}  // namespace polyarm::signals
