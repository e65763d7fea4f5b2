#include "polyarm/hulls/convex_pieces.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "polyarm/base/error.hpp"

namespace polyarm::hulls {
namespace {

using Mesh = std::vector<Triangle>;

void add_box(Mesh& mesh, const Vec3& low, const Vec3& high) {
  std::array<Vec3, 8> c;
  for (std::size_t i = 0; i < 8; ++i)
    c[i] = {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
  constexpr int kFaces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  for (const auto& f : kFaces) mesh.push_back({c[f[0]], c[f[1]], c[f[2]]});
}

/// A tube around z without caps.
Mesh tube(double radius, double height, int corners) {
  Mesh out;
  for (int i = 0; i < corners; ++i) {
    const double a = 2 * std::numbers::pi * i / corners, b = 2 * std::numbers::pi * (i + 1) / corners;
    const Vec3 p{radius * std::cos(a), radius * std::sin(a), 0},
        q{radius * std::cos(b), radius * std::sin(b), 0};
    const Vec3 up{0, 0, height};
    out.push_back({p, q, q + up});
    out.push_back({p, q + up, p + up});
  }
  return out;
}

Mesh torus(double large, double small, int corners) {
  Mesh out;
  const auto at = [&](int i, int j) {
    const double a = 2 * std::numbers::pi * i / corners, b = 2 * std::numbers::pi * j / corners;
    const double r = large + small * std::cos(b);
    return Vec3{r * std::cos(a), r * std::sin(a), small * std::sin(b)};
  };
  for (int i = 0; i < corners; ++i)
    for (int j = 0; j < corners; ++j) {
      out.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      out.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return out;
}

Mesh l_shape() {
  Mesh out;
  add_box(out, {0, 0, 0}, {0.3, 0.1, 0.1});
  add_box(out, {0, 0, 0.1}, {0.1, 0.1, 0.4});
  return out;
}

bool is_inside(const ConvexPieces& made, const Vec3& point, double by = 0) {
  return std::any_of(made.pieces.begin(), made.pieces.end(),
                     [&](const Hull& hull) { return distance_outside(hull, point) <= -by; });
}

/// The largest distance of a random point of the surface from all pieces, m.
double furthest_out(const ConvexPieces& made, const Mesh& mesh) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  double out = -1;
  for (int i = 0; i < 5000; ++i) {
    const Triangle& t = mesh[random() % mesh.size()];
    double u = uniform(random), v = uniform(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 point = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
    double nearest = 1e9;
    for (const Hull& hull : made.pieces) nearest = std::min(nearest, distance_outside(hull, point));
    out = std::max(out, nearest);
  }
  return out;
}

TEST(ConvexPieces, OfSomethingConvexAreOne) {
  Mesh box;
  add_box(box, {0, 0, 0}, {0.1, 0.2, 0.3});
  const ConvexPieces made = convex_pieces(box);
  ASSERT_EQ(made.pieces.size(), 1u);
  EXPECT_NEAR(made.pieces[0].volume, 0.006, 1e-9);
  EXPECT_LT(made.mean_excess, 1e-9);
  EXPECT_NEAR(made.size, std::sqrt(0.14), 1e-6);
}

TEST(ConvexPieces, ContainTheMeshAndLeaveItsHollowsFree) {
  struct Case {
    const char* name;
    Mesh mesh;
    Vec3 hollow;
  };
  for (const Case& each : {Case{"an L", l_shape(), {0.25, 0.05, 0.3}},
                           {"a torus", torus(0.2, 0.05, 40), {0, 0, 0}},
                           {"an open tube", tube(0.1, 0.3, 40), {0, 0, 0.15}}}) {
    const ConvexPieces made = convex_pieces(each.mesh);
    EXPECT_LE(furthest_out(made, each.mesh), 1e-6) << each.name;
    EXPECT_FALSE(is_inside(made, each.hollow)) << each.name;
    EXPECT_LE(made.mean_excess, 0.01 * made.size) << each.name << " of " << made.pieces.size() << " pieces";
    EXPECT_LE(made.pieces.size(), PieceOptions{}.most_pieces) << each.name;
  }
}

TEST(ConvexPieces, DoNotDependOnTheSideThatTrianglesFace) {
  Mesh inverted = l_shape();
  for (Triangle& triangle : inverted) std::swap(triangle[1], triangle[2]);
  const ConvexPieces made = convex_pieces(l_shape()), of_inverted = convex_pieces(inverted);
  EXPECT_EQ(made.pieces.size(), of_inverted.pieces.size());
  EXPECT_NEAR(made.mean_excess, of_inverted.mean_excess, 1e-4);
}

TEST(ConvexPieces, AreTheSameEachTime) {
  const ConvexPieces a = convex_pieces(torus(0.2, 0.05, 24)), b = convex_pieces(torus(0.2, 0.05, 24));
  ASSERT_EQ(a.pieces.size(), b.pieces.size());
  for (std::size_t i = 0; i < a.pieces.size(); ++i) EXPECT_EQ(a.pieces[i].corners, b.pieces[i].corners);
}

TEST(ConvexPieces, OfAFewTrianglesOrFlatOnesAreThin) {
  const ConvexPieces made = convex_pieces({{Vec3{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}}});
  ASSERT_EQ(made.pieces.size(), 1u);
  EXPECT_NEAR(made.pieces[0].volume, 0.005 * kThinnest, 0.005 * kThinnest * 0.01);
}

TEST(ConvexPieces, OfTrianglesWithoutAnEndAreAnError) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {kNan, std::numeric_limits<double>::infinity(), 1e9})
    EXPECT_THROW(convex_pieces({{Vec3{0, 0, bad}, {1, 0, 0}, {0, 1, 0}}}), Error);
  EXPECT_THROW(convex_pieces({}), Error);
}

TEST(ConvexPieces, OfRandomTrianglesContainThem) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  for (int round = 0; round < 10; ++round) {
    Mesh soup;
    for (int i = 0; i < 5 + 20 * round; ++i) {
      const auto point = [&] { return Vec3{uniform(random), uniform(random), uniform(random)}; };
      soup.push_back({point(), point(), point()});
    }
    EXPECT_LE(furthest_out(convex_pieces(soup), soup), 1e-6) << round;
  }
}

TEST(TriangleTree, FindsTheDistanceThatASearchOfAllTrianglesFinds) {
  const Mesh mesh = torus(0.2, 0.05, 20);
  const TriangleTree tree(mesh);
  std::mt19937 random(13);
  std::uniform_real_distribution<double> uniform(-0.4, 0.4);
  for (int i = 0; i < 200; ++i) {
    const Vec3 point{uniform(random), uniform(random), uniform(random)};
    double nearest = 1e9;
    for (const Triangle& triangle : mesh)
      nearest = std::min(nearest, norm(nearest_point(triangle, point) - point));
    EXPECT_NEAR(tree.distance(point), nearest, 1e-12);
  }
  EXPECT_TRUE(tree.escapes({0, 0, 0}, {0.01, 0.02, 1}));
  EXPECT_FALSE(tree.escapes({0.2, 0, 0}, {0.01, 0.02, 1}));
}

}  // namespace
}  // namespace polyarm::hulls
