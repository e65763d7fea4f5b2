#include "polyarm/ros_packages/check.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <map>
#include <set>
#include <sstream>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::ros_packages {

namespace fs = std::filesystem;

namespace {

bool is_source(const fs::path& file) {
  for (const char* ending : {".cpp", ".cc", ".cxx", ".c", ".hpp", ".h", ".hh", ".hxx"})
    if (file.extension() == ending) return true;
  return false;
}
bool of_tests(const fs::path& file) {
  for (const fs::path& part : file)
    for (const char* name : {"test", "tests", "gtest", "benchmark", "examples", "build", "install"})
      if (part == name) return true;
  return false;
}

std::vector<fs::path> sources_of(const Package& package) {
  std::vector<fs::path> out;
  std::error_code error;
  auto at = fs::recursive_directory_iterator(package.folder, error);
  for (; !error && at != fs::recursive_directory_iterator() && out.size() < kMostSources;
       at.increment(error)) {
    if (at->is_directory(error) && (at.depth() > static_cast<int>(kDeepest) || at->path().filename().string().starts_with(".")))
      at.disable_recursion_pending();
    if (is_source(at->path()) && !of_tests(at->path().lexically_relative(package.folder)))
      out.push_back(at->path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// The folders of a list with colons or semicolons in the environment, as the compiler and CMake read it.
std::vector<fs::path> folders_of(const char* variable) {
  std::vector<fs::path> out;
  const char* text = std::getenv(variable);
  for (std::string_view word : split_words(text ? text : "", ":;"))
    if (fs::path(word).is_absolute()) out.emplace_back(word);
  return out;
}

/// Where the compiler finds headers that are installed on this machine.
std::vector<fs::path> header_folders() {
  std::vector<fs::path> out = {"/usr/include", "/usr/local/include", "/usr/include/x86_64-linux-gnu",
                               "/usr/include/aarch64-linux-gnu", "/usr/include/eigen3"};
  std::error_code error;
  for (const char* library :
       {"/usr/include/c++", "/usr/include/x86_64-linux-gnu/c++", "/usr/include/aarch64-linux-gnu/c++"})
    for (const auto& version : fs::directory_iterator(library, error)) out.push_back(version.path());
  for (const char* variable : {"CPATH", "CPLUS_INCLUDE_PATH"})
    for (fs::path& each : folders_of(variable)) out.push_back(std::move(each));
  for (const fs::path& each : folders_of("CMAKE_PREFIX_PATH")) out.push_back(each / "include");
  return out;
}

/// Where CMake finds the files of packages that are installed on this machine.
std::vector<fs::path> config_folders() {
  std::vector<fs::path> out;
  std::vector<fs::path> prefixes = folders_of("CMAKE_PREFIX_PATH");
  prefixes.insert(prefixes.end(), {"/usr", "/usr/local"});
  for (const fs::path& prefix : prefixes)
    for (const char* below :
         {"lib/cmake", "lib/x86_64-linux-gnu/cmake", "lib/aarch64-linux-gnu/cmake", "share", "share/cmake"})
      out.push_back(prefix / below);
  return out;
}

/// Whether a line is between #if and #endif, apart from a header's guard.
class Conditions {
 public:
  void take(std::string_view line) {
    if (!line.starts_with("#")) return;
    const std::string_view word = trim(line.substr(1));
    ++directives_;
    if (word.starts_with("if")) {
      if (directives_ == 1 && (word.starts_with("ifndef") || word.starts_with("if !defined"))) guard_ = true;
      ++depth_;
    } else if (word.starts_with("endif") && depth_ > 0) {
      --depth_;
    }
  }
  bool inside() const { return depth_ > (guard_ ? 1 : 0); }

 private:
  int depth_ = 0, directives_ = 0;
  bool guard_ = false;
};

struct Check {
  const Package& package;
  const std::vector<Package>& all;
  const Kit& kit;
  Problems& problems;
  std::map<std::string, fs::path> own;  ///< headers of the workspace, by every tail of their path
  std::set<std::string> declared;       ///< types that the workspace's code declares itself
  std::set<std::string> reported, visited;
  std::vector<fs::path> waiting;
  struct Name {
    std::string text;
    Location where;
  };
  std::vector<Name> of_hardware =
      {};  ///< unknown names of hardware_interface; packages add constants of their own there
  bool foreign_header_missing = false;
  std::map<std::string, ListedSource> listed = listed_sources(package);

  void run() {
    std::vector<const Package*> providers = in_build_order(package, all);
    if (all.size() <= kMostProviders)  // build files also name folders of packages that package.xml does not
      for (const Package& each : all) providers.push_back(&each);
    for (const Package* each : providers) {
      take_messages(*each);
      take_made(*each);
      take_installed(*each);
      for (const fs::path& file : sources_of(*each)) take_own(*each, file);
    }
    take_folders_beside();
    check_cmake(package.folder / "CMakeLists.txt");
    for (waiting = plugin_sources(); !waiting.empty();) {
      const fs::path file = waiting.back();
      waiting.pop_back();
      if (visited.insert(file.string()).second) collect(problems, [&] { check_source(file); });
    }
    if (foreign_header_missing) return;  // it may declare these names
    for (const Name& name : of_hardware) missing_name(name.text, name.where);
  }

  /// The words of each call of `name` in the build file.
  static std::vector<std::vector<std::string>> calls(const std::string& text, const std::string& name) {
    std::vector<std::vector<std::string>> out;
    for (auto at = text.find(name + "("); at != std::string::npos; at = text.find(name + "(", at + 1)) {
      const auto begin = at + name.size() + 1, end = std::min(text.find(')', begin), text.size());
      out.push_back(split_words(text.substr(begin, end - begin)));
    }
    return out;
  }
  /// What the build file lists for the libraries of the plugins, also by way of a variable; all sources if it
  /// is not that plain.
  std::vector<fs::path> plugin_sources() const {
    std::vector<fs::path> out;
    std::error_code error;
    if (!fs::exists(package.folder / "CMakeLists.txt", error)) return sources_of(package);
    const std::string text = read_file(package.folder / "CMakeLists.txt", kLargestSource);
    const auto variables = variables_of(package, text);
    const auto of = [&](const std::string& word) {
      const auto found = variables.find(word);
      return found == variables.end() ? std::vector<std::string>{word} : found->second;
    };
    std::vector<std::vector<std::string>> libraries =
        calls(text, "add_library");  // also ament_auto_add_library
    for (const PluginClass& c : plugin_classes(package))
      for (const std::vector<std::string>& words : libraries) {
        if (c.library.empty() || words.empty()) continue;
        const std::vector<std::string> names = meanings(words[0], variables, 0);
        if (std::find(names.begin(), names.end(), c.library) == names.end()) continue;
        for (const std::string& word : words)
          for (const std::string& value : of(word))
            for (const std::string& each : meanings(value, variables, 0))
              if (fs::is_regular_file(package.folder / each, error)) out.push_back(package.folder / each);
      }
    return out.empty() ? sources_of(package) : out;
  }

  void take_own(const Package& from, const fs::path& file) {
    const fs::path inside = file.lexically_relative(from.folder);
    std::string tail;
    std::vector<fs::path> parts(inside.begin(), inside.end());
    for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
      tail = tail.empty() ? part->string() : part->string() + "/" + tail;
      own.emplace(tail, file);
    }
    std::istringstream code(read_file(file, kLargestSource));
    for (std::string word, before; code >> word; before = word)
      if (before == "class" || before == "struct" || before == "enum" || before == "namespace" ||
          before == "using" || before == "char" || before == "double" || before == "void" ||
          before == "define") {
        std::string name;
        for (const char c : word) {
          if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') break;
          name += c;
        }
        declared.insert(name);
      }
  }
  /// Folders outside the package that its build file names.
  void take_folders_beside() {
    std::error_code error;
    if (!fs::exists(package.folder / "CMakeLists.txt", error)) return;
    const std::string text = read_file(package.folder / "CMakeLists.txt", kLargestSource);
    for (const std::string& word : split_words(text, " \t\r\n()\"")) {
      const auto at = word.find("../");
      if (at == std::string::npos || (at > 0 && word[at - 1] != '/' && word[at - 1] != '}')) continue;
      const fs::path folder = (package.folder / word.substr(at)).lexically_normal();
      if (!fs::is_directory(folder, error)) continue;
      Package beside = package;
      beside.folder = folder;
      for (const fs::path& file : sources_of(beside)) take_own(beside, file);
    }
  }
  /// What a word with variables may mean: a variable may be set more than once.
  static std::vector<std::string> meanings(const std::string& word,
                                           const std::map<std::string, std::vector<std::string>>& variables,
                                           std::size_t depth) {
    const auto at = word.find("${"), end = word.find('}', at);
    if (at == std::string::npos || end == std::string::npos || depth >= kDeepest) return {word};
    const auto found = variables.find(word.substr(at, end + 1 - at));
    if (found == variables.end()) return {word};
    std::vector<std::string> out;
    for (const std::string& value : found->second) {
      if (out.size() >= kMostMeanings) break;
      if (value.find(found->first) != std::string::npos) continue;  // set(X ${X} more)
      for (std::string& each :
           meanings(word.substr(0, at) + value + word.substr(end + 1), variables, depth + 1))
        out.push_back(std::move(each));
    }
    return out.empty() ? std::vector<std::string>{word} : out;
  }
  /// What the build file sets, by "${NAME}".
  static std::map<std::string, std::vector<std::string>> variables_of(const Package& from,
                                                                      const std::string& text) {
    std::map<std::string, std::vector<std::string>> out;
    for (std::vector<std::string>& words : calls(text, "set")) {
      if (words.empty()) continue;
      std::vector<std::string>& values = out["${" + words[0] + "}"];
      values.insert(values.end(), words.begin() + 1, words.end());
    }
    out["${PROJECT_NAME}"] = {from.name};
    for (const char* here : {"${CMAKE_CURRENT_SOURCE_DIR}", "${CMAKE_CURRENT_LIST_DIR}",
                             "${PROJECT_SOURCE_DIR}", "${CMAKE_SOURCE_DIR}"})
      out[here] = {from.folder.string()};
    return out;
  }
  /// Headers that the build makes of the package's parameter files and templates.
  void take_made(const Package& from) {
    std::error_code error;
    if (!fs::exists(from.folder / "CMakeLists.txt", error)) return;
    const std::string text = read_file(from.folder / "CMakeLists.txt", kLargestSource);
    const auto variables = variables_of(from, text);
    for (const std::vector<std::string>& words : calls(text, "generate_parameter_library")) {
      if (words.empty()) continue;
      for (const std::string& name : meanings(words[0], variables, 0)) {
        own.emplace(name + ".hpp", "");
        own.emplace(from.name + "/" + name + ".hpp", "");
      }
    }
    for (const std::vector<std::string>& words : calls(text, "configure_file")) {
      if (words.size() < 2) continue;
      const std::string name = fs::path(words[1]).filename().string();
      own.emplace(name, "");
      own.emplace(from.name + "/" + name, "");
    }
  }
  /// Headers that the build file installs below include under another path than their own.
  void take_installed(const Package& from) {
    std::error_code error;
    if (!fs::exists(from.folder / "CMakeLists.txt", error)) return;
    const std::string text = read_file(from.folder / "CMakeLists.txt", kLargestSource);
    const auto variables = variables_of(from, text);
    for (const std::vector<std::string>& words : calls(text, "install")) {
      const auto to = std::find(words.begin(), words.end(), "DESTINATION");
      if (to == words.end() || to + 1 == words.end() || words[0] != "DIRECTORY") continue;
      const std::string place = meanings(to[1], variables, 0).front();
      if (!place.starts_with("include/")) continue;
      const fs::path below = fs::path(place).lexically_relative("include");
      for (auto word = words.begin() + 1; word != to; ++word) {
        if (fs::path(*word).is_absolute() || word->find("..") != std::string::npos) continue;
        Package part = from;
        part.folder = from.folder / *word;
        if (!fs::is_directory(part.folder, error)) continue;
        // With a slash at its end the folder's content is installed, otherwise the folder itself.
        const fs::path whole = word->ends_with("/") ? below : below / *word;
        for (const fs::path& file : sources_of(part))
          own.emplace((whole / file.lexically_relative(part.folder)).lexically_normal().string(), file);
      }
    }
  }
  /// Headers that the build makes of the package's interfaces.
  void take_messages(const Package& from) {
    for (const char* kind : {"msg", "srv", "action"}) {
      std::error_code error;
      for (const auto& file : fs::directory_iterator(from.folder / kind, error))
        for (const std::string& name : header_names({from.name, kind, file.path().stem().string(), "", {}}))
          own.emplace(name, "");
    }
  }

  static bool on_machine(const std::string& header) {
    std::error_code error;
    for (const fs::path& folder : header_folders())
      if (fs::exists(folder / header, error)) return true;
    if (header.find('/') != std::string::npos) return false;
    for (const auto& gcc : fs::directory_iterator("/usr/lib/gcc/x86_64-linux-gnu", error))
      if (fs::exists(gcc.path() / "include" / header, error)) return true;
    return header.find('.') == std::string::npos;  // the standard library of another compiler
  }

  void missing(const std::string& key, Location where, std::string what, const std::optional<Source>& source,
               const std::string& otherwise) {
    if (reported.insert(key).second)
      problems.error("missing", std::move(where), std::move(what), source ? source->advice() : otherwise);
  }

  void check_source(const fs::path& file) {
    const std::string code = read_file(file, kLargestSource);
    std::istringstream lines(code);
    int number = 0;
    Conditions conditions;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      conditions.take(trim(line));
      check_include(file, number, line, conditions.inside());
      if (trim(line).starts_with("*") || trim(line).starts_with("/*")) continue;  // a comment
      for (const char* space : {"hardware_interface::", "rclcpp::", "rclcpp_lifecycle::", "rclcpp_action::",
                                "realtime_tools::", "controller_interface::", "controller_manager::",
                                "control_toolbox::", "semantic_components::", "pluginlib::"})
        check_names(file, number, line, space);
    }
  }

  void check_include(const fs::path& file, int number, const std::string& line, bool conditional) {
    const std::string_view text = trim(line);
    if (!text.starts_with("#")) return;
    const std::string_view rest = trim(text.substr(1));
    if (!rest.starts_with("include")) return;
    const auto begin = rest.find_first_of("<\"");
    if (begin == std::string_view::npos) return;
    const auto end = rest.find(rest[begin] == '<' ? '>' : '"', begin + 1);  // a comment may follow
    if (end == std::string_view::npos || end == begin + 1) return;
    std::string header(rest.substr(begin + 1, end - begin - 1));
    std::error_code error;
    if (fs::exists(file.parent_path() / header, error))
      return waiting.push_back((file.parent_path() / header).lexically_normal());
    header = fs::path(header).lexically_normal().string();
    while (header.starts_with("../")) header.erase(0, 3);
    if (const auto found = own.find(header); found != own.end()) {
      if (!found->second.empty()) waiting.push_back(found->second);
      return;
    }
    if (kit.has_header(header) || on_machine(header)) return;
    const std::string folder = header.substr(0, header.find('/'));
    const bool known = header.find('/') != std::string::npos && kit.has_package(folder);
    if (conditional) {  // of another system, or of an option
      if (reported.insert("#if " + header).second)
        problems.warning("missing", {file.string(), number},
                         "no header '" + header + "' is here; it is between #if and #endif",
                         "if the compiler says that it is needed, install it");
      return;
    }
    foreign_header_missing = foreign_header_missing || !known;
    missing(header, {file.string(), number}, "no header '" + header + "' is here",
            kit.source_of_header(header),
            listed.contains(folder) ? advice(listed.at(folder))
            : known                 ? "Polyarm has the package " + folder +
                          ", but not this header: leave it out, or report it to the Polyarm project"
                    : "put the package that has it into the same workspace, or install it");
  }

  void check_names(const fs::path& file, int number, const std::string& line, const std::string& space) {
    const auto comment = std::min(line.find("//"), line.size());
    for (auto at = line.find(space); at < comment; at = line.find(space, at + 1)) {
      if (at > 0 && (std::isalnum(static_cast<unsigned char>(line[at - 1])) || line[at - 1] == '_' ||
                     line[at - 1] == '"'))
        continue;
      std::size_t end = at + space.size();
      while (end < line.size() && (std::isalnum(static_cast<unsigned char>(line[end])) || line[end] == '_'))
        ++end;
      const std::string name = line.substr(at + space.size(), end - at - space.size());
      const std::string package_name = space.substr(0, space.size() - 2);
      if (name.empty() || declared.contains(name) || kit.words(package_name).contains(name)) continue;
      if (space == "hardware_interface::")
        of_hardware.push_back({space + name, {file.string(), number}});
      else
        missing_name(space + name, {file.string(), number});
    }
  }
  static std::string advice(const ListedSource& from) {
    return "put " + from.address + " into the same workspace: " + from.file.filename().string() + " names it";
  }
  void missing_name(const std::string& name, const Location& where) {
    missing(name, where, "Polyarm has no " + name, std::nullopt,
            "write this part without it, or report it to the Polyarm project");
  }

  void check_cmake(const fs::path& file) {
    std::error_code error;
    if (!fs::exists(file, error)) {
      problems.error("missing", {package.folder.string(), 0}, "the package has no CMakeLists.txt",
                     "only packages that are built with ament_cmake can be plugins");
      return;
    }
    if (package.build_type == "catkin")
      problems.error("missing", {(package.folder / "package.xml").string(), 1},
                     "this is a package of ROS 1 (no <build_type>ament_cmake</build_type>)",
                     "port it to ros2_control first: docs/ros-plugins.md says how");
    std::istringstream lines(read_file(file, kLargestSource));
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      const std::string_view text = trim(line);
      if (!text.starts_with("find_package")) continue;
      const auto open = text.find('(');
      if (open == std::string_view::npos || text.find("REQUIRED") == std::string_view::npos) continue;
      const std::vector<std::string> words = split_words(text.substr(open + 1), " \t)");
      if (!words.empty()) check_needed(file, number, words.front());
    }
  }
  void check_needed(const fs::path& file, int number, const std::string& name) {
    if (name.find('$') != std::string::npos || kit.has_package(name)) return;
    if (std::any_of(all.begin(), all.end(), [&](const Package& p) { return p.name == name; }) ||
        found_by_cmake(name))
      return;
    const auto source = kit.source_of_package(name);
    if (reported.insert("package " + name).second)
      problems.warning("missing", {file.string(), number},
                       "no package '" + name + "' is here; the plugins may not need it",
                       source                  ? source->advice()
                       : listed.contains(name) ? advice(listed.at(name))
                                               : "put it into the same workspace, or install it");
  }
  static bool found_by_cmake(const std::string& name) {
    std::error_code error;
    for (const fs::path& folder : config_folders())
      for (const auto& each : fs::directory_iterator(folder, error)) {
        const std::string at = lower(each.path().filename().string());
        const bool named = at == lower(name) || at.starts_with(lower(name) + "-");
        if (named && (folder.filename() != "share" || fs::exists(each.path() / "cmake", error))) return true;
      }
    for (const auto& cmake : fs::directory_iterator("/usr/share", error))
      if (cmake.path().filename().string().starts_with("cmake-") &&
          fs::exists(cmake.path() / "Modules" / ("Find" + name + ".cmake"), error))
        return name != "Boost" || fs::exists("/usr/include/boost", error);
    return false;
  }
};
}  // namespace

bool overrides_configure(const Package& package) {
  for (const fs::path& file : sources_of(package)) {
    std::map<std::string, int> words;
    Problems unread;
    collect(unread, [&] { words = identifiers(read_file(file, kLargestSource)); });
    const auto has = [&](const char* word) { return words.contains(word); };
    if (has("configure") && has("start") && has("stop") && has("HardwareInfo") && !has("BaseInterface") &&
        !has("on_init") && (has("override") || has("final")) &&
        (has("SystemInterface") || has("ActuatorInterface") || has("SensorInterface")))
      return true;
  }
  return false;
}

void check_package(const Package& package, const std::vector<Package>& all, const Kit& kit,
                   Problems& problems) {
  Check{package, all, kit, problems, {}, {}, {}, {}, {}}.run();
}

}  // namespace polyarm::ros_packages
