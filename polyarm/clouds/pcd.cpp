/// PCD of the Point Cloud Library, version 0.7: a header in text, then text, bytes, or bytes compressed by
/// LZF.
#include <algorithm>
#include <optional>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/clouds/cloud_file.hpp"
#include "polyarm/clouds/text_points.hpp"

namespace polyarm::clouds {

namespace {

constexpr std::size_t kMostFields = bounds::kCloudFields, kMostHeaderLines = 200,
                      kMostElements = bounds::kCloudElements;

struct Field {
  std::string name;
  std::size_t size = 4, count = 1;
  char type = 'F';
};
struct Header {
  std::vector<Field> fields;
  std::size_t points = 0, width = 0, height = 1;
  bool has_points = false;
  std::string data;
};

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw Error("bad-cloud", "the point cloud " + name + " is not a whole PCD: " + what, "write it again");
}

std::optional<NumberType> type_of(const Field& field) {
  const auto of = [&](NumberType one, NumberType two, NumberType four) -> std::optional<NumberType> {
    return field.size == 1   ? std::optional(one)
           : field.size == 2 ? std::optional(two)
           : field.size == 4 ? std::optional(four)
                             : std::nullopt;
  };
  if (field.type == 'F' && field.size == 4) return NumberType::f32;
  if (field.type == 'F' && field.size == 8) return NumberType::f64;
  if (field.type == 'I') return of(NumberType::i8, NumberType::i16, NumberType::i32);
  if (field.type == 'U') return of(NumberType::u8, NumberType::u16, NumberType::u32);
  return std::nullopt;
}

/// One word for each field.
template <typename Take>
void each_field(std::string_view line, const std::string& name, Header& out, const Take& take) {
  for (Field& field : out.fields) {
    const std::string_view word = next_word(line);
    if (word.empty() || !take(word, field))
      refuse(name, "its header has no number for the field " + in_quotes(field.name));
  }
}

/// True at the last line.
bool read_header_line(std::string_view line, const std::string& name, Header& out) {
  const std::string_view key = next_word(line);
  const auto count = [&](std::size_t& to) {
    if (!read_count(next_word(line), to)) refuse(name, in_quotes(key) + " has no number");
  };
  if (key == "FIELDS") {
    out.fields.clear();
    for (std::string_view word; !(word = next_word(line)).empty();) {
      if (out.fields.size() >= kMostFields)
        refuse(name, "it has more than " + std::to_string(kMostFields) + " fields");
      out.fields.push_back({std::string(word), 4, 1, 'F'});
    }
  } else if (key == "SIZE") {
    each_field(line, name, out,
               [](std::string_view word, Field& f) { return read_count(word, f.size) && f.size <= 8; });
  } else if (key == "COUNT") {
    each_field(line, name, out, [](std::string_view word, Field& f) {
      return read_count(word, f.count) && f.count <= kMostElements;
    });
  } else if (key == "TYPE") {
    each_field(line, name, out, [](std::string_view word, Field& f) { return f.type = word.front(), true; });
  } else if (key == "WIDTH") {
    count(out.width);
  } else if (key == "HEIGHT") {
    count(out.height);
  } else if (key == "POINTS") {
    count(out.points);
    out.has_points = true;
  } else if (key == "DATA") {
    out.data = next_word(line);
    return true;
  }
  return false;  // VERSION, VIEWPOINT, comments
}

Header read_header(std::string_view& text, const std::string& name) {
  Header out;
  for (std::size_t i = 0; i < kMostHeaderLines && !text.empty(); ++i)
    if (read_header_line(next_line(text), name, out)) {
      if (!out.has_points) {
        if (out.width > kMostPoints || out.height > kMostPoints)
          out.points = kMostPoints + 1;
        else
          out.points = out.width * out.height;
      }
      return out;
    }
  refuse(name, "it has no line DATA");
}

void read_ascii(std::string_view text, const Header& header, const std::size_t (&index)[3],
                const std::string& name, double scale, CloudGrid& grid) {
  for (std::size_t i = 0; i < header.points; ++i) {
    double p[3] = {0, 0, 0};
    for (std::size_t k = 0; k < header.fields.size(); ++k)
      for (std::size_t element = 0; element < header.fields[k].count; ++element) {
        const std::string_view word = next_word(text);
        if (word.empty())
          refuse(name, "it states " + std::to_string(header.points) + " points and has " + std::to_string(i));
        if (element > 0) continue;
        for (int axis = 0; axis < 3; ++axis)
          if (k == index[axis] && !read_number(word, p[axis]))
            refuse(name, in_quotes(word) + " is not a coordinate");
      }
    grid.add(scale * p[0], scale * p[1], scale * p[2]);
  }
}

std::uint32_t u32_at(std::string_view bytes, std::size_t offset) {
  std::uint32_t out = 0;
  for (std::size_t i = 0; i < 4; ++i)
    out |= std::uint32_t{static_cast<unsigned char>(bytes[offset + i])} << (8 * i);
  return out;
}

/// LZF: runs of bytes, and references to what was written before. False if the input is damaged.
bool expand(std::string_view in, std::string& out, std::size_t size) {
  out.clear();
  out.reserve(size);
  std::size_t i = 0;
  const auto byte = [&] { return std::size_t{static_cast<unsigned char>(in[i++])}; };
  while (i < in.size()) {
    const std::size_t control = byte();
    if (control < 32) {
      const std::size_t run = control + 1;
      if (run > in.size() - i || run > size - out.size()) return false;
      out.append(in.substr(i, run));
      i += run;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (i >= in.size()) return false;
      length += byte();
    }
    if (i >= in.size()) return false;
    const std::size_t back = ((control & 31) << 8) + byte() + 1;
    length += 2;
    if (back > out.size() || length > size - out.size()) return false;
    for (std::size_t from = out.size() - back; length > 0; --length) out.push_back(out[from++]);
  }
  return out.size() == size;
}

}  // namespace

void read_pcd(std::string_view bytes, const std::string& name, double scale, CloudGrid& grid) {
  std::string_view text = bytes;
  const Header header = read_header(text, name);
  if (header.points > kMostPoints)
    throw Error("large-cloud",
                "the point cloud " + name + " has more than " + std::to_string(kMostPoints) + " points",
                "thin it out");
  const bool compressed = header.data == "binary_compressed";
  std::size_t index[3] = {}, row = 0;
  for (const Field& field : header.fields) row += field.size * field.count;
  PointLayout layout;
  layout.points = header.points;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const char wanted[2] = {"xyz"[axis], 0};
    std::size_t offset = 0, k = 0;
    for (; k < header.fields.size() && header.fields[k].name != wanted; ++k)
      offset += header.fields[k].size * header.fields[k].count * (compressed ? header.points : 1);
    if (k == header.fields.size()) refuse(name, std::string("it has no field ") + wanted);
    const std::optional<NumberType> type = type_of(header.fields[k]);
    if (!type) refuse(name, "the type of its field " + in_quotes(wanted) + " is unknown");
    index[axis] = k;
    layout.coordinate[axis] = {offset, compressed ? header.fields[k].size * header.fields[k].count : row,
                               *type};
  }
  if (header.data == "ascii") return read_ascii(text, header, index, name, scale, grid);
  if (header.data == "binary") return add_points(text, layout, scale, grid);
  if (!compressed) refuse(name, in_quotes(header.data) + " is no kind of data");
  if (text.size() < 8) refuse(name, "its data is missing");
  const std::size_t packed = u32_at(text, 0), size = u32_at(text, 4);
  std::string expanded;
  if (packed > text.size() - 8 || size > kMostBytes || !expand(text.substr(8, packed), expanded, size))
    refuse(name, "its compressed data is damaged");
  add_points(expanded, layout, scale, grid);
}

}  // namespace polyarm::clouds
