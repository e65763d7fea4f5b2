#include <gtest/gtest.h>

#include "links/modbus/port.hpp"
#include "polyarm/base/file.hpp"
#include "tests/links/running_link.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

TEST(KilledCell, ItsHeartbeatStandsStillAndItsOutputsStay) {
  const int port = test::free_port();
  const signals::LinkEntry entry = test::link_entry(
      "cell: {modbus: server, port: PORT, tags: {Alive: {coil: 0, direction: in}, Vacuum: {coil: 1, "
      "direction: in}}}",
      port);
  test::RunningLink plc(entry, modbus::make_server(entry));
  plc.look();
  ASSERT_TRUE(test::eventually([&] { return test::listens(port); }));

  const test::ExampleCopy copy("pick_and_place");
  write_file_atomically(
      copy.file("cell.yaml"),
      "polyarm: cell/1\nrobots: {arm: {model: universal_robots/ur3, hardware: mock}}\nsignals: "
      "signals.yaml\nprogram: main.script\n");
  write_file_atomically(copy.file("main.script"), "set Vacuum = true\nwait Never\n");
  write_file_atomically(
      copy.file("signals.yaml"),
      "polyarm: signals/1\ntags: {Vacuum: {initial: false}, Never: {initial: false}}\nheartbeat: {tag: "
      "Alive, every: 20ms}\nlinks: {plc: {modbus: client, port: " +
          std::to_string(port) +
          ", timeout: 5s, tags: {Alive: {coil: 0, direction: out}, Vacuum: {coil: 1, direction: out}}}}\n");
  test::Command cell({"run", copy.path(), "--no-socket", "-q"});
  ASSERT_TRUE(plc.comes("Vacuum", true));
  ASSERT_TRUE(plc.comes("Alive", true));
  ASSERT_TRUE(plc.comes("Alive", false)) << "it changes while the cell lives";
  cell.signal(SIGKILL);
  cell.wait();
  ASSERT_TRUE(plc.down());
  plc.look();
  const data::Value last = plc.values.at("Alive");
  for (int k = 0; k < 200; ++k) {
    plc.look();
    ::usleep(500);
  }
  EXPECT_EQ(plc.values.at("Alive"), last);
  EXPECT_EQ(plc.values.at("Vacuum"), data::Value(true)) << "a part that is held stays held";
}

TEST(KilledLinkProcess, TheRobotMovesOnAndTheLinkComesBackWithItsHeartbeatAndOutputs) {
  const int port = test::free_port();
  const signals::LinkEntry entry = test::link_entry(
      "cell: {modbus: server, port: PORT, tags: {Alive: {coil: 0, direction: in}, Vacuum: {coil: 1, "
      "direction: in}}}",
      port);
  auto plc = std::make_unique<test::RunningLink>(entry, modbus::make_server(entry));
  plc->look();
  ASSERT_TRUE(test::eventually([&] { return test::listens(port); }));

  const test::ExampleCopy copy("pick_and_place");
  write_file_atomically(copy.file("cell.yaml"),
                        "polyarm: cell/1\nrobots: {arm: {model: universal_robots/ur3, hardware: mock}}\nsignals: "
                        "signals.yaml\nprogram: main.script\n");
  write_file_atomically(copy.file("main.script"),
                        "set Vacuum = true\nwhile Vacuum\n  movej joints(10deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"
                        "  movej joints(0deg, -90deg, 20deg, 0deg, 0deg, 0deg)\nend\n");
  write_file_atomically(
      copy.file("signals.yaml"),
      "polyarm: signals/1\ntags: {Vacuum: {initial: false}}\nheartbeat: {tag: Alive, every: 20ms}\nlinks: {plc: "
      "{modbus: client, port: " +
          std::to_string(port) +
          ", on_loss: go_on, timeout: 5s, tags: {Alive: {coil: 0, direction: out}, Vacuum: {coil: 1, direction: out}}}}\n");
  test::Command cell({"run", copy.path(), "--no-socket", "--json"});
  const auto beats = [&] { return plc->comes("Alive", true) && plc->comes("Alive", false); };
  for (int round = 0, last = 0; round < 3; ++round) {
    ASSERT_TRUE(beats());
    int process = 0;
    ASSERT_TRUE(test::eventually(
        [&] { return (process = test::link_process_of(cell.process())) != 0 && process != last; }));
    last = process;
    // A PLC that forgets, so that what it has afterwards was told anew.
    plc = nullptr;
    ASSERT_EQ(::kill(process, SIGKILL), 0);
    plc = std::make_unique<test::RunningLink>(entry, modbus::make_server(entry));
    ASSERT_TRUE(plc->comes("Vacuum", true)) << "round " << round;
  }
  ASSERT_TRUE(beats());
  cell.signal(SIGINT);
  const test::Finished& finished = cell.wait();
  const auto result = finished.result();
  EXPECT_EQ(result["result"], "stopped") << finished.output.substr(0, 2000);
  EXPECT_EQ(result["error"], nullptr);
  EXPECT_LE(result["stops"].size(), 1u) << result["stops"];
  EXPECT_NE(finished.output.find("(polyarm_link_modbus) was ended by SIGKILL"), std::string::npos) << finished.output;
  EXPECT_NE(finished.output.find("is connected again"), std::string::npos);
}

}  // namespace
}  // namespace polyarm
