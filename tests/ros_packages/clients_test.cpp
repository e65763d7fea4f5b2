/// Clients of services, in the module and on the graph; and what a controller's node knows of the robot.
#include <gtest/gtest.h>

#include "polyarm/hardware/node_graph.hpp"
#include "rclcpp/rclcpp.hpp"
#include "std_msgs/msg/string.hpp"
#include "std_srvs/srv/set_bool.hpp"

namespace {

using namespace std::chrono_literals;
using polyarm::hardware::Letter;
using polyarm_ros::Payload;
using std_srvs::srv::SetBool;

std::shared_ptr<SetBool::Request> request(bool data) {
  auto out = std::make_shared<SetBool::Request>();
  out->data = data;
  return out;
}

TEST(ServiceClients, ReachAServiceOfTheSameModule) {
  const auto node = std::make_shared<rclcpp::Node>("client");
  const auto client = node->create_client<SetBool>("/driver/switch");
  EXPECT_FALSE(client->wait_for_service(1ms));
  const auto driver = std::make_shared<rclcpp::Node>("driver");
  const auto service = driver->create_service<SetBool>(
      "~/switch", [](const std::shared_ptr<SetBool::Request> asked,
                     std::shared_ptr<SetBool::Response> response) { response->success = asked->data; });
  ASSERT_TRUE(client->wait_for_service(60s));
  auto answer = client->async_send_request(request(true));
  EXPECT_EQ(answer.wait_for(0s), std::future_status::timeout);  // the driver's executor has not run
  ASSERT_EQ(rclcpp::spin_until_future_complete(driver, answer, 60s), rclcpp::FutureReturnCode::SUCCESS);
  EXPECT_TRUE(answer.get()->success);

  int called = 0;
  auto shared = client->async_send_request(request(false), [&](rclcpp::Client<SetBool>::SharedFuture future) {
    ++called;
    EXPECT_FALSE(future.get()->success);
  });
  client->async_send_request(request(true), [&](rclcpp::Client<SetBool>::SharedFutureWithRequest both) {
    ++called;
    EXPECT_TRUE(both.get().first->data && both.get().second->success);
  });
  rclcpp::Client<SetBool>::SharedFuture plain = client->async_send_request(request(true));
  auto removed = client->async_send_request(request(true));
  EXPECT_TRUE(client->remove_pending_request(removed));
  EXPECT_FALSE(client->remove_pending_request(removed));
  rclcpp::spin_some(driver);
  EXPECT_EQ(called, 0);  // callbacks run on the client's executor
  rclcpp::spin_some(node);
  EXPECT_EQ(called, 2);
  EXPECT_TRUE(plain.get()->success);
  EXPECT_FALSE(shared.future.get()->success);
}

TEST(ServiceClients, WaitForAServiceThatAnswersLater) {
  const auto node = std::make_shared<rclcpp::Node>("both");
  std::shared_ptr<rmw_request_id_t> open;
  const auto service =
      node->create_service<SetBool>("slow", [&](const std::shared_ptr<rmw_request_id_t> header,
                                                const std::shared_ptr<SetBool::Request>) { open = header; });
  const auto client = node->create_client<SetBool>("slow");
  auto answer = client->async_send_request(request(true));
  rclcpp::spin_some(node);
  ASSERT_TRUE(open);
  EXPECT_EQ(answer.wait_for(0s), std::future_status::timeout);
  SetBool::Response response;
  response.message = "done";
  service->send_response(*open, response);
  ASSERT_EQ(answer.wait_for(0s), std::future_status::ready);
  EXPECT_EQ(answer.get()->message, "done");
}

TEST(ServiceClients, CallServicesOfTheGraphByTheirPort) {
  const auto node = std::make_shared<rclcpp::Node>("caller");
  const auto client = node->create_client<SetBool>("/light");
  std::shared_ptr<polyarm::hardware::NodePort> port;
  for (const auto& each : polyarm::hardware::node_graph().ports())
    if (each->facts.name == "/light") port = each;
  ASSERT_TRUE(port);
  EXPECT_EQ(port->facts.kind, polyarm::hardware::PortKind::client);
  EXPECT_EQ(port->facts.type, "std_srvs/srv/SetBool");
  EXPECT_FALSE(client->service_is_ready());
  port->peers = 1;
  EXPECT_TRUE(client->service_is_ready());

  auto first = client->async_send_request(request(true)), second = client->async_send_request(request(false));
  Letter one, two;
  ASSERT_TRUE(port->to_graph.take(one) && port->to_graph.take(two));
  SetBool::Request asked;
  ASSERT_TRUE(polyarm_ros::decode(one.payload, asked));
  EXPECT_TRUE(asked.data);
  SetBool::Response response;
  response.message = "second";
  port->from_graph.put(two.number, true, [&](Payload& out) { polyarm_ros::encode(response, out); });
  rclcpp::spin_some(node);
  EXPECT_EQ(first.wait_for(0s), std::future_status::timeout);
  EXPECT_EQ(second.get()->message, "second");
}

TEST(ServiceClients, DoNotHangTheThreadThatServesTheGraph) {
  const auto node = std::make_shared<rclcpp::Node>("caller");
  const auto client = node->create_client<SetBool>("/nobody");
  auto answer = client->async_send_request(request(true));
  const polyarm_ros::ServesGraph mark;
  EXPECT_EQ(rclcpp::spin_until_future_complete(node, answer), rclcpp::FutureReturnCode::TIMEOUT);
}

TEST(ServiceClients, ForgetTheOldestOfTooManyRequests) {
  const auto node = std::make_shared<rclcpp::Node>("caller");
  const auto client = node->create_client<SetBool>("/nobody");
  for (int i = 0; i < 1000; ++i) client->async_send_request(request(true));
  EXPECT_EQ(client->prune_pending_requests(), rclcpp::Client<SetBool>::kMost);
}

TEST(ServiceClients, DoNotWaitOnTheThreadThatServesTheGraph) {
  const auto node = std::make_shared<rclcpp::Node>("caller");
  const auto client = node->create_client<SetBool>("/nobody");
  const polyarm_ros::ServesGraph mark;
  EXPECT_FALSE(client->wait_for_service());  // elsewhere it would wait for ever
  { const polyarm_ros::ServesGraph inner; }
  EXPECT_FALSE(client->wait_for_service());
}

TEST(RobotDescription, IsGivenToControllersThatAskOtherNodes) {
  const auto node = std::make_shared<rclcpp::Node>("controller");
  node->get_node_base_interface()->polyarm_robot_description = "<robot/>";
  std::string heard;
  const auto subscription = node->create_subscription<std_msgs::msg::String>(
      "/robot_description", rclcpp::QoS(1).transient_local(),
      [&](const std::shared_ptr<std_msgs::msg::String> message) { heard = message->data; });
  rclcpp::spin_some(node);
  EXPECT_EQ(heard, "<robot/>");

  rclcpp::AsyncParametersClient publisher(node, "/robot_state_publisher");
  ASSERT_TRUE(publisher.wait_for_service(60s));
  const auto all = publisher.get_parameters({"robot_description", "other"}).get();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all.front().value_to_string(), "<robot/>");
  rclcpp::SyncParametersClient other(node, "/another_node");
  EXPECT_FALSE(other.service_is_ready());
  EXPECT_EQ(other.get_parameter<std::string>("robot_description", "none"), "none");
}

}  // namespace
