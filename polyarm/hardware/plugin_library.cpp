#include "polyarm/hardware/plugin_library.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "polyarm/base/error.hpp"

namespace polyarm::hardware {

namespace {
const char* kRebuild =
    "build it again against this Polyarm: cmake -DCMAKE_PREFIX_PATH=<where Polyarm is installed>";

[[noreturn]] void refuse(const std::filesystem::path& file, std::string reason, std::string advice) {
  throw Error(Problem{"plugin-refused", {file.string()}, std::move(reason), std::move(advice)});
}

std::string version(std::uint32_t major, std::uint32_t minor) {
  return std::to_string(major) + "." + std::to_string(minor);
}

/// A library handle that closes the library unless it is kept.
class Library {
 public:
  /// `from`: path of the bytes of `file`.
  Library(const std::filesystem::path& file, const std::string& from)
      : handle_(::dlopen(from.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (handle_) return;
    const char* said = ::dlerror();
    std::string reason = said ? said : "no reason given";
    if (reason.starts_with(from + ": ")) reason.erase(0, from.size() + 2);
    refuse(file, "it cannot be loaded: " + reason,
           reason.find("undefined symbol") != std::string::npos
               ? std::string("it needs functions that this Polyarm does not have; ") + kRebuild
               : "install the libraries that it needs, or build it again for this machine");
  }
  ~Library() {
    if (handle_) ::dlclose(handle_);
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  void* find(const char* symbol) const { return ::dlsym(handle_, symbol); }
  void keep() { handle_ = nullptr; }

 private:
  void* handle_;
};

const PluginTable* table_of(const Library& library, const std::filesystem::path& file) {
  void* const found = library.find("polyarm_plugin");
  if (!found)
    refuse(file, "it exports no polyarm_plugin, so it is not a plugin of Polyarm",
           "end its source with POLYARM_PLUGIN(…), or take the file out of the folder");
  const PluginTable* table = nullptr;
  try {
    table = reinterpret_cast<const PluginTable* (*)()>(found)();
  } catch (...) {
    refuse(file, "its polyarm_plugin threw: " + what_was_thrown(), "report it to its author");
  }
  if (!table) refuse(file, "its polyarm_plugin returns no table", "report it to its author");
  return table;
}

void judge(const PluginTable& table, const std::filesystem::path& file) {
  if (table.major != kPluginMajor || table.minor > kPluginMinor)
    refuse(file,
           "it is made for plugin interface " + version(table.major, table.minor) + ", this Polyarm has " +
               version(kPluginMajor, kPluginMinor),
           table.major < kPluginMajor ? kRebuild : "install a newer Polyarm, or build it against this one");
  if (!table.abi || !table.compiler || !table.name || !table.version || (!table.entries && table.count > 0))
    refuse(file, "its table has holes", "make it with POLYARM_PLUGIN(…)");
  if (std::strcmp(table.abi, kPluginAbi) != 0)
    refuse(file,
           std::string("it was built with ") + table.compiler + " for '" + table.abi +
               "', this Polyarm with " + kPluginCompiler + " for '" + kPluginAbi + "'",
           std::string("build it again with a compiler and standard library of that ABI, such as ") +
               kPluginCompiler);
}

void judge_entry(const PluginEntry& entry, std::uint32_t number, const std::filesystem::path& file) {
  const bool hardware = entry.kind == PluginKind::hardware, controller = entry.kind == PluginKind::controller;
  if (!entry.name || !entry.help || (hardware && !entry.make_hardware) ||
      (controller && !entry.make_controller))
    refuse(file, "entry " + std::to_string(number) + " of its table has holes",
           "make it with POLYARM_HARDWARE(…) or POLYARM_CONTROLLER(…)");
  if (!hardware && !controller)
    refuse(file,
           std::string("'") + entry.name + "' is neither hardware nor a controller but kind " +
               std::to_string(static_cast<std::uint32_t>(entry.kind)),
           "make it with POLYARM_HARDWARE(…) or POLYARM_CONTROLLER(…)");
  if (hardware && entry.layout != kComponentLayout)
    refuse(file,
           std::string("'") + entry.name +
               "' was built with headers whose types have other sizes than those of this Polyarm",
           kRebuild);
}
}  // namespace

namespace {
/// Copies the bytes into sealed memory, so nobody can change them. The descriptor stays open, because the
/// loader identifies libraries by its path.
std::string sealed_copy(const std::filesystem::path& file, std::string_view bytes) {
  const int fd = ::memfd_create(file.filename().c_str(), MFD_CLOEXEC | MFD_ALLOW_SEALING);
  bool good = fd >= 0;
  for (std::size_t done = 0; good && done < bytes.size();) {
    const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    good = n > 0;
    if (good) done += static_cast<std::size_t>(n);
  }
  if (!good || ::fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    const std::string reason = std::strerror(errno);
    if (fd >= 0) ::close(fd);
    refuse(file, "there is no memory to load it from: " + reason, "free some");
  }
  return "/proc/self/fd/" + std::to_string(fd);
}

const PluginTable& open_from(const std::filesystem::path& file, const std::string& from) {
  Library library(file, from);
  const PluginTable* const table = table_of(library, file);
  judge(*table, file);
  for (std::uint32_t i = 0; i < table->count; ++i) judge_entry(table->entries[i], i + 1, file);
  library.keep();
  return *table;
}
}  // namespace

const PluginTable& open_plugin(const std::filesystem::path& file) {
  return open_from(file, file.string());
}

const PluginTable& open_plugin(const std::filesystem::path& file, std::string_view bytes) {
  return open_from(file, sealed_copy(file, bytes));
}

std::unique_ptr<Component> make_component(const PluginEntry& entry, const std::filesystem::path& file) {
  std::unique_ptr<Component> out;
  try {
    out.reset(entry.make_hardware());
  } catch (...) {
    rethrow_as_error("plugin-failed", file.string() + ": making '" + entry.name + "' it",
                     "its author must fix that");
  }
  if (!out)
    throw Error("plugin-failed", file.string() + " makes nothing for '" + entry.name + "'",
                "report it to its author");
  return out;
}

}  // namespace polyarm::hardware
