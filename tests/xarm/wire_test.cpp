/// The bytes of both wires: golden frames, damaged and split ones.
#include <random>

#include "tests/support/damaged.hpp"
#include "tests/xarm/rig.hpp"

namespace polyarm {
namespace {

using namespace xarm;
using Data = std::vector<std::uint8_t>;

std::string text_of(const Data& bytes) {
  return {bytes.begin(), bytes.end()};
}
Data bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}
std::string hex(const Data& bytes) {
  std::string out;
  for (const std::uint8_t byte : bytes) {
    constexpr const char* kDigits = "0123456789abcdef";
    out += kDigits[byte >> 4];
    out += kDigits[byte & 15];
  }
  return out;
}

TEST(UxFrames, AreThoseOfTheMakersClient) {
  EXPECT_EQ(hex(encode(UxRequest{1, kPrivateProtocol, Register::version, {}})), "00010002000101");
  EXPECT_EQ(hex(encode(UxRequest{2, kPrivateProtocol, Register::motion_enable, UxData().u8(8).u8(1)})),
            "0002000200030b0801");
  EXPECT_EQ(hex(encode(UxRequest{3, kPrivateProtocol, Register::set_mode, UxData().u8(1)})),
            "0003000200021301");
  EXPECT_EQ(hex(encode(UxRequest{0x1234, kPrivateProtocol, Register::set_digital, UxData().u16(0x0202)})),
            "123400020003860202");
  const Data servo =
      encode(UxRequest{4, kPrivateProtocol, Register::servo_joint, UxData().f32(0.5).f32(-1.0).text("", 32)});
  EXPECT_EQ(servo.size(), 6u + 1 + 40);
  EXPECT_EQ(hex({servo.begin(), servo.begin() + 15}), "0004000200291d0000003f000080bf")
      << "floats are little-endian";
  EXPECT_EQ(hex(encode(UxReply{1, Register::get_error, kErrorBit | kNotReadyBit, {31, 0}})),
            "0001000200040f501f00");
}

TEST(UxFrames, OfAnotherProtocolAreNoRequests) {
  UxReader reader;
  ASSERT_TRUE(reader.feed(bytes_of(std::string("\0\7\0\0\0\6\1\3\0\0\0\1", 12))));
  const auto frame = reader.next();
  ASSERT_TRUE(frame) << "Modbus TCP shares the port";
  EXPECT_FALSE(decode_request(*frame));
  EXPECT_FALSE(decode_reply(*frame));
}

/// Clients of newer firmware use another number, and expect it back.
TEST(UxFrames, AreAnsweredInTheProtocolOfTheRequest) {
  Machine machine(test::far_options().machine);
  for (const std::uint16_t protocol : {kPrivateProtocol, kHeartbeatProtocol}) {
    const UxReply reply = machine.answer({5, protocol, Register::get_state, {}});
    const Data bytes = encode(reply);
    EXPECT_EQ(bytes[3], protocol);
    UxReader reader;
    ASSERT_TRUE(reader.feed(bytes));
    EXPECT_EQ(decode_reply(*reader.next())->protocol, protocol);
  }
}

TEST(UxFrames, SplitAtEveryByteTheyAreTheSame) {
  Data all = encode(UxReply{7, Register::version, 0, UxData().text("6,6,XS1304,AC1302,v1.12.10", 40)});
  for (const Data& more : {encode(UxReply{8, Register::set_state, kWarningBit, {}}),
                           encode(UxReply{9, Register::get_error, 0, {1, 2}})})
    all.insert(all.end(), more.begin(), more.end());
  for (std::size_t at = 0; at <= all.size(); ++at) {
    UxReader reader;
    std::vector<UxReply> got;
    for (const Bytes part : {Bytes(all).first(at), Bytes(all).subspan(at)}) {
      ASSERT_TRUE(reader.feed(part));
      while (const auto frame = reader.next()) got.push_back(*decode_reply(*frame));
    }
    ASSERT_EQ(got.size(), 3u) << at;
    EXPECT_EQ(parse_version(got[0].data).axes, 6);
    EXPECT_EQ(got[1].bits, kWarningBit);
    EXPECT_EQ(got[2].data, (Data{1, 2}));
  }
}

TEST(UxFrames, ALengthThatNoFrameHasEndsTheConnection) {
  for (const auto& start :
       {Data{0, 1, 0, 2, 0, 0}, Data{0, 1, 0, 2, 2, 1}, Data{0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE}}) {
    UxReader reader;
    EXPECT_FALSE(reader.feed(start));
    EXPECT_FALSE(reader.next());
    EXPECT_FALSE(reader.feed(start)) << "for good";
  }
}

TEST(UxVersions, AreReadFromTheirText) {
  const auto version = [](const std::string& text) { return parse_version(UxData().text(text, 40).bytes()); };
  EXPECT_EQ(version("7,13,XF1300A1,AC1300B2,v2.5.0").axes, 7);
  EXPECT_EQ(version("7,13,XF1300A1,AC1300B2,v2.5.0").type, 13);
  EXPECT_EQ(version("7,13,XF1300A1,AC1300B2,v2.5.0").firmware(), "2.5.0");
  EXPECT_EQ(version("v1.6.3").firmware(), "1.6.3");
  EXPECT_EQ(version("v1.6.3").axes, 0) << "not said";
  EXPECT_EQ(version("nothing").firmware(), "0.0.0");
  EXPECT_EQ(parse_version({}).firmware(), "0.0.0");
}

Report some_report() {
  Report out;
  out.state = State::moving;
  out.mode = Mode::servo;
  out.queued = 258;
  out.position = {0.5, -1, 2, 0.25, 0, 1, 0};
  out.pose = {100, 200, 300, 3, 0.5, -1};
  out.torque[6] = 0.5;
  out.has_force = true;
  out.force[2] = -4;
  return out;
}

TEST(Reports, HaveTheirFieldsAtThePlacesOfTheMakersClient) {
  const Data real = encode(some_report(), {}, ReportKind::real);
  ASSERT_EQ(real.size(), 135u);
  EXPECT_EQ(hex({real.begin(), real.begin() + 15}),
            "00000087"
            "11"
            "0102"
            "0000003f"
            "000080bf");
  EXPECT_EQ(hex({real.begin() + 35, real.begin() + 39}), "0000c842") << "x, 100 mm";
  EXPECT_EQ(hex({real.begin() + 83, real.begin() + 87}), "0000003f") << "the last torque";
  EXPECT_EQ(hex({real.begin() + 95, real.begin() + 99}), "000080c0") << "force z";
  SlowReport slow;
  slow.error = 31;
  slow.warning = 14;
  slow.brakes = slow.enabled = 0x3F;
  slow.load = 0.5;
  slow.collision_sensitivity = 3;
  slow.axes = 6;
  slow.type = 9;
  slow.inputs = 0x0102;
  const Data normal = encode(some_report(), slow, ReportKind::normal);
  ASSERT_EQ(normal.size(), 145u);
  EXPECT_EQ(hex({normal.begin() + 87, normal.begin() + 91}), "3f3f1f0e");
  EXPECT_EQ(hex({normal.begin() + 115, normal.begin() + 119}), "0000003f");
  EXPECT_EQ(normal[131], 3);
  const Data rich = encode(some_report(), slow, ReportKind::rich);
  ASSERT_EQ(rich.size(), 495u);
  EXPECT_EQ(rich[145], 9);
  EXPECT_EQ(rich[146], 6);
  EXPECT_EQ(hex({rich.begin() + 387, rich.begin() + 389}), "0102");
}

TEST(Reports, ComeBackFromTheirBytes) {
  for (const ReportKind kind : {ReportKind::normal, ReportKind::rich, ReportKind::real}) {
    SlowReport slow;
    slow.error = 22;
    slow.tcp_offset[2] = 150;
    slow.outputs = 5;
    slow.version = "v1.12.10";
    const Data bytes = encode(some_report(), slow, kind);
    const auto report = decode_report(bytes, kind);
    ASSERT_TRUE(report);
    EXPECT_EQ(report->position, some_report().position);
    EXPECT_EQ(report->mode, Mode::servo);
    EXPECT_EQ(report->queued, 258);
    EXPECT_EQ(report->has_force, kind == ReportKind::real);
    if (kind == ReportKind::real) continue;
    const auto people = decode_slow_report(bytes);
    ASSERT_TRUE(people);
    EXPECT_EQ(people->error, 22);
    EXPECT_EQ(people->tcp_offset[2], 150);
    if (kind != ReportKind::rich) continue;
    EXPECT_EQ(people->outputs, 5);
    EXPECT_EQ(people->version, "v1.12.10");
  }
}

TEST(Reports, SplitAtEveryByteTheyAreTheSame) {
  Data all = encode(some_report(), {}, ReportKind::real);
  const Data again = all;
  all.insert(all.end(), again.begin(), again.end());
  for (std::size_t at = 0; at <= all.size(); ++at) {
    ReportReader reader;
    int count = 0;
    for (const Bytes part : {Bytes(all).first(at), Bytes(all).subspan(at)}) {
      ASSERT_TRUE(reader.feed(part));
      while (const auto bytes = reader.next()) {
        EXPECT_EQ(decode_report(*bytes, ReportKind::real)->position[2], 2);
        ++count;
      }
    }
    ASSERT_EQ(count, 2) << at;
  }
}

/// Firmware before 1.1 counts 12 bytes too few.
TEST(Reports, OfOldFirmwareAreLongerThanTheySay) {
  Data old = encode(some_report(), {}, ReportKind::normal);
  old[3] = 133;
  Data two = old;
  two.insert(two.end(), old.begin(), old.end());
  ReportReader reader;
  ASSERT_TRUE(reader.feed(two));
  for (int i = 0; i < 2; ++i) {
    const auto bytes = reader.next();
    ASSERT_TRUE(bytes);
    EXPECT_EQ(bytes->size(), 145u);
  }
}

TEST(Reports, NumbersThatAreNotFiniteAndWrongLengthsAreNone) {
  for (const double bad : {std::nan(""), static_cast<double>(INFINITY)}) {
    Report report = some_report();
    report.position[4] = bad;
    EXPECT_FALSE(decode_report(encode(report, {}, ReportKind::real), ReportKind::real));
    report = some_report();
    report.torque[1] = bad;
    EXPECT_TRUE(decode_report(encode(report, {}, ReportKind::real), ReportKind::real))
        << "an estimate ends no motion";
  }
  for (const auto& start : {Data{0, 0, 0, 86}, Data{0, 0, 8, 1}, Data{0xEE, 0xEE, 0xEE, 0xEE}}) {
    ReportReader reader;
    EXPECT_FALSE(reader.feed(start));
    EXPECT_FALSE(reader.next());
  }
}

TEST(XarmWires, DamagedFramesAreReadOrEndTheConnection) {
  std::mt19937 random(5);
  const std::vector<std::string> pieces{std::string("\0\0\0", 3), "\xFF\xFF\xFF\xFF", "\x1d", "\x7f\xc0"};
  const std::vector<Data> good{
      encode(UxRequest{1, kPrivateProtocol, Register::servo_joint, UxData().text("", 40)}),
      encode(UxRequest{2, kPrivateProtocol, Register::tool_write, UxData().u8(9).u16(0x0A15).f32(257)}),
      encode(UxReply{1, Register::version, 0, UxData().text("6,6,XS1304,AC1302,v1.12.10", 40)}),
      encode(UxReply{2, Register::get_error, kErrorBit, {31, 0}})};
  Machine machine(test::far_options().machine);
  for (int i = 0; i < 100'000; ++i) {
    std::string stream;
    for (int k = 0; k < 3; ++k) stream += text_of(good[random() % good.size()]);
    const Data bytes = bytes_of(test::damaged(stream, pieces, 12, random));
    UxReader reader;
    const std::size_t cut = random() % (bytes.size() + 1);
    for (const Bytes part : {Bytes(bytes).first(cut), Bytes(bytes).subspan(cut)}) {
      if (!reader.feed(part)) break;
      while (const auto frame = reader.next()) {
        ASSERT_LE(frame->body.size(), kLongestUx);
        if (const auto request = decode_request(*frame)) machine.answer(*request);
        if (const auto reply = decode_reply(*frame)) parse_version(reply->data);
      }
    }
    machine.step();
    for (const double q : machine.q()) ASSERT_TRUE(std::isfinite(q));
  }
}

TEST(XarmWires, DamagedReportsAreReadOrEndTheConnection) {
  std::mt19937 random(6);
  const std::vector<std::string> pieces{std::string("\0\0\0", 3), "\xFF\xFF\xFF\xFF", "\x87", "\x7f\xc0"};
  std::vector<Data> good;
  for (const ReportKind kind : {ReportKind::normal, ReportKind::rich, ReportKind::real})
    good.push_back(encode(some_report(), {}, kind));
  for (int i = 0; i < 100'000; ++i) {
    std::string stream;
    for (int k = 0; k < 2; ++k) stream += text_of(good[random() % good.size()]);
    const Data bytes = bytes_of(test::damaged(stream, pieces, 12, random));
    ReportReader reader;
    const std::size_t cut = random() % (bytes.size() + 1);
    for (const Bytes part : {Bytes(bytes).first(cut), Bytes(bytes).subspan(cut)}) {
      if (!reader.feed(part)) break;
      while (const auto one = reader.next()) {
        ASSERT_LE(one->size(), kLongestReport);
        const auto report = decode_report(*one, ReportKind::real);
        for (std::size_t j = 0; report && j < kWireJoints; ++j)
          ASSERT_TRUE(std::isfinite(report->position[j]));
        decode_slow_report(*one);
      }
    }
  }
}

/// Each register with data of any length is answered with the transaction of its request.
TEST(XarmMachine, AnswersAnyRequest) {
  std::mt19937 random(7);
  Machine machine(test::far_options().machine);
  for (int i = 0; i < 60'000; ++i) {
    Data data(random() % 60);
    for (auto& byte : data) byte = static_cast<std::uint8_t>(random());
    const UxReply reply = machine.answer(
        {static_cast<std::uint16_t>(i), kPrivateProtocol, static_cast<Register>(random() % 256), data});
    ASSERT_EQ(reply.transaction, i % 65536);
    ASSERT_LE(reply.data.size(), 100u);
    machine.step();
    for (const double q : machine.q()) ASSERT_TRUE(std::isfinite(q));
  }
}

UxReply ask(Machine& machine, Register reg, const Data& data = {}) {
  return machine.answer({1, kPrivateProtocol, reg, data});
}

TEST(XarmMachine, ErrorsWaitForTheirCauseToEndAndForTheOrderOfTheMaker) {
  Machine machine(test::far_options().machine);
  machine.emergency(1, true);
  EXPECT_EQ(ask(machine, Register::get_error).data, (Data{1, 0}));
  EXPECT_EQ(ask(machine, Register::get_error).bits, kErrorBit | kNotReadyBit);
  ask(machine, Register::clean_error);
  EXPECT_EQ(machine.error(), 1) << "the button is still pressed";
  machine.emergency(0, false);
  EXPECT_TRUE(ask(machine, Register::motion_enable, {8, 1}).bits & kInvalidBit) << "the error is still there";
  ask(machine, Register::clean_error);
  EXPECT_EQ(machine.error(), 0);
  ask(machine, Register::set_state, {0});
  EXPECT_FALSE(machine.is_ready()) << "the motors are off";
  ask(machine, Register::motion_enable, {8, 1});
  ask(machine, Register::set_mode, {1});
  EXPECT_FALSE(machine.is_ready()) << "another mode wants a new start";
  ask(machine, Register::set_state, {0});
  EXPECT_TRUE(machine.is_ready());
  EXPECT_EQ(ask(machine, Register::get_error).bits, 0);
}

TEST(XarmMachine, MovesOfItsOwnGoToTheirTargetsOneAfterTheOther) {
  Machine machine(test::far_options().machine);
  const auto move = [&](double j1) {
    return ask(machine, Register::move_joint,
               UxData().f32(Seven{j1, -0.5, -0.5, 0, 0.5, 0, 0}).f32(1).f32(10).f32(0));
  };
  EXPECT_EQ(move(0.5).bits, 0);
  EXPECT_EQ(move(-0.5).bits, 0);
  EXPECT_EQ(ask(machine, Register::queue_length).data, (Data{0, 2}));
  machine.step();
  EXPECT_EQ(machine.state(), State::moving);
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    machine.step();
    most = std::max(most, machine.q()[0]);
  }
  EXPECT_NEAR(most * test::kDegree, 0.5, 1e-3) << "the first target";
  EXPECT_NEAR(machine.q()[0] * test::kDegree, -0.5, 1e-6);
  EXPECT_EQ(machine.state(), State::standing);
  EXPECT_LE(machine.take_fastest(), 58);
  move(9);
  EXPECT_EQ(machine.error(), 23) << "beyond a limit";
}

TEST(XarmMachine, VelocityModeMovesUntilItIsStopped) {
  Machine machine(test::far_options().machine);
  ask(machine, Register::set_mode, {4});
  ask(machine, Register::set_state, {0});
  const double from = machine.q()[0];
  EXPECT_EQ(ask(machine, Register::joint_velocity, UxData().f32(Seven{0.2}).u8(1)).bits, 0);
  for (int i = 0; i < 250; ++i) machine.step();
  EXPECT_NEAR((machine.q()[0] - from) * test::kDegree, 0.2, 0.01);
  ask(machine, Register::set_state, {4});
  for (int i = 0; i < 20; ++i) machine.step();
  const double at = machine.q()[0];
  for (int i = 0; i < 50; ++i) machine.step();
  EXPECT_EQ(machine.q()[0], at);
}

TEST(XarmMachine, AServoCommandThatIsTooFarAwayIsAnErrorAndNoJump) {
  Machine machine(test::far_options().machine);
  ask(machine, Register::set_mode, {1});
  ask(machine, Register::set_state, {0});
  Seven target;
  for (std::size_t i = 0; i < 7; ++i) target[i] = machine.q()[i] * test::kDegree;
  target[0] += 0.1;
  ask(machine, Register::servo_joint, UxData().f32(target).text("", 12));
  machine.step();
  EXPECT_EQ(machine.error(), 24);
  EXPECT_EQ(machine.largest_jump(), 0);
}

}  // namespace
}  // namespace polyarm
