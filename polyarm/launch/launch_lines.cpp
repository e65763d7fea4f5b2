/// Builds the polyarm command lines that replace a ROS 2 launch file.
#include <algorithm>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/base/shell_word.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/launch/python_launch.hpp"
#include "polyarm/xacro/packages.hpp"

namespace polyarm::ros_files {

namespace launch_lines {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostLines = 5;
constexpr int kMostFiles = 5000;

bool is_there(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error);
}

/// The text of a file; "" if it cannot be read.
std::string text_of(const fs::path& file) {
  std::string out;
  Problems ignored;
  if (is_there(file)) collect(ignored, [&] { out = read_file(file, 1 << 20); });
  return out;
}

/// True for a file of ROS parameters. A Gazebo node also gets the topics of its bridge as a YAML file.
bool has_controllers(const std::string& text) {
  return text.find("ros__parameters") != std::string::npos;
}

/// True if the xacro text declares the argument `name` with a default.
bool has_default(const std::string& text, const std::string& name) {
  for (std::size_t at = text.find("<xacro:arg"); at != std::string::npos;
       at = text.find("<xacro:arg", at + 1)) {
    const std::string element = text.substr(at, std::min<std::size_t>(text.find('>', at), at + 400) - at);
    if (element.find("\"" + name + "\"") != std::string::npos)
      return element.find("default") != std::string::npos;
  }
  return false;
}

/// Removes everything from `begin` to `end`, including both. Nested pairs are removed with the outer one.
void cut_out(std::string& text, std::string_view begin, std::string_view end) {
  std::string out;
  int depth = 0;
  std::size_t from = 0;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    const std::string_view rest = std::string_view(text).substr(at);
    if (rest.starts_with(begin) && depth++ == 0) out += text.substr(from, at - from);
    if (depth > 0 && rest.starts_with(end) && --depth == 0) from = at + end.size();
  }
  if (depth == 0) out += text.substr(from);
  text = std::move(out);
}

/// True for a part of robots: a file that has no link of its own and calls no macro, such as a file of
/// macros, of numbers or of materials. Without macros of its own, a file that includes another one may be a
/// robot.
bool is_part(std::string text) {
  const bool has_macros = text.find("<xacro:macro") != std::string::npos;
  if (!has_macros && text.find("<ros2_control") != std::string::npos) return false;
  for (std::size_t at; (at = text.find("<!--")) != std::string::npos;)
    text.erase(at, std::min(text.size(), text.find("-->", at) + 3) - at);
  cut_out(text, "<xacro:macro", "</xacro:macro>");
  if (text.find("<link") != std::string::npos) return false;
  std::set<std::string> kNoCalls = {"arg", "property", "if", "unless"};
  if (has_macros) kNoCalls.insert("include");
  constexpr std::string_view kCall = "<xacro:";
  for (std::size_t at = text.find(kCall); at != std::string::npos; at = text.find(kCall, at + 1)) {
    const std::size_t begin = at + kCall.size();
    if (!kNoCalls.contains(text.substr(begin, text.find_first_of(" \t\r\n/>", begin) - begin))) return false;
  }
  return true;
}

bool is_semantic(const fs::path& file) {
  return file.filename().string().find(".srdf") != std::string::npos;
}

/// Files in a package that a launch file could have named.
struct Found {
  std::vector<fs::path> descriptions, controllers;
};

Found search_in(const fs::path& package) {
  Found out;
  std::error_code error;
  int seen = 0;
  auto at = fs::recursive_directory_iterator(package, fs::directory_options::skip_permission_denied, error);
  for (; !error && at != fs::recursive_directory_iterator() && ++seen < kMostFiles; at.increment(error)) {
    const fs::path& file = at->path();
    if (at->is_directory(error) && (at.depth() > 4 || file.filename().string().starts_with('.')))
      at.disable_recursion_pending();
    const std::string extension = file.extension().string();
    if (extension == ".urdf" || extension == ".xacro")
      out.descriptions.push_back(file);
    else if ((extension == ".yaml" || extension == ".yml") && has_controllers(text_of(file)) &&
             text_of(file).find("controller_manager") != std::string::npos)
      out.controllers.push_back(file);
  }
  const auto rank = [](const fs::path& file) {  // robots (.urdf.xacro) before parts
    const std::string name = file.filename().string();
    return std::pair(name.ends_with(".urdf.xacro") ? 0 : name.ends_with(".urdf") ? 1 : 2, file.string());
  };
  std::sort(out.descriptions.begin(), out.descriptions.end(),
            [&](const fs::path& a, const fs::path& b) { return rank(a) < rank(b); });
  std::erase_if(out.descriptions, [](const fs::path& file) {
    const std::string text = text_of(file);
    return is_semantic(file) || text.find("<robot") == std::string::npos || is_part(text) ||
           !description::files_that_include(file).empty();
  });
  std::sort(out.controllers.begin(), out.controllers.end());
  return out;
}

/// True if a package beside `package` belongs to it: one names the other in its package.xml, or their names
/// begin with the same word. Other packages of a workspace are other robots.
bool belongs(const fs::path& package, const fs::path& other) {
  const auto names = [](const fs::path& from, const fs::path& to) {
    return text_of(from / "package.xml").find(">" + to.filename().string() + "<") != std::string::npos;
  };
  const auto word = [](const fs::path& folder) {
    const std::string name = folder.filename().string();
    return name.substr(0, name.find_first_of("_-"));
  };
  return word(package) == word(other) || names(package, other) || names(other, package);
}

}  // namespace
}  // namespace launch_lines

namespace {

/// True if a parameter file contains $(var NAME).
bool is_variable(const std::vector<PythonLaunchFile>& files, const std::string& name) {
  return std::any_of(files.begin(), files.end(), [&](const PythonLaunchFile& file) {
    return launch_lines::text_of(file.file).find("$(var " + name + ")") != std::string::npos;
  });
}

std::string text_of_all(const std::vector<PythonLaunchFile>& files) {
  std::string out;
  for (const PythonLaunchFile& file : files) out += launch_lines::text_of(file.file);
  return out;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> PythonLaunch::variables() const {
  std::vector<std::pair<std::string, std::string>> out;
  for (const PythonLaunchArgument& argument : arguments)
    if (argument.known && is_variable(parameters, argument.name))
      out.emplace_back(argument.name, argument.value);
  return out;
}

std::vector<PythonLaunchNeed> PythonLaunch::needed() const {
  std::vector<PythonLaunchNeed> out;
  if (descriptions.empty()) return out;
  const std::string text = launch_lines::text_of(descriptions.front().file);
  for (const PythonLaunchNeed& need : descriptions.front().unknown)
    if (!need.argument.empty() || !launch_lines::has_default(text, need.name)) out.push_back(need);
  for (const PythonLaunchArgument& argument : arguments)
    if (!argument.known && is_variable(parameters, argument.name))
      out.push_back({argument.name, argument.name});
  return out;
}

std::string PythonLaunch::why_no_activate() const {
  if (spawned.empty() && spawned_known) return "";
  if (!spawned_known) return "which controllers are started is not known in full";
  const std::string all = text_of_all(parameters);
  for (const std::string& name : spawned)
    if (all.find(name + ":") == std::string::npos)
      return "'" + name + "' is started, but no controllers file that is here has it";
  return "";
}

std::string PythonLaunch::line(const std::string& verb) const {
  if (descriptions.empty()) return "";
  const PythonLaunchDescription& description = descriptions.front();
  std::string out = "polyarm " + verb + " --description " + shell_word(description.file.string());
  for (const PythonLaunchFile& file : parameters) {
    const std::string text = launch_lines::text_of(file.file);
    if (launch_lines::is_there(file.file) && !launch_lines::has_controllers(text)) continue;
    out += " --controllers " + shell_word(file.file.string());
  }
  if (verb == "run" && why_no_activate().empty())
    for (const std::string& name : std::set<std::string>(spawned.begin(), spawned.end()))
      out += " --activate " + shell_word(name);
  std::set<std::string> said;
  for (const auto& [name, value] : description.arguments)
    if (said.insert(name).second) out += " " + shell_word(name + ":=" + value);
  for (const auto& [name, value] : variables())
    if (said.insert(name).second) out += " " + shell_word(name + ":=" + value);
  for (const PythonLaunchNeed& need : needed())
    if (said.insert(need.name).second) out += " " + shell_word(need.name) + ":=VALUE";
  return out;
}

std::vector<std::string> lines_of_package(const std::filesystem::path& launch, const std::string& verb) {
  using namespace launch_lines;
  std::error_code error;
  fs::path package = fs::weakly_canonical(launch, error).parent_path();
  for (int up = 0; up < 4 && !is_there(package / "package.xml"); ++up) package = package.parent_path();
  if (!is_there(package / "package.xml")) return {};
  std::vector<fs::path> folders{package};
  for (const auto& entry : fs::directory_iterator(package.parent_path(), error))
    if (folders.size() < 20 && entry.path() != package && is_there(entry.path() / "package.xml") &&
        belongs(package, entry.path()))
      folders.push_back(entry.path());
  std::sort(folders.begin() + 1, folders.end());
  std::vector<std::string> out;
  std::string controllers;
  for (const fs::path& folder : folders) {
    const Found found = search_in(folder);
    if (controllers.empty() && !found.controllers.empty())
      controllers = " --controllers " + shell_word(found.controllers.front().string());
    for (const fs::path& description : found.descriptions)
      if (out.size() < kMostLines)
        out.push_back("polyarm " + verb + " --description " + shell_word(description.string()));
    if (folder == package && !out.empty()) break;
  }
  for (std::string& line : out) line += controllers;
  return out;
}

}  // namespace polyarm::ros_files
