/// What a cell takes from its description beside joints: transmissions, states of its SRDF, a reload.
#include <gtest/gtest.h>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/check.hpp"
#include "polyarm/setup/floor.hpp"
#include "polyarm/setup/robots.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::Folder;
using test::Json;
using test::LockStepCell;

const std::string kControllers = R"(
controller_manager:
  ros__parameters:
    update_rate: 1000
    follow: {type: forward_command_controller/ForwardCommandController}
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
follow:
  ros__parameters:
    joints: [a, b]
    interface_name: position
)";

std::string description(const std::string& parameters, const std::string& more = "",
                        const std::string& interfaces = "<state_interface name='position'/>") {
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child) {
    return "<joint name='" + name + "' type='revolute'><parent link='" + parent + "'/><child link='" + child +
           "'/><axis xyz='0 0 1'/><limit lower='-2' upper='2' velocity='100' effort='10'/></joint>";
  };
  const auto driven = [&](const std::string& name) {
    return "<joint name='" + name + "'><command_interface name='position'/>" + interfaces + "</joint>";
  };
  return "<robot name='arm'><link name='l0'/><link name='l1'/><link name='l2'/>" + joint("a", "l0", "l1") +
         joint("b", "l1", "l2") +
         "<ros2_control name='drives' "
         "type='system'><hardware><plugin>mock_components/GenericSystem</plugin>" +
         parameters + "</hardware>" + driven("a") + driven("b") + more + "</ros2_control></robot>";
}

double command(LockStepCell& cell, double a, double b) {
  cell.result({{"request", "send"},
               {"to", "follow"},
               {"message", "data: [" + std::to_string(a) + ", " + std::to_string(b) + "]"}});
  cell.run(0.5);
  return cell.value_of("states", "arm/a/position");
}

TEST(Description, TheToolHangsOnTheLinkThatTheCellNames) {
  const Folder folder;
  folder.write("arm.urdf", description(""));
  Problems problems;
  std::vector<std::string> notes;
  const auto robots_with = [&](const std::string& tip) {
    const auto file =
        folder.write("cell.yaml", "polyarm: cell/1\nrobots: {arm: {model: arm.urdf, tip: " + tip + "}}\n");
    return cell::resolve_robots(cell::read_cell_file(file), description::Catalogue({}), false, problems,
                                notes);
  };
  const cell::CellRobots robots = robots_with("l1");
  ASSERT_FALSE(problems.has_errors());
  EXPECT_TRUE(robots.front()->facts->chain.moves_tcp(0));
  EXPECT_FALSE(robots.front()->facts->chain.moves_tcp(1)) << "b moves l2 alone";
  robots_with("l11");
  ASSERT_TRUE(problems.has_errors());
  EXPECT_NE(problems.list().back().text().find("did you mean 'l1'"), std::string::npos);
}

TEST(Description, JointsArePlayedThroughTheirTransmissions) {
  const Folder folder;
  const std::string four_bar =
      "<transmission name='wrist'><plugin>transmission_interface/FourBarLinkageTransmission</plugin>"
      "<actuator name='m1' role='actuator1'><mechanical_reduction>40</mechanical_reduction></actuator>"
      "<actuator name='m2' role='actuator2'><mechanical_reduction>-20</mechanical_reduction></actuator>"
      "<joint name='a' role='joint1'><mechanical_reduction>1.5</mechanical_reduction><offset>0.2</offset>"
      "</joint><joint name='b' role='joint2'/></transmission>";
  LockStepCell cell(folder.write("arm.urdf", description("", four_bar)), kControllers);
  EXPECT_NEAR(cell.value_of("states", "arm/a/position"), 0, 1e-12) << "where the joints start";
  EXPECT_NEAR(command(cell, 0.4, -0.3), 0.4, 1e-9);
  EXPECT_NEAR(cell.value_of("states", "arm/b/position"), -0.3, 1e-9);
  const Json hardware = cell.result({{"request", "hardware.list"}})[0];
  EXPECT_EQ(hardware["states"].dump(), R"(["arm/a/position","arm/b/position"])") << "joints outside";
}

constexpr const char* kOffset = "<param name='position_state_following_offset'>0.25</param>";

TEST(Description, AComponentIsReloadedFromItsDescriptionAsItIsNow) {
  const Folder folder;
  const std::string file = folder.write("arm.urdf", description(""));
  LockStepCell cell(file, kControllers);
  EXPECT_NEAR(command(cell, 0.4, 0), 0.4, 1e-9);
  folder.write("arm.urdf", description(kOffset));
  const Json done = cell.result({{"request", "hardware.reload"}, {"name", "drives"}});
  EXPECT_EQ(done["state"], "active") << done;
  EXPECT_EQ(cell.state_of("follow"), "inactive") << "stopped, and not started again";
  EXPECT_NE(done["stopped"].dump().find("follow"), std::string::npos);
  cell.result({{"request", "control.switch"}, {"activate", {"follow"}}});
  EXPECT_NEAR(command(cell, 0.4, 0), 0.65, 1e-9) << "the new parameter holds";
}

TEST(Description, AFinalizedComponentComesBackByAReload) {
  const Folder folder;
  LockStepCell cell(folder.write("arm.urdf", description("")), kControllers);
  cell.result({{"request", "hardware.state"}, {"name", "drives"}, {"state", "finalized"}});
  EXPECT_EQ(cell.result({{"request", "hardware.reload"}, {"name", "drives"}})["state"], "unconfigured");
  EXPECT_EQ(cell.result({{"request", "hardware.state"}, {"name", "drives"}, {"state", "active"}})["state"],
            "active");
}

TEST(Description, AReloadWithOtherInterfacesIsRefusedAndTheOldOneStays) {
  const Folder folder;
  LockStepCell cell(folder.write("arm.urdf", description("")), kControllers);
  folder.write("arm.urdf",
               description("", "", "<state_interface name='position'/><state_interface name='effort'/>"));
  const Json refused = cell.ask({{"request", "hardware.reload"}, {"name", "drives"}});
  EXPECT_EQ(refused["error"]["code"], "other-interfaces") << refused;
  folder.write("arm.urdf", "<robot name='arm'><link name='l0'/>");
  EXPECT_FALSE(cell.ask({{"request", "hardware.reload"}, {"name", "drives"}}).value("ok", true));
  EXPECT_EQ(cell.result({{"request", "hardware.state"}, {"name", "drives"}, {"state", "active"}})["state"],
            "active");
}

TEST(Description, IsCheckedWithItsControllersAsACellIs) {
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  const Folder folder;
  const auto urdf = folder.write("arm.urdf", description("", "<joint name='nobody'/>"));
  const auto yaml = folder.write("c.yaml", kControllers);
  const auto checked = [&](const std::string& controllers) {
    return cell::check([&] { return cell::cell_from_description(urdf, {controllers}); },
                       description::Catalogue({}), {});
  };
  const cell::CheckResult good = checked(yaml);
  for (const Problem& p : good.problems) EXPECT_EQ(p.severity, Severity::warning) << p.text();
  EXPECT_TRUE(std::any_of(good.problems.begin(), good.problems.end(), [](const Problem& p) {
    return p.what.find("'nobody'") != std::string::npos && p.severity == Severity::warning;
  }));
  EXPECT_TRUE(checked((folder.path() / "none.yaml").string()).has_errors());
  EXPECT_TRUE(cell::check([]() -> cell::CellFile { throw Error("gone", "no such cell"); },
                          description::Catalogue({}), {})
                  .has_errors());
}

TEST(Description, MadeForGazeboSaysWhichControllersFileItNames) {
  const Folder folder;
  const auto yaml = folder.write("c.yaml", kControllers);
  const auto urdf = folder.write(
      "arm.urdf",
      description("", "</ros2_control><gazebo><plugin filename='p' name='q'><parameters>" + yaml +
                          "</parameters></plugin></gazebo><ros2_control name='x' type='system'><hardware>"
                          "<plugin>mock_components/GenericSystem</plugin></hardware>"));
  const auto notes_of = [&](const std::vector<std::string>& controllers) {
    Problems problems;
    std::vector<std::string> notes;
    cell::resolve_robots(cell::cell_from_description(urdf, controllers), description::Catalogue({}), false,
                         problems, notes);
    return join(notes, " ");
  };
  EXPECT_NE(notes_of({}).find("--controllers " + yaml), std::string::npos) << notes_of({});
  EXPECT_EQ(notes_of({yaml}).find("--controllers"), std::string::npos);
}

TEST(Description, JointsOfItsHardwareThatItLacksAreLeftOutAndTheRestRuns) {
  const Folder folder;
  LockStepCell cell(
      folder.write("arm.urdf",
                   description("", "<joint name='nobody'><command_interface name='position'/></joint>")),
      kControllers);
  EXPECT_NEAR(command(cell, 0.5, -0.5), 0.5, 1e-6);
}

TEST(Description, GroupStatesOfItsSrdfAreNamedPoints) {
  const Folder folder;
  folder.write("arm.srdf",
               "<robot name='arm'><group name='both'><joint name='a'/><joint name='b'/></group>"
               "<group_state name='ready' group='both'><joint name='a' value='0.5'/>"
               "<joint name='b' value='-1'/></group_state></robot>");
  LockStepCell cell(folder.write("arm.urdf", description("")), kControllers);
  const data::Value* ready = cell.cell().store().find("ready");
  ASSERT_TRUE(ready && ready->as_joints());
  EXPECT_EQ(*ready->as_joints()->find("b"), -1);
}

TEST(Description, AFollowerThatIsCommandedOnItsOwnDoesNotFollow) {
  const Folder folder;
  std::string text = description("");
  text.replace(text.find("</joint><joint name='b' type"), 8, "</joint>");
  const std::string limit = "<limit lower='-2' upper='2' velocity='100' effort='10'/>";
  text.insert(text.rfind(limit), "<mimic joint='a'/>");
  text.replace(text.find("<joint name='b'><command"), 16, "<joint name='b' mimic='false'>");
  std::string controllers = kControllers;
  controllers.replace(controllers.find("joints: [a, b]"), 14, "joints: [a]");
  LockStepCell cell(folder.write("arm.urdf", text), controllers);
  cell.result({{"request", "send"}, {"to", "follow"}, {"message", "data: [0.5]"}});
  cell.run(0.1);
  EXPECT_NEAR(cell.value_of("states", "arm/a/position"), 0.5, 1e-9);
  EXPECT_NEAR(cell.value_of("states", "arm/b/position"), 0, 1e-9);
}

/// A link of 0.4 m that lies along x and turns about y, its middle 0.2 m from the joint.
std::string swinging_arm(const std::string& shape, const std::string& block = "") {
  return "<robot name='arm'><link name='foot'><collision><geometry><box size='1 1 1'/></geometry></collision>"
         "</link><link name='beam'><collision><origin xyz='0.2 0 0' rpy='0 1.5707963267948966 "
         "0'/><geometry>" +
         shape +
         "</geometry></collision></link><joint name='a' type='revolute'><parent link='foot'/><child "
         "link='beam'/>"
         "<origin xyz='0 0 0.02'/><axis xyz='0 1 0'/><limit lower='-2' upper='2' velocity='1' "
         "effort='10'/></joint>" +
         block + "</robot>";
}

TEST(Description, WithoutASceneTheFloorIsBelowWhereTheRobotStarts) {
  const Folder folder;
  const auto floor_of = [&](const std::string& urdf, double start, std::vector<std::string>& notes) {
    folder.write("arm.urdf", urdf);
    const auto file =
        folder.write("cell.yaml", "polyarm: cell/1\nrobots: {arm: {model: arm.urdf, xyz: [0, 0, 0.1]}}\n");
    Problems problems;
    std::vector<std::string> unused;
    const auto robots =
        cell::resolve_robots(cell::read_cell_file(file), description::Catalogue({}), false, problems, unused);
    robots.front()->start = {start};
    return cell::scene_without_file(robots, notes).floor_height;
  };
  std::vector<std::string> notes;
  // The foot, which reaches 0.4 m below z = 0, is bolted down and may.
  EXPECT_EQ(floor_of(swinging_arm("<cylinder radius='0.05' length='0.4'/>"), 0, notes), 0);
  EXPECT_TRUE(notes.empty());
  // Turned down, its end is at 0.12 - 0.4 sin 1 - 0.05 cos 1 = -0.2436.
  EXPECT_DOUBLE_EQ(floor_of(swinging_arm("<cylinder radius='0.05' length='0.4'/>"), 1, notes), -0.26);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("starts 0.344 m below its base, so the floor is at z = -0.26 m"), std::string::npos)
      << notes[0];
  EXPECT_DOUBLE_EQ(floor_of(swinging_arm("<box size='0.1 0.1 0.4'/>"), 1, notes), -0.26);
  EXPECT_DOUBLE_EQ(floor_of(swinging_arm("<sphere radius='0.3'/>"), 0, notes), -0.19);
  const std::string free =
      "<ros2_control name='drives' type='system'><hardware><plugin>mock_components/GenericSystem</plugin>"
      "<param name='base'>free</param></hardware><joint name='a'><command_interface name='position'/>"
      "<state_interface name='position'/></joint></ros2_control>";
  EXPECT_EQ(floor_of(swinging_arm("<sphere radius='0.3'/>", free), 0, notes), 0);
}

}  // namespace
}  // namespace polyarm
