/// Guards in a running cell: robots stop before contacts, wait for each other, and say why.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::Json;
using test::LockStepCell;

constexpr double kBall = 0.02, kFace = 0.45;  // radius; the near face of the wall
const std::string kNearWall = "  wall: {box: [0.1, 1, 1], at: [0.5, 0, 0]}\n";

/// Three slides that carry a ball.
std::string gantry() {
  std::string out = "<robot name=\"gantry\"><link name=\"base\"/>";
  const std::string links[] = {"base", "one", "two", "ball"};
  for (int i = 0; i < 3; ++i) {
    const std::string axis = i == 0 ? "1 0 0" : i == 1 ? "0 1 0" : "0 0 1";
    out += "<link name=\"" + links[i + 1] + "\">";
    if (i == 2) out += "<collision><geometry><sphere radius=\"0.02\"/></geometry></collision>";
    out += "</link><joint name=\"slide_" + std::string(1, "xyz"[i]) +
           "\" type=\"prismatic\"><parent link=\"" + links[i] + "\"/><child link=\"" + links[i + 1] +
           "\"/><axis xyz=\"" + axis +
           "\"/><limit lower=\"-2\" upper=\"2\" velocity=\"1\" effort=\"100\"/></joint>";
  }
  return out + "</robot>";
}

class GuardsTest : public ::testing::Test {
 protected:
  GuardsTest() { folder.write("gantry.urdf", gantry()); }

  /// `waits`: a person starts the program and resumes.
  void build(const std::string& program, const std::string& more = "", bool waits = false, bool two = false,
             bool lists = false) {
    folder.write("go.script", program);
    folder.write("scene.yaml", "polyarm: scene/1\nfloor: {height: -5}\nfixtures:\n" + fixtures);
    folder.write(
        "cell.yaml",
        "polyarm: cell/1\nrobots:\n  left: {model: gantry.urdf, hardware: mock}\n" +
            std::string(two ? "  right: {model: gantry.urdf, hardware: mock, at: [1, 0, 0]}\n" : "") +
            "scene: scene.yaml\n" + (program.empty() ? "" : "program: go\n") + more);
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    CellOptions options;
    options.waits = waits;
    options.allow_contact = options.contact_errors = lists;
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()), options);
    cell->run(0.05);
    if (waits && !program.empty()) {
      ASSERT_TRUE(cell->ask({{"request", "program.start"}})["ok"].get<bool>());
    }
  }
  /// A trajectory of points for the robot, as other programs send them.
  Json send(const std::vector<std::vector<double>>& points, double each) {
    Json list = Json::array();
    for (std::size_t i = 0; i < points.size(); ++i)
      list.push_back({{"positions", points[i]}, {"time_from_start", each * static_cast<double>(i + 1)}});
    const Json joints = {"slide_x", "slide_y", "slide_z"};
    std::string to;
    for (const std::string& name : cell->cell().loop().controllers().active_names())
      if (name.find("trajectory") != std::string::npos) to = name;
    return cell->ask(
        {{"request", "send"}, {"to", to}, {"message", {{"joint_names", joints}, {"points", list}}}});
  }
  double x(std::size_t robot = 0) { return cell->cell().tcp(robot).position.x; }
  double z(std::size_t robot = 0) { return cell->cell().tcp(robot).position.z; }
  std::string state() { return cell->result({{"request", "health"}})["state"]; }
  std::string failure() { return cell->cell().failure() ? cell->cell().failure()->problem.code : ""; }
  CellView view() { return CellView(cell->cell().in()); }

  Folder folder;
  std::string fixtures = kNearWall;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(GuardsTest, AMoveStopsOnItsPathBeforeTheContactAndSaysBetweenWhat) {
  build("movej joints(0.9m, 0m, 0m)\n");
  double most = 0;
  for (int i = 0; i < 3000 && failure().empty(); ++i) {
    cell->tick();
    most = std::max(most, x());
  }
  cell->run(0.5);
  ASSERT_EQ(failure(), "guard");
  const Problem& why = cell->cell().failure()->problem;
  EXPECT_NE(why.what.find("left/ball would come within"), std::string::npos) << why.what;
  EXPECT_NE(why.what.find("fixture wall"), std::string::npos) << why.what;
  EXPECT_EQ(why.where.line, 1);
  EXPECT_LE(std::max(most, x()), kFace - kBall - 0.004);
  EXPECT_GE(x(), kFace - kBall - 0.015) << "not long before it";
}

TEST_F(GuardsTest, APointCloudStopsAMove) {
  std::string points;
  for (int y = -10; y <= 10; ++y)
    for (int z = -10; z <= 10; ++z)
      points += "0.46 " + std::to_string(0.02 * y) + " " + std::to_string(0.02 * z) + "\n";
  folder.write(
      "wall.pcd",
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 443\nHEIGHT 1\nPOINTS 443\nDATA ascii\n"
      "nan nan nan\n1e9 0 0\n" +
          points);
  fixtures = "  scan: {cloud: {file: wall.pcd, radius: 10mm}}\n";
  build("movej joints(0.9m, 0m, 0m)\n");
  for (int i = 0; i < 3000 && failure().empty(); ++i) cell->tick();
  ASSERT_EQ(failure(), "guard");
  EXPECT_NE(cell->cell().failure()->problem.what.find("fixture scan"), std::string::npos);
  EXPECT_LE(x(), kFace - kBall - 0.004);
  EXPECT_GE(x(), kFace - kBall - 0.015);
}

/// As for objects of MoveIt's clients.
TEST_F(GuardsTest, ThingsThatComeLaterStopAMoveToo) {
  fixtures = "  far: {box: [0.1, 0.1, 0.1], at: [9, 0, 0]}\n";
  build("wait 1s\nmovej joints(0.9m, 0m, 0m)\n");
  description::Fixture box;
  box.name = "box";
  box.shapes.emplace_back();
  box.shapes[0].size = {0.1, 1, 1};
  box.pose.position.x = 0.5;
  cell->run(0.2);
  view().set_more_obstacles({box});
  for (int i = 0; i < 3000 && failure().empty(); ++i) cell->tick();
  ASSERT_EQ(failure(), "guard");
  EXPECT_NE(cell->cell().failure()->problem.what.find("fixture box"), std::string::npos);
  EXPECT_LE(x(), kFace - kBall - 0.004);
}

/// As for objects that MoveIt's clients attach.
TEST_F(GuardsTest, WhatIsAttachedToARobotStopsBeforeTheWall) {
  build("wait 1s\nmovej joints(0.9m, 0m, 0m)\n");  // where the rod would be behind the wall
  const description::RobotModel& model = cell->cell().in().setup.robots[0]->model;
  surroundings::AttachedThing rod{"rod", {}, 0, model.tool_link(), {{0.1, 0, 0}, {}}};
  rod.shape.size = {0.2, 0.02, 0.02};
  cell->run(0.2);
  view().set_more_obstacles({}, {rod});
  for (int i = 0; i < 3000 && failure().empty(); ++i) cell->tick();
  ASSERT_EQ(failure(), "guard");
  EXPECT_NE(cell->cell().failure()->problem.what.find("part rod would come within"), std::string::npos)
      << cell->cell().failure()->problem.what;
  EXPECT_LE(x(), kFace - 0.2 - 0.004);
  EXPECT_GE(x(), kFace - 0.2 - 0.015);
}

TEST_F(GuardsTest, AMoveGoesOnWhenThingsThatCameLaterAreTakenAway) {
  fixtures = "  far: {box: [0.1, 0.1, 0.1], at: [9, 0, 0]}\n";
  build("movej joints(0.9m, 0m, 0m)\n", "", true);
  description::Fixture box;
  box.name = "box";
  box.shapes.emplace_back();
  box.shapes[0].size = {0.1, 1, 1};
  box.pose.position.x = 0.5;
  view().set_more_obstacles({box});
  cell->run(4);
  ASSERT_EQ(state(), "held");
  EXPECT_LE(x(), kFace - kBall - 0.004);
  view().set_more_obstacles({});
  cell->run(0.1);
  EXPECT_TRUE(cell->ask({{"request", "control.resume"}})["ok"].get<bool>());
  cell->run(4);
  EXPECT_NEAR(x(), 0.9, 1e-6);
}

TEST_F(GuardsTest, SayWhatIsNearestAndHowFarAPlaceIs) {
  build("movej joints(0.9m, 0m, 0m)\n");
  std::optional<Guards::Near> near;
  double least = 1, slowest = 1;
  for (int i = 0; i < 3000 && failure().empty(); ++i) {
    cell->tick();
    if (const auto now = view().near(0)) near = now, least = std::min(least, now->distance);
    slowest = std::min(slowest, view().pace(0));
  }
  ASSERT_TRUE(near);
  EXPECT_EQ(near->mine, "left/ball");
  EXPECT_EQ(near->other, "fixture wall");
  EXPECT_NEAR(near->on_mine.x, x() + kBall, 2e-3);
  EXPECT_NEAR(near->on_other.x, kFace, 1e-6);
  EXPECT_LT(least, 0.02);
  EXPECT_LT(slowest, 0.5);
  EXPECT_NEAR(*view().clearance_at(0, std::vector{0.3, 0.0, 0.0}), kFace - kBall - 0.3, 1e-6);
  EXPECT_EQ(*view().clearance_at(0, std::vector{0.0, 0.0, 0.0}), Guards::kFarthest);
}

TEST_F(GuardsTest, WithoutGuardsItGoesThrough) {
  build("movej joints(0.9m, 0m, 0m)\n", "guards: off\n");
  cell->run(4);
  EXPECT_NEAR(x(), 0.9, 1e-6);
  build("movej joints(0.9m, 0m, 0m)\n", "guards: {moves: false}\n");
  cell->run(4);
  EXPECT_NEAR(x(), 0.9, 1e-6);
}

/// Only the tool may touch: see also LookAhead.AToolThatIsMeantToTouch….
TEST_F(GuardsTest, ALinkOfTheArmMayNotTouchInAMoveThatIsMeantTo) {
  build("movej joints(0.5m, 0m, 0m), touch\n");
  cell->run(4);
  EXPECT_EQ(failure(), "guard") << "the ball is a link of the arm";
}

TEST_F(GuardsTest, AMoveThatStaysClearTakesAsLongAsWithoutGuards) {
  const auto run = [&](const std::string& more) {
    build("movej joints(0.42m, 0m, 0m)\nmovej joints(0m, 0.3m, 0.1m)\n", more);
    std::vector<double> out;
    for (int i = 0; i < 2000; ++i) {
      cell->tick();
      out.push_back(x());
    }
    return out;
  };
  EXPECT_EQ(run(""), run("guards: off\n")) << "bit for bit";
}

TEST_F(GuardsTest, APersonResumesWhenTheWayIsFreeAndNotBefore) {
  build("movej joints(0.9m, 0m, 0m)\n", "", true);
  cell->run(4);
  ASSERT_EQ(state(), "held");
  const double there = x();
  EXPECT_GT(there, 0.4);
  EXPECT_EQ(cell->cell().stop_cause().code, "guard");
  EXPECT_TRUE(cell->ask({{"request", "control.resume"}})["ok"].get<bool>());
  cell->run(2);
  EXPECT_EQ(state(), "held");
  EXPECT_NEAR(x(), there, 0.002);
}

TEST_F(GuardsTest, JoggingStopsBeforeTheWallAndNamesIt) {
  build("", "", true);
  double session = 0;
  Json answer;
  const auto jog = [&](double speed, double seconds) {
    for (double t = 0; t < seconds; t += 0.05) {
      Json request{{"request", "jog"}, {"joints", {{"slide_x", speed}}}};
      if (session != 0) request["session"] = session;
      answer = cell->result(request);
      ASSERT_TRUE(answer.contains("session")) << answer;
      session = answer["session"];
      cell->run(0.05);
    }
  };
  jog(0.5, 3);
  EXPECT_NEAR(x(), kFace - kBall - 0.001, 0.0011);
  jog(0.5, 0.1);
  EXPECT_EQ(answer["held_back"], "body") << answer;
  EXPECT_EQ(answer["which"], "fixture wall");
  EXPECT_EQ(answer["reason"], "near fixture wall");
  jog(-0.5, 0.5);
  EXPECT_LT(x(), kFace - kBall - 0.05) << "away freely";
}

TEST_F(GuardsTest, AStreamedTargetBehindTheWallIsFollowedUpToIt) {
  build("", "", true);
  double session = 0;
  for (double t = 0; t < 3; t += 0.05) {
    Json request{{"request", "target"}, {"joints", {{"slide_x", 0.9}, {"slide_y", 0.0}, {"slide_z", 0.0}}}};
    if (session != 0) request["session"] = session;
    const Json answer = cell->result(request);
    ASSERT_TRUE(answer.contains("session")) << answer;
    session = answer["session"];
    cell->run(0.05);
  }
  EXPECT_NEAR(x(), kFace - kBall - 0.001, 0.0011);
}

TEST_F(GuardsTest, ATrajectoryOfPointsStopsBeforeTheWall) {
  build("", "", true);
  const Json answer = send({{0.9, 0, 0}}, 2);
  ASSERT_TRUE(answer["ok"].get<bool>()) << answer;
  double most = 0;
  for (int i = 0; i < 1500; ++i) {
    cell->tick();
    most = std::max(most, x());
  }
  EXPECT_EQ(state(), "held");
  EXPECT_EQ(cell->cell().stop_cause().code, "guard");
  EXPECT_NE(cell->cell().stop_cause().what.find("fixture wall"), std::string::npos)
      << cell->cell().stop_cause().what;
  EXPECT_LT(most, kFace - kBall) << "it does not touch";
  EXPECT_GT(most, kFace - kBall - 0.1) << "not long before it";
  EXPECT_TRUE(cell->ask({{"request", "control.resume"}})["ok"].get<bool>());
  for (int i = 0; i < 500; ++i) {
    cell->tick();
    most = std::max(most, x());
  }
  EXPECT_EQ(state(), "held") << "the way is still not free";
  EXPECT_LT(most, kFace - kBall);
}

TEST_F(GuardsTest, ATrajectoryOfPointsThatStaysClearGoesToItsEnd) {
  for (const bool moves : {false, true}) {
    const double there = moves ? 0.42 : 0.9;  // without moves it is not guarded
    build("", moves ? "" : "guards: {moves: false}\n", true);
    ASSERT_TRUE(send({{there, 0, 0}, {there, 0.8, 0.1}}, 1)["ok"].get<bool>());
    cell->run(3);
    EXPECT_NEAR(x(), there, 1e-6);
    EXPECT_EQ(state(), "running");
  }
}

TEST_F(GuardsTest, ATrajectoryOfPointsThatReplacesAnotherStopsToo) {
  build("", "", true);
  ASSERT_TRUE(send({{0.3, 0, 0}}, 1)["ok"].get<bool>());
  cell->run(0.5);
  double most = 0;
  ASSERT_TRUE(send({{0.35, 0, 0}, {0.9, 0, 0}, {0.9, 0.5, 0}}, 1)["ok"].get<bool>());
  for (int i = 0; i < 2000; ++i) {
    cell->tick();
    most = std::max(most, x());
  }
  EXPECT_EQ(state(), "held");
  EXPECT_LT(most, kFace - kBall);
}

/// A zone of the reduced profile holds a robot that was planned in the full one.
TEST_F(GuardsTest, AMoveThatWasPlannedInAnotherProfileStopsBeforeAZoneOfThisOne) {
  const std::string zone = "workspace:\n  near: {plane: [0.3, 0, 0], normal: [-1, 0, 0], profile: reduced}\n";
  build("movej joints(0.4m, 0m, 0m)\n", zone, true);
  cell->run(4);
  EXPECT_NEAR(x(), 0.4, 1e-6) << "in the full profile it goes there";
  build("movej joints(0.4m, 0m, 0m), duration 2s\n", zone, true);
  cell->run(0.6);
  EXPECT_LT(x(), 0.2);
  EXPECT_GT(x(), 0.001);
  cell->result({{"request", "profile"}, {"name", "reduced"}});
  cell->run(16);
  EXPECT_EQ(state(), "held");
  EXPECT_LE(x(), 0.3);
  EXPECT_GT(x(), 0.28);
  EXPECT_EQ(cell->cell().stop_cause().code, "guard-workspace") << "nothing is near: it has no pair";
  EXPECT_NE(
      cell->cell().stop_cause().what.find("left stopped before it leaves the workspace: the TCP, at (0.3000"),
      std::string::npos)
      << cell->cell().stop_cause().what;
  cell->result({{"request", "profile"}, {"name", "full"}});
  EXPECT_TRUE(cell->ask({{"request", "control.resume"}})["ok"].get<bool>());
  cell->run(3);
  EXPECT_NEAR(x(), 0.4, 1e-6);
}

TEST_F(GuardsTest, AMoveIntoAZoneOfItsProfileIsRefused) {
  build("movej joints(0.4m, 0m, 0m)\n",
        "profile: reduced\nworkspace:\n  near: {plane: [0.3, 0, 0], normal: [-1, 0, 0], profile: reduced}\n");
  cell->run(1);
  EXPECT_EQ(failure(), "workspace");
  EXPECT_EQ(x(), 0);
}

TEST_F(GuardsTest, AZoneOfBodiesMayBelongToAProfile) {
  fixtures = "  post: {box: [0.1, 0.1, 0.1], at: [5, 0, 0]}\n";
  build("movej joints(0m, 0m, 0.29m), duration 2s\n",
        "workspace:\n  roof: {plane: [0, 0, 0.3], normal: [0, 0, -1], of: bodies, profile: reduced}\n", true);
  cell->run(0.5);
  cell->result({{"request", "profile"}, {"name", "reduced"}});
  cell->run(20);
  EXPECT_EQ(state(), "held");
  EXPECT_LE(z(), 0.3 - kBall + 1e-3);
  EXPECT_NE(cell->cell().stop_cause().what.find("zone roof"), std::string::npos)
      << cell->cell().stop_cause().what;
}

TEST_F(GuardsTest, ATrajectoryOfPointsStopsBeforeABoundaryOfTheWorkspace) {
  build("", "workspace:\n  near: {plane: [0.3, 0, 0], normal: [-1, 0, 0]}\n", true);
  ASSERT_TRUE(send({{0.4, 0, 0}}, 2)["ok"].get<bool>());
  cell->run(4);
  EXPECT_EQ(state(), "held");
  EXPECT_LE(x(), 0.3);
  EXPECT_GT(x(), 0.2);
  EXPECT_NE(cell->cell().stop_cause().what.find("crosses 'near'"), std::string::npos)
      << cell->cell().stop_cause().what;
}

TEST_F(GuardsTest, BeyondABoundaryTheProfileIsReduced) {
  fixtures = "  post: {box: [0.1, 0.1, 0.1], at: [5, 0, 0]}\n";
  build("movej joints(0.4m, 0m, 0m)\nwait 1s\nmovej joints(0m, 0m, 0m)\nwait 2s\n",
        "workspace:\n  desk: {plane: [0.2, 0, 0], normal: [-1, 0, 0], beyond: reduced}\n", true);
  EXPECT_EQ(view().profile(), "full");
  double fastest = 0, before = 0;
  bool was_reduced = false;
  for (int i = 0; i < 8000 && !cell->cell().finished(); ++i) {
    before = x();
    cell->tick();
    was_reduced = was_reduced || view().profile() == "reduced";
    if (x() > 0.3) fastest = std::max(fastest, (x() - before) / 0.002);
  }
  EXPECT_TRUE(was_reduced);
  EXPECT_LT(fastest, 0.26);
  EXPECT_EQ(cell->told("reduced profile: left is beyond 'desk'"), 1);
  EXPECT_EQ(cell->told("profile full again"), 1);
  EXPECT_EQ(view().profile(), "full");
}

TEST_F(GuardsTest, WhereContactsAreListedItSaysWhereItWouldStopAndStopsNothing) {
  build("movej joints(0.427m, 0.3m, 0m)\nmovej joints(0.9m, 0m, 0m)\n", "", false, false, true);
  for (int i = 0; i < 5000 && !cell->cell().finished(); ++i) cell->tick();
  EXPECT_NEAR(x(), 0.9, 1e-6);
  const std::vector<Problem>& found = cell->cell().in().guards->would_stop();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::error) << "the run fails there";
  EXPECT_EQ(found[0].where.line, 2);
  EXPECT_NE(found[0].what.find("left would be stopped before a contact: left/ball would"), std::string::npos)
      << found[0].what;
}

TEST_F(GuardsTest, AZoneOfBodiesHoldsForTheBallAndNotOnlyForItsMiddle) {
  fixtures = "  post: {box: [0.1, 0.1, 0.1], at: [5, 0, 0]}\n";
  const std::string zone = "workspace:\n  roof: {plane: [0, 0, 0.3], normal: [0, 0, -1], of: bodies}\n";
  build("movej joints(0m, 0m, 0.29m)\n", zone);
  cell->run(3);
  EXPECT_EQ(failure(), "guard");
  EXPECT_LE(z(), 0.3 - kBall + 1e-3);
  EXPECT_NE(cell->cell().failure()->problem.what.find("zone roof"), std::string::npos);
}

TEST_F(GuardsTest, OfTwoRobotsOneWaitsUntilTheOtherHasGone) {
  fixtures = "  post: {box: [0.1, 0.1, 0.1], at: [5, 0, 0]}\n";
  build(
      "task a\n  use robot left\n  movej joints(0.8m, 0m, 0m)\nend\n"
      "task b\n  use robot right\n  movej joints(-0.4m, 0m, 0m)\n  wait 1s\n  movej joints(-0.4m, "
      "0.6m, 0m)\nend\n",
      "", false, true);
  double nearest = 1e9;
  for (int i = 0; i < 5000 && !cell->cell().finished() && failure().empty(); ++i) {
    cell->tick();
    nearest =
        std::min(nearest, norm(cell->cell().tcp(0).position - cell->cell().tcp(1).position) - 2 * kBall);
  }
  EXPECT_EQ(failure(), "");
  EXPECT_TRUE(cell->cell().finished());
  EXPECT_NEAR(x(0), 0.8, 1e-6);
  EXPECT_GE(nearest, 0.004);
  EXPECT_EQ(cell->told("left waits for right: left/ball would come within"), 1);
}

TEST_F(GuardsTest, TwoThatWaitForEachOtherAreNamed) {
  fixtures = "  post: {box: [0.1, 0.1, 0.1], at: [5, 0, 0]}\n";
  build(
      "task a\n  use robot left\n  movej joints(0.9m, 0m, 0m)\nend\n"
      "task b\n  use robot right\n  movej joints(-0.9m, 0m, 0m)\nend\n",
      "", false, true);
  double nearest = 1e9;
  for (int i = 0; i < 5000 && failure().empty(); ++i) {
    cell->tick();
    nearest = std::min(nearest, x(1) - x(0) - 2 * kBall);
  }
  EXPECT_EQ(failure(), "guard-deadlock");
  EXPECT_GE(nearest, 0.004);
  EXPECT_LE(nearest, 0.15);
}

TEST_F(GuardsTest, RobotsInStepSlowDownTogether) {
  fixtures = "  wall: {box: [0.1, 1, 0.2], at: [0.5, 0, 0]}\n";
  build(
      "together\n  movej joints(0.9m, 0m, 0m), robot left\n  movej joints(0m, 0m, 0.9m), robot "
      "right\nend\n",
      "", true, true);
  for (int i = 0; i < 2000; ++i) {
    cell->tick();
    ASSERT_NEAR(x(0), z(1), 0.01) << i;
  }
  EXPECT_EQ(state(), "held");
  EXPECT_GT(x(0), 0.4);
}

TEST_F(GuardsTest, OneInStepThatStandsInTheWayOfTheOtherIsNamed) {
  fixtures = "  post: {box: [0.1, 0.1, 0.1], at: [5, 0, 0]}\n";
  build(
      "together\n  movej joints(1.5m, 0m, 0m), robot left\n  movej joints(0m, 0.05m, 0m), robot "
      "right\nend\n",
      "", true, true);
  for (int i = 0; i < 3000 && state() != "held"; ++i) cell->tick();
  EXPECT_EQ(state(), "held");
  EXPECT_EQ(cell->cell().stop_cause().code, "guard-deadlock");
  EXPECT_LT(x(0), 1);
}

TEST_F(GuardsTest, BadEntriesAreNamed) {
  const auto code = [&](const std::string& more) {
    try {
      build("log(1)\n", more);
    } catch (const Error& e) {
      return e.problems().front().what;
    }
    return std::string("none");
  };
  EXPECT_EQ(code("guards: sometimes\n"), "guards is 'sometimes'");
  EXPECT_EQ(code("guards: {clearance: -1mm}\n"), "clearance is -1mm");
  EXPECT_NE(code("guards: {speed: 1}\n").find("speed"), std::string::npos);
  EXPECT_EQ(code("workspace:\n  roof: {plane: [0, 0, 1], normal: [0, 0, 1], of: hands}\n"),
            "the zone 'roof' is of 'hands'");
  EXPECT_EQ(code("guards: {clearance: 2mm, slow_from: 0mm}\n"), "none");
}

}  // namespace
}  // namespace polyarm::cell
