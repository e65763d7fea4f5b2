#include "my_device.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "polyarm/hardware/component_rig.hpp"

namespace my_device_plugin {
namespace {

/// The far side: a device that a test can look at and unplug.
struct Device {
  std::vector<double> positions{0.3, -0.2};
  bool there = true, enabled = false, open = false;
  int writes = 0;
};

class FakeWire : public Wire {
 public:
  explicit FakeWire(Device& device) : device_(device) {}
  bool open(const std::string&, std::size_t) override { return device_.open = device_.there; }
  void close() noexcept override { device_.open = false; }
  bool enable(bool on) noexcept override {
    device_.enabled = on;
    return device_.there;
  }
  bool read(std::size_t joint, double& position) noexcept override {
    position = device_.positions[joint];
    return device_.there;
  }
  bool write(std::size_t joint, double position) noexcept override {
    ++device_.writes;
    device_.positions[joint] = position;
    return device_.there;
  }

 private:
  Device& device_;
};

class MyDeviceTest : public ::testing::Test {
 protected:
  Device device;
  hw::ComponentRig rig{std::make_unique<MyDevice>(std::make_unique<FakeWire>(device)),
                       {"joint_1", "joint_2"}};
};

TEST_F(MyDeviceTest, GoesThroughItsLifeAndLeavesTheDeviceClosed) {
  ASSERT_EQ(rig.initialise(), hw::CallbackReturn::success);
  EXPECT_FALSE(device.open);
  ASSERT_EQ(rig.configure(), hw::CallbackReturn::success);
  EXPECT_TRUE(device.open);
  EXPECT_FALSE(device.enabled);
  ASSERT_EQ(rig.cycle(), hw::ReturnType::ok);  // inactive: it is read
  EXPECT_EQ(rig.state("joint_1/position"), 0.3);
  ASSERT_EQ(rig.activate(), hw::CallbackReturn::success);
  EXPECT_TRUE(device.enabled);
  ASSERT_EQ(rig.deactivate(), hw::CallbackReturn::success);
  EXPECT_FALSE(device.enabled);
  ASSERT_EQ(rig.cleanup(), hw::CallbackReturn::success);
  ASSERT_EQ(rig.configure(), hw::CallbackReturn::success);  // and once more
  ASSERT_EQ(rig.shut_down(), hw::CallbackReturn::success);
  EXPECT_FALSE(device.open);
}

TEST_F(MyDeviceTest, BeginsWhereItStands) {
  ASSERT_TRUE(rig.start());
  EXPECT_EQ(device.positions, (std::vector<double>{0.3, -0.2}));
}

TEST_F(MyDeviceTest, GoesWhereItIsToldAndNoCommandIsNoCommand) {
  ASSERT_TRUE(rig.start());
  rig.command("joint_1/position") = 0.5;
  rig.command("joint_2/position") = NAN;
  ASSERT_EQ(rig.cycle(), hw::ReturnType::ok);
  EXPECT_EQ(device.positions, (std::vector<double>{0.5, -0.2}));
}

TEST_F(MyDeviceTest, AnUnpluggedCableIsAnErrorThatNamesTheJoint) {
  ASSERT_TRUE(rig.start());
  device.there = false;
  EXPECT_EQ(rig.cycle(), hw::ReturnType::error);
  EXPECT_EQ(rig.lifecycle(), hw::LifecycleState::unconfigured);
  EXPECT_FALSE(device.enabled);
  EXPECT_NE(rig.component().reason().find("arm/joint_1"), std::string::npos) << rig.component().reason();
}

TEST_F(MyDeviceTest, ADeviceThatIsNotThereIsToldWhenItIsConfigured) {
  device.there = false;
  ASSERT_EQ(rig.initialise(), hw::CallbackReturn::success);
  EXPECT_EQ(rig.configure(), hw::CallbackReturn::failure);
  EXPECT_NE(rig.component().reason().find("no device answers"), std::string::npos);
}

TEST_F(MyDeviceTest, EveryWrongParameterIsTold) {
  rig.context().parameters = {{"prot", "/dev/ttyUSB0"}, {"speed", "1"}};
  try {
    rig.initialise();
    FAIL() << "nothing was told";
  } catch (const polyarm::Error& e) {
    EXPECT_EQ(e.problems().size(), 2u) << e.what();
  }
}

}  // namespace
}  // namespace my_device_plugin
