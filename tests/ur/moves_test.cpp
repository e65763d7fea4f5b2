/// Moves of the runtime as messages to the program on the robot, and the program itself.
#include <cmath>

#include "drivers/ur/far_moves.hpp"
#include "drivers/ur/move_shape.hpp"
#include "tests/support/wire_rig.hpp"
#include "tests/ur/forward_rig.hpp"

namespace polyarm {
namespace {

using namespace test;
using hardware::ForwardMove;
using ur::MoveFrame;
using ur::MoveMessage;
using ur::Work;

MoveFrame frame() {
  MoveFrame out;
  out.flange = std::make_shared<const kinematics::Chain>(ur_chain());
  out.velocity = {2, 2, 3, 3, 3, 3};
  out.acceleration = {8, 8, 12, 12, 12, 12};
  return out;
}

const ur::Six kFrom{0.3, -1.2, 1.1, -1.5, -1.57, 0.2};

ForwardMove joint_move(const ur::Six& q) {
  ForwardMove out;
  std::copy(q.begin(), q.end(), out.joints.begin());
  out.at = ur_chain().forward(q);
  out.speed = 0.25;
  return out;
}

ForwardMove line_by(const ur::Six& from, const Vec3& by) {
  Pose at = ur_chain().forward(from);
  at.position = at.position + by;
  const auto jacobian = [](const ur::Six& q, std::array<double, 36>& J) { return ur_chain().jacobian(q, J); };
  ForwardMove out = joint_move(*forward::near_joints(jacobian, at, from));
  out.kind = ForwardMove::Kind::line;
  return out;
}

TEST(UrMoves, AMessageSurvivesTheWire) {
  MoveMessage message{7,   100,  Work::arc, 42,  {0.1, -0.2, 0.3, -0.4, 0.5, -6.2}, {1, 2, 3, -1, -2, -3},
                      1.2, 0.25, 0,         0.02};
  const MoveMessage back = ur::decode_move(ur::encode(message));
  EXPECT_EQ(back.sequence, 7);
  EXPECT_EQ(back.work, Work::arc);
  EXPECT_EQ(back.number, 42);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(back.goal[i], message.goal[i], 1e-6);
    EXPECT_NEAR(back.via[i], message.via[i], 1e-6);
  }
  EXPECT_NEAR(back.acceleration, 1.2, 1e-6);
  EXPECT_NEAR(back.blend, 0.02, 1e-6);
  message.speed = std::nan("");
  message.goal[0] = 1e12;
  EXPECT_EQ(ur::decode_move(ur::encode(message)).speed, 0);
  EXPECT_NEAR(ur::decode_move(ur::encode(message)).goal[0], 2100, 1e-6);
}

TEST(UrMoves, TheJointThatTurnsMostSetsTheSpeedAndNoJointIsFasterThanItsShare) {
  ur::Six to = kFrom;
  to[0] += 0.9, to[4] += 1;  // joint 1 has the lower limit
  ForwardMove move = joint_move(to);
  move.share = 0.5;
  move.acceleration = 0.25;
  const MoveMessage message = ur::message_of(move, kFrom, nullptr, frame());
  EXPECT_EQ(message.work, Work::joint);
  EXPECT_NEAR(message.speed, 0.5 * 2 / 0.9, 1e-9);
  EXPECT_NEAR(message.acceleration, 0.25 * 8 / 0.9, 1e-9);
}

TEST(UrMoves, BlendsNeverOverlap) {
  const ForwardMove next = line_by(kFrom, {0, 0.1, -0.1});
  ForwardMove move = line_by(kFrom, {0, 0, -0.1});
  move.blend = 0.5;
  move.stops = false;
  const MoveMessage message = ur::message_of(move, kFrom, &next, frame());
  EXPECT_GT(message.blend, 0.04);
  EXPECT_LT(2 * message.blend, 0.1);
  EXPECT_EQ(ur::message_of(move, kFrom, nullptr, frame()).blend, 0) << "nothing follows";
}

TEST(UrMoves, ALineIsAsSlowAsItsSlowestJointNeeds) {
  const ForwardMove usual = line_by(kFrom, {0, 0, -0.1});
  EXPECT_EQ(ur::message_of(usual, kFrom, nullptr, frame()).speed, 0.25);
  ForwardMove fast = usual;
  fast.speed = 50;
  const double speed = ur::message_of(fast, kFrom, nullptr, frame()).speed;
  EXPECT_LT(speed, 5);
  EXPECT_GT(speed, 0.5);
}

TEST(UrMoves, ALineThatOnlyTurnsHasATime) {
  ur::Six to = kFrom;
  to[5] += 0.5;
  ForwardMove move = joint_move(to);
  move.kind = ForwardMove::Kind::line;
  move.speed = 0;
  move.duration = 1.5;
  const MoveMessage message = ur::message_of(move, kFrom, nullptr, frame());
  EXPECT_EQ(message.work, Work::line);
  EXPECT_EQ(message.time, 1.5);
}

TEST(UrMoves, TheProgramHasNoGapsAndReadsWhatIsSent) {
  ur::ScriptSettings settings;
  settings.host = "10.0.0.2";
  settings.port = 50100;
  const std::string text = ur::move_program_text(settings);
  EXPECT_EQ(text.find('{'), std::string::npos) << text;
  EXPECT_NE(text.find("socket_open(\"10.0.0.2\", 50100, \"polyarm_moves\")"), std::string::npos);
  EXPECT_NE(text.find("socket_read_binary_integer(20, "), std::string::npos);
  const std::size_t queue = text.find("queue = ["), end = text.find(']', queue);
  EXPECT_EQ(std::count(text.begin() + static_cast<std::ptrdiff_t>(queue),
                       text.begin() + static_cast<std::ptrdiff_t>(end), ','),
            18 * static_cast<int>(ur::kMoveSlots) - 1);
  EXPECT_NE(ur::program_text(settings).find("polyarm_stream"), std::string::npos);
}

TEST(UrMoves, AHaltThatTheProgramDoesNotConfirmIsNoticed) {
  ur::MoveQueue queue(frame(), ur::kMoveSlots);
  ur::MoveReport report;
  report.q = kFrom;
  queue.begin(report);
  const auto pass = [&](double seconds) {
    for (const double end = report.time + seconds; report.time < end; report.time += 0.002) {
      queue.take(report);
      queue.next();
    }
  };
  queue.set_pace(1);
  pass(0.2);
  ur::Six to = kFrom;
  to[0] += 0.5;
  ASSERT_TRUE(queue.accept(joint_move(to)));
  pass(0.1);
  queue.set_pace(0);
  pass(10);
  EXPECT_FALSE(queue.awaits_halt_too_long());
  EXPECT_FALSE(queue.flow().standing) << "nobody has confirmed it";
  pass(10);
  EXPECT_TRUE(queue.awaits_halt_too_long());
  report.halted = 1;
  pass(0.1);
  EXPECT_FALSE(queue.awaits_halt_too_long());
  EXPECT_TRUE(queue.flow().standing);
}

/// Whatever a program sends, the simulated controller goes on, and its joints are numbers.
TEST(UrMoves, NoMessageBreaksTheSimulatedController) {
  ur::MachineOptions options;
  options.facts = ur::facts_of(ur_model());
  options.start = kFrom;
  ur::Machine machine(options);
  ur::FarMoves moves(machine);
  Draw draw(11);
  const auto value = [&](double most) { return most * (static_cast<double>(draw(20001)) - 10000) / 10000; };
  for (int i = 0; i < 4000; ++i) {
    std::array<std::uint8_t, ur::kMoveBytes> bytes;
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(draw(256));
    MoveMessage message = ur::decode_move(bytes);
    if (draw(4) > 0) {
      message.work = static_cast<Work>(1 + draw(5));
      for (std::size_t j = 0; j < 6; ++j) {
        message.goal[j] = machine.q()[j] + value(draw(3) ? 0.3 : 7);
        message.via[j] = machine.q()[j] + value(0.3);
      }
      message.acceleration = value(12);
      message.speed = value(3);
      message.time = draw(4) ? 0 : value(1);
      message.blend = draw(2) ? 0 : value(0.2);
    }
    moves.take(message);
    for (std::uint32_t k = draw(30); k > 0; --k) {
      moves.step(0.002);
      machine.step(0.002);
    }
    for (const double q : machine.q()) ASSERT_TRUE(std::abs(q) < 100) << i;
    if (!machine.may_move()) machine.safety(ur::safety_normal);
  }
}

}  // namespace
}  // namespace polyarm
