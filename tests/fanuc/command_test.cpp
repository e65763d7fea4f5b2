/// The example and `polyarm far-side fanuc`, as users start them.
#include "tests/support/driver_examples.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using namespace test;

TEST(FanucExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("fanuc_far_side");
  expect_same_run_twice(copy, "Stream Motion 3 at 125 Hz");
}

TEST(FanucExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  expect_fault_ends_the_run("fanuc_far_side", {"wires: 1=1 ", "faults: fence_open@2\n      wires: 1=1 "},
                            {"the fence of the controller", "close it"});
}

TEST(FanucExample, ACellInAnotherProcessIsArmedAndPlaces) {
  Command far(
      {"far-side", "fanuc", "--port", "0", "--rmi-port", "0", "--session-port", "0", "--wire", "1=1"});
  const std::string line = far.line_with("Stream Motion ");
  ASSERT_FALSE(number_behind(line, "Stream Motion").empty()) << line;
  const ExampleCopy copy("fanuc_far_side");
  edit(copy, "cell.yaml",
       {{"hardware: fanuc_fake", "hardware: fanuc\n    accept_unverified: true"},
        {"      wires: 1=1 ",
         "      stream_port: " + number_behind(line, "Stream Motion") +
             "\n      rmi_port: " + number_behind(line, "Remote Motion") +
             "\n      silence_ms: 10000\n      loop_silence_ms: 10000\n      settle: 0.1\n      max_behind: "
             "0.2\n      # "}});
  expect_armed_run_completes(copy);
  far.signal(SIGTERM);
  const Finished ended = far.wait();
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(ended.output.find("STREAM_MOTN runs"), std::string::npos) << ended.output;
}

// --- forward mode ---

TEST(FanucForwardExample, PlacesByTheControllersOwnMotionAndRepeatsItself) {
  const ExampleCopy copy("fanuc_forward");
  expect_same_run_twice(copy, "its own motion over Remote Motion");
}

TEST(FanucForwardExample, UntilEndsALineInItsMiddleAndTheNextMoveBeginsThere) {
  expect_until_ends_a_line("fanuc_forward");
}

TEST(FanucForwardExample, TheSameProgramStreamsWithoutTheKey) {
  expect_same_program_streams("fanuc_forward");
}

TEST(FanucForwardExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  expect_fault_ends_the_run("fanuc_forward", {"wires: 1=1 ", "faults: fence_open@2\n      wires: 1=1 "},
                            {"the fence of the controller"});
}

/// The programs of the thesis, on a robot whose controller interpolates, with their parts in a simulated
/// world.
class FanucForwardThesis : public testing::TestWithParam<ThesisCell> {};
INSTANTIATE_TEST_SUITE_P(Programs, FanucForwardThesis,
                         testing::Values(ThesisCell{"pick_and_place", 3}, ThesisCell{"sorting", 4},
                                         ThesisCell{"bin_picking", 6}),
                         thesis_name);

void give_forward_robot(const ExampleCopy& copy) {
  edit(copy, "cell.yaml",
       {{"polyarm: cell/1\n", "polyarm: cell/1\nrate: 125\n"},
        {"model: universal_robots/ur3, hardware: mujoco",
         "model: fanuc/lr_mate_200id, hardware: fanuc_fake, parameters: {motion: forward, world: mock}"}});
}

TEST_P(FanucForwardThesis, RunsUnchangedWithEveryPartInItsPlace) {
  const ExampleCopy copy(GetParam().example);
  give_forward_robot(copy);
  expect_all_placed(run_fast(copy), GetParam().parts);
}

TEST(FanucForwardBlends, TheProgramWithBlendsPlacesEveryPartToo) {
  const ExampleCopy copy("pick_and_place");
  give_forward_robot(copy);
  expect_all_placed(run_fast(copy, {"--program", "flowing"}), 3);
}

TEST(FanucForwardCheck, NamesTheMovesThatTheControllerCannotMake) {
  expect_check_names_moves("fanuc_forward");
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
