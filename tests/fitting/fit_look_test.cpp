#include "polyarm/fitting/fit_look.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "polyarm/base/error.hpp"
#include "polyarm/fitting/loft_fit.hpp"

namespace polyarm::fitting {
namespace {

using description::Shape;
using description::ShapeKind;
using hulls::Triangle;
using hulls::TriangleTree;
using meshes::Mesh;
using shapes::MeasuredLoft;

Mesh shape(ShapeKind kind, const Vec3& size, double radius, double length, const Pose& pose) {
  Shape out;
  out.kind = kind;
  out.size = size;
  out.radius = radius;
  out.length = length;
  out.pose = pose;
  Mesh mesh = meshes::mesh_of_shape(out);
  meshes::place(mesh, out);
  return mesh;
}

Mesh box(const Vec3& size, const Pose& pose) {
  return shape(ShapeKind::box, size, 0, 0, pose);
}

Mesh operator+(Mesh a, const Mesh& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Mesh painted(Mesh mesh, const std::array<float, 4>& color) {
  for (meshes::MeshPart& part : mesh) {
    part.color = color;
    part.colored = true;
  }
  return mesh;
}

Mesh drawn(const std::vector<MeasuredLoft>& lofts) {
  shapes::Solid solid;
  for (const MeasuredLoft& loft : lofts) shapes::add_loft(solid, loft, {});
  return solid.take();
}

/// The largest distance of visible points on the triangles of `a` from `b`.
double farthest(const std::vector<Triangle>& a, const std::vector<Triangle>& b) {
  const TriangleTree own(a), tree(b);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(0, 1);
  double out = 0;
  for (const Triangle& t : a)
    for (int i = 0; i < 5; ++i) {
      double u = share(random), v = share(random);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3 p = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
      if (is_visible(own, p, cross(t[1] - t[0], t[2] - t[0]))) out = std::max(out, tree.distance(p));
    }
  return out;
}

double distance(const Mesh& mesh, const std::vector<MeasuredLoft>& lofts) {
  const std::vector<Triangle> a = hulls::surface_of(mesh), b = hulls::surface_of(drawn(lofts));
  return std::max(farthest(a, b), farthest(b, a));
}

TEST(FitLook, ACylinderIsOneLoftThroughTwoCircles) {
  const Pose pose{{0.1, -0.2, 0.3}, from_rpy(0.4, 0.2, -1)};
  const Mesh mesh = shape(ShapeKind::cylinder, {}, 0.06, 0.3, pose);
  const std::vector<MeasuredLoft> lofts = fit_look(mesh, "arm", {});
  ASSERT_EQ(lofts.size(), 1u);
  EXPECT_EQ(lofts[0].link, "arm");
  ASSERT_EQ(lofts[0].sections.size(), 2u);
  for (const auto& section : lofts[0].sections)
    for (const double extent : section.extent) EXPECT_NEAR(extent, 0.06, 0.001);
  EXPECT_LT(distance(mesh, lofts), 0.001);
  EXPECT_LT(shapes::text_size(lofts), 120u);
}

TEST(FitLook, ABoxKeepsItsEdgesHoweverItIsTurned) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-3, 3);
  for (int i = 0; i < 20; ++i) {
    const Mesh mesh =
        box({0.3, 0.1, 0.06}, {{0, 0.1, 0}, from_rpy(angle(random), angle(random), angle(random))});
    const std::vector<MeasuredLoft> lofts = fit_look(mesh, "arm", {});
    ASSERT_EQ(lofts.size(), 1u);
    EXPECT_LT(distance(mesh, lofts), 0.001) << i;
  }
}

TEST(FitLook, ABentLinkHasSeveralLoftsThatFit) {
  const Mesh mesh = box({0.4, 0.1, 0.1}, {}) + box({0.1, 0.1, 0.3}, {{0.15, 0, 0.2}, {}});
  const std::vector<MeasuredLoft> lofts = fit_look(mesh, "arm", {});
  EXPECT_GE(lofts.size(), 2u);
  EXPECT_LT(distance(mesh, lofts), 0.002);
}

TEST(FitLook, ASphereNeedsFewLofts) {
  const Mesh mesh = shape(ShapeKind::sphere, {}, 0.1, 0, {});
  const std::vector<MeasuredLoft> lofts = fit_look(mesh, "arm", {});
  EXPECT_LE(lofts.size(), 2u);
  EXPECT_LT(distance(mesh, lofts), 0.004);
}

TEST(FitLook, WhatNobodySeesIsLeftOut) {
  const Mesh mesh = box({0.3, 0.3, 0.3}, {}) + box({0.1, 0.1, 0.1}, {});
  EXPECT_EQ(fit_look(mesh, "arm", {}).size(), 1u);
}

TEST(FitLook, ScrewsAndLettersAreLeftOut) {
  const Mesh mesh = box({0.3, 0.3, 0.3}, {}) +
                    painted(box({0.003, 0.003, 0.003}, {{0, 0, 0.151}, {}}), {1, 0, 0, 1}) +
                    painted(box({0.1, 0.05, 0.0004}, {{0.1, 0, 0.1502}, {}}), {0, 0, 1, 1});
  FitOptions options;
  options.with_colors = true;
  EXPECT_EQ(fit_look(mesh, "arm", options).size(), 1u);
}

TEST(FitLook, EachColourKeepsItsPaint) {
  const Mesh mesh = painted(box({0.2, 0.1, 0.1}, {}), {0.5f, 0.5f, 0.5f, 1}) +
                    painted(box({0.1, 0.1, 0.1}, {{0.16, 0, 0}, {}}), {0, 0.4f, 1, 1});
  FitOptions options;
  options.with_colors = true;
  const std::vector<MeasuredLoft> lofts = fit_look(mesh, "arm", options);
  ASSERT_EQ(lofts.size(), 2u);
  EXPECT_EQ(lofts[0].paint, "#808080");
  EXPECT_EQ(lofts[1].paint, "#0066ff");
  options.main_color = main_color(mesh);
  EXPECT_EQ(fit_look(mesh, "arm", options)[0].paint, "")
      << "grey covers more: it gets the paint of the style";
  for (const MeasuredLoft& loft : fit_look(mesh, "arm", {})) EXPECT_EQ(loft.paint, "");
}

TEST(FitLook, ATextThatWouldBeTooLongIsMadeShorter) {
  Mesh mesh;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-0.3, 0.3);
  for (int i = 0; i < 5; ++i)
    mesh = mesh +
           shape(ShapeKind::capsule, {}, 0.05, 0.2,
                 {{any(random), any(random), any(random)}, from_rpy(any(random) * 9, any(random) * 9, 0)});
  FitOptions options;
  options.most_text = 1200;
  EXPECT_LE(shapes::text_size(fit_look(mesh, "arm", options)), 1200u);
  options.most_text = 100'000;
  EXPECT_GT(shapes::text_size(fit_look(mesh, "arm", options)), 1200u);
}

TEST(FitLook, NothingGivesNothing) {
  EXPECT_TRUE(fit_look({}, "arm", {}).empty());
}

}  // namespace
}  // namespace polyarm::fitting
