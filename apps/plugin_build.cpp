#include "apps/plugin_build.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "polyarm/base/file.hpp"
#include "polyarm/base/sha256.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/hardware/plugin_library.hpp"
#include "polyarm/plugins/built.hpp"
#include "polyarm/plugins/plugins.hpp"
#include "polyarm/ros_packages/check.hpp"
#include "polyarm/ros_packages/module_code.hpp"

extern char** environ;

namespace polyarm::apps {

namespace fs = std::filesystem;
using ros_packages::Package;

namespace {
constexpr std::size_t kLargestLog = 64 << 20;

fs::path cache_folder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache)
    return fs::path(cache) / "polyarm" / "plugins";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache/polyarm/plugins";
  throw Error("no-home", "there is no folder to build in: neither XDG_CACHE_HOME nor HOME is set",
              "name one with --build-dir DIR");
}

/// Ends the compilers of a build when this process ends in any way before it is over, SIGKILL too: a child
/// reads from a pipe whose other end only this process has.
class GroupGuard {
 public:
  explicit GroupGuard(pid_t group) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return;
    guard_ = ::fork();
    if (guard_ == 0) watch(ends, group);
    ::close(ends[0]);
    write_end_ = ends[1];
  }
  ~GroupGuard() {
    if (write_end_ < 0) return;
    while (::write(write_end_, "x", 1) < 0 && errno == EINTR) {
    }
    ::close(write_end_);
    if (guard_ > 0) wait_for(guard_);
  }
  GroupGuard(const GroupGuard&) = delete;
  GroupGuard& operator=(const GroupGuard&) = delete;
  static int wait_for(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
  }

 private:
  [[noreturn]] static void watch(const int (&ends)[2], pid_t group) {
    ::close(ends[1]);
    for (const int each : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) ::signal(each, SIG_IGN);
    char over = 0;
    ssize_t got = 0;
    while ((got = ::read(ends[0], &over, 1)) < 0 && errno == EINTR) {
    }
    if (got == 0) ::kill(-group, SIGKILL);
    ::_exit(0);
  }
  pid_t guard_ = -1;
  int write_end_ = -1;
};

/// Runs the program in a process group of its own, with its output appended to `log`; true if it ends with 0.
bool run_logged(const std::vector<std::string>& words, const fs::path& log) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  ::posix_spawn_file_actions_adddup2(&actions, 1, 2);
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  pid_t child = 0;
  const int failed = ::posix_spawnp(&child, argv[0], &actions, &attributes, argv.data(), environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  if (failed)
    throw Error("build-failed", fmt::format("'{}' cannot be started: {}", words[0], std::strerror(failed)),
                "sudo apt install cmake g++");
  const GroupGuard guard(child);
  const int status = GroupGuard::wait_for(child);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// The lines of the log that say what is wrong; at most `most`.
std::vector<std::string> errors_in(const fs::path& log, std::size_t most) {
  std::vector<std::string> out;
  std::istringstream lines(read_file(log, kLargestLog));
  for (std::string line; out.size() < most && std::getline(lines, line);) {
    const bool tells =
        line.find(": error:") != std::string::npos || line.find("fatal error:") != std::string::npos ||
        line.find("polyarm-") != std::string::npos || line.find("undefined reference") != std::string::npos;
    if (tells) out.emplace_back(trim(line));
    if (line.starts_with("CMake Error") && std::getline(lines, line) && !trim(line).starts_with("polyarm-"))
      out.emplace_back(line.empty() ? "CMake: an error" : "CMake: " + std::string(trim(line)));
    else if (trim(line).starts_with("polyarm-") && !tells)
      out.emplace_back(trim(line));
  }
  return out;
}

/// What check() finds, else the first errors of compiler and CMake.
[[noreturn]] void fail(const Package& package, const Workspace& workspace, const ros_packages::Kit& kit,
                       const fs::path& log) {
  Problems problems;
  ros_packages::check_package(package, workspace.all, kit, problems);
  const bool explained = problems.has_errors();
  for (const std::string& line : errors_in(log, explained ? 1 : 5))
    problems.error("build-failed", {}, line, "");
  problems.error("build-failed", {package.folder.string(), 0},
                 "the package " + package.name + " was not built",
                 "the output of CMake and the compiler is in " + log.string());
  throw Error(problems.list());
}

/// Makes each class once: those that are really in the module. The others are problems, unless no class is
/// left.
std::vector<plugins::BuiltClass> classes_of(const hardware::PluginTable& table, const fs::path& module,
                                            Problems& problems) {
  std::vector<plugins::BuiltClass> out;
  Problems missing;
  for (std::uint32_t i = 0; i < table.count; ++i) {
    const hardware::PluginEntry& entry = table.entries[i];
    collect(missing, [&] {
      if (entry.kind == hardware::PluginKind::controller)
        plugins::make_controller(entry, module);
      else
        hardware::make_component(entry, module);
      out.push_back({entry.name, module, entry.help, entry.kind});
    });
  }
  if (out.empty() && table.count > 0) throw Error(missing.list());
  for (Problem each : missing.list()) {
    each.severity = Severity::warning;
    problems.add(each);
  }
  return out;
}

/// The packages that the module is made of. A package with filters or kinematics for it that misses something
/// is left out, and named.
std::vector<const Package*> order_with_helpers(const Package& package, const Workspace& workspace,
                                               const ros_packages::Kit& kit, Problems& problems) {
  std::vector<const Package*> out = ros_packages::in_build_order(package, workspace.all);
  for (const Package* helper : ros_packages::helpers_of(out, workspace.all)) {
    Problems missing;
    ros_packages::check_package(*helper, workspace.all, kit, missing);
    if (missing.has_errors()) {
      problems.warning("missing", {helper->folder.string(), 0},
                       "the plugins of " + helper->name + " are left out of " + package.name,
                       "polyarm plugin check " + helper->folder.string() + " says what they miss");
      continue;
    }
    for (const Package* each : ros_packages::in_build_order(*helper, workspace.all))
      if (std::find(out.begin(), out.end(), each) == out.end()) out.insert(out.end() - 1, each);
  }
  return out;
}

/// Replaces the module at once: one that a running cell has open stays as it is.
void install(const fs::path& made, const fs::path& module) {
  fs::create_directories(module.parent_path());
  write_file_atomically(module, read_file(made, std::size_t{256} << 20), 0755);
}
}  // namespace

Workspace open_workspace(const std::string& path, const ros_packages::Kit& kit, Problems& problems) {
  Workspace out;
  const auto replaced = [&](const Package& p) { return kit.replaces(p.name); };
  out.asked = ros_packages::find_packages(path, problems);
  if (out.asked.size() > 1) std::erase_if(out.asked, replaced);
  out.all = out.asked;
  if (out.asked.size() == 1)
    for (Package& beside : ros_packages::packages_beside(out.asked.front(), problems))
      if (!replaced(beside)) out.all.push_back(std::move(beside));
  for (const Package& each : out.asked) ros_packages::check_bases(each, out.all, problems);
  return out;
}

fs::path build_plugin(const Package& package, const Workspace& workspace, const ros_packages::Kit& kit,
                      const PluginBuild& build, Problems& problems) {
  kit.require_headers();
  const fs::path root = build.scratch.empty() ? cache_folder() : fs::absolute(build.scratch);
  const fs::path folder = root / (package.name + "-" + sha256(package.folder.string()).substr(0, 8));
  const fs::path log = folder / "build.log";
  fs::create_directories(folder);
  write_file_atomically(log, "");
  const auto classes = ros_packages::plugin_classes(package);
  const auto order = order_with_helpers(package, workspace, kit, problems);
  ros_packages::ModuleOptions options{build.simulated, fs::read_symlink("/proc/self/exe"),
                                      root / "interfaces", folder / "build", root / "wrappers"};
  ros_packages::write_headers(kit.interfaces(), options.generated);
  write_file_atomically(folder / "module.cpp", ros_packages::module_code(package, classes, order, options));
  write_file_atomically(folder / "CMakeLists.txt",
                        ros_packages::module_cmake(package, classes, order, kit, options));
  const char* set = std::getenv("CMAKE_BUILD_TYPE");
  const bool built =
      run_logged({"cmake", "-S", folder, "-B", folder / "build",
                  std::string("-DCMAKE_BUILD_TYPE=") + (set && *set ? set : "Release"), "-Wno-dev"},
                 log) &&
      run_logged({"cmake", "--build", folder / "build", "--target", "polyarm_ros_plugin", "-j",
                  std::to_string(build.jobs)},
                 log);
  if (!built) fail(package, workspace, kit, log);
  const fs::path made = folder / "build" / (package.name + ".so"),
                 module = plugins::built_folder() / (package.name + ".so");
  const hardware::PluginTable& table = hardware::open_plugin(made);
  const std::vector<plugins::BuiltClass> found = classes_of(table, made, problems);
  install(made, module);
  plugins::record_built(module, found);
  return module;
}

}  // namespace polyarm::apps
