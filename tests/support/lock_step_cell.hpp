#pragma once
/// A whole cell that tests step tick by tick, with mock hardware that can fail and block.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "drivers/mock/mock.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/inside/requests.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/open_cell.hpp"

namespace polyarm::test {

using Json = nlohmann::json;

/// A gate at which a callback waits until the test opens it.
class Gate {
 public:
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  void open() {
    const std::lock_guard lock(mutex_);
    closed_ = false;
    wake_.notify_all();
  }
  void pass() {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [this] { return !closed_; });
    ++passed_;
    wake_.notify_all();
  }
  int passed() {
    const std::lock_guard lock(mutex_);
    return passed_;
  }
  void wait_for(int passed) {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [&] { return passed_ >= passed; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  bool closed_ = false;
  int passed_ = 0;
};

/// The mock with faults: read() fails on request, and its life cycle callbacks wait at gates.
class FailingMock : public drivers::MockComponent {
 public:
  static inline std::atomic<bool> fails{false};
  static inline std::atomic<double> pushed{0};  ///< offset of the first joint's measured position, rad
  static inline Gate configuring, initialising, erring;
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override {
    initialising.pass();
    return drivers::MockComponent::on_init(context);
  }
  hardware::CallbackReturn on_configure() override {
    configuring.pass();
    return drivers::MockComponent::on_configure();
  }
  hardware::CallbackReturn on_error() override {
    erring.pass();
    return drivers::MockComponent::on_error();
  }
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override {
    const hardware::ReturnType out =
        fails ? hardware::ReturnType::error : drivers::MockComponent::read(cycle, states);
    if (!states.empty()) states[0] += pushed;
    return out;
  }
};

/// A six-axis arm with mock hardware, enough for most cells.
inline const std::string kSixAxes = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";

/// A cell in lock-step. By default the arm of examples/r6bot on the mock, with the given controllers.
class LockStepCell {
 public:
  /// `worked_from_outside`: as with the wall clock, where the cell waits for others and its worker is a
  /// thread.
  explicit LockStepCell(const std::string& controllers, bool worked_from_outside = false,
                        Nanoseconds patience = 60'000'000'000) {
    FailingMock::fails = false;
    FailingMock::pushed = 0;
    hardware::register_driver("failing",
                              [] { return std::unique_ptr<hardware::Component>(new FailingMock); });
    const std::filesystem::path urdf = kSixAxes;
    cell::Overrides overrides;
    overrides.hardware = "failing";
    cell::CellOptions options;
    options.lock_step = !worked_from_outside;
    options.hardware_timeout = patience;
    cell_ = std::make_unique<OpenCell>(
        cell::cell_from_description(urdf, {folder_.write("controllers.yaml", controllers)}, overrides),
        description::Catalogue({}), options, observer_);
    cell_->loop().begin();
  }
  /// Any description, with the hardware that it declares.
  LockStepCell(const std::filesystem::path& description, const std::string& controllers) {
    cell::CellOptions options;
    options.lock_step = true;
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    cell::CellFile file =
        cell::cell_from_description(description, {folder_.write("controllers.yaml", controllers)}, {});
    cell_ = std::make_unique<OpenCell>(file, description::Catalogue({}), options, observer_);
    cell_->loop().begin();
  }
  /// A cell file of the test. `robots`: folders of the catalogue.
  explicit LockStepCell(const cell::CellFile& file, const std::vector<std::filesystem::path>& robots = {}) {
    cell::CellOptions options;
    options.lock_step = true;
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    cell_ = std::make_unique<OpenCell>(file, description::Catalogue(robots), options, observer_);
    cell_->loop().begin();
  }
  /// The same with these options, in lock-step.
  LockStepCell(const cell::CellFile& file, cell::CellOptions options) {
    options.lock_step = true;
    cell_ = std::make_unique<OpenCell>(file, description::Catalogue({}), std::move(options), observer_);
    cell_->loop().begin();
  }
  ~LockStepCell() { end(); }
  /// Destroys the cell; its notes remain.
  void end() {
    if (cell_) cell_->loop().end();
    cell_.reset();
  }

  /// One tick of the cell, and the cycles up to the next tick.
  void tick() {
    const Nanoseconds until = cell_->loop().cycle().time + cell::Cell::kTick;
    cell_->tick(cell_->loop().cycle().time);
    while (cell_->loop().cycle().time < until) cell_->loop().step_next();
  }
  void run(double s) {
    for (Nanoseconds end = cell_->loop().cycle().time + nanoseconds(s); cell_->loop().cycle().time < end;)
      tick();
  }

  /// Sends a request. Its answers are appended to the returned list.
  std::shared_ptr<std::vector<Json>> give(const std::string& line, const void* from = nullptr) {
    auto answers = std::make_shared<std::vector<Json>>();
    cell_->requests().handle(
        line,
        [answers](const std::string& text) {
          answers->push_back(Json::parse(text));
          return true;
        },
        from);
    return answers;
  }
  std::shared_ptr<std::vector<Json>> give(const Json& request, const void* from = nullptr) {
    return give(request.dump(-1, ' ', false, Json::error_handler_t::replace), from);
  }
  /// Sends a request, steps until the last answer has arrived (at most 20 s of cell time), and returns that
  /// answer.
  Json ask(const Json& request) {
    const auto answers = give(request);
    for (int ticks = 0; ticks < 30'000 && (answers->empty() || answers->back().value("more", false));
         ++ticks) {
      if (ticks > 1'000) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // a worker may be
                                                                                     // reading files
      hardware::Hardware& hardware = cell_->loop().hardware();
      for (std::size_t i = 0; i < hardware.size(); ++i)  // callbacks may run on their own threads
        if (const hardware::Transition* pending = hardware.pending(i)) pending->wait(60'000'000'000);
      tick();
    }
    return answers->empty() ? Json() : answers->back();
  }
  /// The result of a request; for a refused request the whole answer, so that a failing test shows it.
  Json result(const Json& request) {
    const Json answer = ask(request);
    return answer.value("ok", false) ? answer["result"] : answer;
  }
  std::string state_of(const std::string& controller) {
    for (const Json& c : result({{"request", "control.list"}}))
      if (c["name"] == controller) return c["state"];
    return "gone";
  }
  double value_of(const std::string& kind, const std::string& interface) {
    const Json all = result({{"request", "interfaces"}});
    for (const Json& i : all[kind])
      if (i["name"] == interface) return i["value"].is_null() ? NAN : i["value"].get<double>();
    return NAN;
  }
  OpenCell& cell() { return *cell_; }
  /// The number of notes so far that contain this text.
  int told(const std::string& part) const {
    return static_cast<int>(
        std::count_if(observer_.notes.begin(), observer_.notes.end(),
                      [&](const std::string& note) { return note.find(part) != std::string::npos; }));
  }
  const Folder& folder() const { return folder_; }

 private:
  struct Notes : cell::Observer {
    std::vector<std::string> notes;
    void on_note(const std::string& text) override { notes.push_back(text); }
  };
  Folder folder_;
  Notes observer_;
  std::unique_ptr<OpenCell> cell_;
};

}  // namespace polyarm::test
