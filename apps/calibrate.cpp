/// The verb that calibrates tools, frames, cameras, arms and payloads from samples.
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/calibrate_kinds.hpp"
#include "apps/calibrate_read.hpp"
#include "apps/calibrate_record.hpp"
#include "apps/client.hpp"
#include "apps/options.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/set_edit.hpp"
#include "polyarm/description/tools.hpp"
#include "polyarm/io/cell_edit.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;
constexpr std::size_t kLargestSamples = 16 << 20;  // bytes

struct Arguments {
  CalibrateOptions how;
  RobotOption robot;
  RecordOptions record;
  ReadOptions read;
  std::string samples, into, name, flat, keep, cell;
  bool verify = false, undo = false, yes = false, json = false;
};

std::vector<calibration::Sample> samples_of(const std::string& file) {
  return calibration::read_samples(read_file(file, kLargestSamples), file);
}

void print_residuals(const Calibrated& found) {
  std::vector<std::vector<std::string>> rows;
  const auto row = [&](const std::string& name, const calibration::Residual& r, const std::string& remark) {
    rows.push_back({name, fmt::format("{:.3f}", found.scale * r.position)});
    if (found.rotations) rows.back().push_back(fmt::format("{:.4f}", r.rotation * 180 / M_PI));
    rows.back().push_back(remark);
  };
  const auto& outlier = found.residuals.outlier;
  for (std::size_t k = 0; k < found.residuals.each.size(); ++k)
    row(std::to_string(k + 1), found.residuals.each[k],
        outlier && outlier->sample == k ? "contradicts the others" : "");
  row("rms", found.residuals.rms, "");
  row("largest", found.residuals.largest, "");
  std::vector<std::string> head{"SAMPLE", found.unit};
  if (found.rotations) head.emplace_back("DEGREES");
  head.emplace_back("");
  print_table(head, rows);
}

void print_json(const Calibrated& found) {
  Json out{{"result", found.lines}, {"residuals", Json::array()}};
  for (const calibration::Residual& each : found.residuals.each)
    out["residuals"].push_back({{"position", each.position}, {"rotation", each.rotation}});
  out["rms"] = {{"position", found.residuals.rms.position}, {"rotation", found.residuals.rms.rotation}};
  if (found.residuals.outlier) out["outlier"] = found.residuals.outlier->sample;
  if (found.point) {
    const Pose& pose = found.point->pose;
    out["pose"] = {{"p", {pose.position.x, pose.position.y, pose.position.z}},
                   {"q", {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w}},
                   {"frame", found.point->frame()}};
  }
  fmt::print("{}\n", out.dump(2));
}

void print(const Calibrated& found, bool json) {
  if (json) return print_json(found);
  print_residuals(found);
  for (const std::string& line : found.lines) fmt::print("{}\n", line);
  if (const auto& outlier = found.residuals.outlier)
    fmt::print(
        "sample {} contradicts the others: without it the residuals fall to {:.0f} %; the chance that a good "
        "sample "
        "is this far off is {:.1g}\n",
        outlier->sample + 1, 100 / outlier->improvement, outlier->chance);
  if (!found.next.empty()) fmt::print("{}\n", found.next);
}

/// What the hand carries besides the tool that the cell has for the robot.
calibration::Payload besides_tool(const calibration::Payload& all, const std::string& cell,
                                  const std::string& robot) {
  const cell::CellFile file = cell::read_cell_file(cell);
  for (const cell::RobotEntry& entry : file.robots) {
    if (entry.name != robot) continue;
    const description::Tool tool = description::find_tool(entry.tool, file.folder.string());
    if (tool.mass > 0)
      fmt::print(stderr, "the {:.3f} kg of the tool {} are not included\n", tool.mass, entry.tool);
    return calibration::without_part(all, {tool.mass, tool.center}, "the tool '" + entry.tool + "'");
  }
  return all;  // set_robot_key() says that there is no such robot
}

/// Stores the result in a data file, or in the file of an arm. The former content can be taken back.
void store(const Calibrated& found, const Arguments& a) {
  if (found.residuals.outlier && !a.yes)
    throw Error("bad-points",
                fmt::format("sample {} contradicts the others; nothing was changed",
                            found.residuals.outlier->sample + 1),
                "remove it or measure it again; --yes stores the result in spite of it");
  const std::string what = "calibrate " + a.how.kind;
  const std::string robot = a.record.robot.empty() ? "arm" : a.record.robot;
  if (found.arm && !a.into.empty()) {
    data::edit_text(a.into, what,
                    [&](const std::string&) { return description::arm_calibration_text(*found.arm); });
    fmt::print(stderr, "{} is written; a robot uses it with the key `calibration`\n", a.into);
    if (a.cell.empty()) return;
    const fs::path folder = fs::absolute(cell::cell_file_of(a.cell)).parent_path();
    cell::set_robot_key(a.cell, robot, "calibration",
                        fs::absolute(a.into).lexically_relative(folder).string());
    fmt::print(stderr, "{} uses it now; --undo --cell takes the key back\n", robot);
    return;
  }
  if (found.payload && !a.cell.empty()) {
    cell::set_robot_key(a.cell, robot, "payload", payload_text(besides_tool(*found.payload, a.cell, robot)));
    fmt::print(stderr, "it is the payload of {} now; --undo --cell takes it back\n", robot);
    return;
  }
  if (!found.point || a.into.empty())
    throw WrongUse("bad-usage", "a " + a.how.kind + " is not stored there",
                   "--into FILE for what a file of points or of an arm keeps, --cell FOLDER for a payload");
  if (a.name.empty()) throw WrongUse("bad-usage", "the result needs a name", "--name NAME");
  data::edit_set(a.into, what + " " + a.name, [&](data::ImportFile& set) { set.set(a.name, *found.point); });
  fmt::print(stderr, "{} is stored in {}; --undo takes it back\n", a.name, a.into);
}

int undo(const Arguments& a) {
  if (a.into.empty() == a.cell.empty())
    throw WrongUse("bad-usage", "--undo needs the file that was changed", "--into FILE or --cell FOLDER");
  if (!a.cell.empty()) {
    const std::string taken_back = cell::undo_robot_key(a.cell);
    fmt::print("taken back in {}: {}\n", cell::cell_file_of(a.cell).string(), taken_back);
    return kOk;
  }
  const std::string& file = a.into;
  data::require_history(file, 1);
  const std::string what = data::history(file).back().what;
  data::undo(file, 1);
  fmt::print("taken back in {}: {}\n", file, what);
  return kOk;
}

int verify(const std::vector<calibration::Sample>& samples, const Arguments& a) {
  if (a.into.empty())
    throw WrongUse("bad-usage", "--verify needs the file with the result", "--into FILE --name NAME");
  Calibrated found;
  if (a.how.kind == "joints") {
    found = check_arm(samples, description::read_arm_calibration(a.into), a.how);
  } else {
    const data::ImportFile set = data::ImportFile::load(a.into);
    const data::Value* value = set.values().value(a.name);
    if (!value || !value->as_point())
      throw Error(Problem{"unknown-name",
                          {a.into},
                          "there is no pose '" + a.name + "'" + did_you_mean(a.name, set.values().names()),
                          "--name NAME"});
    found = check_calibration(samples, value->as_point()->pose, a.how);
  }
  found.lines.push_back("checked against " + a.into + "; nothing was changed");
  print(found, a.json);
  return kOk;
}

/// The geometry that the robot itself states.
int read(const Arguments& a) {
  if (!a.how.robot)
    throw WrongUse("bad-usage", "the geometry of an arm needs its description", "--robot MODEL");
  if (a.read.host.empty())
    throw WrongUse("bad-usage", "the address of the controller is missing", "--host ADDRESS");
  Calibrated found;
  found.arm = read_arm(*a.how.robot, a.read);
  if (!a.into.empty() || !a.cell.empty()) store(found, a);
  return kOk;
}

std::vector<calibration::Sample> samples_for(Arguments& a) {
  if (a.record.cell.empty() && a.record.marker.empty() && a.samples.empty())
    throw WrongUse("bad-usage", "a calibration needs samples", "a file, or --from CELL");
  if (!a.samples.empty()) return samples_of(a.samples);
  const auto out = record_samples(a.record);
  if (out.empty()) return out;
  const std::string file = a.keep.empty() ? a.how.kind + "_samples.yaml" : a.keep;
  data::edit_text(file, "samples", [&](const std::string&) { return calibration::samples_text(out); });
  fmt::print(stderr, "the samples are in {}\n", file);
  return out;
}

void add_options(CommandLine& app, Arguments& a) {
  app.add_option("kind", a.how.kind, "tool, frame, robots, hand-eye, eye-to-hand, joints, payload or read")
      ->required()
      ->one_of({"tool", "frame", "robots", "hand-eye", "eye-to-hand", "joints", "payload", "read"});
  app.add_option("samples", a.samples, "a file of samples, YAML or CSV");
  app.add_option("--from", a.record.cell, "take the samples from this running cell, one at each Enter");
  app.add_option("--marker", a.record.marker,
                 "with --from: the pose of the cell's data that a camera or a device writes");
  app.add_option("--arm", a.record.robot,
                 "which robot the samples are of, or gets the result; default: arm, or the only one");
  app.add_option("--keep", a.keep, "with --from: the file that gets the samples; default: KIND_samples.yaml");
  app.add_option("--into", a.into,
                 "the file that gets the result: a data file; for joints the file of the arm");
  app.add_option("--cell", a.cell, "the cell whose robot gets the payload or the calibration");
  app.add_option("--name", a.name, "the name of the result in the data file");
  app.add_option("--in", a.how.in, "the frame that the result is in, where it is not the usual one");
  app.add_option("--robot", a.robot.name, "joints, payload: catalogue name, or a URDF, xacro or robot file");
  app.add_option("--tip", a.robot.tip, "joints, payload: the link that is tool0");
  app.add_option("--host", a.read.host, "read: address of the controller of a robot of Universal Robots");
  app.add_option("--port", a.read.port, "read: its primary interface")
      ->range(1, 65535)
      ->capture_default_str();
  app.add_option("--flat", a.flat, "tool: samples with its face on a plane, for its orientation");
  app.add_flag("--axes", a.how.axes, "joints: also the places of the axes");
  app.add_flag("--positions", a.how.positions, "joints: only positions were measured");
  app.add_flag("--in-base", a.how.base_known, "joints: they were measured in the robot's base");
  app.add_flag("--of-tool0", a.how.target_known, "joints: tool0 itself was measured");
  app.add_flag("--inertia", a.how.inertia, "payload: also the inertia");
  app.add_flag("--friction", a.how.friction, "payload: the joints' friction is unknown, too");
  app.add_flag("--verify", a.verify, "compare the samples with the result in --into; change nothing");
  app.add_flag("--undo", a.undo, "take back the last change of --into, or of --cell");
  app.add_flag("--yes,-y", a.yes, "store the result although a sample contradicts it");
  app.add_flag("--json", a.json, "as JSON");
  app.footer(
      examples({"polyarm calibrate tool touches.yaml --into points.points --name gripper",
                "polyarm calibrate hand-eye pictures.csv --into points.points --name camera",
                "polyarm calibrate hand-eye more.csv --into points.points --name camera --verify",
                "polyarm calibrate tool --into points.points --undo",
                "polyarm calibrate joints poses.csv --robot universal_robots/ur5e --into arm.yaml",
                "polyarm calibrate tool --from my_cell --keep touches.yaml",
                "polyarm calibrate read --host 192.168.1.10 --robot universal_robots/ur5e --into arm.yaml"}));
}

}  // namespace

int run_calibrate(int argc, char** argv) {
  CommandLine app("Calibrates tools, frames, cameras, arms and payloads from samples", "polyarm calibrate");
  Arguments a;
  add_options(app, a);
  if (const auto code = app.parse(argc, argv)) return *code;
  if (a.undo) return undo(a);
  a.record.kind = a.how.kind;
  std::optional<description::RobotModel> robot;
  if (!a.robot.name.empty()) {
    Problems warnings;
    robot = a.robot.load(warnings, open_catalogue());
    a.how.robot = &*robot;
    a.how.robot_name = robot->name;
  }
  if (a.how.kind == "read") return read(a);
  if (!a.flat.empty()) a.how.flat = samples_of(a.flat);
  const std::vector<calibration::Sample> samples = samples_for(a);
  if (a.how.kind == "hand-eye" && a.how.in.empty() && !a.record.robot.empty())
    a.how.in = a.record.robot + "/flange";
  if (!samples.empty() && samples.front().vectors.contains("point") && a.how.kind == "joints")
    a.how.positions = true;
  if (a.verify) return verify(samples, a);
  const Calibrated found = calibrate(samples, a.how);
  print(found, a.json);
  if (!a.into.empty() || !a.cell.empty()) store(found, a);
  return kOk;
}

}  // namespace polyarm::apps
