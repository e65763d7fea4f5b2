#include "apps/new_cell_robot.hpp"

#include <cctype>
#include <set>
#include <utility>

#include "apps/options.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/description/srdf.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/xacro/xacro.hpp"

namespace polyarm::apps {

namespace {
namespace fs = std::filesystem;

/// A word that is the same in YAML, in XML and in a shell.
std::string plain(std::string word) {
  for (char& c : word)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-' && c != '.') c = '_';
  return word;
}

/// "wrist.stl", or "wrist_2.stl" if another mesh has that name.
std::string free_name(const Files& taken, const fs::path& mesh) {
  const auto named = [&](const std::string& more) {
    return "robot/meshes/" + plain(mesh.stem().string() + more + mesh.extension().string());
  };
  std::string out = named("");
  for (int i = 2; taken.contains(out); ++i) out = named("_" + std::to_string(i));
  return out;
}

/// Copies the meshes of the model into `files`. Returns the new name, seen from the description, of each URI.
std::map<std::string, std::string> copy_meshes(description::RobotModel& model, Files& files) {
  std::map<std::string, std::string> by_path, by_uri;
  for (description::Link& link : model.links)
    for (auto* const shapes : {&link.visuals, &link.collisions})
      for (description::Shape& shape : *shapes) {
        if (shape.mesh_path.empty()) continue;
        std::string& name = by_path[shape.mesh_path];
        if (name.empty()) {
          name = free_name(files, shape.mesh_path);
          files[name] = read_file(shape.mesh_path);
        }
        const std::string seen = name.substr(std::string("robot/").size());
        by_uri[std::exchange(shape.mesh, seen)] = seen;
      }
  return by_uri;
}

/// Replaces names in quotes, in one pass: a new name may be the old name of another mesh. False: one of them
/// is not in the text as it was read.
bool rename_in(std::string& text, const std::map<std::string, std::string>& names) {
  constexpr const char* kQuotes = "\"'";
  std::set<std::string> found;
  for (std::size_t at = text.find_first_of(kQuotes); at != std::string::npos;
       at = text.find_first_of(kQuotes, at + 1)) {
    const std::size_t end = text.find(text[at], at + 1);
    if (end == std::string::npos) continue;
    const auto name = names.find(text.substr(at + 1, end - at - 1));
    if (name == names.end()) continue;
    text.replace(at + 1, end - at - 1, name->second);
    found.insert(name->first);
    at += 1 + name->second.size();  // its last quote
  }
  return found.size() == names.size();
}
}  // namespace

CopiedRobot copy_of_robot(const fs::path& description) {
  Problems ignored;  // the check of the new cell tells them
  description::RobotModel model = description::load_robot(description.string(), open_catalogue(), ignored);
  CopiedRobot out;
  out.model =
      "robot/" + plain(description.filename().replace_extension().replace_extension().string()) + ".urdf";
  const auto names = copy_meshes(model, out.files);
  std::string text;
  if (description.extension() != ".yaml") {
    text = read_file(description, bounds::kXmlBytes);
    if (description::uses_xacro(text)) text = description::expand_xacro_text(text, description, {}, ignored);
  }
  if (text.empty() || !rename_in(text, names)) text = description::write_urdf(model);
  out.files[out.model] = std::move(text);
  std::error_code error;
  const fs::path srdf = description::srdf_beside(description);
  if (fs::is_regular_file(srdf, error))
    out.files[description::srdf_beside(out.model).string()] = read_file(srdf, bounds::kXmlBytes);
  return out;
}

}  // namespace polyarm::apps
