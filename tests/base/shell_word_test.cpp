#include "polyarm/base/shell_word.hpp"

#include <gtest/gtest.h>

namespace polyarm {
namespace {

TEST(ShellWord, LeavesPlainWordsAsTheyAre) {
  for (const char* plain : {"cell.yaml", "/home/me/my-cell_2/p.so", "host:10.0.0.1", "arm:=true", "50%"})
    EXPECT_EQ(shell_word(plain), plain);
}

TEST(ShellWord, QuotesWhatAShellWouldCarryOut) {
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("a b"), "'a b'");
  EXPECT_EQ(shell_word("a;touch b"), "'a;touch b'");
  EXPECT_EQ(shell_word("$(id)`id`&|<>*?~#!\\\"\n"), "'$(id)`id`&|<>*?~#!\\\"\n'");
  EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
}

}  // namespace
}  // namespace polyarm
