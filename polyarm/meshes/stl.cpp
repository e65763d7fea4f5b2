#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "polyarm/base/error.hpp"
#include "polyarm/meshes/mesh.hpp"

namespace polyarm::meshes {

namespace {

constexpr std::size_t kHead = 84, kFacet = 50;

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw Error("bad-mesh", "the mesh " + name + " is not a whole STL: " + what, "export it again");
}

Mesh binary(const std::string& bytes, const std::string& name, std::size_t count) {
  if (count > kMostTriangles)
    throw Error("large-mesh", "the mesh " + name + " has " + std::to_string(count) + " triangles",
                "simplify it: at most " + std::to_string(kMostTriangles) + " are shown");
  MeshPart part;
  part.positions.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<float, 3> p;
      std::memcpy(p.data(), bytes.data() + kHead + kFacet * i + 12 * (k + 1), 12);
      part.triangles.push_back(static_cast<std::uint32_t>(part.positions.size()));
      part.positions.push_back(p);
    }
  return {std::move(part)};
}

/// The words of the text in order.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}
  std::string_view next() {
    const auto begin = text_.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return {};
    const auto end = std::min(text_.find_first_of(" \t\r\n", begin), text_.size());
    const std::string_view out = text_.substr(begin, end - begin);
    text_.remove_prefix(end);
    return out;
  }

 private:
  std::string_view text_;
};

Mesh ascii(const std::string& text, const std::string& name) {
  MeshPart part;
  Words words(text);
  for (std::string_view word; !(word = words.next()).empty();) {
    if (word != "vertex" && word != "VERTEX") continue;
    std::array<float, 3> p;
    for (float& c : p) {
      const std::string_view number = words.next();
      const auto [end, wrong] = std::from_chars(number.data(), number.data() + number.size(), c);
      if (wrong != std::errc() || end != number.data() + number.size() || !std::isfinite(c))
        refuse(name, "'" + std::string(number.substr(0, 40)) + "' is not a coordinate");
    }
    part.triangles.push_back(static_cast<std::uint32_t>(part.positions.size()));
    part.positions.push_back(p);
    if (part.positions.size() > 3 * kMostTriangles) refuse(name, "it has too many triangles");
  }
  if (part.positions.empty() || part.positions.size() % 3 != 0)
    refuse(name, "it has " + std::to_string(part.positions.size()) + " corners");
  return {std::move(part)};
}

}  // namespace

Mesh read_stl(const std::string& bytes, const std::string& name) {
  std::uint32_t count = 0;
  if (bytes.size() >= kHead) std::memcpy(&count, bytes.data() + kHead - 4, 4);
  const std::size_t whole = kHead + kFacet * std::size_t{count};
  // Binary files may also begin with "solid".
  if (bytes.size() >= kHead && bytes.size() == whole) return binary(bytes, name, count);
  const bool text = bytes.starts_with("solid") && bytes.find("facet") != std::string::npos;
  if (text) return ascii(bytes, name);
  if (bytes.size() < kHead) refuse(name, "it has " + std::to_string(bytes.size()) + " bytes");
  if (bytes.size() < whole)
    refuse(name, "its header states " + std::to_string(count) + " triangles, but the file has room for " +
                     std::to_string((bytes.size() - kHead) / kFacet));
  return binary(bytes, name, count);
}

}  // namespace polyarm::meshes
