#include <gtest/gtest.h>

#include "polyarm/control/supervisor.hpp"

namespace polyarm::control {
namespace {

struct Transition {
  RunState from;
  Event event;
  RunState to;
};

class StateTable : public testing::TestWithParam<Transition> {};

TEST_P(StateTable, LeadsWhereItMust) {
  EXPECT_EQ(next(GetParam().from, GetParam().event), GetParam().to);
}

using S = RunState;
using E = Event;
INSTANTIATE_TEST_SUITE_P(
    All, StateTable,
    testing::Values(Transition{S::running, E::stop, S::stopping}, Transition{S::running, E::standing, S::running},
                    Transition{S::running, E::resume, S::running}, Transition{S::running, E::discard, S::running},
                    Transition{S::running, E::fault, S::fault}, Transition{S::running, E::recover, S::running},
                    Transition{S::stopping, E::stop, S::stopping}, Transition{S::stopping, E::standing, S::held},
                    Transition{S::stopping, E::resume, S::stopping}, Transition{S::stopping, E::discard, S::stopping},
                    Transition{S::stopping, E::fault, S::fault}, Transition{S::stopping, E::recover, S::stopping},
                    Transition{S::held, E::stop, S::held}, Transition{S::held, E::standing, S::held},
                    Transition{S::held, E::resume, S::running}, Transition{S::held, E::discard, S::held},
                    Transition{S::held, E::fault, S::fault}, Transition{S::held, E::recover, S::held},
                    Transition{S::fault, E::stop, S::fault}, Transition{S::fault, E::standing, S::fault},
                    Transition{S::fault, E::resume, S::fault}, Transition{S::fault, E::discard, S::fault},
                    Transition{S::fault, E::fault, S::fault}, Transition{S::fault, E::recover, S::held},
                    Transition{S::running, E::back, S::running}, Transition{S::stopping, E::back, S::stopping},
                    Transition{S::held, E::back, S::backing}, Transition{S::fault, E::back, S::fault},
                    Transition{S::backing, E::stop, S::stopping}, Transition{S::backing, E::standing, S::held},
                    Transition{S::backing, E::resume, S::backing}, Transition{S::backing, E::discard, S::backing},
                    Transition{S::backing, E::fault, S::fault}, Transition{S::backing, E::recover, S::backing},
                    Transition{S::backing, E::back, S::backing}),
    [](const testing::TestParamInfo<Transition>& row) {
      return std::string(name(row.param.from)) + "_" + name(row.param.event);
    });

Nanoseconds at_ms(int ms) {
  return ms * 1'000'000LL;
}

TEST(Supervisor, OverrideAndShareMultiply) {
  Supervisor supervisor;
  supervisor.watch_cell = false;
  supervisor.set_share(0.5);
  supervisor.set_override(0.4);
  EXPECT_DOUBLE_EQ(supervisor.judge(at_ms(0), false, Request::none).speed, 0.2);
  supervisor.set_override(0);
  EXPECT_EQ(supervisor.judge(at_ms(1), false, Request::none).speed, 0);
  EXPECT_EQ(supervisor.state(), RunState::running) << "it goes on when more is allowed";
}

TEST(Supervisor, StepsBackOnlyFromAHoldSlowlyAndIsHeldAgain) {
  Supervisor supervisor;
  supervisor.watch_cell = false;
  supervisor.set_back(0.5, 0.1);
  EXPECT_EQ(supervisor.judge(at_ms(0), true, Request::back).back, 0) << "it runs";
  supervisor.latch().request(realtime::StopKind::controlled);
  supervisor.judge(at_ms(1), true, Request::none);
  supervisor.judge(at_ms(2), true, Request::back);
  EXPECT_EQ(supervisor.state(), RunState::held) << "the latch is still set";
  supervisor.latch().clear();
  const controllers::Verdict back = supervisor.judge(at_ms(3), true, Request::back);
  EXPECT_EQ(back.speed, 0);
  EXPECT_DOUBLE_EQ(back.back, Supervisor::kBackShare);
  EXPECT_EQ(back.back_time, 0.5);
  EXPECT_EQ(back.back_way, 0.1);
  supervisor.set_override(0.03);
  EXPECT_DOUBLE_EQ(supervisor.judge(at_ms(4), false, Request::none).back, 0.03);
  EXPECT_EQ(supervisor.judge(at_ms(5), false, Request::resume).speed, 0) << "it is under way";
  EXPECT_EQ(supervisor.judge(at_ms(6), true, Request::none).back, 0);
  EXPECT_EQ(supervisor.state(), RunState::held);
}

TEST(Supervisor, SaysWhenAStopBeganAndWhenAllStood) {
  Supervisor supervisor;
  supervisor.watch_cell = false;
  supervisor.judge(at_ms(0), false, Request::none);
  EXPECT_EQ(supervisor.stop_times().begun, -1);
  supervisor.latch().request(realtime::StopKind::controlled);
  for (int ms = 1; ms < 8; ++ms) supervisor.judge(at_ms(ms), false, Request::none);
  EXPECT_EQ(supervisor.stop_times().begun, at_ms(1));
  EXPECT_EQ(supervisor.stop_times().ended, -1);
  for (int ms = 8; ms < 12; ++ms) supervisor.judge(at_ms(ms), true, Request::none);
  EXPECT_EQ(supervisor.stop_times().ended, at_ms(8));
  supervisor.react({StopCause::jump, 0}, false);
  supervisor.judge(at_ms(12), true, Request::none);
  EXPECT_EQ(supervisor.stop_times().begun, at_ms(12));
}

TEST(Supervisor, NothingButResumeLeavesAHold) {
  Supervisor supervisor;
  supervisor.watch_cell = false;
  supervisor.latch().request(realtime::StopKind::controlled);
  EXPECT_EQ(supervisor.judge(at_ms(0), false, Request::none).speed, 0);
  EXPECT_EQ(supervisor.state(), RunState::stopping);
  supervisor.judge(at_ms(1), true, Request::none);
  EXPECT_EQ(supervisor.state(), RunState::held);
  supervisor.judge(at_ms(2), true, Request::resume);
  EXPECT_EQ(supervisor.state(), RunState::held) << "the latch is still set";
  supervisor.latch().clear();
  supervisor.judge(at_ms(3), true, Request::none);
  EXPECT_EQ(supervisor.state(), RunState::held) << "clearing the latch alone moves nothing";
  EXPECT_EQ(supervisor.judge(at_ms(4), true, Request::resume).speed, 1);
  EXPECT_EQ(supervisor.state(), RunState::running);
}

TEST(Supervisor, AGapInWallTimeHolds) {
  Supervisor supervisor;
  supervisor.watch_cell = false;
  supervisor.react({StopCause::gap}, false);
  EXPECT_EQ(supervisor.judge(at_ms(0), false, Request::none).speed, 0);
  EXPECT_EQ(supervisor.cause(), StopCause::gap);
}

TEST(Supervisor, ASilentCellStopsWhatMovesAndOnlyThat) {
  Supervisor supervisor;
  supervisor.heartbeat(0);
  supervisor.judge(at_ms(400), false, Request::none);
  EXPECT_EQ(supervisor.state(), RunState::running);
  supervisor.judge(at_ms(900), true, Request::none);
  EXPECT_EQ(supervisor.state(), RunState::running) << "nothing moves";
  supervisor.judge(at_ms(901), false, Request::none);
  EXPECT_EQ(supervisor.cause(), StopCause::cell_silent);
}

TEST(Supervisor, AFaultNeedsRecoverBeforeResume) {
  Supervisor supervisor;
  supervisor.watch_cell = false;
  EXPECT_TRUE(supervisor.react({StopCause::component, 2}, false)) << "the component is taken off";
  EXPECT_TRUE(supervisor.judge(at_ms(0), false, Request::none).immediate);
  EXPECT_EQ(supervisor.event().component, 2);
  supervisor.judge(at_ms(1), true, Request::resume);
  EXPECT_EQ(supervisor.state(), RunState::fault);
  supervisor.judge(at_ms(2), true, Request::recover);
  EXPECT_EQ(supervisor.state(), RunState::held);
}

TEST(Supervisor, OfTwoFaultsTheFirstIsNamed) {
  Supervisor supervisor;
  supervisor.react({StopCause::component, 2}, false);
  supervisor.react({StopCause::limits, 1, 7}, false);
  EXPECT_EQ(supervisor.cause(), StopCause::component);
  EXPECT_EQ(supervisor.event().component, 2);
}

}  // namespace
}  // namespace polyarm::control
