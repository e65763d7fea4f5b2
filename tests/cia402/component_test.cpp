/// The driver on simulated drives: what it reads, writes and refuses, and that nothing moves by itself.
#include "tests/cia402/rig.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/wire_faults.hpp"

namespace polyarm {
namespace {

using test::Cia402Rig;
using namespace test;
using cia402::FarDrive;
using cia402::Machine;

constexpr double kCount = 2 * std::numbers::pi / (4096 * 100);

TEST(Cia402Component, ConnectingSwitchesNothingOnAndMovesNothing) {
  Cia402Rig rig;
  const auto before = rig.q();
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) {
      EXPECT_STREQ(drive.state_name(), "switch on disabled");
      EXPECT_TRUE(drive.operational());
      EXPECT_TRUE(drive.written(0x6040).empty()) << "no controlword was sent";
    }
    return 0;
  });
  EXPECT_EQ(rig.q(), before);
}

TEST(Cia402Component, MeasuresTheJointsInTheirUnits) {
  Cia402Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(3, [](int) {})) << rig.component.reason();
  for (std::size_t j = 0; j < kStart.size(); ++j) {
    EXPECT_NEAR(rig.states[3 * j], kStart[j], kCount) << j;
    EXPECT_EQ(rig.states[3 * j + 1], 0) << j;
  }
  EXPECT_NEAR(rig.state("joint_1/effort"), 0.1 * 0.5 * 100, 1e-9) << "10 % of 0.5 N m, times the gear";
  EXPECT_NEAR(rig.state("joint_2/effort"), -0.1 * 0.5 * 100, 1e-9) << "it turns against its motor";
  EXPECT_EQ(rig.state("controller/ready"), 1);
  EXPECT_EQ(rig.state("controller/lost"), 0);
}

TEST(Cia402Component, EnablingHoldsTheMeasuredPosition) {
  Cia402Rig rig;
  const auto before = rig.q();
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {})) << rig.component.reason();
  EXPECT_EQ(rig.q(), before);
  EXPECT_LE(rig.largest_jump(), 1e-6) << "the first target is where the drive stands";
}

TEST(Cia402Component, FollowsCommandsToTheCount) {
  Cia402Rig rig(Parameters{{"joint_1.velocity_unit", "counts"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const std::vector<double> from(rig.commands);
  ASSERT_TRUE(rig.runs(200, [&](int i) {
    for (std::size_t j = 0; j < from.size(); ++j) rig.commands[j] = from[j] + travel(i, 0.001, 80);
  })) << rig.component.reason();
  for (const char* joint : {"joint_1/velocity", "joint_2/velocity"})
    EXPECT_NEAR(rig.state(joint), 0.001 / 0.01, 3e-3) << joint;
  const std::vector<double> at(rig.commands);
  ASSERT_TRUE(rig.runs(5, [](int) {}));
  const auto q = rig.q();
  for (std::size_t j = 0; j < at.size(); ++j) EXPECT_NEAR(q[j], at[j], kCount) << j;
  EXPECT_LE(rig.largest_jump(), 0.001 + 2 * kCount);
}

TEST(Cia402Component, ARunRepeatsItself) {
  const auto run = [] {
    Cia402Rig rig;
    EXPECT_TRUE(rig.start()) << rig.component.reason();
    std::vector<double> seen;
    const double from = rig.commands[0];
    EXPECT_TRUE(rig.runs(100, [&](int i) {
      rig.commands[0] = from + travel(i, 0.001, 80);
      seen.insert(seen.end(), rig.states.begin(), rig.states.end());
    }));
    return seen;
  };
  EXPECT_EQ(run(), run());
}

TEST(Cia402Component, WithoutACommandForOneJointAllKeepTheirTargets) {
  Cia402Rig rig;
  ASSERT_TRUE(rig.start());
  ASSERT_TRUE(rig.runs(5, [](int) {}));
  const auto before = rig.q();
  ASSERT_TRUE(rig.runs(20, [&](int i) {
    rig.commands[0] += 0.001;
    if (i == 0) rig.commands[3] = std::nan("");
  }));
  EXPECT_EQ(rig.q(), before);
}

TEST(Cia402Component, AJumpIsNotSent) {
  Cia402Rig rig;
  expect_no_jump_is_sent(rig, "joint_5", Cause::jump);
}

TEST(Cia402Component, TheFirstCommandIsNearTheMeasuredPosition) {
  Cia402Rig rig;
  expect_no_far_begin_is_sent(rig, "joint_2", Cause::jump);
}

TEST(Cia402Component, DeactivatingHoldsAndActivatingAgainDoesNotMove) {
  Cia402Rig rig;
  ASSERT_TRUE(rig.start());
  const double from = rig.commands[0];
  ASSERT_TRUE(rig.runs(100, [&](int i) { rig.commands[0] = from + travel(i, 0.002, 80); }));
  ASSERT_EQ(rig.component.on_deactivate(), CallbackReturn::success) << "while it moves";
  const auto stopped = rig.q();
  rig.far().with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) EXPECT_STREQ(drive.state_name(), "quick stop active");
    return 0;
  });
  rig.forget_jumps();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  EXPECT_EQ(rig.q(), stopped);
  EXPECT_LE(rig.largest_jump(), 1e-6);
}

TEST(Cia402Component, EndingLeavesDrivesThatNoLongerWaitForHeartbeats) {
  Cia402Rig rig;
  ASSERT_TRUE(rig.start());
  rig.component.on_shutdown();
  for (int i = 0; i < 300; ++i) rig.far().step();
  rig.far().with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) {
      EXPECT_EQ(drive.value(0x1016, 1), 0u);
      EXPECT_EQ(drive.value(0x603F), 0u) << "none of them complained";
      EXPECT_STREQ(drive.state_name(), "quick stop active") << "the torque stays";
    }
    return 0;
  });
}

TEST(Cia402Component, OnShutdownItSwitchesOffIfItIsToldTo) {
  Cia402Rig rig(Parameters{{"torque_off", "on_shutdown"}});
  ASSERT_TRUE(rig.start());
  rig.component.on_shutdown();
  rig.far().with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) EXPECT_STREQ(drive.state_name(), "switch on disabled");
    return 0;
  });
}

TEST(Cia402Component, WritesMappingTimesAndLimitsAndReadsThemBack) {
  Cia402Rig rig(Parameters{{"joint_1.max_torque", "0.8"},
                           {"joint_1.max_motor_speed", "3000"},
                           {"joint_1.following_error", "0.1"},
                           {"joint_2.min", "-1"},
                           {"joint_2.max", "2"}});
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().with([](Machine& machine) {
    FarDrive& first = machine.drive(1);
    EXPECT_EQ(first.value(0x1600, 0), 2u);
    EXPECT_EQ(first.value(0x1600, 1), 0x6040'0010u);
    EXPECT_EQ(first.value(0x1600, 2), 0x607A'0020u);
    EXPECT_EQ(first.value(0x1A00, 0), 3u);
    EXPECT_EQ(first.value(0x1A00, 1), 0x6041'0010u);
    EXPECT_EQ(first.value(0x1A00, 2), 0x6064'0020u);
    EXPECT_EQ(first.value(0x1A00, 3), 0x6061'0008u);
    EXPECT_EQ(first.value(0x1A01, 1), 0x606C'0020u);
    EXPECT_EQ(first.value(0x1A01, 2), 0x6077'0010u);
    EXPECT_EQ(first.value(0x1400, 1), 0x201u);
    EXPECT_EQ(first.value(0x1800, 2), 1u) << "at every SYNC";
    EXPECT_EQ(first.value(0x1802, 1) >> 31, 1u) << "other PDOs are off";
    EXPECT_EQ(first.value(0x60C2, 1), 10u);
    EXPECT_EQ(first.value(0x60C2, 2), 0xFDu) << "10 ms";
    EXPECT_EQ(first.value(0x6007), 3u);
    EXPECT_EQ(first.value(0x605A), 6u);
    EXPECT_EQ(first.value(0x1016, 1), 127u << 16 | 500u);
    EXPECT_EQ(first.value(0x1017), 250u);
    EXPECT_EQ(first.value(0x6072), 800u);
    EXPECT_EQ(first.value(0x6080), 3000u);
    EXPECT_EQ(first.value(0x6065), static_cast<unsigned>(std::lround(0.1 / kCount)));
    // Joint 2 turns against its motor: its upper end is the drive's lower one.
    FarDrive& second = machine.drive(2);
    EXPECT_EQ(static_cast<std::int32_t>(second.value(0x607D, 1)), -std::lround(2 / kCount));
    EXPECT_EQ(static_cast<std::int32_t>(second.value(0x607D, 2)), std::lround(1 / kCount));
    return 0;
  });
}

TEST(Cia402Component, AFaultIsResetOnlyIfActivatingMayDoSo) {
  for (const bool may : {true, false}) {
    Cia402Rig rig(Parameters{{"fault_reset", may ? "true" : "false"}});
    rig.far().order("over_current=2");
    rig.far().order("healthy");
    ASSERT_TRUE(rig.configure()) << rig.component.reason();
    rig.far().with([](Machine& machine) {
      EXPECT_STREQ(machine.drive(2).state_name(), "fault") << "connecting resets nothing";
      return 0;
    });
    EXPECT_EQ(rig.activate(), may) << rig.component.reason();
    if (may) continue;
    EXPECT_EQ(rig.component.cause(), Cause::drive_fault) << rig.component.reason();
  }
}

TEST(Cia402Component, ARefusedActivationKeepsReading) {
  Cia402Rig rig(Parameters{{"start_timeout", "0.5"}});
  expect_refused_activation_keeps_reading(rig, "torque_off=3", "healthy");
}

TEST(Cia402Component, LateDoubleAndDamagedFramesCostNothing) {
  Cia402Rig rig;
  ASSERT_TRUE(rig.start());
  const double from = rig.commands[0];
  for (const char* order : {"late=2", "duplicate=1", "garbage=30"}) rig.far().order(order);
  ASSERT_TRUE(rig.runs(100, [&](int i) { rig.commands[0] = from + travel(i, 0.001, 80); }))
      << rig.component.reason();
  EXPECT_GT(rig.state("controller/lost"), 0);
}

TEST(Cia402Component, ADriveWithoutOptionalObjectsIsTaken) {
  Cia402Rig rig;
  rig.far().order("hides=2");
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  EXPECT_TRUE(rig.runs(5, [](int) {})) << rig.component.reason();
}

TEST(Cia402Component, ADriveThatSomebodyEnabledBeforeIsHeldWhereItIs) {
  Cia402Rig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  const auto before = rig.q();
  rig.far().with([](Machine& machine) {
    FarDrive::Frames unheard;
    for (const int word : {0x06, 0x07, 0x0F}) {
      const std::array<std::uint8_t, 2> bytes{static_cast<std::uint8_t>(word), 0};
      machine.drive(2).take(cia402::download_request(2, {0x6040}, bytes), unheard);
    }
    EXPECT_TRUE(machine.drive(2).enabled());
    machine.forget_jumps();
    return 0;
  });
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, [](int) {})) << rig.component.reason();
  EXPECT_EQ(rig.q(), before);
  EXPECT_LE(rig.largest_jump(), 1e-6);
}

TEST(Cia402Component, LimitsAndWarningsAreShown) {
  Cia402Rig rig;
  ASSERT_TRUE(rig.start());
  rig.far().order("limit=2");
  rig.far().order("warning=3");
  ASSERT_TRUE(rig.runs(3, [](int) {})) << rig.component.reason();
  EXPECT_EQ(rig.state("controller/limited"), 2);
  EXPECT_EQ(rig.state("controller/warned"), 4);
}

TEST(Cia402Component, WrongParametersAreNamed) {
  const auto refused = [](Parameters parameters, const std::string& words) {
    cia402::Cia402Component component;
    parameters.try_emplace("bus", "can0");
    for (int j = 1; j <= 6; ++j) {
      parameters.try_emplace("joint_" + std::to_string(j) + ".node", std::to_string(j));
      parameters.try_emplace("joint_" + std::to_string(j) + ".counts_per_turn", "4096");
    }
    try {
      component.on_init(cia402_context(parameters));
      ADD_FAILURE() << words;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
    }
  };
  refused({{"joint_2.node", "1"}}, "joint_1 and joint_2 have the same node number 1");
  refused({{"joint_2.node", "127"}}, "this computer have the node number 127");
  refused({{"joint_2.node", "1.5"}}, "whole number");
  refused({{"joint_2.direction", "0"}}, "1 or -1");
  refused({{"joint_7.node", "7"}}, "no joint 'joint_7'");
  refused({{"joint_1.nod", "7"}}, "no parameter joint_1.nod");
  refused({{"joint_1.min", "1"}}, "give both");
  refused({{"quick_stop", "fall"}}, "hold");
  refused({{"bit_rate", "125000"}}, "% of a bus");
  refused({{"cycle_ms", "1"}}, "lower the rate");
  refused({{"joint_1.velocity_unit", "knots"}}, "mrpm");
  cia402::Cia402Component without;
  EXPECT_THROW(without.on_init(cia402_context({{"bus", "can0"}})), Error) << "no nodes";
}

TEST(Cia402Component, ABusThatIsNotThereIsNamed) {
  for (const auto& [bus, words] : {std::pair{"can7", "there is no CAN interface can7"},
                                   std::pair{"/dev/ttyNone", "there is no serial port /dev/ttyNone"}}) {
    Alone alone(Parameters{{"bus", bus}});
    EXPECT_FALSE(alone.configure());
    EXPECT_EQ(alone.component.cause(), Cause::no_bus);
    EXPECT_NE(alone.component.reason().find(words), std::string::npos) << alone.component.reason();
  }
}

TEST(Cia402Component, TheLoopFollowsTheSync) {
  Alone alone;
  ASSERT_TRUE(alone.component.paces());
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(alone.component.await_cycle(60'000'000'000));
  Alone other(Parameters{{"cycle_ms", "20"}});
  EXPECT_FALSE(other.configure());
  EXPECT_EQ(other.component.cause(), Cause::wrong_rate);
  EXPECT_NE(other.component.reason().find("rate: 50"), std::string::npos) << other.component.reason();
}

TEST(Cia402Component, ASilentLoopIsStopped) {
  Alone alone(Parameters{{"loop_silence_ms", "200"}});
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  std::vector<double> states(alone.component.state_interfaces().size()), commands(6);
  const hardware::Cycle cycle{0, kCycle, 0};
  alone.component.await_cycle(60'000'000'000);
  alone.component.read(cycle, states);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[3 * j];
  alone.component.write(cycle, commands);
  while (alone.component.cause() == Cause::none) alone.component.await_cycle(100'000'000);
  EXPECT_EQ(alone.component.cause(), Cause::loop_silent);
  alone.component.on_error();
  alone.far.with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) EXPECT_FALSE(drive.enabled());
    return 0;
  });
}

TEST(Cia402Component, ReadAndWriteNeitherAllocateNorLock) {
  if (!RealtimeGuard::watches()) GTEST_SKIP();
  Alone alone;
  auto& component = alone.component;
  ASSERT_TRUE(alone.start()) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  const hardware::Cycle cycle{0, kCycle, 0};
  component.await_cycle(60'000'000'000);
  component.read(cycle, states);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[3 * j];
  std::string violations;
  bool fine = true;
  for (int i = 0; i < 100; ++i) {
    component.await_cycle(60'000'000'000);
    const RealtimeGuard guard;
    commands[0] += 1e-5;
    fine = component.read(cycle, states) == ReturnType::ok &&
           component.write(cycle, commands) == ReturnType::ok && fine;
    if (violations.empty()) violations = guard.violations();
  }
  EXPECT_TRUE(fine) << component.reason();
  EXPECT_EQ(violations, "");
}

}  // namespace
}  // namespace polyarm
