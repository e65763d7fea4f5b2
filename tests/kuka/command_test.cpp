/// The example, `polyarm far-side kuka` and `polyarm setup kuka`, as users start them.
#include "tests/support/command.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/file.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using test::Command;
using test::ExampleCopy;
using test::Finished;
using test::number_behind;
using test::run_command;

void replace(std::string& text, const std::string& from, const std::string& to) {
  ASSERT_NE(text.find(from), std::string::npos) << from;
  text.replace(text.find(from), from.size(), to);
}

TEST(KukaExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("kuka_far_side");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("RSI 5 at 250 Hz"), std::string::npos) << first.output;
  EXPECT_EQ(run_command(line).result()["trace_hash"], first.result()["trace_hash"]);
}

TEST(KukaExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  const ExampleCopy copy("kuka_far_side");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "wires: 1=1", "faults: guard_open@2\n      wires: 1=1");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("a guard of the controller"), std::string::npos) << ran.output;
  EXPECT_NE(ran.output.find("close it"), std::string::npos) << "says what to do";
}

// --- forward mode ---

TEST(KukaForwardExample, PlacesByTheControllersOwnMotionAndRepeatsItself) {
  const ExampleCopy copy("kuka_forward");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("its own motion over EthernetKRL"), std::string::npos) << first.output;
  EXPECT_EQ(run_command(line).result()["trace_hash"], first.result()["trace_hash"]);
}

TEST(KukaForwardExample, APersonHoldsAndResumesIt) {
  const ExampleCopy copy("kuka_forward");
  const Finished ran = run_command({"test", copy.path()});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(KukaForwardExample, UntilEndsALineInItsMiddleAndTheNextMoveBeginsThere) {
  const ExampleCopy copy("kuka_forward");
  write_file_atomically(copy.file("placing.script"),
                        "load job\nmovej AbovePick\nset Vacuum = true\n"
                        "movel AbovePlace speed 5% until Holds\nmovel Place\n");
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["result"], "completed");
  // The whole line takes more than 5 s at this speed.
  EXPECT_LT(ran.result()["sim_time_s"].get<double>(), 5) << ran.output;
}

TEST(KukaForwardExample, TheSameProgramStreamsWithoutTheKey) {
  const ExampleCopy copy("kuka_forward");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "motion: forward", "motion: stream");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(KukaForwardExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  const ExampleCopy copy("kuka_forward");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "wires: 1=1 ", "faults: guard_open@2\n      wires: 1=1 ");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("a guard of the controller"), std::string::npos) << ran.output;
}

/// Two programs of the thesis, on a robot whose controller interpolates, with their parts in a simulated
/// world.
struct ThesisCell {
  const char* example;
  std::size_t parts;
};
class KukaForwardThesis : public testing::TestWithParam<ThesisCell> {};
INSTANTIATE_TEST_SUITE_P(Programs, KukaForwardThesis,
                         testing::Values(ThesisCell{"pick_and_place", 3}, ThesisCell{"sorting", 4}),
                         [](const auto& named) { return std::string(named.param.example); });

void give_forward_robot(const ExampleCopy& copy) {
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "polyarm: cell/1\n", "polyarm: cell/1\nrate: 250\n");
  replace(text, "hardware: mujoco", "hardware: kuka_fake, parameters: {motion: forward, world: mock}");
  write_file_atomically(copy.file("cell.yaml"), text);
}

TEST_P(KukaForwardThesis, RunsUnchangedWithEveryPartInItsPlace) {
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

TEST(KukaForwardCheck, NamesTheMovesThatTheControllerCannotMake) {
  const ExampleCopy copy("kuka_forward");
  write_file_atomically(copy.file("placing.script"),
                        "load job\nmovej AbovePick\nmovel [Over, AbovePlace, Place], smooth\n");
  const Finished ran = run_command({"check", copy.path()});
  EXPECT_EQ(ran.exit_code, 1) << ran.output;
  EXPECT_NE(ran.output.find("`motion: forward`"), std::string::npos) << ran.output;
}

TEST(KukaSetup, FindsTheControllerAndWritesItsFiles) {
  Command far({"far-side", "kuka", "--port", "0"});
  const std::string port = number_behind(far.line_with("EthernetKRL "), "at port");
  ASSERT_FALSE(port.empty());
  const ExampleCopy copy("kuka_far_side");
  const std::string folder = copy.file("files").string();
  const Finished done =
      run_command({"setup", "kuka", "--host", "127.0.0.1", "--port", port, "--write", folder, "--rsi", "4"});
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("mode EXT"), std::string::npos) << done.output;
  EXPECT_NE(read_file(folder + "/Config/User/Common/SensorInterface/PolyarmRsi.xml").find("127.0.0.1"),
            std::string::npos);
  EXPECT_NE(read_file(folder + "/KRC/R1/Program/PolyarmRsi.src").find("RSI_MOVECORR"), std::string::npos);
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(KukaSetup, WritesItsFilesThoughTheControllerIsNotReady) {
  Command far({"far-side", "kuka", "--port", "0", "--order", "t1"});
  const std::string port = number_behind(far.line_with("EthernetKRL "), "at port");
  const Finished wrong = run_command({"setup", "kuka", "--host", "127.0.0.1", "--port", port});
  EXPECT_EQ(wrong.exit_code, 1) << wrong.output;
  EXPECT_NE(wrong.output.find("choose EXT"), std::string::npos) << wrong.output;
  far.signal(SIGTERM);
  far.wait();
}

TEST(KukaFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command({"far-side", "kuka", "--cycle", "8", "--port", "0"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "kuka", "--rsi", "nowhere", "--port", "0"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "kuka", "--start", "1 2 3", "--port", "0"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "kuka", "--wire", "0=1", "--port", "0"}).exit_code, 2);
  const Finished base = run_command({"far-side", "kuka", "--robot", "agilex/ranger", "--port", "0"});
  EXPECT_NE(base.exit_code, 0) << base.output;
}

}  // namespace
}  // namespace polyarm
