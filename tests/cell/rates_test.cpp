/// Robots of one cell that run at rates of their own.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <tuple>
#include <utility>

#include "polyarm/cell/run.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::OpenCell;

struct TwoRobots {
  test::Folder folder;
  struct Notes : cell::Observer {
    std::string all;
    void on_note(const std::string& text) override { all += text + "\n"; }
  } observer;
  std::unique_ptr<test::OpenCell> made;

  explicit TwoRobots(const std::string& base, bool lock_step = true, const std::string& controllers = "") {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    const std::string model = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
    const std::string file = folder.write(
        "cell.yaml", "polyarm: cell/1\nrate: 1000\nrobots:\n  arm: {model: " + model +
                         ", hardware: mock}\n  base: {model: " + model + ", hardware: mock" + base + "}\n" +
                         (controllers.empty() ? "" : "controllers: controllers.yaml\n"));
    if (!controllers.empty()) folder.write("controllers.yaml", controllers);
    cell::CellOptions options;
    options.lock_step = lock_step;
    made = std::make_unique<test::OpenCell>(cell::read_cell_file(file), description::Catalogue({}), options,
                                            observer);
  }
  unsigned divisor_of_component(const std::string& robot) {
    hardware::Hardware& hardware = made->loop().hardware();
    const auto index = made->loop().table().find_state(robot + "/joint_1/position");
    return hardware.diagnostics().info(static_cast<std::size_t>(hardware.component_of_state(*index))).divisor;
  }
  std::size_t index_of(const std::string& robot) {
    const auto index = made->loop().table().find_state(robot + "/joint_1/position");
    return static_cast<std::size_t>(made->loop().hardware().component_of_state(*index));
  }
  hardware::HostedInfo component(const std::string& robot) {
    return made->loop().hardware().diagnostics().info(index_of(robot));
  }
  std::uint64_t updates_of(const std::string& controller) {
    for (const control::ListedController& c : made->loop().controllers().list())
      if (c.name == controller) return c.updates;
    return 0;
  }
};

TEST(Rates, ARobotAndItsControllersRunAtItsOwn) {
  TwoRobots cell(", rate: 50");
  EXPECT_EQ(cell.divisor_of_component("arm"), 1u);
  EXPECT_EQ(cell.divisor_of_component("base"), 20u);
  for (int k = 0; k < 2000; ++k) cell.made->loop().step_next();
  EXPECT_EQ(cell.updates_of("arm_joint_trajectory_controller"), 2000u);
  EXPECT_EQ(cell.updates_of("base_joint_trajectory_controller"), 100u);
}

TEST(Rates, AThreadOfItsOwnIsAWord) {
  TwoRobots cell(", rate: 50, thread: true");
  hardware::Hardware& hardware = cell.made->loop().hardware();
  int own = 0;
  for (std::size_t i = 0; i < hardware.size(); ++i) own += hardware.diagnostics().info(i).async ? 1 : 0;
  EXPECT_EQ(own, 1);
}

TEST(Rates, OnAThreadItIsAnyRateAndTheControllersKeepItAsFarAsTheLoopGoes) {
  for (const auto& [rate, period, updates] :
       {std::tuple{"30", 33'333'333, 60u}, {"333", 3'003'003, 666u}, {"2500", 400'000, 2000u}}) {
    TwoRobots cell(std::string(", thread: true, rate: ") + rate);
    EXPECT_EQ(cell.component("base").period, period);
    EXPECT_FALSE(cell.component("arm").async);
    for (int k = 0; k < 2000; ++k) cell.made->loop().step_next();
    EXPECT_EQ(cell.updates_of("arm_joint_trajectory_controller"), 2000u);
    EXPECT_EQ(cell.updates_of("base_joint_trajectory_controller"), updates) << rate;
  }
}

TEST(Rates, AControllerOfAnyRateKeepsItAndKnowsIt) {
  TwoRobots cell(", rate: 50", true, R"(
controller_manager:
  ros__parameters:
    slow: {type: joint_trajectory_controller/JointTrajectoryController}
    fast: {type: joint_trajectory_controller/JointTrajectoryController}
slow: {ros__parameters: {update_rate: 30, joints: [base/joint_1]}}
fast: {ros__parameters: {update_rate: 5000, joints: [arm/joint_1]}}
)");
  for (int k = 0; k < 10'000; ++k) cell.made->loop().step_next();
  EXPECT_EQ(cell.updates_of("slow"), 300u) << "rounding up to a cycle does not add up";
  EXPECT_EQ(cell.made->loop().controllers().context("slow")->period, 33'333'333);
  EXPECT_EQ(cell.updates_of("fast"), 10'000u);
  EXPECT_NE(cell.observer.all.find("fast: 5000 Hz is more than the 1000 Hz"), std::string::npos)
      << cell.observer.all;
}

TEST(Rates, InLockStepAThreadOfAnyRateIsTheSameEachTime) {
  const auto trace = [] {
    TwoRobots cell(", thread: true, rate: 333");
    for (int k = 0; k < 2000; ++k) cell.made->loop().step_next();
    return cell.made->loop().trace().text();
  };
  EXPECT_EQ(trace(), trace());
}

TEST(Rates, HowTheThreadRunsIsReadAndWhatCannotBeIsRefused) {
  TwoRobots cell(", thread: {priority: 60, cpu: 0}");
  hardware::Hardware& hardware = cell.made->loop().hardware();
  const auto base = cell.index_of("base");
  EXPECT_TRUE(hardware.diagnostics().info(base).async);
  EXPECT_EQ(hardware.diagnostics().thread_options(base).priority, 60);
  EXPECT_EQ(hardware.diagnostics().thread_options(base).cpu, 0);
  for (const char* wrong : {"{priority: 100}", "{cpu: 1.5}", "{prio: 60}", "sometimes"})
    EXPECT_THROW(TwoRobots(std::string(", thread: ") + wrong), Error) << wrong;
}

TEST(Rates, HowTheControlThreadRunsIsSaidByTheRunElseTheCellElseTheControllersFile) {
  const std::string controllers =
      "controller_manager:\n  ros__parameters:\n    thread_priority: 61\n    cpu_affinity: [1]\n";
  const TwoRobots cell("", true,
                       controllers + "    tail: {type: joint_state_broadcaster/JointStateBroadcaster}\n");
  cell::LoopEntry stated = cell.made->file().loop;
  cell::RunOptions options;
  const auto thread = [&] { return cell::control_thread(options, stated, cell.made->manager()); };
  EXPECT_EQ(thread().priority, 61);
  EXPECT_EQ(thread().cpu, 1);
  EXPECT_TRUE(thread().lock_memory);
  stated.priority = 0;
  stated.cpu = -1;
  EXPECT_EQ(thread().priority, 0);
  EXPECT_EQ(thread().cpu, -1);
  EXPECT_FALSE(thread().lock_memory);
  options.priority = 7;
  options.cpu = 2;
  EXPECT_EQ(thread().priority, 7);
  EXPECT_EQ(thread().cpu, 2);
}

/// Steps and ticks a cell on the wall clock until its notes hold this, or for a minute.
bool tells(TwoRobots& cell, const std::string& part) {
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (cell.observer.all.find(part) == std::string::npos && std::chrono::steady_clock::now() < patience) {
    cell.made->tick(cell.made->loop().cycle().time);
    for (int k = 0; k < 2; ++k) cell.made->loop().step_next();
  }
  return cell.observer.all.find(part) != std::string::npos;
}

TEST(Rates, HealthTellsWhatEachPartOfTheCycleCostsAndEachThread) {
  TwoRobots cell("", false, R"(
controller_manager:
  ros__parameters:
    beside: {type: joint_trajectory_controller/JointTrajectoryController}
    inside: {type: joint_trajectory_controller/JointTrajectoryController}
beside: {ros__parameters: {is_async: true, joints: [base/joint_1]}}
inside: {ros__parameters: {update_rate: 100, joints: [arm/joint_1]}}
)");
  control::ControlLoop& loop = cell.made->loop();
  const auto cycles = [&loop](int count) {
    for (int k = 0; k < count; ++k) {
      loop.woke(0, 0);
      loop.step_next();
    }
  };
  const auto beside_runs = [&loop] {
    for (const control::ListedController& c : loop.controllers().list())
      if (c.thread) return std::uint64_t{c.thread->runs};
    return std::uint64_t{0};
  };
  cycles(500);
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (beside_runs() == 0 && std::chrono::steady_clock::now() < patience) cycles(10);
  cell.made->tick(loop.cycle().time);
  std::string line;
  cell.made->requests().handle(R"({"request": "health"})", [&](const std::string& text) {
    line = text;
    return true;
  });
  const test::Json health = test::Json::parse(line)["result"];
  const auto find = [&](const char* list, const char* what, const std::string& name) -> test::Json {
    for (const test::Json& entry : health[list])
      if (entry.value(what, "") == name) return entry;
    ADD_FAILURE() << name << " is not among the " << list << ": " << line;
    return {};
  };
  EXPECT_EQ(find("parts", "controller", "inside")["turns"], (health["cycles"].get<int>() + 9) / 10);
  EXPECT_EQ(find("parts", "controller", "inside")["rate_hz"], 100);
  EXPECT_EQ(find("parts", "component", "R6Bot")["turns"], health["cycles"]);
  EXPECT_GT(find("parts", "component", "R6Bot")["cost"]["max_ns"], 0);
  EXPECT_GT(find("parts", "component", "R6Bot")["period"]["max_ns"], 0);
  EXPECT_GT(find("threads", "controller", "beside")["runs"], 0);
  EXPECT_GT(health["period"]["max_ns"], 0) << "of the loop";
}

TEST(Rates, HealthTellsEachThreadFromTheOthers) {
  TwoRobots cell(", rate: 50, thread: {overrun: hold, overrun_after: 20}");
  for (int k = 0; k < 1001; ++k) cell.made->loop().step_next();
  cell.made->tick(cell.made->loop().cycle().time);
  std::string line;
  cell.made->requests().handle(R"({"request": "health"})", [&](const std::string& text) {
    line = text;
    return true;
  });
  const test::Json threads = test::Json::parse(line)["result"]["threads"];
  ASSERT_EQ(threads.size(), 1u) << line;
  EXPECT_EQ(threads[0]["component"], cell.component("base").name);
  EXPECT_EQ(threads[0]["rate_hz"], 50);
  EXPECT_EQ(threads[0]["runs"], 51);
  EXPECT_EQ(threads[0]["late"], 0);
  EXPECT_EQ(threads[0]["missed"], 0);
  for (const char* times : {"cost", "wake_up", "period"}) EXPECT_TRUE(threads[0][times].contains("p99_ns"));
  const auto base = cell.index_of("base");
  EXPECT_EQ(cell.made->loop().hardware().diagnostics().when_late(base), hardware::WhenLate::hold);
  EXPECT_EQ(cell.made->snapshot().threads[base].runs, 51u) << "and the snapshot says it";
  EXPECT_THROW(TwoRobots(", thread: {overrun: stop}"), Error);
  EXPECT_THROW(TwoRobots(", thread: {overrun_after: 0}"), Error);
}

TEST(Rates, WhatTheMachineRefusesAThreadIsToldAndItRunsWithout) {
  TwoRobots cell(", rate: 300, thread: {cpu: 1023}", false);
  cell.made->loop().begin();
  EXPECT_TRUE(
      tells(cell, "the thread of " + cell.component("base").name + " could not be pinned to processor 1023"))
      << cell.observer.all;
  const auto base = cell.index_of("base");
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (cell.made->loop().hardware().diagnostics().thread_health(base)->runs == 0 &&
         std::chrono::steady_clock::now() < patience)
    cell.made->loop().step_next();
  EXPECT_GT(cell.made->loop().hardware().diagnostics().thread_health(base)->runs, 0u);
  cell.made->loop().end();
}

TEST(Rates, WhatIsNoPartOfTheLoopsIsRefusedWithWhatWouldBe) {
  for (const auto& [rate, hint] : {std::pair{"300", "250"}, std::pair{"3000", "raise the cell's rate"}}) {
    try {
      TwoRobots cell(std::string(", rate: ") + rate);
      ADD_FAILURE() << rate << " was taken";
    } catch (const Error& e) {
      EXPECT_EQ(e.problems().front().code, "bad-rate");
      EXPECT_NE(e.problems().front().advice.find(hint), std::string::npos) << e.problems().front().advice;
      EXPECT_NE(e.problems().front().advice.find("thread: true"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace polyarm
