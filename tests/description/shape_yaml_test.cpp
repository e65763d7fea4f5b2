#include "polyarm/description/shape_yaml.hpp"

#include <gtest/gtest.h>

#include <string>

#include "polyarm/yaml/yaml.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::description {
namespace {

struct ShapeYaml : testing::Test {
  polyarm::test::Folder folder;
  std::string mesh = folder.write("table.stl", "solid table\nendsolid table\n");
  Shape read(const std::string& text) {
    return read_shape_or_mesh(Yaml::load(folder.write("scene.yaml", text)));
  }
  std::string code_of(const std::string& text) try {
    read(text);
    return "none";
  } catch (const Error& e) {
    EXPECT_NE(e.problems().front().where.line, 0) << text;
    return e.problems().front().code;
  }
};

TEST_F(ShapeYaml, AMeshIsAFileBesideTheSceneInAUnit) {
  const Shape plain = read("mesh: table.stl\n");
  EXPECT_EQ(plain.kind, ShapeKind::mesh);
  EXPECT_EQ(plain.mesh_path, mesh);
  EXPECT_EQ(plain.scale, (Vec3{1, 1, 1}));
  EXPECT_EQ(read("mesh: {file: table.stl, unit: mm}\n").scale, (Vec3{0.001, 0.001, 0.001}));
  EXPECT_EQ(read("mesh: {file: table.stl, unit: in, scale: 2}\n").scale, (Vec3{0.0508, 0.0508, 0.0508}));
  EXPECT_EQ(read("mesh: {file: table.stl, unit: cm, scale: [1, 2, 3]}\n").scale, (Vec3{0.01, 0.02, 0.03}));
  EXPECT_EQ(read("sphere: {radius: 10mm}\n").kind, ShapeKind::sphere);
}

TEST_F(ShapeYaml, AMeshThatCannotBeIsAnErrorWithItsPlace) {
  EXPECT_EQ(code_of("mesh: chair.stl\n"), "no-mesh");
  EXPECT_EQ(code_of("mesh: {unit: mm}\n"), "missing-key");
  EXPECT_EQ(code_of("mesh: {file: table.stl, unit: feet}\n"), "bad-value");
  EXPECT_EQ(code_of("mesh: {file: table.stl, scale: 0}\n"), "bad-value");
  EXPECT_EQ(code_of("mesh: {file: table.stl, scale: .nan}\n"), "bad-value");
  EXPECT_EQ(code_of("mesh: {file: table.stl, size: 2}\n"), "unknown-key");
  EXPECT_EQ(code_of("mesh: table.stl\nbox: [1, 1, 1]\n"), "bad-value");
}

}  // namespace
}  // namespace polyarm::description
