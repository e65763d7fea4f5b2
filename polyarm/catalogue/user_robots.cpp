#include "polyarm/catalogue/user_robots.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/urdf.hpp"

namespace polyarm::description {

namespace fs = std::filesystem;

namespace {

bool plain_word(const std::string& word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return std::islower(c) || std::isdigit(c) || c == '_' || c == '-';
  });
}

void check_name(const std::string& name) {
  const std::size_t slash = name.find('/');
  if (slash == std::string::npos || !plain_word(name.substr(0, slash)) || !plain_word(name.substr(slash + 1)))
    throw Error("bad-name", "'" + name + "' is not a name for a robot of the catalogue",
                "write maker/model in small letters, digits, '_' and '-', as in --name acme/one");
}

/// The value nearest to zero, slightly inside the joint's limits.
double rest_of(const Joint& joint) {
  if (!joint.limits.lower || !joint.limits.upper) return 0;
  const double low = *joint.limits.lower, high = *joint.limits.upper, margin = 0.05 * (high - low);
  return std::clamp(0.0, low + margin, high - margin);
}

void find_meshes(std::vector<Shape>& shapes) {
  for (Shape& shape : shapes)
    if (!shape.mesh_path.empty()) shape.mesh = "file://" + fs::absolute(shape.mesh_path).string();
}

}  // namespace

fs::path user_robot_folder() {
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config && *config)
    return fs::path(config) / "polyarm" / "robots";
  if (const char* home = std::getenv("HOME"); home && *home)
    return fs::path(home) / ".config" / "polyarm" / "robots";
  return {};
}

void check_for_catalogue(const RobotModel& model, Problems& problems) {
  if (model.actuated.empty())
    problems.error("nothing-moves", {}, "'" + model.name + "' has no joint that moves",
                   "describe an arm with revolute, continuous or prismatic joints");
  for (const int j : model.actuated) {
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    const bool bounded = joint.type == JointType::revolute || joint.type == JointType::prismatic;
    if (bounded && (!joint.limits.lower || !joint.limits.upper))
      problems.error("no-limits", {}, "joint '" + joint.name + "' states no lower and upper limit",
                     "add <limit lower=\"…\" upper=\"…\" velocity=\"…\"/>, or make it continuous");
    if (joint.limits.lower && joint.limits.upper && *joint.limits.lower >= *joint.limits.upper)
      problems.error("bad-limit", {},
                     "joint '" + joint.name + "': the lower limit is not below the upper one");
    if (!joint.limits.velocity || !(*joint.limits.velocity > 0))
      problems.warning("no-velocity", {}, "joint '" + joint.name + "' states no speed",
                       "without a limit, cells use their default speed for it");
  }
}

void complete_for_catalogue(RobotModel& model, const fs::path& source) {
  for (Link& link : model.links) {
    find_meshes(link.visuals);
    find_meshes(link.collisions);
  }
  if (model.provenance.source.empty()) model.provenance.source = fs::absolute(source).lexically_normal();
  if (model.named_states.contains("home")) return;
  std::vector<double> home;
  for (const int j : model.actuated) home.push_back(rest_of(model.joints[static_cast<std::size_t>(j)]));
  model.named_states["home"] = std::move(home);
  model.provenance.notes.emplace_back(
      "the description names no home: all joints as near to zero as limits allow");
}

fs::path store_robot(const RobotModel& model, const std::string& name, const fs::path& folder, bool replace) {
  check_name(name);
  const fs::path file = folder / (name + ".urdf");
  std::error_code error;
  for (const char* ending : {".urdf", ".yaml"})
    if (fs::exists(folder / (name + ending), error) && !replace)
      throw Error("exists", (folder / (name + ending)).string() + " exists already",
                  "take another --name, or --replace it");
  fs::create_directories(file.parent_path(), error);
  if (error)
    throw Error("no-folder", file.parent_path().string() + " cannot be created: " + error.message(),
                "choose a folder with --folder");
  write_file_atomically(file, write_urdf(model));
  // A robot file of this name would be read in place of the description, with its measured surfaces.
  for (const char* ending : {".yaml", ".look"})
    if (const fs::path old = folder / (name + ending); fs::exists(old, error) && !fs::remove(old, error))
      throw Error("not-removed", old.string() + " cannot be removed: " + error.message(),
                  "remove it: it is read in place of " + file.string());
  return file;
}

std::vector<std::string> robots_in(const fs::path& folder) {
  std::vector<std::string> out;
  std::error_code error;
  for (const auto& maker : fs::directory_iterator(folder, error)) {
    if (!maker.is_directory(error)) continue;
    for (const auto& file : fs::directory_iterator(maker.path(), error))
      if (file.path().extension() == ".urdf" || file.path().extension() == ".yaml")
        out.push_back((maker.path().filename() / file.path().stem()).generic_string());
  }
  std::sort(out.begin(), out.end());
  return out;
}

fs::path remove_robot(const std::string& name, const fs::path& folder) {
  check_name(name);
  std::error_code error;
  fs::path removed;
  for (const char* ending : {".urdf", ".yaml", ".srdf", ".look"}) {
    const fs::path file = folder / (name + ending);
    const bool is_beside = file.extension() == ".srdf" || file.extension() == ".look";
    if (!fs::exists(file, error) || (removed.empty() && is_beside)) continue;
    if (!fs::remove(file, error))
      throw Error("not-removed", file.string() + " cannot be removed: " + error.message());
    if (removed.empty()) removed = file;
  }
  if (removed.empty()) {
    const std::vector<std::string> known = robots_in(folder);
    throw Error("unknown-robot", folder.string() + " has no robot '" + name + "'" + did_you_mean(name, known),
                known.empty() ? "no robot has been added there" : "there are: " + join(known, ", "));
  }
  if (fs::is_empty(removed.parent_path(), error)) fs::remove(removed.parent_path(), error);
  return removed;
}

}  // namespace polyarm::description
