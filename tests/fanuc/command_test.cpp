/// The example and `polyarm far-side fanuc`, as users start them.
#include "tests/support/command.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/file.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using test::Command;
using test::ExampleCopy;
using test::Finished;
using test::run_command;

void replace(std::string& text, const std::string& from, const std::string& to) {
  ASSERT_NE(text.find(from), std::string::npos) << from;
  text.replace(text.find(from), from.size(), to);
}

TEST(FanucExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("fanuc_far_side");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("Stream Motion 3 at 125 Hz"), std::string::npos) << first.output;
  EXPECT_EQ(run_command(line).result()["trace_hash"], first.result()["trace_hash"]);
}

TEST(FanucExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  const ExampleCopy copy("fanuc_far_side");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "wires: 1=1 ", "faults: fence_open@2\n      wires: 1=1 ");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("the fence of the controller"), std::string::npos) << ran.output;
  EXPECT_NE(ran.output.find("close it"), std::string::npos) << "says what to do";
}

TEST(FanucExample, ACellInAnotherProcessIsArmedAndPlaces) {
  Command far(
      {"far-side", "fanuc", "--port", "0", "--rmi-port", "0", "--session-port", "0", "--wire", "1=1"});
  const std::string line = far.line_with("Stream Motion ");
  ASSERT_FALSE(test::number_behind(line, "Stream Motion").empty()) << line;
  const ExampleCopy copy("fanuc_far_side");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "hardware: fanuc_fake", "hardware: fanuc\n    accept_unverified: true");
  replace(text, "      wires: 1=1 ",
          "      stream_port: " + test::number_behind(line, "Stream Motion") +
              "\n      rmi_port: " + test::number_behind(line, "Remote Motion") +
              "\n      silence_ms: 10000\n      loop_silence_ms: 10000\n      settle: 0.1\n      max_behind: "
              "0.2\n      # ");
  write_file_atomically(copy.file("cell.yaml"), text);
  Command cell({"run", copy.path(), "--real", "--json", "--no-socket"},
               test::Input::terminal);
  if (cell.wait_for("nothing moves before a person types")) cell.type("arm\n");
  const Finished ran = cell.wait();
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["result"], "completed");
  far.signal(SIGTERM);
  const Finished ended = far.wait();
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(ended.output.find("STREAM_MOTN runs"), std::string::npos) << ended.output;
}

// --- forward mode ---

TEST(FanucForwardExample, PlacesByTheControllersOwnMotionAndRepeatsItself) {
  const ExampleCopy copy("fanuc_forward");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("its own motion over Remote Motion"), std::string::npos) << first.output;
  EXPECT_EQ(run_command(line).result()["trace_hash"], first.result()["trace_hash"]);
}

TEST(FanucForwardExample, UntilEndsALineInItsMiddleAndTheNextMoveBeginsThere) {
  const ExampleCopy copy("fanuc_forward");
  write_file_atomically(copy.file("placing.script"),
                        "load job\nmovej AbovePick\nset Vacuum = true\n"
                        "movel AbovePlace speed 5% until Holds\nmovel Place\n");
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["result"], "completed");
  // The whole line takes more than 5 s at this speed.
  EXPECT_LT(ran.result()["sim_time_s"].get<double>(), 5) << ran.output;
}

TEST(FanucForwardExample, TheSameProgramStreamsWithoutTheKey) {
  const ExampleCopy copy("fanuc_forward");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "motion: forward", "motion: stream");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(FanucForwardExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  const ExampleCopy copy("fanuc_forward");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "wires: 1=1 ", "faults: fence_open@2\n      wires: 1=1 ");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("the fence of the controller"), std::string::npos) << ran.output;
}

/// The programs of the thesis, on a robot whose controller interpolates, with their parts in a simulated
/// world.
struct ThesisCell {
  const char* example;
  std::size_t parts;
};
class FanucForwardThesis : public testing::TestWithParam<ThesisCell> {};
INSTANTIATE_TEST_SUITE_P(Programs, FanucForwardThesis,
                         testing::Values(ThesisCell{"pick_and_place", 3}, ThesisCell{"sorting", 4},
                                         ThesisCell{"bin_picking", 6}),
                         [](const auto& named) { return std::string(named.param.example); });

void give_forward_robot(const ExampleCopy& copy, const std::string& world) {
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "polyarm: cell/1\n", "polyarm: cell/1\nrate: 125\n");
  replace(text, "model: universal_robots/ur3, hardware: mujoco",
          "model: fanuc/lr_mate_200id, hardware: fanuc_fake, parameters: {motion: forward, world: " + world +
              "}");
  write_file_atomically(copy.file("cell.yaml"), text);
}

TEST_P(FanucForwardThesis, RunsUnchangedWithEveryPartInItsPlace) {
  const ExampleCopy copy(GetParam().example);
  give_forward_robot(copy, "mock");
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output.substr(ran.output.size() > 3000 ? ran.output.size() - 3000 : 0);
  const nlohmann::json result = ran.result();
  EXPECT_EQ(result["result"], "completed");
  ASSERT_EQ(result["parts"].size(), GetParam().parts);
  for (const auto& part : result["parts"]) {
    EXPECT_EQ(part["state"], "placed") << part;
    EXPECT_LE(part["error_m"].get<double>(), 0.005) << part;
  }
}

TEST(FanucForwardBlends, TheProgramWithBlendsPlacesEveryPartToo) {
  const ExampleCopy copy("pick_and_place");
  give_forward_robot(copy, "mock");
  const Finished ran =
      run_command({"run", copy.path(), "--program", "flowing", "--fast", "--json", "--no-socket"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  for (const auto& part : ran.result()["parts"]) EXPECT_EQ(part["state"], "placed") << part;
}

TEST(FanucForwardCheck, NamesTheMovesThatTheControllerCannotMake) {
  const ExampleCopy copy("fanuc_forward");
  write_file_atomically(copy.file("placing.script"),
                        "load job\nmovej AbovePick\nmovel [Over, AbovePlace, Place], smooth\n");
  const Finished ran = run_command({"check", copy.path()});
  EXPECT_EQ(ran.exit_code, 1) << ran.output;
  EXPECT_NE(ran.output.find("`motion: forward`"), std::string::npos) << ran.output;
  EXPECT_NE(ran.output.find("placing.script:3"), std::string::npos) << ran.output;
}

TEST(FanucFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command({"far-side", "nachi"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "fanuc", "--protocol", "2"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "fanuc", "--start", "1 2 3", "--port", "0"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "fanuc", "--wire", "0=1", "--port", "0", "--rmi-port", "0"}).exit_code,
            2);
  const Finished base = run_command({"far-side", "fanuc", "--robot", "agilex/ranger", "--port", "0"});
  EXPECT_NE(base.exit_code, 0) << base.output;
}

}  // namespace
}  // namespace polyarm
