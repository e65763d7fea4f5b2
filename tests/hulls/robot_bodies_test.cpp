#include "polyarm/hulls/robot_bodies.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "polyarm/base/file.hpp"
#include "polyarm/description/bodies.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::hulls {
namespace {

namespace fs = std::filesystem;
using description::RobotModel;
using description::Shape;
using description::ShapeKind;

/// A pyramid as STL text.
constexpr const char* kPyramid = R"(solid pyramid
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 1 0
vertex 1 0 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 1
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 0 1
vertex 0 1 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 1 0 0
vertex 0 1 0
vertex 0 0 1
endloop
endfacet
endsolid pyramid
)";

Shape mesh_at(const std::string& path, double scale) {
  Shape out;
  out.kind = ShapeKind::mesh;
  out.mesh = out.mesh_path = path;
  out.scale = {scale, scale, scale};
  return out;
}

RobotModel robot_of(const std::vector<Shape>& shapes) {
  RobotModel out;
  for (const Shape& shape : shapes) {
    description::Link link;
    link.name = "link" + std::to_string(out.links.size());
    link.collisions = {shape};
    out.links.push_back(link);
  }
  return out;
}

struct RobotBodies : testing::Test {
  test::Folder folder;
  std::string mesh = folder.write("pyramid.stl", kPyramid);
  fs::path cache = folder.path() / "cache";
};

TEST_F(RobotBodies, GiveEachMeshThePiecesOfItsScale) {
  RobotModel model = robot_of({mesh_at(mesh, 0.1), mesh_at(mesh, 0.2), mesh_at(mesh, 0.1)});
  EXPECT_EQ(description::links_without_body(model).size(), 3u);
  const BodiesMade made = make_bodies(model, {});
  EXPECT_EQ(made.reports.size(), 2u);
  EXPECT_TRUE(made.warnings.empty());
  EXPECT_TRUE(description::links_without_body(model).empty());
  EXPECT_EQ(model.links[0].collisions[0].pieces, model.links[2].collisions[0].pieces);
  const auto& piece = model.links[1].collisions[0].pieces.at(0);
  EXPECT_EQ(piece.size(), 4u);
  for (const Vec3& corner : piece) EXPECT_LE(corner.x + corner.y + corner.z, 0.2 + 1e-6);
}

TEST_F(RobotBodies, AreKeptUnderTheContentOfTheMesh) {
  RobotModel first = robot_of({mesh_at(mesh, 0.1)}), again = first, moved = first;
  EXPECT_FALSE(make_bodies(first, cache).reports.at(0).cached);
  const BodiesMade kept = make_bodies(again, cache);
  EXPECT_TRUE(kept.reports.at(0).cached);
  EXPECT_EQ(kept.reports[0].triangles, 4u);
  EXPECT_EQ(first.links[0].collisions[0].pieces, again.links[0].collisions[0].pieces);
  folder.write("pyramid.stl", std::string(kPyramid) + " ");
  EXPECT_FALSE(make_bodies(moved, cache).reports.at(0).cached);
}

TEST_F(RobotBodies, AreAnnouncedWhileTheyAreComputedAndNotWhenTheyAreKept) {
  std::vector<std::pair<std::size_t, std::size_t>> announced;  // so many of so many are made
  listen_to_making([&](std::size_t made, std::size_t meshes) { announced.emplace_back(made, meshes); });
  RobotModel first = robot_of({mesh_at(mesh, 0.1), mesh_at(mesh, 0.2), mesh_at(mesh, 0.1)}), again = first;
  RobotModel more = robot_of({mesh_at(mesh, 0.1), mesh_at(mesh, 0.3)}), boxes = robot_of({Shape{}});
  make_bodies(first, cache);
  make_bodies(again, cache);
  make_bodies(more, cache);
  make_bodies(boxes, cache);
  listen_to_making({});
  EXPECT_EQ(announced, (std::vector<std::pair<std::size_t, std::size_t>>{{0, 2}, {1, 2}, {2, 2}, {0, 1}, {1, 1}}));
}

TEST_F(RobotBodies, AreComputedAgainWhereTheCacheIsBroken) {
  RobotModel model = robot_of({mesh_at(mesh, 0.1)});
  make_bodies(model, cache);
  const auto pieces = model.links[0].collisions[0].pieces;
  const fs::path file = fs::directory_iterator(cache)->path();
  const std::string good = read_file(file);
  std::vector<std::string> broken = {"", "polyarm-bodies/1\n", good + "more",
                                     "polyarm-bodies/1\n4 9999999 1 1 1\nend\n"};
  for (std::size_t cut = 0; cut + 1 < good.size(); cut += 7) broken.push_back(good.substr(0, cut));
  std::string nan = good;
  nan.replace(nan.find("0."), 2, "nan");
  broken.push_back(nan);
  for (const std::string& text : broken) {
    write_file_atomically(file, text);
    RobotModel again = robot_of({mesh_at(mesh, 0.1)});
    EXPECT_FALSE(make_bodies(again, cache).reports.at(0).cached) << text;
    EXPECT_EQ(again.links[0].collisions[0].pieces, pieces);
  }
}

TEST_F(RobotBodies, OfMeshesThatCannotBeReadAreWarnings) {
  RobotModel model = robot_of(
      {mesh_at("", 1), mesh_at("", 2), mesh_at(folder.write("bad.stl", "solid nothing\nendsolid\n"), 1),
       mesh_at(folder.write("part.step", "ISO"), 1), mesh_at(mesh, 1e30), mesh_at(mesh, 1)});
  model.links[0].collisions[0].mesh = "package://nowhere/arm.stl";
  const BodiesMade made = make_bodies(model, cache);
  EXPECT_EQ(made.reports.size(), 1u);
  ASSERT_EQ(made.warnings.size(), 4u);
  for (const Problem& problem : made.warnings) EXPECT_EQ(problem.severity, Severity::warning);
  EXPECT_NE(made.warnings[0].what.find("2 meshes were not found"), std::string::npos)
      << made.warnings[0].what;
  EXPECT_EQ(description::links_without_body(model).size(), 5u);
}

}  // namespace
}  // namespace polyarm::hulls
