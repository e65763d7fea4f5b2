/// Laws of plans, over random scenes of MoveIt's messages: what is planned is free, within limits and reaches
/// the goal.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/kinematics/random.hpp"
#include "polyarm/move_group/goals.hpp"
#include "polyarm/move_group/groups.hpp"
#include "polyarm/move_group/plans.hpp"
#include "polyarm/move_group/poses.hpp"

namespace polyarm::move_group {
namespace {

using Primitive = messages::shape_msgs::msg::SolidPrimitive;

/// An arm of the catalogue alone in the world.
class Cell {
 public:
  explicit Cell(const std::string& name)
      : model_(description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name)) {
    add_groups(model_, "arm", {});
    kinematics::Chain chain(model_, model_.tool_link());
    std::vector<trajectory::JointMotionLimits> limits(chain.joints(), {3, 12, 120});
    auto solver = std::make_unique<const ik::InverseKinematics>(chain);
    const std::vector<double> home(chain.joints(), 0.0);
    facts_ = std::make_unique<moves::RobotFacts>(moves::RobotFacts{
        "arm", &model_, std::move(chain), std::move(limits), {}, home, std::move(solver), {}, {}});
    Problems problems;
    surroundings::make_meshes(model_, tool_, "arm", problems);
    robots_.push_back({"arm", &model_, &tool_, -1, false, {}});
    scene_.floor = false;
    around_.arm = std::make_shared<const Arm>(*facts_, model_, 0);
    around_.bodies = {nullptr, &robots_, &scene_};
    around_.moment.robots.push_back({{}, home});
    around_.scene = std::make_shared<const SceneState>();
  }
  Cell(const Cell&) = delete;

  const kinematics::Chain& chain() const { return facts_->chain; }
  Around& around() { return around_; }
  std::vector<double> draw(kinematics::Random& random) const {
    std::vector<double> q;
    for (std::size_t j = 0; j < chain().joints(); ++j)
      q.push_back(std::clamp(kinematics::random_value(chain(), j, random), -2.5, 2.5));
    return q;
  }

 private:
  description::RobotModel model_;
  description::Tool tool_;
  std::unique_ptr<moves::RobotFacts> facts_;
  std::vector<surroundings::Robot> robots_;
  description::Scene scene_;
  Around around_;
};

msg::CollisionObject object(const std::string& id, std::uint8_t type, std::vector<double> sizes,
                            const Vec3& at) {
  msg::CollisionObject out;
  out.id = id;
  out.header.frame_id = "world";
  out.pose = to_message(Pose{at, from_rpy(0.3, -0.2, 0.7)});
  Primitive primitive;
  primitive.type = type;
  primitive.dimensions = std::move(sizes);
  out.primitives.push_back(std::move(primitive));
  return out;
}

msg::PlanningScene random_scene(kinematics::Random& random) {
  msg::PlanningScene out;
  out.is_diff = true;
  for (int i = 0; i < 5; ++i) {
    const auto size = [&] { return random.between(0.03, 0.25); };
    const double angle = random.between(-M_PI, M_PI), far = random.between(0.35, 0.8);
    const Vec3 at{far * std::cos(angle), far * std::sin(angle), random.between(-0.1, 0.8)};
    const auto type = static_cast<std::uint8_t>(1 + i % 4);
    std::vector<double> sizes{size(), size(), size()};
    if (type != Primitive::BOX) sizes.resize(type == Primitive::SPHERE ? 1 : 2);
    out.world.collision_objects.push_back(object("object " + std::to_string(i), type, std::move(sizes), at));
  }
  return out;
}

msg::Constraints joints_of(const Arm& arm, std::span<const double> q) {
  msg::Constraints out;
  for (std::size_t j = 0; j < q.size(); ++j)
    out.joint_constraints.push_back({arm.joints()[j], q[j], 1e-4, 1e-4, 1});
  return out;
}

msg::Constraints pose_of_tool(const Around& around, std::span<const double> q) {
  const int link = around.arm->group("arm").tip;
  const Pose pose = around.link_in_world(link, q);
  msg::PositionConstraint position;
  position.header.frame_id = "world";
  position.link_name = around.arm->link_name(link);
  Primitive ball;
  ball.type = Primitive::SPHERE;
  ball.dimensions = {1e-3};
  position.constraint_region.primitives.push_back(ball);
  position.constraint_region.primitive_poses.push_back(to_message(Pose{pose.position, {}}));
  msg::OrientationConstraint orientation;
  orientation.header.frame_id = "world";
  orientation.link_name = position.link_name;
  orientation.orientation = to_message(pose.rotation);
  orientation.absolute_x_axis_tolerance = orientation.absolute_y_axis_tolerance =
      orientation.absolute_z_axis_tolerance = 1e-2;
  msg::Constraints out;
  out.position_constraints.push_back(std::move(position));
  out.orientation_constraints.push_back(std::move(orientation));
  return out;
}

/// The smallest distance of a state by the exact shapes.
double distance_at(const Around& around, std::span<const double> q) {
  return compiled(around, q, 0)->probe().nearest(q).distance;
}

class Laws : public ::testing::TestWithParam<const char*> {};

TEST_P(Laws, PlansAreFreeWithinLimitsAndReachTheGoal) {
  Cell cell(GetParam());
  Around& around = cell.around();
  kinematics::Random random(11);
  int found = 0, touching = 0;
  for (int round = 0; round < 12; ++round) {
    std::vector<std::string> notes;
    around.scene = std::make_shared<const SceneState>();
    around.scene = std::make_shared<const SceneState>(applied(around, random_scene(random), notes));
    around.moment.robots[0].joints = cell.draw(random);
    const std::vector<double> goal = cell.draw(random);
    msg::MotionPlanRequest request;
    request.group_name = "arm";
    request.allowed_planning_time = 20;
    request.goal_constraints.push_back(round % 2 == 0 ? joints_of(*around.arm, goal)
                                                      : pose_of_tool(around, goal));
    const msg::MotionPlanResponse answer = plan(around, request, {});
    SCOPED_TRACE(std::to_string(round) + ": " + answer.error_code.message);
    if (answer.error_code.val == Code::START_STATE_IN_COLLISION) {
      EXPECT_LT(distance_at(around, around.joints()), 1e-3);
      ++touching;
      continue;
    }
    if (answer.error_code.val == Code::GOAL_IN_COLLISION && round % 2 == 0) {
      EXPECT_LT(distance_at(around, goal), 1e-3);
      ++touching;
      continue;
    }
    if (answer.error_code.val != Code::SUCCESS) continue;
    ++found;
    const auto judge = compiled(around, around.joints(), 0);
    const auto& points = answer.trajectory.joint_trajectory.points;
    ASSERT_FALSE(points.empty());
    EXPECT_EQ(points.front().positions, around.joints());
    EXPECT_EQ(Goal(around, request.goal_constraints.front()).violated(points.back().positions), "");
    for (const auto& point : points) {
      EXPECT_EQ(around.arm->outside_limits(point.positions), "");
      EXPECT_GT(judge->probe().nearest(point.positions).distance, 0);
      for (const double v : point.velocities) EXPECT_LE(std::abs(v), 3 + 1e-6);
    }
    EXPECT_NO_THROW(check_trajectory(around, answer.trajectory));
  }
  EXPECT_GE(found, 3);
  EXPECT_GE(touching, 1);
}

TEST_P(Laws, InverseOfForwardIsTheIdentityAndKeepsTheSeed) {
  Cell cell(GetParam());
  Around& around = cell.around();
  kinematics::Random random(5);
  for (int i = 0; i < 20; ++i) {
    const std::vector<double> q = cell.draw(random);
    around.moment.robots[0].joints = q;
    msg::PositionIKRequest request;
    request.group_name = "arm";
    request.pose_stamped.header.frame_id = "world";
    request.pose_stamped.pose = to_message(around.link_in_world(around.arm->group("arm").tip, q));
    const auto answer = solve_ik(around, request, {});
    ASSERT_EQ(answer.error_code.val, Code::SUCCESS) << answer.error_code.message;
    const Pose reached =
        around.link_in_world(around.arm->group("arm").tip, answer.solution.joint_state.position);
    EXPECT_LT(norm(reached.position - around.link_in_world(around.arm->group("arm").tip).position), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, Laws, ::testing::Values("universal_robots/ur5e", "franka/fr3"));

/// The scene that a client reads and sends back changes nothing.
TEST(Scenes, ReadBackAreTheSame) {
  Cell cell("universal_robots/ur5e");
  Around& around = cell.around();
  kinematics::Random random(3);
  std::vector<std::string> notes;
  around.scene = std::make_shared<const SceneState>(applied(around, random_scene(random), notes));
  const msg::PlanningScene read = to_message(around, 0);
  EXPECT_EQ(read.world.collision_objects.size(), 5u);
  Around again = around;
  again.scene = std::make_shared<const SceneState>(applied(around, read, notes));
  EXPECT_TRUE(notes.empty()) << notes.front();
  for (int i = 0; i < 50; ++i) {
    const std::vector<double> q = cell.draw(random);
    EXPECT_NEAR(distance_at(around, q), distance_at(again, q), 1e-9);
  }
}

TEST(Scenes, AMeshIsAsSolidAsItsBox) {
  Cell cell("universal_robots/ur5e");
  Around& around = cell.around();
  msg::CollisionObject box = object("box", Primitive::BOX, {0.4, 0.3, 0.2}, {0.5, 0.1, 0.3}), mesh = box;
  mesh.primitives.clear();
  mesh.meshes.emplace_back();
  for (int i = 0; i < 8; ++i)
    mesh.meshes[0].vertices.push_back({i & 1 ? 0.2 : -0.2, i & 2 ? 0.15 : -0.15, i & 4 ? 0.1 : -0.1});
  const std::uint32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  for (const auto& face : faces) mesh.meshes[0].triangles.push_back({{face[0], face[1], face[2]}});
  const auto with = [&](const msg::CollisionObject& one) {
    SceneState state;
    apply(around, one, state);
    Around out = around;
    out.scene = std::make_shared<const SceneState>(std::move(state));
    return out;
  };
  const Around of_box = with(box), of_mesh = with(mesh);
  kinematics::Random random(9);
  for (int i = 0; i < 50; ++i) {
    const std::vector<double> q = cell.draw(random);
    EXPECT_NEAR(distance_at(of_box, q), distance_at(of_mesh, q), 2e-3);
  }
}

}  // namespace
}  // namespace polyarm::move_group
