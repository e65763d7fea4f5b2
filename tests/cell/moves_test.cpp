// What programs draw: moves of every kind in a cell, looked at in every cycle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <tuple>
#include <vector>

#include "polyarm/cell/rehearsal.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::LockStepCell;

cell::CellFile drawing(const std::string& program) {
  cell::Overrides overrides;
  overrides.program = program;
  overrides.hardware = "mock";
  return cell::read_cell_file(std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/drawing.yaml", overrides);
}

/// Runs to the end of the program and gives the TCP's place in every tick.
std::vector<Vec3> drawn(LockStepCell& run, double most_s) {
  std::vector<Vec3> out;
  while (!run.cell().finished() && run.cell().loop().cycle().time < nanoseconds(most_s)) {
    run.tick();
    out.push_back(run.cell().tcp(0).position);
  }
  EXPECT_TRUE(run.cell().finished());
  return out;
}

TEST(Moves, TheCircleIsACircle) {
  LockStepCell run(drawing("circle"));
  const std::vector<Vec3> way = drawn(run, 20);
  ASSERT_FALSE(way.empty());
  const Vec3 start = way.back(), center = start - Vec3{0, 0, 0.1};
  double length = 0;
  std::size_t begin = 0;
  while (norm(way[begin] - start) > 1e-7) ++begin;  // on the way there
  ASSERT_GT(way.size() - begin, 1000u);
  for (std::size_t i = begin + 1; i < way.size(); ++i) {
    EXPECT_NEAR(norm(way[i] - center), 0.1, 1e-6);
    EXPECT_NEAR(way[i].y, start.y, 1e-6);
    length += norm(way[i] - way[i - 1]);
  }
  EXPECT_NEAR(length, 2 * M_PI * 0.1, 2e-3);
}

TEST(Moves, TheEllipseIsThatOfItsReference) {
  LockStepCell run(drawing("ellipse"));
  const std::vector<Vec3> way = drawn(run, 20);
  ASSERT_GT(way.size(), 1000u);
  const Vec3 start = way.back();
  const double a = 0.3 * 2 * 3 / (2 * M_PI),
               b = 0.3 * 3 / (2 * M_PI);  // of the generator's velocities over 3 s
  double most = 0;
  for (const Vec3& p : way) {
    const double x = (p.x - start.x) / a, y = (p.y - start.y) / b + 1;
    most = std::max(most, std::abs(std::hypot(x, y) - 1) * b);
  }
  EXPECT_LT(most, 1e-4);  // a curve through 72 points of it
}

TEST(Moves, TogetherRobotsBeginAndArriveInStep) {
  const test::Folder folder;
  const std::string urdf = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
  folder.write(
      "both.script",
      "together\n"
      "  movej joints(0deg, -90deg, 0deg, 0deg, 0deg, 0deg), robot left\n"
      "  movej [joints(0deg, 5deg, 0deg, 0deg, 0deg, 0deg), joints(5deg, 5deg, 0deg, 0deg, 0deg, 0deg)], "
      "robot right\n"
      "end\n");
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  left: {model: " + urdf +
                                ", hardware: mock}\n  right: {model: " + urdf +
                                ", at: [0, 2, 0], hardware: mock}\nprogram: both\n");
  LockStepCell run(cell::read_cell_file(folder.path()));
  std::vector<std::vector<Vec3>> ways(2);
  for (int i = 0; i < 5000 && !run.cell().finished(); ++i) {
    run.tick();
    for (std::size_t robot = 0; robot < 2; ++robot) ways[robot].push_back(run.cell().tcp(robot).position);
  }
  ASSERT_TRUE(run.cell().finished());
  const auto first_change = [](auto begin, auto end) {
    return std::find_if(begin, end, [&](const Vec3& p) { return norm(p - *begin) > 1e-12; }) - begin;
  };
  EXPECT_EQ(first_change(ways[0].begin(), ways[0].end()), first_change(ways[1].begin(), ways[1].end()));
  EXPECT_NEAR(first_change(ways[0].rbegin(), ways[0].rend()), first_change(ways[1].rbegin(), ways[1].rend()),
              2);
}

/// The arm of examples/r6bot with a program and what a test adds to its cell.
cell::CellFile with_program(const test::Folder& folder, const std::string& program, const std::string& more) {
  folder.write("go.script", program);
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + std::string(POLYARM_SOURCE_DIR) +
                                "/examples/r6bot/r6bot.urdf, hardware: mock}\nprogram: go\n" + more);
  return cell::read_cell_file(folder.path());
}

TEST(Moves, OneRobotCannotMakeTwoMovesTogether) {
  const test::Folder folder;
  LockStepCell run(with_program(folder,
                                "let which = \"arm\"\n"
                                "together\n"
                                "  movej joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                                "  movej joints(0, -40deg, 60deg, 0, 60deg, 0), robot which\n"
                                "end\n",
                                ""));
  for (int i = 0; i < 5000 && !run.cell().finished(); ++i) run.tick();
  ASSERT_TRUE(run.cell().program()->status().problem);
  EXPECT_EQ(run.cell().program()->status().problem->code, "two-moves");
  EXPECT_EQ(run.cell().program()->status().problem->where.line, 4);
}

// Values that are set on the way, by time and by length from the start and from the end, in the second of two
// moves.
TEST(Moves, WhatIsSetOnTheWayIsSetThere) {
  for (const auto& [at, least, most] : {std::tuple{"start + 300ms", 0.29, 0.32},
                                        {"start + 40mm", 0.39, 0.52},
                                        {"end - 500ms", 0.55, 0.75},
                                        {"end - 20mm", 0.75, 0.95}}) {
    const test::Folder folder;
    folder.write("go.script",
                 std::string("movej joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                             "let from = here()\nset Set = false\nlet begin = clock()\nlet passed = 0s\n"
                             "when Set\n  set passed = clock() - begin\nend\n"
                             "movel offset(from, z = -100mm), speed 100mm/s, at ") +
                     at + " set Set = true\nwait 1ms\nraise \"{passed / 1s}\"\n");
    folder.write("signals.yaml", "polyarm: signals/1\ntags:\n  Set: {initial: false}\n");
    folder.write("cell.yaml",
                 "polyarm: cell/1\nrobots:\n  arm: {model: " + std::string(POLYARM_SOURCE_DIR) +
                     "/examples/r6bot/r6bot.urdf, hardware: mock}\nprogram: go\nsignals: signals.yaml\n");
    LockStepCell run(cell::read_cell_file(folder.path()));
    while (!run.cell().program()->ended() && run.cell().loop().cycle().time < nanoseconds(30.0)) run.tick();
    const std::string said = run.cell().program()->status().problem.value_or(Problem{}).what;
    EXPECT_GE(std::atof(said.c_str()), least) << at << ": " << said;
    EXPECT_LE(std::atof(said.c_str()), most) << at << ": " << said;
  }
}

/// What a program of two robots says at its end: for each of two rounds the error of its `together`, which
/// has these two statements, and joint 1 of both robots after the moves behind it, in degrees.
std::string after_a_failure(const std::string& first, const std::string& second) {
  const test::Folder folder;
  const std::string urdf = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
  folder.write("go.script",
               "let ready = joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
               "func ahead(name, z)\n"
               "  use robot name\n"
               "  return offset(fk(ready), z = z)\n"
               "end\n"
               "let third = length(split(\"a,b,c\", \",\"))\n"
               "let said = \"\"\n"
               "movej ready, robot left\n"
               "movej ready, robot right\n"
               "for round in 1 .. 2\n"
               "  try\n"
               "    together\n"
               "      " +
                   first +
                   "\n"
                   "      " +
                   second +
                   "\n"
                   "    end\n"
                   "  on error e\n"
                   "    set said = said + \"{e.kind} {e.line}{e.robot}, \"\n"
                   "  end\n"
                   "  movej joints(round * 10deg, -30deg, 60deg, 0, 60deg, 0), robot left\n"
                   "  movej joints(round * 20deg, -30deg, 60deg, 0, 60deg, 0), robot right\n"
                   "  use robot left\n"
                   "  let q = here_joints()\n"
                   "  use robot right\n"
                   "  let p = here_joints()\n"
                   "  set said = said + \"{round(q.joint_1 / 1deg)} {round(p.joint_1 / 1deg)}; \"\n"
                   "end\n"
                   "raise said\n");
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  left: {model: " + urdf +
                                ", hardware: mock}\n  right: {model: " + urdf +
                                ", at: [0, 2, 0], hardware: mock}\nprogram: go\n");
  LockStepCell run(cell::read_cell_file(folder.path()));
  while (!run.cell().program()->ended() && run.cell().loop().cycle().time < nanoseconds(60.0)) run.tick();
  const Problem why = run.cell().program()->status().problem.value_or(Problem{});
  return run.cell().program()->ended() ? why.what : "still waits";
}

// Of robots in step, one cannot move: the others must not wait for it, and the program can go on with all.
TEST(Moves, AFailureOfOneInStepIsTheErrorOfAllAndEndsWithIt) {
  const std::string good = R"(movel ahead("left", 20mm), robot left, speed 100mm/s)";
  for (const std::string bad :
       {R"(movel ahead("right", 5m), robot right)", "movej [ready][third], robot right"}) {
    const std::string kind = bad.starts_with("movel") ? "unreachable" : "value";
    const std::string of = bad.starts_with("movel") ? "right" : "";
    EXPECT_EQ(after_a_failure(good, bad), kind + " 14" + of + ", 10 20; " + kind + " 14" + of + ", 20 40; ")
        << bad;
    EXPECT_EQ(after_a_failure(bad, good), kind + " 13" + of + ", 10 20; " + kind + " 13" + of + ", 20 40; ")
        << bad;
  }
}

// A program that fails stops its robots also if it has an `on stop` block, which begins when they stand.
TEST(Moves, AFailedProgramDoesNotExecuteItsQueuedMovesBeforeOnStop) {
  const std::string away = "movej joints(60deg, -30deg, 60deg, 0, 60deg, 0), speed 10%\n";
  for (const auto& [program, least, most] :
       {std::tuple{away + "raise \"no\"\n", 0.0, 0.1},  // before the first move begins
        {"task one\n" + away + away + "end\ntask two\nwait 1s\nraise \"no\"\nend\n", 2.0, 40.0},
        {"every 1s\nset At = 1 / (At - At)\nend\n" + away + "wait 1ms\n", 2.0, 40.0}}) {
    const test::Folder folder;
    folder.write("go.script", program +
                                  "on stop\n  try\n    raise \"caught\"\n  on error\n  end\n"
                                  "  let q = here_joints()\n  set At = q.joint_1 / 1deg\nend\n");
    folder.write("signals.yaml", "polyarm: signals/1\ntags:\n  At: {initial: 0}\n");
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + std::string(POLYARM_SOURCE_DIR) +
                                  "/examples/r6bot/r6bot.urdf, hardware: mock}\nprogram: go\n"
                                  "signals: signals.yaml\n");
    LockStepCell run(cell::read_cell_file(folder.path()));
    while (!run.cell().finished() && run.cell().loop().cycle().time < nanoseconds(30.0)) run.tick();
    EXPECT_TRUE(run.cell().program()->failed()) << program;
    const double at = run.cell().store().find("At")->as_number()->value;
    EXPECT_GE(at, least) << program;
    EXPECT_LT(at, most) << program;
    EXPECT_NEAR(at, run.cell().snapshot().commands.front() * 180 / M_PI, 1e-3) << "it stood: " << program;
  }
}

// `stop` in a task ends the moves of the others.
TEST(Moves, StopStopsTheRobotsOfOtherTasks) {
  for (const std::string end : {"", "on stop\nlog(1)\nend\n"}) {
    const test::Folder folder;
    LockStepCell run(
        with_program(folder,
                     "task one\nmovej joints(60deg, -30deg, 60deg, 0, 60deg, 0), speed 10%\nend\n"
                     "task two\nwait 1s\nstop\nend\n" +
                         end,
                     ""));
    while (!run.cell().finished() && run.cell().loop().cycle().time < nanoseconds(30.0)) run.tick();
    EXPECT_TRUE(run.cell().finished());
    EXPECT_TRUE(run.cell().snapshot().standing) << end;
    EXPECT_LT(run.cell().loop().cycle().time, nanoseconds(2.0)) << end;
    EXPECT_LT(run.cell().snapshot().commands.front(), 40 * M_PI / 180) << end;
  }
}

// Of two robots, blocks beside the program use the one that `use` names at their line.
TEST(Moves, BlocksThatRunByThemselvesHaveTheDefaultsOfTheirLine) {
  const test::Folder folder;
  const std::string urdf = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
  folder.write("go.script",
               "let ready = joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
               "let ys = [0m, 0m, 0m]\n"
               "use robot right\n"
               "every 20ms\n"
               "  if true\n    use speed 50%\n  end\n"
               "  set ys[1] = fk(ready).y\n"
               "end\n"
               "when ys[1] > 1m\n"
               "  set ys[2] = fk(ready).y\n"
               "end\n"
               "wait 100ms\n"
               "raise \"{ys[1] > 1m} {ys[2] > 1m}\"\n"
               "on stop\n"
               "  set Side = fk(ready).y / 1m\n"
               "end\n");
  folder.write("signals.yaml", "polyarm: signals/1\ntags:\n  Side: {initial: 0}\n");
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  left: {model: " + urdf +
                                ", hardware: mock}\n  right: {model: " + urdf +
                                ", at: [0, 2, 0], hardware: mock}\nprogram: go\nsignals: signals.yaml\n");
  LockStepCell run(cell::read_cell_file(folder.path()));
  while (!run.cell().finished() && run.cell().loop().cycle().time < nanoseconds(10.0)) run.tick();
  EXPECT_EQ(run.cell().program()->status().problem.value_or(Problem{}).what, "True True");
  EXPECT_GT(run.cell().store().find("Side")->as_number()->value, 1);
}

// A handler begins while the moves before the error are still under way; what needs rest waits for them.
TEST(Moves, AHandlerWaitsForTheRobotWhereItNeedsItAtRest) {
  const std::string away = "movej joints(50deg, -30deg, 60deg, 0, 60deg, 0), speed 20%\n";
  for (const std::string& failing :
       {away + "movel offset(fk(ready), z = 5m)\nwait 10ms\n", away + "moveto offset(fk(ready), z = 5m)\n",
        away + "raise \"no\"\n", "together\n" + away + "raise \"no\"\nend\n",
        "together\nif true\n" + away + "movel offset(fk(ready), z = 5m)\nend\nwait 1ms\nend\n",
        "together\nwait 5s\ntogether\nwait 5s\n" + away + "raise \"no\"\nend\nend\n"}) {
    const test::Folder folder;
    LockStepCell run(with_program(folder,
                                  "let ready = joints(0, -30deg, 60deg, 0, 60deg, 0)\nmovej ready\ntry\n" +
                                      failing +
                                      "on error e\n  let q = here_joints()\n"
                                      "  raise \"at {round(q.joint_1 / 1deg)}\"\nend\n",
                                  ""));
    while (!run.cell().program()->ended() && run.cell().loop().cycle().time < nanoseconds(30.0)) run.tick();
    EXPECT_EQ(run.cell().program()->status().problem.value_or(Problem{}).what, "at 50") << failing;
  }
}

TEST(Moves, AProgramThatLeavesTheWorkspaceFailsAtItsLineBeforeItMoves) {
  const test::Folder folder;
  LockStepCell run(with_program(folder,
                                "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                                "let start = here()\n"
                                "movel offset(start, z = -50mm)\n"
                                "movel offset(start, z = -500mm)\n",
                                "workspace:\n  table: {plane: [0, 0, 1300mm], normal: [0, 0, 1]}\n"));
  double lowest = 2;
  while (!run.cell().program()->ended() && run.cell().loop().cycle().time < nanoseconds(30.0)) {
    run.tick();
    lowest = std::min(lowest,
                      run.cell().program()->status().where.line > 1 ? run.cell().tcp(0).position.z : lowest);
  }
  ASSERT_TRUE(run.cell().program()->failed());
  const Problem why = run.cell().program()->status().problem.value_or(Problem{});
  EXPECT_EQ(why.code, "workspace");
  EXPECT_EQ(why.where.line, 4);
  EXPECT_NE(why.what.find("crosses 'table'"), std::string::npos) << why.what;
  EXPECT_GT(lowest, 1.5);
}

/// The place and the text with which a program of two lines fails that turns the hand by `by` in the second.
std::string failure_of_turn(const std::string& by, const std::string& more) {
  const test::Folder folder;
  LockStepCell run(with_program(folder,
                                "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                                "moveto joints(0, -30deg, 60deg, 0, 60deg + " +
                                    by + ", 0)\n",
                                more));
  while (!run.cell().program()->ended() && run.cell().loop().cycle().time < nanoseconds(30.0)) run.tick();
  const Problem why = run.cell().program()->status().problem.value_or(Problem{});
  return run.cell().program()->failed() ? why.code + " " + std::to_string(why.where.line) + " " + why.what
                                        : "none";
}

TEST(Moves, AMoveThatTiltsTheToolTooFarIsRefusedAtItsLine) {
  const test::Folder folder;
  LockStepCell there(with_program(folder, "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n", ""));
  while (!there.cell().finished() && there.cell().loop().cycle().time < nanoseconds(30.0)) there.tick();
  const Vec3 axis = there.cell().tcp(0).rotation * Vec3{0, 0, 1};
  const auto zone = [&](const std::string& profile) {
    return "workspace:\n  upright: {cone: [" + std::to_string(axis.x) + ", " + std::to_string(axis.y) + ", " +
           std::to_string(axis.z) + "], within: 90deg, profile: " + profile + "}\n";
  };
  EXPECT_EQ(failure_of_turn("-20deg", zone("full")), "none");
  const std::string why = failure_of_turn("-100deg", zone("full"));
  EXPECT_TRUE(why.starts_with("workspace 2 ")) << why;
  EXPECT_NE(why.find("leaves 'upright', 90.0 degrees are permitted"), std::string::npos) << why;
  EXPECT_EQ(failure_of_turn("-100deg", zone("reduced")), "none");
  EXPECT_NE(failure_of_turn("-100deg", zone("reduced") + "profile: reduced\n"), "none");
}

TEST(Moves, ARangeOfTheWorkspaceIsKeptByMoves) {
  const std::string zone = "workspace: {low: {joint: joint_5, range: [-10deg, 80deg]}}\n";
  EXPECT_EQ(failure_of_turn("-20deg", zone), "none");
  const std::string why = failure_of_turn("30deg", zone);
  EXPECT_TRUE(why.starts_with("workspace 2 ")) << why;
  EXPECT_NE(why.find("joint_5, at 1.396"), std::string::npos) << why;
  EXPECT_NE(why.find("leaves 'low', -0.1745 to 1.3963"), std::string::npos) << why;
}

TEST(Moves, AtReducedSpeedProgramsArePlannedForIt) {
  const test::Folder folder;
  const std::string program =
      "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
      "let start = here()\n"
      "movel offset(start, z = -300mm)\n"
      "movel start\n"
      "moveto joints(40deg, -30deg, 60deg, 0, 60deg, 0)\n";
  struct Drive {
    double fastest = 0, fastest_joint = 0, time = 0;
  };
  const auto drive = [&](const std::string& more) {
    LockStepCell run(with_program(folder, program, more));
    Drive out;
    const std::vector<Vec3> way = drawn(run, 120);
    for (std::size_t i = 1; i < way.size(); ++i)
      out.fastest = std::max(out.fastest, norm(way[i] - way[i - 1]) / seconds(cell::Cell::kTick));
    out.time = seconds(run.cell().loop().cycle().time);
    EXPECT_TRUE(run.cell().loop().limits().report().empty()) << more;
    return out;
  };
  const Drive full = drive("");
  EXPECT_GT(full.fastest, 0.4);
  const Drive reduced = drive("profile: reduced\nprofiles: {reduced: {joint_speed: 100%}}\n");
  EXPECT_LE(reduced.fastest, 0.25 * (1 + 1e-3));
  EXPECT_GT(reduced.fastest, 0.24) << "and no slower than it may be";
  EXPECT_LE(drive("profiles: {full: {tcp_speed: 100mm/s}}\n").fastest, 0.1 * (1 + 1e-3));
  const Drive joints = drive("profile: reduced\n");
  EXPECT_LE(joints.fastest, 0.25 * (1 + 1e-3));
  EXPECT_GT(joints.time, reduced.time);
}

TEST(Moves, APlanOfFullSpeedIsGovernedWhenTheProfileBecomesReduced) {
  const test::Folder folder;
  LockStepCell run(with_program(folder,
                                "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                                "let start = here()\n"
                                "movel offset(start, z = -300mm), speed 300mm/s\n",
                                ""));
  const auto speed = [&] {
    const Vec3 before = run.cell().tcp(0).position;
    run.tick();
    return norm(run.cell().tcp(0).position - before) / seconds(cell::Cell::kTick);
  };
  Vec3 at = run.cell().tcp(0).position;
  for (int i = 0; i < 5000 && !(speed() > 0.29 && run.cell().tcp(0).position.z < at.z); ++i)
    at = run.cell().tcp(0).position;
  run.give(test::Json{{"request", "profile"}, {"name", "reduced"}});
  run.run(0.3);
  double most = 0;
  for (int i = 0; i < 200; ++i) most = std::max(most, speed());
  EXPECT_LE(most, 0.25);
  EXPECT_GT(most, 0);
}

/// The joints and TCP at rest after each line from the second on.
struct Rest {
  std::vector<double> joints;
  Pose tcp;
};
std::vector<Rest> rests(LockStepCell& run, int lines) {
  std::vector<Rest> out;
  Rest last;
  for (int line = 2; !run.cell().finished() && run.cell().loop().cycle().time < nanoseconds(60.0);) {
    Rest at{{}, run.cell().tcp(0)};
    for (int j = 1; j <= 6; ++j)
      at.joints.push_back(run.cell().snapshot().commands[*run.cell().loop().table().find_command(
          "arm/joint_" + std::to_string(j) + "/position")]);
    for (const int now = run.cell().program()->status().where.line; line < now && line <= lines; ++line)
      out.push_back(at);
    last = at;
    run.tick();
  }
  out.push_back(last);
  EXPECT_TRUE(run.cell().finished());
  EXPECT_FALSE(run.cell().program()->failed())
      << run.cell().program()->status().problem.value_or(Problem{}).text();
  return out;
}

TEST(Moves, AtAVelocityItGoesSoFarAsThatAndTheTime) {
  const test::Folder folder;
  LockStepCell run(with_program(folder,
                                "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                                "wait 10ms\n"
                                "speedl {x = 20mm/s, z = -50mm/s}, duration 2s\n"
                                "wait 10ms\n"
                                "speedj {joint_1 = 10deg/s, joint_4 = -20deg/s}, duration 1500ms\n"
                                "wait 10ms\n"
                                "speedl {rz = 30deg/s}, duration 1s\n"
                                "wait 10ms\n"
                                "speedl {z = 40mm/s}, duration 1s, frame \"arm/tcp\"\n"
                                "wait 10ms\n",
                                ""));
  const std::vector<Rest> at = rests(run, 11);
  ASSERT_GE(at.size(), 9u);
  const Rest &start = at[0], &lower = at[2], &turned = at[4], &about = at[6], &out = at[8];
  EXPECT_LT(norm(lower.tcp.position - start.tcp.position - Vec3{0.04, 0, -0.1}), 1e-6);
  EXPECT_LT(angle_between(lower.tcp.rotation, start.tcp.rotation), 1e-6);
  EXPECT_NEAR(turned.joints[0] - lower.joints[0], 15 * M_PI / 180, 1e-9);
  EXPECT_NEAR(turned.joints[3] - lower.joints[3], -30 * M_PI / 180, 1e-9);
  EXPECT_NEAR(turned.joints[1], lower.joints[1], 1e-9);
  EXPECT_LT(norm(about.tcp.position - turned.tcp.position), 1e-6);
  const Vec3 turn = to_rotation_vector(about.tcp.rotation * inverse(turned.tcp.rotation));
  EXPECT_LT(norm(turn - Vec3{0, 0, M_PI / 6}), 1e-6);
  EXPECT_LT(norm(out.tcp.position - about.tcp.position - about.tcp.rotation * Vec3{0, 0, 0.04}), 1e-6);
}

TEST(Moves, AtAVelocityItIsNoFasterAndEndsWhereAConditionIsTrue) {
  const test::Folder folder;
  folder.write("d.data", "Name: Far\nBool: False\n");
  LockStepCell run(
      with_program(folder,
                   "load d\n"
                   "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                   "speedl {z = -50mm/s}, duration 4s, at start + 100mm set Far = true, until Far else\n"
                   "  raise \"went all the way\"\n"
                   "end\n",
                   ""));
  double fastest = 0, lowest = 9, highest = 0;
  Vec3 before = run.cell().tcp(0).position;
  while (!run.cell().finished() && run.cell().loop().cycle().time < nanoseconds(30.0)) {
    run.tick();
    const Vec3 now = run.cell().tcp(0).position;
    if (run.cell().program()->status().where.line == 3) {
      fastest = std::max(fastest, norm(now - before) / seconds(cell::Cell::kTick));
      lowest = std::min(lowest, now.z), highest = std::max(highest, now.z);
    }
    before = now;
  }
  EXPECT_FALSE(run.cell().program()->failed())
      << run.cell().program()->status().problem.value_or(Problem{}).text();
  EXPECT_LE(fastest, 0.05 * (1 + 1e-6));
  EXPECT_GT(fastest, 0.0499);
  EXPECT_GT(highest - lowest, 0.1);
  EXPECT_LT(highest - lowest, 0.11);
}

TEST(Moves, InAConditionHereIsWhereTheToolIsNow) {
  const test::Folder folder;
  folder.write("d.data", "Name: Lamp\nBool: False\n");
  LockStepCell run(
      with_program(folder,
                   "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                   "let from = here()\n"
                   "movel offset(from, z = -200mm), speed 100mm/s, until here().z < from.z - 80mm else\n"
                   "  raise \"it went the whole way\"\n"
                   "end\n"
                   "if here().z > from.z - 80mm or here().z < from.z - 95mm\n"
                   "  raise \"it stopped at {from.z - here().z:.2mm}\"\n"
                   "end\n",
                   ""));
  run.run(30);
  EXPECT_FALSE(run.cell().program()->failed())
      << run.cell().program()->status().problem.value_or(Problem{}).text();
}

/// A trap stops the line, moves the robot aside and lets it go on: the TCP is on the line before and afterwards.
TEST(Moves, ATrapInterruptsALineWhichGoesOnFromItsPlace) {
  const test::Folder folder;
  folder.write("d.data", "Name: Door\nBool: False\nName: Lamp\nBool: False\n");
  LockStepCell run(with_program(folder,
                                "load d\n"
                                "let n = 0\n"
                                "trap when Door\n"
                                "  set n = n + 1\n"
                                "  movej joints(20deg, -30deg, 60deg, 0, 60deg, 0), speed 40%\n"
                                "  set Lamp = true\n"
                                "end\n"
                                "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                                "let from = here()\n"
                                "movel offset(from, z = -200mm), speed 100mm/s, at start + 50mm set Door = true\n"
                                "wait 10ms\n"
                                "if n != 1 or not Lamp or abs(here().z - (from.z - 200mm)) > 0.001mm\n"
                                "  raise \"it did not do what it should\"\n"
                                "end\n",
                                ""));
  Vec3 from;
  Nanoseconds sprung = 0;
  double away = 0, after = 0;
  bool lamp = false;
  while (!run.cell().finished() && run.cell().loop().cycle().time < nanoseconds(60.0)) {
    run.tick();
    const Vec3 now = run.cell().tcp(0).position;
    const auto status = run.cell().program()->interpreter().status();
    const bool in_trap = std::any_of(status.begin(), status.end(), [](const auto& task) { return task.name == "trap"; });
    if (in_trap && sprung == 0) sprung = run.cell().loop().cycle().time;
    if (sprung == 0) from = now;
    if (in_trap) away = std::max(away, std::hypot(now.x - from.x, now.y - from.y));
    lamp = lamp || run.cell().in().data.store.find("Lamp")->text() == "True";
    if (sprung > 0 && !in_trap) after = std::max(after, std::hypot(now.x - from.x, now.y - from.y));
  }
  EXPECT_FALSE(run.cell().program()->failed())
      << run.cell().program()->status().problem.value_or(Problem{}).text();
  EXPECT_GT(sprung, 0);
  EXPECT_GT(away, 0.05) << "the block moved the robot";
  EXPECT_LT(after, 1e-6) << "afterwards it is on the line";
  EXPECT_TRUE(lamp);
}

TEST(Moves, VelocitiesThatCannotBeAreRefusedWithTheirLine) {
  const auto told = [](const std::string& line) {
    const test::Folder folder;
    const auto file = with_program(folder, "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n" + line, "");
    LockStepCell before(file), run(file);
    const std::size_t problems = cell::rehearse(before.cell().in()).problems.list().size();
    EXPECT_EQ(problems, 1u) << "told by a rehearsal, too";
    while (!run.cell().finished() && run.cell().loop().cycle().time < nanoseconds(30.0)) run.tick();
    const Problem why = run.cell().program()->status().problem.value_or(Problem{});
    EXPECT_EQ(why.where.line, 2);
    return why.code + ": " + why.what;
  };
  EXPECT_NE(told("speedl {rz = 60deg/s}, duration 4s\n").find("turn-too-large: it would turn by 240 deg"),
            std::string::npos);
  EXPECT_NE(told("speedj {joint_7 = 60deg/s}, duration 1s\n").find("unknown-joint"), std::string::npos);
  EXPECT_NE(told("speedj {joint_1 = 60mm/s}, duration 1s\n").find("'joint_1' turns"), std::string::npos);
  EXPECT_NE(told("speedl {z = 1m/s}, duration 5s\n").find("unreachable"), std::string::npos);
}

}  // namespace
}  // namespace polyarm
