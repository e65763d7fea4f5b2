/// The moves of a driver whose controller interpolates, from accept() to their end.
#include "drivers/forward/move_buffer.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace polyarm::forward {
namespace {

using hardware::ForwardMove;

ForwardMove move_to(double angle, std::uint64_t id, bool stops = true) {
  ForwardMove out;
  out.id = id;
  out.stops = stops;
  out.joints[0] = angle;
  return out;
}

Six at(double angle) {
  return {angle};
}

TEST(MoveBuffer, AMoveThatStopsEndsOnlyWhenTheRobotStandsThere) {
  MoveBuffer buffer;
  ASSERT_TRUE(buffer.idle());
  ASSERT_TRUE(buffer.accept(move_to(1, 7)));
  EXPECT_FALSE(buffer.idle()) << "what is in the queue counts as left";
  buffer.collect();
  buffer.send(1, at(0));
  EXPECT_FALSE(buffer.land(at(1), true, 0)) << "the controller has not said that it ended";
  EXPECT_FALSE(buffer.idle());
  buffer.end_up_to(1);
  EXPECT_FALSE(buffer.land(at(0.5), true, 0.1));
  EXPECT_FALSE(buffer.idle()) << "the robot is elsewhere";
  buffer.land(at(1.001), false, 0.2);
  EXPECT_FALSE(buffer.idle()) << "it moves";
  buffer.land(at(1.001), true, 0.3);
  EXPECT_TRUE(buffer.idle());
  EXPECT_EQ(buffer.done(), 7u);
}

TEST(MoveBuffer, AMoveThatBlendsEndsWhenTheControllerSaysSo) {
  MoveBuffer buffer;
  buffer.accept(move_to(1, 1, false));
  buffer.accept(move_to(2, 2));
  buffer.collect();
  buffer.send(1, at(0));
  buffer.send(2, at(1));
  buffer.end_up_to(1);
  buffer.land(at(0.9), false, 0);
  EXPECT_EQ(buffer.done(), 1u);
  EXPECT_EQ(buffer.sent().size(), 1u);
}

TEST(MoveBuffer, TheJointThatIsElsewhereIsNamedAfterAWhileAtRest) {
  MoveBuffer buffer;
  buffer.accept(move_to(1, 1));
  buffer.collect();
  buffer.send(1, at(0));
  buffer.end_up_to(1);
  Six q = at(0.99);
  q[3] = 0.4;
  for (double time = 0; time < 2; time += 0.1) EXPECT_FALSE(buffer.land(q, false, time));
  for (double time = 2; time < 4.9; time += 0.1) EXPECT_FALSE(buffer.land(q, true, time)) << time;
  EXPECT_EQ(buffer.land(q, true, 5.2), 3);
  EXPECT_FALSE(buffer.idle());
}

TEST(MoveBuffer, OnlyWhatMayFollowIsSent) {
  MoveBuffer buffer;
  EXPECT_FALSE(buffer.may_send(6)) << "nothing waits";
  buffer.accept(move_to(1, 1, false));
  buffer.collect();
  EXPECT_FALSE(buffer.may_send(6)) << "a move that blends needs the one after it";
  buffer.accept(move_to(2, 2));
  buffer.accept(move_to(3, 3));
  buffer.collect();
  ASSERT_TRUE(buffer.may_send(6));
  buffer.send(1, at(0));
  EXPECT_FALSE(buffer.may_send(1)) << "no slot is free";
  ASSERT_TRUE(buffer.may_send(6));
  buffer.send(2, at(1));
  EXPECT_FALSE(buffer.may_send(6)) << "the robot comes to rest first";
  buffer.end_up_to(2);
  buffer.land(at(2), true, 1);
  EXPECT_TRUE(buffer.may_send(6));
}

TEST(MoveBuffer, WhatIsTakenBackIsSentAgainInItsOrder) {
  MoveBuffer buffer;
  for (int i = 1; i <= 3; ++i) buffer.accept(move_to(i, static_cast<std::uint64_t>(i), i < 3));
  buffer.collect();
  buffer.send(1, at(0));
  buffer.send(2, at(1));
  buffer.take_back();
  ASSERT_EQ(buffer.waiting().size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(buffer.waiting()[i].id, i + 1);
  EXPECT_FALSE(buffer.idle());
}

TEST(MoveBuffer, NothingIsAcceptedUntilAClearIsDone) {
  MoveBuffer buffer;
  buffer.accept(move_to(1, 1));
  buffer.clear();
  EXPECT_FALSE(buffer.accept(move_to(2, 2)));
  EXPECT_TRUE(buffer.clearing());
  EXPECT_FALSE(buffer.idle());
  buffer.forget();
  EXPECT_TRUE(buffer.idle());
  EXPECT_EQ(buffer.done(), 0u) << "a move that was forgotten has not ended";
  EXPECT_TRUE(buffer.accept(move_to(3, 3)));
}

TEST(MoveBuffer, IsFullAfterSomeMovesAndTakesMoreOnceTheyAreCollected) {
  MoveBuffer buffer;
  std::uint64_t id = 0;
  while (buffer.accept(move_to(1, id + 1))) ASSERT_LT(++id, 1000u);
  EXPECT_GE(id, 60u);
  buffer.collect();
  EXPECT_TRUE(buffer.accept(move_to(1, id + 1)));
}

/// Two threads: no move is lost or comes twice, whatever is cleared when.
TEST(MoveBuffer, EveryMoveEndsOrIsForgotten) {
  MoveBuffer buffer;
  std::atomic<bool> quit{false};
  std::thread link([&] {
    int number = 0;
    for (double time = 0; !quit; time += 0.01) {
      buffer.collect();
      if (buffer.clearing()) buffer.forget();
      while (buffer.may_send(6)) buffer.send(++number, at(0));
      if (!buffer.sent().empty()) {
        buffer.end_up_to(buffer.sent().front().number);
        buffer.land(end_of(buffer.sent().front().move), true, time);
      }
      std::this_thread::yield();
    }
  });
  for (std::uint64_t id = 1; id <= 3000; ++id) {
    while (!buffer.accept(move_to(1, id))) std::this_thread::yield();
    if (id % 50 == 0) buffer.clear();
  }
  while (!buffer.idle()) std::this_thread::yield();
  quit = true;
  link.join();
  EXPECT_TRUE(buffer.waiting().empty());
  EXPECT_TRUE(buffer.sent().empty());
}

}  // namespace
}  // namespace polyarm::forward
