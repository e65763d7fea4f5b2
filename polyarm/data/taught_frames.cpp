#include "polyarm/data/taught_frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::data {

namespace {
using Row = std::array<double, 7>;  // six unknowns and the right side

/// The rotation whose columns are the axes.
Quaternion from_axes(const Vec3& x, const Vec3& y, const Vec3& z) {
  const double trace = x.x + y.y + z.z;
  Quaternion q;
  if (trace > 0) {
    q = {y.z - z.y, z.x - x.z, x.y - y.x, 1 + trace};
  } else if (x.x >= y.y && x.x >= z.z) {
    q = {1 + x.x - y.y - z.z, x.y + y.x, z.x + x.z, y.z - z.y};
  } else if (y.y >= z.z) {
    q = {x.y + y.x, 1 - x.x + y.y - z.z, y.z + z.y, z.x - x.z};
  } else {
    q = {z.x + x.z, y.z + z.y, 1 - x.x - y.y + z.z, x.y - y.x};
  }
  return normalized(q);
}

[[noreturn]] void refuse(const std::string& why, const std::string& advice) {
  throw Error("bad-points", why, advice);
}

/// Gaussian elimination with pivoting; the smallest pivot measures how well the poses determine the tool.
double solve(std::array<Row, 6>& a) {
  double smallest = 1e300;
  for (std::size_t k = 0; k < 6; ++k) {
    const auto best =
        std::max_element(a.begin() + static_cast<std::ptrdiff_t>(k), a.end(),
                         [&](const Row& r, const Row& s) { return std::abs(r[k]) < std::abs(s[k]); });
    std::swap(a[k], *best);
    smallest = std::min(smallest, std::abs(a[k][k]));
    if (smallest < 1e-9) return 0;
    for (std::size_t i = 0; i < 6; ++i) {
      if (i == k) continue;
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < 7; ++j) a[i][j] -= factor * a[k][j];
    }
  }
  for (std::size_t k = 0; k < 6; ++k) a[k][6] /= a[k][k];
  return smallest;
}
}  // namespace

Pose frame_from_points(const Vec3& origin, const Vec3& on_x, const Vec3& in_plane) {
  constexpr double kNearest = 1e-3, kFlattest = 0.01;
  const Vec3 along = on_x - origin, aside = in_plane - origin;
  if (norm(along) < kNearest || norm(aside) < kNearest)
    refuse("two of the three points are less than 1 mm apart", "take points that lie far from each other");
  const Vec3 x = normalized(along), up = cross(x, normalized(aside));
  if (norm(up) < kFlattest)
    refuse("the three points lie on a line",
           "the third is to be to the side of the line through the other two");
  const Vec3 z = normalized(up);
  return {origin, from_axes(x, cross(z, x), z)};
}

TaughtTool tool_from_poses(std::span<const Pose> poses) {
  constexpr double kWeakest = 1e-3;
  if (poses.size() < 4)
    refuse("a tool needs four poses, here are " + std::to_string(poses.size()),
           "touch one point with its tip from four directions");
  std::array<Row, 6> normal{};
  for (const Pose& pose : poses) {
    const Vec3 ex = pose.rotation * Vec3{1, 0, 0}, ey = pose.rotation * Vec3{0, 1, 0},
               ez = pose.rotation * Vec3{0, 0, 1};
    const Vec3& p = pose.position;
    const Row rows[3] = {{ex.x, ey.x, ez.x, -1, 0, 0, -p.x},
                         {ex.y, ey.y, ez.y, 0, -1, 0, -p.y},
                         {ex.z, ey.z, ez.z, 0, 0, -1, -p.z}};
    for (const Row& row : rows)
      for (std::size_t i = 0; i < 6; ++i)
        for (std::size_t j = 0; j < 7; ++j) normal[i][j] += row[i] * row[j];
  }
  if (solve(normal) < kWeakest)
    refuse("the poses hardly differ in orientation, so they do not determine the tip",
           "turn the tool by 30 degrees and more about two axes between them");
  TaughtTool out{
      {normal[0][6], normal[1][6], normal[2][6]}, {normal[3][6], normal[4][6], normal[5][6]}, {}, 0, 0};
  for (const Pose& pose : poses) {
    out.residuals.push_back(norm(pose * out.tcp - out.tip));
    out.rms += out.residuals.back() * out.residuals.back();
    out.largest = std::max(out.largest, out.residuals.back());
  }
  out.rms = std::sqrt(out.rms / static_cast<double>(poses.size()));
  return out;
}

Point point_of(const TaughtTool& tool) {
  return {{tool.tcp, {}}, false, std::make_shared<const Taught>(Taught{"tool0", {}, {}, {}})};
}

}  // namespace polyarm::data
