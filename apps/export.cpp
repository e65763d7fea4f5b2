#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "apps/asked_cell.hpp"
#include "apps/export_moveit.hpp"
#include "apps/options.hpp"
#include "apps/verb.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/inside/view.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::apps {

namespace {

void write_moveit(const cell::CellView& cell, const std::filesystem::path& folder, int samples) {
  for (std::size_t i = 0; i < cell.robots().size(); ++i) {
    const std::filesystem::path own =
        cell.robots().size() == 1 ? folder : folder / cell.robots()[i]->entry.name;
    const MoveItFiles files = moveit_files(cell, i, samples);
    std::filesystem::create_directories(own);
    for (const auto& [name, text] : files.texts) {
      write_file_atomically(own / name, text);
      fmt::print("{}\n", (own / name).string());
    }
    for (const std::string& note : files.notes) fmt::print(stderr, "note: {}\n", note);
  }
}

}  // namespace

int run_export(int argc, char** argv) {
  CommandLine app("Writes configuration files for other programs", "polyarm export");
  app.require_subcommand();
  CommandLine& moveit =
      *app.add_subcommand("moveit", "SRDF, kinematics, limits, controllers and a launch file for MoveIt 2");
  CellOption asked;
  std::string folder;
  int samples = 10'000;
  moveit
      .add_option("cell", asked.cell,
                  "folder with a cell.yaml, a cell file, or a robot: a URDF, xacro or catalogue name")
      ->required();
  moveit.add_option("folder", folder, "output folder; with several robots, one subfolder for each")
      ->required();
  moveit.add_option("arguments", asked.arguments, "NAME:=VALUE of a description in xacro");
  moveit.add_option("--controllers", asked.controllers, "controllers YAML for a robot; may be repeated");
  moveit.add_option("--robot", asked.overrides.robot,
                    "another robot: MODEL, or NAME=MODEL in a cell of several");
  moveit
      .add_option("--samples", samples,
                  "number of joint states that are tried to find links that never touch")
      ->range(100, 1'000'000);
  app.footer(examples({"polyarm export moveit examples/pick_and_place moveit",
                       "polyarm export moveit my_cell moveit --samples 100000",
                       "polyarm export moveit robot.urdf.xacro moveit --controllers controllers.yaml"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  if (const auto code = asked.settle("export moveit")) return *code;
  cell::CellFile file = asked.open();
  for (cell::RobotEntry& robot : file.robots) robot.hardware = "mock";
  file.doors.clear();
  cell::CellOptions options;
  options.lock_step = true;
  cell::Observer silent;
  cell::Cell cell(file, open_catalogue(), options, silent);
  write_moveit(cell.view(), folder, samples);
  return kOk;
}

}  // namespace polyarm::apps
