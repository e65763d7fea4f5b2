#pragma once
/// Plugins: shared libraries with hardware and controllers. They run with all rights of the user. They are
/// loaded from Polyarm's installation, from folders that the user names on the command line and, if a cell
/// names a folder, only after the user has approved them on this machine (base/approvals.hpp). Their types
/// are then found by name like built-in ones. Building thread only.
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/hardware/plugin.hpp"

namespace polyarm::plugins {

struct Entry {
  std::string name;  ///< "vendor/Type"
  hardware::PluginKind kind;
  std::string help;
};

/// A loaded plugin.
struct Plugin {
  std::filesystem::path file;
  std::string name, version, compiler;
  std::vector<Entry> entries;
};

/// A library that was refused. It does not affect the others.
struct Refusal {
  std::filesystem::path file;
  std::string reason, advice;
};

/// A library on disk; none of its code has run.
struct Library {
  std::filesystem::path file;
  std::string sha256;  ///< empty if it cannot be read
  std::size_t bytes = 0;
  bool approved = false;  ///< by its hash, or by its folder
};

/// Loads every `*.so` of a folder that the user has named, in order of name, and skips those loaded or
/// refused before. If two claim one name, the first is used. A folder that cannot be read becomes a
/// refusal.
void load_folder(const std::filesystem::path& folder);
/// The same for a folder that a cell names: loads exactly the hashed bytes of approved libraries, and all
/// libraries of a folder approved for development. The others become unapproved().
void load_approved_in(const std::filesystem::path& folder);
/// Reads and hashes the libraries of the folder; loads nothing.
std::vector<Library> look_at(const std::filesystem::path& folder);
Library check_file(const std::filesystem::path& file);
/// The `*.so` of the folder that this process has neither loaded nor refused; loads nothing.
std::vector<std::filesystem::path> not_loaded_in(const std::filesystem::path& folder);
/// The default folders: those of POLYARM_PLUGINS (separated by ':'), then `lib/polyarm/plugins` of the
/// installation.
std::vector<std::filesystem::path> default_folders();
/// Loads the existing default folders. A missing folder of POLYARM_PLUGINS is a refusal.
void load_default_folders();

/// The controller of an entry. Throws Error("plugin-refused") if it was built for other types, and
/// Error("plugin-failed") if the plugin makes none.
std::unique_ptr<controllers::Controller> make_controller(const hardware::PluginEntry& entry,
                                                         const std::filesystem::path& file);

const std::vector<Plugin>& found();
const std::vector<Refusal>& refused();
/// Libraries that cells name and that were not loaded because they are not approved.
const std::vector<Library>& unapproved();

}  // namespace polyarm::plugins
