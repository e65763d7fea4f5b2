#pragma once
/// Reads point clouds: PLY and PCD files, and the bytes of a sensor_msgs/PointCloud2. Any thread.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/clouds/cloud_grid.hpp"

namespace polyarm::clouds {

enum class NumberType : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };
std::size_t size_of(NumberType type);

/// Where the coordinates of points are in bytes.
struct PointLayout {
  struct Coordinate {
    std::size_t offset = 0;  ///< of the first point
    std::size_t step = 0;    ///< from one point to the next
    NumberType type = NumberType::f32;
  };
  Coordinate coordinate[3];
  std::size_t points = 0;
  bool big_endian = false;
};

/// Adds the points, each multiplied by `scale`. Throws Error("bad-cloud") if the bytes are too short for
/// them.
void add_points(std::string_view bytes, const PointLayout& layout, double scale, CloudGrid& grid);

// The readers; `name` is for errors. They throw Error("bad-cloud" | "large-cloud"), and then say what to do.
void read_ply(std::string_view bytes, const std::string& name, double scale, CloudGrid& grid);
void read_pcd(std::string_view bytes, const std::string& name, double scale, CloudGrid& grid);
/// The CDR bytes of a sensor_msgs/PointCloud2.
void read_point_cloud2(std::string_view bytes, const std::string& name, double scale, CloudGrid& grid);

struct CloudOptions {
  double radius = 0.01;  ///< m around each point
  double scale = 1;      ///< m per unit of the file
  double cell = 0;       ///< m; 0: as large as the radius
};
/// Reads a .ply or .pcd file, or a .cdr file with a sensor_msgs/PointCloud2. Throws as the readers do, and
/// Error("no-cloud" | "unknown-cloud").
Cloud read_cloud(const std::filesystem::path& path, const CloudOptions& options);

}  // namespace polyarm::clouds
