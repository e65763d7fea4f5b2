#include "polyarm/ros_packages/package.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <string_view>

#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/xml_bounds.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::ros_packages {

namespace fs = std::filesystem;

namespace {
void parse(tinyxml2::XMLDocument& document, const fs::path& file) {
  const std::string text = without_instructions(read_file(file, kLargestXml));
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    throw Error(
        Problem{"bad-package", {file.string(), document.ErrorLineNum()}, "this is no XML", "mend the file"});
}

std::string text_of(const tinyxml2::XMLElement* element) {
  return element && element->GetText() ? std::string(trim(element->GetText())) : std::string();
}
std::string attribute(const tinyxml2::XMLElement& element, const char* name) {
  const char* text = element.Attribute(name);
  return text ? std::string(trim(text)) : std::string();
}

bool left_out(const fs::path& folder) {
  const std::string name = folder.filename().string();
  if (name.empty() || name[0] == '.' || name == "build" || name == "install" || name == "log") return true;
  std::error_code error;
  for (const char* mark : {"COLCON_IGNORE", "AMENT_IGNORE", "CATKIN_IGNORE"})
    if (fs::exists(folder / mark, error)) return true;
  return false;
}

struct Search {
  std::vector<Package>& out;
  Problems& problems;
  std::size_t folders = 0;

  void look(const fs::path& folder, int depth) {
    if (++folders > kMostFolders || out.size() >= kMostPackages || depth > static_cast<int>(kDeepest)) return;
    std::error_code error;
    if (fs::is_regular_file(folder / "package.xml", error))
      return collect(problems, [&] { out.push_back(read_package(folder / "package.xml")); });
    std::vector<fs::path> below;
    for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator();
         at.increment(error))
      if (at->is_directory(error) && !at->is_symlink(error)) below.push_back(at->path());
    std::sort(below.begin(), below.end());
    for (const fs::path& each : below)
      if (!left_out(each)) look(each, depth + 1);
  }
};

/// What the build file names in find_package or in a list: a package of the workspace with such a name is
/// needed, whatever package.xml says.
std::set<std::string> cmake_names(const fs::path& file) {
  std::set<std::string> out;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return out;
  std::istringstream lines(read_file(file, kLargestSource));
  bool list = false;
  int tests = 0;  // depth of what is between if(BUILD_TESTING) and its endif
  for (std::string line; std::getline(lines, line);) {
    line.erase(std::min(line.find('#'), line.size()));
    const std::vector<std::string> words = split_words(line, " \t();");
    if (words.empty()) continue;
    const std::string first = lower(words[0]);
    if (tests > 0) {  // not built
      tests += first == "if" ? 1 : first == "endif" ? -1 : 0;
      continue;
    }
    if (first == "if" && words.size() > 1 && words[1] == "BUILD_TESTING") tests = 1;
    list = list || first == "set" || first == "ament_target_dependencies";
    if (first == "find_package" && words.size() > 1) out.insert(words[1]);
    if (list) out.insert(words.begin(), words.end());
    if (line.find(')') != std::string::npos) list = false;
    if (out.size() > kMostPackages) break;
  }
  return out;
}

void add_in_order(const Package& package, const std::vector<Package>& all, std::set<std::string>& seen,
                  std::vector<const Package*>& out) {
  if (!seen.insert(package.name).second) return;
  const auto add = [&](const std::string& name) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const Package& p) { return p.name == name; });
    if (found != all.end()) add_in_order(*found, all, seen, out);
  };
  for (const Dependency& needed : package.dependencies)
    if (needed.for_build) add(needed.name);
  for (const std::string& name : package.named_by_cmake) add(name);
  out.push_back(&package);
}

void add_classes(const tinyxml2::XMLElement& library, const fs::path& file, std::vector<PluginClass>& out) {
  for (auto* e = library.FirstChildElement("class"); e; e = e->NextSiblingElement("class")) {
    PluginClass made;
    made.type = attribute(*e, "type");
    made.name = attribute(*e, "name");
    if (made.name.empty()) made.name = made.type;
    made.base = attribute(*e, "base_class_type");
    if (made.base.empty()) made.base = attribute(*e, "base_class");
    made.description = text_of(e->FirstChildElement("description"));
    made.library = fs::path(attribute(library, "path")).filename().string();
    if (made.library.starts_with("lib")) made.library.erase(0, 3);
    made.where = {file.string(), e->GetLineNum()};
    if (!made.type.empty()) out.push_back(std::move(made));
  }
}

void read_classes(const fs::path& file, std::vector<PluginClass>& out) {
  tinyxml2::XMLDocument document;
  parse(document, file);
  const tinyxml2::XMLElement* root = document.RootElement();
  if (!root) return;
  if (std::string_view(root->Name()) == "library") {
    for (auto* e = root; e; e = e->NextSiblingElement("library")) add_classes(*e, file, out);
  } else if (std::string_view(root->Name()) == "class_libraries") {
    for (auto* e = root->FirstChildElement("library"); e; e = e->NextSiblingElement("library"))
      add_classes(*e, file, out);
  }
}
}  // namespace

std::string bounds_table() {
  std::string out = "| what | at most | beyond |\n|---|---|---|\n";
  const auto row = [&](std::size_t value, std::string unit, const char* what, const char* beyond) {
    const bool mebibytes = unit == "bytes" && value % (1 << 20) == 0;
    out += std::string("| ") + what + " | " + std::to_string(mebibytes ? value >> 20 : value) + " " +
           (mebibytes ? "MiB" : unit) + " | " + beyond + " |\n";
  };
#define POLYARM_ROS_PACKAGES_ROW(name, value, unit, what, beyond) row(value, unit, what, beyond);
  POLYARM_ROS_PACKAGES_BOUNDS(POLYARM_ROS_PACKAGES_ROW)
#undef POLYARM_ROS_PACKAGES_ROW
  return out;
}

bool Package::has_cmake() const {
  std::error_code error;
  return fs::is_regular_file(folder / "CMakeLists.txt", error);
}

Package read_package(const fs::path& file) {
  tinyxml2::XMLDocument document;
  parse(document, file);
  const tinyxml2::XMLElement* root = document.FirstChildElement("package");
  Package out;
  out.name = root ? text_of(root->FirstChildElement("name")) : "";
  const bool plain =
      out.name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") ==
      std::string::npos;
  if (out.name.empty() || !plain)
    throw Error(Problem{"bad-package",
                        {file.string(), root ? root->GetLineNum() : 1},
                        "the file names no package",
                        "write <package format=\"3\"><name>my_package</name>…"});
  out.version = text_of(root->FirstChildElement("version"));
  out.folder = file.parent_path();
  for (auto* e = root->FirstChildElement(); e; e = e->NextSiblingElement()) {
    const std::string tag = e->Name();
    if (!tag.ends_with("depend")) continue;
    const bool runs = tag == "exec_depend" || tag == "test_depend" || tag == "run_depend" ||
                      tag == "doc_depend" || tag == "group_depend";
    out.dependencies.push_back({text_of(e), e->GetLineNum(), !runs});
  }
  out.named_by_cmake = cmake_names(out.folder / "CMakeLists.txt");
  if (const auto* exports = root->FirstChildElement("export"))
    out.build_type = text_of(exports->FirstChildElement("build_type"));
  if (out.build_type.empty()) {  // ROS 1 writes nothing, and in ROS 2 colcon needs nothing
    const bool ament = std::any_of(out.dependencies.begin(), out.dependencies.end(),
                                   [](const Dependency& d) { return d.name.starts_with("ament_cmake"); });
    out.build_type = ament ? "ament_cmake" : "catkin";
  }
  return out;
}

std::vector<Package> find_packages(const fs::path& path, Problems& problems) {
  std::vector<Package> out;
  Search{out, problems}.look(fs::absolute(path).lexically_normal(), 0);
  if (out.empty() && !problems.has_errors())
    throw Error("no-package", "there is no package.xml in " + path.string() + " or below it",
                "name the folder of a package, or of a workspace with packages in it");
  return out;
}

namespace {
/// The folder of the repository or the workspace that holds the package: the farthest of the folders above it
/// that has .git or is called src. Empty if none of the nearest five is one.
fs::path root_of(const Package& package) {
  fs::path out;
  std::error_code error;
  fs::path above = package.folder.parent_path();
  for (int up = 0; up < 5 && above.has_relative_path(); ++up, above = above.parent_path())
    if (above.filename() == "src" || fs::exists(above / ".git", error)) out = above;
  return out;
}

/// Packages elsewhere in the same repository or workspace; one that cannot be read is not needed.
void add_from_root(const Package& package, std::vector<Package>& out) {
  const fs::path root = root_of(package);
  if (root.empty() || root == package.folder.parent_path()) return;
  std::vector<Package> all;
  Problems ignored;
  Search{all, ignored}.look(root, 0);
  for (Package& found : all) {
    const bool known =
        found.name == package.name ||
        std::any_of(out.begin(), out.end(), [&](const Package& other) { return other.name == found.name; });
    if (!known && out.size() < kMostPackages) out.push_back(std::move(found));
  }
}
}  // namespace

namespace {
std::string last_word(std::string text) {
  while (!text.empty() && text.back() == '/') text.pop_back();
  if (text.ends_with(".git")) text.erase(text.size() - 4);
  const auto slash = text.find_last_of("/:");
  return slash == std::string::npos ? text : text.substr(slash + 1);
}
void add_listed(const fs::path& file, std::map<std::string, ListedSource>& out) {
  const Yaml listed = Yaml::parse(read_file(file, kLargestXml), file.string());
  for (const Yaml::Entry& repository : listed["repositories"].entries()) {
    if (out.size() >= kMostPackages) return;
    const std::string address = printable_line(repository.value["url"].text(""));
    if (address.empty()) continue;
    for (const std::string& name : {last_word(repository.key), last_word(address)})
      if (!name.empty()) out.try_emplace(name, ListedSource{address, file});
  }
}
}  // namespace

std::map<std::string, ListedSource> listed_sources(const Package& package) {
  std::map<std::string, ListedSource> out;
  const fs::path root = root_of(package);
  std::error_code error;
  fs::path folder = package.folder;
  for (int up = 0; up < 6 && folder.has_relative_path(); ++up, folder = folder.parent_path()) {
    std::vector<fs::path> files;
    for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator();
         at.increment(error))
      if (at->path().extension() == ".repos") files.push_back(at->path());
    std::sort(files.begin(), files.end());
    Problems ignored;  // one that cannot be read names nothing
    for (const fs::path& file : files) collect(ignored, [&] { add_listed(file, out); });
    if (folder == root || root.empty()) break;
  }
  return out;
}

std::vector<Package> packages_beside(const Package& package, Problems& problems) {
  std::vector<Package> out;
  const fs::path above = package.folder.parent_path();
  std::error_code error;
  for (auto at = fs::directory_iterator(above, error); !error && at != fs::directory_iterator();
       at.increment(error)) {
    if (out.size() >= kMostPackages) break;
    if (at->path() != package.folder && fs::is_regular_file(at->path() / "package.xml", error) &&
        !left_out(at->path()))
      collect(problems, [&] { out.push_back(read_package(at->path() / "package.xml")); });
    error.clear();
  }
  std::sort(out.begin(), out.end(), [](const Package& a, const Package& b) { return a.folder < b.folder; });
  add_from_root(package, out);
  return out;
}

std::vector<const Package*> in_build_order(const Package& package, const std::vector<Package>& all) {
  std::vector<const Package*> out;
  std::set<std::string> seen;
  add_in_order(package, all, seen, out);
  return out;
}

namespace {
/// All classes of the package's plugin description files.
std::vector<PluginClass> described_classes(const Package& package) {
  std::vector<fs::path> files;
  std::error_code error;
  auto at = fs::recursive_directory_iterator(package.folder, error);
  for (std::size_t seen = 0; !error && at != fs::recursive_directory_iterator() && seen < kMostFolders;
       at.increment(error), ++seen) {
    const std::string name = at->path().filename().string();
    if (at->is_directory(error) &&
        (at.depth() >= 3 || left_out(at->path()) || name == "test" || name == "tests"))
      at.disable_recursion_pending();
    if (at->path().extension() == ".xml" && at->path().filename() != "package.xml")
      files.push_back(at->path());
  }
  std::sort(files.begin(), files.end());
  std::vector<PluginClass> out;
  for (const fs::path& file : files) {
    Problems ignored;  // files of other kinds end in .xml too
    collect(ignored, [&] { read_classes(file, out); });
  }
  return out;
}
}  // namespace

bool PluginClass::is_hardware() const {
  for (const char* each : {"SystemInterface", "ActuatorInterface", "SensorInterface"})
    if (base == std::string("hardware_interface::") + each) return true;
  return false;
}
bool PluginClass::is_controller() const {
  return base.starts_with("controller_interface::") && base.ends_with("Interface");
}

std::vector<PluginClass> plugin_classes(const Package& package) {
  std::vector<PluginClass> out = described_classes(package);
  const auto of_others = [&](const PluginClass& c) { return !c.is_hardware() && !c.is_controller(); };
  out.erase(std::remove_if(out.begin(), out.end(), of_others), out.end());
  return out;
}

namespace {
/// True if so many letters added, left out or replaced make `b` of `a`.
bool within_edits(std::string_view a, std::string_view b, int edits) {
  while (!a.empty() && !b.empty() && a[0] == b[0]) a.remove_prefix(1), b.remove_prefix(1);
  if (a.empty() && b.empty()) return true;
  if (edits == 0) return false;
  const std::string_view less_a = a.substr(a.empty() ? 0 : 1), less_b = b.substr(b.empty() ? 0 : 1);
  return within_edits(less_a, less_b, edits - 1) || (!a.empty() && within_edits(less_a, b, edits - 1)) ||
         (!b.empty() && within_edits(a, less_b, edits - 1));
}

/// The base class of hardware or controllers that `base` misspells; empty: none.
std::string misspelled_base(std::string_view base) {
  constexpr int kSlips = 2;  // more make another package's name, as my_hardware_interface, or another class
  const auto colons = base.find("::");
  if (colons == std::string_view::npos) return {};
  for (const std::string_view known :
       {"hardware_interface::SystemInterface", "hardware_interface::ActuatorInterface",
        "hardware_interface::SensorInterface", "controller_interface::ControllerInterface",
        "controller_interface::ChainableControllerInterface"}) {
    const auto end = known.find("::");
    if (within_edits(base.substr(0, colons), known.substr(0, end), kSlips) &&
        within_edits(base.substr(colons + 2), known.substr(end + 2), kSlips))
      return std::string(known);
  }
  return {};
}
}  // namespace

void check_bases(const Package& package, const std::vector<Package>& all, Problems& problems) {
  for (const PluginClass& each : described_classes(package)) {
    if (each.is_hardware() || each.is_controller()) continue;
    const std::string space = each.base.substr(0, each.base.find("::"));
    if (std::any_of(all.begin(), all.end(), [&](const Package& p) { return p.name == space; })) continue;
    if (each.base == "hardware_interface::RobotHW" || each.base == "controller_interface::ControllerBase")
      problems.warning(
          "bad-base", each.where,
          "the base class '" + each.base + "' of " + each.name + " is one of ROS 1; the class is left out",
          "port it to ros2_control: docs/ros-plugins.md says how");
    else if (const std::string meant = misspelled_base(each.base); !meant.empty())
      problems.warning(
          "bad-base", each.where,
          "the base class '" + each.base + "' of " + each.name + " does not exist; the class is left out",
          "write base_class_type=\"" + meant + "\" if this is meant");
  }
}

std::vector<PluginClass> helper_classes(const Package& package, const std::vector<const Package*>& bases) {
  std::vector<PluginClass> out = described_classes(package);
  const auto of_others = [&](const PluginClass& c) {
    const std::string space = c.base.substr(0, c.base.find("::"));
    const auto is_base = [&](const Package* p) { return p->name == space; };
    return c.is_hardware() || c.is_controller() ||
           (space != "filters" && std::none_of(bases.begin(), bases.end(), is_base));
  };
  out.erase(std::remove_if(out.begin(), out.end(), of_others), out.end());
  return out;
}

std::vector<const Package*> helpers_of(const std::vector<const Package*>& order,
                                       const std::vector<Package>& all) {
  const bool filters = std::any_of(order.begin(), order.end(), [](const Package* p) {
    return std::any_of(p->dependencies.begin(), p->dependencies.end(),
                       [](const Dependency& d) { return d.name == "filters"; });
  });
  std::vector<const Package*> out;
  for (const Package& each : all) {
    if (std::any_of(order.begin(), order.end(), [&](const Package* p) { return p->name == each.name; }))
      continue;
    const auto classes = helper_classes(each, order);
    if (std::any_of(classes.begin(), classes.end(),
                    [&](const PluginClass& c) { return filters || !c.base.starts_with("filters::"); }))
      out.push_back(&each);
  }
  return out;
}

}  // namespace polyarm::ros_packages
