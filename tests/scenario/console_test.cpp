/// The console: a transcript for each menu from a pipe, and keys at a pseudo-terminal.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "polyarm/base/file.hpp"
#include "polyarm/data/import_format.hpp"
#include "tests/support/at_terminal.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::AtTerminal;
using test::Command;
using test::Finished;
using test::run_command;
namespace fs = std::filesystem;

class Console : public ::testing::Test {
 protected:
  Console() {
    std::string pattern = (fs::temp_directory_path() / "polyarm_con_XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
    work = folder / "work";
    fs::create_directory(work);
    ::setenv("XDG_RUNTIME_DIR", folder.c_str(), 1);
  }
  ~Console() override {
    ::unsetenv("XDG_RUNTIME_DIR");
    fs::remove_all(folder);
  }
  /// The console in the working folder, told these lines.
  Finished told(const std::vector<std::string>& lines, const std::string& options = "") {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    write_file_atomically(folder / "answers.txt", text);
    const std::string command =
        POLYARM_COMMAND " console " + work.string() + options + " < " + (folder / "answers.txt").string() + " 2>&1";
    std::FILE* const out = ::popen(command.c_str(), "r");
    Finished done;
    char part[4096];
    while (const std::size_t n = std::fread(part, 1, sizeof part, out)) done.output.append(part, n);
    const int status = ::pclose(out);
    done.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return done;
  }
  data::DataSet values(const std::string& name) const {
    return data::ImportFile::load((work / name).string()).values();
  }
  static bool has(const Finished& of, const std::string& text) {
    return of.output.find(text) != std::string::npos;
  }
  /// The parts stand in the output in this order.
  static ::testing::AssertionResult in_order(const Finished& of, const std::vector<std::string>& parts) {
    std::size_t at = 0;
    for (const std::string& part : parts) {
      const auto found = of.output.find(part, at);
      if (found == std::string::npos)
        return ::testing::AssertionFailure() << "'" << part << "' is not there (any more) in\n" << of.output;
      at = found + part.size();
    }
    return ::testing::AssertionSuccess();
  }

  fs::path folder, work;
};

TEST_F(Console, TheMenusAreTheThesissAsTheyArePrinted) {
  const Finished shown = told({"1", "3", "11", "0", "2", "0", "4", "0", "0"});
  EXPECT_EQ(shown.exit_code, 0) << shown.output;
  EXPECT_TRUE(in_order(shown, {"universal_robots/ur3", "1->Start Simulation\n", "3->Select Robot\n",
                               "0->Exit\n", "Main Menu", "File Editor", "0->Exit\n"}));
  EXPECT_TRUE(in_order(shown, {"1->RQT Joint Trajectory Controller Start\n"
                               "2->Move Joints\n"
                               "3->Move TCP Pose\n"
                               "4->Move Robot To Input JS\n"
                               "5->Move Robot To Input POSE\n"
                               "6->Move Robot To File Point\n"
                               "7->Move Robot To Input JS Trajectory\n"
                               "8->Move Robot To Input POSE Trajectory\n"
                               "9->Move Robot To File Trajectory\n"
                               "10->Move Robot To Input or File Trajectory\n"
                               "11->Change Duration Input method to Manual\n"
                               "12->Change Automatic Duration Scale\n"
                               "0->Exit\n",
                               "11->Change Duration Input method to Automatic\n"}));
  EXPECT_TRUE(in_order(
      shown,
      {"1->Load File\n", "2->Save File\n", "3->Save File as\n", "4->List Files in Directory\n",
       "5->Delete Data File\n", "6->Save Current JS\n", "7->Save Current Pose\n", "8->Save Input JS\n",
       "9->Save Input Pose\n", "10->Save Input Boolean\n", "11->Save Input Number\n", "12->Save Input Text\n",
       "13->Import From Text File\n", "14->Delete Point\n", "15->List Keys\n", "0->Exit\n"}));
}

TEST_F(Console, ARobotIsFoundInTheCatalogueByNumberPartOrName) {
  const Finished found =
      told({"3", "fanuc lr mate 200id", "", "3", "UNIVERSAL_ROBOTS/UR5E", "3", "ur 99", "", "3", "1", "0"});
  EXPECT_TRUE(in_order(found, {"universal_robots/ur3", "fanuc\n", " lr_mate_200id_4s", "nothing was changed",
                               "robot: universal_robots/ur5e", "no robot is called 'ur 99'", "robot: abb/"}));
  EXPECT_EQ(found.exit_code, 1) << "something was refused";
}

TEST_F(Console, TheEditorKeepsValuesOfEveryKindAndAsksBeforeItOverwrites) {
  const Finished done =
      told({"4",  // file editor
            "10",    "True",    "Repeat", "11",    "40mm",    "Height", "12",   "PAPpoints", "PointFile",
            "9",     "0.3",     "150mm",  "0.04",  "",        "180deg", "0",    "0",         "Pick",
            "8",     "0",       "-90deg", "90deg", "0",       "0",      "0",    "Home",      "10",
            "False", "Repeat",  "n",      "y",     "Repeat2",  // exists: no, another name
            "10",    "False",   "Repeat", "y",                 // overwritten
            "10",    "perhaps", "True",   "Sure",  "15",      "3",      "mine", "0",         "0"});
  EXPECT_TRUE(in_order(
      done, {"no file yet", "Repeat = True", "* (not saved)", "'Repeat' exists already: True. Overwrite it?",
             "Choose another name?", "Repeat2 = False", "'perhaps' is not a boolean", "Sure = True", "NAME",
             "saved 7 values in mine.data"}));
  const data::DataSet kept = values("mine.data");
  EXPECT_EQ(*kept.value("Repeat"), data::Value(false));
  EXPECT_EQ(*kept.value("Repeat2"), data::Value(false));
  EXPECT_EQ(kept.value("Height")->as_number()->value, 0.04);
  EXPECT_EQ(*kept.value("PointFile"), data::Value("PAPpoints"));
  EXPECT_NEAR(kept.value("Pick")->as_point()->pose.position.y, 0.15, 1e-12);
  EXPECT_NEAR(*kept.value("Home")->as_joints()->find("elbow_joint"), M_PI / 2, 1e-12);
}

TEST_F(Console, FilesAreLoadedMadeSavedAndDeletedAfterQuestions) {
  write_file_atomically(work / "one.data", "# mine\nName: A\nNum: 1 # of them\nName: B\nNum: 2\n");
  write_file_atomically(work / "two.data", "Name: C\nNum: 3\n");
  const Finished done =
      told({"4",   "1",     "none", "n",  // not found, not made
            "1",   "one",   "14",   "A",   "n",   "14", "A",       "y", "1", "two", "",  // unsaved: stays
            "3",   "two",   "n",  // exists: not overwritten
            "3",   "three", "4",    "1",   "new", "y",  "11",      "7", "N", "2",   "5",
            "two", "n",     "5",    "two", "y",   "5",  "nothing", "0", "0"});
  EXPECT_TRUE(in_order(
      done, {"There is no file 'none'", "Create it?", "one.data: 2 values", "Delete A = 1?", "deleted A",
             "one.data has changes that are not saved", "two.data exists already. Overwrite it?",
             "saved 1 values in three.data", "new.data is new", "saved 1 values in new.data",
             "Delete two.data?", "deleted two.data", "there is no data file 'nothing'"}));
  EXPECT_EQ(read_file(work / "one.data"), "# mine\nName: A\nNum: 1 # of them\nName: B\nNum: 2\n");
  EXPECT_EQ(read_file(work / "three.data"), "# mine\nName: B\nNum: 2\n");
  EXPECT_FALSE(fs::exists(work / "two.data"));
  EXPECT_EQ(*values("new.data").value("N"), data::Value(7));
}

TEST_F(Console, TheThesissTextFilesAreImportedAndAPickleIsRefused) {
  write_file_atomically(work / "listing1.txt",
                        "Name: ScriptFile\nText: cycle\n\nName: Repetitions\nNum: 10\n\nName: GripperActive\n"
                        "Bool: False\nJS: elbow_joint shoulder_lift_joint shoulder_pan_joint wrist_1_joint "
                        "wrist_2_joint wrist_3_joint\nName: Home\nPoint: 0.0, 0.0, 0.0, 0.0, 0.0, 0.0\n\n"
                        "Name: DropPoint\nPoint: 0.5, 0.2, 2.0, 0.0, 0.0, 0.0\n\nPose: RPY\nName: PickPoint\n"
                        "Point: 5.0, 3.0, 2.0, 0.0, 0.0, 0.0\n");
  write_file_atomically(work / "old.data", std::string("\x80\x04\x95\x10\x00", 5));
  write_file_atomically(work / "broken.txt", "Name: A\nBol: True\n");
  const Finished done =
      told({"4", "13", "listing1", "13", "listing1", "13", "broken", "3", "kept", "1", "old", "0", "0"});
  EXPECT_TRUE(in_order(done, {"imported 6 values of listing1.txt", "6 of them over those of the same name"}));
  EXPECT_TRUE(has(done, "pickle")) << done.output;
  EXPECT_TRUE(has(done, "did you mean 'Bool'")) << done.output;
  EXPECT_EQ(*values("kept.data").value("DropPoint")->as_joints()->find("shoulder_pan_joint"), 2.0);
}

TEST_F(Console, AValueIsEditedPartByPartAndWhatIsNotSaidStays) {
  write_file_atomically(
      work / "p.points",
      "Pose: RPY\nName: P\nPoint: 0.1, 0.2, 0.3, 0, 0, 1\nName: Q\nPoint: 1, 1, 1, 0, 0, 0\n");
  const Finished done = told({"4", "1", "p", "16", "P", "", "250mm", "", "", "", "", "2", "0", "0"});
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_EQ(read_file(work / "p.points"),
            "Pose: RPY\nName: P\nPoint: 0.1, 0.25, 0.3, 0, 0, 1\nName: Q\nPoint: 1, 1, 1, 0, 0, 0\n");
}

TEST_F(Console, APointInAFrameKeepsItWhenEditedAndTheRobotGoesWhereTheFrameIs) {
  write_file_atomically(work / "p.points",
                        "Pose: RPY\nName: table\nPoint: 0.2, 0.1, 0, 0, 0, 0\nName: P\nPoint: 0.05, 0, 0.2, "
                        "3.141592653589793, 0, 0; frame = \"table\"\n");
  const Finished done =
      told({"1", "2", "1", "p", "16", "P", "",  "",  "0.25", "", "", "", "2", "0",  // edited
            "3", "6", "p", "P", "10", "L", "P", "0", "0"});
  EXPECT_TRUE(in_order(done, {"arrived after", "TCP x 250.00 y 100.00 z 250.00 mm", "arrived after",
                              "TCP x 250.00 y 100.00 z 250.00 mm"}));
  EXPECT_NE(
      read_file(work / "p.points").find("Point: 0.05, 0, 0.25, 3.141592653589793, 0, 0; frame = \"table\""),
      std::string::npos)
      << read_file(work / "p.points");
}

TEST_F(Console, TheEndOfTheAnswersEndsItCleanlyAndLosesNothing) {
  const Finished clean = told({"1", "3"});
  EXPECT_EQ(clean.exit_code, 0) << clean.output;
  EXPECT_NE(run_command({"health"}).exit_code, 0) << "its cell is gone too";
  const Finished unsaved = told({"4", "11", "7", "N"});
  EXPECT_EQ(unsaved.exit_code, 1);
  EXPECT_TRUE(has(unsaved, "unsaved values are in")) << unsaved.output;
  EXPECT_EQ(*values("editor.unsaved.txt").value("N"), data::Value(7));
}

TEST_F(Console, PointsAreTaughtAndTheRobotGoesToThemAndBack) {
  const Finished done =
      told({"1",     "2",    "6",    "Start", "7",   "StartPose", "0",       "3", "4", "0.2",
            "-1.4",  "1.2",  "-1.3", "-1.5",  "0.1",                               // input JS
            "5",     "0.25", "0.1",  "0.25",  "rpy", "180deg",    "0",       "0",  // input pose
            "0",     "2",    "7",    "There", "3",   "mine",      "0",       "3", "6", "mine",
            "Start", "6",    "mine", "There", "6",   "mine",      "Nowhere", "0", "0"});
  EXPECT_TRUE(in_order(done, {"Start = ", "arrived after", "arrived after",
                              "TCP x 250.00 y 100.00 z 250.00 mm", "There = ", "arrived after",
                              "arrived after", "TCP x 250.00 y 100.00 z 250.00 mm", "has no 'Nowhere'"}));
  EXPECT_NE(values("mine.points").value("There"), nullptr);
}

TEST_F(Console, AMixedTrajectoryIsOnePathAndDurationsAreAskedOrComputed) {
  write_file_atomically(
      work / "f.points",
      "JS: shoulder_pan_joint shoulder_lift_joint elbow_joint wrist_1_joint wrist_2_joint wrist_3_joint\n"
      "Name: A\nPoint: 0.3, -1.5, 1.5, -1.5, -1.5, 0\nName: B\nPoint: 0.6, -1.3, 1.4, -1.5, -1.5, 0\n");
  const std::vector<std::string> js = {"0", "-1.5", "1.5", "-1.5", "-1.5", "0"};
  std::vector<std::string> lines = {"1", "2", "1", "f", "0", "3", "4"};
  lines.insert(lines.end(), js.begin(), js.end());
  lines.insert(lines.end(), {"10", "js, F L p"});
  lines.insert(lines.end(), {"0.1", "-1.4", "1.5", "-1.5", "-1.5", "0"});
  lines.insert(lines.end(), {"f", "A", "B", "0.25", "0.1", "0.25", "", "180deg", "0", "0"});
  lines.insert(lines.end(),
               {"9", "f", "A, B", "10", "X", "12", "0", "11", "6", "f", "A", "-1", "4", "0", "0"});
  const Finished done = told(lines);
  EXPECT_TRUE(in_order(done, {"Types in their order", "arrived after", "TCP x 250.00 y 100.00 z 250.00 mm",
                              "arrived after", "'X' is not a type of a point",
                              "Duration of the move to A in s", "takes more than 0 s", "arrived after 4."}));
}

TEST_F(Console, JointValuesOfAFileGoToTheRobotWithTheirUnits) {
  write_file_atomically(
      work / "f.points",
      "JS: shoulder_pan_joint shoulder_lift_joint elbow_joint wrist_1_joint wrist_2_joint wrist_3_joint\n"
      "Name: A\nPoint: 0.3, -1.5, 150mm, -1.5, -1.5, 0\nName: B\nPoint: 20deg, -1.3, 80deg, -1.5, -1.5, 0\n");
  const Finished done = told({"1", "3", "6", "f", "A", "6", "f", "B", "0", "0"});
  EXPECT_TRUE(in_order(done, {"is 0.15m, not an angle", "arrived after"}));
}

TEST_F(Console, WithoutATerminalJogAndSlidersTakeSteps) {
  const Finished done = told({"1", "3", "3", "z -20mm tool", "x 5", "w 5mm", "", "2", "elbow_joint 5deg", "",
                              "1", "elbow_joint -5deg", "elbow_jont 1deg", "", "0", "0"});
  EXPECT_TRUE(in_order(done, {"Axis, distance and frame", "x ", "Joint and distance", "elbow_joint",
                              "Joint and distance", "did you mean 'elbow_joint'"}));
  EXPECT_EQ(done.exit_code, 1);
}

TEST_F(Console, AScriptIsLoadedStartedSteppedAndEnded) {
  write_file_atomically(
      work / "places.points",
      "JS: shoulder_pan_joint shoulder_lift_joint elbow_joint wrist_1_joint wrist_2_joint wrist_3_joint\n"
      "Name: A\nPoint: 0.3, -1.5, 1.5, -1.5, -1.5, 0\nName: B\nPoint: 0.5, -1.5, 1.5, -1.5, -1.5, 0\n");
  write_file_atomically(
      work / "info.data",
      "Name: PointFile\nText: places\nName: ScriptFile\nText: work\nName: Repeat\nBool: True\n");
  write_file_atomically(
      work / "work.script",
      "load info\nwhile Repeat\nmoveto A\nwait user\nmoveto B\nendwhile\nlog \"all done\"\n");
  write_file_atomically(work / "wrong.script", "moveto C\nendwhile\n");
  const Finished done = told({"1", "4",    "3", "1", "wrong.script",
                              "1", "info", "5", "5", "5",
                              "9",
                              "8",                   // ended
                              "3", "1",    "",  "",  // once round, and an answer for the question
                              "7", "7",    "y", "0", "0"});
  EXPECT_TRUE(in_order(done, {"no script is loaded", "wrong.script", "loaded work.script",
                              "paused before line 1", "paused before line 2", "paused before line 3",
                              "Repeat = True", "the script was ended", "moveto A", "The script waits for you",
                              "moveto B", "all done", "the script has ended", "it will begin at line 7",
                              "the robot is as after the move to: B", "all done", "the script has ended"}));
}

TEST_F(Console, TheThesissPickAndPlaceRunsFromItsCell) {
  for (const auto& entry : fs::directory_iterator(fs::path(POLYARM_SOURCE_DIR) / "examples/pick_and_place"))
    if (entry.is_regular_file()) fs::copy_file(entry.path(), work / entry.path().filename());
  const Finished done = told({"1", "4", "1", "cycledata", "5", "5", "9", "8", "0", "0"});
  EXPECT_TRUE(in_order(done, {"the robots of cell.yaml", "loaded PAPscript.script", "paused before line 2",
                              "GripperActive = False", "the script was ended"}));
  EXPECT_EQ(done.exit_code, 0) << done.output;
}

TEST_F(Console, SlidersNameThePendantWhereOneIsServed) {
  fs::create_directory(folder / "bench");
  write_file_atomically(folder / "bench/cell.yaml",
                        "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur5e}\n");
  Command running({"run", (folder / "bench").string(), "--quiet", "--pendant", "--port", "0"});
  for (int tries = 0; tries < 5000 && run_command({"health"}).exit_code != 0; ++tries) {
  }
  const Finished done = told({"2", "", "3", "1", "", "0", "0", "0"});
  EXPECT_TRUE(in_order(done, {"Move Menu", "the pendant has sliders, too: http://"}));
}

TEST_F(Console, ACellThatCannotStartSaysWhy) {
  write_file_atomically(work / "cell.yaml",
                        "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur33}\n");
  const Finished done = told({"1", "0"});
  EXPECT_TRUE(in_order(done, {"the simulation has not started", "ur33", "console.log"}));
}

TEST_F(Console, WhatItsCommandLineAllowsHoldsForTheCellThatItStarts) {
  write_file_atomically(folder / "outside.yaml", "polyarm: scene/1\nfloor: {height: -0.75}\n");
  write_file_atomically(work / "cell.yaml",
                        "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur3, hardware: mock}\n"
                        "scene: ../outside.yaml\n");
  EXPECT_TRUE(has(told({"1", "0", "0"}), "the simulation has not started"));
  const Finished done = told({"1", "0", "0"}, " --allow " + (folder / "outside.yaml").string());
  EXPECT_FALSE(has(done, "the simulation has not started")) << done.output;
  EXPECT_TRUE(has(done, "is running; its files are in")) << done.output;
}

TEST_F(Console, AnotherCellIsConnectedWithAndStaysWhenTheConsoleLeaves) {
  fs::create_directory(folder / "bench");
  write_file_atomically(folder / "bench/cell.yaml",
                        "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur5e}\n");
  write_file_atomically(folder / "bench/p.points",
                        "Pose: RPY\nName: P\nPoint: 0.4, 0.1, 0.4, 3.14159, 0, 0\n");
  Command running({"run", (folder / "bench").string(), "--quiet"});
  for (int tries = 0; tries < 5000 && run_command({"health"}).exit_code != 0; ++tries) {
  }
  const Finished done = told({"2", "", "2", "4", "0", "3", "6", "p", "P", "0", "5", "0"});
  EXPECT_TRUE(in_order(done, {"Connect with 'bench'?", "p.points", "arrived after", "TCP x 400.00",
                              "Connect To A Running Cell"}));
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_EQ(run_command({"health"}).exit_code, 0);
}

TEST_F(Console, AtATerminalKeysJogAndEnterKeepsThePlace) {
  AtTerminal keys({"console", work.string()});
  keys.type("1\n3\n2\n");
  ASSERT_TRUE(keys.shows("Hold a key to move"));
  ASSERT_TRUE(keys.shows("joints, 5.73"));
  keys.type("q");
  ASSERT_TRUE(keys.shows(">shoulder_pan_joint"));
  keys.type("\n");
  ASSERT_TRUE(keys.shows("Store it as a joint state"));
  keys.type("y\nTaught\n");
  ASSERT_TRUE(keys.shows("kept as Taught"));
  keys.type("\x03");
  ASSERT_TRUE(keys.shows("0->Exit"));
  keys.type("1\n");
  ASSERT_TRUE(keys.shows("the robot follows them"));
  keys.type("\x1b[C\x1b[C");
  ASSERT_TRUE(keys.shows("of the speed limits"));
  keys.type("0");
  ASSERT_TRUE(keys.shows("0->Exit"));
  keys.type("0\n2\n3\ntaught\n0\n0\n");
  EXPECT_EQ(keys.ends(), 0) << keys.seen();
  EXPECT_TRUE(keys.is_as_it_was());
  EXPECT_NE(values("taught.points").value("Taught"), nullptr);
}

TEST_F(Console, CtrlCStopsAMoveOnItsPathAndAsks) {
  AtTerminal keys({"console", work.string()});
  keys.type("1\n3\n12\n20\n4\n2\n-1\n1\n-1\n-1\n0\n");
  ASSERT_TRUE(keys.shows("Ctrl-C stops it"));
  for (int tries = 0; tries < 5000; ++tries) {
    const auto health = nlohmann::json::parse(run_command({"health", "--json"}).output, nullptr, false);
    if (health.is_object() && !health["standing"].get<bool>()) break;
  }
  keys.signal(SIGINT);
  ASSERT_TRUE(keys.shows("stopped on its path"));
  keys.type("0\n");
  ASSERT_TRUE(keys.shows("TCP x"));
  keys.type("0\n0\n");
  EXPECT_EQ(keys.ends(), 0) << keys.seen();
}

}  // namespace
}  // namespace polyarm
