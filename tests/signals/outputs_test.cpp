#include <gtest/gtest.h>

#include <cmath>

#include "polyarm/signals/tags.hpp"

namespace polyarm::signals {
namespace {

Signals parsed(const std::string& text, Problems& problems) {
  return parse_signals("polyarm: signals/1\n" + text, "signals.yaml", problems);
}

TEST(OutputRules, TellWhatAnOutputHasWhenTheCellIsNotAsUsual) {
  Problems problems;
  const Signals signals = parsed(
      "tags:\n  Belt: {command: belt/speed, type: number, on_hold: 0, on_stop: 0.5}\n  Lamp: {command: a/b, "
      "on_link_loss: true, on_hold: keep, unit: lx}\n",
      problems);
  ASSERT_FALSE(problems.has_errors());
  const Tag &belt = signals.tags[0], &lamp = signals.tags[1];
  const data::Value two = 2, off = false;
  EXPECT_EQ(belt.output(two, {}), two);
  EXPECT_EQ(belt.output(two, {.held = true}), data::Value(0));
  EXPECT_EQ(belt.output(two, {.stopped = true, .held = true}), data::Value(0.5))
      << "the end goes before a hold";
  EXPECT_EQ(belt.output(two, {.link_lost = true}), two);
  EXPECT_EQ(lamp.output(off, {.held = true}), off);
  EXPECT_EQ(lamp.output(off, {.link_lost = true}), data::Value(true));
  EXPECT_EQ(lamp.unit, "lx");
}

TEST(OutputRules, WarnOfWhatDropsAPartAndRefuseWhatIsNoOutput) {
  Problems problems;
  parsed("tags:\n  Vacuum: {command: arm/tool/vacuum, on_hold: false}\n", problems);
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_EQ(problems.list().front().code, "drops-part");
  EXPECT_FALSE(problems.has_errors());
  parsed("tags:\n  Held: {state: arm/tool/part_present, on_hold: false}\n", problems);
  EXPECT_TRUE(problems.has_errors());
  Problems others;
  parsed("tags:\n  Belt: {command: a/b, type: number, on_hold: true}\n", others);
  EXPECT_TRUE(others.has_errors()) << "a rule is of the tag's type";
}

TEST(SignalsFile, HasHeartbeatsRangesAndACameraOnARobot) {
  Problems problems;
  const Signals signals = parsed(
      "heartbeat: {tag: Alive, every: 200ms}\nwatch: {PlcAlive: 2s}\npoints: {pick: {within: [[0.5, 0, 0], "
      "[0, 1, "
      "1]]}}\ncameras: {eye: {on: arm, point: pick, request: Look, done: Seen, view: 30deg}}\n",
      problems);
  ASSERT_FALSE(problems.has_errors()) << problems.list().front().text();
  EXPECT_EQ(signals.heartbeat->period, 200'000'000);
  EXPECT_EQ(signals.watched.at(0).period, 2'000'000'000);
  EXPECT_EQ(signals.cameras.at(0).on, "arm");
  const PoseRange& range = signals.points.at("pick");
  EXPECT_FALSE(range.refuses({{0.2, 0.5, 0.5}, {}}));
  EXPECT_TRUE(range.refuses({{0.7, 0.5, 0.5}, {}}));
  EXPECT_TRUE(range.refuses({{0.2, 0.5, std::nan("")}, {}}));
  EXPECT_TRUE(range.refuses({{0.2, 0.5, 0.5}, {0, 0, 0, 0}}));
}

}  // namespace
}  // namespace polyarm::signals
