/// What the small headers with ROS's names do.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "angles/angles.h"
#include "control_msgs/msg/joint_trajectory_controller_state.hpp"
#include "controller_interface/helpers.hpp"
#include "hardware_interface/handle.hpp"
#include "hardware_interface/lexical_casts.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp/scope_exit.hpp"
#include "rcpputils/asserts.hpp"
#include "rcpputils/join.hpp"
#include "rcutils/time.h"
#include "realtime_tools/realtime_buffer.hpp"
#include "realtime_tools/realtime_thread_safe_box.hpp"
#include "rmw/qos_profiles.h"
#include "std_srvs/srv/trigger.hpp"
#include "tf2/LinearMath/Scalar.h"
#include "tf2_geometry_msgs/tf2_geometry_msgs.hpp"
#include "tl/expected.hpp"
#include "trajectory_msgs/msg/joint_trajectory.hpp"
#include "urdf_parser/urdf_parser.h"

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

TEST(Handles, AreOrderedIntoAListThatHasReservedNoRoom) {
  std::vector<hardware_interface::StateInterface> all;
  all.emplace_back("wrist", "position", "double");
  all.emplace_back("elbow", "position", "double");
  all.emplace_back("elbow", "velocity", "double");
  std::vector<std::reference_wrapper<hardware_interface::StateInterface>> ordered;
  EXPECT_TRUE(controller_interface::get_ordered_interfaces(all, {"elbow", "wrist"}, "position", ordered));
  ASSERT_EQ(ordered.size(), 2u);
  EXPECT_EQ(ordered[0].get().get_name(), "elbow/position");
  EXPECT_EQ(ordered[1].get().get_name(), "wrist/position");
  ordered.clear();
  EXPECT_FALSE(
      controller_interface::get_ordered_interfaces(all, {"elbow/velocity", "knee/position"}, "", ordered));
}

TEST(Messages, AreTextInTheFormOfRos) {
  trajectory_msgs::msg::JointTrajectory way;
  way.header.frame_id = "a \"b\"";
  way.joint_names = {"lift"};
  way.points.resize(1);
  way.points[0].positions = {1, -2.5};
  way.points[0].time_from_start.sec = 3;
  EXPECT_EQ(
      trajectory_msgs::msg::to_yaml(way),
      "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: \"a \\\"b\\\"\"\njoint_names:\n- \"lift\"\n"
      "points:\n-\n  positions:\n  - 1.00000\n  - -2.50000\n  velocities: []\n  accelerations: []\n"
      "  effort: []\n  time_from_start:\n    sec: 3\n    nanosec: 0\n");
  EXPECT_EQ(to_yaml(way.points[0], true),
            "{positions: [1.00000, -2.50000], velocities: [], accelerations: [], effort: [], "
            "time_from_start: {sec: 3, nanosec: 0}}");
  EXPECT_EQ(std_srvs::srv::to_yaml(std_srvs::srv::Trigger::Request()), "null\n");
  EXPECT_EQ(std_srvs::srv::to_yaml(std_srvs::srv::Trigger::Response(), true),
            "{success: false, message: \"\"}");
  EXPECT_STREQ(rosidl_generator_traits::data_type<trajectory_msgs::msg::JointTrajectory>(),
               "trajectory_msgs::msg::JointTrajectory");
  EXPECT_TRUE(rosidl_generator_traits::is_service<std_srvs::srv::Trigger>::value);
  EXPECT_FALSE(rosidl_generator_traits::is_message<std_srvs::srv::Trigger>::value);
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

TEST(RobotDescription, HasTheShapesOfItsLinks) {
  const auto model = urdf::parseURDF(
      "<robot name='r'><link name='a'><visual><origin xyz='0 0 1'/><geometry><box size='1 2 3'/></geometry>"
      "</visual><collision><geometry><cylinder radius='0.1' length='2'/></geometry><origin xyz='1 0 0'/>"
      "</collision><collision name='c2'><geometry><mesh filename='f.stl' scale='2 2 2'/></geometry>"
      "</collision></link></robot>");
  ASSERT_TRUE(model);
  const auto link = model->getLink("a");
  EXPECT_EQ(link->visual->origin.position.z, 1);
  EXPECT_EQ(std::dynamic_pointer_cast<urdf::Box>(link->visual->geometry)->dim.y, 2);
  EXPECT_EQ(std::dynamic_pointer_cast<urdf::Cylinder>(link->collision->geometry)->radius, 0.1);
  EXPECT_EQ(link->collision->origin.position.x, 1);
  ASSERT_EQ(link->collision_array.size(), 2u);
  EXPECT_EQ(link->collision_array[1]->geometry->type, urdf::Geometry::MESH);
  EXPECT_EQ(std::dynamic_pointer_cast<urdf::Mesh>(link->collision_array[1]->geometry)->scale.z, 2);
  EXPECT_FALSE(urdf::parseURDF("no robot"));
}

using Outcome = tl::expected<int, std::string>;
Outcome half_of(int n) {
  if (n % 2 != 0) return tl::make_unexpected("odd " + std::to_string(n));
  return n / 2;
}

TEST(Expected, ChainsStepsUntilOneFails) {
  EXPECT_EQ(half_of(8).and_then(half_of).value(), 2);
  EXPECT_EQ(half_of(6).and_then(half_of).error(), "odd 3");
  EXPECT_EQ(half_of(4).map([](int n) { return std::to_string(n); }).value(), "2");
  EXPECT_EQ(half_of(3).map_error([](const std::string& e) { return e.size(); }).error(), 5u);
  EXPECT_EQ(half_of(3).or_else([](const std::string&) -> Outcome { return 7; }).value(), 7);
  std::string said;
  const tl::expected<void, std::string> done =
      half_of(4)
          .and_then([](int) { return tl::expected<void, std::string>(); })
          .and_then([]() -> tl::expected<void, std::string> { return tl::unexpected<std::string>("full"); })
          .or_else([&](const std::string& e) { said = e; });
  EXPECT_FALSE(done);
  EXPECT_EQ(said, "full");
  EXPECT_THROW(done.value(), tl::bad_expected_access<std::string>);
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

TEST(SmallHelpers, DoWhatTheirNamesSay) {
  int ended = 0;
  {
    RCPPUTILS_SCOPE_EXIT(++ended);
    auto cancelled = rcpputils::make_scope_exit([&] { ended += 10; });
    cancelled.cancel();
    EXPECT_EQ(ended, 0);
  }
  EXPECT_EQ(ended, 1);
  EXPECT_EQ(rcpputils::join(std::vector<int>{1, 2, 3}, ", "), "1, 2, 3");
  EXPECT_THROW(rcpputils::check_true(false, "shut"), rcpputils::IllegalStateException);
  EXPECT_THROW(rcpputils::require_true(false), std::invalid_argument);
  EXPECT_EQ(RCUTILS_S_TO_NS(2), 2'000'000'000);
  EXPECT_EQ(RCUTILS_NS_TO_MS(3'500'000), 3);
  EXPECT_EQ(RCUTILS_S_TO_NS(0.5), 5e8);
  EXPECT_EQ(RCUTILS_NS_TO_S(5e8), 0.5);
  EXPECT_NEAR(tf2Radians(180), M_PI, 1e-15);
  EXPECT_EQ(tf2Acos(1 + 1e-12), 0);
}

/// Code of Humble gets these macros by way of other headers.
class HARDWARE_INTERFACE_PUBLIC OfHumble : public hardware_interface::StateInterface {
 public:
  using StateInterface::StateInterface;
};

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

TEST(Parameters, BecomeMessagesAndComeBack) {
  using rclcpp::Parameter;
  for (const Parameter& p : {Parameter("a", true), Parameter("b", 3), Parameter("c", 1.5),
                             Parameter("d", "text"), Parameter("e", std::vector<double>{1, 2}),
                             Parameter("f", std::vector<std::string>{"x"}), Parameter("g")}) {
    const auto message = p.to_parameter_msg();
    EXPECT_EQ(message.value.type, static_cast<std::uint8_t>(p.get_type()));
    EXPECT_EQ(Parameter::from_parameter_msg(message), p) << p.get_name();
  }
  rcl_interfaces::msg::Parameter wrong;
  wrong.value.type = 99;
  EXPECT_THROW(Parameter::from_parameter_msg(wrong), std::runtime_error);
}

TEST(Messages, HaveTheirFieldsOfHumbleUnderBothNames) {
  control_msgs::msg::JointTrajectoryControllerState state;
  state.desired.positions = {1, 2};
  state.actual.positions = {3, 4};
  EXPECT_EQ(state.reference.positions, (std::vector<double>{1, 2}));
  auto copy = state;
  copy.feedback.positions = {5};
  EXPECT_EQ(copy.actual.positions, std::vector<double>{5});
  EXPECT_EQ(state.actual.positions, (std::vector<double>{3, 4}));
  state = std::move(copy);
  EXPECT_EQ(state.actual.positions, std::vector<double>{5});
  EXPECT_EQ(state.desired.positions, (std::vector<double>{1, 2}));
}

TEST(QualityOfService, KeepsWhatIsSetOnIt) {
  const auto qos = rclcpp::QoS(rclcpp::KeepAll())
                       .transient_local()
                       .best_effort()
                       .liveliness(rclcpp::LivelinessPolicy::ManualByTopic)
                       .liveliness_lease_duration(rclcpp::Duration(std::chrono::milliseconds(1500)));
  EXPECT_EQ(qos.history(), rclcpp::HistoryPolicy::KeepAll);
  EXPECT_EQ(qos.durability(), rclcpp::DurabilityPolicy::TransientLocal);
  EXPECT_EQ(qos.reliability(), rclcpp::ReliabilityPolicy::BestEffort);
  EXPECT_EQ(qos.liveliness(), rclcpp::LivelinessPolicy::ManualByTopic);
  EXPECT_EQ(qos.get_rmw_qos_profile().liveliness_lease_duration.nsec, 500'000'000u);
  EXPECT_EQ(rclcpp::SensorDataQoS().history(), rclcpp::HistoryPolicy::KeepLast);
  const rmw_qos_profile_t profile = {RMW_QOS_POLICY_HISTORY_KEEP_LAST,
                                     3,
                                     RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT,
                                     RMW_QOS_POLICY_DURABILITY_VOLATILE,
                                     RMW_QOS_DEADLINE_DEFAULT,
                                     RMW_QOS_LIFESPAN_DEFAULT,
                                     RMW_QOS_POLICY_LIVELINESS_SYSTEM_DEFAULT,
                                     RMW_QOS_LIVELINESS_LEASE_DURATION_DEFAULT,
                                     false};
  const rclcpp::QoS written(rclcpp::QoSInitialization::from_rmw(profile), profile);
  EXPECT_EQ(written, rclcpp::QoS(3).best_effort());
  EXPECT_NE(written, rclcpp::QoS(3));
}

TEST(Node, KeepsAllMessagesOfATopicThatIsToKeepThemAndCountsItsPublishers) {
  const auto node = std::make_shared<rclcpp::Node>("n");
  int heard = 0;
  const auto subscription = node->create_subscription<std_msgs::msg::String>(
      "many", rclcpp::QoS(rclcpp::KeepAll()), [&](const std_msgs::msg::String&) { ++heard; });
  const auto speaker = node->create_publisher<std_msgs::msg::String>("many", 1);
  for (int i = 0; i < 40; ++i) speaker->publish(std_msgs::msg::String());
  rclcpp::spin_some(node);
  EXPECT_EQ(heard, 40);
  const auto publishers = node->get_publishers_info_by_topic("many");
  ASSERT_EQ(publishers.size(), 1u);
  EXPECT_EQ(publishers[0].endpoint_type(), rclcpp::EndpointType::Publisher);
  EXPECT_TRUE(node->get_publishers_info_by_topic("none").empty());
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
