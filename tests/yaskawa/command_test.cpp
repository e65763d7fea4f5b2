/// The example, `polyarm far-side yaskawa` and `polyarm setup yaskawa`, as users start them.
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

constexpr const char* kAnyPorts[] = {"--port",    "0", "--state-port", "0",
                                     "--io-port", "0", "--hses-port",  "0"};

std::vector<std::string> far_side(std::vector<std::string> more = {}) {
  std::vector<std::string> out{"far-side", "yaskawa"};
  out.insert(out.end(), std::begin(kAnyPorts), std::end(kAnyPorts));
  out.insert(out.end(), more.begin(), more.end());
  return out;
}

/// `polyarm setup yaskawa` for a far side, from the line with its ports.
std::vector<std::string> setup(const std::string& line, std::vector<std::string> more = {}) {
  std::vector<std::string> out{"setup", "yaskawa", "--host", "127.0.0.1"};
  const std::pair<const char*, const char*> kPorts[] = {{"--port", "motion at port"},
                                                        {"--state-port", "states at"},
                                                        {"--io-port", "signals at"},
                                                        {"--hses-port", "Ethernet server at"}};
  for (const auto& [option, words] : kPorts) {
    out.push_back(option);
    out.push_back(number_behind(line, words));
  }
  out.insert(out.end(), more.begin(), more.end());
  return out;
}

TEST(YaskawaExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("yaskawa_far_side");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("a point every 20 ms"), std::string::npos) << first.output;
  EXPECT_EQ(run_command(line).result()["trace_hash"], first.result()["trace_hash"]);
}

TEST(YaskawaExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  const ExampleCopy copy("yaskawa_far_side");
  std::string text = read_file(copy.file("cell.yaml"));
  ASSERT_NE(text.find("wires: 1=1"), std::string::npos);
  text.replace(text.find("wires: 1=1"), 10, "faults: hold@2\n      wires: 1=1");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("is in hold, by the button of the pendant"), std::string::npos) << ran.output;
  EXPECT_NE(ran.output.find("release it"), std::string::npos) << "says what to do";
}

TEST(YaskawaSetup, FindsTheControllerAndWritesItsJob) {
  Command far(far_side({"--bytes", "big"}));
  const std::string line = far.line_with("MotoROS with motion");
  const ExampleCopy copy("yaskawa_far_side");
  const std::string folder = copy.file("files").string();
  const Finished done = run_command(setup(line, {"--write", folder}));
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("mode play, remote yes"), std::string::npos) << done.output;
  EXPECT_NE(done.output.find("big-endian"), std::string::npos) << done.output;
  EXPECT_NE(read_file(folder + "/INIT_ROS.JBI").find("WAIT OT#(890)=ON"), std::string::npos);
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

// --- forward mode ---

TEST(YaskawaForwardExample, PlacesByTheControllersOwnMotion) {
  const ExampleCopy copy("yaskawa_forward");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("its own motion over the Ethernet server, a stop at each move"),
            std::string::npos)
      << first.output;
}

TEST(YaskawaForwardExample, APersonHoldsAndResumesIt) {
  const ExampleCopy copy("yaskawa_forward");
  const Finished ran = run_command({"test", copy.path()});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(YaskawaForwardExample, TheSameProgramStreamsWithoutTheKey) {
  const ExampleCopy copy("yaskawa_forward");
  std::string text = read_file(copy.file("cell.yaml"));
  ASSERT_NE(text.find("motion: forward"), std::string::npos);
  text.replace(text.find("motion: forward"), 15, "motion: stream");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(YaskawaSetup, OfForwardModeNeedsNoMotoRosAndWritesJobAndLadder) {
  Command far(far_side({"--tool", "suction_cup"}));
  const std::string line = far.line_with("MotoROS with motion");
  const ExampleCopy copy("yaskawa_forward");
  const std::string folder = copy.file("files").string();
  const Finished done =
      run_command({"setup", "yaskawa", "--host", "127.0.0.1", "--hses-port",
                   number_behind(line, "Ethernet server at"), "--motion", "forward", "--write", folder});
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("axes S L U R B T: 0 0 0 0 -54000 0 pulses"), std::string::npos) << done.output;
  EXPECT_NE(read_file(folder + "/POLYARM.JBI").find("MOVL P083 V=I084"), std::string::npos);
  EXPECT_NE(read_file(folder + "/LADDER.TXT").find("EXTERNAL HOLD"), std::string::npos);
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(YaskawaSetup, SaysWhatIsNotReady) {
  Command far(far_side({"--order", "teach"}));
  const Finished wrong = run_command(setup(far.line_with("MotoROS with motion")));
  EXPECT_EQ(wrong.exit_code, 1) << wrong.output;
  EXPECT_NE(wrong.output.find("key of the pendant to REMOTE"), std::string::npos) << wrong.output;
  far.signal(SIGTERM);
  far.wait();
}

TEST(YaskawaFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command(far_side({"--cycle", "0"})).exit_code, 2);
  EXPECT_EQ(run_command(far_side({"--bytes", "middle"})).exit_code, 2);
  EXPECT_EQ(run_command(far_side({"--start", "1 2 3"})).exit_code, 2);
  EXPECT_EQ(run_command(far_side({"--wire", "0=1"})).exit_code, 2);
  const Finished base = run_command(far_side({"--robot", "agilex/ranger"}));
  EXPECT_NE(base.exit_code, 0) << base.output;
}

}  // namespace
}  // namespace polyarm
