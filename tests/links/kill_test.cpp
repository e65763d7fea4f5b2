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

}  // namespace
}  // namespace polyarm
