/// Limiters of joint_limits, and the messages that wait for transforms.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <thread>

#include "joint_limits/joint_limiter_interface.hpp"
#include "joint_limits/joint_soft_limiter.hpp"
#include "message_filters/cache.hpp"
#include "message_filters/pass_through.hpp"
#include "rclcpp/rclcpp.hpp"
#include "sensor_msgs/msg/imu.hpp"
#include "std_msgs/msg/string.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tf2_ros/message_filter.h"

namespace {

using joint_limits::JointControlInterfacesData;
using joint_limits::JointLimits;
using trajectory_msgs::msg::JointTrajectoryPoint;
const rclcpp::Duration kLimitCycle = rclcpp::Duration::from_seconds(0.01);

JointLimits elbow_limits() {
  JointLimits out;
  out.has_position_limits = out.has_velocity_limits = out.has_acceleration_limits = true;
  out.has_effort_limits = true;
  out.min_position = -1, out.max_position = 2;
  out.max_velocity = 3, out.max_acceleration = 20, out.max_effort = 50;
  return out;
}
template <class Limiter>
bool start_limiter(Limiter& limiter, std::vector<JointLimits> limits,
                   std::vector<joint_limits::SoftJointLimits> soft = {}) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < limits.size(); ++i) names.push_back("joint" + std::to_string(i));
  return limiter.init(names, limits, soft, nullptr, nullptr);
}

TEST(SaturationLimiter, OfOneJointKeepsEachCommandWithinItsRange) {
  joint_limits::JointSaturationLimiter<JointControlInterfacesData> limiter;
  ASSERT_TRUE(start_limiter(limiter, {elbow_limits()}));
  JointControlInterfacesData actual, wanted;
  actual.position = 0, actual.velocity = 0;
  wanted.position = 5;
  EXPECT_TRUE(limiter.enforce(actual, wanted, kLimitCycle));
  EXPECT_NEAR(*wanted.position, 20 * 0.01 * 0.01, 1e-12);  // from rest, as fast as it can accelerate
  limiter.reset_internals();
  wanted = {}, wanted.velocity = 1;
  EXPECT_TRUE(limiter.enforce(actual, wanted, kLimitCycle));
  EXPECT_NEAR(*wanted.velocity, 0.2, 1e-12);
  actual.position = 2, actual.velocity = 0.1;
  wanted = {}, wanted.effort = 60;
  EXPECT_TRUE(limiter.enforce(actual, wanted, kLimitCycle));
  EXPECT_EQ(*wanted.effort, 0);  // it would push the joint beyond its limit
  wanted.effort = -60;
  EXPECT_TRUE(limiter.enforce(actual, wanted, kLimitCycle));
  EXPECT_EQ(*wanted.effort, -50);
  wanted = {}, wanted.velocity = std::nan("");
  EXPECT_FALSE(limiter.enforce(actual, wanted, kLimitCycle));
  EXPECT_FALSE(limiter.enforce(actual, wanted, rclcpp::Duration(0, 0)));
  actual.position = 2.1, wanted = {}, wanted.position = 1;
  EXPECT_THROW(limiter.enforce(actual, wanted, kLimitCycle), std::runtime_error);
}

TEST(SaturationLimiter, OfOneJointRefusesTwo) {
  joint_limits::JointSaturationLimiter<JointControlInterfacesData> limiter;
  EXPECT_FALSE(start_limiter(limiter, {elbow_limits(), elbow_limits()}));
}

TEST(SaturationLimiter, OfAPointStopsAllJointsBeforeALimitOfOne) {
  joint_limits::JointSaturationLimiter<JointTrajectoryPoint> limiter;
  JointLimits free = elbow_limits();
  free.has_position_limits = false;
  ASSERT_TRUE(start_limiter(limiter, {elbow_limits(), free}));
  JointTrajectoryPoint at, wanted;
  at.positions = {0, 0}, at.velocities = {0, 0};
  double fastest = 0;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 4);
  for (int i = 0; i < 2000; ++i) {
    wanted.positions.clear(), wanted.velocities = {i % 500 < 250 ? 3 : any(random), any(random)};
    limiter.enforce(at, wanted, kLimitCycle);
    for (std::size_t j = 0; j < 2; ++j) {
      EXPECT_LE(std::fabs(wanted.velocities[j]), 3 + 1e-9);
      EXPECT_LE(std::fabs(wanted.velocities[j] - at.velocities[j]), 0.2 + 1e-9);
      at.positions[j] += wanted.velocities[j] * 0.01;
      at.velocities[j] = wanted.velocities[j];
    }
    fastest = std::max(fastest, at.velocities[0]);
    EXPECT_LE(at.positions[0], 2 + 1e-9);
    EXPECT_GE(at.positions[0], -1 - 1e-9);
  }
  EXPECT_GT(fastest, 2.9);
}

TEST(SaturationLimiter, AllocatesNothingInACycle) {
  if (!polyarm::test::RealtimeGuard::watches()) GTEST_SKIP() << "a sanitizer watches the allocations";
  joint_limits::JointSaturationLimiter<JointTrajectoryPoint> limiter;
  ASSERT_TRUE(start_limiter(limiter, {elbow_limits(), elbow_limits()}));
  JointTrajectoryPoint at, wanted;
  at.positions = {0, 0}, at.velocities = {0, 0};
  wanted.positions = {1, 1}, wanted.velocities = {9, 9}, wanted.accelerations = {0, 0};
  limiter.enforce(at, wanted, kLimitCycle);
  std::uint64_t allocations = 0;
  {
    const polyarm::test::RealtimeGuard guard;
    wanted.positions[0] = 1, wanted.velocities[0] = 9;
    limiter.enforce(at, wanted, kLimitCycle);
    allocations = polyarm::test::RealtimeGuard::allocations();
  }
  EXPECT_EQ(allocations, 0u);
}

template <class Limiter>
void expect_no_allocation_with_a_long_name() {
  Limiter limiter;
  const std::string name = "left_arm_wrist_rotation_joint";
  joint_limits::SoftJointLimits soft;
  soft.min_position = -0.8, soft.max_position = 1.5, soft.k_position = 4, soft.k_velocity = 10;
  ASSERT_TRUE(limiter.init({name}, {elbow_limits()}, {soft}, nullptr, nullptr));
  JointControlInterfacesData actual, wanted;
  actual.joint_name = wanted.joint_name = name;
  actual.position = 0, actual.velocity = 0;
  for (const bool reset : {false, true}) {
    if (reset) limiter.reset_internals();
    std::uint64_t allocations = 0;
    {
      const polyarm::test::RealtimeGuard guard;
      for (int i = 0; i < 3; ++i) {
        wanted.position = 1, wanted.velocity = 9, wanted.effort = 90;
        limiter.enforce(actual, wanted, kLimitCycle);
      }
      allocations = polyarm::test::RealtimeGuard::allocations();
    }
    EXPECT_EQ(allocations, 0u) << (reset ? "after a reset" : "from the first cycle on");
  }
}

TEST(Limiters, OfOneJointAllocateNothingFromTheirFirstCycleOn) {
  if (!polyarm::test::RealtimeGuard::watches()) GTEST_SKIP() << "a sanitizer watches the allocations";
  expect_no_allocation_with_a_long_name<joint_limits::JointSaturationLimiter<JointControlInterfacesData>>();
  expect_no_allocation_with_a_long_name<joint_limits::JointSoftLimiter>();
}

TEST(SoftLimiter, SlowsAJointDownTowardsItsSoftLimit) {
  joint_limits::JointSoftLimiter limiter;
  joint_limits::SoftJointLimits soft;
  soft.min_position = -0.8, soft.max_position = 1.5, soft.k_position = 4, soft.k_velocity = 10;
  JointLimits hard = elbow_limits();
  hard.has_acceleration_limits = false;
  ASSERT_TRUE(start_limiter(limiter, {hard}, {soft}));
  JointControlInterfacesData actual, wanted;
  actual.position = 0, actual.velocity = 0;
  double before = 0;
  for (int i = 0; i < 1000; ++i) {
    wanted.position = 5;
    limiter.enforce(actual, wanted, kLimitCycle);
    EXPECT_LE(*wanted.position - before, std::min(3.0, 4 * (1.5 - before)) * 0.01 + 1e-12);
    before = *wanted.position;
    actual.position = before;
  }
  EXPECT_NEAR(before, 1.5, 1e-6);
}

TEST(Limiters, ReadParametersFollowThemAndAreLoadedByName) {
  rclcpp::NodeOptions options;
  options.parameter_overrides({rclcpp::Parameter("joint_limits.a.has_velocity_limits", true),
                               rclcpp::Parameter("joint_limits.a.max_velocity", 0.5)});
  const auto node = std::make_shared<rclcpp::Node>("limited", options);
  pluginlib::ClassLoader<joint_limits::JointLimiterInterface<JointControlInterfacesData>> loader(
      "joint_limits", "joint_limits::JointLimiterInterface<joint_limits::JointControlInterfacesData>");
  const auto limiter = loader.createSharedInstance("joint_limits/JointInterfacesSaturationLimiter");
  ASSERT_TRUE(limiter->init({"a"}, node));
  JointControlInterfacesData actual, wanted;
  wanted.velocity = 2;
  EXPECT_TRUE(limiter->enforce(actual, wanted, kLimitCycle));
  EXPECT_EQ(*wanted.velocity, 0.5);
  node->set_parameter(rclcpp::Parameter("joint_limits.a.max_velocity", 1.5));
  wanted.velocity = 2;
  EXPECT_TRUE(limiter->enforce(actual, wanted, kLimitCycle));
  EXPECT_EQ(*wanted.velocity, 1.5);
}

std::shared_ptr<sensor_msgs::msg::Imu> imu_at(const std::string& frame, int second) {
  auto out = std::make_shared<sensor_msgs::msg::Imu>();
  out->header.frame_id = frame;
  out->header.stamp = rclcpp::Time(std::int64_t{second} * 1000000000, RCL_ROS_TIME);
  return out;
}
geometry_msgs::msg::TransformStamped head_pose(int second) {
  geometry_msgs::msg::TransformStamped out;
  out.header.frame_id = "base", out.child_frame_id = "head";
  out.header.stamp = imu_at("", second)->header.stamp;
  out.transform.rotation.w = 1;
  return out;
}

TEST(TransformFilter, PassesMessagesOnceTheirTransformIsKnown) {
  tf2_ros::Buffer buffer(std::make_shared<rclcpp::Clock>(RCL_ROS_TIME));
  const auto node = std::make_shared<rclcpp::Node>("filtering_transforms");
  message_filters::PassThrough<sensor_msgs::msg::Imu> input;
  std::vector<int> passed, refused;
  {
    tf2_ros::MessageFilter<sensor_msgs::msg::Imu> filter(input, buffer, "base", 3, node);
    filter.registerCallback([&](const std::shared_ptr<const sensor_msgs::msg::Imu>& m) {
      passed.push_back(m->header.stamp.sec);
    });
    auto failures = filter.registerFailureCallback(
        [&](const auto& m, tf2_ros::FilterFailureReason) { refused.push_back(m->header.stamp.sec); });
    buffer.setTransform(head_pose(1), "test");
    for (const int second : {1, 2, 3, 4, 5}) input.add(imu_at("head", second));
    EXPECT_EQ(passed, std::vector<int>{1});
    EXPECT_EQ(refused, std::vector<int>{2});  // three may wait
    buffer.setTransform(head_pose(4), "test");
    EXPECT_EQ(passed, (std::vector<int>{1, 3, 4}));
    input.add(imu_at("", 9));
    EXPECT_EQ(refused, (std::vector<int>{2, 9}));
    failures.disconnect();
  }
  buffer.setTransform(head_pose(6), "test");  // the filter has ended
  EXPECT_EQ(passed, (std::vector<int>{1, 3, 4}));
}

TEST(MessageFilters, ASmallerCacheDropsItsOldestMessages) {
  message_filters::PassThrough<sensor_msgs::msg::Imu> input;
  message_filters::Cache<sensor_msgs::msg::Imu> cache(input, 5);
  for (int second = 1; second <= 5; ++second) input.add(imu_at("a", second));
  cache.setCacheSize(2);
  EXPECT_EQ(cache.getOldestTime().seconds(), 4);
  input.add(imu_at("a", 6));
  EXPECT_EQ(cache.getOldestTime().seconds(), 5);
  EXPECT_EQ(cache.getLatestTime().seconds(), 6);
}

}  // namespace
