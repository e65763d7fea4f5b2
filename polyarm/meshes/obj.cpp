#include <charconv>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/meshes/mesh.hpp"

namespace polyarm::meshes {

namespace {

using Color = std::array<float, 4>;

template <class T>
std::optional<T> number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  T out{};
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (wrong != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return out;
}

constexpr std::size_t kMostInLine = bounds::kObjLineBytes, kMostWords = bounds::kObjWords;

/// Calls `take` with the words of each line; a backslash at the end continues a line. Throws
/// Error("bad-mesh") for an unreasonably long line.
template <class Take>
void each_line(const std::string& text, const std::string& name, Take take) {
  std::vector<std::string> words;
  int line = 0;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    std::string_view part = trim(std::string_view(text).substr(from, end - from));
    from = end + 1;
    ++line;
    if (part.size() > kMostInLine || words.size() > kMostWords)
      throw Error("bad-mesh", "the mesh " + name + ":" + std::to_string(line) + ": the line is too long",
                  "export it again");
    const bool keeps_going = part.ends_with('\\');
    if (keeps_going) part.remove_suffix(1);
    for (std::string& word : split_words(part.substr(0, part.find('#')))) words.push_back(std::move(word));
    if (keeps_going) continue;
    if (!words.empty()) take(words, line);
    words.clear();
  }
}

struct Material {
  Color color{0.8f, 0.8f, 0.8f, 1};
  std::string image;  ///< empty: none
};

std::map<std::string, Material> materials_of(const std::string& materials, const std::string& name) {
  std::map<std::string, Material> out;
  Material* current = nullptr;
  each_line(materials, name, [&](const std::vector<std::string>& words, int) {
    if (words[0] == "newmtl" && words.size() > 1) current = &(out[words[1]] = {});
    if (!current || words.size() < 2) return;
    const auto first = number<float>(words[1]);
    if (words[0] == "Kd" && words.size() > 3)
      for (std::size_t k = 0; k < 3; ++k) current->color[k] = number<float>(words[k + 1]).value_or(0.8f);
    if (words[0] == "d" && first) current->color[3] = *first;
    if (words[0] == "Tr" && first) current->color[3] = 1 - *first;
    if (words[0] == "map_Kd") current->image = words.back();  // options stand before the name
  });
  return out;
}

class ObjReader {
 public:
  ObjReader(const std::string& name, std::map<std::string, Material> materials, const FindImage& find)
      : name_(name), materials_(std::move(materials)), find_(find) {}

  Mesh read(const std::string& text) {
    each_line(text, name_, [this](const std::vector<std::string>& words, int line) {
      line_ = line;
      if (words[0] == "v") add(positions_, words);
      if (words[0] == "vn") add(normals_, words);
      if (words[0] == "vt") add_texcoord(words);
      if (words[0] == "usemtl") material_ = words.size() > 1 ? words[1] : "";
      if (words[0] == "f") face(words);
    });
    Mesh out;
    for (auto& [material, part] : parts_) {
      // Normals are used only if every corner has one.
      if (part.normals.size() != part.positions.size()) part.normals.clear();
      if (const auto found = materials_.find(material); found != materials_.end()) paint(part, found->second);
      out.push_back(std::move(part));
    }
    return out;
  }

 private:
  void paint(MeshPart& part, const Material& material) const {
    part.color = material.color;
    part.colored = true;
    if (material.image.empty() || !find_ || part.texcoords.size() != part.positions.size()) return;
    part.image = find_(material.image);
    if (part.image) part.color = {1, 1, 1, material.color[3]};
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw Error("bad-mesh", "the mesh " + name_ + ":" + std::to_string(line_) + ": " + what,
                "export it again");
  }

  void add(std::vector<std::array<float, 3>>& to, const std::vector<std::string>& words) const {
    if (to.size() >= 3 * kMostTriangles) refuse("it has too many corners");
    to.push_back(triple(words));
  }

  /// v counts from the lower edge of the image.
  void add_texcoord(const std::vector<std::string>& words) {
    if (texcoords_.size() >= 3 * kMostTriangles) refuse("it has too many corners");
    const auto at = [&](std::size_t k) {
      return words.size() > k ? number<float>(words[k]).value_or(0.f) : 0.f;
    };
    texcoords_.push_back({at(1), 1 - at(2)});
  }

  std::array<float, 3> triple(const std::vector<std::string>& words) const {
    std::array<float, 3> out{};
    if (words.size() < 4) refuse("'" + words[0] + "' needs three numbers");
    for (std::size_t k = 0; k < 3; ++k) {
      const auto value = number<float>(words[k + 1]);
      if (!value) refuse("'" + words[k + 1].substr(0, 40) + "' is not a number");
      out[k] = *value;
    }
    return out;
  }

  /// Indices count from 1; negative ones count back from the newest. Nothing if there is no such entry.
  static std::optional<std::size_t> entry(std::string_view text, std::size_t count) {
    const auto given = number<std::int64_t>(text);
    const std::int64_t size = static_cast<std::int64_t>(count);
    const std::int64_t at = !given ? -1 : *given < 0 ? size + *given : *given - 1;
    if (at < 0 || at >= size) return std::nullopt;
    return static_cast<std::size_t>(at);
  }
  std::size_t index(std::string_view text, std::size_t count) const {
    const auto at = entry(text, count);
    if (!at)
      refuse("'" + std::string(text.substr(0, 40)) + "' is not one of its " + std::to_string(count) +
             " corners");
    return *at;
  }

  void face(const std::vector<std::string>& words) {
    if (words.size() < 4) return;  // a line or a point
    MeshPart& part = parts_[material_];
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const std::vector<std::string> fields = split_fields(words[i], '/');
      corners.push_back(static_cast<std::uint32_t>(part.positions.size()));
      part.positions.push_back(positions_[index(fields[0], positions_.size())]);
      // Without a place for each corner the part has no image.
      if (fields.size() > 1 && !fields[1].empty())
        if (const auto at = entry(fields[1], texcoords_.size())) part.texcoords.push_back(texcoords_[*at]);
      if (fields.size() > 2 && !fields[2].empty())
        part.normals.push_back(normals_[index(fields[2], normals_.size())]);
    }
    for (std::size_t i = 2; i < corners.size(); ++i)
      part.triangles.insert(part.triangles.end(), {corners[0], corners[i - 1], corners[i]});
    if ((triangles_ += corners.size() - 2) > kMostTriangles) refuse("it has too many triangles");
  }

  const std::string& name_;
  std::map<std::string, Material> materials_;
  const FindImage& find_;
  std::vector<std::array<float, 3>> positions_, normals_;
  std::vector<std::array<float, 2>> texcoords_;
  std::map<std::string, MeshPart> parts_;
  std::string material_;
  std::size_t triangles_ = 0;
  int line_ = 0;
};

}  // namespace

Mesh read_obj(const std::string& text, const std::string& name, const std::string& materials,
              const FindImage& find) {
  return ObjReader(name, materials_of(materials, name), find).read(text);
}

}  // namespace polyarm::meshes
