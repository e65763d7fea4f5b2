#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::ExampleCopy;
using test::Finished;
using test::run_command;

struct Case {
  const char* example;
  const char* robot;
  std::size_t parts;
};

class Examples : public testing::TestWithParam<Case> {};

TEST_P(Examples, RunToTheirEndWithEveryPartInItsPlaceAndTwiceAlike) {
  const ExampleCopy copy(GetParam().example);
  const std::vector<std::string> line{"run", copy.path(), "--robot", GetParam().robot, "--fast", "--json"};
  const Finished first = run_command(line), second = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output.substr(first.output.size() > 3000 ? first.output.size() - 3000
                                                                                  : 0);
  const nlohmann::json result = first.result();
  EXPECT_EQ(result["result"], "completed");
  EXPECT_GE(result["program_cycles"], 2);
  ASSERT_EQ(result["parts"].size(), GetParam().parts);
  for (const auto& part : result["parts"]) {
    EXPECT_EQ(part["state"], "placed") << part;
    EXPECT_LE(part["error_m"].get<double>(), 0.005) << part;
    EXPECT_NE(part["bin"], "") << part;
  }
  EXPECT_TRUE(result["repeatable"]);
  EXPECT_EQ(result["trace_hash"], second.result()["trace_hash"]);
  EXPECT_LT(result["tracking_error_max"].get<double>(), 1e-3);
}

constexpr Case kCases[] = {
    {"pick_and_place", "universal_robots/ur3", 3},
    {"pick_and_place", "universal_robots/ur5e", 3},
    {"pick_and_place", "fanuc/lr_mate_200id", 3},
    {"pick_and_place", "abb/irb_120", 3},
    {"pick_and_place", "franka/fer_panda", 3},
    {"sorting", "franka/fer_panda", 4},
    {"bin_picking", "franka/fer_panda", 6},
    {"sorting", "universal_robots/ur3", 4},
    {"sorting", "universal_robots/ur5e", 4},
    {"sorting", "fanuc/lr_mate_200id", 4},
    {"sorting", "abb/irb_120", 4},
    {"bin_picking", "universal_robots/ur3", 6},
    {"bin_picking", "universal_robots/ur5e", 6},
    {"bin_picking", "fanuc/lr_mate_200id", 6},
    {"bin_picking", "abb/irb_120", 6},
};
INSTANTIATE_TEST_SUITE_P(All, Examples, testing::ValuesIn(kCases), [](const auto& named) {
  std::string name = std::string(named.param.example) + "_" + named.param.robot;
  for (char& c : name)
    if (c == '/') c = '_';
  return name;
});

class Flowing : public testing::TestWithParam<const char*> {};

TEST_P(Flowing, PicksAndPlacesWithoutStoppingAtEveryPoint) {
  const ExampleCopy copy("pick_and_place");
  const std::vector<std::string> line{"run",    copy.path(), "--robot",   GetParam(),
                                      "--fast", "--json",    "--program", "flowing"};
  const Finished run = run_command(line);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const nlohmann::json result = run.result();
  EXPECT_LT(result["sim_time_s"].get<double>(), 10)
      << "of cell time; with a stop at every point it takes longer";
  ASSERT_EQ(result["parts"].size(), 3u);
  for (const auto& part : result["parts"]) EXPECT_EQ(part["state"], "placed") << part;
  EXPECT_EQ(result["clamps"], 0);
}

INSTANTIATE_TEST_SUITE_P(Robots, Flowing,
                         testing::Values("universal_robots/ur3", "universal_robots/ur5e",
                                         "fanuc/lr_mate_200id", "abb/irb_120"),
                         [](const auto& named) {
                           std::string name = named.param;
                           for (char& c : name)
                             if (c == '/') c = '_';
                           return name;
                         });

TEST(Sorting, SendsEachKindToItsOwnBin) {
  const ExampleCopy copy("sorting");
  const nlohmann::json result = run_command({"run", copy.path(), "--fast", "--json"}).result();
  for (const auto& part : result["parts"]) EXPECT_EQ(part["bin"], "bin_" + part["kind"].get<std::string>());
}

TEST(BinPicking, TheCameraChangesThePickPointAndPartsAreLoadedAndUnloaded) {
  const ExampleCopy copy("bin_picking");
  const Finished run = run_command({"run", copy.path(), "--fast", "--json", "--cycles", "4"});
  EXPECT_EQ(run.result()["result"], "completed") << run.result();
  int pictures = 0, loads = 0, unloads = 0;
  std::set<std::string> points;
  std::istringstream lines(run.output);
  for (std::string line; std::getline(lines, line);) {
    const auto event = nlohmann::json::parse(line, nullptr, false);
    if (event.value("event", "") != "tag") continue;
    if (event["name"] == "pinput") {
      ++pictures;
      points.insert(event["value"].get<std::string>());
    }
    if (event["name"] == "LoadMachine" && event["value"] == "True") ++loads;
    if (event["name"] == "UnloadMachine" && event["value"] == "True") ++unloads;
  }
  EXPECT_GE(pictures, 2);
  EXPECT_GE(points.size(), 2u);
  EXPECT_GE(loads, 2);
  EXPECT_GE(unloads, 2);
}

TEST(Carrier, TakesBoxesFromTableToTableOnABaseThatDrives) {
  const ExampleCopy copy("carrier");
  const Finished run = run_command({"run", copy.path(), "--fast", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.output.substr(run.output.size() > 3000 ? run.output.size() - 3000 : 0);
  const nlohmann::json result = run.result();
  ASSERT_EQ(result["parts"].size(), 2u);
  for (const auto& part : result["parts"]) {
    EXPECT_EQ(part["state"], "placed") << part;
    EXPECT_EQ(part["bin"], "shelf") << part;
    EXPECT_GT(part["at"][1].get<double>(), 1.3) << "on the other table";
  }
}

TEST(OverAWall, WaysAreFoundTheSameEveryTime) {
  const ExampleCopy copy("over_a_wall");
  std::vector<nlohmann::json> results;
  for (int i = 0; i < 2; ++i) {
    const Finished run = run_command({"run", copy.path(), "--fast", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.output.substr(run.output.size() > 3000 ? run.output.size() - 3000 : 0);
    results.push_back(run.result());
  }
  for (const auto& part : results[0]["parts"]) EXPECT_EQ(part["state"], "placed") << part;
  EXPECT_EQ(results[0]["parts"].size(), 3u);
  EXPECT_EQ(results[0]["trace_hash"], results[1]["trace_hash"]);
  const Finished taught = run_command({"run", copy.path(), "--fast", "--json", "--program", "job_taught"});
  EXPECT_EQ(taught.exit_code, 0) << taught.output;
}

TEST(OverAWall, IsWithoutContactOnMockAsInPhysics) {
  const ExampleCopy copy("over_a_wall");
  for (const char* hardware : {"mock", "mujoco"}) {
    const Finished checked = run_command({"check", copy.path(), "--dry", "--hardware", hardware});
    EXPECT_EQ(checked.exit_code, 0) << checked.output;
    EXPECT_NE(checked.output.find("0 errors"), std::string::npos) << checked.output;
  }
}

/// Three places of the plate: found in a spiral, found late, and met at once.
TEST(PegInHole, FindsItsHoleWhereverItIs) {
  const ExampleCopy copy("peg_in_hole");
  const std::filesystem::path file = std::filesystem::path(copy.path()) / "cell.yaml";
  const std::string cell = read_file(file);
  for (const std::string seed : {"1", "3", "8"}) {
    std::string text = cell;
    text.replace(text.find("seed: 1"), 7, "seed: " + seed);
    std::ofstream(file) << text;
    const Finished run = run_command({"run", copy.path(), "--fast", "--json"});
    EXPECT_EQ(run.exit_code, 0) << "seed " << seed << '\n' << run.output;
  }
}

TEST(TwoRobots, ShareATableWithoutTouchingEachOther) {
  const ExampleCopy copy("two_robots");
  const Finished run = run_command({"run", copy.path(), "--fast", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.output.substr(run.output.size() > 3000 ? run.output.size() - 3000 : 0);
  const nlohmann::json result = run.result();
  EXPECT_EQ(result["result"], "completed");
  ASSERT_EQ(result["parts"].size(), 5u);
  for (const auto& part : result["parts"]) EXPECT_EQ(part["bin"], "pallet") << part;
}

TEST(TwoRobots, ACupThatNeverHoldsEndsTheProgramAtItsLine) {
  const ExampleCopy copy("two_robots");
  const Finished run =
      run_command({"run", copy.path(), "--fast", "--json", "--fault", "left/tool/vacuum=off"});
  EXPECT_EQ(run.exit_code, 1);
  const std::string error = run.result()["error"];
  EXPECT_NE(error.find("no part at Seen"), std::string::npos) << error;
  EXPECT_NE(error.find("emptying.script:"), std::string::npos) << error;
}

TEST(ExamplesTests, OfEveryExampleHold) {
  for (const char* example :
       {"pick_and_place", "sorting", "bin_picking", "two_robots", "belt_picking", "polishing"}) {
    const ExampleCopy copy(example);
    const Finished tests = run_command({"test", copy.path()});
    EXPECT_EQ(tests.exit_code, 0) << example << "\n" << tests.output;
    EXPECT_NE(tests.output.find(" 0 failed"), std::string::npos) << tests.output;
  }
}

TEST(PickAndPlace, WithoutVacuumFailsAndSaysWhoWaitsForWhat) {
  const ExampleCopy copy("pick_and_place");
  const Finished run =
      run_command({"run", copy.path(), "--fast", "--json", "--fault", "arm/tool/vacuum=off"});
  EXPECT_EQ(run.exit_code, 1);
  const nlohmann::json result = run.result();
  EXPECT_EQ(result["result"], "failed");
  EXPECT_LT(result["sim_time_s"].get<double>(), 60);
  EXPECT_NE(result["error"].get<std::string>().find("GripperActive"), std::string::npos);
  EXPECT_NE(result["error"].get<std::string>().find("PartHeld"), std::string::npos);
  const std::filesystem::path folder = result["failure_folder"].get<std::string>();
  for (const char* file : {"cell.yaml", "plc.script", "command.txt", "result.json", "cycles.csv", "arm.urdf"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
}

TEST(PickAndPlace, CyclesEndTheProgramAfterThatManyPasses) {
  const ExampleCopy copy("pick_and_place");
  const nlohmann::json result =
      run_command({"run", copy.path(), "--fast", "--json", "--cycles", "2"}).result();
  EXPECT_EQ(result["result"], "completed");
  EXPECT_EQ(result["program_cycles"], 2);
  EXPECT_EQ(result["parts"].size(), 2u) << "only the parts that were fed";
}

TEST(PickAndPlace, ARunChangesNoFileOfTheUser) {
  const ExampleCopy copy("pick_and_place");
  std::map<std::string, std::string> before;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(copy.path()))
    if (entry.is_regular_file()) before[entry.path()] = read_file(entry.path());
  run_command({"run", copy.path(), "--fast", "-q", "--cycles", "1"});
  for (const auto& [path, content] : before) EXPECT_EQ(read_file(path), content) << path;
  EXPECT_TRUE(std::filesystem::exists(copy.file(".state/.gitignore")));
}

TEST(PickAndPlace, ATableInTheWayIsFound) {
  const ExampleCopy copy("pick_and_place");
  std::string scene = read_file(copy.file("scene.yaml"));
  const std::string line = "  table: {box: [1.4, 1.4, 0.04], at: [0.2, 0, -0.02]}\n";
  ASSERT_NE(scene.find(line), std::string::npos);
  scene.insert(scene.find(line), "  wall: {box: [0.3, 0.02, 0.16], at: [0.3, 0, 0.08]}\n");
  write_file_atomically(copy.file("scene.yaml"), scene);
  const nlohmann::json guarded = run_command({"run", copy.path(), "--fast", "--json"}).result();
  EXPECT_EQ(guarded["result"], "failed");
  ASSERT_FALSE(guarded["problems"].empty());
  EXPECT_EQ(guarded["problems"][0]["code"], "guard");
  write_file_atomically(copy.file("cell.yaml"), read_file(copy.file("cell.yaml")) + "\nguards: off\n");
  const nlohmann::json result = run_command({"run", copy.path(), "--fast", "--json"}).result();
  EXPECT_EQ(result["result"], "failed");
  ASSERT_FALSE(result["problems"].empty());
  EXPECT_EQ(result["problems"][0]["code"], "contact");
  EXPECT_NE(result["error"].get<std::string>().find("wall"), std::string::npos);
  EXPECT_NE(result["error"].get<std::string>().find("PAPscript.script:"), std::string::npos)
      << "names the program line";
  const auto dry = run_command({"check", copy.path(), "--dry", "--json"});
  EXPECT_EQ(dry.exit_code, 1) << "a contact is an error";
  bool told = false;
  const auto found = nlohmann::json::parse(dry.output.substr(dry.output.find('{')), nullptr, false);
  ASSERT_TRUE(found.is_object()) << dry.output;
  for (const nlohmann::json& problem : found["problems"])
    told = told || (problem["code"] == "contact" && problem["severity"] == "error");
  EXPECT_TRUE(told) << dry.output;
}

TEST(PickAndPlace, ARobotThatStartsInsideAWallIsSaidTo) {
  const ExampleCopy copy("pick_and_place");
  std::string scene = read_file(copy.file("scene.yaml"));
  scene.insert(scene.find("  table: {"), "  wall: {box: [0.3, 0.02, 0.5], at: [0.3, 0, 0.25]}\n");
  write_file_atomically(copy.file("scene.yaml"), scene);
  const nlohmann::json result = run_command({"run", copy.path(), "--fast", "--json"}).result();
  EXPECT_EQ(result["result"], "failed");
  const std::string error = result["error"];
  EXPECT_NE(error.find("is inside fixture wall where it starts"), std::string::npos) << error;
  EXPECT_EQ(error.find(".script:"), std::string::npos) << "no line of the program is to blame: " << error;
}

TEST(PickAndPlace, APlaceBesideTheTrayIsAFailure) {
  const ExampleCopy copy("pick_and_place");
  std::string points = read_file(copy.file("PAPpoints.points"));
  const std::string place = "Point: 0.30, -0.15, 0.045";
  points.replace(points.find(place), place.size(), "Point: 0.31, -0.15, 0.045");
  write_file_atomically(copy.file("PAPpoints.points"), points);
  const nlohmann::json result =
      run_command({"run", copy.path(), "--fast", "--json", "--cycles", "1"}).result();
  EXPECT_EQ(result["result"], "failed");
  EXPECT_EQ(result["parts"][0]["state"], "off_goal");
  EXPECT_NEAR(result["parts"][0]["error_m"].get<double>(), 0.01, 1e-3);
}

TEST(PickAndPlace, RunsOnMockHardwareToo) {
  const ExampleCopy copy("pick_and_place");
  const nlohmann::json result =
      run_command({"run", copy.path(), "--fast", "--json", "--hardware", "mock"}).result();
  EXPECT_EQ(result["result"], "completed");
  EXPECT_TRUE(result["physics_step_s"].is_null());
}

TEST(Check, ReportsEveryErrorOfEveryFileAtOnce) {
  const ExampleCopy copy("pick_and_place");
  const auto change = [&](const char* file, const std::string& from, const std::string& to) {
    std::string text = read_file(copy.file(file));
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    write_file_atomically(copy.file(file), text);
  };
  change("PAPpoints.points", "0.30, 0.15, 0.14", "5.0, 3.0, 2.0");
  change("PAPscript.script", "wait GripperActive", "mait GripperActive");
  change("PAPscript.script", "moveto Pass2", "moveto Pas2");
  change("scene.yaml", "outfeed: {at", "outfeed: {att");
  change("signals.yaml", "Vacuum: {command", "Vacuum: {comand");
  change("cycledata.data", "Bool: False", "Bool: Flase");
  const Finished check = run_command({"check", copy.path()});
  EXPECT_EQ(check.exit_code, 1);
  for (const char* wanted : {"PAPpoints.points:8:", "6.16 m from the base, this robot reaches 0.50 m",
                             "PAPscript.script:11:1:", "'mait'", "PAPscript.script:17:", "'Pas2'",
                             "did you mean 'Pass2'", "scene.yaml:11:", "'att'", "signals.yaml:4:", "'comand'",
                             "did you mean 'command'", "cycledata.data:10:7:", "'Flase'"})
    EXPECT_NE(check.output.find(wanted), std::string::npos) << wanted << "\n" << check.output;
}

TEST(Check, FindsNothingInTheExamplesOnAnyOfTheFiveRobots) {
  for (const char* example : {"pick_and_place", "sorting", "bin_picking"})
    for (const char* robot : {"universal_robots/ur3", "universal_robots/ur5e", "fanuc/lr_mate_200id",
                              "abb/irb_120", "franka/fer_panda"}) {
      const ExampleCopy copy(example);
      const Finished check = run_command({"check", copy.path(), "--robot", robot});
      EXPECT_EQ(check.exit_code, 0) << example << " " << robot << "\n" << check.output;
    }
}

TEST(Check, ADryRunListsContactsByLine) {
  const ExampleCopy copy("pick_and_place");
  std::string scene = read_file(copy.file("scene.yaml"));
  scene.insert(scene.find("bins:"), "  wall: {box: [0.1, 0.02, 0.3], at: [0.3, -0.09, 0.15]}\n");
  write_file_atomically(copy.file("scene.yaml"), scene);
  EXPECT_EQ(run_command({"check", copy.path()}).exit_code, 0);
  const Finished dry = run_command({"check", copy.path(), "--dry", "--cycles", "1"});
  EXPECT_NE(dry.output.find("touched fixture wall"), std::string::npos) << dry.output;
  EXPECT_NE(dry.output.find("PAPscript.script:"), std::string::npos);
}

}  // namespace
}  // namespace polyarm
