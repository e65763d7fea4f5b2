/// Point clouds: every format gives the same points, damaged files are refused, and boxes are true to the
/// points.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>

#include "polyarm/base/error.hpp"
#include "polyarm/clouds/cloud_file.hpp"

namespace polyarm::clouds {
namespace {

namespace fs = std::filesystem;
using Points = std::vector<std::array<float, 3>>;

/// A table, a wall behind it and a ball, as a camera sees them.
Points a_scene(std::size_t count, std::uint64_t seed = 1) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<float> even(-1, 1);
  std::normal_distribution<float> noise(0, 0.001f);
  Points out;
  for (std::size_t i = 0; i < count; ++i) {
    const float a = even(engine), b = even(engine);
    if (i % 3 == 0) {
      out.push_back({a, b, 0.4f + noise(engine)});
    } else if (i % 3 == 1) {
      out.push_back({1 + noise(engine), a, 1 + b});
    } else {
      const float angle = 3.1415927f * a, z = b, r = std::sqrt(1 - z * z);
      out.push_back({0.5f + 0.1f * r * std::cos(angle), 0.1f * r * std::sin(angle), 0.6f + 0.1f * z});
    }
  }
  return out;
}

std::string floats(const Points& points, std::size_t gap = 0) {
  std::string out;
  for (const auto& p : points) {
    out.append(reinterpret_cast<const char*>(p.data()), 12);
    out.append(gap, 'x');
  }
  return out;
}
std::string pcd_header(std::size_t points, const std::string& data, bool extra = false) {
  const std::string n = std::to_string(points);
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z" +
         std::string(extra ? " rgb" : "") + "\nSIZE 4 4 4" + (extra ? " 4" : "") + "\nTYPE F F F" +
         (extra ? " U" : "") + "\nCOUNT 1 1 1" + (extra ? " 1" : "") + "\nWIDTH " + n +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + n + "\nDATA " + data + "\n";
}
std::string lines(const Points& points) {
  std::ostringstream out;
  out.precision(9);
  for (const auto& p : points) out << p[0] << " " << p[1] << " " << p[2] << "\n";
  return out.str();
}
/// Literal runs only: what every LZF reader takes.
std::string compressed(const std::string& bytes) {
  std::string packed;
  for (std::size_t i = 0; i < bytes.size(); i += 32) {
    const std::string run = bytes.substr(i, 32);
    packed += static_cast<char>(run.size() - 1);
    packed += run;
  }
  std::string out;
  for (const std::size_t size : {packed.size(), bytes.size()})
    for (int i = 0; i < 4; ++i) out += static_cast<char>((size >> (8 * i)) & 255);
  return out + packed;
}
std::string in_columns(const Points& points) {
  std::string out;
  for (int k = 0; k < 3; ++k)
    for (const auto& p : points)
      out.append(reinterpret_cast<const char*>(&p[static_cast<std::size_t>(k)]), 4);
  return out;
}
/// As a recorder stores it: little-endian CDR.
std::string message(const Points& points, std::size_t gap = 4) {
  std::string out;
  const auto word = [&](std::size_t v) {
    while (out.size() % 4) out += '\0';
    for (int i = 0; i < 4; ++i) out += static_cast<char>((v >> (8 * i)) & 255);
  };
  const auto text = [&](const std::string& s) {
    word(s.size() + 1);
    out += s + '\0';
  };
  word(17), word(5), text("camera"), word(2), word(points.size() / 2), word(3);
  for (int i = 0; i < 3; ++i) {
    text(std::string(1, "xyz"[i]));
    word(std::size_t(4 * i));
    out += '\7';
    word(1);
  }
  out += '\0';
  const std::string data = floats(points, gap);
  word(12 + gap), word((12 + gap) * points.size() / 2), word(data.size());
  out += data;
  out += '\1';
  return std::string("\0\1\0\0", 4) + out;
}
std::string ply(const Points& points, const std::string& format) {
  const std::string header = "ply\nformat " + format + " 1.0\ncomment a camera\nelement vertex " +
                             std::to_string(points.size()) +
                             "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  if (format == "ascii") return header + lines(points);
  std::string bytes = floats(points);
  if (format == "binary_big_endian")
    for (std::size_t i = 0; i < bytes.size(); i += 4)
      std::reverse(bytes.begin() + long(i), bytes.begin() + long(i) + 4);
  return header + bytes;
}

Cloud of_points(const Points& points, double radius) {
  CloudGrid grid(radius);
  for (const auto& p : points) grid.add(p[0], p[1], p[2]);
  return grid.boxes(radius);
}
bool same(const Cloud& a, const Cloud& b) {
  return a.points == b.points && a.boxes.size() == b.boxes.size() &&
         std::equal(a.boxes.begin(), a.boxes.end(), b.boxes.begin(),
                    [](const CloudBox& x, const CloudBox& y) {
                      return norm(x.lower - y.lower) < 1e-6 && norm(x.upper - y.upper) < 1e-6;
                    });
}
template <typename Read>
Cloud read_with(Read read, const std::string& bytes) {
  CloudGrid grid(0.01);
  read(bytes, "a.file", 1, grid);
  return grid.boxes(0.01);
}
std::string error_of(const std::function<void()>& what) {
  try {
    what();
  } catch (const Error& e) {
    return e.problems().front().code + ": " + e.what();
  }
  return "no error";
}

TEST(Clouds, EveryFormatGivesTheSamePoints) {
  const Points points = a_scene(3000);
  const Cloud expected = of_points(points, 0.01);
  EXPECT_EQ(expected.points, 3000u);
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"})
    EXPECT_TRUE(same(read_with(read_ply, ply(points, format)), expected)) << format;
  EXPECT_TRUE(same(read_with(read_pcd, pcd_header(3000, "ascii") + lines(points)), expected));
  EXPECT_TRUE(same(read_with(read_pcd, pcd_header(3000, "binary") + floats(points)), expected));
  EXPECT_TRUE(same(read_with(read_pcd, pcd_header(3000, "binary", true) + floats(points, 4)), expected));
  EXPECT_TRUE(same(
      read_with(read_pcd, pcd_header(3000, "binary_compressed") + compressed(in_columns(points))), expected));
}

TEST(Clouds, AMessageIsReadAsAFileIs) {
  const Points points = a_scene(3000);
  EXPECT_TRUE(same(read_with(read_point_cloud2, message(points)), of_points(points, 0.01)));
  EXPECT_NE(
      error_of([&] { read_with(read_point_cloud2, message(points).substr(0, 900)); }).find("ends too early"),
      std::string::npos);
}

TEST(Clouds, ReferencesOfCompressedDataAreFollowed) {
  // Three equal points: one float per column, then eight bytes from four bytes before.
  std::string packed;
  for (const float value : {0.5f, 0.25f, 0.75f}) {
    packed += '\x03';
    packed.append(reinterpret_cast<const char*>(&value), 4);
    packed += '\xc0';  // length 6 + 2
    packed += '\x03';  // 3 + 1 back
  }
  std::string data(8, '\0');
  data[0] = static_cast<char>(packed.size());
  data[4] = 36;
  const Cloud cloud = read_with(read_pcd, pcd_header(3, "binary_compressed") + data + packed);
  ASSERT_EQ(cloud.boxes.size(), 1u);
  EXPECT_EQ(cloud.points, 3u);
  EXPECT_NEAR(cloud.boxes[0].lower.x, 0.49, 1e-6);
  EXPECT_NEAR(cloud.boxes[0].upper.z, 0.76, 1e-6);
}

TEST(Clouds, PointsWithoutAPlaceAreDroppedAndCounted) {
  CloudGrid grid(0.01);
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e300, 1001.0})
    grid.add(0, bad, 0), grid.add(bad, 0, 0);
  grid.add(0.1, 0.2, 0.3);
  const Cloud cloud = grid.boxes(0.005);
  EXPECT_EQ(cloud.dropped, 10u);
  EXPECT_EQ(cloud.points, 1u);
  ASSERT_EQ(cloud.boxes.size(), 1u);
  const Cloud text = read_with(read_pcd, pcd_header(3, "ascii") + "nan nan nan\n1 2 3\n1e999 0 0\n");
  EXPECT_EQ(text.dropped, 2u);
}

/// By brute force: each point with its ball is inside, and no place of a box is far from all points.
TEST(Clouds, BoxesContainThePointsAndLittleElse) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> even(-1, 1);
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const double radius = 0.004 * double(1 + seed);
    const Points points = a_scene(4000, seed);
    CloudGrid grid(radius);
    for (const auto& p : points) grid.add(p[0], p[1], p[2]);
    const Cloud cloud = grid.boxes(radius, seed % 2 ? 4000 : 60);
    EXPECT_LE(cloud.boxes.size(), seed % 2 ? 4000u : 60u);
    const auto inside = [&](const Vec3& p) {
      return std::any_of(cloud.boxes.begin(), cloud.boxes.end(), [&](const CloudBox& b) {
        constexpr double kRounding = 1e-9;
        return p.x >= b.lower.x - kRounding && p.x <= b.upper.x + kRounding && p.y >= b.lower.y - kRounding &&
               p.y <= b.upper.y + kRounding && p.z >= b.lower.z - kRounding && p.z <= b.upper.z + kRounding;
      });
    };
    for (const auto& p : points) {
      const Vec3 way{even(engine), even(engine), even(engine)};
      ASSERT_TRUE(inside(Vec3{p[0], p[1], p[2]} + (0.999 * radius / norm(way)) * way));
    }
    for (int i = 0; i < 500; ++i) {
      const CloudBox& b = cloud.boxes[engine() % cloud.boxes.size()];
      const auto between = [&](double low, double high) {
        return low + (even(engine) + 1) / 2 * (high - low);
      };
      const Vec3 place{between(b.lower.x, b.upper.x), between(b.lower.y, b.upper.y),
                       between(b.lower.z, b.upper.z)};
      double nearest = 1e9;
      for (const auto& p : points) nearest = std::min(nearest, norm(Vec3{p[0], p[1], p[2]} - place));
      ASSERT_LE(nearest, std::sqrt(3.0) * (cloud.cell + radius) + 1e-6);
    }
  }
}

TEST(Clouds, RefusalsSayWhatIsWrong) {
  const Points points = a_scene(30);
  EXPECT_NE(
      error_of([&] { read_with(read_pcd, pcd_header(31, "binary") + floats(points)); }).find("31 points"),
      std::string::npos);
  EXPECT_NE(error_of([&] { read_with(read_ply, "plx\n"); }).find("does not begin with 'ply'"),
            std::string::npos);
  EXPECT_NE(error_of([&] { read_with(read_pcd, pcd_header(99'999'999, "binary")); }).find("large-cloud"),
            std::string::npos);
  EXPECT_NE(error_of([&] { read_with(read_pcd, pcd_header(1, "ascii") + "1 two 3\n"); }).find("'two'"),
            std::string::npos);
  EXPECT_NE(error_of([&] {
              read_with(read_pcd, "FIELDS a b\nSIZE 4 4\nPOINTS 1\nDATA ascii\n");
            }).find("no field x"),
            std::string::npos);
  EXPECT_NE(error_of([&] { read_cloud("/nowhere/a.pcd", {}); }).find("no-cloud"), std::string::npos);
  EXPECT_NE(error_of([&] { read_cloud("/nowhere/a.txt", {}); }).find("unknown-cloud"), std::string::npos);
  EXPECT_NE(error_of([&] {
              read_with(
                  read_ply,
                  "ply\nformat binary_little_endian 1.0\nelement face 3\nproperty list uchar int v\n"
                  "element vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n");
            }).find("other things"),
            std::string::npos);
}

/// Damaged files give an Error or a cloud, and nothing else.
TEST(Clouds, DamagedFilesAreRefused) {
  const Points points = a_scene(40);
  using Reader = void (*)(std::string_view, const std::string&, double, CloudGrid&);
  const std::vector<std::pair<Reader, std::string>> files = {
      {read_ply, ply(points, "ascii")},
      {read_ply, ply(points, "binary_big_endian")},
      {read_point_cloud2, message(points)},
      {read_pcd, pcd_header(40, "ascii") + lines(points)},
      {read_pcd, pcd_header(40, "binary", true) + floats(points, 4)},
      {read_pcd, pcd_header(40, "binary_compressed") + compressed(in_columns(points))}};
  std::mt19937_64 engine(9);
  long refused = 0, read = 0;
  for (int i = 0; i < 20'000; ++i) {
    auto [reader, bytes] = files[engine() % files.size()];
    const std::size_t changes = 1 + engine() % 4;
    for (std::size_t k = 0; k < changes && !bytes.empty(); ++k) {
      const std::size_t at = engine() % bytes.size();
      switch (engine() % 4) {
        case 0:
          bytes[at] = static_cast<char>(engine());
          break;
        case 1:
          bytes.erase(at, engine() % 30);
          break;
        case 2:
          bytes.insert(at, bytes.substr(engine() % bytes.size(), engine() % 20));
          break;
        default:
          bytes.resize(at);
      }
    }
    try {
      read_with(reader, bytes);
      ++read;
    } catch (const Error& e) {
      ++refused;
      ASSERT_FALSE(e.problems().front().advice.empty());
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(read, 1000);
}

TEST(Clouds, AMillionPointsAreTaken) {
  const fs::path file = fs::temp_directory_path() / ("cloud_" + std::to_string(::getpid()) + ".pcd");
  {
    std::ofstream out(file, std::ios::binary);
    out << pcd_header(1'000'000, "binary", true) << floats(a_scene(1'000'000), 4);
  }
  double best = 1e9;
  Cloud cloud;
  for (int i = 0; i < 5; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    cloud = read_cloud(file, {0.01, 1, 0});
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  fs::remove(file);
  EXPECT_EQ(cloud.points, 1'000'000u);
  EXPECT_LE(cloud.boxes.size(), kMostBoxes);
  std::printf("10^6 points in %.1f ms: %zu boxes, cells of %.0f mm\n", 1e3 * best, cloud.boxes.size(),
              1e3 * cloud.cell);
}

}  // namespace
}  // namespace polyarm::clouds
