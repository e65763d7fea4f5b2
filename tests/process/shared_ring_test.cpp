#include "polyarm/process/shared_ring.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

namespace polyarm::process {
namespace {

constexpr std::size_t kSize = 256 * 1024, kMost = 1 << 20;
using Bytes = std::vector<std::byte>;

struct Ring {
  RingState state;
  Bytes bytes = Bytes(kSize);
  RingWriter writer{state, bytes};
  RingReader reader{state, bytes};
  Bytes message;
  bool last = false;
  RingResult take() { return reader.take(message, kMost, last); }
  /// What a frame at the beginning says of itself, and how much was written.
  void claim(std::uint32_t length, std::uint32_t end, std::uint64_t written) {
    std::memcpy(bytes.data(), &length, 4);
    std::memcpy(bytes.data() + 4, &end, 4);
    state.written = written;
  }
};

TEST(SharedRing, FramesArriveInOrderRoundAndRound) {
  Ring ring;
  std::mt19937 random(1);
  std::size_t put = 0, taken = 0;
  while (taken < 2000) {
    Bytes frame(random() % 3 == 0 ? kMostInFrame : random() % 900, static_cast<std::byte>(put));
    if (random() % 2 == 0 && ring.writer.put(frame, true) == RingResult::done) ++put;
    if (random() % 2 == 0) continue;
    ring.message.clear();
    if (ring.take() != RingResult::done) continue;
    for (const std::byte byte : ring.message) ASSERT_EQ(byte, static_cast<std::byte>(taken));
    ++taken;
  }
}

TEST(SharedRing, WhereThereIsNoRoomNothingIsPut) {
  Ring ring;
  const Bytes frame(kMostInFrame);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(ring.writer.put(frame, true), RingResult::done);
  EXPECT_EQ(ring.writer.put(frame, true), RingResult::none);
  EXPECT_EQ(ring.take(), RingResult::done);
  EXPECT_EQ(ring.writer.put(frame, true), RingResult::done);
}

TEST(SharedRing, AWriterThatSaysWhatCannotBeIsFoundOut) {
  const std::uint32_t most = kMostInFrame;
  const struct {
    std::uint32_t length, end;
    std::uint64_t written;
    const char* what;
  } lies[] = {{8, 1, kSize + 1, "more than there is room for"},
              {8, 1, UINT64_MAX, "all there ever can be"},
              {8, 1, 4, "half a head"},
              {0xffffffff, 1, 64, "a length beyond everything"},
              {most + 8, 1, most + 64, "a length beyond a frame"},
              {64, 1, 16, "a length beyond what was written"},
              {8, 2, 64, "an end that is neither"},
              {0, 0, 8, "an empty piece that others follow"},
              {8, 0, 16, "a short piece that others follow"}};
  for (const auto& lie : lies) {
    Ring ring;
    ring.claim(lie.length, lie.end, lie.written);
    EXPECT_EQ(ring.take(), RingResult::broken) << lie.what;
    EXPECT_TRUE(ring.message.empty()) << lie.what;
  }
}

TEST(SharedRing, AMessageEndsAtItsBoundHoweverManyPiecesItHas) {
  Ring ring;
  const Bytes piece(kMostInFrame);
  RingResult result = RingResult::done;
  for (int i = 0; i < 100 && result == RingResult::done; ++i) {
    ASSERT_EQ(ring.writer.put(piece, false), RingResult::done);
    result = ring.take();
  }
  EXPECT_EQ(result, RingResult::broken);
  EXPECT_LE(ring.message.size(), kMost);
}

TEST(SharedRing, AReaderThatSaysWhatCannotBeIsFoundOut) {
  Ring ring;
  ring.state.read = 8;
  EXPECT_EQ(ring.writer.put(Bytes(8), true), RingResult::broken);
}

TEST(SharedRing, MemoryFullOfNoiseIsReadWithoutHarm) {
  Ring ring;
  std::mt19937_64 random(2);
  int broken = 0;
  for (int i = 0; i < 200'000; ++i) {
    const std::uint64_t noise = random();
    std::memcpy(ring.bytes.data() + random() % (kSize - 8), &noise, 8);
    if (i % 3 == 0) ring.claim(static_cast<std::uint32_t>(random() % 300), random() % 3 == 0, 0);
    ring.state.written = random() % 5 == 0 ? random() : random() % (2 * kSize);
    if (random() % 9 == 0) ring.message.clear();
    broken += ring.take() == RingResult::broken ? 1 : 0;
    ASSERT_LE(ring.message.size(), kMost);
  }
  EXPECT_GT(broken, 1000);
}

}  // namespace
}  // namespace polyarm::process
