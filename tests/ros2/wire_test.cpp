#include "polyarm/ros2/wire.hpp"

#include <gtest/gtest.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "tests/ros2/client.hpp"
#include "tests/ros2/domain.hpp"
#include "tests/ros2/process.hpp"
#ifdef POLYARM_CYCLONE
#include "messages.h"
#include "tests/ros2/cyclone.hpp"
#endif

namespace polyarm::ros2 {
namespace {

using messages::from_cdr;
using messages::to_cdr;
using messages::type_info;
using test::json;
using test::Process;
using test::wait;

/// Each test has a domain of its own, so that those that run beside it are not met.
std::uint32_t own_domain() {
  return test::own_domain();
}

ParticipantOptions options() {
  ParticipantOptions out;
  out.domain = own_domain();
  return out;
}

void serve_set_bool(Wire& wire) {
  using SetBool = messages::std_srvs::srv::SetBool;
  wire.service("/arm/switch", "/arm/switch/set", "std_srvs/srv/SetBool", [](Wire::Request request) {
    SetBool::Request asked;
    if (from_cdr(request.payload, asked) != messages::CdrError::none) return false;
    request.answer(to_cdr(SetBool::Response{asked.data, asked.data ? "on" : "off"}));
    return true;
  });
}

/// A client as ROS 2's middleware on Fast DDS is one: a reader of replies, a writer whose requests name it.
class FastClient {
 public:
  explicit FastClient(std::uint32_t domain)
      : participant_{[&] {
          ParticipantOptions made;
          made.domain = domain;
          return made;
        }()} {
    replies_ = participant_.add_reader("rr/arm/switch/setReply", "std_srvs::srv::dds_::SetBool_Response_", {},
                                       "", [this](const Sample& sample) {
                                         ++received;
                                         if (sample.related != participant_.guid(replies_)) return;
                                         from_cdr(sample.payload, reply);
                                         ++mine;
                                       });
    requests_ =
        participant_.add_writer("rq/arm/switch/setRequest", "std_srvs::srv::dds_::SetBool_Request_", {}, "");
  }
  bool ready() const {
    return !participant_.matched(replies_).empty() && !participant_.matched(requests_).empty();
  }
  void ask(bool data) {
    participant_.write(requests_, to_cdr(messages::std_srvs::srv::SetBool::Request{data}),
                       Related{participant_.guid(replies_), 0});
  }
  std::atomic<int> received{0}, mine{0};
  messages::std_srvs::srv::SetBool::Response reply;

 private:
  Participant participant_;
  Participant::Id replies_ = 0, requests_ = 0;
};

TEST(Wire, AServiceAnswersClientsOfFastDdsEachItsOwn) {
  Wire wire(options());
  serve_set_bool(wire);
  FastClient first(own_domain()), second(own_domain());
  ASSERT_TRUE(wait([&] { return wire.take(10), first.ready() && second.ready(); }));
  for (int i = 1; i <= 20; ++i) {
    first.ask(i % 2 == 0);
    ASSERT_TRUE(wait([&] { return wire.take(10), first.mine == i; })) << i;
    EXPECT_EQ(first.reply.message, i % 2 == 0 ? "on" : "off");
  }
  second.ask(true);
  ASSERT_TRUE(wait([&] { return wire.take(10), second.mine == 1; }));
  EXPECT_EQ(first.received, 20) << "it got what was not meant for it";
  EXPECT_EQ(second.received, 1);
}

TEST(Wire, RubbishIsCountedAndAnswersNobody) {
  Wire wire(options());
  int asked = 0;
  wire.service("/n", "/arm/switch/set", "std_srvs/srv/SetBool", [&](Wire::Request request) {
    messages::std_srvs::srv::SetBool::Request out;
    if (from_cdr(request.payload, out) != messages::CdrError::none) return false;
    ++asked;
    return true;
  });
  Participant other(options());
  const auto writer =
      other.add_writer("rq/arm/switch/setRequest", "std_srvs::srv::dds_::SetBool_Request_", {}, "");
  ASSERT_TRUE(wait([&] { return !other.matched(writer).empty(); }));
  for (std::size_t size = 1; size < 9; ++size)  // nothing at all Fast DDS itself keeps from us
    other.write(writer, std::vector<std::byte>(size, static_cast<std::byte>(size * 37 + 5)));
  other.write(writer, to_cdr(messages::std_srvs::srv::SetBool::Request{true}));
  ASSERT_TRUE(wait([&] { return wire.take(100), asked > 0; }));
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(wire.statistics().received, 9u);
  EXPECT_EQ(wire.statistics().refused, 8u);
}

TEST(Wire, WhatComesInRingsTheBell) {
  Wire wire(options());
  const auto bell = std::make_shared<realtime::Bell>();
  wire.set_wakeup(bell);
  int taken = 0;
  wire.subscription("/n", "/chatter", type_info<messages::std_msgs::msg::Int32>(), {},
                    [&](std::span<const std::byte>) { return ++taken > 0; });
  Participant other(options());
  const auto writer = other.add_writer("rt/chatter", "std_msgs::msg::dds_::Int32_", {}, "");
  ASSERT_TRUE(wait([&] { return !other.matched(writer).empty(); }));
  for (int i = 1; i <= 20; ++i) {
    other.write(writer, to_cdr(messages::std_msgs::msg::Int32{i}));
    ASSERT_TRUE(bell->wait_until(realtime::monotonic_now() + 60'000'000'000)) << "nobody rang";
    EXPECT_EQ(wire.take(10), 1u);
    EXPECT_EQ(taken, i);
  }
}

TEST(Wire, WithoutDiscoveryNobodyIsFound) {
  ParticipantOptions off = options();
  off.discovery = false;
  Wire hidden(off);
  const auto publisher = hidden.publisher("/n", "/chatter", type_info<messages::std_msgs::msg::Int32>());
  serve_set_bool(hidden);
  Wire seen(options());
  const auto heard = seen.publisher("/n", "/chatter", type_info<messages::std_msgs::msg::Int32>());
  Participant other(options());
  const auto reader =
      other.add_reader("rt/chatter", "std_msgs::msg::dds_::Int32_", {}, "", [](const Sample&) {});
  ASSERT_TRUE(wait([&] { return seen.wanted(heard) && !other.matched(reader).empty(); }));
  EXPECT_EQ(other.matched(reader).size(), 1u);
  EXPECT_FALSE(hidden.wanted(publisher));
  EXPECT_EQ(hidden.participant().known(), 0u);
}

TEST(Wire, ATypeThatIsNotKnownIsRefused) {
  Wire wire(options());
  EXPECT_THROW(wire.service("/n", "/x", "std_srvs/srv/Nothing", {}), Error);
}

TEST(Wire, MoreThanIsTakenIsDroppedAndCounted) {
  Wire wire(options());
  int taken = 0;
  wire.subscription("/n", "/chatter", type_info<messages::std_msgs::msg::Int32>(), {true, false, 5000},
                    [&](std::span<const std::byte>) { return ++taken > 0; });
  Participant other(options());
  const auto writer = other.add_writer("rt/chatter", "std_msgs::msg::dds_::Int32_", {true, false, 5000}, "");
  ASSERT_TRUE(wait([&] { return !other.matched(writer).empty(); }));
  for (int i = 0; i < 1500; ++i) other.write(writer, to_cdr(messages::std_msgs::msg::Int32{i}));
  ASSERT_TRUE(wait([&] { return wire.statistics().received == 1500; }));
  while (wire.take(100) > 0) {
  }
  EXPECT_EQ(taken, 1000);
  EXPECT_EQ(wire.statistics().dropped, 500u);
}

TEST(Wire, AClientIsAnsweredByAServiceOnFastDds) {
  Wire asker(options());
  std::string heard;
  const auto client = asker.client("/asker", "/arm/switch/set", "std_srvs/srv/SetBool",
                                   [&](std::span<const std::byte> payload) {
                                     messages::std_srvs::srv::SetBool::Response reply;
                                     if (from_cdr(payload, reply) != messages::CdrError::none) return false;
                                     heard += reply.message;
                                     return true;
                                   });
  EXPECT_FALSE(asker.call(client, to_cdr(messages::std_srvs::srv::SetBool::Request{true})))
      << "nobody serves";
  Wire server(options());
  serve_set_bool(server);
  ASSERT_TRUE(wait([&] { return server.take(10), asker.ready(client); }));
  for (const bool data : {true, false, true}) {
    heard.clear();
    ASSERT_TRUE(asker.call(client, to_cdr(messages::std_srvs::srv::SetBool::Request{data})));
    ASSERT_TRUE(wait([&] { return server.take(10), asker.take(10), !heard.empty(); }));
    EXPECT_EQ(heard, data ? "on" : "off");
  }
}

TEST(Wire, WhatIsLargerThanAnyMessageIsRefused) {
  Wire wire(options());
  bool taken = false;
  wire.subscription("/n", "/chatter", type_info<messages::std_msgs::msg::String>(), {},
                    [&](std::span<const std::byte>) { return taken = true; });
  Participant other(options());
  const auto writer = other.add_writer("rt/chatter", "std_msgs::msg::dds_::String_", {}, "");
  ASSERT_TRUE(wait([&] { return !other.matched(writer).empty(); }));
  ASSERT_GT(other.write(writer, std::vector<std::byte>((16u << 20) + 5)), 0);
  ASSERT_TRUE(wait([&] { return wire.statistics().refused == 1; }));
  ASSERT_GT(other.write(writer, to_cdr(messages::std_msgs::msg::String{std::string(300'000, 'x')})), 0);
  EXPECT_TRUE(wait([&] { return wire.take(1), taken; })) << "one of many fragments is none too many";
}

TEST(Wire, AParticipantThatVanishesHoldsNobodyBackAndIsForgotten) {
  Wire wire(options());
  const auto publisher = wire.publisher("/n", "/chatter", type_info<messages::std_msgs::msg::Int32>());
  Process gone({"listen", std::to_string(own_domain())});
  ASSERT_TRUE(gone.has_output());
  ASSERT_TRUE(wait([&] { return wire.wanted(publisher); }));
  std::atomic<int> heard{0};
  Participant other(options());
  other.add_reader("rt/chatter", "std_msgs::msg::dds_::Int32_", {true, false, 5000}, "",
                   [&](const Sample&) { ++heard; });
  ASSERT_TRUE(wait([&] { return wire.participant().matched(publisher).size() == 2; }));
  gone.kill();
  for (int i = 0; i < 500; ++i) {
    wire.publish(publisher, to_cdr(messages::std_msgs::msg::Int32{i}));
    ASSERT_TRUE(wait([&] { return heard == i + 1; })) << i;
  }
  EXPECT_TRUE(wait([&] { return wire.participant().matched(publisher).size() == 1; })) << "after its lease";
}

std::size_t allocated() {
  return ::mallinfo2().uordblks;
}

TEST(Wire, AThousandClientsThatComeAndGoLeaveNothing) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "memory is not counted under a sanitizer";
#endif
  Wire wire(options());
  wire.publisher("/n", "/chatter", type_info<messages::std_msgs::msg::Int32>());
  serve_set_bool(wire);
  const auto come_and_go = [&](int each) {
    std::deque<Process> processes;
    for (int i = 0; i < 4; ++i)
      processes.emplace_back(
          std::vector<std::string>{"cycles", std::to_string(own_domain()), std::to_string(each)});
    for (Process& process : processes) {
      EXPECT_TRUE(process.ended_well());
      wire.take(1000);
    }
    EXPECT_TRUE(wait([&] { return wire.participant().known() == 0; }))
        << wire.participant().known() << " endpoints are still known";
  };
  come_and_go(25);
  const std::size_t before = allocated();
  come_and_go(250);
  EXPECT_LT(allocated(), before + 64 * 1024) << "of 1000 clients, nothing may stay";
}

TEST(Wire, WhatHumbleHasOtherwiseIsOtherwise) {
  Wire wire(options(), messages::Distribution::humble);
  wire.publisher("/arm/talker", "/chatter", type_info<messages::std_msgs::msg::String>());
  Participant other(options());
  std::mutex mutex;
  json graph;
  other.add_reader("ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
                   {true, true, 1}, "", [&](const Sample& sample) {
                     const std::lock_guard lock(mutex);
                     messages::to_json(*messages::find_type("rmw_dds_common/msg/ParticipantEntitiesInfo",
                                                            messages::Distribution::humble),
                                       sample.payload, graph);
                   });
  ASSERT_TRUE(wait([&] {
    wire.take(10);
    const std::lock_guard lock(mutex);
    return graph.is_object() && !graph["node_entities_info_seq"].empty();
  }));
  const std::lock_guard lock(mutex);
  EXPECT_EQ(graph["gid"]["data"].size(), 24u);
  EXPECT_EQ(graph["node_entities_info_seq"][0]["writer_gid_seq"][0]["data"].size(), 24u);
  EXPECT_EQ(graph["node_entities_info_seq"][0]["node_name"], "talker");
  const auto reader = other.add_reader("rt/chatter", "std_msgs::msg::dds_::String_", {}, "", {});
  ASSERT_TRUE(wait([&] { return !other.matched(reader).empty(); }));
  EXPECT_EQ(other.matched(reader).front().user_data.find("typehash"), std::string::npos);
}

#ifdef POLYARM_CYCLONE
using test::Cyclone;

/// The other way round: a service on Cyclone DDS, whose header says who asks.
TEST(WireAndCyclone, AClientIsAnsweredByAServiceOnCyclone) {
  Wire asker(options());
  const Cyclone cyclone(own_domain());
  const auto requests = cyclone.reader(std_srvs_srv_dds__SetBool_Request__desc, "rq/arm/switch/setRequest");
  const auto replies = cyclone.writer(std_srvs_srv_dds__SetBool_Response__desc, "rr/arm/switch/setReply");
  std::string heard;
  const auto client = asker.client("/asker", "/arm/switch/set", "std_srvs/srv/SetBool",
                                   [&](std::span<const std::byte> payload) {
                                     messages::std_srvs::srv::SetBool::Response reply;
                                     if (from_cdr(payload, reply) != messages::CdrError::none) return false;
                                     heard += reply.message;
                                     return true;
                                   });
  // As soon as it says that it is ready, not even the first call is lost.
  ASSERT_TRUE(wait([&] { return asker.ready(client); }));
  for (const bool data : {true, false, true}) {
    heard.clear();
    ASSERT_TRUE(asker.call(client, to_cdr(messages::std_srvs::srv::SetBool::Request{data})));
    ASSERT_TRUE(wait([&] {
      test::take<std_srvs_srv_dds__SetBool_Request_>(requests, [&](const auto& request) {
        std::string other = "for another", mine = request.data ? "on" : "off";
        std_srvs_srv_dds__SetBool_Response_ reply{request.guid + 1, request.number, true, other.data()};
        dds_write(replies, &reply);
        reply = {request.guid, request.number, true, mine.data()};
        dds_write(replies, &reply);
      });
      return asker.take(10), !heard.empty();
    }));
    EXPECT_EQ(heard, data ? "on" : "off");
  }
}

TEST(WireAndCyclone, TopicsGoBothWays) {
  Wire wire(options());
  messages::sensor_msgs::msg::JointState state;
  state.header.frame_id = "base";
  state.name = {"a", "bc"};
  state.position = {1.5, -2.5};
  const auto publisher = wire.publisher("/joint_state_broadcaster", "/joint_states",
                                        type_info<messages::sensor_msgs::msg::JointState>());
  std::string heard;
  wire.subscription("/listener", "/chatter", type_info<messages::std_msgs::msg::String>(), {},
                    [&](std::span<const std::byte> payload) {
                      messages::std_msgs::msg::String text;
                      if (from_cdr(payload, text) != messages::CdrError::none) return false;
                      heard = text.data;
                      return true;
                    });
  const Cyclone cyclone(own_domain());
  const auto reader = cyclone.reader(sensor_msgs_msg_dds__JointState__desc, "rt/joint_states");
  const auto writer = cyclone.writer(std_msgs_msg_dds__String__desc, "rt/chatter");
  bool read = false;
  std_msgs_msg_dds__String_ text{const_cast<char*>("hello")};
  EXPECT_TRUE(wait([&] {
    wire.publish(publisher, to_cdr(state));
    dds_write(writer, &text);
    wire.take(10);
    read = read || test::take<sensor_msgs_msg_dds__JointState_>(reader, [&](const auto& got) {
             EXPECT_STREQ(got.header.frame_id, "base");
             ASSERT_EQ(got.name._length, 2u);
             EXPECT_STREQ(got.name._buffer[1], "bc");
             ASSERT_EQ(got.position._length, 2u);
             EXPECT_EQ(got.position._buffer[1], -2.5);
             EXPECT_EQ(got.velocity._length, 0u);
           });
    return read && heard == "hello";
  }));
}

TEST(WireAndCyclone, AServiceAnswersWhoAskedAndHowOftenBesideClientsOfFastDds) {
  Wire wire(options());
  serve_set_bool(wire);
  FastClient fast(own_domain());
  const Cyclone cyclone(own_domain());
  const auto requests = cyclone.writer(std_srvs_srv_dds__SetBool_Request__desc, "rq/arm/switch/setRequest");
  const auto replies = cyclone.reader(std_srvs_srv_dds__SetBool_Response__desc, "rr/arm/switch/setReply");
  const auto matched = [&] {
    dds_publication_matched_status_t sent;
    dds_subscription_matched_status_t got;
    dds_get_publication_matched_status(requests, &sent);
    dds_get_subscription_matched_status(replies, &got);
    return sent.current_count > 0 && got.current_count > 0;
  };
  ASSERT_TRUE(wait([&] { return wire.take(10), fast.ready() && matched(); }));
  for (int i = 1; i <= 30; ++i) {
    fast.ask(i % 2 == 0);
    std_srvs_srv_dds__SetBool_Request_ request{0x1234567890abcdefull, i, i % 3 == 0};
    dds_write(requests, &request);
    bool answered = false;
    ASSERT_TRUE(wait([&] {
      wire.take(10);
      test::take<std_srvs_srv_dds__SetBool_Response_>(replies, [&](const auto& reply) {
        if (reply.guid != request.guid) return;  // it also hears what was meant for others
        EXPECT_EQ(reply.number, i);
        EXPECT_STREQ(reply.message, i % 3 == 0 ? "on" : "off");
        answered = true;
      });
      return answered && fast.mine == i;
    })) << i;
  }
  EXPECT_EQ(fast.received, 30);
}

TEST(WireAndCyclone, TheGraphNamesNodesWithWhatTheyHave) {
  Wire wire(options());
  const Cyclone cyclone(own_domain());
  const auto reader =
      cyclone.reader(rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc, "ros_discovery_info", true);
  serve_set_bool(wire);
  wire.publisher("/talker", "/chatter", type_info<messages::std_msgs::msg::String>());
  struct Seen {
    std::string space, name;
    std::size_t readers, writers;
    auto operator<=>(const Seen&) const = default;
  };
  std::vector<Seen> seen;
  const auto look = [&] {
    wire.take(10);
    test::take<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_>(reader, [&](const auto& info) {
      seen.clear();
      for (std::uint32_t i = 0; i < info.node_entities_info_seq._length; ++i) {
        const auto& node = info.node_entities_info_seq._buffer[i];
        seen.push_back(
            {node.node_namespace, node.node_name, node.reader_gid_seq._length, node.writer_gid_seq._length});
      }
    });
  };
  const std::vector<Seen> both{{"/arm", "switch", 1, 1}, {"/", "talker", 0, 1}};
  EXPECT_TRUE(wait([&] { return look(), seen == both; })) << seen.size();
  wire.remove_node("/talker");
  const std::vector<Seen> one{{"/arm", "switch", 1, 1}};
  EXPECT_TRUE(wait([&] { return look(), seen == one; })) << seen.size();
}
#endif

}  // namespace
}  // namespace polyarm::ros2
