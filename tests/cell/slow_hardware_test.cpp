/// Hardware that takes its time: its callbacks wait at a gate that a test opens, on threads of their own,
/// while the cell goes on.
#include <gtest/gtest.h>

#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using hardware::LifecycleState;
using test::FailingMock;
using test::Json;
using test::LockStepCell;

constexpr const char* kSlowControllers = R"(
controller_manager:
  ros__parameters:
    update_rate: 1000
    tail: {type: forward_command_controller/ForwardCommandController}
tail:
  ros__parameters: {joints: [joint_5, joint_6], interface_name: position}
)";

class SlowHardware : public ::testing::Test {
 protected:
  ~SlowHardware() override {
    for (test::Gate* gate : {&FailingMock::configuring, &FailingMock::initialising, &FailingMock::erring})
      gate->open();
  }
  /// Lets the callback that is under way come back, and the cell see it.
  void come_back() {
    while (const hardware::Transition* pending = hardware().pending(0)) {
      ASSERT_TRUE(pending->wait(60'000'000'000));
      cell.tick();
    }
    cell.tick();
  }
  /// Until the component that a reload makes is called for the first time.
  void come_to_init() {
    while (!hardware().pending(0) || hardware().pending(0)->step() != hardware::Step::init) {
      if (const hardware::Transition* pending = hardware().pending(0)) {
        ASSERT_TRUE(pending->wait(60'000'000'000));
      }
      cell.cell().worker().drain();
      cell.tick();
    }
  }
  /// An answer that comes in the meantime.
  Json at_once(const Json& request) {
    const auto answers = cell.give(request);
    for (int ticks = 0; ticks < 3 && answers->empty(); ++ticks) cell.tick();
    return answers->empty() ? Json("no answer") : answers->back();
  }
  Json ask(const std::string& request, const std::string& state = "") {
    Json out{{"request", request}, {"name", name}};
    if (!state.empty()) out["state"] = state;
    const auto answers = cell.give(out);
    while (answers->empty()) {
      come_back();
      cell.tick();
    }
    return answers->back();
  }
  Json begin(const std::string& request, const std::string& state = "") {
    Json out{{"request", request}, {"name", name}};
    if (!state.empty()) out["state"] = state;
    waiting = cell.give(out);
    for (int ticks = 0; ticks < 5; ++ticks) cell.tick();
    return *waiting;
  }
  hardware::Hardware& hardware() { return cell.cell().loop().hardware(); }

  LockStepCell cell{kSlowControllers, true};
  const std::string name = hardware().component_name(0);
  std::shared_ptr<std::vector<Json>> waiting;
};

TEST_F(SlowHardware, TheCellGoesOnWhileItIsConfigured) {
  ASSERT_TRUE(ask("hardware.state", "unconfigured")["ok"]);
  FailingMock::configuring.close();
  EXPECT_TRUE(begin("hardware.state", "active").empty());
  const std::uint64_t before = cell.cell().loop().health().cycles;
  const Json health = at_once({{"request", "health"}});
  ASSERT_TRUE(health.is_object()) << health;
  EXPECT_EQ(health["result"]["state"], "running");
  const Json listed = at_once({{"request", "hardware.list"}})["result"][0];
  EXPECT_EQ(listed["state"], "unconfigured");
  EXPECT_EQ(listed["being"], "configured");
  cell.run(3);
  EXPECT_GE(std::uint64_t{cell.cell().loop().health().cycles}, before + 3000);
  EXPECT_EQ(cell.cell().snapshot().state, control::RunState::running);
  EXPECT_EQ(cell.told("is being configured for 2 s; the cell continues"), 1);
  EXPECT_TRUE(waiting->empty());
  FailingMock::configuring.open();
  come_back();
  come_back();
  ASSERT_EQ(waiting->size(), 1u);
  EXPECT_EQ(waiting->front()["result"]["state"], "active");
  EXPECT_EQ(hardware().state_of(0), LifecycleState::active);
}

TEST_F(SlowHardware, WhatElseIsAskedOfItIsRefusedWithASentence) {
  ask("hardware.state", "unconfigured");
  FailingMock::configuring.close();
  begin("hardware.state", "inactive");
  for (const char* request : {"hardware.state", "hardware.reload", "hardware.recover"}) {
    Json wanted{{"request", request}, {"name", name}};
    if (request == std::string("hardware.state")) wanted["state"] = "unconfigured";
    const auto other = cell.give(wanted);
    cell.run(0.5);
    EXPECT_TRUE(other->empty()) << "a second is waited, it may be over soon";
    cell.run(0.6);
    ASSERT_EQ(other->size(), 1u) << request;
    EXPECT_EQ(other->front()["error"]["code"], "busy") << other->front();
    EXPECT_NE(other->front()["error"]["what"].get<std::string>().find("is being configured"),
              std::string::npos);
  }
  const Json start = at_once({{"request", "control.switch"}, {"activate", "tail"}});
  EXPECT_FALSE(start["ok"].get<bool>()) << "its controllers cannot begin either";
  FailingMock::configuring.open();
  come_back();
  EXPECT_EQ(waiting->front()["result"]["state"], "inactive");
}

TEST_F(SlowHardware, WhoWaitsAMomentComesAfterIt) {
  ask("hardware.state", "unconfigured");
  FailingMock::configuring.close();
  begin("hardware.state", "inactive");
  const auto other = cell.give(Json{{"request", "hardware.state"}, {"name", name}, {"state", "active"}});
  cell.run(0.1);
  FailingMock::configuring.open();
  come_back();
  come_back();
  ASSERT_EQ(other->size(), 1u);
  EXPECT_EQ(other->front()["result"]["state"], "active");
}

TEST_F(SlowHardware, AReloadThatWaitsForTheDiskKeepsNobody) {
  test::Gate disk;
  disk.close();
  cell.cell().worker().post([&disk] { disk.pass(); });
  begin("hardware.reload");
  for (int k = 0; k < 5; ++k) come_back();  // it is unconfigured, and nothing of it is pending
  cell.run(1);
  EXPECT_EQ(at_once({{"request", "health"}})["result"]["state"], "running");
  EXPECT_EQ(hardware().state_of(0), LifecycleState::unconfigured);
  EXPECT_TRUE(waiting->empty());
  FailingMock::initialising.close();  // else it may have been called before anybody looks
  disk.open();
  come_to_init();
  FailingMock::initialising.open();
  for (int k = 0; k < 5; ++k) come_back();
  ASSERT_EQ(waiting->size(), 1u);
  EXPECT_EQ(waiting->front()["result"]["state"], "active") << waiting->front();
}

TEST_F(SlowHardware, AReloadIsMadeElsewhereToo) {
  FailingMock::initialising.close();
  begin("hardware.reload");
  come_to_init();
  EXPECT_TRUE(at_once({{"request", "health"}})["ok"]);
  EXPECT_TRUE(waiting->empty());
  FailingMock::initialising.open();
  for (int k = 0; k < 5; ++k) come_back();
  ASSERT_EQ(waiting->size(), 1u);
  EXPECT_EQ(waiting->front()["result"]["state"], "active") << waiting->front();
}

TEST_F(SlowHardware, AfterAFailureTheCellDoesNotWaitForOnError) {
  FailingMock::erring.close();
  FailingMock::fails = true;
  cell.run(0.02);
  FailingMock::fails = false;
  EXPECT_TRUE(at_once({{"request", "health"}})["ok"]);
  EXPECT_EQ(at_once({{"request", "hardware.list"}})["result"][0]["being"], "freed from its error");
  FailingMock::erring.open();
  come_back();
  EXPECT_EQ(hardware().state_of(0), LifecycleState::unconfigured);
  EXPECT_EQ(ask("hardware.recover")["result"]["state"], "active");
}

TEST(SlowHardwareAtTheEnd, ACallbackThatNeverComesBackIsLeftBehindWithASentence) {
  LockStepCell cell(kSlowControllers, true, 1);
  const std::string name = cell.cell().loop().hardware().component_name(0);
  auto& hardware = cell.cell().loop().hardware();
  const auto down = cell.give(Json{{"request", "hardware.state"}, {"name", name}, {"state", "unconfigured"}});
  while (down->empty()) {
    if (const auto* pending = hardware.pending(0)) pending->wait(60'000'000'000);
    cell.tick();
  }
  FailingMock::configuring.close();
  const int passed = FailingMock::configuring.passed();
  cell.give(Json{{"request", "hardware.state"}, {"name", name}, {"state", "active"}});
  cell.tick();
  cell.end();
  EXPECT_EQ(cell.told("the cell stops waiting for it"), 1);
  FailingMock::configuring.open();
  FailingMock::configuring.wait_for(passed + 1);
}

}  // namespace
}  // namespace polyarm
