#include "polyarm/plugins/plugins.hpp"

#include <algorithm>
#include <cstdlib>
#include <set>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/hardware/plugin_library.hpp"
#include "polyarm/plugins/types.hpp"
#include "polyarm/base/approvals.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/sha256.hpp"

namespace polyarm::plugins {

namespace fs = std::filesystem;
using hardware::PluginEntry;
using hardware::PluginKind;
using hardware::PluginTable;

namespace {
struct Known {
  std::vector<Plugin> found;
  std::vector<Refusal> refused;
  std::vector<Library> unapproved;
  std::set<fs::path> seen;  ///< files and folders
};
Known& known() {
  static Known all;
  return all;
}

[[noreturn]] void refuse(const fs::path& file, std::string reason, std::string advice) {
  throw Error(Problem{"plugin-refused", {file.string()}, std::move(reason), std::move(advice)});
}

/// True for "vendor/Type": two words and a slash, which no description or YAML file uses for anything else.
bool is_type_name(const std::string& name) {
  const auto slash = name.find('/');
  return slash != std::string::npos && slash > 0 && slash + 1 < name.size() &&
         name.find('/', slash + 1) == std::string::npos &&
         name.find_first_of(" \t\r\n\"'<>&:#") == std::string::npos;
}

/// The plugin that already provides the name, for error messages.
std::string where_taken(const std::string& name, PluginKind kind) {
  for (const Plugin& plugin : known().found)
    for (const Entry& entry : plugin.entries)
      if (entry.name == name && entry.kind == kind) return "by " + plugin.file.string();
  return "by Polyarm itself";
}

void judge_layout(const PluginEntry& entry, const fs::path& file) {
  if (entry.layout != controllers::kControllerLayout)
    refuse(file,
           std::string("'") + entry.name + "' was built with headers whose types have other sizes than here",
           "build it again against this Polyarm: cmake -DCMAKE_PREFIX_PATH=<where Polyarm is installed>");
}

void judge_entry(const PluginEntry& entry, const fs::path& file) {
  const std::string name = entry.name;
  if (!is_type_name(name))
    refuse(file, "'" + name + "' is not a name for a type",
           "names have the form vendor/Type, without blanks");
  const bool is_hardware = entry.kind == PluginKind::hardware;
  if (!is_hardware) judge_layout(entry, file);
  const bool taken =
      is_hardware ? hardware::driver_available(name) : controllers::find_controller_type(name) != nullptr;
  if (taken)
    refuse(file, "the name '" + name + "' is taken " + where_taken(name, entry.kind),
           "give it a name of its own");
}

void judge(const PluginTable& table, const fs::path& file) {
  if (std::string_view(table.name).empty())
    refuse(file, "it has no name", "give it one: POLYARM_PLUGIN(\"name\", …)");
  for (const Plugin& plugin : known().found)
    if (plugin.name == table.name)
      refuse(file, "there is a plugin '" + plugin.name + "' already: " + plugin.file.string(),
             "take one of the two away, or rename it");
  std::set<std::pair<PluginKind, std::string>> own;
  for (std::uint32_t i = 0; i < table.count; ++i) {
    const PluginEntry& entry = table.entries[i];
    judge_entry(entry, file);
    if (!own.emplace(entry.kind, entry.name).second)
      refuse(file, std::string("it has '") + entry.name + "' twice", "give them different names");
  }
}

void take(const PluginEntry& entry, const fs::path& file) {
  if (entry.kind == PluginKind::hardware)
    hardware::register_driver(entry.name, [&entry, file] { return hardware::make_component(entry, file); });
  else
    controllers::register_controller_type(
        {entry.name, [&entry, file] { return make_controller(entry, file); }, entry.help, {}});
}

void take_all(const PluginTable& table, const fs::path& file) {
  judge(table, file);
  Plugin plugin{file, table.name, table.version, table.compiler, {}};
  for (std::uint32_t i = 0; i < table.count; ++i) {
    take(table.entries[i], file);
    plugin.entries.push_back({table.entries[i].name, table.entries[i].kind, table.entries[i].help});
  }
  known().found.push_back(std::move(plugin));
}

bool seen(const fs::path& file) {
  return known().seen.contains(fs::weakly_canonical(file));
}

void refused_with(const fs::path& file, const Error& e) {
  const Problem& problem = e.problems().front();
  known().refused.push_back({file, problem.what, problem.advice});
}

/// Loads a library from a folder that the user named or that belongs to the installation, unless it was seen
/// before.
void load_once(const fs::path& file) {
  if (!known().seen.insert(fs::weakly_canonical(file)).second) return;
  try {
    take_all(hardware::open_plugin(file), file);
  } catch (const Error& e) {
    refused_with(file, e);
  }
}

constexpr std::size_t kLargestLibrary = 256 << 20;

bool in_development(const fs::path& file) {
  const fs::path real = resolved(file);
  for (const Approval& each : approvals())
    if (each.kind == "folder" && inside(real, each.subject) && unfit_for_development(each.subject).empty())
      return true;
  return false;
}

/// Reads and hashes a library. Exactly these bytes are loaded later, so the file cannot be replaced in
/// between.
Library judged_by_hash(const fs::path& file, std::string& bytes) {
  const AsUser user;  // only hashed, not shown to anybody
  bytes = read_file(file, kLargestLibrary);
  Library out{file, sha256(bytes), bytes.size(), false};
  out.approved = is_approved({"library", out.sha256, {}});
  return out;
}

/// Loads a library from a folder that a cell names; only approved libraries run.
void load_approved(const fs::path& file) {
  if (seen(file)) return;
  try {
    if (in_development(file)) return load_once(file);
    std::string bytes;
    const Library library = judged_by_hash(file, bytes);
    if (!library.approved) return known().unapproved.push_back(library);
    known().seen.insert(fs::weakly_canonical(file));
    take_all(hardware::open_plugin(file, bytes), file);
  } catch (const Error& e) {
    known().seen.insert(fs::weakly_canonical(file));
    refused_with(file, e);
  }
}

fs::path installed_folder() {
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  if (error) return {};
  return executable.parent_path().parent_path() / "lib" / "polyarm" / "plugins";
}

std::vector<fs::path> folders_of_user() {
  std::vector<fs::path> out;
  if (const char* written = std::getenv("POLYARM_PLUGINS"))
    for (const std::string& folder : split_words(written, ":")) out.emplace_back(folder);
  return out;
}
}  // namespace

std::unique_ptr<controllers::Controller> make_controller(const PluginEntry& entry, const fs::path& file) {
  judge_layout(entry, file);
  std::unique_ptr<controllers::Controller> out;
  try {
    out.reset(entry.make_controller());
  } catch (...) {
    rethrow_as_error("plugin-failed", file.string() + ": making '" + entry.name + "' it",
                     "its makers have to mend that");
  }
  if (!out)
    throw Error("plugin-failed", file.string() + " makes nothing for '" + entry.name + "'",
                "tell its makers");
  return out;
}

std::vector<fs::path> libraries_in(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator();
       at.increment(error))
    if (at->path().extension() == ".so") files.push_back(at->path());
  if (error && known().seen.insert(fs::absolute(folder)).second)
    known().refused.push_back({folder, "the folder cannot be read: " + error.message(),
                               "plugins are looked for in it because somebody named it"});
  std::sort(files.begin(), files.end());
  return files;
}

void load_folder(const fs::path& folder) {
  for (const fs::path& file : libraries_in(folder)) load_once(file);
}

void load_approved_in(const fs::path& folder) {
  std::erase_if(known().unapproved, [&](const Library& u) { return u.file.parent_path() == folder; });
  for (const fs::path& file : libraries_in(folder)) load_approved(file);
}

Library check_file(const fs::path& file) {
  std::string bytes;
  Library out = judged_by_hash(file, bytes);
  out.approved = out.approved || in_development(file);
  return out;
}

std::vector<Library> look_at(const fs::path& folder) {
  std::vector<Library> out;
  for (const fs::path& file : libraries_in(folder)) {
    Problems ignored;
    Library library{file, {}, 0, false};
    collect(ignored, [&] { library = check_file(file); });
    out.push_back(std::move(library));
  }
  return out;
}

std::vector<fs::path> not_loaded_in(const fs::path& folder) {
  std::vector<fs::path> out = libraries_in(folder);
  std::erase_if(out, seen);
  return out;
}

std::vector<fs::path> default_folders() {
  std::vector<fs::path> out = folders_of_user();
  if (fs::path installed = installed_folder(); !installed.empty()) out.push_back(std::move(installed));
  return out;
}

void load_default_folders() {
  for (const fs::path& folder : folders_of_user()) load_folder(folder);
  std::error_code error;
  if (const fs::path installed = installed_folder(); fs::is_directory(installed, error))
    load_folder(installed);
}

const std::vector<Plugin>& found() {
  return known().found;
}
const std::vector<Refusal>& refused() {
  return known().refused;
}
const std::vector<Library>& unapproved() {
  return known().unapproved;
}

}  // namespace polyarm::plugins
