/// Whatever way in a message takes: beyond the limits, or no number, it is refused before anything moves.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

#include "polyarm/joint_control/asked_limits.hpp"
#include "tests/controllers/made_controller.hpp"
#include "tests/controllers/trajectory_rig.hpp"

namespace polyarm::controllers {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(),
                 kInf = std::numeric_limits<double>::infinity();

std::string refusal_of(const std::function<void()>& send) {
  try {
    send();
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

/// j1 to j3 from -2 to 2 with a velocity of 3 and an effort of 50.
struct LimitedRig : TrajectoryRig {
  explicit LimitedRig(std::vector<double> start = {0, 0, 0}) : TrajectoryRig(std::move(start)) {
    for (JointFacts& joint : context.joints.edit()) {
      joint.lower = -2, joint.upper = 2;
      joint.velocity = 3, joint.acceleration = 10, joint.states_acceleration = true;
      joint.effort = 50;
    }
  }
};

void set_limits(Made& m) {
  for (JointFacts& joint : m.rig.context.joints.edit()) {
    joint.continuous = false;
    joint.lower = -2, joint.upper = 2, joint.velocity = 3, joint.effort = 50;
  }
}

TEST(RequestedLimits, ATrajectoryBeyondThemIsRefusedWithJointAndValue) {
  LimitedRig rig;
  rig.start();
  const std::pair<trajectory::TrajectoryPoint, const char*> kWrong[] = {
      {point(1, {0, 100, 0}), "'j2' gets a command for a position of 100 at point 1; its limits are -2 to 2"},
      {point(1, {0, 0, -1e308}), "'j3' gets a command for a position of -1e+308"},
      {point(1, {0, 0, 2.001}), "'j3' gets a command for a position of 2.001"},
      {point(1, {0, 0, 0}, {1e308, 0, 0}), "'j1' gets a command for a velocity of 1e+308"},
      {point(1, {0, 0, 0}, {0, 31, 0}),
       "'j2' gets a command for a velocity of 31 at point 1; its limit is 3"},
      {point(1, {0, 0, 0}, {0, 0, 0}, {0, 101, 0}), "'j2' gets a command for an acceleration of 101"},
      {point(1, {0, kNan, 0}), "not a finite number"},
      {point(1, {0, 0, 0}, {kInf, 0, 0}), "not a finite number"},
      {point(1, {0, 0, 0}, {0, 0, 0}, {0, kNan, 0}), "not a finite number"},
      {point(kNan, {0, 0, 0}), "point 1 is at nan s"},
      {point(1e308, {0, 0, 0}), "point 1 is at 1e+308 s"},
      {point(1e-300, {0.1, 0, 0}), "point 1 is at 1e-300 s"},
  };
  for (const auto& [wrong, sentence] : kWrong) {
    const std::string topic = refusal_of([&] { rig.send({wrong}); });
    EXPECT_NE(topic.find(sentence), std::string::npos) << topic << "\nfor: " << sentence;
    const std::string goal = refusal_of([&] { rig.send_goal(rig.message({wrong})); });
    EXPECT_NE(goal.find(sentence), std::string::npos) << goal;
  }
  rig.run(0.5);
  EXPECT_TRUE(rig.events.empty());
  for (std::size_t j = 0; j < 3; ++j) EXPECT_EQ(rig.commanded(j), 0);
}

TEST(RequestedLimits, OfManyWrongPointsOnlySomeAreListed) {
  LimitedRig rig;
  rig.start();
  std::vector<trajectory::TrajectoryPoint> points;
  for (int i = 1; i <= 5000; ++i) points.push_back(point(i, {100, 100, 100}));
  EXPECT_LT(refusal_of([&] { rig.send(points); }).size(), 5000u);
}

TEST(RequestedLimits, ATinyRoundingIsNoRefusal) {
  LimitedRig rig;
  rig.start();
  EXPECT_EQ(refusal_of([&] { rig.send({point(1, {2.00009, -2.00009, 2})}); }), "");
}

TEST(RequestedLimits, AJointThatStandsOutsideMayStayAndComeBack) {
  LimitedRig rig({2.3, 0, 0});
  rig.start();
  EXPECT_EQ(refusal_of([&] { rig.send({point(1, {2.3, 0, 0}), point(2, {1.9, 0, 0})}); }), "");
  EXPECT_NE(refusal_of([&] { rig.send({point(1, {2.4, 0, 0})}); }), "");
  EXPECT_NE(refusal_of([&] { rig.send({point(1, {-2.3, 0, 0})}); }), "");
}

TEST(RequestedLimits, TolerancesThatAreNoNumbersAreRefused) {
  LimitedRig rig;
  rig.start();
  for (const double wrong : {kNan, kInf}) {
    TrajectoryMessage path = rig.message({point(1, {0, 0, 0})});
    path.path_tolerance = {{"j1", wrong, 0, 0}};
    EXPECT_NE(refusal_of([&] { rig.send_goal(path); }).find("path tolerance of 'j1'"), std::string::npos);
    TrajectoryMessage goal = rig.message({point(1, {0, 0, 0})});
    goal.goal_tolerance = {{"j2", 0, wrong, 0}};
    EXPECT_NE(refusal_of([&] { rig.send_goal(goal); }).find("goal tolerance of 'j2'"), std::string::npos);
    TrajectoryMessage time = rig.message({point(1, {0, 0, 0})});
    time.goal_time_tolerance = wrong;
    EXPECT_NE(refusal_of([&] { rig.send_goal(time); }).find("goal's time"), std::string::npos);
  }
}

TEST(RequestedLimits, IntegratedPointsAreJudgedByWhereTheyLead) {
  LimitedRig rig({1.5, 0, 0});
  rig.set("allow_integration_in_goal_trajectories", {"true"});
  rig.start();
  rig.step();
  const auto go = [&](double v) {
    return refusal_of([&] { rig.send({point(0, {}, {v, 0, 0}), point(1, {}, {v, 0, 0}), point(2, {}, {0, 0, 0})}); });
  };
  EXPECT_NE(go(1).find("'j1' gets a command for a position of"), std::string::npos) << go(1);
  EXPECT_EQ(go(-1), "");
}

TEST(RequestedLimits, SpeedScalingIsANumberOfReason) {
  LimitedRig rig;
  rig.start();
  for (const double wrong : {kNan, kInf, -0.1, 1e308, 11.0})
    EXPECT_THROW(rig.jtc.receive("speed_scaling_input", Numbers{{wrong}}, false), Error) << wrong;
  EXPECT_NO_THROW(rig.jtc.receive("speed_scaling_input", Numbers{{0.5}}, false));
}

TEST(RequestedLimits, EveryControllerOfNumbersRefuses) {
  struct Case {
    const char* type;
    std::map<std::string, std::vector<std::string>> parameters;
    double good, wrong;
    const char* sentence;
  };
  const Case kCases[] = {
      {"forward_command_controller/ForwardCommandController", {}, 1.5, 100, "a position of 100"},
      {"forward_command_controller/ForwardCommandController",
       {{"interface_name", {"velocity"}}},
       4,
       1e308,
       "a velocity of 1e+308"},
      {"forward_command_controller/ForwardCommandController",
       {{"interface_name", {"effort"}}},
       60,
       -1e9,
       "an effort of -1000000000"},
      {"velocity_controllers/JointPositionController", {{"pid.p", {"1"}}}, 1.5, 2.1, "a position of 2.1"},
      {"effort_controllers/JointVelocityController", {{"pid.p", {"1"}}}, 2, 40, "a velocity of 40"},
  };
  for (const Case& c : kCases) {
    Made m(c.type);
    set_limits(m);
    m.rig.set("joint", {"j1"});
    for (const auto& [key, value] : c.parameters) m.rig.set(key, value);
    m.rig.start();
    for (const double wrong : {c.wrong, kNan, kInf, -kInf}) {
      const std::string why =
          refusal_of([&] { m.controller->receive("commands", Numbers{{wrong}}, false); });
      EXPECT_NE(why.find("j1"), std::string::npos) << c.type << ": " << why;
      EXPECT_NE(why.find(std::isfinite(wrong) ? c.sentence : "not a finite number"), std::string::npos)
          << why;
    }
    EXPECT_EQ(refusal_of([&] { m.controller->receive("commands", Numbers{{c.good}}, false); }), "") << c.type;
  }
}

TEST(RequestedLimits, AWrongValueLeavesTheOthersOfItsMessageUnused) {
  Made m("forward_command_controller/ForwardCommandController", {"j1", "j2"});
  set_limits(m);
  m.rig.set("joints", {"j1", "j2"});
  m.rig.start();
  EXPECT_THROW(m.controller->receive("commands", Numbers{{1, 100}}, false), Error);
  m.rig.step();
  EXPECT_EQ(m.rig.command("arm/j1/position"), 0);
}

TEST(RequestedLimits, ReferencesOfAPidAreJudged) {
  Made m = chainable();
  set_limits(m);
  m.rig.start();
  const auto ask = [&](double value) {
    return refusal_of([&] { m.controller->receive("reference", NamedValues{{"j1"}, {value}}, false); });
  };
  EXPECT_EQ(ask(1), "");
  EXPECT_NE(ask(100).find("'j1' gets a command for a position of 100"), std::string::npos) << ask(100);
  EXPECT_NE(ask(kNan), "");
}

}  // namespace
}  // namespace polyarm::controllers
