#include "polyarm/language/format.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "polyarm/base/file.hpp"
#include "polyarm/language/lexer.hpp"
#include "polyarm/language/parser.hpp"

namespace polyarm::program {
namespace {

TEST(Format, IndentsBlocksAndSpacesWords) {
  EXPECT_EQ(
      format("while  true\nIf A==1\nset x=-1+2*y\nelse\nmovel  offset( p,z=80mm ),speed   50%\nend\nend\n"),
      "while true\n  If A == 1\n    set x = -1 + 2 * y\n  else\n    movel offset(p, z = 80mm), speed 50%\n"
      "  end\nend\n");
}

TEST(Format, KeepsCommentsAndOneEmptyLine) {
  EXPECT_EQ(format("\n\n#first\n\n\nif A   #why\n      # alone\nend\n\n\n"),
            "#first\n\nif A  #why\n  # alone\nend\n");
}

TEST(Format, KeepsTheTextOfThesisLines) {
  EXPECT_EQ(format("  set  Name   some text,here = 3   # note\nload  cycledata\n"),
            "set  Name   some text,here = 3  # note\nload  cycledata\n");
}

TEST(Format, KeepsTheLinesOfAStatement) {
  EXPECT_EQ(format("let a = [1,\n2, # two\n\n3]\nmovel P,\nspeed 50%\n"),
            "let a = [1,\n    2,  # two\n    3]\nmovel P,\n    speed 50%\n");
}

TEST(Format, PutsErrorHandlersBesideTheirTry) {
  EXPECT_EQ(format("try\nraise \"x\"\non error e\nretry 3\nend\nwait A timeout 2s else\nstop\nend\non "
                   "stop\nset B = -b\nend"),
            "try\n  raise \"x\"\non error e\n  retry 3\nend\nwait A timeout 2s else\n  stop\nend\n"
            "on stop\n  set B = -b\nend\n");
}

std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> out;
  for (const SourceLine& line : read_source(split_lines(text)))
    for (const Token& token : line.tokens) out.push_back(token.text);
  return out;
}

TEST(Format, ChangesNoWordOfAnyProgramAndNothingTheSecondTime) {
  int programs = 0;
  for (const char* folder : {"/tests/program", "/examples"})
    for (const auto& file :
         std::filesystem::recursive_directory_iterator(std::string(POLYARM_SOURCE_DIR) + folder)) {
      if (file.path().extension() != ".script") continue;
      const std::string text = read_file(file.path());
      const std::string once = format(text);
      EXPECT_EQ(words(once), words(text)) << file.path();
      EXPECT_EQ(format(once), once) << file.path();
      ++programs;
    }
  EXPECT_GT(programs, 50);
}

}  // namespace
}  // namespace polyarm::program
