/// DDS in a process of its own: what is there when it has ended, and what one that has been taken over can
/// do.
#include <gtest/gtest.h>

#include <optional>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/ros2/remote_participant.hpp"
#include "polyarm/ros2/wire.hpp"
#include "tests/ros2/client.hpp"
#include "tests/ros2/domain.hpp"
#include "tests/ros2/process.hpp"

namespace polyarm::ros2::remote_tests {
namespace {

using messages::from_cdr;
using messages::to_cdr;
using messages::type_info;
using test::wait;
using Int32 = messages::std_msgs::msg::Int32;
using String = messages::std_msgs::msg::String;
using SetBool = messages::std_srvs::srv::SetBool;

constexpr const char* kInt32 = "std_msgs::msg::dds_::Int32_";
constexpr const char* kString = "std_msgs::msg::dds_::String_";

ParticipantOptions options() {
  ParticipantOptions out;
  out.domain = test::own_domain();
  return out;
}

/// What the kernel says of a process: "NoNewPrivs" → "1".
std::string status_of(int process, const std::string& key) {
  std::ifstream file("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(key + ":")) return line.substr(line.find_first_not_of(" \t", key.size() + 1));
  return "";
}
bool is_there(int process) {
  const std::string state = status_of(process, "State");
  return !state.empty() && state[0] != 'Z' && state[0] != 'X';
}

TEST(RemoteParticipant, EndedByWhateverItIsStartedAgainWithAllThatThereWas) {
  Wire wire(options());
  const auto latched = wire.publisher("/n", "/text", type_info<String>(), {true, true, 2});
  const auto counter = wire.publisher("/n", "/count", type_info<Int32>());
  int heard = 0;
  wire.subscription("/n", "/ask", type_info<Int32>(), {}, [&](std::span<const std::byte> payload) {
    Int32 got;
    if (from_cdr(payload, got) != messages::CdrError::none) return false;
    heard = got.data;
    return true;
  });
  wire.service("/n", "/set", "std_srvs/srv/SetBool", [](Wire::Request request) {
    SetBool::Request asked;
    if (from_cdr(request.payload, asked) != messages::CdrError::none) return false;
    request.answer(to_cdr(SetBool::Response{asked.data, "served"}));
    return true;
  });
  for (const char* text : {"one", "two", "three"}) wire.publish(latched, to_cdr(String{text}));
  int last = 0;
  for (int round = 1; round <= 3; ++round) {
    const int process = wire.participant().process();
    ASSERT_GT(process, 0);
    ASSERT_NE(process, last);
    last = process;
    const Guid prefix = wire.participant().prefix();
    ASSERT_EQ(::kill(process, round == 1 ? SIGABRT : SIGKILL), 0);
    std::vector<RemoteReport> news;
    ASSERT_TRUE(wait([&] {
      wire.take(10);
      for (RemoteReport& each : wire.take_reports()) news.push_back(std::move(each));
      return wire.participant().statistics().losses == static_cast<std::uint64_t>(round) &&
             wire.participant().settled();
    }));
    EXPECT_NE(wire.participant().prefix(), prefix) << "others must not take it for the old one";
    EXPECT_EQ(wire.participant().missing_for().count(), 0);
    if (round == 1) {
      ASSERT_EQ(news.size(), 2u);
      EXPECT_NE(news[0].what.find("was ended by SIGABRT"), std::string::npos) << news[0].what;
      EXPECT_FALSE(news[0].good);
      EXPECT_NE(news[1].what.find("is back after"), std::string::npos) << news[1].what;
    } else {
      EXPECT_TRUE(news.empty()) << "said once a minute";
    }
    // Somebody new finds everything, and what was latched.
    Participant other(options());
    std::mutex mutex;
    std::vector<std::string> texts;
    test::json graph;
    other.add_reader("rt/text", kString, {true, true, 10}, "", [&](const Sample& sample) {
      const std::lock_guard lock(mutex);
      String got;
      if (from_cdr(sample.payload, got) == messages::CdrError::none) texts.push_back(got.data);
    });
    other.add_reader("ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
                     {true, true, 1}, "", [&](const Sample& sample) {
                       const std::lock_guard lock(mutex);
                       messages::to_json(*messages::find_type("rmw_dds_common/msg/ParticipantEntitiesInfo"),
                                         sample.payload, graph);
                     });
    const auto counts = other.add_reader("rt/count", kInt32, {}, "", [](const Sample&) {});
    const auto asks = other.add_writer("rt/ask", kInt32, {}, "");
    EXPECT_TRUE(wait([&] {
      wire.take(10);
      const std::lock_guard lock(mutex);
      return texts.size() == 2 && graph.is_object() && graph["node_entities_info_seq"].size() == 1;
    }));
    {
      const std::lock_guard lock(mutex);
      EXPECT_EQ(texts, (std::vector<std::string>{"two", "three"}));
      const Guid now = wire.participant().prefix();
      EXPECT_EQ(graph["gid"]["data"], test::json(std::vector<int>(now.begin(), now.end())));
    }
    ASSERT_TRUE(wait([&] { return wire.wanted(counter) && !other.matched(asks).empty(); }));
    EXPECT_EQ(other.matched(counts).size(), 1u);
    other.write(asks, to_cdr(Int32{round}));
    EXPECT_TRUE(wait([&] { return wire.take(10), heard == round; }));
    test::Client client(options().domain);
    std::atomic<bool> over{false};
    std::thread serving([&] {
      while (!over) wire.wait(std::chrono::milliseconds(1)), wire.take(10);
    });
    EXPECT_EQ(client.call("/set", "std_srvs/srv/SetBool", {{"data", true}})["message"], "served");
    over = true;
    serving.join();
  }
}

TEST(RemoteParticipant, ACallOfOursAfterALossIsAnswered) {
  Wire asker(options()), server(options());
  server.service("/n", "/set", "std_srvs/srv/SetBool", [](Wire::Request request) {
    request.answer(to_cdr(SetBool::Response{true, "served"}));
    return true;
  });
  int answers = 0;
  const auto client = asker.client("/asker", "/set", "std_srvs/srv/SetBool",
                                   [&](std::span<const std::byte>) { return ++answers > 0; });
  const auto serve = [&] { server.take(10), asker.take(10); };
  for (int round = 1; round <= 3; ++round) {
    ASSERT_TRUE(wait([&] { return serve(), asker.ready(client); }));
    for (int i = 0; i < 5; ++i) {
      const int before = answers;
      ASSERT_TRUE(asker.call(client, to_cdr(SetBool::Request{true})));
      ASSERT_TRUE(wait([&] { return serve(), answers == before + 1; })) << round << " " << i;
    }
    if (round == 3) break;
    Wire& lost = round == 1 ? asker : server;
    const int process = lost.participant().process();
    ASSERT_GT(process, 0);  // 0 would be all of us
    ASSERT_EQ(::kill(process, SIGKILL), 0);
    ASSERT_TRUE(wait([&] {
      serve();
      return lost.participant().statistics().losses == 1 && lost.participant().settled();
    }));
    const Guid anew = server.participant().prefix();
    ASSERT_TRUE(wait([&] {
      serve();
      for (const Remote& remote : asker.participant().matched(client))
        if (std::equal(anew.begin(), anew.begin() + 12, remote.guid.begin())) return true;
      return false;
    }));
  }
}

TEST(RemoteParticipant, TheProcessHasNoRightsAndNoDescriptorsOfOurs) {
  int secret[2];
  ASSERT_EQ(::pipe(secret), 0);
  const RemoteParticipant remote(options());
  const int process = remote.process();
  EXPECT_EQ(status_of(process, "NoNewPrivs"), "1");
  EXPECT_EQ(status_of(process, "Seccomp"), "2") << "its calls are filtered";
  const std::filesystem::path folder = "/proc/" + std::to_string(process) + "/fd";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::error_code error;
    const std::string to = std::filesystem::read_symlink(entry.path(), error).string();
    const bool own = to == "/dev/null" || to.starts_with("socket:") || to.starts_with("anon_inode:") ||
                     to.find("memfd:polyarm") != std::string::npos || to.starts_with("/dev/shm") ||
                     entry.path().filename() == "2";  // a pipe to us
    EXPECT_TRUE(own) << entry.path() << " is " << to;
  }
  ::close(secret[0]);
  ::close(secret[1]);
}

TEST(RemoteParticipant, ItEndsWithTheProcessThatStartedIt) {
  test::Process owner({"wire", std::to_string(options().domain)});
  const int process = owner.number();
  ASSERT_GT(process, 0);
  EXPECT_TRUE(is_there(process));
  owner.kill();
  EXPECT_TRUE(wait([&] { return !is_there(process); }));
}

TEST(RemoteParticipant, WhereItCannotBeStartedItIsSaidWhatIsMissing) {
  const auto refusal = [](RemoteOptions remote) -> std::string {
    try {
      RemoteParticipant participant(options(), std::move(remote));
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  RemoteOptions missing;
  missing.program = "/no/such/program";
  EXPECT_NE(refusal(missing).find("/no/such/program cannot be started"), std::string::npos);
  RemoteOptions other;
  other.program = "/bin/false";
  EXPECT_NE(refusal(other).find("ended with code 1"), std::string::npos) << refusal(other);
  RemoteOptions mute;
  mute.program = POLYARM_ROS2_CLIENT;
  mute.words = {"rotten", "silent"};
  mute.patience = std::chrono::milliseconds(300);
  EXPECT_NE(refusal(mute).find("sent nothing for"), std::string::npos) << refusal(mute);
}

/// The cell's side of a process that says what it likes: it goes on, holds little, and starts it anew.
class Rotten : public ::testing::TestWithParam<const char*> {};

TEST_P(Rotten, DoesNothingButEnd) {
  RemoteOptions rotten;
  rotten.program = POLYARM_ROS2_CLIENT;
  rotten.words = {"rotten", GetParam()};
  rotten.first_pause = rotten.longest_pause = std::chrono::milliseconds(1);
  rotten.patience = std::chrono::milliseconds(500);
  const std::size_t before = ::mallinfo2().uordblks;
  std::optional<RemoteParticipant> opened;
  for (int attempt = 0; attempt < 200 && !opened; ++attempt) {
    try {
      opened.emplace(options(), rotten);
    } catch (const Error& e) {  // it broke the rules before it was ready: refused, and another is started
      ASSERT_NE(std::string(e.what()).find("broke the rules"), std::string::npos) << e.what();
    }
  }
  ASSERT_TRUE(opened) << "it never becomes ready";
  RemoteParticipant& remote = *opened;
  std::atomic<std::uint64_t> taken{0};
  std::vector<RemoteParticipant::Id> ids;
  for (int i = 0; i < 5; ++i) {
    ids.push_back(remote.add_writer("rt/t", "T", {true, true, 3}, "", false));
    ids.push_back(remote.add_reader("rt/t", "T", {}, "",
                                    [&](const Sample& sample) { taken += sample.payload.size(); }));
  }
  const std::vector<std::byte> payload(1000);
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(3);
  while (std::chrono::steady_clock::now() < until) {
    for (const auto id : ids) {
      remote.write(id, payload);
      remote.guid(id);
      remote.matched(id);
    }
    remote.take_reports();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const std::string how = GetParam();
  if (how == "noise" || how == "memory" || how == "frozen") {
    EXPECT_GT(remote.statistics().losses, 0u);
  }
  if (how == "lies") {
    EXPECT_GT(taken, 0u) << "what is well-formed arrives, whatever it says";
  }
  EXPECT_LE(remote.known(), bounds::kRemoteEndpoints);
#if !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(::mallinfo2().uordblks, before + (80u << 20));
#endif
}
INSTANTIATE_TEST_SUITE_P(, Rotten, ::testing::Values("noise", "lies", "flood", "memory", "frozen"));

}  // namespace
}  // namespace polyarm::ros2::remote_tests
