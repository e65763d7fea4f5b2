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

namespace polyarm::plugins {

namespace fs = std::filesystem;

namespace {
constexpr std::size_t kLargestModule = 256 << 20, kLargestRecord = 1 << 20;

std::set<std::string>& known_built() {
  static std::set<std::string> names;
  return names;
}

std::unique_ptr<hardware::Component> make_built(const BuiltClass& built) {
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
    if (built.name == table->entries[i].name)
      return hardware::make_component(table->entries[i], built.module);
  throw Error("plugin-failed", built.module.string() + " has no '" + built.name + "'",
              "build it again with `polyarm plugin build`");
}

void read_record(const fs::path& file, std::vector<BuiltClass>& out) {
  std::error_code error;
  const fs::path module = fs::path(file).replace_extension(".so");
  if (!fs::is_regular_file(module, error)) return;
  std::istringstream lines(read_file(file, kLargestRecord));
  for (std::string line; std::getline(lines, line);) {
    const auto tab = line.find('\t');
    if (tab != std::string::npos && tab > 0)
      out.push_back({line.substr(0, tab), module, line.substr(tab + 1)});
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
  for (const BuiltClass& each : classes) text += each.name + "\t" + join(split_words(each.help), " ") + "\n";
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
    if (hardware::driver_available(each.name)) continue;
    known_built().insert(each.name);
    hardware::register_driver(each.name, [each] { return make_built(each); });
  }
}

bool is_built(const std::string& name) {
  return known_built().contains(name);
}

}  // namespace polyarm::plugins
