#pragma once
/// A cell that does something worth recording, and its messages in readable form.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/messages/json.hpp"
#include "polyarm/recording/cell_recorder.hpp"
#include "tests/recording/mcap_reader.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::test {

/// The payload as JSON, by the schema that its channel has.
inline Json decoded(const McapMessage& message) {
  if (message.schema.starts_with("polyarm.")) return Json::parse(message.data);
  const messages::TypeInfo* type = messages::find_type(message.schema);
  if (!type) return "an unknown type: " + message.schema;
  Json out;
  const auto bytes = std::as_bytes(std::span(message.data.data(), message.data.size()));
  const messages::CdrError error = messages::to_json(*type, bytes, out);
  return error == messages::CdrError::none ? out : Json(messages::name(error));
}

/// A cell with tags and a program that moves and sets them.
class Demo {
 public:
  Demo() {
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + robot() +
                                  ", hardware: mock}\nsignals: signals.yaml\nprogram: demo.script\n");
    folder.write("signals.yaml",
                 "polyarm: signals/1\ntags:\n  Lamp: {initial: false}\n"
                 "  Count: {initial: 3, type: number}\n");
    folder.write("demo.script",
                 "moveto joints(0.4rad, 0, 0, 0, 0, 0)\nset Lamp True\nset Count 4\nlog \"there\"\n"
                 "wait 300ms\nset Lamp False\n");
  }
  static std::string robot() {
    return (std::filesystem::path(POLYARM_SOURCE_DIR) / "examples/r6bot/r6bot.urdf").string();
  }
  cell::CellFile file() const { return cell::read_cell_file(folder.path() / "cell.yaml"); }
  /// The bytes of a recording of `s` seconds in lock-step.
  std::string record(double s, double rate, const std::string& name = "demo.mcap") {
    test::LockStepCell bench(file());
    bench.cell().set_recorder(recording::make_recorder(bench.cell().view(), "9.9"));
    bench.cell().recorder()->start({folder.path() / name, rate});
    bench.run(s);
    bench.cell().recorder()->stop();
    status = bench.cell().recorder()->status();
    measured.clear();
    joints = bench.cell().robots()[0]->model.joint_names();
    for (const std::string& joint : joints)
      measured.push_back(bench.cell()
                             .snapshot()
                             .states[*bench.cell().loop().table().find_state("arm/" + joint + "/position")]);
    return read_file(folder.path() / name);
  }
  test::Folder folder;
  cell::RecordStatus status;
  std::vector<std::string> joints;
  std::vector<double> measured;  ///< of them, at the end
};

}  // namespace polyarm::test
