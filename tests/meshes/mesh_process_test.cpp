/// Meshes that a process apart reads, and what becomes of a bad file or a bad answer.
#include "polyarm/meshes/mesh_process.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <string>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/meshes/glb_writer.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::meshes {
namespace {

using test::Folder;

/// A tetrahedron with the corners 0, x, y and z.
MeshPart tetrahedron() {
  MeshPart out;
  out.positions = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  out.triangles = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  out.color = {0.25f, 0.5f, 0.75f, 1};
  out.colored = true;
  return out;
}

std::array<float, 3> extent(const Mesh& mesh) {
  std::array<float, 3> out{};
  for (const MeshPart& part : mesh)
    for (const auto& p : part.positions)
      for (std::size_t k = 0; k < 3; ++k) out[k] = std::max(out[k], p[k]);
  return out;
}

constexpr const char* kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 255 0 0\n1 0 0 255 0 0\n0 2 0 255 0 0\n0 0 3 255 0 0\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

TEST(MeshProcess, AnAnswerIsReadAsItWasWritten) {
  std::vector<std::byte> message;
  pack_mesh({tetrahedron(), tetrahedron()}, message);
  Mesh mesh;
  ASSERT_TRUE(unpack_mesh(message, mesh));
  ASSERT_EQ(mesh.size(), 2u);
  EXPECT_EQ(mesh[1].positions, tetrahedron().positions);
  EXPECT_EQ(mesh[1].triangles, tetrahedron().triangles);
  EXPECT_EQ(mesh[1].color, tetrahedron().color);
}

TEST(MeshProcess, ADamagedAnswerIsRefusedOrSafe) {
  std::vector<std::byte> whole;
  pack_mesh({tetrahedron()}, whole);
  Mesh mesh;
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(unpack_mesh(std::span(whole).first(size), mesh)) << size;
  std::mt19937_64 draw(7);
  int taken = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::vector<std::byte> message = whole;
    for (std::uint64_t i = 1 + draw() % 4; i > 0; --i)
      message[draw() % message.size()] = static_cast<std::byte>(draw());
    if (!unpack_mesh(message, mesh)) continue;
    ++taken;
    for (MeshPart& part : mesh) {
      for (const std::uint32_t corner : part.triangles) ASSERT_LT(corner, part.positions.size());
      for (const float value : part.color) ASSERT_TRUE(value >= 0 && value <= 1);
      tidy(part);
    }
  }
  EXPECT_GT(taken, 100);
}

TEST(MeshProcess, AnUnknownFormatIsRefusedWithTheKnownOnes) {
  Folder folder;
  try {
    read_mesh(folder.write("a.sldprt", "x"));
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "unknown-mesh");
    EXPECT_NE(e.problems().front().advice.find("PLY"), std::string::npos);
  }
}

#ifdef POLYARM_MESH_IMPORT
TEST(MeshProcess, ReadsGlbAndPlyWithTheirColours) {
  Folder folder;
  const Mesh glb = read_mesh(folder.write("a.glb", write_glb({{"a", {tetrahedron()}}})));
  ASSERT_EQ(glb.size(), 1u);
  EXPECT_EQ(glb[0].triangles.size(), 12u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(glb[0].color[k], tetrahedron().color[k], 1e-4);
  const Mesh ply = read_mesh(folder.write("a.PLY", kPly));
  ASSERT_EQ(ply.size(), 1u);
  EXPECT_EQ(ply[0].triangles.size(), 12u);
  EXPECT_EQ(extent(ply), (std::array<float, 3>{1, 2, 3}));
  EXPECT_EQ(ply[0].color, (std::array<float, 4>{1, 0, 0, 1}));
  EXPECT_EQ(ply[0].normals.size(), ply[0].positions.size());
}

TEST(MeshProcess, ADamagedFileIsAnErrorThatNamesIt) {
  Folder folder;
  const std::string glb = write_glb({{"a", {tetrahedron()}}});
  std::mt19937_64 draw(3);
  int refused = 0;
  for (int round = 0; round < 16; ++round) {
    const bool is_glb = round % 2 == 0;
    std::string bytes = is_glb ? glb : kPly;
    bytes.resize(1 + draw() % bytes.size());
    for (int i = 0; i < 3; ++i) bytes[draw() % bytes.size()] = static_cast<char>(draw());
    try {
      read_mesh(folder.write(is_glb ? "broken.glb" : "broken.ply", bytes));
    } catch (const Error& e) {
      ++refused;
      EXPECT_NE(e.problems().front().what.find("broken."), std::string::npos) << e.what();
    }
  }
  EXPECT_GT(refused, 7);
}

TEST(MeshProcess, AFileThatNamesOthersReachesNone) {
  Folder folder;
  folder.write("secret.bin", std::string(36, '\0'));
  const std::string gltf = R"({"asset":{"version":"2.0"},"buffers":[{"uri":"secret.bin","byteLength":36}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0})";
  EXPECT_THROW(read_mesh(folder.write("a.gltf", gltf)), Error);
}
#endif

TEST(MeshProcess, WithoutItsLibraryAFileIsRefusedWithTheNameOfThePackage) {
#ifndef POLYARM_STEP_IMPORT
  Folder folder;
  try {
    read_mesh(folder.write("a.step", "x"));
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("libocct-data-exchange-dev"), std::string::npos) << e.what();
  }
#else
  GTEST_SKIP() << "this build has Open CASCADE";
#endif
}

#ifdef POLYARM_STEP_IMPORT
/// A block of 10 x 20 x 30 mm: six plane faces with straight edges, as ISO 10303-21 with AP214.
std::string step_block() {
  std::string data;
  int next = 100;
  const auto add = [&](const std::string& text) {
    data += "#" + std::to_string(++next) + "=" + text + ";\n";
    return next;
  };
  const auto ref = [](int id) { return "#" + std::to_string(id); };
  const auto point = [&](double x, double y, double z) {
    return add("CARTESIAN_POINT('',(" + std::to_string(x) + "," + std::to_string(y) + "," +
               std::to_string(z) + "))");
  };
  const auto direction = [&](double x, double y, double z) {
    return add("DIRECTION('',(" + std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(z) +
               "))");
  };
  const double size[3] = {10, 20, 30};
  int vertices[8];
  const auto coordinate = [&](int corner, int k) { return corner >> k & 1 ? size[k] : 0.0; };
  for (int i = 0; i < 8; ++i)
    vertices[i] =
        add("VERTEX_POINT(''," + ref(point(coordinate(i, 0), coordinate(i, 1), coordinate(i, 2))) + ")");
  std::map<std::pair<int, int>, int> edges;
  const auto edge = [&](int a, int b) {
    const std::pair<int, int> key{std::min(a, b), std::max(a, b)};
    if (!edges.contains(key)) {
      double way[3];
      for (int k = 0; k < 3; ++k) way[k] = (coordinate(key.second, k) - coordinate(key.first, k)) > 0 ? 1 : 0;
      const int from = point(coordinate(key.first, 0), coordinate(key.first, 1), coordinate(key.first, 2));
      const int vector = add("VECTOR(''," + ref(direction(way[0], way[1], way[2])) + ",1.)");
      const int line = add("LINE(''," + ref(from) + "," + ref(vector) + ")");
      edges[key] = add("EDGE_CURVE(''," + ref(vertices[key.first]) + "," + ref(vertices[key.second]) + "," +
                       ref(line) + ",.T.)");
    }
    return add("ORIENTED_EDGE('',*,*," + ref(edges[key]) + (a < b ? ",.T.)" : ",.F.)"));
  };
  const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  const double normals[6][3] = {{0, 0, -1}, {0, 0, 1}, {0, -1, 0}, {0, 1, 0}, {-1, 0, 0}, {1, 0, 0}};
  std::string list;
  for (int f = 0; f < 6; ++f) {
    std::string loop;
    for (int k = 0; k < 4; ++k) loop += (k ? "," : "") + ref(edge(faces[f][k], faces[f][(k + 1) % 4]));
    const int bound = add("FACE_OUTER_BOUND(''," + ref(add("EDGE_LOOP('',(" + loop + "))")) + ",.T.)");
    const int c = faces[f][0];
    const double* n = normals[f];
    const int axis =
        add("AXIS2_PLACEMENT_3D(''," + ref(point(coordinate(c, 0), coordinate(c, 1), coordinate(c, 2))) +
            "," + ref(direction(n[0], n[1], n[2])) + "," +
            ref(n[0] != 0 ? direction(0, 1, 0) : direction(1, 0, 0)) + ")");
    list += (f ? "," : "") + ref(add("ADVANCED_FACE('',(" + ref(bound) + ")," +
                                     ref(add("PLANE(''," + ref(axis) + ")")) + ",.T.)"));
  }
  const int solid = add("MANIFOLD_SOLID_BREP(''," + ref(add("CLOSED_SHELL('',(" + list + "))")) + ")");
  return "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
         "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
         "#1=APPLICATION_CONTEXT('');\n#2=PRODUCT_CONTEXT('',#1,'mechanical');\n#3=PRODUCT('block','block',''"
         ",(#2));\n"
         "#4=PRODUCT_DEFINITION_FORMATION('','',#3);\n#5=PRODUCT_DEFINITION_CONTEXT('part "
         "definition',#1,'design');\n"
         "#6=PRODUCT_DEFINITION('design','',#4,#5);\n#7=PRODUCT_DEFINITION_SHAPE('','',#6);\n"
         "#8=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n#9=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_"
         "UNIT($,.RADIAN.));\n"
         "#10=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());\n"
         "#11=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),#8,'distance_accuracy_value','');\n"
         "#12=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#11))GLOBAL_UNIT_"
         "ASSIGNED_CONTEXT((#8,#9,#10))"
         "REPRESENTATION_CONTEXT('',''));\n#13=CARTESIAN_POINT('',(0.,0.,0.));\n#14=DIRECTION('',(0.,0.,1.));"
         "\n"
         "#15=DIRECTION('',(1.,0.,0.));\n#16=AXIS2_PLACEMENT_3D('',#13,#14,#15);\n" +
         data + "#17=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#16," + ref(solid) +
         "),#12);\n#18=SHAPE_DEFINITION_REPRESENTATION(#7,#17);\n"
         "ENDSEC;\nEND-ISO-10303-21;\n";
}

TEST(MeshProcess, ReadsStepInMetres) {
  Folder folder;
  for (const char* name : {"a.step", "b.STP"}) {
    const Mesh mesh = read_mesh(folder.write(name, step_block()));
    ASSERT_EQ(mesh.size(), 1u);
    EXPECT_EQ(mesh[0].triangles.size(), 36u) << "two triangles for each of six faces";
    const auto size = extent(mesh);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(size[k], 0.01 * static_cast<double>(k + 1), 1e-6);
    for (std::size_t i = 0; i < mesh[0].positions.size(); ++i) {  // outwards
      const auto &p = mesh[0].positions[i], &n = mesh[0].normals[i];
      EXPECT_GT((p[0] - 0.005) * n[0] + (p[1] - 0.01) * n[1] + (p[2] - 0.015) * n[2], 0);
    }
  }
}

TEST(MeshProcess, ADamagedStepIsAnErrorThatNamesIt) {
  Folder folder;
  const std::string whole = step_block();
  std::mt19937_64 draw(3);
  int refused = 0;
  for (int round = 0; round < 12; ++round) {
    std::string bytes = whole;
    if (round % 3 == 0) bytes.resize(draw() % bytes.size());
    for (int i = 0; i < 4 && !bytes.empty(); ++i) bytes[draw() % bytes.size()] = static_cast<char>(draw());
    try {
      read_mesh(folder.write("broken.step", bytes));
    } catch (const Error& e) {
      ++refused;
      EXPECT_NE(e.problems().front().what.find("broken."), std::string::npos) << e.what();
    }
  }
  EXPECT_GT(refused, 3);
}
#endif

}  // namespace
}  // namespace polyarm::meshes
