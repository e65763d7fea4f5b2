/// Moves of the runtime as moves of our RAPID program, its messages and its text, and the simulated program.
#include <algorithm>
#include <cmath>
#include <random>
#include <regex>
#include <set>
#include <thread>

#include "drivers/abb/rapid.hpp"
#include "tests/abb/forward_rig.hpp"
#include "tests/support/damaged.hpp"

namespace polyarm {
namespace {

using namespace abb;
using namespace test;

/// A program of a session without a driver: the client of the program alone.
class Session {
 public:
  Session() : far(options()), port("127.0.0.1", far.moves_port()) {
    far.hold_clock(true);
    far.with([](Machine& m) { return m.start_program(); });
    port.open(20'000'000'000);
  }
  MoveReply ask(MoveDo what, int number = 0, int value = 0, const RapidMove& move = {}) {
    EXPECT_TRUE(port.send({0, what, number, value, move, {}}));
    const auto reply = port.await_reply(20'000'000'000);
    EXPECT_TRUE(reply);
    return reply.value_or(MoveReply{});
  }
  RapidMove turn(double degrees) {
    RapidMove out;
    out.kind = RapidMove::joints;
    const Six q = far.with([](Machine& m) { return m.q(); });
    std::copy(q.begin(), q.end(), out.end.begin());
    out.end[0] += degrees;
    out.end[6] = 0;
    out.time = 2;
    out.acceleration = 50;
    return out;
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) far.step();
  }
  double joint() {
    return far.with([](Machine& m) { return m.q()[0]; });
  }
  void expect_rest(const char* when) {
    steps(300);
    const double at = joint();
    steps(300);
    EXPECT_NEAR(joint(), at, 1e-6) << when;
  }
  static FarSideOptions options() {
    FarSideOptions out = far_options();
    out.machine.modules = {kMovesModule};
    return out;
  }
  FarSide far;
  MovePort port;
};

/// As after `kill -9`: the socket closes while moves wait at the controller.
TEST(AbbMoves, WhenTheConnectionEndsTheProgramStopsTheRobot) {
  Session session;
  const int number = session.ask(MoveDo::begin, 0, 5000).session;
  ASSERT_GT(number, 0);
  for (int i = 1; i <= 3; ++i)
    ASSERT_EQ(session.ask(MoveDo::move, i, number, session.turn(i % 2 ? 100 : -20)).result, MoveResult::done);
  const double start = session.joint();
  session.steps(120);
  EXPECT_GT(std::abs(session.joint() - start), 5);
  session.port.close();
  while (session.far.takes_moves()) std::this_thread::yield();
  session.expect_rest("closed");
  EXPECT_LT(std::abs(session.joint() - start), 90) << "not the end of the first move";
}

TEST(AbbMoves, WithoutRequestsTheProgramStopsTheRobotAndEndsTheSession) {
  Session session;
  const int number = session.ask(MoveDo::begin, 0, 200).session;
  session.ask(MoveDo::move, 1, number, session.turn(100));
  const double start = session.joint();
  session.steps(40);
  EXPECT_EQ(session.ask(MoveDo::state).session, number);
  session.steps(60);
  session.expect_rest("silent");
  EXPECT_GT(std::abs(session.joint() - start), 1);
  EXPECT_LT(std::abs(session.joint() - start), 90) << "not the end of the move";
  EXPECT_EQ(session.ask(MoveDo::state).session, 0);
  EXPECT_EQ(session.ask(MoveDo::move, 2, number, session.turn(10)).result, MoveResult::no_session);
}

/// ExitCycle ends a program that was started for a single cycle.
TEST(AbbMoves, AHaltEndsAProgramThatWasStartedForOneCycle) {
  for (const bool once : {false, true}) {
    Session session;
    session.far.order("stop");
    session.far.with([&](Machine& m) { return m.reset_pointer(), m.start_program(once); });
    const int number = session.ask(MoveDo::begin, 0, 8000).session;
    session.ask(MoveDo::move, 1, number, session.turn(100));
    session.steps(120);
    session.ask(MoveDo::halt, 1, number);
    session.expect_rest("halted");
    EXPECT_EQ(session.far.with([](Machine& m) { return m.program_runs(); }), !once);
  }
}

/// Its main may begin again for as long as the driver wants moves. EGM's runs once.
TEST(AbbMoves, TheDriverStartsTheProgramForAnyNumberOfCycles) {
  for (const int version : {1, 2}) {
    ForwardRig rig(Parameters{{"rws", std::to_string(version)}});
    ASSERT_TRUE(begins(rig));
    EXPECT_FALSE(rig.far().with([](Machine& m) { return m.runs_once(); })) << version;
    AbbRig stream(Parameters{{"rws", std::to_string(version)}});
    ASSERT_TRUE(stream.start());
    EXPECT_TRUE(stream.far().with([](Machine& m) { return m.runs_once(); })) << version;
  }
}

/// A stopped program goes on with its path at Start; behind a new start of main nothing is left.
TEST(AbbMoves, AProgramThatBeginsAtItsMainHasNoMoves) {
  Session session;
  const int number = session.ask(MoveDo::begin, 0, 8000).session;
  session.ask(MoveDo::move, 1, number, session.turn(100));
  session.steps(120);
  session.far.order("stop");
  session.expect_rest("stopped");
  const double at = session.joint();
  session.far.order("play");
  session.steps(60);
  EXPECT_GT(session.joint(), at + 1) << "the session is open: the program goes on";
  session.far.order("stop");
  session.steps(60);
  session.far.with([](Machine& m) { return m.reset_pointer(); });
  session.far.order("play");
  session.expect_rest("began at main");
  EXPECT_EQ(session.ask(MoveDo::move, 2, number, session.turn(10)).result, MoveResult::no_session);
}

TEST(AbbMoves, ASecondClientWaitsUntilTheFirstOneIsGone) {
  Session session;
  session.ask(MoveDo::begin, 0, 5000);
  MovePort other("127.0.0.1", session.far.moves_port());
  ASSERT_TRUE(other.open(20'000'000'000));
  ASSERT_TRUE(other.send({}));
  EXPECT_FALSE(other.await_reply(50'000'000));
  session.port.close();
  EXPECT_TRUE(other.await_reply(20'000'000'000));
}

MoveRequest arc_request() {
  MoveRequest out{7, MoveDo::move, 42, 3, {}, {}};
  out.move.kind = RapidMove::arc;
  out.move.end = {500.25, -20, 300, 0.5, 0.5, -0.5, 0.5};
  out.move.via = {480, 0, 350};
  out.move.speed = 250, out.move.turn = 1000, out.move.acceleration = 2, out.move.zone = 40;
  return out;
}

TEST(AbbMoveMessages, HaveTheirLayoutInBothDirections) {
  const auto request = encode(arc_request());
  ASSERT_EQ(request.size(), kMoveRequestBytes);
  // By hand: the version, the id, what, number, session, kind; then x of the end, 500.25.
  const std::vector<std::uint8_t> begin{0, 0,  0, 1, 0, 0, 0, 7, 0, 0, 0,    2,    0,    0,
                                        0, 42, 0, 0, 0, 3, 0, 0, 0, 3, 0x43, 0xFA, 0x20, 0};
  EXPECT_TRUE(std::equal(begin.begin(), begin.end(), request.begin()));
  const auto back = decode_move_request(request);
  ASSERT_TRUE(back);
  EXPECT_EQ(encode(*back), request);
  EXPECT_EQ(back->move.end, arc_request().move.end);
  EXPECT_EQ(back->move.via, arc_request().move.via);
  EXPECT_EQ(back->move.zone, 40);
  MoveReply reply;
  reply.id = 7, reply.session = 3, reply.ended = 41, reply.halted = 2, reply.time_ms = 999'999;
  reply.joints = {1, -2, 0.5, 0, 90, 180};
  const auto bytes = encode(reply);
  ASSERT_EQ(bytes.size(), kMoveReplyBytes);
  const auto read = decode_move_reply(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(encode(*read), bytes);
  EXPECT_EQ(read->ended, 41);
  EXPECT_EQ(read->joints, reply.joints);
}

TEST(AbbMoveMessages, DamagedOnesAreRefusedOrHaveNumbersInTheirRange) {
  std::mt19937 draw(5);
  MoveReply reply;
  reply.joints = {1, -2, 0.5, 0, 90, 180};
  int requests = 0, replies = 0;
  for (int i = 0; i < 200'000; ++i) {
    auto bytes = i % 2 ? encode(arc_request()) : encode(reply);
    for (std::uint32_t k = draw() % 4; k > 0; --k)
      bytes[draw() % bytes.size()] = static_cast<std::uint8_t>(draw());
    if (draw() % 10 == 0) bytes.resize(draw() % 120);
    if (const auto one = decode_move_request(bytes)) {
      ++requests;
      for (const double value : one->move.end) ASSERT_LE(std::abs(value), 1e5);
      for (const double value : one->move.via) ASSERT_LE(std::abs(value), 1e5);
      for (const double value : {one->move.time, one->move.speed, one->move.zone, one->load.mass})
        ASSERT_TRUE(value >= 0 && value <= 1e5);
    }
    if (const auto one = decode_move_reply(bytes)) {
      ++replies;
      for (const double value : one->joints) ASSERT_LE(std::abs(value), 36'000);
      ASSERT_TRUE(one->time_ms >= 0 && one->time_ms <= kMovesClock);
      ASSERT_LE(one->result, MoveResult::busy);
    }
  }
  EXPECT_GT(requests, 1000);
  EXPECT_GT(replies, 1000);
}

forward::MoveFrame frame_of_irb() {
  forward::MoveFrame out;
  out.flange = std::make_shared<const kinematics::Chain>(abb_chain());
  out.velocity.fill(4);
  out.acceleration.fill(10);
  return out;
}

TEST(AbbMoves, AJointMoveHasItsAnglesAndItsTime) {
  forward::MoveOrder order;
  order.from = {0.3, 0.2, -0.1, 0.1, 0.8, 0.4};
  Six to = order.from;
  to[0] += 1;
  std::copy(to.begin(), to.end(), order.move.joints.begin());
  order.move.at = abb_chain().forward(to);
  order.move.share = 0.5;
  order.move.acceleration = 0.5;
  RapidMove move = rapid_move(order, frame_of_irb());
  EXPECT_EQ(move.kind, RapidMove::joints);
  EXPECT_NEAR(move.end[0], 1.3 / kDegree, 1e-9);
  EXPECT_NEAR(move.time, 1 / 2.0 + 2.0 / 5, 1e-9) << "at half the speed and half the acceleration";
  EXPECT_EQ(move.acceleration, 50);
  EXPECT_EQ(move.zone, 0);
  order.move.stops = false;
  order.move.blend = 0.03;
  order.next = order.move;
  order.next->at.position.z += 0.2;
  EXPECT_NEAR(rapid_move(order, frame_of_irb()).zone, 30, 1e-9);
}

TEST(AbbMoves, ALineHasTheTcpInTheBaseOfTheRobot) {
  forward::MoveFrame frame = frame_of_irb();
  frame.base = {{1, 2, 0.5}, from_rpy(0, 0, 1.5)};
  forward::MoveOrder order;
  order.from = {0.3, 0.2, -0.1, 0.1, 0.8, 0.4};
  Pose at = abb_chain().forward(order.from);
  at.position.z += 0.05;
  const auto jacobian = [](const Six& one, std::array<double, 36>& J) {
    return abb_chain().jacobian(one, J);
  };
  const Six to = *forward::near_joints(jacobian, at, order.from);
  std::copy(to.begin(), to.end(), order.move.joints.begin());
  order.move.kind = hardware::ForwardMove::Kind::line;
  order.move.at = frame.base * at;
  order.move.speed = 0.2;
  const RapidMove move = rapid_move(order, frame);
  EXPECT_EQ(move.kind, RapidMove::line);
  EXPECT_NEAR(move.end[0], 1000 * at.position.x, 1e-6);
  EXPECT_NEAR(move.end[2], 1000 * at.position.z, 1e-6);
  EXPECT_NEAR(std::abs(move.end[3]), std::abs(at.rotation.w), 1e-9);
  EXPECT_NEAR(move.speed, 200, 1e-6);
}

/// MoveC refuses a point near the end, and a rest that is too short.
TEST(AbbMoves, ThePointOfAnArcIsInItsMiddleAndAShortRestIsALine) {
  const forward::MoveFrame frame = frame_of_irb();
  const auto jacobian = [](const Six& one, std::array<double, 36>& J) {
    return abb_chain().jacobian(one, J);
  };
  forward::MoveOrder order;
  order.from = {0.3, 0.2, -0.1, 0.1, 0.8, 0.4};
  const Pose begin = abb_chain().forward(order.from);
  const auto on_circle = [&](double angle) {  // radius 0.05, upwards first
    Pose out = begin;
    out.position = begin.position + 0.05 * Vec3{0, std::cos(angle) - 1, std::sin(angle)};
    return out;
  };
  const auto joints_on = [&](double angle) {
    return *forward::near_joints(jacobian, on_circle(angle), order.from);
  };
  const Six to = joints_on(M_PI);
  std::copy(to.begin(), to.end(), order.move.joints.begin());
  order.move.kind = hardware::ForwardMove::Kind::arc;
  order.move.at = on_circle(M_PI);
  order.move.via = on_circle(M_PI - 0.01);
  order.move.speed = 0.1;
  const RapidMove move = rapid_move(order, frame);
  ASSERT_EQ(move.kind, RapidMove::arc);
  EXPECT_NEAR(move.angle, 180, 1e-3);
  const Vec3 middle = on_circle(M_PI / 2).position;
  EXPECT_NEAR(move.via[1], 1000 * middle.y, 1e-3);
  EXPECT_NEAR(move.via[2], 1000 * middle.z, 1e-3);
  for (const double left : {0.05, 0.2}) {
    hardware::ForwardMove rest = order.move;
    shorten_arc(rest, order.from, joints_on(M_PI - left), frame);
    EXPECT_EQ(rest.kind == hardware::ForwardMove::Kind::arc, left > 0.1);
  }
}

/// RAPID does not tell capitals from small letters.
TEST(AbbRapidMoves, NamesAreDeclaredOnceAndBlocksAreClosed) {
  const std::string text = rapid_moves_module("192.168.125.1", 54700);
  EXPECT_EQ(text.find('@'), std::string::npos) << "a place that is not filled";
  std::set<std::string> names;
  const std::regex global(R"(\n  LOCAL (?:VAR|CONST|PERS|PROC|TRAP|FUNC)(?: [a-z]+)? ([A-Za-z_]+))");
  for (std::sregex_iterator i(text.begin(), text.end(), global), end; i != end; ++i) {
    std::string name = (*i)[1];
    std::transform(name.begin(), name.end(), name.begin(), ::tolower);
    EXPECT_TRUE(names.insert(name).second) << name;
  }
  EXPECT_GT(names.size(), 50u);
  const auto count = [&](const std::string& word) {
    const std::regex lines("\n *(?:LOCAL )?" + word + "\\b");
    return std::distance(std::sregex_iterator(text.begin(), text.end(), lines), std::sregex_iterator());
  };
  for (const char* block : {"PROC", "TRAP", "FUNC", "WHILE", "FOR"})
    EXPECT_EQ(count(block), count(std::string("END") + block)) << block;
  const std::regex ifs("\n *IF [^\n]* THEN(?=\n)");
  EXPECT_EQ(std::distance(std::sregex_iterator(text.begin(), text.end(), ifs), std::sregex_iterator()),
            count("ENDIF"));
}

/// As the runtime plans it: without this, the tool turns with the circle.
TEST(AbbRapidMoves, ArcsTurnTheToolInTheObjectFrame) {
  const std::string text = rapid_moves_module("192.168.125.1", 54700);
  const std::size_t main = text.find("PROC main()"), end = text.find("ENDPROC", main);
  EXPECT_LT(text.find("CirPathMode \\ObjectFrame;", main), end);
}

/// It reads and writes each byte of the messages, and knows what can be asked for.
TEST(AbbRapidMoves, TheProgramReadsAndWritesEachByteOfTheMessages) {
  const std::string text = rapid_moves_module("192.168.125.1", 54700);
  EXPECT_NE(text.find("\"192.168.125.1\""), std::string::npos);
  EXPECT_NE(text.find("\\ReadNoOfBytes:=" + std::to_string(kMoveRequestBytes)), std::string::npos);
  const auto places = [&](const std::regex& line) {
    std::set<int> out;
    for (std::sregex_iterator i(text.begin(), text.end(), line), end; i != end; ++i)
      EXPECT_TRUE(out.insert(std::stoi((*i)[1])).second);
    return out;
  };
  const auto read = places(std::regex(R"(UnpackRawBytes request \\Network, (\d+), )"));
  const auto written = places(std::regex(R"(PackRawBytes [^\n]*, reply \\Network, (\d+) )"));
  EXPECT_EQ(4 * read.size(), kMoveRequestBytes);
  EXPECT_EQ(*read.rbegin(), static_cast<int>(kMoveRequestBytes) - 3);
  EXPECT_EQ(4 * written.size(), kMoveReplyBytes);
  EXPECT_EQ(*written.rbegin(), static_cast<int>(kMoveReplyBytes) - 3);
}

/// Whatever a client sends, the simulated controller goes on, and its joints are numbers.
TEST(AbbMoves, NoMessageBreaksTheSimulatedController) {
  Machine machine(Session::options().machine);
  machine.start_program();
  const MoveFaults faults;
  FarMoves moves(machine, faults);
  Draw draw(12);
  const auto value = [&](double most) { return most * (static_cast<double>(draw(20001)) - 10000) / 10000; };
  for (int i = 1; i < 3000; ++i) {
    if (draw(20) == 0) moves.carry_out({i, MoveDo::begin, 0, static_cast<int>(draw(500)), {}, {}});
    const int session = moves.carry_out({i, MoveDo::state, 0, 0, {}, {}}).session;
    RapidMove move;
    move.kind = static_cast<RapidMove::Kind>(draw(4));
    move.end = move.kind == RapidMove::joints ? Frame{} : abb::frame_of(machine.tool0());
    for (std::size_t j = 0; j < 6; ++j)
      if (move.kind == RapidMove::joints) move.end[j] = machine.q()[j] + value(draw(4) ? 30 : 1e5);
    for (std::size_t j = 0; j < 3; ++j) {
      if (move.kind != RapidMove::joints) move.end[j] += value(draw(4) ? 50 : 1e5);
      move.via[j] = move.end[j] + value(100);
    }
    move.time = std::abs(value(3)), move.speed = std::abs(value(draw(3) ? 500 : 1e5));
    move.turn = std::abs(value(1200)), move.acceleration = std::abs(value(100));
    move.zone = draw(2) ? 0 : std::abs(value(100));
    moves.carry_out({i, MoveDo::move, i, session, move, {}});
    if (draw(30) == 0) moves.carry_out({i, MoveDo::halt, i, session, {}, {}});
    if (draw(30) == 0) moves.carry_out({i, MoveDo::pace, static_cast<int>(draw(200)), session, {}, {}});
    if (draw(60) == 0) moves.carry_out({i, MoveDo::end, 0, 0, {}, {}});
    for (std::uint32_t k = draw(30); k > 0; --k) {
      moves.step(0.004);
      machine.step(0.004);
    }
    for (const double q : machine.q()) ASSERT_TRUE(std::abs(q) < 1000) << i;
    if (machine.program_runs()) continue;
    machine.reset_pointer();
    machine.start_program();
    moves.restart();
  }
}

}  // namespace
}  // namespace polyarm
