/// A cell in one process, the verbs in others, as a person has them in two terminals.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using nlohmann::json;
using test::Command;
using test::ExampleCopy;
using test::Finished;
using test::run_command;

/// A cell without program on the mock, running on the wall clock, with sockets of its own.
class DoorTest : public ::testing::Test {
 protected:
  DoorTest() {
    ::setenv("XDG_RUNTIME_DIR", copy.path().c_str(), 1);
    write_file_atomically(copy.file("cell.yaml"),
                          "polyarm: cell/1\nrate: 500\nrobots:\n  arm: {model: demo/r6bot, hardware: mock}\n"
                          "controllers: [controllers.yaml]\n");
    write_file_atomically(copy.file("controllers.yaml"), R"(
controller_manager:
  ros__parameters:
    follow: {type: joint_trajectory_controller/JointTrajectoryController}
    tail: {type: forward_command_controller/ForwardCommandController}
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
follow:
  ros__parameters: {joints: [joint_1, joint_2], command_interfaces: [position], state_interfaces: [position, velocity]}
tail:
  ros__parameters: {joints: [joint_6], interface_name: position}
)");
    cell = std::make_unique<Command>(std::vector<std::string>{"run", copy.path(), "--json"});
    EXPECT_TRUE(cell->wait_for("mock hardware"));
    for (int tries = 0; tries < 500 && run_command({"health"}).exit_code != 0;)
      ++tries;  // each waits for a process
  }
  ~DoorTest() override { ::unsetenv("XDG_RUNTIME_DIR"); }

  static json asked(std::vector<std::string> line) {
    line.push_back("--json");
    const Finished finished = run_command(line);
    EXPECT_EQ(finished.exit_code, 0) << finished.output;
    return json::parse(finished.output, nullptr, false);
  }
  static std::string state_of(const std::string& controller) {
    for (const json& c : asked({"control", "list"}))
      if (c["name"] == controller) return c["state"];
    return "gone";
  }
  std::string trajectory(double to, double seconds) {
    const json m{{"joint_names", {"joint_1", "joint_2"}},
                 {"points", {{{"positions", {to, 0}}, {"time_from_start", seconds}}}}};
    write_file_atomically(copy.file("t.yaml"), m.dump());
    return copy.file("t.yaml");
  }

  ExampleCopy copy{"pick_and_place"};
  std::unique_ptr<Command> cell;
};

TEST(Door, WithoutACellThereIsOneSentence) {
  const ExampleCopy empty("pick_and_place");
  ::setenv("XDG_RUNTIME_DIR", empty.path().c_str(), 1);
  const Finished nobody = run_command({"control", "list"});
  ::unsetenv("XDG_RUNTIME_DIR");
  EXPECT_EQ(nobody.exit_code, 1);
  EXPECT_NE(nobody.output.find("no cell is running"), std::string::npos);
  EXPECT_EQ(std::count(nobody.output.begin(), nobody.output.end(), '\n'), 1) << nobody.output;
}

TEST_F(DoorTest, TablesNameControllersHardwareAndInterfaces) {
  const std::string list = run_command({"control", "list"}).output;
  EXPECT_NE(list.find("follow"), std::string::npos) << list;
  EXPECT_NE(list.find("arm/joint_1/position, arm/joint_2/position"), std::string::npos) << list;
  EXPECT_NE(
      run_command({"control", "types"}).output.find("joint_trajectory_controller/JointTrajectoryController"),
      std::string::npos);
  EXPECT_NE(run_command({"control", "chains"}).output.find("no controller works through another"),
            std::string::npos);
  EXPECT_NE(run_command({"hardware", "list"}).output.find("active"), std::string::npos);
  EXPECT_NE(run_command({"interfaces"}).output.find("arm/joint_6/position"), std::string::npos);
  EXPECT_NE(run_command({"health"}).output.find("state     running"), std::string::npos);
  EXPECT_NE(run_command({"limits"}).output.find("no limit has changed"), std::string::npos);
  EXPECT_EQ(asked({"health"})["rate_hz"], 500.0);
}

TEST_F(DoorTest, ControllersAreSwitchedLoadedAndUnloaded) {
  const Finished dry = run_command({"control", "switch", "-d", "tail", "--dry"});
  EXPECT_EQ(dry.exit_code, 0) << dry.output;
  EXPECT_EQ(state_of("tail"), "active");
  EXPECT_EQ(run_command({"control", "switch", "-d", "tail"}).exit_code, 0);
  EXPECT_EQ(state_of("tail"), "inactive");
  EXPECT_EQ(run_command({"control", "unload", "tail"}).exit_code, 0);
  EXPECT_EQ(state_of("tail"), "gone");
  const Finished load = run_command({"control", "load", "other", "--type",
                                     "forward_command_controller/ForwardCommandController", "-p",
                                     "joints=[joint_5, joint_6]", "-p", "interface_name=position"});
  EXPECT_EQ(load.exit_code, 0) << load.output;
  EXPECT_EQ(run_command({"control", "state", "other", "active"}).exit_code, 0);
  EXPECT_EQ(state_of("other"), "active");
  EXPECT_EQ(run_command({"control", "load", "tail", "--file", copy.file("controllers.yaml")}).exit_code, 0);
  EXPECT_EQ(state_of("tail"), "inactive");
  const Finished refused = run_command({"control", "switch", "-a", "tail"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.output.find("arm/joint_6/position"), std::string::npos) << refused.output;
  EXPECT_EQ(run_command({"control", "switch", "-a", "tail", "--strictness", "force"}).exit_code, 0);
  EXPECT_EQ(state_of("other"), "inactive");
  EXPECT_EQ(run_command({"control", "frobnicate"}).exit_code, 2);
}

TEST_F(DoorTest, AGoalIsFollowedToItsEndAndCanceledByCtrlC) {
  const Finished done = run_command({"send", "follow", trajectory(0.2, 0.3), "--goal"});
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("accepted"), std::string::npos);
  EXPECT_NE(done.output.find("off by"), std::string::npos) << "feedback";
  EXPECT_NE(done.output.find("succeeded (SUCCESSFUL)"), std::string::npos);
  Command longer({"send", "/follow/follow_joint_trajectory", trajectory(-1, 30), "--goal"});
  ASSERT_TRUE(longer.wait_for("off by"));
  longer.signal(SIGINT);
  EXPECT_EQ(longer.wait().exit_code, 3);
  EXPECT_NE(longer.wait().output.find("canceled"), std::string::npos);
  const Finished wrong = run_command({"send", "follow", "{joint_names: [joint_9], points: []}", "--goal"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_NE(wrong.output.find("joint_9"), std::string::npos) << wrong.output;
}

TEST_F(DoorTest, MessagesAreSentOnceAndAsAStream) {
  const auto arrives = [](double at) {
    for (int tries = 0; tries < 2000; ++tries) {
      const json all = asked({"interfaces"});
      for (const json& state : all["states"])
        if (state["name"] == "arm/joint_6/position" && std::abs(state["value"].get<double>() - at) < 1e-6)
          return true;
    }
    return false;
  };
  EXPECT_EQ(run_command({"send", "tail", "data: [-0.25]"}).exit_code, 0);
  EXPECT_TRUE(arrives(-0.25));
  const Finished stream = run_command(
      {"send", "/tail/commands", "data: [-0.2]\n---\ndata: [-0.1]\n---\ndata: [0.1]\n", "--rate", "100"});
  EXPECT_EQ(stream.exit_code, 0) << stream.output;
  EXPECT_TRUE(arrives(0.1)) << "the last of the stream";
  EXPECT_EQ(run_command({"send", "/tail/command", "data: 0.05"}).exit_code, 0);
  EXPECT_TRUE(arrives(0.05));
  EXPECT_EQ(run_command({"send", "tail", "0.15"}).exit_code, 0);
  EXPECT_NE(run_command({"send", "tail", "nothere.yaml"}).output.find("no such file"), std::string::npos);
  const Finished nothing = run_command({"send", "tail", "-"});
  EXPECT_EQ(nothing.exit_code, 1) << "there is nothing on standard input";
  EXPECT_NE(run_command({"send", "tial", "data: [1]"}).output.find("did you mean 'tail'"), std::string::npos);
}

TEST_F(DoorTest, AWatchPrintsMessages) {
  const Finished watch = run_command({"watch", "joint_states", "--count", "3", "--rate", "100", "--json"});
  EXPECT_EQ(watch.exit_code, 0) << watch.output;
  EXPECT_EQ(std::count(watch.output.begin(), watch.output.end(), '\n'), 3);
  EXPECT_EQ(watch.result()["name"].size(), 6u);
  EXPECT_NE(run_command({"watch", "joint_states", "--count", "1"}).output.find("joint_6"), std::string::npos);
}

TEST_F(DoorTest, AWatchOfWhatPutsOutNothingSaysWhy) {
  EXPECT_EQ(run_command({"control", "state", "follow", "inactive"}).exit_code, 0);
  Command watch({"watch", "follow/controller_state"});
  EXPECT_TRUE(watch.wait_for("its controller is inactive"));
  EXPECT_EQ(run_command({"control", "state", "follow", "active"}).exit_code, 0);
  EXPECT_TRUE(watch.wait_for("joint_names")) << "it goes on";
}

TEST_F(DoorTest, OneMessageWithARateIsRepeated) {
  // `ros2 topic echo` ends its messages with ---, which is no second message.
  Command stream({"send", "tail", "data: [0.2]\n---\n", "--rate", "50"});
  for (const double gone_to : {0.1, 0.3}) {
    EXPECT_EQ(run_command({"send", "tail", "data: [" + std::to_string(gone_to) + "]"}).exit_code, 0);
    bool back = false;
    for (int tries = 0; tries < 500 && !back; ++tries) {
      const json all = asked({"interfaces"});
      for (const json& state : all["states"])
        back = back || (state["name"] == "arm/joint_6/position" &&
                        std::abs(state["value"].get<double>() - 0.2) < 1e-6);
    }
    EXPECT_TRUE(back) << "it was sent again after " << gone_to;
  }
  stream.signal(SIGINT);
  EXPECT_EQ(stream.wait().exit_code, 0) << stream.wait().output;
}

/// Physics is one component, whatever it plays: its parts are called as their descriptions call them.
TEST(PhysicsDoor, ComponentsKeepTheirNames) {
  const ExampleCopy copy("pick_and_place");
  ::setenv("XDG_RUNTIME_DIR", copy.path().c_str(), 1);
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child) {
    return "<joint name='" + name + "' type='revolute'><parent link='" + parent + "'/><child link='" + child +
           "'/><origin xyz='0 0 0.3'/><axis xyz='0 0 1'/><limit lower='-2' upper='2' velocity='2' "
           "effort='50'/></joint>";
  };
  const auto link = [](const std::string& name) {
    return "<link name='" + name +
           "'><inertial><mass value='1'/><inertia ixx='0.01' ixy='0' ixz='0' iyy='0.01' iyz='0' "
           "izz='0.01'/></inertial></link>";
  };
  const auto block = [](const std::string& name, const std::string& joint) {
    return "<ros2_control name='" + name +
           "' type='system'><hardware><plugin>gz_ros2_control/GazeboSimSystem</plugin></hardware><joint "
           "name='" +
           joint +
           "'><command_interface name='position'/><state_interface name='position'/></joint></ros2_control>";
  };
  write_file_atomically(copy.file("two.urdf"), "<robot name='two'><link name='base'/>" + link("l1") +
                                                   link("l2") + joint("a", "base", "l1") +
                                                   joint("b", "l1", "l2") + block("Shoulder", "a") +
                                                   block("Elbow", "b") + "</robot>");
  Command cell({"run", "--description", copy.file("two.urdf"), "--json"});
  EXPECT_TRUE(cell.wait_for("MuJoCo"));
  for (int tries = 0; tries < 500 && run_command({"health"}).exit_code != 0;) ++tries;
  const auto listed = [] {
    return json::parse(run_command({"hardware", "list", "--json"}).output, nullptr, false);
  };
  const json before = listed();
  ASSERT_EQ(before.size(), 2u) << before;
  EXPECT_EQ(before[0]["name"], "Shoulder");
  EXPECT_EQ(before[1]["name"], "Elbow");
  EXPECT_EQ(before[1]["plugin"], "gz_ros2_control/GazeboSimSystem");
  ASSERT_FALSE(before[1]["commands"].empty()) << before;
  EXPECT_EQ(before[1]["commands"][0]["name"], "arm/b/position");
  const Finished off = run_command({"hardware", "state", "Elbow", "inactive"});
  EXPECT_EQ(off.exit_code, 0) << off.output;
  EXPECT_NE(off.output.find("with it Shoulder"), std::string::npos) << off.output;
  for (const json& component : listed()) EXPECT_EQ(component["state"], "inactive") << component;
  EXPECT_EQ(run_command({"hardware", "state", "Shoulder", "active"}).exit_code, 0);
  ::unsetenv("XDG_RUNTIME_DIR");
}

/// Two grippers that never reach their goals, so that there is feedback until they have stalled.
TEST(GripperDoor, GoalsOfBothControllersAreFollowedToTheirEnds) {
  const ExampleCopy copy("pick_and_place");
  ::setenv("XDG_RUNTIME_DIR", copy.path().c_str(), 1);
  write_file_atomically(
      copy.file("cell.yaml"),
      "polyarm: cell/1\nrate: 500\nrobots:\n  arm:\n    model: demo/r6bot\n    hardware: mock\n"
      "    parameters: {disable_commands: true}\n"
      "controllers: [controllers.yaml]\n");
  write_file_atomically(copy.file("controllers.yaml"), R"(
controller_manager:
  ros__parameters:
    old: {type: position_controllers/GripperActionController}
    new: {type: parallel_gripper_action_controller/GripperActionController}
old: {ros__parameters: {joint: joint_5, stall_timeout: 0.5, allow_stalling: true}}
new: {ros__parameters: {joint: joint_6, stall_timeout: 0.5, allow_stalling: false}}
)");
  Command cell({"run", copy.path(), "--json"});
  EXPECT_TRUE(cell.wait_for("mock hardware"));
  for (int tries = 0; tries < 500 && run_command({"health"}).exit_code != 0;) ++tries;
  const Finished old = run_command({"send", "old/gripper_cmd", "{position: 0.4, max_effort: 5}", "--goal"});
  EXPECT_EQ(old.exit_code, 0) << old.output;
  EXPECT_NE(old.output.find("stalled"), std::string::npos) << old.output;
  EXPECT_NE(old.output.find("reference 0.4"), std::string::npos)
      << "feedback in its own words: " << old.output;
  const Finished parallel = run_command({"send", "new/gripper_cmd", "{position: [0.4]}", "--goal"});
  EXPECT_EQ(parallel.exit_code, 1) << parallel.output;
  EXPECT_NE(parallel.output.find("aborted"), std::string::npos) << parallel.output;
  EXPECT_NE(parallel.output.find("reference 0.4"), std::string::npos) << parallel.output;
  EXPECT_NE(parallel.output.find("not reached, stalled"), std::string::npos) << parallel.output;
  ::unsetenv("XDG_RUNTIME_DIR");
}

TEST_F(DoorTest, ParametersAreReadChangedDumpedAndLoaded) {
  EXPECT_NE(run_command({"param", "list", "follow"}).output.find("constraints.goal_time"), std::string::npos);
  EXPECT_EQ(run_command({"param", "set", "follow", "constraints.goal_time=1.5"}).exit_code, 0);
  EXPECT_EQ(run_command({"param", "get", "follow", "constraints.goal_time"}).output, "1.5\n");
  const std::string dump = run_command({"param", "dump", "follow"}).output;
  write_file_atomically(copy.file("dump.yaml"), dump);
  EXPECT_EQ(run_command({"param", "set", "follow", "constraints.goal_time", "0.5"}).exit_code, 0);
  const Finished load = run_command({"param", "load", "follow", copy.file("dump.yaml")});
  EXPECT_EQ(load.output, "changed 1 parameter\n") << dump;
  EXPECT_EQ(run_command({"param", "get", "follow", "constraints.goal_time"}).output, "1.5\n");
  // Of a repeated key in a controllers file the last value counts, as in ROS.
  write_file_atomically(copy.file("twice.yaml"),
                        "constraints: {goal_time: 9}\nconstraints: {goal_time: 2.5}\n");
  const Finished twice = run_command({"param", "load", "follow", copy.file("twice.yaml")});
  EXPECT_EQ(twice.exit_code, 0) << twice.output;
  EXPECT_EQ(run_command({"param", "get", "follow", "constraints.goal_time"}).output, "2.5\n");
  write_file_atomically(copy.file("other.yaml"), "constraints: {gaol_time: 2}\n");
  const Finished wrong = run_command({"param", "load", "follow", copy.file("other.yaml")});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_NE(wrong.output.find("did you mean 'constraints.goal_time'"), std::string::npos) << wrong.output;
  EXPECT_EQ(run_command({"param", "set", "follow", "joints=[joint_3]"}).exit_code, 1);
}

TEST_F(DoorTest, HardwareGoesDownAndComesBack) {
  const std::string name = asked({"hardware", "list"})[0]["name"];
  const Finished off = run_command({"hardware", "state", name, "inactive"});
  EXPECT_EQ(off.exit_code, 0) << off.output;
  EXPECT_NE(off.output.find("follow"), std::string::npos) << off.output;
  EXPECT_EQ(state_of("follow"), "inactive");
  EXPECT_EQ(run_command({"control", "state", "follow", "active"}).exit_code, 1);
  EXPECT_EQ(run_command({"hardware", "state", name, "active"}).exit_code, 0);
  EXPECT_EQ(run_command({"control", "state", "follow", "active"}).exit_code, 0);
}

TEST_F(DoorTest, APersonStopsAndResumesFromAnotherTerminal) {
  EXPECT_EQ(run_command({"send", "follow", trajectory(1, 60)}).exit_code, 0);
  EXPECT_EQ(run_command({"control", "hold"}).exit_code, 0);
  ASSERT_TRUE(cell->wait_for("\"held\""));
  EXPECT_EQ(asked({"health"})["state"], "held");
  EXPECT_EQ(run_command({"control", "discard"}).exit_code, 0);
  EXPECT_EQ(run_command({"control", "resume"}).exit_code, 0);
  ASSERT_TRUE(cell->wait_for("\"running\""));
  cell->signal(SIGINT);
  EXPECT_EQ(cell->wait().exit_code, 3);
  EXPECT_EQ(run_command({"health"}).exit_code, 1) << "the socket is gone";
}

TEST_F(DoorTest, ASecondCellOfTheSameNameIsToldApart) {
  const Finished twice = run_command({"run", copy.path(), "--json"});
  EXPECT_EQ(twice.exit_code, 1) << twice.output;
  EXPECT_NE(twice.output.find("another polyarm runs this cell"), std::string::npos) << twice.output;
  // A folder of the same name elsewhere is a cell of its own.
  namespace fs = std::filesystem;
  const ExampleCopy elsewhere("pick_and_place");
  const std::string name = fs::path(copy.path()).filename().string();
  const fs::path other = elsewhere.file(name);
  fs::create_directory(other);
  for (const char* file : {"cell.yaml", "controllers.yaml"}) fs::copy_file(copy.file(file), other / file);
  Command second({"run", other.string(), "--json"});
  ASSERT_TRUE(second.wait_for("this cell answers as"));
  const Finished which = run_command({"health"});
  EXPECT_EQ(which.exit_code, 1);
  EXPECT_NE(which.output.find("--cell"), std::string::npos) << which.output;
  EXPECT_EQ(run_command({"health", "--cell", name}).exit_code, 0);
  EXPECT_EQ(run_command({"health", "--cell", name + "-2"}).exit_code, 0);
}

TEST_F(DoorTest, ACellThatIsKilledLeavesNoRiddle) {
  cell->signal(SIGKILL);
  cell->wait();
  EXPECT_EQ(run_command({"health"}).exit_code, 1);
  Command again({"run", copy.path(), "--no-socket", "--seconds", "0.2"});
  EXPECT_EQ(again.wait().exit_code, 0);
  Command third({"run", copy.path(), "--fast", "--socket", "--json"});
  ASSERT_TRUE(third.wait_for("mock hardware"));
  int tries = 0;
  while (run_command({"health"}).exit_code != 0 && ++tries < 500) {
  }
  EXPECT_LT(tries, 500);
  third.signal(SIGINT);
  EXPECT_EQ(third.wait().exit_code, 3);
}

}  // namespace
}  // namespace polyarm
