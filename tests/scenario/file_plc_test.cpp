/// Examples with their PLC in a process of its own, at the other end of data files: the thesis's way.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;
using test::Command;
using test::ExampleCopy;

/// An example whose PLC shares `cycledata` and two data sets of wires with it, one for each direction. Which
/// wires there are is what its Modbus variant says; a script on the robot's side ties those of the hardware
/// to its tags.
class FilePlc {
 public:
  FilePlc(const std::string& example, std::size_t parts) : copy_(example) {
    keep_parts(parts);
    const fs::path far = fs::path(POLYARM_SOURCE_DIR) / "examples" / example / "far_plc" / "signals.yaml";
    const std::string signals = read_file(copy_.file("modbus_signals.yaml"));
    const Yaml all = Yaml::parse(signals, "signals"), other = Yaml::parse(read_file(far), "far");
    const std::string data = read_file(copy_.file("cycledata.data"));
    const Yaml tags = all["tags"];
    std::string to_arm, from_arm, script = "load to_arm\nload from_arm\nwhile true\n",
                                  text = signals.substr(0, signals.find("links:"));
    for (const Yaml::Entry& wire : all["links"]["plc"]["tags"].entries()) {
      const std::string name = wire.key;
      if (data.find("Name: " + name + "\n") != std::string::npos) continue;
      const std::string initial = other["tags"][name]["initial"].text();
      const bool number = parse_number(initial).has_value();
      const bool sensor = wire.value["direction"].text() == "out";
      (sensor ? from_arm : to_arm) += "Name: " + name + (number ? "\nNum: " : "\nBool: ") + initial + "\n";
      const auto at = text.find("\n  " + name + ": ");
      if (tags[name].has("initial")) {  // a flag of the PLC and a camera: the wire is all there is of it
        text.erase(at, text.find('\n', at + 1) - at);
        continue;
      }
      text.insert(at + 3, "Io");
      const bool to_robot = wire.value["direction"].text() == "in";
      const std::string to = to_robot ? "Io" + name : name, from = to_robot ? name : "Io" + name;
      script += "  if " + to + " != " + from + "\n    set " + to + " = " + from + "\n  end\n";
    }
    write("to_arm.data", to_arm);
    write("from_arm.data", from_arm);
    write("wires.script", script + "  wait 10ms\nend\n");
    write("file_signals.yaml", text + "\nlive: [cycledata, to_arm, from_arm]\n");
    std::string cell = read_file(copy_.file("modbus.yaml"));
    cell.replace(cell.find("modbus_signals"), 14, "file_signals");
    write("file.yaml", cell + "plc: wires.script\n");
    write("far.script", "load to_arm\nload from_arm\nload cycledata\n" + read_file(copy_.file("plc.script")));
    write("far_signals.yaml", "polyarm: signals/1\nlive: [cycledata, to_arm, from_arm]\n");
    write("far.yaml", "polyarm: cell/1\nplc: far.script\nsignals: far_signals.yaml\nrate: 100\n");
  }
  std::string cell() const { return copy_.file("file.yaml").string(); }
  std::string plc() const { return copy_.file("far.yaml").string(); }

 private:
  /// The scene without its further parts: less of the same.
  void keep_parts(std::size_t count) {
    const std::string name = "scene.yaml", scene = read_file(copy_.file(name));
    const auto parts = scene.find("\nparts:\n");
    std::size_t end = scene.find('\n', parts + 1);
    for (; count > 0 && end != std::string::npos; --count) end = scene.find('\n', end + 1);
    if (end != std::string::npos) write(name.c_str(), scene.substr(0, end + 1));
  }
  void write(const char* name, const std::string& text) { write_file_atomically(copy_.file(name), text); }
  ExampleCopy copy_;
};

struct FileCase {
  const char* example;
  const char* robot;
  std::size_t parts;
};
class OverFiles : public testing::TestWithParam<FileCase> {};

TEST_P(OverFiles, TheExampleRunsToItsEndWithItsPlcInAnotherProcess) {
  const FilePlc far(GetParam().example, GetParam().parts);
  Command plc({"run", far.plc(), "--no-socket", "--json"});
  ASSERT_TRUE(plc.wait_for("load cycledata"));
  std::thread listener([&] { plc.wait_for("\nnever"); });  // a full pipe would stop the PLC
  const test::Finished run =
      test::run_command({"run", far.cell(), "--robot", GetParam().robot, "--fast", "--json"});
  plc.signal(SIGKILL);
  listener.join();
  ASSERT_EQ(run.exit_code, 0) << run.output.substr(run.output.size() > 3000 ? run.output.size() - 3000 : 0);
  const nlohmann::json result = run.result();
  EXPECT_EQ(result["result"], "completed");
  ASSERT_EQ(result["parts"].size(), GetParam().parts);
  for (const auto& part : result["parts"]) EXPECT_EQ(part["state"], "placed") << part;
  EXPECT_FALSE(result["repeatable"]) << "a far side is not ours to repeat";
}

constexpr FileCase kFileCases[] = {{"pick_and_place", "universal_robots/ur3", 3},
                                   {"sorting", "fanuc/lr_mate_200id", 4},
                                   {"pick_and_place", "franka/fer_panda", 3},
                                   {"sorting", "franka/fer_panda", 4},
                                   {"bin_picking", "universal_robots/ur3", 1},
                                   {"bin_picking", "fanuc/lr_mate_200id", 1},
                                   {"bin_picking", "abb/irb_120", 2},
                                   {"bin_picking", "franka/fer_panda", 2}};
INSTANTIATE_TEST_SUITE_P(All, OverFiles, testing::ValuesIn(kFileCases), [](const auto& named) {
  std::string name = std::string(named.param.example) + "_" + named.param.robot;
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
});

}  // namespace
}  // namespace polyarm
