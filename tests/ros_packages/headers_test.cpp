/// What the small headers with ROS's names do.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "angles/angles.h"
#include "hardware_interface/handle.hpp"
#include "hardware_interface/lexical_casts.hpp"
#include "rclcpp/rclcpp.hpp"
#include "realtime_tools/realtime_buffer.hpp"
#include "realtime_tools/realtime_thread_safe_box.hpp"
#include "tf2_geometry_msgs/tf2_geometry_msgs.hpp"
#include "urdf/model.hpp"

namespace {

TEST(Angles, GoTheShortestWayWithinLimitsOfMoreThanATurn) {
  double way = 0;
  EXPECT_TRUE(angles::shortest_angular_distance_with_large_limits(6, 0.2, -7, 7, way));
  EXPECT_NEAR(way, 0.2 + 2 * M_PI - 6, 1e-12);
  EXPECT_TRUE(angles::shortest_angular_distance_with_large_limits(6, 0.2, -7, 6.1, way));
  EXPECT_NEAR(way, 0.2 - 6, 1e-12);
  EXPECT_FALSE(angles::shortest_angular_distance_with_large_limits(8, 0.2, -7, 7, way));
  EXPECT_NEAR(angles::normalize_angle(3 * M_PI / 2), -M_PI / 2, 1e-12);
}

TEST(Transforms, OfMessagesTurnThenMoveAndGoBack) {
  tf2::Quaternion turn;
  turn.setRPY(0.3, -0.2, 1.1);
  const tf2::Transform there(turn, tf2::Vector3(1, 2, 3));
  const tf2::Vector3 v(0.5, -0.4, 2), back = there.inverse() * (there * v);
  EXPECT_NEAR((back - v).length(), 0, 1e-12);
  EXPECT_NEAR(there.getRotation().angleShortestPath(turn), 0, 1e-7);
  geometry_msgs::msg::TransformStamped stamped;
  stamped.header.frame_id = "base";
  stamped.transform = tf2::toMsg(there);
  geometry_msgs::msg::PoseStamped pose;
  pose.pose.position.z = 2;
  geometry_msgs::msg::PoseStamped moved;
  tf2::doTransform(pose, moved, stamped);
  EXPECT_EQ(moved.header.frame_id, "base");
  EXPECT_NEAR(moved.pose.position.z, (there * tf2::Vector3(0, 0, 2)).z(), 1e-12);
  for (const double sign : {1.0, -1.0}) {  // a half turn, where the trace is negative
    tf2::Quaternion half(tf2::Vector3(sign, 0, 0), 3.1), out;
    tf2::Matrix3x3(half).getRotation(out);
    EXPECT_NEAR(out.angleShortestPath(half), 0, 1e-7);
  }
}

TEST(RobotDescription, HasTheMassesOfItsLinks) {
  urdf::Model model;
  ASSERT_TRUE(model.initString(
      "<robot name='r'><link name='a'/><link name='b'><visual><origin xyz='9 9 9'/></visual><inertial>"
      "<origin xyz='0 0 0.1'/><mass value='2'/><inertia ixx='1' iyy='2' izz='3' ixy='0' ixz='0' iyz='0.5'/>"
      "</inertial></link><joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint></robot>"));
  EXPECT_EQ(model.getLink("a")->inertial, nullptr);
  ASSERT_NE(model.getLink("b")->inertial, nullptr);
  EXPECT_EQ(model.getLink("b")->inertial->mass, 2);
  EXPECT_EQ(model.getLink("b")->inertial->iyz, 0.5);
  EXPECT_EQ(model.getLink("b")->inertial->origin.position.z, 0.1);
}

TEST(LexicalCasts, ReadNumbersListsAndBooleansAndRefuseTheRest) {
  using namespace hardware_interface;
  EXPECT_EQ(hardware_interface::stod("1.5"), 1.5);
  EXPECT_TRUE(std::isnan(hardware_interface::stod("nan")));
  EXPECT_THROW(hardware_interface::stod("1,5"), std::invalid_argument);
  EXPECT_EQ(parse_array<double>("[1, 2.5]"), (std::vector<double>{1, 2.5}));
  EXPECT_EQ(parse_string_array("['a', b]"), (std::vector<std::string>{"a", "b"}));
  EXPECT_THROW(parse_array<int>("[1, x]"), std::invalid_argument);
  EXPECT_TRUE(parse_bool("True"));
  EXPECT_THROW(parse_bool("yes"), std::invalid_argument);
}

TEST(Handles, HoldEveryTypeAsItsDescriptionSays) {
  hardware_interface::InterfaceInfo info;
  info.name = "vacuum", info.data_type = "bool", info.initial_value = "true";
  hardware_interface::StateInterface vacuum{hardware_interface::InterfaceDescription("tool", info)};
  EXPECT_EQ(vacuum.get_name(), "tool/vacuum");
  EXPECT_TRUE(*vacuum.get_optional<bool>());
  vacuum.set_value(false);
  EXPECT_FALSE(*vacuum.get_optional<bool>());
  EXPECT_EQ(hardware_interface::StateInterface("t", "n", "uint8").get_value(), 255);
  EXPECT_TRUE(std::isnan(hardware_interface::StateInterface("t", "n", "double").get_value()));
}

TEST(Handles, ThatWereCopiedKeepTheirOwnNumberOrTheSharedOne) {
  double shared = 1;
  const hardware_interface::StateInterface bound("j", "position", &shared);
  hardware_interface::StateInterface copy = bound;
  copy.set_value(2.0);
  EXPECT_EQ(shared, 2);
  const hardware_interface::StateInterface own("j", "position", "double", "3");
  hardware_interface::StateInterface other = own;
  other.set_value(4.0);
  EXPECT_EQ(own.get_value(), 3);
}

TEST(Time, OfTwoClocksCannotBeCompared) {
  EXPECT_THROW((void)(rclcpp::Time(1, 0, RCL_ROS_TIME) < rclcpp::Time(1, 0, RCL_STEADY_TIME)),
               std::runtime_error);
  EXPECT_DOUBLE_EQ((rclcpp::Time(3, 500'000'000) - rclcpp::Time(1, 0)).seconds(), 2.5);
  EXPECT_THROW(rclcpp::Duration::max() + rclcpp::Duration(1, 0), std::overflow_error);
}

TEST(RealtimeBuffer, ShowsTheNewestValueAndNeverWaits) {
  realtime_tools::RealtimeBuffer<int> buffer(1);
  buffer.writeFromNonRT(2);
  buffer.writeFromNonRT(3);
  EXPECT_EQ(*buffer.readFromRT(), 3);
  realtime_tools::RealtimeThreadSafeBox<int> box(4);
  box.get([&](const int& value) {
    EXPECT_EQ(value, 4);
    std::thread([&] { EXPECT_FALSE(box.try_get()); }).join();  // held by this thread
  });
}

TEST(Node, RunsTimersInItsExecutorAndChecksParameters) {
  const auto node = std::make_shared<rclcpp::Node>("n");
  int ran = 0;
  const auto timer = node->create_wall_timer(std::chrono::nanoseconds(0), [&] { ++ran; });
  rclcpp::executors::SingleThreadedExecutor executor;
  executor.add_node(node);
  executor.spin_some();
  EXPECT_EQ(ran, 1);
  EXPECT_EQ(node->declare_parameter("gain", 2.0), 2.0);
  EXPECT_THROW(node->declare_parameter("gain", 2.0), rclcpp::exceptions::ParameterAlreadyDeclaredException);
  const auto handle = node->add_on_set_parameters_callback([](const std::vector<rclcpp::Parameter>& all) {
    rcl_interfaces::msg::SetParametersResult result;
    result.successful = all[0].as_double() > 0;
    return result;
  });
  EXPECT_FALSE(node->set_parameter(rclcpp::Parameter("gain", -1.0)).successful);
  EXPECT_TRUE(node->set_parameter(rclcpp::Parameter("gain", 3.0)).successful);
  EXPECT_EQ(node->get_parameter("gain").as_double(), 3.0);
}

}  // namespace
