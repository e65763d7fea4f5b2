/// Files of samples: what is read, what is refused with its line, and bytes of any kind.
#include "polyarm/calibration/samples.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

namespace polyarm::calibration {
namespace {

const std::string kYaml =
    "polyarm: samples/1\n"
    "samples:\n"
    "  - flange: [0.1, 0.2, 0.3, 0, 0, 1.5707963267948966]\n"
    "    marker: {xyz: [1, 2, 3], quaternion: [0, 0, 0, 1]}\n"
    "    point: [4, 5, 6]\n"
    "    q: {one: 0.5, two: -0.5}\n";
const std::string kCsv =
    "# a comment\n"
    "flange.x, flange.y, flange.z, flange.roll, flange.pitch, flange.yaw, q.one, q.two, point.x, point.y, "
    "point.z\n"
    "0.1, 0.2, 0.3, 0, 0, 1.5707963267948966, 0.5, -0.5, 4, 5, 6\n";

std::string problem(const std::string& text, const std::string& file = "s.csv") {
  try {
    read_samples(text, file);
  } catch (const Error& e) {
    return e.what();
  }
  return "(no problem)";
}

TEST(Samples, AreReadFromYamlAndCsv) {
  for (const auto& [text, file] : {std::pair{kYaml, "s.yaml"}, std::pair{kCsv, "s.csv"}}) {
    const std::vector<Sample> all = read_samples(text, file);
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].pose("flange").position, (Vec3{0.1, 0.2, 0.3}));
    EXPECT_LT(angle_between(all[0].pose("flange").rotation, from_rpy(0, 0, 1.5707963267948966)), 1e-12);
    EXPECT_EQ(all[0].vector("point"), (Vec3{4, 5, 6}));
    EXPECT_EQ(all[0].values("q", {"two", "one"}), (std::vector<double>{-0.5, 0.5}));
    EXPECT_EQ(all[0].where.line, 3);
  }
}

TEST(Samples, AreReadBackAsTheyWereWritten) {
  const std::vector<Sample> all = read_samples(kYaml, "s.yaml"),
                            again = read_samples(samples_text(all), "t.yaml");
  ASSERT_EQ(again.size(), 1u);
  EXPECT_LT(norm(again[0].pose("marker").position - all[0].pose("marker").position), 1e-15);
  EXPECT_LT(angle_between(again[0].pose("flange").rotation, all[0].pose("flange").rotation), 1e-7);
  EXPECT_EQ(again[0].vectors, all[0].vectors);
  EXPECT_EQ(again[0].joints, all[0].joints);
}

TEST(Samples, WrongOnesAreNamedWithTheirLine) {
  EXPECT_NE(problem("point.x, point.y, point.z\n1, 2, 3\n1, x, 3\n").find("s.csv:3"), std::string::npos);
  EXPECT_NE(problem("point.x, point.y, point.z\n1, 2\n").find("2 values under 3 columns"), std::string::npos);
  EXPECT_NE(problem("point.x, point.y\n1, 2\n").find("not complete"), std::string::npos);
  EXPECT_NE(problem("pint.x\n1\n").find("not a column"), std::string::npos);
  EXPECT_NE(problem("point.x, point.y, point.z\n1, 2, nan\n").find("not a"), std::string::npos);
  EXPECT_NE(problem("point.x, point.y, point.z\n1, 2, 1e300\n").find("not a possible"), std::string::npos);
  EXPECT_NE(problem("flange.x,flange.y,flange.z,flange.qx,flange.qy,flange.qz,flange.qw\n0,0,0,0,0,0,0\n")
                .find("length 1"),
            std::string::npos);
  EXPECT_NE(problem("samples: []\n", "s.yaml").find("polyarm: samples/1"), std::string::npos);
  for (const char* name : {"point", "known"})
    EXPECT_NE(
        problem(fmt::format("{0}.x, {0}.y, {0}.z\n1, 2, 3\n1, -410, 3\n", name))
            .find(fmt::format("s.csv:3: error: '{}' lies 410 m away (this looks like millimetres", name)),
        std::string::npos);
  EXPECT_EQ(problem("force.x, force.y, force.z\n1, 410, 3\n"), "(no problem)");
  const std::string angles = "flange.x,flange.y,flange.z,flange.roll,flange.pitch,flange.yaw\n";
  EXPECT_NE(problem(angles + "410,0,0,0,0,0\n").find("looks like millimetres"), std::string::npos);
  EXPECT_NE(problem(angles + "0.4,0,0,180,0,0\n").find("looks like degrees"), std::string::npos);
  EXPECT_NE(problem("polyarm: samples/1\nsamples:\n  - {point: [0, 410, 0]}\n", "s.yaml").find("millimetres"),
            std::string::npos);
  EXPECT_NE(problem("polyarm: samples/1\nsamples:\n  - {flnge: [0, 0, 0]}\n", "s.yaml").find("s.yaml:3"),
            std::string::npos);
  EXPECT_NE(problem("polyarm: samples/1\nsamples:\n  - {point: [0, 1, 0], point: [0, 1, 1]}\n", "s.yaml")
                .find("'point' is defined twice"),
            std::string::npos);
  const Sample one = read_samples(kYaml, "s.yaml").front();
  EXPECT_THROW(one.pose("measured"), Error);
  EXPECT_THROW(one.values("q", {"one", "three"}), Error);
  EXPECT_THROW(one.values("q", {"one"}), Error);
}

TEST(Samples, MoreThanTheirBoundAreRefused) {
  std::string text = "point.x, point.y, point.z\n";
  for (std::size_t k = 0; k <= kMostSamples; ++k) text += "1,2,3\n";
  EXPECT_NE(problem(text).find("more than"), std::string::npos);
}

TEST(Samples, AnyBytesAreReadOrRefused) {
  std::mt19937 draw(11);
  const std::string bytes = "0123456789.,-e:[]{}#\n \tqxyzflange\xff";
  for (int k = 0; k < 3000; ++k)
    for (const std::string& from : {kYaml, kCsv}) {
      const bool yaml = from == kYaml;
      std::string text = from;
      for (int i = 0; i < 4; ++i) {
        const std::size_t at = draw() % text.size();
        if (draw() % 3 == 0)
          text.erase(at, 1 + draw() % 8);
        else
          text.insert(at, 1, bytes[draw() % bytes.size()]);
        if (text.empty()) text = "x";
      }
      try {
        for (const Sample& each : read_samples(text, yaml ? "s.yaml" : "s.csv"))
          for (const auto& [name, v] : each.vectors) EXPECT_LE(std::abs(v.x), 1e6);
      } catch (const Error&) {
      }
    }
}

}  // namespace
}  // namespace polyarm::calibration
