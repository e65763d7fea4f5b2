#include "polyarm/base/printable.hpp"

#include <gtest/gtest.h>

namespace polyarm {
namespace {

TEST(Printable, LeavesWordsOfEveryLanguageAsTheyAre) {
  for (const char* text : {"", "plain", "two\nlines\tand a tab", "Größe °C … 机器人 ロボット 🤖 é"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, ShowsWhatWouldSteerATerminal) {
  const std::pair<const char*, const char*> kTexts[] = {
      {"\x1b[2J", "\\x1b[2J"},                        // CSI
      {"\x1b]0;title\x07", "\\x1b]0;title\\x07"},     // OSC
      {"\x1bPq\x1b\\", "\\x1bPq\\x1b\\"},             // DCS
      {"over\rwritten\b\b", "over\\x0dwritten\\x08\\x08"},
      {"\x7f", "\\x7f"},
      {"\xc2\x9b" "2J", "\\x9b2J"},                   // C1 in UTF-8
      {"\x9b" "2J", "\\x9b2J"},                       // C1 as a byte
      {"a\xe2\x80\xae" "b", "a\\u202eb"},             // right to left
      {"\xe2\x81\xa6x\xe2\x81\xa9", "\\u2066x\\u2069"},
      {"\xe2\x80\x8f\xd8\x9c", "\\u200f\\u061c"},
      {"\xe2\x80\xa8", "\\u2028"},
      {"\xff\xc0\x80", "\\xff\\xc0\\x80"},            // no UTF-8, and an overlong form
      {"\xed\xa0\x80", "\\xed\\xa0\\x80"},            // half of a pair
      {"\xe2\x80", "\\xe2\\x80"},                     // cut
  };
  for (const auto& [given, shown] : kTexts) EXPECT_EQ(printable(given), shown);
}

TEST(Printable, WholeCharactersEndBeforeACutOne) {
  EXPECT_EQ(whole_characters("abc"), 3u);
  EXPECT_EQ(whole_characters("ab\xe2\x80"), 2u);
  EXPECT_EQ(whole_characters("ab\xe2\x80\xa6"), 5u);
  EXPECT_EQ(whole_characters("\xf0\x9f\xa4"), 0u);
  EXPECT_EQ(whole_characters("\x80\x80\x80\x80"), 4u);
}

TEST(Shortened, CutsLongTextsBetweenCharacters) {
  EXPECT_EQ(shortened("short"), "short");
  std::string text;
  for (int i = 0; i < 100; ++i) text += "é…";
  EXPECT_LE(shortened(text).size(), 204u);
  EXPECT_EQ(printable(shortened(text)), shortened(text));
}

TEST(Printable, ALineStaysOneLine) {
  EXPECT_EQ(printable_line("host\n  plugin\tx\x1b[2J ä"), "host\\x0a  plugin\\x09x\\x1b[2J ä");
}

}  // namespace
}  // namespace polyarm
