#pragma once
/// Plugins: shared libraries with hardware and controllers, from folders that somebody has named. What they
/// bring is then known by its name like everything else. Building thread only.
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

/// Loads every `*.so` of the folder, by name; what was loaded or refused before is passed over. Of two that
/// claim one name the first is used. A folder that cannot be read becomes a refusal.
void load_folder(const std::filesystem::path& folder);
/// The folders that are looked through when nobody names one: those of POLYARM_PLUGINS (separated by ':'),
/// then `lib/polyarm/plugins` where Polyarm is installed.
std::vector<std::filesystem::path> default_folders();
/// Loads those of them that there are; one that POLYARM_PLUGINS names and is not there is a refusal.
void load_default_folders();

const std::vector<Plugin>& found();
const std::vector<Refusal>& refused();

}  // namespace polyarm::plugins
