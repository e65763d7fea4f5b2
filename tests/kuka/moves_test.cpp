/// Moves of the runtime as moves of KRL, our texts for them, and the simulated program that makes them.
#include <cmath>
#include <thread>

#include "drivers/kuka/krl.hpp"
#include "drivers/kuka/move_shape.hpp"
#include "polyarm/base/bounds.hpp"
#include "tests/kuka/forward_rig.hpp"

namespace polyarm {
namespace {

using namespace test;

/// A program of a session without a driver: the client of EthernetKRL alone.
class Session {
 public:
  Session() : far(far_options()), eki("127.0.0.1", far.eki_port(), 20'000'000'000) {
    far.hold_clock(true);
    eki.open();
  }
  kuka::EkiReply ask(kuka::EkiDo what, int number = 0, int value = 0,
                     const std::optional<kuka::EkiMove>& move = std::nullopt) {
    const auto reply = eki.ask(what, number, value, move);
    EXPECT_TRUE(reply);
    return reply.value_or(kuka::EkiReply{});
  }
  kuka::EkiMove turn(double degrees) {
    kuka::EkiMove out;
    out.kind = kuka::EkiMove::ptp;
    out.end = far.with([](kuka::Machine& m) { return m.q(); });
    out.end[0] += degrees;
    out.speed = out.acceleration = 50;
    return out;
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) far.step();
  }
  double axis() {
    return far.with([](kuka::Machine& m) { return m.q()[0]; });
  }
  void expect_standing(const char* when) {
    steps(200);
    const double at = axis();
    steps(300);
    EXPECT_NEAR(axis(), at, 1e-6) << when;
  }
  FarSide far;
  kuka::Eki eki;
};

/// As after `kill -9`: the socket closes while moves wait at the controller.
TEST(KukaForward, WhenTheConnectionEndsTheControllerStops) {
  Session session;
  ASSERT_EQ(session.ask(kuka::EkiDo::begin, 0, 5000).result, kuka::EkiResult::done);
  const int number = session.ask(kuka::EkiDo::state).state.session;
  for (int i = 1; i <= 3; ++i)
    ASSERT_EQ(session.ask(kuka::EkiDo::move, i, number, session.turn(i % 2 ? 120 : -20)).result,
              kuka::EkiResult::done);
  const double start = session.axis();
  session.steps(80);
  EXPECT_GT(std::abs(session.axis() - start), 5);
  session.eki.close();
  while (session.far.takes_moves()) std::this_thread::yield();
  session.expect_standing("closed");
  EXPECT_LT(std::abs(session.axis() - start), 110) << "not the end of the first move";
}

TEST(KukaForward, WithoutRequestsTheControllerStops) {
  Session session;
  session.ask(kuka::EkiDo::begin, 0, 200);
  const int number = session.ask(kuka::EkiDo::state).state.session;
  session.ask(kuka::EkiDo::move, 1, number, session.turn(100));
  const double start = session.axis();
  session.steps(40);
  EXPECT_TRUE(session.ask(kuka::EkiDo::state).state.moves);
  session.steps(100);
  session.expect_standing("silent");
  EXPECT_LT(std::abs(session.axis() - start), 90) << "not the end of the move";
  const kuka::EkiState state = session.ask(kuka::EkiDo::state).state;
  EXPECT_FALSE(state.moves);
  EXPECT_EQ(session.ask(kuka::EkiDo::move, 2, number, session.turn(10)).result, kuka::EkiResult::not_ready);
}

/// Moves of an earlier session are refused, and a program that was stopped is cancelled when its session
/// ends.
TEST(KukaForward, AStoppedProgramWhoseSessionEndsDoesNotGoOnAtStart) {
  Session session;
  session.ask(kuka::EkiDo::begin, 0, 5000);
  const int number = session.ask(kuka::EkiDo::state).state.session;
  session.ask(kuka::EkiDo::move, 1, number, session.turn(100));
  session.steps(100);
  session.far.order("stop");
  session.expect_standing("stopped");
  session.far.order("play");
  const double at = session.axis();
  session.steps(100);
  EXPECT_GT(session.axis(), at + 1) << "the session is open: the program goes on";
  session.far.order("stop");
  session.steps(50);
  session.ask(kuka::EkiDo::end);
  session.far.order("play");
  session.expect_standing("ended");
  EXPECT_EQ(session.ask(kuka::EkiDo::begin, 0, 5000).result, kuka::EkiResult::done);
  EXPECT_EQ(session.ask(kuka::EkiDo::move, 2, number, session.turn(10)).result, kuka::EkiResult::not_ready);
  session.expect_standing("begun");
}

TEST(KukaMoves, AMessageSurvivesTheWireAndDamageDoesNoHarm) {
  kuka::EkiRequest request{7, kuka::EkiDo::move, 42, 3, kuka::EkiMove{}};
  request.move->kind = kuka::EkiMove::circ;
  request.move->end = {500.1, -20, 300, -90, 0.5, 180};
  request.move->via = {480, 0, 350, -90, 0.5, 180};
  request.move->speed = 0.25, request.move->acceleration = 2.3, request.move->blend = 40;
  const std::string text = kuka::encode(request);
  EXPECT_LT(text.size(), bounds::kEkiMessageBytes / 4);
  const auto back = kuka::decode_request(text);
  ASSERT_TRUE(back && back->move);
  EXPECT_EQ(back->number, 42);
  EXPECT_EQ(back->move->kind, kuka::EkiMove::circ);
  EXPECT_EQ(back->move->end, request.move->end);
  EXPECT_EQ(back->move->via, request.move->via);
  EXPECT_EQ(back->move->blend, 40);
  for (const auto& [from, to] :
       std::initializer_list<std::pair<std::string, std::string>>{{"Kind=\"3\"", "Kind=\"4\""},
                                                                  {"Kind=\"3\"", "Kind=\"-1\""},
                                                                  {"P3=\"300.000000\"", "P3=\"nan\""},
                                                                  {"P3=\"300.000000\"", "P3=\"1e9\""},
                                                                  {"P3=\"300.000000\"", ""},
                                                                  {"Speed=\"0.250000\"", "Speed=\"-1\""}}) {
    std::string bad = text;
    ASSERT_NE(bad.find(from), std::string::npos) << from;
    bad.replace(bad.find(from), from.size(), to);
    EXPECT_FALSE(kuka::decode_request(bad)) << bad;
  }
}

/// What the controller gets for a joint move: whole per cents, and a share of half of the way as its blend.
TEST(KukaMoves, AJointMoveIsAPtpInPerCent) {
  forward::MoveFrame frame;
  frame.flange = std::make_shared<const kinematics::Chain>(kuka_chain());
  frame.velocity.fill(5);
  frame.acceleration.fill(10);
  forward::MoveOrder order;
  order.kind = forward::MoveOrder::Kind::move;
  order.from = {0.3, -1.2, 1.1, 0.1, 0.8, 0.4};
  Six to = order.from;
  to[0] += 0.5;
  std::copy(to.begin(), to.end(), order.move.joints.begin());
  order.move.at = kuka_chain().forward(to);
  order.move.share = 0.559;
  order.move.acceleration = 0.4;
  kuka::EkiMove move = kuka::eki_move(order, frame);
  EXPECT_EQ(move.kind, kuka::EkiMove::ptp);
  EXPECT_EQ(move.speed, 55);
  EXPECT_EQ(move.acceleration, 40);
  EXPECT_EQ(move.blend, 0);
  EXPECT_NEAR(move.end[0], 0.8 / kDegree, 1e-9);
  order.move.stops = false;
  order.move.blend = 0.03;
  order.next = order.move;
  order.next->at.position.z += 0.2;
  move = kuka::eki_move(order, frame);
  const double radius = std::hypot(order.move.at.position.x, order.move.at.position.y);
  EXPECT_NEAR(move.blend, 200 * 0.03 / (0.5 * radius), 0.1);
}

TEST(KukaMoves, FramesTurnAboutZThenYThenX) {
  const Pose pose{{0.5, -0.02, 0.3}, from_rpy(0.3, -0.4, 0.5)};
  const Six frame = kuka::frame_of(pose);
  EXPECT_NEAR(frame[0], 500, 1e-9);
  EXPECT_NEAR(frame[3], 0.5 / kDegree, 1e-9);
  EXPECT_NEAR(frame[4], -0.4 / kDegree, 1e-9);
  EXPECT_NEAR(frame[5], 0.3 / kDegree, 1e-9);
  EXPECT_LT(angle_between(kuka::pose_of(frame).rotation, pose.rotation), 1e-12);
}

/// The configuration receives each element of a move that the program reads, and the program reads each.
TEST(KukaMoves, TheProgramReadsEachElementOfAMove) {
  const auto files = kuka::krl_files({});
  const auto file = [&](const std::string& name) {
    for (const auto& one : files)
      if (one.name == name) return one.text;
    ADD_FAILURE() << name;
    return std::string();
  };
  const std::string configuration = file("PolyarmEki.xml"), program = file("PolyarmEki.src");
  const std::string text = kuka::encode(kuka::EkiRequest{1, kuka::EkiDo::move, 1, 1, kuka::EkiMove{}});
  std::size_t tags = 0;
  const std::string begin = "Tag=\"Polyarm/Move/@";
  for (std::size_t at = 0; (at = configuration.find(begin, at)) != std::string::npos; ++at, ++tags) {
    const std::size_t from = at + begin.size();
    const std::string name = configuration.substr(from, configuration.find('"', from) - from);
    EXPECT_NE(program.find("\"Polyarm/Move/@" + name + "\""), std::string::npos) << name << " is never read";
    EXPECT_NE(text.find(" " + name + "=\""), std::string::npos) << name << " is never sent";
  }
  EXPECT_EQ(tags, 17u);
  const std::string moves = file("PolyarmMoves.src"), data = file("PolyarmEki.dat");
  for (const char* name :
       {"POLYARM_OPEN", "POLYARM_RUNS", "POLYARM_TAKEN", "POLYARM_BLEND", "POLYARM_AXES"}) {
    EXPECT_NE(moves.find(name), std::string::npos) << name;
    EXPECT_NE(data.find(name), std::string::npos) << name << " is not declared";
  }
}

/// Whatever a client sends, the simulated controller goes on, and its axes are numbers.
TEST(KukaMoves, NoMessageBreaksTheSimulatedController) {
  kuka::Machine machine(far_options().machine);
  kuka::FarMoves moves(machine);
  Draw draw(12);
  const auto value = [&](double most) { return most * (static_cast<double>(draw(20001)) - 10000) / 10000; };
  for (int i = 0; i < 3000; ++i) {
    if (draw(20) == 0) moves.begin(static_cast<int>(draw(500)));
    kuka::EkiState state;
    moves.fill(state);
    kuka::EkiRequest request{i, kuka::EkiDo::move, i, state.session, kuka::EkiMove{}};
    kuka::EkiMove& move = *request.move;
    move.kind = static_cast<kuka::EkiMove::Kind>(draw(4));
    const Six frame =
        move.kind == kuka::EkiMove::ptp ? machine.q() : kuka::frame_of(kuka_chain().forward([&] {
          Six q = machine.q();
          for (double& one : q) one *= kDegree;
          return q;
        }()));
    for (std::size_t j = 0; j < 6; ++j) {
      move.end[j] = frame[j] + value(draw(4) ? 30 : 1e5);
      move.via[j] = frame[j] + value(100);
    }
    move.speed = std::abs(value(draw(3) ? 100 : 1e5));
    move.acceleration = std::abs(value(100));
    move.turn = draw(2) ? 0 : std::abs(value(300));
    move.blend = draw(2) ? 0 : std::abs(value(100));
    moves.hear();
    moves.take(request);
    if (draw(30) == 0) moves.halt(state.session, i);
    if (draw(60) == 0) moves.end();
    for (std::uint32_t k = draw(30); k > 0; --k) {
      moves.step(0.004);
      machine.step();
    }
    for (const double q : machine.q()) ASSERT_TRUE(std::abs(q) < 1000) << i;
    machine.acknowledge();
  }
}

}  // namespace
}  // namespace polyarm
