/// Clients in a process of their own, for tests that kill it or have many of them come and go.
///   listen DOMAIN           hears /chatter, says so on its output, and stays
///   goal DOMAIN ACTION JSON sends a goal of FollowJointTrajectory, says that it was accepted, and stays
///   cycles DOMAIN COUNT     joins, is matched on /chatter and a service, and leaves, so often
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <string>

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

}  // namespace
}  // namespace polyarm::ros2::test

int main(int argc, char** argv) {
  using namespace polyarm::ros2::test;
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() < 2) return 2;
  const auto domain = static_cast<std::uint32_t>(std::stoul(words[1]));
  if (words[0] == "listen") return listen(domain);
  if (words[0] == "goal" && words.size() == 4) return goal(domain, words[2], words[3]);
  if (words[0] == "cycles" && words.size() == 3) return cycles(domain, std::stoi(words[2]));
  return 2;
}
