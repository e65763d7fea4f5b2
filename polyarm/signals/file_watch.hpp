#pragma once
/// What the system tells about who opens and rewrites one file.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace polyarm::signals {

/// Follows who reads and rewrites a file, to know which of its versions a rewrite was made from: the one that
/// was read last before it, by whomever. For one thread. Where the system has no such news (other systems,
/// network drives) it stays silent.
class FileWatch {
 public:
  /// `version` stands in the file at `path`.
  FileWatch(const std::filesystem::path& path, std::uint64_t version);
  ~FileWatch();
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

  /// Takes the news so far.
  void collect();
  /// What a version of the file is called here: its number, or while nobody has looked at it a label.
  using Label = std::uint64_t;
  /// Of what stands in the file, by the news taken so far.
  Label standing() const { return standing_; }
  /// Takes the news right after we have replaced the file by `version`. Gives the label of what was displaced
  /// and has the name `displaced_name` since: who was just opening it is reported under that name.
  /// `own_open`: we opened it ourselves under that name.
  Label collect_replaced(std::uint64_t version, const std::string& displaced_name, bool own_open);
  /// Whether the next opening in the news is our own. Our readings make no news.
  void expect_own_open(bool opens) { own_open_ = opens; }

  /// The version from which the rewrites up to `label` were made, as far as it is known; forgotten with this
  /// call.
  std::optional<std::uint64_t> take_base(Label label);
  /// What was written up to `label` has been looked at and is `version`.
  void resolve(Label label, std::uint64_t version);
  /// Whether somebody rewrote the file since the last call.
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
  /// Gives each piece of news to `each`, and whether it is about the displaced file.
  template <class Each>
  void drain(Each each);

  std::string name_;
  std::string displaced_name_;  ///< of the file that we displaced last
  Label displaced_ = 0;
  int fd_ = -1;
  Label standing_;
  Label next_label_;
  std::optional<Label> last_read_, read_before_;  ///< none: not known
  std::vector<Rewrite> rewrites_;
  bool opened_ = false, accessed_ = false;  ///< the latest opening may turn out to be for writing
  bool own_open_ = false, own_late_open_ = false;
  /// The first opening after an exchange may be of the displaced file, although it has the name of the new
  /// one: its news can come late (seen on Linux 6.18). Readings tell.
  bool just_replaced_ = false, in_doubt_ = false;
  bool rewritten_ = false;
};

}  // namespace polyarm::signals
