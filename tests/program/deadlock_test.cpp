/// Tasks that wait for each other without end fail, with the names of tasks, locks and meetings.
#include <gtest/gtest.h>

#include "fake_host.hpp"
#include "parsed.hpp"
#include "polyarm/vm/interpreter.hpp"

namespace polyarm::program {
namespace {

/// The program after a minute.
TaskStatus after_a_minute(const std::string& text) {
  FakeHost host;
  host.store.declare_tag("Never", false);
  Interpreter interpreter(parsed(text), host);
  for (int tick = 0; tick < 6000; ++tick, host.time += 10'000'000) interpreter.step(200);
  return interpreter.overview();
}

const std::string kOpposite =
    "task a\n  lock l\n    wait 1s\n    lock m\n      log(1)\n    end\n  end\nend\n"
    "task b\n  lock m\n    wait 1s\n    lock l\n      log(2)\n    end\n  end\nend\n";

TEST(Deadlock, OfLocksTakenInOppositeOrderNamesTasksAndLocks) {
  const TaskStatus end = after_a_minute(kOpposite);
  ASSERT_EQ(end.state, TaskState::failed);
  EXPECT_EQ(end.problem->code, "deadlock");
  EXPECT_EQ(end.problem->where.line, 4);
  EXPECT_EQ(end.problem->what,
            "tasks wait for each other without end: 'a' waits in line 4 for the lock 'm', which 'b' has; 'b' "
            "waits in line 12 for the lock 'l', which 'a' has");
}

TEST(Deadlock, IsFoundWhileAnotherTaskWorks) {
  EXPECT_EQ(after_a_minute(kOpposite + "task c\n  while true\n    wait 10ms\n  end\nend\n").state,
            TaskState::failed);
}

TEST(Deadlock, IsNotCaughtByATry) {
  EXPECT_EQ(after_a_minute("task a\n  lock l\n    wait 1s\n    try\n      lock m\n        log(1)\n      end\n"
                           "    on error e\n      log(e.text)\n    end\n  end\nend\n"
                           "task b\n  lock m\n    wait 1s\n    lock l\n      log(2)\n    end\n  end\nend\n")
                .state,
            TaskState::failed);
}

TEST(Deadlock, OfAMeetingNamesTheTaskThatHasEnded) {
  const TaskStatus end = after_a_minute("task a\n  meet x\nend\ntask b\n  meet x\n  meet x\nend\n");
  ASSERT_EQ(end.state, TaskState::failed);
  EXPECT_EQ(end.problem->what,
            "tasks wait for each other without end: 'b' waits in line 6 at the meeting 'x'; 'a' has ended and "
            "does not come");
}

TEST(Deadlock, OfAMeetingIsFoundWithAThirdTaskThatCannotCome) {
  EXPECT_EQ(after_a_minute("task a\n  meet x\nend\ntask b\n  meet x\n  meet x\nend\n"
                           "task c\n  while true\n    wait 10ms\n  end\nend\n")
                .state,
            TaskState::failed);
}

TEST(Deadlock, IsFoundInPartsOfATogether) {
  const std::string parts =
      "task a\n  lock l\n    wait 1s\n    together\n      meet x\n      log(1)\n    end\n  end\nend\n"
      "task b\n  wait 1s\n  lock l\n    meet x\n  end\nend\n";
  const TaskStatus end = after_a_minute(parts);
  ASSERT_EQ(end.state, TaskState::failed);
  EXPECT_NE(end.problem->what.find("'b' waits in line 12 for the lock 'l', which 'a' has"), std::string::npos)
      << end.problem->what;
}

TEST(Deadlock, IsNoWaitThatATimeOutOrAnotherTaskEnds) {
  EXPECT_EQ(after_a_minute("task a\n  lock l\n    wait 30s\n  end\nend\ntask b\n  lock l\n    log(1)\n  end\n"
                           "  meet x\nend\ntask c\n  meet x\nend\n")
                .state,
            TaskState::finished);
  EXPECT_EQ(after_a_minute("task a\n  meet x\nend\ntask b\n  wait Never\n  meet x\nend\n").state,
            TaskState::waiting)
      << "a tag may become true";
  EXPECT_EQ(after_a_minute("task a\n  meet x\nend\ntask b\n  meet x\n  meet x timeout 20s else\n    log(1)\n"
                           "  end\nend\n")
                .state,
            TaskState::finished);
}

}  // namespace
}  // namespace polyarm::program
