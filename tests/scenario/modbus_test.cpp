#include <gtest/gtest.h>

#include "polyarm/base/file.hpp"
#include "tests/links/peers.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::Command;
using test::ExampleCopy;

/// An example and its PLC, both on a port that is free.
class FarPlc {
 public:
  explicit FarPlc(const std::string& example) : copy_(example), port_(test::free_port()) {
    for (const char* file : {"far_plc/signals.yaml", "modbus_signals.yaml"}) {
      std::string text = read_file(copy_.file(file));
      const auto at = text.find("1502");
      if (at == std::string::npos) throw std::runtime_error("no port in " + std::string(file));
      write_file_atomically(
          copy_.file(file),
          text.replace(at, 4,
                       std::to_string(port_) + "\n    timeout: 60s"));  // a busy machine is no lost link
    }
  }
  std::string cell() const { return copy_.file("modbus.yaml").string(); }
  std::string plc() const { return copy_.file("far_plc").string(); }
  int port() const { return port_; }

 private:
  ExampleCopy copy_;
  int port_;
};

struct Case {
  const char* example;
  const char* robot;
  std::size_t parts;
};
class OverModbus : public testing::TestWithParam<Case> {};

TEST_P(OverModbus, TheExampleRunsToItsEndWithItsPlcOnTheFarEnd) {
  const FarPlc far(GetParam().example);
  Command plc({"run", far.plc(), "--no-socket", "-q"});
  ASSERT_TRUE(test::eventually([&] { return test::listens(far.port()); }));
  const test::Finished run =
      test::run_command({"run", far.cell(), "--robot", GetParam().robot, "--fast", "--links", "--json"});
  const nlohmann::json result = run.result();
  ASSERT_EQ(run.exit_code, 0) << run.output.substr(run.output.size() > 3000 ? run.output.size() - 3000 : 0);
  EXPECT_EQ(result["result"], "completed");
  ASSERT_EQ(result["parts"].size(), GetParam().parts);
  for (const auto& part : result["parts"]) EXPECT_EQ(part["state"], "placed") << part;
  EXPECT_FALSE(result["repeatable"]) << "a far side is not ours to repeat";
}

constexpr Case kCases[] = {{"pick_and_place", "universal_robots/ur3", 3},
                           {"sorting", "fanuc/lr_mate_200id", 4},
                           {"bin_picking", "abb/irb_120", 6},
                           {"pick_and_place", "franka/fer_panda", 3},
                           {"sorting", "franka/fer_panda", 4},
                           {"bin_picking", "franka/fer_panda", 6}};
INSTANTIATE_TEST_SUITE_P(All, OverModbus, testing::ValuesIn(kCases), [](const auto& named) {
  std::string name = std::string(named.param.example) + "_" + named.param.robot;
  for (char& c : name)
    if (c == '/') c = '_';
  return name;
});

TEST(FarPlcGone, HoldsTheRobotWithTheReason) {
  const FarPlc far("pick_and_place");
  auto plc = std::make_unique<Command>(std::vector<std::string>{"run", far.plc(), "--no-socket", "-q"});
  ASSERT_TRUE(test::eventually([&] { return test::listens(far.port()); }));
  Command run({"run", far.cell(), "--json", "--hardware", "mock", "--no-socket"});
  ASSERT_TRUE(run.wait_for("\"moveto p0\""));
  plc = nullptr;  // killed
  EXPECT_TRUE(run.wait_for("the link 'plc' is lost"));
  EXPECT_TRUE(run.wait_for("held"));
  run.signal(SIGINT);
  EXPECT_EQ(run.wait().exit_code, 3);
}

TEST(BinPicking, RunsWithTheCameraOnTheArmToo) {
  const ExampleCopy copy("bin_picking");
  for (const char* robot : {"universal_robots/ur3", "fanuc/lr_mate_200id"}) {
    const test::Finished run = test::run_command(
        {"run", copy.file("eye_in_hand.yaml").string(), "--robot", robot, "--fast", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.output.substr(run.output.size() > 3000 ? run.output.size() - 3000 : 0);
    const nlohmann::json result = run.result();
    ASSERT_EQ(result["parts"].size(), 6u);
    for (const auto& part : result["parts"]) EXPECT_EQ(part["state"], "placed") << part;
  }
}

}  // namespace
}  // namespace polyarm
