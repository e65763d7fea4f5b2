#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string_view>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/xml_bounds.hpp"
#include "polyarm/meshes/affine.hpp"
#include "polyarm/meshes/mesh.hpp"

namespace polyarm::meshes {

namespace {

using Element = tinyxml2::XMLElement;
using Color = std::array<float, 4>;
constexpr int kDeepest = bounds::kColladaNesting;
/// Limits: an element costs some hundred bytes, and other nodes may instantiate a node repeatedly.
constexpr std::size_t kMostElements = bounds::kColladaElements, kMostNodes = bounds::kColladaNodes;
/// Limits for one list, and for all together.
constexpr std::size_t kMostInList = 12 * kMostTriangles, kMostNumbers = 8 * kMostInList;

Affine rotation(const std::vector<double>& v) {
  const double n = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (!(n > 0)) return kIdentity;
  const double x = v[0] / n, y = v[1] / n, z = v[2] / n, angle = v[3] * std::numbers::pi / 180;
  const double c = std::cos(angle), s = std::sin(angle), t = 1 - c;
  return {{{t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0},
           {t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0},
           {t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0}}};
}

std::string attribute(const Element* e, const char* name) {
  const char* text = e ? e->Attribute(name) : nullptr;
  return text ? text : "";
}
/// The id of a reference "#id".
std::string link(const Element* e, const char* name) {
  const std::string text = attribute(e, name);
  return text.starts_with('#') ? text.substr(1) : text;
}

class ColladaReader {
 public:
  ColladaReader(const std::string& text, const std::string& name, const FindImage& find)
      : name_(name), find_(find) {
    check_xml_bounds(text, name, kLargestFile);
    if (static_cast<std::size_t>(std::count(text.begin(), text.end(), '<')) > kMostElements)
      refuse("it has more than a million elements");
    const std::string plain = without_instructions(text);
    if (document_.Parse(plain.data(), plain.size()) != tinyxml2::XML_SUCCESS)
      refuse("line " + std::to_string(document_.ErrorLineNum()) + " is no XML");
    root_ = document_.FirstChildElement("COLLADA");
    if (!root_) refuse("its root is not <COLLADA>");
    index(root_, 0);
  }

  Mesh read() {
    Affine scale = kIdentity;
    const Element* asset = root_->FirstChildElement("asset");
    const double meter = asset && asset->FirstChildElement("unit")
                             ? asset->FirstChildElement("unit")->DoubleAttribute("meter", 1)
                             : 1;
    for (std::size_t k = 0; k < 3; ++k) scale[k][k] = meter > 0 && std::isfinite(meter) ? meter : 1;
    const Element* scene = root_->FirstChildElement("scene");
    const Element* shown =
        scene ? find(link(scene->FirstChildElement("instance_visual_scene"), "url")) : nullptr;
    if (!shown && root_->FirstChildElement("library_visual_scenes"))
      shown = root_->FirstChildElement("library_visual_scenes")->FirstChildElement("visual_scene");
    if (shown)
      add_nodes(*shown, scale, 0);
    else
      for (const auto& [id, element] : by_id_)
        if (std::string_view(element->Name()) == "geometry") add_geometry(*element, scale, nullptr);
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error("bad-mesh", "the mesh " + name_ + " is not a whole Collada: " + what, "export it again");
  }

  void index(const Element* e, int depth) {
    if (depth > kDeepest) refuse("its elements are too deep in each other");
    for (; e; e = e->NextSiblingElement()) {
      if (const char* id = e->Attribute("id")) by_id_.emplace(id, e);
      index(e->FirstChildElement(), depth + 1);
      if (depth == 0) break;
    }
  }
  const Element* find(const std::string& id) const {
    const auto at = by_id_.find(id);
    return at == by_id_.end() ? nullptr : at->second;
  }

  template <class T>
  std::vector<T> numbers(const Element* e, std::size_t most = kMostInList) {
    std::vector<T> out;
    std::string_view rest = e && e->GetText() ? e->GetText() : "";
    for (;;) {
      const auto begin = rest.find_first_not_of(" \t\r\n");
      if (begin == std::string_view::npos) return out;
      rest.remove_prefix(begin);
      if (rest.starts_with('+')) rest.remove_prefix(1);
      if (out.size() >= most || ++numbers_ > kMostNumbers)
        refuse("there are too many numbers in line " + std::to_string(e->GetLineNum()));
      T value{};
      const auto [end, wrong] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
      if (wrong != std::errc())
        refuse("'" + std::string(rest.substr(0, rest.find_first_of(" \t\r\n"))).substr(0, 40) + "' in line " +
               std::to_string(e->GetLineNum()) + " is not a number");
      out.push_back(value);
      rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    }
  }

  Affine own_map(const Element& node) {
    Affine out = kIdentity;
    for (const Element* e = node.FirstChildElement(); e; e = e->NextSiblingElement()) {
      const std::string_view kind = e->Name();
      if (kind != "matrix" && kind != "translate" && kind != "rotate" && kind != "scale") continue;
      const std::vector<double> v = numbers<double>(e, 16);
      if (v.size() < (kind == "matrix" ? 12u : kind == "rotate" ? 4u : 3u))
        refuse("<" + std::string(kind) + "> in line " + std::to_string(e->GetLineNum()) + " is too short");
      Affine next = kIdentity;
      for (std::size_t r = 0; r < 3; ++r) {
        if (kind == "translate") next[r][3] = v[r];
        if (kind == "scale") next[r][r] = v[r];
        for (std::size_t c = 0; kind == "matrix" && c < 4; ++c) next[r][c] = v[4 * r + c];
      }
      out = out * (kind == "rotate" ? rotation(v) : next);
    }
    return out;
  }

  /// Nodes that are shown again and again count each time, with all that is in them.
  void visit() {
    if (++visits_ > kMostElements) refuse("it shows more than a million elements");
  }

  void add_nodes(const Element& parent, const Affine& before, int depth) {
    if (depth > kDeepest) refuse("its nodes are too deep in each other");
    if (++nodes_ > kMostNodes) refuse("it shows more than 20,000 nodes");
    for (const Element* e = parent.FirstChildElement(); e; e = e->NextSiblingElement()) {
      visit();
      const std::string_view kind = e->Name();
      if (kind == "node") add_nodes(*e, before * own_map(*e), depth + 1);
      if (kind == "instance_node")
        if (const Element* node = find(link(e, "url"))) add_nodes(*node, before * own_map(*node), depth + 1);
      if (kind != "instance_geometry") continue;
      const Element* geometry = find(link(e, "url"));
      if (!geometry) refuse("there is no geometry '" + link(e, "url") + "'");
      add_geometry(*geometry, before, e);
    }
  }

  void add_geometry(const Element& geometry, const Affine& map, const Element* instance) {
    const Element* mesh = geometry.FirstChildElement("mesh");
    if (!mesh) return;  // a spline
    for (const Element* e = mesh->FirstChildElement(); e; e = e->NextSiblingElement()) {
      visit();
      const std::string_view kind = e->Name();
      if (kind == "triangles" || kind == "polylist" || kind == "polygons") add_faces(*e, map, instance);
    }
  }

  struct Source {
    std::shared_ptr<const std::vector<float>> values;
    std::size_t stride = 3, offset = 0;
    std::size_t width = 3;  ///< numbers that are used of each entry
    bool there = false;
    std::array<float, 3> at(std::size_t i) const {
      return {(*values)[i * stride], (*values)[i * stride + 1], (*values)[i * stride + 2]};
    }
    /// v counts from the lower edge of the image.
    std::array<float, 2> texcoord(std::size_t i) const {
      return {(*values)[i * stride], 1 - (*values)[i * stride + 1]};
    }
    std::size_t size() const { return stride < width ? 0 : (values->size() + stride - width) / stride; }
  };
  struct Sources {
    const Source &positions, &normals, &texcoords;
  };

  Source source(const std::string& id, std::size_t offset, std::size_t width = 3) {
    const Element* e = find(id);
    if (!e) refuse("there is no source '" + id + "'");
    Source out;
    auto& values = floats_[e];  // many faces share one
    if (!values)
      values =
          std::make_shared<const std::vector<float>>(numbers<float>(e->FirstChildElement("float_array")));
    out.values = values;
    out.offset = offset;
    out.there = true;
    out.width = out.stride = width;
    const Element* common = e->FirstChildElement("technique_common");
    const Element* accessor = common ? common->FirstChildElement("accessor") : nullptr;
    if (accessor) out.stride = accessor->UnsignedAttribute("stride", static_cast<unsigned>(width));
    return out;
  }

  void add_faces(const Element& faces, const Affine& map, const Element* instance) {
    Source positions, normals, texcoords;
    std::size_t stride = 1;
    for (const Element* e = faces.FirstChildElement("input"); e; e = e->NextSiblingElement("input")) {
      const std::string kind = attribute(e, "semantic");
      const std::size_t offset = e->UnsignedAttribute("offset", 0);
      if (offset > 64) refuse("an input has the offset " + std::to_string(offset));
      stride = std::max(stride, offset + 1);
      if (kind == "NORMAL") normals = source(link(e, "source"), offset);
      if (kind == "TEXCOORD" && !texcoords.there && find_ && find(link(e, "source")))
        texcoords = source(link(e, "source"), offset, 2);
      if (kind != "VERTEX") continue;
      const Element* vertices = find(link(e, "source"));
      for (const Element* in = vertices ? vertices->FirstChildElement("input") : nullptr; in;
           in = in->NextSiblingElement("input")) {
        if (attribute(in, "semantic") == "POSITION") positions = source(link(in, "source"), offset);
        if (attribute(in, "semantic") == "NORMAL") normals = source(link(in, "source"), offset);
      }
    }
    if (!positions.there)
      refuse("faces in line " + std::to_string(faces.GetLineNum()) + " have no positions");
    MeshPart part;
    paint(attribute(&faces, "material"), instance, part);
    if (!part.image) texcoords.there = false;
    const std::vector<std::size_t> counts = numbers<std::size_t>(faces.FirstChildElement("vcount"));
    const bool list = std::string_view(faces.Name()) == "polylist";
    for (const Element* p = faces.FirstChildElement("p"); p; p = p->NextSiblingElement("p")) {
      const std::vector<std::size_t> indices = numbers<std::size_t>(p);
      const std::size_t corners = indices.size() / stride;
      const bool polygon = std::string_view(faces.Name()) == "polygons";
      for (std::size_t from = 0, face = 0; from < corners; ++face) {
        const std::size_t count = list ? (face < counts.size() ? counts[face] : 0) : polygon ? corners : 3;
        if (count == 0 || count > corners - from) refuse("a face has too few corners");
        add_polygon(part, indices, from, count, stride, {positions, normals, texcoords}, map);
        from += count;
      }
    }
    // A mirroring map turns faces inside out.
    if (determinant(map) < 0)
      for (std::size_t i = 0; i + 2 < part.triangles.size(); i += 3)
        std::swap(part.triangles[i], part.triangles[i + 1]);
    mesh_.push_back(std::move(part));
  }

  void add_polygon(MeshPart& part, const std::vector<std::size_t>& indices, std::size_t from,
                   std::size_t count, std::size_t stride, const Sources& from_file, const Affine& map) {
    const auto& [positions, normals, texcoords] = from_file;
    const auto first = static_cast<std::uint32_t>(part.positions.size());
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = indices[(from + i) * stride + positions.offset];
      if (at >= positions.size()) refuse("a face has the corner " + std::to_string(at));
      const auto p = positions.at(at);
      std::array<float, 3> placed;
      for (std::size_t r = 0; r < 3; ++r)
        placed[r] = static_cast<float>(map[r][0] * p[0] + map[r][1] * p[1] + map[r][2] * p[2] + map[r][3]);
      part.positions.push_back(placed);
      if (normals.there && uniform(map)) {
        const std::size_t n = indices[(from + i) * stride + normals.offset];
        if (n >= normals.size()) refuse("a face has the normal " + std::to_string(n));
        part.normals.push_back(turned(normals.at(n), map));
      }
      if (texcoords.there) {
        const std::size_t t = indices[(from + i) * stride + texcoords.offset];
        if (t < texcoords.size()) part.texcoords.push_back(texcoords.texcoord(t));  // else it has no image
      }
    }
    for (std::uint32_t i = 2; i < count; ++i)
      part.triangles.insert(part.triangles.end(), {first, first + i - 1, first + i});
    if ((triangles_ += count) > 2 * kMostTriangles) refuse("it has too many triangles");
  }

  /// Normals rotate like positions if all axes have the same scale; else they are computed again.
  static bool uniform(const Affine& m) {
    double n[3];
    for (std::size_t c = 0; c < 3; ++c)
      n[c] = std::sqrt(m[0][c] * m[0][c] + m[1][c] * m[1][c] + m[2][c] * m[2][c]);
    const double cube = n[0] * n[1] * n[2];
    return n[0] > 0 && std::abs(n[1] - n[0]) < 1e-3 * n[0] && std::abs(n[2] - n[0]) < 1e-3 * n[0] &&
           std::abs(determinant(m)) > 0.99 * cube;
  }
  static std::array<float, 3> turned(const std::array<float, 3>& v, const Affine& m) {
    double out[3], length = 0;
    for (std::size_t r = 0; r < 3; ++r) {
      out[r] = m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2];
      length += out[r] * out[r];
    }
    length = length > 0 ? std::sqrt(length) : 1;
    return {static_cast<float>(out[0] / length), static_cast<float>(out[1] / length),
            static_cast<float>(out[2] / length)};
  }

  /// The diffuse colour or image of the material that the instance binds to the symbol of the faces.
  void paint(const std::string& symbol, const Element* instance, MeshPart& part) {
    std::string target = symbol;
    const Element* bind = instance ? instance->FirstChildElement("bind_material") : nullptr;
    const Element* common = bind ? bind->FirstChildElement("technique_common") : nullptr;
    for (const Element* e = common ? common->FirstChildElement("instance_material") : nullptr; e;
         e = e->NextSiblingElement("instance_material"), visit())
      if (attribute(e, "symbol") == symbol) target = link(e, "target");
    const Element* material = find(target);
    const Element* effect =
        material ? find(link(material->FirstChildElement("instance_effect"), "url")) : nullptr;
    const Element* profile = effect ? effect->FirstChildElement("profile_COMMON") : nullptr;
    const Element* technique = profile ? profile->FirstChildElement("technique") : nullptr;
    const Element* shading = technique ? technique->FirstChildElement() : nullptr;
    while (shading && !shading->FirstChildElement("diffuse")) shading = shading->NextSiblingElement();
    const Element* diffuse = shading ? shading->FirstChildElement("diffuse") : nullptr;
    if (const Element* texture = diffuse ? diffuse->FirstChildElement("texture") : nullptr;
        texture && find_) {
      part.image = image(attribute(texture, "texture"), *profile);
      if (part.image) {
        part.color = {1, 1, 1, 1};
        part.colored = true;
      }
    }
    const Element* value = diffuse ? diffuse->FirstChildElement("color") : nullptr;
    if (!value) return;
    const std::vector<float> c = numbers<float>(value, 4);
    for (std::size_t k = 0; k < 4 && k < c.size(); ++k)
      if (std::isfinite(c[k])) part.color[k] = c[k];
    part.colored = c.size() >= 3;
  }

  /// The parameter of the profile with this sid.
  const Element* parameter(const Element& profile, const std::string& sid) {
    for (const Element* e = profile.FirstChildElement("newparam"); e;
         e = e->NextSiblingElement("newparam"), visit())
      if (attribute(e, "sid") == sid) return e;
    return nullptr;
  }
  static std::string text_of(const Element* e, const char* child) {
    const Element* inner = e ? e->FirstChildElement(child) : nullptr;
    return inner && inner->GetText() ? std::string(trim(inner->GetText())) : std::string();
  }

  /// Collada 1.4.1: texture → sampler2D → surface → image; some exporters name the image at once.
  Image image(std::string id, const Element& profile) {
    if (const Element* sampler = parameter(profile, id))
      id = text_of(sampler->FirstChildElement("sampler2D"), "source");
    if (const Element* surface = parameter(profile, id))
      id = text_of(surface->FirstChildElement("surface"), "init_from");
    const std::string file = text_of(find(id), "init_from");
    return file.empty() ? Image() : find_(file);
  }

  const std::string& name_;
  const FindImage& find_;
  tinyxml2::XMLDocument document_;
  const Element* root_ = nullptr;
  std::map<std::string, const Element*> by_id_;
  std::map<const Element*, std::shared_ptr<const std::vector<float>>> floats_;
  Mesh mesh_;
  std::size_t triangles_ = 0, nodes_ = 0, numbers_ = 0, visits_ = 0;
};

}  // namespace

Mesh read_collada(const std::string& text, const std::string& name, const FindImage& find) {
  return ColladaReader(text, name, find).read();
}

}  // namespace polyarm::meshes
