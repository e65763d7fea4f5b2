#include <fmt/format.h>

#include <algorithm>

#include "apps/options.hpp"
#include "apps/robots.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/catalogue/user_robots.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"

namespace polyarm::apps {

namespace {

/// "own/my_arm_2" for a model "My Arm 2" without a manufacturer.
std::string default_name(const description::RobotModel& model) {
  const auto word = [](const std::string& text) {
    std::string out;
    for (const char c : lower(text)) {
      const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0;
      if (plain)
        out += c;
      else if (!out.empty() && out.back() != '_')
        out += '_';
    }
    while (!out.empty() && out.back() == '_') out.pop_back();
    return out;
  };
  const std::string maker = word(model.provenance.maker), name = word(model.name);
  return (maker.empty() ? "own" : maker) + "/" + (name.empty() ? "robot" : name);
}

/// Collects all problems that prevent adding the robot; also builds its chain, as a cell would.
void check(const description::RobotModel& model, Problems& problems) {
  description::check_for_catalogue(model, problems);
  if (problems.has_errors()) return;
  try {
    const kinematics::Chain chain(model, model.tool_link());
    bool moves = false;
    for (std::size_t i = 0; i < chain.joints(); ++i) moves |= chain.moves_tcp(i);
    if (!moves) problems.error("no-arm", {}, "no joint moves the tool link", "name the tool link tool0");
  } catch (const Error& e) {
    problems.add(e);
  }
}

}  // namespace

int run_robots_add(int argc, char** argv) {
  CommandLine app("Adds a description of your own to the catalogue", "polyarm robots add");
  RobotOption robot;
  std::string name, folder;
  bool replace = false;
  robot.add_to(app, "URDF, xacro or robot file")->required()->existing_file();
  app.add_option("--name", name, "maker/model (own/<name of the robot> by default)");
  app.add_option("--folder", folder,
                 "the folder (by default ~/.config/polyarm/robots, which is always read)");
  app.add_flag("--replace", replace, "replace a robot of this name");
  app.footer(examples({"polyarm robots add my_arm.urdf --name acme/one",
                       "polyarm robots add ur.urdf.xacro name:=ur ur_type:=ur5e --name acme/cell_ur",
                       "polyarm robots add arm.urdf --folder my_cell/robots"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  Problems problems;
  description::RobotModel model = robot.load(problems, description::Catalogue({}));
  check(model, problems);
  for (const Problem& problem : problems.list())
    if (problem.severity == Severity::warning) fmt::print(stderr, "{}\n", problem.text());
  problems.throw_if_errors();
  description::complete_for_catalogue(model, robot.name);
  if (name.empty()) name = default_name(model);
  const std::filesystem::path where =
      folder.empty() ? description::user_robot_folder() : std::filesystem::path(folder);
  if (where.empty()) throw Error("no-folder", "there is no home folder to put robots into", "use --folder");
  const std::filesystem::path stored = store_robot(model, name, where, replace);
  const ik::InverseKinematics arm(kinematics::Chain(model, model.tool_link()));
  fmt::print("{}: {} axes, tool on {}, {}\n  {}\n", name, model.actuated.size(),
             model.links[static_cast<std::size_t>(model.tool_link())].name,
             arm ? "closed form: " + arm.report() : arm.report(), stored.string());
  if (!folder.empty()) fmt::print("  POLYARM_ROBOTS={} makes it known\n", where.string());
  return kOk;
}

int run_robots_remove(int argc, char** argv) {
  CommandLine app("Removes a robot that `polyarm robots add` has added", "polyarm robots remove");
  std::string name, folder;
  app.add_option("name", name, "maker/model")->required();
  app.add_option("--folder", folder, "where from (by default ~/.config/polyarm/robots)");
  app.footer(
      examples({"polyarm robots remove acme/one", "polyarm robots remove acme/one --folder my_cell/robots"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  const std::filesystem::path where =
      folder.empty() ? description::user_robot_folder() : std::filesystem::path(folder);
  if (where.empty()) throw Error("no-folder", "there is no home folder that robots are in", "use --folder");
  const std::filesystem::path removed = description::remove_robot(name, where);
  fmt::print("{}: {} removed\n", name, removed.string());
  const std::vector<std::string> left = open_catalogue().names();
  if (std::find(left.begin(), left.end(), name) != left.end())
    fmt::print("  the catalogue has another robot of that name, which is used now\n");
  return kOk;
}

}  // namespace polyarm::apps
