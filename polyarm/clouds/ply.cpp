/// Stanford's PLY: a header in text, then elements in text or bytes. Only the coordinates of "vertex" are
/// read.
#include <optional>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/clouds/cloud_file.hpp"
#include "polyarm/clouds/text_points.hpp"

namespace polyarm::clouds {

namespace {

constexpr std::size_t kMostProperties = bounds::kCloudFields, kMostHeaderLines = bounds::kCloudHeaderLines;

struct Property {
  std::string name;
  NumberType type = NumberType::f32;
  bool is_list = false;
};
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};
enum class Format { ascii, little, big };
struct Header {
  std::optional<Format> format;
  std::vector<Element> elements;
};

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw Error("bad-cloud", "the point cloud " + name + " is not a whole PLY: " + what, "write it again");
}

std::optional<NumberType> type_of(std::string_view word) {
  if (word == "char" || word == "int8") return NumberType::i8;
  if (word == "uchar" || word == "uint8") return NumberType::u8;
  if (word == "short" || word == "int16") return NumberType::i16;
  if (word == "ushort" || word == "uint16") return NumberType::u16;
  if (word == "int" || word == "int32") return NumberType::i32;
  if (word == "uint" || word == "uint32") return NumberType::u32;
  if (word == "float" || word == "float32") return NumberType::f32;
  if (word == "double" || word == "float64") return NumberType::f64;
  return std::nullopt;
}

void read_header_line(std::string_view line, const std::string& name, Header& out) {
  const std::string_view key = next_word(line);
  if (key.empty() || key == "comment" || key == "obj_info") return;
  if (key == "format") {
    const std::string_view format = next_word(line);
    if (format == "ascii") out.format = Format::ascii;
    if (format == "binary_little_endian") out.format = Format::little;
    if (format == "binary_big_endian") out.format = Format::big;
    if (!out.format) refuse(name, in_quotes(format) + " is no format");
    return;
  }
  if (key == "element") {
    Element element;
    element.name = next_word(line);
    if (!read_count(next_word(line), element.count))
      refuse(name, "the number of " + in_quotes(element.name) + " is missing");
    out.elements.push_back(std::move(element));
    return;
  }
  if (key != "property") refuse(name, in_quotes(key) + " is no word of a header");
  if (out.elements.empty()) refuse(name, "a property comes before the first element");
  std::vector<Property>& properties = out.elements.back().properties;
  if (properties.size() >= kMostProperties)
    refuse(name, "an element has more than " + std::to_string(kMostProperties) + " properties");
  Property property;
  std::string_view type = next_word(line);
  if (type == "list") {
    property.is_list = true;
    next_word(line);
    type = next_word(line);
  }
  const std::optional<NumberType> known = type_of(type);
  if (!known) refuse(name, in_quotes(type) + " is no type");
  property.type = *known;
  property.name = next_word(line);
  properties.push_back(std::move(property));
}

Header read_header(std::string_view& text, const std::string& name) {
  if (next_line(text) != "ply") refuse(name, "it does not begin with 'ply'");
  Header out;
  for (std::size_t i = 0; i < kMostHeaderLines && !text.empty(); ++i) {
    const std::string_view line = next_line(text);
    if (line != "end_header") {
      read_header_line(line, name, out);
      continue;
    }
    if (!out.format) refuse(name, "the header states no format");
    return out;
  }
  refuse(name, "its header does not end");
}

void read_ascii(std::string_view text, const Element& vertex, const std::size_t (&index)[3],
                const std::string& name, double scale, CloudGrid& grid) {
  const std::size_t width = vertex.properties.size();
  for (std::size_t i = 0; i < vertex.count; ++i) {
    double p[3] = {0, 0, 0};
    for (std::size_t k = 0; k < width; ++k) {
      const std::string_view word = next_word(text);
      if (word.empty())
        refuse(name, "it states " + std::to_string(vertex.count) + " points and has " + std::to_string(i));
      for (int axis = 0; axis < 3; ++axis)
        if (k == index[axis] && !read_number(word, p[axis]))
          refuse(name, in_quotes(word) + " is not a coordinate");
    }
    grid.add(scale * p[0], scale * p[1], scale * p[2]);
  }
}

}  // namespace

void read_ply(std::string_view bytes, const std::string& name, double scale, CloudGrid& grid) {
  std::string_view text = bytes;
  const Header header = read_header(text, name);
  std::size_t before = 0;
  for (const Element& element : header.elements) {
    std::size_t size = 0;
    bool has_list = false;
    for (const Property& property : element.properties)
      size += size_of(property.type), has_list |= property.is_list;
    if (element.name != "vertex") {
      const bool skips = *header.format != Format::ascii && !has_list &&
                         (size == 0 || element.count <= (text.size() - before) / size);
      if (!skips && element.count > 0) refuse(name, "other things come before its points");
      before += size * element.count;
      continue;
    }
    if (has_list) refuse(name, "its points have lists");
    if (element.count > kMostPoints)
      throw Error("large-cloud",
                  "the point cloud " + name + " has " + std::to_string(element.count) + " points",
                  "thin it out: at most " + std::to_string(kMostPoints) + " are read");
    PointLayout layout;
    layout.points = element.count;
    layout.big_endian = *header.format == Format::big;
    std::size_t index[3] = {};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const char wanted[2] = {"xyz"[axis], 0};
      std::size_t offset = before, k = 0;
      while (k < element.properties.size() && element.properties[k].name != wanted)
        offset += size_of(element.properties[k++].type);
      if (k == element.properties.size()) refuse(name, std::string("its points have no ") + wanted);
      index[axis] = k;
      layout.coordinate[axis] = {offset, size, element.properties[k].type};
    }
    if (*header.format == Format::ascii) return read_ascii(text, element, index, name, scale, grid);
    return add_points(text, layout, scale, grid);
  }
  refuse(name, "it has no element 'vertex'");
}

}  // namespace polyarm::clouds
