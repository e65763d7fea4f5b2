/// Topics and services of a node of a plugin, as the ROS 2 door sees them.
#include <gtest/gtest.h>

#include <random>

#include "geometry_msgs/msg/transform_stamped.hpp"
#include "polyarm/hardware/node_graph.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp/serialization.hpp"
#include "sensor_msgs/msg/joint_state.hpp"
#include "std_msgs/msg/string.hpp"
#include "std_srvs/srv/set_bool.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tf2_msgs/msg/tf_message.hpp"
#include "tf2_ros/static_transform_broadcaster.hpp"
#include "tf2_ros/transform_broadcaster.hpp"

namespace {

using polyarm::hardware::Letter;
using polyarm::hardware::LetterQueue;
using polyarm::hardware::NodePort;
using polyarm_ros::Payload;

std::shared_ptr<NodePort> port_of(const std::string& name) {
  for (const auto& port : polyarm::hardware::node_graph().ports())
    if (port->facts.name == name) return port;
  return nullptr;
}
template <typename Message>
void put(LetterQueue& queue, const Message& message, std::uint64_t number = 0) {
  queue.put(number, true, [&](Payload& out) { polyarm_ros::encode(message, out); });
}

TEST(Payloads, AreThoseOfRos2) {
  std_msgs::msg::String text;
  text.data = "abc";
  Payload out;
  polyarm_ros::encode(text, out);
  EXPECT_EQ(out, (Payload{0, 1, 0, 0, 4, 0, 0, 0, 'a', 'b', 'c', 0}));

  sensor_msgs::msg::JointState state;
  state.header.stamp.sec = 3;
  state.name = {"a", "bc"};
  state.position = {1.5, -2};
  out.clear();
  polyarm_ros::encode(state, out);
  sensor_msgs::msg::JointState back;
  ASSERT_TRUE(polyarm_ros::decode(out, back));
  EXPECT_EQ(back, state);
  EXPECT_EQ((out.size() - 4 - 2 * sizeof(double) - 8) % 8, 0u);  // doubles stand at multiples of 8

  std_srvs::srv::SetBool::Request request;
  out.clear();
  polyarm_ros::encode(request, out);
  EXPECT_EQ(out.size(), 5u);
  EXPECT_TRUE(polyarm_ros::decode(Payload{0, 0, 0, 0, 1}, request));  // of the other byte order
  EXPECT_TRUE(request.data);
  EXPECT_FALSE(polyarm_ros::decode(Payload{0, 1, 0, 0, 2}, request));
  EXPECT_FALSE(polyarm_ros::decode(Payload{0, 1, 0, 0}, request));
}

TEST(Payloads, ThatAreBrokenAreRefused) {
  sensor_msgs::msg::JointState state;
  state.name.assign(20, "joint");
  state.position.assign(20, 0.5);
  Payload whole;
  polyarm_ros::encode(state, whole);
  std::mt19937 random(7);
  for (int i = 0; i < 20000; ++i) {
    Payload broken = whole;
    if (i % 2) broken.resize(random() % whole.size());
    for (int changes = 0; changes < 3 && !broken.empty(); ++changes)
      broken[random() % broken.size()] = static_cast<std::uint8_t>(random());
    sensor_msgs::msg::JointState out;
    polyarm_ros::decode(broken, out);  // does not crash, and allocates no more than the payload could fill
    EXPECT_LE(out.position.size(), whole.size());
  }
}

TEST(NodePorts, SayWhatANodeOffersAndCloseWithIt) {
  {
    const auto node = std::make_shared<rclcpp::Node>("driver", "/arm");
    const auto publisher = node->create_publisher<std_msgs::msg::String>("~/state", rclcpp::SensorDataQoS());
    const auto absolute =
        node->create_publisher<std_msgs::msg::String>("/alarm", rclcpp::QoS(3).transient_local());
    const auto state = port_of("/arm/driver/state"), alarm = port_of("/alarm");
    ASSERT_TRUE(state && alarm);
    EXPECT_EQ(state->facts.type, "std_msgs/msg/String");
    EXPECT_EQ(state->facts.node, "/arm/driver");
    EXPECT_FALSE(state->facts.reliable || state->facts.absolute || state->facts.transient_local);
    EXPECT_EQ(state->facts.depth, 5u);
    EXPECT_TRUE(alarm->facts.reliable && alarm->facts.absolute && alarm->facts.transient_local);
    EXPECT_EQ(alarm->facts.depth, 3u);

    Letter letter;
    publisher->publish(std_msgs::msg::String());  // nobody wants it
    EXPECT_FALSE(state->to_graph.take(letter));
    state->peers = 1;
    EXPECT_EQ(publisher->get_subscription_count(), 1u);
    for (int i = 0; i < 9; ++i) {
      std_msgs::msg::String message;
      message.data = std::to_string(i);
      publisher->publish(message);
    }
    std_msgs::msg::String first;
    ASSERT_TRUE(state->to_graph.take(letter) && polyarm_ros::decode(letter.payload, first));
    EXPECT_EQ(first.data, "4");  // the five latest are kept
    absolute->publish(std_msgs::msg::String());
    EXPECT_TRUE(alarm->to_graph.take(letter));  // for those who come later
  }
  EXPECT_EQ(port_of("/arm/driver/state"), nullptr);
}

TEST(NodePorts, OfACellThatIsOnlyTriedStayOffTheGraph) {
  const auto node = std::make_shared<rclcpp::Node>("tried");
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr publisher;
  {
    const polyarm::hardware::OffGraph off_graph;
    publisher = node->create_publisher<std_msgs::msg::String>("~/state", 1);
  }
  EXPECT_EQ(port_of("/tried/state"), nullptr);
  publisher->publish(std_msgs::msg::String());
  EXPECT_EQ(publisher->get_subscription_count(), 0u);
  const auto running = node->create_publisher<std_msgs::msg::String>("~/state", 1);
  EXPECT_NE(port_of("/tried/state"), nullptr);
}

TEST(NodePorts, BringMessagesAndRequestsToTheCallbacks) {
  const auto node = std::make_shared<rclcpp::Node>("driver");
  std::vector<std::string> heard;
  const auto subscription = node->create_subscription<std_msgs::msg::String>(
      "words", 10, [&](const std_msgs::msg::String& message) { heard.push_back(message.data); });
  using SetBool = std_srvs::srv::SetBool;
  const auto service = node->create_service<SetBool>(
      "switch", [](const std::shared_ptr<rmw_request_id_t>, const std::shared_ptr<SetBool::Request> request,
                   std::shared_ptr<SetBool::Response> response) { response->success = request->data; });
  std::shared_ptr<rmw_request_id_t> open;
  const auto later =
      node->create_service<SetBool>("later", [&](const std::shared_ptr<rmw_request_id_t> header,
                                                 const std::shared_ptr<SetBool::Request>) { open = header; });
  const auto words = port_of("/words"), call = port_of("/switch"), slow = port_of("/later");
  ASSERT_TRUE(words && call && slow);
  EXPECT_EQ(call->facts.type, "std_srvs/srv/SetBool");

  std_msgs::msg::String word;
  word.data = "go";
  put(words->from_graph, word);
  words->from_graph.put(0, true, [](Payload& out) { out = {1, 2, 3}; });  // no message: dropped
  put(words->from_graph, word);
  SetBool::Request on;
  on.data = true;
  put(call->from_graph, on, 41);
  put(slow->from_graph, on, 42);
  rclcpp::spin_some(node);
  EXPECT_EQ(heard, (std::vector<std::string>{"go", "go"}));

  Letter letter;
  SetBool::Response response;
  ASSERT_TRUE(call->to_graph.take(letter) && polyarm_ros::decode(letter.payload, response));
  EXPECT_EQ(letter.number, 41u);
  EXPECT_TRUE(response.success);
  EXPECT_FALSE(slow->to_graph.take(letter));
  ASSERT_TRUE(open);
  later->send_response(*open, response);
  ASSERT_TRUE(slow->to_graph.take(letter));
  EXPECT_EQ(letter.number, 42u);
}

TEST(GenericTopics, CarryPayloadsOfATypeThatIsOnlyNamed) {
  const std::string type = "std_msgs/msg/String";
  const auto node = std::make_shared<rclcpp::Node>("driver");
  std::vector<std::string> heard;
  std::vector<Payload> raw;
  const auto typed = node->create_subscription<std_msgs::msg::String>(
      "raw_words", 10, [&](const std_msgs::msg::String& message) { heard.push_back(message.data); });
  const auto bytes = node->create_generic_subscription(
      "raw_words", type, 10,
      [&](std::shared_ptr<rclcpp::SerializedMessage> m) { raw.push_back(m->polyarm_payload()); });
  const auto other = node->create_generic_subscription(
      "raw_words", "std_msgs/msg/Bool", 10,
      [&](std::shared_ptr<rclcpp::SerializedMessage>) { FAIL() << "it is of another type"; });
  const auto speaker = node->create_publisher<std_msgs::msg::String>("raw_words", 10);
  const auto generic = node->create_generic_publisher("raw_words", type, 10);

  std_msgs::msg::String word;
  word.data = "go";
  rclcpp::SerializedMessage message;
  rclcpp::Serialization<std_msgs::msg::String>().serialize_message(&word, &message);
  speaker->publish(word);
  generic->publish(message);
  rclcpp::spin_some(node);
  EXPECT_EQ(heard, (std::vector<std::string>{"go", "go"}));
  EXPECT_EQ(raw, (std::vector<Payload>{message.polyarm_payload(), message.polyarm_payload()}));

  std::shared_ptr<NodePort> out, in;
  for (const auto& port : polyarm::hardware::node_graph().ports())
    if (port->facts.name == "/raw_words" && port->facts.type == type)
      (port->facts.kind == polyarm::hardware::PortKind::publisher ? out : in) = port;
  ASSERT_TRUE(out && in);  // the last ones: those without a C++ type
  out->peers = 1;
  generic->publish(message);
  Letter letter;
  ASSERT_TRUE(out->to_graph.take(letter));
  EXPECT_EQ(letter.payload, message.polyarm_payload());
  rclcpp::spin_some(node);
  raw.clear();
  put(in->from_graph, word);
  rclcpp::spin_some(node);
  EXPECT_EQ(raw, (std::vector<Payload>{message.polyarm_payload()}));
}

TEST(NodePorts, CarryTransforms) {
  const auto node = std::make_shared<rclcpp::Node>("odometry");
  tf2_ros::TransformBroadcaster moving(node);
  tf2_ros::StaticTransformBroadcaster fixed(*node);
  tf2_ros::TransformBroadcaster of_a_view(node->get_node_topics_interface());
  const auto tf = port_of("/tf"), tf_static = port_of("/tf_static");
  ASSERT_TRUE(tf && tf_static);
  tf->peers = 1;
  geometry_msgs::msg::TransformStamped transform;
  transform.child_frame_id = "base_link";
  moving.sendTransform(transform);
  of_a_view.sendTransform(transform);
  fixed.sendTransform(transform);
  transform.child_frame_id = "camera";
  fixed.sendTransform({transform, transform});

  Letter letter;
  tf2_msgs::msg::TFMessage message;
  ASSERT_TRUE(tf->to_graph.take(letter) && polyarm_ros::decode(letter.payload, message));
  EXPECT_EQ(message.transforms.size(), 1u);
  EXPECT_FALSE(tf->to_graph.take(letter));
  ASSERT_TRUE(tf_static->to_graph.take(letter) && polyarm_ros::decode(letter.payload, message));
  ASSERT_EQ(message.transforms.size(), 2u);  // the latest message has all
  EXPECT_EQ(message.transforms[1].child_frame_id, "camera");
}

TEST(NodePorts, TakeMessagesInACycleWithoutAllocatingOrWaiting) {
  if (!polyarm::test::RealtimeGuard::watches()) GTEST_SKIP() << "a sanitizer watches the allocations";
  const auto node = std::make_shared<rclcpp::Node>("fast");
  const auto publisher = node->create_publisher<sensor_msgs::msg::JointState>("joints", 10);
  const auto port = port_of("/joints");
  ASSERT_TRUE(port);
  port->peers = 1;
  sensor_msgs::msg::JointState message;
  message.name.assign(6, "joint");
  message.position.assign(6, 0.5);
  for (int i = 0; i < 20; ++i) publisher->publish(message);
  std::string violations;
  polyarm_ros::in_cycle() = true;
  {
    const polyarm::test::RealtimeGuard guard;
    for (int i = 0; i < 1000; ++i) publisher->publish(message);
    violations = guard.violations();
  }
  polyarm_ros::in_cycle() = false;
  EXPECT_EQ(violations, "");
}

}  // namespace
