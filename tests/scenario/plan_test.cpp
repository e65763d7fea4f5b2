// `polyarm plan`: what it prints and writes, and how it refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/command.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Files of one test, gone at its end.
class Plan : public testing::Test {
 protected:
  Plan() {
    std::string pattern = (fs::temp_directory_path() / "polyarm_plan_XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
  }
  ~Plan() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(file(name)) << text;
    return file(name);
  }
  std::string read(const std::string& name) const {
    std::stringstream out;
    out << std::ifstream(file(name)).rdbuf();
    return out.str();
  }
  static std::string last_line(std::string text) {
    while (text.ends_with('\n')) text.pop_back();
    return text.substr(text.rfind('\n') + 1);
  }
  static test::Finished plan(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "plan");
    return test::run_command(arguments);
  }
  /// On a UR5e.
  static test::Finished ur(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--robot", "universal_robots/ur5e"});
    return plan(arguments);
  }
  static bool says(const test::Finished& run, const std::string& text) {
    return run.output.find(text) != std::string::npos;
  }

  /// Three points, the third as far as `reach` of the elbow.
  std::string way(double reach = 1.2) const {
    std::ostringstream text;
    text
        << "joint_names: [elbow_joint, shoulder_pan_joint, shoulder_lift_joint, wrist_1_joint, "
           "wrist_2_joint, wrist_3_joint]\npoints:\n"
        << "- {positions: [1.5, 0, -1.5, -1.5, -1.5, 0], time_from_start: 0}\n"
        << "- {positions: [1.3, 0.5, -1.2, -1.6, -1.5, 0.3], time_from_start: {sec: 0, nanosec: 400000000}}\n"
        << "- {positions: [" << reach
        << ", 1, -1.4, -1.7, -1.4, 0], time_from_start: {secs: 0, nsecs: 800000000}}\n";
    return write("way.yaml", text.str());
  }

  fs::path folder_;
};

TEST_F(Plan, AFileIsPlannedWithinLimitsAndSaysWhatBoundsIt) {
  const auto run = ur({way(), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const json out = run.result();
  EXPECT_EQ(out["result"], "ok");
  ASSERT_EQ(out["joints"].size(), 6u);
  double nearest = 0;
  for (const json& joint : out["joints"])
    for (const char* quantity : {"velocity", "acceleration", "jerk"}) {
      EXPECT_LE(joint[quantity]["share"].get<double>(), 1 + 1e-5) << joint;
      nearest = std::max(nearest, joint[quantity]["share"].get<double>());
    }
  EXPECT_GT(nearest, 0.95) << "nothing bounds it";
  // Bounds without gaps, from begin to end.
  double at = 0;
  for (const json& band : out["sections"][0]["bounded_by"]) {
    EXPECT_NEAR(band["from"].get<double>(), at, 1e-9);
    at = band["to"];
  }
  EXPECT_NEAR(at, out["duration"].get<double>(), 1e-9);
}

TEST_F(Plan, WhatItExportsKeepsTheLimitsWithItsTimes) {
  const std::string yaml = file("out.yaml"), ros1 = file("out.json");
  const auto run = ur({way(), "--export", yaml, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  ASSERT_EQ(ur({way(), "--export", ros1, "--rate", "500", "--ros1"}).exit_code, 0);
  EXPECT_NE(read("out.json").find("\"nsecs\""), std::string::npos);
  for (const std::string& name : {yaml, ros1}) {
    const auto again = ur({name, "--keep-times", "--json"});
    const json out = again.result();
    EXPECT_NEAR(out["duration"].get<double>(), run.result()["duration"].get<double>(), 1e-6);
    for (const json& joint : out["joints"]) EXPECT_LE(joint["velocity"]["share"].get<double>(), 1.01);
  }
  EXPECT_EQ(ur({yaml, "--keep-times"}).exit_code, 0);
}

TEST_F(Plan, TimesThatAreTooShortAreToldByJointLimitAndPlace) {
  const std::string points =
      "joint_names: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint, wrist_2_joint, "
      "wrist_3_joint]\npoints:\n"
      "- {positions: [0, -1.5, 1.5, 0, 0, 0], velocities: [0, 0, 0, 0, 0, 0], accelerations: [0, 0, 0, 0, 0, "
      "0], time_from_start: 0}\n"
      "- {positions: [0, -1.5, 0.5, 0, 0, 0], velocities: [0, 0, 0, 0, 0, 0], accelerations: [0, 0, 0, 0, 0, "
      "0], time_from_start: 0.2}\n";
  const auto run = ur({write("fast.yaml", points), "--keep-times"});
  EXPECT_EQ(run.exit_code, 1);
  // A quintic over 1 rad in 0.2 s: 15/8 of the mean speed, in the middle.
  EXPECT_TRUE(says(run, "elbow_joint would have a velocity of 9.375 rad/s between points 1 and 2 (0.100 s)"))
      << run.output;
  EXPECT_TRUE(says(run, "times the time"));
  const auto jumps = ur({way(), "--keep-times"});
  EXPECT_EQ(jumps.exit_code, 1);
  EXPECT_TRUE(says(jumps, "jumps by")) << jumps.output;
}

TEST_F(Plan, SpeedsAndBlendsOfAFile) {
  const auto slow = ur({way(), "--blend", "20mm", "--speed", "100mm/s", "--json"});
  ASSERT_EQ(slow.exit_code, 0) << slow.output;
  EXPECT_LE(slow.result()["tcp_speed"].get<double>(), 0.1 * (1 + 1e-5));
  EXPECT_EQ(slow.result()["sections"].size(), 1u);
  const auto stops = ur({way(), "--lines", "--json"});
  EXPECT_EQ(stops.result()["sections"].size(), 2u) << "without a blend it rests at the point";
  const auto shrunk = ur({way(), "--blend", "10m"});
  EXPECT_TRUE(says(shrunk, "warning")) << shrunk.output;
  const double whole = ur({way(), "--json"}).result()["duration"];
  const double half = ur({way(), "--speed", "10%", "--json"}).result()["duration"];
  EXPECT_GT(half, 2 * whole);
}

TEST_F(Plan, MovesOnTheCommandLine) {
  const std::vector<std::string> moves{"movej",           "joints(0,-90deg,90deg,-90deg,-90deg,0)",
                                       "movel",           "by(0,0,-150mm)",
                                       "movel",           "tool(100mm,0,0)",
                                       "blend=0",         "movec",
                                       "by(50mm,50mm,0)", "by(50mm,-50mm,0)"};
  std::vector<std::string> arguments = moves;
  for (const char* more : {"--blend", "20mm", "--speed", "250mm/s", "--json"}) arguments.push_back(more);
  const auto run = ur(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const json out = run.result();
  EXPECT_LE(out["tcp_speed"].get<double>(), 0.25 * (1 + 1e-5));
  EXPECT_EQ(out["sections"].size(), 2u) << "it stops where the blend is 0";
}

TEST_F(Plan, PointsOfACell) {
  const std::string cell = POLYARM_SOURCE_DIR "/examples/pick_and_place";
  const auto run = plan({cell, "movel", "Pick", "movel", "Place", "--blend", "20mm", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_GT(run.result()["duration"].get<double>(), 0.1);
  const auto wrong = plan({cell, "movel", "Plac"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_TRUE(says(wrong, "did you mean 'Place'")) << wrong.output;
}

TEST_F(Plan, PointsInFramesAreWhereTheirFramesPutThem) {
  const std::string points = write(
      "framed.points",
      "Pose: RPY\nName: table\nPoint: 0.4, 0.1, 0.2, 0, 0, 0.5\nName: P\nPoint: 0.1, 0, 0.1, 3, 0, 0; frame "
      "= \"table\"\nName: B\nPoint: 0.4, 0.1, 0.3, 3, 0, 0; frame = \"base\"\nName: T\nPoint: 0, 0, 0.1, "
      "0, 0, 0; frame = \"arm/tcp\"\n");
  const auto to = [&](const std::string& point) {
    return ur({"movej", point, "--data", points, "--csv", file("way.csv")});
  };
  const auto framed = to("P");
  ASSERT_EQ(framed.exit_code, 0) << framed.output;
  std::vector<double> last;
  std::istringstream line(last_line(read("way.csv")));
  for (std::string value; std::getline(line, value, ',');) last.push_back(std::stod(value));
  ASSERT_GT(last.size(), 4u);
  EXPECT_NEAR(last[last.size() - 4], 0.4 + 0.1 * std::cos(0.5), 1e-5);
  EXPECT_NEAR(last[last.size() - 3], 0.1 + 0.1 * std::sin(0.5), 1e-5);
  EXPECT_NEAR(last[last.size() - 2], 0.3, 1e-5);
  EXPECT_EQ(to("B").exit_code, 0);
  EXPECT_TRUE(says(to("T"), "'T' is in the frame 'arm/tcp', whose place is not known here"));
}

TEST_F(Plan, StartsWhereItIsTold) {
  const std::string cell = POLYARM_SOURCE_DIR "/examples/pick_and_place";
  const auto duration = [&](const std::vector<std::string>& words) {
    const auto run = plan(words);
    EXPECT_EQ(run.exit_code, 0) << run.output;
    return run.exit_code == 0 ? run.result()["duration"].get<double>() : 0.0;
  };
  const double from_home = duration({cell, "movej", "Pick", "--json"});
  const double from_pick = duration({"--from", "Pick", cell, "movej", "Place", "--json"});
  EXPECT_NE(from_home, from_pick);
  EXPECT_EQ(from_pick, duration({cell, "movej", "Place", "--json", "--from", "Pick"}));
  const std::vector<std::string> numbers{"0", "-1.2", "1.2", "-1.57", "-1.57", "0.5"};
  std::vector<std::string> first{"--from"}, last{cell, "movej", "Place", "--json", "--from"};
  first.insert(first.end(), numbers.begin(), numbers.end());
  first.insert(first.end(), {cell, "movej", "Place", "--json"});
  last.insert(last.end(), numbers.begin(), numbers.end());
  EXPECT_EQ(duration(first), duration(last));
  EXPECT_EQ(duration(first), duration({"--from", "joints(0,-1.2rad,1.2rad,-1.57rad,-1.57rad,0.5rad)", cell,
                                       "movej", "Place", "--json"}));
  EXPECT_TRUE(says(plan({cell, "movej", "Place", "--from", "1", "2"}), "a place, or 6 numbers"));
  EXPECT_TRUE(says(plan({cell, "movej", "Place", "--from", "Plac"}), "did you mean 'Place'"));
}

TEST_F(Plan, AFileOfOnePointBeginsAtHome) {
  const std::string one = write("one.yaml",
                                "joint_names: [elbow_joint]\npoints:\n"
                                "- {positions: [1.3], time_from_start: 1}\n");
  const auto planned = ur({one, "--json"});
  EXPECT_EQ(planned.exit_code, 0) << planned.output;
  const auto by_name = ur({one, "--from", "home", "--json"});
  EXPECT_EQ(json::parse(last_line(planned.output))["duration"],
            json::parse(last_line(by_name.output))["duration"]);
}

TEST_F(Plan, PlotsAndTables) {
  const auto run = ur({way(), "--svg", file("a.svg"), "--csv", file("a.csv"), "--rate", "100", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::string svg = read("a.svg"), csv = read("a.csv");
  for (const char* text :
       {"<svg", "position", "velocity", "acceleration", "jerk", "TCP speed", "elbow_joint", "</svg>"})
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_LT(svg.size(), 200'000u);
  const auto lines = std::count(csv.begin(), csv.end(), '\n');
  EXPECT_EQ(lines, 2 + std::ceil(run.result()["duration"].get<double>() * 100));
  EXPECT_EQ(csv.substr(0, 5), "time,");
}

TEST_F(Plan, RefusalsSayWhichMoveWhyAndWhatToDo) {
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& text) {
    const auto run = ur(arguments);
    EXPECT_EQ(run.exit_code, 1) << run.output;
    EXPECT_TRUE(says(run, text)) << run.output;
  };
  refused({"movej", "home", "movel", "pose(5,0,0)"}, "move 2, movel pose(5,0,0)");
  refused({"movel"}, "has 0 targets");
  refused({"movec", "by(0,0,1mm)"}, "a point on the way and its end");
  refused({"movel", "by(0,0,200)"}, "a length needs a unit: write by(0,0,200mm)");
  refused({"movel", "pose(0.4,-250,0.3)"}, "a length needs a unit: write pose(0.4,-250mm,0.3)");
  refused({"movel", "by(0,0,50mm)", "blend=20"}, "a length needs a unit: write blend=20mm");
  refused({"movel", "pose(1,2)"}, "is not a target");
  refused({"movel", "by(0,0,1mm)", "sped=1"}, "did you mean 'speed'");
  refused({"movel", "by(0,0,1mm)", "--speed", "200%"}, "more than the limits");
  refused({"movej", "joints(1,2)"}, "2 values for 6 joints");
  refused({"jump", "home"}, "begins no move");
  refused({file("none.yaml")}, "none.yaml");
  refused(
      {write("bad.yaml", "joint_names: [elbow_joint]\npoints:\n- {positions: [x], time_from_start: 1}\n")},
      "bad.yaml:3:");
  refused(
      {write("other.yaml", "joint_names: [elbo_joint]\npoints:\n- {positions: [1], time_from_start: 1}\n")},
      "did you mean 'elbow_joint'");
  const auto failed = ur({"movel", "pose(5,0,0)", "--json"});
  EXPECT_EQ(failed.result()["result"], "failed");
}

TEST_F(Plan, ACommandLineWithoutARobotOrWithBareNumbersSaysWhatToWrite) {
  const auto refused = [&](const std::vector<std::string>& arguments, int code, const std::string& text) {
    const auto run = plan(arguments);
    EXPECT_EQ(run.exit_code, code) << run.output;
    EXPECT_TRUE(says(run, text)) << run.output;
  };
  refused({"movel", "home"}, 2,
          "no robot is named (begin with the folder of a cell, or with a robot such as");
  refused({"-1.57", "0"}, 2, "no robot is named");
  refused({"no_cell", "movel", "home"}, 2, "'no_cell' is neither a cell nor a robot");
  refused({"universal_robots/ur5", "movel", "hom"}, 1, "did you mean 'home'?");
  const std::string joints = "joint values are one word: movej 'joints(0, -90deg, …)'";
  refused({"universal_robots/ur5", "0", "-1", "0", "0", "0", "0"}, 1, joints);
  refused({"universal_robots/ur5", "movej", "0", "-1", "0", "0", "0", "0"}, 1, joints);
}

TEST_F(Plan, ARobotMayStandWhereACellStands) {
  const std::vector<std::string> move{"movej", "joints(0,-90deg,90deg,-90deg,-90deg,0)"};
  const auto run = plan({"universal_robots/ur5e", move[0], move[1]});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(run.output, ur(move).output);
}

}  // namespace
}  // namespace polyarm
