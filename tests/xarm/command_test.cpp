/// The example, `polyarm far-side xarm` and `polyarm setup xarm`, as users start them.
#include "tests/support/driver_examples.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using namespace test;

constexpr const char* kAnyPorts[] = {"--port",      "0", "--normal-port", "0",
                                     "--rich-port", "0", "--report-port", "0"};

std::vector<std::string> far_side(std::vector<std::string> more = {}) {
  std::vector<std::string> out{"far-side", "xarm"};
  out.insert(out.end(), std::begin(kAnyPorts), std::end(kAnyPorts));
  out.insert(out.end(), more.begin(), more.end());
  return out;
}

/// `polyarm setup xarm` for a far side, from the line with its ports.
std::vector<std::string> setup(const std::string& line) {
  const std::string rich = line.substr(line.find("(normal), ") + 10);
  const std::string motion = line.substr(line.find("(rich) and ") + 11);
  return {"setup",         "xarm",
          "--host",        "127.0.0.1",
          "--port",        number_behind(line, "commands at port"),
          "--rich-port",   rich.substr(0, rich.find(' ')),
          "--report-port", motion.substr(0, motion.find(' '))};
}

TEST(XarmExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("xarm_far_side");
  expect_same_run_twice(copy, "a servo command every 4 ms");
}

TEST(XarmExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  expect_fault_ends_the_run("xarm_far_side", {"wires: 0=0", "faults: error=31@2\n      wires: 0=0"},
                            {"stopped for a collision (C31)", "clear the space"});
}

// --- forward mode ---

TEST(XarmForwardExample, PlacesByTheControllersOwnMotionAndRepeatsItself) {
  const ExampleCopy copy("xarm_forward");
  expect_same_run_twice(copy, "its own motion");
}

TEST(XarmForwardExample, APersonHoldsAndResumesIt) {
  const ExampleCopy copy("xarm_forward");
  const Finished ran = run_command({"test", copy.path()});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(XarmForwardExample, UntilEndsALineInItsMiddleAndTheNextMoveBeginsThere) {
  expect_until_ends_a_line("xarm_forward");
}

TEST(XarmForwardExample, TheSameProgramStreamsWithoutTheKey) {
  expect_same_program_streams("xarm_forward");
}

TEST(XarmForwardExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  expect_fault_ends_the_run("xarm_forward", {"wires: 0=0 ", "faults: error=31@2\n      wires: 0=0 "},
                            {"stopped for a collision (C31)"});
}

TEST(XarmForwardExample, CheckNamesMovesThatTheControllerDoesNotTake) {
  expect_check_names_moves("xarm_forward");
}

/// Two programs of the thesis, on a robot whose controller interpolates, with their parts in a simulated
/// world.
class XarmForwardThesis : public testing::TestWithParam<ThesisCell> {};
INSTANTIATE_TEST_SUITE_P(Programs, XarmForwardThesis,
                         testing::Values(ThesisCell{"pick_and_place", 3}, ThesisCell{"sorting", 4}),
                         thesis_name);

TEST_P(XarmForwardThesis, RunsUnchangedWithEveryPartInItsPlace) {
  const ExampleCopy copy(GetParam().example);
  edit(copy, "cell.yaml",
       {{"polyarm: cell/1\n", "polyarm: cell/1\nrate: 250\n"},
        {"model: universal_robots/ur3, hardware: mujoco",
         "model: ufactory/xarm_6, hardware: xarm_fake, parameters: {motion: forward, world: mock}"}});
  expect_all_placed(run_fast(copy), GetParam().parts);
}

TEST(XarmSetup, FindsTheControllerAndShowsItsSettings) {
  Command far(far_side({"--robot", "ufactory/xarm_7", "--firmware", "2.5.0"}));
  const Finished done = run_command(setup(far.line_with("commands at port")));
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("an arm with 7 axes"), std::string::npos) << done.output;
  EXPECT_NE(done.output.find("firmware 2.5.0"), std::string::npos) << done.output;
  EXPECT_NE(done.output.find("motors on"), std::string::npos) << done.output;
  EXPECT_NE(done.output.find("sensitivity to collisions 3 of 5"), std::string::npos) << done.output;
  EXPECT_NE(done.output.find("reports for motion"), std::string::npos) << done.output;
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(XarmSetup, SaysWhatIsNotReady) {
  Command far(far_side({"--order", "e_stop"}));
  const Finished wrong = run_command(setup(far.line_with("commands at port")));
  EXPECT_EQ(wrong.exit_code, 1) << wrong.output;
  EXPECT_NE(wrong.output.find("button at the control box is pressed"), std::string::npos) << wrong.output;
  far.signal(SIGTERM);
  far.wait();
}

TEST(XarmFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command(far_side({"--cycle", "0"})).exit_code, 2);
  EXPECT_EQ(run_command(far_side({"--start", "1 2 3"})).exit_code, 2);
  EXPECT_EQ(run_command(far_side({"--wire", "0=16"})).exit_code, 2);
  EXPECT_NE(run_command(far_side({"--robot", "agilex/ranger"})).exit_code, 0);
  EXPECT_NE(run_command(far_side({"--order", "storm"})).exit_code, 0);
  EXPECT_EQ(run_command({"setup", "xarm"}).exit_code, 2) << "the address is on the label of the control box";
}

}  // namespace
}  // namespace polyarm
