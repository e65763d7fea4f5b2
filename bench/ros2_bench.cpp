/// What does the ROS 2 door cost, and how soon does it act? The command runs a UR5e on the mock at 1 kHz,
/// clients on Fast DDS sit in this process, all on one machine: what a network or another middleware adds is
/// not in it. Times are of the system's clock, which stamps are told in. Needs two idle cores; says the load
/// beside. With a word, that part alone: write, start, see, latency, late.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "polyarm/messages/types.hpp"
#include "polyarm/ros2/wire.hpp"
#include "tests/ros2/client.hpp"
#include "tests/support/command.hpp"
#ifdef POLYARM_CYCLONE
#include "messages.h"
#include "tests/ros2/cyclone.hpp"
#endif

namespace polyarm::ros2 {
namespace {

using test::Client;
using test::json;
using test::wait;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kDomain = 101;
const char* const kJoints =
    "[shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint, wrist_2_joint, wrist_3_joint]";

double milliseconds(Clock::duration d) {
  return std::chrono::duration<double, std::milli>(d).count();
}

void report(const char* what, const char* unit, std::vector<double> values) {
  if (values.empty()) return static_cast<void>(std::printf("%-58s nothing measured\n", what));
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  std::printf("%-58s p50 %8.2f  p99 %8.2f  max %8.2f %s  (%zu)\n", what, at(0.5), at(0.99), at(1), unit,
              values.size());
}

ParticipantOptions options() {
  ParticipantOptions out;
  out.domain = kDomain;
  return out;
}

class Cell {
 public:
  explicit Cell(std::vector<std::string> more = {"--ros2"}, double rate = 1000) {
    ::setenv("ROS_DOMAIN_ID", std::to_string(kDomain).c_str(), 1);
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "cell.yaml")
        << "polyarm: cell/1\nrate: " << rate
        << "\nrobots:\n  arm: {model: "
           "universal_robots/ur5e, hardware: mock}\ncontrollers: controllers.yaml\n";
    std::ofstream(folder_ / "controllers.yaml")
        << "controller_manager:\n  ros__parameters:\n"
           "    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}\n"
           "    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}\n"
           "arm_controller:\n  ros__parameters:\n    joints: "
        << kJoints << "\n    command_interfaces: [position]\n    state_interfaces: [position, velocity]\n";
    more.insert(more.begin(), {"run", folder_.string(), "--no-socket", "--json"});
    command_ = std::make_unique<polyarm::test::Command>(more);
  }
  ~Cell() {
    command_.reset();
    std::filesystem::remove_all(folder_);
  }
  polyarm::test::Command& command() { return *command_; }

 private:
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("polyarm_ros2_bench_" + std::to_string(::getpid()));
  std::unique_ptr<polyarm::test::Command> command_;
};

messages::sensor_msgs::msg::JointState joint_state() {
  messages::sensor_msgs::msg::JointState out;
  out.name = {"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
              "wrist_1_joint",      "wrist_2_joint",       "wrist_3_joint"};
  for (auto* list : {&out.position, &out.velocity, &out.effort}) list->resize(6);
  return out;
}

/// On the thread that sends, at 1 kHz.
void write_cost(std::size_t readers) {
  const auto& type = messages::type_info<messages::sensor_msgs::msg::JointState>();
  Participant ours(options());
  const auto writer = ours.add_writer("rt/joint_states", type.dds_name, {}, "");
  std::vector<std::unique_ptr<Participant>> others;
  for (std::size_t i = 0; i < readers; ++i) {
    others.push_back(std::make_unique<Participant>(options()));
    others.back()->add_reader("rt/joint_states", type.dds_name, {}, "", [](const Sample&) {});
  }
  if (!wait([&] { return ours.matched(writer).size() == readers; })) return;
  const auto payload = messages::to_cdr(joint_state());
  std::vector<double> taken;
  auto next = Clock::now();
  for (int i = 0; i < 3000; ++i) {
    std::this_thread::sleep_until(next += std::chrono::milliseconds(1));
    const auto begun = Clock::now();
    ours.write(writer, payload);
    taken.push_back(1e3 * milliseconds(Clock::now() - begun));
  }
  report(("write of joint states, " + std::to_string(readers) + " readers").c_str(), "us", taken);
}

void start_cost() {
  std::vector<double> taken;
  for (int i = 0; i < 10; ++i) {
    const auto begun = Clock::now();
    Wire wire(options());
    for (int k = 0; k < 40; ++k)
      wire.service("/n", "/n/s" + std::to_string(k), "std_srvs/srv/Trigger",
                   [](Wire::Request) { return true; });
    wire.take(1);
    taken.push_back(milliseconds(Clock::now() - begun));
  }
  report("a participant with 40 services", "ms", taken);
}

/// From the birth of a client to the graph that names a controller's node.
void time_to_see() {
  const Cell cell;
  std::vector<double> taken;
  for (int i = 0; i < 20; ++i) {
    const auto begun = Clock::now();
    Client client(kDomain);
    std::mutex mutex;
    json graph;
    const auto& type = messages::type_info<messages::rmw_dds_common::msg::ParticipantEntitiesInfo>();
    const auto reader = client.participant().add_reader("ros_discovery_info", type.dds_name, {true, true, 1},
                                                        "", [&](const Sample& sample) {
                                                          const std::lock_guard lock(mutex);
                                                          messages::to_json(type, sample.payload, graph);
                                                        });
    const auto seen = [&] {
      const std::lock_guard lock(mutex);
      const json& latest = graph;
      if (!latest.is_object()) return false;
      for (const json& node : latest["node_entities_info_seq"])
        if (node["node_name"] == "arm_controller") return true;
      return false;
    };
    if (wait(seen) && i > 0) taken.push_back(milliseconds(Clock::now() - begun));
    client.participant().remove(reader);
  }
  report("until a client sees a node", "ms", taken);
}

#ifdef POLYARM_CYCLONE
/// The same on Cyclone DDS, and until a service can be asked.
void time_to_see_on_cyclone() {
  const Cell cell;
  std::vector<double> seen, ready;
  for (int i = 0; i < 20; ++i) {
    const auto begun = Clock::now();
    const test::Cyclone cyclone(kDomain);
    const auto graph =
        cyclone.reader(rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc, "ros_discovery_info", true);
    const test::CycloneCaller<controller_manager_msgs_srv_dds__SwitchController_Request_,
                              controller_manager_msgs_srv_dds__SwitchController_Response_>
        caller(cyclone, "/controller_manager/switch_controller",
               controller_manager_msgs_srv_dds__SwitchController_Request__desc,
               controller_manager_msgs_srv_dds__SwitchController_Response__desc);
    const auto named = [&] {
      bool out = false;
      test::take<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_>(graph, [&](const auto& info) {
        for (std::uint32_t k = 0; k < info.node_entities_info_seq._length; ++k)
          out = out || info.node_entities_info_seq._buffer[k].node_name == std::string("arm_controller");
      });
      return out;
    };
    if (wait(named)) seen.push_back(milliseconds(Clock::now() - begun));
    if (wait([&] { return caller.ready(); })) ready.push_back(milliseconds(Clock::now() - begun));
  }
  report("until a client on Cyclone sees a node", "ms", seen);
  report("  until it can ask a service", "ms", ready);
}
#endif

double stamp_ms(const json& sample) {
  const json& stamp = sample["header"]["stamp"];
  return 1e3 * stamp["sec"].get<double>() + 1e-6 * stamp["nanosec"].get<double>();
}

/// From the publishing of a trajectory to the cycle that commands its beginning, which a later state tells:
/// its stamp less how far the trajectory is, which is a period in its first cycle. Beside it, the wait for
/// the next cycle from that moment on, on the grid that stamps lie on: the least that any loop can need. The
/// rate is one whose cycles wander past the cell's ticks, so that stamps are not late by where they happen to
/// lie.
void trajectory_latency() {
  constexpr double kRate = 990, kPeriod = 1e3 / kRate;
  const Cell cell({"--ros2"}, kRate);
  Client client(kDomain);
  const auto state =
      client.listen("/arm_controller/controller_state", "control_msgs/JointTrajectoryControllerState");
  const auto publisher =
      client.publish("/arm_controller/joint_trajectory", "trajectory_msgs/JointTrajectory");
  if (!wait([&] { return state->heard() && publisher->matched(); })) return;
  std::vector<double> taken, waits, above;
  for (int i = 0; i < 300; ++i) {
    const json still = state->latest()["reference"]["positions"];
    std::vector<double> there(6);
    for (std::size_t k = 0; k < 6; ++k) there[k] = still[k].get<double>() + (i % 2 == 0 ? 0.01 : -0.01);
    json names = json::array();
    for (const auto& name : joint_state().name) names.push_back(name);
    const json message{{"joint_names", names},
                       {"points", json::array({{{"positions", there}, {"time_from_start", 0.02}}})}};
    const std::size_t before = state->count();
    const auto since = std::chrono::system_clock::now().time_since_epoch();
    const double now = std::chrono::duration<double, std::milli>(since).count();
    publisher->publish(message);
    json moved;
    const bool found = wait(
        [&] {
          for (const json& sample : state->since(before))
            if (sample["reference"]["positions"] != still) return moved = sample, true;
          return false;
        },
        2);
    if (!found) continue;
    const json& into = moved["reference"]["time_from_start"];
    const double begun =
        stamp_ms(moved) - 1e3 * into["sec"].get<double>() - 1e-6 * into["nanosec"].get<double>() + kPeriod;
    taken.push_back(begun - now);
    waits.push_back(std::fmod(std::fmod(taken.back(), kPeriod) + kPeriod, kPeriod));
    above.push_back((taken.back() - waits.back()) / kPeriod);
    std::this_thread::sleep_for(std::chrono::microseconds(40'000 + i * 7919 % 3000));
  }
  report("published trajectory to the first command", "ms", taken);
  report("  the wait for the next cycle from then on", "ms", waits);
  report("  cycles missed", "  ", above);
}

void late_cycles(const char* what, bool ros2, std::size_t subscribers) {
  std::vector<std::string> more{"--seconds", "15"};
  if (ros2) more.emplace_back("--ros2");
  Cell cell(more);
  const auto& type = messages::type_info<messages::sensor_msgs::msg::JointState>();
  Participant client(options());
  for (std::size_t i = 0; i < subscribers; ++i)
    client.add_reader("rt/joint_states", type.dds_name, {}, "", [](const Sample&) {});
  const json result = cell.command().wait().result();
  std::printf("%-58s %d late, an empty loop beside it %d\n", what, result.value("late_cycles", -1),
              result.value("late_cycles_empty_loop", -1));
}

}  // namespace
}  // namespace polyarm::ros2

int main(int argc, char** argv) {
  using namespace polyarm::ros2;
  const std::string only = argc > 1 ? argv[1] : "";
  const auto wanted = [&](const char* part) { return only.empty() || only == part; };
  double load[1] = {0};
  ::getloadavg(load, 1);
  std::printf("load %.1f\n", load[0]);
  if (wanted("write"))
    for (const std::size_t readers : {0u, 1u, 5u}) write_cost(readers);
  if (wanted("start")) start_cost();
  if (wanted("see")) time_to_see();
#ifdef POLYARM_CYCLONE
  if (wanted("see")) time_to_see_on_cyclone();
#endif
  if (wanted("latency")) trajectory_latency();
  if (!wanted("late")) return 0;
  late_cycles("late cycles without the door", false, 0);
  late_cycles("late cycles, 20 subscribers of joint states at 1 kHz", true, 20);
}
