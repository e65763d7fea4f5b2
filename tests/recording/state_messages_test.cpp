#include "polyarm/recording/state_messages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "polyarm/messages/json.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::recording {
namespace {

const std::filesystem::path kRobot = std::filesystem::path(POLYARM_SOURCE_DIR) / "examples/r6bot/r6bot.urdf";

TEST(StateMessages, SayTheStatesOfACycleByName) {
  test::LockStepCell bench(kRobot, std::string());
  test::OpenCell& cell = bench.cell();
  StateMessages messages(cell.robots(), cell.loop().table());
  std::vector<double> states(cell.loop().table().states().size());
  for (std::size_t i = 0; i < states.size(); ++i) states[i] = 0.01 * static_cast<double>(i);
  const auto& joints = messages.joint_states(states, 3'000'000'007);
  EXPECT_EQ(joints.header.stamp.sec, 3);
  EXPECT_EQ(joints.header.stamp.nanosec, 7u);
  const description::RobotModel& model = cell.robots()[0]->model;
  ASSERT_EQ(joints.name, model.joint_names());
  for (std::size_t j = 0; j < joints.name.size(); ++j)
    EXPECT_EQ(joints.position[j],
              states[*cell.loop().table().find_state("arm/" + joints.name[j] + "/position")]);
}

TEST(StateMessages, FramesLeadToWhereTheKinematicsSayTheToolIs) {
  test::LockStepCell bench(kRobot, std::string());
  test::OpenCell& cell = bench.cell();
  const cell::CellRobot& robot = *cell.robots()[0];
  StateMessages messages(cell.robots(), cell.loop().table());
  std::vector<double> states(cell.loop().table().states().size(), 0.0), q;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    q.push_back(0.3 - 0.2 * static_cast<double>(j));
    states[*cell.loop().table().find_state(robot.joints[j].name + "/position")] = q.back();
  }
  std::map<std::string, messages::geometry_msgs::msg::TransformStamped> by_child;
  for (const auto* list : {&messages.fixed_frames(), &messages.moving_frames(states, 5)})
    for (const auto& one : list->transforms)
      EXPECT_TRUE(by_child.emplace(one.child_frame_id, one).second) << "a frame has one parent";
  const description::Link& flange = robot.model.links[static_cast<std::size_t>(robot.model.tool_link())];
  Pose seen;
  std::string frame = flange.name;
  for (; by_child.contains(frame); frame = by_child[frame].header.frame_id) {
    const auto& t = by_child[frame].transform;
    seen = Pose{{t.translation.x, t.translation.y, t.translation.z},
                {t.rotation.x, t.rotation.y, t.rotation.z, t.rotation.w}} *
           seen;
  }
  EXPECT_EQ(frame, "world");
  const Pose told = robot.facts->chain.forward(q) * inverse(robot.tool.tcp);
  EXPECT_LT(norm(seen.position - told.position), 1e-12);
  EXPECT_LT(angle_between(seen.rotation, told.rotation), 1e-9);
}

TEST(StateMessages, AJointThatIsNotMeasuredStandsAtZeroInTheFramesAndIsNoNumberInTheStates) {
  test::LockStepCell bench(kRobot, std::string());
  test::OpenCell& cell = bench.cell();
  StateMessages messages(cell.robots(), cell.loop().table());
  const std::vector<double> nothing;
  for (const auto& one : messages.moving_frames(nothing, 0).transforms)
    EXPECT_TRUE(std::isfinite(one.transform.rotation.w)) << one.child_frame_id;
  for (const double q : messages.joint_states(nothing, 0).position) EXPECT_TRUE(std::isnan(q));
}

TEST(StateMessages, SeveralRobotsAreToldApart) {
  test::Folder folder;
  const std::string cell_yaml =
      folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  left: {model: " + kRobot.string() +
                                    ", hardware: mock}\n  right: {model: " + kRobot.string() +
                                    ", hardware: mock, xyz: [0, 1, 0]}\n");
  test::LockStepCell bench(cell::read_cell_file(cell_yaml));
  StateMessages messages(bench.cell().robots(), bench.cell().loop().table());
  std::set<std::string> joints, frames;
  for (const std::string& name : messages.joint_states({}, 0).name) joints.insert(name);
  EXPECT_TRUE(joints.contains("left/joint_1") && joints.contains("right/joint_1"));
  for (const auto* list : {&messages.fixed_frames(), &messages.moving_frames({}, 0)})
    for (const auto& one : list->transforms) EXPECT_TRUE(frames.insert(one.child_frame_id).second);
}

}  // namespace
}  // namespace polyarm::recording
