#include "polyarm/data/rows.hpp"

#include <gtest/gtest.h>

#include <random>

#include "polyarm/base/error.hpp"

namespace polyarm::data {
namespace {

std::string refusal(const std::string& text) {
  try {
    read_rows(text, "parts.csv");
  } catch (const Error& e) {
    return e.problems().front().where.text() + " " + e.problems().front().what;
  }
  return {};
}

TEST(Rows, TheFirstLineNamesTheColumns) {
  const List rows = read_rows(
      "\xEF\xBB\xBFname;x;ok\r\n# a comment\r\nlid;12.5mm;true\r\n\r\n\"a;\"\"b\"\"\";-3;no\r\n", "f");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].text(), "{name = lid, x = 0.0125m, ok = True}");
  EXPECT_EQ(*rows[1].as_record()->find("name")->as_text(), "a;\"b\"");
  EXPECT_EQ(rows[1].as_record()->find("x")->as_number()->value, -3);
}

TEST(Rows, WithoutNamesARowIsAList) {
  const List rows = read_rows("1,2\n3,\"4\n5\"\n", "f");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ((*rows[0].as_list())[1].as_number()->value, 2);
  EXPECT_EQ(*(*rows[1].as_list())[1].as_text(), "4\n5");
  EXPECT_TRUE(read_rows("", "f").empty());
  EXPECT_TRUE(read_rows("\n\n#\n", "f").empty());
}

TEST(Rows, WhatIsWrongIsSaidWithItsLine) {
  EXPECT_EQ(refusal("a,b\n\n1,2\n1\n"), "parts.csv:4 this line has 1 columns, the first one has 2");
  EXPECT_EQ(refusal("a,b\n1,\"2\n3\n"), "parts.csv:2 a quoted text that begins in this line has no end");
  EXPECT_EQ(refusal(std::string(100, ',')), "parts.csv:1 this line has more than 64 columns");
  EXPECT_EQ(refusal(std::string(kMostRowBytes + 1, 'a')), "parts.csv the file has more than 1 MiB");
  std::string many;
  for (std::size_t i = 0; i < kMostRows + 2; ++i) many += "1\n";
  EXPECT_NE(refusal(many).find("more than 10000 rows"), std::string::npos);
}

TEST(Rows, RandomBytesDoNoHarm) {
  std::mt19937 random(3);
  const std::string bytes = "\"\"\",;\t\n\r# aB1.-+emm\xEF\xBB\xBF\x80{}[]()";
  for (int i = 0; i < 3000; ++i) {
    std::string text;
    for (std::size_t k = random() % 60; k > 0; --k) text += bytes[random() % bytes.size()];
    try {
      read_rows(text, "f");
    } catch (const Error& e) {
      EXPECT_FALSE(e.problems().front().advice.empty()) << text;
    }
  }
}

}  // namespace
}  // namespace polyarm::data
