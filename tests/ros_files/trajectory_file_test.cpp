#include "polyarm/ros_files/trajectory_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "polyarm/timing/timing.hpp"
#include "polyarm/trajectory/splines.hpp"
#include "tests/description/support.hpp"
#include "tests/support/test_paths.hpp"

namespace polyarm {
namespace {

using namespace ros_files;
using description::test::has;
using description::test::Mutator;
using timing::TimedPath;
using trajectory::MotionLimits;

// As ros2 topic echo prints it.
constexpr const char* kRos2 = R"(header:
  stamp:
    sec: 0
    nanosec: 0
  frame_id: ''
joint_names:
- shoulder
- elbow
points:
- positions:
  - 0.0
  - 0.5
  velocities: []
  accelerations: []
  effort: []
  time_from_start:
    sec: 0
    nanosec: 0
- positions:
  - 1.0
  - -0.5
  velocities: []
  accelerations: []
  effort: []
  time_from_start:
    sec: 1
    nanosec: 500000000
---
)";
// As rostopic echo prints it.
constexpr const char* kRos1 = R"(header: 
  seq: 3
  stamp: 
    secs: 0
    nsecs:         0
  frame_id: ''
joint_names: [shoulder, elbow]
points: 
  - 
    positions: [0.0, 0.5]
    velocities: [0.0, 0.0]
    accelerations: []
    effort: []
    time_from_start: 
      secs: 0
      nsecs:         0
  - 
    positions: [1.0, -0.5]
    velocities: [0.0, 0.0]
    accelerations: []
    effort: []
    time_from_start: 
      secs: 1
      nsecs: 500000000
---
)";

std::string refusal(const std::string& text) {
  try {
    parse_trajectory(text, "way.yaml");
  } catch (const Error& e) {
    return e.what();
  }
  return "taken";
}
void says(const std::string& text, const std::vector<std::string>& pieces) {
  const std::string what = refusal(text);
  for (const std::string& piece : pieces) EXPECT_TRUE(has(what, piece));
}

TEST(TrajectoryFile, ReadsWhatRos2AndRos1Print) {
  for (const char* text : {kRos2, kRos1}) {
    const JointTrajectoryFile file = parse_trajectory(text, "way.yaml");
    EXPECT_EQ(file.message.joints, (std::vector<std::string>{"shoulder", "elbow"}));
    ASSERT_EQ(file.message.points.size(), 2u);
    EXPECT_EQ(file.message.points[1].positions, (std::vector<double>{1, -0.5}));
    EXPECT_DOUBLE_EQ(file.message.points[1].time_from_start, 1.5);
    EXPECT_FALSE(file.message.start);
  }
}

TEST(TrajectoryFile, TakesGoalsAndRobotTrajectoriesOff) {
  const std::string inner = "{joint_names: [a], points: [{positions: [1], time_from_start: 1}]}";
  for (const std::string& text : {"{trajectory: " + inner + "}", "{goal: {trajectory: " + inner + "}}",
                                  "{joint_trajectory: " + inner + "}"})
    EXPECT_EQ(parse_trajectory(text, "m").message.points.size(), 1u) << text;
}

TEST(TrajectoryFile, ComplaintsNameFileLinePointAndJoint) {
  const std::string head =
      "joint_names: [shoulder, elbow]\npoints:\n- positions: [0, 0]\n  time_from_start: 0\n";
  says(head + "- positions: [1, x]\n  time_from_start: 1\n", {"way.yaml:5:", "point 2", "elbow", "'x'"});
  says(head + "- positions: [1, '...']\n  time_from_start: 1\n", {"way.yaml:5:", "--full-length"});
  says(head + "- positions: [1]\n  time_from_start: 1\n",
       {"way.yaml:5:", "point 2 has 1 positions for 2 joints", "elbow"});
  says(head + "- {positions: [1, 2], velocities: [1, 2, 3], time_from_start: 1}\n", {"3 velocities"});
  says(head + "- positions: [1, 2]\n  time_from_start: 0\n", {"way.yaml:5:", "not after point 1"});
  says(head + "- positions: [1, 2]\n  time_from_start: -1\n", {"way.yaml:5:", "-1 s"});
  says(head + "- positions: [1, 2]\n", {"way.yaml:5:", "point 2 has no time_from_start"});
  says(head + "- positions: [1, .inf]\n  time_from_start: 1\n", {"way.yaml:5:", "elbow"});
  says(head + "- position: [1, 2]\n  time_from_start: 1\n", {"way.yaml:5:", "positions"});
  says("joint_names: [a]\npoints: []\n", {"way.yaml:2:", "no points"});
  says("joint_names: [a, a]\npoints: [{positions: [1, 1], time_from_start: 1}]\n", {"way.yaml:1:", "twice"});
  says("points: []\n", {"joint_names"});
  says("7", {"not a trajectory"});
  says("", {"not a trajectory"});
  // Everything at once.
  says(head + "- positions: [1]\n  time_from_start: 0\n", {"1 positions", "not after"});
}

TEST(TrajectoryFile, BringsJointsIntoTheRobotsOrder) {
  Problems warnings;
  JointTrajectoryFile file = parse_trajectory(kRos2, "way.yaml");
  order_joints(file, {"base", "elbow", "shoulder"}, {0.25, 9, 9}, warnings);
  EXPECT_EQ(file.message.points[1].positions, (std::vector<double>{0.25, -0.5, 1}));
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_TRUE(has(warnings.list()[0].text(), "base"));

  JointTrajectoryFile prefixed = parse_trajectory(kRos2, "way.yaml");
  order_joints(prefixed, {"arm/ur_elbow", "arm/ur_shoulder"}, {0, 0}, warnings);
  EXPECT_EQ(prefixed.message.points[1].positions, (std::vector<double>{-0.5, 1}));

  JointTrajectoryFile other = parse_trajectory(kRos2, "way.yaml");
  try {
    order_joints(other, {"elbows", "shoulder"}, {0, 0}, warnings);
    FAIL();
  } catch (const Error& e) {
    EXPECT_TRUE(has(e.what(), "did you mean 'elbows'"));
  }
}

TEST(TrajectoryFile, IsTimedAsTheControllerWould) {
  // Positions alone are linear, with velocities cubic.
  const auto linear = as_timed(parse_trajectory(kRos2, "way.yaml"), {9, 9});
  const auto cubic = as_timed(parse_trajectory(kRos1, "way.yaml"), {9, 9});
  std::vector<double> q(2), v(2);
  std::size_t hint = 0;
  linear.sample(0.375, q, v, {}, hint);
  EXPECT_DOUBLE_EQ(q[0], 0.25);
  EXPECT_DOUBLE_EQ(v[0], 1 / 1.5);
  cubic.sample(0.375, q, v, {}, hint);
  EXPECT_DOUBLE_EQ(q[0], 3.0 / 16 - 2.0 / 64);  // 3x² - 2x³ at a quarter
  cubic.sample(0, q, v, {}, hint);
  EXPECT_EQ(v[0], 0);
  EXPECT_EQ(cubic.duration(), 1.5);
  // A first point that is later is reached from the start state.
  const auto later = as_timed(
      parse_trajectory("{joint_names: [a], points: [{positions: [1], time_from_start: 2}]}", "m"), {0.5});
  later.sample(1, std::span(q).first(1), {}, {}, hint);
  EXPECT_DOUBLE_EQ(q[0], 0.75);
}

TEST(TrajectoryFile, WaypointsAreThePositions) {
  const auto points = as_waypoints(parse_trajectory(kRos1, "way.yaml"), 0.1);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].q, (std::vector<double>{1, -0.5}));
  EXPECT_EQ(points[1].radius, 0.1);
  EXPECT_EQ(points[1].name, "point 2");
  try {
    as_waypoints(
        parse_trajectory("joint_names: [a]\npoints:\n- {velocities: [1], time_from_start: 2}", "m.yaml"));
    FAIL();
  } catch (const Error& e) {
    EXPECT_TRUE(has(e.what(), "m.yaml:3:"));
  }
}

controllers::TrajectoryMessage random_message(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> draw(-3, 3);
  std::uniform_int_distribution<int> power(-40, 40), count(1, 5), field(0, 7);
  controllers::TrajectoryMessage m;
  for (int j = 0, n = count(engine); j < n; ++j) m.joints.push_back("joint \"" + std::to_string(j) + "\\\t");
  const int fields = field(engine);
  Nanoseconds time = 0;
  for (int i = 0, n = count(engine); i < n; ++i) {
    trajectory::TrajectoryPoint p;
    const auto fill = [&](std::vector<double>& list) {
      for (std::size_t j = 0; j < m.joints.size(); ++j)
        list.push_back(draw(engine) * std::pow(2, power(engine)) * (power(engine) != 0));
    };
    fill(p.positions);
    if (fields & 1) fill(p.velocities);
    if (fields & 2) fill(p.accelerations);
    if (fields & 4) fill(p.effort);
    p.time_from_start = seconds(time);
    time += 1 + Nanoseconds(1e9 * std::abs(draw(engine)));
    m.points.push_back(std::move(p));
  }
  return m;
}

TEST(TrajectoryFile, WhatIsWrittenReadsBackToTheBit) {
  std::mt19937_64 engine(5);
  for (int k = 0; k < 300; ++k) {
    const controllers::TrajectoryMessage m = random_message(engine);
    for (const TimeWords words : {TimeWords::ros2, TimeWords::ros1})
      for (const std::string& text : {to_yaml(m, words), to_json(m, words)}) {
        const controllers::TrajectoryMessage back = parse_trajectory(text, "m").message;
        ASSERT_EQ(back.joints, m.joints) << text;
        ASSERT_EQ(back.points.size(), m.points.size());
        for (std::size_t i = 0; i < m.points.size(); ++i) {
          EXPECT_EQ(back.points[i].positions, m.points[i].positions);
          EXPECT_EQ(back.points[i].velocities, m.points[i].velocities);
          EXPECT_EQ(back.points[i].accelerations, m.points[i].accelerations);
          EXPECT_EQ(back.points[i].effort, m.points[i].effort);
          EXPECT_EQ(nanoseconds(back.points[i].time_from_start), nanoseconds(m.points[i].time_from_start));
        }
      }
    EXPECT_TRUE(nlohmann::json::accept(to_json(m)));
  }
}

/// PyYAML takes 1e-08 for a word.
TEST(TrajectoryFile, EveryNumberHasItsPoint) {
  controllers::TrajectoryMessage m;
  m.joints = {"a"};
  m.points.push_back({{1e-8}, {1e22}, {-3}, {0.5}, 1});
  const std::string text = to_yaml(m);
  for (const char* number : {"[1.0e-08]", "[1.0e+22]", "[-3.0]", "[0.5]", "{sec: 1, nanosec: 0}"})
    EXPECT_TRUE(has(text, number));
}

TEST(TrajectoryFile, TimedPathsAreWrittenAsSamplesOrAsKnotsThatQuinticsFollow) {
  const auto path = test::random_spline(3, 5, 2);
  const std::vector<MotionLimits> limits(3, MotionLimits::symmetric(2, 5, 50));
  const TimedPath timed = timing::timed(path, limits);
  const std::vector<std::string> names{"a", "b", "c"};

  const auto samples = sampled(timed, 100, names);
  ASSERT_EQ(samples.points.size(), std::size_t(std::ceil(timed.duration() * 100)) + 1);
  EXPECT_DOUBLE_EQ(samples.points[7].time_from_start, 0.07);
  EXPECT_DOUBLE_EQ(samples.points.back().time_from_start, timed.duration());
  EXPECT_NEAR(samples.points.back().velocities[0], 0, 1e-12);

  const auto knots = knots_of(timed, 1e-6, names);
  const auto back = as_timed(parse_trajectory(to_yaml(knots), "m"), knots.points[0].positions);
  std::vector<double> there(3), here(3);
  std::size_t hint = 0, hint_back = 0;
  for (int i = 0; i <= 2000; ++i) {
    const double t = timed.duration() * i / 2000;
    timed.sample(t, there, {}, {}, {}, hint);
    back.sample(t, here, {}, {}, hint_back);
    for (std::size_t j = 0; j < 3; ++j) ASSERT_NEAR(there[j], here[j], 2e-6) << t;
  }
}

TEST(TrajectoryFile, SectionsAreWrittenOneBehindTheOther) {
  controllers::TrajectoryMessage a, b;
  a.joints = b.joints = {"x"};
  a.points = {{{0}, {}, {}, {}, 0}, {{1}, {}, {}, {}, 2}};
  b.points = {{{1}, {}, {}, {}, 0}, {{3}, {}, {}, {}, 1}};
  append(a, b);
  ASSERT_EQ(a.points.size(), 3u);
  EXPECT_EQ(a.points[2].time_from_start, 3);
}

TEST(TrajectoryFileFuzz, DamagedTextEndsInATrajectoryOrAnError) {
  Mutator mutate(61);
  const std::string good[] = {kRos2, kRos1, to_json(parse_trajectory(kRos1, "m").message)};
  int read = 0;
  for (int i = 0; i < 6000; ++i) {
    const std::string text = mutate(good[i % 3]);
    try {
      JointTrajectoryFile file = parse_trajectory(text, "m");
      ++read;
      Problems warnings;
      order_joints(file, {"shoulder", "elbow"}, {0, 0}, warnings);
      for (const auto& point : file.message.points) ASSERT_TRUE(std::isfinite(point.time_from_start));
      (void)as_waypoints(file);
      (void)as_timed(file, {0, 0});
    } catch (const Error& e) {
      EXPECT_FALSE(std::string(e.what()).empty());
    }
  }
  EXPECT_GT(read, 300) << "most damage is too much to say anything about the reader";
}

}  // namespace
}  // namespace polyarm
