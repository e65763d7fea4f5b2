#include "polyarm/process/child.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include "polyarm/base/error.hpp"

namespace polyarm::process {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

Ending of_shell(const std::string& script) {
  Child child;
  child.start("/bin/sh", {"-c", script}, {});
  return child.finish(seconds(20));
}

TEST(Child, HowItEndedIsKnown) {
  EXPECT_EQ(of_shell("exit 3").text(), "ended with code 3");
  EXPECT_EQ(of_shell("kill -ABRT $$").text(), "was ended by SIGABRT");
  EXPECT_EQ(of_shell("echo first >&2; echo 'Assertion failed.' >&2; kill -SEGV $$").text(),
            "was ended by SIGSEGV (Assertion failed.)");
}

TEST(Child, ItsLastWordsAreOneLineThatATerminalBears) {
  EXPECT_EQ(of_shell("printf '\\033[2Jred\\302\\233 \\303\\244 \\377\\n' >&2; exit 1").last_words,
            "\\x1b[2Jred\\x9b \xc3\xa4 \\xff");
  const Ending ending =
      of_shell("i=0; while [ $i -lt 20000 ]; do echo 'many words of a child' >&2; i=$((i+1)); done");
  EXPECT_EQ(ending.code, 0) << "nobody reads what it says, and it goes on";
  EXPECT_LT(ending.last_words.size(), 310u);
}

TEST(Child, ItsEndCanBeWaitedForAndOneThatDoesNotEndIsKilled) {
  Child child;
  child.start("/bin/sh", {"-c", "exit 0"}, {});
  pollfd end{child.end(), POLLIN, 0};
  EXPECT_EQ(::poll(&end, 1, 20'000), 1);
  EXPECT_TRUE(child.ended());
  EXPECT_FALSE(child.ended()) << "once";
  child.start("/bin/sh", {"-c", "exec sleep 100"}, {});
  EXPECT_FALSE(child.ended());
  const Ending ending = child.finish(milliseconds(30));
  EXPECT_EQ(ending.signal, SIGKILL);
}

TEST(Child, WhatIsHandedOverIsThereAndNothingElse) {
  int secret[2], handed[2];
  ASSERT_EQ(::pipe(secret), 0);  // this one its owner forgot to keep for itself
  ASSERT_EQ(::pipe(handed), 0);
  Child child;
  const int fds[] = {handed[1]};
  child.start("/bin/sh", {"-c", "echo here >&3"}, fds);
  EXPECT_EQ(child.finish(seconds(20)).code, 0);
  char text[8] = {};
  EXPECT_EQ(::read(handed[0], text, sizeof text), 5);
  EXPECT_STREQ(text, "here\n");
  for (const int fd : {secret[0], secret[1], handed[0], handed[1]}) ::close(fd);
}

TEST(Child, AProgramThatIsNotThereIsSaidByName) {
  Child child;
  try {
    child.start("/no/such/program", {}, {});
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("/no/such/program cannot be started"), std::string::npos)
        << e.what();
  }
  EXPECT_EQ(find_program("no_such_program"), "");
  EXPECT_NE(program_folders().find("drivers"), std::string::npos);
}

}  // namespace
}  // namespace polyarm::process
