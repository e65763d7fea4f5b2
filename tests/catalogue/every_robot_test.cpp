/// Every robot of the catalogue at work: it stands in physics, solves its inverse kinematics, and carries a
/// part from one place to another, all scaled to its reach.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <set>

#include "drivers/mujoco/component.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "tests/drivers/rig.hpp"
#include "tests/ik/answers.hpp"

namespace polyarm::test {
namespace {

using description::RobotModel;
using kinematics::Chain;
using State = std::vector<double>;

const description::Catalogue& catalogue() {
  static const description::Catalogue out({POLYARM_SOURCE_DIR "/robots"});
  return out;
}

/// A suction cup `scale` times the size of that of the examples.
description::Tool cup(double scale, double payload) {
  description::Tool out = description::find_tool("suction_cup", "");
  out.tcp.position.z *= scale;
  out.mass = std::min(out.mass * scale, 0.2 * payload);
  out.center = scale * out.center;
  out.cup_radius *= scale;
  for (description::Shape& shape : out.body) {
    shape.radius *= scale;
    shape.length *= scale;
    shape.pose.position = scale * shape.pose.position;
  }
  return out;
}

/// The states of one pass, the TCP's poses among them.
struct Pass {
  State home, over_pick, pick, place, over_place;
  Pose T_pick, T_place;
};

class Robot {
 public:
  explicit Robot(const std::string& name)
      : model(catalogue().load(name)),
        home(model.named_states.at("home")),
        reach(Chain(model, model.tool_link()).reach()),
        payload(model.provenance.payload_kg.value_or(0.5)),
        scale(std::clamp(reach / 0.9, 0.2, 3.0)),
        tool(cup(scale, payload)),
        chain(model, model.tool_link(), {}, tool.tcp) {}

  /// The same posture, the first joint turned by `angle`, less where its limits are near.
  State turned(double angle) const {
    State out = home;
    out[0] = std::clamp(home[0] + angle, chain.lower()[0] + 0.02, chain.upper()[0] - 0.02);
    return out;
  }
  /// The TCP higher by `rise`, its orientation kept as far as the arm has it.
  State above(const State& q, double rise) const {
    Pose target = chain.forward(q);
    target.position.z += rise;
    test::Answer found = test::move(chain, target, q, q);
    if (!found) found = test::descend(chain, target, q, ik::IkTask::position_only());
    return found ? found.q : State{};
  }
  Pass pass() const {
    Pass out;
    out.home = home;
    out.pick = turned(0.45);
    out.place = turned(-0.45);
    for (double rise = 0.06 * reach; rise > 0.01 * reach; rise *= 0.7) {
      out.over_pick = above(out.pick, rise);
      out.over_place = above(out.place, rise);
      if (!out.over_pick.empty() && !out.over_place.empty()) break;
    }
    out.T_pick = chain.forward(out.pick);
    out.T_place = chain.forward(out.place);
    return out;
  }

  const RobotModel model;
  const State home;
  const double reach, payload, scale;
  const description::Tool tool;
  const Chain chain;
};

// --- inverse kinematics

State random_state(const Chain& chain, std::mt19937& random) {
  State out;
  for (std::size_t i = 0; i < chain.joints(); ++i) {
    const double low = std::max(chain.lower()[i], -3.1), high = std::min(chain.upper()[i], 3.1);
    out.push_back(std::uniform_real_distribution<double>(low + 0.02 * (high - low),
                                                         high - 0.02 * (high - low))(random));
  }
  return out;
}

void expect_inverse_kinematics(const Robot& robot) {
  const ik::InverseKinematics closed(robot.chain);
  std::mt19937 random(11);
  for (int k = 0; k < 20; ++k) {
    const Pose target = robot.chain.forward(random_state(robot.chain, random));
    State q;
    ik::IkSolution solution;
    if (closed && closed.solve(target, robot.home, solution) == ik::IkOutcome::solved)
      q.assign(solution.q.begin(), solution.q.begin() + static_cast<std::ptrdiff_t>(robot.chain.joints()));
    else
      q = test::descend(closed, target, robot.home).q;
    const Pose reached = robot.chain.forward(q);
    EXPECT_LT(norm(reached.position - target.position), 1e-5) << "pose " << k;
    EXPECT_LT(angle_between(reached.rotation, target.rotation), 1e-4) << "pose " << k;
    for (std::size_t i = 0; i < q.size(); ++i) {
      EXPECT_GE(q[i], robot.chain.lower()[i] - 1e-9);
      EXPECT_LE(q[i], robot.chain.upper()[i] + 1e-9);
    }
  }
}

// --- physics

/// A plate at right angles to the tool, its upper face `below` under the TCP along the tool's axis.
description::Fixture plate(const std::string& name, const Pose& T_tcp, double below, double edge) {
  description::Fixture out;
  out.name = name;
  out.shapes = {box({edge, edge, 0.2 * edge})};
  out.pose = T_tcp * Pose{{0, 0, below + 0.1 * edge}, {}};
  return out;
}

/// Two plates under the tool, and a part on the first.
Stage stage_for(const Robot& robot, const Pass& pass, double edge) {
  Stage out;
  out.model = robot.model;
  out.tool = robot.tool;
  out.start = robot.home;
  out.scene.floor_height = -3 * robot.reach;
  out.scene.kinds = {"cube"};
  out.scene.fixtures = {plate("pick_plate", pass.T_pick, edge, 1.5 * edge),
                        plate("place_plate", pass.T_place, 1.04 * edge, 1.5 * edge)};
  out.scene.parts = {cube("cube", pass.T_pick * Vec3{0, 0, edge / 2}, edge,
                          std::min(400 * edge * edge * edge, 0.3 * robot.payload))};
  out.scene.parts[0].start.rotation = pass.T_pick.rotation;
  return out;
}

/// Long enough for speed and acceleration limits of every joint (peaks of the quintic: 1.875 and 5.774).
double duration(const Robot& robot, const State& from, const State& to) {
  double out = 0.25;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto& limits = robot.model.joints[static_cast<std::size_t>(robot.model.actuated[i])].limits;
    const double way = std::abs(to[i] - from[i]);
    out = std::max({out, 2.1 * way / limits.velocity.value_or(1),
                    std::sqrt(6.5 * way / limits.acceleration.value_or(3))});
  }
  return out;
}

class Work {
 public:
  Work(const Robot& robot, Rig& rig) : robot_(robot), rig_(rig), at_(robot.home) {}

  void go(const State& to) {
    std::map<std::string, double> goal;
    for (std::size_t i = 0; i < to.size(); ++i) goal["arm/" + robot_.chain.names()[i] + "/position"] = to[i];
    rig_.move(goal, duration(robot_, at_, to));
    at_ = to;
  }
  void vacuum(double on) {
    rig_.command("arm/tool/vacuum") = on;
    rig_.run(0.2);
  }
  double worst_error() const {
    double out = 0;
    for (std::size_t i = 0; i < at_.size(); ++i)
      out = std::max(out, std::abs(rig_.state("arm/" + robot_.chain.names()[i] + "/position") - at_[i]));
    return out;
  }

 private:
  const Robot& robot_;
  Rig& rig_;
  State at_;
};

/// Robots that do not carry the part through today, in physics: with the masses and limits of their files
/// they sag, swing or touch themselves. One that does is to leave this list.
bool carries_no_part(const std::string& name) {
  static const std::set<std::string> names{"aubo/i16",
                                           "doosan/m1509",
                                           "elephant_robotics/mycobot_pro_630",
                                           "kawada/nextage_open_left_arm",
                                           "kawada/nextage_open_right_arm",
                                           "robotis/omy_3m",
                                           "the_robot_studio/so_100",
                                           "yaskawa/sda10f_arm_group_1_incl_torso_axis",
                                           "yaskawa/sda10f_arm_group_2_incl_torso_axis"};
  return names.contains(name);
}

class EveryRobot : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryRobot, SolvesItsInverseKinematics) {
  expect_inverse_kinematics(Robot(GetParam()));
}

/// One pass of a pick and place. Returns what was not as it should be; empty when all was.
std::string carry_a_part(const Robot& robot) {
  const Pass pass = robot.pass();
  if (pass.over_pick.empty() || pass.over_place.empty()) return "nothing above the pick is reachable";
  const double edge = 0.05 * robot.scale;
  const Stage stage = stage_for(robot, pass, edge);
  Rig rig(std::make_unique<drivers::MujocoComponent>(), stage.context());
  Work work(robot, rig);
  const auto held = [&] { return rig.state("arm/tool/part_present") == 1; };
  work.go(pass.home);
  rig.run(0.3);
  if (!(work.worst_error() < 2.5e-3)) return "it does not stand still";
  work.go(pass.over_pick);
  work.go(pass.pick);
  work.vacuum(1);
  if (!held()) return "the cup does not hold the part";
  work.go(pass.over_pick);
  if (!held()) return "the part is lost on the way up";
  work.go(pass.over_place);
  work.go(pass.place);
  work.vacuum(0);
  if (held()) return "the cup does not switch its torque off";
  work.go(pass.over_place);
  rig.run(0.3);
  const Vec3 wanted = pass.T_place * Vec3{0, 0, 0.54 * edge};
  if (!(norm(rig.part(0).pose.position - wanted) < std::max(0.15 * edge, 0.005)))
    return "the part lies elsewhere";
  if (!(work.worst_error() < 2.5e-3)) return "it does not stand still at the end";
  return {};
}

TEST_P(EveryRobot, StandsStillAndCarriesAPart) {
  const std::string wrong = carry_a_part(Robot(GetParam()));
  EXPECT_EQ(!wrong.empty(), carries_no_part(GetParam())) << wrong;
}

std::vector<std::string> robots() {
  return catalogue().names();
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryRobot, ::testing::ValuesIn(robots()), [](const auto& test) {
  std::string out = test.param;
  std::replace_if(
      out.begin(), out.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return out;
});

}  // namespace
}  // namespace polyarm::test
