#include "polyarm/catalogue/catalogue.hpp"

#include <algorithm>
#include <cstdlib>
#include <set>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/installation.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/catalogue/catalogue_index.hpp"
#include "polyarm/catalogue/user_robots.hpp"
#include "polyarm/description/srdf.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/shell_word.hpp"
#include "polyarm/xacro/xacro.hpp"

namespace polyarm::description {

namespace fs = std::filesystem;

namespace {

/// "universal_robots/ur3" from the last two parts of the path.
std::string name_of(const fs::path& file) {
  return file.parent_path().filename().string() + "/" + file.stem().string();
}

/// True for a maker and a model with a slash between them, and no path to another folder.
bool is_whole_name(const std::string& name) {
  const std::size_t slash = name.find('/');
  if (slash == std::string::npos || name.find('/', slash + 1) != std::string::npos) return false;
  for (const std::string& part : {name.substr(0, slash), name.substr(slash + 1)})
    if (part.empty() || part == "." || part == "..") return false;
  return true;
}

/// The content of a folder; empty if it cannot be listed.
std::vector<fs::path> content_of(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  for (auto it = fs::directory_iterator(folder, error); !error && it != fs::directory_iterator();
       it.increment(error))
    out.push_back(it->path());
  return out;
}

std::vector<fs::path> robot_files(const std::vector<fs::path>& folders) {
  std::vector<fs::path> out;
  std::set<std::string> seen;
  for (const fs::path& folder : folders)
    for (const fs::path& maker : content_of(folder))
      for (const fs::path& file : content_of(maker))
        if ((file.extension() == ".yaml" || file.extension() == ".urdf") && seen.insert(name_of(file)).second)
          out.push_back(file);
  std::sort(out.begin(), out.end(),
            [](const fs::path& a, const fs::path& b) { return name_of(a) < name_of(b); });
  return out;
}

}  // namespace

/// Reads a robot file, or a description that a user has added. Its warnings were shown when it was added.
static RobotModel read_entry(const fs::path& file) {
  if (file.extension() != ".urdf") return read_robot_file(file);
  Problems found;
  RobotModel out = read_urdf(read_file(file, bounds::kXmlBytes), file.string(), found);
  if (found.has_errors()) out.hardware.clear();  // this fault was shown when the robot was added
  for (const Link& link : out.links)             // the user added it with its meshes, so they may be read
    for (const auto* shapes : {&link.visuals, &link.collisions})
      for (const Shape& shape : *shapes) reach().allow_reading(shape.mesh_path);
  return out;
}

static CatalogueEntry entry_of(const RobotModel& model, std::string name, const fs::path& file) {
  CatalogueEntry out;
  out.name = std::move(name);
  out.maker = model.provenance.maker;
  out.model = model.provenance.model;
  out.axes = static_cast<int>(model.actuated.size());
  out.reach_m = model.provenance.reach_m;
  out.payload_kg = model.provenance.payload_kg;
  out.file = file;
  for (const Link& link : model.links)
    if (link.inertial) {
      out.mass_kg = out.mass_kg.value_or(0) + link.inertial->mass;
      out.mass_estimated |= link.inertial->estimated;
    }
  return out;
}

std::vector<CatalogueEntry> Catalogue::entries() const {
  std::vector<CatalogueEntry> out;
  CatalogueIndex index(catalogue_index_file());
  for (const fs::path& file : robot_files(folders_)) {
    if (auto known = index.find(file)) {
      out.push_back(std::move(*known));
      continue;
    }
    out.push_back(entry_of(read_entry(file), name_of(file), file));
    index.add(out.back());
  }
  index.save();
  return out;
}

std::vector<std::string> Catalogue::names() const {
  std::vector<std::string> out;
  for (const fs::path& file : robot_files(folders_)) out.push_back(name_of(file));
  return out;
}

std::optional<fs::path> Catalogue::find(const std::string& name) const {
  std::error_code error;
  if (is_whole_name(name)) {
    for (const fs::path& folder : folders_)
      for (const char* extension : {".yaml", ".urdf"})
        if (fs::path file = folder / (name + extension); fs::is_regular_file(file, error)) return file;
    return std::nullopt;
  }
  std::optional<fs::path> out;
  for (const fs::path& file : robot_files(folders_)) {
    if (!equal_ignoring_case(file.stem().string(), name)) continue;
    if (out) return std::nullopt;
    out = file;
  }
  return out;
}

RobotModel Catalogue::load(const std::string& wanted) const {
  if (const auto file = find(wanted)) return read_entry(*file);
  std::vector<std::string> all;
  for (const fs::path& file : robot_files(folders_)) {
    all.push_back(name_of(file));
    all.push_back(file.stem().string());
  }
  if (all.empty())
    throw Error("no-catalogue", "the catalogue of robots was not found",
                "set POLYARM_ROBOTS to the folder robots/ of Polyarm");
  throw Error("unknown-robot", "there is no robot '" + wanted + "'" + did_you_mean(wanted, all),
              "`polyarm robots` lists them; a path to a .urdf file works too");
}

std::vector<fs::path> default_catalogue_folders() {
  std::vector<fs::path> out;
  if (const char* from_user = std::getenv("POLYARM_ROBOTS"))
    for (const std::string& folder : split_words(from_user, ":")) out.emplace_back(folder);
  std::error_code error;
  if (const fs::path own = user_robot_folder(); !own.empty() && fs::is_directory(own, error))
    out.push_back(own);
  for (const fs::path& folder : installation::data_folders("robots", "universal_robots"))
    out.push_back(folder);
  return out;
}

void add_srdf_beside(const fs::path& description, RobotModel& model, Problems& warnings) {
  const fs::path file = srdf_beside(description);
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return;
  // The user did not name this file, so its faults do not reject the robot. MoveIt too logs such lines and
  // continues.
  Problems lines, whole;
  collect(whole, [&] { read_srdf(read_file(file, bounds::kXmlBytes), file.string(), model, lines); });
  for (const auto& [problems, left_out] :
       {std::pair{&lines, "; the line is left out"}, std::pair{&whole, "; the file is left out"}})
    for (Problem problem : problems->list()) {
      if (problem.severity == Severity::error) problem.what += left_out;
      problem.severity = Severity::warning;
      warnings.add(std::move(problem));
    }
}

static std::string naming(const std::vector<fs::path>& callers) {
  std::vector<std::string> names;
  for (const fs::path& file : callers) names.push_back(file.string());
  return "name what includes it: " + join(names, ", ");
}

/// The error for a file that defines parts of robots but no robot. It names the file to use instead.
static Error only_macros(const fs::path& path, const std::vector<std::string>& macros) {
  const auto callers = files_that_include(path);
  return Error(Problem{"only-macros",
                       {path.string()},
                       "the file only defines macros (" + join(macros, ", ") + "), which a description calls",
                       callers.empty() ? "name the description that includes it" : naming(callers)});
}

/// Reads a description file, after expanding it if it is xacro. Locations then refer to the expanded text.
static RobotModel read_description(const fs::path& path, Problems& warnings,
                                   const std::map<std::string, std::string>& arguments) {
  const std::string text = read_file(path);
  if (!uses_xacro(text)) return read_urdf(text, path.string(), warnings, {packages_near(path)});
  XacroReport report;
  const std::string expanded = expand_xacro_text(text, path, {arguments, {}}, warnings, &report);
  try {
    return read_urdf(expanded, path.string() + " (expanded)", warnings, {packages_near(path)});
  } catch (const Error& e) {
    const std::string& code = e.problems().front().code;
    if (code == "no-links" && !report.macros.empty()) throw only_macros(path, report.macros);
    const auto callers = files_that_include(path);
    if (code != "unknown-link" || callers.empty()) throw;
    std::vector<Problem> problems = e.problems();
    problems.front().advice = "this file may be a part of a description; " + naming(callers);
    throw Error(std::move(problems));
  }
}

RobotModel load_robot(const std::string& name_or_path, const Catalogue& catalogue, Problems& warnings,
                      const std::map<std::string, std::string>& arguments) {
  const fs::path path = name_or_path;
  std::error_code error;
  const std::string extension = path.extension().string();
  if (extension == ".yaml" && fs::exists(path, error)) return read_robot_file(path);
  if (is_launch_file(path) && fs::is_regular_file(path, error))
    throw Error("launch-file", path.string() + " is a launch file of ROS, not a description",
                "polyarm run " + shell_word(path.string()) + " runs what it describes, or prints what to type instead");
  if (fs::is_regular_file(path, error) || extension == ".urdf" || extension == ".xacro" ||
      extension == ".xml") {
    RobotModel model = read_description(path, warnings, arguments);
    add_srdf_beside(path, model, warnings);
    return model;
  }
  return catalogue.load(name_or_path);
}

}  // namespace polyarm::description
