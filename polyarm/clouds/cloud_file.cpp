#include "polyarm/clouds/cloud_file.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <memory>
#include <system_error>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::clouds {

namespace fs = std::filesystem;

namespace {

template <typename T>
double value_at(const char* from, bool swap) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), from, sizeof(T));
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return static_cast<double>(std::bit_cast<T>(bytes));
}

double number_at(const char* from, NumberType type, bool swap) {
  switch (type) {
    case NumberType::i8:
      return value_at<std::int8_t>(from, swap);
    case NumberType::u8:
      return value_at<std::uint8_t>(from, swap);
    case NumberType::i16:
      return value_at<std::int16_t>(from, swap);
    case NumberType::u16:
      return value_at<std::uint16_t>(from, swap);
    case NumberType::i32:
      return value_at<std::int32_t>(from, swap);
    case NumberType::u32:
      return value_at<std::uint32_t>(from, swap);
    case NumberType::f64:
      return value_at<double>(from, swap);
    case NumberType::f32:
      break;
  }
  return value_at<float>(from, swap);
}

/// The usual layout: little-endian floats.
void add_floats(const char* bytes, const PointLayout& layout, double scale, CloudGrid& grid) {
  const auto& [x, y, z] = layout.coordinate;
  const char *at_x = bytes + x.offset, *at_y = bytes + y.offset, *at_z = bytes + z.offset;
  for (std::size_t i = 0; i < layout.points; ++i) {
    grid.add(scale * value_at<float>(at_x, false), scale * value_at<float>(at_y, false),
             scale * value_at<float>(at_z, false));
    at_x += x.step, at_y += y.step, at_z += z.step;
  }
}

}  // namespace

std::size_t size_of(NumberType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

void add_points(std::string_view bytes, const PointLayout& layout, double scale, CloudGrid& grid) {
  if (layout.points == 0) return;
  if (layout.points > kMostPoints)
    throw Error("large-cloud",
                "the cloud has " + std::to_string(layout.points) + " points, " + std::to_string(kMostPoints) +
                    " are the most",
                "thin it out");
  for (const PointLayout::Coordinate& c : layout.coordinate) {
    const std::size_t size = size_of(c.type);
    const bool fits =
        c.offset <= bytes.size() && size <= bytes.size() - c.offset &&
        (layout.points == 1 || c.step <= (bytes.size() - c.offset - size) / (layout.points - 1));
    if (!fits)
      throw Error("bad-cloud",
                  "the cloud states " + std::to_string(layout.points) + " points, and has " +
                      std::to_string(bytes.size()) + " bytes, which are too few",
                  "write it again");
  }
  constexpr bool kSwaps = std::endian::native == std::endian::big;
  const bool swap = layout.big_endian != kSwaps;
  const auto& [x, y, z] = layout.coordinate;
  if (!swap && x.type == NumberType::f32 && y.type == NumberType::f32 && z.type == NumberType::f32)
    return add_floats(bytes.data(), layout, scale, grid);
  for (std::size_t i = 0; i < layout.points; ++i) {
    double p[3];
    for (int k = 0; k < 3; ++k) {
      const PointLayout::Coordinate& c = layout.coordinate[k];
      p[k] = scale * number_at(bytes.data() + c.offset + i * c.step, c.type, swap);
    }
    grid.add(p[0], p[1], p[2]);
  }
}

Cloud read_cloud(const fs::path& path, const CloudOptions& options) {
  const std::string name = path.string(), extension = lower(path.extension().string());
  if (extension != ".ply" && extension != ".pcd" && extension != ".cdr")
    throw Error("unknown-cloud", "point clouds are not read from files such as " + name,
                "write it as PLY or PCD");
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file || !fs::is_regular_file(path, error))
    throw Error("no-cloud", "the point cloud " + name + " cannot be read", "check its path and rights");
  if (size > kMostBytes)
    throw Error("large-cloud", "the point cloud " + name + " has " + std::to_string(size) + " bytes",
                "thin it out: at most " + std::to_string(kMostBytes) + " are read");
  const auto memory = std::make_unique_for_overwrite<char[]>(static_cast<std::size_t>(size));
  file.read(memory.get(), static_cast<std::streamsize>(size));
  const std::string_view bytes(memory.get(),
                               static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  CloudGrid grid(options.cell > 0 ? options.cell : options.radius);
  if (extension == ".ply")
    read_ply(bytes, name, options.scale, grid);
  else if (extension == ".pcd")
    read_pcd(bytes, name, options.scale, grid);
  else
    read_point_cloud2(bytes, name, options.scale, grid);
  if (grid.points() == 0)
    throw Error("bad-cloud", "the point cloud " + name + " has no point with finite coordinates",
                "write it again");
  return grid.boxes(options.radius);
}

}  // namespace polyarm::clouds
