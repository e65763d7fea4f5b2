#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/options.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/tools.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/singularity.hpp"

namespace polyarm::apps {

namespace {

using json = nlohmann::ordered_json;  // keeps joints in the order that --joints and --seed use

/// Options of both verbs.
struct Common {
  RobotOption robot;
  std::string tool = "none";
  std::vector<double> tcp;
  bool as_json = false;

  void add_to(CommandLine& app) {
    robot.add_to(app)->required();
    app.add_option("--tool", tool, "tool: " + join(description::built_in_tools(), ", ") + ", or a file");
    app.add_option("--tcp", tcp, "TCP in tool0 instead: x y z, or x y z roll pitch yaw (m, rad)")
        ->expected(3, 6);
    app.add_flag("--json", as_json, "one JSON object");
  }
  Pose tcp_pose() const {
    if (tcp.size() == 3) return {{tcp[0], tcp[1], tcp[2]}, {}};
    for (std::size_t i = 3; i < tcp.size(); ++i)
      if (std::abs(tcp[i]) > 6.3)
        throw WrongUse("bad-value", fmt::format("--tcp has {:g} radians, more than a turn", tcp[i]),
                       fmt::format("write radians: {:.5g} for {:g} degrees", tcp[i] * M_PI / 180, tcp[i]));
    if (tcp.size() == 6) return pose_xyz_rpy({tcp[0], tcp[1], tcp[2]}, {tcp[3], tcp[4], tcp[5]});
    if (!tcp.empty()) throw WrongUse("bad-value", "--tcp takes 3 or 6 numbers", {});
    return description::find_tool(tool, ".").tcp;
  }
};

struct Loaded {
  description::RobotModel model;
  std::unique_ptr<kinematics::Chain> chain;
  std::vector<double> home;
};

Loaded load(const Common& common) {
  Problems warnings;
  Loaded out;
  out.model = common.robot.load(warnings, open_catalogue());
  out.chain =
      std::make_unique<kinematics::Chain>(out.model, out.model.tool_link(), Pose{}, common.tcp_pose());
  out.home = out.model.start();
  return out;
}

void check_size(const std::vector<double>& values, const kinematics::Chain& chain, const char* option) {
  if (values.size() != chain.joints())
    throw WrongUse("bad-value",
                   fmt::format("{} takes {} numbers for this robot ({}), here are {}", option, chain.joints(),
                               join(chain.names(), " "), values.size()),
                   {});
}

json json_of(const Pose& pose) {
  const Vec3 rpy = to_rpy(pose.rotation);
  return {{"xyz", {pose.position.x, pose.position.y, pose.position.z}},
          {"rpy", {rpy.x, rpy.y, rpy.z}},
          {"quaternion", {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w}}};
}

json joints_json(const kinematics::Chain& chain, const std::vector<double>& q) {
  json out = json::object();
  for (std::size_t j = 0; j < q.size(); ++j) out[chain.names()[j]] = q[j];
  return out;
}

/// How `--all` finds solutions: the arm's closed form and its kind, or why it has none.
std::string way_of(const ik::InverseKinematics& arm) {
  if (!arm) return arm.report();
  return "closed form: " + arm.report();
}

double norm_of_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t j = 0; j < a.size(); ++j) sum += (a[j] - b[j]) * (a[j] - b[j]);
  return std::sqrt(sum);
}

/// A remark about a solution: distance from the seed, and singularity.
std::string remark_on(const kinematics::Chain& chain, const std::vector<double>& q,
                      const std::vector<double>& seed) {
  const bool singular = kinematics::smallest_singular_value(chain, q) < kinematics::kSingular;
  return fmt::format("{:.3f} from the seed{}", norm_of_difference(q, seed),
                     singular ? ", near a singularity" : "");
}

/// Arguments of `polyarm ik`.
struct PoseQuestion {
  std::vector<double> xyz, rpy, quaternion, seed, position_tolerance, orientation_tolerance;
  std::string spin;
  bool all = false, position_only = false;

  void add_to(CommandLine& app) {
    app.add_option("--xyz", xyz, "position, m; must be given")->expected(3);
    Option* by_rpy =
        app.add_option("--rpy", rpy, "roll pitch yaw, rad or such as 180deg (180deg 0 0: tool down)")
            ->expected(3)
            ->angle();
    app.add_option("--quaternion", quaternion, "x y z w")->expected(4)->excludes(by_rpy);
    app.add_option("--seed", seed, "joint values to start from (home by default)")->expected(-1);
    app.add_flag("--all", all, "every solution, nearest to the seed first, and how they were found");
    app.add_flag("--position-only", position_only, "the TCP's place, however the tool is turned");
    app.add_option("--free-spin", spin, "the tool may turn about its own axis x, y or z")
        ->one_of({"x", "y", "z"});
    app.add_option("--position-tolerance", position_tolerance,
                   "how far off the TCP may be along the tool's x y z, m (one number: each)")
        ->expected(1, 3);
    app.add_option("--orientation-tolerance", orientation_tolerance,
                   "how far the tool may be turned about its x y z, rad (one number: each)")
        ->expected(1, 3);
  }
  bool of_parts() const {
    return position_only || !spin.empty() || !position_tolerance.empty() || !orientation_tolerance.empty();
  }
  Pose target() const;
  ik::IkTask task() const;
};

Pose PoseQuestion::target() const {
  if (xyz.size() != 3)
    throw WrongUse("bad-value", "no position is given",
                   "write --xyz X Y Z, in metres in the frame of the base");
  Pose out{{xyz[0], xyz[1], xyz[2]}, {}};
  if (rpy.size() == 3) out.rotation = from_rpy(rpy[0], rpy[1], rpy[2]);
  if (quaternion.size() != 4) return out;
  const Quaternion q{quaternion[0], quaternion[1], quaternion[2], quaternion[3]};
  if (std::abs(q.x) + std::abs(q.y) + std::abs(q.z) + std::abs(q.w) < 1e-9)
    throw Error("bad-value", "--quaternion 0 0 0 0 is not a rotation", "write a unit quaternion x y z w");
  out.rotation = normalized(q);
  return out;
}

/// Sets the tolerance ±`values` on three rows of the task.
void widen(ik::IkTask& task, std::size_t row, const std::vector<double>& values, const char* option) {
  if (values.size() == 2)
    throw Error("bad-value", fmt::format("{} takes 1 or 3 numbers, here are 2", option),
                "one number for all of x y z, or one for each");
  for (std::size_t k = 0; !values.empty() && k < 3; ++k) {
    const double value = values[values.size() == 3 ? k : 0];
    if (!(value >= 0) || !std::isfinite(value))
      throw Error("bad-value", fmt::format("{} {:g} is not a tolerance", option, value),
                  "write 0 or more, or --position-only or --free-spin for what may be anything");
    task.low[row + k] = -value;
    task.high[row + k] = value;
  }
}

ik::IkTask PoseQuestion::task() const {
  ik::IkTask out;
  widen(out, 0, position_tolerance, "--position-tolerance");
  widen(out, 3, orientation_tolerance, "--orientation-tolerance");
  if (!spin.empty()) out.free(3 + static_cast<std::size_t>(spin[0] - 'x'));
  for (std::size_t row = 3; position_only && row < 6; ++row) out.free(row);
  return out;
}

std::vector<double> values_of(const ik::InverseKinematics& arm, const ik::IkSolution& one) {
  return {one.q.begin(), one.q.begin() + static_cast<std::ptrdiff_t>(arm.chain().joints())};
}

/// Solutions for `--all`; a partially constrained pose uses many descents. For an arm with infinitely many
/// solutions the nearest of all comes first.
std::vector<std::vector<double>> all_solutions(const ik::InverseKinematics& arm, const PoseQuestion& question,
                                               const Pose& target) {
  const auto found = std::make_unique<ik::IkSolutions>();
  std::vector<std::vector<double>> out;
  ik::IkSolution nearest;
  if (question.of_parts()) {
    arm.solve_all(target, question.task(), question.seed, *found);
  } else {
    if (!arm.complete() && arm.solve(target, question.seed, nearest) == ik::IkOutcome::solved)
      out.push_back(values_of(arm, nearest));
    arm.solve_all(target, question.seed, *found);
  }
  for (const ik::IkSolution& one : *found) {
    const bool known = !out.empty() && norm_of_difference(out[0], values_of(arm, one)) < 1e-3;
    if (!known) out.push_back(values_of(arm, one));
  }
  return out;
}

struct Result {
  ik::IkOutcome outcome = ik::IkOutcome::malformed;
  std::vector<double> q;  ///< the nearest joint state if it is not solved
  double position_error = 0, orientation_error = 0;
  std::string reason;
  explicit operator bool() const { return outcome == ik::IkOutcome::solved; }
};

Result answer(const ik::InverseKinematics& arm, const PoseQuestion& question, const Pose& target,
              const std::vector<double>& home) {
  const ik::IkTask task = question.of_parts() ? question.task() : ik::IkTask{};
  ik::IkExplanation found;
  found.outcome = question.of_parts() ? arm.solve(target, task, question.seed, found.nearest)
                                      : arm.solve_move(target, question.seed, home, found.nearest);
  if (found.outcome != ik::IkOutcome::solved) found = arm.explain(target, question.seed, task);
  return {found.outcome, values_of(arm, found.nearest), found.nearest.position_error,
          found.nearest.orientation_error, found.reason};
}

}  // namespace

int run_fk(int argc, char** argv) {
  CommandLine app("Forward kinematics: the pose of the TCP for given joint values, in the base frame",
                  "polyarm fk");
  Common common;
  std::vector<double> joints;
  common.robot.of_numbers = "--joints";
  common.add_to(app);
  app.add_option("--joints", joints, "one value for each joint, rad or m (home by default)")->expected(-1);
  app.footer(examples({"polyarm fk universal_robots/ur3 --joints 0 -1.2 1.5 -1.9 -1.57 0",
                       "polyarm fk abb/irb_120 --tool suction_cup --json"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  const Loaded robot = load(common);
  if (joints.empty()) joints = robot.home;
  check_size(joints, *robot.chain, "--joints");
  const Pose pose = robot.chain->forward(joints);
  if (common.as_json) {
    json out = json_of(pose);
    out["joints"] = joints_json(*robot.chain, joints);
    fmt::print("{}\n", out.dump());
    return kOk;
  }
  const Vec3 rpy = to_rpy(pose.rotation);
  const Quaternion& q = pose.rotation;
  fmt::print(
      "xyz         {:.6f} {:.6f} {:.6f}\nrpy         {:.6f} {:.6f} {:.6f}\nquaternion  {:.6f} {:.6f} {:.6f} "
      "{:.6f}\n",
      pose.position.x, pose.position.y, pose.position.z, rpy.x, rpy.y, rpy.z, q.x, q.y, q.z, q.w);
  return kOk;
}

int run_ik(int argc, char** argv) {
  CommandLine app("Inverse kinematics: joint values that put the TCP at a pose in the base frame",
                  "polyarm ik");
  Common common;
  PoseQuestion question;
  common.robot.of_numbers = "--xyz";
  common.add_to(app);
  question.add_to(app);
  app.footer(examples(
      {"polyarm ik universal_robots/ur5e --xyz 0.4 0 0.3 --rpy 3.1416 0 0",
       "polyarm ik fanuc/lr_mate_200id --tool suction_cup --xyz 0.3 0.15 0.04 --rpy 3.1416 0 0 --json",
       "polyarm ik universal_robots/ur3 --xyz 0.3 0 0.3 --quaternion 1 0 0 0 --all",
       "polyarm ik franka/fer_panda --xyz 0.4 0 0.4 --rpy 3.1416 0 0 --free-spin z",
       "polyarm ik universal_robots/ur5e --xyz 0.4 0 0.3 --position-only",
       "polyarm ik abb/irb_120 --xyz 0.4 0 0.3 --rpy 3.1416 0 0 --orientation-tolerance 0.1 0.1 0"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  const Loaded robot = load(common);
  const Pose target = question.target();
  if (question.seed.empty()) question.seed = robot.home;
  check_size(question.seed, *robot.chain, "--seed");
  const ik::InverseKinematics arm(*robot.chain);
  const Result result = answer(arm, question, target, robot.home);
  const std::string way = question.of_parts() ? "solved by iteration: parts of a pose" : way_of(arm);
  std::vector<std::vector<double>> solutions;
  if (question.all && result) solutions = all_solutions(arm, question, target);
  if (common.as_json) {
    json out = {{"status", ik::name(result.outcome)},
                {"position_error_m", result.position_error},
                {"orientation_error_rad", result.orientation_error},
                {"q", result.q},
                {"joints", joints_json(*robot.chain, result.q)}};
    if (!result) out["reason"] = result.reason;
    if (question.all) {
      out["solutions"] = solutions;
      out["found_by"] = way;
    }
    fmt::print("{}\n", out.dump());
  } else if (!result) {
    fmt::print(stderr, "polyarm ik: {} cannot: {}\n", robot.model.name, result.reason);
  } else if (!question.all) {
    fmt::print("{:.6f}\n", fmt::join(result.q, " "));
  } else {
    fmt::print("# {}\n# {} solution{} within limits\n", way, solutions.size(),
               solutions.size() == 1 ? "" : "s");
    for (const std::vector<double>& q : solutions)
      fmt::print("{:.6f}  # {}\n", fmt::join(q, " "), remark_on(*robot.chain, q, question.seed));
  }
  return result ? kOk : kFailed;
}

}  // namespace polyarm::apps
