/// What the supervisor decides on each fault event, in each state.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "polyarm/control/supervisor.hpp"

namespace polyarm::control {
namespace {

using enum Reaction::Loop;

struct Row {
  StopCause cause;
  Reaction alone, contained;  // without and with `on_fault: group`
};

/// With late threads that are a fault, and contacts that stop on the path.
const std::vector<Row>& table() {
  static const std::vector<Row> rows = {
      {StopCause::none, {keeps_going, false}, {keeps_going, false}},
      {StopCause::asked, {stops, false}, {stops, false}},
      {StopCause::gap, {stops, false}, {stops, false}},
      {StopCause::cell_silent, {stops, false}, {stops, false}},
      {StopCause::component, {faults, true}, {keeps_going, true}},
      {StopCause::controller, {faults, false}, {keeps_going, true}},
      {StopCause::program, {stops, false}, {stops, false}},
      {StopCause::late, {faults, true}, {keeps_going, true}},
      {StopCause::not_a_number, {faults, true}, {keeps_going, true}},
      {StopCause::jump, {faults, true}, {keeps_going, true}},
      {StopCause::not_following, {faults, true}, {keeps_going, true}},
      {StopCause::limits, {faults, false}, {keeps_going, true}},
      {StopCause::contact, {stops, false}, {stops, false}},
      {StopCause::deactivated, {faults, true}, {keeps_going, true}},
  };
  return rows;
}

std::string name_of(const testing::TestParamInfo<Row>& row) {
  static constexpr const char* kNames[] = {"none",          "asked",   "gap",     "cell_silent",  "component",
                                           "controller",    "program", "late",    "not_a_number", "jump",
                                           "not_following", "limits",  "contact", "deactivated"};
  return kNames[static_cast<std::size_t>(row.param.cause)];
}

class ReactionTable : public testing::TestWithParam<Row> {};

TEST_P(ReactionTable, DecidesAsTheTableSays) {
  const Row& row = GetParam();
  EXPECT_EQ(reaction_to(row.cause, false, Overrun::fault, ContactStop::path), row.alone);
  EXPECT_EQ(reaction_to(row.cause, true, Overrun::fault, ContactStop::path), row.contained);
}

/// Takes a supervisor to a state as a cell would.
void take_to(Supervisor& supervisor, RunState state) {
  supervisor.watch_cell = false;
  if (state == RunState::running) return;
  if (state == RunState::fault) {
    supervisor.react({StopCause::component, 5}, false);
    return;
  }
  supervisor.latch().request(realtime::StopKind::controlled);
  supervisor.judge(0, false, Request::none);
  supervisor.latch().clear();
  if (state == RunState::stopping) return;
  supervisor.judge(1, true, Request::none);
  if (state == RunState::backing) supervisor.judge(2, true, Request::back);
}

TEST_P(ReactionTable, ChangesEachStateAsTheStateTableSays) {
  const Row& row = GetParam();
  for (const RunState state :
       {RunState::running, RunState::stopping, RunState::held, RunState::fault, RunState::backing})
    for (const bool contained : {false, true}) {
      Supervisor supervisor;
      take_to(supervisor, state);
      ASSERT_EQ(supervisor.state(), state);
      const StopCause before = supervisor.cause();
      supervisor.set_when_late(Overrun::fault, {Overrun::fault});
      supervisor.set_contact_stop(ContactStop::path);
      const Reaction reaction = contained ? row.contained : row.alone;
      EXPECT_EQ(supervisor.react({row.cause, 0, 3, -1, 0.5}, contained), reaction.group_off) << name(state);
      RunState then = state;
      if (reaction.loop == stops) then = next(state, Event::stop);
      if (reaction.loop == faults) then = next(state, Event::fault);
      EXPECT_EQ(supervisor.state(), then) << name(state);
      EXPECT_EQ(supervisor.cause(), then == state ? before : reported(row.cause)) << name(state);
      if (then != state) {
        EXPECT_EQ(supervisor.event().cause, row.cause);
        EXPECT_EQ(supervisor.event().interface, 3);
        EXPECT_EQ(supervisor.event().value, 0.5);
      }
    }
}

TEST_P(ReactionTable, HasAWordAndASentence) {
  EXPECT_NE(std::string(name(GetParam().cause)), "");
  EXPECT_NE(std::string(code(GetParam().cause)), "");
}

INSTANTIATE_TEST_SUITE_P(All, ReactionTable, testing::ValuesIn(table()), name_of);

TEST(ReactionTable, HasARowForEachCause) {
  ASSERT_EQ(table().size(), static_cast<std::size_t>(kStopCauses));
  for (std::size_t i = 0; i < table().size(); ++i) EXPECT_EQ(static_cast<std::size_t>(table()[i].cause), i);
}

TEST(ReactionTable, LateThreadsAndCyclesFollowWhatTheCellSays) {
  for (const bool contained : {false, true}) {
    EXPECT_EQ(reaction_to(StopCause::late, contained, Overrun::report, ContactStop::none),
              (Reaction{keeps_going, false}));
    EXPECT_EQ(reaction_to(StopCause::late, contained, Overrun::hold, ContactStop::none),
              (Reaction{stops, false}));
  }
  Supervisor supervisor;
  supervisor.watch_cell = false;
  supervisor.set_when_late(Overrun::report, {Overrun::hold, Overrun::fault});
  supervisor.react({StopCause::late}, false);
  EXPECT_EQ(supervisor.state(), RunState::running) << "cycles of the loop";
  supervisor.react({StopCause::late, 0}, false);
  EXPECT_EQ(supervisor.state(), RunState::stopping) << "the thread of the first component";
  supervisor.react({StopCause::late, 1}, false);
  EXPECT_EQ(supervisor.state(), RunState::fault) << "the thread of the second";
}

TEST(ReactionTable, ContactsFollowWhatTheCellSays) {
  for (const bool contained : {false, true}) {
    EXPECT_EQ(reaction_to(StopCause::contact, contained, Overrun::report, ContactStop::none),
              (Reaction{keeps_going, false}));
    EXPECT_EQ(reaction_to(StopCause::contact, contained, Overrun::report, ContactStop::cut),
              (Reaction{stops, false}));
  }
  for (const ContactStop stop : {ContactStop::none, ContactStop::path, ContactStop::cut}) {
    Supervisor supervisor;
    supervisor.watch_cell = false;
    supervisor.set_contact_stop(stop);
    supervisor.react({StopCause::contact}, false);
    const controllers::Verdict verdict = supervisor.judge(0, false, Request::none);
    EXPECT_EQ(verdict.immediate, stop != ContactStop::none);
    EXPECT_EQ(verdict.cut, stop == ContactStop::cut);
  }
}

TEST(ReactionTable, AContactThatIsNotMeantStopsAsHardWhileOthersAreMeant) {
  for (const ContactStop stop : {ContactStop::path, ContactStop::cut}) {
    Supervisor supervisor;
    supervisor.watch_cell = false;
    supervisor.set_contact_stop(stop);
    supervisor.set_contacts_meant(true);
    supervisor.react({StopCause::contact}, false);
    EXPECT_FALSE(supervisor.judge(0, false, Request::none).immediate) << "the cell thread judges it";
    EXPECT_EQ(supervisor.state(), RunState::running);
    supervisor.stop_for_contact();
    supervisor.latch().request(realtime::StopKind::controlled);
    const controllers::Verdict verdict = supervisor.judge(1, false, Request::none);
    EXPECT_TRUE(verdict.immediate);
    EXPECT_EQ(verdict.cut, stop == ContactStop::cut);
    EXPECT_EQ(supervisor.state(), RunState::stopping);
    EXPECT_EQ(supervisor.cause(), StopCause::contact);
  }
}

TEST(ReactionTable, OnlyStopsThatNobodyAskedForCountAsOthers) {
  Supervisor supervisor;
  supervisor.watch_cell = false;
  supervisor.latch().request(realtime::StopKind::controlled);
  const controllers::Verdict asked = supervisor.judge(0, false, Request::none);
  EXPECT_EQ(asked.stops, asked.stop_requests);
  supervisor.react({StopCause::gap}, false);
  EXPECT_EQ(supervisor.judge(1, false, Request::none).stops, asked.stops + 1);
}

}  // namespace
}  // namespace polyarm::control
