#include "polyarm/xacro/packages.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <set>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/xml_bounds.hpp"

namespace polyarm::description {

namespace fs = std::filesystem;

namespace {

void add_from(const char* variable, const char* below, std::vector<fs::path>& out) {
  if (const char* value = std::getenv(variable))
    for (const std::string& folder : split_words(value, ":")) out.push_back(fs::path(folder) / below);
}

constexpr std::size_t kLargestManifest = 1 << 20;

/// The name in a folder's package.xml, or "".
std::string declared_name(const fs::path& folder) {
  std::error_code error;
  const fs::path file = folder / "package.xml";
  if (!fs::is_regular_file(file, error)) return {};
  std::string text;
  Problems ignored;
  {
    const AsUser user;  // the name of a package is not secret, and packages may lie outside the cell's folder
    collect(ignored, [&] { text = read_file(file, kLargestManifest); });
  }
  tinyxml2::XMLDocument document;
  const std::string plain = without_instructions(text);
  if (document.Parse(plain.data(), plain.size()) != tinyxml2::XML_SUCCESS) return folder.filename().string();
  const auto* package = document.FirstChildElement("package");
  const auto* name = package ? package->FirstChildElement("name") : nullptr;
  return name && name->GetText() ? std::string(trim(name->GetText())) : folder.filename().string();
}

/// A folder that ROS build tools ignore.
bool is_ignored(const fs::path& folder) {
  std::error_code error;
  for (const char* mark : {"COLCON_IGNORE", "AMENT_IGNORE", "CATKIN_IGNORE"})
    if (fs::exists(folder / mark, error)) return true;
  return false;
}

constexpr int kMostFolders = 20'000, kDeepestPackage = 8;

/// The packages below a folder by name. Searches as ROS build tools do: at any depth, but not inside
/// packages, hidden folders and ignored folders. If several packages have the same name, the first one
/// nearest to the root counts.
class Workspace {
 public:
  explicit Workspace(fs::path root) : root_{std::move(root)} {}

  fs::path find(const std::string& name) {
    if (declared_name(root_ / name) == name) return root_ / name;  // the layout of installations
    if (!looked_) look();
    const auto found = packages_.find(name);
    return found == packages_.end() ? fs::path{} : found->second;
  }

 private:
  void look() {
    looked_ = true;
    std::vector<fs::path> level{root_};
    for (int depth = 0; depth < kDeepestPackage && !level.empty(); ++depth) {
      std::vector<fs::path> below;
      for (const fs::path& folder : level) search_in(folder, depth > 0, below);
      std::sort(below.begin(), below.end());
      level = std::move(below);
    }
  }

  void search_in(const fs::path& folder, bool may_be_package, std::vector<fs::path>& below) {
    std::error_code error;
    if (seen_ > kMostFolders || is_ignored(folder)) return;
    if (!visited_.insert(fs::weakly_canonical(folder, error)).second) return;  // links may form a cycle
    if (const std::string name = declared_name(folder); !name.empty()) {
      packages_.emplace(name, folder);
      if (may_be_package) return;
    }
    for (const auto& entry :
         fs::directory_iterator(folder, fs::directory_options::skip_permission_denied, error))
      if (entry.is_directory(error) && ++seen_ <= kMostFolders &&
          !entry.path().filename().string().starts_with('.'))
        below.push_back(entry.path());
  }

  fs::path root_;
  std::map<std::string, fs::path> packages_;
  std::set<fs::path> visited_;
  bool looked_ = false;
  int seen_ = 0;
};

/// Finds the folder of the package at or below `root`: first by its name, then by package.xml in the next
/// `levels` levels.
fs::path find_below(const fs::path& root, const std::string& name, int levels) {
  std::error_code error;
  if (declared_name(root / name) == name) return root / name;
  if (levels == 0) return {};
  int seen = 0;
  for (const auto& entry :
       fs::directory_iterator(root, fs::directory_options::skip_permission_denied, error)) {
    if (++seen > 2000) break;
    if (!entry.is_directory(error) || entry.path().filename().string().starts_with('.')) continue;
    if (declared_name(entry.path()) == name) return entry.path();
    if (levels > 1)
      if (const fs::path found = find_below(entry.path(), name, levels - 1); !found.empty()) return found;
  }
  return {};
}

}  // namespace

PackageSearch packages_near(const fs::path& file, const std::map<std::string, fs::path>& known) {
  std::vector<fs::path> above;
  std::error_code error;
  for (fs::path folder = fs::weakly_canonical(file, error).parent_path(); folder.has_relative_path();
       folder = folder.parent_path())
    above.push_back(folder);
  std::vector<fs::path> roots;
  add_from("POLYARM_PACKAGES", "", roots);
  add_from("ROS_PACKAGE_PATH", "", roots);
  add_from("AMENT_PREFIX_PATH", "share", roots);
  const auto workspaces = std::make_shared<std::vector<Workspace>>(roots.begin(), roots.end());
  const auto find = [known, above, workspaces](const std::string& name) -> fs::path {
    if (const auto found = known.find(name); found != known.end()) return found->second;
    if (name.empty() || name.find('/') != std::string::npos || name == "..") return {};
    bool inside = true;  // search two levels deep, but only below the nearest folders, not on the whole disk
    for (std::size_t i = 0; i < above.size() && i < 8; ++i) {
      const std::string own = declared_name(above[i]);
      if (own == name) return above[i];
      if (const fs::path found = find_below(above[i], name, inside && i < 4 ? 2 : 0); !found.empty())
        return found;
      inside = inside && i < 3;
    }
    for (Workspace& workspace : *workspaces)
      if (const fs::path found = workspace.find(name); !found.empty()) return found;
    return {};
  };
  return [find](const std::string& name) {
    fs::path found = find(name);
    reach().allow_reading(found);  // descriptions are read from packages anywhere on the disk
    return found;
  };
}

fs::path find_inside(const fs::path& package, const fs::path& inside) {
  const std::string tail = "/" + inside.generic_string();
  std::error_code error;
  fs::path found;
  int seen = 0;
  auto at = fs::recursive_directory_iterator(package, fs::directory_options::skip_permission_denied, error);
  for (; !error && at != fs::recursive_directory_iterator() && ++seen < 20'000; at.increment(error)) {
    const bool hidden = at->path().filename().string().starts_with('.');
    if (at->is_directory(error) && (hidden || at.depth() > 6)) at.disable_recursion_pending();
    if (!at->path().generic_string().ends_with(tail) || !at->is_regular_file(error)) continue;
    if (!found.empty()) return {};
    found = at->path();
  }
  return found;
}

std::vector<fs::path> files_that_include(const fs::path& file) {
  const std::string name = file.filename().string();
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(file, error).parent_path();
  std::vector<fs::path> folders{folder, folder.parent_path()};
  for (const fs::path& above : {folder, folder.parent_path()})
    for (const auto& entry : fs::directory_iterator(above, error))
      if (entry.is_directory(error) && folders.size() < 50) folders.push_back(entry.path());
  std::set<fs::path> out;
  int seen = 0;
  for (const fs::path& at : folders)
    for (const auto& entry : fs::directory_iterator(at, error)) {
      const std::string extension = entry.path().extension().string();
      if ((extension != ".xacro" && extension != ".urdf") || entry.path().filename() == name) continue;
      if (!entry.is_regular_file(error) || entry.file_size(error) > 256 * 1024 || ++seen > 500) continue;
      Problems ignored;
      std::string text;
      collect(ignored, [&] { text = read_file(entry.path()); });
      const bool includes = text.find("xacro:include") != std::string::npos &&
                            (text.find("/" + name + "\"") != std::string::npos ||
                             text.find("\"" + name + "\"") != std::string::npos);
      if (includes && out.size() < 10) out.insert(entry.path());
    }
  return {out.begin(), out.end()};
}

namespace {

/// True if the letter belongs to the "[a-z]" or "[!a-z]" that begins at `at`. Moves `at` to its end.
bool in_set(std::string_view pattern, std::size_t& at, char letter) {
  const bool inverted = at + 1 < pattern.size() && pattern[at + 1] == '!';
  const std::size_t first = at + (inverted ? 2 : 1);
  const std::size_t end = pattern.find(']', first + 1);
  if (end == std::string_view::npos) return letter == '[';
  bool found = false;
  for (std::size_t k = first; k < end; ++k) {
    const bool range = k + 2 < end && pattern[k + 1] == '-';
    found = found || (letter >= pattern[k] && letter <= pattern[range ? k + 2 : k]);
    if (range) k += 2;
  }
  at = end;
  return found != inverted;
}

/// A name that begins with '.' only matches a pattern that begins with '.'.
bool name_matches(std::string_view pattern, std::string_view name) {
  if (name.starts_with('.') && !pattern.starts_with('.')) return false;
  std::size_t p = 0, n = 0, star = std::string_view::npos, resume = 0;
  while (n < name.size()) {
    std::size_t next = p;
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = n;
    } else if (p < pattern.size() && (pattern[p] == '[' ? in_set(pattern, next, name[n])
                                                        : pattern[p] == '?' || pattern[p] == name[n])) {
      p = next + 1;
      ++n;
    } else if (star != std::string_view::npos) {  // the last * matches one more letter
      p = star + 1;
      n = ++resume;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

}  // namespace

std::vector<fs::path> files_matching(const fs::path& pattern) {
  std::vector<fs::path> found = {""};
  std::error_code error;
  for (const fs::path& part : pattern) {
    std::vector<fs::path> next;
    const bool fixed = part.string().find_first_of("*?[") == std::string::npos;
    for (const fs::path& folder : found) {
      if (fixed) {
        next.push_back(folder / part);
        continue;
      }
      for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, error))
        if (next.size() < 2000 && name_matches(part.string(), entry.path().filename().string()))
          next.push_back(folder / entry.path().filename());
    }
    found = std::move(next);
  }
  std::erase_if(found, [&](const fs::path& path) { return !fs::is_regular_file(path, error); });
  std::sort(found.begin(), found.end(),
            [](const fs::path& a, const fs::path& b) { return a.string() < b.string(); });
  return found;
}

}  // namespace polyarm::description
