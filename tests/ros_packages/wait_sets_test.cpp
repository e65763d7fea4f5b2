/// Wait sets: what makes them ready, and what the caller takes by itself.
#include <gtest/gtest.h>

#include <thread>

#include "polyarm/hardware/node_graph.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp/wait_set.hpp"
#include "std_msgs/msg/string.hpp"
#include "std_srvs/srv/set_bool.hpp"

namespace {

using namespace std::chrono_literals;
using std_srvs::srv::SetBool;

TEST(WaitSets, AreReadyWithAMessageOrATimerAndTakeNothing) {
  const auto node = std::make_shared<rclcpp::Node>("waiting");
  int heard = 0;
  const auto subscription = node->create_subscription<std_msgs::msg::String>(
      "word", 10, [&](const std_msgs::msg::String&) { ++heard; });
  const auto publisher = node->create_publisher<std_msgs::msg::String>("word", 10);
  rclcpp::WaitSet set;
  EXPECT_EQ(set.wait().kind(), rclcpp::WaitResultKind::Empty);
  set.add_subscription(subscription);
  EXPECT_THROW(set.add_subscription(subscription), std::runtime_error);
  EXPECT_EQ(set.wait(std::chrono::milliseconds(1)).kind(), rclcpp::WaitResultKind::Timeout);
  std::thread sender([&] { publisher->publish(std_msgs::msg::String()); });
  EXPECT_EQ(set.wait(std::chrono::seconds(60)).kind(), rclcpp::WaitResultKind::Ready);
  sender.join();
  EXPECT_EQ(set.wait(std::chrono::seconds(0)).kind(), rclcpp::WaitResultKind::Ready);
  rclcpp::spin_some(node);
  EXPECT_EQ(heard, 1);
  EXPECT_EQ(set.wait(std::chrono::seconds(0)).kind(), rclcpp::WaitResultKind::Timeout);
  set.remove_subscription(subscription);
  EXPECT_THROW(set.remove_subscription(subscription), std::runtime_error);
  EXPECT_EQ(set.wait(std::chrono::seconds(60)).kind(), rclcpp::WaitResultKind::Empty);
  set.add_timer(node->create_wall_timer(std::chrono::milliseconds(1), [] {}));
  EXPECT_EQ(set.wait(std::chrono::seconds(60)).kind(), rclcpp::WaitResultKind::Ready);
}

TEST(WaitSets, TakeTheTriggerOfAGuardCondition) {
  const auto condition = std::make_shared<rclcpp::GuardCondition>();
  rclcpp::WaitSet set({}, {condition});
  EXPECT_EQ(set.wait(1ms).kind(), rclcpp::WaitResultKind::Timeout);
  std::thread other([&] { condition->trigger(); });
  EXPECT_EQ(set.wait(60s).kind(), rclcpp::WaitResultKind::Ready);
  other.join();
  ASSERT_EQ(set.get_rcl_wait_set().size_of_guard_conditions, 1u);
  EXPECT_EQ(set.get_rcl_wait_set().guard_conditions[0], condition.get());
  EXPECT_EQ(set.wait(0s).kind(), rclcpp::WaitResultKind::Timeout);
  EXPECT_EQ(set.get_rcl_wait_set().guard_conditions[0], nullptr);
  std::size_t count = 0;
  condition->trigger();
  condition->trigger();
  condition->set_on_trigger_callback([&](std::size_t more) { count += more; });
  condition->trigger();
  EXPECT_EQ(count, 4u);  // one of them before the first wait
  set.remove_guard_condition(condition);
  EXPECT_EQ(set.wait().kind(), rclcpp::WaitResultKind::Empty);
}

TEST(WaitSets, AreReadyWithARequestAndWithItsResponse) {
  const auto node = std::make_shared<rclcpp::Node>("served_by_hand");
  const auto service = node->create_service<SetBool>(
      "switch", [](const SetBool::Request::SharedPtr asked, SetBool::Response::SharedPtr response) {
        response->success = asked->data;
      });
  const auto client = node->create_client<SetBool>("switch");
  rclcpp::StaticWaitSet<0, 0, 0, 1, 1, 0> set({}, {}, {}, {client}, {service});
  EXPECT_EQ(set.wait(1ms).kind(), rclcpp::WaitResultKind::Timeout);

  auto request = std::make_shared<SetBool::Request>();
  request->data = true;
  int called = 0;
  auto future = client->async_send_request(request, [&](rclcpp::Client<SetBool>::SharedFuture) { ++called; });
  auto asked = set.wait(0s);
  ASSERT_EQ(asked.kind(), rclcpp::WaitResultKind::Ready);
  EXPECT_EQ(asked.next_ready_client(), nullptr);
  const auto ready = asked.next_ready_service();
  ASSERT_EQ(ready, service);
  EXPECT_EQ(asked.next_ready_service(), nullptr);
  const auto header = ready->create_request_header();
  const auto taken = ready->create_request();
  ASSERT_TRUE(ready->take_type_erased_request(taken.get(), *header));
  EXPECT_FALSE(ready->take_type_erased_request(taken.get(), *header));
  ready->handle_request(header, taken);

  ASSERT_EQ(set.wait(0s).kind(), rclcpp::WaitResultKind::Ready);
  SetBool::Response response;
  ASSERT_TRUE(client->take_response(response, *header));
  EXPECT_TRUE(response.success);
  EXPECT_EQ(header->sequence_number, future.request_id);
  EXPECT_EQ(set.wait(0s).kind(), rclcpp::WaitResultKind::Timeout);
  EXPECT_EQ(called, 0);
  client->handle_response(header, std::make_shared<SetBool::Response>(response));
  EXPECT_EQ(called, 1);
  EXPECT_TRUE(future.get()->success);
}

TEST(WaitSets, SeeRequestsAndResponsesOfTheGraph) {
  const auto node = std::make_shared<rclcpp::Node>("by_hand_on_the_graph");
  const auto service = node->create_service<SetBool>(
      "~/switch", [](const SetBool::Request::SharedPtr, SetBool::Response::SharedPtr) {});
  const auto client = node->create_client<SetBool>("/elsewhere/switch");
  std::shared_ptr<polyarm::hardware::NodePort> asking, asked;
  for (const auto& each : polyarm::hardware::node_graph().ports()) {
    if (each->facts.name == "/by_hand_on_the_graph/switch") asked = each;
    if (each->facts.name == "/elsewhere/switch") asking = each;
  }
  ASSERT_TRUE(asking && asked);
  rclcpp::WaitSet set({}, {}, {}, {client}, {service});
  EXPECT_EQ(set.wait(0s).kind(), rclcpp::WaitResultKind::Timeout);

  SetBool::Request request;
  request.data = true;
  asked->from_graph.put(7, true, [&](polyarm_ros::Payload& out) { polyarm_ros::encode(request, out); });
  EXPECT_EQ(set.wait(0s).kind(), rclcpp::WaitResultKind::Ready);
  rmw_request_id_t header{};
  SetBool::Request taken;
  ASSERT_TRUE(service->take_request(taken, header));
  EXPECT_TRUE(taken.data);
  SetBool::Response response;
  response.message = "on";
  service->send_response(header, response);
  polyarm::hardware::Letter letter;
  ASSERT_TRUE(asked->to_graph.take(letter));
  EXPECT_EQ(letter.number, 7u);

  auto future = client->async_send_request(std::make_shared<SetBool::Request>());
  asking->from_graph.put(static_cast<std::uint64_t>(future.request_id), true,
                         [&](polyarm_ros::Payload& out) { polyarm_ros::encode(response, out); });
  EXPECT_EQ(set.wait(0s).kind(), rclcpp::WaitResultKind::Ready);
  EXPECT_EQ(future.wait_for(0s), std::future_status::timeout);
  rclcpp::spin_some(node);
  ASSERT_EQ(future.wait_for(0s), std::future_status::ready);
  EXPECT_EQ(future.get()->message, "on");
}

TEST(WaitSets, MessagesAndTimersAreTakenByTheCaller) {
  const auto node = std::make_shared<rclcpp::Node>("taking_by_hand");
  std::string heard;
  const auto subscription = node->create_subscription<std_msgs::msg::String>(
      "taken", 10, [&](const std_msgs::msg::String& m) { heard = m.data; });
  const auto generic = node->create_generic_subscription(
      "taken", "std_msgs/msg/String", 10, [&](const rclcpp::SerializedMessage&) { heard += "!"; });
  int ticks = 0;
  const auto timer = node->create_wall_timer(0s, [&] { ++ticks; });
  rclcpp::WaitSet set({{subscription}, {generic}}, {}, {timer});
  std_msgs::msg::String word;
  word.data = "go";
  node->create_publisher<std_msgs::msg::String>("taken", 10)->publish(word);
  auto result = set.wait(60s);
  ASSERT_EQ(result.kind(), rclcpp::WaitResultKind::Ready);
  EXPECT_EQ(result.get_wait_set().get_rcl_wait_set().size_of_subscriptions, 2u);
  int taken = 0;
  for (auto ready = result.next_ready_subscription(); ready; ready = result.next_ready_subscription()) {
    std::shared_ptr<void> message = ready->create_message();
    rclcpp::MessageInfo info;
    ASSERT_TRUE(ready->take_type_erased(message.get(), info));
    ready->handle_message(message, info);
    ++taken;
  }
  EXPECT_EQ(taken, 2);
  EXPECT_EQ(heard, "go!");
  const auto due = result.next_ready_timer();
  ASSERT_EQ(due, timer);
  EXPECT_TRUE(due->call());
  due->execute_callback();
  EXPECT_EQ(ticks, 1);
  timer->cancel();
  EXPECT_FALSE(timer->call());
}

}  // namespace
