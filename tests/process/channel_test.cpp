#include "polyarm/process/channel.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/process/packing.hpp"

namespace polyarm::process {
namespace {

using Bytes = std::vector<std::byte>;

/// The child's end, in this process.
Channel::Inherited copies(const Channel& parent) {
  const auto fds = parent.of_child();
  return {::dup(fds[0]), ::dup(fds[1]), ::dup(fds[2])};
}

Bytes numbered(std::uint32_t number, std::size_t size) {
  Bytes out(std::max<std::size_t>(4, size), static_cast<std::byte>(number));
  std::memcpy(out.data(), &number, 4);
  return out;
}
std::uint32_t number_of(const Bytes& message) {
  std::uint32_t out = 0;
  std::memcpy(&out, message.data(), 4);
  return out;
}

TEST(Channel, MessagesOfEverySizeArriveWholeAndInOrderAndWakeWhoSleeps) {
  Channel parent;
  Channel child(copies(parent));
  constexpr std::uint32_t kMessages = 3000;
  std::thread writer([&] {
    std::mt19937 random(3);
    for (std::uint32_t i = 0; i < kMessages; ++i) {
      const std::size_t size = random() % 50 == 0 ? random() % 3'000'000 : random() % 2000;
      while (!child.send(numbered(i, size), false)) {  // too much waits
        Bytes ignored;
        child.receive(ignored);
        std::this_thread::yield();
      }
    }
    Bytes ignored;  // what waits goes on when there is room
    while (child.receive(ignored) != Channel::Received::message) child.wait(1000);
  });
  Bytes message;
  const auto begun = std::chrono::steady_clock::now();
  for (std::uint32_t i = 0; i < kMessages;) {
    const auto received = parent.receive(message);
    ASSERT_NE(received, Channel::Received::broken);
    if (received == Channel::Received::nothing) {
      parent.wait(20'000);
      continue;
    }
    ASSERT_EQ(number_of(message), i);
    if (message.size() > 4) {
      ASSERT_EQ(message.back(), static_cast<std::byte>(i));
    }
    ++i;
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(19)) << "somebody was not woken";
  EXPECT_TRUE(parent.send(numbered(1, 4), true));
  writer.join();
}

TEST(Channel, WhatFindsNoRoomWaitsUpToABoundAndThenIsDroppedAndCounted) {
  ChannelLimits limits;
  limits.most_waiting = 200'000;
  Channel parent;
  Channel child(copies(parent), limits);
  std::uint32_t sent = 0, refused = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) (child.send(numbered(sent, 1000), false) ? sent : refused) += 1;
  EXPECT_GT(sent, 1000u) << "a ring of a million bytes, and what may wait";
  EXPECT_LT(sent, 1400u);
  EXPECT_EQ(parent.dropped_there(), refused);
  EXPECT_TRUE(child.send(numbered(sent++, 1000), true)) << "what has to arrive is not dropped";
  Bytes message;
  for (std::uint32_t i = 0; i < sent;) {
    const auto received = parent.receive(message);
    ASSERT_NE(received, Channel::Received::broken);
    if (received == Channel::Received::nothing) {
      ASSERT_EQ(child.receive(message), Channel::Received::nothing);
    } else {
      ASSERT_EQ(number_of(message), i++);
    }
  }
}

TEST(Channel, WhoDoesNotListenAtAllIsGivenUp) {
  ChannelLimits limits;
  limits.most_ever = 2'000'000;
  Channel parent(limits);
  for (int i = 0; i < 4000; ++i) parent.send(Bytes(1000), true);
  EXPECT_TRUE(parent.broken());
}

TEST(Channel, LargerThanAMessageIsNotSent) {
  Channel parent;
  EXPECT_FALSE(parent.send(Bytes(ChannelLimits().most_message + 1), true));
  EXPECT_FALSE(parent.broken());
}

TEST(Channel, NobodyCanTakeTheMemoryAway) {
  Channel parent;
  const int memory = parent.of_child()[0];
  EXPECT_NE(::ftruncate(memory, 0), 0) << "the other side would be ended by its next look";
  EXPECT_NE(::ftruncate(memory, 1 << 30), 0);
}

TEST(Channel, ARottenChildBreaksItAndNothingElse) {
  std::mt19937_64 random(4);
  for (int round = 0; round < 300; ++round) {
    Channel parent;
    const int memory = ::dup(parent.of_child()[0]);
    constexpr std::size_t kSize = 4096 + (2 << 20);
    void* const at = ::mmap(nullptr, kSize, PROT_READ | PROT_WRITE, MAP_SHARED, memory, 0);
    ASSERT_NE(at, MAP_FAILED);
    auto* words = static_cast<std::uint64_t*>(at);
    // All that is shared: positions, flags, what both rings hold.
    for (int i = 0; i < 64; ++i) words[random() % 512] = random() % 3 == 0 ? random() : random() % 4096;
    for (int i = 0; i < 500; ++i) words[512 + random() % (kSize / 8 - 512)] = random();
    Bytes message;
    bool over = false;
    for (int i = 0; i < 1000 && !over; ++i) {
      over = parent.receive(message) != Channel::Received::message;
      ASSERT_LE(message.size(), ChannelLimits().most_message);
      parent.send(Bytes(random() % 5000), random() % 2 == 0);
    }
    parent.wait(0);
    ::munmap(at, kSize);
    ::close(memory);
  }
}

TEST(Unpacker, WhatIsNotThereIsNothing) {
  Bytes message;
  Packer(message).number(std::uint32_t{7}).text("name").array(std::array<std::uint8_t, 2>{1, 2});
  for (std::size_t size = 0; size <= message.size(); ++size) {
    Unpacker in(std::span<const std::byte>(message.data(), size));
    const auto number = in.number<std::uint32_t>();
    const std::string text = in.text(100);
    in.array<2>();
    EXPECT_EQ(in.good(), size == message.size());
    EXPECT_EQ(in.good() ? std::to_string(number) + text : "7name", "7name");
    EXPECT_TRUE(in.good() || in.rest().empty());
  }
  Unpacker longer(message);
  longer.number<std::uint32_t>();
  EXPECT_EQ(longer.text(3), "") << "longer than it may be";
  EXPECT_FALSE(longer.good());
  const std::uint32_t lie = 0xffffffff;
  std::memcpy(message.data() + 4, &lie, 4);
  Unpacker lying(message);
  lying.number<std::uint32_t>();
  EXPECT_EQ(lying.text(SIZE_MAX), "");
  EXPECT_FALSE(lying.good());
}

}  // namespace
}  // namespace polyarm::process
