/// A plugin that never comes back keeps nobody: it is named, and the run ends without it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

#include "polyarm/cell/run.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

/// The mock, whose reads or configuration wait at a gate; with or without a thread of its own.
class Hanging : public drivers::MockComponent {
 public:
  static inline std::atomic<bool> own_thread{false};
  static inline std::atomic<int> waiting{0};
  static inline test::Gate reading, configuring, deactivating;
  static void close(test::Gate& gate) {
    waiting = 0;
    gate.close();
  }
  bool blocks() const noexcept override { return own_thread; }
  hardware::CallbackReturn on_configure() override {
    pass(configuring);
    return drivers::MockComponent::on_configure();
  }
  hardware::CallbackReturn on_deactivate() override {
    pass(deactivating);
    return drivers::MockComponent::on_deactivate();
  }
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override {
    pass(reading);
    return drivers::MockComponent::read(cycle, states);
  }

 private:
  static void pass(test::Gate& gate) {
    ++waiting;
    waiting.notify_all();
    gate.pass();
  }
};

struct Notes : cell::Observer {
  std::string all;
  void on_note(const std::string& text) override { all += text + "\n"; }
};

class HangingPlugin : public testing::Test {
 protected:
  ~HangingPlugin() override {
    Hanging::reading.open();
    Hanging::configuring.open();
    Hanging::deactivating.open();
  }
  std::unique_ptr<test::OpenCell> make(bool own_thread, cell::CellOptions options = {}) {
    Hanging::own_thread = own_thread;
    hardware::register_driver("hanging", [] { return std::unique_ptr<hardware::Component>(new Hanging); });
    if (!options.lock_step) options.hardware_timeout = 1;
    const std::string model = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
    return std::make_unique<test::OpenCell>(
        cell::read_cell_file(folder.write(
            "cell.yaml",
            "polyarm: cell/1\nrate: 1000\nrobots:\n  arm: {model: " + model + ", hardware: hanging}\n")),
        description::Catalogue({}), options, notes);
  }
  const test::Folder folder;
  Notes notes;
};

TEST_F(HangingPlugin, ARunEndsWithoutTheLoopThatItKeepsAndNamesIt) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  // As the program does it: the loop is still inside the plugin, so the process ends without tidying up.
  const auto run_and_leave = [this] {
    const std::unique_ptr<test::OpenCell> cell = make(false);
    Hanging::close(Hanging::reading);
    std::thread person([] {
      Hanging::waiting.wait(0);
      cell::request_stop();
    });
    cell::RunOptions options;
    options.socket = options.console = false;
    options.patience = 1;
    const cell::RunResult result = cell::run(*cell, options, notes);
    person.join();
    const bool right = result.stuck && result.outcome == cell::Outcome::failed && result.problems.size() == 1 &&
                       result.problems[0].code == "stuck" &&
                       cell::stops_requested() == 0;  // the next run is not stopped by this one's
    fmt::print(stderr, "{}\n", result.problems.empty() ? "no problem" : result.problems[0].what);
    std::_Exit(right ? 0 : 1);
  };
  EXPECT_EXIT(run_and_leave(), testing::ExitedWithCode(0), "waits for the hardware component R6Bot");
}

TEST_F(HangingPlugin, ItsOwnThreadIsLeftBehindWithASentence) {
  auto cell = make(true);
  cell->loop().begin();
  Hanging::close(Hanging::reading);
  while (Hanging::waiting == 0) cell->loop().step_next();
  for (int k = 0; k < 1000; ++k) cell->loop().step_next();  // the loop goes on, else this would never end
  cell->loop().end();
  cell.reset();
  EXPECT_NE(notes.all.find("the cell stops waiting for it"), std::string::npos) << notes.all;
}

TEST_F(HangingPlugin, ARunInLockStepEndsWithoutTheCallbackThatKeepsIt) {
  cell::CellOptions options;
  options.lock_step = true;
  options.hardware_timeout = 100'000'000;
  auto cell = make(false, options);
  cell->loop().begin();
  cell->loop().step_next();
  Hanging::close(Hanging::deactivating);
  cell->loop().end();
  cell.reset();
  EXPECT_NE(notes.all.find("the cell stops waiting for it"), std::string::npos) << notes.all;
}

TEST_F(HangingPlugin, WhoAsksForTheEndDuringTheStartInLockStepHasItToo) {
  Hanging::close(Hanging::configuring);
  cell::CellOptions options;
  options.lock_step = true;
  options.start_given_up = [] { return Hanging::waiting > 0; };
  EXPECT_THROW(make(false, options), Error);
  EXPECT_NE(notes.all.find("the cell stops waiting for it"), std::string::npos) << notes.all;
}

TEST_F(HangingPlugin, WhoAsksForTheEndDuringTheStartHasIt) {
  Hanging::close(Hanging::configuring);
  cell::CellOptions options;
  options.start_given_up = [] { return Hanging::waiting > 0; };
  try {
    make(false, options);
    FAIL() << "it started";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().at(0).code, "given-up");
    EXPECT_NE(std::string(e.what()).find("is being configured and has not returned"), std::string::npos);
  }
  EXPECT_NE(notes.all.find("the cell stops waiting for it"), std::string::npos) << notes.all;
}

}  // namespace
}  // namespace polyarm
