/// Mutated RTPS packets at the ports of a cell whose robot moves. They end the process that speaks DDS, again
/// and again (Debian's Fast DDS 2.9.1 aborts on one in some thousands); the cell's own process, its program
/// and its trajectories take no notice, and who comes afterwards finds the cell as ever.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/ros2/client.hpp"
#include "tests/ros2/domain.hpp"
#include "tests/ros2/rtps_fuzz.hpp"
#include "tests/support/command.hpp"

namespace polyarm::ros2::attack_tests {
namespace {

using polyarm::test::Command;
using polyarm::test::Finished;
using test::Client;
using test::json;
using test::kSubmessages;
using test::RtpsFuzz;
using test::wait;

class Attack : public ::testing::Test {
 protected:
  Attack() {
    ::setenv("ROS_DOMAIN_ID", std::to_string(domain_).c_str(), 1);
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "work.data") << "Name: Repeat\nBool: True\n";
    std::ofstream(folder_ / "job.script") << "load work\nwhile Repeat\n"
                                             "  movej joints(10deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"
                                             "  movej joints(0deg, -90deg, 20deg, 0deg, 0deg, 0deg)\nend\n";
    std::ofstream(folder_ / "cell.yaml")
        << "polyarm: cell/1\nrobots:\n  arm: {model: " POLYARM_SOURCE_DIR
           "/examples/r6bot/r6bot.urdf, hardware: mock}\nprogram: job\ncontrollers: controllers.yaml\n";
    std::ofstream(folder_ / "controllers.yaml")
        << "controller_manager:\n  ros__parameters:\n    update_rate: 500\n"
           "    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}\n"
           "    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}\n"
           "arm_controller:\n  ros__parameters:\n    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, "
           "joint_6]\n"
           "    command_interfaces: [position]\n    state_interfaces: [position, velocity]\n";
  }
  ~Attack() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  std::vector<std::string> run(std::vector<std::string> more) const {
    more.insert(more.begin(), {"run", folder_.string(), "--no-socket", "--json"});
    return more;
  }
  std::uint16_t port(int index) const {
    return static_cast<std::uint16_t>(7400 + 250 * domain_ + 10 + index);
  }

  /// Prefixes and endpoints of the cell, as somebody new on the graph learns them.
  RtpsFuzz fuzz(std::uint32_t seed) const {
    Client client(domain_);
    std::vector<RtpsFuzz::Prefix> known;
    std::vector<RtpsFuzz::Entity> entities;
    const auto learn = [&](const Guid& guid) {
      RtpsFuzz::Prefix prefix;
      RtpsFuzz::Entity entity;
      std::copy(guid.begin(), guid.begin() + 12, prefix.begin());
      std::copy(guid.begin() + 12, guid.end(), entity.begin());
      known.push_back(prefix);
      entities.push_back(entity);
    };
    const auto states = client.participant().add_reader(
        "rt/joint_states", "sensor_msgs::msg::dds_::JointState_", {}, "", [](const Sample&) {});
    const auto asks = client.participant().add_writer(
        "rq/controller_manager/list_controllersRequest",
        "controller_manager_msgs::srv::dds_::ListControllers_Request_", {}, "");
    wait(
        [&] {
          return !client.participant().matched(states).empty() && !client.participant().matched(asks).empty();
        },
        8);
    for (const auto id : {states, asks}) {
      learn(client.participant().guid(id));
      for (const Remote& remote : client.participant().matched(id)) learn(remote.guid);
    }
    return RtpsFuzz(seed, known, entities);
  }

  /// Sends so many packets that somebody was there for; gives up after so long.
  std::size_t attack(std::size_t packets, std::chrono::seconds most) {
    const test::Datagrams discovery(port(0)), user(port(1));
    const auto end = std::chrono::steady_clock::now() + most;
    std::size_t sent = 0;
    for (std::uint32_t seed = 1; sent < packets && std::chrono::steady_clock::now() < end; ++seed) {
      RtpsFuzz packet = fuzz(seed);
      for (std::size_t i = 0; i < 10'000 && sent < packets && std::chrono::steady_clock::now() < end;) {
        const auto bytes = packet.packet(kSubmessages[i % kSubmessages.size()]);
        if (!(i % 3 == 0 ? user : discovery).send(bytes)) {
          std::this_thread::sleep_for(std::chrono::milliseconds(20));  // it is being started again
          continue;
        }
        ++sent, ++i;
        if (i % 16 == 0) std::this_thread::sleep_for(std::chrono::microseconds(300));
      }
    }
    return sent;
  }

  /// The one that the cell of this folder has started; 0 where there is none.
  int process_of_dds() const {
    const auto text = [](const std::string& file) {
      const std::ifstream in(file);
      std::ostringstream out;
      out << in.rdbuf();  // of a process that ends meanwhile: what was read so far
      return out.str();
    };
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator("/proc", error)) {
      const int process = std::atoi(entry.path().filename().c_str());
      if (process <= 0 || text(entry.path().string() + "/comm") != "polyarm_ros2_dd\n") continue;
      const std::string status = text(entry.path().string() + "/status");
      const std::size_t at = status.find("PPid:");
      if (at == std::string::npos || status.find("State:\tZ") != std::string::npos) continue;
      const int parent = std::atoi(status.c_str() + at + 5);
      if (text("/proc/" + std::to_string(parent) + "/cmdline").find(folder_.string()) != std::string::npos)
        return process;
    }
    return 0;
  }

  void expect_served() {
    Client client(domain_);
    std::set<std::string> names;
    const json listed =
        client.call("/controller_manager/list_controllers", "controller_manager_msgs/srv/ListControllers");
    for (const json& controller : listed["controller"]) names.insert(controller["name"]);
    EXPECT_TRUE(names.contains("arm_controller")) << listed;
    const auto states = client.listen("/joint_states", "sensor_msgs/JointState");
    ASSERT_TRUE(wait([&] { return states->heard(); }));
    const json first = states->latest()["position"];
    EXPECT_TRUE(wait([&] { return states->latest()["position"] != first; })) << "it stands still";
  }

  const std::uint32_t domain_ = test::own_domain();
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("polyarm_ros2_attack_" + std::to_string(::getpid()));
};

TEST_F(Attack, AHundredThousandMutatedPacketsEndNoCell) {
  Command command(run({"--ros2"}));
  ASSERT_TRUE(command.wait_for("ROS 2: domain")) << command.wait().output;
  expect_served();
  EXPECT_EQ(attack(100'000, std::chrono::seconds(300)), 100'000u);
  expect_served();
  command.signal(SIGINT);
  const Finished& finished = command.wait();
  const json result = finished.result();
  EXPECT_EQ(result["result"], "stopped") << finished.output.substr(0, 2000);
  EXPECT_EQ(result["error"], nullptr);
  EXPECT_GT(result.value("program_cycles", 0), 3) << "the program has gone on";
  EXPECT_LE(result["stops"].size(), 1u) << result["stops"];
  EXPECT_NE(finished.output.find("(polyarm_ros2_dds) was ended by SIGABRT"), std::string::npos)
      << "no packet met what it was meant for: this test shows nothing";
  EXPECT_NE(finished.output.find("ROS 2 is back after"), std::string::npos);
}

TEST_F(Attack, KilledUnderARobotThatMovesItComesBackAndTheProgramGoesOn) {
  Command command(run({"--ros2"}));
  ASSERT_TRUE(command.wait_for("ROS 2: domain")) << command.wait().output;
  for (int last = 0, round = 0; round < 3; ++round) {
    int process = 0;
    ASSERT_TRUE(wait([&] { return (process = process_of_dds()) != 0 && process != last; }));
    last = process;
    expect_served();
    ASSERT_EQ(::kill(process, SIGKILL), 0);
  }
  expect_served();
  command.signal(SIGINT);
  const Finished& finished = command.wait();
  EXPECT_EQ(finished.result()["result"], "stopped") << finished.output.substr(0, 2000);
  EXPECT_EQ(finished.result()["error"], nullptr);
  EXPECT_NE(finished.output.find("(polyarm_ros2_dds) was ended by SIGKILL"), std::string::npos);
  EXPECT_NE(finished.output.find("ROS 2 is back after"), std::string::npos);
}

TEST_F(Attack, StoppedUnderARobotThatMovesItIsReportedAndStartedAgain) {
  Command command(run({"--ros2"}));
  ASSERT_TRUE(command.wait_for("ROS 2: domain")) << command.wait().output;
  expect_served();
  const int process = process_of_dds();
  ASSERT_EQ(::kill(process, SIGSTOP), 0);
  ASSERT_TRUE(wait([&] {
    const int now = process_of_dds();
    return now != 0 && now != process;
  }));
  expect_served();
  command.signal(SIGINT);
  const Finished& finished = command.wait();
  EXPECT_EQ(finished.result()["result"], "stopped") << finished.output.substr(0, 2000);
  EXPECT_EQ(finished.result()["error"], nullptr);
  EXPECT_LE(finished.result()["stops"].size(), 1u) << finished.result()["stops"];
  EXPECT_NE(finished.output.find("(polyarm_ros2_dds) hangs: it sent nothing for 1.0 s, and was ended"),
            std::string::npos)
      << finished.output.substr(0, 4000);
  EXPECT_NE(finished.output.find("ROS 2 is back after"), std::string::npos);
}

TEST_F(Attack, ATrajectoryIsTheSameBitForBitWithAndWithout) {
  const std::vector<std::string> fast{"--ros2", "--fast", "--cycles", "150"};
  const json quiet = Command(run(fast)).wait().result();
  ASSERT_EQ(quiet["result"], "completed") << quiet;
  Command command(run(fast));
  ASSERT_TRUE(command.wait_for("ROS 2: domain")) << command.wait().output;
  std::atomic<bool> over{false};
  std::size_t sent = 0;
  std::thread attacker([&] {
    RtpsFuzz packet(99, {}, {});
    const test::Datagrams discovery(port(0));
    for (std::size_t i = 0; !over; ++i) {
      sent += discovery.send(packet.packet(kSubmessages[i % kSubmessages.size()])) ? 1 : 0;
      if (i % 16 == 0) std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
  });
  const json attacked = command.wait().result();
  over = true;
  attacker.join();
  EXPECT_GT(sent, 1000u);
  EXPECT_EQ(attacked["result"], "completed") << attacked;
  EXPECT_EQ(attacked["trace_hash"], quiet["trace_hash"]);
  EXPECT_EQ(attacked["sim_time_s"], quiet["sim_time_s"]);
}

}  // namespace
}  // namespace polyarm::ros2::attack_tests
