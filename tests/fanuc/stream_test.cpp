/// Packets of Stream Motion byte for byte, and what happens to damaged ones.
#include "drivers/fanuc/stream.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace polyarm::fanuc {
namespace {

using Packet = std::vector<std::uint8_t>;

std::uint32_t word(const Packet& packet, std::size_t at) {
  return wire::Reader(Bytes(packet).subspan(at)).u32();
}

TEST(StreamPackets, ACommandHasTheMakersLayout) {
  Command c;
  c.version = 3;
  c.sequence = 7;
  c.last = c.motion = true;
  c.joints = {1, -2, 0.5, 0, 0, 0, 0, 0, 9};
  c.io[0] = 0x05;
  const Packet p = encode(c);
  ASSERT_EQ(p.size(), 344u);
  const Packet head{0, 0,    0,    201,  0,    0, 0, 3, 0, 0, 0, 7,    1,
                    1, 0xFF, 0xFF, 0x3F, 0xF0, 0, 0, 0, 0, 0, 0, 0xC0, 0};
  EXPECT_EQ(Packet(p.begin(), p.begin() + static_cast<long>(head.size())), head);
  EXPECT_EQ(p[88], 0x05) << "inputs and outputs come behind nine doubles";
  const auto back = decode_command(p);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->joints, c.joints);
  EXPECT_TRUE(back->last);
}

TEST(StreamPackets, AStatusHasTheMakersLayoutInBothVersions) {
  Status s;
  s.sequence = 0x01020304;
  s.status = 5;
  s.robot = 2;
  s.contact_stop = 3;
  s.time_ms = 1000;
  s.pose[0] = 1;
  s.joints[8] = -1;
  s.safety_scale = 0.5F;
  s.force[5] = 2;
  s.io[255] = 9;
  for (const std::uint32_t version : {3u, 4u}) {
    s.version = version;
    s.with_force = version == 4;
    const Packet p = encode(s);
    ASSERT_EQ(p.size(), version == 3 ? 388u : 416u);
    EXPECT_EQ(word(p, 0), version == 3 ? 202u : 204u);
    EXPECT_EQ(word(p, 8), 0x01020304u);
    EXPECT_EQ(Packet(p.begin() + 12, p.begin() + 16), (Packet{5, 2, 3, 0}));
    EXPECT_EQ(word(p, 16), 1000u);
    EXPECT_EQ(word(p, 20), 0x3F800000u) << "X";
    EXPECT_EQ(word(p, 20 + 36 + 32), 0xBF800000u) << "the ninth joint";
    EXPECT_EQ(word(p, 20 + 3 * 36), 0x3F000000u) << "safety scale";
    EXPECT_EQ(p.back(), 9);
    const auto back = decode_status(p);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->joints[8], -1);
    EXPECT_EQ(back->force[5], version == 3 ? 0 : 2);
  }
}

TEST(StreamPackets, TheOthersHaveTheMakersLayout) {
  EXPECT_EQ(encode_start(4), (Packet{0, 0, 0, 200, 0, 0, 0, 4}));
  EXPECT_EQ(encode_stop(3), (Packet{0, 0, 0, 2, 0, 0, 0, 3}));
  const Packet get = encode(Capability{});
  EXPECT_EQ(get,
            (Packet{0, 0, 0, 7, 0, 0, 0, 3, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(word(encode(Capability{true}), 0), 8u);
  EXPECT_EQ(encode(LimitRequest{3, 6, LimitKind::jerk}),
            (Packet{0, 0, 0, 3, 0, 0, 0, 3, 0, 0, 0, 6, 0, 0, 0, 2}));
  LimitTable table;
  table.empty.fill(1);
  table.loaded.fill(2);
  const Packet limits = encode(table, 3);
  ASSERT_EQ(limits.size(), 184u);
  EXPECT_EQ(word(limits, 16), 2000u);
  EXPECT_EQ(word(limits, 24 + 80), 0x40000000u) << "the first value at full load";
  IoSetup setup;
  setup[1] = {IoDirection::command, static_cast<std::uint32_t>(IoKind::flag), 3, 40};
  const Packet io = encode(setup, 3);
  ASSERT_EQ(io.size(), 520u);
  EXPECT_EQ(Packet(io.begin() + 24, io.begin() + 40),
            (Packet{0, 0, 0, 1, 0, 0, 0, 6, 0, 0, 0, 3, 0, 0, 0, 40}));
  EXPECT_EQ(encode_io_result(0).size(), 12u);
  EXPECT_EQ(decode_io_result(encode_io_result(5)), 5u);
}

TEST(StreamPackets, RowsTakeTheBytesThatTheirKindNeeds) {
  const auto bytes = [](IoDirection direction, std::uint32_t kind, std::uint32_t count) {
    return IoRow{direction, kind, 1, count}.bytes();
  };
  EXPECT_EQ(bytes(IoDirection::state, 1, 32), 4u);
  EXPECT_EQ(bytes(IoDirection::state, 1, 33), 8u);
  EXPECT_EQ(bytes(IoDirection::command, 4, 3), 8u) << "two analog values in each four bytes";
  EXPECT_EQ(bytes(IoDirection::register_state, 100, 2), 8u);
  EXPECT_EQ(bytes(IoDirection::register_state, 1, 2), 0u) << "no register of that kind";
  EXPECT_EQ(bytes(IoDirection::state, 7, 1), 0u);
  EXPECT_EQ(bytes(IoDirection::state, 0, 0xFFFFFFFF), 0u);
}

TEST(StreamPackets, NumbersThatAreNotFiniteAreRefused) {
  Status s;
  s.joints[2] = std::nanf("");
  EXPECT_FALSE(decode_status(encode(s)));
  Command c;
  c.joints[0] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(decode_command(encode(c)));
  LimitTable table;
  table.empty.fill(1);
  table.loaded.fill(1);
  EXPECT_TRUE(decode_limits(encode(table, 3)));
  table.empty[19] = 0;
  EXPECT_FALSE(decode_limits(encode(table, 3))) << "a limit of 0";
  table.empty[19] = 1;
  table.max_speed = 0;
  EXPECT_FALSE(decode_limits(encode(table, 3)));
}

TEST(StreamPackets, DigitalsBeyondTheAreaAreIgnored) {
  IoArea area{};
  set_digital(area, 255, 7, true);
  EXPECT_TRUE(digital(area, 255, 7));
  set_digital(area, 255, 8, true);
  set_digital(area, std::numeric_limits<std::size_t>::max() - 2, 0, true);
  EXPECT_FALSE(digital(area, 256, 0));
}

/// Nothing crashes, and what is accepted is a valid packet: encoded again it gives the same bytes.
TEST(StreamFuzz, RandomAndDamagedPacketsAreRefusedOrValid) {
  std::uint64_t seed = 27;
  const auto draw = [&](std::uint64_t n) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (seed >> 33) % n;
  };
  Status s4;
  s4.version = 4;
  s4.with_force = true;
  LimitTable table;
  table.empty.fill(100);
  table.loaded.fill(50);
  const std::vector<Packet> good{encode(Status{}),     encode(s4),          encode(Command{}),
                                 encode(Capability{}), encode(table, 3),    encode(LimitRequest{}),
                                 encode(IoSetup{}, 3), encode_io_result(0), encode_start(3)};
  std::size_t accepted = 0;
  for (int round = 0; round < 100'000; ++round) {
    Packet p = good[draw(good.size())];
    if (draw(4) == 0) p.resize(draw(600));
    for (std::uint64_t k = 0, changes = draw(6); k < changes && !p.empty(); ++k)
      p[draw(draw(2) ? p.size() : std::min<std::size_t>(p.size(), 32))] =
          static_cast<std::uint8_t>(draw(256));
    if (const auto x = decode_status(p)) {
      ++accepted;
      Packet again = encode(*x);
      again[15] = p[15];  // a byte without meaning
      EXPECT_EQ(again, p);
    }
    if (const auto x = decode_command(p)) {
      ++accepted;
      EXPECT_TRUE(std::isfinite(x->joints[8]));
    }
    if (const auto x = decode_limits(p)) {
      ++accepted;
      EXPECT_GT(x->empty[0], 0);
      EXPECT_LE(x->axis, 9u);
    }
    if (const auto x = decode_io_setup(p)) {
      ++accepted;
      for (const IoRow& row : *x) EXPECT_LE(row.bytes(), 400'000u);
    }
    accepted += decode_capability(p).has_value() + decode_limit_request(p).has_value() +
                decode_io_result(p).has_value();
  }
  EXPECT_GT(accepted, 10'000u) << "the damage left too little to look at";
}

}  // namespace
}  // namespace polyarm::fanuc
