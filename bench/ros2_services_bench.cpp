/// Does a cell answer many callers of one service as soon as a plain server does, and how long does it take
/// until a long goal is accepted? The callers are processes with the DDS layer and the transports of
/// rmw_fastrtps. The peers are processes, too: plain servers on the same layer with the same type, which give
/// every caller the answer that the cell gave (so they do no work of their own), one of them with shared memory,
/// which the cell has not. Peers and cell take turns. What a network, rclcpp and rclpy add is not in
/// it. Needs idle cores; says the load beside. Arguments: callers, rounds (8, 3).
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "polyarm/messages/json.hpp"
#include "tests/ros2/rmw_fast.hpp"
#include "tests/support/command.hpp"

#ifdef POLYARM_RMW_FAST
namespace polyarm::ros2 {
namespace {

using nlohmann::json;
using test::Bytes;
using test::RmwNode;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kDomain = 102;
constexpr const char* kService = "/controller_manager/list_controllers";
/// With shared memory to its callers as rmw_fastrtps has it, and with UDP alone as the cell has it.
constexpr const char *kPeer = "/peer/list_controllers", *kUdpPeer = "/udp_peer/list_controllers";
constexpr const char* kType = "controller_manager_msgs/srv/ListControllers";
constexpr int kCalls = 200;
/// A reader has the replies to all callers; with the 10 of ROS 2 the plain server's own get lost among them.
constexpr int kDepth = 1000;

double milliseconds(Clock::duration d) {
  return std::chrono::duration<double, std::milli>(d).count();
}

double at(std::vector<double>& values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void report(const std::string& what, std::vector<double> values) {
  if (values.empty()) return static_cast<void>(std::printf("%-58s nothing measured\n", what.c_str()));
  std::printf("%-58s p50 %8.2f  p99 %8.2f  max %8.2f ms  (%zu)\n", what.c_str(), at(values, 0.5),
              at(values, 0.99), at(values, 1), values.size());
  std::fflush(stdout);
}

std::string dds_name(const std::string& type) {
  return messages::find_type(type)->dds_name;
}

template <class Until>
bool wait(Until until, int seconds = 20) {
  const auto end = Clock::now() + std::chrono::seconds(seconds);
  while (!until()) {
    if (Clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// A client as rcl has one: sleeps until its answer is there.
class Caller {
 public:
  Caller(RmwNode& node, const std::string& service, const std::string& type)
      : replies_{node.reader("rr" + service + "Reply", dds_name(type + "_Response"), false, true, kDepth)},
        requests_{node.writer("rq" + service + "Request", dds_name(type + "_Request"), kDepth)} {}
  bool ready() const {
    test::dds::PublicationMatchedStatus sent;
    test::dds::SubscriptionMatchedStatus got;
    requests_->get_publication_matched_status(sent);
    replies_->get_subscription_matched_status(got);
    return sent.current_count > 0 && got.current_count > 0;
  }
  std::optional<Bytes> call(Bytes request, int seconds = 10) {
    test::fast::WriteParams params;
    params.related_sample_identity().writer_guid(replies_->guid());
    requests_->write(&request, params);
    const auto asked = params.sample_identity().sequence_number();
    const auto end = Clock::now() + std::chrono::seconds(seconds);
    while (Clock::now() < end) {
      replies_->wait_for_unread_message({0, 200'000'000});
      test::dds::SampleInfo info;
      while (auto out = RmwNode::take(*replies_, &info)) {
        const auto& who = info.related_sample_identity.writer_guid();
        const bool mine = who == replies_->guid() || who == requests_->guid();
        if (mine && info.related_sample_identity.sequence_number() == asked) return out;
      }
    }
    return std::nullopt;
  }

 private:
  test::dds::DataReader* replies_;
  test::dds::DataWriter* requests_;
};

/// Work in a process of its own, which is killed when this ends.
class Process {
 public:
  explicit Process(const std::function<int()>& work) {
    std::fflush(stdout);
    pid_ = ::fork();
    if (pid_ == 0) ::_exit(work());
  }
  ~Process() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  void wait() { ::waitpid(std::exchange(pid_, 0), nullptr, 0); }
  pid_t number() const { return pid_; }

 private:
  pid_t pid_ = 0;
};

/// The plain server: takes a request, answers with `answer`.
int serve(const std::string& service, const Bytes& answer) {
  RmwNode node(kDomain, RmwNode::Range::localhost, nullptr, {}, service == kPeer);
  auto* requests =
      node.reader("rq" + service + "Request", dds_name(std::string(kType) + "_Request"), false, true, kDepth);
  auto* replies = node.writer("rr" + service + "Reply", dds_name(std::string(kType) + "_Response"), kDepth);
  for (;;) {
    requests->wait_for_unread_message({1, 0});
    test::dds::SampleInfo info;
    while (RmwNode::take(*requests, &info)) {
      test::fast::WriteParams params;
      auto& related = params.related_sample_identity();
      const auto& reader = info.related_sample_identity.writer_guid();
      related = info.sample_identity;
      if (reader != test::fast::c_Guid_Unknown) related.writer_guid(reader);
      Bytes out = answer;
      replies->write(&out, params);
    }
  }
}

struct ProcessorTime {
  double cell = 0, dds = 0, peers = 0;  ///< ms that these processes have used
};

/// Of the child of this process that is the cell, of the process that speaks DDS for it, and of `peers`.
ProcessorTime processor_time(const std::set<int>& peers = {}) {
  ProcessorTime out;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream in(entry.path() / "stat");
    std::string name, state;
    int pid = 0, parent = 0;
    if (!(in >> pid >> name >> state >> parent)) continue;
    std::string skipped;
    for (int i = 0; i < 9; ++i) in >> skipped;
    double user = 0, system = 0;
    in >> user >> system;
    const double used = 1e3 * (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
    if (name == "(polyarm)" && parent == ::getpid()) out.cell = used;
    if (name == "(polyarm_ros2_dd)") out.dds = used;
    if (peers.contains(pid)) out.peers += used;
  }
  return out;
}

/// So many calls one after the other; each caller begins when it sees the file `go`.
int call_often(const std::string& service, const std::filesystem::path& folder, int number) {
  RmwNode node(kDomain, RmwNode::Range::localhost);
  Caller caller(node, service, kType);
  if (!wait([&] { return caller.ready(); }))
    return std::fprintf(stderr, "caller %d finds no server\n", number);
  const Bytes request =
      messages::from_json(*messages::find_type(std::string(kType) + "_Request"), json::object());
  // A plain server may not know the reader of its first caller yet.
  if (!wait([&] { return caller.call(request, 1).has_value(); }))
    return std::fprintf(stderr, "caller %d is not answered\n", number);
  std::ofstream(folder / ("ready" + std::to_string(number)));
  if (!wait([&] { return std::filesystem::exists(folder / "go"); })) return 1;
  std::vector<double> taken;
  for (int i = 0; i < kCalls; ++i) {
    const auto begun = Clock::now();
    if (!caller.call(request)) return std::fprintf(stderr, "caller %d lost an answer\n", number);
    taken.push_back(milliseconds(Clock::now() - begun));
  }
  std::ofstream out(folder / ("times" + std::to_string(number)));
  for (const double ms : taken) out << ms << '\n';
  return 0;
}

std::vector<double> many_callers(const std::string& service, int callers) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("polyarm_callers_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::vector<std::unique_ptr<Process>> all;
  for (int i = 0; i < callers; ++i)
    all.push_back(std::make_unique<Process>([&, i] { return call_often(service, folder, i); }));
  wait([&] {
    for (int i = 0; i < callers; ++i)
      if (!std::filesystem::exists(folder / ("ready" + std::to_string(i)))) return false;
    return true;
  });
  std::ofstream(folder / "go").close();
  for (auto& process : all) process->wait();
  std::vector<double> out;
  for (int i = 0; i < callers; ++i) {
    std::ifstream in(folder / ("times" + std::to_string(i)));
    for (double ms = 0; in >> ms;) out.push_back(ms);
  }
  std::filesystem::remove_all(folder);
  return out;
}

Bytes goal_of(int number, int points) {
  json names = {"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
                "wrist_1_joint",      "wrist_2_joint",       "wrist_3_joint"};
  json list = json::array();
  for (int i = 1; i <= points; ++i) {
    std::vector<double> q(6), dq(6);
    for (int j = 0; j < 6; ++j) {
      q[static_cast<std::size_t>(j)] =
          (j == 1 ? -1.57 : 0.0) + 0.01 * std::sin(0.01 * i + j) - 0.01 * std::sin(j);
      dq[static_cast<std::size_t>(j)] = i == points ? 0 : 0.1 * std::cos(0.01 * i + j) * 0.1;
    }
    const double t = 1 + 0.01 * i;
    list.push_back({{"positions", q},
                    {"velocities", dq},
                    {"time_from_start",
                     {{"sec", static_cast<int>(t)}, {"nanosec", static_cast<int>(std::fmod(t, 1) * 1e9)}}}});
  }
  std::vector<int> uuid(16, 3);
  uuid[0] = number % 256, uuid[1] = points % 256;
  return messages::from_json(
      *messages::find_type("control_msgs/action/FollowJointTrajectory_SendGoal_Request"),
      {{"goal_id", {{"uuid", uuid}}},
       {"goal", {{"trajectory", {{"joint_names", names}, {"points", list}}}}}});
}

/// From the sending of a goal to the answer that it is accepted.
void goals(int points, const std::function<std::string()>& cell_says) {
  std::vector<double> taken;
  const ProcessorTime before = processor_time();
  const auto since = Clock::now();
  Process process([&] {
    RmwNode node(kDomain, RmwNode::Range::localhost);
    Caller caller(node, "/arm_controller/follow_joint_trajectory/_action/send_goal",
                  "control_msgs/action/FollowJointTrajectory_SendGoal");
    if (!wait([&] { return caller.ready(); })) return 1;
    std::vector<Bytes> all;
    for (int i = 0; i < 12; ++i) all.push_back(goal_of(i, points));
    int refused = 0;
    for (Bytes& goal : all) {
      const auto begun = Clock::now();
      const auto answer = caller.call(std::move(goal));
      if (!answer || answer->size() < 5 || (*answer)[4] != std::byte{1})
        ++refused;
      else
        taken.push_back(milliseconds(Clock::now() - begun));
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    report("a goal of " + std::to_string(points) + " points is accepted", taken);
    if (refused > 0) std::printf("  refused: %d; the cell says:\n%s\n", refused, cell_says().c_str());
    std::fflush(stdout);
    return 0;
  });
  process.wait();
  const ProcessorTime after = processor_time();
  std::printf("  processor time of the cell and of its DDS process: %.0f + %.0f ms in %.0f ms\n",
              after.cell - before.cell, after.dds - before.dds, milliseconds(Clock::now() - since));
  std::fflush(stdout);
}

int run(int callers, int rounds) {
  double load[1] = {0};
  ::getloadavg(load, 1);
  std::printf("load %.1f\n", load[0]);
  ::setenv("ROS_DOMAIN_ID", std::to_string(kDomain).c_str(), 1);
  const auto folder =
      std::filesystem::temp_directory_path() / ("polyarm_services_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "cell.yaml")
      << "polyarm: cell/1\nrate: 500\nrobots:\n  arm: {model: "
         "universal_robots/ur5e, hardware: mock}\ncontrollers: controllers.yaml\n";
  std::ofstream(folder / "controllers.yaml")
      << "controller_manager:\n  ros__parameters:\n"
         "    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}\n"
         "    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}\n"
         "arm_controller:\n  ros__parameters:\n    joints: [shoulder_pan_joint, shoulder_lift_joint, "
         "elbow_joint, "
         "wrist_1_joint, wrist_2_joint, wrist_3_joint]\n    command_interfaces: [position]\n"
         "    state_interfaces: [position, velocity]\n";
  {
    polyarm::test::Command cell({"run", folder.string(), "--ros2", "--no-socket"});
    if (!cell.wait_for("ROS 2: domain")) return 1;
    // The answer of the cell becomes the peer's.
    const auto file = folder / "answer";
    Process asking([&] {
      RmwNode node(kDomain, RmwNode::Range::localhost);
      Caller caller(node, kService, kType);
      if (!wait([&] { return caller.ready(); })) return 1;
      const auto answer = caller.call(
          messages::from_json(*messages::find_type(std::string(kType) + "_Request"), json::object()));
      if (answer)
        std::ofstream(file, std::ios::binary)
            .write(reinterpret_cast<const char*>(answer->data()),
                   static_cast<std::streamsize>(answer->size()));
      return 0;
    });
    asking.wait();
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    const Bytes answer(begin, begin + text.size());
    std::printf("answers of %zu bytes\n", answer.size());
    const Process peer([&] { return serve(kPeer, answer); }),
        udp_peer([&] { return serve(kUdpPeer, answer); });
    std::map<std::string, std::vector<double>> all;
    for (int round = 0; round < rounds; ++round) {
      for (const char* service : {kPeer, kUdpPeer, kService}) {
        const ProcessorTime before = processor_time({peer.number(), udp_peer.number()});
        const std::vector<double> taken = many_callers(service, callers);
        const ProcessorTime after = processor_time({peer.number(), udp_peer.number()});
        all[service].insert(all[service].end(), taken.begin(), taken.end());
        report(
            "round " + std::to_string(round + 1) + ", " + std::to_string(callers) + " callers of " + service,
            taken);
        std::printf("  processor time: plain servers %.0f, cell %.0f, its DDS process %.0f ms\n",
                    after.peers - before.peers, after.cell - before.cell, after.dds - before.dds);
      }
    }
    report(std::to_string(callers) + " callers, a plain server with shared memory", all[kPeer]);
    report(std::to_string(callers) + " callers, a plain server over UDP", all[kUdpPeer]);
    report(std::to_string(callers) + " callers, the cell", all[kService]);
    if (!all[kService].empty() && !all[kPeer].empty() && !all[kUdpPeer].empty())
      std::printf("the cell's p50 is %.2f and %.2f times those of the plain servers\n",
                  at(all[kService], 0.5) / at(all[kPeer], 0.5),
                  at(all[kService], 0.5) / at(all[kUdpPeer], 0.5));
    std::fflush(stdout);
    for (const int points : {10, 1000, 5000}) goals(points, [&] { return cell.line_with("refused"); });
  }
  std::filesystem::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace polyarm::ros2

int main(int argc, char** argv) {
  return polyarm::ros2::run(argc > 1 ? std::atoi(argv[1]) : 8, argc > 2 ? std::atoi(argv[2]) : 3);
}
#else
int main() {
  std::puts("needs Fast DDS 2");
  return 1;
}
#endif
