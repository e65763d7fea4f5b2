#include "apps/workspace.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <optional>

#include "apps/options.hpp"
#include "apps/terminal.hpp"
#include "apps/workspace_map.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/tools.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::apps {

namespace {

/// The requested orientation: `any`, `down`, `home`, or roll pitch yaw.
std::optional<Quaternion> rotation_of(const std::string& wanted, const std::vector<double>& rpy,
                                      const kinematics::Chain& chain, const std::vector<double>& home) {
  if (rpy.size() == 3) return from_rpy(rpy[0], rpy[1], rpy[2]);
  if (wanted == "any") return std::nullopt;
  if (wanted == "home") return chain.forward(home).rotation;
  return from_rpy(M_PI, 0, 0);
}

/// Prints the progress on a terminal only, "  42 %", overwriting itself.
void tell_share(double share) {
  if (::isatty(STDERR_FILENO))
    fmt::print(stderr, "{}{:4.0f} %{}", own_return(), 100 * share, share < 1 ? "" : "\n");
}

std::string image_of(const std::filesystem::path& file, const WorkspaceMap& map,
                     const WorkspaceQuestion& question, const std::string& title) {
  if (file.extension() == ".png") return png_of(map);
  if (file.extension() == ".svg") return svg_of(map, question, title);
  throw Error("bad-value", "--image " + file.string() + ": neither .svg nor .png",
              "name a file that ends so");
}

/// The arm to examine: alone, or at its place in a cell.
struct Subject {
  std::string name;
  std::optional<kinematics::Chain> chain;
  std::vector<double> home;
  moves::Workspace allowed;
};

Subject alone(const RobotOption& robot, const std::string& tool) {
  Problems warnings;
  const description::RobotModel model = robot.load(warnings, open_catalogue());
  Subject out;
  out.name = model.name;
  out.chain.emplace(model, model.tool_link(), Pose{}, description::find_tool(tool, ".").tcp);
  out.home = model.start();
  return out;
}

/// The cell's robot called `name`; the only one if `name` is empty.
Subject in_cell(const std::string& folder, const std::string& name) {
  Problems problems;
  std::vector<std::string> notes, names;
  const cell::CellFile file = cell::read_cell_file(folder);
  const cell::CellRobots robots = cell::resolve_robots(file, open_catalogue(), false, problems, notes);
  problems.throw_if_errors();
  Problems faults;
  cell::add_hardware_faults(robots, Severity::warning, faults);
  for (const Problem& fault : faults.list()) fmt::print(stderr, "{}\n", fault.text());
  for (const auto& robot : robots) {
    names.push_back(robot->entry.name);
    if (robot->entry.name != name && (!name.empty() || robots.size() > 1)) continue;
    return {robot->entry.name, robot->facts->chain, robot->facts->home, robot->facts->workspace};
  }
  throw Error("unknown-name",
              name.empty() ? "this cell has several robots"
                           : "the cell has no robot '" + name + "'" + did_you_mean(name, names),
              "name one of them: " + join(names, ", "));
}

}  // namespace

int run_workspace(int argc, char** argv) {
  CommandLine app("Where an arm reaches in a plane, and how well it moves there", "polyarm workspace");
  RobotOption robot;
  std::string folder, tool = "none", orientation = "down", image, data;
  std::vector<double> rpy;
  WorkspaceQuestion question;
  robot.add_to(app, "catalogue name, or a URDF, xacro or robot file; with --cell one of its robots");
  app.add_option("--cell", folder, "a cell: its robot at its place, with its tool, limits and workspace")
      ->existing_path();
  app.add_option("--plane", question.plane, "xz (the default), xy or yz")->one_of({"xz", "xy", "yz"});
  app.add_option("--at", question.at, "where the plane lies along its third axis, m (0)");
  app.add_option("--resolution", question.resolution, "cells along an edge (80)")->range(2, 2000);
  app.add_option("--tool", tool, "tool: " + join(description::built_in_tools(), ", ") + ", or a file");
  app.add_option("--orientation", orientation, "of the TCP: down (the default), home or any")
      ->one_of({"any", "down", "home"});
  app.add_option("--rpy", rpy, "orientation as roll pitch yaw, rad or such as 180deg")->expected(3)->angle();
  app.add_option("--image", image, "picture, .svg or .png");
  app.add_option("--data", data, "table, .csv: position, reached, manipulability, joint values");
  app.footer(examples(
      {"polyarm workspace universal_robots/ur5e --image ur5e.svg",
       "polyarm workspace --cell my_cell --plane xy --at 0.1 --image cell.svg",
       "polyarm workspace abb/irb_120 --plane xy --at 0.2 --data irb.csv",
       "polyarm workspace kuka/lbr_iiwa_7_r800 --orientation any --resolution 60 --image iiwa.png"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  if (!image.empty()) image_of(image, {}, question, {});
  if (robot.name.empty() && folder.empty())
    throw Error("no-robot", "no robot is named",
                "name one such as universal_robots/ur5e, or use --cell FOLDER");
  for (const char* option : {"--tool", "--tip"})
    if (!folder.empty() && app.count(option) > 0)
      throw Error("bad-value", std::string(option) + " and --cell: the cell defines the tool of its robot",
                  "leave one of them out");
  const Subject subject = folder.empty() ? alone(robot, tool) : in_cell(folder, robot.name);
  const kinematics::Chain& chain = *subject.chain;
  const std::vector<double>& home = subject.home;
  question.allowed = subject.allowed;
  question.rotation = rotation_of(orientation, rpy, chain, home);
  const WorkspaceMap map = map_workspace(chain, home, question, tell_share);
  if (!image.empty())
    write_file_atomically(
        image, image_of(image, map, question,
                        fmt::format("{}: {} plane at {:g} m, tool {}", subject.name, question.plane,
                                    question.at, rpy.empty() ? orientation : "as given")));
  if (!data.empty()) write_file_atomically(data, csv_of(map, chain));
  fmt::print("{}: {} of {} cells of {:.3g} m reached ({:.3g} m²), best manipulability {:.3f}, by {}\n",
             subject.name, map.reached(), map.cells.size(), map.cell,
             static_cast<double>(map.reached()) * map.cell * map.cell, map.best_manipulability(),
             map.closed_form ? "closed form" : "iteration");
  return kOk;
}

}  // namespace polyarm::apps
