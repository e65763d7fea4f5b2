#include <gtest/gtest.h>

#include <random>

#include "drivers/dynamixel/protocol2.hpp"
#include "drivers/feetech/protocol0.hpp"

namespace polyarm {
namespace {

using Bytes = std::vector<std::uint8_t>;
using servo_bus::Found;
using servo_bus::Instruction;
using servo_bus::Protocol;

Bytes hex(const std::string& text) {
  Bytes out;
  for (std::size_t i = 0; i < text.size();)
    if (text[i] == ' ')
      ++i;
    else
      out.push_back(static_cast<std::uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16))), i += 2;
  return out;
}

Bytes made(const Protocol& protocol, int id, Instruction instruction, const std::string& parameters) {
  Bytes out(512);
  out.resize(protocol.make(out, static_cast<std::uint8_t>(id), instruction, hex(parameters)));
  return out;
}

/// All answers in `bytes`, looked for as the bus does.
std::vector<std::pair<int, Bytes>> answers(const Protocol& protocol, Bytes bytes, std::size_t longest = 64) {
  std::vector<std::pair<int, Bytes>> out;
  std::size_t at = 0;
  for (;;) {
    const Found found = protocol.find(std::span(bytes).subspan(at), longest);
    EXPECT_LE(found.used, bytes.size() - at);
    at += found.used;
    if (found.kind == Found::Kind::more) return out;
    if (found.kind == Found::Kind::frame)
      out.push_back({found.id << 8 | found.error, Bytes(found.data.begin(), found.data.end())});
  }
}

// The examples of the maker's description of the wire.
TEST(FeetechFrames, AreThoseOfTheMakersExamples) {
  const feetech::Protocol0 wire;
  EXPECT_EQ(made(wire, 1, Instruction::ping, ""), hex("FF FF 01 02 01 FB"));
  EXPECT_EQ(made(wire, 1, Instruction::read, "38 02"), hex("FF FF 01 04 02 38 02 BE"));
  EXPECT_EQ(made(wire, 0xFE, Instruction::write, "05 01"), hex("FF FF FE 04 03 05 01 F4"));
  EXPECT_EQ(made(wire, 1, Instruction::write, "2A 00 08 00 00 E8 03"),
            hex("FF FF 01 09 03 2A 00 08 00 00 E8 03 D5"));
  EXPECT_EQ(
      made(wire, 0xFE, Instruction::sync_write,
           "2A 06 01 00 08 00 00 E8 03 02 00 08 00 00 E8 03 03 00 08 00 00 E8 03 04 00 08 00 00 E8 03"),
      hex("FF FF FE 20 83 2A 06 01 00 08 00 00 E8 03 02 00 08 00 00 E8 03 03 00 08 00 00 E8 03 04 00 08 00 "
          "00 E8 03 58"));
  EXPECT_EQ(made(wire, 0xFE, Instruction::sync_read, "38 08 01 02"), hex("FF FF FE 06 82 38 08 01 02 36"));
  EXPECT_EQ(made(wire, 1, Instruction::reboot, ""), hex("FF FF 01 02 08 F4"));
}

TEST(FeetechFrames, AnswersOfTheMakersExamplesAreRead) {
  const feetech::Protocol0 wire;
  const auto position = answers(wire, hex("FF FF 01 04 00 18 05 DD"));
  ASSERT_EQ(position.size(), 1u);
  EXPECT_EQ(position[0].first, 0x100);
  EXPECT_EQ(position[0].second, hex("18 05"));
  const auto two =
      answers(wire, hex("FF FF 01 0A 00 00 08 00 00 00 00 79 1E 55 FF FF 02 0A 00 FF 07 00 00 00 00 77 "
                        "23 53"));
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[1].second, hex("FF 07 00 00 00 00 77 23"));
}

// The examples of the e-manual's page on Protocol 2.0 (an XM430-W210 at id 1 and 2).
TEST(DynamixelFrames, AreThoseOfTheMakersExamples) {
  const dynamixel::Protocol2 wire;
  EXPECT_EQ(made(wire, 1, Instruction::ping, ""), hex("FF FF FD 00 01 03 00 01 19 4E"));
  EXPECT_EQ(made(wire, 0xFE, Instruction::ping, ""), hex("FF FF FD 00 FE 03 00 01 31 42"));
  EXPECT_EQ(made(wire, 1, Instruction::read, "84 00 04 00"),
            hex("FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"));
  EXPECT_EQ(made(wire, 1, Instruction::write, "74 00 00 02 00 00"),
            hex("FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89"));
  EXPECT_EQ(made(wire, 1, Instruction::reboot, ""), hex("FF FF FD 00 01 03 00 08 2F 4E"));
  EXPECT_EQ(made(wire, 0xFE, Instruction::sync_read, "84 00 04 00 01 02"),
            hex("FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA"));
  EXPECT_EQ(made(wire, 0xFE, Instruction::sync_write, "74 00 04 00 01 96 00 00 00 02 AA 00 00 00"),
            hex("FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87"));
  EXPECT_EQ(made(wire, 0xFE, Instruction::fast_sync_read, "84 00 04 00 03 07 04"),
            hex("FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2"));
}

TEST(DynamixelFrames, AnswersOfTheMakersExamplesAreRead) {
  const dynamixel::Protocol2 wire;
  const auto ping = answers(wire, hex("FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"));
  ASSERT_EQ(ping.size(), 1u);
  EXPECT_EQ(ping[0].second, hex("06 04 26"));
  const auto two =
      answers(wire, hex("FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0 FF FF FD 00 02 08 00 55 00 1F 08 "
                        "00 00 BA BE"));
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[0].second, hex("A6 00 00 00"));
  EXPECT_EQ(two[1].first, 0x200);
  EXPECT_EQ(answers(wire, hex("FF FF FD 00 01 04 00 55 00 A1 0C")).size(), 1u);
}

TEST(DynamixelFrames, AFastAnswerIsTakenApart) {
  const dynamixel::Protocol2 wire;
  const Bytes whole =
      hex("FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 "
          "D1 9E");
  std::vector<std::pair<int, Bytes>> got;
  const auto take = [](void* context, std::uint8_t id, std::uint8_t, servo_bus::Bytes data) {
    static_cast<std::vector<std::pair<int, Bytes>>*>(context)->push_back(
        {id, Bytes(data.begin(), data.end())});
  };
  ASSERT_TRUE(wire.split_fast(whole, 3, 4, take, &got));
  ASSERT_EQ(got.size(), 3u);
  EXPECT_EQ(got[1], (std::pair<int, Bytes>{7, hex("1F 08 00 00")}));
  got.clear();
  const Bytes cut(whole.begin(), whole.end() - 3);
  EXPECT_FALSE(wire.split_fast(cut, 3, 4, take, &got));
  EXPECT_EQ(got.size(), 2u) << "what was whole counts";
}

TEST(DynamixelFrames, WhatLooksLikeAHeaderIsStuffedAndUnstuffed) {
  const dynamixel::Protocol2 wire;
  const Bytes sent = made(wire, 1, Instruction::write, "74 00 FF FF FD 00");
  EXPECT_EQ(Bytes(sent.begin() + 10, sent.end() - 2), hex("FF FF FD FD 00"));
  EXPECT_EQ(sent[5], 10) << "the length counts the stuffing";
  Bytes status = hex("FF FF FD 00 01 09 00 55 00 FF FF FD FD 07");
  const std::uint16_t crc = dynamixel::crc16(status);
  status.push_back(static_cast<std::uint8_t>(crc));
  status.push_back(static_cast<std::uint8_t>(crc >> 8));
  const auto got = answers(wire, status);
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].second, hex("FF FF FD 07"));
}

TEST(DynamixelFrames, AnInstructionIsNoAnswer) {
  const dynamixel::Protocol2 wire;
  EXPECT_TRUE(answers(wire, made(wire, 1, Instruction::read, "84 00 04 00")).empty());
}

class Wires : public testing::TestWithParam<bool> {
 protected:
  const feetech::Protocol0 feetech_;
  const dynamixel::Protocol2 dynamixel_;
  const Protocol& wire() const { return GetParam() ? static_cast<const Protocol&>(feetech_) : dynamixel_; }
  Bytes answer() const {
    return GetParam() ? hex("FF FF 01 04 00 18 05 DD") : hex("FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0");
  }
};
INSTANTIATE_TEST_SUITE_P(Both, Wires, testing::Bool(),
                         [](const auto& which) { return which.param ? "Feetech" : "Dynamixel"; });

TEST_P(Wires, GarbageBeforeAnAnswerDoesNotHideIt) {
  for (const char* garbage :
       {"00", "FF", "FF FF", "FF FF FF", "FF FF 01", "FF FF FD", "FF FF FD 00 01", "55 AA FF 00"}) {
    Bytes bytes = hex(garbage);
    const Bytes good = answer();
    bytes.insert(bytes.end(), good.begin(), good.end());
    bytes.insert(bytes.end(), 80, 0);  // so that a false length of the garbage is satisfied
    const auto got = answers(wire(), bytes);
    ASSERT_EQ(got.size(), 1u) << garbage;
    EXPECT_EQ(got[0].first, 0x100) << garbage;
  }
}

TEST_P(Wires, ABrokenAnswerIsNone) {
  const Bytes good = answer();
  for (std::size_t i = 0; i < good.size(); ++i)
    for (int bit = 0; bit < 8; ++bit) {
      Bytes bad = good;
      bad[i] ^= static_cast<std::uint8_t>(1 << bit);
      EXPECT_TRUE(answers(wire(), bad).empty()) << i << " " << bit;
    }
}

TEST_P(Wires, APieceOfAnAnswerAsksForMore) {
  const Bytes good = answer();
  for (std::size_t size = 0; size < good.size(); ++size) {
    Bytes part(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
    const Found found = wire().find(part, 64);
    EXPECT_EQ(found.kind, Found::Kind::more);
    EXPECT_EQ(found.used, 0u) << "nothing of it may be dropped";
  }
}

TEST_P(Wires, SurviveAnyBytes) {
  std::mt19937 random(20);
  const Bytes likely = hex("FF FF FD 00 01 FE 55 02 04 08 00 FF");
  for (int round = 0; round < 20'000; ++round) {
    Bytes bytes(random() % 60);
    for (std::uint8_t& byte : bytes)
      byte = random() % 3 ? likely[random() % likely.size()] : static_cast<std::uint8_t>(random());
    answers(wire(), bytes, random() % 40);
    const auto ignore = [](void*, std::uint8_t, std::uint8_t, servo_bus::Bytes) {};
    wire().split_fast(bytes, 1 + random() % 4, random() % 8, ignore, nullptr);
  }
}

}  // namespace
}  // namespace polyarm
