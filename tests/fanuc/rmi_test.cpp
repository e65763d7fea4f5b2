/// The Remote Motion Interface of the simulated controller: what a program on the network sees.
#include <thread>

#include "tests/fanuc/rig.hpp"

namespace polyarm {
namespace {

using namespace test;
using fanuc::RmiLine;
using fanuc::RmiMessage;
using fanuc::RmiSession;

constexpr Nanoseconds kTimeout = 10'000'000'000;

/// A program on the network, against a far side whose clock only the test moves.
class Remote {
 public:
  explicit Remote(FarSideOptions options = far_options()) : far(std::move(options)) {
    far.hold_clock(true);
    std::string why;
    int error = 0;
    EXPECT_TRUE(session.open("127.0.0.1", far.rmi_port(), "FRC_Connect", kTimeout, why, error))
        << why << error;
  }
  RmiMessage ask(const char* name) { return ask(name, RmiLine("Command", name)); }
  RmiMessage ask(const char* name, const RmiLine& line) {
    const auto answer = session.ask("Command", name, line, kTimeout);
    EXPECT_TRUE(answer) << name;
    return answer.value_or(RmiMessage{});
  }
  void initialize() {
    EXPECT_EQ(ask("FRC_Initialize", RmiLine("Command", "FRC_Initialize").number("GroupMask", 1)).error(), 0);
  }
  RmiLine joint_move(const Six& joints, const char* term = "FINE", double value = 0, double percent = 50) {
    const std::pair<const char*, double> group[] = {{"J1", joints[0]}, {"J2", joints[1]}, {"J3", joints[2]},
                                                    {"J4", joints[3]}, {"J5", joints[4]}, {"J6", joints[5]}};
    RmiLine out("Instruction", "FRC_JointMotionJRep");
    return out.number("SequenceID", ++sequence)
        .group("JointAngle", group)
        .text("SpeedType", "Percent")
        .number("Speed", percent)
        .text("TermType", term)
        .number("TermValue", value);
  }
  RmiLine line_move(const char* name, const std::array<double, 6>& pose, double speed,
                    const char* term = "FINE", double value = 0) {
    RmiLine out("Instruction", name);
    return out.number("SequenceID", ++sequence)
        .group("Position", group_of(pose))
        .text("SpeedType", "mmSec")
        .number("Speed", speed)
        .text("TermType", term)
        .number("TermValue", value);
  }
  std::vector<std::pair<const char*, double>> group_of(const std::array<double, 6>& p) {
    return {{"X", p[0]}, {"Y", p[1]}, {"Z", p[2]}, {"W", p[3]}, {"P", p[4]}, {"R", p[5]}};
  }
  /// Sends instructions, and waits until the controller has read them.
  void send(const std::vector<RmiLine>& lines) {
    for (const RmiLine& line : lines) EXPECT_TRUE(session.send(line));
    EXPECT_EQ(ask_in_background("FRC_GetStatus").name, "FRC_GetStatus");
  }
  /// Like ask(), and keeps what else arrives.
  RmiMessage ask_in_background(const char* name) {
    EXPECT_TRUE(session.send(RmiLine("Command", name)));
    RmiMessage out;
    while (out.name.empty() && wire::wait_readable(session.descriptor(), kTimeout))
      session.poll([&](const RmiMessage& m) {
        if (m.name == name)
          out = m;
        else
          arrived.push_back(m);
      });
    return out;
  }
  /// Moves the clock until so many instructions are done; returns the cycles.
  int run(std::uint64_t done, int most = 5000) {
    int cycles = 0;
    for (; far.instructions_done() < done && cycles < most; ++cycles) far.step();
    return cycles;
  }
  Six q() {
    return far.with([](fanuc::Machine& m) { return m.q(); });
  }
  std::array<double, 6> pose() {
    return far.with([](fanuc::Machine& m) { return fanuc::Machine::pose_values(m.flange(m.q())); });
  }

  FarSide far;
  RmiSession session;
  int sequence = 0;
  std::vector<RmiMessage> arrived;
};

TEST(RmiLines, AreBuiltAndReadAsTheInterfaceHasThem) {
  const std::pair<const char*, double> group[] = {{"J1", 1.5}, {"J2", -2}};
  const std::string line = RmiLine("Instruction", "FRC_X")
                               .number("SequenceID", 7)
                               .group("JointAngle", group)
                               .text("T", "a\"b")
                               .line();
  EXPECT_EQ(line,
            "{\"Instruction\":\"FRC_X\",\"SequenceID\":7,\"JointAngle\":{\"J1\":1.5,\"J2\":-2},\"T\":"
            "\"a\\\"b\"}\r\n");
  const auto message = fanuc::parse_rmi(line);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->kind, RmiMessage::Kind::instruction);
  EXPECT_EQ(message->number("JointAngle.J2"), -2);
  EXPECT_EQ(message->text("T"), "a\"b");
  EXPECT_EQ(message->whole("SequenceID", 0, 9), 7);
  EXPECT_FALSE(message->whole("SequenceID", 0, 6)) << "out of range";
  EXPECT_FALSE(message->whole("JointAngle.J1", 0, 6)) << "not whole";
}

TEST(RmiLines, TooDeepTooLongAndBrokenOnesAreRefused) {
  EXPECT_FALSE(fanuc::parse_rmi("[]"));
  EXPECT_FALSE(fanuc::parse_rmi("{\"a\":"));
  EXPECT_FALSE(fanuc::parse_rmi("{\"a\":1e999}"));
  EXPECT_FALSE(fanuc::parse_rmi("{\"a\":" + std::string(100'000, '[') + std::string(100'000, ']') + "}"));
  std::string nested = "1";
  for (std::size_t i = 0; i + 1 < bounds::kRmiNesting; ++i) nested = "{\"a\":" + nested + "}";
  EXPECT_TRUE(fanuc::parse_rmi(nested));
  EXPECT_FALSE(fanuc::parse_rmi("{\"a\":{\"a\":" + nested + "}}"));
  fanuc::RmiLines lines;
  const std::vector<std::uint8_t> much(bounds::kRmiLineBytes + 1, 'x');
  EXPECT_FALSE(lines.feed(much, [](auto) {}));
}

TEST(RmiLines, ComeWholeHoweverTheStreamIsCut) {
  const std::string text = "{\"Command\":\"A\"}\r\n\r\n{\"Command\":\"B\"}\n";
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    fanuc::RmiLines lines;
    std::string out;
    const auto feed = [&](std::string_view part) {
      return lines.feed({reinterpret_cast<const std::uint8_t*>(part.data()), part.size()},
                        [&](std::string_view line) { out += fanuc::parse_rmi(line)->name; });
    };
    EXPECT_TRUE(feed(text.substr(0, cut)) && feed(text.substr(cut)));
    EXPECT_EQ(out, "AB") << cut;
  }
}

TEST(FarRmi, TellsItsStateFramesAndPlaces) {
  Remote remote;
  const RmiMessage before = remote.ask("FRC_GetStatus");
  EXPECT_EQ(before.number("ServoReady"), 1);
  EXPECT_EQ(before.number("ProgramStatus"), 1);
  EXPECT_EQ(before.number("NextSequenceID"), 1);
  remote.initialize();
  EXPECT_EQ(remote.ask("FRC_GetStatus").number("ProgramStatus"), 0);
  const RmiMessage joints = remote.ask("FRC_ReadJointAngles");
  EXPECT_EQ(joints.number("JointAngle.J2"), 10);
  EXPECT_EQ(joints.number("JointAngle.J3"), -15) << "against the horizontal: -5 less 10";
  const std::array<double, 6> tool{0, 0, 100, 0, 0, 0};
  RmiLine write("Command", "FRC_WriteUToolData");
  write.number("ToolNumber", 2).group("Frame", remote.group_of(tool));
  EXPECT_EQ(remote.ask("FRC_WriteUToolData", write).error(), 0);
  RmiLine set("Command", "FRC_SetUFrameUTool");
  EXPECT_EQ(remote.ask("FRC_SetUFrameUTool", set.number("UFrameNumber", 0).number("UToolNumber", 2)).error(),
            0);
  const RmiMessage pose = remote.ask("FRC_ReadCartesianPosition");
  EXPECT_EQ(pose.number("Configuration.UToolNumber"), 2);
  const auto flange = remote.pose();
  const double off = std::hypot(pose.number("Position.X") - flange[0], pose.number("Position.Y") - flange[1],
                                pose.number("Position.Z") - flange[2]);
  EXPECT_NEAR(off, 100, 0.01) << "the tool's length";
  EXPECT_EQ(remote.ask("FRC_GetExtStatus").text("ControlMode"), "AUTO");
  EXPECT_EQ(remote.ask("FRC_ReadError").text("ErrorData"), "No Error");
  EXPECT_EQ(
      remote.ask("FRC_SetUFrameUTool", RmiLine("Command", "FRC_SetUFrameUTool").number("UToolNumber", 99))
          .error(),
      fanuc::kRmiFrameNumber);
  EXPECT_EQ(remote.ask("FRC_Nonsense").name, "Unknown");
}

TEST(FarRmi, WritesOutputsAndWaitsForInputs) {
  FarSideOptions options = far_options();
  Remote remote(options);
  remote.far.with([](fanuc::Machine& m) { return m.wire_output(3, 7), 0; });
  remote.initialize();
  RmiLine wait("Instruction", "FRC_WaitDIN");
  remote.send({wait.number("SequenceID", 1).number("PortNumber", 7).text("PortValue", "ON")});
  EXPECT_EQ(remote.run(1, 50), 50) << "the input is off";
  RmiLine write("Command", "FRC_WriteDOUT");
  EXPECT_EQ(remote.ask("FRC_WriteDOUT", write.number("PortNumber", 3).text("PortValue", "ON")).error(), 0);
  EXPECT_LT(remote.run(1, 50), 5);
  EXPECT_EQ(remote.ask("FRC_ReadDIN", RmiLine("Command", "FRC_ReadDIN").number("PortNumber", 7))
                .number("PortValue"),
            1);
  EXPECT_EQ(remote.ask("FRC_ReadDIN", RmiLine("Command", "FRC_ReadDIN").number("PortNumber", -1)).error(),
            fanuc::kRmiPort);
  RmiLine time("Instruction", "FRC_WaitTime");
  remote.send({time.number("SequenceID", 2).number("Time", 0.8)});
  EXPECT_NEAR(remote.run(2), 100, 2) << "0.8 s of 8 ms";
}

TEST(FarRmi, MovesJointsAndLinesToTheirEnd) {
  Remote remote;
  remote.initialize();
  remote.send({remote.joint_move({20, 5, -25, 10, -70, 0})});
  remote.run(1);
  EXPECT_NEAR(remote.q()[0], 20, 0.01);
  EXPECT_NEAR(remote.q()[2], -20, 0.01) << "its joint 3 is against the horizontal";
  auto target = remote.pose();
  target[1] += 150;
  target[5] += 20;
  const auto from = remote.pose();
  remote.send({remote.line_move("FRC_LinearMotion", target, 200)});
  double off = 0;
  while (remote.far.instructions_done() < 2) {
    remote.far.step();
    const auto at = remote.pose();
    off = std::max(off, std::hypot(at[0] - from[0], at[2] - from[2]));
  }
  EXPECT_LT(off, 0.2) << "mm from the line";
  const auto at = remote.pose();
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(at[i], target[i], 0.2) << i;
}

TEST(FarRmi, ACircleGoesThroughItsViaPoint) {
  Remote remote;
  remote.initialize();
  const auto from = remote.pose();
  auto via = from, to = from;
  via[1] += 80, via[2] += 80;
  to[2] += 160;
  RmiLine circle = remote.line_move("FRC_CircularMotion", to, 200);
  remote.send({circle.group("ViaPosition", remote.group_of(via))});
  double nearest = 1e9, widest = 0;
  while (remote.far.instructions_done() < 1) {
    remote.far.step();
    const auto at = remote.pose();
    nearest = std::min(nearest, std::hypot(at[0] - via[0], at[1] - via[1], at[2] - via[2]));
    widest = std::max(widest, std::abs(std::hypot(at[1] - from[1], at[2] - from[2] - 80) - 80));
  }
  EXPECT_LT(nearest, 2);
  EXPECT_LT(widest, 0.5) << "mm from the circle of 80 mm";
}

TEST(FarRmi, CntIsFasterThanFineAndNeverJumps) {
  int cycles[3] = {};
  for (int mode = 0; mode < 3; ++mode) {
    Remote remote;
    remote.initialize();
    const char* term = mode == 0 ? "FINE" : "CNT";
    const double value = mode == 2 ? 100 : 0;
    std::vector<RmiLine> lines;
    for (int i = 1; i <= 4; ++i)
      lines.push_back(remote.joint_move({10.0 + 5 * i, 10, -15, 0, -60, 20}, i == 4 ? "FINE" : term, value));
    remote.send(lines);
    remote.far.with([](fanuc::Machine& m) { return m.forget_jumps(), 0; });
    cycles[mode] = remote.run(4);
    EXPECT_NEAR(remote.q()[0], 30, 0.01);
    EXPECT_LT(remote.far.with([](fanuc::Machine& m) { return m.largest_jump(); }), 120 * 0.5 * 0.008 * 1.05);
  }
  EXPECT_LT(cycles[2], cycles[1]);
  EXPECT_LT(cycles[1], cycles[0]);
}

TEST(FarRmi, TheOverrideSlowsMotions) {
  int cycles[2] = {};
  for (int i = 0; i < 2; ++i) {
    Remote remote;
    remote.initialize();
    EXPECT_EQ(
        remote
            .ask("FRC_SetOverRide", RmiLine("Command", "FRC_SetOverRide").number("Value", i == 0 ? 100 : 50))
            .error(),
        0);
    remote.send({remote.joint_move({60, 10, -15, 0, -60, 20})});
    cycles[i] = remote.run(1);
  }
  EXPECT_NEAR(cycles[1], 2 * cycles[0], 40);
  Remote remote;
  EXPECT_EQ(remote.ask("FRC_SetOverRide", RmiLine("Command", "FRC_SetOverRide").number("Value", 0)).error(),
            fanuc::kRmiOverride);
}

TEST(FarRmi, PauseHoldsAndContinueGoesOn) {
  Remote remote;
  remote.initialize();
  remote.send({remote.joint_move({60, 10, -15, 0, -60, 20})});
  for (int i = 0; i < 40; ++i) remote.far.step();
  EXPECT_EQ(remote.ask_in_background("FRC_Pause").error(), 0);
  for (int i = 0; i < 120; ++i) remote.far.step();  // it slows down first
  const Six at = remote.q();
  for (int i = 0; i < 40; ++i) remote.far.step();
  EXPECT_NEAR(remote.q()[0], at[0], 1e-4);
  EXPECT_EQ(remote.ask_in_background("FRC_GetStatus").number("ProgramStatus"), 2);
  EXPECT_EQ(remote.ask_in_background("FRC_Continue").error(), 0);
  remote.run(1);
  EXPECT_NEAR(remote.q()[0], 60, 0.01);
  EXPECT_EQ(remote.ask_in_background("FRC_Continue").error(), fanuc::kRmiNotPaused);
}

TEST(FarRmi, InstructionsHaveRisingNumbersAndARoomForEight) {
  Remote remote;
  RmiLine early = remote.joint_move({20, 10, -15, 0, -60, 20});
  remote.send({early});
  ASSERT_EQ(remote.arrived.size(), 1u);
  EXPECT_EQ(remote.arrived[0].error(), fanuc::kRmiNotRunning);
  remote.initialize();
  remote.sequence = 4;
  remote.send({remote.joint_move({20, 10, -15, 0, -60, 20})});
  EXPECT_EQ(remote.arrived.back().error(), fanuc::kRmiSequence);
  remote.sequence = 0;
  std::vector<RmiLine> lines;
  for (int i = 0; i < 9; ++i) lines.push_back(remote.joint_move({20, 10, -15, 0, -60, 20}));
  remote.send(lines);
  EXPECT_EQ(remote.arrived.back().error(), fanuc::kRmiWaitInstruction);
  EXPECT_EQ(remote.arrived.back().number("SequenceID"), 9);
}

TEST(FarRmi, AnUnreachableTargetIsNamedAndHoldsUntilAbort) {
  Remote remote;
  remote.initialize();
  auto far_away = remote.pose();
  far_away[0] += 5000;
  remote.send({remote.line_move("FRC_LinearMotion", far_away, 100), remote.joint_move({0, 0, 0, 0, 0, 0})});
  remote.run(1, 20);
  remote.ask_in_background("FRC_GetStatus");
  ASSERT_FALSE(remote.arrived.empty());
  EXPECT_EQ(remote.arrived.back().error(), fanuc::kRmiDestination);
  const Six at = remote.q();
  for (int i = 0; i < 50; ++i) remote.far.step();
  EXPECT_EQ(remote.q(), at) << "the next motion waits";
  EXPECT_EQ(remote.ask_in_background("FRC_Abort").error(), 0);
  EXPECT_EQ(remote.ask_in_background("FRC_GetStatus").number("ProgramStatus"), 1);
  remote.initialize();
}

TEST(FarRmi, AnAlarmStopsTheMotionAndIsReportedUnasked) {
  Remote remote;
  remote.initialize();
  remote.send({remote.joint_move({60, 10, -15, 0, -60, 20})});
  for (int i = 0; i < 40; ++i) remote.far.step();
  remote.far.order("fence_open");
  for (int i = 0; i < 40; ++i) remote.far.step();
  const Six at = remote.q();
  for (int i = 0; i < 40; ++i) remote.far.step();
  EXPECT_NEAR(remote.q()[0], at[0], 1e-4);
  EXPECT_EQ(remote.ask_in_background("FRC_ReadError").text("ErrorData"), "SRVO-004 Fence open");
  EXPECT_TRUE(std::any_of(remote.arrived.begin(), remote.arrived.end(),
                          [](const RmiMessage& m) { return m.name == "FRC_SystemFault"; }));
  EXPECT_EQ(remote.ask_in_background("FRC_Initialize").error(), fanuc::kRmiServoOff);
}

TEST(FarRmi, OneProgramAtATimeAndItsEndStopsTheRobot) {
  Remote remote;
  RmiSession second;
  std::string why;
  int error = 0;
  EXPECT_FALSE(second.open("127.0.0.1", remote.far.rmi_port(), "FRC_Connect", 500'000'000, why, error));
  EXPECT_EQ(error, fanuc::kRmiConnected);
  remote.initialize();
  remote.send({remote.joint_move({90, 10, -15, 0, -60, 20})});
  for (int i = 0; i < 40; ++i) remote.far.step();
  remote.session.close(kTimeout);
  for (int i = 0; i < 100; ++i) remote.far.step();
  const Six at = remote.q();
  EXPECT_LT(at[0], 80);
  for (int i = 0; i < 40; ++i) remote.far.step();
  EXPECT_NEAR(remote.q()[0], at[0], 1e-4);
  EXPECT_TRUE(second.open("127.0.0.1", remote.far.rmi_port(), "FRC_Connect", kTimeout, why, error)) << why;
}

/// Random lines, damaged ones and packets at both ports: the controller goes on and the robot stands.
TEST(FarRmiFuzz, RandomLinesAndPacketsNeitherStopNorMoveIt) {
  std::uint64_t seed = 11;
  const auto draw = [&](std::uint64_t n) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (seed >> 33) % n;
  };
  constexpr const char* kWords[] = {
      "FRC_Initialize", "FRC_Abort",        "FRC_ReadError",        "FRC_WriteUToolData",
      "FRC_Call",       "FRC_LinearMotion", "FRC_CircularRelative", "FRC_WaitDIN",
      "FRC_SetUFrame",  "FRC_ReadRegister", "FRC_WriteIOPort",      "FRC_JointMotionJRep",
      "nonsense"};
  constexpr const char* kKeys[] = {"Command",    "Instruction", "Communication",  "SequenceID",
                                   "PortNumber", "Position",    "JointAngle",     "Speed",
                                   "SpeedType",  "TermType",    "RegisterNumber", "Frame"};
  constexpr const char* kValues[] = {
      "1",         "-1",       "1e308",      "null", "\"ON\"", "{\"X\":1e300}", "{\"J1\":1e9}", "[]",
      "\"mmSec\"", "\"FINE\"", "2147483648", "true", "0.5"};
  FarSide far(far_options());
  far.hold_clock(true);
  const Six before = far.with([](fanuc::Machine& m) { return m.q(); });
  std::string why;
  const Descriptor udp = wire::connect_udp("127.0.0.1", far.stream_port(), why);
  for (int round = 0; round < 20; ++round) {
    RmiSession session;
    int error = 0;
    while (!session.open("127.0.0.1", far.rmi_port(), "FRC_Connect", kTimeout, why, error))
      std::this_thread::yield();  // until the last session is gone
    for (int i = 0; i < 300; ++i) {
      std::string line = "{";
      for (std::uint64_t k = 0, n = 1 + draw(5); k < n; ++k)
        line += std::string(k ? "," : "") + "\"" + kKeys[draw(k ? 12 : 3)] +
                "\":" + (k ? std::string(kValues[draw(13)]) : "\"" + std::string(kWords[draw(13)]) + "\"");
      line += "}";
      for (std::uint64_t k = 0, n = draw(3); k < n; ++k)
        line[draw(line.size())] = static_cast<char>(draw(256));
      line += "\r\n";
      wire::send_frame(session.descriptor(), line);
      std::vector<std::uint8_t> packet(draw(600));
      for (auto& byte : packet) byte = static_cast<std::uint8_t>(draw(4) ? 0 : draw(256));
      if (packet.size() > 4) packet[3] = static_cast<std::uint8_t>(draw(2) ? 200 + draw(6) : draw(10));
      wire::send_datagram(udp.number(), packet);
      if (i % 20 == 0) session.poll([](const RmiMessage&) {}), far.step();
    }
    const auto alive =
        session.ask("Command", "FRC_GetExtStatus", RmiLine("Command", "FRC_GetExtStatus"), kTimeout);
    EXPECT_TRUE(alive) << round;
    session.close(kTimeout);
  }
  const Six after = far.with([](fanuc::Machine& m) { return m.q(); });
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(after[i], before[i], 1e-9) << "no instruction was whole";
}

}  // namespace
}  // namespace polyarm
