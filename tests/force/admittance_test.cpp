/// Admittance: the equation against its solution, contacts of any stiffness, an arm, and the controller.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/force/admittance_controller.hpp"
#include "tests/controllers/rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers::admittance_test {
namespace {

/// Three axes that slide along x, y, z and three that turn about x, y, z in one point: the Jacobian is the
/// identity at zero. `tool` is turned against the rest.
description::RobotModel gantry() {
  std::string text = "<robot name=\"gantry\"><link name=\"base_link\"/>";
  std::string parent = "base_link";
  const auto add = [&](const std::string& name, const char* type, const char* axis) {
    text += "<link name=\"" + name + "_link\"/><joint name=\"" + name + "\" type=\"" + type +
            "\"><parent link=\"" + parent + "\"/><child link=\"" + name + "_link\"/><axis xyz=\"" + axis +
            "\"/><limit lower=\"-2\" upper=\"2\" velocity=\"10\" effort=\"100\"/></joint>";
    parent = name + "_link";
  };
  add("x", "prismatic", "1 0 0");
  add("y", "prismatic", "0 1 0");
  add("z", "prismatic", "0 0 1");
  add("rx", "revolute", "1 0 0");
  add("ry", "revolute", "0 1 0");
  add("rz", "revolute", "0 0 1");
  text +=
      "<link name=\"tool\"/><joint name=\"to_tool\" type=\"fixed\"><parent link=\"rz_link\"/><child "
      "link=\"tool\"/>"
      "<origin rpy=\"0 0 1.5707963267948966\"/></joint></robot>";
  Problems found;
  return description::read_urdf(text, "gantry.urdf", found);
}

AdmittanceParameters soft(double mass, double stiffness, double ratio) {
  AdmittanceParameters out;
  out.axes.fill(true);
  out.mass.fill(mass);
  out.stiffness.fill(stiffness);
  out.damping_ratio.fill(ratio);
  out.joint_damping = 0;
  out.filter = 1;
  out.alpha = 0;
  return out;
}

/// A robot that does what it is commanded, one step later.
struct Plant {
  description::RobotModel model = gantry();
  AdmittanceFrames frames;
  AdmittanceRule rule;
  std::vector<double> reference, measured;

  explicit Plant(const AdmittanceParameters& parameters, const char* control = "base_link",
                 const char* sensor = "rz_link")
      : frames{model.find_link(sensor), 0, model.find_link(control), 0, model.find_link(sensor)},
        rule(model, frames, {0, 1, 2, 3, 4, 5}),
        reference(6, 0.0),
        measured(6, 0.0) {
    rule.set(parameters);
  }
  void step(const SixVector& wrench, double dt) {
    ASSERT_TRUE(rule.update(measured, reference, wrench, dt));
    for (std::size_t i = 0; i < 6; ++i) measured[i] = reference[i] + rule.offset()[i];
  }
};

/// M x'' + D x' + K x = F from rest.
double solution(double t, double F, double M, double D, double K) {
  const double w = std::sqrt(K / M), zeta = D / (2 * std::sqrt(M * K));
  const double end = F / K;
  if (std::abs(zeta - 1) < 1e-9) return end * (1 - (1 + w * t) * std::exp(-w * t));
  if (zeta < 1) {
    const double wd = w * std::sqrt(1 - zeta * zeta);
    return end * (1 - std::exp(-zeta * w * t) * (std::cos(wd * t) + zeta * w / wd * std::sin(wd * t)));
  }
  const double root = w * std::sqrt(zeta * zeta - 1), a = -zeta * w + root, b = -zeta * w - root;
  return end * (1 + (b * std::exp(a * t) - a * std::exp(b * t)) / (a - b));
}

TEST(Admittance, AStepOnOneAxisIsTheSolutionOfItsEquation) {
  for (std::size_t axis = 0; axis < 6; ++axis)
    for (const double zeta : {0.4, 1.0, 2.5}) {
      const double M = 5, K = 200, F = axis < 3 ? 20 : 4;
      Plant plant(soft(M, K, zeta));
      SixVector wrench{};
      wrench[axis] = F;
      for (int k = 1; k <= 4000; ++k) {
        // The torque stays along the axis: it is measured in the sensor, which turns about that axis only.
        plant.step(wrench, 0.0005);
        const double exact = solution(k * 0.0005, F, M, 2 * zeta * std::sqrt(M * K), K);
        ASSERT_NEAR(plant.rule.offset()[axis], exact, 0.01 * F / K) << axis << " at " << k;
      }
      for (std::size_t other = 0; other < 6; ++other)
        if (other != axis) {
          EXPECT_NEAR(plant.rule.offset()[other], 0, 1e-12);
        }
    }
}

TEST(Admittance, ComesCloserToTheSolutionWithShorterSteps) {
  const auto worst = [](double dt) {
    Plant plant(soft(5, 200, 0.7));
    double out = 0;
    for (int k = 1; k * dt <= 1; ++k) {
      plant.step({20, 0, 0, 0, 0, 0}, dt);
      out = std::max(
          out, std::abs(plant.rule.offset()[0] - solution(k * dt, 20, 5, 1.4 * std::sqrt(1000.0), 200)));
    }
    return out;
  };
  EXPECT_NEAR(worst(0.002) / worst(0.001), 2, 0.2);
}

TEST(Admittance, JointDampingAndAlphaAreMoreDampingAndMoreMass) {
  AdmittanceParameters parameters = soft(5, 200, 0.7);
  parameters.joint_damping = 3;
  parameters.alpha = 0.1;
  Plant plant(parameters);
  // q'' = (F − D x' − K x) / (1.1 M) − 3 q'
  const double M = 5 * 1.1, D = 1.4 * std::sqrt(1000.0) + 3 * M;
  for (int k = 1; k <= 4000; ++k) {
    plant.step({20, 0, 0, 0, 0, 0}, 0.0005);
    ASSERT_NEAR(plant.rule.offset()[0], solution(k * 0.0005, 20, M, D, 200), 1e-3);
  }
}

TEST(Admittance, YieldsOnTheSelectedAxesOfTheControlFrame) {
  AdmittanceParameters parameters = soft(5, 200, 1);
  parameters.axes = {true, false, false, false, false, false};
  Plant plant(parameters, "tool");  // its x is the base's y
  for (int k = 0; k < 4000; ++k) plant.step({10, 20, 30, 1, 1, 1}, 0.001);
  EXPECT_NEAR(plant.rule.offset()[0], 0, 1e-6);
  EXPECT_NEAR(plant.rule.offset()[1], 20 / 200.0, 1e-4);
  for (std::size_t i = 2; i < 6; ++i) EXPECT_NEAR(plant.rule.offset()[i], 0, 1e-6);
}

TEST(Admittance, SmoothsTheWrench) {
  AdmittanceParameters parameters = soft(5, 200, 1);
  parameters.filter = 0.25;
  Plant plant(parameters);
  for (int k = 1; k <= 5; ++k) {
    plant.step({8, 0, 0, 0, 0, 0}, 0.001);
    EXPECT_NEAR(plant.rule.wrench()[0], 8 * (1 - std::pow(0.75, k)), 1e-3);
  }
}

TEST(Admittance, DoesNotFeelTheWeightOfItsTool) {
  AdmittanceParameters parameters = soft(5, 200, 1);
  parameters.weight = 12;
  parameters.cog = {0.03, -0.02, 0.1};
  Plant plant(parameters);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-1.5, 1.5);
  for (int k = 0; k < 200; ++k) {
    for (std::size_t i = 0; i < 6; ++i) plant.reference[i] = plant.measured[i] = any(random);
    plant.rule.reset();
    // What the sensor measures of 12 N at that point.
    const kinematics::Chain chain(plant.model, plant.frames.sensor);
    const Quaternion R = inverse(chain.forward(plant.measured).rotation);
    const Vec3 force = R * Vec3{0, 0, -12}, torque = cross(parameters.cog, force);
    ASSERT_TRUE(plant.rule.update(plant.measured, plant.reference,
                                  {force.x, force.y, force.z, torque.x, torque.y, torque.z}, 0.001));
    for (const double value : plant.rule.wrench()) ASSERT_NEAR(value, 0, 1e-12);
  }
}

TEST(Admittance, SettlesOnContactsOfAnyStiffness) {
  for (const double wall : {1e3, 1e4, 1e5})
    for (const double mass : {2.0, 10.0}) {
      AdmittanceParameters parameters = soft(mass, 500, 500 / std::sqrt(mass * 500));  // D = 1000 N s/m
      Plant plant(parameters);
      double force = 0, most = 0, least_late = 1e9, most_late = 0;
      for (int k = 0; k < 10000; ++k) {
        plant.reference[2] =
            std::max(-0.05, -0.02 * k * 0.001);  // down at 20 mm/s, to 50 mm; the wall is at −10 mm
        const double depth = -0.01 - plant.measured[2];
        force = depth > 0 ? wall * depth : 0;
        plant.step({0, 0, force, 0, 0, 0}, 0.001);
        most = std::max(most, force);
        if (k > 9000) least_late = std::min(least_late, force), most_late = std::max(most_late, force);
      }
      const double rest = 500 * wall / (500 + wall) * 0.04;  // both springs share 40 mm
      EXPECT_NEAR(force, rest, 0.001 * rest) << wall << " " << mass;
      EXPECT_LT(most_late - least_late, 0.001 * rest) << wall << " " << mass;
      EXPECT_LT(most, 2 * rest) << wall << " " << mass;
    }
}

TEST(Admittance, AnArmYieldsAlongTheForceAlone) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  const description::RobotModel model = catalogue.load("universal_robots/ur5e");
  const int tool = model.find_link("tool0");
  ASSERT_GE(tool, 0);
  const kinematics::Chain chain(model, tool);
  AdmittanceParameters parameters = soft(4, 300, 1);
  parameters.alpha = 1e-6;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    AdmittanceRule rule(model, {tool, 0, 0, 0, tool}, {0, 1, 2, 3, 4, 5});
    rule.set(parameters);
    const std::vector<double> reference{0.3, -1.2, 1.6, -1.9, -1.4, 0.2};
    std::vector<double> measured = reference;
    const Pose before = chain.forward(reference);
    Vec3 force{};
    (axis == 0 ? force.x : axis == 1 ? force.y : force.z) = 15;
    for (int k = 0; k < 4000; ++k) {
      const Vec3 felt = inverse(chain.forward(measured).rotation) * force;
      ASSERT_TRUE(rule.update(measured, reference, {felt.x, felt.y, felt.z, 0, 0, 0}, 0.001));
      for (std::size_t i = 0; i < 6; ++i) measured[i] = reference[i] + rule.offset()[i];
    }
    const Pose after = chain.forward(measured);
    const Vec3 moved = after.position - before.position;
    EXPECT_LT(norm(moved - (1 / 300.0) * force), 2e-3);
    EXPECT_LT(angle_between(before.rotation, after.rotation), 2e-3);
  }
}

// ---- the controller

const std::vector<std::string> kJoints = {"x", "y", "z", "rx", "ry", "rz"};

struct Yielding {
  AdmittanceController controller;
  description::RobotModel model = gantry();
  Rig rig;
  explicit Yielding(const Rig::Values& more = {})
      : rig(controller, "arm", kJoints, states(), commands(), values(more), "admittance") {
    for (JointFacts& joint : rig.context.joints.edit()) joint.lower = -2, joint.upper = 2;
    controller.set_models({{"arm", &model}});
    rig.cycle.period = 1'000'000;
  }
  static std::vector<std::string> commands() {
    std::vector<std::string> out;
    for (const std::string& joint : kJoints)
      for (const char* kind : {"/position", "/velocity"}) out.push_back(joint + kind);
    return out;
  }
  static std::vector<std::string> states() {
    std::vector<std::string> out = commands();
    for (const char* axis : {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"})
      out.push_back(std::string("fts/") + axis);
    return out;
  }
  static Rig::Values values(const Rig::Values& more) {
    Rig::Values out{{"joints", kJoints},
                    {"command_interfaces", {"position", "velocity"}},
                    {"state_interfaces", {"position", "velocity"}},
                    {"chainable_command_interfaces", {"position", "velocity"}},
                    {"kinematics.plugin_name", {"kinematics_interface_kdl/KinematicsInterfaceKDL"}},
                    {"kinematics.plugin_package", {"kinematics_interface"}},
                    {"kinematics.base", {"base_link"}},
                    {"kinematics.tip", {"rz_link"}},
                    {"kinematics.alpha", {"0"}},
                    {"ft_sensor.name", {"fts"}},
                    {"ft_sensor.frame.id", {"rz_link"}},
                    {"ft_sensor.filter_coefficient", {"1"}},
                    {"control.frame.id", {"base_link"}},
                    {"fixed_world_frame.frame.id", {"base_link"}},
                    {"gravity_compensation.frame.id", {"rz_link"}},
                    {"gravity_compensation.CoG.pos", {"0", "0", "0"}},
                    {"gravity_compensation.CoG.force", {"0"}},
                    {"admittance.selected_axes", {"true", "true", "true", "true", "true", "true"}},
                    {"admittance.mass", {"5", "5", "5", "5", "5", "5"}},
                    {"admittance.damping_ratio", {"1", "1", "1", "1", "1", "1"}},
                    {"admittance.stiffness", {"200", "200", "200", "200", "200", "200"}},
                    {"admittance.joint_damping", {"0"}}};
    for (const auto& [key, value] : more) out[key] = value;
    return out;
  }
  void follow() {
    for (const std::string& joint : kJoints)
      if (std::isfinite(rig.command(joint + "/position")))
        rig.state(joint + "/position") = rig.command(joint + "/position");
  }
  void run(int steps) {
    for (int k = 0; k < steps; ++k) {
      ASSERT_EQ(rig.step(), ReturnType::ok);
      follow();
    }
  }
  double command(const char* name) { return rig.command(name); }
};

TEST(AdmittanceController, OffersAndClaimsWhatItsOriginalDoes) {
  Yielding arm;
  arm.rig.start();
  EXPECT_EQ(arm.controller.command_interfaces().front(), "arm/x/position");
  EXPECT_EQ(arm.controller.command_interfaces()[6], "arm/x/velocity");
  EXPECT_EQ(arm.controller.state_interfaces().back(), "arm/fts/torque.z");
  EXPECT_EQ(arm.controller.reference_interfaces().front(), "admittance/x/position");
  EXPECT_EQ(arm.controller.reference_interfaces()[6], "admittance/x/velocity");
  EXPECT_EQ(arm.rig.findings().find("has no parameter"), std::string::npos) << arm.rig.findings();
}

TEST(AdmittanceController, NeverJumpsWhenItStarts) {
  for (const bool chained : {false, true}) {
    Yielding arm;
    arm.rig.configure();
    arm.rig.state("x/position") = 0.5;
    arm.rig.state("fts/force.x") = 300;    // it stands in a contact
    arm.rig.command("y/position") = 0.01;  // and was commanded a little more than it reached
    arm.rig.activate(chained);
    arm.rig.step();
    EXPECT_NEAR(arm.command("x/position"), 0.5, 1e-4);
    EXPECT_NEAR(arm.command("y/position"), 0.01, 1e-4);
    EXPECT_NEAR(arm.command("x/velocity"), 0, 0.1);
    EXPECT_EQ(arm.rig.command("admittance/x/position"), 0.5);
  }
}

TEST(AdmittanceController, AddsItsOffsetToReferences) {
  Yielding arm;
  arm.rig.start(true);
  for (int k = 0; k < 5000; ++k) {
    arm.rig.command("admittance/x/position") = 0.3;
    arm.rig.state("fts/force.x") = 10;
    arm.run(1);
  }
  EXPECT_NEAR(arm.command("x/position"), 0.3 + 10 / 200.0, 1e-5);
  EXPECT_NEAR(arm.command("x/velocity"), 0, 1e-5);
  arm.rig.command("admittance/x/position") = std::nan("");
  arm.run(1);
  EXPECT_NEAR(arm.command("x/position"), 0.3 + 10 / 200.0, 1e-5);
}

TEST(AdmittanceController, TakesReferencesFromMessages) {
  Yielding arm;
  arm.rig.start();
  TrajectoryMessage point;
  point.points.push_back({{0.1, 0, 0, 0, 0, 0.2}, {}, {}, {}, 0});
  arm.controller.receive("joint_references", point, false);
  arm.run(2000);
  EXPECT_NEAR(arm.command("x/position"), 0.1, 1e-6);
  EXPECT_NEAR(arm.command("rz/position"), 0.2, 1e-6);
  point.points.front().positions = {9, 0, 0, 0, 0, 0};
  EXPECT_THROW(arm.controller.receive("joint_references", point, false), Error);
  point.points.front().positions = {std::nan(""), 0, 0, 0, 0, 0};
  EXPECT_THROW(arm.controller.receive("joint_references", point, false), Error);
  point.points.front().positions = {0, 0};
  EXPECT_THROW(arm.controller.receive("joint_references", point, false), Error);
}

TEST(AdmittanceController, AddsAWrenchReferenceInTheSensorsFrame) {
  Yielding arm;
  arm.rig.start();
  NamedValues wrench{{"force.z", "frame_id=rz_link"}, {-6, 0}};
  arm.controller.receive("wrench_reference", wrench, false);
  arm.rig.state("fts/force.z") = 2;
  arm.run(5000);
  EXPECT_NEAR(arm.command("z/position"), -4 / 200.0, 1e-5);
  wrench.names[1] = "frame_id=base_link";
  EXPECT_THROW(arm.controller.receive("wrench_reference", wrench, false), Error);
}

TEST(AdmittanceController, TakesAMissingWrenchForNone) {
  Yielding arm;
  arm.rig.start();
  arm.rig.state("fts/force.x") = 10;
  arm.rig.state("fts/torque.y") = std::nan("");
  arm.run(100);
  EXPECT_EQ(arm.command("x/position"), 0);
}

TEST(AdmittanceController, KeepsItsOffsetWhileTheCellStands) {
  Yielding arm;
  arm.rig.start(true);
  arm.rig.state("fts/force.x") = 10;
  arm.run(300);
  const double offset = arm.command("x/position");
  EXPECT_GT(offset, 0.01);
  EXPECT_FALSE(arm.controller.standing());
  arm.rig.verdict.speed = 0;
  arm.rig.state("fts/force.x") = -50;
  arm.run(300);
  EXPECT_EQ(arm.command("x/position"), offset);
  EXPECT_EQ(arm.command("x/velocity"), 0);
  EXPECT_TRUE(arm.controller.standing());
  arm.rig.command("admittance/x/position") = 0.1;  // the one before it comes to rest on its path
  arm.run(1);
  EXPECT_NEAR(arm.command("x/position"), offset + 0.1, 1e-12);
}

TEST(AdmittanceController, StaysWithinTheJointsLimits) {
  Yielding arm;
  arm.rig.start(true);
  arm.rig.command("admittance/x/position") = 1.95;
  arm.rig.state("fts/force.x") = 100;
  arm.run(5000);
  EXPECT_LE(arm.command("x/position"), 2);
  arm.rig.state("fts/force.x") = 0;
  arm.run(5000);
  EXPECT_NEAR(arm.command("x/position"), 1.95, 1e-4);  // nothing has wound up
}

TEST(AdmittanceController, PublishesItsState) {
  Yielding arm;
  arm.rig.start();
  arm.rig.told("status", "mass.data[0]");  // somebody listens
  arm.rig.state("fts/force.x") = 10;
  arm.run(10);
  EXPECT_EQ(arm.rig.told("status", "mass.data[0]"), 5);
  EXPECT_NEAR(arm.rig.told("status", "damping.data[1]"), 2 * std::sqrt(1000.0), 1e-12);
  EXPECT_EQ(arm.rig.told("status", "selected_axes.data[5]"), 1);
  EXPECT_EQ(arm.rig.told("status", "wrench_base.wrench.force.x"), 10);
  EXPECT_GT(arm.rig.told("status", "admittance_velocity.twist.linear.x"), 0);
  EXPECT_GT(arm.rig.told("status", "joint_state.position[0]"), 0);
  EXPECT_EQ(arm.rig.told("status", "rot_base_control.w"), 1);
  EXPECT_EQ(arm.controller.find_output("status")->texts.at("frame_id"), "base_link");
}

TEST(AdmittanceController, TakesNewDampingWhileItRuns) {
  Yielding arm;
  arm.rig.start();
  EXPECT_EQ(arm.rig.change("admittance.joint_damping", "1000"), "");
  arm.rig.state("fts/force.x") = 10;
  arm.run(100);
  EXPECT_LT(arm.command("x/position"), 3e-4);
  EXPECT_THROW(arm.rig.change("admittance.joint_damping", "-1"), Error);
  EXPECT_THROW(arm.rig.change("ft_sensor.filter_coefficient", "2"), Error);
}

TEST(AdmittanceController, ReportsTheProblem) {
  const std::pair<Rig::Values, const char*> kWrong[] = {
      {{{"joints", {"x", "y"}}}, "moves the sensor and is not controlled"},
      {{{"joints", {"x", "y", "z", "rx", "ry", "rq"}}}, "rq"},
      {{{"command_joints", {"x"}}}, "'command_joints' has 1 names for 6 joints"},
      {{{"command_interfaces", {"effort"}}}, "'command_interfaces' has 'effort'"},
      {{{"state_interfaces", {"velocity"}}}, "'state_interfaces' has no position"},
      {{{"chainable_command_interfaces", {"effort"}}}, "'chainable_command_interfaces' has 'effort'"},
      {{{"ft_sensor.name", {"fts_2"}}}, "there is no sensor 'fts_2'"},
      {{{"ft_sensor.frame.id", {"rz_lnk"}}}, "did you mean 'rz_link'"},
      {{{"admittance.mass", {"1", "1", "1"}}}, "'admittance.mass' is not six numbers"},
      {{{"admittance.mass", {"0", "1", "1", "1", "1", "1"}}}, "'admittance.mass' is not six numbers"},
      {{{"admittance.stiffness", {"-1", "1", "1", "1", "1", "1"}}},
       "'admittance.stiffness' is not six numbers"},
      {{{"admittance.selected_axes", {"true"}}}, "is not six times true or false"},
      {{{"gravity_compensation.CoG.pos", {"1"}}}, "is not three numbers"},
  };
  for (const auto& [values, sentence] : kWrong) {
    Yielding arm(values);
    const std::string why = arm.rig.refusal();
    EXPECT_NE(why.find(sentence), std::string::npos) << sentence << "\n" << why;
  }
}

TEST(AdmittanceController, DoesNothingThatWaits) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  Yielding arm(Rig::Values{{"kinematics.alpha", {"0.01"}}});
  arm.rig.start(true);
  arm.rig.told("status", "mass.data[0]");
  arm.rig.state("fts/force.x") = 10;
  arm.run(10);
  test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    arm.rig.verdict.speed = i % 100 < 10 ? 0 : 1;
    arm.controller.update(arm.rig.cycle, arm.rig.verdict);
    arm.rig.cycle.time += arm.rig.cycle.period;
  }
  arm.controller.on_deactivate(arm.rig.cycle);
  arm.controller.on_activate(arm.rig.cycle);
  ASSERT_EQ(guard.violations(), "");
}

}  // namespace
}  // namespace polyarm::controllers::admittance_test
