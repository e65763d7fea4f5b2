#include "polyarm/messages/json.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/messages/types.hpp"

namespace polyarm::messages {
namespace {

using nlohmann::json;

std::string refusal(const char* type, const json& message) {
  try {
    from_json(*find_type(type), message);
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(MessageJson, HasTheShapeOfTheMessage) {
  sensor_msgs::msg::JointState state;
  state.header.stamp = {3, 4};
  state.name = {"a"};
  state.position = {0.25};
  json out;
  ASSERT_EQ(to_json(type_info<sensor_msgs::msg::JointState>(), to_cdr(state), out), CdrError::none);
  EXPECT_EQ(out, json::parse(R"({"header": {"stamp": {"sec": 3, "nanosec": 4}, "frame_id": ""}, "name": ["a"],
                                 "position": [0.25], "velocity": [], "effort": []})"));
}

TEST(MessageJson, WhatIsLeftOutIsZero) {
  const auto payload =
      from_json(*find_type("geometry_msgs/TwistStamped"),
                json::parse(R"({"header": {"stamp": 1.5}, "twist": {"linear": {"x": 2}}, "more": 1})"));
  geometry_msgs::msg::TwistStamped twist;
  ASSERT_EQ(from_cdr(payload, twist), CdrError::none);
  EXPECT_EQ(twist.header.stamp.sec, 1);
  EXPECT_EQ(twist.header.stamp.nanosec, 500'000'000u);
  EXPECT_EQ(twist.twist.linear.x, 2.0);
  EXPECT_EQ(twist.twist.angular.z, 0.0);
}

TEST(MessageJson, ARefusalNamesTheField) {
  EXPECT_NE(
      refusal("sensor_msgs/JointState", {{"position", {1, "two"}}}).find("position is \"two\", not a number"),
      std::string::npos);
  EXPECT_NE(refusal("geometry_msgs/Twist", {{"linear", {{"x", true}}}}).find("linear.x"), std::string::npos);
  EXPECT_NE(refusal("std_msgs/Int32", {{"data", 3'000'000'000}}).find("whole number that fits"),
            std::string::npos);
  EXPECT_NE(refusal("std_msgs/UInt32", {{"data", -1}}).find("whole number that fits"), std::string::npos);
  EXPECT_NE(refusal("std_msgs/String", {{"data", 1}}).find("not a text"), std::string::npos);
  EXPECT_NE(refusal("sensor_msgs/Imu", {{"orientation_covariance", {1, 2}}}).find("a list of 9"),
            std::string::npos);
  EXPECT_NE(refusal("std_msgs/String", 3).find("the message is 3"), std::string::npos);
}

TEST(MessageJson, AWholeNumberMayHaveAPoint) {
  const TypeInfo& type = *find_type("std_msgs/UInt8");
  EXPECT_EQ(from_json(type, {{"data", 3.0}}), from_json(type, {{"data", 3}}));
  for (const double wrong : {3.5, -1.0, 256.0, 1e300})
    EXPECT_NE(refusal("std_msgs/UInt8", {{"data", wrong}}).find("whole number that fits"), std::string::npos)
        << wrong;
}

/// For every type there is: what CDR says of an empty message, JSON says too, and the other way round.
TEST(MessageJson, GoesThereAndBackForEveryType) {
  for (const TypeInfo* type : types()) {
    const auto empty = from_json(*type, json::object());
    json out;
    ASSERT_EQ(to_json(*type, empty, out), CdrError::none) << type->name;
    EXPECT_EQ(from_json(*type, out), empty) << type->name << " " << out;
  }
}

TEST(MessageJson, RubbishIsReadOrRefused) {
  std::mt19937 random(5);
  for (const TypeInfo* type : types())
    for (int round = 0; round < 60; ++round) {
      std::vector<std::byte> payload(4 + random() % 80);
      for (std::byte& byte : payload)
        byte = static_cast<std::byte>(random() % 4 == 0 ? random() : random() % 3);
      payload[0] = payload[2] = payload[3] = std::byte{0};
      payload[1] = std::byte{1};
      json out;
      if (to_json(*type, payload, out) != CdrError::none) continue;
      json again;
      ASSERT_EQ(to_json(*type, from_json(*type, out), again), CdrError::none) << type->name;
      EXPECT_EQ(again, out) << type->name;
    }
}

}  // namespace
}  // namespace polyarm::messages
