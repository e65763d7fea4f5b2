/// Packages beside the control framework that plugins use: message_filters, interactive_markers,
/// pal_statistics, realtime_tools' thread, rcpputils.
#include <gtest/gtest.h>

#include <thread>

#include "interactive_markers/menu_handler.hpp"
#include "message_filters/cache.hpp"
#include "message_filters/pass_through.hpp"
#include "message_filters/subscriber.hpp"
#include "message_filters/sync_policies/approximate_time.hpp"
#include "message_filters/time_synchronizer.hpp"
#include "pal_statistics/pal_statistics_macros.hpp"
#include "rcpputils/filesystem_helper.hpp"
#include "rcpputils/find_and_replace.hpp"
#include "rcpputils/pointer_traits.hpp"
#include "rcpputils/time.hpp"
#include "realtime_tools/async_function_handler.hpp"
#include "sensor_msgs/msg/imu.hpp"
#include "sensor_msgs/msg/joint_state.hpp"
#include "tests/support/realtime_guard.hpp"

namespace {

using sensor_msgs::msg::Imu;
using sensor_msgs::msg::JointState;
using ImuPtr = std::shared_ptr<const Imu>;
using StatePtr = std::shared_ptr<const JointState>;

template <typename M>
std::shared_ptr<M> at_ms(int ms) {
  auto out = std::make_shared<M>();
  out->header.stamp = rclcpp::Time(std::int64_t{ms} * 1000000);
  return out;
}
template <typename M>
int ms_of(const std::shared_ptr<const M>& message) {
  return static_cast<int>(rclcpp::Time(message->header.stamp).nanoseconds() / 1000000);
}

struct Pairs {
  std::vector<std::pair<int, int>> all;
  void take(const ImuPtr& a, const StatePtr& b) { all.emplace_back(ms_of(a), ms_of(b)); }
};

TEST(MessageFilters, JoinMessagesOfOneStamp) {
  message_filters::PassThrough<Imu> first;
  message_filters::PassThrough<JointState> second;
  message_filters::TimeSynchronizer<Imu, JointState> join(first, second, 3);
  Pairs pairs;
  join.registerCallback(&Pairs::take, &pairs);
  first.add(at_ms<Imu>(1));
  first.add(at_ms<Imu>(2));
  second.add(at_ms<JointState>(2));
  second.add(at_ms<JointState>(1));  // older than the last set
  EXPECT_EQ(pairs.all, (std::vector<std::pair<int, int>>{{2, 2}}));
  for (int ms = 3; ms < 8; ++ms) first.add(at_ms<Imu>(ms));
  second.add(at_ms<JointState>(4));  // dropped: three may wait
  second.add(at_ms<JointState>(5));
  EXPECT_EQ(pairs.all.back(), std::make_pair(5, 5));
  EXPECT_EQ(pairs.all.size(), 2u);
}

TEST(MessageFilters, JoinTheClosestMessagesOnceNoneCanBeCloser) {
  using Policy = message_filters::sync_policies::ApproximateTime<Imu, JointState>;
  message_filters::PassThrough<Imu> first;
  message_filters::PassThrough<JointState> second;
  message_filters::Synchronizer<Policy> join(Policy(10), first, second);
  Pairs pairs;
  auto connection =
      join.registerCallback(std::bind(&Pairs::take, &pairs, std::placeholders::_1, std::placeholders::_2));
  first.add(at_ms<Imu>(100));
  second.add(at_ms<JointState>(108));
  EXPECT_TRUE(pairs.all.empty());  // one at 109 would be closer
  first.add(at_ms<Imu>(110));
  EXPECT_EQ(pairs.all, (std::vector<std::pair<int, int>>{{110, 108}}));
  join.getPolicy()->setMaxIntervalDuration(rclcpp::Duration::from_seconds(0.005));
  first.add(at_ms<Imu>(120));
  second.add(at_ms<JointState>(130));
  first.add(at_ms<Imu>(133));
  EXPECT_EQ(pairs.all.back(), std::make_pair(133, 130));  // the one at 120 is too far from all
  for (const int ms : {190, 212}) first.add(at_ms<Imu>(ms));
  for (const int ms : {205, 213}) second.add(at_ms<JointState>(ms));
  first.add(at_ms<Imu>(220));
  EXPECT_EQ(pairs.all.back(), std::make_pair(212, 213));  // 205 is the oldest: it is dropped
  connection.disconnect();
  first.add(at_ms<Imu>(300));
  second.add(at_ms<JointState>(300));
  EXPECT_EQ(pairs.all.size(), 3u);
}

TEST(MessageFilters, SubscribeATopicAndKeepTheLastMessages) {
  auto node = std::make_shared<rclcpp::Node>("filtering");
  message_filters::Subscriber<Imu> input(node, "imu", rclcpp::SensorDataQoS().get_rmw_qos_profile());
  message_filters::Cache<Imu> cache(input, 2);
  auto publisher = rclcpp::create_publisher<Imu>(node->get_node_topics_interface(), "imu", 10);
  for (const int ms : {10, 30, 20}) publisher->publish(*at_ms<Imu>(ms));
  rclcpp::spin_some(node);
  const auto time = [](int ms) { return rclcpp::Time(std::int64_t{ms} * 1000000, RCL_ROS_TIME); };
  ASSERT_TRUE(cache.getElemBeforeTime(time(29)));
  EXPECT_EQ(ms_of(cache.getElemBeforeTime(time(29))), 20);
  EXPECT_EQ(ms_of(cache.getElemAfterTime(time(21))), 30);
  EXPECT_FALSE(cache.getElemBeforeTime(time(15)));
  EXPECT_EQ(cache.getInterval(time(0), time(40)).size(), 2u);
  input.unsubscribe();
  publisher->publish(*at_ms<Imu>(50));
  rclcpp::spin_some(node);
  EXPECT_EQ(cache.getLatestTime(), time(30));
}

TEST(InteractiveMarkers, ShowWhatIsAppliedAndFollowADrag) {
  using namespace visualization_msgs;
  auto node = std::make_shared<rclcpp_lifecycle::LifecycleNode>("markers");
  interactive_markers::InteractiveMarkerServer server("target", node);
  std::vector<msg::InteractiveMarkerUpdate> updates;
  auto topics = node->get_node_topics_interface();
  const auto seen = rclcpp::create_subscription<msg::InteractiveMarkerUpdate>(
      topics, "target/update", 10, [&](const msg::InteractiveMarkerUpdate& m) { updates.push_back(m); });
  msg::InteractiveMarker marker;
  marker.name = "tool";
  marker.header.frame_id = "base";
  double heard = 0;
  server.insert(marker, [&](const auto& feedback) { heard = feedback->pose.position.x; });
  interactive_markers::MenuHandler menu;
  const auto entry = menu.insert("Home", [&](const auto&) { heard = -1; });
  const auto hidden = menu.insert(entry, "Below");
  EXPECT_TRUE(menu.setVisible(hidden, false));
  EXPECT_TRUE(menu.apply(server, "tool"));
  server.applyChanges();
  server.applyChanges();  // nothing is left to tell
  rclcpp::spin_some(node->get_node_base_interface());
  ASSERT_EQ(updates.size(), 1u);
  ASSERT_EQ(updates[0].markers.at(0).menu_entries.size(), 1u);
  EXPECT_EQ(updates[0].markers[0].menu_entries[0].title, "Home");

  auto drag = node->create_publisher<msg::InteractiveMarkerFeedback>("target/feedback", 10);
  drag->on_activate();
  msg::InteractiveMarkerFeedback feedback;
  feedback.marker_name = "tool";
  feedback.event_type = msg::InteractiveMarkerFeedback::POSE_UPDATE;
  feedback.pose.position.x = 0.25;
  drag->publish(feedback);
  rclcpp::spin_some(node->get_node_base_interface());
  EXPECT_EQ(heard, 0.25);
  msg::InteractiveMarker moved;
  ASSERT_TRUE(server.get("tool", moved));
  EXPECT_EQ(moved.pose.position.x, 0.25);
  server.applyChanges();
  feedback.event_type = msg::InteractiveMarkerFeedback::MENU_SELECT;
  feedback.menu_entry_id = entry;
  drag->publish(feedback);
  EXPECT_TRUE(server.erase("tool"));
  server.applyChanges();
  rclcpp::spin_some(node->get_node_base_interface());
  EXPECT_EQ(heard, 0.25);  // erased before the selection was heard
  EXPECT_EQ(updates.size(), 3u);
  EXPECT_EQ(updates[1].poses.at(0).pose.position.x, 0.25);
  EXPECT_EQ(updates[2].erases, std::vector<std::string>{"tool"});
  EXPECT_EQ(server.size(), 0u);
}

TEST(PalStatistics, PublishRegisteredVariablesUntilTheirBookkeepingEnds) {
  auto node = std::make_shared<rclcpp_lifecycle::LifecycleNode>("counting");
  std::vector<pal_statistics_msgs::msg::Statistics> heard;
  const auto seen = node->create_subscription<pal_statistics_msgs::msg::Statistics>(
      "~/stats/full", 10, [&](const pal_statistics_msgs::msg::Statistics& m) { heard.push_back(m); });
  double force = 1.5;
  int count = 3;
  {
    pal_statistics::RegistrationsRAII book;
    REGISTER_VARIABLE(node, "~/stats", "force", &force, &book);
    REGISTER_VARIABLE(node, "~/stats", "count", &count, &book);
    PUBLISH_STATISTICS(node, "~/stats");
    rclcpp::spin_some(node->get_node_base_interface());
    ASSERT_EQ(heard.size(), 1u);
    ASSERT_EQ(heard[0].statistics.size(), 2u);
    EXPECT_EQ(heard[0].statistics[1].name, "count");
    EXPECT_EQ(heard[0].statistics[1].value, 3);
    const auto registry = pal_statistics::getRegistry(node, "~/stats");
    EXPECT_EQ(pal_statistics::getRegistry(node.get(), "~/stats"), registry) << "one for each node and topic";
    const polyarm::test::RealtimeGuard guard;
    force = 2;
    const bool copied = registry->publishAsync(), again = registry->publishAsync();
    EXPECT_EQ(guard.allocations(), 0u);
    EXPECT_TRUE(copied);
    EXPECT_FALSE(again);  // what was copied waits for the thread
  }
  EXPECT_TRUE(pal_statistics::getRegistry(node, "~/stats")->createMsg().statistics.empty());
}

TEST(AsyncFunctionHandler, CallsOnceForEachTriggerAndThrowsWhatTheFunctionThrew) {
  realtime_tools::AsyncFunctionHandler<int> handler;
  EXPECT_THROW(handler.trigger_async_callback(rclcpp::Time(0), rclcpp::Duration(0, 0)), std::runtime_error);
  int calls = 0;
  handler.init([&](const rclcpp::Time& time, const rclcpp::Duration&) {
    if (time.nanoseconds() == 3) throw std::runtime_error("the cable is cut");
    return ++calls;
  });
  handler.start_thread();
  for (const int at : {1, 2}) {
    EXPECT_TRUE(handler.trigger_async_callback(rclcpp::Time(at), rclcpp::Duration(0, 0)).first);
    handler.wait_for_trigger_cycle_to_finish();
  }
  EXPECT_EQ(handler.get_last_return_value(), 2);
  handler.trigger_async_callback(rclcpp::Time(3), rclcpp::Duration(0, 0));
  handler.wait_for_trigger_cycle_to_finish();
  EXPECT_THROW(handler.trigger_async_callback(rclcpp::Time(4), rclcpp::Duration(0, 0)), std::runtime_error);
  handler.stop_thread();
  EXPECT_EQ(calls, 2);
}

TEST(Rcpputils, HavePathsPointersTextsAndSpans) {
  EXPECT_EQ((rcpputils::fs::path("/a") / "b.yaml").filename().string(), "b.yaml");
  EXPECT_FALSE(rcpputils::fs::exists(rcpputils::fs::path("/no/such/file")));
  EXPECT_EQ(rcpputils::find_and_replace("a.b.c", ".", "::"), "a::b::c");
  EXPECT_TRUE(rcpputils::is_pointer<std::shared_ptr<int>>::value);
  EXPECT_EQ(rcpputils::convert_to_nanoseconds(std::chrono::milliseconds(2)).count(), 2000000);
  EXPECT_THROW(rcpputils::convert_to_nanoseconds(std::chrono::hours(24 * 365 * 400)), std::invalid_argument);
}

}  // namespace
