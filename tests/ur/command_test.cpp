/// The example and `polyarm far-side ur`, as users start them.
#include "tests/support/driver_examples.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using namespace test;

TEST(UrExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("ur_far_side");
  expect_same_run_twice(copy, "Universal Robots controller 5.15.0");
}

TEST(UrExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  expect_fault_ends_the_run("ur_far_side", {"wires: 0=0 ", "faults: protective_stop@2\n      wires: 0=0 "},
                            {"made a protective stop", "Enable robot"});
}

void expect_places_from_another_process(const char* example) {
  Command far({"far-side", "ur", "--port", "0", "--dashboard-port", "0", "--primary-port", "0",
               "--secondary-port", "0", "--wire", "0=0"});
  const std::string line = far.line_with("RTDE ");
  ASSERT_FALSE(number_behind(line, "RTDE").empty()) << line;
  const ExampleCopy copy(example);
  edit(copy, "cell.yaml",
       {{"hardware: ur_fake", "hardware: ur\n    accept_unverified: true"},
        {"      wires: 0=0 ", "      rtde_port: " + number_behind(line, "RTDE") +
                                  "\n      primary_port: " + number_behind(line, "primary") +
                                  "\n      dashboard_port: " + number_behind(line, "dashboard") +
                                  "\n      watchdog_ms: 5000\n      silence_ms: 10000\n      # "}});
  expect_armed_run_completes(copy, {"--full-speed"});
  far.signal(SIGTERM);
  const Finished ended = far.wait();
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  expect_words(ended.output, {"a program started"});
}

TEST(UrExample, ACellInAnotherProcessIsArmedAndPlaces) {
  expect_places_from_another_process("ur_far_side");
}

// --- forward mode ---

TEST(UrForwardExample, PlacesByTheControllersOwnMotionAndRepeatsItself) {
  const ExampleCopy copy("ur_forward");
  expect_same_run_twice(copy, "500 Hz, its own motion");
}

TEST(UrForwardExample, APersonHoldsAndResumesIt) {
  const ExampleCopy copy("ur_forward");
  const Finished ran = run_command({"test", copy.path()});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(UrForwardExample, UntilEndsALineInItsMiddleAndTheNextMoveBeginsThere) {
  expect_until_ends_a_line("ur_forward");
}

TEST(UrForwardExample, TheSameProgramStreamsWithoutTheKey) {
  expect_same_program_streams("ur_forward");
}

TEST(UrForwardExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  expect_fault_ends_the_run("ur_forward", {"wires: 0=0 ", "faults: protective_stop@2\n      wires: 0=0 "},
                            {"made a protective stop"});
}

TEST(UrForwardExample, ACellInAnotherProcessIsArmedAndPlaces) {
  expect_places_from_another_process("ur_forward");
}

/// The programs of the thesis, on a robot whose controller interpolates, with their parts in a simulated
/// world.
class UrForwardThesis : public testing::TestWithParam<ThesisCell> {};
INSTANTIATE_TEST_SUITE_P(Programs, UrForwardThesis,
                         testing::Values(ThesisCell{"pick_and_place", 3}, ThesisCell{"sorting", 4},
                                         ThesisCell{"bin_picking", 6}),
                         thesis_name);

void give_forward_robot(const ExampleCopy& copy) {
  edit(copy, "cell.yaml",
       {{"polyarm: cell/1\n", "polyarm: cell/1\nrate: 125\n"},
        {"hardware: mujoco", "hardware: ur_fake, parameters: {motion: forward, world: mock}"}});
}

TEST_P(UrForwardThesis, RunsUnchangedWithEveryPartInItsPlace) {
  const ExampleCopy copy(GetParam().example);
  give_forward_robot(copy);
  expect_all_placed(run_fast(copy), GetParam().parts);
}

TEST(UrForwardBlends, TheProgramWithBlendsPlacesEveryPartToo) {
  const ExampleCopy copy("pick_and_place");
  give_forward_robot(copy);
  expect_all_placed(run_fast(copy, {"--program", "flowing"}), 3);
}

TEST(UrForwardCheck, NamesTheMovesThatTheControllerCannotMake) {
  expect_check_names_moves("ur_forward");
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
