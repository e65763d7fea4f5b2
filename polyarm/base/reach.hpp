#pragma once
/// Which files and hosts a cell may reach. A cell may come from a stranger: what its files name stays inside
/// its folder. Every file is read by read_file() and written by write_file_atomically(), which ask here, so
/// that no reader of a format needs a check of its own. Any thread; not for the control loop.
#include <filesystem>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace polyarm {

/// `path` with links resolved as far as it exists; absolute.
std::filesystem::path resolved(const std::filesystem::path& path);
/// Is `path` the folder `root`, or below it? By name alone: pass resolved paths.
bool inside(const std::filesystem::path& path, const std::filesystem::path& root);
/// The folder that a cell may reach: its own, or the outermost one above it that is a cell itself, without a
/// gap: `pick/cell.yaml` reaches the files of `pick/far_plc/cell.yaml`, and the other way round.
std::filesystem::path project_root(const std::filesystem::path& cell_folder);

class Reach {
 public:
  enum class Use { read, write };

  /// Nothing is refused before confine() was called and a cell was entered.
  void confine();
  /// A cell was opened by the user: its project's folder may be read and written from now on.
  void enter(const std::filesystem::path& cell_folder);
  /// The user has named it: the file, or the folder and all below.
  void allow(const std::filesystem::path& path);
  /// Installed descriptions and packages. Their own links may lead elsewhere: they are the user's.
  void allow_reading(const std::filesystem::path& folder);
  /// The user lets cells speak with this host; a name or address, or "all".
  void allow_host(const std::string& host);
  bool host_allowed(const std::string& host) const;
  /// The user lets cells send this secret, by its name (base/secrets.hpp).
  void allow_secret(const std::string& name);
  bool secret_allowed(const std::string& name) const;

  /// True where nothing forbids it. `real`: `path` with its links resolved.
  bool allows(const std::filesystem::path& path, const std::filesystem::path& real, Use use) const;
  /// Throws Error("outside-cell") that names the option; passes in an AsUser.
  void check(const std::filesystem::path& path, const std::filesystem::path& real, Use use) const;
  void check(const std::filesystem::path& path, Use use) const { check(path, resolved(path), use); }
  /// True once files are refused.
  bool confined() const;
  std::vector<std::filesystem::path> cells() const;

 private:
  mutable std::mutex mutex_;
  bool confined_ = false;
  std::vector<std::filesystem::path> cells_, allowed_, readable_;
  std::set<std::string> hosts_, secrets_;
};

/// That of this process.
Reach& reach();

/// While it lives, this thread reads and writes for the user and not for a cell: projects that a person
/// lists or copies, settings.
class AsUser {
 public:
  AsUser();
  ~AsUser();
  AsUser(const AsUser&) = delete;
  AsUser& operator=(const AsUser&) = delete;
  static bool active();
};

/// Is the name or address this machine's own ("localhost", 127.0.0.0/8, ::1)?
bool is_loopback(const std::string& host);

/// `$XDG_CONFIG_HOME/polyarm` (or `~/.config/polyarm`): settings of this user. Empty without a home.
std::filesystem::path config_folder();
/// `$XDG_CACHE_HOME/polyarm` (or `~/.cache/polyarm`): what can be made anew. Empty without a home.
std::filesystem::path cache_folder();

}  // namespace polyarm
