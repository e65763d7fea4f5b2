/// The example, `polyarm far-side kuka` and `polyarm setup kuka`, as users start them.
#include "tests/support/driver_examples.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using namespace test;

TEST(KukaExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("kuka_far_side");
  expect_same_run_twice(copy, "RSI 5 at 250 Hz");
}

TEST(KukaExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  expect_fault_ends_the_run("kuka_far_side", {"wires: 1=1", "faults: guard_open@2\n      wires: 1=1"},
                            {"a guard of the controller", "close it"});
}

// --- forward mode ---

TEST(KukaForwardExample, PlacesByTheControllersOwnMotionAndRepeatsItself) {
  const ExampleCopy copy("kuka_forward");
  expect_same_run_twice(copy, "its own motion over EthernetKRL");
}

TEST(KukaForwardExample, APersonHoldsAndResumesIt) {
  const ExampleCopy copy("kuka_forward");
  const Finished ran = run_command({"test", copy.path()});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(KukaForwardExample, UntilEndsALineInItsMiddleAndTheNextMoveBeginsThere) {
  expect_until_ends_a_line("kuka_forward");
}

TEST(KukaForwardExample, TheSameProgramStreamsWithoutTheKey) {
  expect_same_program_streams("kuka_forward");
}

TEST(KukaForwardExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  expect_fault_ends_the_run("kuka_forward", {"wires: 1=1 ", "faults: guard_open@2\n      wires: 1=1 "},
                            {"a guard of the controller"});
}

/// Two programs of the thesis, on a robot whose controller interpolates, with their parts in a simulated
/// world.
class KukaForwardThesis : public testing::TestWithParam<ThesisCell> {};
INSTANTIATE_TEST_SUITE_P(Programs, KukaForwardThesis,
                         testing::Values(ThesisCell{"pick_and_place", 3}, ThesisCell{"sorting", 4}),
                         thesis_name);

TEST_P(KukaForwardThesis, RunsUnchangedWithEveryPartInItsPlace) {
  const ExampleCopy copy(GetParam().example);
  edit(copy, "cell.yaml",
       {{"polyarm: cell/1\n", "polyarm: cell/1\nrate: 250\n"},
        {"hardware: mujoco", "hardware: kuka_fake, parameters: {motion: forward, world: mock}"}});
  expect_all_placed(run_fast(copy), GetParam().parts);
}

TEST(KukaForwardCheck, NamesTheMovesThatTheControllerCannotMake) {
  expect_check_names_moves("kuka_forward");
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
