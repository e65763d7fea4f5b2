/// What people write wrong in a cell is told where it stands, once, with what to do.
#include <gtest/gtest.h>

#include <string>

#include "polyarm/cell/check.hpp"
#include "polyarm/cell/program_tests.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

std::string told(const std::vector<Problem>& problems) {
  std::string out;
  for (const Problem& p : problems)
    out += std::filesystem::path(p.where.file).filename().string() + ":" + std::to_string(p.where.line) +
           " " + p.what + " (" + p.advice + ")\n";
  return out;
}

class Mistakes : public ::testing::Test {
 protected:
  Mistakes() {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    cell();
  }
  /// Of one robot, which is at `robot`.
  void cell(const std::string& robot = "", const std::string& more = "") {
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes +
                                  ", hardware: mock" + robot + "}\n" + more);
  }
  std::string checked() { return told(check(folder.path(), {}, description::Catalogue({}), {}).problems); }
  /// What a run says before it begins.
  std::string run() {
    try {
      test::LockStepCell built(read_cell_file(folder.path()));
      return "";
    } catch (const Error& e) {
      return told(e.problems());
    }
  }
  /// Both of them, which say the same.
  std::string both() {
    const std::string of_check = checked();
    EXPECT_EQ(run(), of_check);
    return of_check;
  }
  test::Folder folder;
};

TEST_F(Mistakes, AFileThatIsNotThereIsNamedWhereTheCellNamesIt) {
  folder.write("scene.yaml", "polyarm: scene/1\n");
  cell("", "scene: scen.yaml\n");
  EXPECT_EQ(both().find("cell.yaml:4 there is no file 'scen.yaml'; did you mean 'scene.yaml'? (looked in /"),
            0u)
      << checked();
  cell("", "signals: signals.yaml\n");
  EXPECT_EQ(both().find("cell.yaml:4 there is no file 'signals.yaml' (looked in /"), 0u) << checked();
}

TEST_F(Mistakes, ANameThatTheSystemCannotLookUpIsAnErrorAsAnyWrongName) {
  const std::string longest(5000, 'x');
  cell("", "program: " + longest + "\n");
  EXPECT_NE(checked().find("cell.yaml"), std::string::npos);
  EXPECT_THROW(test::LockStepCell(read_cell_file(folder.path())), Error);
  cell();
  for (const std::string& name : {longest, std::string(300, 'x'), std::string(3000, 'a') + "/b"}) {
    Overrides overrides;
    overrides.program = name;
    EXPECT_THROW(test::LockStepCell(read_cell_file(folder.path(), overrides)), Error);
    overrides = {};
    overrides.robot = name;
    EXPECT_THROW(test::LockStepCell(read_cell_file(folder.path(), overrides)), Error);
    EXPECT_THROW(read_cell_file(name), Error);
    Problems problems;
    EXPECT_THROW(find_tests(name, problems), Error);
  }
}

TEST_F(Mistakes, ATabInYamlIsCalledATab) {
  cell("", "motion:\n\tspeed: 50%\n");
  EXPECT_NE(checked().find("cell.yaml:5 not valid YAML: a tab indents this line (write blanks"),
            std::string::npos)
      << checked();
}

TEST_F(Mistakes, DegreesAndMillimetresWithoutTheirUnitsAreErrors) {
  cell(", rpy: [0, 0, 90]");
  EXPECT_NE(both().find(
                "cell.yaml:3 an angle of 90 rad is more than two whole turns (this looks like degrees, write "
                "90deg"),
            std::string::npos)
      << checked();
  cell(", at: [0, 350, 0]");
  EXPECT_NE(
      both().find("cell.yaml:3 350 m is far outside of any cell (this looks like millimetres, write 350mm"),
      std::string::npos)
      << checked();
  cell(", at: [0, 350mm, 2], rpy: [0, 0, 450deg]");
  EXPECT_EQ(checked(), "");
  cell("", "motion: {tcp_speed: 500}\n");
  EXPECT_NE(both().find("cell.yaml:4 tcp_speed is 500, faster than any robot (this looks like mm/s"),
            std::string::npos)
      << checked();
}

TEST_F(Mistakes, AProgramSetsNoTagThatTheHardwareMeasures) {
  folder.write("signals.yaml",
               "polyarm: signals/1\ntags:\n  Where: {state: arm/joint_1/position, type: number}\n"
               "  Lamp: {initial: false}\n");
  folder.write("job.script", "set Where = 1\n");
  cell("", "signals: signals.yaml\nprogram: job.script\n");
  EXPECT_NE(both().find("job.script:1 'Where' is a measured value of the hardware; a program cannot set it"),
            std::string::npos)
      << checked();
  folder.write("job.script", "set Lamp = Where > 1\n");
  folder.write("plc.script", "wait Lamp\nset Where = 2\n");
  cell("", "signals: signals.yaml\nprogram: job.script\nplc: plc.script\n");
  EXPECT_NE(both().find("plc.script:2 'Where' is a measured value"), std::string::npos) << checked();
}

TEST_F(Mistakes, ARobotThatTheCellDoesNotHaveIsAnErrorBehindAWaitToo) {
  folder.write("signals.yaml", "polyarm: signals/1\ntags:\n  Go: {initial: false}\n");
  folder.write("job.script", "wait Go\nmovej joints(0, 0, 0, 0, 0, 0), robot amr\n");
  cell("", "signals: signals.yaml\nprogram: job.script\n");
  EXPECT_EQ(both(), "job.script:2 the cell has no robot 'amr'; did you mean 'arm'? (known are: arm)\n");
}

TEST_F(Mistakes, TheNamedStatesOfARobotAreNamesOfTheCell) {
  folder.write("r.urdf", read_file(test::kSixAxes));
  folder.write(
      "r.srdf",
      "<robot name='r6bot'><group name='arm'/><group_state name='home' group='arm'><joint name='joint_1' "
      "value='0'/></group_state></robot>");
  folder.write("job.script", "movej home\n");
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n  arm: {model: r.urdf, hardware: mock}\nprogram: job.script\n");
  EXPECT_EQ(both(), "");
  folder.write("job.script", "let home = pose(1m, 0, 0)\n");
  EXPECT_NE(both().find("job.script:1 there is a 'home' already"), std::string::npos) << checked();
}

TEST_F(Mistakes, ANameThatIsThereAlreadyIsToldWithThePlaceOfTheFirst) {
  folder.write("signals.yaml", "polyarm: signals/1\ntags:\n  Ready: {initial: False}\n");
  folder.write("job.data", "Name: Count\nNum: 3\n");
  folder.write("more.script", "let step = 2\n");
  const auto of = [&](const std::string& program) {
    folder.write("job.script", "load job\n" + program);
    return both();
  };
  cell("", "signals: signals.yaml\nprogram: job.script\n");
  EXPECT_EQ(of("let n = 1\nlet n = 2\n").find("job.script:3 there is a 'n' already, in line 2 ("), 0u)
      << checked();
  EXPECT_EQ(of("let Count = 1\n").find("job.script:2 there is a 'Count' already, in line 2 of job.data ("),
            0u)
      << checked();
  EXPECT_EQ(of("for Ready in [1]\nend\n")
                .find("job.script:2 there is a 'Ready' already, in line 3 of signals.yaml"),
            0u)
      << checked();
  EXPECT_EQ(of("include \"more.script\"\nlet step = 3\n")
                .find("job.script:3 there is a 'step' already, in line 1 of more.script"),
            0u)
      << checked();
}

TEST_F(Mistakes, AKeyThatIsDefinedTwiceIsAnErrorInEveryFile) {
  folder.write("signals.yaml",
               "polyarm: signals/1\ntags:\n  Ready: {initial: False}\n  Ready: {initial: 3}\n");
  cell("", "signals: signals.yaml\n");
  EXPECT_EQ(both().find("signals.yaml:4 'Ready' is defined twice, here and in line 3 (rename"), 0u)
      << checked();
  cell("", "motion: {speed: 50%}\nmotion: {speed: 20%}\n");
  EXPECT_EQ(both().find("cell.yaml:5 'motion' is defined twice, here and in line 4 (rename"), 0u)
      << checked();
  cell(", at: [0, 0, 0], at: [1, 0, 0]");
  EXPECT_EQ(both().find("cell.yaml:3 'at' is defined twice, here and in line 3 (rename"), 0u) << checked();
  folder.write("scene.yaml",
               "polyarm: scene/1\nparts:\n  cube: {box: [50mm, 50mm, 50mm], mass: 1, at: [1, 0, 0]}\n"
               "  cube: {box: [50mm, 50mm, 50mm], mass: 1, at: [2, 0, 0]}\n");
  cell("", "scene: scene.yaml\n");
  EXPECT_EQ(both().find("scene.yaml:4 'cube' is defined twice, here and in line 3 (rename"), 0u) << checked();
  folder.write("cup.yaml", "kind: suction\nmass: 1kg\nmass: 2kg\n");
  cell(", tool: cup");
  EXPECT_EQ(both().find("cup.yaml:3 'mass' is defined twice, here and in line 2 (rename"), 0u) << checked();
}

TEST_F(Mistakes, ALiveDataSetWithoutAFileIsToldWithTheNearest) {
  folder.write("orders.data", "Name: Count\nNum: 0\n");
  folder.write("job.script", "load orders\nlog(Count)\n");
  folder.write("signals.yaml", "polyarm: signals/1\nlive: [order]\n");
  cell("", "signals: signals.yaml\nprogram: job.script\n");
  EXPECT_EQ(
      checked().find("signals.yaml:2 there is no file 'order'; did you mean 'orders'?: nothing is live"), 0u)
      << checked();
  for (const char* name : {"orders", "orders.data"}) {
    folder.write("signals.yaml", std::string("polyarm: signals/1\nlive: [") + name + "]\n");
    EXPECT_EQ(checked(), "");
    test::LockStepCell built(read_cell_file(folder.path()));
    EXPECT_TRUE(built.cell().files().is_live("orders")) << name;
  }
}

TEST_F(Mistakes, AnIncludedFileThatIsMissingIsOneError) {
  folder.write("moves.script", "func go()\n  log(1)\nend\nlet fast = 50%\n");
  folder.write("job.script", "include \"move.script\"\ngo()\nlog(fast)\nset fast = 2\n");
  cell("", "program: job.script\n");
  const std::string told = both();
  EXPECT_NE(told.find("job.script:1 'move.script' cannot be included"), std::string::npos) << told;
  EXPECT_NE(told.find("did you mean 'moves.script'?"), std::string::npos) << told;
  EXPECT_EQ(told.find('\n'), told.size() - 1) << told;
}

TEST_F(Mistakes, ABooleanTagThatIsComparedWithANumberSaysWhatItsTypeIs) {
  folder.write("signals.yaml", "polyarm: signals/1\ntags:\n  Kind: {state: arm/joint_1/position}\n");
  folder.write("job.script", "wait Kind == 2\n");
  cell("", "signals: signals.yaml\nprogram: job.script\n");
  EXPECT_NE(both().find("(a tag is a bool unless signals.yaml says `type: number`)"), std::string::npos)
      << checked();
}

TEST_F(Mistakes, RobotsThatAreNotDescribedAreNamedAndShowHowToDescribeThem) {
  folder.write("cell.yaml", "polyarm: cell/1\nrobots: [arm]\n");
  EXPECT_EQ(checked(), "cell.yaml:2 'robots' has no names of robots (write 'robots: {arm: {model: universal_robots/ur3}}')\n");
  folder.write("cell.yaml", "polyarm: cell/1\nrobots: {arm: kuka/kr_3_r540}\n");
  EXPECT_EQ(checked(), "cell.yaml:2 the robot 'arm' is not described (write 'arm: {model: kuka/kr_3_r540}')\n");
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm:\n");
  EXPECT_NE(checked().find("the robot 'arm' is not described"), std::string::npos) << checked();
}

TEST_F(Mistakes, ATagOfTheWrongDirectionSaysWhichOneItIs) {
  folder.write("signals.yaml",
               "polyarm: signals/1\ntags:\n  Set: {state: program/running}\n  Asked: {command: program/running}\n");
  cell("", "signals: signals.yaml\n");
  EXPECT_NE(both().find("(it is a state: write {state: …})"), std::string::npos) << checked();
}

TEST_F(Mistakes, SizesThatLookLikeMillimetresNeedAUnit) {
  const auto scene = [&](const std::string& box) {
    folder.write("scene.yaml", "polyarm: scene/1\nparts:\n  a: {box: " + box + ", mass: 1kg, at: [1, 0, 0.02]}\n");
    cell("", "scene: scene.yaml\n");
    return checked();
  };
  EXPECT_NE(scene("[40, 40, 40]").find("a size of 40 m is unusual (this looks like millimetres, write 40mm"),
            std::string::npos);
  EXPECT_EQ(scene("[40mm, 40mm, 40mm]"), "");
  EXPECT_EQ(scene("[0.04, 0.04, 0.04]"), "");
}

TEST_F(Mistakes, APointInAFileThatIsNotLoadedSaysWhichFile) {
  folder.write("places.points", "Pose: RPY\nName: A\nPoint: 0.3, 0, 1, 0, 0, 0\n");
  folder.write("job.script", "movej A\n");
  cell("", "program: job.script\n");
  EXPECT_EQ(checked(), "job.script:1 there is nothing called 'A' (it is in places.points: write `load places` above)\n");
}

TEST_F(Mistakes, TwoTasksMayNotMoveTheOnlyRobot) {
  folder.write("places.points", "Pose: RPY\nName: A\nPoint: 0.3, 0, 1, 0, 0, 0\n");
  folder.write("job.script", "load places\ntask one\n  movej A\nend\ntask two\n  movej A\nend\n");
  cell("", "program: job.script\n");
  EXPECT_NE(checked().find("job.script:6 the robot 'arm' is used by the task 'one' in line 3, too"), std::string::npos)
      << checked();
}

TEST_F(Mistakes, AFeederHasItsPartsFromTheStart) {
  folder.write("scene.yaml",
               "polyarm: scene/1\nfeeders:\n  belt: {at: [0.4, 0.3, 0.02]}\n"
               "parts:\n  a: {kind: red, box: [40mm, 40mm, 40mm], mass: 80g, feeder: belt}\n");
  folder.write("signals.yaml",
               "polyarm: signals/1\ntags:\n  Left: {state: scene/belt/remaining, type: number}\n"
               "  Kind: {state: scene/belt/kind, type: number}\n");
  folder.write("places.points", "Pose: RPY\nName: A\nPoint: 0.3, 0.2, 0.6, 0, 0, 0\n");
  folder.write("job.script",
               "load places\nwhile Left > 0\n  if Kind == 1\n    movej offset(A, z = 5m)\n  end\n  wait 1s\nend\n");
  cell("", "scene: scene.yaml\nsignals: signals.yaml\nprogram: job.script\n");
  EXPECT_NE(checked().find("job.script:4 "), std::string::npos) << "the branch in the loop is planned: " << checked();
}

TEST_F(Mistakes, WithSeveralRobotsOneMustReachEachPoint) {
  const auto two = [&](const std::string& x) {
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  left: {model: " + test::kSixAxes +
                                  "}\n  right: {model: " + test::kSixAxes + ", at: [3, 0, 0]}\nprogram: job.script\n");
    folder.write("places.points", "Pose: RPY\nName: A\nPoint: " + x + ", 0.2, 0.6, 0, 0, 0\n");
    folder.write("job.script", "load places\n");
    return checked();
  };
  EXPECT_EQ(two("0.3"), "");
  EXPECT_EQ(two("3.3"), "");
  const std::string none = two("9");
  EXPECT_EQ(none.find("places.points:3 no robot reaches A (left: A is "), 0u) << none;
  EXPECT_NE(none.find("; right: A is "), std::string::npos) << none;
}

TEST_F(Mistakes, ATagWithoutTheMiddleOfAnInterfaceIsToldTheWholeOne) {
  folder.write("signals.yaml", "polyarm: signals/1\ntags:\n  Up: {state: arm/z, type: number}\n");
  folder.write("job.script", "wait 1s\n");
  cell("", "signals: signals.yaml\nprogram: job.script\n");
  EXPECT_NE(both().find("arm/tcp/z"), std::string::npos) << both();
}

TEST_F(Mistakes, OneMistakeIsOneError) {
  folder.write("signals.yaml",
               "polyarm: signals/1\ntags:\n  Where: {state: arm/joint_9/position, type: number}\n");
  folder.write("job.script", "moveto joints(0, 0, 0, 0, 0, 0)\n");
  cell("", "signals: signals.yaml\nprogram: job.script\n");
  EXPECT_EQ(both().find("signals.yaml:3 the tag 'Where' reads 'arm/joint_9/position', which nothing offers"),
            0u);
  EXPECT_EQ(checked().find('\n'), checked().size() - 1) << checked();
  folder.write("places.points",
               "Pose: RPY\nName: A\nPoint: nan, 0, 1, 0, 0, 0\nName: B\nPoint: 0.3, 0, 1, 0, 0, 0\n");
  folder.write("job.script", "load places\nmovej A\nmovej B\n");
  cell("", "program: job.script\n");
  EXPECT_EQ(run().find("places.points:3 'nan' is not a number here"), 0u) << run();
  EXPECT_EQ(run().find('\n'), run().size() - 1) << "what comes of it is not an error of its own: " << run();
}

TEST_F(Mistakes, NamesThatOnlyThePlcLoadsAreKnown) {
  folder.write("settings.data", "Name: Delay\nValue: 20ms\n");
  folder.write("job.script", "wait Delay\n");
  folder.write("plc.script", "load settings\nwait Delay\n");
  cell("", "program: job.script\nplc: plc.script\n");
  EXPECT_EQ(both(), "");
  folder.write("job.script", "wait Delai\n");
  EXPECT_NE(both().find("job.script:1 there is nothing called 'Delai'; did you mean 'Delay'?"),
            std::string::npos);
}

TEST_F(Mistakes, WhoSetsATagThatALinkBringsIsWarned) {
  const std::string link =
      "polyarm: signals/1\ntags:\n  Lamp: {initial: false}\nlinks:\n  plc: {modbus: client, port: 1502, "
      "tags: "
      "{Go: {coil: 0, direction: in}, Done: {coil: 1, direction: both}}}\n";
  folder.write("signals.yaml", link);
  folder.write("job.script", "wait Go\nset Done = true\nset Go = false\n");
  cell("", "signals: signals.yaml\nprogram: job.script\n");
  const std::string text =
      "job.script:3 'Go' comes from the link 'plc': what a program sets holds until the other side changes "
      "it "
      "(wait for it; if both sides set it, say direction: both in signals.yaml)\n";
  EXPECT_EQ(checked(), text);
  EXPECT_EQ(run(), "") << "a warning";
  folder.write("job.script", "wait Go\n");
  folder.write("plc.script", "wait Lamp\nwait Lamp\nset Go = false\n");
  cell("", "signals: signals.yaml\nprogram: job.script\nplc: plc.script\n");
  EXPECT_EQ(checked(), "plc" + text.substr(3));
  folder.write("signals.yaml",
               "polyarm: signals/1\nlinks:\n  eye: {mqtt: client, tags: {Go: {topic: go, direction: in}}}\n");
  folder.write("job.script", "wait Go\nset Go = false\n");
  cell("", "signals: signals.yaml\nprogram: job.script\n");
  EXPECT_EQ(checked(), "") << "a message is taken back, so that the next one is seen";
}

TEST_F(Mistakes, AControllerWithoutJointsSaysSo) {
  folder.write(
      "controllers.yaml",
      "controller_manager:\n  ros__parameters:\n    update_rate: 100\n    arm: {type: "
      "joint_trajectory_controller/JointTrajectoryController}\n    push: {type: "
      "forward_command_controller/ForwardCommandController}\narm:\n  ros__parameters:\n    joints: []\n"
      "push:\n  ros__parameters:\n    interface_name: position\n");
  cell("", "controllers: controllers.yaml\n");
  const std::string told = checked();
  EXPECT_NE(told.find("controllers.yaml:8 the controller 'arm' is left unconfigured: 'joints' names no joint "
                      "(write joints: [NAME, "
                      "…])"),
            std::string::npos)
      << told;
  EXPECT_NE(told.find("'push' is left unconfigured: the controller has no joints"), std::string::npos)
      << told;
}

/// What a cell says that waits for `Ready` of cycledata, which nobody sets.
std::string waiting(const test::Folder& folder, const std::string& signals, const std::string& plc = "") {
  folder.write("cycledata.data", "Name: Ready\nBool: False\n");
  folder.write("job.script", "load cycledata\nwait Ready\n");
  folder.write("signals.yaml", "polyarm: signals/1\n" + signals);
  folder.write("plc.script", plc + "wait false\n");
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes +
                   ", hardware: mock}\nprogram: job.script\nsignals: signals.yaml\nplc: plc.script\n");
  test::LockStepCell cell(read_cell_file(folder.path()));
  cell.run(4);
  if (cell.cell().failure()) return cell.cell().failure()->problem.advice;
  return cell.told("set live: [cycledata]") > 0 ? "a note" : "";
}

TEST_F(Mistakes, WhoWaitsForWhatAnotherProgramWritesIsToldOfLiveFiles) {
  EXPECT_EQ(waiting(folder, ""),
            "nothing in the cell sets 'Ready', which comes from cycledata.data: the run has a copy of that "
            "file; if another program writes it, set live: [cycledata] in signals.yaml");
  EXPECT_EQ(waiting(folder, "live: [cycledata]\n"), "") << "somebody outside may write it";
  EXPECT_EQ(waiting(folder, "", "if Ready\n  set Ready = true\nend\n"), "check what should set these tags");
}

TEST_F(Mistakes, ATableIsReadWhereACheckFollowsTheProgram) {
  cell("", "program: go.script\n");
  folder.write("parts.csv", "name;x\nlid;12mm\nbox;40mm\n");
  folder.write("go.script", "let rows = rows_of(\"parts.csv\")\nlog(rows[2].name)\nlog(rows[3].name)\n");
  Problem found = check(folder.path(), {}, description::Catalogue({}), {}).problems.at(0);
  EXPECT_EQ(found.severity, Severity::error) << found.text();
  EXPECT_EQ(found.where.line, 3) << found.text();
  folder.write("go.script", "for row in rows_of(\"orders.csv\")\n  log(row)\nend\n");
  found = check(folder.path(), {}, description::Catalogue({}), {}).problems.at(0);
  EXPECT_EQ(found.code, "no-table") << found.text();
  EXPECT_EQ(found.severity, Severity::warning) << "another program may write it before the run";
}

TEST_F(Mistakes, AJointThatTurnsTakesNoLength) {
  cell("", "program: go.script\n");
  folder.write("go.script", "movej joints(0, -30deg, 60mm, 0, 60deg, 0)\n");
  const Problem found = check(folder.path(), {}, description::Catalogue({}), {}).problems.at(0);
  EXPECT_EQ(found.code, "joint-unit") << found.text();
  EXPECT_EQ(found.severity, Severity::error);
  EXPECT_EQ(found.where.line, 1);
}

}  // namespace
}  // namespace polyarm::cell
