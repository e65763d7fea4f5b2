#include "polyarm/meshes/glb_writer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

namespace polyarm::meshes {

namespace {

using Json = nlohmann::json;
enum ComponentType { kByte = 5120, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126 };
enum Target { kArrayBuffer = 34962, kElementArrayBuffer = 34963 };

/// The box around a mesh in steps of 12 bits, which compress well: position = center + step * number.
struct Grid {
  static constexpr float kMost = 2047;
  std::array<float, 3> center{};
  float step = 1;

  explicit Grid(const Mesh& mesh) {
    std::array<float, 3> low, high;
    low.fill(std::numeric_limits<float>::max());
    high.fill(std::numeric_limits<float>::lowest());
    for (const MeshPart& part : mesh)
      for (const auto& p : part.positions)
        for (std::size_t k = 0; k < 3; ++k) {
          low[k] = std::min(low[k], p[k]);
          high[k] = std::max(high[k], p[k]);
        }
    float longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      center[k] = (low[k] + high[k]) / 2;
      longest = std::max(longest, high[k] - low[k]);
    }
    if (longest > 0) step = longest / 2 / kMost;
  }
  std::int16_t number(float value, std::size_t k) const {
    return static_cast<std::int16_t>(std::lround(std::clamp((value - center[k]) / step, -kMost, kMost)));
  }
};

class Glb {
 public:
  explicit Glb(Precision precision) : compact_(precision == Precision::compact) {}

  void add(const GlbNode& node) {
    Json primitives = Json::array();
    const Grid grid(node.mesh);
    for (const MeshPart& part : node.mesh)
      if (!part.triangles.empty()) primitives.push_back(compact_ ? compact(part, grid) : primitive(part));
    if (primitives.empty()) return;
    meshes_.push_back({{"primitives", primitives}});
    nodes_.push_back({{"name", node.name}, {"mesh", meshes_.size() - 1}});
    if (!compact_) return;
    nodes_.back()["translation"] = grid.center;
    nodes_.back()["scale"] = {grid.step, grid.step, grid.step};
  }

  std::string bytes() {
    Json roots = Json::array();
    for (std::size_t i = 0; i < nodes_.size(); ++i) roots.push_back(i);
    Json all{{"asset", {{"version", "2.0"}, {"generator", "polyarm"}}},
             {"scene", 0},
             {"scenes", Json::array({{{"nodes", roots}}})},
             {"nodes", nodes_},
             {"meshes", meshes_},
             {"materials", materials_},
             {"accessors", accessors_},
             {"bufferViews", views_},
             {"buffers", Json::array({{{"byteLength", data_.size()}}})}};
    if (!images_.empty()) {
      all["images"] = images_;
      all["textures"] = textures_json();
    }
    if (nodes_.empty()) all = {{"asset", all["asset"]}};
    if (compact_ && !nodes_.empty())
      all["extensionsUsed"] = all["extensionsRequired"] = {"KHR_mesh_quantization"};
    std::string text = all.dump(-1, ' ', false, Json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string out;
    const std::size_t data = data_.empty() ? 0 : 8 + data_.size();
    number(out, 0x46546C67);  // "glTF"
    number(out, 2);
    number(out, 12 + 8 + text.size() + data);
    number(out, text.size());
    number(out, 0x4E4F534A);  // "JSON"
    out += text;
    if (data_.empty()) return out;
    number(out, data_.size());
    number(out, 0x004E4942);  // "BIN"
    return out + data_;
  }

 private:
  static void number(std::string& out, std::size_t value) {
    for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> (8 * i));
  }

  /// Each corner takes eight bytes for its position and four for its normal; the last of them are padding.
  Json compact(const MeshPart& part, const Grid& grid) {
    std::vector<std::int16_t> positions;
    std::vector<std::int8_t> normals;
    std::array<std::int16_t, 3> low, high;
    low.fill(std::numeric_limits<std::int16_t>::max());
    high.fill(std::numeric_limits<std::int16_t>::min());
    for (std::size_t i = 0; i < part.positions.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        positions.push_back(grid.number(part.positions[i][k], k));
        low[k] = std::min(low[k], positions.back());
        high[k] = std::max(high[k], positions.back());
        normals.push_back(
            static_cast<std::int8_t>(std::lround(127 * std::clamp(part.normals[i][k], -1.f, 1.f))));
      }
      positions.push_back(0);
      normals.push_back(0);
    }
    const std::size_t at = accessor(positions.data(), part.positions.size(), 8, kShort, "VEC3");
    views_.back()["byteStride"] = 8;
    accessors_[at]["min"] = low;
    accessors_[at]["max"] = high;
    const std::size_t normal = accessor(normals.data(), part.normals.size(), 4, kByte, "VEC3");
    views_.back()["byteStride"] = 4;
    accessors_[normal]["normalized"] = true;
    return {{"attributes", {{"POSITION", at}, {"NORMAL", normal}}},
            {"indices", indices(part)},
            {"material", material(part)}};
  }

  Json primitive(const MeshPart& part) {
    std::array<float, 3> low = part.positions[0], high = low;
    for (const auto& p : part.positions)
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
      }
    const std::size_t positions = accessor(part.positions.data(), part.positions.size(), 12, kFloat, "VEC3");
    accessors_[positions]["min"] = low;
    accessors_[positions]["max"] = high;
    const std::size_t normals = accessor(part.normals.data(), part.normals.size(), 12, kFloat, "VEC3");
    Json attributes{{"POSITION", positions}, {"NORMAL", normals}};
    if (part.image)
      attributes["TEXCOORD_0"] = accessor(part.texcoords.data(), part.texcoords.size(), 8, kFloat, "VEC2");
    return {{"attributes", attributes}, {"indices", indices(part)}, {"material", material(part)}};
  }

  std::size_t indices(const MeshPart& part) {
    if (part.positions.size() > 65535)  // the highest index has a special meaning
      return accessor(part.triangles.data(), part.triangles.size(), 4, kUnsignedInt, "SCALAR",
                      kElementArrayBuffer);
    const std::vector<std::uint16_t> small(part.triangles.begin(), part.triangles.end());
    return accessor(small.data(), small.size(), 2, kUnsignedShort, "SCALAR", kElementArrayBuffer);
  }

  std::size_t accessor(const void* from, std::size_t count, std::size_t size, ComponentType component,
                       const char* type, Target target = kArrayBuffer) {
    views_.push_back(
        {{"buffer", 0}, {"byteOffset", data_.size()}, {"byteLength", count * size}, {"target", target}});
    data_.append(static_cast<const char*>(from), count * size);
    data_.resize((data_.size() + 3) / 4 * 4, '\0');
    accessors_.push_back(
        {{"bufferView", views_.size() - 1}, {"componentType", component}, {"count", count}, {"type", type}});
    return accessors_.size() - 1;
  }

  /// One material per colour and finish. Colours in files are sRGB; glTF needs linear ones.
  std::size_t material(const MeshPart& part) {
    const bool has_image = part.image && !compact_;
    const Finish key{
        has_image ? std::string_view(*part.image) : std::string_view(),
        {part.color[0], part.color[1], part.color[2], part.color[3], part.roughness, part.metallic}};
    const auto at = by_check_.find(key);
    if (at != by_check_.end()) return at->second;
    std::array<float, 4> linear = part.color;
    for (std::size_t k = 0; k < 3; ++k) {
      const float c = std::clamp(part.color[k], 0.f, 1.f);
      linear[k] = c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
    }
    Json out{{"pbrMetallicRoughness",
              {{"baseColorFactor", linear},
               {"metallicFactor", part.metallic},
               {"roughnessFactor", part.roughness}}},
             {"doubleSided", true}};
    if (linear[3] < 1) out["alphaMode"] = "BLEND";
    if (has_image) out["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", texture(*part.image)}};
    materials_.push_back(std::move(out));
    return by_check_[key] = materials_.size() - 1;
  }

  /// An image is stored once, however many parts and files have it.
  std::size_t texture(std::string_view image) {
    const auto at = textures_.find(image);
    if (at != textures_.end()) return at->second;
    views_.push_back({{"buffer", 0}, {"byteOffset", data_.size()}, {"byteLength", image.size()}});
    data_ += image;
    data_.resize((data_.size() + 3) / 4 * 4, '\0');
    images_.push_back({{"bufferView", views_.size() - 1}, {"mimeType", media_type(image)}});
    return textures_[image] = images_.size() - 1;
  }

  Json textures_json() const {
    Json out = Json::array();
    for (std::size_t i = 0; i < images_.size(); ++i) out.push_back({{"source", i}});
    return out;
  }

  /// Image, colour, roughness, metallic. The images belong to the nodes.
  using Finish = std::pair<std::string_view, std::array<float, 6>>;

  const bool compact_;
  Json nodes_ = Json::array(), meshes_ = Json::array(), materials_ = Json::array(),
       accessors_ = Json::array(), views_ = Json::array(), images_ = Json::array();
  std::map<Finish, std::size_t> by_check_;
  std::map<std::string_view, std::size_t> textures_;
  std::string data_;
};

}  // namespace

std::string write_glb(const std::vector<GlbNode>& nodes, Precision precision) {
  Glb out(precision);
  for (const GlbNode& node : nodes) out.add(node);
  return out.bytes();
}

}  // namespace polyarm::meshes
