#include "polyarm/meshes/glb_writer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

namespace polyarm::meshes {

namespace {

using Json = nlohmann::json;
enum ComponentType { kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126 };
enum Target { kArrayBuffer = 34962, kElementArrayBuffer = 34963 };

class Glb {
 public:
  void add(const GlbNode& node) {
    Json primitives = Json::array();
    for (const MeshPart& part : node.mesh)
      if (!part.triangles.empty()) primitives.push_back(primitive(part));
    if (primitives.empty()) return;
    meshes_.push_back({{"primitives", primitives}});
    nodes_.push_back({{"name", node.name}, {"mesh", meshes_.size() - 1}});
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
    if (nodes_.empty()) all = {{"asset", all["asset"]}};
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
    return {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
            {"indices", indices(part)},
            {"material", material(part)}};
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

  /// Colours in files are sRGB; glTF needs linear ones.
  std::size_t material(const MeshPart& part) {
    const auto at = by_color_.find(part.color);
    if (at != by_color_.end()) return at->second;
    std::array<float, 4> linear = part.color;
    for (std::size_t k = 0; k < 3; ++k) {
      const float c = std::clamp(part.color[k], 0.f, 1.f);
      linear[k] = c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
    }
    Json out{{"pbrMetallicRoughness",
              {{"baseColorFactor", linear}, {"metallicFactor", 0.1}, {"roughnessFactor", 0.6}}},
             {"doubleSided", true}};
    if (linear[3] < 1) out["alphaMode"] = "BLEND";
    materials_.push_back(std::move(out));
    return by_color_[part.color] = materials_.size() - 1;
  }

  Json nodes_ = Json::array(), meshes_ = Json::array(), materials_ = Json::array(),
       accessors_ = Json::array(), views_ = Json::array();
  std::map<std::array<float, 4>, std::size_t> by_color_;
  std::string data_;
};

}  // namespace

std::string write_glb(const std::vector<GlbNode>& nodes) {
  Glb out;
  for (const GlbNode& node : nodes) out.add(node);
  return out.bytes();
}

}  // namespace polyarm::meshes
