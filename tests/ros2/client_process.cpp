/// Clients in a process of their own, for tests that kill it or have many of them come and go.
///   listen DOMAIN           hears /chatter, says so on its output, and stays
///   goal DOMAIN ACTION JSON sends a goal of FollowJointTrajectory, says that it was accepted, and stays
///   cycles DOMAIN COUNT     joins, is matched on /chatter and a service, and leaves, so often
///   wire DOMAIN             has a wire, says so, and stays
///   rotten HOW PARENT       stands for polyarm_ros2_dds and does not keep to the rules
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <random>
#include <string>

#include "polyarm/participant/dds_exchange.hpp"
#include "polyarm/process/channel.hpp"
#include "polyarm/ros2/wire.hpp"
#include "tests/ros2/client.hpp"

namespace polyarm::ros2::test {
namespace {

constexpr const char* kInt32 = "std_msgs::msg::dds_::Int32_";

ParticipantOptions in(std::uint32_t domain) {
  ParticipantOptions out;
  out.domain = domain;
  return out;
}

[[noreturn]] void say_and_stay() {
  std::cout << '!' << std::flush;
  for (;;) ::pause();
}

int listen(std::uint32_t domain) {
  Participant participant(in(domain));
  const auto reader = participant.add_reader("rt/chatter", kInt32, {}, "", [](const Sample&) {});
  if (!wait([&] { return !participant.matched(reader).empty(); })) return 1;
  say_and_stay();
}

int goal(std::uint32_t domain, const std::string& action, const std::string& message) {
  Client client(domain);
  const json answer = client.call(action + "/_action/send_goal",
                                  "control_msgs/action/FollowJointTrajectory_SendGoal", json::parse(message));
  if (!answer["accepted"].get<bool>()) return 1;
  say_and_stay();
}

bool is_matched_once(std::uint32_t domain) {
  Participant participant(in(domain));
  const auto reader = participant.add_reader("rt/chatter", kInt32, {}, "", [](const Sample&) {});
  const auto writer =
      participant.add_writer("rq/arm/switch/setRequest", "std_srvs::srv::dds_::SetBool_Request_", {}, "");
  return wait([&] { return !participant.matched(reader).empty() && !participant.matched(writer).empty(); });
}

/// Each in a process of its own: who joins twice from one process has the same guid again.
int cycles(std::uint32_t domain, int count) {
  for (int i = 0; i < count; ++i) {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(is_matched_once(domain) ? 0 : 1);
    int status = -1;
    ::waitpid(child, &status, 0);
    if (status != 0) return 1;
  }
  return 0;
}

int wire(std::uint32_t domain) {
  const Wire wire(in(domain));
  std::cout << wire.participant().process() << std::endl;
  say_and_stay();
}

/// As one whom a packet has made its own: says that it is ready, then whatever it likes.
int rotten(const std::string& how) {
  process::Channel channel{process::Channel::Inherited{}};
  std::mt19937 random(8);
  std::vector<std::byte> message;
  const auto send = [&](DdsReport news, auto fill) {
    process::Packer out(message);
    out.number(static_cast<std::uint8_t>(news));
    fill(out);
    channel.send(message, true);
  };
  if (how == "silent")
    for (;;) ::pause();
  send(DdsReport::ready, [](process::Packer& out) { out.array(Guid{1, 0x0f, 7}); });
  if (how == "frozen")
    for (;;) ::pause();
  const auto noise = [&](std::size_t most) {
    std::vector<std::byte> out(random() % most);
    for (std::byte& byte : out) byte = static_cast<std::byte>(random());
    return out;
  };
  if (how == "memory") {  // over all that is shared
    constexpr std::size_t kSize = 4096 + (2 << 20);
    auto* words = static_cast<std::uint32_t*>(
        ::mmap(nullptr, kSize, PROT_READ | PROT_WRITE, MAP_SHARED, process::kMemoryOfChild, 0));
    for (;; channel.beat())
      for (std::size_t i = 0; i < kSize / 4; i += 1 + random() % 64)
        words[i] = static_cast<std::uint32_t>(random());
  }
  for (std::uint64_t i = 0;; ++i) {
    channel.beat();
    const auto id = static_cast<std::uint64_t>(how == "lies" ? random() % 12 : random());
    Guid guid;
    for (auto& byte : guid) byte = static_cast<std::uint8_t>(random());
    if (how == "noise")  // of every number that there is, and some that there are not
      send(static_cast<DdsReport>(random() % 14), [&](process::Packer& out) { out.rest(noise(300)); });
    else if (how == "flood")  // endpoints without end
      send(DdsReport::known, [&](process::Packer& out) {
        out.array(guid).text(std::string(kMostUserData, 'x')).text("rt/t").text("T");
      });
    else  // well-formed
      send(i % 2 == 0 ? DdsReport::matched : DdsReport::sample, [&](process::Packer& out) {
        out.number(id).array(guid);
        if (i % 2 == 0) out.number(random() % 3 != 0);
        if (i % 2 == 1) out.number(std::int64_t{-5}).array(guid).number(std::int64_t{-1}).rest(noise(200));
      });
    std::vector<std::byte> order;
    while (channel.receive(order) == process::Channel::Received::message) {
    }
    if (channel.broken()) return 1;
    if (how != "noise" && random() % 200 == 0) channel.wait(1);
  }
}

}  // namespace
}  // namespace polyarm::ros2::test

int main(int argc, char** argv) {
  using namespace polyarm::ros2::test;
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() < 2) return 2;
  if (words[0] == "rotten") return rotten(words[1]);
  const auto domain = static_cast<std::uint32_t>(std::stoul(words[1]));
  if (words[0] == "listen") return listen(domain);
  if (words[0] == "wire") return wire(domain);
  if (words[0] == "goal" && words.size() == 4) return goal(domain, words[2], words[3]);
  if (words[0] == "cycles" && words.size() == 3) return cycles(domain, std::stoi(words[2]));
  return 2;
}
