#include "polyarm/language/parser.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "fake_host.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/language/format.hpp"
#include "polyarm/program/checker.hpp"

namespace polyarm::program {
namespace {

std::string repeat(const std::string& text, int times) {
  std::string out;
  for (int i = 0; i < times; ++i) out += text;
  return out;
}

Problems problems_of(const std::string& text) {
  Problems problems;
  const Program program = parse(text, "t", problems);
  check(program, {}, problems);
  return problems;
}

TEST(Parser, TakesTwoHundredNestedBlocksAndRunsThem) {
  Problems problems;
  Program program = parse(repeat("if true\n", 200) + "log(1)\n" + repeat("endif\n", 200), "t", problems);
  ASSERT_FALSE(problems.has_errors());
  FakeHost host;
  Interpreter interpreter(std::move(program), host);
  EXPECT_EQ(run(interpreter, host).state, TaskState::finished);
  EXPECT_EQ(host.logs.size(), 1u);
}

TEST(Parser, RefusesTenThousandNestedBlocksWithOneSentence) {
  const Problems problems = problems_of(repeat("while true\n", 10000));
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_EQ(problems.list()[0].code, "too-deep");
}

TEST(Parser, RefusesDeepExpressionsOfEveryKind) {
  for (const std::string& text :
       {repeat("(", 10000) + "1" + repeat(")", 10000), repeat("-", 10000) + "1",
        repeat("not ", 10000) + "true", repeat("[", 10000) + repeat("]", 10000), "1" + repeat("+1", 10000),
        "1" + repeat("^1", 10000), "x" + repeat("[1]", 10000),
        repeat("abs(", 10000) + "1" + repeat(")", 10000)}) {
    const Problems problems = problems_of("let a = " + text + "\n");
    ASSERT_FALSE(problems.list().empty());
    EXPECT_EQ(problems.list()[0].code, "too-deep") << text.substr(0, 20) << " " << problems.list()[0].text();
  }
}

TEST(Parser, ReadsLongLines) {
  std::string text = "let a = [1";
  for (int i = 0; i < 100'000; ++i) text += ", 1";
  const Problems problems = problems_of(text + "]\n");
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_EQ(problems.list()[0].code, "too-long") << "it is read, and a run would refuse so many values";
}

TEST(Parser, CountsColumnsInCharacters) {
  const Problems problems = problems_of("set Größe größe; log(\"äöü\" ; 1)\nlog(\"äöü\" ; 1)\n");
  ASSERT_GE(problems.list().size(), 2u);
  EXPECT_EQ(problems.list()[0].where.text(), "t:2:11");
}

TEST(Parser, ReadsWindowsLineEndsAndAByteOrderMark) {
  EXPECT_TRUE(problems_of("\xEF\xBB\xBFlog(1)\r\n\r\nlog(2)\r\n").list().empty());
}

TEST(Parser, RefusesBinaryFiles) {
  EXPECT_EQ(problems_of(std::string("\x80\x04\x95") + std::string(20, '\0')).list().at(0).code, "not-text");
  EXPECT_EQ(problems_of(std::string("log(1)\n\0", 8)).list().at(0).code, "not-text");
  EXPECT_EQ(problems_of("log(1)\rlog(2)\r").list().at(0).code, "not-text");
}

TEST(Parser, AnEmptyProgramDoesNothing) {
  for (const char* text : {"", "\n\n", "# only a comment", " \t\r\n"})
    EXPECT_TRUE(problems_of(text).list().empty());
}

TEST(Parser, GivesUpCountingErrorsButNotReading) {
  EXPECT_LE(problems_of(repeat("nonsense nonsense\n", 5000)).list().size(), 200u);
}

std::vector<std::string> all_programs() {
  std::vector<std::string> out;
  for (const char* folder : {"/tests/program/cases", "/tests/program/thesis"})
    for (const auto& file :
         std::filesystem::recursive_directory_iterator(std::string(POLYARM_SOURCE_DIR) + folder))
      if (file.path().extension() == ".script") out.push_back(read_file(file.path()));
  return out;
}

/// A copy of `text` with some bytes changed, or pieces of others put in.
std::string mutated(std::string text, const std::vector<std::string>& others, std::mt19937& random) {
  static const std::string kBytes = "()[]{}\"`#=.,+-*/^<>\n\t \\0189ae_\x80\xC3\xFF%";
  const auto draw = [&](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
  };
  for (std::size_t changes = 1 + draw(6); changes > 0 && !text.empty(); --changes) {
    const std::size_t at = draw(text.size());
    const std::string& other = others[draw(others.size())];
    const std::size_t from = draw(other.size());
    switch (draw(4)) {
      case 0:
        text[at] = kBytes[draw(kBytes.size())];
        break;
      case 1:
        text.erase(at, 1 + draw(20));
        break;
      case 2:
        text.insert(at, other.substr(from, draw(60)));
        break;
      default:
        text.insert(at, 1, kBytes[draw(kBytes.size())]);
    }
  }
  return text;
}

TEST(Parser, SurvivesFiveThousandDamagedPrograms) {
  std::mt19937 random(20);
  const auto programs = all_programs();
  int ran = 0;
  for (int i = 0; i < 5000; ++i) {
    const std::string text =
        mutated(programs[static_cast<std::size_t>(i) % programs.size()], programs, random);
    Problems problems;
    Program program = parse(text, "t", problems);
    for (const Problem& problem : problems.list()) ASSERT_FALSE(problem.what.empty());
    const bool runs = !problems.has_errors();
    const std::string formatted = format(text);
    if (runs) {
      Problems again;
      parse(formatted, "t", again);
      ASSERT_FALSE(again.has_errors()) << text << "\n---\n" << formatted << again.list().front().text();
    }
    check(program, {}, problems);
    if (!runs) continue;
    FakeHost host;
    host.store.declare_tag("A", true);
    Interpreter interpreter(std::move(program), host);
    run(interpreter, host, nanoseconds(0.1));
    ++ran;
  }
  EXPECT_GT(ran, 300);
}

}  // namespace
}  // namespace polyarm::program
