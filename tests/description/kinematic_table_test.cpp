#include "polyarm/catalogue/kinematic_table.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <random>

#include "polyarm/base/file.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "tests/description/support.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::description::kinematic_table_test {
namespace {

using test::has;

using polyarm::test::Folder;

std::string file_with(const std::string& kinematics, const std::string& rows, const std::string& rest = {}) {
  return "polyarm: robot/1\nmaker: Test\nmodel: T\nsource: s\nlicence: l\nkinematics: " + kinematics +
         "\njoints:\n" + rows + rest;
}

RobotModel read(const Folder& folder, const std::string& text) {
  return read_robot_file(folder.write("arm.yaml", text));
}

const std::string kLimits = ", lower: -3, upper: 3, velocity: 1}\n";

/// Universal Robots' published Denavit-Hartenberg parameters of the UR5e.
std::string ur5e_dh() {
  return "  - {a: 0, d: 0.1625, alpha: 90deg" + kLimits + "  - {a: -0.425, d: 0, alpha: 0" + kLimits +
         "  - {a: -0.3922, d: 0, alpha: 0" + kLimits + "  - {a: 0, d: 0.1333, alpha: 90deg" + kLimits +
         "  - {a: 0, d: 0.0997, alpha: -90deg" + kLimits + "  - {a: 0, d: 0.0996, alpha: 0" + kLimits;
}
std::string ur5e_modified() {
  return "  - {a: 0, alpha: 0, d: 0.1625" + kLimits + "  - {a: 0, alpha: 90deg, d: 0" + kLimits +
         "  - {a: -0.425, alpha: 0, d: 0" + kLimits + "  - {a: -0.3922, alpha: 0, d: 0.1333" + kLimits +
         "  - {a: 0, alpha: 90deg, d: 0.0997" + kLimits + "  - {a: 0, alpha: -90deg, d: 0.0996" + kLimits;
}
std::string ur5e_poe() {
  return "  - {axis: [0, 0, 1], point: [0, 0, 0]" + kLimits + "  - {axis: [0, -1, 0], point: [0, 0, 0.1625]" +
         kLimits + "  - {axis: [0, -1, 0], point: [-0.425, 0, 0.1625]" + kLimits +
         "  - {screw: [0, -1, 0, 0.1625, 0, 0.8172]" + kLimits +
         "  - {axis: [0, 0, -1], point: [-0.8172, -0.1333, 0]" + kLimits +
         "  - {axis: [0, -1, 0], point: [-0.8172, 0, 0.0628]" + kLimits;
}
const std::string kUr5eFlange = "flange: {xyz: [-0.8172, -0.2329, 0.0628], rpy: [90deg, 0, 0]}\n";

/// The Puma 560 (Corke, Robotics, Vision and Control; Armstrong et al. 1986): as Corke has it and as Craig
/// would.
std::string puma_dh() {
  return "  - {a: 0, alpha: 90deg, d: 0" + kLimits + "  - {a: 0.4318, alpha: 0, d: 0" + kLimits +
         "  - {a: 0.0203, alpha: -90deg, d: 0.15005" + kLimits + "  - {a: 0, alpha: 90deg, d: 0.4318" +
         kLimits + "  - {a: 0, alpha: -90deg, d: 0" + kLimits + "  - {a: 0, alpha: 0, d: 0" + kLimits;
}
std::string puma_modified() {
  return "  - {a: 0, alpha: 0, d: 0" + kLimits + "  - {a: 0, alpha: 90deg, d: 0" + kLimits +
         "  - {a: 0.4318, alpha: 0, d: 0.15005" + kLimits + "  - {a: 0.0203, alpha: -90deg, d: 0.4318" +
         kLimits + "  - {a: 0, alpha: 90deg, d: 0" + kLimits + "  - {a: 0, alpha: -90deg, d: 0" + kLimits;
}
std::string puma_poe() {
  return "  - {axis: [0, 0, 1], point: [0, 0, 0]" + kLimits + "  - {axis: [0, -1, 0], point: [0, 0, 0]" +
         kLimits + "  - {axis: [0, -1, 0], point: [0.4318, 0, 0]" + kLimits +
         "  - {axis: [0, 0, 1], point: [0.4521, -0.15005, 0]" + kLimits +
         "  - {axis: [0, -1, 0], point: [0.4521, 0, 0.4318]" + kLimits +
         "  - {axis: [0, 0, 1], point: [0.4521, -0.15005, 0]" + kLimits;
}
const std::string kPumaFlange = "flange: {xyz: [0.4521, -0.15005, 0.4318]}\n";

Pose tool_of(const RobotModel& model, const std::vector<double>& q) {
  return test::walk(model, q)[static_cast<std::size_t>(model.tool_link())];
}

void expect_same_arm(const RobotModel& a, const RobotModel& b) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-3, 3);
  for (int k = 0; k < 50; ++k) {
    std::vector<double> q(6);
    for (double& value : q) value = angle(random);
    const Pose at = tool_of(a, q), bt = tool_of(b, q);
    EXPECT_LT(norm(at.position - bt.position), 1e-9);
    EXPECT_LT(angle_between(at.rotation, bt.rotation), 1e-7);
  }
}

TEST(KinematicTable, TheThreeFormsOfAnArmAreOneArm) {
  const Folder folder;
  const RobotModel ur = read(folder, file_with("dh", ur5e_dh()));
  expect_same_arm(ur, read(folder, file_with("modified_dh", ur5e_modified())));
  expect_same_arm(ur, read(folder, file_with("poe", ur5e_poe(), kUr5eFlange)));
  const RobotModel puma = read(folder, file_with("dh", puma_dh()));
  expect_same_arm(puma, read(folder, file_with("modified_dh", puma_modified())));
  expect_same_arm(puma, read(folder, file_with("poe", puma_poe(), kPumaFlange)));
}

/// The catalogue's UR5e comes from another source; its base is turned by half a turn.
TEST(KinematicTable, AgreesWithTheCatalogue) {
  const Folder folder;
  const RobotModel table = read(folder, file_with("dh", ur5e_dh()));
  const RobotModel known = Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/ur5e");
  for (const std::vector<double>& q :
       {std::vector<double>{0.1, -1.2, 1.4, -1.7, -1.3, 0.4}, std::vector<double>{-1, 0.5, -0.7, 2, 1, -2}}) {
    const Pose a = tool_of(known, q), b = tool_of(table, q);
    EXPECT_LT(norm(a.position - Vec3{-b.position.x, -b.position.y, b.position.z}), 1e-6);
  }
}

TEST(KinematicTable, ScaraWithASlidingJointInEachForm) {
  const Folder folder;
  const std::string turn = ", lower: -2, upper: 2, velocity: 1}\n";
  const std::string slide = ", type: prismatic, lower: 0, upper: 0.2, velocity: 1}\n";
  const RobotModel dh = read(
      folder, file_with("dh", "  - {a: 0.3, alpha: 0, d: 0.4" + turn + "  - {a: 0.2, alpha: 180deg, d: 0" +
                                  turn + "  - {a: 0, alpha: 0, theta: 0" + slide));
  const RobotModel poe = read(folder, file_with("poe",
                                                "  - {axis: [0, 0, 1], point: [0, 0, 0]" + turn +
                                                    "  - {axis: [0, 0, 1], point: [0.3, 0, 0]" + turn +
                                                    "  - {axis: [0, 0, -1]" + slide,
                                                "flange: {xyz: [0.5, 0, 0.4], rpy: [180deg, 0, 0]}\n"));
  for (const std::vector<double>& q : {std::vector<double>{0, 0, 0}, std::vector<double>{0.4, -1, 0.13}}) {
    EXPECT_LT(norm(tool_of(dh, q).position - tool_of(poe, q).position), 1e-12);
    EXPECT_LT(angle_between(tool_of(dh, q).rotation, tool_of(poe, q).rotation), 1e-7);
  }
  EXPECT_NEAR(tool_of(dh, {0.4, -1, 0.13}).position.z, 0.27, 1e-12);
}

TEST(KinematicTable, HasShapesMassesAndFrames) {
  const Folder folder;
  const RobotModel model = read(folder, file_with("dh", ur5e_dh(), "named_states:\n  home: {joint_2: -1}\n"));
  EXPECT_EQ(model.tool_link(), model.find_link("tool0"));
  EXPECT_EQ(model.named_states.at("home")[1], -1);
  int shaped = 0;
  for (const Link& link : model.links) shaped += !link.collisions.empty();
  EXPECT_EQ(shaped, 7);
  const auto& notes = model.provenance.notes;
  EXPECT_NE(std::find(notes.begin(), notes.end(), "shapes are capsules derived from the chain"), notes.end());
}

TEST(KinematicTable, ErrorsNameTheRow) {
  struct Case {
    const char* kinematics;
    std::string rows;
    const char* piece;
  };
  const std::string good = "  - {name: one, a: 0, alpha: 0, d: 1" + kLimits;
  const Case cases[] = {
      {"denavit", good, "'denavit' is not a kind of table"},
      {"dh", good + "  - {name: two, a: 0, d: 1" + kLimits, "row 2 (two): 'alpha'"},
      {"dh", good + "  - {name: two, a: 0, alpha: 3m, d: 1" + kLimits, "row 2 (two): "},
      {"dh", good + "  - {name: two, a: 1e9, alpha: 0, d: 1" + kLimits, "row 2 (two): a robot is smaller"},
      {"dh", good + "  - {name: two, type: fixed, a: 0, alpha: 0, d: 1" + kLimits, "row 2 (two): 'fixed'"},
      {"dh", good + "  - {name: two, a: 0, alhpa: 0, alpha: 0, d: 1" + kLimits, "did you mean 'alpha'"},
      {"poe", "  - {name: one, axis: [0, 0, 0], point: [0, 0, 0]" + kLimits,
       "row 1 (one): the axis has no dir"},
      {"poe", "  - {name: one, axis: [0, 0, 1]" + kLimits, "row 1 (one): 'point'"},
      {"poe", "  - {name: one, screw: [0, 0, 1, 0, 0, 1]" + kLimits, "row 1 (one): w and v"},
      {"poe", "  - {name: one, screw: [0, 0, 2, 0, 0, 0]" + kLimits, "row 1 (one): w is not a unit"},
      {"poe", "  - {name: one, screw: [0, 0, 1]" + kLimits, "six numbers, here are 3"},
  };
  const Folder folder;
  for (const Case& c : cases) try {
      read(folder, file_with(c.kinematics, c.rows));
      ADD_FAILURE() << "was accepted: " << c.rows;
    } catch (const Error& e) {
      EXPECT_TRUE(has(e.what(), c.piece)) << e.what();
      EXPECT_GT(e.problems().at(0).where.line, 0) << e.what();
    }
}

}  // namespace
}  // namespace polyarm::description::kinematic_table_test
