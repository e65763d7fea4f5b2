/// Builds a cell from a ROS 1 launch file.
#include <fmt/format.h>

#include "polyarm/base/text.hpp"
#include "polyarm/ros_files/launch_file.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/xacro/packages.hpp"

namespace polyarm::cell {

namespace {

namespace fs = std::filesystem;

void describe_robot(const ros_files::LaunchedCell& launched, const fs::path& launch, RobotEntry& robot,
                    Problems& problems) {
  if (launched.descriptions.empty())
    return problems.error("no-description", {launch.string()}, "the launch file loads no robot_description",
                          "a cell needs one: <param name=\"robot_description\" textfile=\"…\"/>");
  const ros_files::LaunchedDescription& description = launched.descriptions.front();
  robot.where = description.where;
  robot.model = description.file.empty() ? launch.string() : description.file.string();
  robot.text = description.text;
  for (const auto& [name, value] : description.arguments) robot.arguments[name] = value;
  if (launched.descriptions.size() > 1)
    problems.warning("several-descriptions", launched.descriptions[1].where,
                     "a cell has one description; '" + launched.descriptions[1].parameter + "' is left out");
}

}  // namespace

CellFile cell_from_launch(const fs::path& launch, const std::map<std::string, std::string>& arguments,
                          const Overrides& overrides, Problems& problems) {
  const ros_files::LaunchedCell launched =
      ros_files::read_launch_file(launch, arguments, description::packages_near(launch), problems);
  CellFile cell;
  cell.path = launch;
  cell.folder = launch.parent_path().empty() ? fs::path(".") : launch.parent_path();
  cell.name = launch.stem().string();
  RobotEntry robot;
  robot.hardware = overrides.hardware.empty() ? "declared" : overrides.hardware;
  robot.budget = cell.budget = overrides.budget;
  describe_robot(launched, launch, robot, problems);
  cell.robots.push_back(robot);
  cell.launched =
      std::make_shared<ros_files::ControllersFile>(ros_files::read_controllers(launched, problems));
  if (cell.launched->update_rate > 0) cell.rate = cell.launched->update_rate;
  for (const ros_files::NotApplicable& other : launched.not_applicable)
    cell.notes.push_back(fmt::format("{}: not applicable here: {}", other.where.text(), other.what));
  problems.throw_if_errors();
  return cell;
}

}  // namespace polyarm::cell
