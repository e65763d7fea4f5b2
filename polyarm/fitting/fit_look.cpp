#include "polyarm/fitting/fit_look.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/fitting/loft_fit.hpp"
#include "polyarm/hulls/convex_pieces.hpp"

namespace polyarm::fitting {

using hulls::Hull;
using hulls::Triangle;
using hulls::TriangleTree;
using shapes::MeasuredLoft;

namespace {

constexpr std::size_t kMostTriangles = 8'000;  // of a link; finer meshes are made coarser first
constexpr double kAlike = 0.12;                // colours this close are one colour
constexpr int kCoarser = 7;                    // times that the tolerance may grow before pieces are dropped
constexpr double kNearMain = 0.35;             // colours this close to the main one get its paint
constexpr double kLeastShare = 0.03;           // of the visible surface; smaller colours are labels
constexpr int kLines = 32;                     // directions in which a point is looked at
constexpr int kLeastOpen = 4;                  // in fewer it lies deep in a hole, and nobody sees it
constexpr double kLargeTriangle = 2e-4;        // m²; twice the area; larger ones may be visible in part
constexpr double kOff = 2e-4;                  // m; visibility is judged this far off a surface

/// A colour and its triangles.
struct Painted {
  std::array<float, 4> color{};
  std::vector<Triangle> triangles;
};

double difference(const std::array<float, 4>& a, const std::array<float, 4>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

std::vector<Painted> by_color(const meshes::Mesh& mesh, bool with_colors) {
  std::vector<Painted> out;
  for (const meshes::MeshPart& part : mesh) {
    auto same = std::find_if(out.begin(), out.end(), [&](const Painted& each) {
      return !with_colors || difference(each.color, part.color) < kAlike;
    });
    if (same == out.end()) same = out.insert(out.end(), Painted{part.color, {}});
    for (Triangle& triangle : hulls::surface_of({part})) same->triangles.push_back(triangle);
  }
  return out;
}

/// True if lines from the point meet no triangle in enough directions.
bool is_open(const TriangleTree& tree, const Vec3& point) {
  int left = kLeastOpen;
  for (int i = 0; i < kLines; ++i) {
    // Directions evenly spread over the sphere: a spiral (Vogel 1979).
    const double z = 1 - (2 * i + 1.0) / kLines, r = std::sqrt(1 - z * z), turn = 2.399963229728653 * i;
    if (tree.escapes(point, {r * std::cos(turn), r * std::sin(turn), z}) && --left == 0) return true;
    if (kLines - i - 1 < left) return false;
  }
  return false;
}

bool is_visible(const TriangleTree& tree, const Triangle& triangle) {
  const Vec3 normal = cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
  const double area = norm(normal);
  if (area < 1e-14) return false;
  const Vec3 middle = (1.0 / 3) * (triangle[0] + triangle[1] + triangle[2]);
  if (fitting::is_visible(tree, middle, normal)) return true;
  if (area < kLargeTriangle) return false;
  return std::any_of(triangle.begin(), triangle.end(), [&](const Vec3& corner) {
    return fitting::is_visible(tree, 0.8 * corner + 0.2 * middle, normal);
  });
}

/// True for screws, letters and labels.
bool is_left_out(const Hull& piece, const FitOptions& options) {
  const hulls::Axes axes = hulls::principal_axes(piece.corners);
  return axes.upper[0] - axes.lower[0] <= options.smallest ||
         axes.upper[2] - axes.lower[2] <= options.tolerance;
}

std::string hex(const std::array<float, 4>& color) {
  const auto byte = [](float part) {
    return static_cast<int>(std::lround(std::clamp(part, 0.f, 1.f) * 255));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(color[0]), byte(color[1]), byte(color[2]));
}

double area_of(const std::vector<Triangle>& triangles) {
  double out = 0;
  for (const Triangle& t : triangles) out += norm(cross(t[1] - t[0], t[2] - t[0])) / 2;
  return out;
}

/// The pieces of one colour.
struct PaintedPieces {
  std::string paint;
  std::vector<Hull> pieces;
};

/// Takes the smallest piece away.
void drop_smallest(std::vector<PaintedPieces>& all) {
  std::vector<Hull>* from = nullptr;
  std::ptrdiff_t at = 0;
  for (PaintedPieces& each : all)
    for (std::size_t i = 0; i < each.pieces.size(); ++i) {
      if (from && each.pieces[i].volume >= (*from)[static_cast<std::size_t>(at)].volume) continue;
      from = &each.pieces;
      at = static_cast<std::ptrdiff_t>(i);
    }
  if (from) from->erase(from->begin() + at);
}

std::vector<MeasuredLoft> lofts_of(const std::vector<PaintedPieces>& all, const std::string& link,
                                   double tolerance) {
  std::vector<MeasuredLoft> out;
  for (const PaintedPieces& each : all)
    for (const Hull& piece : each.pieces) {
      MeasuredLoft loft = fit_loft(piece, tolerance);
      loft.link = link;
      loft.paint = each.paint;
      out.push_back(std::move(loft));
    }
  return out;
}

}  // namespace

std::array<float, 4> main_color(const meshes::Mesh& mesh) {
  double most = -1;
  std::array<float, 4> out{};
  for (const Painted& each : by_color(mesh, true)) {
    const double area = area_of(each.triangles);
    if (area <= most) continue;
    most = area;
    out = each.color;
  }
  return out;
}

bool is_visible(const TriangleTree& tree, const Vec3& point, const Vec3& normal) {
  const Vec3 off = kOff * normalized(normal);
  return is_open(tree, point + off) || is_open(tree, point - off);
}

std::vector<MeasuredLoft> fit_look(const meshes::Mesh& mesh, const std::string& link,
                                   const FitOptions& options) {
  meshes::Mesh coarse = mesh;
  meshes::simplify(coarse, kMostTriangles);
  std::vector<Triangle> all = hulls::surface_of(coarse);
  if (all.empty()) return {};
  const TriangleTree tree(all);
  std::vector<Painted> groups = by_color(coarse, options.with_colors);
  double area = 0;
  for (Painted& each : groups) {
    std::erase_if(each.triangles, [&](const Triangle& t) { return !is_visible(tree, t); });
    area += area_of(each.triangles);
  }
  std::vector<PaintedPieces> pieces;
  for (const Painted& each : groups) {
    if (each.triangles.empty()) continue;
    const double share = area_of(each.triangles) / area;
    if (share < kLeastShare) continue;
    const bool own = options.with_colors && difference(each.color, options.main_color) >= kNearMain;
    hulls::PieceOptions cut;
    cut.most_pieces = std::max<std::size_t>(
        2, static_cast<std::size_t>(std::lround(share * static_cast<double>(options.most_pieces))));
    cut.most_corners = 256;
    cut.desired_excess = 0.002;
    PaintedPieces out{own ? hex(each.color) : std::string{}, {}};
    for (Hull& piece : hulls::convex_pieces(each.triangles, cut).pieces)
      if (!is_left_out(piece, options)) out.pieces.push_back(std::move(piece));
    pieces.push_back(std::move(out));
  }
  double tolerance = options.tolerance;
  std::vector<MeasuredLoft> out = lofts_of(pieces, link, tolerance);
  for (int i = 0; shapes::text_size(out) > options.most_text; ++i) {
    if (i < kCoarser)
      tolerance *= 1.5;
    else
      drop_smallest(pieces);
    out = lofts_of(pieces, link, tolerance);
  }
  return out;
}

}  // namespace polyarm::fitting
