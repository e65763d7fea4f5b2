/// The bytes on the bus against printed examples of the standards, damaged frames, SDO transfers, and the
/// state machine of CiA 402.
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>

#include <deque>
#include <random>
#include <string>

#include "drivers/cia402/drive.hpp"
#include "drivers/cia402/far_drive.hpp"
#include "drivers/cia402/sdo.hpp"
#include "drivers/cia402/slcan.hpp"
#include "drivers/cia402/socket_can.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::cia402 {
namespace {

using Data = std::vector<std::uint8_t>;

Data data_of(const CanFrame& frame) {
  return {frame.data.begin(), frame.data.begin() + frame.size};
}

std::string text(const CanFrame& frame) {
  const SlcanText out = slcan_text(frame);
  return {out.text.data(), out.size};
}

/// What the parser makes of a text.
std::vector<CanFrame> frames_in(const std::string& text, int* refused = nullptr, int* garbage = nullptr) {
  SlcanParser parser;
  std::vector<CanFrame> out;
  for (const char c : text) {
    const SlcanParser::Token token = parser.take(static_cast<std::uint8_t>(c));
    if (token == SlcanParser::Token::frame) out.push_back(parser.frame());
    if (refused) *refused += token == SlcanParser::Token::refused;
    if (garbage) *garbage += token == SlcanParser::Token::garbage;
  }
  return out;
}

TEST(Slcan, TheExamplesOfTheManual) {
  EXPECT_EQ(text(frame_of(0x100, Data{0x11, 0x33})), "t10021133\r");
  EXPECT_EQ(text(frame_of(0x0A7, {})), "t0A70\r");
  EXPECT_EQ(text(frame_of(0x7FF, Data{0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88})),
            "t7FF81122334455667788\r");
  EXPECT_EQ(frames_in("t10021133\r"), std::vector{frame_of(0x100, Data{0x11, 0x33})});
  EXPECT_EQ(frames_in("t10021133A902\r"), std::vector{frame_of(0x100, Data{0x11, 0x33})}) << "a time stamp";
  EXPECT_EQ(frames_in("z\rzt0A70\r"), std::vector{frame_of(0x0A7, {})}) << "an answer before it";
  EXPECT_STREQ(slcan_rate(1'000'000), "S8");
  EXPECT_STREQ(slcan_rate(500'000), "S6");
  EXPECT_STREQ(slcan_rate(10'000), "S0");
  EXPECT_EQ(slcan_rate(83'333), nullptr);
}

TEST(Slcan, WhatIsNoFrameIsCountedAndTheNextLineIsRead) {
  int refused = 0, garbage = 0;
  const std::string text =
      "\a"
      "t1\r"
      "t80001\r"
      "t1009"
      "11223344556677889900\r"
      "t10g0\r"
      "t100211\r"
      "hello\r"
      "T0C34567F20102\r"
      "r1000\r"
      "V1013\r"
      "F00\r" +
      std::string(100, 't') + "\rt0A70\r";
  EXPECT_EQ(frames_in(text, &refused, &garbage), std::vector{frame_of(0x0A7, {})});
  EXPECT_EQ(refused, 1);
  EXPECT_EQ(garbage, 7);
}

TEST(Slcan, DamagedLinesNeverMakeFramesThatCannotBe) {
  std::mt19937 random(1);
  int frames = 0;
  for (int n = 0; n < 200'000; ++n) {
    std::string line = text(frame_of(static_cast<std::uint16_t>(random() % 0x800),
                                     Data(random() % 9, static_cast<std::uint8_t>(random()))));
    for (unsigned k = 0; k <= random() % 3; ++k) line[random() % line.size()] = static_cast<char>(random());
    for (const CanFrame& frame : frames_in(line + "\r")) {
      ++frames;
      ASSERT_LE(frame.id, 0x7FF);
      ASSERT_LE(frame.size, 8);
      ASSERT_EQ(frames_in(text(frame)), std::vector{frame});
    }
  }
  EXPECT_GT(frames, 1000) << "some of them are still frames";
}

/// Two ends of a socket in the place of an interface.
struct Interface {
  int ends[2];
  Interface() { EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, ends), 0); }
  ~Interface() { ::close(ends[1]); }
  void put(std::uint32_t id, std::uint8_t size, std::size_t bytes = sizeof(can_frame)) const {
    can_frame frame{};
    frame.can_id = id;
    frame.can_dlc = size;
    frame.data[0] = 0x42;
    EXPECT_EQ(::send(ends[1], &frame, bytes, 0), static_cast<ssize_t>(bytes));
  }
};

TEST(SocketCan, CarriesFramesAndKnowsThoseOfErrors) {
  Interface wire;
  SocketCanBus bus{Descriptor(wire.ends[0])};
  EXPECT_EQ(bus.send(frame_of(0x601, Data{1, 2, 3})), BusState::ok);
  can_frame out{};
  ASSERT_EQ(::recv(wire.ends[1], &out, sizeof out, 0), static_cast<ssize_t>(sizeof out));
  EXPECT_EQ(out.can_id, 0x601u);
  EXPECT_EQ(out.can_dlc, 3);
  EXPECT_EQ(out.data[2], 3);
  CanFrame frame;
  EXPECT_EQ(bus.receive(frame, 0), BusState::nothing);
  wire.put(0x181, 7);
  EXPECT_EQ(bus.receive(frame, 0), BusState::ok);
  EXPECT_EQ(frame.id, 0x181);
  EXPECT_EQ(frame.size, 7);
  EXPECT_EQ(frame.data[0], 0x42);
  wire.put(0x181 | CAN_EFF_FLAG, 8);        // 29 bits
  wire.put(0x181 | CAN_RTR_FLAG, 0);        // a remote frame
  wire.put(0x181, 9);                       // too long
  wire.put(0x181, 8, 10);                   // cut off
  wire.put(CAN_ERR_FLAG | CAN_ERR_ACK, 8);  // nobody acknowledged
  EXPECT_EQ(bus.receive(frame, 0), BusState::nothing);
  EXPECT_EQ(bus.garbage(), 4u);
  EXPECT_EQ(bus.refused(), 1u);
  wire.put(CAN_ERR_FLAG | CAN_ERR_BUSOFF, 8);
  EXPECT_EQ(bus.receive(frame, 0), BusState::off);
  EXPECT_EQ(bus.send(sync()), BusState::off);
  wire.put(CAN_ERR_FLAG | CAN_ERR_RESTARTED, 8);
  EXPECT_EQ(bus.receive(frame, 0), BusState::nothing);
  EXPECT_EQ(bus.send(sync()), BusState::ok);
}

TEST(SocketCan, AFullQueueAndAnInterfaceThatIsGoneAreToldApart) {
  Interface wire;
  SocketCanBus bus{Descriptor(wire.ends[0])};
  BusState state = BusState::ok;
  for (int n = 0; n < 100'000 && state == BusState::ok; ++n) state = bus.send(sync());
  EXPECT_EQ(state, BusState::full);
  EXPECT_EQ(bus.refused(), 1u);
  Interface other;
  SocketCanBus gone{Descriptor(other.ends[0])};
  ::shutdown(other.ends[1], SHUT_RDWR);
  CanFrame frame;
  EXPECT_EQ(gone.receive(frame, 0), BusState::gone);
  EXPECT_EQ(gone.send(sync()), BusState::gone);
}

TEST(CanOpen, TheExamplesOfTheStandard) {
  EXPECT_EQ(nmt(NmtCommand::start, 5), frame_of(0x000, Data{0x01, 0x05}));
  EXPECT_EQ(nmt(NmtCommand::pre_operational, 0), frame_of(0x000, Data{0x80, 0x00}));
  EXPECT_EQ(nmt(NmtCommand::reset_node, 127), frame_of(0x000, Data{0x81, 0x7F}));
  EXPECT_EQ(sync(), frame_of(0x080, {}));
  EXPECT_EQ(heartbeat(127, NmtState::operational), frame_of(0x77F, Data{0x05}));
  EXPECT_EQ(state_of_heartbeat(frame_of(0x701, Data{0x7F})), NmtState::pre_operational);
  EXPECT_EQ(state_of_heartbeat(frame_of(0x701, Data{0x85})), NmtState::operational) << "a toggle bit";
  EXPECT_EQ(state_of_heartbeat(frame_of(0x701, {})), NmtState::unknown);
  // Reading the device type: a servo drive with CiA 402.
  EXPECT_EQ(upload_request(1, {0x1000}), frame_of(0x601, Data{0x40, 0x00, 0x10, 0, 0, 0, 0, 0}));
  const SdoAnswer type = read_answer(frame_of(0x581, Data{0x43, 0x00, 0x10, 0, 0x92, 0x01, 0x02, 0x00}));
  EXPECT_EQ(type.kind, SdoKind::expedited);
  EXPECT_EQ(type.object, (Object{0x1000, 0}));
  EXPECT_EQ(get(type.data, 0, type.size), 0x0002'0192u);
  // Writing the controlword "shutdown", a mode, and a target.
  const Data shutdown{0x06, 0x00}, mode{0x08}, target{0x78, 0x56, 0x34, 0x12};
  EXPECT_EQ(download_request(1, {0x6040}, shutdown),
            frame_of(0x601, Data{0x2B, 0x40, 0x60, 0, 0x06, 0, 0, 0}));
  EXPECT_EQ(download_request(1, {0x6060}, mode), frame_of(0x601, Data{0x2F, 0x60, 0x60, 0, 0x08, 0, 0, 0}));
  EXPECT_EQ(download_request(1, {0x607A}, target),
            frame_of(0x601, Data{0x23, 0x7A, 0x60, 0, 0x78, 0x56, 0x34, 0x12}));
  EXPECT_EQ(read_answer(frame_of(0x581, Data{0x60, 0x40, 0x60, 0, 0, 0, 0, 0})).kind, SdoKind::written);
  const SdoAnswer no = read_answer(frame_of(0x581, Data{0x80, 0x40, 0x60, 0, 0x11, 0x00, 0x09, 0x06}));
  EXPECT_EQ(no.kind, SdoKind::aborted);
  EXPECT_EQ(abort_words(no.code), "the sub-index does not exist (0x06090011)");
  EXPECT_EQ(abort_words(0x12345678), "a reason of this maker's own (0x12345678)");
  // Segments.
  EXPECT_EQ(upload_segment_request(1, false).data[0], 0x60);
  EXPECT_EQ(upload_segment_request(1, true).data[0], 0x70);
  EXPECT_EQ(data_of(download_announcement(1, {0x1F50, 1}, 26)), (Data{0x21, 0x50, 0x1F, 1, 26, 0, 0, 0}));
  EXPECT_EQ(data_of(download_segment(1, true, true, Data{1, 2, 3})), (Data{0x19, 1, 2, 3, 0, 0, 0, 0}));
}

TEST(CanOpen, EmergenciesHaveWords) {
  const auto emergency = emergency_of(frame_of(0x083, Data{0x10, 0x23, 0x03, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(emergency);
  EXPECT_EQ(emergency_words(emergency->code), "continuous over-current (0x2310)");
  EXPECT_EQ(emergency_words(0x8611), "following error: the joint did not follow its target (0x8611)");
  EXPECT_EQ(emergency_words(0x8F01), "monitoring (0x8F01)") << "the words of its class";
  EXPECT_EQ(emergency_words(0xFF07), "an error of this maker's own (0xFF07)");
  EXPECT_EQ(emergency_words(0xB000), "an error that no standard names (0xB000)");
  EXPECT_FALSE(emergency_of(frame_of(0x083, Data{0x10, 0x23})));
}

/// A drive and its master, without anything between them.
class Wire : public CanBus {
 public:
  explicit Wire(FarDrive* drive) : drive_(drive) {}
  BusState send(const CanFrame& frame) noexcept override {
    FarDrive::Frames out;
    sent.push_back(frame);
    if (drive_) drive_->take(frame, out);
    waiting.insert(waiting.end(), out.begin(), out.end());
    return BusState::ok;
  }
  BusState receive(CanFrame& frame, Nanoseconds) noexcept override {
    if (waiting.empty()) return BusState::nothing;
    frame = waiting.front();
    waiting.pop_front();
    return BusState::ok;
  }
  std::array<int, 2> descriptors() const noexcept override { return {-1, -1}; }
  std::deque<CanFrame> waiting;
  std::vector<CanFrame> sent;

 private:
  FarDrive* drive_;
};

TEST(Sdo, ReadsAndWritesShortAndLongObjects) {
  FarDrive drive({}, 1'000'000);
  Wire wire(&drive);
  SdoClient sdo(wire, 1'000'000'000);
  std::array<std::uint8_t, 64> bytes{};
  const SdoDone name = sdo.upload(1, {0x1008}, bytes);
  ASSERT_TRUE(name);
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(name.size)),
            "Polyarm simulated drive");
  std::uint64_t value = 0;
  ASSERT_TRUE(sdo.write(1, {0x6085}, 4, 123456));
  ASSERT_TRUE(sdo.read(1, {0x6085}, 4, value));
  EXPECT_EQ(value, 123456u);
  EXPECT_EQ(sdo.read(1, {0x6085}, 2, value).result, SdoResult::wrong) << "another size";
  EXPECT_EQ(sdo.read(1, {0x6FFF}, 4, value).code, kNoObject);
  EXPECT_TRUE(sdo.read(1, {0x1018, 9}, 4, value).missing());
  EXPECT_EQ(sdo.write(1, {0x6041}, 2, 0).code, 0x0601'0002u) << "it can only be read";
  EXPECT_EQ(sdo.write(1, {0x6085}, 2, 0).code, 0x0607'0010u) << "a wrong length";
  const Data long_one(23, 7);
  EXPECT_EQ(sdo.download(1, {0x6085}, long_one).code, 0x0607'0010u) << "it came in segments, and is too long";
  std::array<std::uint8_t, 8> small{};
  EXPECT_EQ(sdo.upload(1, {0x1008}, small).result, SdoResult::wrong) << "there is no room for it";
  EXPECT_EQ(wire.sent.back().data[0], 0x80) << "and the drive gets an abort";
  ASSERT_TRUE(sdo.read(1, {0x6085}, 4, value)) << "then all is well again";
}

TEST(Sdo, AnswersThatDoNotFitEndIt) {
  const auto result = [](std::initializer_list<Data> answers, std::size_t room = 64) {
    Wire wire(nullptr);
    for (const Data& one : answers) wire.waiting.push_back(frame_of(0x581, one));
    SdoClient sdo(wire, 1'000'000);
    std::vector<std::uint8_t> bytes(room);
    return sdo.upload(1, {0x1008}, bytes).result;
  };
  const Data head{0x41, 0x08, 0x10, 0, 9, 0, 0, 0}, first{0x00, 1, 2, 3, 4, 5, 6, 7},
      last{0x1B, 8, 9, 0, 0, 0, 0, 0};
  EXPECT_EQ(result({head, first, last}), SdoResult::ok);
  EXPECT_EQ(result({}), SdoResult::silent);
  EXPECT_EQ(result({head}), SdoResult::silent);
  EXPECT_EQ(result({head, first}), SdoResult::silent);
  EXPECT_EQ(result({head, last}), SdoResult::wrong) << "the toggle bit";
  EXPECT_EQ(result({head, first, first}), SdoResult::wrong);
  EXPECT_EQ(result({head, first, last}, 8), SdoResult::wrong) << "too long";
  EXPECT_EQ(result({Data{0x41, 0x08, 0x10, 0, 12, 0, 0, 0}, first, last}), SdoResult::wrong) << "too short";
  EXPECT_EQ(result({head, Data{0x0E, 0, 0, 0, 0, 0, 0, 0}}), SdoResult::wrong) << "empty, and not the last";
  EXPECT_EQ(result({Data{0x60, 0x08, 0x10, 0, 0, 0, 0, 0}}), SdoResult::wrong) << "nothing was written";
  EXPECT_EQ(result({Data{0x43, 0x09, 0x10, 0, 1, 2, 3, 4}}), SdoResult::silent) << "of another object";
  EXPECT_EQ(result({Data{0x43, 0x08, 0x10}}), SdoResult::silent) << "too short for an answer";
  EXPECT_EQ(result({Data{0x80, 0x08, 0x10, 0, 0, 0, 0x02, 0x06}}), SdoResult::aborted);
}

TEST(Sdo, RandomRequestsAndAnswersEndIt) {
  std::mt19937 random(2);
  FarDrive drive({}, 1'000'000);
  std::uint64_t answers = 0;
  for (int n = 0; n < 60'000; ++n) {
    Data bytes(8);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (random() % 2) bytes[0] = static_cast<std::uint8_t>(random() % 8 << 5 | 2);
    if (random() % 2) bytes[1] = static_cast<std::uint8_t>(random() % 0x20), bytes[2] = 0x10;
    FarDrive::Frames out;
    drive.take(frame_of(0x601, bytes), out);
    for (const CanFrame& one : out) ASSERT_EQ(one.size, 8);
    answers += out.size();
    Wire wire(nullptr);
    for (int k = 0; k < 4; ++k) {
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
      if (random() % 2) bytes[0] = static_cast<std::uint8_t>(random() % 4 << 4);
      if (k == 0) bytes[0] = 0x41, bytes[1] = 0x08, bytes[2] = 0x10, bytes[3] = 0;
      wire.waiting.push_back(frame_of(0x581, bytes));
    }
    SdoClient sdo(wire, 1'000'000);
    std::array<std::uint8_t, 20> room{};
    const SdoDone done = sdo.upload(1, {0x1008}, room);
    ASSERT_LE(done.size, room.size());
  }
  EXPECT_GT(answers, 30'000u);
}

TEST(Drive, DamagedFramesOfDrivesAreRefusedOrRead) {
  std::mt19937 random(3);
  for (int n = 0; n < 100'000; ++n) {
    Data bytes(random() % 9);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const CanFrame frame = frame_of(static_cast<std::uint16_t>(random() % 0x800), bytes);
    EXPECT_EQ(state_pdo(frame).has_value(), frame.size == 7);
    EXPECT_EQ(feedback_pdo(frame).has_value(), frame.size == 6);
    EXPECT_EQ(emergency_of(frame).has_value(), frame.size >= 3);
    EXPECT_LE(static_cast<int>(read_answer(frame).kind), static_cast<int>(SdoKind::aborted));
    EXPECT_LE(read_answer(frame).kind == SdoKind::segment ? read_answer(frame).size : 0, 7u);
  }
}

/// The table of the standard: a mask, a value, a state.
TEST(Drive, EveryStatuswordIsTheStateOfTheStandard) {
  constexpr struct {
    unsigned mask, value;
    DriveState state;
  } kTable[] = {{0x4F, 0x00, DriveState::not_ready},      {0x4F, 0x40, DriveState::switch_on_disabled},
                {0x6F, 0x21, DriveState::ready},          {0x6F, 0x23, DriveState::switched_on},
                {0x6F, 0x27, DriveState::enabled},        {0x6F, 0x07, DriveState::quick_stop},
                {0x4F, 0x0F, DriveState::fault_reaction}, {0x4F, 0x08, DriveState::fault}};
  for (unsigned word = 0; word <= 0xFFFF; ++word) {
    DriveState expected = DriveState::not_ready;
    for (const auto& row : kTable)
      if ((word & row.mask) == row.value) expected = row.state;
    ASSERT_EQ(state_of(static_cast<std::uint16_t>(word)), expected) << word;
  }
}

/// A drive whose SYNCs are a test's, in the state that a test wants.
class StateMachine : public testing::Test {
 protected:
  StateMachine() : drive({}, 10'000'000), wire(&drive) {
    SdoClient sdo(wire, 1'000'000'000);
    sdo.write(1, object::kMode, 1, 8);
    sdo.write(1, object::kQuickStopOption, 2, 6);
  }
  DriveState state() {
    SdoClient sdo(wire, 1'000'000'000);
    std::uint64_t word = 0;
    EXPECT_TRUE(sdo.read(1, object::kStatusword, 2, word));
    return state_of(static_cast<std::uint16_t>(word));
  }
  DriveState after(std::uint16_t controlword) {
    SdoClient sdo(wire, 1'000'000'000);
    EXPECT_TRUE(sdo.write(1, object::kControlword, 2, controlword));
    FarDrive::Frames out;
    for (int k = 0; k < 3; ++k) drive.tick(out);
    return state();
  }
  void fail() {
    FarDrive::Frames out;
    drive.fail(0x2310, false, out);
    for (int k = 0; k < 3; ++k) drive.tick(out);
    drive.heal(out);
  }
  FarDrive drive;
  Wire wire;
};

TEST_F(StateMachine, ItsTransitionsAreThoseOfTheStandard) {
  EXPECT_EQ(state(), DriveState::switch_on_disabled) << "0 and 1";
  EXPECT_EQ(after(control::kSwitchOn), DriveState::switch_on_disabled) << "not in one step";
  EXPECT_EQ(after(control::kShutdown), DriveState::ready) << "2";
  EXPECT_EQ(after(control::kSwitchOn), DriveState::switched_on) << "3";
  EXPECT_EQ(after(control::kEnable), DriveState::enabled) << "4";
  EXPECT_EQ(after(control::kSwitchOn), DriveState::switched_on) << "5";
  EXPECT_EQ(after(control::kShutdown), DriveState::ready) << "6";
  EXPECT_EQ(after(control::kQuickStop), DriveState::switch_on_disabled) << "7";
  after(control::kShutdown), after(control::kSwitchOn), after(control::kEnable);
  EXPECT_EQ(after(control::kShutdown), DriveState::ready) << "8";
  after(control::kSwitchOn), after(control::kEnable);
  EXPECT_EQ(after(control::kDisableVoltage), DriveState::switch_on_disabled) << "9";
  after(control::kShutdown), after(control::kSwitchOn);
  EXPECT_EQ(after(control::kDisableVoltage), DriveState::switch_on_disabled) << "10";
  after(control::kShutdown), after(control::kSwitchOn), after(control::kEnable);
  EXPECT_EQ(after(control::kQuickStop), DriveState::quick_stop) << "11";
  EXPECT_EQ(after(control::kEnable), DriveState::enabled) << "16";
  after(control::kQuickStop);
  EXPECT_EQ(after(control::kDisableVoltage), DriveState::switch_on_disabled) << "12";
  fail();
  EXPECT_EQ(state(), DriveState::fault) << "13 and 14";
  EXPECT_EQ(after(control::kEnable), DriveState::fault);
  EXPECT_EQ(after(control::kFaultReset), DriveState::switch_on_disabled) << "15";
  fail();
  EXPECT_EQ(after(control::kFaultReset), DriveState::fault) << "a reset is an edge";
  after(control::kDisableVoltage);
  EXPECT_EQ(after(control::kFaultReset), DriveState::switch_on_disabled);
}

TEST_F(StateMachine, TheDriversStepsLeadToWhereItWants) {
  for (int n = 0; n < 3; ++n) after(towards_enabled(state()));
  EXPECT_EQ(state(), DriveState::enabled);
  EXPECT_EQ(after(towards_standstill(state())), DriveState::quick_stop);
  EXPECT_EQ(after(towards_standstill(state())), DriveState::quick_stop) << "it stays there";
  EXPECT_EQ(after(towards_enabled(state())), DriveState::enabled);
  for (int s = 0; s < kDriveStates; ++s) {
    const auto state = static_cast<DriveState>(s);
    EXPECT_EQ(towards_standstill(state) & 0x08, 0) << name(state) << ": a stop enables nothing";
    EXPECT_EQ((towards_enabled(state) | towards_standstill(state)) & 0x80, 0) << "and resets no fault";
  }
}

TEST(Drive, AnglesAndCountsAreOfOneAnother) {
  const Scale scale{4096, 100, 0.25, -1};
  EXPECT_NEAR(scale.angle(0), 0.25, 1e-15);
  EXPECT_NEAR(scale.counts(0.25 + 2 * std::numbers::pi), -409600, 1e-9);
  for (const double angle : {-3.0, 0.0, 0.1, 2.5})
    EXPECT_NEAR(scale.angle(scale.counts(angle)), angle, 1e-12);
}

TEST(Drive, TheCycleIsWrittenInMillisecondsIfItCanBe) {
  const auto seconds_of = [](Nanoseconds cycle) {
    const PeriodObject out = period_object(cycle);
    return out.value * std::pow(10.0, out.exponent);
  };
  EXPECT_EQ(period_object(10'000'000).value, 10);
  EXPECT_EQ(period_object(10'000'000).exponent, -3);
  EXPECT_EQ(period_object(1'000'000).exponent, -3);
  EXPECT_EQ(period_object(2'500'000).value, 25);
  EXPECT_EQ(period_object(2'500'000).exponent, -4);
  EXPECT_NEAR(seconds_of(125'000), 125e-6, 1e-12);
  EXPECT_GE(seconds_of(3'333'333), 3.333333e-3) << "rounded up: a drive must not be ahead";
  EXPECT_LT(seconds_of(3'333'333), 3.41e-3);
}

TEST(Drive, TargetsAreLittleEndianAndSigned) {
  EXPECT_EQ(command_pdo(3, 0x000F, -2), frame_of(0x203, Data{0x0F, 0x00, 0xFE, 0xFF, 0xFF, 0xFF}));
  const auto state = state_pdo(frame_of(0x183, Data{0x37, 0x12, 0xFE, 0xFF, 0xFF, 0xFF, 0x08}));
  ASSERT_TRUE(state);
  EXPECT_EQ(state->statusword, 0x1237);
  EXPECT_EQ(state->position, -2);
  EXPECT_EQ(state->mode, 8);
  EXPECT_EQ(state_of(state->statusword), DriveState::enabled);
  const auto feedback = feedback_pdo(frame_of(0x283, Data{0xFF, 0xFF, 0xFF, 0xFF, 0x18, 0xFC}));
  ASSERT_TRUE(feedback);
  EXPECT_EQ(feedback->velocity, -1);
  EXPECT_EQ(feedback->torque, -1000);
}

}  // namespace
}  // namespace polyarm::cia402
