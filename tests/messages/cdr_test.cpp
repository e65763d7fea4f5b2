#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "polyarm/messages/types.hpp"
#include "tests/messages/bytes.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::messages {
namespace {

sensor_msgs::msg::JointState two_joints() {
  sensor_msgs::msg::JointState state;
  state.header.stamp = {1, 2};
  state.header.frame_id = "base";
  state.name = {"j1", "j2"};
  state.position = {0.5, -1.0};
  return state;
}
/// The same in bytes, as another writer of ROS 2's messages (rosbags 0.11.5) has them.
const char* const kTwoJoints =
    "00010000010000000200000005000000626173650000000002000000030000006a310000030000006a3200000200000000000000"
    "000000"
    "000000e03f000000000000f0bf0000000000000000";

TEST(Cdr, IsWrittenAsOthersWriteIt) {
  EXPECT_EQ(hex(to_cdr(two_joints())), kTwoJoints);
  EXPECT_EQ(hex(to_cdr(std_msgs::msg::String{"hello"})), "000100000600000068656c6c6f00");
  EXPECT_EQ(hex(to_cdr(std_msgs::msg::String{""})), "000100000100000000");
  EXPECT_EQ(hex(to_cdr(std_srvs::srv::Trigger::Request{})), "0001000000");
  std_msgs::msg::Float64MultiArray numbers;
  numbers.data = {0.25, -0.5, 1.0};
  EXPECT_EQ(hex(to_cdr(numbers)),
            "0001000000000000000000000300000000000000000000000000d03f000000000000e0bf000000000000f03f");
}

TEST(Cdr, IsReadAsOthersWriteIt) {
  sensor_msgs::msg::JointState state;
  ASSERT_EQ(from_cdr(bytes(kTwoJoints), state), CdrError::none);
  EXPECT_EQ(state, two_joints());
  std_msgs::msg::String text;
  ASSERT_EQ(from_cdr(bytes("000000000000000668656c6c6f00"), text), CdrError::none) << "big-endian";
  EXPECT_EQ(text.data, "hello");
}

TEST(Cdr, OneValueStandsForTheFieldsOfANewMessage) {
  EXPECT_EQ(geometry_msgs::msg::Quaternion{}.w, 1.0);
  EXPECT_EQ(sensor_msgs::msg::NavSatStatus{}.status, -2);
  EXPECT_EQ(action_msgs::msg::GoalStatus::STATUS_ABORTED, 6);
}

TEST(Cdr, AMemoryThatIsTooSmallIsToldAndNotOverrun) {
  const auto whole = to_cdr(two_joints());
  for (std::size_t room = 0; room <= whole.size(); ++room) {
    std::vector<std::byte> memory(whole.size() + 8, std::byte{0xaa});
    const std::size_t written = to_cdr(two_joints(), std::span(memory).first(room));
    EXPECT_EQ(written, room < whole.size() ? 0 : whole.size());
    for (std::size_t i = room; i < memory.size(); ++i)
      ASSERT_EQ(memory[i], std::byte{0xaa}) << room << " " << i;
  }
}

TEST(Cdr, IntoMemoryThatIsThereItIsWrittenWithoutAllocating) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers watch here";
  const auto state = two_joints();
  std::vector<std::byte> room(256);
  std::size_t written = 0;
  std::string violations;
  {
    const test::RealtimeGuard guard;
    written = to_cdr(state, room);
    violations = guard.violations();
  }
  EXPECT_EQ(violations, "");
  EXPECT_GT(written, 0u);
}

TEST(Cdr, EveryPayloadThatIsCutShortIsRefused) {
  const auto whole = to_cdr(two_joints());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    sensor_msgs::msg::JointState state;
    EXPECT_NE(from_cdr(std::span(whole).first(size), state), CdrError::none) << size;
  }
}

TEST(Cdr, TellsWhatIsWrong) {
  const auto error = [](const std::string& payload, auto message) {
    return from_cdr(bytes(payload), message);
  };
  EXPECT_EQ(error("00070000010000000000", std_msgs::msg::String{}), CdrError::header);
  EXPECT_EQ(error("0001", std_msgs::msg::String{}), CdrError::header);
  EXPECT_EQ(error("000100000200000061", std_msgs::msg::String{}), CdrError::short_);
  EXPECT_EQ(error("00010000020000006162", std_msgs::msg::String{}), CdrError::text);
  EXPECT_EQ(error("0001000002", std_msgs::msg::Bool{}), CdrError::boolean);
  EXPECT_EQ(error("00010000ffffffff00000000", tf2_msgs::msg::TFMessage{}), CdrError::short_);
  EXPECT_EQ(error("00010000010000000000000000000000", std_msgs::msg::String{}), CdrError::trailing);
  rcl_interfaces::msg::ParameterDescriptor two_ranges;
  two_ranges.floating_point_range.resize(2);
  EXPECT_EQ(from_cdr(to_cdr(two_ranges), two_ranges), CdrError::too_many);
}

/// Whatever the bytes, reading ends, and what was read whole is written and read again as the same.
template <class Message>
void read_rubbish(std::uint32_t seed, const Message& start) {
  std::mt19937 random(seed);
  const auto good = to_cdr(start);
  for (int round = 0; round < 3000; ++round) {
    auto payload = good;
    for (unsigned changes = random() % 6; changes > 0; --changes)
      payload[4 + random() % (payload.size() - 4)] = static_cast<std::byte>(random());
    if (random() % 3 == 0) payload.resize(random() % (payload.size() + 1));
    Message message;
    if (from_cdr(payload, message) != CdrError::none) continue;
    Message again;
    ASSERT_EQ(from_cdr(to_cdr(message), again), CdrError::none);
    EXPECT_EQ(hex(to_cdr(again)), hex(to_cdr(message)));
  }
}

TEST(Cdr, RubbishIsReadOrRefusedAndNeverMore) {
  read_rubbish(1, two_joints());
  control_msgs::action::FollowJointTrajectory::SendGoal_Request goal;
  goal.goal.trajectory.joint_names = {"a", "b"};
  goal.goal.trajectory.points.resize(2);
  goal.goal.trajectory.points[1].positions = {1, 2};
  goal.goal.path_tolerance.resize(1);
  read_rubbish(2, goal);
  controller_manager_msgs::srv::ListControllers::Response controllers;
  controllers.controller.resize(1);
  controllers.controller[0].chain_connections.resize(1);
  read_rubbish(3, controllers);
  rcl_interfaces::srv::SetParameters::Request parameters;
  parameters.parameters.resize(1);
  parameters.parameters[0].value.bool_array_value = {1, 0};
  read_rubbish(4, parameters);
}

TEST(TypeInfo, NamesATypeInBothWays) {
  EXPECT_EQ(find_type("sensor_msgs/JointState"), find_type("sensor_msgs/msg/JointState"));
  EXPECT_STREQ(find_type("sensor_msgs/JointState")->dds_name, "sensor_msgs::msg::dds_::JointState_");
  EXPECT_STREQ(find_type("control_msgs/action/FollowJointTrajectory_SendGoal_Request")->dds_name,
               "control_msgs::action::dds_::FollowJointTrajectory_SendGoal_Request_");
  EXPECT_EQ(find_type("control_msgs/action/GripperCommand_Goal"),
            &type_info<control_msgs::action::GripperCommand::Goal>());
  EXPECT_EQ(find_type("std_srvs/Trigger_Request"), nullptr);
  EXPECT_EQ(find_type(""), nullptr);
}

TEST(TypeInfo, TheSchemaHasEveryTypeThatIsUsedOnce) {
  EXPECT_EQ(std::string(type_info<tf2_msgs::msg::TFMessage>().schema).substr(0, 44),
            "geometry_msgs/TransformStamped[] transforms\n");
  for (const TypeInfo* type : types()) {
    const std::string schema = type->schema;
    for (const FieldInfo& field : type->fields)
      EXPECT_EQ(field.nested == nullptr, field.kind != FieldKind::nested) << type->name;
    for (std::size_t at = schema.find("MSG: "); at != std::string::npos; at = schema.find("MSG: ", at + 1)) {
      const std::string line = schema.substr(at, schema.find('\n', at) - at + 1);
      EXPECT_EQ(schema.find(line, at + 1), std::string::npos) << type->name << " " << line;
    }
  }
}

}  // namespace
}  // namespace polyarm::messages
