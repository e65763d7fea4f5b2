/// The example, `polyarm far-side abb` and `polyarm setup abb`, as users start them.
#include "tests/support/driver_examples.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using namespace test;

TEST(AbbExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("abb_far_side");
  expect_same_run_twice(copy, "EGM at 250 Hz");
}

TEST(AbbExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  expect_fault_ends_the_run(
      "abb_far_side", {"wires: doVacuum=diHolds", "faults: guard_open@2\n      wires: doVacuum=diHolds"},
      {"a guard of the controller", "close it"});
}

TEST(AbbSetup, FindsTheControllerAndInstallsTheModule) {
  Command far({"far-side", "abb", "--port", "0", "--moves-port", "0", "--order", "no_module"});
  const std::string port = number_behind(far.line_with("Robot Web Services "), "at port");
  ASSERT_FALSE(port.empty());
  const std::vector<std::string> line{"setup", "abb", "--host",     "127.0.0.1",
                                      "--rws", "2",   "--rws-port", port};
  const Finished missing = run_command(line);
  EXPECT_EQ(missing.exit_code, 1) << missing.output;
  EXPECT_NE(missing.output.find("does not have the module PolyarmEGM"), std::string::npos) << missing.output;
  EXPECT_NE(missing.output.find("Externally Guided Motion is installed"), std::string::npos)
      << missing.output;
  std::vector<std::string> install = line;
  install.insert(install.end(), {"--install", "--yes"});
  const Finished done = run_command(install);
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("loaded"), std::string::npos) << done.output;
  EXPECT_EQ(run_command(line).exit_code, 0);
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

// --- forward mode ---

TEST(AbbForwardExample, PlacesByTheControllersOwnMotionAndRepeatsItself) {
  const ExampleCopy copy("abb_forward");
  expect_same_run_twice(copy, "its own motion by the RAPID program PolyarmMoves");
}

TEST(AbbForwardExample, APersonHoldsAndResumesIt) {
  const ExampleCopy copy("abb_forward");
  const Finished ran = run_command({"test", copy.path()});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(AbbForwardExample, UntilEndsALineInItsMiddleAndTheNextMoveBeginsThere) {
  expect_until_ends_a_line("abb_forward");
}

TEST(AbbForwardExample, TheSameProgramStreamsWithoutTheKey) {
  expect_same_program_streams("abb_forward");
}

TEST(AbbForwardExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  expect_fault_ends_the_run(
      "abb_forward", {"wires: doVacuum=diHolds", "faults: guard_open@2\n      wires: doVacuum=diHolds"},
      {"a guard of the controller", "close it"});
}

TEST(AbbForwardExample, ACellInAnotherProcessIsArmedAndPlaces) {
  Command far({"far-side", "abb", "--motion", "forward", "--port", "0", "--moves-port", "0", "--wire",
               "doVacuum=diHolds"});
  const std::string rws = number_behind(far.line_with("Robot Web Services "), "at port");
  const std::string moves = number_behind(far.line_with("PolyarmMoves"), "at port");
  ASSERT_FALSE(rws.empty() || moves.empty());
  const ExampleCopy copy("abb_forward");
  edit(copy, "cell.yaml",
       {{"hardware: abb_fake", "hardware: abb\n    accept_unverified: true"},
        {"      wires: doVacuum=diHolds", "      rws_port: " + rws + "\n      moves_port: " + moves +
                                              "\n      answer_ms: 10000\n      watchdog_ms: 5000\n      "
                                              "loop_silence_ms: 10000\n      # "}});
  expect_armed_run_completes(copy);
  far.signal(SIGTERM);
  const Finished ended = far.wait();
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(ended.output.find("the program ended"), std::string::npos) << ended.output;
}

/// Two programs of the thesis, on a robot whose controller interpolates, with their parts in a simulated
/// world.
class AbbForwardThesis : public testing::TestWithParam<ThesisCell> {};
INSTANTIATE_TEST_SUITE_P(Programs, AbbForwardThesis,
                         testing::Values(ThesisCell{"pick_and_place", 3}, ThesisCell{"sorting", 4}),
                         thesis_name);

TEST_P(AbbForwardThesis, RunsUnchangedWithEveryPartInItsPlace) {
  const ExampleCopy copy(GetParam().example);
  edit(copy, "cell.yaml",
       {{"polyarm: cell/1\n", "polyarm: cell/1\nrate: 250\n"},
        {"hardware: mujoco", "hardware: abb_fake, parameters: {motion: forward, world: mock}"}});
  expect_all_placed(run_fast(copy), GetParam().parts);
}

TEST(AbbForwardCheck, NamesTheMovesThatTheControllerCannotMake) {
  expect_check_names_moves("abb_forward");
}

TEST(AbbSetup, InstallsTheModuleOfForwardMode) {
  Command far(
      {"far-side", "abb", "--port", "0", "--moves-port", "0", "--motion", "forward", "--order", "no_module"});
  const std::string port = number_behind(far.line_with("Robot Web Services "), "at port");
  ASSERT_FALSE(port.empty());
  const ExampleCopy copy("abb_forward");
  const std::string folder = copy.file("files").string();
  const std::vector<std::string> line{"setup",      "abb", "--host",   "127.0.0.1", "--rws",   "2",
                                      "--rws-port", port,  "--motion", "forward",   "--write", folder};
  const Finished missing = run_command(line);
  EXPECT_EQ(missing.exit_code, 1) << missing.output;
  EXPECT_NE(missing.output.find("does not have the module PolyarmMoves"), std::string::npos)
      << missing.output;
  EXPECT_NE(read_file(folder + "/PolyarmMoves.mod").find("SocketBind server, address, port"),
            std::string::npos);
  std::vector<std::string> install = line;
  install.insert(install.end(), {"--install", "--yes"});
  const Finished done = run_command(install);
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_EQ(run_command(line).exit_code, 0);
  const Finished again = run_command(install);
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_NE(again.output.find("  loaded\n"), std::string::npos) << "it replaces an old one\n" << again.output;
  std::vector<std::string> named = line;
  named[3] = "localhost";
  EXPECT_EQ(run_command(named).exit_code, 0);
  EXPECT_NE(read_file(folder + "/PolyarmMoves.mod").find("\"127.0.0.1\""), std::string::npos)
      << "SocketBind takes no name";
  std::vector<std::string> other = install;
  other.erase(std::find(other.begin(), other.end(), "--motion"),
              std::find(other.begin(), other.end(), "--write"));
  const Finished both = run_command(other);
  EXPECT_EQ(both.exit_code, 1) << both.output;
  EXPECT_NE(both.output.find("PolyarmMoves is loaded in T_ROB1: unload it first"), std::string::npos)
      << both.output;
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(AbbFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command({"far-side", "abb", "--rws", "3"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "abb", "--egm", "nowhere", "--port", "0"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "abb", "--start", "1 2 3", "--port", "0"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "abb", "--wire", "a", "--port", "0"}).exit_code, 2);
  const Finished base = run_command({"far-side", "abb", "--robot", "agilex/ranger", "--port", "0"});
  EXPECT_NE(base.exit_code, 0) << base.output;
}

}  // namespace
}  // namespace polyarm
