/// The example and `polyarm far-side ur`, as users start them.
#include "tests/support/command.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/file.hpp"

namespace polyarm {
namespace {

using test::Command;
using test::ExampleCopy;
using test::Finished;
using test::run_command;

TEST(UrExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("ur_far_side");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("Universal Robots controller 5.15.0"), std::string::npos);
  EXPECT_EQ(run_command(line).result()["trace_hash"], first.result()["trace_hash"]);
}

TEST(UrExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  const ExampleCopy copy("ur_far_side");
  std::string text = read_file(copy.file("cell.yaml"));
  const std::string wires = "wires: 0=0 ";
  text.replace(text.find(wires), wires.size(), "faults: protective_stop@2\n      wires: 0=0 ");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("made a protective stop"), std::string::npos) << ran.output;
  EXPECT_NE(ran.output.find("Enable robot"), std::string::npos) << "says what to do";
}

/// The number behind a word, in a line of the far side.
std::string port_behind(const std::string& line, const std::string& word) {
  const std::size_t at = line.find(word + " ");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + word.size() + 1;
  return line.substr(begin, line.find_first_not_of("0123456789", begin) - begin);
}

TEST(UrExample, ACellInAnotherProcessIsArmedAndPlaces) {
  Command far({"far-side", "ur", "--port", "0", "--dashboard-port", "0", "--primary-port", "0",
               "--secondary-port", "0", "--wire", "0=0"});
  const std::string line = far.line_with("RTDE ");
  ASSERT_FALSE(port_behind(line, "RTDE").empty()) << line;
  const ExampleCopy copy("ur_far_side");
  std::string text = read_file(copy.file("cell.yaml"));
  const auto replace = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
  };
  replace("hardware: ur_fake", "hardware: ur\n    accept_unverified: true");
  replace("      wires: 0=0 ", "      rtde_port: " + port_behind(line, "RTDE") +
                                   "\n      primary_port: " + port_behind(line, "primary") +
                                   "\n      dashboard_port: " + port_behind(line, "dashboard") +
                                   "\n      watchdog_ms: 5000\n      silence_ms: 10000\n      # ");
  write_file_atomically(copy.file("cell.yaml"), text);
  Command cell({"run", copy.path(), "--real", "--full-speed", "--json", "--no-socket"},
               test::Input::terminal);
  if (cell.wait_for("nothing moves before a person types")) cell.type("arm\n");
  const Finished ran = cell.wait();
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["result"], "completed");
  far.signal(SIGTERM);
  const Finished ended = far.wait();
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(ended.output.find("a program started"), std::string::npos) << ended.output;
}

// --- forward mode ---

void replace(std::string& text, const std::string& from, const std::string& to) {
  ASSERT_NE(text.find(from), std::string::npos) << from;
  text.replace(text.find(from), from.size(), to);
}

TEST(UrForwardExample, PlacesByTheControllersOwnMotionAndRepeatsItself) {
  const ExampleCopy copy("ur_forward");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("500 Hz, its own motion"), std::string::npos) << first.output;
  EXPECT_EQ(run_command(line).result()["trace_hash"], first.result()["trace_hash"]);
}

TEST(UrForwardExample, APersonHoldsAndResumesIt) {
  const ExampleCopy copy("ur_forward");
  const Finished ran = run_command({"test", copy.path()});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(UrForwardExample, UntilEndsALineInItsMiddleAndTheNextMoveBeginsThere) {
  const ExampleCopy copy("ur_forward");
  write_file_atomically(copy.file("placing.script"),
                        "load job\nmovej AbovePick\nset Vacuum = true\n"
                        "movel AbovePlace speed 5% until Holds\nmovel Place\n");
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["result"], "completed");
  // The whole line takes more than 5 s at this speed.
  EXPECT_LT(ran.result()["sim_time_s"].get<double>(), 5) << ran.output;
}

TEST(UrForwardExample, TheSameProgramStreamsWithoutTheKey) {
  const ExampleCopy copy("ur_forward");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "motion: forward", "motion: stream");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(UrForwardExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  const ExampleCopy copy("ur_forward");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "wires: 0=0 ", "faults: protective_stop@2\n      wires: 0=0 ");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("made a protective stop"), std::string::npos) << ran.output;
}

TEST(UrForwardExample, ACellInAnotherProcessIsArmedAndPlaces) {
  Command far({"far-side", "ur", "--port", "0", "--dashboard-port", "0", "--primary-port", "0",
               "--secondary-port", "0", "--wire", "0=0"});
  const std::string line = far.line_with("RTDE ");
  ASSERT_FALSE(port_behind(line, "RTDE").empty()) << line;
  const ExampleCopy copy("ur_forward");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "hardware: ur_fake", "hardware: ur\n    accept_unverified: true");
  replace(text, "      wires: 0=0 ",
          "      rtde_port: " + port_behind(line, "RTDE") + "\n      primary_port: " +
              port_behind(line, "primary") + "\n      dashboard_port: " + port_behind(line, "dashboard") +
              "\n      watchdog_ms: 5000\n      silence_ms: 10000\n      # ");
  write_file_atomically(copy.file("cell.yaml"), text);
  Command cell({"run", copy.path(), "--real", "--full-speed", "--json", "--no-socket"},
               test::Input::terminal);
  if (cell.wait_for("nothing moves before a person types")) cell.type("arm\n");
  const Finished ran = cell.wait();
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["result"], "completed");
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

/// The programs of the thesis, on a robot whose controller interpolates, with their parts in a simulated
/// world.
struct ThesisCell {
  const char* example;
  std::size_t parts;
};
class UrForwardThesis : public testing::TestWithParam<ThesisCell> {};
INSTANTIATE_TEST_SUITE_P(Programs, UrForwardThesis,
                         testing::Values(ThesisCell{"pick_and_place", 3}, ThesisCell{"sorting", 4},
                                         ThesisCell{"bin_picking", 6}),
                         [](const auto& named) { return std::string(named.param.example); });

void give_forward_robot(const ExampleCopy& copy) {
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "polyarm: cell/1\n", "polyarm: cell/1\nrate: 125\n");
  replace(text, "hardware: mujoco", "hardware: ur_fake, parameters: {motion: forward, world: mock}");
  write_file_atomically(copy.file("cell.yaml"), text);
}

TEST_P(UrForwardThesis, RunsUnchangedWithEveryPartInItsPlace) {
  const ExampleCopy copy(GetParam().example);
  give_forward_robot(copy);
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

TEST(UrForwardBlends, TheProgramWithBlendsPlacesEveryPartToo) {
  const ExampleCopy copy("pick_and_place");
  give_forward_robot(copy);
  const Finished ran =
      run_command({"run", copy.path(), "--program", "flowing", "--fast", "--json", "--no-socket"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  for (const auto& part : ran.result()["parts"]) EXPECT_EQ(part["state"], "placed") << part;
}

TEST(UrForwardCheck, NamesTheMovesThatTheControllerCannotMake) {
  const ExampleCopy copy("ur_forward");
  write_file_atomically(copy.file("placing.script"),
                        "load job\nmovej AbovePick\nmovel [Over, AbovePlace, Place], smooth\n");
  const Finished ran = run_command({"check", copy.path()});
  EXPECT_EQ(ran.exit_code, 1) << ran.output;
  EXPECT_NE(ran.output.find("`motion: forward`"), std::string::npos) << ran.output;
  EXPECT_NE(ran.output.find("placing.script:3"), std::string::npos) << ran.output;
}

TEST(UrForwardCheck, NamesACallThatWouldLetTheToolYield) {
  const ExampleCopy copy("ur_forward");
  write_file_atomically(copy.file("placing.script"),
                        "load job\nmovej AbovePick\ncomply(\"z\", force = 20N)\nstiff()\n");
  for (const char* verb : {"check", "run"}) {
    std::vector<std::string> line{verb, copy.path()};
    if (line.front() == "run") line.insert(line.end(), {"--fast", "--json", "--no-socket"});
    const Finished ran = run_command(line);
    if (line.front() == "run") EXPECT_EQ(ran.exit_code, 1) << ran.output;
    EXPECT_NE(ran.output.find("`motion: forward`"), std::string::npos) << ran.output;
  }
}

TEST(UrFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command({"far-side", "nachi"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "ur", "--software", "new"}).exit_code, 2);
  const Finished base = run_command({"far-side", "ur", "--robot", "agilex/ranger", "--port", "0"});
  EXPECT_NE(base.exit_code, 0) << base.output;
}

}  // namespace
}  // namespace polyarm
