#pragma once
/// Plugins: shared libraries with hardware and controllers. They run with all rights of the user: they are
/// loaded from where Polyarm is installed, from folders that the user names to the command, and, where a cell
/// names a folder, only if the user has approved them on this machine (base/approvals.hpp). What they bring
/// is then known by its name like everything else. Building thread only.
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/hardware/plugin.hpp"

namespace polyarm::plugins {

struct Entry {
  std::string name;  ///< "vendor/Type"
  hardware::PluginKind kind;
  std::string help;
};

/// A plugin that is in use.
struct Plugin {
  std::filesystem::path file;
  std::string name, version, compiler;
  std::vector<Entry> entries;
};

/// A library that is not used; that never hinders the others.
struct Refusal {
  std::filesystem::path file;
  std::string reason, advice;
};

/// A library as it lies there; not a byte of it has run.
struct Library {
  std::filesystem::path file;
  std::string sha256;  ///< empty where it cannot be read
  std::size_t bytes = 0;
  bool approved = false;  ///< by its hash, or by its folder
};

/// Loads every `*.so` of a folder that the user has named, by name; what was loaded or refused before is passed over. Of two that
/// claim one name the first is used. A folder that cannot be read becomes a refusal.
void load_folder(const std::filesystem::path& folder);
/// The same for a folder that a cell names: of approved libraries the bytes that were hashed are loaded, and
/// what lies in a folder that was approved for development; the others become unapproved().
void load_approved_in(const std::filesystem::path& folder);
/// The libraries of the folder, read and hashed; nothing is loaded.
std::vector<Library> look_at(const std::filesystem::path& folder);
Library look_at_file(const std::filesystem::path& file);
/// The `*.so` of the folder that this process has not loaded or refused; nothing is loaded.
std::vector<std::filesystem::path> not_loaded_in(const std::filesystem::path& folder);
/// The folders that are looked through when nobody names one: those of POLYARM_PLUGINS (separated by ':'),
/// then `lib/polyarm/plugins` where Polyarm is installed.
std::vector<std::filesystem::path> default_folders();
/// Loads those of them that there are; one that POLYARM_PLUGINS names and is not there is a refusal.
void load_default_folders();

const std::vector<Plugin>& found();
const std::vector<Refusal>& refused();
/// Those that cells named and that were not loaded as nobody has approved them.
const std::vector<Library>& unapproved();

}  // namespace polyarm::plugins
