#pragma once
/// Decides which files and hosts a cell may access. A cell may come from a stranger, so its files may name
/// only paths inside its folder. read_file() and write_file_atomically() check here for every file; readers
/// of formats need no check of their own. Any thread; not for the control loop.
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace polyarm {

/// `path` with links resolved as far as it exists; absolute.
std::filesystem::path resolved(const std::filesystem::path& path);
/// True if `path` is the folder `root` or below it. Compares names only: pass resolved paths.
bool inside(const std::filesystem::path& path, const std::filesystem::path& root);
/// The folder that a cell may reach: its own, or the outermost one above it that is a cell itself, without a
/// gap: `pick/cell.yaml` reaches the files of `pick/far_plc/cell.yaml`, and the other way round.
std::filesystem::path project_root(const std::filesystem::path& cell_folder);

/// Allowed files, hosts and secrets. Any thread.
class ReachGrant {
 public:
  /// Allows reading and writing a file, or a folder and everything below it.
  void allow(const std::filesystem::path& path);
  /// Allows reading installed descriptions and packages. Their links may lead outside: the user owns them.
  void allow_reading(const std::filesystem::path& folder);
  /// A name or address, or "all".
  void allow_host(const std::string& host);
  /// A secret, by its name (base/secrets.hpp).
  void allow_secret(const std::string& name);

  bool has_path(const std::filesystem::path& path, const std::filesystem::path& real, bool writes) const;
  bool has_host(const std::string& host) const;
  bool has_secret(const std::string& name) const;
  /// The folder of the cell that holds the grant; empty if there is none.
  std::filesystem::path cell() const;

 private:
  friend class Reach;
  mutable std::mutex mutex_;
  std::filesystem::path cell_;
  std::vector<std::filesystem::path> allowed_, readable_;
  std::set<std::string> hosts_, secrets_;
};

/// The permissions of every cell (`--allow`, installed packages) and the grants of the open cells. A grant
/// ends with its last owner; a cell that is opened later starts without it.
class Reach {
 public:
  enum class Use { read, write };

  /// Refuses nothing until confine() was called and a cell was opened.
  void confine();
  /// For every cell of this process, as ReachGrant.
  void allow(const std::filesystem::path& path) { all_.allow(path); }
  void allow_reading(const std::filesystem::path& folder) { all_.allow_reading(folder); }
  void allow_host(const std::string& host) { all_.allow_host(host); }
  void allow_secret(const std::string& name) { all_.allow_secret(name); }

  /// The user opens a cell: its project's folder may be read and written as long as the grant lives. In an
  /// AsUser the cell is only looked at, and its grant opens no file.
  [[nodiscard]] std::shared_ptr<ReachGrant> open_cell(const std::filesystem::path& cell_folder);
  /// An empty grant, of a scratch folder or of a cell without a folder.
  [[nodiscard]] std::shared_ptr<ReachGrant> grant();

  /// `grant` is that of the requesting cell; null if there is none.
  bool host_allowed(const std::string& host, const ReachGrant* grant) const;
  bool secret_allowed(const std::string& name, const ReachGrant* grant) const;
  /// True if the common permissions or the grant of any open cell allow it, on any calling thread. `real` is
  /// `path` with its links resolved.
  bool allows(const std::filesystem::path& path, const std::filesystem::path& real, Use use) const;
  /// Throws Error("outside-cell"), which names the option. Never throws inside an AsUser.
  void check(const std::filesystem::path& path, const std::filesystem::path& real, Use use) const;
  void check(const std::filesystem::path& path, Use use) const { check(path, resolved(path), use); }
  /// True once files are refused.
  bool confined() const;

 private:
  std::vector<std::shared_ptr<const ReachGrant>> open() const;

  ReachGrant all_;
  mutable std::mutex mutex_;
  bool confined_ = false, any_cell_ = false;
  std::vector<std::weak_ptr<const ReachGrant>> open_;
};

/// That of this process.
Reach& reach();

/// While it exists, this thread reads and writes on behalf of the user, not of a cell: for settings and for
/// projects that a person lists or copies.
class AsUser {
 public:
  AsUser();
  ~AsUser();
  AsUser(const AsUser&) = delete;
  AsUser& operator=(const AsUser&) = delete;
  static bool active();
};

/// True if the name or address is this machine's own ("localhost", 127.0.0.0/8, ::1).
bool is_loopback(const std::string& host);

/// `$XDG_CONFIG_HOME/polyarm` (or `~/.config/polyarm`): settings of this user. Empty without a home.
std::filesystem::path config_folder();
/// `$XDG_CACHE_HOME/polyarm` (or `~/.cache/polyarm`): data that can be regenerated. Empty without a home.
std::filesystem::path cache_folder();

}  // namespace polyarm
