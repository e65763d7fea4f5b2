#include <atomic>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "tests/servos/rig.hpp"
#include "tests/support/waiting_component.hpp"

namespace polyarm::test {
namespace {

constexpr std::size_t kPosition = 0, kEffort = 2, kCurrent = 3, kTemperature = 4, kVoltage = 5;

INSTANTIATE_TEST_SUITE_P(On, BothWires, testing::Values(Wire::feetech, Wire::dynamixel),
                         [](const auto& which) {
                           return std::string(which.param == Wire::feetech ? "Feetech" : "Dynamixel");
                         });

TEST_P(BothWires, OffersWhatIsDeclaredAndSaysThatItIsReal) {
  ServoRig rig(GetParam());
  EXPECT_TRUE(rig.component->real());
  EXPECT_TRUE(rig.component->blocks());
  ASSERT_EQ(rig.component->state_interfaces().size(), 18u);
  EXPECT_EQ(rig.component->state_interfaces()[4].name, "arm/a/temperature");
  EXPECT_EQ(rig.component->command_interfaces()[2].name, "arm/c/position");
}

TEST_P(BothWires, JointsLedByHandAreLetGoAndOnlyMeasured) {
  ServoRig rig(GetParam());
  rig.set("by_hand", "true");
  rig.set("release_time", "0.1");
  EXPECT_TRUE(rig.component->command_interfaces().empty());
  for (const int id : {1, 2, 3}) rig.fake.set(id, rig.family.torque, id == 2);  // b still holds
  ASSERT_TRUE(rig.start());
  EXPECT_EQ(rig.fake.get(2, rig.family.torque), 0);
  EXPECT_TRUE(rig.fake.written(1, rig.family.goal_position).empty());
  rig.fake.move_by_hand(1, 1500);
  ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
  EXPECT_NEAR(rig.state(0, kPosition), (1500 - 2048) * kStep, 1e-12);
  ASSERT_EQ(rig.component->on_deactivate(), CallbackReturn::success);
  ASSERT_EQ(rig.component->on_shutdown(), CallbackReturn::success);
  for (const int id : {1, 2, 3}) {
    EXPECT_EQ(rig.fake.get(id, rig.family.torque), 0);
    EXPECT_TRUE(rig.fake.written(id, rig.family.goal_position).empty());
  }
}

TEST_P(BothWires, ConfiguringWritesNothing) {
  ServoRig rig(GetParam());
  rig.fake.set(1, rig.family.goal_position, 100);
  ASSERT_EQ(rig.component->on_configure(), CallbackReturn::success) << rig.component->reason();
  ASSERT_EQ(rig.step(), ReturnType::ok);
  EXPECT_EQ(rig.fake.get(1, rig.family.torque), 0);
  EXPECT_EQ(rig.fake.get(1, rig.family.goal_position), 100);
  EXPECT_EQ(rig.fake.get(1, rig.family.present_position), 2048);
}

TEST_P(BothWires, ActivationTakesOverFromWhereTheJointsStand) {
  ServoRig rig(GetParam());
  for (const int id : {1, 2, 3}) {
    rig.fake.set(id, rig.family.goal_position, 3000);  // what an earlier session has left
    rig.fake.move_by_hand(id, 1000 + 100 * id);
  }
  ASSERT_TRUE(rig.start());
  for (int k = 0; k < 5; ++k) ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
  for (const int id : {1, 2, 3}) {
    EXPECT_EQ(rig.fake.get(id, rig.family.torque), 1);
    EXPECT_EQ(rig.fake.written(id, rig.family.goal_position), std::vector<std::int32_t>{1000 + 100 * id});
    EXPECT_EQ(rig.fake.get(id, rig.family.present_position), 1000 + 100 * id);
  }
  EXPECT_NEAR(rig.state(0, kPosition), (1100 - 2048) * kStep, 1e-12);
}

TEST_P(BothWires, JointsFollowTheirCommandsWithDirectionZeroAndOffset) {
  ServoRig rig(GetParam());
  rig.set("b.direction", "-1");
  rig.set("b.zero", "2000");
  rig.set("b.offset", "0.1");
  ASSERT_TRUE(rig.start());
  rig.commands = {0.3, 0.1 + 100 * kStep, -0.2};
  for (int k = 0; k < 40; ++k) ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
  EXPECT_NEAR(rig.state(0, kPosition), 0.3, kStep);
  EXPECT_NEAR(rig.state(1, kPosition), rig.commands[1], 1e-9);
  EXPECT_NEAR(rig.state(2, kPosition), -0.2, kStep);
  EXPECT_EQ(rig.fake.get(2, rig.family.present_position), 1900);
}

TEST_P(BothWires, NoCommandIsNoGoal) {
  ServoRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  rig.commands = {std::nan(""), 0.1, std::nan("")};
  for (int k = 0; k < 20; ++k) ASSERT_EQ(rig.step(), ReturnType::ok);
  EXPECT_EQ(rig.fake.written(1, rig.family.goal_position).size(), 1u) << "only that of the activation";
  EXPECT_GT(rig.fake.written(2, rig.family.goal_position).size(), 10u);
}

TEST_P(BothWires, GoalsStayWithinTheRange) {
  ServoRig rig(GetParam());
  rig.set("a.min", "1900");
  rig.fake.set(2, rig.family.max_limit, 2100);
  ASSERT_TRUE(rig.start());
  rig.commands = {-3, 3, 1e300};
  for (int k = 0; k < 3; ++k) ASSERT_EQ(rig.step(), ReturnType::ok);
  EXPECT_EQ(rig.fake.get(1, rig.family.goal_position), 1900);
  EXPECT_EQ(rig.fake.get(2, rig.family.goal_position), 2100);
  EXPECT_EQ(rig.fake.get(3, rig.family.goal_position), 4095);
}

TEST_P(BothWires, TemperatureVoltageAndEffortAreTold) {
  ServoRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  ASSERT_EQ(rig.step(), ReturnType::ok);
  EXPECT_EQ(rig.state(1, kTemperature), 31);
  EXPECT_NEAR(rig.state(1, kVoltage), GetParam() == Wire::feetech ? 7.4 : 11.8, 1e-9);
  EXPECT_EQ(rig.state(1, kEffort), 0);
  EXPECT_EQ(rig.state(1, kCurrent), 0);
}

TEST_P(BothWires, VelocityJointsTurnAndStandAfterDeactivation) {
  ServoRig rig(GetParam(), "velocity");
  ASSERT_TRUE(rig.start());
  EXPECT_EQ(rig.fake.get(1, rig.family.mode), rig.family.mode_velocity);
  rig.commands = {20 * rig.family.velocity_unit, -20 * rig.family.velocity_unit, 0};
  for (int k = 0; k < 10; ++k) ASSERT_EQ(rig.step(), ReturnType::ok);
  EXPECT_GT(rig.fake.get(1, rig.family.present_position), 2100);
  EXPECT_LT(rig.fake.get(2, rig.family.present_position), 2000);
  EXPECT_EQ(rig.component->on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(rig.fake.get(1, rig.family.goal_velocity), 0);
  EXPECT_EQ(rig.fake.get(1, rig.family.torque), 1) << "deactivating lets nothing fall";
}

TEST_P(BothWires, DeactivationStopsWhatIsUnderWayAndKeepsTorque) {
  ServoRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  rig.commands = {1.0, std::nan(""), std::nan("")};
  for (int k = 0; k < 3; ++k) ASSERT_EQ(rig.step(), ReturnType::ok);
  ASSERT_EQ(rig.component->on_deactivate(), CallbackReturn::success);
  const int goal = rig.fake.get(1, rig.family.goal_position);
  EXPECT_LT(goal, 2400);
  EXPECT_EQ(rig.fake.get(1, rig.family.torque), 1);
  EXPECT_EQ(rig.fake.written(1, rig.family.torque), std::vector<std::int32_t>{1});
  for (int k = 0; k < 5; ++k) EXPECT_EQ(rig.step(), ReturnType::ok) << "inactive: read, not commanded";
  EXPECT_EQ(rig.fake.get(1, rig.family.goal_position), goal);
}

TEST_P(BothWires, ShutdownLeavesTorqueUnlessLoweringIsAskedFor) {
  ServoRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  rig.component->on_deactivate();
  rig.component->on_shutdown();
  EXPECT_EQ(rig.fake.get(1, rig.family.torque), 1);

  ServoRig lowering(GetParam());
  lowering.set("release_time", "0.1");
  lowering.set("torque_off", "on_shutdown");
  ASSERT_TRUE(lowering.start());
  lowering.component->on_deactivate();
  lowering.component->on_shutdown();
  EXPECT_EQ(lowering.fake.get(1, lowering.family.torque), 0);
  const auto limits = lowering.fake.written(2, lowering.family.soft_limit);
  ASSERT_GE(limits.size(), 5u);
  for (std::size_t k = 2; k + 1 < limits.size(); ++k)
    EXPECT_LT(limits[k], limits[k - 1]) << "it gives way little by little";
  EXPECT_EQ(limits.back(), static_cast<int>(lowering.family.soft_limit_full)) << "as it was found";
}

TEST_P(BothWires, ATorqueLimitIsSetBeforeTorque) {
  ServoRig rig(GetParam());
  rig.set("c.torque_limit", "0.5");
  ASSERT_TRUE(rig.start());
  EXPECT_EQ(rig.fake.get(3, rig.family.soft_limit), std::lround(rig.family.soft_limit_full / 2));
}

TEST_P(BothWires, EchoOfTheAdapterIsNoAnswer) {
  ServoRig rig(GetParam());
  Mischief echo;
  echo.echo = true;
  rig.fake.mischief(echo);
  ASSERT_TRUE(rig.start());
  rig.commands = {0.2, -0.2, 0.1};
  for (int k = 0; k < 30; ++k) ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
  EXPECT_NEAR(rig.state(0, kPosition), 0.2, kStep);
  EXPECT_EQ(rig.component->counters().lost, 0u);
}

TEST_P(BothWires, GarbageBeforeAnswersIsPassedOver) {
  ServoRig rig(GetParam());
  Mischief noise;
  for (const std::vector<std::uint8_t>& garbage : {std::vector<std::uint8_t>{0x00},
                                                   {0xFF},
                                                   {0xFF, 0xFF},
                                                   {0xFF, 0xFF, 0x01},
                                                   {0xFF, 0xFF, 0xFD, 0x00}}) {
    noise.garbage = garbage;
    rig.fake.mischief(noise);
    ASSERT_EQ(rig.component->on_configure(), CallbackReturn::success) << rig.component->reason();
    ASSERT_EQ(rig.component->on_activate(), CallbackReturn::success) << rig.component->reason();
    for (int k = 0; k < 3; ++k) ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
    EXPECT_EQ(rig.component->counters().lost, 0u);
    EXPECT_GT(rig.component->counters().garbage, 0u);
    rig.component->on_cleanup();
  }
}

TEST_P(BothWires, AnAnswerInPiecesIsOne) {
  ServoRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  Mischief pieces;
  pieces.next_pieces = 9;
  rig.fake.mischief(pieces);
  for (int k = 0; k < 3; ++k) ASSERT_EQ(rig.step(), ReturnType::ok);
  EXPECT_EQ(rig.component->counters().lost, 0u);
}

/// What costs one cycle and no more, each on its own.
class Disturbed : public testing::TestWithParam<std::tuple<Wire, int Mischief::*>> {};
INSTANTIATE_TEST_SUITE_P(On, Disturbed,
                         testing::Combine(testing::Values(Wire::feetech, Wire::dynamixel),
                                          testing::Values(&Mischief::next_lose_byte,
                                                          &Mischief::next_extra_byte,
                                                          &Mischief::next_wrong_checksum,
                                                          &Mischief::next_wrong_id, &Mischief::next_late)));

TEST_P(Disturbed, ACycleIsLostAndTheNextIsGood) {
  ServoRig rig(std::get<0>(GetParam()));
  rig.set("answer_timeout_ms", "100");
  ASSERT_TRUE(rig.start());
  ASSERT_EQ(rig.step(), ReturnType::ok);
  const auto before = rig.component->counters().lost;
  Mischief once;
  once.*std::get<1>(GetParam()) = 1;
  rig.fake.move_by_hand(1, 2060);
  rig.fake.set(1, rig.family.torque, 0);  // stays where the hand has put it
  rig.fake.mischief(once);
  ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
  EXPECT_NEAR(rig.state(0, kPosition), 0, 1e-9) << "what is not known stays as it was";
  rig.fake.mischief({});
  rig.fake.move_by_hand(1, 2070);
  for (int k = 0; k < 3; ++k) ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
  EXPECT_NEAR(rig.state(0, kPosition), 22 * kStep, 1e-9);
  EXPECT_GT(rig.component->counters().lost, before);
}

TEST_P(BothWires, SurvivesALineFullOfNoiseAndIsGoodAgainAfterIt) {
  ServoRig rig(GetParam());
  rig.set("answer_timeout_ms", "20");
  rig.set("lost_cycles", "10000");
  ASSERT_TRUE(rig.start());
  std::mt19937 random(7);
  const std::uint8_t likely[] = {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x02, 0xFE, 0x55, 0x04};
  rig.commands = {0.1, -0.1, 0.2};
  for (int k = 0; k < 60; ++k) {
    Mischief noise;
    noise.garbage.resize(random() % 12);
    for (std::uint8_t& byte : noise.garbage) byte = likely[random() % std::size(likely)];
    noise.echo = random() % 2;
    for (int Mischief::*what : {&Mischief::next_lose_byte, &Mischief::next_wrong_checksum,
                                &Mischief::next_extra_byte, &Mischief::next_late, &Mischief::next_wrong_id})
      noise.*what = random() % 4 == 0;
    rig.fake.mischief(noise);
    ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
    for (std::size_t joint = 0; joint < 3; ++joint)
      ASSERT_LT(std::abs(rig.state(joint, kPosition)), 0.3) << "noise is never taken for a position";
  }
  rig.fake.mischief({});
  for (int k = 0; k < 40; ++k) ASSERT_EQ(rig.step(), ReturnType::ok);
  EXPECT_NEAR(rig.state(0, kPosition), 0.1, kStep);
}

TEST_P(BothWires, AServoThatFallsSilentIsNamedAfterSoManyCycles) {
  ServoRig rig(GetParam());
  rig.set("lost_cycles", "4");
  rig.set("answer_timeout_ms", "100");
  ASSERT_TRUE(rig.start());
  ASSERT_EQ(rig.step(), ReturnType::ok);
  Mischief silent;
  silent.silent = {2};
  rig.fake.mischief(silent);
  const double last = rig.state(1, kPosition);
  EXPECT_EQ(rig.steps_until_error(), 4);
  EXPECT_TRUE(rig.says("b (servo 2 on " + rig.fake.path() + "): no answer in 4 cycles"))
      << rig.component->reason();
  EXPECT_FALSE(rig.says("a (servo 1"));
  EXPECT_EQ(rig.state(1, kPosition), last);
}

TEST_P(BothWires, APulledCableEndsInAnErrorThatNamesTheJoints) {
  ServoRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  ASSERT_EQ(rig.step(), ReturnType::ok);
  rig.fake.close_connection();
  EXPECT_GT(rig.steps_until_error(), 0);
  EXPECT_TRUE(rig.says("is gone")) << rig.component->reason();
  for (const char* joint : {"a (servo 1", "b (servo 2", "c (servo 3"}) EXPECT_TRUE(rig.says(joint));
  EXPECT_EQ(rig.component->on_error(), CallbackReturn::success);
  EXPECT_EQ(rig.component->on_configure(), CallbackReturn::failure) << "the port is not there any more";
}

TEST_P(BothWires, TheFarSideDiesInTheMidstOfAnAnswer) {
  ServoRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  rig.fake.on_instruction({});
  Mischief half;
  half.silent = {2, 3};
  rig.fake.mischief(half);
  const std::uint64_t before = rig.fake.instructions();
  std::thread cable([&] {
    while (rig.fake.instructions() == before) std::this_thread::yield();
    rig.fake.close_connection();
  });
  const int steps = rig.steps_until_error();
  cable.join();
  EXPECT_GT(steps, 0);
  EXPECT_TRUE(rig.says("is gone")) << rig.component->reason();
}

TEST_P(BothWires, AnOverloadIsToldByNameAndTheJointHoldsWhereItIs) {
  ServoRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  rig.commands = {1.0, std::nan(""), std::nan("")};
  for (int k = 0; k < 3; ++k) ASSERT_EQ(rig.step(), ReturnType::ok);
  rig.fake.set(1, rig.family.status, 0x20);
  EXPECT_EQ(rig.steps_until_error(), 1);
  EXPECT_TRUE(rig.says("a (servo 1")) << rig.component->reason();
  EXPECT_TRUE(rig.says("overload")) << rig.component->reason();
  EXPECT_EQ(rig.component->on_error(), CallbackReturn::success);
  EXPECT_LT(rig.fake.get(1, rig.family.goal_position), 2400);
  EXPECT_TRUE(rig.says("overload")) << "the first cause stays";
  ASSERT_EQ(rig.component->on_configure(), CallbackReturn::success);
  EXPECT_EQ(rig.component->on_activate(), CallbackReturn::failure) << "not before the alarm is over";
  EXPECT_TRUE(rig.says("overload")) << rig.component->reason();
}

TEST_P(BothWires, AHotServoIsAnErrorAtItsLimit) {
  ServoRig rig(GetParam());
  rig.set("c.max_temperature", "55");
  ASSERT_TRUE(rig.start());
  rig.fake.set(3, rig.family.present_temperature, 54);
  EXPECT_EQ(rig.step(), ReturnType::ok);
  rig.fake.set(3, rig.family.present_temperature, 55);
  EXPECT_EQ(rig.steps_until_error(), 1);
  EXPECT_TRUE(rig.says("c (servo 3") && rig.says("55 °C")) << rig.component->reason();
}

TEST_P(BothWires, AJointThatIsHeldFastIsFoundStalled) {
  ServoRig rig(GetParam());
  rig.set("b.stall_effort", "0.9");
  rig.set("b.stall_time", "0.05");
  ASSERT_TRUE(rig.start());
  rig.fake.block(2, true);
  rig.commands = {0.5, 0.5, std::nan("")};
  EXPECT_GE(rig.steps_until_error(), 5);
  EXPECT_TRUE(rig.says("b (servo 2") && rig.says("in its way")) << rig.component->reason();
}

TEST_P(BothWires, RefusesToHoldOutsideTheRange) {
  ServoRig rig(GetParam());
  rig.set("b.max", "2500");
  rig.fake.move_by_hand(2, 2600);
  EXPECT_FALSE(rig.start());
  EXPECT_TRUE(rig.says("b (servo 2") && rig.says("100 steps outside")) << rig.component->reason();
  EXPECT_EQ(rig.fake.get(1, rig.family.torque), 0) << "nobody is enabled where one cannot be";
}

TEST_P(BothWires, RefusesTheWrongSupply) {
  ServoRig rig(GetParam());
  rig.fake.set(1, rig.family.present_voltage, 30);
  EXPECT_FALSE(rig.start());
  EXPECT_TRUE(rig.says("3 V")) << rig.component->reason();
}

TEST_P(BothWires, NamesEveryServoThatIsMissingOrWrong) {
  ServoRig rig(GetParam());
  rig.set("answer_timeout_ms", "50");
  rig.fake.unplug(1);
  rig.fake.set(3, rig.family.model, 9999);
  EXPECT_FALSE(rig.start());
  EXPECT_TRUE(rig.says("a (servo 1") && rig.says("does not answer")) << rig.component->reason();
  EXPECT_TRUE(rig.says("c (servo 3") && rig.says("9999")) << rig.component->reason();
  rig.fake.plug_in(1);
  rig.set("c.model", "any");
  EXPECT_TRUE(rig.start());
}

TEST_P(BothWires, NeverTakesTorqueOffToChangeAMode) {
  ServoRig rig(GetParam(), "velocity");
  rig.fake.set(2, rig.family.torque, 1);
  EXPECT_FALSE(rig.start());
  EXPECT_TRUE(rig.says("b (servo 2") && rig.says("support the arm")) << rig.component->reason();
  EXPECT_EQ(rig.fake.get(2, rig.family.torque), 1);
}

TEST_P(BothWires, ActivationFromAnotherThreadThanTheReadsHasTheBusForItself) {
  ServoRig rig(GetParam());
  ASSERT_EQ(rig.component->on_configure(), CallbackReturn::success) << rig.component->reason();
  std::atomic<bool> done = false;
  std::thread loop([&] {
    while (!done) rig.step();
  });
  for (int k = 0; k < 30; ++k) {
    EXPECT_EQ(rig.component->on_activate(), CallbackReturn::success) << rig.component->reason();
    EXPECT_EQ(rig.component->on_deactivate(), CallbackReturn::success);
  }
  done = true;
  loop.join();
  EXPECT_EQ(rig.component->counters().lost, 0u);
}

TEST_P(BothWires, ABusHasOneMaster) {
  ServoRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  ServoRig second(GetParam());
  second.set("port", rig.fake.path());
  EXPECT_FALSE(second.start());
  EXPECT_TRUE(second.says("in use by component bus")) << second.component->reason();
  rig.component->on_cleanup();
  EXPECT_TRUE(second.start());
}

/// Cycles of joints in position, and of joints in velocity with their watchdog.
class UnderGuard : public testing::TestWithParam<std::tuple<Wire, const char*>> {};
INSTANTIATE_TEST_SUITE_P(On, UnderGuard,
                         testing::Combine(testing::Values(Wire::feetech, Wire::dynamixel),
                                          testing::Values("position", "velocity")));

TEST_P(UnderGuard, ReadAndWriteNeitherAllocateNorThrow) {
  ServoRig rig(std::get<0>(GetParam()), std::get<1>(GetParam()));
  rig.set("watchdog", "on");
  rig.set("watchdog_ms", "5000");
  rig.set("answer_timeout_ms", "20");
  const auto guarded = [&](int cycles) {
    return neither_allocates_nor_throws(*rig.component, cycles, rig.states, rig.commands);
  };
  ASSERT_TRUE(rig.start());
  rig.commands = {0.1, 0.2, 0.3};
  for (int k = 0; k < 5; ++k) ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
  Mischief noise;
  noise.garbage = {0xFF, 0x13};
  rig.fake.mischief(noise);
  EXPECT_TRUE(guarded(200));
  ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
  noise.silent = {2};
  rig.fake.mischief(noise);
  EXPECT_TRUE(guarded(6)) << "nor while answers are lost";
  EXPECT_TRUE(rig.says("no answer in 5 cycles")) << rig.component->reason();
  rig.fake.close_connection();
  EXPECT_TRUE(guarded(3)) << "nor when the port is gone";
}

TEST_P(BothWires, EveryWrongParameterIsToldAtOnce) {
  ServoRig rig(GetParam());
  rig.context.parameters = {{"baud", "fast"}, {"lost_cycles", "0"}, {"a.direction", "0"},
                            {"a.zerro", "1"}, {"d.id", "4"},        {"torque_off", "now"},
                            {"b.id", "1"},    {"c.min", "5"},       {"c.max", "5"}};
  try {
    rig.component->on_init(rig.context);
    FAIL() << "it took them";
  } catch (const Error& e) {
    const std::string all = e.what();
    for (const char* text :
         {"port", "baud = 'fast'", "lost_cycles", "a.direction", "a.zerro", "did you mean 'zero'", "'d'",
          "torque_off", "same servo id 1", "c.min is not below"})
      EXPECT_NE(all.find(text), std::string::npos) << text << "\n" << all;
  }
}

TEST_P(BothWires, ACalibrationFileGivesWhatTheCellDoesNot) {
  ServoRig rig(GetParam());
  const auto path =
      std::filesystem::temp_directory_path() / ("polyarm_cal_" + std::to_string(getpid()) + ".yaml");
  std::ofstream(path)
      << "polyarm: servo_calibration/1\nfamily: " << rig.family.name
      << "\njoints:\n  a: {id: 3, zero: 1000}\n  b: {id: 2, zero: 1900, min: 1800, max: 2300}\n"
         "  c: {id: 1, direction: -1}\n";
  for (auto& part : rig.context.robots[0].hardware[0].components) part.parameters.clear();
  rig.context.parameters["b.zero"] = "2048";
  rig.set("calibration", path.string());
  ASSERT_TRUE(rig.start());
  ASSERT_EQ(rig.step(), ReturnType::ok);
  EXPECT_NEAR(rig.state(0, kPosition), 1048 * kStep, 1e-9);
  EXPECT_NEAR(rig.state(1, kPosition), 0, 1e-9) << "the cell has the last word";
  rig.commands = {std::nan(""), 2, std::nan("")};
  for (int k = 0; k < 2; ++k) ASSERT_EQ(rig.step(), ReturnType::ok);  // nobody answers a sync write
  EXPECT_EQ(rig.fake.get(2, rig.family.goal_position), 2300);
  std::filesystem::remove(path);
}

TEST(Feetech, TheModeIsChangedBehindTheLockAndTheLockCloses) {
  ServoRig rig(Wire::feetech, "velocity");
  ASSERT_TRUE(rig.start());
  EXPECT_EQ(rig.fake.written(1, rig.family.lock), (std::vector<std::int32_t>{0, 1}));
}

TEST(Feetech, CoarseSpeedUnitsOfOlderServosAreKnown) {
  ServoRig rig(Wire::feetech, "velocity");
  rig.fake.set(1, rig.family.phase, 0);
  ASSERT_TRUE(rig.start());
  rig.commands = {500 * kStep, 500 * kStep, 0};
  for (int k = 0; k < 2; ++k) ASSERT_EQ(rig.step(), ReturnType::ok);  // nobody answers a sync write
  EXPECT_EQ(rig.fake.get(1, rig.family.goal_velocity), 10);
  EXPECT_EQ(rig.fake.get(2, rig.family.goal_velocity), 500);
}

TEST(Dynamixel, FastSyncReadTellsTheSame) {
  ServoRig rig(Wire::dynamixel);
  rig.set("fast_sync_read", "true");
  ASSERT_TRUE(rig.start());
  rig.fake.move_by_hand(3, 2100);
  rig.commands = {0.1, -0.1, std::nan("")};
  for (int k = 0; k < 10; ++k) ASSERT_EQ(rig.step(), ReturnType::ok) << rig.component->reason();
  EXPECT_NEAR(rig.state(0, kPosition), 0.1, kStep);
  EXPECT_EQ(rig.component->counters().lost, 0u);
}

TEST(Dynamixel, InAFastAnswerThoseBehindAGapAreLostAndTheFirstOfThemIsNamed) {
  ServoRig rig(Wire::dynamixel);
  rig.set("fast_sync_read", "true");
  rig.set("answer_timeout_ms", "50");
  ASSERT_TRUE(rig.start());
  Mischief silent;
  silent.silent = {2};
  rig.fake.mischief(silent);
  EXPECT_EQ(rig.steps_until_error(), 5);
  EXPECT_TRUE(rig.says("b (servo 2"));
  EXPECT_FALSE(rig.says("a (servo 1"));
}

TEST(Dynamixel, CurrentModeCommandsAmperes) {
  ServoRig rig(Wire::dynamixel, "current");
  ASSERT_TRUE(rig.start());
  EXPECT_EQ(rig.fake.get(1, rig.family.mode), 0);
  rig.commands = {0.269, -0.269, 0};
  for (int k = 0; k < 2; ++k) ASSERT_EQ(rig.step(), ReturnType::ok);  // nobody answers a sync write
  EXPECT_EQ(rig.fake.get(1, rig.family.goal_current), 100);
  EXPECT_EQ(rig.fake.get(2, rig.family.goal_current), -100);
}

TEST(Dynamixel, AWatchdogInTheServoStopsWhatTurnsWithoutAMaster) {
  ServoRig rig(Wire::dynamixel, "velocity");
  rig.set("bus_watchdog_ms", "200");
  ASSERT_TRUE(rig.start());
  EXPECT_EQ(rig.fake.get(1, rig.family.watchdog), 10);
}

TEST(Dynamixel, EveryHardwareErrorHasItsName) {
  const auto& family = dynamixel::x_family();
  EXPECT_EQ(servo_bus::status_names(family, 0x3D),
            "input voltage and overheating and motor encoder and electrical shock and overload");
  EXPECT_EQ(servo_bus::status_names(family, 0x40), "bit 6");
}

}  // namespace
}  // namespace polyarm::test
