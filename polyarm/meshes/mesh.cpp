#include "polyarm/meshes/mesh.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <system_error>
#include <unordered_map>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/meshes/mesh_process.hpp"

namespace polyarm::meshes {

namespace fs = std::filesystem;

namespace {

using Triple = std::array<float, 3>;
constexpr float kCrease = 0.8660254f;        // cosine of 30 degrees
constexpr std::size_t kMostNeighbours = 64;  // checked, if very many triangles share a corner

struct TripleHash {
  std::size_t operator()(const Triple& t) const {
    std::uint64_t h = 0xcbf29ce484222325u;
    for (const float f : t) h = (h ^ std::bit_cast<std::uint32_t>(f)) * 0x100000001b3u;
    return h ^ (h >> 29);
  }
};

Triple operator-(const Triple& a, const Triple& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Triple cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
float dot(const Triple& a, const Triple& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Triple unit(const Triple& a) {
  const float n = std::sqrt(dot(a, a));
  return n > 0 ? Triple{a[0] / n, a[1] / n, a[2] / n} : Triple{0, 0, 1};
}

/// Indices of distinct corner positions; -0 equals 0.
std::vector<std::uint32_t> places_of(const std::vector<Triple>& positions, std::size_t& count) {
  std::unordered_map<Triple, std::uint32_t, TripleHash> known;
  known.reserve(positions.size());
  std::vector<std::uint32_t> out;
  out.reserve(positions.size());
  for (const Triple& p : positions)
    out.push_back(
        known.try_emplace({p[0] + 0.f, p[1] + 0.f, p[2] + 0.f}, static_cast<std::uint32_t>(known.size()))
            .first->second);
  count = known.size();
  return out;
}

void drop_flat(MeshPart& part) {
  std::vector<std::uint32_t> kept;
  kept.reserve(part.triangles.size());
  for (std::size_t i = 0; i + 2 < part.triangles.size(); i += 3) {
    const Triple &a = part.positions[part.triangles[i]], &b = part.positions[part.triangles[i + 1]],
                 &c = part.positions[part.triangles[i + 2]];
    const Triple area = cross(b - a, c - a);
    if (!(dot(area, area) > 0) || !std::isfinite(dot(area, area))) continue;  // also drops NaN and infinity
    for (std::size_t k = 0; k < 3; ++k) kept.push_back(part.triangles[i + k]);
  }
  part.triangles = std::move(kept);
}

/// Computes a normal for each corner of each triangle; corners are no longer shared.
void make_normals(MeshPart& part) {
  std::size_t places = 0;
  const std::vector<std::uint32_t> place = places_of(part.positions, places);
  const std::size_t faces = part.triangles.size() / 3;
  std::vector<Triple> areas(faces), directions(faces);
  std::vector<std::uint32_t> begin(places + 1), list(part.triangles.size());
  for (std::size_t f = 0; f < faces; ++f) {
    const auto corner = [&](std::size_t k) -> const Triple& {
      return part.positions[part.triangles[3 * f + k]];
    };
    areas[f] = cross(corner(1) - corner(0), corner(2) - corner(0));
    directions[f] = unit(areas[f]);
  }
  for (const std::uint32_t corner : part.triangles) ++begin[place[corner] + 1];
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t i = 0; i < part.triangles.size(); ++i)
    list[next[place[part.triangles[i]]]++] = static_cast<std::uint32_t>(i / 3);
  std::vector<Triple> positions, normals;
  std::vector<std::array<float, 2>> texcoords;
  positions.reserve(part.triangles.size());
  normals.reserve(part.triangles.size());
  for (std::size_t i = 0; i < part.triangles.size(); ++i) {
    if (part.image) texcoords.push_back(part.texcoords[part.triangles[i]]);
    const std::uint32_t at = place[part.triangles[i]];
    const std::size_t end = std::min<std::size_t>(begin[at + 1], begin[at] + kMostNeighbours);
    Triple sum = areas[i / 3];
    for (std::size_t k = begin[at]; k < end; ++k)
      if (list[k] != i / 3 && dot(directions[list[k]], directions[i / 3]) > kCrease)
        for (std::size_t d = 0; d < 3; ++d) sum[d] += areas[list[k]][d];
    positions.push_back(part.positions[part.triangles[i]]);
    normals.push_back(unit(sum));
    part.triangles[i] = static_cast<std::uint32_t>(i);
  }
  part.positions = std::move(positions);
  part.normals = std::move(normals);
  part.texcoords = std::move(texcoords);
}

/// Numbers of distinct directions, to a thousandth, and distinct places in the image.
std::vector<std::uint32_t> looks_of(const MeshPart& part) {
  std::vector<Triple> rounded = part.normals;
  for (Triple& n : rounded)
    for (float& c : n) c = std::round(c * 1000.f) + 0.f;
  std::size_t count = 0;
  std::vector<std::uint32_t> out = places_of(rounded, count);
  if (!part.image) return out;
  // floats represent numbers up to 2^24 exactly
  for (std::size_t i = 0; i < rounded.size(); ++i)
    rounded[i] = {static_cast<float>(out[i]), part.texcoords[i][0], part.texcoords[i][1]};
  return places_of(rounded, count);
}

/// Merges corners with the same position, the same place in the image and (to a thousandth) the same normal.
void share_corners(MeshPart& part) {
  std::size_t places = 0;
  const std::vector<std::uint32_t> place = places_of(part.positions, places), direction = looks_of(part);
  std::unordered_map<std::uint64_t, std::uint32_t> known;
  known.reserve(part.positions.size());
  std::vector<Triple> positions, normals;
  std::vector<std::array<float, 2>> texcoords;
  for (std::uint32_t& corner : part.triangles) {
    const std::uint64_t key = std::uint64_t{place[corner]} << 32 | direction[corner];
    const auto [at, is_new] = known.try_emplace(key, static_cast<std::uint32_t>(positions.size()));
    if (is_new) {
      positions.push_back(part.positions[corner]);
      normals.push_back(part.normals[corner]);
      if (part.image) texcoords.push_back(part.texcoords[corner]);
    }
    corner = at->second;
  }
  part.positions = std::move(positions);
  part.normals = std::move(normals);
  part.texcoords = std::move(texcoords);
}

std::string material_files(const fs::path& path, const std::string& obj) {
  std::string out;
  std::size_t from = 0;
  while ((from = obj.find("mtllib", from)) != std::string::npos) {
    const bool begins = from == 0 || obj[from - 1] == '\n';
    const std::size_t end = std::min(obj.find_first_of("\r\n", from), obj.size());
    const std::string name(trim(std::string_view(obj).substr(from + 6, end - from - 6)));
    from = end;
    std::error_code error;
    const fs::path file = path.parent_path() / name;
    if (!begins || name.empty() || !fs::is_regular_file(file, error)) continue;
    if (fs::file_size(file, error) < 1'000'000) out += read_file(file) + "\n";
  }
  return out;
}

/// Reads each image once. Empty without `notes`.
FindImage image_finder(const fs::path& mesh, Problems* notes) {
  if (!notes) return {};
  return [mesh, notes, known = std::map<std::string, Image>()](const std::string& name) mutable {
    const auto at = known.find(name);
    if (at != known.end()) return at->second;
    return known[name] = known.size() < kMostImages ? read_image(mesh, name, *notes) : Image();
  };
}

}  // namespace

void tidy(MeshPart& part) {
  drop_flat(part);
  if (part.texcoords.size() != part.positions.size()) part.image.reset();
  if (!part.image) part.texcoords.clear();
  for (std::array<float, 2>& at : part.texcoords)
    if (!std::isfinite(at[0]) || !std::isfinite(at[1])) at = {0, 0};
  const bool good = std::all_of(part.normals.begin(), part.normals.end(),
                                [](const Triple& n) { return std::isfinite(dot(n, n)); });
  if (!good || part.normals.size() != part.positions.size()) make_normals(part);
  share_corners(part);
}

const std::vector<std::string>& mesh_extensions() {
  static const std::vector<std::string> list = {".stl",  ".obj", ".dae",  ".3mf", ".glb",
                                                ".gltf", ".ply", ".step", ".stp"};
  return list;
}

Mesh read_mesh(const fs::path& path, Problems* notes) {
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    throw Error("no-mesh", "there is no mesh file " + path.string(),
                "put it there, or name its package's folder in POLYARM_PACKAGES");
  if (fs::file_size(path, error) > kLargestFile)
    throw Error("large-mesh",
                "the mesh " + path.string() + " is larger than " + std::to_string(kLargestFile >> 20) + " MB",
                "simplify it: some thousand triangles are enough to draw it");
  const std::string kind = lower(path.extension().string()), name = path.string();
  const std::string bytes = read_file(path, kLargestFile);
  const FindImage find = image_finder(path, notes);
  Mesh out;
  if (kind == ".stl")
    out = read_stl(bytes, name);
  else if (kind == ".obj")
    out = read_obj(bytes, name, material_files(path, bytes), find);
  else if (kind == ".dae")
    out = read_collada(bytes, name, find);
  else if (kind == ".3mf")
    out = read_3mf(bytes, name);
  else if (is_imported(kind))
    out = import_mesh(bytes, kind, name);
  else
    throw Error("unknown-mesh", "the mesh " + name + " has a format that is not read",
                "convert it to STL, OBJ, Collada (.dae), 3MF, " + imported_formats());
  for (MeshPart& part : out) tidy(part);
  std::erase_if(out, [](const MeshPart& part) { return part.triangles.empty(); });
  if (out.empty())
    throw Error("bad-mesh", "the mesh " + name + " has no triangle with an area", "export it again");
  return out;
}

std::string doubt_of_size(double size) {
  constexpr double kLarge = 20;  // m
  if (size < kLarge) return {};
  return " is " + format_number(std::round(size)) + " m large: this looks like another unit than metres";
}

std::size_t triangles_of(const Mesh& mesh) {
  std::size_t out = 0;
  for (const MeshPart& part : mesh) out += part.triangles.size() / 3;
  return out;
}

}  // namespace polyarm::meshes
