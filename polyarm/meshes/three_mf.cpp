/// 3MF: the Core Specification 1.3, base materials; colour groups of the Materials Extension; components in
/// other files of the archive (Production Extension).
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/meshes/affine.hpp"
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/meshes/tag_scanner.hpp"
#include "polyarm/meshes/zip_archive.hpp"

namespace polyarm::meshes {

namespace {

using Rgba = std::array<float, 4>;
constexpr int kDeepestObject = bounds::kThreeMfNesting;
constexpr std::size_t kMostObjects = bounds::kThreeMfObjects, kMostModels = bounds::kThreeMfModels,
                      kMostColors = bounds::kThreeMfColors;
constexpr std::size_t kMostFinishes = bounds::kThreeMfFinishes;  // of one object; further ones get no colour
constexpr std::size_t kMostColoredParts = bounds::kThreeMfParts;

/// "#RRGGBB" or "#RRGGBBAA"
std::optional<Rgba> color_of(std::string_view text) {
  if ((text.size() != 7 && text.size() != 9) || text[0] != '#') return std::nullopt;
  Rgba out{0, 0, 0, 1};
  for (std::size_t k = 0; 2 * k + 2 < text.size(); ++k) {
    unsigned value = 0;
    const char* begin = text.data() + 1 + 2 * k;
    const auto [end, wrong] = std::from_chars(begin, begin + 2, value, 16);
    if (wrong != std::errc() || end != begin + 2) return std::nullopt;
    out[k] = static_cast<float>(value) / 255;
  }
  return out;
}

/// A reference to an object. 3MF writes the map by columns.
struct Use {
  std::string file, object;
  Affine map = kIdentity;
};

/// A colour of a group.
struct Property {
  std::string group;
  std::size_t index = 0;
  auto operator<=>(const Property&) const = default;
};

struct Object {
  std::vector<std::array<float, 3>> corners;
  std::map<Property, std::vector<std::uint32_t>> triangles;
  std::vector<Use> components;
  Property property;
  bool shown = true;  ///< false: material that only supports others while they are printed
};

struct Model {
  double metres = 1e-3;
  std::map<std::string, Object> objects;
  std::map<std::string, std::vector<Rgba>> colors;
  std::vector<Use> items;
};

std::string without_slash(std::string_view path) {
  return std::string(path.starts_with('/') ? path.substr(1) : path);
}

/// Reads one model file of the archive.
class ModelReader {
 public:
  ModelReader(const std::string& text, const std::string& file, const std::string& name,
              std::size_t& triangles)
      : file_(file), tags_(text, name), triangles_(triangles) {}

  Model read() {
    bool is_model = false;
    while (tags_.next()) {
      if (!is_model && tags_.element() != "model") tags_.refuse("its root is not <model>");
      is_model = true;
      if (tags_.opens()) open();
      if (tags_.closes() && tags_.element() == "object") object_ = nullptr;
    }
    if (!is_model) tags_.refuse("it is empty");
    return std::move(out_);
  }

 private:
  void open() {
    const std::string_view kind = tags_.element();
    if (kind == "vertex") {
      vertex();
    } else if (kind == "triangle") {
      triangle();
    } else if (kind == "model") {
      out_.metres = metres();
    } else if (kind == "basematerials" || kind == "colorgroup") {
      if (out_.colors.size() >= kMostObjects) tags_.refuse("it has too many colours");
      group_ = &out_.colors[std::string(tags_.attribute("id"))];
    } else if ((kind == "base" || kind == "color") && group_) {
      if (++colors_ > kMostColors) tags_.refuse("it has too many colours");
      group_->push_back(color_of(tags_.attribute(kind == "base" ? "displaycolor" : "color"))
                            .value_or(Rgba{0.8f, 0.8f, 0.8f, 1}));
    } else if (kind == "object") {
      object();
    } else if (kind == "component" && object_) {
      object_->components.push_back(use());
    } else if (kind == "item") {
      out_.items.push_back(use());
    }
  }

  double metres() const {
    const std::string_view unit = tags_.attribute("unit");
    constexpr std::pair<std::string_view, double> kUnits[] = {{"micron", 1e-6},     {"millimeter", 1e-3},
                                                              {"centimeter", 1e-2}, {"inch", 0.0254},
                                                              {"foot", 0.3048},     {"meter", 1}};
    for (const auto& [name, metres] : kUnits)
      if (unit == name) return metres;
    if (!unit.empty()) tags_.refuse("its unit is not one of 3MF");
    return 1e-3;
  }

  void object() {
    if (out_.objects.size() >= kMostObjects) tags_.refuse("it has more than 20,000 objects");
    object_ = &out_.objects[std::string(tags_.attribute("id"))];
    *object_ = {};
    object_->property = {std::string(tags_.attribute("pid")), index("pindex", 0)};
    const std::string_view type = tags_.attribute("type");
    object_->shown = type != "support" && type != "solidsupport";
  }

  Use use() const {
    if (++uses_ > kMostObjects) tags_.refuse("it shows more than 20,000 objects");
    Use out;
    const std::string_view path = tags_.attribute("path");
    out.file = path.empty() ? file_ : without_slash(path);
    out.object = tags_.attribute("objectid");
    const std::string text(tags_.attribute("transform"));
    if (text.empty()) return out;
    const std::vector<std::string> words = split_words(text);
    if (words.size() != 12) tags_.refuse("a transform has not twelve numbers");
    for (std::size_t i = 0; i < 12; ++i) {
      const auto value = parse_number(words[i]);
      if (!value || !std::isfinite(*value)) tags_.refuse("a transform has not twelve numbers");
      out.map[i % 3][i / 3] = *value;
    }
    return out;
  }

  void vertex() {
    if (!object_) tags_.refuse("a corner belongs to no object");
    if (++corners_ > 3 * kMostTriangles) tags_.refuse("it has too many corners");
    object_->corners.push_back({static_cast<float>(tags_.number("x")), static_cast<float>(tags_.number("y")),
                                static_cast<float>(tags_.number("z"))});
  }

  void triangle() {
    if (!object_) tags_.refuse("a triangle belongs to no object");
    if (++triangles_ > kMostTriangles) tags_.refuse("it has too many triangles");
    const std::string_view group = tags_.attribute("pid");
    const Property own = group.empty()
                             ? Property{object_->property.group, index("p1", object_->property.index)}
                             : Property{std::string(group), index("p1", 0)};
    const bool is_new = !object_->triangles.contains(own) && object_->triangles.size() >= kMostFinishes;
    std::vector<std::uint32_t>& list = object_->triangles[is_new ? Property{} : own];
    for (const char* key : {"v1", "v2", "v3"}) {
      const std::size_t corner = index(key, object_->corners.size());
      if (corner >= object_->corners.size()) tags_.refuse("a triangle has a corner that is not there");
      list.push_back(static_cast<std::uint32_t>(corner));
    }
  }

  std::size_t index(std::string_view key, std::size_t fallback) const {
    const double value = tags_.number(key, static_cast<double>(fallback));
    if (value < 0 || value > 1e9) tags_.refuse("'" + std::string(key) + "' is not an index");
    return static_cast<std::size_t>(value);
  }

  const std::string file_;
  TagScanner tags_;
  Model out_;
  Object* object_ = nullptr;
  std::vector<Rgba>* group_ = nullptr;
  std::size_t& triangles_;
  std::size_t corners_ = 0, colors_ = 0;
  mutable std::size_t uses_ = 0;
};

class ThreeMfReader {
 public:
  ThreeMfReader(const std::string& bytes, const std::string& name)
      : name_(name), archive_(bytes, name, kLargestFile) {}

  Mesh read() {
    const std::string root = root_file();
    const Model& model = file(root);
    if (model.items.empty()) refuse("it builds nothing");
    for (const Use& item : model.items) add(item, kIdentity, model.metres, 0);
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    throw Error("bad-mesh", "the mesh " + name_ + " is not a whole 3MF: " + why, "export it again");
  }

  /// Open Packaging Conventions: the relationships name the first model.
  std::string root_file() {
    if (archive_.has("_rels/.rels")) {
      const std::string text = archive_.read("_rels/.rels");
      for (TagScanner tags(text, name_); tags.next();)
        if (tags.element() == "Relationship" && tags.attribute("Type").ends_with("/3dmodel"))
          return without_slash(tags.attribute("Target"));
    }
    return "3D/3dmodel.model";
  }

  const Model& file(const std::string& path) {
    const auto known = files_.find(path);
    if (known != files_.end()) return known->second;
    if (files_.size() >= kMostModels) refuse("it has more than 1,000 models");
    const std::string text = archive_.read(path);
    return files_[path] = ModelReader(text, path, name_ + "/" + path, read_triangles_).read();
  }

  /// `metres`: the unit of the first model holds for all.
  void add(const Use& use, const Affine& before, double metres, int depth) {
    if (depth > kDeepestObject) refuse("its objects are too deep in each other");
    if (++objects_ > kMostObjects) refuse("it shows more than 20,000 objects");
    const Model& model = file(use.file);
    const auto found = model.objects.find(use.object);
    if (found == model.objects.end()) refuse("there is no object '" + use.object.substr(0, 40) + "'");
    if (!found->second.shown) return;
    const Affine map = before * use.map;
    for (const auto& [property, triangles] : found->second.triangles)
      add_part(model, found->second, property, triangles, map, metres);
    for (const Use& component : found->second.components) add(component, map, metres, depth + 1);
  }

  void add_part(const Model& model, const Object& object, const Property& property,
                const std::vector<std::uint32_t>& triangles, const Affine& map, double metres) {
    if ((shown_triangles_ += triangles.size() / 3) > kMostTriangles) refuse("it has too many triangles");
    if (mesh_.size() >= kMostColoredParts) refuse("it has more than 10,000 parts of one colour");
    MeshPart part;
    const auto group = model.colors.find(property.group);
    if (group != model.colors.end() && property.index < group->second.size()) {
      part.color = group->second[property.index];
      part.colored = true;
    }
    for (const std::uint32_t corner : triangles) {
      const auto& p = object.corners[corner];
      std::array<float, 3> placed;
      for (std::size_t r = 0; r < 3; ++r)
        placed[r] =
            static_cast<float>(metres * (map[r][0] * p[0] + map[r][1] * p[1] + map[r][2] * p[2] + map[r][3]));
      part.triangles.push_back(static_cast<std::uint32_t>(part.positions.size()));
      part.positions.push_back(placed);
    }
    if (determinant(map) < 0)
      for (std::size_t i = 0; i + 2 < part.triangles.size(); i += 3)
        std::swap(part.triangles[i], part.triangles[i + 1]);
    mesh_.push_back(std::move(part));
  }

  const std::string& name_;
  ZipArchive archive_;
  std::map<std::string, Model> files_;
  Mesh mesh_;
  std::size_t read_triangles_ = 0, shown_triangles_ = 0, objects_ = 0;
};

}  // namespace

Mesh read_3mf(const std::string& bytes, const std::string& name) {
  return ThreeMfReader(bytes, name).read();
}

}  // namespace polyarm::meshes
