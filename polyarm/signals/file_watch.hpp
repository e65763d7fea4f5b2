#pragma once
/// What the system tells about who opens and rewrites one file.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

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
  /// The same right after we have replaced the file by `version`.
  void collect_replaced(std::uint64_t version);
  /// The next opening and reading of the file is our own.
  void expect_own_read();
  /// What somebody wrote and was not looked at yet is `version`; `stands`: it is what stands in the file.
  void resolve(std::uint64_t version, bool stands);

  /// The version from which the latest rewrite was made; forgotten with this call.
  std::optional<std::uint64_t> take_base();
  /// Whether somebody rewrote the file since the last call.
  bool take_rewritten();

 private:
  void take(std::uint32_t mask);
  void take_rewrite();
  /// Gives each piece of news about the file to `each`.
  template <class Each>
  void drain(Each each);

  std::string name_;
  int fd_ = -1;
  std::uint64_t standing_;
  std::optional<std::uint64_t> last_read_, read_before_, base_;
  bool opened_ = false, accessed_ = false;  ///< the latest opening may turn out to be for writing
  int own_opens_ = 0, own_accesses_ = 0;
  bool rewritten_ = false;
};

}  // namespace polyarm::signals
