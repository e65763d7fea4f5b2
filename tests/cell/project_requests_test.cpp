/// Requests about points, files and texts of the project that a cell runs, and about other cells; in
/// lock-step.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <random>

#include "polyarm/base/error.hpp"
#include "polyarm/data/import_format.hpp"
#include "polyarm/inside/requests_later.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::Json;
using test::LockStepCell;

const char* const kPoints =
    "Name: Home\nJS: joint_1 joint_2 joint_3 joint_4 joint_5 joint_6\nPoint: 0, 0.4, 0.8, 0, 0.6, 0\n"
    "Name: Bench\nPose: RPY\nPoint: 0.3, 0.1, 0.2, 0, 0, 1.5707963267948966\n"
    "Name: Count\nNum: 3\n";
const char* const kScript = "load points\nmovej Home\n# Home in a comment\nlog \"done\"\n";

class ProjectTest : public ::testing::Test {
 protected:
  ProjectTest() {
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes +
                                  ", hardware: mock}\nprogram: main.script\n");
    folder.write("points.points", kPoints);
    folder.write("main.script", kScript);
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
    cell->run(6);
  }
  Json result(Json request) { return cell->result(request); }
  std::string code(const Json& request) {
    const Json answer = cell->ask(request);
    return answer.value("ok", false) ? "ok" : answer["error"]["code"].get<std::string>();
  }
  Json point(const std::string& name) {
    const Json all = result({{"request", "points"}});
    for (const Json& each : all["values"])
      if (each["name"] == name) return each;
    return {};
  }
  data::DataSet file() { return data::ImportFile::load((folder.path() / "points.points").string()).values(); }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(ProjectTest, WhatSomebodyWritesIntoTheFileIsToldAndTakenWhenSomebodySaysSo) {
  EXPECT_TRUE(result({{"request", "points.outside"}})["files"].empty());
  result({{"request", "points.teach"}, {"name", "Own"}});
  EXPECT_TRUE(result({{"request", "points.outside"}})["files"].empty()) << "what the cell itself wrote";
  std::string text = read_file(folder.path() / "points.points");
  text.replace(text.find("0.3, 0.1, 0.2"), 13, "0.3, 0.1, 0.4");
  text.replace(text.find("Name: Count\nNum: 3\n"), 19,
               "Name: New\nGroup: by hand\nPoint: 0.4, 0, 0.3, 0, 0, 0\n");
  folder.write("points.points", text);
  const Json told = result({{"request", "points.outside"}})["files"];
  ASSERT_EQ(told.size(), 1u) << told;
  EXPECT_EQ(told[0]["file"], "points.points");
  EXPECT_EQ(told[0]["changed"], Json({"Bench"}));
  EXPECT_EQ(told[0]["added"], Json({"New"}));
  EXPECT_EQ(told[0]["removed"], Json({"Count"}));
  EXPECT_NEAR(point("Bench")["pose"]["p"][2].get<double>(), 0.2, 1e-9) << "nothing is taken by itself";
  result({{"request", "points.set"}, {"name", "Own"}, {"value", "pose(0.3, 0, 0.2, 0, 0, 0)"}});
  EXPECT_EQ(result({{"request", "points.outside"}})["files"], told)
      << "a change by the page hides none of it";
  EXPECT_EQ(result({{"request", "points.take"}})["files"], told);
  EXPECT_NEAR(point("Bench")["pose"]["p"][2].get<double>(), 0.4, 1e-9);
  EXPECT_EQ(point("New")["group"], "by hand");
  EXPECT_TRUE(point("Count").is_null());
  EXPECT_FALSE(point("Own").is_null());
  EXPECT_TRUE(result({{"request", "points.outside"}})["files"].empty());
  folder.write("points.points", "this is not a data file");
  EXPECT_TRUE(result({{"request", "points.outside"}})["files"].empty()) << "a broken file is nobody's news";
}

TEST_F(ProjectTest, PointsAreListedWithTheirFileAndPlace) {
  const Json all = result({{"request", "points"}});
  EXPECT_EQ(all["file"], "points.points");
  EXPECT_EQ(point("Home")["kind"], "joints");
  EXPECT_NEAR(point("Home")["joints"]["joint_3"].get<double>(), 0.8, 1e-12);
  EXPECT_EQ(point("Bench")["kind"], "pose");
  EXPECT_NEAR(point("Bench")["world"]["p"][0].get<double>(), 0.3, 1e-12);
  EXPECT_EQ(point("Count")["value"], 3);
}

TEST_F(ProjectTest, WhereTheRobotStandsIsTaughtIntoTheUsersFileAndTheRunningCell) {
  const Json here = result({{"request", "points.here"}});
  const Json taught = result({{"request", "points.teach"}, {"name", "Pick"}});
  ASSERT_EQ(taught.value("name", ""), "Pick") << taught;
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(taught["pose"]["p"][k].get<double>(), here["tcp"]["p"][k].get<double>(), 1e-9);
  ASSERT_NE(file().value("Pick"), nullptr) << "it stands in the file";
  EXPECT_TRUE(cell->cell().store().find("Pick")->as_point());
  EXPECT_EQ(code({{"request", "points.teach"}, {"name", "Pick"}}), "exists");
  EXPECT_EQ(code({{"request", "points.teach"}, {"name", "Pick"}, {"replace", true}}), "ok");
  EXPECT_EQ(code({{"request", "points.teach"}, {"name", "Count"}, {"replace", true}}), "exists")
      << "a number does not become a point";
  EXPECT_EQ(code({{"request", "points.teach"}, {"name", "two words"}}), "bad-name");
  const Json joints = result({{"request", "points.teach"}, {"name", "Stand"}, {"kind", "joints"}});
  EXPECT_NEAR(joints["joints"]["joint_2"].get<double>(), 0.4, 1e-3);
}

TEST_F(ProjectTest, APointTaughtInAFrameStandsWhereTheRobotStands) {
  const Json world = result({{"request", "points.teach"}, {"name", "A"}});
  const Json framed = result({{"request", "points.teach"}, {"name", "B"}, {"frame", "Bench"}});
  EXPECT_EQ(framed["taught"]["frame"], "Bench");
  EXPECT_NE(framed["pose"], world["pose"]);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(framed["world"]["p"][k].get<double>(), world["world"]["p"][k].get<double>(), 1e-9);
  EXPECT_EQ(code({{"request", "points.teach"}, {"name", "C"}, {"frame", "Moon"}}), "unknown-frame");
  EXPECT_EQ(code({{"request", "points.teach"}, {"name", "C"}, {"frame", "Count"}}), "unknown-frame");
}

TEST_F(ProjectTest, PointsAreShiftedRenamedDeletedAndAllIsTakenBack) {
  const std::string before = read_file(folder.path() / "points.points");
  const Json shifted =
      result({{"request", "points.shift"}, {"names", {"Bench"}}, {"by", {{"x", "10mm"}, {"rz", 0.1}}}});
  EXPECT_NEAR(shifted["values"][0]["pose"]["p"][0].get<double>(), 0.31, 1e-9) << shifted;
  const Json own =
      result({{"request", "points.shift"}, {"names", {"Bench"}}, {"by", {{"x", 0.1}}}, {"along", "own"}});
  EXPECT_NEAR(own["values"][0]["pose"]["p"][0].get<double>(),
              0.31 + 0.1 * std::cos(std::numbers::pi / 2 + 0.1), 1e-9);
  EXPECT_EQ(code({{"request", "points.shift"}, {"names", {"Home"}}, {"by", {{"x", 1}}}}), "bad-points");
  const Json renamed = result({{"request", "points.rename"}, {"name", "Home"}, {"to", "Ready"}});
  ASSERT_EQ(renamed["uses"].size(), 1u) << renamed << " the comment does not count";
  EXPECT_EQ(renamed["uses"][0]["line"], 2);
  EXPECT_TRUE(point("Home").is_null());
  EXPECT_EQ(point("Ready")["kind"], "joints");
  EXPECT_EQ(code({{"request", "points.delete"}, {"name", "Ready"}}), "ok");
  EXPECT_EQ(file().find("Ready"), nullptr);
  EXPECT_EQ(cell->cell().store().find("Ready"), nullptr);
  EXPECT_EQ(result({{"request", "points.history"}})[0]["what"], "delete Ready");
  EXPECT_EQ(result({{"request", "points.undo"}})["what"], "delete Ready");
  EXPECT_EQ(point("Ready")["kind"], "joints");
  EXPECT_EQ(code({{"request", "points.undo"}, {"steps", 3}}), "ok");
  EXPECT_EQ(read_file(folder.path() / "points.points"), before);
  EXPECT_EQ(point("Home")["kind"], "joints");
  EXPECT_NEAR(point("Bench")["pose"]["p"][0].get<double>(), 0.3, 1e-12);
}

TEST_F(ProjectTest, PointsAreGroupedByALineOfTheirFile) {
  const std::string before = read_file(folder.path() / "points.points");
  const Json grouped =
      result({{"request", "points.group"}, {"names", {"Bench", "Home"}}, {"group", " conveyor "}});
  ASSERT_EQ(grouped["values"].size(), 2u) << grouped;
  EXPECT_EQ(grouped["values"][0]["group"], "conveyor");
  EXPECT_EQ(point("Home")["group"], "conveyor");
  EXPECT_EQ(point("Count")["group"], "");
  EXPECT_EQ(
      read_file(folder.path() / "points.points"),
      "Name: Home\nJS: joint_1 joint_2 joint_3 joint_4 joint_5 joint_6\nGroup: conveyor\nPoint: 0, 0.4, 0.8, "
      "0, 0.6, 0\nName: Bench\nPose: RPY\nGroup: conveyor\nPoint: 0.3, 0.1, 0.2, 0, 0, "
      "1.5707963267948966\nName: Count\nNum: 3\n");
  const Json taught = result({{"request", "points.teach"}, {"name", "Pick"}, {"group", "table"}});
  EXPECT_EQ(taught["group"], "table") << taught;
  result({{"request", "points.teach"}, {"name", "Pick"}, {"replace", true}});
  EXPECT_EQ(point("Pick")["group"], "table") << "touching up leaves it where it is";
  result({{"request", "points.rename"}, {"name", "Pick"}, {"to", "Grip"}});
  result({{"request", "points.shift"}, {"names", {"Bench"}}, {"by", {{"x", 0.01}}}});
  result({{"request", "program.from"}, {"line", 1}, {"confirmed", true}});
  EXPECT_EQ(point("Grip")["group"], "table") << "and so does a new name, and loading anew";
  EXPECT_EQ(point("Bench")["group"], "conveyor");
  EXPECT_EQ(code({{"request", "points.group"}, {"names", {"Bench"}}, {"group", ""}}), "ok");
  EXPECT_EQ(point("Bench")["group"], "");
  EXPECT_EQ(code({{"request", "points.undo"}}), "ok");
  EXPECT_EQ(point("Bench")["group"], "conveyor") << "what is undone is seen at once";
  result({{"request", "points.delete"}, {"name", "Grip"}});
  EXPECT_EQ(point("Bench")["group"], "conveyor") << "what goes takes no other out of its group";
  EXPECT_EQ(code({{"request", "points.undo"}, {"steps", 5}}), "ok");
  EXPECT_EQ(read_file(folder.path() / "points.points"), before);
  EXPECT_EQ(point("Home")["group"], "");
}

TEST_F(ProjectTest, AGroupIsRefusedWhereItIsNone) {
  const std::string before = read_file(folder.path() / "points.points");
  EXPECT_EQ(code({{"request", "points.group"}, {"names", {"Bench"}}, {"group", "a # b"}}), "bad-group");
  EXPECT_EQ(code({{"request", "points.group"}, {"names", {"Bench", "Moon"}}, {"group", "x"}}),
            "unknown-name");
  EXPECT_EQ(code({{"request", "points.group"}, {"names", Json::array()}, {"group", "x"}}), "bad-argument");
  EXPECT_EQ(code({{"request", "points.teach"}, {"name", "P"}, {"group", "a\nb"}}), "bad-argument");
  EXPECT_EQ(read_file(folder.path() / "points.points"), before);
}

TEST_F(ProjectTest, WhatWasTaughtIsThereWhenTheProgramBeginsAnew) {
  result({{"request", "points.teach"}, {"name", "Pick"}});
  result({{"request", "points.delete"}, {"name", "Count"}});
  const Json begun = result({{"request", "program.from"}, {"line", 1}, {"confirmed", true}});
  ASSERT_TRUE(begun.contains("where")) << begun;
  cell->run(1);
  EXPECT_TRUE(cell->cell().store().find("Pick") != nullptr);
  EXPECT_EQ(cell->cell().store().find("Count"), nullptr);
}

TEST_F(ProjectTest, ASightingIsOfARobotAtRest) {
  EXPECT_EQ(code({{"request", "points.sighting"}, {"marker", "Bench"}}), "ok");
  cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
  cell->run(0.3);
  ASSERT_FALSE(cell->cell().snapshot().standing) << "on its way to Home";
  EXPECT_EQ(code({{"request", "points.sighting"}, {"marker", "Bench"}}), "moving");
}

TEST_F(ProjectTest, AFrameComesFromThreePlacesAndATheToolFromFourPoses) {
  const Json frame = result({{"request", "points.frame"},
                             {"name", "Table"},
                             {"origin", {0.1, 0.2, 0.3}},
                             {"on_x", {0.1, 1.2, 0.3}},
                             {"in_plane", {-0.9, 0.2, 0.3}}});
  EXPECT_NEAR(frame["angle"].get<double>(), std::numbers::pi / 2, 1e-9) << frame;
  EXPECT_NEAR(point("Table")["pose"]["rpy"][2].get<double>(), std::numbers::pi / 2, 1e-9);
  EXPECT_EQ(code({{"request", "points.frame"},
                  {"name", "Bad"},
                  {"origin", {0, 0, 0}},
                  {"on_x", {0, 0, 0}},
                  {"in_plane", {1, 0, 0}}}),
            "bad-points");
  // Poses of tool0 whose tip, 0.1 m out of it and 0.02 aside, is at one place.
  const Vec3 tip{0.4, 0.1, 0.2}, tool{0.02, 0, 0.1};
  Json poses = Json::array();
  for (const Vec3 turn : {Vec3{0, 0, 0}, Vec3{0.5, 0, 0}, Vec3{0, 0.6, 0}, Vec3{0.3, -0.4, 1}}) {
    const Quaternion r = from_rpy(turn.x, turn.y, turn.z);
    const Vec3 p = tip - r * tool;
    poses.push_back({{"p", {p.x, p.y, p.z}}, {"q", {r.x, r.y, r.z, r.w}}});
  }
  const Json found =
      result({{"request", "points.tool"}, {"name", "Gripper"}, {"poses", poses}, {"dry", true}});
  EXPECT_NEAR(found["tcp"][2].get<double>(), 0.1, 1e-9) << found;
  EXPECT_LT(found["largest"].get<double>(), 1e-9);
  EXPECT_TRUE(point("Gripper").is_null()) << "it was only looked at";
  EXPECT_EQ(code({{"request", "points.tool"}, {"name", "Gripper"}, {"poses", poses}}), "ok");
  const Json kept = point("Gripper");
  EXPECT_EQ(kept["taught"]["frame"], "tool0");
  EXPECT_NEAR(kept["pose"]["p"][2].get<double>(), 0.1, 1e-9);
  EXPECT_TRUE(kept["world"].is_null()) << "it is not a place of the cell";
  EXPECT_NE(read_file(folder.path() / "points.points").find("tool0"), std::string::npos);
}

TEST_F(ProjectTest, AWayIsLookedAtWithoutMoving) {
  const Json before = result({{"request", "points.here"}})["joints"];
  const Json plan = result({{"request", "plan.preview"}, {"joints", {{"joint_1", 0.5}}}});
  ASSERT_TRUE(plan.value("ok", false)) << plan;
  EXPECT_GT(plan["seconds"].get<double>(), 0.1);
  EXPECT_GT(plan["path"].size(), 10u);
  EXPECT_EQ(result({{"request", "points.here"}})["joints"], before);
  EXPECT_EQ(code({{"request", "plan.preview"}, {"joints", {{"joint_1", 50}}}}), "limit");
  EXPECT_EQ(
      code(
          {{"request", "plan.preview"}, {"pose", {{"p", {9, 9, 9}}, {"q", {0, 0, 0, 1}}}}, {"kind", "line"}}),
      "singular")
      << "the arm is stretched before it is at its end";
  EXPECT_EQ(code({{"request", "plan.preview"}, {"to", "Nowhere"}}), "unknown-name");
}

TEST_F(ProjectTest, TheBaseIsThatOfTheRobotThatATeachingAPlanAndAMoveName) {
  cell.reset();
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n  left: {model: " + test::kSixAxes +
                   ", hardware: mock}\n  right: {model: " + test::kSixAxes +
                   ", hardware: mock, at: [2, 0, 0], rpy: [0, 0, 90deg]}\nprogram: main.script\n");
  folder.write("main.script", "load points\n");
  cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
  cell->run(1);
  const Json own = {{"request", "points.teach"}, {"name", "Own"}, {"robot", "right"}, {"frame", "base"}};
  const Json taught = result(own);
  const Json left = result({{"request", "points.here"}, {"robot", "left"}});
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(taught["pose"]["p"][k].get<double>(), left["tcp"]["p"][k].get<double>(), 1e-9)
        << "both stand in the same joints";
  EXPECT_TRUE(taught["world"].is_null()) << "each robot has its own";
  EXPECT_EQ(code({{"request", "plan.preview"}, {"robot", "right"}, {"to", "Own"}}), "ok");
  EXPECT_EQ(code({{"request", "move"}, {"robot", "right"}, {"points", {"Own"}}}), "ok");
  const Json there = result({{"request", "points.here"}, {"robot", "right"}});
  EXPECT_NEAR(there["tcp"]["p"][0].get<double>(), 2 - left["tcp"]["p"][1].get<double>(), 1e-4);
}

TEST_F(ProjectTest, FilesAreReadKeptAsDraftsAndWrittenWithoutLosingAnothersChange) {
  const Json listed = result({{"request", "files"}});
  EXPECT_EQ(listed["main"], "main.script");
  EXPECT_EQ(listed["files"].size(), 3u) << listed;
  const Json read = result({{"request", "files.read"}, {"name", "main.script"}});
  EXPECT_EQ(read["text"], kScript);
  EXPECT_TRUE(read["draft"].is_null());
  EXPECT_EQ(
      code(
          {{"request", "files.draft"}, {"name", "main.script"}, {"text", "log 1\n"}, {"base", read["hash"]}}),
      "ok");
  EXPECT_EQ(result({{"request", "files.read"}, {"name", "main.script"}})["draft"]["text"], "log 1\n");
  EXPECT_EQ(read_file(folder.path() / "main.script"), kScript) << "the file itself is as it was";
  folder.write("main.script", "log \"somebody else\"\n");
  EXPECT_EQ(
      code(
          {{"request", "files.write"}, {"name", "main.script"}, {"text", "log 1\n"}, {"base", read["hash"]}}),
      "changed-meanwhile");
  EXPECT_EQ(code({{"request", "files.write"},
                  {"name", "main.script"},
                  {"text", "log 1\n"},
                  {"base", read["hash"]},
                  {"force", true}}),
            "ok");
  EXPECT_EQ(read_file(folder.path() / "main.script"), "log 1\n");
  EXPECT_TRUE(result({{"request", "files.read"}, {"name", "main.script"}})["draft"].is_null())
      << "it is saved";
  const Json versions = result({{"request", "files.versions"}, {"name", "main.script"}})["versions"];
  ASSERT_EQ(versions.size(), 1u);
  EXPECT_EQ(
      result(
          {{"request", "files.version"}, {"name", "main.script"}, {"number", versions[0]["number"]}})["text"],
      "log \"somebody else\"\n");
  EXPECT_EQ(code({{"request", "files.write"}, {"name", "new.script"}, {"text", "log 2\n"}}), "ok");
  EXPECT_EQ(code({{"request", "files.write"}, {"name", "new.script"}, {"text", "log 3\n"}}),
            "changed-meanwhile");
  EXPECT_EQ(code({{"request", "files.rename"}, {"name", "new.script"}, {"to", "main.script"}}), "exists");
  EXPECT_EQ(code({{"request", "files.rename"}, {"name", "new.script"}, {"to", "old.script"}}), "ok");
  EXPECT_EQ(code({{"request", "files.delete"}, {"name", "old.script"}}), "ok");
  EXPECT_EQ(code({{"request", "files.read"}, {"name", "old.script"}}), "no-file");
}

TEST_F(ProjectTest, NoPathLeadsOutOfTheProject) {
  std::error_code error;
  std::filesystem::create_directory_symlink("/etc", folder.path() / "link", error);
  std::ofstream(folder.path() / "secret.key") << "x";
  std::filesystem::create_symlink("/etc/hostname", folder.path() / "host.txt", error);
  for (const char* path :
       {"", "/etc/passwd", "../x.script", "a/../../x.script", ".state/drafts/x.json", ".hidden.script",
        "link/hosts.txt", "host.txt", "secret.key", "a\\b.script", "./main.script", "main.script/"})
    EXPECT_EQ(code({{"request", "files.read"}, {"name", path}}), "bad-path") << path;
  std::mt19937 random(5);
  const std::string pieces[] = {"..", "/",   ".", "a",  "main.script", "link",
                                "\\", "%2e", "~", "\n", ".script"};
  const auto root = std::filesystem::canonical(folder.path());
  for (int n = 0; n < 5000; ++n) {
    std::string path;
    for (unsigned i = random() % 7; i > 0; --i) path += pieces[random() % std::size(pieces)];
    try {
      const auto whole = project_file(folder.path(), path).string();
      EXPECT_TRUE(whole.starts_with(root.string() + "/")) << path;
      EXPECT_EQ(whole.find("/../"), std::string::npos) << path;
    } catch (const Error&) {
    }
  }
}

TEST_F(ProjectTest, AFileIsWrittenWhereItCanBeAndSaysWhyElsewhere) {
  std::filesystem::create_symlink("/nowhere/deep", folder.path() / "away");
  std::filesystem::create_symlink("later", folder.path() / "here");
  std::filesystem::create_symlink("round", folder.path() / "round");
  const auto writes = [&](const std::string& name) {
    return code({{"request", "files.write"}, {"name", name}, {"text", "log 1\n"}});
  };
  EXPECT_EQ(writes("away/a.script"), "bad-path");
  EXPECT_EQ(writes("away/b/a.script"), "bad-path");
  EXPECT_EQ(writes("round/a.script"), "bad-path");
  EXPECT_EQ(writes("main.script/a.script"), "unwritable") << "a file is not a folder";
  EXPECT_EQ(writes("here/a.script"), "ok") << "the link stays in the project";
  EXPECT_EQ(read_file(folder.path() / "later/a.script"), "log 1\n");
  for (const char* name : {"a\nb.script", "a\x1b[2J.script", "a\x7f.script", "a\tb/c.script"}) {
    EXPECT_EQ(writes(name), "bad-argument");
    EXPECT_EQ(code({{"request", "files.rename"}, {"name", "main.script"}, {"to", name}}), "bad-argument");
    EXPECT_THROW(project_file(folder.path(), name), Error) << "nor by another way";
  }
}

TEST_F(ProjectTest, ATextIsCheckedWithLineAndColumn) {
  const Json good = result({{"request", "program.check"}, {"name", "main.script"}});
  EXPECT_TRUE(good["problems"].empty()) << good;
  const Json bad =
      result({{"request", "program.check"}, {"name", "main.script"}, {"text", "load points\nmovej Hom\n"}});
  ASSERT_EQ(bad["problems"].size(), 1u) << bad;
  EXPECT_EQ(bad["problems"][0]["line"], 2);
  EXPECT_GT(bad["problems"][0]["column"], 1);
  EXPECT_EQ(bad["problems"][0]["severity"], "error");
  bool known = false;
  const Json names = result({{"request", "program.names"}});
  for (const Json& each : names["names"])
    known = known || (each["name"] == "Home" && each["kind"] == "joints");
  EXPECT_TRUE(known);
  EXPECT_GT(result({{"request", "language.words"}})["words"].size(), 20u);
}

TEST_F(ProjectTest, AProgramIsAListOfStepsWithTheirLines) {
  const char* text =
      "load points\n"
      "while Count > 0\n"
      "  movej Home\n"
      "  if Count == 1\n"
      "    log \"a\"\n"
      "  else\n"
      "    log \"b\"\n"
      "  end\n"
      "end\n"
      "# over\n"
      "log \"end\"\n";
  const Json listed = result({{"request", "program.steps"}, {"name", "main.script"}, {"text", text}});
  ASSERT_TRUE(listed["problems"].empty()) << listed;
  std::vector<std::string> seen;
  for (const Json& step : listed["steps"])
    seen.push_back(step["kind"].get<std::string>() + " " + step["line"].dump() + "-" + step["end"].dump() +
                   " " + step["depth"].dump());
  EXPECT_EQ(seen, (std::vector<std::string>{"load 1-1 0", "while 2-9 0", "move 3-3 1", "if 4-5 1",
                                            "log 5-5 2", "else 6-8 1", "log 7-7 2", "log 11-11 0"}));
  EXPECT_EQ(listed["steps"][2]["points"], Json::array({"Home"}));
}

TEST_F(ProjectTest, AForcedTagIsReleasedByAnybodyAndChangesAreTold) {
  const auto forced =
      cell->give({{"request", "tags.force"}, {"name", "Count"}, {"value", 7}, {"by", "Tablet 4"}});
  const auto by = [&] { return cell->cell().store().facts("Count")->changed_by; };
  cell->run(0.05);
  EXPECT_EQ(point("Count")["value"], 7);
  EXPECT_EQ(by(), "Tablet 4");
  EXPECT_EQ(code({{"request", "tags.release"}, {"name", "Count"}, {"by", "Phone 5"}}), "ok");
  cell->run(0.5);
  EXPECT_EQ(by(), "Phone 5");
  EXPECT_EQ(point("Count")["value"], 3);
  ASSERT_FALSE(forced->empty());
  EXPECT_FALSE(forced->back().value("more", false)) << "who forced it is told that it is over";
  EXPECT_EQ(code({{"request", "tags.release"}, {"name", "Count"}}), "not-forced");
  const Json history = result({{"request", "tags.history"}, {"names", {"Count"}}});
  ASSERT_GE(history["changes"].size(), 2u);
  EXPECT_EQ(history["changes"].back()["now"], "3");
  EXPECT_EQ(history["changes"].back()["by"], "Phone 5");
  EXPECT_EQ(code({{"request", "tags.set"}, {"name", "Count"}, {"value", 4}}), "ok");
  EXPECT_EQ(by(), "a person");
}

TEST_F(ProjectTest, ACellIsAskedToBeBuiltAnew) {
  EXPECT_EQ(code({{"request", "cell.restart"}, {"robot", "abb/irb_120"}}), "ok");
  ASSERT_TRUE(cell->cell().restart());
  EXPECT_EQ(cell->cell().restart()->robot, "abb/irb_120");
}

TEST_F(ProjectTest, ACellThatIsNotThereDoesNotEndThisOne) {
  EXPECT_EQ(code({{"request", "cell.restart"}, {"cell", "no/such/cell"}}), "unknown-cell");
  EXPECT_FALSE(cell->cell().restart());
}

/// A cell with a catalogue, whose user has a data folder of the test's own.
class CellsTest : public ::testing::Test {
 protected:
  CellsTest() {
    ::setenv("XDG_DATA_HOME", (folder.path() / "data").c_str(), 1);
    folder.write("lab/bench/cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes +
                                            ", hardware: mock}\nprogram: main.script\n");
    folder.write("lab/bench/points.points",
                 "Name: Home\nJS: joint_1 joint_2 joint_3 joint_4 joint_5 joint_6\n"
                 "Point: 0, 0.4, 0.8, 0, 0.6, 0\nName: Far\nPose: RPY\nPoint: 9, 0, 0.3, 0, 0, 0\n");
    folder.write("lab/bench/main.script", "load points\nmovej Home\n");
    folder.write("lab/bench/.state/secret", "not copied");
    folder.write("lab/bench/README.md", "# The bench\nA text.\n");
    folder.write("lab/other/cell.yaml", "polyarm: cell/1\nrobots:\n  left: {model: abb/irb_120}\n");
    folder.write("lab/none/notes.txt", "no cell");
    cell = std::make_unique<test::LockStepCell>(read_cell_file(bench()));
    cell->run(3);
  }
  ~CellsTest() override { ::unsetenv("XDG_DATA_HOME"); }
  std::filesystem::path bench() const { return std::filesystem::canonical(folder.path()) / "lab" / "bench"; }
  Json result(const Json& request) { return cell->result(request); }
  std::string code(const Json& request) {
    const Json answer = cell->ask(request);
    return answer.value("ok", false) ? "ok" : answer["error"]["code"].get<std::string>();
  }

  Folder folder;
  std::unique_ptr<test::LockStepCell> cell;
};

TEST_F(CellsTest, ADryRunTellsTheWaysAndWhatCannotBeReachedAndMovesNothing) {
  const double before = cell->value_of("states", "arm/joint_2/position");
  ASSERT_TRUE(std::isfinite(before));
  const std::string text = "load points\nmovej Home\nmovel Far\n";
  const Json found = result({{"request", "program.dry"}, {"name", "main.script"}, {"text", text}});
  ASSERT_TRUE(found.contains("problems")) << found;
  ASSERT_EQ(found["problems"].size(), 1u) << found["problems"];
  EXPECT_EQ(found["problems"][0]["line"], 3);
  EXPECT_EQ(found["problems"][0]["file"], "main.script") << "as the user knows it";
  ASSERT_FALSE(found["paths"].empty());
  EXPECT_EQ(found["paths"][0]["line"], 2);
  EXPECT_GT(found["paths"][0]["points"].size(), 10u);
  EXPECT_EQ(cell->value_of("states", "arm/joint_2/position"), before);
  EXPECT_EQ(read_file(bench() / "main.script"), "load points\nmovej Home\n");
}

TEST_F(CellsTest, ADryRunOfTheFileItselfAndOfATextWithErrors) {
  const Json clean = result({{"request", "program.dry"}, {"name", "main.script"}});
  EXPECT_TRUE(clean["problems"].empty()) << clean;
  EXPECT_EQ(clean["moves"], 1);
  const Json bad = result({{"request", "program.dry"}, {"name", "main.script"}, {"text", "movej Nowhere\n"}});
  ASSERT_FALSE(bad["problems"].empty()) << bad;
  EXPECT_EQ(bad["problems"][0]["line"], 1);
  EXPECT_EQ(code({{"request", "program.dry"}, {"name", "../other/cell.yaml"}}), "bad-path");
}

TEST_F(CellsTest, TheOpenCellIsCheckedAsItsFilesAreNow) {
  const Json before = result({{"request", "cell.check"}});
  ASSERT_EQ(before["problems"].size(), 1u) << before;
  EXPECT_EQ(before["problems"][0]["code"], "unreachable");
  EXPECT_EQ(before["problems"][0]["file"], "points.points");
  folder.write("lab/bench/main.script", "load points\nmovej Hoem\n");
  const Json found = result({{"request", "cell.check"}});
  EXPECT_TRUE(std::any_of(found["problems"].begin(), found["problems"].end(), [](const Json& each) {
    return each["file"] == "main.script" && each["line"] == 2;
  })) << found;
}

TEST_F(CellsTest, CellsBesideTheOpenOneAreListed) {
  const Json list = result({{"request", "cells"}});
  EXPECT_EQ(list["open"], bench().string());
  ASSERT_EQ(list["cells"].size(), 2u) << list;
  EXPECT_EQ(list["cells"][0]["title"], "The bench");
  EXPECT_EQ(list["cells"][1]["name"], "other");
  EXPECT_EQ(list["cells"][1]["robots"], Json::array({"abb/irb_120"}));
}

TEST_F(CellsTest, CellsThatWereOpenStayListedWithThoseBesideThem) {
  const std::string cell = "polyarm: cell/1\nrobots:\n  arm: {model: abb/irb_120, hardware: mock}\n";
  folder.write("examples/first/cell.yaml", cell);
  folder.write("examples/second/cell.yaml", cell);
  const Json gone = (folder.path() / "gone").string(), first = (folder.path() / "examples/first").string();
  folder.write("data/polyarm/recent.json", Json::array({first, gone, 7}).dump());
  const Json list = result({{"request", "cells"}});
  std::map<std::string, bool> recent;
  for (const Json& each : list["cells"]) recent[each.value("name", "")] = each.value("recent", false);
  EXPECT_EQ(recent.at("first"), true) << list;
  EXPECT_EQ(recent.at("second"), false) << list;
  EXPECT_EQ(recent.at("bench"), false) << "it is open";
  EXPECT_EQ(recent.count("gone"), 0u);
  const Json kept = Json::parse(read_file(folder.path() / "data/polyarm/recent.json"));
  EXPECT_EQ(kept, Json::array({bench().string(), first}));
  folder.write("data/polyarm/recent.json", "no JSON");
  EXPECT_EQ(result({{"request", "cells"}})["cells"].size(), 2u);
}

TEST_F(CellsTest, ACopyHasTheFilesAndNothingHidden) {
  const Json made = result({{"request", "cell.save_as"}, {"name", "mine"}});
  const std::filesystem::path copy = made.value("folder", "");
  EXPECT_EQ(copy, folder.path() / "data/polyarm/cells/mine") << made;
  EXPECT_EQ(read_file(copy / "main.script"), "load points\nmovej Home\n");
  EXPECT_FALSE(std::filesystem::exists(copy / ".state"));
  EXPECT_EQ(code({{"request", "cell.save_as"}, {"name", "mine"}}), "exists");
  EXPECT_EQ(code({{"request", "cell.save_as"}, {"name", "../out"}}), "bad-argument");
  const Json list = result({{"request", "cells"}});
  EXPECT_EQ(list["cells"].size(), 3u);
}

TEST_F(CellsTest, ANewCellNeedsARobotThatThereIs) {
  EXPECT_EQ(code({{"request", "cell.new"}, {"name", "fresh"}, {"robot", "nobody/nothing"}}), "no-catalogue");
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "data/polyarm/cells/fresh")) << "nothing is left";
}

TEST(NewCell, CanBeOpened) {
  const Folder folder;
  ::setenv("XDG_DATA_HOME", folder.path().c_str(), 1);
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes + ", hardware: mock}\n");
  test::LockStepCell cell(read_cell_file(folder.path()),
                          std::vector<std::filesystem::path>{POLYARM_SOURCE_DIR "/robots"});
  const Json made =
      cell.result({{"request", "cell.new"}, {"name", "fresh"}, {"robot", "universal_robots/ur5e"}});
  ::unsetenv("XDG_DATA_HOME");
  ASSERT_TRUE(made.contains("folder")) << made;
  const CellFile file = read_cell_file(made["folder"].get<std::string>());
  ASSERT_EQ(file.robots.size(), 1u);
  EXPECT_EQ(file.robots[0].model, "universal_robots/ur5e");
}

}  // namespace
}  // namespace polyarm::cell
