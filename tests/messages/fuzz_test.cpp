/// Whatever comes, it is read or refused; under the sanitizers, too.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "polyarm/messages/json.hpp"
#include "polyarm/messages/types.hpp"
#include "tests/messages/random_message.hpp"

namespace polyarm::messages {
namespace {

using nlohmann::json;
using Bytes = std::vector<std::byte>;

/// Cut short, made longer, with bytes, lengths and the byte order changed.
Bytes spoiled(Bytes payload, std::mt19937& random) {
  for (unsigned changes = 1 + random() % 4; changes > 0 && payload.size() > 4; --changes)
    payload[random() % 8 == 0 ? random() % 4 : 4 + random() % (payload.size() - 4)] =
        static_cast<std::byte>(random() % 3 == 0 ? 0xff : random());
  if (random() % 4 == 0) payload.resize(random() % (payload.size() + 1));
  if (random() % 8 == 0) payload.resize(payload.size() + random() % 9);
  if (random() % 4 == 0 && payload.size() >= 8) {
    const std::size_t at = 4 + 4 * (random() % ((payload.size() - 4) / 4));
    for (std::size_t i = 0; i < 4; ++i) payload[at + i] = static_cast<std::byte>(i == 3 ? 0x7f : 0xff);
  }
  return payload;
}

TEST(Fuzz, EveryTypeInEveryFormComesBackAsItWas) {
  std::mt19937 random(11);
  for (const TypeInfo* type : test::all_types())
    for (int round = 0; round < 20; ++round) {
      const json message = test::random_message(*type, random);
      json again;
      ASSERT_EQ(to_json(*type, from_json(*type, message), again), CdrError::none) << type->name;
      EXPECT_EQ(again, message) << type->name;
    }
}

TEST(Fuzz, WhatIsSpoiledIsReadOrRefused) {
  std::mt19937 random(12);
  int refused = 0, read = 0;
  for (const TypeInfo* type : test::all_types())
    for (int round = 0; round < 150; ++round) {
      const Bytes payload = spoiled(from_json(*type, test::random_message(*type, random)), random);
      json out;
      if (to_json(*type, payload, out) != CdrError::none) {
        ++refused;
        continue;
      }
      ++read;
      json again;
      ASSERT_EQ(to_json(*type, from_json(*type, out), again), CdrError::none) << type->name;
      EXPECT_EQ(again, out) << type->name;
    }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(read, 1000);
}

/// The structs' readers and the one by description agree on what is a message.
template <class Message>
void agree(std::uint32_t seed) {
  std::mt19937 random(seed);
  const TypeInfo& type = type_info<Message>();
  for (int round = 0; round < 2000; ++round) {
    const Bytes payload = spoiled(from_json(type, test::random_message(type, random)), random);
    Message message;
    json out;
    const CdrError by_struct = from_cdr(payload, message), by_description = to_json(type, payload, out);
    ASSERT_EQ(by_struct, by_description) << type.name;
    if (by_struct == CdrError::none) {
      json again;
      ASSERT_EQ(to_json(type, to_cdr(message), again), CdrError::none);
      EXPECT_EQ(again, out) << type.name;
    }
  }
}

TEST(Fuzz, BothReadersAgree) {
  agree<sensor_msgs::msg::JointState>(1);
  agree<control_msgs::action::FollowJointTrajectory::SendGoal_Request>(2);
  agree<rcl_interfaces::srv::SetParameters::Request>(3);
  agree<tf2_msgs::msg::TFMessage>(4);
  agree<action_msgs::srv::CancelGoal::Request>(5);
}

}  // namespace
}  // namespace polyarm::messages
