/// Requests that add meshes to the scene: their files are uploaded in pieces, then written into the scene
/// file.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/scene_edit.hpp"
#include "polyarm/description/scene_file.hpp"
#include "polyarm/inside/requests_later.hpp"
#include "polyarm/io/free_space.hpp"
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/protocol/scene.hpp"
#include "polyarm/requests/families.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

namespace {

using namespace protocol;

struct SceneOwners {
  const CellSetup& setup;
  Worker& worker;
  LongWorker& long_worker;  ///< reads meshes
};

constexpr std::size_t kLongestName = bounds::kSceneFileNameBytes, kLargestMtl = bounds::kMtlBytes;
constexpr double kLargeNumber = 10;  // sizes from here on are hardly metres

bool among(const std::string& ending, const std::vector<std::string>& list) {
  return std::find(list.begin(), list.end(), ending) != list.end();
}

std::string ending_of(const std::string& name) {
  return lower(fs::path(name).extension().string());
}

bool is_image(const std::string& ending) {
  return among(ending, {".png", ".jpg", ".jpeg"});
}

/// Throws unless the name is that of a file in one folder, of a kind that scenes use.
void check_name(const std::string& name) {
  const auto fine = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.' || c == ' ';
  };
  if (name.empty() || name.size() > kLongestName || name[0] == '.' || name[0] == ' ' ||
      !std::all_of(name.begin(), name.end(), fine))
    throw Error("bad-path", "'" + shortened(printable_line(name)) + "' is not a name for a file of the scene",
                "give it a name of letters, digits, spaces and - _ .");
  const std::string ending = ending_of(name);
  if (!among(ending, meshes::mesh_extensions()) && !is_image(ending) && ending != ".mtl")
    throw Error("unknown-mesh", "'" + shortened(name) + "' has a format that is not read",
                "meshes are " + join(meshes::mesh_extensions(), ", ") + "; their images are PNG or JPEG");
}

/// RFC 4648, 4. Throws Error("bad-request").
std::string decoded(const std::string& text) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  std::uint32_t bits = 0;
  int count = 0;
  std::string_view body = text;
  while (body.ends_with('=')) body.remove_suffix(1);
  for (const char c : body) {
    const auto digit = kDigits.find(c);
    if (digit == std::string_view::npos || text.size() % 4 != 0)
      throw Error("bad-request", "'data' is not base64", "encode the bytes of the file as base64");
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    if ((count += 6) >= 8) out += static_cast<char>(bits >> (count -= 8) & 255);
  }
  return out;
}

/// The folder for meshes; a link there must not lead elsewhere.
fs::path meshes_folder(const fs::path& folder) {
  const fs::path out = folder / "meshes";
  std::error_code error;
  if (fs::is_symlink(fs::symlink_status(out, error)))
    throw Error("bad-path", out.string() + " is a link", "make it a folder of the cell");
  fs::create_directories(out, error);
  return out;
}

MeshFacts facts_of(const fs::path& file) {
  const meshes::Mesh mesh = meshes::read_mesh(file);
  MeshFacts out;
  out.triangles = meshes::triangles_of(mesh);
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  for (const meshes::MeshPart& part : mesh)
    for (const auto& p : part.positions) {
      low = {std::min<double>(low.x, p[0]), std::min<double>(low.y, p[1]), std::min<double>(low.z, p[2])};
      high = {std::max<double>(high.x, p[0]), std::max<double>(high.y, p[1]), std::max<double>(high.z, p[2])};
    }
  out.size = high - low;
  out.lower = low;
  out.metres = among(ending_of(file.string()), {".dae", ".3mf", ".glb", ".gltf", ".step", ".stp"});
  out.likely = !out.metres && std::max({out.size.x, out.size.y, out.size.z}) >= kLargeNumber ? "mm" : "m";
  return out;
}

/// Throws if the file is no mesh, no image and no MTL.
OrNull<MeshFacts> check_content(const fs::path& file) {
  OrNull<MeshFacts> out;
  const std::string ending = ending_of(file.string());
  if (among(ending, meshes::mesh_extensions())) {
    out.emplace(facts_of(file));
  } else if (is_image(ending)) {
    if (const std::string why = meshes::why_no_image(read_file(file, meshes::kMostImageBytes)); !why.empty())
      throw Error("bad-image", "the image " + file.filename().string() + " is not taken: " + why,
                  "save it as PNG or JPEG");
  } else if (std::error_code error; fs::file_size(file, error) > kLargestMtl) {
    throw Error("too-large", "the file " + file.filename().string() + " is too large for materials");
  }
  return out;
}

struct Stored {
  std::size_t count = 0;
  std::uint64_t bytes = 0;
};

/// Files of a folder, and their bytes. Links and devices count as files without bytes.
Stored files_of(const fs::path& folder) {
  Stored out;
  std::error_code error;
  for (const auto& each : fs::directory_iterator(folder, error)) {
    ++out.count;
    const bool regular = fs::is_regular_file(each.symlink_status(error));
    const std::uint64_t size = regular ? each.file_size(error) : 0;
    if (!error) out.bytes += size;
  }
  return out;
}

/// Moves a complete upload into the folder of meshes. The same file may be there already.
std::string keep(const fs::path& folder, const fs::path& part, const std::string& name) {
  const fs::path target = meshes_folder(folder) / name;
  std::error_code error;
  if (fs::exists(fs::symlink_status(target, error))) {
    if (fs::is_regular_file(fs::symlink_status(target, error)) &&
        read_file(target, meshes::kLargestFile) == read_file(part, meshes::kLargestFile)) {
      fs::remove(part, error);
      return "meshes/" + name;
    }
    throw Error("exists", "there is another file meshes/" + name + " already", "give it another name");
  }
  fs::rename(part, target, error);
  if (error) throw Error("unwritable", "meshes/" + name + " cannot be written: " + error.message());
  return "meshes/" + name;
}

/// Removes an earlier upload of this name, and all if they are many: those that nobody completed.
void make_room(const fs::path& part) {
  std::error_code error;
  const bool many = files_of(part.parent_path()).count >= bounds::kSceneUploads;
  fs::remove_all(many ? part.parent_path() : part, error);
  fs::create_directories(part.parent_path(), error);
}

/// Throws if the cell would store more than its bounds allow.
void require_room(const fs::path& folder, const fs::path& uploads, const std::string& name,
                  std::size_t more) {
  const Stored kept = files_of(meshes_folder(folder)), coming = files_of(uploads);
  std::error_code error;
  if (kept.count >= bounds::kSceneFiles && !fs::exists(meshes_folder(folder) / name, error))
    throw Error("too-many", fmt::format("the folder meshes has {} files", kept.count), "delete some of them");
  if (kept.bytes + coming.bytes + more > bounds::kSceneFilesBytes)
    throw Error("too-large",
                fmt::format("the files in the folder meshes and unfinished uploads may have {} MiB together",
                            bounds::kSceneFilesBytes >> 20),
                "delete meshes that the scene does not use");
  require_free_space(folder, more);
}

/// The folder for uploads. A cell of a stranger may have links there, which would lead elsewhere.
fs::path uploads_folder(const fs::path& folder) {
  std::error_code error;
  const fs::path out = folder / ".state" / "uploads";
  for (const fs::path& each : {out.parent_path(), out})
    if (fs::is_symlink(fs::symlink_status(each, error)))
      throw Error("bad-path", each.string() + " is a link", "make it a folder of the cell");
  fs::create_directories(out, error);
  return out;
}

SceneUpload::Answer stored(const fs::path& folder, const SceneUpload& request) {
  check_name(request.name);
  const std::string bytes = decoded(request.data);
  // With its own ending, so that it is read as what it is.
  const fs::path part = uploads_folder(folder) / request.name;
  std::error_code error;
  keep_out_of_git(folder);
  if (request.offset == 0) make_room(part);
  const fs::file_status status = fs::symlink_status(part, error);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw Error("bad-path", part.string() + " is not a file", "begin the upload again, from 0 on");
  const std::uint64_t there = fs::exists(status) ? fs::file_size(part, error) : 0;
  if (there != request.offset)
    throw Error("bad-offset",
                fmt::format("{} bytes of '{}' are here, but this piece begins at {}", there, request.name,
                            request.offset),
                "send the pieces in order, from 0 on");
  if (there + bytes.size() > meshes::kLargestFile) {
    fs::remove(part, error);
    throw Error("too-large",
                fmt::format("'{}' has more than {} MB", request.name, meshes::kLargestFile >> 20),
                "simplify it: some thousand triangles are enough to draw it");
  }
  require_room(folder, part.parent_path(), request.name, bytes.size());
  std::ofstream file(part, std::ios::binary | std::ios::app);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) {
    fs::remove(part, error);
    throw Error("unwritable", "'" + request.name + "' cannot be stored",
                "look at the free space of the disk");
  }
  SceneUpload::Answer out{there + bytes.size(), {}, {}};
  if (!request.last) return out;
  try {
    out.mesh = check_content(part);
    out.file = keep(folder, part, request.name);
  } catch (...) {
    fs::remove(part, error);
    throw;
  }
  return out;
}

Poll<SceneUpload::Answer> scene_upload(const SceneOwners& cell, const SceneUpload& request) {
  return later(cell.long_worker,
               [folder = cell.setup.file.folder, request] { return stored(folder, request); });
}

void check(const SceneAdd& request) {
  const auto near = [](const Vec3& v, double most) {
    return std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most;  // false for NaN, too
  };
  if (!near(request.at, bounds::kSceneMetres) || !near(request.rpy, 100))
    throw Error("bad-value", "the pose is not a pose of a scene", "give metres and radians");
  const double scale = request.scale.value_or(1);
  if (!(scale > 0 && scale <= 1e6)) throw Error("bad-value", "the scale must be above zero and at most 1e6");
  if (!among(request.unit, {"m", "mm", "cm", "in"}))
    throw Error("bad-value", "'" + shortened(request.unit) + "' is not a unit of a mesh file",
                "m, mm, cm or in");
  if (request.mass && !(*request.mass > 0 && *request.mass <= bounds::kSceneMass))
    throw Error("bad-value", "the mass must be above zero", "give it in kg");
}

/// Returns the name of the scene file. A cell without one gets a new file, and its cell file names it. The
/// new file has the floor that the cell had. `cell`: the name of the cell file in the folder; `named`: the
/// scene of the running cell.
std::string scene_file(const fs::path& folder, const std::string& cell, const std::string& named,
                       double floor_height) {
  if (!named.empty()) return named;
  if (const std::string ending = ending_of(cell); ending != ".yaml" && ending != ".yml")
    throw Error("cannot-keep", "this cell has no cell file that could name a scene; nothing was changed",
                "write a cell.yaml with the robot and 'scene: scene.yaml'");
  const std::string before = read_file(folder / cell);
  const Yaml now = Yaml::parse(before, (folder / cell).string());
  // An entry before may have named it since the cell began.
  if (const std::string since = now["scene"].text(""); !since.empty()) return since;
  const fs::path scene = folder / "scene.yaml";
  std::error_code error;
  if (fs::exists(scene, error))
    throw Error("exists", "there is a scene.yaml, but " + cell + " does not name it",
                "add 'scene: scene.yaml' to " + cell);
  std::string after = before + (before.ends_with('\n') ? "" : "\n") + "scene: scene.yaml\n";
  bool reads = true;
  try {
    reads = Yaml::parse(after, cell)["scene"].text("") == "scene.yaml";
  } catch (const Error&) {
    reads = false;
  }
  if (!reads)
    throw Error("cannot-keep", "'scene: scene.yaml' cannot be added to " + cell + "; nothing was changed",
                "write it yourself");
  write_file_atomically(scene, "polyarm: scene/1\nfloor: {height: " + format_number(floor_height) + "}\n");
  write_project_file(folder, cell, after);
  return "scene.yaml";
}

SceneAdd::Answer added(const fs::path& folder, const std::string& cell, const std::string& named,
                       double floor_height, const SceneAdd& request) {
  check(request);
  description::MeshEntry entry{request.name,
                               request.file,
                               request.unit,
                               request.at,
                               request.rpy,
                               request.scale.value_or(1),
                               request.mass.value_or(0)};
  description::with_mesh("polyarm: scene/1\n", "scene.yaml", entry);  // before a file is made
  check_name(fs::path(request.file).filename().string());
  std::error_code error;
  if (request.file != "meshes/" + fs::path(request.file).filename().string() ||
      !fs::is_regular_file(folder / request.file, error))
    throw Error("no-mesh", "there is no mesh '" + shortened(request.file) + "' in the folder of the cell",
                "upload it with scene.upload");
  const std::string name = scene_file(folder, cell, named, floor_height);
  const fs::path path = project_file(folder, name);
  // The scene names the mesh from its own folder.
  entry.file = fs::relative(folder / request.file, path.parent_path(), error).generic_string();
  const std::string text = description::with_mesh(read_file(path), name, entry);
  description::read_scene(Yaml::parse(text, path.string()));  // throws what check would say of it
  write_project_file(folder, name, text);
  return {name, description::line_of(entry)};
}

Poll<SceneAdd::Answer> scene_add(const SceneOwners& cell, const SceneAdd& request) {
  return later(cell.worker, [folder = cell.setup.file.folder, file = cell.setup.file.path.filename().string(),
                             named = cell.setup.file.scene, floor = cell.setup.scene.floor_height,
                             request] { return added(folder, file, named, floor, request); });
}

}  // namespace

std::vector<Handler> scene_handlers() {
  return handlers<scene_upload, scene_add>();
}

}  // namespace polyarm::cell
