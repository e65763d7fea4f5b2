#include "polyarm/signals/tags.hpp"

#include <gtest/gtest.h>

namespace polyarm::signals {
namespace {

Signals parsed(const std::string& text) {
  Problems problems;
  Signals out = parse_signals(text, "signals.yaml", problems);
  problems.throw_if_errors();
  return out;
}

std::vector<Problem> problems_of(const std::string& text) {
  Problems problems;
  parse_signals(text, "signals.yaml", problems);
  return problems.list();
}

TEST(Tags, ReadsEveryKindOfTag) {
  const Signals signals = parsed(
      "polyarm: signals/1\ntags:\n  Vacuum: {command: arm/tool/vacuum}\n  PartHeld: {state: "
      "arm/tool/part_present}\n"
      "  Speed: {command: belt/speed, type: number, scale: 0.5}\n  Count: {initial: 3}\n  Label: {initial: "
      "red}\n  Flag:\n");
  ASSERT_EQ(signals.tags.size(), 6u);
  EXPECT_EQ(signals.tags[0].role, data::TagRole::command);
  EXPECT_EQ(signals.tags[0].interface, "arm/tool/vacuum");
  EXPECT_EQ(signals.tags[1].role, data::TagRole::state);
  EXPECT_EQ(signals.tags[2].to_interface(4.0), 2.0);
  EXPECT_EQ(signals.tags[3].initial, data::Value(3));
  EXPECT_EQ(signals.tags[4].initial, data::Value("red"));
  EXPECT_EQ(signals.tags[5].initial, data::Value(false));
}

TEST(Tags, ABooleanIsZeroOrOneOnItsInterface) {
  const Tag tag = parsed("polyarm: signals/1\ntags: {A: {state: x/y/z}}\n").tags.at(0);
  EXPECT_EQ(tag.to_interface(true), 1.0);
  EXPECT_EQ(tag.to_interface(false), 0.0);
  EXPECT_EQ(tag.to_interface(data::Value("x")), std::nullopt);
  EXPECT_EQ(tag.from_interface(1), data::Value(true));
  EXPECT_EQ(tag.from_interface(0.2), data::Value(false));
}

TEST(Tags, ReadsCamerasAndLiveSets) {
  const Signals signals = parsed(
      "polyarm: signals/1\nlive: [cycledata]\ncameras:\n  bin: {camera: overhead, point: pinput, data: "
      "BINpoints, "
      "request: AskPickupPoint, done: PickupPointSet, noise: true, seed: 7}\n");
  EXPECT_EQ(signals.live, std::vector<std::string>{"cycledata"});
  const CameraLink camera = signals.cameras.at(0);
  EXPECT_EQ(camera.camera, "overhead");
  EXPECT_EQ(camera.data, "BINpoints");
  EXPECT_TRUE(camera.noise);
  EXPECT_EQ(camera.seed, 7u);
}

TEST(Tags, FindsEveryErrorAtOnceWithItsPlace) {
  const auto problems = problems_of(
      "polyarm: signals/9\ntags:\n  A: {comand: x}\n  B: {command: x, state: y}\n  C: {type: boo}\n  D: "
      "{initial: 3, type: bool}\n"
      "cameras:\n  c: {point: p}\n");
  ASSERT_EQ(problems.size(), 6u);
  for (const Problem& problem : problems) EXPECT_GT(problem.where.line, 0) << problem.text();
  EXPECT_NE(problems[1].text().find("command"), std::string::npos);
  EXPECT_NE(problems[3].what.find("did you mean 'bool'?"), std::string::npos);
}

TEST(Tags, SurvivesWhatIsNoMap) {
  for (const char* text :
       {"", "3", "[1]", "polyarm: [1]", "polyarm: signals/1\ntags: 3\ncameras: [x]\n", "\x80\x04"}) {
    Problems problems;
    EXPECT_NO_THROW(parse_signals(text, "s", problems)) << text;
  }
}

}  // namespace
}  // namespace polyarm::signals
