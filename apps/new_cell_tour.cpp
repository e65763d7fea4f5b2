#include "apps/new_cell_tour.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

/// "joints(0.500rad, 0.020m)", as the language writes joint values.
std::string joints_text(const cell::CellRobot& robot, const std::vector<double>& q) {
  std::vector<std::string> values;
  for (std::size_t i = 0; i < q.size(); ++i)
    values.push_back(fmt::format("{:.3f}{}", q[i] + 0.0, robot.facts->chain.slides(i) ? "m" : "rad"));
  return "joints(" + join(values, ", ") + ")";
}

/// The value of joint `i` after a step of `share` from the start, well inside its limits.
double moved(const cell::CellRobot& robot, std::size_t i, double share) {
  const controllers::JointFacts& joint = robot.joints[i];
  const double q = robot.start[i];
  if (joint.continuous || !std::isfinite(joint.upper - joint.lower)) return q + 0.4 * share;
  const double range = joint.upper - joint.lower, margin = 0.02 * range;
  const double step = robot.facts->chain.slides(i) ? 0.4 * range : std::min(0.4, 0.4 * range);
  return std::clamp(q + step * share, std::min(q, joint.lower + margin), std::max(q, joint.upper - margin));
}

}  // namespace

std::map<std::string, std::string> tour_files(const NewCell& asked, const cell::CellRobot& robot,
                                              const std::string& hardware, const std::string& why,
                                              double size) {
  std::vector<double> left = robot.start, right = robot.start;
  for (std::size_t i = 0; i < left.size(); ++i) {
    const double share = i == 0 ? size : size / 4;  // mostly the first axis: the arm keeps its height
    left[i] = moved(robot, i, share);
    right[i] = moved(robot, i, -share);
  }
  std::map<std::string, std::string> out;
  out["cell.yaml"] = fmt::format(
      "polyarm: cell/1\n"
      "# A robot that moves between three places.\n"
      "robots:\n"
      "  arm: {{model: {}, hardware: {}}}\n"
      "program: main.script\n",
      asked.robot, hardware);
  out["main.script"] = fmt::format(
      "# Moves between three places, three times. Teach your own places on the pendant.\n"
      "use speed 30%\n"
      "for n in 1 .. 3\n"
      "  movej {}\n"
      "  movej {}\n"
      "  movej {}\n"
      "end\n"
      "log(\"three rounds are done\")\n",
      joints_text(robot, robot.start), joints_text(robot, left), joints_text(robot, right));
  out["tests.script"] =
      "# polyarm test .\n"
      "test \"the robot moves between its places\"\n"
      "  run\n"
      "  expect program.state == \"finished\" timeout 300s\n"
      "end\n";
  out["README.md"] = fmt::format(
      "# {}\n\n"
      "{} moves between three places. Everything is simulated.\n\n"
      "{}\n\n"
      "```\n"
      "polyarm check .              # all files, and every move along its path\n"
      "polyarm run . --fast         # as fast as the machine allows\n"
      "polyarm run . --pendant      # with the pendant in a browser\n"
      "polyarm test .\n"
      "```\n\n"
      "Next: put a tool and your surroundings into `cell.yaml` and a `scene.yaml`, teach places, and change "
      "the program.\n",
      asked.name, asked.robot, why);
  return out;
}

}  // namespace polyarm::apps
