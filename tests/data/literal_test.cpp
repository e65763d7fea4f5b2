#include "polyarm/data/literal.hpp"

#include <gtest/gtest.h>

#include <random>

namespace polyarm::data {
namespace {

Value read(const std::string& text) {
  std::string why;
  const auto value = parse_literal(text, why);
  EXPECT_TRUE(value) << text << ": " << why;
  return value.value_or(Value("nothing"));
}

TEST(Literal, IsReadAsAPersonWritesIt) {
  EXPECT_EQ(read(" True "), Value(true));
  EXPECT_EQ(read("40mm"), Value(Number{0.04, Dimension::length}));
  EXPECT_EQ(read(R"("a \"b\"\n")"), Value("a \"b\"\n"));
  EXPECT_EQ(read("[1, [2], {}]"), Value(List{1, List{2}, Record{}}));
  EXPECT_EQ(read("{a = 1, \"b c\": \"x\"}"), Value(Record{{"a", "b c"}, {1, "x"}}));
  EXPECT_EQ(read("joints(elbow = 90deg)").as_joints()->names, std::vector<std::string>{"elbow"});
  EXPECT_NEAR(read("pose(100mm, 0, 0, 0, 0, 180deg)").as_point()->pose.position.x, 0.1, 1e-12);
  EXPECT_EQ(read("quat(0, 0, 1, 0, 0, 0, 1, frame = \"table\")").as_point()->frame(), "table");
}

TEST(Literal, ReportsTheProblem) {
  for (const char* text :
       {"", "x", "[1", "[1 2]", "{a}", "{a = 1, a = 2}", "\"open", "1 2", "pose(1, 2)", "1deg2",
        "pose(1deg, 0, 0, 0, 0, 0)", "quat(0, 0, 0, 0, 0, 0, 0)", "joints(a = 1, 2)", "nan", "[,]"}) {
    std::string why;
    EXPECT_FALSE(parse_literal(text, why)) << text;
    EXPECT_FALSE(why.empty()) << text;
  }
  std::string why;
  EXPECT_FALSE(parse_literal(std::string(100000, '['), why));
  EXPECT_NE(why.find("nested"), std::string::npos);
}

TEST(Literal, SurvivesWhateverIsWritten) {
  std::mt19937 random(3);
  const std::string alphabet = "[]{}()\"\\=:,.0123456789eE+- abposequatjintrufls\n\xc3\xa9";
  for (int k = 0; k < 20000; ++k) {
    std::string text, why;
    for (std::size_t n = random() % 40; n > 0; --n) text += alphabet[random() % alphabet.size()];
    if (const auto value = parse_literal(text, why)) {
      EXPECT_EQ(read(literal(*value)), *value) << text;
    }
  }
}

}  // namespace
}  // namespace polyarm::data
