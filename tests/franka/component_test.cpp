/// The driver against the simulated robot: states, commands, limits, hand, life cycle.
#include <algorithm>
#include <random>

#include "polyarm/trajectory/joint_move.hpp"
#include "tests/franka/rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm {
namespace {

using test::FrankaRig;
using namespace test;
using franka::Machine;
using franka::RobotMode;

TEST(FrankaComponent, ReadsWhatTheRobotSends) {
  FrankaRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.read();
  EXPECT_NEAR(rig.state("fr3_joint4/position"), -2.2, 1e-9) << "before it is active";
  EXPECT_EQ(rig.state("controller/mode"), 1) << "idle";
  EXPECT_EQ(rig.state("controller/ready"), 0);
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  rig.far().order("force=15");
  // The share counts the last 100 commands; the clock did not wait for the first ones of a motion.
  ASSERT_TRUE(rig.runs(130, [](int) {})) << rig.component.reason();
  EXPECT_EQ(rig.state("controller/mode"), 2);
  EXPECT_EQ(rig.state("controller/ready"), 1);
  EXPECT_EQ(rig.state("controller/error"), -1);
  EXPECT_GE(rig.state("controller/success_rate"), 0.97);
  EXPECT_EQ(rig.state("controller/lost_states"), 0);
  EXPECT_EQ(rig.state("force_base/force.z"), 15);
  EXPECT_NEAR(std::hypot(rig.state("force/force.x"), rig.state("force/force.y"), rig.state("force/force.z")),
              15, 1e-9);
  EXPECT_LT(rig.state("force/force.z"), -5) << "the hand looks down";
  EXPECT_GT(std::abs(rig.state("fr3_joint2/external_torque")), 3) << "the arm is a lever";
}

TEST(FrankaComponent, TheTcpIsWhereTheCataloguesKinematicsHaveIt) {
  FrankaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(2, [](int) {}));
  int tip = -1;
  for (std::size_t i = 0; i < franka_model().links.size(); ++i)
    if (franka_model().links[i].name == "flange") tip = static_cast<int>(i);
  const Pose flange = kinematics::Chain(franka_model(), tip).forward(rig.q());
  EXPECT_NEAR(rig.state("tcp_pose/position.x"), flange.position.x, 1e-9);
  EXPECT_NEAR(rig.state("tcp_pose/position.z"), flange.position.z, 1e-9);
  const Quaternion r{rig.state("tcp_pose/orientation.x"), rig.state("tcp_pose/orientation.y"),
                     rig.state("tcp_pose/orientation.z"), rig.state("tcp_pose/orientation.w")};
  EXPECT_LT(angle_between(r, flange.rotation), 1e-6);
}

/// The limits of moves, as a cell plans them for a robot of the catalogue.
std::vector<trajectory::JointMotionLimits> catalogue_limits(const char* model) {
  std::vector<trajectory::JointMotionLimits> out;
  for (const description::Joint& joint : franka_model(model).joints)
    if (joint.limits.velocity)
      out.push_back({*joint.limits.velocity, *joint.limits.acceleration, *joint.limits.jerk});
  return out;
}

/// Anywhere in the range; every third time at one of its ends, except for `margin` rad.
std::vector<double> anywhere(const char* model, std::mt19937& random, double margin) {
  const franka::MachineFacts facts = franka::facts_of(franka_model(model));
  std::vector<double> out;
  for (std::size_t i = 0; i < 7; ++i) {
    const double lower = facts.lower[i] + margin, upper = facts.upper[i] - margin;
    const double share = static_cast<double>(random() % 1001) / 1000;
    out.push_back(random() % 3 > 0 ? lower + share * (upper - lower) : share < 0.5 ? lower : upper);
  }
  return out;
}

/// A Research 3 allows less speed towards the ends of its ranges. Its accelerations in the catalogue are so
/// low that a move which ends within the range keeps to that.
TEST(FrankaCatalogue, MovesAtFullSpeedKeepTheSpeedThatTheRobotAllows) {
  for (const char* model : {"franka/fr3", "franka/fp3", "franka/fer_panda"}) {
    const int version = franka::facts_of(franka_model(model)).version;
    const auto limits = catalogue_limits(model);
    ASSERT_EQ(limits.size(), 7u);
    for (std::size_t j = 0; j < 7; ++j) {
      EXPECT_LE(limits[j].acceleration, franka::motion_limits(version).acceleration[j]) << model << j;
      EXPECT_LE(limits[j].jerk, franka::motion_limits(version).jerk[j]) << model << j;
    }
    std::mt19937 random(3);
    for (int move = 0; move < 200; ++move) {
      const auto from = anywhere(model, random, 0.035), to = anywhere(model, random, 0.035);
      const trajectory::Trajectory path = trajectory::plan_joint_move(from, to, limits);
      std::vector<double> q(7), v(7);
      std::size_t hint = 0;
      for (int i = 0; i <= 200; ++i) {
        path.sample(path.duration() * i / 200, q, v, {}, hint);
        for (std::size_t j = 0; j < 7; ++j) {
          const auto bounds = franka::velocity_bounds(version, j, q[j]);
          ASSERT_LE(v[j], bounds.upper + 1e-9) << model << " joint " << j + 1 << " at " << q[j];
          ASSERT_GE(v[j], bounds.lower - 1e-9) << model << " joint " << j + 1 << " at " << q[j];
        }
      }
    }
  }
}

struct Robot {
  const char* model;
  const char* joint;
};
class Robots : public testing::TestWithParam<Robot> {};
INSTANTIATE_TEST_SUITE_P(Models, Robots,
                         testing::Values(Robot{"franka/fr3", "fr3_joint"},
                                         Robot{"franka/fer_panda", "fer_joint"}),
                         [](const auto& robot) { return std::string(robot.param.model).substr(7); });

TEST_P(Robots, EachJointFollowsItsCommands) {
  FrankaRig rig(Parameters{}, GetParam().model);
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  for (std::size_t j = 0; j < 7; ++j) {
    const double from = rig.commands[j];
    ASSERT_TRUE(rig.runs(700, [&](int i) { rig.commands[j] = from + 0.15 * smooth((i + 1) / 500.0); }))
        << rig.component.reason();
    EXPECT_NEAR(rig.states[4 * j], from + 0.15, 1e-9) << "joint " << j + 1;
  }
  EXPECT_EQ(rig.state("controller/shaped"), 0);
}

TEST_P(Robots, RandomCommandsNeverExceedALimitOfTheRobot) {
  FrankaRig rig(Parameters{{"max_speed", "300"}, {"max_behind", "0.2"}}, GetParam().model);
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  std::mt19937 random(5);
  std::array<double, 7> from{};
  std::copy_n(rig.commands.begin(), 7, from.begin());
  rig.far().with([](Machine& m) { return m.take_extremes(); });
  ASSERT_TRUE(rig.runs(4000, [&](int i) {
    if (i % 40 == 0)
      for (std::size_t j = 0; j < 7; ++j)
        rig.commands[j] = from[j] + 0.03 * (static_cast<double>(random() % 2001) / 1000 - 1);
  })) << rig.component.reason();
  EXPECT_GT(rig.state("controller/shaped"), 1000) << "it had to hold back";
  const auto shares = rig.far().with([](Machine& m) { return m.take_extremes(); });
  for (std::size_t i = 0; i < 3; ++i) EXPECT_LE(shares[i], 1.0) << i;
  EXPECT_GT(shares[1], 0.5) << "it uses what there is";
}

/// The motion, in the cycles of the robot.
void follow(FrankaRig& rig, const trajectory::Trajectory& path, double until) {
  std::vector<double> q(7);
  std::size_t hint = 0;
  const int cycles = static_cast<int>(std::ceil(until * 1000));
  ASSERT_TRUE(rig.runs(cycles, [&](int i) {
    path.sample(std::min(0.001 * (i + 1), until), q, {}, {}, hint);
    std::copy_n(q.begin(), 7, rig.commands.begin());
  })) << rig.component.reason();
}

TEST_P(Robots, MovesAtTheCataloguesSpeedRunAcrossTheWholeRange) {
  const char* const model = GetParam().model;
  FrankaRig rig(Parameters{}, model);
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  std::mt19937 random(11);
  double fastest = 0;
  for (int move = 0; move < 6; ++move) {
    const std::vector<double> from(rig.commands.begin(), rig.commands.begin() + 7);
    const auto path =
        trajectory::plan_joint_move(from, anywhere(model, random, 0.035), catalogue_limits(model));
    ASSERT_NO_FATAL_FAILURE(follow(rig, path, path.duration())) << move;
    ASSERT_TRUE(rig.runs(200, [](int) {})) << rig.component.reason();
    EXPECT_LE(rig.state("controller/behind"), 1e-6) << "it arrives: " << move;
    fastest = std::max(fastest, rig.far().with([](Machine& m) { return m.take_extremes()[0]; }));
  }
  EXPECT_GT(fastest, 0.9) << "of the speed of a joint";
}

/// The hardest stop of a cell has three times the acceleration and nine times the jerk of a move.
TEST(FrankaComponent, TheHardestStopOfACellIsFollowed) {
  const char* const model = "franka/fr3";
  FrankaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  auto limits = catalogue_limits(model);
  const std::vector<double> from(rig.commands.begin(), rig.commands.begin() + 7);
  std::vector<double> to = from, q(7), v(7), a(7);
  to[0] += 1.5, to[1] += 0.7, to[4] -= 2;
  const auto path = trajectory::plan_joint_move(from, to, limits);
  const double half = std::floor(path.duration() * 500) / 1000;
  ASSERT_NO_FATAL_FAILURE(follow(rig, path, half));
  std::size_t hint = 0;
  path.sample(half, q, v, a, hint);
  for (auto& joint : limits) joint.acceleration *= 3, joint.jerk *= 9;
  const auto stop = trajectory::plan_stop(q, v, a, limits);
  ASSERT_NO_FATAL_FAILURE(follow(rig, stop, stop.duration()));
  ASSERT_TRUE(rig.runs(200, [](int) {})) << rig.component.reason();
  EXPECT_LE(rig.state("controller/behind"), 1e-6);
}

/// A Research 3 is slower near the ends of its range.
TEST(FrankaComponent, TheLimitOfSpeedNearTheEndOfARangeIsKept) {
  FrankaRig rig(Parameters{{"max_speed", "150"}, {"max_behind", "0.2"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.commands[0];
  const bool failed = static_cast<bool>(
      rig.fails(2500, [&](int i) { rig.commands[0] = std::min(2.74, from + travel(i, 0.0024, 600)); }));
  EXPECT_TRUE(!failed || rig.component.cause() == Cause::too_fast ||
              rig.component.cause() == Cause::position_limit)
      << rig.component.reason();
  EXPECT_TRUE(rig.far().with([](Machine& m) { return m.errors().none(); }))
      << "the robot had no reason to stop";
  EXPECT_GT(rig.q()[0], 2.0) << rig.component.reason();
}

TEST(FrankaComponent, TheRobotComesToRestBeforeTheEndOfARange) {
  FrankaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.commands[5];
  ASSERT_TRUE(rig.fails(8000, [&](int i) { rig.commands[5] = from + travel(i, 0.0008, 300); }));
  EXPECT_EQ(rig.component.cause(), Cause::position_limit) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("joint 6"), std::string::npos) << rig.component.reason();
  EXPECT_TRUE(rig.far().with([](Machine& m) { return m.errors().none(); }));
  EXPECT_LT(rig.q()[5], 4.5169);
  EXPECT_GT(rig.q()[5], 4.4);
}

TEST(FrankaComponent, NothingMovesWhenTheArmHangsBelowItsCommand) {
  FrankaRig rig;
  rig.far().order("sag=4");
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  for (int i = 0; i < 200; ++i) rig.far().step();
  rig.forget_jumps();
  const auto desired = rig.far().with([](Machine& m) { return m.q_d(); });
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(rig.activate()) << rig.component.reason();
    ASSERT_TRUE(rig.runs(100, [](int) {}));
    EXPECT_LE(rig.largest_jump(), 1e-9)
        << "the robot's own position stays, though the arm is measured elsewhere";
    EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  }
  EXPECT_EQ(rig.far().with([](Machine& m) { return m.q_d(); }), desired);
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  const double from = rig.commands[1];
  ASSERT_TRUE(rig.runs(1200, [&](int i) { rig.commands[1] = from + 0.5 * smooth((i + 1) / 1000.0); }));
  EXPECT_NEAR(rig.far().with([](Machine& m) { return m.q_d()[1]; }) * kDegree, from + 0.5, 1e-4)
      << "the difference fades away on the way";
}

TEST(FrankaComponent, VelocitiesMoveTheRobotWithinItsLimits) {
  FrankaRig rig(Parameters{{"command", "velocity"}});
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  ASSERT_EQ(rig.component.on_activate(), CallbackReturn::success) << rig.component.reason();
  std::fill_n(rig.commands.begin(), 7, 0.0);
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  const double before = rig.state("fr3_joint1/position");
  rig.command("fr3_joint1/velocity") = 0.5;  // a step
  ASSERT_TRUE(rig.runs(1000, [](int) {})) << rig.component.reason();
  EXPECT_NEAR(rig.state("fr3_joint1/velocity"), 0.5, 1e-6);
  EXPECT_NEAR(rig.state("fr3_joint1/position"), before + 0.5, 0.04);
  rig.command("fr3_joint1/velocity") = 0;
  ASSERT_TRUE(rig.runs(300, [](int) {})) << rig.component.reason();
  EXPECT_NEAR(rig.state("fr3_joint1/velocity"), 0, 1e-9);
  const auto shares = rig.far().with([](Machine& m) { return m.take_extremes(); });
  EXPECT_LE(shares[1], 1.0);
  EXPECT_LE(shares[2], 1.0);
  rig.command("fr3_joint1/velocity") = 0.9;
  ASSERT_TRUE(rig.fails(8000, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::position_limit) << rig.component.reason();
  expect_standing(rig);
  EXPECT_LT(rig.q()[0], 2.7437);
}

TEST(FrankaComponent, WithoutACommandTheArmHoldsAndGoesOnFromThere) {
  FrankaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.commands[1];
  ASSERT_TRUE(rig.runs(300, [&](int i) { rig.commands[1] = from + travel(i, 0.0003); }));
  rig.commands[3] = std::nan("");
  ASSERT_TRUE(rig.runs(400, [](int) {}));
  const double at = rig.states[4];
  EXPECT_GT(at, from + travel(299, 0.0003)) << "it was braked, not stopped at once";
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  EXPECT_NEAR(rig.states[4], at, 1e-9) << "it stands";
  rig.hold();
  ASSERT_TRUE(rig.runs(50, [](int) {})) << rig.component.reason();
}

TEST(FrankaComponent, DeactivatingWhileItMovesBrakesAndEndsTheMotion) {
  FrankaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.commands[0];
  ASSERT_TRUE(rig.runs(300, [&](int i) { rig.commands[0] = from + travel(i, 0.0006, 150); }));
  const double last = rig.commands[0];
  rig.forget_jumps();
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(rig.component.cause(), Cause::none) << rig.component.reason();
  EXPECT_LE(rig.largest_jump(), 0.0006 + 1e-6);
  EXPECT_EQ(rig.far().with([](Machine& m) { return m.mode(); }), RobotMode::idle);
  EXPECT_TRUE(rig.far().with([](Machine& m) { return m.errors().none(); })) << "its own end, no reflex";
  EXPECT_GT(rig.q()[0], last + 0.002) << "it did not stop at once";
  ASSERT_EQ(rig.read(), ReturnType::ok);
  expect_standing(rig);
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  EXPECT_TRUE(rig.runs(10, [](int) {}));
}

TEST(FrankaComponent, ActivatingSetsWhatTheParametersName) {
  FrankaRig rig(Parameters{{"collision_torque", "30"},
                           {"contact_torque", "10 10 10 10 8 8 8"},
                           {"collision_force", "50"},
                           {"joint_stiffness", "2000"},
                           {"cartesian_stiffness", "1000 1000 1500 50 50 50"},
                           {"guiding", "x y elbow"},
                           {"load_mass", "0.7"},
                           {"load_center", "0 0 0.05"}});
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  EXPECT_EQ(rig.far().with([](Machine& m) { return m.load().mass; }), 0) << "configuring sets nothing";
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  rig.far().with([](Machine& m) {
    EXPECT_EQ(m.collision().upper_torque[6], 30);
    EXPECT_EQ(m.collision().lower_torque[6], 8);
    EXPECT_EQ(m.collision().upper_force[2], 50);
    EXPECT_EQ(m.collision().lower_force[2], 25) << "half of it";
    EXPECT_EQ(m.joint_stiffness()[3], 2000);
    EXPECT_EQ(m.cartesian_stiffness()[2], 1500);
    EXPECT_EQ(m.guiding_axes(), (std::array<bool, 7>{true, true, false, false, false, false, true}));
    EXPECT_EQ(m.load().mass, 0.7);
    EXPECT_EQ(m.load().center[2], 0.05);
    return 0;
  });
}

TEST(FrankaComponent, TheVersionOfTheRobotIsFound) {
  for (const int version : {5, 6, 7, 8, 9, 10}) {
    FarSideOptions options = far_options();
    options.machine.facts.version = version;
    options.patience = 100'000'000;
    Alone alone(options);
    ASSERT_TRUE(alone.start()) << version << " " << alone.component.reason();
    EXPECT_NE(alone.component.summary().find("interface version " + std::to_string(version)),
              std::string::npos)
        << alone.component.summary();
  }
}

TEST(FrankaHand, GraspsOpensAndFindsItsRange) {
  FrankaRig rig(Parameters{{"hand", "true"}, {"hand_speed", "0.1"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  EXPECT_NEAR(rig.state("tool/width"), 0.04, 1e-9) << "nothing moves by itself";
  rig.command("tool/homing") = 1;
  ASSERT_TRUE(rig.runs(3000, [](int) {})) << rig.component.reason();
  EXPECT_EQ(rig.state("tool/max_width"), 0.08);
  EXPECT_EQ(rig.state("tool/busy"), 0);
  rig.command("tool/grip") = 0;
  ASSERT_TRUE(rig.runs(1500, [](int) {})) << rig.component.reason();
  EXPECT_NEAR(rig.state("tool/width"), 0.08, 1e-9);
  rig.far().order("part=30");
  rig.command("tool/grip") = 1;
  ASSERT_TRUE(rig.runs(1500, [](int) {})) << rig.component.reason();
  EXPECT_NEAR(rig.state("tool/width"), 0.03, 1e-9);
  EXPECT_EQ(rig.state("tool/part_present"), 1);
  rig.command("tool/grip") = 0;
  ASSERT_TRUE(rig.runs(100, [](int) {}));
  rig.command("tool/grip") = 1;  // while it opens: it is stopped, then it grasps
  ASSERT_TRUE(rig.runs(1500, [](int) {})) << rig.component.reason();
  EXPECT_EQ(rig.state("tool/part_present"), 1);
  rig.far().order("part=0");
  rig.command("tool/grip") = 0;
  ASSERT_TRUE(rig.runs(1500, [](int) {}));
  rig.command("tool/grip") = 1;
  ASSERT_TRUE(rig.runs(1500, [](int) {}))
      << "nothing between the fingers is no fault: " << rig.component.reason();
  EXPECT_EQ(rig.state("tool/part_present"), 0);
  rig.command("tool/width") = 0.05;
  ASSERT_TRUE(rig.runs(1500, [](int) {})) << rig.component.reason();
  EXPECT_NEAR(rig.state("tool/width"), 0.05, 1e-9);
}

TEST(FrankaComponent, WrongParametersAreNamed) {
  EXPECT_THROW(franka::FrankaComponent().on_init(franka_context()), Error) << "a host must be given";
  for (const auto& [name, value] :
       std::initializer_list<std::pair<std::string, std::string>>{{"command", "torque"},
                                                                  {"controller", "mine"},
                                                                  {"version", "4"},
                                                                  {"collision_torque", "1 2"},
                                                                  {"collision_force", "x"},
                                                                  {"contact_force", "-1"},
                                                                  {"guiding", "x w"},
                                                                  {"load_mass", "1"},
                                                                  {"load_center", "1 2"},
                                                                  {"port", "0"},
                                                                  {"recover", "7"}})
    EXPECT_THROW(franka::FrankaComponent().on_init(franka_context({{"host", "x"}, {name, value}})), Error)
        << name;
  EXPECT_THROW(franka::FakeFranka().on_init(franka_context({{"faults", "user_stop"}})), Error);
  EXPECT_THROW(franka::FakeFranka().on_init(franka_context({{"world", "moon"}})), Error);
  EXPECT_THROW(franka::FakeFranka().on_init(franka_context({}, "franka/fr3", 2'000'000)), Error) << "500 Hz";
  EXPECT_THROW(
      franka::FakeFranka().on_init(wire_context(catalogue_model("ufactory/xarm_6"), {}, kMillisecond, {})),
      Error);
}

TEST(FrankaComponent, AnotherRateOfTheCellIsNamed) {
  FarSide far(far_options());
  franka::FrankaComponent component;
  component.on_init(
      franka_context({{"host", "127.0.0.1"}, {"port", std::to_string(far.port())}}, "franka/fr3", 2'000'000));
  EXPECT_EQ(component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(component.cause(), Cause::wrong_rate) << component.reason();
  EXPECT_NE(component.reason().find("rate: 1000"), std::string::npos) << component.reason();
}

TEST(FrankaComponent, ReadAndWriteNeitherAllocateNorLock) {
  if (!RealtimeGuard::watches()) GTEST_SKIP();
  FarSideOptions options = far_options();
  options.patience = 1'000'000'000;
  Alone alone(options, {{"hand", "true"}});
  auto& component = alone.component;
  ASSERT_TRUE(component.paces());
  ASSERT_TRUE(alone.start()) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, kMillisecond, 0};
  component.await_cycle(1'000'000'000);
  component.read(cycle, states);
  for (std::size_t j = 0; j < 7; ++j) commands[j] = states[4 * j];
  std::string violations;
  bool fine = true;
  for (int i = 0; i < 300; ++i) {
    component.await_cycle(1'000'000'000);
    const RealtimeGuard guard;
    commands[0] += 1e-6 * std::min(i, 20);
    fine = component.read(cycle, states) == ReturnType::ok &&
           component.write(cycle, commands) == ReturnType::ok && fine;
    if (violations.empty()) violations = guard.violations();
  }
  EXPECT_TRUE(fine) << component.reason();
  EXPECT_EQ(violations, "");
}

}  // namespace
}  // namespace polyarm
