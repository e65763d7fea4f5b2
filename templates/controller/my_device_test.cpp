#include "my_device.hpp"

#include <gtest/gtest.h>

#include "polyarm/controllers/controller_rig.hpp"

namespace my_device_plugin {
namespace {

class MyDeviceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    rig.state("joint_1/position") = 0.3;
    rig.state("joint_2/position") = -0.2;
  }
  ctl::ControllerRig rig{std::make_unique<MyDevice>(),
                         {"joint_1", "joint_2"},
                         {{"joints", {"joint_1", "joint_2"}}, {"speed", {"1.0"}}}};
};

TEST_F(MyDeviceTest, BeginsWhereTheJointsAre) {
  ASSERT_TRUE(rig.start());
  EXPECT_EQ(rig.update(), ctl::ReturnType::ok);
  EXPECT_EQ(rig.command("joint_1/position"), 0.3);
  EXPECT_EQ(rig.command("joint_2/position"), -0.2);
  EXPECT_TRUE(rig.controller().standing());
}

TEST_F(MyDeviceTest, GoesThereAtItsSpeed) {
  ASSERT_TRUE(rig.start());
  rig.controller().receive("commands", ctl::Numbers{{0.4, -0.2}}, false);
  rig.update();  // 1 ms at 1 rad/s
  EXPECT_DOUBLE_EQ(rig.command("joint_1/position"), 0.301);
  EXPECT_FALSE(rig.controller().standing());
  for (int i = 0; i < 200; ++i) rig.update();
  EXPECT_EQ(rig.command("joint_1/position"), 0.4);
  EXPECT_TRUE(rig.controller().standing());
}

TEST_F(MyDeviceTest, StopsWhereItIsAndGoesOn) {
  ASSERT_TRUE(rig.start());
  rig.controller().receive("commands", ctl::Numbers{{0.4, -0.2}}, false);
  rig.update();
  rig.verdict.speed = 0;
  rig.update();
  EXPECT_DOUBLE_EQ(rig.command("joint_1/position"), 0.301);
  EXPECT_TRUE(rig.controller().standing());
  rig.verdict.speed = 1;
  rig.update();
  EXPECT_DOUBLE_EQ(rig.command("joint_1/position"), 0.302);
}

TEST_F(MyDeviceTest, TakesANewSpeedWhileItRuns) {
  ASSERT_TRUE(rig.start());
  rig.change("speed", "2");
  rig.controller().receive("commands", ctl::Numbers{{1.0, -0.2}}, false);
  rig.update();
  EXPECT_DOUBLE_EQ(rig.command("joint_1/position"), 0.302);
  EXPECT_THROW(rig.change("speed", "-1"), polyarm::Error);
}

TEST_F(MyDeviceTest, RefusesMessagesOfAnotherSize) {
  ASSERT_TRUE(rig.start());
  EXPECT_THROW(rig.controller().receive("commands", ctl::Numbers{{1}}, false), polyarm::Error);
}

}  // namespace
}  // namespace my_device_plugin
