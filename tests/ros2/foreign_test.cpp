/// Samples and discovery as other vendors, broken programs and strangers send them: counted, dropped, and
/// nobody else is disturbed.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#if __has_include(<fastrtps/xmlparser/XMLProfileManager.h>)
#include <fastrtps/xmlparser/XMLProfileManager.h>
#define FAST_DDS_2
#endif
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "polyarm/messages/types.hpp"
#include "polyarm/ros2/wire.hpp"
#include "tests/ros2/client.hpp"
#include "tests/ros2/domain.hpp"
#include "tests/ros2/rmw_fast.hpp"

namespace polyarm::ros2 {
namespace {

using messages::from_cdr;
using messages::to_cdr;
using messages::type_info;
using test::wait;
using Payload = std::vector<std::byte>;

ParticipantOptions here() {
  ParticipantOptions out;
  out.domain = test::own_domain();
  return out;
}

/// Two participants of one process may crash in Fast DDS 2.9 when one of them ends (intraprocess_gap). From
/// now on they communicate as those of two processes do.
void as_in_two_processes() {
#ifdef FAST_DDS_2
  eprosima::fastrtps::LibrarySettingsAttributes settings;
  settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
#endif
}

/// A wire that takes texts and trajectories and serves SetBool, and somebody who writes to it.
class Foreign : public ::testing::Test {
 protected:
  Foreign() {
    wire.subscription("/n", "/text", type_info<messages::std_msgs::msg::String>(), {true, false, 5000},
                      [&](std::span<const std::byte> payload) {
                        messages::std_msgs::msg::String got;
                        if (from_cdr(payload, got) != messages::CdrError::none) return false;
                        text = got.data;
                        return ++taken > 0;
                      });
    wire.subscription("/n", "/path", type_info<messages::trajectory_msgs::msg::JointTrajectory>(),
                      {true, false, 5000}, [&](std::span<const std::byte> payload) {
                        test::json out;
                        const auto& type = type_info<messages::trajectory_msgs::msg::JointTrajectory>();
                        if (messages::to_json(type, payload, out) != messages::CdrError::none) return false;
                        return ++taken > 0;
                      });
    wire.service("/n", "/set", "std_srvs/srv/SetBool", [&](Wire::Request request) {
      messages::std_srvs::srv::SetBool::Request asked;
      if (from_cdr(request.payload, asked) != messages::CdrError::none) return false;
      request.answer(to_cdr(messages::std_srvs::srv::SetBool::Response{asked.data, "served"}));
      return ++taken > 0;
    });
  }
  /// All that was written has been looked at: taken or refused.
  bool all_seen(std::uint64_t written) {
    return wait([&] {
      while (wire.take(100) > 0) {
      }
      return wire.statistics().received >= written;
    });
  }
  /// Somebody with nothing wrong about him is served as ever.
  void expect_served() {
    test::Client good(here().domain);
    const auto publisher = good.publish("/text", "std_msgs/String");
    ASSERT_TRUE(wait([&] { return publisher->matched(); }));
    text.clear();
    publisher->publish({{"data", "well"}});
    EXPECT_TRUE(wait([&] { return wire.take(100), text == "well"; }));
  }

  Wire wire{here()};
  Participant other{here()};
  std::uint64_t taken = 0;
  std::string text;
};

Payload text_in(bool big_endian, const std::string& text) {
  Payload out{std::byte{0}, std::byte{big_endian ? std::uint8_t{0} : std::uint8_t{1}}, std::byte{0},
              std::byte{0}};
  const auto size = static_cast<std::uint32_t>(text.size() + 1);
  for (int i = 0; i < 4; ++i)
    out.push_back(static_cast<std::byte>(size >> (big_endian ? 24 - 8 * i : 8 * i) & 255));
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
  out.push_back(std::byte{0});
  return out;
}

TEST_F(Foreign, PlainCdrOfEitherByteOrderIsTakenAndNoOtherRepresentation) {
  const auto writer = other.add_writer("rt/text", "std_msgs::msg::dds_::String_", {true, false, 5000}, "");
  ASSERT_TRUE(wait([&] { return !other.matched(writer).empty(); }));
  // PL_CDR, XML, and all of XCDR2 among them.
  for (int representation = 0; representation < 512; ++representation) {
    Payload payload = text_in(false, "little");
    payload[0] = static_cast<std::byte>(representation >> 8);
    payload[1] = static_cast<std::byte>(representation & 255);
    other.write(writer, payload);
  }
  ASSERT_TRUE(all_seen(512));
  EXPECT_EQ(taken, 1u);
  EXPECT_EQ(wire.statistics().refused, 511u);
  other.write(writer, text_in(true, "big"));
  ASSERT_TRUE(all_seen(513));
  EXPECT_EQ(text, "big");
}

Payload trajectory() {
  messages::trajectory_msgs::msg::JointTrajectory out;
  out.joint_names = {"shoulder", "elbow", "wrist"};
  for (int i = 0; i < 3; ++i) {
    auto& point = out.points.emplace_back();
    point.positions = {0.1, 0.2, 0.3};
    point.velocities = {0, 0, 0};
    point.time_from_start.sec = i + 1;
  }
  return to_cdr(out);
}

TEST_F(Foreign, WhatIsCutLengthenedOrChangedIsTakenOrRefusedAndNothingElse) {
  const auto writer =
      other.add_writer("rt/path", "trajectory_msgs::msg::dds_::JointTrajectory_", {true, false, 5000}, "");
  ASSERT_TRUE(wait([&] { return !other.matched(writer).empty(); }));
  const Payload whole = trajectory();
  std::uint64_t written = 0;
  const auto put = [&](const Payload& payload) {
    other.write(writer, payload);
    if (++written % 500 == 0) {
      ASSERT_TRUE(all_seen(written));
    }
  };
  for (std::size_t size = 1; size < whole.size(); ++size)  // nothing at all Fast DDS itself keeps from us
    put({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
  ASSERT_TRUE(all_seen(written));
  // To four bytes it is filled up on the way, which may make a cut one whole again at its very end.
  EXPECT_LE(taken, 3u);
  for (const std::uint32_t length : {0xffffffffu, 0x7fffffffu, 0x10000000u, 100'000u})
    for (std::size_t at = 4; at + 4 <= whole.size(); at += 4) {
      Payload payload = whole;
      std::memcpy(payload.data() + at, &length, 4);
      put(payload);
    }
  std::mt19937 random(9);
  for (int i = 0; i < 3000; ++i) {
    Payload payload = whole;
    for (unsigned n = 1 + random() % 6; n > 0; --n)
      payload[random() % payload.size()] = static_cast<std::byte>(random());
    if (random() % 4 == 0) payload.resize(1 + random() % (2 * payload.size()));
    put(payload);
  }
  ASSERT_TRUE(all_seen(written));
  const WireStatistics seen = wire.statistics();
  EXPECT_EQ(seen.received, written);
  EXPECT_EQ(seen.dropped, 0u);
  EXPECT_EQ(seen.refused + taken, written) << "of each it is known what became of it";
  EXPECT_GT(seen.refused, 1000u);
  expect_served();
}

#ifdef POLYARM_RMW_FAST
using test::RmwNode;

TEST_F(Foreign, AClientOfAnotherVendorIsAnsweredAsFastDdsIs) {
  // Connext, OpenDDS, and one that nobody knows.
  for (const std::array<std::uint8_t, 2> vendor : {std::array<std::uint8_t, 2>{1, 1}, {1, 3}, {0x77, 0x77}}) {
    RmwNode node(here().domain, RmwNode::Range::localhost, nullptr, vendor);
    RmwNode::Caller caller(node, "/set", "std_srvs::srv::dds_::SetBool_Request_",
                           "std_srvs::srv::dds_::SetBool_Response_");
    ASSERT_TRUE(wait([&] { return caller.ready(); }));
    caller.ask(to_cdr(messages::std_srvs::srv::SetBool::Request{true}));
    std::optional<test::Bytes> answer;
    ASSERT_TRUE(wait([&] { return wire.take(10), (answer = caller.answer()).has_value(); }));
    messages::std_srvs::srv::SetBool::Response reply;
    EXPECT_EQ(from_cdr(*answer, reply), messages::CdrError::none);
    EXPECT_EQ(reply.message, "served");
  }
}

TEST_F(Foreign, WhoSaysThatHeIsCycloneAndSendsNoHeaderIsRefused) {
  RmwNode node(here().domain, RmwNode::Range::localhost, nullptr, std::array<std::uint8_t, 2>{1, 0x10});
  auto* writer = node.writer("rq/setRequest", "std_srvs::srv::dds_::SetBool_Request_");
  ASSERT_TRUE(wait([&] {
    eprosima::fastdds::dds::PublicationMatchedStatus status;
    writer->get_publication_matched_status(status);
    return status.current_count > 0;
  }));
  for (std::size_t size = 4; size < 20; ++size) {
    test::Bytes bytes(size, std::byte{1});
    bytes[0] = bytes[2] = bytes[3] = std::byte{0};
    writer->write(&bytes);
  }
  ASSERT_TRUE(all_seen(16));
  EXPECT_EQ(wire.statistics().refused, 16u);
  EXPECT_EQ(taken, 0u);
  expect_served();
}
#endif

TEST_F(Foreign, WildUserDataOtherTypesAndARottenGraphDisturbNobody) {
  as_in_two_processes();
  std::mt19937 random(4);
  const auto rubbish = [&](std::size_t size) {
    std::string out(size, ' ');
    for (char& c : out) c = static_cast<char>(random());
    return out;
  };
  const std::string wild[] = {"",
                              ";",
                              "=",
                              "clientid=",
                              "clientid=;",
                              "serviceid=",
                              "typehash=RIHS01_",
                              "clientid=..;typehash=;clientid=",
                              std::string("\0\0clientid=\0", 12),
                              rubbish(200),
                              rubbish(5000)};
  for (const std::string& data : wild) {
    Participant stranger([&] {
      ParticipantOptions out = here();
      out.user_data = data;
      return out;
    }());
    stranger.add_writer("rq/setRequest", "std_srvs::srv::dds_::SetBool_Request_", {}, data);
    stranger.add_reader("rr/setReply", "std_srvs::srv::dds_::SetBool_Response_", {}, data,
                        [](const Sample&) {});
    stranger.add_writer("rt/text", "nothing::like::It_", {}, data);
    const auto graph = stranger.add_writer(
        "ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_", {true, true, 1}, data);
    const std::string bytes = rubbish(random() % 300);
    stranger.write(graph, std::as_bytes(std::span(bytes)));
    expect_served();
  }
}

/// Datagrams at the ports of the domain, with and without the look of RTPS.
TEST_F(Foreign, DatagramsThatAreNoRtpsDisturbNobody) {
  const int out = ::socket(AF_INET, SOCK_DGRAM, 0);
  ASSERT_GE(out, 0);
  std::mt19937 random(5);
  for (int i = 0; i < 4000; ++i) {
    std::vector<std::uint8_t> bytes(random() % 400);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (i % 2 == 0 && bytes.size() > 20) std::memcpy(bytes.data(), "RTPS\2\3\1\17", 8);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * here().domain + 10 + random() % 4));
    ::sendto(out, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    if (i % 500 == 499) expect_served();
  }
  ::close(out);
}

}  // namespace
}  // namespace polyarm::ros2
