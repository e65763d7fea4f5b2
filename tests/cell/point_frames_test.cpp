#include <gtest/gtest.h>

#include <cmath>

#include "polyarm/base/text.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

constexpr const char* kUr3 = "{arm: {model: universal_robots/ur3, hardware: mock, tool: suction_cup}}";

/// A UR3 on the mock, with points and a program of the test's own.
class PointFrames : public testing::Test {
 protected:
  void run(const std::string& points, const std::string& program, const std::string& robots = kUr3) {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    folder.write("cell.yaml", "polyarm: cell/1\nrobots: " + robots + "\nprogram: main.script\n" +
                                  (plc.empty() ? "" : "plc: plc.script\n"));
    if (!plc.empty()) folder.write("plc.script", "load places\n" + plc);
    folder.write("places.points", points);
    folder.write("main.script", "load places\n" + program);
    cell::CellOptions options;
    options.lock_step = true;
    cell = std::make_unique<test::OpenCell>(cell::read_cell_file(folder.path() / "cell.yaml"),
                                            description::Catalogue({POLYARM_SOURCE_DIR "/robots"}), options,
                                            observer);
    cell->loop().begin();
    for (int k = 0; k < 20'000 && !cell->finished() && !cell->failure(); ++k) {
      const Nanoseconds until = cell->loop().cycle().time + cell::Cell::kTick;
      cell->tick(cell->loop().cycle().time);
      while (cell->loop().cycle().time < until) cell->loop().step_next();
    }
    cell->loop().end();
  }
  void expect_tcp(const Pose& wanted, std::size_t robot = 0) {
    ASSERT_FALSE(cell->failure()) << cell->failure()->problem.text();
    EXPECT_LT(norm(cell->tcp(robot).position - wanted.position), 1e-6);
    EXPECT_LT(angle_between(cell->tcp(robot).rotation, wanted.rotation), 1e-6);
  }

  struct Logs : cell::Observer {
    std::vector<std::string> lines;
    void on_log(Nanoseconds, const std::string&, const std::string& text) override { lines.push_back(text); }
  };

  test::Folder folder;
  std::string plc;  ///< empty: none
  Logs observer;
  std::unique_ptr<test::OpenCell> cell;
};

const Pose kTable = pose_xyz_rpy({0.25, 0.1, 0.05}, {0, 0, 0.5});
const Pose kOnTable = pose_xyz_rpy({0.05, 0.02, 0.1}, {3, 0, 0});
constexpr const char* kFramedPoints =
    "Pose: RPY\nName: table\nPoint: 0.25, 0.1, 0.05, 0, 0, 0.5\nName: corner\nPoint: 0.01, 0, 0, 0, 0, 0; "
    "frame = "
    "\"table\"\nName: p\nPoint: 0.05, 0.02, 0.1, 3, 0, 0; frame = \"table\"\nName: q\nPoint: 0.05, 0.02, "
    "0.1, 3, 0, 0; "
    "frame = \"corner\"\nName: up\nPoint: 0, 0, -0.03, 0, 0, 0; frame = \"arm/tcp\"\nName: lost\nPoint: 0, "
    "0, 0.1, 0, "
    "0, 0; frame = \"tabel\"\nName: a\nPoint: 0, 0, 0, 0, 0, 0; frame = \"b\"\nName: b\nPoint: 0, 0, 0, 0, "
    "0, 0; frame "
    "= \"a\"\n";

TEST_F(PointFrames, APoseIsMeantInTheFrameThatItNames) {
  run(kFramedPoints, "movej p\n");
  expect_tcp(kTable * kOnTable);
}

TEST_F(PointFrames, AFrameMayBeInAnotherAndAMovesOwnFrameDoesNotCount) {
  run(kFramedPoints, "use frame table\nmovej q\n");
  expect_tcp(kTable * Pose{{0.01, 0, 0}, {}} * kOnTable);
}

TEST_F(PointFrames, AFrameThatChangesTakesItsPointsAlong) {
  run(kFramedPoints, "set table = pose(300mm, 0, 50mm, 0, 0, 0)\nmovej p\n");
  expect_tcp(pose_xyz_rpy({0.3, 0, 0.05}, {0, 0, 0}) * kOnTable);
}

TEST_F(PointFrames, AFrameThatHangsOnTheRobotIsWhereItStands) {
  run(kFramedPoints, "moveto p\nmovel up\n");
  expect_tcp(kTable * kOnTable * Pose{{0, 0, -0.03}, {}});
}

TEST_F(PointFrames, AFrameOnARobotThatIsUnderWayIsRefused) {
  run(kFramedPoints, "movej p\nmovel up\n");
  ASSERT_TRUE(cell->failure());
  EXPECT_EQ(cell->failure()->problem.code, "frame-moves") << cell->failure()->problem.text();
}

TEST_F(PointFrames, AFrameThatThereIsNotIsToldWithTheNearestName) {
  run(kFramedPoints, "movej lost\n");
  ASSERT_TRUE(cell->failure());
  EXPECT_NE(cell->failure()->problem.text().find("did you mean 'table'"), std::string::npos)
      << cell->failure()->problem.text();
}

TEST_F(PointFrames, AFrameThatHangsOnItselfIsToldAndNothingHangs) {
  run(kFramedPoints, "movej a\n");
  ASSERT_TRUE(cell->failure());
  EXPECT_EQ(cell->failure()->problem.code, "frame-cycle");
  EXPECT_NE(cell->failure()->problem.text().find("in a circle: b in a in b"), std::string::npos)
      << cell->failure()->problem.text();
}

TEST_F(PointFrames, AFrameInACircleIsNotSet) {
  run(kFramedPoints, "movej p\n");
  test::LockStepCell open(cell::read_cell_file(folder.path() / "cell.yaml"),
                          std::vector<std::filesystem::path>{POLYARM_SOURCE_DIR "/robots"});
  const auto refused = [&](const std::string& name, const std::string& frame) {
    const test::Json answer = open.ask({{"request", "points.set"},
                                        {"name", name},
                                        {"value", "pose(0.3, 0, 0.05, 0, 0, 0)"},
                                        {"frame", frame}});
    return answer["ok"].get<bool>() ? std::string("set") : answer["error"]["what"].get<std::string>();
  };
  EXPECT_EQ(refused("table", "corner"), "frames depend on each other in a circle: table in corner in table");
  EXPECT_EQ(refused("table", "table"), "the frame 'table' is stated in itself");
  EXPECT_EQ(refused("Own", "Own"), "there is no frame 'Own'");
  EXPECT_EQ(refused("p", "corner"), "set");
}

/// A PLC reads points as a program does.
TEST_F(PointFrames, ThePlcReadsTheFieldsOfAFramedPointInTheWorld) {
  const std::string fields = "log(p.x / 1m)\nlog(q.z / 1m)\nlog(p.rz / 1rad)\n";
  plc = fields;
  run(kFramedPoints, "wait 100ms\n" + fields + "wait 100ms\n");
  ASSERT_FALSE(cell->failure()) << cell->failure()->problem.text();
  const Pose wanted = kTable * kOnTable;
  ASSERT_EQ(observer.lines.size(), 6u);
  EXPECT_NEAR(std::stod(observer.lines[0]), wanted.position.x, 1e-6);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(observer.lines[i], observer.lines[3 + i]);
}

TEST_F(PointFrames, ThePlcReadsAPointOnTheRobotWhereItIsNow) {
  plc = "wait 3s\nlog(up.z / 1m)\n";
  run(kFramedPoints, "moveto p\nwait 5s\n");
  ASSERT_FALSE(cell->failure()) << cell->failure()->problem.text();
  ASSERT_EQ(observer.lines.size(), 1u);
  const Pose there = kTable * kOnTable * Pose{{0, 0, -0.03}, {}};
  EXPECT_NEAR(std::stod(observer.lines[0]), there.position.z, 1e-4) << observer.lines[0];
}

TEST_F(PointFrames, TheFrameOfAMoveIsNotAskedForAPointThatHasItsOwn) {
  run(kFramedPoints, "movej p\nuse frame \"arm/tcp\"\nmovej offset(p, z = 20mm)\nmovej p\n");
  expect_tcp(kTable * kOnTable);
}

TEST_F(PointFrames, IkTakesAFramedPointInItsOwnFrameWhateverTheFrameInUse) {
  run(kFramedPoints, "use frame pose(300mm, 0, 0, 0, 0, 1rad)\nmovej ik(p, here_joints())\n");
  expect_tcp(kTable * kOnTable);
  run(kFramedPoints, "use frame table\nmovej ik(p, here_joints())\n");
  expect_tcp(kTable * kOnTable);
  run(kFramedPoints, "use frame pose(200mm, 0, 0)\nmovej ik(pose(50mm, 20mm, 100mm, 3rad), here_joints())\n");
  expect_tcp(Pose{{0.2, 0, 0}, {}} * kOnTable);
}

TEST_F(PointFrames, WhatIsMadeOfAFramedPointIsInItsFrameWhateverTheFrameOfTheMove) {
  const Pose shifted = kTable * pose_xyz_rpy({0.08, 0.02, 0.12}, {3, 0, 0.2});
  const std::string offset = "movej offset(p, x = 30mm, z = 20mm, rz = 0.2rad)\n";
  run(kFramedPoints, offset);
  expect_tcp(shifted);
  run(kFramedPoints, "use frame table\n" + offset);
  expect_tcp(shifted);
  run(kFramedPoints, "use frame table\nmovej tool_offset(p, y = 20mm)\n");
  expect_tcp(kTable * kOnTable * Pose{{0, 0.02, 0}, {}});
  run(kFramedPoints, "use frame table\nmovej p * pose(y = 20mm)\n");
  expect_tcp(kTable * kOnTable * Pose{{0, 0.02, 0}, {}});
  const Pose high = kTable * pose_xyz_rpy({0.05, 0.02, 0.12}, {3, 0, 0});
  run(kFramedPoints, "use frame table\nlet above = offset(p, z = 40mm)\nmovej interpolate(p, above, 50%)\n");
  expect_tcp(high);
  run(kFramedPoints, "use frame table\nmovej p with z = p.z + 20mm\n");
  expect_tcp(high);
  run(kFramedPoints,
      "use frame table\nlet slots = pallet(p, offset(p, x = 40mm), offset(p, y = 30mm), 2, 2, 2, 20mm)\n"
      "movej slots[8]\n");
  expect_tcp(kTable * pose_xyz_rpy({0.09, 0.05, 0.12}, {3, 0, 0}));
}

TEST_F(PointFrames, APoseOfTheFrameInUseIsComparedWithAFramedPointInOneFrame) {
  const Pose middle = kTable * pose_xyz_rpy({0.05, 0.04, 0.1}, {3, 0, 0});
  const std::string far = "pose(50mm, 60mm, 100mm, 3rad)";
  run(kFramedPoints, "use frame table\nmovej interpolate(p, " + far + ", 50%)\n");
  expect_tcp(middle);
  run(kFramedPoints, "moveto p\nuse frame table\nmovel interpolate(here(), p with x = p.x, 50%)\n");
  expect_tcp(kTable * kOnTable);
  run(kFramedPoints,
      "use frame pose(250mm, 100mm, 50mm, rz = 0.5rad)\nmovej interpolate(" + far + ", p, 50%)\n");
  expect_tcp(middle);
  run(kFramedPoints, "use frame table\nif abs(distance(p, " + far +
                         ") - 40mm) > 0.001mm\n  raise \"{distance(p, " + far + ")}\"\nend\n");
  EXPECT_FALSE(cell->failure());
  run(kFramedPoints, "use frame table\nmovej pallet(p, " + far + ", offset(p, x = 40mm), 2, 2)[4]\n");
  expect_tcp(kTable * pose_xyz_rpy({0.09, 0.06, 0.1}, {3, 0, 0}));
}

TEST_F(PointFrames, TheBaseIsThatOfTheRobotThatMoves) {
  const std::string point = "Pose: RPY\nName: p\nPoint: 0.25, 0.1, 0.15, 3, 0, 0; frame = \"base\"\n";
  const std::string two =
      "{left: {model: universal_robots/ur3, hardware: mock}, right: {model: universal_robots/ur3, hardware: "
      "mock, at: [0.9, 0, 0.1], rpy: [0, 0, 180deg]}}";
  const Pose base = pose_xyz_rpy({0.9, 0, 0.1}, {0, 0, std::acos(-1)});
  run(point, "use robot right\nmovej p\n", two);
  expect_tcp(base * pose_xyz_rpy({0.25, 0.1, 0.15}, {3, 0, 0}), 1);
  run(point, "use robot right\nmovej offset(p, z = 20mm)\n", two);
  expect_tcp(base * pose_xyz_rpy({0.25, 0.1, 0.17}, {3, 0, 0}), 1);
  run(point, "log(distance(p, pose(0, 0, 0)))\n", two);
  ASSERT_TRUE(cell->failure()) << "one of the numbers is in the world";
  EXPECT_NE(cell->failure()->problem.what.find("takes poses of one frame"), std::string::npos)
      << cell->failure()->problem.text();
  run(point, "use frame \"base\"\nlog(distance(p, pose(0, 0, 0)))\n", two);
  EXPECT_FALSE(cell->failure());
}

TEST_F(PointFrames, AFrameGivenAsAValueIsInItsOwnFrame) {
  const std::string points = "Pose: RPY\nName: shelf\nPoint: 0.05, 0, 0.02, 0, 0, 0.3; frame = \"base\"\n";
  const std::string two =
      "{left: {model: universal_robots/ur3, hardware: mock}, right: {model: universal_robots/ur3, hardware: "
      "mock, at: [0.9, 0, 0.1], rpy: [0, 0, 180deg]}}";
  const Pose base = pose_xyz_rpy({0.9, 0, 0.1}, {0, 0, std::acos(-1)});
  const Pose shelf = base * pose_xyz_rpy({0.05, 0, 0.02}, {0, 0, 0.3});
  const std::string use = "use robot right\nlet f = shelf\nuse frame f\n";
  run(points, use + "movej pose(250mm, 100mm, 150mm, 3rad)\n", two);
  expect_tcp(shelf * pose_xyz_rpy({0.25, 0.1, 0.15}, {3, 0, 0}), 1);
  run(points, use + "moveto pose(250mm, 100mm, 150mm, 3rad)\nmovel offset(here(), z = 20mm)\n", two);
  expect_tcp(shelf * pose_xyz_rpy({0.25, 0.1, 0.17}, {3, 0, 0}), 1);
  run(points, use + "movej ik(pose(250mm, 100mm, 150mm, 3rad), here_joints())\n", two);
  expect_tcp(shelf * pose_xyz_rpy({0.25, 0.1, 0.15}, {3, 0, 0}), 1);
}

TEST_F(PointFrames, ALengthForAJointThatTurnsIsRefusedAndAnAngleForOneThatSlides) {
  const auto code = [this](const std::string& points, const std::string& program, const std::string& robots) {
    run(points, program, robots);
    return cell->failure() ? cell->failure()->problem.code + ": " + cell->failure()->problem.what : "moved";
  };
  const std::string scara = "{arm: {model: denso/hsr065a1_n32, hardware: mock}}";
  EXPECT_EQ(code("", "movej joints(0, -90deg, 100mm, 0, 0, 0)\n", kUr3),
            "joint-unit: joints(0, …) has a length for 'elbow_joint' of ur3, which turns");
  EXPECT_EQ(code("", "movej joints(10deg, 20deg, 100mm, 5deg)\n", scara), "moved");
  EXPECT_NE(code("", "movej joints(joint_2 = 0, joint_1 = 0, joint_3 = 5deg, joint_4 = 0)\n", scara)
                .find("has an angle for 'joint_3'"),
            std::string::npos);
  EXPECT_NE(code("", "let now = here_joints()\nmovej now with joint_1 = 100mm\n", scara)
                .find("has a length for 'joint_1'"),
            std::string::npos);
  const std::string in_file = "JS: joint_1 joint_2 joint_3 joint_4\nName: p\nPoint: 0, 10deg, 5deg, 0\n";
  EXPECT_NE(code(in_file, "movej p\n", scara).find("p has an angle for 'joint_3'"), std::string::npos);
  EXPECT_EQ(
      code("JS: joint_1 joint_2 joint_3 joint_4\nName: p\nPoint: 0, 0.1, 0.05, 0\n", "movej p\n", scara),
      "moved")
      << "numbers without a unit are rad and m";
  EXPECT_EQ(code("", "let j = here_joints()\nmovej j with joint_3 = j.joint_3 + 20mm\n", scara), "moved")
      << "a joint that slides has a length";
}

/// A point as `polyarm data teach` keeps it, of this robot standing in `joints` with `tool`.
class TaughtPoints : public PointFrames {
 protected:
  static const std::vector<std::string>& names() {
    static const std::vector<std::string> out = {"shoulder_pan_joint", "shoulder_lift_joint",
                                                 "elbow_joint",        "wrist_1_joint",
                                                 "wrist_2_joint",      "wrist_3_joint"};
    return out;
  }
  static std::string taught(const std::vector<double>& joints, const Pose& tcp, const std::string& robot) {
    const Quaternion& q = tcp.rotation;
    std::string by_name;
    for (std::size_t i = 0; i < joints.size(); ++i)
      by_name += (i ? ", " : "") + names()[i] + " = " + format_number(joints[i]);
    std::string numbers;
    for (const double n : {tcp.position.x, tcp.position.y, tcp.position.z, q.x, q.y, q.z, q.w})
      numbers += (numbers.empty() ? "" : ", ") + format_number(n);
    return "Pose: Quaternion\nName: p\nPoint: " + numbers + "; tool = \"suction_cup\", robot = \"" + robot +
           "\", joints = joints(" + by_name + ")\n";
  }
  double joint(const std::string& name) const {
    return cell->snapshot().states[*cell->loop().table().find_state("arm/" + name + "/position")];
  }
  /// Where the TCP is in these joints, with the cup.
  Pose tcp_in(const std::vector<double>& joints) {
    std::string line = "movej joints(";
    for (std::size_t i = 0; i < joints.size(); ++i)
      line += (i ? ", " : "") + names()[i] + " = " + format_number(joints[i]) + "rad";
    run("", line + ")\n");
    return cell->tcp(0);
  }
  const std::vector<double> elbow_down = {0.3, -0.6, -1.3, -1.2, -1.5, 0.2};
};

TEST_F(TaughtPoints, AreReachedInTheConfigurationInWhichTheRobotStood) {
  const Pose tcp = tcp_in(elbow_down);
  run(taught(elbow_down, tcp, "universal_robots/ur3"), "movej p\n");
  expect_tcp(tcp);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(joint(names()[i]), elbow_down[i], 1e-5) << names()[i];
  run(taught(elbow_down, tcp, "universal_robots/ur5e"), "movej p\n");
  expect_tcp(tcp);
  EXPECT_GT(joint("elbow_joint"), 0) << "what another robot's joints were says nothing about these";
}

TEST_F(TaughtPoints, PutTheTipOfAnotherToolWhereTheTaughtOnesWas) {
  const Pose tcp = tcp_in(elbow_down);
  run(taught(elbow_down, tcp, "universal_robots/ur3") +
          "Pose: RPY\nName: long_cup\nPoint: 0, 0, 0.14, 0, 0, 0\n",
      "use tool long_cup\nmovej p\n");
  ASSERT_FALSE(cell->failure()) << cell->failure()->problem.text();
  const Pose flange = cell->tcp(0) * inverse(cell->robots()[0]->tool.tcp);
  EXPECT_LT(norm((flange * Pose{{0, 0, 0.14}, {}}).position - tcp.position), 1e-6);
  EXPECT_LT(joint("elbow_joint"), 0) << "and the configuration stays";
}

TEST_F(TaughtPoints, AJointStateOfAnotherMakeSaysWhyItCannot) {
  run("JS: panda_joint1 panda_joint2\nName: p\nPoint: 0, 1\n", "movej p\n");
  ASSERT_TRUE(cell->failure());
  const std::string told = cell->failure()->problem.text();
  EXPECT_NE(told.find("names the joint 'panda_joint1', which ur3 does not have"), std::string::npos) << told;
  EXPECT_NE(told.find("a pose works for all"), std::string::npos) << told;
}

}  // namespace
}  // namespace polyarm
