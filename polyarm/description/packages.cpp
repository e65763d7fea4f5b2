#include "polyarm/description/packages.hpp"

#include <tinyxml2.h>

#include <cstdlib>

#include "polyarm/base/text.hpp"

namespace polyarm::description {

namespace fs = std::filesystem;

namespace {

void add_from(const char* variable, const char* below, std::vector<fs::path>& out) {
  if (const char* value = std::getenv(variable))
    for (const std::string& folder : split_words(value, ":")) out.push_back(fs::path(folder) / below);
}

/// The name that a folder's package.xml gives, or "".
std::string declared_name(const fs::path& folder) {
  std::error_code error;
  const fs::path file = folder / "package.xml";
  if (!fs::is_regular_file(file, error)) return {};
  tinyxml2::XMLDocument document;
  if (document.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS) return folder.filename().string();
  const auto* package = document.FirstChildElement("package");
  const auto* name = package ? package->FirstChildElement("name") : nullptr;
  return name && name->GetText() ? std::string(trim(name->GetText())) : folder.filename().string();
}

/// A folder below `root` that is the package: of its name, or at any of the next two levels.
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
  return [known, above, roots](const std::string& name) -> fs::path {
    if (const auto found = known.find(name); found != known.end()) return found->second;
    if (name.empty() || name.find('/') != std::string::npos || name == "..") return {};
    bool inside = true;  // of packages: a workspace is looked through two levels deep, not the whole disk
    for (std::size_t i = 0; i < above.size() && i < 8; ++i) {
      const std::string own = declared_name(above[i]);
      if (own == name) return above[i];
      if (const fs::path found = find_below(above[i], name, inside && i < 4 ? 2 : 0); !found.empty())
        return found;
      inside = inside && i < 3;
    }
    for (const fs::path& root : roots)
      if (const fs::path found = find_below(root, name, 1); !found.empty()) return found;
    return {};
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

}  // namespace polyarm::description
