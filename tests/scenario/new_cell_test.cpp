/// `polyarm new cell`: what it writes runs as it is.
#include <gtest/gtest.h>

#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

using test::Finished;
using test::run_command;

class NewCell : public ::testing::TestWithParam<const char*> {};

TEST_P(NewCell, ChecksRunsAndPassesItsTest) {
  const test::Folder folder;
  const std::string cell = (folder.path() / "mine").string();
  const Finished made = run_command({"new", "cell", "mine", "--robot", GetParam(), "--folder", cell});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  for (const char* file : {"README.md", "cell.yaml", "scene.yaml", "tool.yaml", "signals.yaml",
                           "points.points", "main.script", "tests.script"})
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "mine" / file)) << file;
  const Finished checked = run_command({"check", cell});
  EXPECT_EQ(checked.exit_code, 0) << checked.output;
  EXPECT_NE(checked.output.find("0 errors, 0 warnings"), std::string::npos) << checked.output;
  EXPECT_EQ(run_command({"check", cell, "--dry"}).exit_code, 0);
  const Finished planned = run_command({"plan", cell, "movej", "PrePick", "movel", "Pick"});
  EXPECT_EQ(planned.exit_code, 0) << "its program loads the points itself: " << planned.output;
  const Finished run = run_command({"run", cell, "--fast", "--quiet"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  const Finished tested = run_command({"test", cell});
  EXPECT_EQ(tested.exit_code, 0) << tested.output;
}

INSTANTIATE_TEST_SUITE_P(
    Robots, NewCell,
    ::testing::Values("universal_robots/ur3e", "universal_robots/ur10e", "fanuc/lr_mate_200id", "abb/irb_120",
                      // With four and five axes.
                      "denso/hsr065a1_n32", "fanuc/lr_mate_200ic_5f", "trossen_robotics/rx200",
                      "the_robot_studio/so_101",
                      // Its first axis stands beside the origin, and its joints leave little room.
                      "robotis/open_manipulator_x",
                      // Its tool is low at home, where a table would be.
                      "kuka/lbr_iiwa_7_r800"));

TEST(NewCellCommand, AnArmThatCannotTakePartsFromAboveMovesItsJoints) {
  const test::Folder folder;
  const std::string cell = (folder.path() / "mine").string();
  const Finished made = run_command({"new", "cell", "mine", "--robot", "kinova/m1n4s200", "--folder", cell});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  EXPECT_NE(made.output.find("no place was found where the tool of this robot points straight down"),
            std::string::npos)
      << made.output;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "mine/scene.yaml"))
      << "no rest of a layout that failed";
  EXPECT_EQ(run_command({"check", cell, "--dry"}).exit_code, 0);
  EXPECT_EQ(run_command({"run", cell, "--fast", "--quiet"}).exit_code, 0);
  EXPECT_EQ(run_command({"test", cell}).exit_code, 0);
}

/// The description of r6bot, with a mesh.
std::string arm_with_mesh(const std::string& mesh) {
  std::string text = read_file(POLYARM_SOURCE_DIR "/examples/r6bot/r6bot.urdf");
  const std::string link = "<link name=\"base_link\">";
  text.insert(text.find(link) + link.size(),
              "<visual><geometry><mesh filename='" + mesh + "'/></geometry></visual>");
  return text;
}

TEST(NewCellCommand, CopiesADescriptionOfTheUser) {
  const test::Folder folder;
  std::string triangle(84 + 50, '\0');
  triangle[80] = 1;
  folder.write("elsewhere/looks/base.stl", triangle);
  const std::string urdf = folder.write("elsewhere/my arm.urdf", arm_with_mesh("looks/base.stl"));
  folder.write(
      "elsewhere/my arm.srdf",
      "<robot name='r6bot'><group name='all'><joint name='joint_1'/></group>"
      "<group_state name='aside' group='all'><joint name='joint_1' value='0.5'/></group_state></robot>");
  const auto cell = folder.path() / "mine";
  const Finished made = run_command({"new", "cell", "mine", "--robot", urdf, "--folder", cell.string()});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  EXPECT_NE(made.output.find("robot/my_arm.urdf is a copy of " + urdf), std::string::npos) << made.output;
  const std::string copy = read_file(cell / "robot/my_arm.urdf");
  EXPECT_NE(copy.find("filename='meshes/base.stl'"), std::string::npos) << copy;
  EXPECT_NE(copy.find("<!-- r6bot"), std::string::npos) << "the text is that of the user";
  EXPECT_EQ(read_file(cell / "robot/meshes/base.stl"), triangle);
  std::filesystem::remove_all(folder.path() / "elsewhere");
  const Finished checked = run_command({"check", cell.string()});
  EXPECT_EQ(checked.exit_code, 0) << checked.output;
  EXPECT_EQ(run_command({"run", cell.string(), "--fast", "--quiet"}).exit_code, 0);
  EXPECT_NE(run_command({"describe", (cell / "robot/my_arm.urdf").string(), "--json"}).output.find("aside"),
            std::string::npos);
}

TEST(NewCellCommand, MeshesWithOneNameStayDifferentFiles) {
  const test::Folder folder;
  std::string triangle(84 + 50, '\0');
  triangle[80] = 1;
  folder.write("elsewhere/looks/base.stl", triangle);
  folder.write("elsewhere/meshes/base.stl", "another" + triangle.substr(7));
  std::string text = arm_with_mesh("looks/base.stl");
  const std::string end = "</visual>";
  text.insert(text.find(end) + end.size(),
              "<visual><geometry><mesh filename='meshes/base.stl'/></geometry></visual>");
  const std::string urdf = folder.write("elsewhere/arm.urdf", text);
  const auto cell = folder.path() / "mine";
  const Finished made = run_command({"new", "cell", "mine", "--robot", urdf, "--folder", cell.string()});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const std::string copy = read_file(cell / "robot/arm.urdf");
  EXPECT_NE(copy.find("<!-- r6bot"), std::string::npos) << "the text is that of the user";
  EXPECT_NE(copy.find("filename='meshes/base.stl'"), std::string::npos) << copy;
  EXPECT_NE(copy.find("filename='meshes/base_2.stl'"), std::string::npos) << copy;
  EXPECT_EQ(read_file(cell / "robot/meshes/base.stl"), triangle);
}

TEST(NewCellCommand, CopiesWhatAnXacroExpandsTo) {
  const test::Folder folder;
  std::string text = arm_with_mesh("/nowhere.stl");
  text.replace(text.find("<robot"), std::string("<robot").size(),
               "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'");
  text.insert(text.find("<link"), "<xacro:property name='unused' value='1'/>");
  const std::string xacro = folder.write("elsewhere/arm.urdf.xacro", text);
  const auto cell = folder.path() / "mine";
  const Finished made = run_command({"new", "cell", "mine", "--robot", xacro, "--folder", cell.string()});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  EXPECT_EQ(read_file(cell / "robot/arm.urdf").find("xacro:property"), std::string::npos);
  EXPECT_EQ(run_command({"run", cell.string(), "--fast", "--quiet"}).exit_code, 0);
}

TEST(NewCellCommand, WritesOverNothing) {
  const test::Folder folder;
  folder.write("mine/mine.txt", "kept");
  const Finished refused = run_command(
      {"new", "cell", "mine", "--robot", "demo/r6bot", "--folder", (folder.path() / "mine").string()});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.output.find("exists already"), std::string::npos) << refused.output;
  EXPECT_EQ(read_file(folder.path() / "mine" / "mine.txt"), "kept");
}

TEST(NewCellCommand, SaysTheNearestRobot) {
  const test::Folder folder;
  const Finished refused = run_command(
      {"new", "cell", "mine", "--robot", "fanuc/lr_mat", "--folder", (folder.path() / "mine").string()});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.output.find("did you mean 'fanuc/lr_mate_"), std::string::npos) << refused.output;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "mine"));
}

TEST(NewCellCommand, TakesNoNameWithControlCharacters) {
  const test::Folder folder;
  for (const char* name : {"a\nb", "a\x1b[2J", "a\tb", "a\x7f"}) {
    const Finished refused = run_command({"new", "cell", name, "--folder", (folder.path() / "mine").string()});
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_NE(refused.output.find("cannot be the name of a cell"), std::string::npos) << refused.output;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "mine"));
  }
}

}  // namespace
}  // namespace polyarm
