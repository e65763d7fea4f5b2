#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "polyarm/meshes/mesh.hpp"

namespace polyarm::meshes {

namespace {

using Point = std::array<float, 3>;
constexpr double kImageCells = 64;  // cells across an image
constexpr int kMostRounds = 24;     // of the search for a grid
constexpr double kGrows = 1.25;     // of a cell, each round

struct Extent {
  Point low, high;
  double longest() const {
    double out = 0;
    for (std::size_t k = 0; k < 3; ++k) out = std::max(out, static_cast<double>(high[k]) - low[k]);
    return out;
  }
};

Extent extent_of(const Mesh& mesh) {
  Extent out;
  out.low.fill(std::numeric_limits<float>::max());
  out.high.fill(std::numeric_limits<float>::lowest());
  for (const MeshPart& part : mesh)
    for (const Point& p : part.positions)
      for (std::size_t k = 0; k < 3; ++k) {
        out.low[k] = std::min(out.low[k], p[k]);
        out.high[k] = std::max(out.high[k], p[k]);
      }
  return out;
}

using Cell = std::array<std::int32_t, 5>;
struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    std::uint64_t h = 0xcbf29ce484222325u;
    for (const std::int32_t each : cell) h = (h ^ static_cast<std::uint32_t>(each)) * 0x9e3779b97f4a7c15u;
    return h ^ (h >> 29);
  }
};

/// The cells of a grid that corners of a part fall into.
struct Cells {
  std::vector<std::uint32_t> of;  ///< by corner
  std::size_t count = 0;
};

/// Corners of one place but with other places in the image stay apart.
Cells cells_of(const MeshPart& part, const Extent& box, double side) {
  Cells out;
  out.of.reserve(part.positions.size());
  std::unordered_map<Cell, std::uint32_t, CellHash> known;
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    Cell cell{};
    for (std::size_t k = 0; k < 3; ++k)
      cell[k] = static_cast<std::int32_t>((static_cast<double>(part.positions[i][k]) - box.low[k]) / side);
    for (std::size_t k = 0; part.image && k < 2; ++k)
      cell[3 + k] = static_cast<std::int32_t>(std::clamp(kImageCells * part.texcoords[i][k], -1e6, 1e6));
    out.of.push_back(known.try_emplace(cell, static_cast<std::uint32_t>(known.size())).first->second);
  }
  out.count = known.size();
  return out;
}

std::size_t triangles_in(const MeshPart& part, const Cells& cells) {
  std::size_t out = 0;
  for (std::size_t i = 0; i + 2 < part.triangles.size(); i += 3) {
    const std::uint32_t a = cells.of[part.triangles[i]], b = cells.of[part.triangles[i + 1]],
                        c = cells.of[part.triangles[i + 2]];
    out += a != b && b != c && a != c;
  }
  return out;
}

/// Each cell keeps the corner that is nearest to the mean of its corners: sharp edges stay sharper than with
/// the mean.
std::vector<std::uint32_t> kept_corners(const MeshPart& part, const Cells& cells) {
  std::vector<std::array<double, 4>> sums(cells.count);
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    auto& sum = sums[cells.of[i]];
    for (std::size_t k = 0; k < 3; ++k) sum[k] += part.positions[i][k];
    sum[3] += 1;
  }
  std::vector<std::uint32_t> out(cells.count);
  std::vector<double> nearest(cells.count, std::numeric_limits<double>::max());
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    const std::uint32_t cell = cells.of[i];
    double away = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = part.positions[i][k] - sums[cell][k] / sums[cell][3];
      away += d * d;
    }
    if (away >= nearest[cell]) continue;
    nearest[cell] = away;
    out[cell] = static_cast<std::uint32_t>(i);
  }
  return out;
}

/// Triangles with the same three corners are kept once.
void join_corners(MeshPart& part, const Cells& cells) {
  const std::vector<std::uint32_t> kept = kept_corners(part, cells);
  std::vector<std::array<std::uint32_t, 3>> faces;
  for (std::size_t i = 0; i + 2 < part.triangles.size(); i += 3) {
    std::array<std::uint32_t, 3> face;
    for (std::size_t k = 0; k < 3; ++k) face[k] = cells.of[part.triangles[i + k]];
    if (face[0] == face[1] || face[1] == face[2] || face[0] == face[2]) continue;
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    faces.push_back(face);
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  MeshPart out = part;
  out.positions.clear();
  out.normals.clear();
  out.texcoords.clear();
  out.triangles.clear();
  for (const std::uint32_t corner : kept) {
    out.positions.push_back(part.positions[corner]);
    if (part.image) out.texcoords.push_back(part.texcoords[corner]);
  }
  for (const auto& face : faces) out.triangles.insert(out.triangles.end(), face.begin(), face.end());
  part = std::move(out);
}

}  // namespace

double simplify(Mesh& mesh, std::size_t most) {
  if (triangles_of(mesh) <= most) return 0;
  const Extent box = extent_of(mesh);
  // A surface of about one cell in depth covers some six cells of each layer; the search begins finer.
  double side = box.longest() / std::max(4.0, std::sqrt(static_cast<double>(most)));
  if (!(side > 0)) return 0;
  std::vector<Cells> cells(mesh.size());
  for (int round = 0; round < kMostRounds; ++round, side *= kGrows) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < mesh.size(); ++i) {
      cells[i] = cells_of(mesh[i], box, side);
      count += triangles_in(mesh[i], cells[i]);
    }
    if (count <= most || round + 1 == kMostRounds) break;
  }
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    join_corners(mesh[i], cells[i]);
    tidy(mesh[i]);
  }
  return std::sqrt(3.0) * side;
}

}  // namespace polyarm::meshes
