/// The example and `polyarm far-side ur`, as users start them.
#include "tests/support/command.hpp"

#include <gtest/gtest.h>

#include <regex>

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

/// A controller in a process of its own, and the cell that drives it, with a person at its terminal.
struct TwoTerminals {
  const ExampleCopy copy{"ur_far_side"};
  Command controller{{"far-side", "ur", "--port", "0", "--dashboard-port", "0", "--primary-port", "0",
                      "--secondary-port", "0", "--wire", "0=0"},
                     test::Input::terminal};
  std::unique_ptr<Command> cell;

  bool begin() {
    std::smatch ports;
    const std::string line = controller.line_with("RTDE");
    if (!std::regex_search(line, ports, std::regex("RTDE (\\d+), dashboard (\\d+), primary (\\d+)")))
      return false;
    std::string text = read_file(copy.file("cell.yaml"));
    const std::string fake = "hardware: ur_fake\n", host = "host: 127.0.0.1";
    text.replace(text.find(fake), fake.size(), "hardware: ur\n");
    // The machine of a test may be busy: its lateness is not what is tested.
    text.replace(text.find(host), host.size(),
                 host + "\n      rtde_port: " + ports[1].str() + "\n      dashboard_port: " + ports[2].str() +
                     "\n      primary_port: " + ports[3].str() +
                     "\n      watchdog_ms: 5000\n      silence_ms: 10000");
    write_file_atomically(copy.file("cell.yaml"), text);
    cell = std::make_unique<Command>(
        std::vector<std::string>{"run", copy.path(), "--real", "--full-speed", "--json", "--no-socket"},
        test::Input::terminal);
    if (!cell->wait_for("nothing moves before a person types")) return false;
    cell->type("arm\n");
    return controller.wait_for("a program started: polyarm");
  }
};

TEST(UrFarSide, AProcessOfItsOwnIsDrivenLikeARobot) {
  TwoTerminals both;
  ASSERT_TRUE(both.begin()) << both.cell->wait().output;
  const Finished ran = both.cell->wait();
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_TRUE(both.controller.wait_for("the program ended"));
  both.controller.signal(SIGINT);
  EXPECT_EQ(both.controller.wait().exit_code, 0);
}

TEST(UrFarSide, AFaultThatIsTypedThereIsNamedHere) {
  TwoTerminals both;
  ASSERT_TRUE(both.begin()) << both.cell->wait().output;
  ASSERT_TRUE(both.cell->wait_for("\"event\":\"line\""));
  both.controller.type("nonsense\nemergency_stop\n");
  EXPECT_TRUE(both.controller.wait_for("'nonsense' is no fault of this controller"));
  EXPECT_TRUE(both.controller.wait_for("ordered: emergency_stop"));
  const Finished ran = both.cell->wait();
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("is in an emergency stop"), std::string::npos) << ran.output;
}

TEST(UrFarSide, AKilledDriverLeavesTheRobotStanding) {
  TwoTerminals both;
  ASSERT_TRUE(both.begin()) << both.cell->wait().output;
  ASSERT_TRUE(both.cell->wait_for("\"event\":\"line\""));
  both.cell->signal(SIGKILL);
  both.cell->wait();
  EXPECT_TRUE(both.controller.wait_for("the program ended")) << "which it does when the robot stands";
}

TEST(UrFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command({"far-side", "fanuc"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "ur", "--software", "new"}).exit_code, 2);
  const Finished base = run_command({"far-side", "ur", "--robot", "agilex/ranger", "--port", "0"});
  EXPECT_NE(base.exit_code, 0) << base.output;
}

}  // namespace
}  // namespace polyarm
