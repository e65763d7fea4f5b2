/// Tests, comparisons and cut-off runs of programs, as a user types them.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::Finished;
using test::Folder;
using test::run_command;

class Programs : public ::testing::Test {
 protected:
  Programs() {
    folder.write("work.data", "Name: Placed\nNum: 0\nName: Repeat\nBool: True\n");
    folder.write("job.script",
                 "load work\nlet step = 1\nwhile Repeat\n"
                 "  movej joints(10deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"
                 "  set Placed = Placed + step\n"
                 "  movej joints(0deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"
                 "  if Placed == 20\n    set Repeat False\n  end\nend\n");
    folder.write("cell.yaml",
                 "polyarm: cell/1\nrobots:\n  arm: {model: " + urdf + ", hardware: mock}\nprogram: job\n");
  }
  std::string placed() {
    const std::string text = read_file(folder.path() / ".state" / "data" / "work.data");
    const auto at = text.find("Num: ");
    return text.substr(at + 5, text.find('\n', at) - at - 5);
  }

  Folder folder;
  const std::string urdf = POLYARM_SOURCE_DIR "/examples/r6bot/r6bot.urdf";
};

TEST_F(Programs, TestsRunApartAndTellInEveryForm) {
  folder.write("tests.script",
               "test \"counts\"\n  run\n  expect Placed == 2 timeout 20s\nend\n"
               "test \"counts <wrong>\"\n  run\n  expect Placed < 1 timeout 5s\n  wait 5s\n  expect Placed "
               "== 99\nend\n"
               "test \"counts again\"\n  expect Placed == 0\n  run\n  expect Placed == 1 timeout 20s\nend\n");
  const std::string report = (folder.path() / "results.xml").string();
  const Finished all = run_command({"test", folder.path().string(), "--junit", report, "-j", "2"});
  EXPECT_EQ(all.exit_code, 1) << all.output;
  EXPECT_NE(all.output.find("3 tests, 2 passed, 1 failed"), std::string::npos) << all.output;
  EXPECT_NE(all.output.find("tests.script:9:"), std::string::npos) << all.output;
  const std::string xml = read_file(report);
  EXPECT_NE(xml.find("tests=\"3\" failures=\"1\""), std::string::npos) << xml;
  EXPECT_NE(xml.find("name=\"counts &lt;wrong&gt;\""), std::string::npos) << xml;
  EXPECT_NE(xml.find("<failure message=\"expected Placed == 99; Placed is "), std::string::npos) << xml;
  EXPECT_EQ(run_command({"test", folder.path().string(), "--only", "again"}).exit_code, 0);
  EXPECT_EQ(read_file(folder.path() / "work.data").find("Num: 0"), std::string("Name: Placed\n").size());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / ".state"));
  const auto told = run_command({"test", folder.path().string(), "--only", "wrong", "--json"}).result();
  EXPECT_EQ(told["passed"], false);
}

TEST_F(Programs, AFileOfTestsThatIsWrongFailsWithEveryError) {
  folder.write("tests.script", "test \"one\"\n  movel A\n  expec True\nend\n");
  const Finished told = run_command({"test", folder.path().string()});
  EXPECT_EQ(told.exit_code, 1);
  EXPECT_NE(told.output.find("did you mean 'expect'"), std::string::npos) << told.output;
}

TEST_F(Programs, ARunThatWasCutOffGoesOn) {
  const std::string cell = folder.path().string();
  EXPECT_EQ(run_command({"run", cell, "--fast", "--seconds", "4", "--quiet"}).exit_code, 0);
  const std::string before = placed();
  EXPECT_GT(std::stoi(before), 1);
  EXPECT_LT(std::stoi(before), 19);
  const Finished asks = run_command({"run", cell, "--fast", "--continue"});
  EXPECT_NE(asks.exit_code, 0) << "nobody said that it may";
  EXPECT_NE(asks.output.find("step = 1"), std::string::npos) << asks.output;
  const Finished more = run_command({"run", cell, "--fast", "--continue", "--yes", "--seconds", "1"});
  EXPECT_EQ(more.exit_code, 0) << more.output;
  EXPECT_GE(std::stoi(placed()), std::stoi(before));
  EXPECT_EQ(run_command({"run", cell, "--fast", "--continue", "--yes"}).exit_code, 0);
  EXPECT_EQ(placed(), "20");
  const Finished nothing = run_command({"run", cell, "--fast", "--continue", "--yes"});
  EXPECT_NE(nothing.exit_code, 0);
  EXPECT_NE(nothing.output.find("no program was interrupted here"), std::string::npos) << nothing.output;
}

TEST_F(Programs, DataAndPointsMayHaveTheSameName) {
  folder.write("work.data", "Name: PointFile\nText: work\nName: X\nNum: 3\n");
  folder.write("work.points", "Pose: RPY\nName: Here\nPoint: 0.1, 0, 0.2, 0, 0, 0\n");
  folder.write("job.script", "load work.data\nset X = X + 1\nload work.data\nlog(\"{X} {Here.z}\")\n");
  const Finished run = run_command({"run", folder.path().string(), "--fast"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("4 0.2m"), std::string::npos) << run.output;
}

TEST(CutOff, TheRunAfterwardsTellsWhatTheGripperHeld) {
  const test::ExampleCopy copy("pick_and_place");
  const auto asks = [&] { return run_command({"run", copy.path(), "--fast", "--continue"}); };
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--quiet", "--seconds"};
  const auto cut_off_after = [&](const char* seconds) {
    std::vector<std::string> words = line;
    words.emplace_back(seconds);
    run_command(words);
    const std::string told = asks().output;
    const auto at = told.find("held part");
    return at == std::string::npos ? told : told.substr(at, told.find('\n', at) - at);
  };
  EXPECT_NE(cut_off_after("0.5").find("none known"), std::string::npos);
  std::string held;
  for (const char* seconds : {"4", "5", "6", "7", "8", "9"})
    if (held.find("when it was cut off") == std::string::npos) held = cut_off_after(seconds);
  EXPECT_NE(held.find("cube_1 when it was cut off"), std::string::npos) << held;
}

TEST_F(Programs, AHoldThatNobodyCanEndEndsTheRun) {
  folder.write("job.script",
               "load work\nset Placed = 7\nhold \"look at the cup\"\nset Placed = 8\ntask other\n"
               "  wait 1ms\n  set Placed = 9\nend\n");
  const Finished run = run_command({"run", folder.path().string(), "--fast", "--json"});
  EXPECT_EQ(run.exit_code, 1) << run.output;
  const auto result = run.result();
  EXPECT_EQ(result["problems"][0]["code"], "held") << result;
  EXPECT_NE(result["error"].get<std::string>().find("job.script:"), std::string::npos) << result;
  EXPECT_NE(run.output.find("look at the cup"), std::string::npos);
  EXPECT_LT(result["sim_time_s"].get<double>(), 15);
  EXPECT_EQ(placed(), "7");
}

TEST_F(Programs, ARunBeginsAtALine) {
  const Finished run =
      run_command({"run", folder.path().string(), "--fast", "--from", "5", "--yes", "--seconds", "1"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("last point before it"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("step = 1"), std::string::npos) << run.output;
}

TEST_F(Programs, RobotsAreComparedByWhatTheyCan) {
  folder.write(
      "far.script",
      "load work\nmovej joints(10deg, -90deg, 0deg, 0deg, 0deg, 0deg)\nmovel offset(here(), z = 3m)\n");
  const Finished well =
      run_command({"compare", folder.path().string(), "--robots", urdf + "," + urdf, "--json"});
  EXPECT_EQ(well.exit_code, 0) << well.output;
  const auto told = nlohmann::json::parse(well.output);
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0], told[1]);
  EXPECT_TRUE(told[0]["runs"]);
  EXPECT_GT(told[0]["cycle_s"], 0.1);
  EXPECT_GE(told[0]["nearest_singularity"]["value"], 0);
  const Finished badly = run_command({"compare", (folder.path() / "far.script").string(), "--robots", urdf});
  EXPECT_EQ(badly.exit_code, 1);
  EXPECT_NE(badly.output.find("far.script:3"), std::string::npos) << badly.output;
}

TEST_F(Programs, TheCycleOfAProgramWithoutALoopIsItsWholeTime) {
  folder.write("once.script", "load work\nmovej joints(10deg, -90deg, 0deg, 0deg, 0deg, 0deg)\nwait 1s\n");
  const Finished run =
      run_command({"compare", (folder.path() / "once.script").string(), "--robots", urdf, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const auto told = nlohmann::json::parse(run.output)[0];
  EXPECT_EQ(told["cycles"], 1);
  ASSERT_TRUE(told["cycle_s"].is_number()) << told;
  EXPECT_GT(told["cycle_s"], 1.0);
  EXPECT_LE(told["cycle_s"], told["time_s"]);
}

TEST_F(Programs, TheReferencePageIsWhatTheCommandWrites) {
  EXPECT_EQ(run_command({"language", "page"}).output,
            read_file(POLYARM_SOURCE_DIR "/docs/language-reference.md"));
}

}  // namespace
}  // namespace polyarm
