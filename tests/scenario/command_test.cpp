#include "tests/support/command.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "polyarm/base/file.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

using test::ExampleCopy;
using test::Finished;
using test::run_command;

TEST(Command, AnUnknownVerbIsAnErrorWithTheNearestOne) {
  const Finished wrong = run_command({"rnu"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.output.find("did you mean 'run'"), std::string::npos);
}

TEST(Command, AnUnknownOptionOrPartIsAnErrorWithTheNearestOne) {
  const auto said = [](const std::vector<std::string>& words) {
    const Finished wrong = run_command(words);
    EXPECT_EQ(wrong.exit_code, 2) << wrong.output;
    return wrong.output;
  };
  EXPECT_NE(said({"control", "hodl", "--cell", "x"}).find("no 'polyarm control hodl'; did you mean 'hold'?"),
            std::string::npos)
      << "the word that is wrong comes before its options";
  EXPECT_NE(said({"run", "cell", "--fst"}).find("no option '--fst'; did you mean '--fast'?"),
            std::string::npos);
  EXPECT_NE(said({"check", ".", "--roobt", "x"}).find("did you mean '--robot'?"), std::string::npos);
  EXPECT_NE(said({"new", "cel", "mine"}).find("no 'cel'; did you mean 'cell'?"), std::string::npos);
}

TEST(Command, SaysWhatACommandLineLacksAndWhatFitsThere) {
  const auto said = [](const std::vector<std::string>& words) {
    const Finished wrong = run_command(words);
    EXPECT_EQ(wrong.exit_code, 2) << wrong.output;
    return wrong.output;
  };
  const auto says = [&](const std::vector<std::string>& words, const std::string& part) {
    const std::string output = said(words);
    EXPECT_NE(output.find(part), std::string::npos) << output;
    for (const char* foreign : {"required", "Required", "At least", "At Most", "TEXT", "subcommand"})
      EXPECT_EQ(output.find(foreign), std::string::npos) << output;
  };
  says({"new"}, "kind is missing: ");
  says({"new"}, "(cell, hardware, controller)");
  says({"calibrate"}, "(tool, frame, robots,");
  says({"hardware"}, "'polyarm hardware' needs one of these words: list, ");
  says({"data"}, "polyarm data --help lists what is possible");
  says({"data", "get", "cell", "Pick", "more"}, "polyarm data get --help lists what is possible");
  says({"ik", "universal_robots/ur5e", "--xyz", "0.4", "0"}, "--xyz takes 3 values, 2 were given");
  says({"compare", "cell", "--robots"}, "--robots takes at least 1 value, none was given");
  says({"jog", "arm", "x", "10mm"}, "names takes at most 2 values, 3 were given");
  says({"plugin", "build", "nosuch"}, "there is no folder 'nosuch'");
}

TEST(Command, AllowTakesAPathAHostOrASecret) {
  const ExampleCopy cell("r6bot");
  for (const char* wrong : {"", "host:", "secret:", "foo:bar", "/no/such/folder"}) {
    const Finished run = run_command({"check", cell.path(), "--allow", wrong});
    EXPECT_NE(run.exit_code, 0) << wrong << ": " << run.output;
    EXPECT_NE(run.output.find("--allow PATH, --allow host:NAME or --allow secret:NAME"), std::string::npos)
        << wrong << ": " << run.output;
  }
}

TEST(Command, CheckSaysNothingOfTheReachOfAnUnknownRobot) {
  const ExampleCopy cell("pick_and_place");
  const Finished wrong = run_command({"check", cell.path(), "--robot", "fanuc/lr_mat"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_NE(wrong.output.find("there is no robot 'fanuc/lr_mat'"), std::string::npos) << wrong.output;
  EXPECT_EQ(wrong.output.find("can be reached"), std::string::npos) << wrong.output;
}

TEST(Command, ReplaySaysWhatItNeedsInstead) {
  const test::Folder folder;
  folder.write("run.mcap", "");
  const auto says = [&](const std::filesystem::path& path, const char* part) {
    const Finished wrong = run_command({"replay", path.string()});
    EXPECT_EQ(wrong.exit_code, 1) << wrong.output;
    EXPECT_NE(wrong.output.find(part), std::string::npos) << wrong.output;
    EXPECT_NE(wrong.output.find(".state/faults/0001"), std::string::npos) << wrong.output;
  };
  says(folder.path() / "run.mcap", "this is a file, not the folder of a fault");
  says(folder.path(), "this folder has no record of a fault");
  says(folder.path() / "none", "there is no such folder");
}

TEST(Command, AValueThatIsNoNumberIsSaidWithWhatWasExpected) {
  const auto said = [](const std::vector<std::string>& words) {
    const Finished wrong = run_command(words);
    EXPECT_EQ(wrong.exit_code, 2) << wrong.output;
    return wrong.output;
  };
  const std::string seconds = said({"run", "cell", "--seconds", "abc"});
  EXPECT_NE(seconds.find("--seconds"), std::string::npos) << seconds;
  EXPECT_NE(seconds.find("'abc' was given, a number"), std::string::npos) << seconds;
  EXPECT_LT(seconds.size(), 300u) << seconds;
  EXPECT_NE(said({"run", "cell", "--seconds", "-3"}).find("'-3' was given, a number"), std::string::npos);
  EXPECT_NE(said({"run", "cell", "--cycles", "1.5"}).find("a whole number of at least 0 was expected"),
            std::string::npos);
}

TEST(Command, EveryVerbHasHelpWithExamples) {
  for (const char* verb :
       {"run",    "check",   "new",      "plugins",    "robots",     "describe",  "fk",   "ik",    "xacro",
        "replay", "control", "hardware", "interfaces", "health",     "limits",    "send", "watch", "param",
        "setup",  "teleop",  "doctor",   "drivers",    "completion", "workspace", "fmt"}) {
    const Finished help = run_command({verb, "--help"});
    EXPECT_EQ(help.exit_code, 0) << verb;
    EXPECT_NE(help.output.find("Examples:"), std::string::npos) << verb;
  }
}

TEST(Robots, AreAnArrayOfFacts) {
  const Finished listed = run_command({"robots", "--json"});
  const auto robots = nlohmann::json::parse(listed.output);
  ASSERT_TRUE(robots.is_array());
  std::set<std::string> names;
  for (const auto& robot : robots) {
    names.insert(robot["name"].get<std::string>());
    EXPECT_GE(robot["axes"].get<int>(), 3);
    EXPECT_TRUE(robot.contains("maker") && robot.contains("reach_m") && robot.contains("payload_kg"));
  }
  for (const char* name :
       {"universal_robots/ur3", "universal_robots/ur5", "universal_robots/ur10", "universal_robots/ur3e",
        "universal_robots/ur5e", "universal_robots/ur10e", "fanuc/lr_mate_200id", "fanuc/lr_mate_200id_7l",
        "abb/irb_120", "abb/irb_1200_7_70", "demo/r6bot"})
    EXPECT_TRUE(names.contains(name)) << name;
}

TEST(Kinematics, AnglesAboveATurnNeedTheirUnit) {
  const auto ik = [](const char* roll) {
    return run_command(
        {"ik", "universal_robots/ur5e", "--xyz", "0.4", "0.1", "0.3", "--rpy", roll, "0", "0"});
  };
  const Finished bare = ik("180"), degrees = ik("180deg"), radians = ik("3.141592653589793");
  EXPECT_EQ(bare.exit_code, 2);
  EXPECT_NE(bare.output.find("'180' radians are more than a turn; write 180deg or 180rad"), std::string::npos)
      << bare.output;
  EXPECT_EQ(degrees.exit_code, 0) << degrees.output;
  EXPECT_EQ(degrees.output, radians.output);
}

TEST(Kinematics, IkAndFkUndoEachOther) {
  const Finished ik = run_command(
      {"ik", "universal_robots/ur5e", "--xyz", "0.4", "0.1", "0.3", "--rpy", "3.1", "0.1", "0.2", "--json"});
  ASSERT_EQ(ik.exit_code, 0) << ik.output;
  std::vector<std::string> line{"fk", "universal_robots/ur5e", "--json", "--joints"};
  const auto solution = nlohmann::json::parse(ik.output);
  for (const auto& q : solution["q"]) line.push_back(q.dump());
  const auto pose = nlohmann::json::parse(run_command(line).output);
  EXPECT_NEAR(pose["xyz"][0].get<double>(), 0.4, 1e-6);
  EXPECT_NEAR(pose["xyz"][1].get<double>(), 0.1, 1e-6);
  EXPECT_NEAR(pose["rpy"][0].get<double>(), 3.1, 1e-5);
  EXPECT_NEAR(pose["rpy"][2].get<double>(), 0.2, 1e-5);
}

/// What a script reads from --json it gives back in the same order.
TEST(Kinematics, JointsAreNamedInTheOrderThatTheyAreGivenIn) {
  const Finished fk = run_command({"fk", "universal_robots/ur5e", "--json"});
  const auto pose = nlohmann::ordered_json::parse(fk.output);
  std::vector<std::string> names;
  for (const auto& [name, value] : pose["joints"].items()) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
                                             "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"}));
}

TEST(Kinematics, OfTheLinkThatIsSaid) {
  const auto height = [](std::vector<std::string> line) {
    line.insert(line.begin(), {"fk", "universal_robots/ur5e", "--json"});
    return nlohmann::json::parse(run_command(line).output)["xyz"][2].get<double>();
  };
  EXPECT_GT(std::abs(height({}) - height({"--tip", "forearm_link"})), 0.01);
  EXPECT_EQ(height({}), height({"--tip", "tool0"}));
  const Finished slip = run_command({"describe", "universal_robots/ur5e", "--tip", "forarm_link"});
  EXPECT_NE(slip.exit_code, 0);
  EXPECT_NE(slip.output.find("did you mean 'forearm_link'"), std::string::npos) << slip.output;
}

TEST(Describe, ADescriptionInXacroIsToldItsArguments) {
  const ExampleCopy copy("pick_and_place");
  const std::string file = copy.file("arm.urdf.xacro");
  write_file_atomically(file, R"xml(<robot name="$(arg name)" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="prefix" default="a_"/>
<link name="$(arg prefix)base"/><link name="$(arg prefix)tool0"/>
<joint name="$(arg prefix)j" type="revolute">
<parent link="$(arg prefix)base"/><child link="$(arg prefix)tool0"/>
<origin xyz="0.1 0.2 0.3"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>)xml");
  const Finished described = run_command({"describe", file, "name:=mine", "prefix:=b_", "--json"});
  ASSERT_EQ(described.exit_code, 0) << described.output;
  const auto robot = nlohmann::json::parse(described.output);
  EXPECT_EQ(robot["name"], "mine");
  EXPECT_EQ(robot["tool_link"], "b_tool0");
  const Finished fk = run_command({"fk", file, "--joints", "0", "name:=mine"});  // behind what takes many
  EXPECT_EQ(fk.exit_code, 0) << fk.output;
  const Finished wrong = run_command({"describe", file, "name=mine"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.output.find("NAME:=VALUE"), std::string::npos) << wrong.output;
}

TEST(Kinematics, BareNumbersAreSaidToFollowAnOption) {
  const auto said = [](const std::vector<std::string>& words) {
    const Finished wrong = run_command(words);
    EXPECT_EQ(wrong.exit_code, 2) << wrong.output;
    return wrong.output;
  };
  const std::string ur3 = "universal_robots/ur3";
  EXPECT_EQ(said({"fk", ur3, "0", "-1.57"}),
            "error: no option takes the numbers 0 -1.57 (write --joints 0 -1.57)\n");
  EXPECT_EQ(said({"fk", ur3, "-90deg"}),
            "error: no option takes the number -90deg (write --joints -90deg)\n");
  EXPECT_EQ(said({"ik", ur3, "0.4", "0", "0.3"}),
            "error: no option takes the numbers 0.4 0 0.3 (write --xyz 0.4 0 0.3)\n");
  EXPECT_NE(said({"ik", ur3}).find("no position is given (write --xyz X Y Z"), std::string::npos);
  EXPECT_NE(said({"fk", ur3, "--joints", "0", "1"}).find("--joints takes 6 numbers"), std::string::npos);
}

TEST(Kinematics, IkSaysWhyNot) {
  const Finished ik = run_command({"ik", "universal_robots/ur3", "--xyz", "5", "3", "2"});
  EXPECT_EQ(ik.exit_code, 1);
  EXPECT_NE(ik.output.find("reaches"), std::string::npos) << ik.output;
}

TEST(Describe, SaysThatACellIsNoRobot) {
  const test::ExampleCopy copy("pick_and_place");
  for (const char* verb : {"describe", "fk"}) {
    const Finished told = run_command({verb, copy.path()});
    EXPECT_EQ(told.exit_code, 2);
    EXPECT_NE(
        told.output.find("is a cell, and this verb is about one robot (its robots are universal_robots/ur3)"),
        std::string::npos)
        << told.output;
  }
}

TEST(Describe, UrdfOfARobotRunsAsADescription) {
  const ExampleCopy copy("pick_and_place");
  const std::string urdf = copy.file("robot.urdf");
  write_file_atomically(urdf, run_command({"describe", "abb/irb_120", "--urdf"}).output);
  const Finished run = run_command({"run", "--description", urdf, "--fast", "--seconds", "1", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(run.result()["result"], "completed");
  EXPECT_EQ(run.result()["control_cycles"], 1000);
}

TEST(Run, ReplacesAPluginThatIsNotInstalledAndSaysSo) {
  const ExampleCopy copy("pick_and_place");
  std::string urdf = run_command({"describe", "demo/r6bot", "--urdf"}).output;
  const auto block = [](const std::string& name, const std::string& plugin, const std::string& joint) {
    return "<ros2_control name=\"" + name + "\" type=\"system\"><hardware><plugin>" + plugin +
           "</plugin></hardware><joint name=\"" + joint +
           "\"><command_interface name=\"position\"/><state_interface name=\"position\"/></joint>"
           "</ros2_control>";
  };
  const auto hardware = [&](const std::string& plugin) {
    return block("R6", plugin, "joint_1") + "</robot>";
  };
  urdf.erase(urdf.rfind("</robot>"));
  write_file_atomically(copy.file("a.urdf"), urdf + hardware("acme/Unheard"));
  write_file_atomically(copy.file("b.urdf"), urdf + hardware("mock_components/GenericSystem"));
  const Finished a = run_command({"run", "--description", copy.file("a.urdf"), "--fast", "--seconds", "1"});
  EXPECT_NE(a.output.find("R6: the plugin acme/Unheard is not installed, replaced by"), std::string::npos)
      << a.output;
  const Finished b = run_command({"run", "--description", copy.file("b.urdf"), "--fast", "--seconds", "1"});
  EXPECT_NE(b.output.find("mock_components/GenericSystem is simulated by mock"), std::string::npos)
      << b.output;
  // Two blocks of one robot: physics plays all of its joints.
  write_file_atomically(copy.file("c.urdf"), urdf + block("R6", "mock_components/GenericSystem", "joint_1") +
                                                 block("Tail", "acme/Unheard", "joint_2") + "</robot>");
  const Finished c = run_command({"run", "--description", copy.file("c.urdf"), "--fast", "--seconds", "1"});
  EXPECT_EQ(c.exit_code, 0) << c.output;
  if (c.output.find("Tail: the plugin acme/Unheard is not installed, replaced by physics") !=
      std::string::npos) {
    EXPECT_NE(c.output.find("R6: simulated by physics, like the other joints"), std::string::npos)
        << c.output;
  }
}

TEST(Run, TakesARobotWhereACellMayStand) {
  const ExampleCopy copy("pick_and_place");
  write_file_atomically(copy.file("r6.urdf"), run_command({"describe", "demo/r6bot", "--urdf"}).output);
  for (const std::string& robot : {std::string("universal_robots/ur5e"), std::string(copy.file("r6.urdf"))}) {
    const Finished run = run_command({"run", robot, "--fast", "--seconds", "0.5", "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.output;
    EXPECT_NE(run.output.find("\"completed\""), std::string::npos) << run.output;
  }
}

TEST(Run, SaysWhatAFileIsThatIsNoCell) {
  const ExampleCopy copy("pick_and_place");
  write_file_atomically(copy.file("controllers.yaml"), "arm:\n  ros__parameters: {joints: [a]}\n");
  write_file_atomically(copy.file("a.launch"),
                        "<launch><arg name='which'/><group if='$(arg which)'/></launch>");
  for (const auto& [file, says] : {std::pair{"controllers.yaml", "--controllers"},
                                   {"flowing.script", "--program"},
                                   {"a.launch", "which:=VALUE"}}) {
    const Finished run = run_command({"run", copy.file(file), "--fast"});
    EXPECT_EQ(run.exit_code, 1) << run.output;
    EXPECT_NE(run.output.find(says), std::string::npos) << run.output;
    EXPECT_EQ(run.output.find("no cell file"), std::string::npos) << run.output;
  }
}

TEST(Run, ExplainsALaunchFile) {
  const ExampleCopy copy("pick_and_place");
  write_file_atomically(
      copy.file("view.launch.py"),
      "urdf = PathJoinSubstitution([FindPackageShare('d'), 'urdf', 'bot.urdf.xacro'])\n"
      "yaml = PathJoinSubstitution([FindPackageShare('d'), 'config', 'bot_controllers.yaml'])\n");
  const Finished run = run_command({"run", copy.file("view.launch.py")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.output.find("polyarm run --description bot.urdf.xacro --controllers bot_controllers.yaml"),
            std::string::npos)
      << run.output;
}

TEST(Run, WaitUserNeedsSomebodyOrAnAnswer) {
  const ExampleCopy copy("pick_and_place");
  write_file_atomically(copy.file("ask.script"), "wait user \"Is the tray empty?\"\nlog \"on it goes\"\n");
  write_file_atomically(copy.file("cell.yaml"),
                        "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur3}\nprogram: ask\n");
  const Finished nobody = run_command({"run", copy.path(), "--fast"});
  EXPECT_EQ(nobody.exit_code, 1);
  EXPECT_NE(nobody.output.find("--answer"), std::string::npos) << nobody.output;
  const Finished answered = run_command({"run", copy.path(), "--fast", "--answer", "yes"});
  EXPECT_EQ(answered.exit_code, 0) << answered.output;
  EXPECT_NE(answered.output.find("on it goes"), std::string::npos);
}

TEST(Run, GoesOnAndEndsWhereNobodyReadsItsOutput) {
  const ExampleCopy example("pick_and_place");
  std::ofstream(example.file("PAPscript.script")) << "while true\n  log \"again\"\n  wait 5ms\nend\n";
  test::Command running({"run", example.path(), "--json", "--seconds", "3"});
  running.shrink_output(4096);
  ASSERT_TRUE(running.ends_unread(600)) << "it waits for its reader";
  const Finished& finished = running.wait();
  EXPECT_NE(finished.output.find("again"), std::string::npos);
  EXPECT_EQ(finished.output.find("silent"), std::string::npos) << finished.output;
}

/// Writes a cell of a UR3 with one part in physics.
void write_cell_with_part(const test::Folder& folder, const std::string& mass) {
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur3, hardware: mujoco, tool: "
               "suction_cup}\nscene: scene.yaml\nsignals: signals.yaml\nprogram: job.script\n");
  folder.write(
      "scene.yaml",
      "polyarm: scene/1\nfloor: {height: 0}\nparts:\n  cube: {kind: cube, box: [40mm, 40mm, 40mm], mass: " +
          mass + ", at: [0.3, 0.1, 0.02]}\n");
  folder.write("signals.yaml",
               "polyarm: signals/1\ntags:\n  Suck: {command: arm/tool/vacuum}\n  Held: {state: "
               "arm/tool/part_present}\n");
}

TEST(Run, APartThatIsTooHeavyForTheCupIsNamed) {
  const test::Folder folder;
  write_cell_with_part(folder, "20kg");
  folder.write(
      "job.script",
      "movej pose(300mm, 100mm, 140mm, 180deg, 0, 0)\nmovel pose(300mm, 100mm, 40.5mm, 180deg, 0, 0)\n"
      "set Suck = true\nmovel pose(300mm, 100mm, 140mm, 180deg, 0, 0)\nwait Held timeout 1s\n");
  const Finished run = run_command({"run", folder.path().string(), "--fast", "--quiet"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(
      run.output.find("job.script:5:1: error: the time-out passed and the condition is still false; it reads "
                      "Held; the TCP of 'arm' is "),
      std::string::npos)
      << run.output;
  folder.write(
      "job.script",
      "movej pose(300mm, 100mm, 140mm, 180deg, 0, 0)\nmovel pose(300mm, 100mm, 41mm, 180deg, 0, 0)\nset Suck "
      "= true\nwait Held timeout 1s\nmovel pose(300mm, 100mm, 41.2mm, 180deg, 0, 0), accel 8m/s2\nwait Held "
      "timeout 1s\n");
  const Finished heavy = run_command({"run", folder.path().string(), "--fast", "--quiet"});
  EXPECT_NE(heavy.output.find("cube weighs 20 kg, and the cup holds 60 N, which is 6.12 kg"),
            std::string::npos)
      << heavy.output;
}

TEST(Run, WhoStartsInsideSomethingIsToldThatAlone) {
  const test::Folder folder;
  write_cell_with_part(folder, "50g");
  folder.write("scene.yaml",
               "polyarm: scene/1\nfixtures:\n  crate: {box: [0.3, 0.3, 0.3], at: [0.2, 0, 0.3]}\n");
  folder.write("job.script", "movej joints(0, -90deg, 90deg, -90deg, -90deg, 0)\n");
  const Finished dry = run_command({"check", folder.path().string(), "--dry"});
  EXPECT_EQ(dry.exit_code, 1);
  EXPECT_NE(dry.output.find(" is inside fixture crate where it starts"), std::string::npos) << dry.output;
  EXPECT_EQ(dry.output.find("jumped"), std::string::npos) << "what physics makes of it: " << dry.output;
  const Finished run = run_command({"run", folder.path().string(), "--fast"});
  EXPECT_EQ(run.output.find("type resume"), std::string::npos) << "nobody can: " << run.output;
}

TEST(Run, AProgramThatFailsIsNotCalledAStopThatSomebodyAskedFor) {
  const test::Folder folder;
  folder.write("job.script",
               "movej joints(50deg, 0deg, 0deg, 0deg, 0deg, 0deg)\nwait 200ms\nraise \"no part\"\n");
  folder.write("cell.yaml", std::string("polyarm: cell/1\nrobots: {arm: {model: ") + POLYARM_SOURCE_DIR +
                                "/examples/r6bot/r6bot.urdf}}\nprogram: job.script\n");
  const Finished run = run_command({"run", folder.path().string(), "--fast", "--quiet"});
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_NE(run.output.find("held: the run failed\n"), std::string::npos) << run.output;
  EXPECT_EQ(run.output.find("was requested"), std::string::npos) << run.output;
}

TEST(Run, TheThesisDurationRuleStretchesMoves) {
  const ExampleCopy copy("pick_and_place");
  const double fast =
      run_command({"run", copy.path(), "--fast", "--json", "--cycles", "1", "--hardware", "mock"})
          .result()["sim_time_s"];
  write_file_atomically(copy.file("cell.yaml"),
                        read_file(copy.file("cell.yaml")) + "motion: {thesis_scale: 4}\n");
  const double slow =
      run_command({"run", copy.path(), "--fast", "--json", "--cycles", "1", "--hardware", "mock"})
          .result()["sim_time_s"];
  EXPECT_GT(slow, fast + 5);
}

}  // namespace
}  // namespace polyarm
