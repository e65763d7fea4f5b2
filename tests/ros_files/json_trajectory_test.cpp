#include "polyarm/ros_files/json_trajectory.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "polyarm/ros_files/message_forms.hpp"

namespace polyarm::ros_files::json_trajectory_test {
namespace {

using controllers::TrajectoryMessage;
using nlohmann::json;

const std::vector<std::string> kTypes{"trajectory_msgs/JointTrajectory"},
    kGoals{"control_msgs/FollowJointTrajectory"};

json trajectory(int points) {
  json out{{"joint_names", {"a", "b"}}, {"points", json::array()}};
  for (int i = 0; i < points; ++i)
    out["points"].push_back({{"positions", {0.1 * i, 1e-3 / 3 * i}},
                             {"velocities", {1.0 / 7, -2}},
                             {"time_from_start", {{"sec", i / 10}, {"nanosec", i % 10 * 100'000'000}}}});
  return out;
}

void expect_equal(const TrajectoryMessage& a, const TrajectoryMessage& b) {
  EXPECT_EQ(a.start, b.start);
  EXPECT_EQ(a.joints, b.joints);
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].positions, b.points[i].positions) << i;
    EXPECT_EQ(a.points[i].velocities, b.points[i].velocities) << i;
    EXPECT_EQ(a.points[i].accelerations, b.points[i].accelerations) << i;
    EXPECT_EQ(a.points[i].effort, b.points[i].effort) << i;
    EXPECT_EQ(a.points[i].time_from_start, b.points[i].time_from_start) << i;
  }
  EXPECT_EQ(a.path_tolerance.size(), b.path_tolerance.size());
  EXPECT_EQ(a.goal_time_tolerance, b.goal_time_tolerance);
}

TEST(JsonTrajectory, ReadsWhatTheTextSays) {
  json plain = trajectory(40), goal{{"trajectory", trajectory(40)},
                                    {"path_tolerance", {{{"name", "a"}, {"position", 0.1}}}},
                                    {"goal_time_tolerance", {{"sec", 2}, {"nanosec", 0}}}};
  plain["header"] = {{"stamp", {{"sec", 3}, {"nanosec", 5}}}, {"frame_id", ""}};
  const json wrapped{{"goal", goal}};
  for (const auto& [message, types] : {std::pair{plain, kTypes}, {goal, kGoals}, {wrapped, kGoals}}) {
    const auto fast = read_json_trajectory(message, "m", types);
    ASSERT_TRUE(fast) << message.dump().substr(0, 80);
    expect_equal(std::get<TrajectoryMessage>(*fast),
                 std::get<TrajectoryMessage>(read_message(message.dump(), "m", types)));
  }
}

TEST(JsonTrajectory, LeavesToTheTextWhatIsShortOrOdd) {
  EXPECT_FALSE(read_json_trajectory(trajectory(3), "m", kTypes));
  EXPECT_FALSE(read_json_trajectory("joint_names: [a]", "m", kTypes));
  EXPECT_FALSE(read_json_trajectory(json{{"data", {1, 2}}}, "m", kTypes));
  for (const auto& [key, value] : {std::pair<const char*, json>{"positions", {nullptr, 1}},
                                   {"positions", "x"},
                                   {"velocities", {"fast", 1}},
                                   {"time_from_start", "soon"},
                                   {"time_from_start", {{"sec", 1}}},
                                   {"colour", 1}}) {
    json odd = trajectory(40);
    odd["points"][20][key] = value;
    EXPECT_FALSE(read_json_trajectory(odd, "m", kTypes)) << key;
  }
  json untimed = trajectory(40);
  untimed["points"][7].erase("time_from_start");
  EXPECT_FALSE(read_json_trajectory(untimed, "m", kTypes));
  json misspelled = trajectory(40);
  misspelled["joint_name"] = misspelled["joint_names"];
  EXPECT_THROW(read_json_trajectory(misspelled, "m", kTypes), Error);
}

// The text took 400 ms and more; a goal of this length is to be accepted within 50.
TEST(JsonTrajectory, FiveThousandPointsTakeNoTimeToSpeakOf) {
  const json goal{{"trajectory", trajectory(5000)}};
  auto best = std::chrono::nanoseconds::max();
  for (int i = 0; i < 5; ++i) {
    const auto before = std::chrono::steady_clock::now();
    ASSERT_TRUE(read_json_trajectory(goal, "m", kGoals));
    best = std::min<std::chrono::nanoseconds>(best, std::chrono::steady_clock::now() - before);
  }
  EXPECT_LT(best, std::chrono::milliseconds(50));
}

}  // namespace
}  // namespace polyarm::ros_files::json_trajectory_test
