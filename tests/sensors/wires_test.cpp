/// Frames and messages without a device: golden bytes of the public protocol descriptions, split, garbled,
/// and random ones.
#include <gtest/gtest.h>

#include <random>

#include "drivers/sensors/ubx.hpp"
#include "drivers/sensors/wit.hpp"
#include "tests/sensors/far_sides.hpp"

namespace polyarm::sensors::wires_test {
namespace {

using test::Bytes;
using test::operator+;

Bytes random_bytes(std::mt19937& random, std::size_t count) {
  Bytes out(count);
  for (std::uint8_t& byte : out) byte = static_cast<std::uint8_t>(random());
  return out;
}

std::vector<WitFrame> frames_in(WitReader& reader, const Bytes& bytes) {
  std::vector<WitFrame> out;
  reader.take(bytes, [&](const WitFrame& frame) { out.push_back(frame); });
  return out;
}

struct Message {
  UbxId id;
  Bytes payload;
};
std::vector<Message> messages_in(UbxReader& reader, const Bytes& bytes) {
  std::vector<Message> out;
  reader.take(bytes, [&](const UbxMessage& m) {
    out.push_back({m.id, Bytes(m.payload.begin(), m.payload.end())});
  });
  return out;
}

TEST(WitWire, ReadsFramesAndTheirSigns) {
  WitReader reader;
  const auto frames = frames_in(reader, test::wit(0x51, -1, 32767, -32768, 2500));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].type, WitType::acceleration);
  EXPECT_EQ(frames[0].values, (std::array<std::int16_t, 4>{-1, 32767, -32768, 2500}));
}

TEST(WitWire, CommandsAreThoseOfTheDescription) {
  EXPECT_EQ(wit_write(kWitKey, kWitUnlock), (std::array<std::uint8_t, 5>{0xFF, 0xAA, 0x69, 0x88, 0xB5}));
  EXPECT_EQ(wit_write(kWitRate, wit_rate_code(200)),
            (std::array<std::uint8_t, 5>{0xFF, 0xAA, 0x03, 0x0B, 0x00}));
  EXPECT_EQ(wit_rate_code(100), 9);
  EXPECT_EQ(wit_rate_code(33), 0);
}

TEST(WitWire, ABadSumIsNoFrameAndTheNextOneIs) {
  WitReader reader;
  Bytes bad = test::wit(0x52, 1, 2, 3, 4);
  bad[4] ^= 0x10;
  const auto frames = frames_in(reader, bad + test::wit(0x53, 5, 6, 7, 8));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].type, WitType::angle);
  EXPECT_EQ(reader.counts().bad_sums, 1u);
  EXPECT_EQ(reader.counts().skipped_bytes, kWitFrameSize);
}

TEST(WitWire, AFalseBeginningHidesNoFrame) {
  for (std::size_t cut = 1; cut < kWitFrameSize; ++cut) {  // the rest of a frame is lost, the next one begins
    WitReader reader;
    const Bytes whole = test::wit(0x51, 0x5155, 0x5255, 0x5355, 0x5955);
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut));
    const auto frames = frames_in(reader, part + test::wit(0x59, 1, 2, 3, 4) + test::wit(0x59, 5, 6, 7, 8));
    ASSERT_EQ(frames.size(), 2u) << "cut after " << cut;
    EXPECT_EQ(frames[1].values[3], 8);
  }
}

TEST(WitWire, RandomBytesBetweenFramesLoseNone) {
  std::mt19937 random(20);
  WitReader reader;
  std::size_t sent = 0, got = 0;
  for (int round = 0; round < 3000; ++round) {
    const Bytes noise = random_bytes(random, random() % 30);
    const auto value = static_cast<std::int16_t>(random());
    for (const WitFrame& frame : frames_in(reader, noise + test::wit(0x52, value, 7, value, -7)))
      got += frame.values[1] == 7 && frame.values[3] == -7;
    ++sent;
  }
  // A frame may be taken for the tail of noise that happens to have a right sum: about one in 10^5 here.
  EXPECT_GE(got + 2, sent);
  EXPECT_LE(got, sent);
}

TEST(UbxWire, MessagesAreThoseOfTheDescription) {
  EXPECT_EQ(cfg_rate(1000),
            (Bytes{0xB5, 0x62, 0x06, 0x08, 0x06, 0x00, 0xE8, 0x03, 0x01, 0x00, 0x01, 0x00, 0x01, 0x39}));
  EXPECT_EQ(cfg_rate(200),
            (Bytes{0xB5, 0x62, 0x06, 0x08, 0x06, 0x00, 0xC8, 0x00, 0x01, 0x00, 0x01, 0x00, 0xDE, 0x6A}));
  EXPECT_EQ(cfg_msg(kNavPvt, 1), (Bytes{0xB5, 0x62, 0x06, 0x01, 0x03, 0x00, 0x01, 0x07, 0x01, 0x13, 0x51}));
  EXPECT_EQ(ubx_message(kMonVer, {}), (Bytes{0xB5, 0x62, 0x0A, 0x04, 0x00, 0x00, 0x0E, 0x34}));
  EXPECT_EQ(cfg_valset(200, ReceiverPort::usb),
            test::ubx(0x06, 0x8A, {0,    1,    0,    0,                 // version, working memory
                                   0x01, 0x00, 0x21, 0x30, 0xC8, 0x00,  // CFG-RATE-MEAS
                                   0x02, 0x00, 0x21, 0x30, 0x01, 0x00,  // CFG-RATE-NAV
                                   0x09, 0x00, 0x91, 0x20, 0x01,        // CFG-MSGOUT-UBX_NAV_PVT_USB
                                   0x02, 0x00, 0x78, 0x10, 0x00}));     // CFG-USBOUTPROT-NMEA
}

TEST(UbxWire, ReadsAFix) {
  test::Fix fix;
  fix.longitude = -1'234'567'890;
  fix.latitude = -12;
  fix.flags = 0x83;
  const auto read = read_nav_pvt(test::nav_pvt_payload(fix));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->fix_type, 3);
  EXPECT_TRUE(read->fix_ok && read->differential);
  EXPECT_EQ(read->carrier, 2);
  EXPECT_NEAR(read->longitude, -123.456789, 1e-12);
  EXPECT_NEAR(read->latitude, -12e-7, 1e-15);
  EXPECT_NEAR(read->height, 456.789, 1e-9);
  EXPECT_NEAR(read->horizontal_accuracy, 1.5, 1e-12);
  EXPECT_NEAR(read->velocity_east, -2, 1e-12);
  EXPECT_NEAR(read->velocity_down, 0.3, 1e-12);
  EXPECT_NEAR(read->speed_accuracy, 0.4, 1e-12);
  EXPECT_EQ(read->satellites, 12);
}

TEST(UbxWire, TheShorterFixOfGenerationSevenIsReadAndAShorterOneNot) {
  EXPECT_TRUE(read_nav_pvt(test::nav_pvt_payload({}, 84)));
  EXPECT_FALSE(read_nav_pvt(Bytes(83)));
  EXPECT_FALSE(read_nav_pvt({}));
}

TEST(UbxWire, ReadsVersions) {
  UbxReader reader;
  const auto messages = messages_in(reader, test::mon_ver("27.31"));
  ASSERT_EQ(messages.size(), 1u);
  const ReceiverVersion version = read_mon_ver(messages[0].payload);
  EXPECT_EQ(version.software, "HPG 1.32");
  EXPECT_EQ(version.hardware, "00190000");
  EXPECT_EQ(version.protocol, "27.31");
  EXPECT_EQ(read_mon_ver(Bytes(39)).software, "");
}

TEST(UbxWire, EverySplitOfAMessageIsTheSameMessage) {
  const Bytes whole = test::nav_pvt();
  for (std::size_t cut = 0; cut <= whole.size(); ++cut) {
    UbxReader reader;
    const auto at = whole.begin() + static_cast<std::ptrdiff_t>(cut);
    auto messages = messages_in(reader, Bytes(whole.begin(), at));
    const auto rest = messages_in(reader, Bytes(at, whole.end()));
    messages.insert(messages.end(), rest.begin(), rest.end());
    ASSERT_EQ(messages.size(), 1u) << "cut at " << cut;
    EXPECT_EQ(messages[0].payload, test::nav_pvt_payload({}));
  }
}

TEST(UbxWire, EveryFlippedBitIsNoticedAndTheNextMessageIsRead) {
  const Bytes good = test::nav_pvt();
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    UbxReader reader;
    Bytes stream = bad;
    stream = stream + good;  // at once, whatever a garbled length asks for
    const auto messages = messages_in(reader, stream);
    ASSERT_EQ(messages.size(), 1u) << "bit " << bit;
    for (const Message& message : messages) EXPECT_EQ(message.payload, test::nav_pvt_payload({}));
  }
}

TEST(UbxWire, AMessageTooLongIsPassedOver) {
  UbxReader reader;
  const auto messages = messages_in(reader, test::ubx(0x02, 0x15, Bytes(2000, 0xB5)) + test::nav_pvt());
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].id, kNavPvt);
}

TEST(UbxWire, RandomBytesAreSurvivedAndMessagesAmongThemRead) {
  std::mt19937 random(21);
  UbxReader reader;
  std::size_t got = 0;
  constexpr std::size_t kSent = 2000;
  for (std::size_t round = 0; round < kSent; ++round) {
    Bytes noise = random_bytes(random, random() % 200);
    if (round % 3 == 0) noise = noise + Bytes{0xB5, 0x62, 0x01, 0x07, 0x5C, 0x00};  // a head alone
    if (round % 7 == 0) noise.push_back(0xB5);
    for (const Message& m : messages_in(reader, noise + test::nav_pvt())) {
      if (m.id == kNavPvt) got += read_nav_pvt(m.payload).has_value();
      read_mon_ver(m.payload);
    }
  }
  EXPECT_EQ(got, kSent);
}

TEST(UbxWire, PayloadsOfAnyBytesAreReadWithoutHarm) {
  std::mt19937 random(22);
  for (int round = 0; round < 5000; ++round) {
    const Bytes payload = random_bytes(random, random() % 300);
    read_nav_pvt(payload);
    const ReceiverVersion version = read_mon_ver(payload);
    for (const char c : version.software + version.protocol) EXPECT_TRUE(c >= 0x20 && c < 0x7F);
  }
}

}  // namespace
}  // namespace polyarm::sensors::wires_test
