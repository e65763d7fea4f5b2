/// Meshes that a process apart reads, and what becomes of a bad file or a bad answer.
#include "polyarm/meshes/mesh_process.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

}  // namespace
}  // namespace polyarm::meshes
