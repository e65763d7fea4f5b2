/// Nodes of plugins on the graph: a package in ROS's style is built without ROS, and a client of the graph
/// hears its topics, publishes to it and calls its service.
#include <gtest/gtest.h>
#include <unistd.h>

#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/messages/cdr.hpp"
#include "tests/ros2/client.hpp"
#include "tests/ros2/domain.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::ros2 {
namespace {

namespace fs = std::filesystem;

/// What the package's own message says; its type is known to the package only.
struct WearListener {
  WearListener(Participant& participant, const std::string& topic) : participant_{participant} {
    id_ = participant.add_reader("rt" + topic, "two_joints::msg::dds_::Wear_", {}, "",
                                 [this](const Sample& sample) {
                                   messages::CdrReader in(sample.payload);
                                   std::int32_t seconds = 0;
                                   std::uint32_t rest = 0;
                                   std::string frame;
                                   in.read(seconds), in.read(rest), in.read(frame);
                                   std::vector<double> turns(in.read_length(sizeof(double)));
                                   in.read_all(std::span<double>(turns));
                                   std::uint8_t state = 9;
                                   in.read(state);
                                   in.finish();
                                   const std::lock_guard lock(mutex_);
                                   if (!in || turns.size() != 2) return void(broken = true);
                                   latest_ = turns[0], state_ = state, heard_ = true;
                                 });
  }
  ~WearListener() { participant_.remove(id_); }
  bool heard() const {
    const std::lock_guard lock(mutex_);
    return heard_;
  }
  bool says(double turns, int state) const {
    const std::lock_guard lock(mutex_);
    return heard_ && latest_ == turns && state_ == state;
  }
  bool broken = false;

 private:
  Participant& participant_;
  Participant::Id id_;
  mutable std::mutex mutex_;
  double latest_ = 0;
  int state_ = 9;
  bool heard_ = false;
};

TEST(PluginNodes, AreOnTheGraphWithTheirTopicsAndServices) {
  polyarm::test::Folder place;
  for (const char* name : {"CONFIG", "DATA", "CACHE"})
    ::setenv((std::string("XDG_") + name + "_HOME").c_str(), (place.path() / name).c_str(), 1);
  ::setenv("CMAKE_BUILD_TYPE", "None", 1);
  const fs::path package = fs::path(POLYARM_SOURCE_DIR) / "tests/ros_packages/two_joints";
  const auto built = polyarm::test::run_command({"plugin", "build", package.string(), "--simulated"});
  ASSERT_EQ(built.exit_code, 0) << built.output;
  place.write("cell/cell.yaml",
              "polyarm: cell/1\nrate: 100\nrobots: {arm: {model: robot.urdf, hardware: declared}}\n");
  place.write("cell/robot.urdf", read_file(package / "robot.urdf"));

  const std::uint32_t domain = test::own_domain();
  ::setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), 1);
  polyarm::test::Command command({"run", (place.path() / "cell").string(), "--ros2", "--no-socket"});
  ASSERT_TRUE(command.wait_for("ROS 2: domain")) << command.wait().output;
  test::Client client(domain);

  WearListener wear(client.participant(), "/two_joints/wear");
  EXPECT_TRUE(test::wait([&] { return wear.heard(); }));
  EXPECT_TRUE(wear.says(0, 0));

  const auto turns = client.publish("/two_joints/set_turns", "std_msgs/msg/Float64");
  ASSERT_TRUE(test::wait([&] { return turns->matched(); }));
  EXPECT_TRUE(test::wait([&] {  // the plugin's subscription is of best effort: the first messages may be lost
    turns->publish({{"data", 7.5}});
    return wear.says(7.5, 1);
  }));
  // A topic with an absolute name; its last message is kept for those who come later.
  const auto last = client.listen("/last_turns", "std_msgs/msg/Float64", {true, true, 1});
  EXPECT_TRUE(test::wait([&] { return last->heard(); }));
  EXPECT_EQ(last->latest()["data"], 7.5);

  const auto answer = client.call("/two_joints/reset", "std_srvs/srv/Trigger");
  EXPECT_EQ(answer["success"], true);
  EXPECT_EQ(answer["message"], "as new");
  EXPECT_TRUE(test::wait([&] { return wear.says(0, 0); }));
  EXPECT_FALSE(wear.broken);
}

}  // namespace
}  // namespace polyarm::ros2
