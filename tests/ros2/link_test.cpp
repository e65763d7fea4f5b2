/// Tags bound to topics and services: a link of a cell as a node of ROS 2's graph.
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>
#include <utility>
#include <vector>

#include "links/ros2/field.hpp"
#include "links/ros2/port.hpp"
#include "polyarm/ros2/wire.hpp"
#include "polyarm/signals/links_file.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "tests/ros2/client.hpp"
#ifdef POLYARM_CYCLONE
#include "tests/ros2/domain.hpp"
#include "tests/ros2/raw_cyclone.hpp"
#endif

namespace polyarm::ros2 {
namespace {

using signals::LinkEntry;
using signals::LinkReport;
using signals::LinkValue;
using test::json;
using test::wait;

std::uint32_t own_domain() {
  return test::own_domain();
}

LinkEntry read_entry(const std::string& tags) {
  Problems problems;
  const std::string text =
      "camera:\n  ros2: node\n  domain: " + std::to_string(own_domain()) + "\n  tags:\n" + tags;
  auto links = signals::read_links(Yaml::parse(text, "signals.yaml"), ".", problems);
  problems.throw_if_errors();
  return links.front();
}

std::string refusal(const std::string& tags) {
  try {
    make_port(read_entry(tags));
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

/// A port, and what it has brought.
class Node {
 public:
  explicit Node(const std::string& tags) : entry{read_entry(tags)}, port_{make_port(entry)} { port_->open(); }

  std::size_t index(const std::string& tag) const {
    for (std::size_t i = 0; i < entry.tags.size(); ++i)
      if (entry.tags[i].name == tag) return i;
    throw std::out_of_range(tag);
  }
  void set(const std::string& tag, data::Value value) { writes_.push_back({index(tag), std::move(value)}); }
  /// One round; then the newest value of each tag is in `values`.
  void round() {
    LinkReport news;
    port_->exchange(std::exchange(writes_, {}), 0, 1'000'000, news);
    for (LinkValue& value : news.values) values[entry.tags[value.tag].name] = std::move(value.value);
    for (auto& [tag, why] : news.refused) refused[entry.tags[tag].name] = why;
  }
  bool has(const std::string& tag, const data::Value& value) {
    round();
    return values.contains(tag) && values.at(tag) == value;
  }

  const LinkEntry entry;
  std::map<std::string, data::Value> values;
  std::map<std::string, std::string> refused;

 private:
  std::unique_ptr<signals::LinkPort> port_;
  std::vector<LinkValue> writes_;
};

TEST(Ros2Link, APoseThatACameraTellsBecomesAPoint) {
  Node node(R"(
    pick: {topic: /camera/part, message: geometry_msgs/PoseStamped, type: pose, direction: in, within: [[0, -1, 0], [1, 1, 1]]}
    tag3: {topic: /tf, message: tf2_msgs/TFMessage, field: "transforms[child_frame_id=tag_3]", type: pose, direction: in}
)");
  test::Client camera(own_domain());
  const auto poses = camera.publish("/camera/part", "geometry_msgs/PoseStamped");
  const auto frames = camera.publish("/tf", "tf2_msgs/TFMessage");
  ASSERT_TRUE(wait([&] { return poses->matched() && frames->matched(); }));
  const auto pose = [](double x) {
    return json{{"pose", {{"position", {{"x", x}, {"y", 0.2}, {"z", 0.3}}}, {"orientation", {{"w", 1}}}}}};
  };
  poses->publish(pose(0.5));
  ASSERT_TRUE(wait([&] { return node.round(), node.values.contains("pick"); }));
  EXPECT_EQ(node.values["pick"].as_point()->pose.position, (Vec3{0.5, 0.2, 0.3}));
  poses->publish(pose(7));
  ASSERT_TRUE(wait([&] { return node.round(), node.refused.contains("pick"); }));
  EXPECT_NE(node.refused["pick"].find("outside"), std::string::npos);
  EXPECT_EQ(node.values["pick"].as_point()->pose.position.x, 0.5) << "the old one stays";
  const auto transform = [](const char* child, double x) {
    return json{{"child_frame_id", child},
                {"transform", {{"translation", {{"x", x}}}, {"rotation", {{"z", 1}}}}}};
  };
  frames->publish({{"transforms", {transform("tag_1", 1)}}});
  frames->publish({{"transforms", {transform("tag_1", 1), transform("tag_3", 3)}}});
  ASSERT_TRUE(wait([&] { return node.round(), node.values.contains("tag3"); }));
  EXPECT_EQ(node.values["tag3"].as_point()->pose.position.x, 3);
  EXPECT_EQ(node.values["tag3"].as_point()->pose.rotation.z, 1);
}

TEST(Ros2Link, WhatAProgramSetsIsPublishedAsOneMessageOfItsTopic) {
  Node node(R"(
    x: {topic: /goal, message: geometry_msgs/PointStamped, field: point.x, type: number, direction: out, scale: 1000, with: {header.frame_id: base}}
    y: {topic: /goal, message: geometry_msgs/PointStamped, field: point.y, type: number, direction: out}
    count: {topic: /count, message: std_msgs/UInt8, field: data, type: number, direction: out, latched: true}
    at: {topic: /at, message: geometry_msgs/TransformStamped, type: pose, direction: out}
    said: {topic: /said, message: std_msgs/String, field: data, type: text, direction: both}
    ready: {topic: /ready, message: std_msgs/Int32, field: data, type: number, direction: out}
)");
  test::Client other(own_domain());
  const auto goal = other.listen("/goal", "geometry_msgs/PointStamped");
  const auto at = other.listen("/at", "geometry_msgs/TransformStamped");
  const auto said = other.listen("/said", "std_msgs/String");
  const auto says = other.publish("/said", "std_msgs/String");
  const auto ready = other.listen("/ready", "std_msgs/Int32");
  ASSERT_TRUE(wait([&] { return goal->matched() && at->matched() && said->matched() && says->matched(); }));
  // Listeners are made known one after the other: when the last one hears, the node knows all of them.
  int count = 0;
  ASSERT_TRUE(wait([&] {
    node.set("ready", ++count);
    node.round();
    return ready->heard();
  }));
  node.set("x", 500);
  node.set("y", 2);
  node.set("count", 300);
  data::Point point;
  point.pose = {{1, 2, 3}, {0, 0, 1, 0}};
  node.set("at", point);
  node.set("said", "hello");
  node.round();
  ASSERT_TRUE(wait([&] { return goal->heard() && at->heard() && said->heard(); }));
  EXPECT_EQ(goal->latest()["point"], json({{"x", 0.5}, {"y", 2.0}, {"z", 0.0}}));
  EXPECT_EQ(goal->latest()["header"]["frame_id"], "base");
  EXPECT_GT(goal->latest()["header"]["stamp"]["sec"], 0);
  EXPECT_EQ(goal->count(), 1u) << "both at once";
  EXPECT_EQ(at->latest()["transform"]["translation"]["z"], 3.0);
  EXPECT_EQ(at->latest()["transform"]["rotation"]["z"], 1.0);
  const auto late = other.listen("/count", "std_msgs/UInt8", {true, true, 1});
  ASSERT_TRUE(wait([&] { return late->heard(); })) << "latched";
  EXPECT_EQ(late->latest()["data"], 255) << "as far as the field goes";
  says->publish({{"data", "good day"}});
  EXPECT_TRUE(wait([&] { return node.has("said", "good day"); }));
}

TEST(Ros2Link, AProgramCallsAServiceAndGetsItsAnswer) {
  Node node(R"(
    Light: {call: /lamp/set, service: std_srvs/SetBool}
    On: {request: /lamp/set, field: data}
    Done: {answer: /lamp/set, field: success}
    Text: {answer: /lamp/set, field: message, type: text}
)");
  node.set("On", true);
  node.set("Light", true);
  node.round();
  EXPECT_FALSE(node.values.contains("Light")) << "nobody is there to answer";
  ParticipantOptions options;
  options.domain = own_domain();
  Wire server(options);
  std::vector<bool> asked;
  server.service("/lamp", "/lamp/set", "std_srvs/srv/SetBool", [&](Wire::Request request) {
    json fields;
    if (messages::to_json(*messages::find_type("std_srvs/srv/SetBool_Request"), request.payload, fields) !=
        messages::CdrError::none)
      return false;
    asked.push_back(fields["data"]);
    request.answer(messages::from_json(*messages::find_type("std_srvs/srv/SetBool_Response"),
                                       {{"success", true}, {"message", asked.back() ? "lit" : "dark"}}));
    return true;
  });
  ASSERT_TRUE(wait([&] { return server.take(10), node.has("Light", false); }));
  EXPECT_EQ(node.values.at("Done"), data::Value(true));
  EXPECT_EQ(node.values.at("Text"), data::Value("lit"));
  node.values.clear();
  node.set("On", false);
  node.set("Light", true);
  ASSERT_TRUE(wait([&] { return server.take(10), node.has("Light", false); }));
  EXPECT_EQ(node.values.at("Text"), data::Value("dark"));
  EXPECT_EQ(node.values.at("Done"), data::Value(true)) << "an answer is told again";
  EXPECT_EQ(asked, (std::vector<bool>{true, false})) << "once for each time it is set";
}

#ifdef POLYARM_CYCLONE
/// The same with a camera, a listener and a service on Cyclone DDS.
TEST(Ros2Link, ACameraAndAServiceOnCycloneAreBoundAsThoseOnFastDds) {
  Node node(R"(
    pick: {topic: /camera/part, message: geometry_msgs/PoseStamped, type: pose, direction: in}
    x: {topic: /goal, message: geometry_msgs/PointStamped, field: point.x, type: number, direction: out}
    Look: {call: /camera/look, service: std_srvs/SetBool}
    Side: {request: /camera/look, field: data}
    Found: {answer: /camera/look, field: success}
)");
  test::RawCyclone cyclone(own_domain());
  const auto& pose = *messages::find_type("geometry_msgs/PoseStamped");
  const auto& point = *messages::find_type("geometry_msgs/PointStamped");
  const auto& asked = *messages::find_type("std_srvs/srv/SetBool_Request");
  const auto& answered = *messages::find_type("std_srvs/srv/SetBool_Response");
  const auto camera = cyclone.writer("rt/camera/part", pose.dds_name);
  const auto goals = cyclone.reader("rt/goal", point.dds_name);
  const auto requests = cyclone.reader("rq/camera/lookRequest", asked.dds_name);
  const auto replies = cyclone.writer("rr/camera/lookReply", answered.dds_name);
  test::Payload told = messages::from_json(
      pose, {{"header", {{"frame_id", "base"}}},
             {"pose", {{"position", {{"x", 0.5}, {"y", 0.2}, {"z", 0.3}}}, {"orientation", {{"w", 1}}}}}});
  ASSERT_TRUE(wait([&] {
    dds_write(camera, &told);
    node.round();
    return node.values.contains("pick");
  }));
  EXPECT_EQ(node.values["pick"].as_point()->pose.position, (Vec3{0.5, 0.2, 0.3}));
  json goal;
  double x = 0;
  ASSERT_TRUE(wait([&] {
    node.set("x", x += 1);
    node.round();
    const auto payload = test::RawCyclone::take(goals);
    return payload && messages::to_json(point, *payload, goal) == messages::CdrError::none;
  }));
  EXPECT_GE(goal["point"]["x"], 1.0);
  node.set("Side", true);
  node.set("Look", true);
  ASSERT_TRUE(wait([&] {
    if (const auto request = test::RawCyclone::take(requests)) {
      EXPECT_EQ((*request)[20], std::byte{1}) << "behind who asks";
      test::Payload reply = messages::from_json(answered, {{"success", true}});
      reply.insert(reply.begin() + 4, request->begin() + 4, request->begin() + 20);
      dds_write(replies, &reply);
    }
    return node.has("Look", false);
  }));
  EXPECT_EQ(node.values.at("Found"), data::Value(true));
}
#endif

TEST(Ros2Link, WhatDoesNotFitIsRefusedWithWhatThereIs) {
  EXPECT_NE(
      refusal("    a: {topic: /a, message: no_msgs/Thing, direction: in}\n").find("no type no_msgs/Thing"),
      std::string::npos);
  EXPECT_NE(refusal("    a: {topic: /a, message: std_msgs/Bool, field: dta, direction: in}\n").find("'data'"),
            std::string::npos);
  EXPECT_NE(
      refusal("    a: {topic: /a, message: std_msgs/String, field: data, direction: in}\n").find("text"),
      std::string::npos);
  EXPECT_NE(refusal("    a: {topic: /a, message: geometry_msgs/PoseArray, field: poses, type: pose, "
                    "direction: in}\n")
                .find("poses[0]"),
            std::string::npos);
  EXPECT_EQ(refusal("    a: {topic: /a, message: geometry_msgs/PoseArray, field: 'poses[0]', type: pose, "
                    "direction: in}\n"),
            "");
  EXPECT_NE(refusal("    a: {answer: /a, field: success}\n").find("no tag calls /a"), std::string::npos);
  EXPECT_NE(refusal("    a: {topic: /a, message: std_msgs/Bool, field: data}\n").find("direction"),
            std::string::npos);
  EXPECT_NE(refusal("    a: {call: /a, service: std_srvs/Trigger, field: success}\n").find("no field"),
            std::string::npos);
  EXPECT_NE(
      refusal("    a: {topic: /a, message: std_msgs/Bool, field: data, direction: out, with: {dat: 1}}\n")
          .find("no field 'dat'"),
      std::string::npos);
}

}  // namespace
}  // namespace polyarm::ros2
