#pragma once
/// Finds out which version of a file a rewrite is based on, from the system's file events (inotify).
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace polyarm::signals {

/// Tracks readers and writers of a file. A rewrite is based on the version that any process read last before
/// it. One thread. Without file events (other systems, network drives) it reports nothing.
class FileWatch {
 public:
  /// `version`: the version in the file at `path`.
  FileWatch(const std::filesystem::path& path, std::uint64_t version);
  ~FileWatch();
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

  /// Processes the events so far.
  void collect();
  /// Identifies a version of the file: its number, or a temporary label until its content is known.
  using Label = std::uint64_t;
  /// The label of the file's present content, by the events so far.
  Label standing() const { return standing_; }
  /// Processes the events directly after we have replaced the file by `version`. Returns the label of the
  /// displaced version. That file is now called `displaced_name`; events of a process that was just opening
  /// it carry that name. `own_open`: we opened it ourselves under that name.
  Label collect_replaced(std::uint64_t version, const std::string& displaced_name, bool own_open);
  /// Announces that the next open event is our own. Our own reads cause no events.
  void expect_own_open(bool opens) { own_open_ = opens; }

  /// The version on which the rewrites up to `label` are based, if known. The call clears it.
  std::optional<std::uint64_t> take_base(Label label);
  /// Records that the content up to `label` is `version`.
  void resolve(Label label, std::uint64_t version);
  /// True if a process rewrote the file since the last call.
  bool take_rewritten();
  bool rewritten() const { return rewritten_; }

 private:
  struct Rewrite {
    Label label;
    std::optional<Label> base;
  };
  void take(std::uint32_t mask);
  void take_late(std::uint32_t mask);
  void take_open(std::optional<Label> label);
  void take_rewrite(bool replaced);
  void lose_track();
  /// Calls `each` for every event, with true for events of the displaced file.
  template <class Each>
  void drain(Each each);

  std::string name_;
  std::string displaced_name_;  ///< of the last displaced file
  Label displaced_ = 0;
  int fd_ = -1;
  Label standing_;
  Label next_label_;
  std::optional<Label> last_read_, read_before_;  ///< empty: unknown
  std::vector<Rewrite> rewrites_;
  bool opened_ = false, accessed_ = false;  ///< the latest open may turn out to be for writing
  bool own_open_ = false, own_late_open_ = false;
  /// The first open event after an exchange may belong to the displaced file although it carries the name of
  /// the new one, because events can arrive late (seen on Linux 6.18). Read events decide.
  bool just_replaced_ = false, in_doubt_ = false;
  bool rewritten_ = false;
};

}  // namespace polyarm::signals
