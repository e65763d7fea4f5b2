#include "polyarm/description/tools.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/description/support.hpp"

namespace polyarm::description::tools_test {
namespace {

using test::has;

Tool read(const std::string& text) {
  return read_tool(Yaml::parse(text, "tool.yaml"), "mine");
}

double end_of(const Shape& shape) {
  return shape.pose.position.z + shape.length / 2;
}

TEST(Tools, ThatAreBuiltInCanAllBeFound) {
  for (const std::string& name : built_in_tools()) EXPECT_EQ(find_tool(name, ".").name, name);
}

TEST(Tools, NoneIsNothing) {
  const Tool tool = find_tool("none", ".");
  EXPECT_EQ(tool.tcp, Pose{});
  EXPECT_EQ(tool.mass, 0);
  EXPECT_TRUE(tool.body.empty());
  EXPECT_EQ(tool.gripper, GripperKind::none);
  EXPECT_EQ(find_tool("", ".").name, "none");
}

TEST(Tools, SuctionCupIsSlimAndEndsAboveItsLip) {
  const Tool tool = find_tool("suction_cup", ".");
  EXPECT_EQ(tool.gripper, GripperKind::suction);
  test::expect_near(tool.tcp.position, {0, 0, 0.10});
  EXPECT_NEAR(tool.mass, 0.15, 1e-12);
  EXPECT_GE(tool.cup_radius, 0.008);
  EXPECT_LE(tool.cup_radius, 0.010);
  double end = 0;
  for (const Shape& shape : tool.body) end = std::max(end, end_of(shape));
  EXPECT_NEAR(end, 0.096, 1e-9);
  EXPECT_LE(tool.body.back().radius, 0.0121);
}

TEST(Tools, ParallelGripperLeavesRoomForItsFingers) {
  const Tool tool = find_tool("parallel_gripper", ".");
  EXPECT_EQ(tool.gripper, GripperKind::parallel);
  test::expect_near(tool.tcp.position, {0, 0, 0.10});
  for (const Shape& shape : tool.body) EXPECT_LE(end_of(shape), 0.10 - tool.finger_length);
  EXPECT_GT(tool.stroke, 0);
  EXPECT_GT(tool.grip_force, 0);
}

TEST(Tools, AreReadFromFilesWithUnits) {
  const Tool tool = read(
      "polyarm: tool/1\n"
      "tcp: {xyz: [0, 0, 80mm], rpy: [0, 0, 90deg]}\n"
      "mass: 250g\n"
      "center: [0, 0, 3cm]\n"
      "gripper: parallel\n"
      "stroke: 60mm\n"
      "body:\n"
      "  - {cylinder: {radius: 2cm, height: 40mm}, at: [0, 0, 20mm]}\n"
      "  - {box: [10mm, 20mm, 30mm]}\n");
  EXPECT_EQ(tool.name, "mine");
  test::expect_near(tool.tcp.position, {0, 0, 0.08});
  test::expect_near(tool.tcp.rotation * Vec3{1, 0, 0}, {0, 1, 0});
  EXPECT_NEAR(tool.mass, 0.25, 1e-12);
  EXPECT_NEAR(tool.center.z, 0.03, 1e-12);
  EXPECT_NEAR(tool.stroke, 0.06, 1e-12);
  ASSERT_EQ(tool.body.size(), 2u);
  EXPECT_NEAR(tool.body[0].pose.position.z, 0.02, 1e-12);
  EXPECT_NEAR(tool.body[0].length, 0.04, 1e-12);
  test::expect_near(tool.body[1].size, {0.01, 0.02, 0.03});
}

TEST(Tools, ThatAreUnknownAreAnsweredWithTheNearestName) {
  try {
    find_tool("sucktion_cup", ".");
    FAIL() << "was found";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().at(0).code, "unknown-tool");
    EXPECT_TRUE(has(e.what(), "did you mean 'suction_cup'"));
  }
}

TEST(Tools, AFileBesideTheCellIsANameThatIsSuggested) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / ("polyarm-tools-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "welding_torch.yaml") << "mass: 1\n";
  try {
    find_tool("welding_toch", folder.string());
    FAIL() << "was found";
  } catch (const Error& e) {
    EXPECT_TRUE(has(e.what(), "did you mean 'welding_torch'"));
  }
}

struct Bad {
  const char* name;
  std::string text;
  int line;
  std::string piece;
};

void PrintTo(const Bad& bad, std::ostream* out) {
  *out << bad.name;
}

class BadTool : public ::testing::TestWithParam<Bad> {};

TEST_P(BadTool, IsRefusedWithLineAndReason) {
  try {
    read(GetParam().text);
    FAIL() << "was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().at(0).where.line, GetParam().line) << e.what();
    EXPECT_TRUE(has(e.what(), GetParam().piece));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadTool,
    ::testing::Values(Bad{"UnknownKey", "mass: 1\nstrok: 1\n", 2, "did you mean 'stroke'"},
                      Bad{"UnknownGripper", "mass: 1\n\ngripper: magnet\n", 3, "'magnet' is not a gripper"},
                      Bad{"NegativeMass", "mass: -1\n", 1, "above zero"},
                      Bad{"NoStroke", "mass: 1\nstroke: 0\n", 2, "above zero"},
                      Bad{"OtherKind", "polyarm: scene/1\n", 1, "tool/1 was expected"},
                      Bad{"WrongUnit", "mass: 3mm\n", 1, "3mm"},
                      Bad{"BodyWithoutShape", "body:\n  - {at: [0, 0, 1]}\n", 2, "no shape"},
                      Bad{"TwoShapes", "body:\n  - {box: [1, 1, 1], sphere: {radius: 1}}\n", 2,
                          "more than one shape"},
                      Bad{"FlatBox", "body:\n  - box: [1, 0, 1]\n", 2, "above zero"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace polyarm::description::tools_test
