/// Moves as instructions, line by line.
#include "drivers/fanuc/instructions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "drivers/wire/six_axes.hpp"
#include "tests/fanuc/rig.hpp"

namespace polyarm {
namespace {

using fanuc::Configuration;
using fanuc::InstructionFrame;
using fanuc::RmiMessage;
using hardware::ForwardMove;
using namespace test;

InstructionFrame frame() {
  InstructionFrame out;
  const wire::AxisFacts axes = wire::axis_facts(fanuc_model(), "fanuc/crx_10ia_l", 1);
  out.flange = std::make_shared<const kinematics::Chain>(fanuc_model(), axes.flange);
  out.world_height = out.flange->axes().at(1).point.z;
  out.base = {{1, 2, 0.5}, from_rpy(0, 0, 0.5)};
  return out;
}

ForwardMove move(ForwardMove::Kind kind) {
  ForwardMove out;
  out.kind = kind;
  const Six degrees{10, 20, 30, 40, 50, 60};
  for (std::size_t i = 0; i < 6; ++i) out.joints[i] = degrees[i] * kDegree;
  out.share = 0.509;
  out.speed = 0.25;
  return out;
}

RmiMessage line(const ForwardMove& of, const InstructionFrame& in = frame(), bool fine = false) {
  const auto parsed =
      fanuc::parse_rmi(instruction_of(of, in, 7, fine, Configuration{{1, 1, 0, 0, 0, -1, 0}}).line());
  EXPECT_TRUE(parsed);
  return parsed.value_or(RmiMessage{});
}

TEST(FanucInstructions, AJointMoveHasAnglesWithJoint3AgainstTheHorizontal) {
  const RmiMessage out = line(move(ForwardMove::Kind::joint));
  EXPECT_EQ(out.kind, RmiMessage::Kind::instruction);
  EXPECT_EQ(out.name, "FRC_JointMotionJRep");
  EXPECT_EQ(out.number("SequenceID"), 7);
  EXPECT_NEAR(out.number("JointAngle.J2"), 20, 1e-9);
  EXPECT_NEAR(out.number("JointAngle.J3"), 10, 1e-9);
  EXPECT_EQ(out.number("JointAngle.J9", -1), 0);
  EXPECT_EQ(out.text("SpeedType"), "Percent");
  EXPECT_EQ(out.number("Speed"), 50);
  EXPECT_EQ(out.text("TermType"), "FINE");
  EXPECT_FALSE(out.has("ACC"));
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(fanuc::radians_of(fanuc::rmi_joints({1, 2, 3, 4, 5, 6}))[i], static_cast<double>(i + 1),
                1e-12);
}

TEST(FanucInstructions, ALineHasMillimetresPerSecondOrItsTimeIfTheToolOnlyTurns) {
  ForwardMove of = move(ForwardMove::Kind::line);
  of.acceleration = 0.4;
  RmiMessage out = line(of);
  EXPECT_EQ(out.name, "FRC_LinearMotionJRep");
  EXPECT_EQ(out.text("SpeedType"), "mmSec");
  EXPECT_EQ(out.number("Speed"), 250);
  EXPECT_EQ(out.number("ACC"), 40);
  of.speed = 0;
  of.duration = 1.5;
  out = line(of);
  EXPECT_EQ(out.text("SpeedType"), "mSec");
  EXPECT_EQ(out.number("Speed"), 1500);
}

TEST(FanucInstructions, ABlendIsCntByTheWayOfTheSlowingDown) {
  ForwardMove of = move(ForwardMove::Kind::line);
  of.stops = false;
  of.blend = 0.00625;  // 0.25 m/s slow down in 0.2 s within 25 mm: a quarter of that
  EXPECT_EQ(line(of).text("TermType"), "CNT");
  EXPECT_EQ(line(of).number("TermValue"), 50);
  of.blend = 0.1;
  EXPECT_EQ(line(of).number("TermValue"), 100);
  EXPECT_EQ(line(of, frame(), true).text("TermType"), "FINE");
  of.blend = 1e-9;
  EXPECT_EQ(line(of).text("TermType"), "FINE") << "CNT has 1 to 100";
  of.blend = 0.1;
  of.stops = true;
  EXPECT_EQ(line(of).text("TermType"), "FINE");
}

TEST(FanucInstructions, AnArcHasPosesInTheControllersWorldFrame) {
  const InstructionFrame in = frame();
  ForwardMove of = move(ForwardMove::Kind::arc);
  const Pose end{{0.7, 0.1, 0.4}, from_rpy(std::numbers::pi, 0, 0)}, via{{0.6, 0, 0.5}, end.rotation};
  of.at = in.base * end;
  of.via = in.base * via;
  const RmiMessage out = line(of, in);
  EXPECT_EQ(out.name, "FRC_CircularMotion");
  EXPECT_NEAR(out.number("Position.X"), 700, 1e-6);
  EXPECT_NEAR(out.number("Position.Z"), 400 - 1000 * in.world_height, 1e-6);
  EXPECT_NEAR(out.number("ViaPosition.X"), 600, 1e-6);
  EXPECT_NEAR(std::abs(out.number("Position.W")), 180, 1e-6);
  EXPECT_EQ(out.number("Configuration.UToolNumber"), 9);
  EXPECT_EQ(out.number("Configuration.UFrameNumber", -1), 0);
  EXPECT_EQ(out.number("ViaConfiguration.Turn5"), -1);
}

TEST(FanucInstructions, TheToolIsTheTcpInTheFacePlate) {
  const InstructionFrame in = frame();
  ForwardMove of = move(ForwardMove::Kind::line);
  const Pose tool{{0.01, 0.02, 0.15}, from_rpy(0.1, -0.2, 0.3)};
  of.at = in.base * in.flange->forward(std::span(of.joints).first(6)) * tool;
  const Pose found = tool_of(of, in);
  EXPECT_NEAR(norm(found.position - tool.position), 0, 1e-9);
  EXPECT_NEAR(angle_between(found.rotation, tool.rotation), 0, 1e-7);
  const auto written = fanuc::parse_rmi(tool_line(tool, in).line());
  ASSERT_TRUE(written);
  EXPECT_EQ(written->number("ToolNumber"), 9);
  EXPECT_NEAR(written->number("Frame.Z"), 150, 1e-9);
}

}  // namespace
}  // namespace polyarm
