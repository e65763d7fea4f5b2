/// polyarm_mesh_import: reads one mesh file with Assimp, and writes its triangles to the process that started
/// it.
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "polyarm/meshes/mesh_process.hpp"
#include "polyarm/process/child.hpp"
#include "polyarm/process/confinement.hpp"

namespace polyarm::meshes {
namespace {

constexpr std::size_t kMostMemory = std::size_t{2} << 30;  // bytes

void limit_work(std::size_t bytes) {
  const rlim_t seconds = import_seconds(bytes);
  const rlimit file{kMostImportBytes, kMostImportBytes}, time{seconds, seconds};
  ::setrlimit(RLIMIT_FSIZE, &file);
  ::setrlimit(RLIMIT_CPU, &time);
}

std::string read_all(int descriptor) {
  std::string out;
  char bytes[65536];
  for (ssize_t count = 0; (count = ::read(descriptor, bytes, sizeof bytes)) > 0;)
    out.append(bytes, static_cast<std::size_t>(count));
  return out;
}

bool write_all(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

/// Mean of the colours of the corners; some formats have no materials.
std::array<float, 4> mean_color(const aiMesh& mesh) {
  std::array<double, 4> sum{};
  for (unsigned i = 0; i < mesh.mNumVertices; ++i)
    for (unsigned k = 0; k < 4; ++k) sum[k] += mesh.mColors[0][i][k];
  std::array<float, 4> out;
  for (std::size_t k = 0; k < 4; ++k) out[k] = static_cast<float>(sum[k] / mesh.mNumVertices);
  return out;
}

/// Colours of glTF are linear, those of a Mesh are sRGB (IEC 61966-2-1).
float srgb(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

void take_material(const aiMaterial& from, MeshPart& part) {
  aiColor4D color;
  part.colored = from.Get(AI_MATKEY_BASE_COLOR, color) == AI_SUCCESS ||
                 from.Get(AI_MATKEY_COLOR_DIFFUSE, color) == AI_SUCCESS;
  if (part.colored) part.color = {color.r, color.g, color.b, color.a};
  from.Get(AI_MATKEY_METALLIC_FACTOR, part.metallic);
  from.Get(AI_MATKEY_ROUGHNESS_FACTOR, part.roughness);
}

MeshPart part_of(const aiMesh& mesh, const aiScene& scene) {
  MeshPart out;
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& p = mesh.mVertices[i];
    out.positions.push_back({p.x, p.y, p.z});
    if (mesh.mNormals) out.normals.push_back({mesh.mNormals[i].x, mesh.mNormals[i].y, mesh.mNormals[i].z});
  }
  for (unsigned i = 0; i < mesh.mNumFaces; ++i)
    if (mesh.mFaces[i].mNumIndices == 3)
      out.triangles.insert(out.triangles.end(), mesh.mFaces[i].mIndices, mesh.mFaces[i].mIndices + 3);
  if (mesh.mMaterialIndex < scene.mNumMaterials) take_material(*scene.mMaterials[mesh.mMaterialIndex], out);
  if (mesh.mColors[0] && mesh.mNumVertices > 0) {
    out.color = mean_color(mesh);
    out.colored = true;
  }
  return out;
}

void to_srgb(MeshPart& part) {
  for (std::size_t k = 0; k < 3; ++k) part.color[k] = srgb(part.color[k]);
}

int run(const std::string& kind) {
  const std::string bytes = read_all(kImportFile);
  limit_work(bytes.size());
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFileFromMemory(
      bytes.data(), bytes.size(),
      aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices, kind.c_str());
  if (!scene) {
    std::fprintf(stderr, "%s\n", importer.GetErrorString());
    return kImportRefused;
  }
  Mesh mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) mesh.push_back(part_of(*scene->mMeshes[i], *scene));
  if (kind != "ply")
    for (MeshPart& part : mesh)
      if (part.colored) to_srgb(part);
  std::vector<std::byte> message;
  pack_mesh(mesh, message);
  return write_all(kImportAnswer, message) ? 0 : 1;
}

}  // namespace
}  // namespace polyarm::meshes

int main(int argc, char** argv) {
  using namespace polyarm;
  const int parent = argc == 3 ? std::atoi(argv[1]) : 0;
  if (parent <= 0) {
    std::fputs("polyarm starts this program to read a mesh file\n", stderr);
    return 2;
  }
  process::ChildRules rules;
  rules.handed = 2;
  rules.parent = parent;
  rules.most_memory = meshes::kMostMemory;
  if (!process::become_child(rules)) return 1;
  process::filter_calls();
  process::confine(
      {.readable = {}, .connects = std::vector<std::uint16_t>{}, .listens = std::vector<std::uint16_t>{}});
  int code = 1;
  try {
    code = meshes::run(argv[2]);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
  }
  std::fflush(stderr);
  ::_exit(code);  // without the destructors of a library that has read a hostile file
}
