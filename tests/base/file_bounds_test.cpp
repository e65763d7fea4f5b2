/// What a file of any size may cost: its aliases, its unknown keys, and what is said of them.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/yaml.hpp"

namespace polyarm {
namespace {

using Clock = std::chrono::steady_clock;

TEST(YamlBounds, AliasesOfAliasesAreRefusedBeforeAnybodyWalksThem) {
  std::string text = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string before = "*a" + std::to_string(i - 1), name = "a" + std::to_string(i);
    text += name + ": &" + name + " [" + before;
    for (int k = 1; k < 10; ++k) text += ", " + before;
    text += "]\n";
  }
  try {
    Yaml::parse(text, "laughs.yaml");
    FAIL() << "it was read";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "too-large");
  }
  EXPECT_NO_THROW(Yaml::parse("a: &a {x: 1}\nb: *a\nc: {<<: *a, y: 2}\n", "fine.yaml"));
}

TEST(YamlBounds, DeepNestingIsRefused) {
  std::string text;
  for (int i = 0; i < 100'000; ++i) text += "- ";
  EXPECT_THROW(Yaml::parse(text + "x", "deep.yaml"), Error);
  EXPECT_THROW(Yaml::parse(std::string(100'000, '['), "deep.yaml"), Error);
}

TEST(YamlBounds, SixtyThousandUnknownKeysAreFewSentencesAndLittleTime) {
  std::string text;
  for (int i = 0; i < 60'000; ++i) text += "kez" + std::to_string(i) + ": 1\n";
  const Yaml yaml = Yaml::parse(text, "many.yaml");
  Problems problems;
  const auto begun = Clock::now();
  yaml.check_keys({"key", "keys", "name"}, problems);
  EXPECT_LT(Clock::now() - begun, std::chrono::seconds(2));
  EXPECT_LE(problems.list().size(), 51u);
  EXPECT_EQ(problems.list().back().what, "and 59950 more keys are not known here");
  EXPECT_EQ(problems.list().back().where.line, 51);
}

TEST(NearestName, IsBoundedInLengthAndNumber) {
  std::vector<std::string> names;
  for (int i = 0; i < 60'000; ++i) names.push_back("name_of_a_thing_" + std::to_string(i));
  const auto begun = Clock::now();
  for (int i = 0; i < 50; ++i) nearest_name("nameofathing" + std::to_string(i), names);
  EXPECT_FALSE(nearest_name(std::string(10'000'000, 'x'), names));
  EXPECT_LT(Clock::now() - begun, std::chrono::seconds(10));
  EXPECT_EQ(nearest_name("name_of_a_thing_1x", names), "name_of_a_thing_1");
}

TEST(ErrorBounds, TheTextOfManyProblemsIsBounded) {
  const std::vector<Problem> many(60'000, Problem{"code", {"file", 1, 2}, "what", "advice"});
  const std::string what = Error(many).what();
  EXPECT_LT(what.size(), 10'000u);
  EXPECT_TRUE(what.ends_with("and 59900 more problems")) << what.substr(what.size() - 100);
  EXPECT_EQ(Error(many).problems().size(), many.size());
}

}  // namespace
}  // namespace polyarm
