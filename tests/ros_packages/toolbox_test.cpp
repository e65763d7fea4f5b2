/// Filters, limits and parameters that plugins use by their names in ROS.
#include <gtest/gtest.h>

#include <cmath>

#include "filters/filter_chain.hpp"
#include "hardware_interface/helpers.hpp"
#include "joint_limits/joint_limits_rosparam.hpp"
#include "rclcpp/parameter_event_handler.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp/serialization.hpp"
#include "rclcpp/wait_for_message.hpp"
#include "sensor_msgs/image_encodings.hpp"
#include "std_msgs/msg/string.hpp"

namespace {

using rclcpp::Parameter;

std::shared_ptr<rclcpp::Node> node_with(std::vector<Parameter> given) {
  rclcpp::NodeOptions options;
  options.parameter_overrides(std::move(given));
  return std::make_shared<rclcpp::Node>("n", options);
}

TEST(LowPassFilter, FollowsItsFormula) {
  control_toolbox::LowPassFilter<double> filter(1000, 20, 5);
  double out = 0;
  EXPECT_THROW(filter.update(1, out), std::runtime_error);
  ASSERT_TRUE(filter.configure());
  EXPECT_FALSE(filter.update(std::nan(""), out));
  const double a = std::exp(-2 * M_PI * 20 / (1000 * std::pow(10.0, -0.5)));
  double expected = 1, before = 1;
  for (const double in : {1.0, 2.0, 2.0, -1.0, 4.0}) {
    expected = (1 - a) * before + a * expected;
    before = in;
    ASSERT_TRUE(filter.update(in, out));
    EXPECT_NEAR(out, expected, 1e-12);
  }
}

TEST(ExponentialFilter, LeavesOutWhatIsNotFinite) {
  control_toolbox::ExponentialFilter<double> filter(0.25);
  double out = 0;
  ASSERT_TRUE(filter.configure());
  EXPECT_FALSE(filter.update(std::nan(""), out));
  ASSERT_TRUE(filter.update(1, out));
  EXPECT_EQ(out, 1);
  ASSERT_TRUE(filter.update(std::nan(""), out));
  EXPECT_EQ(out, 1);
  ASSERT_TRUE(filter.update(5, out));
  EXPECT_EQ(out, 2);
}

TEST(FilterChain, HasTheFiltersOfControlToolbox) {
  const auto node = node_with({Parameter("filter1.name", "low"),
                               Parameter("filter1.type", "control_filters/LowPassFilterVectorDouble"),
                               Parameter("filter1.params.sampling_frequency", 100.0),
                               Parameter("filter1.params.damping_frequency", 1.0),
                               Parameter("filter1.params.damping_intensity", 1.0)});
  filters::FilterChain<std::vector<double>> chain("std::vector<double>");
  ASSERT_TRUE(chain.configure("", node->get_node_logging_interface(), node->get_node_parameters_interface()));
  ASSERT_EQ(chain.get_length(), 1u);
  std::vector<double> out;
  ASSERT_TRUE(chain.update({1, 2}, out));
  EXPECT_EQ(out, (std::vector<double>{1, 2}));
  ASSERT_TRUE(chain.update({5, 2}, out));
  ASSERT_TRUE(chain.update({5, 2}, out));
  EXPECT_GT(out[0], 1);
  EXPECT_LT(out[0], 5);
  EXPECT_NEAR(out[1], 2, 1e-12);
  EXPECT_THROW(chain.update({1}, out), std::runtime_error);
}

TEST(JointLimits, ComeFromTheParametersOfTheNode) {
  const auto node = node_with({Parameter("joint_limits.j1.has_velocity_limits", true),
                               Parameter("joint_limits.j1.max_velocity", 2),
                               Parameter("joint_limits.j1.has_position_limits", true),
                               Parameter("joint_limits.j1.min_position", -1.0)});
  joint_limits::JointLimits limits;
  EXPECT_FALSE(joint_limits::get_joint_limits("j1", node, limits));  // none is declared yet
  ASSERT_TRUE(joint_limits::declare_parameters("j1", node));
  ASSERT_TRUE(joint_limits::get_joint_limits("j1", node, limits));
  EXPECT_TRUE(limits.has_velocity_limits);
  EXPECT_EQ(limits.max_velocity, 2);
  EXPECT_FALSE(limits.has_position_limits);  // no maximum
  EXPECT_FALSE(limits.has_jerk_limits);
}

TEST(Parameters, AreListedDescribedAndPrinted) {
  const auto node = node_with({});
  rcl_interfaces::msg::ParameterDescriptor about;
  about.description = "gain";
  node->declare_parameter("pid.p", 2.5, about);
  node->declare_parameter("joints", std::vector<std::string>{"a", "b"});
  EXPECT_EQ(node->list_parameters({}, 1).names, (std::vector<std::string>{"joints"}));
  EXPECT_EQ(node->list_parameters({"pid"}, 0).names, (std::vector<std::string>{"pid.p"}));
  EXPECT_EQ(node->list_parameters({}, 0).prefixes, (std::vector<std::string>{"pid"}));
  const auto described = node->describe_parameter("pid.p");
  EXPECT_EQ(described.description, "gain");
  EXPECT_EQ(described.type, rcl_interfaces::msg::ParameterType::PARAMETER_DOUBLE);
  EXPECT_THROW(node->describe_parameter("none"), rclcpp::exceptions::ParameterNotDeclaredException);
  EXPECT_EQ(node->get_parameter("pid.p").value_to_string(), "2.500000");
  EXPECT_EQ(node->get_parameter("joints").value_to_string(), "[\"a\", \"b\"]");
  EXPECT_EQ(node->declare_parameters<double>("more", {{"x", 1.0}, {"y", 2.0}}), (std::vector<double>{1, 2}));
}

TEST(ParameterEvents, ReachThoseWhoWatchTheParameter) {
  const auto node = node_with({});
  node->declare_parameter("speed", 1.0);
  rclcpp::ParameterEventHandler events(node);
  double seen = 0;
  auto watch = events.add_parameter_callback("speed", [&](const Parameter& p) { seen = p.as_double(); });
  node->set_parameter(Parameter("speed", 3.0));
  EXPECT_EQ(seen, 3);
  watch.reset();
  node->set_parameter(Parameter("speed", 4.0));
  EXPECT_EQ(seen, 3);
}

TEST(SerializedMessages, ComeBackAsTheyWere) {
  std_msgs::msg::String message, back;
  message.data = "abc";
  rclcpp::SerializedMessage payload;
  const rclcpp::Serialization<std_msgs::msg::String> serialization;
  serialization.serialize_message(&message, &payload);
  EXPECT_EQ(payload.size(), 12u);
  serialization.deserialize_message(&payload, &back);
  EXPECT_EQ(back.data, "abc");
  payload.polyarm_payload().resize(6);
  EXPECT_THROW(serialization.deserialize_message(&payload, &back), std::runtime_error);
}

TEST(WaitForMessage, GetsTheNextOneOfTheTopic) {
  const auto node = std::make_shared<rclcpp::Node>("waiting");
  const auto heard = node->create_subscription<std_msgs::msg::String>(
      "/words", 10, [](const std::shared_ptr<std_msgs::msg::String>&) {});
  const auto publisher = node->create_publisher<std_msgs::msg::String>("/words", 10);
  std_msgs::msg::String message, got;
  EXPECT_FALSE(rclcpp::wait_for_message(got, heard, nullptr, std::chrono::milliseconds(1)));
  {
    const polyarm_ros::ServesGraph mark;
    EXPECT_FALSE(rclcpp::wait_for_message(got, heard, nullptr));  // elsewhere it would wait for ever
  }
  message.data = "now";
  publisher->publish(message);
  ASSERT_TRUE(rclcpp::wait_for_message(got, heard, nullptr, std::chrono::seconds(60)));
  EXPECT_EQ(got.data, "now");
}

TEST(SmallHelpers, AnswerAsInRos) {
  std::vector<std::string> names = {"a"};
  ros2_control::add_item(names, std::string("a"));
  ros2_control::add_item(names, std::string("b"));
  EXPECT_EQ(names.size(), 2u);
  EXPECT_TRUE(ros2_control::has_item(std::map<std::string, int>{{"k", 1}}, std::string("k")));
  EXPECT_EQ(ros2_control::strip("  x y\n"), "x y");
  EXPECT_EQ(sensor_msgs::image_encodings::numChannels("bgr8"), 3);
  EXPECT_EQ(sensor_msgs::image_encodings::bitDepth("16UC1"), 16);
  EXPECT_EQ(sensor_msgs::image_encodings::numChannels("32FC3"), 3);
}

}  // namespace
