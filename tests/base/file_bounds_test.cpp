/// What a file of any size may cost: its aliases, its unknown keys, and what is said of them.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/xml_bounds.hpp"
#include "polyarm/yaml/yaml.hpp"

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

TEST(YamlBounds, AnAliasWithinWhatItNamesIsAnError) {
  EXPECT_THROW(Yaml::parse("a: &a [*a]\n", "round.yaml"), Error);
  EXPECT_THROW(Yaml::parse("a: &a {b: {c: *a}}\n", "round.yaml"), Error);
}

TEST(YamlBounds, ValuesAndBytesAreRefusedBeyondABound) {
  std::string values = "x:\n";
  for (int i = 0; i < 1'100'000; ++i) values += "- 1\n";
  const std::string comment(17 << 20, '#');
  for (const std::string& text : {values, comment}) {
    try {
      Yaml::parse(text, "large.yaml");
      FAIL() << "it was read";
    } catch (const Error& e) {
      EXPECT_EQ(e.problems().front().code, "too-large");
    }
  }
}

TEST(YamlBounds, EachKeyOfALargeMapIsFoundInLittleTime) {
  std::string text = "things:\n";
  for (int i = 0; i < 60'000; ++i) text += "  k" + std::to_string(i) + ": " + std::to_string(i) + "\n";
  const Yaml yaml = Yaml::parse(text, "many.yaml");
  const auto begun = Clock::now();
  double sum = 0;
  const Yaml things = yaml["things"];
  for (const std::string& key : things.keys())
    sum += yaml["things"][key].number() + things.key_location(key).line;
  EXPECT_LT(Clock::now() - begun, std::chrono::seconds(5));
  EXPECT_EQ(sum, 59'999 * 30'000.0 + 60'000 * 60'005.0 / 2 - 60'000);
}

TEST(YamlBounds, AKeyThatStandsTwiceIsTheSameInLargeAndSmallMaps) {
  std::string text = "k: 1\n? [no, name]\n: 0\nk: 2\n";
  for (const bool large : {false, true}) {
    for (int i = 0; large && i < 100; ++i) text += "a" + std::to_string(i) + ": 0\n";
    const Yaml yaml = Yaml::parse(text, "twice.yaml");
    EXPECT_EQ(yaml["k"].text(), "2");
    EXPECT_EQ(yaml["k"].where().line, 4);
    EXPECT_EQ(yaml.key_location("k").line, 1);
    EXPECT_FALSE(yaml.has("no"));
  }
}

TEST(XmlBounds, AttributesOfOneElementAndBytesAreRefusedBeyondABound) {
  std::string many = "<!-- \"\"\" -->\n<robot a='<>\"'>\n<link";
  for (int i = 0; i < 200; ++i) many += " a" + std::to_string(i) + "='\"'";
  EXPECT_NO_THROW(check_xml_bounds(many + "/></robot>", "fine.xml"));
  const std::string quotes(1000, '"');
  EXPECT_NO_THROW(check_xml_bounds("<a b='" + quotes + "'/><![CDATA[" + quotes + "]]>", "fine.xml"));
  try {
    check_xml_bounds(many + " b=\"\"/></robot>", "many.xml");
    FAIL() << "it was taken";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().where.line, 3);
  }
  EXPECT_THROW(check_xml_bounds(std::string(17 << 20, ' '), "large.xml"), Error);
  for (const char* cut : {"<", "<a b='", "<!--", "<![CDATA[", "<a b", ""})
    EXPECT_NO_THROW(check_xml_bounds(cut, "cut.xml"));
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

TEST(ReadFile, WithoutDescriptorsSaysWhatToDo) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  rlimit none = before;
  none.rlim_cur = 0;
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  std::string what;
  try {
    read_file("/etc/hostname");
  } catch (const Error& e) {
    what = e.what();
  }
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_NE(what.find("ulimit -n"), std::string::npos) << what;
  EXPECT_EQ(what.find("permissions"), std::string::npos) << what;
}

TEST(ErrorBounds, ANameWithALineFeedMakesNoSecondLine) {
  const Problem problem{"code", {"a\nfile", 1, 2}, "there is no 'x\nok: done'", "or\rthis"};
  EXPECT_EQ(problem.text(), "a\\x0afile:1:2: error: there is no 'x\\x0aok: done' (or\\x0dthis)");
}

TEST(ErrorBounds, ALineOfAProblemIsBounded) {
  const Problem problem{"code", {"file", 1, 2}, std::string(3'000'000, 'x'), std::string(3'000'000, 'y')};
  EXPECT_LT(problem.text().size(), 5000u);
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
