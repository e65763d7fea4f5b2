/// Held is held and switched off is off, whatever a controller commands.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/control/control_loop.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::control {
namespace {

using controllers::Controller;
using hardware::CallbackReturn;
using hardware::Cycle;
using hardware::ReturnType;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// An arm's joint that is where it is told to be, and a wheel that turns as fast as it is told to.
class Base : public hardware::Component {
 public:
  CallbackReturn on_init(const hardware::ComponentContext&) override { return CallbackReturn::success; }
  std::vector<hardware::InterfaceDescription> state_interfaces() const override {
    return {{"r/arm/position", 0.0}, {"r/wheel/position", 0.0}};
  }
  std::vector<hardware::InterfaceDescription> command_interfaces() const override {
    return {{"r/arm/position"}, {"r/wheel/velocity"}, {"r/wheel/effort"}};
  }
  ReturnType read(const Cycle&, std::span<double> states) noexcept override {
    std::copy(at.begin(), at.end(), states.begin());
    return ReturnType::ok;
  }
  ReturnType write(const Cycle& cycle, std::span<const double> commands) noexcept override {
    if (std::isfinite(commands[0])) at[0] = commands[0];
    if (std::isfinite(commands[1])) at[1] += commands[1] * seconds(cycle.period);
    return ReturnType::ok;
  }
  static inline std::vector<double> at;
};

/// Follows no stop: its commands are what the test says, or grow by 1 mm or mrad each time.
class Stubborn : public Controller {
 public:
  std::vector<std::string> claims;
  std::vector<double> wants;  ///< one each; NaN: grows
  double found = kNone;       ///< its first command, as it was when it started
  ReturnType result = ReturnType::ok;
  CallbackReturn activate = CallbackReturn::success;

  CallbackReturn on_configure(controllers::ControllerContext&) override {
    for (const std::string& claim : claims) claim_command(claim);
    return CallbackReturn::success;
  }
  CallbackReturn on_activate(const Cycle&) noexcept override {
    found = command(0);
    return activate;
  }
  ReturnType update(const Cycle&, const controllers::Verdict&) noexcept override {
    for (std::size_t i = 0; i < wants.size(); ++i) {
      const double last = std::isfinite(command(i)) ? command(i) : 0;
      set_command(i, std::isfinite(wants[i]) ? wants[i] : last + 1e-3);
    }
    return result;
  }
};

struct BaseBench {
  ControlLoop loop{LoopOptions{}};
  std::vector<controllers::JointFacts> joints;

  explicit BaseBench(double acceleration = controllers::kUnlimited) {
    Base::at = {0, 0};
    loop.supervisor().watch_cell = false;
    loop.hardware().add(std::make_unique<Base>(), {});
    loop.start_hardware();
    joints = {{"r/arm", false, -3, 3, 2, acceleration, 80},
              {"r/wheel", true, -1e9, 1e9, 5, acceleration, 80}};
    for (controllers::JointFacts& joint : joints) joint.states_acceleration = acceleration < 1e9;
  }
  Stubborn& add(const std::string& name, std::vector<std::string> claims, std::vector<double> wants) {
    auto made = std::make_unique<Stubborn>();
    Stubborn& out = *made;
    out.claims = std::move(claims);
    out.wants = std::move(wants);
    controllers::ControllerContext context;
    context.name = name;
    context.joints = joints;
    loop.controllers().add(std::move(made), context);
    return out;
  }
  void go(const std::string& name) {
    loop.controllers().activate(name);
    loop.prepare(joints);
  }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) loop.step_next();
  }
  double command(const std::string& name) {
    return loop.table().commands()[*loop.table().find_command(name)];
  }
};

TEST(StandStill, WhatAControllerThatFollowsNoStopCommandsDoesNotArrive) {
  for (const double acceleration : {controllers::kUnlimited, 50.0}) {
    BaseBench bench(acceleration);
    bench.add("stubborn", {"r/arm/position", "r/wheel/velocity"}, {kNone, 1});
    bench.go("stubborn");
    bench.run(200);
    EXPECT_GT(Base::at[0], 0.1) << "it moves";
    EXPECT_GT(Base::at[1], 0.1);
    bench.loop.supervisor().latch().request(realtime::StopKind::controlled);
    bench.run(3);
    ASSERT_EQ(bench.loop.supervisor().state(), RunState::held);
    const std::vector<double> at = Base::at;
    bench.run(2000);
    EXPECT_EQ(Base::at[0], at[0]);
    EXPECT_NEAR(Base::at[1], at[1], 0.03) << "a wheel may correct itself, and go nowhere";
    EXPECT_EQ(bench.command("r/wheel/velocity"), 0);
    const auto clamps = bench.loop.limits().report();
    EXPECT_TRUE(std::any_of(clamps.begin(), clamps.end(), [](const Clamp& c) {
      return c.limit == controllers::Limit::held;
    })) << "and it is told";

    bench.loop.supervisor().latch().clear();
    bench.loop.post(Request::resume);
    double last = Base::at[0];
    for (int k = 0; k < 500; ++k) {
      bench.run(1);
      EXPECT_LE(Base::at[0] - last, 2e-3 * (1 + 1e-5)) << "no jump, but within its limits";
      last = Base::at[0];
    }
    EXPECT_GT(last, at[0] + 0.1) << "a person let it go on";
  }
}

TEST(StandStill, AtAFaultToo) {
  BaseBench bench;
  bench.add("stubborn", {"r/arm/position", "r/wheel/velocity"}, {kNone, 1});
  bench.go("stubborn");
  bench.run(200);
  bench.loop.supervisor().react({StopCause::component}, false);
  bench.run(2);
  const std::vector<double> at = Base::at;
  bench.run(2000);
  EXPECT_EQ(Base::at[0], at[0]);
  EXPECT_NEAR(Base::at[1], at[1], 0.03);
}

TEST(StandStill, AVelocityMayBringAJointBackToWhereItStood) {
  BaseBench bench;
  Stubborn& corrects = bench.add("corrects", {"r/wheel/velocity"}, {0.0});
  bench.go("corrects");
  bench.run(10);
  bench.loop.supervisor().latch().request(realtime::StopKind::controlled);
  bench.run(3);
  Base::at[1] += 0.04;  // somebody pushes it
  corrects.wants = {-1};
  bench.run(2);
  EXPECT_EQ(bench.command("r/wheel/velocity"), -1);
  corrects.wants = {1};
  bench.run(1);
  EXPECT_EQ(bench.command("r/wheel/velocity"), 0) << "but not farther away";
}

TEST(SwitchedOff, AVelocityOrEffortThatNobodyCommandsAnyMoreEnds) {
  BaseBench bench;
  bench.add("drives", {"r/wheel/velocity", "r/wheel/effort", "r/arm/position"}, {1, 0.5, 0.3});
  bench.go("drives");
  bench.run(400);
  ASSERT_EQ(bench.command("r/wheel/velocity"), 1);
  bench.loop.controllers().deactivate("drives");
  EXPECT_EQ(bench.command("r/wheel/velocity"), 0);
  EXPECT_EQ(bench.command("r/wheel/effort"), 0);
  EXPECT_EQ(bench.command("r/arm/position"), 0.3) << "a position stays where it was commanded last";
}

TEST(SwitchedOff, WhatAnotherTakesOverInTheSameSwitchGoesOn) {
  BaseBench bench;
  bench.add("first", {"r/wheel/effort"}, {0.5});
  Stubborn& second = bench.add("second", {"r/wheel/effort"}, {0.7});
  bench.go("first");
  bench.run(10);
  bench.loop.controllers().switch_now({{"second"}, {"first"}, Strictness::strict});
  EXPECT_EQ(second.found, 0.5) << "an effort that carries something is handed over without a gap";

  Stubborn& refuses = bench.add("refuses", {"r/wheel/effort"}, {1});
  refuses.activate = CallbackReturn::failure;
  EXPECT_THROW(bench.loop.controllers().switch_now({{"refuses"}, {"second"}, Strictness::strict}), Error);
  EXPECT_EQ(bench.command("r/wheel/effort"), 0) << "who was to take over did not";
}

TEST(SwitchedOff, AControllerThatFailsLeavesNoVelocityBehind) {
  BaseBench bench;
  Stubborn& fails = bench.add("fails", {"r/wheel/velocity"}, {1});
  bench.go("fails");
  bench.run(50);
  fails.result = ReturnType::error;
  std::string violations;
  {
    const test::RealtimeGuard guard;
    bench.run(2);
    violations = guard.violations();
  }
  if (test::RealtimeGuard::watches()) {
    EXPECT_EQ(violations, "");
  }
  EXPECT_EQ(bench.loop.supervisor().cause(), StopCause::controller);
  EXPECT_EQ(bench.command("r/wheel/velocity"), 0);
}

}  // namespace
}  // namespace polyarm::control
