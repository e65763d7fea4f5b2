#include "polyarm/plugins/built.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>
#include <set>
#include <sstream>

#include "polyarm/base/approvals.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/sha256.hpp"
#include "polyarm/base/shell_word.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/hardware/plugin_library.hpp"
#include "polyarm/plugins/plugins.hpp"
#include "polyarm/plugins/types.hpp"

namespace polyarm::plugins {

namespace fs = std::filesystem;

namespace {
constexpr const char* kControllerWord = "controller";
constexpr std::size_t kLargestModule = 256 << 20, kLargestRecord = 1 << 20;

std::set<std::string>& known_built() {
  static std::set<std::string> names;
  return names;
}

/// The entry of the class, from exactly the bytes that are approved.
const hardware::PluginEntry& open_built(const BuiltClass& built) {
  std::string bytes;
  {
    const AsUser user;
    bytes = read_file(built.module, kLargestModule);
  }
  const std::string hash = sha256(bytes);
  if (!is_approved({"library", hash, {}}))
    throw Error(
        "plugin-not-approved",
        built.module.string() + " has changed since it was built (sha256 " + hash + ")",
        "build it again with `polyarm plugin build`, or: polyarm plugins approve " + shell_word(built.module.string()));
  static std::map<std::string, const hardware::PluginTable*> open;  // a library is opened once
  const hardware::PluginTable*& table = open[hash];
  if (!table) table = &hardware::open_plugin(built.module, bytes);
  for (std::uint32_t i = 0; i < table->count; ++i)
    if (built.name == table->entries[i].name && built.kind == table->entries[i].kind)
      return table->entries[i];
  throw Error("plugin-failed", built.module.string() + " has no '" + built.name + "'",
              "build it again with `polyarm plugin build`");
}

void read_record(const fs::path& file, std::vector<BuiltClass>& out) {
  std::error_code error;
  const fs::path module = fs::path(file).replace_extension(".so");
  if (!fs::is_regular_file(module, error)) return;
  std::istringstream lines(read_file(file, kLargestRecord));
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> words = split_fields(line, '\t');
    if (words.size() < 2 || words[0].empty()) continue;
    const bool controller = words.size() > 2 && words[1] == kControllerWord;
    out.push_back({words[0], module, words.back(),
                   controller ? hardware::PluginKind::controller : hardware::PluginKind::hardware});
  }
}
}  // namespace

fs::path built_folder() {
  if (const char* data = std::getenv("XDG_DATA_HOME"); data && *data)
    return fs::path(data) / "polyarm" / "plugins";
  if (const char* home = std::getenv("HOME"); home && *home)
    return fs::path(home) / ".local/share/polyarm/plugins";
  return {};
}

void record_built(const fs::path& module, const std::vector<BuiltClass>& classes) {
  std::string text;
  for (const BuiltClass& each : classes)
    text += each.name + "\t" +
            (each.kind == hardware::PluginKind::controller ? std::string(kControllerWord) + "\t" : "") +
            join(split_words(each.help), " ") + "\n";
  write_file_atomically(fs::path(module).replace_extension(".plugin"), text);
  const std::string hash = sha256(read_file(module, kLargestModule)), file = resolved(module).string();
  for (const Approval& old : approvals())
    if (old.kind == "library" && old.what == file && old.subject != hash) revoke(old.subject);
  approve({"library", hash, file});
}

std::vector<BuiltClass> built_classes() {
  const AsUser user;
  std::vector<fs::path> files;
  std::error_code error;
  for (auto at = fs::directory_iterator(built_folder(), error); !error && at != fs::directory_iterator();
       at.increment(error))
    if (at->path().extension() == ".plugin") files.push_back(at->path());
  std::sort(files.begin(), files.end());
  std::vector<BuiltClass> out;
  Problems ignored;  // a record that cannot be read names nothing
  for (const fs::path& file : files) collect(ignored, [&] { read_record(file, out); });
  return out;
}

void register_built() {
  for (const BuiltClass& each : built_classes()) {
    if (each.kind == hardware::PluginKind::controller) {
      for (const std::string& name : {each.name, kBuiltPrefix + each.name})
        if (!controllers::find_controller_type(name) && known_built().insert(name).second)
          controllers::register_controller_type(
              {name, [each] { return make_controller(open_built(each), each.module); }, each.help});
      continue;
    }
    if (hardware::driver_available(each.name)) continue;
    known_built().insert(each.name);
    hardware::register_driver(each.name, [each] { return hardware::make_component(open_built(each), each.module); });
  }
}

bool is_own_controller(const std::string& name) {
  return controllers::find_controller_type(name) && !known_built().contains(name);
}

bool is_built(const std::string& name) {
  return known_built().contains(name);
}

}  // namespace polyarm::plugins
