/// What others have written never steers the terminal of the person who reads it.
#include <gtest/gtest.h>

#include <string>

#include "polyarm/base/file.hpp"
#include "tests/support/at_terminal.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::AtTerminal;
using test::Command;
using test::ExampleCopy;

const std::string kNasty =
    "a\x1b[2Jb\x1b]0;owned\x07 c\xc2\x9b" "31m d\x9b" "1m e\xe2\x80\xae f\x1b" "0123456789abcdef[K";

/// Nothing of `text` but what the command itself draws with on a line: \r\033[K.
void expect_harmless(std::string text) {
  for (const std::string own : {"\r\x1b[K", "\r\n"})
    for (auto at = text.find(own); at != std::string::npos; at = text.find(own)) text.erase(at, own.size());
  for (const char* wrong : {"\x1b", "\x07", "\xc2\x9b", "\xe2\x80\xae", "\r"})
    EXPECT_EQ(text.find(wrong), std::string::npos) << text;
}

std::string everything(AtTerminal& at) {
  at.ends();
  return at.seen();
}

TEST(Terminal, ErrorsThatQuoteAFileAreHarmless) {
  const ExampleCopy copy("pick_and_place");
  write_file_atomically(copy.file("cell.yaml"), "polyarm: cell/1\n\"" + std::string("a\\x1b[2Jb\\u009b31m\\u202e") + "\": 1\n");
  for (const char* verb : {"check", "run"}) {
    AtTerminal at({verb, copy.path()});
    const std::string seen = everything(at);
    EXPECT_NE(seen.find("\\x1b[2J"), std::string::npos) << seen;
    EXPECT_NE(seen.find("\\u202e"), std::string::npos) << seen;
    expect_harmless(seen);
  }
}

TEST(Terminal, ArgumentsThatAreQuotedAreHarmless) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{kNasty}, {"run", kNasty}, {"describe", kNasty}, {"check", kNasty, kNasty}}) {
    AtTerminal at(arguments);
    const std::string seen = everything(at);
    EXPECT_NE(seen.find("\\x1b"), std::string::npos) << seen;
    expect_harmless(seen);
  }
}

TEST(Terminal, TextsAndNamesOfAProgramAreHarmlessWhileItRuns) {
  const ExampleCopy copy("pick_and_place");
  write_file_atomically(copy.file("PAPscript.script"),
                        "load cycledata\nlog \"said " + kNasty + "\"\nset Note = \"" + kNasty + "\"\n");
  for (const bool json : {false, true}) {
    std::vector<std::string> arguments{"run", copy.path(), "--hardware", "mock", "--fast"};
    if (json) arguments.emplace_back("--json");
    AtTerminal at(arguments);
    expect_harmless(everything(at));
  }
}

TEST(Terminal, WhatGoesThroughAPipeToATerminalIsHarmless) {
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{kNasty}, {"check", kNasty}}) {
    const test::Finished ended = test::run_command(arguments);
    EXPECT_NE(ended.output.find("\\x1b[2J"), std::string::npos) << ended.output;
    expect_harmless(ended.output);
  }
}

TEST(Terminal, ADocumentInAPipeIsAsItWasWritten) {
  const ExampleCopy copy("pick_and_place");
  const std::string text = "<robot name=\"r\"><!-- \xe2\x80\xae \xc2\x9b --><link name=\"a\"/></robot>";
  write_file_atomically(copy.file("r.urdf.xacro"), text);
  const test::Finished ended = test::run_command({"xacro", copy.file("r.urdf.xacro")});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_NE(ended.output.find("\xe2\x80\xae \xc2\x9b"), std::string::npos) << ended.output;
}

TEST(Real, ACellWithNothingRealSaysSoAndEnds) {
  const ExampleCopy copy("pick_and_place");
  const test::Finished ended = test::run_command({"run", copy.path(), "--real", "--fast"});
  EXPECT_EQ(ended.exit_code, 2) << ended.output;
  EXPECT_NE(ended.output.find("nothing of this cell is real: arm (mujoco)"), std::string::npos)
      << ended.output;
  const test::Finished json = test::run_command({"run", copy.path(), "--real", "--json", "--hardware", "mock"});
  EXPECT_EQ(json.exit_code, 2);
  EXPECT_EQ(json.result()["problems"][0]["code"], "nothing-real");
}

TEST(Check, ManyUnknownKeysAreABoundedAnswer) {
  const ExampleCopy copy("pick_and_place");
  std::string text = read_file(copy.file("cell.yaml"));
  for (int i = 0; i < 60'000; ++i) text += "unknown_" + std::to_string(i) + ": 1\n";
  write_file_atomically(copy.file("cell.yaml"), text);
  const test::Finished ended = test::run_command({"check", copy.path()});
  EXPECT_EQ(ended.exit_code, 1);
  EXPECT_LT(ended.output.size(), 100'000u);
  EXPECT_NE(ended.output.find("and 59950 more keys"), std::string::npos) << ended.output.substr(0, 2000);
}

}  // namespace
}  // namespace polyarm
