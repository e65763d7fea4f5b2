#include <gtest/gtest.h>

#include "polyarm/control/supervisor.hpp"

namespace polyarm::control {
namespace {

struct Row {
  RunState from;
  Event event;
  RunState to;
};

class StateTable : public testing::TestWithParam<Row> {};

TEST_P(StateTable, LeadsWhereItMust) {
  EXPECT_EQ(next(GetParam().from, GetParam().event), GetParam().to);
}

using S = RunState;
using E = Event;
INSTANTIATE_TEST_SUITE_P(
    All, StateTable,
    testing::Values(Row{S::running, E::stop, S::stopping}, Row{S::running, E::standing, S::running},
                    Row{S::running, E::resume, S::running}, Row{S::running, E::discard, S::running},
                    Row{S::running, E::fault, S::fault}, Row{S::running, E::recover, S::running},
                    Row{S::stopping, E::stop, S::stopping}, Row{S::stopping, E::standing, S::held},
                    Row{S::stopping, E::resume, S::stopping}, Row{S::stopping, E::discard, S::stopping},
                    Row{S::stopping, E::fault, S::fault}, Row{S::stopping, E::recover, S::stopping},
                    Row{S::held, E::stop, S::held}, Row{S::held, E::standing, S::held},
                    Row{S::held, E::resume, S::running}, Row{S::held, E::discard, S::held},
                    Row{S::held, E::fault, S::fault}, Row{S::held, E::recover, S::held},
                    Row{S::fault, E::stop, S::fault}, Row{S::fault, E::standing, S::fault},
                    Row{S::fault, E::resume, S::fault}, Row{S::fault, E::discard, S::fault},
                    Row{S::fault, E::fault, S::fault}, Row{S::fault, E::recover, S::held}),
    [](const testing::TestParamInfo<Row>& row) {
      return std::string(name(row.param.from)) + "_" + name(row.param.event);
    });

hardware::Cycle at_ms(int ms) {
  return {ms * 1'000'000LL, 1'000'000, static_cast<std::uint64_t>(ms)};
}

TEST(Supervisor, NothingButResumeLeavesAHold) {
  Supervisor supervisor;
  supervisor.watch_cell = false;
  supervisor.latch().request(realtime::StopKind::controlled);
  EXPECT_EQ(supervisor.judge(at_ms(0), {}, false, false, Request::none).speed, 0);
  EXPECT_EQ(supervisor.state(), RunState::stopping);
  supervisor.judge(at_ms(1), {}, false, true, Request::none);
  EXPECT_EQ(supervisor.state(), RunState::held);
  supervisor.judge(at_ms(2), {}, false, true, Request::resume);
  EXPECT_EQ(supervisor.state(), RunState::held) << "the latch is still set";
  supervisor.latch().clear();
  supervisor.judge(at_ms(3), {}, false, true, Request::none);
  EXPECT_EQ(supervisor.state(), RunState::held) << "clearing the latch alone moves nothing";
  EXPECT_EQ(supervisor.judge(at_ms(4), {}, false, true, Request::resume).speed, 1);
  EXPECT_EQ(supervisor.state(), RunState::running);
}

TEST(Supervisor, AGapInWallTimeHolds) {
  Supervisor supervisor;
  supervisor.watch_cell = false;
  EXPECT_EQ(supervisor.judge(at_ms(0), {}, true, false, Request::none).speed, 0);
  EXPECT_EQ(supervisor.cause(), StopCause::gap);
}

TEST(Supervisor, ASilentCellStopsWhatMovesAndOnlyThat) {
  Supervisor supervisor;
  supervisor.heartbeat(0);
  supervisor.judge(at_ms(400), {}, false, false, Request::none);
  EXPECT_EQ(supervisor.state(), RunState::running);
  supervisor.judge(at_ms(900), {}, false, true, Request::none);
  EXPECT_EQ(supervisor.state(), RunState::running) << "nothing moves";
  supervisor.judge(at_ms(901), {}, false, false, Request::none);
  EXPECT_EQ(supervisor.cause(), StopCause::cell_silent);
}

TEST(Supervisor, AFaultNeedsRecoverBeforeResume) {
  Supervisor supervisor;
  supervisor.watch_cell = false;
  const hardware::Fault fault{hardware::FaultKind::component_read, 2};
  EXPECT_TRUE(supervisor.judge(at_ms(0), fault, false, false, Request::none).immediate);
  EXPECT_EQ(supervisor.culprit(), 2);
  supervisor.judge(at_ms(1), {}, false, true, Request::resume);
  EXPECT_EQ(supervisor.state(), RunState::fault);
  supervisor.judge(at_ms(2), {}, false, true, Request::recover);
  EXPECT_EQ(supervisor.state(), RunState::held);
}

TEST(Supervisor, OfTwoFaultsTheFirstIsNamed) {
  Supervisor supervisor;
  supervisor.raise(StopCause::component, 2);
  supervisor.raise(StopCause::limits, 7);
  EXPECT_EQ(supervisor.cause(), StopCause::component);
  EXPECT_EQ(supervisor.culprit(), 2);
}

}  // namespace
}  // namespace polyarm::control
