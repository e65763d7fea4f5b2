/// The driver against the simulated controller: states, commands, life cycle.
#include <algorithm>
#include <limits>
#include <thread>

#include "polyarm/kinematics/chain.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/ur/rig.hpp"

namespace polyarm {
namespace {

using test::UrRig;
using namespace test;

TEST(UrComponent, ReadsWhatTheControllerMeasures) {
  UrRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().with([](ur::Machine& machine) {
    machine.digital_input(3, true);
    machine.digital_input(17, true);
    return 0;
  });
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(3, [](int) {}));
  const ur::Six q = rig.q();
  EXPECT_NEAR(rig.state("elbow_joint/position"), q[2], 1e-12);
  EXPECT_EQ(rig.state("controller/robot_mode"), ur::running);
  EXPECT_EQ(rig.state("controller/safety_mode"), ur::safety_normal);
  EXPECT_EQ(rig.state("controller/program_state"), ur::playing);
  EXPECT_EQ(rig.state("controller/speed_slider"), 1);
  EXPECT_EQ(rig.state("io/digital_in_3"), 1);
  EXPECT_EQ(rig.state("io/digital_in_4"), 0);
  EXPECT_EQ(rig.state("io/digital_in_17"), 1);
  EXPECT_EQ(rig.state("controller/lost_packages"), 0);
}

/// The controller reports them in the axes of its base.
TEST(UrComponent, ForcesAreInTheAxesOfTheTcp) {
  UrRig rig;
  rig.far().with([](ur::Machine& machine) {
    machine.set_register("actual_TCP_force", 20);
    return 0;
  });
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(3, [](int) {}));
  const Quaternion tcp{rig.state("tcp_pose/orientation.x"), rig.state("tcp_pose/orientation.y"),
                       rig.state("tcp_pose/orientation.z"), rig.state("tcp_pose/orientation.w")};
  const Vec3 force{rig.state("tcp_wrench/force.x"), rig.state("tcp_wrench/force.y"),
                   rig.state("tcp_wrench/force.z")};
  EXPECT_GT(angle_between(tcp, Quaternion{}), 0.5) << "else it shows nothing";
  EXPECT_LT(norm(tcp * force - Vec3{20, 0, 0}), 1e-9);
}

TEST(UrComponent, TheTcpIsWhereTheCataloguesKinematicsHaveIt) {
  for (const char* name : {"ur3", "ur5e", "ur10e", "ur16e", "ur20"}) {
    const description::RobotModel& model = ur_model(name);
    int tip = -1;
    for (std::size_t i = 0; i < model.links.size(); ++i)
      if (model.links[i].name == "tool0") tip = static_cast<int>(i);
    ASSERT_GE(tip, 0);
    const kinematics::Chain chain(model, tip);
    const ur::Six q{0.4, -1.1, 0.9, -0.3, 0.7, 1.9};
    const Pose tool = chain.forward(q);
    const ur::Six pose = ur::flange_pose(ur::facts_of(model).kinematics, q);
    // The controller's base is turned by half a turn against the description's.
    EXPECT_NEAR(pose[0], -tool.position.x, 1e-4) << name;
    EXPECT_NEAR(pose[1], -tool.position.y, 1e-4) << name;
    EXPECT_NEAR(pose[2], tool.position.z, 1e-4) << name;
  }
}

TEST(UrComponent, TheFirstCommandIsTheMeasuredPosition) {
  UrRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const ur::Six before = rig.q();
  rig.far().with([](ur::Machine& machine) { return machine.forget_jumps(), 0; });
  ASSERT_TRUE(rig.runs(200, [](int) {}));
  EXPECT_LE(rig.far().with([](ur::Machine& m) { return m.largest_jump(); }), 1e-6);
  EXPECT_GT(rig.far().messages(), 150u);
  const ur::Six after = rig.q();
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(after[i], before[i], 1e-6);
}

TEST(UrComponent, TheRobotFollowsPositionsInEachCycleOnce) {
  UrRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("elbow_joint/position");
  // Each step of the controller waits for the command of the cycle before. Until the loop's first command,
  // the link keeps the program waiting with messages of its own, as often as this machine runs.
  ASSERT_TRUE(rig.runs(2, [](int) {}));
  ASSERT_EQ(rig.read(), ReturnType::ok);
  const std::uint64_t before = rig.far().messages();
  ASSERT_TRUE(
      rig.runs(1000, [&](int i) { rig.command("elbow_joint/position") = from + 0.4 * (i + 1) / 1000; }));
  ASSERT_EQ(rig.read(), ReturnType::ok);
  EXPECT_EQ(rig.far().messages() - before, 1000u) << "one message for each cycle";
  EXPECT_EQ(rig.far().with([](ur::Machine& m) { return m.largest_jump() < 0.0005; }), true);
  ASSERT_TRUE(rig.runs(300, [](int) {}));
  EXPECT_NEAR(rig.state("elbow_joint/position"), from + 0.4, 1e-4);
  EXPECT_LE(rig.state("controller/command_age"), 2);
}

TEST(UrComponent, VelocitiesMoveAndNoCommandHolds) {
  hardware::ComponentContext context = ur_context();
  description::HardwareInfo block;
  for (const std::string& joint : ur_model().joint_names()) {
    description::ComponentInfo part;
    part.name = joint;
    part.kind = "joint";
    part.command_interfaces.push_back({"velocity"});
    block.components.push_back(part);
  }
  context.robots.front().hardware.push_back(block);
  ur::FakeUr component;
  component.on_init(context);
  ASSERT_EQ(component.command_interfaces().front().name, "arm/shoulder_pan_joint/velocity");
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  std::fill_n(commands.begin(), 6, 0.0);
  commands[0] = 0.5;
  hardware::Cycle cycle{0, context.period, 0};
  const double from = component.far_side().with([](ur::Machine& m) { return m.q()[0]; });
  for (int i = 0; i < 500; ++i) {
    ASSERT_EQ(component.read(cycle, states), ReturnType::ok) << component.reason();
    ASSERT_EQ(component.write(cycle, commands), ReturnType::ok);
  }
  EXPECT_NEAR(states[0], from + 0.5, 0.05);
  commands[0] = std::nan("");
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(component.read(cycle, states), ReturnType::ok) << component.reason();
    ASSERT_EQ(component.write(cycle, commands), ReturnType::ok);
  }
  EXPECT_NEAR(states[1], 0, 1e-9) << "it stands";
  component.on_shutdown();
}

TEST(UrComponent, AnOrderedFaultEndsWhenTheDriverStartsAgain) {
  UrRig rig(Parameters{{"faults", "protective_stop@0.1 normal@again protective_stop@0.3"}});
  const auto still = [](int) {};
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.fails(500, still));
  EXPECT_EQ(rig.component.cause(), ur::Cause::protective_stop);
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, still));
  ASSERT_TRUE(rig.fails(500, still)) << "the next fault comes at its time";
  EXPECT_FALSE(rig.start()) << "nothing ends this one";
}

TEST(UrComponent, AFaultThatTheControllerDoesNotKnowIsRefusedAtOnce) {
  for (const char* faults : {"protective_stopp@3", "protective_stop", "protective_stop@soon", "@again"})
    EXPECT_THROW(ur::FakeUr().on_init(ur_context({{"faults", faults}})), Error) << faults;
}

TEST(UrComponent, OutputsAreWrittenWhenTheyChangeAndReadBack) {
  UrRig rig(Parameters{{"wires", "0=5"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().with([](ur::Machine& m) { return m.digital_output(1, true), 0; });  // by hand
  rig.command("io/digital_out_0") = 1;
  rig.command("io/digital_out_9") = 1;
  rig.command("io/analog_out_1") = 0.25;
  rig.command("controller/speed_slider") = 0.6;
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  EXPECT_EQ(rig.state("io/digital_out_0"), 1);
  EXPECT_EQ(rig.state("io/digital_out_1"), 1) << "what nobody commands stays";
  EXPECT_EQ(rig.state("io/digital_out_9"), 1);
  EXPECT_EQ(rig.state("io/digital_in_5"), 1) << "wired to output 0";
  EXPECT_EQ(rig.state("io/analog_out_1"), 0.25);
  EXPECT_EQ(rig.state("controller/speed_slider"), 0.6);
  rig.command("io/digital_out_0") = 0;
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  EXPECT_EQ(rig.state("io/digital_out_0"), 0);
  EXPECT_EQ(rig.state("io/digital_in_5"), 0);
  EXPECT_EQ(rig.state("io/digital_out_9"), 1);
}

TEST(UrComponent, NoChangeOfAnOutputIsLostWhenSeveralCyclesFollowQuickly) {
  UrRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int round = 0; round < 20; ++round) {
    const double on = round % 2 == 0;
    for (int i = 0; i < 18; ++i) {
      rig.command("io/digital_out_" + std::to_string(i)) = on;
      ASSERT_EQ(rig.component.write(rig.cycle, rig.commands), ReturnType::ok);
      rig.far().step();  // nobody waits until the link's thread has run
    }
    ASSERT_TRUE(rig.runs(2, [](int) {}));
    for (int i = 0; i < 18; ++i)
      ASSERT_EQ(rig.state("io/digital_out_" + std::to_string(i)), on) << round << " " << i;
  }
}

TEST(UrComponent, ADigitalWordOutOfRangeReadsAsNothingSwitched) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double word : {-1.0, -1e300, 1e300, 0x1p64, infinity, -infinity, std::nan("")}) {
    UrRig rig;
    rig.far().with([&](ur::Machine& machine) {
      machine.report_instead("actual_digital_input_bits", word);
      machine.report_instead("actual_digital_output_bits", 5);  // a word, though it comes as a DOUBLE
      return 0;
    });
    ASSERT_TRUE(rig.start()) << rig.component.reason();
    ASSERT_TRUE(rig.runs(3, [](int) {})) << word;
    for (int i = 0; i < 18; ++i)
      EXPECT_EQ(rig.state("io/digital_in_" + std::to_string(i)), 0) << word << " " << i;
    EXPECT_EQ(rig.state("io/digital_out_0"), 1) << word;
    EXPECT_EQ(rig.state("io/digital_out_1"), 0) << word;
    EXPECT_EQ(rig.state("io/digital_out_2"), 1) << word;
  }
}

TEST(UrComponent, AnOutputIsSwitchedInTheCycleOfItsCommand) {
  UrRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(5, [](int) {}));
  for (int round = 0; round < 300; ++round) {
    rig.command("io/digital_out_3") = round % 2;
    ASSERT_TRUE(rig.runs(1, [](int) {}));
    ASSERT_EQ(rig.read(), ReturnType::ok);
    ASSERT_EQ(rig.state("io/digital_out_3"), round % 2) << round;
    ASSERT_EQ(rig.component.write(rig.cycle, rig.commands), ReturnType::ok);
  }
}

TEST(UrComponent, DeactivatingEndsTheProgramAndTheRobotStands) {
  UrRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("wrist_1_joint/position");
  ASSERT_TRUE(rig.runs(200, [&](int i) { rig.command("wrist_1_joint/position") = from + 0.001 * i; }));
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  while (rig.far().program_runs()) std::this_thread::yield();  // its end is on the way
  for (int i = 0; i < 500; ++i) rig.far().step();
  EXPECT_TRUE(rig.far().with([](ur::Machine& m) { return m.still(); }));
  EXPECT_FALSE(rig.far().program_runs());
  EXPECT_EQ(rig.component.cause(), Cause::none);
  EXPECT_TRUE(rig.activate()) << rig.component.reason();
  EXPECT_TRUE(rig.runs(10, [](int) {}));
}

TEST(UrComponent, RepeatedAndReorderedPackagesMoveNothingAndAreCounted) {
  UrRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const ur::Six before = rig.q();
  for (const char* fault : {"duplicate=5", "reorder=1", "late=2"}) {
    rig.far().order(fault);
    ASSERT_TRUE(rig.runs(20, [](int) {})) << fault;
  }
  const ur::Six after = rig.q();
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(after[i], before[i], 1e-6);
}

TEST(UrComponent, NeedsSixJointsAndKnownCommands) {
  hardware::ComponentContext context = ur_context();
  context.parameters["host"] = "127.0.0.1";
  description::HardwareInfo block;
  description::ComponentInfo part;
  part.name = "only";
  part.kind = "joint";
  part.command_interfaces.push_back({"effort"});
  block.components.push_back(part);
  context.robots.front().hardware.push_back(block);
  ur::UrComponent component;
  try {
    component.on_init(context);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("has 1 joints"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("takes no command 'effort'"), std::string::npos) << e.what();
  }
  ur::UrComponent nowhere;
  EXPECT_THROW(nowhere.on_init(ur_context()), Error) << "a host must be given";
}

TEST(UrComponent, ReadAndWriteNeitherAllocateNorLock) {
  if (!RealtimeGuard::watches()) GTEST_SKIP();
  // The far side ticks on its own thread here, as a controller does.
  ur::FarSideOptions options;
  options.machine.facts = ur::facts_of(ur_model());
  options.rtde = options.dashboard = options.primary = options.secondary = 0;
  FarSide far(options);
  ur::UrComponent component;
  component.on_init(ur_context({{"host", "127.0.0.1"},
                                {"rtde_port", std::to_string(far.rtde_port())},
                                {"primary_port", std::to_string(far.primary_port())},
                                {"dashboard_port", std::to_string(far.dashboard_port())},
                                {"watchdog_ms", "5000"},
                                {"silence_ms", "10000"}}));
  ASSERT_TRUE(component.paces());
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 2'000'000, 0};
  component.await_cycle(1'000'000'000);
  component.read(cycle, states);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[4 * j];
  std::string violations;
  bool fine = true;
  for (int i = 0; i < 300; ++i) {
    component.await_cycle(1'000'000'000);
    const RealtimeGuard guard;
    commands[0] += 1e-4;
    commands[6] = i % 2 ? 1.0 : 0.9;
    fine = component.read(cycle, states) == ReturnType::ok &&
           component.write(cycle, commands) == ReturnType::ok && fine;
    if (violations.empty()) violations = guard.violations();
  }
  EXPECT_TRUE(fine) << component.reason();
  EXPECT_EQ(violations, "");
  component.on_shutdown();
}

}  // namespace
}  // namespace polyarm
