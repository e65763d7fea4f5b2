/// polyarm_mesh_import: reads one mesh file with Assimp, and writes its triangles to the process that started
/// it.
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "importers/importer.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::meshes {
namespace {

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

/// The images that materials use, each made once.
class Images {
 public:
  explicit Images(const aiScene& scene) : scene_(scene), made_(scene.mNumTextures) {}

  /// Null if the material has none within the file.
  Image of(const aiMaterial& material) {
    aiString path;
    if (material.GetTexture(aiTextureType_BASE_COLOR, 0, &path) != AI_SUCCESS &&
        material.GetTexture(aiTextureType_DIFFUSE, 0, &path) != AI_SUCCESS)
      return {};
    for (unsigned i = 0; i < scene_.mNumTextures && i < kMostImages; ++i)
      if (scene_.mTextures[i] == scene_.GetEmbeddedTexture(path.C_Str())) return made(i);
    return {};
  }

 private:
  Image made(unsigned i) {
    const aiTexture& texture = *scene_.mTextures[i];
    if (texture.mHeight != 0 || texture.mWidth > kMostImageBytes) return {};  // not a file in memory
    if (!made_[i])
      made_[i] =
          std::make_shared<const std::string>(reinterpret_cast<const char*>(texture.pcData), texture.mWidth);
    return made_[i];
  }

  const aiScene& scene_;
  std::vector<Image> made_;
};

/// Assimp counts v from the lower edge of the image.
void take_image(const aiMesh& mesh, Image image, MeshPart& part) {
  if (!image || !mesh.mTextureCoords[0]) return;
  part.image = std::move(image);
  if (!part.colored) part.color = {1, 1, 1, 1};
  for (unsigned i = 0; i < mesh.mNumVertices; ++i)
    part.texcoords.push_back({mesh.mTextureCoords[0][i].x, 1 - mesh.mTextureCoords[0][i].y});
}

Mesh read(const std::string& bytes, const std::string& kind) {
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFileFromMemory(
      bytes.data(), bytes.size(),
      aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices, kind.c_str());
  if (!scene) throw Refused{importer.GetErrorString()};
  Images images(*scene);
  Mesh mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
    const aiMesh& from = *scene->mMeshes[i];
    mesh.push_back(part_of(from, *scene));
    if (from.mMaterialIndex < scene->mNumMaterials)
      take_image(from, images.of(*scene->mMaterials[from.mMaterialIndex]), mesh.back());
  }
  if (kind != "ply")
    for (MeshPart& part : mesh)
      if (part.colored) to_srgb(part);
  return mesh;
}

}  // namespace
}  // namespace polyarm::meshes

int main(int argc, char** argv) {
  constexpr std::size_t kMostMemory = polyarm::bounds::kMeshImportMemory;  // bytes
  return polyarm::meshes::run_importer(argc, argv, kMostMemory, polyarm::meshes::read);
}
