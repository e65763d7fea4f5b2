#include <fmt/format.h>

#include <limits>

#include "apps/options.hpp"
#include "apps/robots.hpp"
#include "polyarm/fitting/robot_fit.hpp"

namespace polyarm::apps {

namespace {

void print(const fitting::Comparison& fit, double reach) {
  fmt::print("meshes: {} triangles, look: {} triangles\n", fit.mesh_triangles, fit.look_triangles);
  fmt::print("look to meshes: half of it within {:.1f} mm, 95 % within {:.1f} mm\n",
             1000 * fitting::at_share(fit.there, 0.5), 1000 * fitting::at_share(fit.there, 0.95));
  fmt::print("meshes to look: half of them within {:.1f} mm, 95 % within {:.1f} mm\n",
             1000 * fitting::at_share(fit.back, 0.5), 1000 * fitting::at_share(fit.back, 0.95));
  fmt::print("95 %: {:.1f} % of the reach, {:.3g} m\n", 100 * fit.p95() / reach, reach);
}

}  // namespace

int run_robots_fit(int argc, char** argv) {
  CommandLine app(
      "Compares the look of a robot of the catalogue with the meshes of a description, or measures it",
      "polyarm robots fit");
  RobotOption robot, other;
  fitting::MeasureOptions options;
  bool line = false;
  app.add_option("robot", robot.name, "a robot of the catalogue")->required();
  app.add_option("description", other.name, "a URDF or xacro with visual meshes of the same robot")
      ->required();
  app.add_option("arguments", other.arguments, "NAME:=VALUE of a description in xacro");
  app.add_option("--out", options.file,
                 "measures the surfaces of the meshes and writes them: MODEL.look beside a robot file");
  app.add_option("--source", options.source, "where the meshes are from, for the file");
  app.add_flag("--plain", options.plain, "colours of the maker's style instead of those of the meshes");
  app.add_flag("--csv", line,
               "one line: name, triangles of the meshes and of the look, reach, p95, largest (m)");
  app.footer(examples({"polyarm robots fit universal_robots/ur5e ur5e.urdf",
                       "polyarm robots fit universal_robots/ur5e ur.urdf.xacro name:=ur ur_type:=ur5e",
                       "polyarm robots fit robots/a6.yaml a6.urdf --out robots/a6.look"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  Problems warnings;
  const description::Catalogue catalogue = open_catalogue();
  const description::RobotModel model = robot.load(warnings, catalogue);
  const description::RobotModel meshed = other.load(warnings, catalogue);

  const double most_off =
      options.file.empty() ? std::numeric_limits<double>::infinity() : fitting::kOtherRobot;
  const fitting::MeshedRobot meshes = fitting::meshes_of(model, meshed, most_off);
  const fitting::Comparison fit = options.file.empty() ? fitting::compare(model, meshes, warnings)
                                                       : fitting::measure(model, meshes, options, warnings);
  for (const Problem& problem : warnings.list()) fmt::print(stderr, "{}\n", problem.text());
  if (line)
    fmt::print("{},{},{},{:.4g},{:.5f},{:.5f}\n", robot.name, fit.mesh_triangles, fit.look_triangles,
               meshes.reach, fit.p95(), fit.largest());
  else
    print(fit, meshes.reach);
  return kOk;
}

}  // namespace polyarm::apps
