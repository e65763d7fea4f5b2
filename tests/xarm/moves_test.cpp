/// Moves of the runtime as moves of a controller of UFACTORY, and the simulated controller that makes them.
#include "drivers/xarm/moves.hpp"

#include <cmath>
#include <numbers>

#include "tests/xarm/forward_rig.hpp"

namespace polyarm {
namespace {

using namespace test;
using forward::MoveOrder;
using hardware::ForwardMove;
using xarm::Machine;
using xarm::Register;
using xarm::UxMove;
using xarm::UxMoveForms;

constexpr UxMoveForms kOld{}, kNew{true, true};

std::string hex_of(const xarm::UxMoveRequest& move) {
  std::string out;
  for (const std::uint8_t byte :
       xarm::encode(xarm::UxRequest{1, xarm::kPrivateProtocol, move.reg, move.data})) {
    constexpr const char* kDigits = "0123456789abcdef";
    out += kDigits[byte >> 4];
    out += kDigits[byte & 15];
  }
  return out.substr(12);  // without the head
}

UxMove joint_move() {
  UxMove out;
  out.joints = {0.1, -0.5, -0.6, 0.2, 1, -1.5, 0};
  out.speed = 0.5;
  out.acceleration = 10;
  return out;
}

UxMove line_move() {
  UxMove out;
  out.kind = UxMove::Kind::line;
  out.pose = {350.5, -200, 300.25, std::numbers::pi, 0, -0.5};
  out.via = {400, 0, 400, std::numbers::pi, 0, 0};
  out.speed = 250;
  out.acceleration = 2000;
  return out;
}

/// Recorded from xArm-Python-SDK 1.18.5.
TEST(XarmMoves, AreThoseOfTheMakersClient) {
  const std::string joints = "cdcccc3d000000bf9a9919bfcdcc4c3e0000803f0000c0bf000000000000003f00002041";
  const std::string pose = "0040af43000048c300209643db0f494000000000000000bf", speeds = "00007a430000fa44";
  UxMove joint = joint_move(), line = line_move();
  EXPECT_EQ(hex_of(encode(joint, kNew)), "17" + joints + "00000000");
  EXPECT_EQ(hex_of(encode(line, kOld)), "15" + pose + speeds + "00000000");
  EXPECT_EQ(hex_of(encode(line, kNew)), "15" + pose + speeds + "00000000" + "000080bf" + "000000");
  joint.radius = 25;
  line.radius = 40;
  EXPECT_EQ(hex_of(encode(joint, kNew)), "18" + joints + "0000c841");
  EXPECT_EQ(hex_of(encode(joint, kOld)), "17" + joints + "00000000") << "older firmware rounds none";
  EXPECT_EQ(hex_of(encode(line, kOld)), "16" + pose + speeds + "00000000" + "00002042");
  EXPECT_EQ(hex_of(encode(line, kNew)), "15" + pose + speeds + "00000000" + "00002042" + "000000");
  line.kind = UxMove::Kind::circle;
  line.percent = 30.5;
  const std::string via = "0000c843000000000000c843db0f49400000000000000000";
  EXPECT_EQ(hex_of(encode(line, kOld)), "1b" + via + pose + speeds + "00000000" + "0000f441");
  EXPECT_EQ(hex_of(encode(line, kNew)), "1b" + via + pose + speeds + "00000000" + "0000f441" + "000000");
}

TEST(XarmMoves, TheirFormsFollowTheFirmware) {
  const auto forms = [](int major, int minor, int revision) {
    xarm::Version version;
    version.major = major, version.minor = minor, version.revision = revision;
    return xarm::forms_of(version);
  };
  EXPECT_FALSE(forms(1, 5, 19).joint_radius);
  EXPECT_TRUE(forms(1, 5, 20).joint_radius);
  EXPECT_FALSE(forms(1, 11, 99).general);
  EXPECT_TRUE(forms(1, 11, 100).general);
  EXPECT_TRUE(forms(2, 0, 0).general && forms(2, 0, 0).joint_radius);
}

TEST(XarmMoves, ComeBackFromTheirBytesAndOthersAreNone) {
  UxMove circle = line_move();
  circle.kind = UxMove::Kind::circle;
  circle.percent = 30.5;
  UxMove rounded = line_move();
  rounded.radius = 40;
  for (const UxMoveForms& forms : {kOld, kNew})
    for (const UxMove& move : {joint_move(), line_move(), rounded, circle}) {
      const auto request = encode(move, forms);
      const auto back = xarm::decode_move(request.reg, request.data);
      ASSERT_TRUE(back);
      EXPECT_EQ(back->kind, move.kind);
      EXPECT_NEAR(back->speed, move.speed, 1e-3);
      EXPECT_NEAR(back->radius, move.radius, 1e-3);
      for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_NEAR(back->joints[i], move.joints[i], 1e-6);
        EXPECT_NEAR(back->pose[i], move.pose[i], 1e-4);
      }
      for (std::size_t cut = 1; cut < request.data.size(); cut += 5) {
        std::vector<std::uint8_t> shorter(request.data.begin(),
                                          request.data.end() - static_cast<std::ptrdiff_t>(cut));
        xarm::decode_move(request.reg, shorter);  // whatever it is, it is read within its bytes
      }
    }
  auto line = encode(line_move(), kNew);
  line.data[40] = 1;
  EXPECT_FALSE(xarm::decode_move(line.reg, line.data)) << "in coordinates of the tool";
  auto broken = encode(joint_move(), kNew);
  broken.data[2] = broken.data[3] = 0xFF;
  EXPECT_FALSE(xarm::decode_move(broken.reg, broken.data)) << "not a number";
  EXPECT_FALSE(xarm::decode_move(Register::set_state, line.data));
}

forward::MoveFrame xarm_frame() {
  forward::MoveFrame out;
  out.flange = std::make_shared<const kinematics::Chain>(xarm_chain());
  out.velocity.fill(3);
  out.acceleration.fill(10);
  return out;
}

MoveOrder order_to(const Six& to) {
  MoveOrder out;
  out.kind = MoveOrder::Kind::move;
  out.from = {0.3, -0.5, -0.6, 0.1, 0.8, 0.4};
  std::copy(to.begin(), to.end(), out.move.joints.begin());
  out.move.at = xarm_chain().forward(to);
  return out;
}

/// The joint that turns most sets the speed, and no joint exceeds its share.
TEST(XarmMoves, AJointMoveHasTheSpeedOfItsLargestTurn) {
  forward::MoveFrame frame = xarm_frame();
  frame.velocity[1] = 1;
  MoveOrder order = order_to({1.3, 0, -0.6, 0.1, 0.8, 0.4});  // by 1 and by 0.5 rad
  order.move.share = 0.5;
  order.move.acceleration = 0.4;
  UxMove move = xarm::ux_move(order, frame);
  EXPECT_EQ(move.kind, UxMove::Kind::joint);
  EXPECT_NEAR(move.speed, 1, 1e-9) << "joint 2 has half of it";
  EXPECT_NEAR(move.acceleration, 4, 1e-9);
  EXPECT_LT(move.radius, 0);
  order.pace = 0.3;
  move = xarm::ux_move(order, frame);
  EXPECT_NEAR(move.speed, 0.3, 1e-9);
  order.pace = 1;
  order.move.share = 1;
  frame.velocity.fill(30);
  EXPECT_NEAR(xarm::ux_move(order, frame).speed, std::numbers::pi, 1e-9) << "the most that the maker takes";
}

TEST(XarmMoves, ACircleHasTheShareOfItsArc) {
  const forward::MoveFrame frame = xarm_frame();
  MoveOrder order = order_to({0.3, -0.5, -0.6, 0.1, 0.8, 0.4});
  const Pose begin = order.move.at;
  order.move.kind = ForwardMove::Kind::arc;
  order.move.speed = 0.2;
  order.move.via = begin;
  order.move.via.position = begin.position + Vec3{0, -0.1, 0.1};
  order.move.at.position = begin.position + Vec3{0, -0.2, 0};
  const auto jacobian = [](const Six& q, std::array<double, 36>& J) { return xarm_chain().jacobian(q, J); };
  const auto end = forward::near_joints(jacobian, order.move.at, order.from);
  ASSERT_TRUE(end);
  std::copy(end->begin(), end->end(), order.move.joints.begin());
  const UxMove move = xarm::ux_move(order, frame);
  EXPECT_EQ(move.kind, UxMove::Kind::circle);
  EXPECT_NEAR(move.percent, 50, 1e-6);
  EXPECT_NEAR(move.pose[1], 1000 * (begin.position.y - 0.2), 1e-6);
  EXPECT_NEAR(move.via[2], 1000 * (begin.position.z + 0.1), 1e-6);
}

TEST(XarmMoves, NoCornerAtACircleIsRounded) {
  const forward::MoveFrame frame = xarm_frame();
  MoveOrder order = order_to({0.6, -0.5, -0.6, 0.1, 0.8, 0.4});
  order.move.stops = false;
  order.move.blend = 0.03;
  order.next = order.move;
  order.next->at.position.z += 0.2;
  EXPECT_NEAR(xarm::ux_move(order, frame).radius, 30, 1e-9);
  order.next->kind = ForwardMove::Kind::arc;
  EXPECT_LT(xarm::ux_move(order, frame).radius, 0);
}

xarm::UxReply put(Machine& machine, const UxMove& move) {
  const auto request = encode(move, kNew);
  return machine.answer({1, xarm::kPrivateProtocol, request.reg, request.data});
}

int cycles_to_stand(Machine& machine) {
  int cycles = 0;
  for (machine.step(); machine.state() == xarm::State::moving && cycles < 10'000; ++cycles) machine.step();
  return cycles;
}

/// A client of the maker's that sends one move with a radius waits for its end.
TEST(XarmMachine, AMoveWithARadiusAndNoneBehindItIsTheLastOne) {
  Machine machine(test::far_options().machine);
  UxMove move = joint_move();
  move.radius = 30;
  put(machine, move);
  EXPECT_LT(cycles_to_stand(machine), 5000);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(machine.q()[i] * kDegree, move.joints[i], 1e-5);
}

TEST(XarmMachine, ALineOutOfReachIsAnErrorAndNoJump) {
  Machine machine(test::far_options().machine);
  UxMove move = line_move();
  move.pose[0] = 3000;
  put(machine, move);
  cycles_to_stand(machine);
  EXPECT_EQ(machine.error(), 21);
  EXPECT_EQ(machine.largest_jump(), 0);
}

TEST(XarmMachine, AStopWhileItMovesEndsOnARampAndForgetsItsMoves) {
  Machine machine(test::far_options().machine);
  UxMove move = joint_move();
  move.joints[0] = 2;
  put(machine, move);
  for (int i = 0; i < 200; ++i) machine.step();
  machine.take_fastest();
  machine.set_state(4);
  EXPECT_EQ(machine.report().queued, 0);
  for (int i = 0; i < 20; ++i) machine.step();
  EXPECT_GT(machine.take_fastest(), 5) << "not at once";
  for (int i = 0; i < 200; ++i) machine.step();
  machine.take_fastest();
  machine.set_state(0);
  for (int i = 0; i < 200; ++i) machine.step();
  EXPECT_LT(machine.take_fastest(), 1e-6);
}

/// Whatever a client sends, the simulated controller goes on, and its joints are numbers.
TEST(XarmMachine, NoMoveBreaksTheSimulatedController) {
  Machine machine(test::far_options().machine);
  Draw draw(12);
  const auto value = [&](double most) { return most * (static_cast<double>(draw(20001)) - 10000) / 10000; };
  for (int i = 0; i < 3000; ++i) {
    UxMove move;
    move.kind = static_cast<UxMove::Kind>(draw(3));
    const auto q = machine.q();
    for (std::size_t j = 0; j < 6; ++j) move.joints[j] = q[j] * kDegree + value(draw(4) ? 0.5 : 100);
    for (std::size_t j = 0; j < 6; ++j) {
      move.pose[j] = machine.report().pose[j] + value(j < 3 ? (draw(4) ? 100 : 1e6) : 1);
      move.via[j] = machine.report().pose[j] + value(j < 3 ? 100 : 1);
    }
    move.speed = std::abs(value(draw(3) ? 300 : 1e6));
    move.acceleration = std::abs(value(draw(3) ? 3000 : 1e6));
    move.radius = draw(2) ? -1 : value(100);
    move.percent = value(200);
    put(machine, move);
    if (draw(20) == 0) machine.set_state(static_cast<int>(draw(6)));
    if (draw(60) == 0) machine.set_mode(static_cast<int>(draw(8)));
    if (draw(60) == 0) machine.push_by_hand({value(5)});
    for (std::uint32_t k = draw(30); k > 0; --k) machine.step();
    for (const double one : machine.q()) ASSERT_TRUE(std::abs(one) < 1000) << i;
    machine.answer({1, xarm::kPrivateProtocol, Register::clean_error, {}});
    if (draw(4) == 0) machine.set_mode(0), machine.set_state(0);
  }
}

}  // namespace
}  // namespace polyarm
