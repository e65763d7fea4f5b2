#include "polyarm/control/switch_plan.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"

namespace polyarm::control {
namespace {

using hardware::LifecycleState;
using Names = std::vector<std::string>;

const Unavailable kAllThere = [](const std::string&, bool) { return std::string{}; };

ControllerView arm(const std::string& name, Names commands, LifecycleState state = LifecycleState::inactive) {
  return {name, state, std::move(commands), {}, {}, {}};
}

/// top → middle (reference m) → bottom (reference b) → joint
std::vector<ControllerView> chain(LifecycleState state) {
  return {{"top", state, {"middle/m"}, {}, {}, {}},
          {"middle", state, {"bottom/b"}, {}, {"middle/m"}, {}},
          {"bottom", state, {"j/effort"}, {}, {"bottom/b"}, {}}};
}

TEST(SwitchPlan, StartsAndStopsWhatWasAsked) {
  const std::vector all{arm("old", {"j/position"}, LifecycleState::active), arm("new", {"j/position"})};
  const SwitchPlan plan = plan_switch(all, {{"new"}, {"old"}}, kAllThere);
  ASSERT_TRUE(plan.ok) << plan.reason;
  EXPECT_EQ(plan.stop, Names{"old"});
  EXPECT_EQ(plan.start, Names{"new"});
  EXPECT_EQ(plan.stop_interfaces, Names{"j/position"});
  EXPECT_EQ(plan.start_interfaces, Names{"j/position"});
}

TEST(SwitchPlan, RefusesWithAReasonAndChangesNothing) {
  const std::vector all{arm("old", {"j/position"}, LifecycleState::active), arm("new", {"j/position"}),
                        arm("raw", {"k/position"}, LifecycleState::unconfigured)};
  const auto reason = [&](const SwitchRequest& request, const char* code) {
    const SwitchPlan plan = plan_switch(all, request, kAllThere);
    EXPECT_FALSE(plan.ok);
    EXPECT_EQ(plan.code, code);
    EXPECT_TRUE(plan.start.empty() && plan.stop.empty());
    return plan.reason;
  };
  EXPECT_NE(reason({{"new"}, {}}, "claimed").find("'j/position', which the active controller 'old' holds"),
            std::string::npos);
  EXPECT_NE(reason({{"nev"}, {}}, "unknown-controller").find("did you mean 'new'"), std::string::npos);
  reason({{"raw"}, {}}, "not-configured");
  reason({{"old"}, {}}, "already-active");
  reason({{}, {"new"}}, "not-active");
}

TEST(SwitchPlan, BestEffortLeavesOutWhatCannotBe) {
  const std::vector all{arm("a", {"j/position"}), arm("b", {"j/position"}), arm("c", {"k/position"})};
  const SwitchPlan plan = plan_switch(all, {{"a", "b", "c"}, {}, Strictness::best_effort}, kAllThere);
  ASSERT_TRUE(plan.ok);
  EXPECT_EQ(plan.start.size(), 2u);
  EXPECT_EQ(plan.left_out.size(), 1u);
  EXPECT_NE(plan.left_out[0].find("'b'"), std::string::npos) << "of two that want the same the first wins";
}

TEST(SwitchPlan, ARestartStopsAndStarts) {
  const std::vector all{arm("a", {"j/position"}, LifecycleState::active)};
  const SwitchPlan plan = plan_switch(all, {{"a"}, {"a"}}, kAllThere);
  ASSERT_TRUE(plan.ok) << plan.reason;
  EXPECT_EQ(plan.stop, Names{"a"});
  EXPECT_EQ(plan.start, Names{"a"});
}

TEST(SwitchPlan, AChainStartsFromItsEndAndStopsFromItsTop) {
  const SwitchPlan up =
      plan_switch(chain(LifecycleState::inactive), {{"top", "middle", "bottom"}, {}}, kAllThere);
  ASSERT_TRUE(up.ok) << up.reason;
  EXPECT_EQ(up.start, (Names{"bottom", "middle", "top"}));
  EXPECT_EQ(up.chained, (Names{"middle", "bottom"}));
  EXPECT_EQ(up.start_interfaces, Names{"j/effort"}) << "references are not hardware's";
  const SwitchPlan down =
      plan_switch(chain(LifecycleState::active), {{}, {"bottom", "middle", "top"}}, kAllThere);
  ASSERT_TRUE(down.ok) << down.reason;
  EXPECT_EQ(down.stop, (Names{"top", "middle", "bottom"}));
}

TEST(SwitchPlan, AChainNeedsAllItsLinks) {
  EXPECT_EQ(plan_switch(chain(LifecycleState::inactive), {{"top"}, {}}, kAllThere).code, "chain-missing");
  EXPECT_EQ(plan_switch(chain(LifecycleState::active), {{}, {"bottom"}}, kAllThere).code, "chain-in-use");
  const SwitchPlan up =
      plan_switch(chain(LifecycleState::inactive), {{"top"}, {}, Strictness::automatic}, kAllThere);
  EXPECT_EQ(up.start, (Names{"bottom", "middle", "top"}));
  const SwitchPlan down =
      plan_switch(chain(LifecycleState::active), {{}, {"bottom"}, Strictness::automatic}, kAllThere);
  EXPECT_EQ(down.stop, (Names{"top", "middle", "bottom"}));
}

TEST(SwitchPlan, OnlyTheTopOfAChainMayStopAlone) {
  const SwitchPlan plan = plan_switch(chain(LifecycleState::active), {{}, {"top"}}, kAllThere);
  ASSERT_TRUE(plan.ok) << plan.reason;
  EXPECT_EQ(plan.unchained, Names{"middle"});
  EXPECT_TRUE(plan.chained.empty());
}

TEST(SwitchPlan, ForceStopsWhoStandsInTheWay) {
  const std::vector all{arm("old", {"j/position"}, LifecycleState::active), arm("new", {"j/position"})};
  EXPECT_FALSE(plan_switch(all, {{"new"}, {}, Strictness::automatic}, kAllThere).ok);
  const SwitchPlan plan = plan_switch(all, {{"new"}, {}, Strictness::force}, kAllThere);
  ASSERT_TRUE(plan.ok) << plan.reason;
  EXPECT_EQ(plan.stop, Names{"old"});
}

TEST(SwitchPlan, InactiveHardwareCannotBeCommanded) {
  const std::vector all{arm("a", {"j/position"})};
  const SwitchPlan plan = plan_switch(all, {{"a"}, {}}, [](const std::string&, bool command) {
    return command ? std::string("the hardware component 'arm' is inactive") : std::string{};
  });
  EXPECT_EQ(plan.code, "hardware-inactive");
  EXPECT_NE(plan.reason.find("'arm' is inactive"), std::string::npos);
}

TEST(SwitchPlan, UpdatesGoDownTheChainWhateverTheOrderOfLoading) {
  auto all = chain(LifecycleState::active);
  std::swap(all[0], all[2]);
  const auto order = update_order(all);
  EXPECT_EQ(all[order[0]].name, "top");
  EXPECT_EQ(all[order[2]].name, "bottom");
}

TEST(SwitchPlan, ReadersOfAnExportedStateComeAfterIt) {
  const std::vector<ControllerView> all{{"reader", LifecycleState::active, {}, {"filter/x"}, {}, {}},
                                        {"filter", LifecycleState::active, {}, {}, {}, {"filter/x"}}};
  EXPECT_EQ(all[update_order(all)[0]].name, "filter");
}

TEST(SwitchPlan, ACircleIsNamed) {
  const std::vector<ControllerView> all{{"a", LifecycleState::inactive, {"b/r"}, {}, {"a/r"}, {}},
                                        {"b", LifecycleState::inactive, {"a/r"}, {}, {"b/r"}, {}}};
  EXPECT_THROW(update_order(all), Error);
  EXPECT_EQ(plan_switch(all, {{"a", "b"}, {}}, kAllThere).code, "chain-circle");
}

TEST(SwitchPlan, AFailureTakesItsWholeChainAndNobodyElse) {
  auto all = chain(LifecycleState::active);
  all.push_back(arm("other", {"k/position"}, LifecycleState::active));
  const std::vector<std::size_t> fallen = chain_of(all, 1, {true, true, true, true});
  EXPECT_EQ(fallen, (std::vector<std::size_t>{0, 1, 2}));
}

}  // namespace
}  // namespace polyarm::control
