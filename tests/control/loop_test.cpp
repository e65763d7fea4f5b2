#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "polyarm/broadcasters/joint_state_broadcaster.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/joint_control/forward_command_controller.hpp"
#include "polyarm/joint_control/joint_trajectory_controller.hpp"
#include "polyarm/paths/joint_path.hpp"
#include "polyarm/timing/timing.hpp"
#include "polyarm/trajectory/joint_move.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::control {
namespace {

constexpr int kJoints = 6;

/// Six joints that are where they were last told to be.
class Plant : public hardware::Component {
 public:
  hardware::CallbackReturn on_init(const hardware::ComponentContext&) override {
    return hardware::CallbackReturn::success;
  }
  std::vector<hardware::InterfaceDescription> state_interfaces() const override {
    std::vector<hardware::InterfaceDescription> out;
    for (int j = 0; j < kJoints; ++j) out.push_back({joint(j) + "/position", 0.1 * j});
    return out;
  }
  std::vector<hardware::InterfaceDescription> command_interfaces() const override {
    std::vector<hardware::InterfaceDescription> out;
    for (int j = 0; j < kJoints; ++j) out.push_back({joint(j) + "/position"});
    return out;
  }
  hardware::ReturnType read(const hardware::Cycle&, std::span<double> states) noexcept override {
    if (fails) return hardware::ReturnType::error;
    for (int j = 0; j < kJoints; ++j) {
      const auto k = static_cast<std::size_t>(j);
      if (std::isfinite(at_[k])) states[k] = at_[k];
    }
    if (std::isfinite(pushed)) states[0] = pushed;
    return hardware::ReturnType::ok;
  }
  hardware::ReturnType write(const hardware::Cycle&, std::span<const double> commands) noexcept override {
    std::copy(commands.begin(), commands.end(), at_.begin());
    return hardware::ReturnType::ok;
  }
  static std::string joint(int j) { return "arm/joint_" + std::to_string(j + 1); }
  static inline bool fails = false;
  static inline double pushed = std::numeric_limits<double>::quiet_NaN();  // where joint_1 has been pushed

 private:
  std::array<double, kJoints> at_ = [] {
    std::array<double, kJoints> nothing{};
    nothing.fill(std::numeric_limits<double>::quiet_NaN());
    return nothing;
  }();
};

struct Bench {
  ControlLoop loop{LoopOptions{}};
  controllers::JointTrajectoryController* jtc = nullptr;
  std::vector<controllers::JointFacts> joints;
  std::vector<trajectory::JointMotionLimits> limits;
  std::vector<double> at;
  std::uint64_t next_id = 1;

  explicit Bench(bool accelerations = false) {
    Plant::fails = false;
    Plant::pushed = std::numeric_limits<double>::quiet_NaN();
    loop.supervisor().watch_cell = false;
    loop.hardware().add(std::make_unique<Plant>(), {});
    loop.start_hardware();
    controllers::ControllerContext context;
    context.robot = "arm";
    for (int j = 0; j < kJoints; ++j) {
      joints.push_back({Plant::joint(j), false, -3, 3, 2.0, 8.0, 80.0});
      joints.back().states_acceleration = accelerations;
      limits.push_back({2.0, 8.0, 80.0});
      at.push_back(0.1 * j);
    }
    context.joints = joints;
    context.name = "jtc";
    for (int j = 0; j < kJoints; ++j)
      context.parameters.entries["joints"].values.push_back("joint_" + std::to_string(j + 1));
    auto made = std::make_unique<controllers::JointTrajectoryController>();
    jtc = made.get();
    loop.controllers().add(std::move(made), context);
    controllers::ControllerContext broadcaster;
    broadcaster.name = "jsb";
    broadcaster.joints = joints;
    loop.controllers().add(std::make_unique<controllers::JointStateBroadcaster>(), broadcaster);
    loop.controllers().activate("jtc");
    loop.controllers().activate("jsb");
    loop.prepare(joints);
  }

  void move(std::vector<double> target) {
    auto goal = std::make_unique<controllers::TrajectoryGoal>();
    goal->id = next_id++;
    goal->trajectory = trajectory::plan_joint_move(at, target, limits, {});
    ASSERT_TRUE(jtc->follow(goal));
    at = std::move(target);
  }
  /// Along a planned path with a rounded corner.
  timing::TimedPath go_along(const std::vector<std::vector<double>>& points) {
    std::vector<paths::JointWaypoint> way{{at}};
    for (const std::vector<double>& q : points) way.push_back({q, 0.1});
    std::shared_ptr<const paths::Path> path = std::move(paths::joint_lines(way).sections.front());
    std::vector<trajectory::MotionLimits> bounds(kJoints, trajectory::MotionLimits::symmetric(2, 8, 80));
    const timing::TimedPath timed = timing::timed(path, bounds);
    auto goal = std::make_unique<controllers::TrajectoryGoal>();
    goal->id = next_id++;
    goal->planned = std::make_unique<timing::PathFollower>(timed, bounds, jtc->period());
    EXPECT_TRUE(jtc->follow(goal));
    at = points.back();
    return timed;
  }
  double commanded(int j) { return loop.table().commands()[static_cast<std::size_t>(j)]; }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) loop.step_next();
  }
};

TEST(ControlLoop, HoldsWhereItFoundTheRobot) {
  Bench bench;
  bench.run(100);
  for (int j = 0; j < kJoints; ++j) EXPECT_DOUBLE_EQ(bench.commanded(j), 0.1 * j);
}

TEST(ControlLoop, FollowsATrajectoryToItsEnd) {
  Bench bench;
  bench.move({1, 0.5, 0, -0.5, 0.2, 0.3});
  bench.run(3000);
  EXPECT_EQ(bench.jtc->status().finished.load(), 1u);
  EXPECT_DOUBLE_EQ(bench.commanded(0), 1);
  EXPECT_DOUBLE_EQ(bench.commanded(3), -0.5);
  EXPECT_EQ(bench.loop.limits().clamps(), 0u);
}

TEST(ControlLoop, StopsOnThePathAndResumesWithoutAJump) {
  Bench straight, stopped;
  straight.move({1, 1, 1, 1, 1, 1});
  stopped.move({1, 1, 1, 1, 1, 1});
  std::vector<double> path;
  for (int i = 0; i < 4000; ++i) {
    straight.loop.step_next();
    path.push_back(straight.commanded(0));
  }
  stopped.run(249);
  const double earlier = stopped.commanded(0);
  stopped.run(1);
  stopped.loop.supervisor().latch().request(realtime::StopKind::controlled);
  double before = stopped.commanded(0), fastest = 0, speed = stopped.commanded(0) - earlier, hardest = 0;
  const auto watch = [&](int cycles) {
    for (int i = 0; i < cycles; ++i) {
      stopped.loop.step_next();
      fastest = std::max(fastest, std::abs(stopped.commanded(0) - before));
      hardest = std::max(hardest, std::abs(stopped.commanded(0) - before - speed));
      speed = stopped.commanded(0) - before;
      before = stopped.commanded(0);
      // On the path: all joints stand at the same share of the line as the first.
      const double share = stopped.commanded(0);
      for (int j = 1; j < kJoints; ++j)
        EXPECT_NEAR((stopped.commanded(j) - 0.1 * j) / (1 - 0.1 * j), share, 1e-9);
    }
  };
  watch(1500);
  EXPECT_EQ(stopped.loop.supervisor().state(), RunState::held);
  const double held_at = stopped.commanded(0);
  EXPECT_GT(held_at, 0.01);
  EXPECT_LT(held_at, 0.99);
  watch(500);
  EXPECT_DOUBLE_EQ(stopped.commanded(0), held_at);
  stopped.loop.supervisor().latch().clear();
  stopped.loop.post(Request::resume);
  watch(4000);
  EXPECT_DOUBLE_EQ(stopped.commanded(0), 1);
  EXPECT_LE(hardest, 8.0e-6 * 1.1) << "stop and resume stay within the acceleration limit";
  EXPECT_LE(fastest, 2.0e-3 * (1 + 1e-6)) << "never faster than the joint's velocity limit";
}

TEST(ControlLoop, AStopOfAPlannedPathIsHeldOnItAndResumesToItsEnd) {
  Bench bench;
  bench.loop.supervisor().set_share(0.8);
  const timing::TimedPath path = bench.go_along({{1, 0.5, 0, -0.5, 0.2, 0.3}, {0.5, 1, 0.5, 0.5, 0.5, 0}});
  bench.run(400);
  EXPECT_NEAR(bench.jtc->status().speed.load(), 0.8, 1e-9);
  bench.loop.supervisor().latch().request(realtime::StopKind::controlled);
  bench.run(600);
  EXPECT_EQ(bench.loop.supervisor().state(), RunState::held);
  std::vector<double> on(kJoints);
  std::size_t hint = 0;
  path.sample(bench.jtc->status().time.load(), on, {}, {}, {}, hint);
  for (int j = 0; j < kJoints; ++j) EXPECT_EQ(bench.commanded(j), on[static_cast<std::size_t>(j)]);
  bench.loop.supervisor().latch().clear();
  bench.loop.post(Request::resume);
  bench.run(4000);
  EXPECT_EQ(bench.jtc->status().finished.load(), 1u);
  EXPECT_NEAR(bench.commanded(1), 1, 1e-12);
  EXPECT_EQ(bench.loop.limits().clamps(), 0u);
}

TEST(ControlLoop, DiscardForgetsTheRestOfTheMove) {
  Bench bench;
  bench.move({1, 1, 1, 1, 1, 1});
  bench.run(300);
  bench.loop.supervisor().latch().request(realtime::StopKind::controlled);
  bench.run(1500);
  const double held_at = bench.commanded(0);
  bench.loop.post(Request::discard);
  bench.run(1);
  bench.loop.supervisor().latch().clear();
  bench.loop.post(Request::resume);
  bench.run(2000);
  EXPECT_DOUBLE_EQ(bench.commanded(0), held_at);
  EXPECT_EQ(bench.jtc->status().discarded.load(), 1u);
}

TEST(ControlLoop, RefusesAGoalThatWouldJump) {
  Bench bench;
  bench.run(10);
  bench.at[0] = 0.5;
  bench.move({1, 1, 1, 1, 1, 1});
  bench.run(10);
  EXPECT_EQ(bench.jtc->status().refused.load(), 1u);
  EXPECT_DOUBLE_EQ(bench.commanded(0), 0);
}

TEST(ControlLoop, AComponentErrorIsAFaultThatHolds) {
  Bench bench;
  bench.move({1, 1, 1, 1, 1, 1});
  bench.run(200);
  Plant::fails = true;
  bench.run(1000);
  EXPECT_EQ(bench.loop.supervisor().state(), RunState::fault);
  EXPECT_EQ(bench.loop.supervisor().cause(), StopCause::component);
  const double held_at = bench.commanded(0);
  Plant::fails = false;
  bench.run(100);
  EXPECT_DOUBLE_EQ(bench.commanded(0), held_at) << "nothing moves on recovery by itself";
  EXPECT_EQ(bench.loop.controllers().list()[0].state, hardware::LifecycleState::inactive)
      << "what works on failed hardware is stopped with it";
  bench.loop.controllers().take_events();
  const double stands_at = bench.loop.table().states()[0];
  EXPECT_NE(stands_at, held_at) << "the last command was not done";
  hardware::Hardware& hardware = bench.loop.hardware();
  hardware.run(0, hardware::Step::error);
  hardware.run(0, hardware::Step::configure);
  hardware.run(0, hardware::Step::activate);
  bench.loop.controllers().switch_now({{"jtc", "jsb"}, {}});
  bench.loop.post(Request::recover);
  bench.loop.post(Request::resume);
  bench.run(4000);
  EXPECT_DOUBLE_EQ(bench.commanded(0), stands_at)
      << "it begins where it is measured, and the trajectory is not taken up again";
  bench.at = std::vector<double>{stands_at, 0, 0, 0, 0, 0};
  for (int j = 1; j < kJoints; ++j) bench.at[static_cast<std::size_t>(j)] = bench.commanded(j);
  bench.move({1, 1, 1, 1, 1, 1});
  bench.run(4000);
  EXPECT_DOUBLE_EQ(bench.commanded(0), 1);
}

TEST(ControlLoop, LateCyclesInARowAreCountedHeldOrAFaultAsTheCellSays) {
  for (const Overrun overrun : {Overrun::report, Overrun::hold, Overrun::fault}) {
    LoopOptions options;
    options.overrun = overrun;
    options.overrun_after = 3;
    ControlLoop loop(options);
    loop.supervisor().watch_cell = false;
    for (int k = 0; k < 10; ++k) {  // never three in a row
      EXPECT_FALSE(loop.woke(600'000, 0));
      EXPECT_FALSE(loop.woke(600'000, 0));
      EXPECT_FALSE(loop.woke(100'000, 0));
    }
    EXPECT_EQ(loop.supervisor().state(), RunState::running);
    EXPECT_EQ(std::uint64_t{loop.health().late}, 20u);
    for (int k = 0; k < 3; ++k) loop.woke(600'000, 0);
    const RunState wanted = overrun == Overrun::report ? RunState::running
                            : overrun == Overrun::hold ? RunState::stopping
                                                       : RunState::fault;
    EXPECT_EQ(loop.supervisor().state(), wanted);
    if (overrun != Overrun::report) {
      EXPECT_EQ(loop.supervisor().cause(), StopCause::late);
    }
  }
}

TEST(ControlLoop, HalfASecondThatWentMissingIsAGapAndLessIsNot) {
  ControlLoop loop(LoopOptions{});
  EXPECT_FALSE(loop.woke(0, 499));
  EXPECT_TRUE(loop.woke(0, 500));
}

TEST(ControlLoop, TwoControllersNeverShareACommand) {
  Bench bench;
  controllers::ControllerContext context;
  context.name = "forward";
  context.robot = "arm";
  context.joints = bench.joints;
  context.parameters.entries["joints"].values = {"joint_1"};
  context.parameters.entries["interface_name"].values = {"position"};
  bench.loop.controllers().add(std::make_unique<controllers::ForwardCommandController>(), context);
  EXPECT_THROW(bench.loop.controllers().activate("forward"), Error);
  bench.loop.controllers().deactivate("jtc");
  EXPECT_NO_THROW(bench.loop.controllers().activate("forward"));
}

TEST(ControlLoop, SameInputsGiveTheSameTrace) {
  Bench a, b, c;
  for (Bench* bench : {&a, &b}) bench->move({1, 0, 0, 0, 0, 0});
  c.move({1.0000001, 0, 0, 0, 0, 0});
  for (Bench* bench : {&a, &b, &c}) bench->run(2000);
  EXPECT_EQ(a.loop.trace().text(), b.loop.trace().text());
  EXPECT_NE(a.loop.trace().text(), c.loop.trace().text());
}

TEST(ControlLoop, LimitsHaveTheLastWord) {
  Bench bench;
  bench.loop.controllers().deactivate("jtc");
  controllers::ControllerContext context;
  context.name = "forward";
  context.robot = "arm";
  context.joints = bench.joints;
  context.parameters.entries["joints"].values = {"joint_1"};
  auto made = std::make_unique<controllers::ForwardCommandController>();
  auto* forward = made.get();
  bench.loop.controllers().add(std::move(made), context);
  bench.loop.controllers().activate("forward");
  forward->send(std::array{100.0});
  double last = bench.commanded(0);
  for (int i = 0; i < 3000; ++i) {
    bench.loop.step_next();
    EXPECT_LE(bench.commanded(0) - last, 2e-3 * (1 + 1e-5));
    last = bench.commanded(0);
  }
  EXPECT_DOUBLE_EQ(last, 3);
  EXPECT_GT(bench.loop.limits().clamps(), 0u);
}

TEST(ControlLoop, AJointFarOutsideItsLimitsIsAFaultAndCanBeBroughtBack) {
  for (const bool accelerations : {false, true}) {
    Bench bench(accelerations);
    const Supervisor& supervisor = bench.loop.supervisor();
    bench.run(10);
    const auto push = [&bench](double to) {  // as fast as a joint may be measured to move
      double at = std::isfinite(Plant::pushed) ? Plant::pushed : 0.0;
      while (at != to) {
        at += std::clamp(to - at, -0.02, 0.02);
        Plant::pushed = at;
        bench.run(1);
      }
    };
    push(3.008);
    bench.run(10);
    EXPECT_EQ(supervisor.state(), RunState::running) << "a little outside is none";
    {
      const test::RealtimeGuard guard;
      Plant::pushed = 3.01;
      bench.run(1);
      EXPECT_TRUE(guard.violations().empty() || !test::RealtimeGuard::watches()) << guard.violations();
    }
    EXPECT_EQ(supervisor.state(), RunState::fault);
    EXPECT_EQ(supervisor.cause(), StopCause::limits);
    ASSERT_GE(supervisor.event().interface, 0);
    EXPECT_EQ(bench.loop.table().command_names()[static_cast<std::size_t>(supervisor.event().interface)],
              "arm/joint_1/position");
    bench.run(10);
    bench.loop.post(Request::recover);
    bench.run(1);
    bench.loop.post(Request::resume);
    bench.run(10);
    EXPECT_EQ(supervisor.state(), RunState::running) << "it is told once, or nobody could bring it back";
    push(2.9);
    push(-3.01);
    EXPECT_EQ(supervisor.state(), RunState::fault) << "outside again, and told again";
    Plant::pushed = std::numeric_limits<double>::quiet_NaN();
  }
}

TEST(ControlLoop, AHundredThousandCyclesTouchNothingForbidden) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  Bench bench;
  bench.move({1, 0.5, 0, -0.5, 0.2, 0.3});
  bench.run(100);
  std::string violations;
  for (int part = 0; part < 100; ++part) {
    if (part % 10 == 5) bench.loop.supervisor().latch().request(realtime::StopKind::controlled);
    if (part % 10 == 8) {
      bench.loop.supervisor().latch().clear();
      bench.loop.post(Request::resume);
    }
    if (bench.jtc->status().finished.load() + 1 == bench.next_id)
      bench.move(part % 2 ? std::vector<double>{1, 0.5, 0, -0.5, 0.2, 0.3}
                          : std::vector<double>{-1, 0, 1, 0.5, 0, 0});
    const test::RealtimeGuard guard;
    bench.run(1000);
    violations += guard.violations();
  }
  EXPECT_EQ(violations, "");
}

TEST(RealtimeGuard, SeesWhatIsForbidden) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  const test::RealtimeGuard guard;
  auto* volatile p = new int(1);
  delete p;
  try {
    throw 1;
  } catch (int) {
  }
  const std::string seen = guard.violations();
  EXPECT_NE(seen.find("malloc"), std::string::npos);
  EXPECT_NE(seen.find("free"), std::string::npos);
  EXPECT_NE(seen.find("throw"), std::string::npos);
}

TEST(BlackBox, KeepsTheNewestRowsThatItsMemoryHolds) {
  BlackBox box;
  box.build(2, 1, 1000, 10 * 64);
  for (std::uint64_t cycle = 0; cycle < 100; ++cycle) {
    const double value = static_cast<double>(cycle);
    box.record({cycle, RunState::running, StopCause::none, Request::none, std::array{value, value + 1},
                std::array{value + 2}});
  }
  ASSERT_GT(box.rows(), 5u);
  ASSERT_LT(box.rows(), 20u);
  EXPECT_EQ(box.row(box.rows() - 1).cycle, 99u);
  EXPECT_EQ(box.row(0).cycle, 100 - box.rows());
  EXPECT_EQ(box.row(0).commands[0], box.row(0).states[0] + 2);
}

}  // namespace
}  // namespace polyarm::control
