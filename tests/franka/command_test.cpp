/// The example, `polyarm far-side franka` and `polyarm setup franka`, as users start them.
#include "tests/support/driver_examples.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using namespace test;

std::vector<std::string> far_side(std::vector<std::string> more = {}) {
  std::vector<std::string> out{"far-side", "franka", "--port", "0", "--hand-port", "0"};
  out.insert(out.end(), more.begin(), more.end());
  return out;
}

/// `polyarm setup franka` for a far side, from the line with its ports.
Finished set_up(Command& far, std::vector<std::string> more = {}) {
  const std::string line = far.line_with("robot at port");
  std::vector<std::string> out{"setup",       "franka",
                               "--host",      "127.0.0.1",
                               "--port",      number_behind(line, "robot at port"),
                               "--hand-port", number_behind(line, "hand at port")};
  out.insert(out.end(), more.begin(), more.end());
  return run_command(out);
}

TEST(FrankaExample, PlacesWithTheHandAndRepeatsItself) {
  const ExampleCopy copy("franka");
  edit(copy, "placing.script", {{"part < 2", "part < 1"}});  // for a short test
  expect_same_run_twice(copy, "joint positions at 1000 Hz, with its hand");
}

TEST(FrankaExample, AFaultOfTheRobotEndsTheRunWithItsCause) {
  expect_fault_ends_the_run("franka", {"faults: part=30@0", "faults: part=30@0 collision@2"},
                            {"stopped for a collision (joint_reflex)", "clear the space"});
}

TEST(FrankaSetup, FindsTheRobotAndShowsItsState) {
  Command far(far_side({"--start", "0 -45 0 -135 0 90 45"}));
  const Finished done = set_up(far, {"--hand"});
  // Whether states come in time is a matter of this machine, and of the exit code.
  EXPECT_NE(done.output.find("version 9 of the Franka Control Interface (Research 3, system 5.7.2)"),
            std::string::npos)
      << done.output;
  EXPECT_NE(done.output.find("mode: idle"), std::string::npos) << done.output;
  EXPECT_NE(done.output.find("joints 0.000 -45.000 0.000 -135.000 0.000 90.000 45.000 degrees"),
            std::string::npos)
      << done.output;
  EXPECT_NE(done.output.find(" of 1000 lost, "), std::string::npos) << done.output;
  EXPECT_NE(done.output.find("hand: 40.0 mm open"), std::string::npos) << done.output;
  EXPECT_NE(done.output.find("In Desk (https://127.0.0.1)"), std::string::npos) << done.output;
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(FrankaSetup, FindsTheVersionOfAPanda) {
  Command far(far_side({"--robot", "franka/fer_panda"}));
  const Finished done = set_up(far);
  EXPECT_NE(done.output.find("version 5 of the Franka Control Interface (Panda, system 4.2)"),
            std::string::npos)
      << done.output;
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(FrankaSetup, SaysWhatIsNotReady) {
  Command far(far_side({"--order", "user_stop", "--order", "hand_silent"}));
  const Finished wrong = set_up(far, {"--hand"});
  EXPECT_EQ(wrong.exit_code, 1) << wrong.output;
  EXPECT_NE(wrong.output.find("pressed the user stop"), std::string::npos) << wrong.output;
  EXPECT_NE(wrong.output.find("check its cable"), std::string::npos) << wrong.output;
  EXPECT_NE(wrong.output.find("Not everything is ready"), std::string::npos) << wrong.output;
  far.signal(SIGTERM);
  far.wait();
}

TEST(FrankaSetup, ARobotThatIsNotThereOrSwitchedOffIsNamed) {
  Command far(far_side({"--order", "busy"}));
  const Finished busy = set_up(far);
  EXPECT_EQ(busy.exit_code, 1) << busy.output;
  EXPECT_NE(busy.output.find("activate FCI"), std::string::npos) << busy.output;
  far.signal(SIGTERM);
  far.wait();
  const Finished nobody = run_command({"setup", "franka", "--host", "127.0.0.1", "--port", "1"});
  EXPECT_EQ(nobody.exit_code, 1) << nobody.output;
  EXPECT_NE(nobody.output.find("refuses the connection"), std::string::npos) << nobody.output;
  EXPECT_EQ(run_command({"setup", "franka"}).exit_code, 2) << "the address is the user's";
}

TEST(FrankaFarSide, TakesFaultsAndShowsItsState) {
  Command far(far_side({"--order", "collision", "--interface", "10"}), Input::terminal);
  EXPECT_NE(far.line_with("robot at port").find("interface version 10"), std::string::npos);
  ASSERT_TRUE(far.wait_for("type `state`"));
  far.type("state\n");
  EXPECT_NE(far.line_with("commands").find("mode reflex, errors: joint_reflex"), std::string::npos);
  far.type("recover\nstate\n");
  ASSERT_TRUE(far.wait_for("ordered: recover"));
  EXPECT_NE(far.line_with("commands").find("mode idle, errors: none"), std::string::npos);
  far.type("storm\n");
  EXPECT_NE(far.line_with("storm").find("storm"), std::string::npos) << "a wrong kind does not end it";
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(FrankaFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command(far_side({"--interface", "4"})).exit_code, 2);
  EXPECT_EQ(run_command(far_side({"--start", "1 2 3"})).exit_code, 2);
  EXPECT_NE(run_command(far_side({"--robot", "agilex/ranger"})).exit_code, 0);
  EXPECT_NE(run_command(far_side({"--order", "storm"})).exit_code, 0);
  const Finished help = run_command({"far-side", "franka", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.output.find("user_stop"), std::string::npos) << "lists the faults: " << help.output;
}

}  // namespace
}  // namespace polyarm
