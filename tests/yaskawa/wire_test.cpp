/// The bytes of both wires: golden messages, damaged and split ones.
#include <random>

#include "drivers/yaskawa/far_services.hpp"
#include "tests/support/damaged.hpp"
#include "tests/yaskawa/rig.hpp"

namespace polyarm {
namespace {

using namespace yaskawa;
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

// As a public client of the FS100 sends it, and as a controller answers.
TEST(HsesDatagrams, AreThoseOfTheProtocol) {
  const HsesRequest status{1, 7, 0x72, 1, 0, 0x01, {}};
  EXPECT_EQ(hex(encode(status)),
            "594552432000000003010007000000003939393939393939"
            "7200010000010000");
  const HsesRequest servo{1, 0, 0x83, 2, 1, 0x10, {1, 0, 0, 0}};
  EXPECT_EQ(hex(encode(servo)),
            "594552432000040003010000000000003939393939393939"
            "8300020001100000"
            "01000000");
  HsesReply refused{1, 7, kLastBlock, 0x01, HsesResult::refused, 0x2080, {}};
  EXPECT_EQ(hex(encode(refused)),
            "594552432000000003010107000000803939393939393939"
            "811f010080200000");
  const auto back = decode_hses_reply(encode(refused));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->result, HsesResult::refused);
  EXPECT_EQ(back->added, 0x2080);
  EXPECT_FALSE(decode_hses_request(encode(refused))) << "an answer is no request";
}

TEST(HsesDatagrams, StatusAlarmAndPositionComeBack) {
  HsesStatus status;
  status.running = status.error = status.external_hold = status.servo = true;
  status.remote = false;
  const auto back = decode_status(encode(status));
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->running && back->error && back->external_hold && back->servo && back->play);
  EXPECT_FALSE(back->remote || back->alarm || back->teach || back->pendant_hold);
  EXPECT_EQ(hex(encode(status)), "4c00000064000000") << "bits of the maker's manual";
  const auto alarm = decode_alarm(encode(HsesAlarm{4107, 3, 1, "2026/11/28 12:00", "OUT OF RANGE"}));
  ASSERT_TRUE(alarm);
  EXPECT_EQ(alarm->code, 4107u);
  EXPECT_EQ(alarm->name, "OUT OF RANGE");
  HsesPosition position;
  position.values = {1, -2, 3, -4, 5, -6, 0, 0};
  EXPECT_EQ(decode_position(encode(position))->values, position.values);
  EXPECT_EQ(encode(position).size(), 52u);
}

TEST(HsesDatagrams, OfAnotherLengthOrMagicAreNone) {
  const Data good = encode(HsesRequest{1, 7, 0x72, 1, 0, 0x01, {1, 2, 3}});
  ASSERT_TRUE(decode_hses_request(good));
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(decode_hses_request(Bytes(good).first(size))) << size;
  Data longer = good;
  longer.push_back(0);
  EXPECT_FALSE(decode_hses_request(longer));
  Data other = good;
  other[0] = 'X';
  EXPECT_FALSE(decode_hses_request(other));
}

MotoPoint point() {
  MotoPoint out;
  out.sequence = 3;
  out.time = 0.25f;
  out.position = {0.5f, -1.0f};
  out.velocity = {0.125f};
  return out;
}

TEST(SimpleMessages, AreThoseOfMotoRos) {
  const Data bytes = encode(point(), ByteOrder::little);
  ASSERT_EQ(bytes.size(), 4u + 12 + 136);
  EXPECT_EQ(hex({bytes.begin(), bytes.begin() + 44}),
            "94000000"                  // length without itself: 12 + 136
            "0e0000000200000000000000"  // JOINT_TRAJ_PT_FULL, request, -
            "0000000003000000"          // group 0, sequence 3
            "07000000"                  // time, position, velocity
            "0000803e"                  // 0.25 s
            "0000003f000080bf"          // 0.5, -1
            "00000000");
  EXPECT_EQ(encode(MotoStatus{}, ByteOrder::big).size(), 4u + 12 + 28);
  EXPECT_EQ(encode(MotoFeedback{}, ByteOrder::big).size(), 4u + 12 + 132);
  EXPECT_EQ(encode(MotoControl{}, ByteOrder::big).size(), 4u + 12 + 52);
  EXPECT_EQ(encode(MotoReply{}, ByteOrder::big).size(), 4u + 12 + 60);
  const Data big = encode(MotoControl{0, 1, MotoCommand::start_trajectory}, ByteOrder::big);
  EXPECT_EQ(hex({big.begin(), big.begin() + 28}),
            "00000040"
            "000007d10000000200000000"
            "000000000000000100030db9");
}

TEST(SimpleMessages, SplitAtEveryByteTheyAreTheSameInBothOrders) {
  for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
    Data all = encode(MotoFeedback{0, 6, 0, {1, 2, 3}, {4}, {}}, order);
    for (const Data& more : {encode(MotoStatus{1, 0, 0, 0, 0, 2, 1}, order), encode(point(), order)})
      all.insert(all.end(), more.begin(), more.end());
    for (std::size_t at = 0; at <= all.size(); ++at) {
      MotoReader reader;
      ASSERT_TRUE(reader.feed(Bytes(all).first(at)));
      std::vector<Message> got;
      while (auto message = reader.next()) got.push_back(*message);
      ASSERT_TRUE(reader.feed(Bytes(all).subspan(at)));
      while (auto message = reader.next()) got.push_back(*message);
      ASSERT_EQ(got.size(), 3u) << at;
      ASSERT_EQ(reader.order(), order);
      EXPECT_EQ(decode_feedback(got[0], order)->position[2], 3);
      EXPECT_EQ(decode_status(got[1], order)->motion_possible, 1);
      EXPECT_EQ(decode_point(got[2], order)->sequence, 3);
    }
  }
}

TEST(SimpleMessages, ALengthThatNoMessageHasEndsTheConnection) {
  for (const auto& start : {Data{0xEE, 0xEE, 0xEE, 0xEE}, Data{0, 0, 0, 0}, Data{11, 0, 0, 0},
                            Data{0, 0, 2, 49}}) {  // 561 in big-endian
    MotoReader reader;
    EXPECT_FALSE(reader.feed(start));
    EXPECT_FALSE(reader.next());
  }
}

TEST(SimpleMessages, NumbersThatAreNotFiniteAreNone) {
  for (const float bad : {std::nanf(""), INFINITY}) {
    MotoFeedback feedback;
    feedback.position[4] = bad;
    MotoReader reader;
    reader.feed(encode(feedback, ByteOrder::little));
    EXPECT_FALSE(decode_feedback(*reader.next(), ByteOrder::little));
    MotoPoint with = point();
    with.time = bad;
    reader.feed(encode(with, ByteOrder::little));
    EXPECT_FALSE(decode_point(*reader.next(), ByteOrder::little));
  }
}

TEST(YaskawaWires, ADamagedDatagramOfTheEthernetServerIsReadOrRefused) {
  std::mt19937 random(5);
  const std::vector<std::string> pieces{std::string("\0\0", 2), "YERC", "99999999", "\xFF\xFF", "\x20"};
  const std::vector<Data> good{
      encode(HsesRequest{1, 7, 0x300, 1, 0, 0x33, {4, 0, 0, 0}}),
      encode(HsesReply{1, 7, kLastBlock, 1, HsesResult::done, 0, encode(HsesAlarm{})}),
      encode(HsesReply{1, 7, kLastBlock, 1, HsesResult::done, 0, encode(HsesStatus{})})};
  for (int i = 0; i < 100'000; ++i) {
    const Data bytes = bytes_of(test::damaged(text_of(good[random() % good.size()]), pieces, 12, random));
    if (const auto reply = decode_hses_reply(bytes)) {
      ASSERT_LE(reply->payload.size(), kHsesPayload);
      decode_alarm(reply->payload);
      decode_status(reply->payload);
      decode_position(reply->payload);
    }
    if (const auto request = decode_hses_request(bytes)) {
      ASSERT_LE(request->payload.size(), kHsesPayload);
    }
  }
}

TEST(YaskawaWires, DamagedMessagesOfMotoRosAreReadOrEndTheConnection) {
  std::mt19937 random(6);
  const std::vector<std::string> pieces{std::string("\0\0\0", 3), "\xFF\xFF\xFF\xFF", "\x0e", "\x7f\xc0"};
  for (int i = 0; i < 100'000; ++i) {
    const ByteOrder order = random() % 2 ? ByteOrder::big : ByteOrder::little;
    const std::vector<Data> good{encode(point(), order), encode(MotoFeedback{}, order),
                                 encode(MotoStatus{}, order), encode(MotoReply{}, order),
                                 encode(MotoControl{}, order)};
    std::string stream;
    for (int k = 0; k < 3; ++k) stream += text_of(good[random() % good.size()]);
    const Data bytes = bytes_of(test::damaged(stream, pieces, 12, random));
    MotoReader reader;
    const std::size_t cut = random() % (bytes.size() + 1);
    for (const Bytes part : {Bytes(bytes).first(cut), Bytes(bytes).subspan(cut)}) {
      if (!reader.feed(part)) break;
      while (const auto message = reader.next()) {
        ASSERT_LE(message->body.size(), kLongestMessage);
        if (const auto got = decode_point(*message, order)) {
          ASSERT_TRUE(std::isfinite(got->time));
        }
        decode_points(*message, order);
        decode_feedback(*message, order);
        decode_status(*message, order);
        decode_control(*message, order);
        decode_reply(*message, order);
        read_words(*message, 2, order);
      }
    }
  }
}

/// Points of any kind leave the machine with finite positions, and never with a jump.
TEST(YaskawaWires, TheSimulatedControllerTakesAnyPointWithoutAJump) {
  MachineOptions options = test::far_options().machine;
  options.begin = 0;
  Machine machine(options);
  ASSERT_TRUE(machine.start_trajectory());
  machine.step();
  ASSERT_TRUE(machine.ready());
  std::mt19937 random(7);
  std::uniform_real_distribution<float> any(-0.02f, 0.02f);
  for (int i = 0; i < 20'000; ++i) {
    MotoPoint next;
    next.sequence = static_cast<int>(random() % 5) - 1;
    next.time = static_cast<float>(random() % 200) / 100;
    for (std::size_t j = 0; j < 6; ++j)
      next.position[j] = static_cast<float>(machine.q()[j] * test::kDegree) + any(random);
    machine.take(next);
    machine.step();
    for (const double q : machine.q()) ASSERT_TRUE(std::isfinite(q));
  }
}

TEST(PointStream, BeginsAtRestAndEndsAtRestWithVelocitiesOfItsNeighbours) {
  wire::AxisLimits limits;
  limits.of[0].fill(100);
  limits.of[1].fill(1000);
  limits.of[2].fill(100'000);
  PointStream stream(20, 120, 1);
  const Six at{1, 2, 3, 4, 5, 6};
  stream.begin(at);
  EXPECT_TRUE(stream.stands());
  std::vector<TimedPoint> all;
  for (int i = 0; i < 100; ++i) {
    Six target = at;
    target[0] += 10 * test::smooth(i / 60.0);
    stream.go(target, limits);
    for (; !stream.out().empty(); stream.out().pop_front()) all.push_back(stream.out().front());
  }
  ASSERT_GT(all.size(), 90u);
  EXPECT_EQ(all[0].time_ms, 0);
  EXPECT_EQ(all[1].time_ms, 120);
  EXPECT_EQ(all[0].position, at);
  EXPECT_EQ(all[1].position, at);
  EXPECT_EQ(all[1].velocity, Six{});
  for (std::size_t i = 2; i + 1 < all.size(); ++i) {
    EXPECT_EQ(all[i].sequence, static_cast<int>(i));
    EXPECT_EQ(all[i].time_ms, 120 + 20 * static_cast<int>(i - 1));
    EXPECT_NEAR(all[i].velocity[0], (all[i + 1].position[0] - all[i - 1].position[0]) / 0.04, 1e-9);
  }
  EXPECT_EQ(all.back().velocity, Six{});
  EXPECT_NEAR(all.back().position[0], 11, 1e-12);
  EXPECT_TRUE(stream.stands());
  stream.rest();
  stream.go(all.back().position, limits);
  EXPECT_EQ(stream.out().front().sequence, 0) << "a new trajectory";
  EXPECT_EQ(stream.out().front().time_ms, 0);
}

TEST(PointStream, BrakingFromAMotionEndsAtRest) {
  wire::AxisLimits limits;
  limits.of[0].fill(100);
  limits.of[1].fill(1000);
  limits.of[2].fill(100'000);
  PointStream stream(20, 120, 1);
  stream.begin({});
  Six target{};
  for (int i = 0; i < 50; ++i) {
    target[2] += 0.02 * std::min(i, 20);
    stream.go(target, limits);
  }
  EXPECT_FALSE(stream.stands());
  int steps = 0;
  for (; !stream.stands() && steps < 400; ++steps) stream.brake(limits);
  EXPECT_LT(steps, 60);
  EXPECT_EQ(stream.out().back().velocity, Six{});
}

TEST(Machine, AnswersAsMotoRosDoes) {
  MachineOptions options = test::far_options().machine;
  options.begin = 0;
  Machine machine(options);
  MotoPoint first;
  EXPECT_EQ(machine.take(first).result, MotoResult::not_ready);
  EXPECT_EQ(machine.take(first).subcode, static_cast<int>(NotReady::not_started));
  ASSERT_TRUE(machine.start_trajectory());
  machine.step();
  first.sequence = 0;
  EXPECT_EQ(machine.take(first).subcode, static_cast<int>(Invalid::start_position)) << "it is not at zero";
  first.position = machine.feedback().position;
  EXPECT_EQ(machine.take(first).result, MotoResult::success);
  first.sequence = 1;
  first.time = 0.1f;
  EXPECT_EQ(machine.take(first).result, MotoResult::success);
  EXPECT_EQ(machine.take(first).result, MotoResult::busy) << "one point at a time";
  machine.step();
  EXPECT_EQ(machine.queued(), 24);
  EXPECT_FALSE(machine.stop_trajectory()) << "while there is motion";
  first.velocity[0] = 1000;
  EXPECT_EQ(machine.take(first).subcode, static_cast<int>(Invalid::speed));
  first.valid = 3;
  EXPECT_EQ(machine.take(first).subcode, static_cast<int>(Invalid::insufficient));
  first.group = 2;
  EXPECT_EQ(machine.take(first).subcode, static_cast<int>(Invalid::group));
  machine.turn_key(KeySwitch::teach);
  EXPECT_EQ(machine.queued(), 0);
  EXPECT_EQ(machine.not_ready(), static_cast<int>(NotReady::not_play));
}

}  // namespace
}  // namespace polyarm
