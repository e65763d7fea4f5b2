/// What simulated controllers share: faults of packets, and a clock that takes what has come.
#include <gtest/gtest.h>

#include <atomic>

#include "drivers/wire/far_clock.hpp"
#include "drivers/wire/far_packets.hpp"

namespace polyarm::wire {
namespace {

using Packet = PacketQueue::Packet;
using Went = PacketQueue::Went;

/// Packets with one byte each, as they leave the queue.
class Outgoing {
 public:
  Went pass(std::uint8_t byte) {
    const auto note = [this](const Packet& one) { out.push_back(one.at(0)); };
    return queue.pass({byte}, faults, note, note);
  }
  PacketFaults faults;
  PacketQueue queue;
  Packet out;
};

TEST(FarPackets, GoOutInTheirTurn) {
  Outgoing o;
  for (std::uint8_t i = 1; i <= 3; ++i) EXPECT_EQ(o.pass(i), Went::in_turn);
  EXPECT_EQ(o.out, (Packet{1, 2, 3}));
}

TEST(FarPackets, LateOnesComeTogether) {
  Outgoing o;
  o.faults.take({"late", 3});
  EXPECT_EQ(o.pass(1), Went::nowhere);
  EXPECT_EQ(o.pass(2), Went::nowhere);
  EXPECT_TRUE(o.out.empty());
  EXPECT_EQ(o.pass(3), Went::together);
  EXPECT_EQ(o.pass(4), Went::in_turn);
  EXPECT_EQ(o.out, (Packet{1, 2, 3, 4}));
}

TEST(FarPackets, ComeBehindTheNextOnes) {
  Outgoing o;
  o.faults.take({"reorder", 4});
  for (std::uint8_t i = 1; i <= 6; ++i) o.pass(i);
  EXPECT_EQ(o.out, (Packet{2, 1, 4, 3, 5, 6}));
}

TEST(FarPackets, ComeTwice) {
  Outgoing o;
  o.faults.take({"duplicate", 2});
  for (std::uint8_t i = 1; i <= 3; ++i) o.pass(i);
  EXPECT_EQ(o.out, (Packet{1, 1, 2, 2, 3}));
}

TEST(FarPackets, WhatIsForgottenIsNeverSent) {
  Outgoing o;
  o.faults.take({"late", 10});
  o.pass(1);
  o.faults = {};
  o.queue.clear();
  o.pass(2);
  EXPECT_EQ(o.out, Packet{2});
}

TEST(FarPackets, TakeTheOrdersOfAPerson) {
  PacketFaults faults;
  for (const char* kind : {"silent", "deaf", "garbage", "stranger", "late", "duplicate", "reorder"})
    faults.take({kind, -1});
  EXPECT_TRUE(faults.silent && faults.deaf && faults.garbage && faults.stranger);
  EXPECT_EQ(faults.late + faults.duplicate + faults.reorder, 30) << "ten of each";
}

TEST(FarClock, SettlesWhenEverythingThatHadComeIsTaken) {
  std::atomic<int> come{0}, taken{0};
  FarClock clock(0);
  clock.start(1'000'000,
              {[](std::vector<int>&) {}, [&] { taken = come.load(); }, [] { return false; }, [] {}});
  for (int i = 1; i <= 50; ++i) {
    come = i;
    clock.settle();
    EXPECT_EQ(taken, i);
  }
}

}  // namespace
}  // namespace polyarm::wire
