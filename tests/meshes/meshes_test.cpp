#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "polyarm/base/file.hpp"
#include "polyarm/meshes/glb_writer.hpp"
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/meshes/robot_meshes.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::meshes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

using test::Folder;

/// A cube of 2 m about the origin: twelve triangles, anticlockwise seen from outside.
struct Cube {
  std::vector<Vec3> corners;
  std::vector<std::array<int, 3>> faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                           {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  Cube() {
    for (int i = 0; i < 8; ++i)
      corners.push_back({i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0});
  }
  std::string binary_stl() const {
    std::string out(80, ' ');
    const auto number = [&](auto value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
    number(static_cast<std::uint32_t>(faces.size()));
    for (const auto& face : faces) {
      for (int k = 0; k < 3; ++k) number(0.f);
      for (const int c : face)
        for (const double x : {corners[c].x, corners[c].y, corners[c].z}) number(static_cast<float>(x));
      number(static_cast<std::uint16_t>(0));
    }
    return out;
  }
  std::string ascii_stl() const {
    std::string out = "solid cube\n";
    for (const auto& face : faces) {
      out += " facet normal 0 0 0\n  outer loop\n";
      for (const int c : face) out += "   vertex " + text(c) + "\n";
      out += "  endloop\n endfacet\n";
    }
    return out + "endsolid cube\n";
  }
  std::string obj() const {
    std::string out = "# a cube\r\nmtllib cube.mtl\r\n";
    for (int c = 0; c < 8; ++c) out += "v " + text(c) + "\r\n";
    out += "usemtl red\r\n";
    for (const auto& face : faces) {
      out += "f";
      for (const int c : face) out += " " + std::to_string(c - 8);  // backwards
      out += "\r\n";
    }
    return out;
  }
  /// In millimetres, turned by a quarter about z and moved by 3 m along x.
  std::string collada() const {
    std::string positions, indices;
    for (const Vec3& c : corners)
      for (const double x : {c.x, c.y, c.z}) positions += std::to_string(static_cast<int>(1000 * x)) + " ";
    for (const auto& face : faces)
      for (const int c : face) indices += std::to_string(c) + " ";
    return R"(<?xml version="1.0"?><COLLADA version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><phong><diffuse><color>0 0.5 1 1</color></diffuse></phong>
</technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array count="24">)" +
           positions +
           R"(</float_array><technique_common><accessor source="#pa" count="8" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles material="sym" count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>)" +
           indices + R"(</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><translate>3000 0 0</translate><rotate>0 0 1 90</rotate>
<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="sym" target="#m"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
  }

 private:
  std::string text(int c) const {
    const Vec3& v = corners[static_cast<std::size_t>(c)];
    return std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z);
  }
};

std::size_t triangles(const Mesh& mesh) {
  std::size_t out = 0;
  for (const MeshPart& part : mesh) out += part.triangles.size() / 3;
  return out;
}

/// Six times the volume inside: positive where all faces look outwards.
double volume(const Mesh& mesh) {
  double out = 0;
  for (const MeshPart& part : mesh)
    for (std::size_t i = 0; i + 2 < part.triangles.size(); i += 3) {
      const auto at = [&](std::size_t k) {
        const auto& p = part.positions[part.triangles[i + k]];
        return Vec3{p[0], p[1], p[2]};
      };
      out += dot(at(0), cross(at(1), at(2)));
    }
  return out / 6;
}

void expect_cube(const Mesh& mesh, const std::string& what) {
  EXPECT_EQ(triangles(mesh), 12u) << what;
  EXPECT_NEAR(volume(mesh), 8, 1e-5) << what;
  ASSERT_EQ(mesh.size(), 1u) << what;
  EXPECT_EQ(mesh[0].positions.size(), 24u) << what << ": four corners on each of six flat sides";
  ASSERT_EQ(mesh[0].normals.size(), 24u) << what;
  for (const auto& n : mesh[0].normals) {
    float most = 0;
    for (const float c : n) most = std::max(most, std::abs(c));
    EXPECT_NEAR(most, 1, 1e-5) << what << ": an edge of a right angle stays an edge";
  }
}

TEST(Meshes, ACubeIsACubeInEveryFormat) {
  const Cube cube;
  Folder folder;
  folder.write("cube.mtl", "newmtl red\nKd 1 0 0\nd 0.5\n");
  expect_cube(read_mesh(folder.write("binary.stl", cube.binary_stl())), "binary STL");
  expect_cube(read_mesh(folder.write("text.STL", cube.ascii_stl())), "ASCII STL");
  const Mesh obj = read_mesh(folder.write("cube.obj", cube.obj()));
  expect_cube(obj, "OBJ");
  EXPECT_EQ(obj[0].color, (std::array<float, 4>{1, 0, 0, 0.5f}));
  const Mesh collada = read_mesh(folder.write("cube.dae", cube.collada()));
  EXPECT_EQ(collada[0].color, (std::array<float, 4>{0, 0.5f, 1, 1}));
  for (const auto& p : collada[0].positions) {
    EXPECT_NEAR(std::abs(p[0] - 3), 1, 1e-5) << "in metres, where its node is";
    EXPECT_NEAR(std::abs(p[1]), 1, 1e-5);
  }
  expect_cube(collada, "Collada");
}

TEST(Meshes, ABinaryStlMayBeginWithSolidAndEndWithMore) {
  std::string bytes = Cube().binary_stl();
  std::memcpy(bytes.data(), "solid facet", 11);
  EXPECT_EQ(triangles(read_stl(bytes, "a.stl")), 12u);
  std::string longer = Cube().binary_stl() + "made by somebody";
  EXPECT_EQ(triangles(read_stl(longer, "a.stl")), 12u);
}

TEST(Meshes, ARoundSurfaceIsSmooth) {
  MeshPart cylinder;
  constexpr int kSides = 48;
  for (int i = 0; i < kSides; ++i) {
    const auto at = [](int k, float z) {
      const double a = 2 * M_PI * k / kSides;
      return std::array<float, 3>{static_cast<float>(std::cos(a)), static_cast<float>(std::sin(a)), z};
    };
    for (const auto& p : {at(i, 0), at(i + 1, 0), at(i + 1, 1), at(i, 0), at(i + 1, 1), at(i, 1)}) {
      cylinder.triangles.push_back(static_cast<std::uint32_t>(cylinder.positions.size()));
      cylinder.positions.push_back(p);
    }
  }
  tidy(cylinder);
  for (std::size_t i = 0; i < cylinder.positions.size(); ++i) {
    const auto &p = cylinder.positions[i], &n = cylinder.normals[i];
    EXPECT_GT(p[0] * n[0] + p[1] * n[1], 0.99f) << "the normal is that of the circle";
  }
}

TEST(Meshes, ShapesOfCollisionsHaveTheirVolume) {
  description::Shape shape;
  shape.size = {1, 2, 3};
  shape.radius = 0.5;
  shape.length = 2;
  const double disc = M_PI * 0.25, ball = M_PI / 6;
  const auto volume_of = [&](description::ShapeKind kind) {
    shape.kind = kind;
    return volume(mesh_of_shape(shape));
  };
  EXPECT_NEAR(volume_of(description::ShapeKind::box), 6, 1e-5);
  EXPECT_NEAR(volume_of(description::ShapeKind::cylinder), 2 * disc, 0.03 * disc);
  EXPECT_NEAR(volume_of(description::ShapeKind::sphere), ball, 0.03 * ball);
  EXPECT_NEAR(volume_of(description::ShapeKind::capsule), 2 * disc + ball, 0.06);
  EXPECT_TRUE((shape.kind = description::ShapeKind::mesh, mesh_of_shape(shape).empty()));
}

TEST(Meshes, WhatIsBrokenIsRefusedWithASentence) {
  const Cube cube;
  const auto why = [](auto read) {
    try {
      read();
      return std::string("it was taken");
    } catch (const Error& e) {
      return std::string(e.what());
    }
  };
  const auto stl = [&](const std::string& bytes) { return why([&] { read_stl(bytes, "arm.stl"); }); };
  EXPECT_NE(stl(cube.binary_stl().substr(0, 300)).find("12 triangles"), std::string::npos);
  EXPECT_NE(stl("").find("arm.stl"), std::string::npos);
  EXPECT_NE(stl("solid a\nfacet normal 0 0 1\nvertex 0 x 0\n").find("'x'"), std::string::npos);
  EXPECT_NE(why([] { read_obj("v 0 0 0\nf 1 2 3\n", "a.obj"); }).find("a.obj:2"), std::string::npos);
  EXPECT_NE(why([] { read_collada("<COLLADA", "a.dae"); }).find("a.dae"), std::string::npos);
  Folder folder;
  EXPECT_NE(why([&] { read_mesh(folder.path() / "no.stl"); }).find("no.stl"), std::string::npos);
  EXPECT_NE(why([&] { read_mesh(folder.write("a.sldprt", "x")); }).find("STL, OBJ"), std::string::npos);
}

/// Small files that cost a reader much; each would keep it for hours, or take gigabytes.
TEST(Meshes, FilesThatUnfoldAreRefused) {
  const auto why = [](auto read) {
    try {
      read();
      return std::string("it was taken");
    } catch (const Error& e) {
      return std::string(e.what());
    }
  };
  std::string face = "v 0 0 0\nf";
  for (int i = 0; i < 600'000; ++i) face += " 1";
  EXPECT_NE(why([&] { read_obj(face, "a.obj"); }).find("the line is too long"), std::string::npos);
  std::string continued = "v 0 0 0\nf";
  for (int i = 0; i < 300'000; ++i) continued += i % 1000 == 0 ? " 1 \\\n" : " 1";
  EXPECT_NE(why([&] { read_obj(continued, "a.obj"); }).find("the line is too long"), std::string::npos);
  // Each node shows the one before it twice.
  std::string nodes = "<COLLADA><library_nodes><node id='n0'/>";
  for (int i = 1; i < 60; ++i) {
    const std::string before = "<instance_node url='#n" + std::to_string(i - 1) + "'/>";
    nodes += "<node id='n" + std::to_string(i) + "'>" + before + before + "</node>";
  }
  nodes += "</library_nodes><library_visual_scenes><visual_scene><instance_node url='#n59'/></visual_scene>"
           "</library_visual_scenes></COLLADA>";
  EXPECT_NE(why([&] { read_collada(nodes, "a.dae"); }).find("20,000 nodes"), std::string::npos);
  std::string full = "<COLLADA><library_nodes><node id='n'>", shown;
  for (int i = 0; i < 2000; ++i) full += "<extra/>", shown += "<instance_node url='#n'/>";
  full += "</node></library_nodes><library_visual_scenes><visual_scene>" + shown + "</visual_scene></library_visual_scenes></COLLADA>";
  EXPECT_NE(why([&] { read_collada(full, "a.dae"); }).find("a million elements"), std::string::npos);
  std::string elements = "<COLLADA>";
  for (int i = 0; i < 1'000'001; ++i) elements += "<a/>";
  EXPECT_NE(why([&] { read_collada(elements + "</COLLADA>", "a.dae"); }).find("a million elements"), std::string::npos);
  std::string attributes = "<COLLADA ";
  for (int i = 0; i < 1000; ++i) attributes += "a" + std::to_string(i) + "='' ";
  EXPECT_NE(why([&] { read_collada(attributes + "/>", "a.dae"); }).find("attributes"), std::string::npos);
  std::string matrix = "<COLLADA><library_visual_scenes><visual_scene><node><matrix>";
  for (int i = 0; i < 100; ++i) matrix += "1 ";
  matrix += "</matrix></node></visual_scene></library_visual_scenes></COLLADA>";
  EXPECT_NE(why([&] { read_collada(matrix, "a.dae"); }).find("too many numbers"), std::string::npos);
}

TEST(Meshes, ManyFacesOfOneSourceReadItOnce) {
  const Cube cube;
  std::string text = cube.collada();
  // 10,000 groups of faces share a source of 100,000 numbers: read each time that is a thousand million.
  const std::size_t at = text.find("<float_array count=\"24\">") + 24;
  std::string more;
  for (int i = 0; i < 100'000; ++i) more += "0 ";
  text.insert(text.find("</float_array>", at), more);
  const std::size_t begin = text.find("<triangles"), end = text.find("</mesh>");
  const std::string group = "<triangles count='1'><input semantic='VERTEX' source='#v' offset='0'/><p>0 2 1</p></triangles>";
  std::string groups;
  for (int i = 0; i < 10'000; ++i) groups += group;
  text.replace(begin, end - begin, groups);
  EXPECT_EQ(triangles(read_collada(text, "a.dae")), 10'000u);
}

TEST(Meshes, WhatIsNotFiniteIsLeftOut) {
  const Cube cube;
  for (const float bad : {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    std::string bytes = cube.binary_stl();
    std::memcpy(bytes.data() + 84 + 12, &bad, 4);
    Folder folder;
    const Mesh mesh = read_mesh(folder.write("a.stl", bytes));
    EXPECT_EQ(triangles(mesh), 11u);
    for (const MeshPart& part : mesh)
      for (const auto& p : part.positions)
        for (const float c : p) EXPECT_TRUE(std::isfinite(c));
  }
  std::string text = cube.obj();
  for (std::size_t at = 0; (at = text.find("usemtl", at)) != std::string::npos; ++at)
    text.insert(at, "vn nan 0 0\r\n"), at += 20;
  for (std::size_t at = 0; (at = text.find("f -", at)) != std::string::npos; at += 3) {
    std::string line = text.substr(at, text.find("\r\n", at) - at), with;
    for (std::size_t k = 0; k < line.size(); ++k)
      with += (line[k] == ' ' && k > 2) || k + 1 == line.size() ? (line[k] == ' ' ? "//1 " : line.substr(k) + "//1")
                                                                : line.substr(k, 1);
    text.replace(at, line.size(), with);
  }
  Mesh mesh = read_obj(text, "a.obj");
  for (MeshPart& part : mesh) {
    tidy(part);
    for (const auto& n : part.normals)
      for (const float c : n) EXPECT_TRUE(std::isfinite(c));
  }
}

TEST(Meshes, NoFileBreaksAReader) {
  const Cube cube;
  std::mt19937_64 draw(5);
  const std::vector<std::string> whole = {cube.binary_stl(), cube.ascii_stl(), cube.obj(), cube.collada()};
  int taken = 0;
  for (int round = 0; round < 4000; ++round) {
    const std::size_t kind = draw() % whole.size();
    std::string text = whole[kind];
    for (std::uint64_t i = 1 + draw() % 4; i > 0; --i) {
      const std::size_t at = draw() % text.size();
      if (draw() % 8 == 0)
        text.resize(at + 1);
      else if (draw() % 4 == 0)
        text.insert(at, text.substr(draw() % text.size(), draw() % 50));
      else
        text[at] = static_cast<char>(draw());
    }
    try {
      Mesh mesh = kind < 2 ? read_stl(text, "x") : kind == 2 ? read_obj(text, "x") : read_collada(text, "x");
      for (MeshPart& part : mesh) {
        tidy(part);
        for (const std::uint32_t corner : part.triangles) ASSERT_LT(corner, part.positions.size());
        ASSERT_EQ(part.positions.size(), part.normals.size());
      }
      ++taken;
    } catch (const Error&) {
    }
  }
  EXPECT_GT(taken, 100);
}

TEST(Simplify, KeepsTheFormOfAMeshWithFewerTriangles) {
  // A ball of 2 m with 200 x 200 fields.
  MeshPart ball;
  constexpr int kFields = 200;
  for (int i = 0; i <= kFields; ++i)
    for (int k = 0; k <= kFields; ++k) {
      const double up = std::numbers::pi * i / kFields, around = 2 * std::numbers::pi * k / kFields;
      ball.positions.push_back({static_cast<float>(std::sin(up) * std::cos(around)),
                                static_cast<float>(std::sin(up) * std::sin(around)),
                                static_cast<float>(std::cos(up))});
    }
  for (std::uint32_t i = 0; i < kFields; ++i)
    for (std::uint32_t k = 0; k < kFields; ++k) {
      const std::uint32_t a = i * (kFields + 1) + k, b = a + kFields + 1;
      ball.triangles.insert(ball.triangles.end(), {a, b, a + 1, a + 1, b, b + 1});
    }
  tidy(ball);
  Mesh mesh = {ball};
  const double whole = volume(mesh);
  const double moved = simplify(mesh, 3'000);
  EXPECT_LE(triangles_of(mesh), 3'000u);
  EXPECT_GT(triangles_of(mesh), 800u) << "not far below what is allowed";
  EXPECT_NEAR(volume(mesh), whole, 0.03 * whole);
  EXPECT_LT(moved, 0.2);
  for (const MeshPart& part : mesh) {
    ASSERT_EQ(part.normals.size(), part.positions.size());
    for (const auto& p : part.positions)
      EXPECT_NEAR(std::hypot(p[0], p[1], p[2]), 1, 1e-5) << "corners are kept, not moved";
  }
  Mesh small = {ball};
  EXPECT_EQ(simplify(small, 100'000), 0);
  EXPECT_EQ(triangles_of(small), triangles_of({ball}));
}

struct Read {
  Json json;
  std::string data;
};

/// A GLB taken apart, with its form checked.
Read read_glb(const std::string& glb) {
  const auto number = [&](std::size_t at) {
    std::uint32_t out;
    std::memcpy(&out, glb.data() + at, 4);
    return out;
  };
  Read out;
  EXPECT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(number(8), glb.size());
  EXPECT_EQ(glb.size() % 4, 0u);
  const std::size_t size = number(12);
  EXPECT_EQ(number(16), 0x4E4F534Au);
  out.json = Json::parse(glb.substr(20, size));
  EXPECT_EQ(number(24 + size), 0x004E4942u);
  out.data = glb.substr(28 + size);
  EXPECT_EQ(out.data.size(), number(20 + size));
  return out;
}

description::RobotModel robot(const fs::path& base, const fs::path& arm) {
  description::RobotModel out;
  description::Shape mesh;
  mesh.kind = description::ShapeKind::mesh;
  mesh.mesh = "package://demo/base.stl";
  mesh.mesh_path = base.string();
  mesh.scale = {0.001, 0.001, 0.001};
  mesh.pose = pose_xyz_rpy({1, 0, 0}, {0, 0, 0});
  out.links.resize(3);
  out.links[0].name = "base_link";
  out.links[0].visuals = {mesh};
  description::Shape box;
  box.size = {0.1, 0.1, 0.1};
  out.links[0].collisions = {box};
  out.links[1].name = "arm_link";
  mesh.mesh_path = arm.string();
  mesh.scale = {-1, 1, 1};
  out.links[1].visuals = {mesh};
  out.links[2].name = "plain_link";
  return out;
}

TEST(RobotMeshes, HaveANodeForEachLinkWithItsMeshesInItsFrame) {
  Folder folder;
  const auto made = robot_meshes(
      robot(folder.write("base.stl", Cube().binary_stl()), folder.write("arm.obj", Cube().obj())), {});
  EXPECT_TRUE(made.warnings.empty());
  const Read glb = read_glb(made.glb);
  EXPECT_EQ(glb.json["asset"]["version"], "2.0");
  ASSERT_EQ(glb.json["nodes"].size(), 2u);
  EXPECT_EQ(glb.json["nodes"][0]["name"], "base_link");
  const Json& primitive = glb.json["meshes"][0]["primitives"][0];
  const Json& positions = glb.json["accessors"][primitive["attributes"]["POSITION"].get<int>()];
  EXPECT_NEAR(positions["min"][0].get<double>(), 0.999, 1e-6) << "scaled, then moved";
  EXPECT_NEAR(positions["max"][0].get<double>(), 1.001, 1e-6);
  for (const Json& view : glb.json["bufferViews"])
    EXPECT_LE(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>(), glb.data.size());
  EXPECT_EQ(glb.json["accessors"][primitive["indices"].get<int>()]["count"], 36);
}

TEST(RobotMeshes, AMirroredMeshIsNotInsideOut) {
  Folder folder;
  const auto made = robot_meshes(
      robot(folder.write("base.stl", Cube().binary_stl()), folder.write("arm.obj", Cube().obj())), {});
  const Read glb = read_glb(made.glb);
  for (int node = 0; node < 2; ++node) {
    const Json& primitive = glb.json["meshes"][node]["primitives"][0];
    const auto view = [&](const Json& accessor) {
      const Json& a = glb.json["accessors"][accessor.get<int>()];
      return glb.json["bufferViews"][a["bufferView"].get<int>()]["byteOffset"].get<std::size_t>();
    };
    const std::size_t positions = view(primitive["attributes"]["POSITION"]),
                      indices = view(primitive["indices"]);
    Mesh mesh(1);
    for (std::size_t i = 0; i < 36; ++i) {
      std::uint16_t corner;
      std::memcpy(&corner, glb.data.data() + indices + 2 * i, 2);
      std::array<float, 3> p;
      std::memcpy(p.data(), glb.data.data() + positions + 12 * std::size_t{corner}, 12);
      mesh[0].triangles.push_back(static_cast<std::uint32_t>(i));
      mesh[0].positions.push_back(p);
    }
    EXPECT_GT(volume(mesh), 0) << glb.json["nodes"][node]["name"];
  }
}

TEST(RobotMeshes, ABrokenMeshIsAWarningAndTheOthersAreShown) {
  Folder folder;
  const auto made =
      robot_meshes(robot(folder.write("base.stl", "nothing"), folder.write("arm.obj", Cube().obj())),
                   folder.path() / "cache");
  ASSERT_EQ(made.warnings.size(), 1u);
  EXPECT_NE(made.warnings[0].what.find("base_link"), std::string::npos);
  EXPECT_NE(made.warnings[0].what.find("base.stl"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder.path() / "cache")) << "it is told again the next time";
  const Json names = read_glb(made.glb).json["nodes"];
  ASSERT_EQ(names.size(), 2u);
  EXPECT_EQ(names[0]["name"], "base_link") << "by the box that it collides with";
}

TEST(RobotMeshes, LinksBeyondTheTrianglesOfARobotAreShownByWhatTheyCollideWith) {
  Folder folder;
  const auto model = robot(folder.write("base.stl", Cube().binary_stl()), folder.write("arm.obj", Cube().obj()));
  EXPECT_TRUE(robot_meshes(model, {}, 24).warnings.empty());
  const auto made = robot_meshes(model, {}, 20);
  ASSERT_EQ(made.warnings.size(), 1u);
  EXPECT_NE(made.warnings[0].what.find("arm_link"), std::string::npos);
  EXPECT_NE(made.warnings[0].what.find("too many triangles together"), std::string::npos);
}

TEST(RobotMeshes, AreSimplifiedForThePictureAndSayHowFar) {
  Folder folder;
  const auto model =
      robot(folder.write("base.stl", Cube().binary_stl()), folder.write("arm.obj", Cube().obj()));
  const auto made = robot_meshes(model, folder.path() / "cache", 1000, 20);
  EXPECT_TRUE(made.warnings.empty());
  ASSERT_EQ(made.notes.size(), 1u) << "12 triangles a cube is what each link may keep at the least";
  EXPECT_NE(made.notes[0].what.find("24 triangles"), std::string::npos) << made.notes[0].what;
  EXPECT_FALSE(made.glb.empty());
  EXPECT_TRUE(robot_meshes(model, folder.path() / "cache", 1000, 20).notes.empty()) << "said once";
}

TEST(RobotMeshes, OfAnotherUnitThanMetresAreDoubted) {
  Folder folder;
  auto model = robot(folder.write("base.stl", Cube().binary_stl()), folder.write("arm.obj", Cube().obj()));
  model.links[0].visuals[0].scale = {100, 100, 100};  // the cube has 2 m
  const auto made = robot_meshes(model, {});
  ASSERT_EQ(made.notes.size(), 1u);
  EXPECT_NE(made.notes[0].what.find("base.stl is 346 m large"), std::string::npos) << made.notes[0].what;
  EXPECT_NE(made.notes[0].advice.find("0.001"), std::string::npos);
}

TEST(RobotMeshes, AreMadeOnceAndAnewWhenAFileChanges) {
  Folder folder;
  const fs::path base = folder.write("base.stl", Cube().binary_stl()),
                 arm = folder.write("arm.obj", Cube().obj());
  const fs::path cache = folder.path() / "cache";
  const auto first = robot_meshes(robot(base, arm), cache);
  const std::string hash = mesh_hash(robot(base, arm));
  const fs::path kept = cache / (hash + ".glb");
  ASSERT_TRUE(fs::exists(kept));
  std::string other = first.glb;
  other.back() ^= 1;
  write_file_atomically(kept, other);
  EXPECT_EQ(robot_meshes(robot(base, arm), cache).glb, other) << "it came from there";
  write_file_atomically(base, Cube().ascii_stl());
  EXPECT_NE(mesh_hash(robot(base, arm)), hash);
}

TEST(RobotMeshes, ARobotWithoutMeshesHasNone) {
  const auto made = robot_meshes({}, {});
  EXPECT_TRUE(made.glb.empty() && made.warnings.empty());
  EXPECT_EQ(mesh_hash({}), "");
}

}  // namespace
}  // namespace polyarm::meshes
