#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <semaphore>

#include "polyarm/control/control_loop.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::control {
namespace {

using controllers::CallbackReturn;
using controllers::Cycle;
using controllers::ReturnType;
using hardware::LifecycleState;

/// A component with one joint, `name/j`, that does what it is told to do wrong.
class Part : public hardware::Component {
 public:
  struct Script {
    CallbackReturn configure = CallbackReturn::success, activate = CallbackReturn::success,
                   deactivate = CallbackReturn::success, error = CallbackReturn::success;
    ReturnType read = ReturnType::ok, write = ReturnType::ok;
    std::string calls;
    std::vector<std::string> started, stopped;
    int reads = 0, writes = 0;
    Nanoseconds period = 0;
  };
  static std::map<std::string, Script>& scripts() {
    static std::map<std::string, Script> all;
    return all;
  }
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override {
    name_ = context.name;
    return CallbackReturn::success;
  }
  CallbackReturn on_configure() override { return s().calls += "configure ", s().configure; }
  CallbackReturn on_activate() override { return s().calls += "activate ", s().activate; }
  CallbackReturn on_deactivate() override { return s().calls += "deactivate ", s().deactivate; }
  CallbackReturn on_cleanup() override { return s().calls += "cleanup ", CallbackReturn::success; }
  CallbackReturn on_shutdown() override { return s().calls += "shutdown ", CallbackReturn::success; }
  CallbackReturn on_error() override { return s().calls += "error ", s().error; }
  std::vector<hardware::InterfaceDescription> state_interfaces() const override {
    return {{name_ + "/j/position", 0.5}};
  }
  std::vector<hardware::InterfaceDescription> command_interfaces() const override {
    return {{name_ + "/j/position"}, {name_ + "/j/velocity"}};
  }
  ReturnType perform_command_mode_switch(std::span<const std::string> start,
                                         std::span<const std::string> stop) noexcept override {
    s().started.assign(start.begin(), start.end());
    s().stopped.assign(stop.begin(), stop.end());
    return ReturnType::ok;
  }
  ReturnType read(const Cycle& cycle, std::span<double> states) noexcept override {
    ++s().reads;
    s().period = cycle.period;
    if (std::isfinite(last_)) states[0] = last_;
    return s().read;
  }
  ReturnType write(const Cycle&, std::span<const double> commands) noexcept override {
    ++s().writes;
    last_ = commands[0];
    return s().write;
  }

 private:
  Script& s() const { return scripts()[name_]; }
  std::string name_;
  double last_ = std::numeric_limits<double>::quiet_NaN();
};

/// Claims what it is given, adds one to its command each time, fails when told to.
class Counter : public controllers::Controller {
 public:
  std::string claim, reference, reads;
  CallbackReturn configure = CallbackReturn::success, activate = CallbackReturn::success,
                 error = CallbackReturn::success;
  ReturnType result = ReturnType::ok;
  int updates = 0, deactivations = 0;
  Nanoseconds period = 0;
  double seen = -1;
  std::binary_semaphore* gate = nullptr;

  CallbackReturn on_configure(controllers::ControllerContext&) override {
    if (!claim.empty()) claim_command(claim);
    if (!reference.empty()) export_reference(reference);
    if (!reads.empty()) claim_state(reads);
    return configure;
  }
  CallbackReturn on_error() override { return error; }
  CallbackReturn on_activate(const Cycle&) noexcept override {
    if (!reference.empty()) set_reference(0, 0);
    return activate;
  }
  void on_deactivate(const Cycle&) noexcept override { ++deactivations; }
  ReturnType update(const Cycle& cycle, const controllers::Verdict&) noexcept override {
    if (gate) gate->acquire();
    ++updates;
    period = cycle.period;
    if (!reference.empty()) seen = Controller::reference(0);
    if (!reads.empty()) seen = state(0);
    if (!claim.empty()) set_command(0, updates);
    return result;
  }
};

struct LifeCycleBench {
  ControlLoop loop{LoopOptions{}};
  /// `first_read`: the answer of each component's read until a test changes it.
  LifeCycleBench(std::vector<std::string> parts = {"arm"}, hardware::HostOptions options = {},
                 ReturnType first_read = ReturnType::ok) {
    Part::scripts().clear();
    for (const std::string& part : parts) Part::scripts()[part].read = first_read;
    loop.supervisor().watch_cell = false;
    for (const std::string& part : parts) {
      hardware::ComponentContext context;
      context.name = part;
      loop.hardware().add(std::make_unique<Part>(), context, options);
    }
    loop.start_hardware();
  }
  Counter& add(const std::string& name, const std::string& claim, const std::string& reference = "",
               LoadOptions options = {}) {
    auto made = std::make_unique<Counter>();
    Counter& out = *made;
    out.claim = claim;
    out.reference = reference;
    controllers::ControllerContext context;
    context.name = name;
    context.period = loop.options().period;
    loop.controllers().add(std::move(made), context, std::move(options));
    return out;
  }
  void go() { loop.prepare({}); }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) loop.step_next();
  }
  LifecycleState state(const std::string& name) {
    for (const ListedController& c : loop.controllers().list())
      if (c.name == name) return c.state;
    return LifecycleState::finalized;
  }
  Part::Script& part(const std::string& name = "arm") { return Part::scripts()[name]; }
};

std::string code_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    return e.problems().front().code;
  }
  return "none";
}

// --- components -------------------------------------------------------------------------------------------

TEST(ComponentLife, GoesThroughEveryState) {
  LifeCycleBench b;
  b.go();
  hardware::Hardware& h = b.loop.hardware();
  EXPECT_EQ(h.state_of(0), LifecycleState::active);
  h.begin_deactivate(0);
  h.run(0, hardware::Step::deactivate);
  EXPECT_EQ(h.state_of(0), LifecycleState::inactive);
  h.begin_cleanup(0);
  h.run(0, hardware::Step::cleanup);
  EXPECT_EQ(h.state_of(0), LifecycleState::unconfigured);
  h.run(0, hardware::Step::configure);
  h.run(0, hardware::Step::activate);
  EXPECT_EQ(h.state_of(0), LifecycleState::active);
  h.begin_cleanup(0);
  h.run(0, hardware::Step::shutdown);
  EXPECT_EQ(h.state_of(0), LifecycleState::finalized);
  EXPECT_EQ(b.part().calls, "configure activate deactivate cleanup configure activate deactivate shutdown ");
}

TEST(ComponentLife, IsReadWhenInactiveAndWrittenOnlyWhenActive) {
  LifeCycleBench b;
  b.go();
  b.loop.hardware().begin_deactivate(0);
  b.loop.hardware().run(0, hardware::Step::deactivate);
  const int reads = b.part().reads, writes = b.part().writes;
  b.run(10);
  EXPECT_EQ(b.part().reads, reads + 10);
  EXPECT_EQ(b.part().writes, writes);
  b.loop.hardware().begin_cleanup(0);
  b.loop.hardware().run(0, hardware::Step::cleanup);
  b.run(10);
  EXPECT_EQ(b.part().reads, reads + 10);
}

TEST(ComponentLife, TransitionsBeginWhereTheyBegin) {
  LifeCycleBench b;
  b.go();
  hardware::Hardware& h = b.loop.hardware();
  EXPECT_EQ(code_of([&] { h.run(0, hardware::Step::configure); }), "wrong-state");
  EXPECT_EQ(code_of([&] { h.run(0, hardware::Step::activate); }), "wrong-state");
  EXPECT_EQ(code_of([&] { h.run(0, hardware::Step::cleanup); }), "wrong-state");
}

TEST(ComponentLife, AFailureLeavesItWhereItWas) {
  LifeCycleBench b;
  b.go();
  hardware::Hardware& h = b.loop.hardware();
  h.begin_deactivate(0);
  h.run(0, hardware::Step::deactivate);
  b.part().activate = CallbackReturn::failure;
  EXPECT_EQ(code_of([&] { h.run(0, hardware::Step::activate); }), "component-failed");
  EXPECT_EQ(h.state_of(0), LifecycleState::inactive);
  b.part().activate = CallbackReturn::success;
  h.run(0, hardware::Step::activate);
  EXPECT_EQ(h.state_of(0), LifecycleState::active);
}

TEST(ComponentLife, AnErrorLetsOnErrorDecide) {
  for (const auto& [verdict, state] : {std::pair{CallbackReturn::success, LifecycleState::unconfigured},
                                       std::pair{CallbackReturn::failure, LifecycleState::finalized}}) {
    LifeCycleBench b;
    b.go();
    hardware::Hardware& h = b.loop.hardware();
    h.begin_deactivate(0);
    h.run(0, hardware::Step::deactivate);
    b.part().activate = CallbackReturn::error;
    b.part().error = verdict;
    EXPECT_EQ(code_of([&] { h.run(0, hardware::Step::activate); }), "component-failed");
    EXPECT_EQ(h.state_of(0), state);
  }
}

TEST(ComponentLife, AReadErrorStopsWhoWorksOnItAndNobodyElse) {
  LifeCycleBench b({"left", "right"});
  b.add("l", "left/j/position");
  b.add("r", "right/j/position");
  b.loop.controllers().switch_now({{"l", "r"}, {}});
  b.go();
  b.run(5);
  b.part("left").read = ReturnType::error;
  b.run(1);
  EXPECT_EQ(b.state("l"), LifecycleState::inactive);
  EXPECT_EQ(b.state("r"), LifecycleState::active);
  EXPECT_EQ(b.loop.supervisor().state(), RunState::fault);
  const auto events = b.loop.controllers().take_events();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].kind, LoopEvent::Kind::component_failed);
  EXPECT_EQ(events[1].kind, LoopEvent::Kind::controller_stopped);
  EXPECT_EQ(b.part("left").stopped, std::vector<std::string>{"left/j/position"});
  const int reads = b.part("left").reads;
  b.run(10);
  EXPECT_EQ(b.part("left").reads, reads) << "what has failed is not read again";
  b.part("left").read = ReturnType::ok;
  b.loop.hardware().run(0, hardware::Step::error);
  b.loop.hardware().run(0, hardware::Step::configure);
  b.loop.hardware().run(0, hardware::Step::activate);
  b.loop.controllers().switch_now({{"l"}, {}});
  b.run(5);
  EXPECT_EQ(b.state("l"), LifecycleState::active);
}

TEST(ComponentLife, OneThatAsksToBeDeactivatedIsStillRead) {
  LifeCycleBench b;
  b.add("c", "arm/j/position");
  b.loop.controllers().activate("c");
  b.go();
  b.part().read = ReturnType::deactivate;
  b.run(1);
  b.part().read = ReturnType::ok;
  EXPECT_EQ(b.state("c"), LifecycleState::inactive);
  EXPECT_EQ(b.loop.controllers().take_events()[0].kind, LoopEvent::Kind::component_deactivated);
  const int reads = b.part().reads, writes = b.part().writes;
  b.run(5);
  EXPECT_EQ(b.part().reads, reads + 5);
  EXPECT_EQ(b.part().writes, writes);
}

TEST(ComponentLife, AFailureInTheReadBeforeTheFirstCycleIsAFault) {
  LifeCycleBench b({"left", "right"}, {}, ReturnType::error);
  b.part("left").read = b.part("right").read = ReturnType::ok;  // it failed once
  b.go();
  b.run(1);
  EXPECT_EQ(b.loop.supervisor().state(), RunState::fault);
  EXPECT_EQ(b.loop.supervisor().cause(), StopCause::component);
  EXPECT_EQ(b.loop.supervisor().event().component, 0) << "of two faults the first is named";
  const int reads = b.part("right").reads;
  b.run(10);
  EXPECT_EQ(b.part("right").reads, reads) << "what has failed is not read again";
}

TEST(ComponentLife, AGroupFailsTogether) {
  hardware::HostOptions options;
  options.group = "base";
  LifeCycleBench b({"left", "right"}, options);
  b.add("r", "right/j/position");
  b.loop.controllers().activate("r");
  b.go();
  b.part("left").write = ReturnType::error;
  b.run(1);
  EXPECT_EQ(b.state("r"), LifecycleState::inactive);
}

void replace(hardware::Hardware& hardware, const hardware::ComponentContext& context) {
  const auto made = hardware.begin_replace(0, std::make_unique<Part>(), context);
  made->run();
  hardware.finish(*made);
}

TEST(ComponentLife, AReplacementMustOfferTheSame) {
  LifeCycleBench b;
  b.go();
  hardware::Hardware& h = b.loop.hardware();
  hardware::ComponentContext same, other;
  same.name = "arm";
  other.name = "leg";
  EXPECT_EQ(code_of([&] { replace(h, same); }), "wrong-state");
  h.begin_cleanup(0);
  h.run(0, hardware::Step::shutdown);
  EXPECT_EQ(code_of([&] { replace(h, other); }), "other-interfaces");
  replace(h, same);
  h.run(0, hardware::Step::configure);
  h.run(0, hardware::Step::activate);
  b.run(3);
  EXPECT_EQ(h.state_of(0), LifecycleState::active);
}

TEST(ComponentLife, AtItsOwnRateItGetsItsOwnPeriod) {
  hardware::HostOptions options;
  options.divisor = 5;
  LifeCycleBench b({"arm"}, options);
  b.go();
  const int reads = b.part().reads;
  b.run(100);
  EXPECT_EQ(b.part().reads, reads + 20);
  EXPECT_EQ(b.part().period, 5'000'000);
}

TEST(ComponentLife, AnAsyncOneInLockStepIsOnePeriodLate) {
  hardware::HostOptions options;
  options.async = options.lock_step = true;
  LifeCycleBench b({"arm"}, options);
  b.add("c", "arm/j/position");
  b.loop.controllers().activate("c");
  b.go();
  b.run(10);
  const double commanded = b.loop.table().commands()[0];
  EXPECT_EQ(b.loop.table().states()[0], commanded - 1);
  EXPECT_EQ(b.loop.hardware().diagnostics().info(0).missed, 0u);
}

TEST(ComponentLife, OnAClockOfItsOwnItCostsTheLoopNothingForbidden) {
  for (const bool lock_step : {false, true}) {
    hardware::HostOptions options;
    options.async = true;
    options.lock_step = lock_step;
    options.period = 700'000;
    LifeCycleBench b({"arm"}, options);
    b.add("c", "arm/j/position");
    b.loop.controllers().activate("c");
    b.go();
    b.run(10);
    const test::RealtimeGuard guard;
    b.run(100'000);
    EXPECT_TRUE(guard.violations().empty() || !test::RealtimeGuard::watches()) << guard.violations();
  }
}

TEST(ComponentLife, AFaultThatIsContainedStopsWhatWorksOnItAndNothingElse) {
  hardware::HostOptions options;
  options.contained = true;
  LifeCycleBench b({"arm", "base"}, options);
  Counter& arm = b.add("a", "arm/j/position");
  b.add("b", "base/j/position");
  b.loop.controllers().switch_now({{"a", "b"}, {}});
  b.go();
  b.run(10);
  for (const char* part : {"arm", "base"}) b.part(part).stopped.reserve(4);  // what the part notes itself
  {
    const test::RealtimeGuard guard;
    b.part("base").read = ReturnType::error;
    b.run(10);
    EXPECT_TRUE(guard.violations().empty() || !test::RealtimeGuard::watches()) << guard.violations();
  }
  EXPECT_EQ(b.loop.supervisor().state(), RunState::running);
  EXPECT_EQ(b.state("b"), LifecycleState::inactive);
  EXPECT_EQ(b.state("a"), LifecycleState::active);
  EXPECT_EQ(arm.updates, 20);
  b.loop.outbox().fetch();
  EXPECT_EQ(b.loop.outbox().value().fallen, (std::vector<StopCause>{StopCause::none, StopCause::component}));
}

TEST(ComponentLife, AContainedFaultUnderAControllerThatCommandsAnotherIsAFaultOfAll) {
  hardware::HostOptions options;
  options.contained = true;
  LifeCycleBench b({"arm", "base"}, options);
  b.add("a", "arm/j/position").reads = "base/j/position";
  b.loop.controllers().cleanup("a");
  b.loop.controllers().configure("a");
  b.loop.controllers().activate("a");
  b.go();
  b.part("base").write = ReturnType::error;
  b.run(2);
  EXPECT_EQ(b.loop.supervisor().state(), RunState::fault);
  EXPECT_EQ(b.state("a"), LifecycleState::inactive);
}

// --- controllers ------------------------------------------------------------------------------------------

TEST(ControllerLife, GoesThroughEveryState) {
  LifeCycleBench b;
  b.add("c", "arm/j/position");
  ControllerManager& m = b.loop.controllers();
  EXPECT_EQ(b.state("c"), LifecycleState::inactive);
  m.activate("c");
  EXPECT_EQ(m.holder_of("arm/j/position"), "c");
  EXPECT_EQ(code_of([&] { m.unload("c"); }), "wrong-state");
  EXPECT_EQ(code_of([&] { m.cleanup("c"); }), "wrong-state");
  m.deactivate("c");
  EXPECT_EQ(m.holder_of("arm/j/position"), "");
  m.cleanup("c");
  EXPECT_EQ(b.state("c"), LifecycleState::unconfigured);
  EXPECT_EQ(code_of([&] { m.activate("c"); }), "not-configured");
  m.configure("c");
  m.unload("c");
  EXPECT_TRUE(m.list().empty());
}

TEST(ControllerLife, CallbackResultsDecide) {
  LifeCycleBench b;
  const auto add = [&](const std::string& name, CallbackReturn configure, CallbackReturn error) {
    auto made = std::make_unique<Counter>();
    made->configure = configure;
    made->error = error;
    controllers::ControllerContext context;
    context.name = name;
    return code_of([&] { b.loop.controllers().add(std::move(made), context); });
  };
  EXPECT_EQ(add("failure", CallbackReturn::failure, CallbackReturn::success), "controller-failed");
  EXPECT_EQ(b.state("failure"), LifecycleState::unconfigured);
  EXPECT_EQ(add("error", CallbackReturn::error, CallbackReturn::success), "controller-failed");
  EXPECT_EQ(b.state("error"), LifecycleState::unconfigured);
  EXPECT_EQ(add("fatal", CallbackReturn::error, CallbackReturn::failure), "controller-failed");
  EXPECT_EQ(b.state("fatal"), LifecycleState::finalized);
}

TEST(ControllerLife, OneThatCannotBeActivatedStaysInactive) {
  LifeCycleBench b;
  Counter& c = b.add("c", "arm/j/position");
  c.activate = CallbackReturn::failure;
  EXPECT_EQ(code_of([&] { b.loop.controllers().activate("c"); }), "controller-failed");
  EXPECT_EQ(b.state("c"), LifecycleState::inactive);
  EXPECT_EQ(b.loop.controllers().holder_of("arm/j/position"), "");
}

TEST(ControllerLife, AnErrorStopsItsChainAndStartsItsFallback) {
  LifeCycleBench b;
  LoadOptions with_fallback;
  with_fallback.fallback = {"rescue"};
  Counter& bottom = b.add("bottom", "arm/j/position", "bottom/r", with_fallback);
  b.add("top", "bottom/r");
  b.add("rescue", "arm/j/position");
  b.loop.controllers().switch_now({{"bottom", "top"}, {}});
  b.go();
  b.run(5);
  bottom.result = ReturnType::error;
  b.run(1);
  EXPECT_EQ(b.state("bottom"), LifecycleState::inactive);
  EXPECT_EQ(b.state("top"), LifecycleState::inactive);
  EXPECT_EQ(b.state("rescue"), LifecycleState::active);
  EXPECT_EQ(b.loop.supervisor().state(), RunState::running) << "somebody has taken over";
  EXPECT_EQ(bottom.deactivations, 1);
  const auto events = b.loop.controllers().take_events();
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0].kind, LoopEvent::Kind::controller_failed);
  EXPECT_EQ(events[1].kind, LoopEvent::Kind::controller_stopped);
  EXPECT_EQ(events[2].kind, LoopEvent::Kind::fallback_started);
}

TEST(ControllerLife, WithoutAFallbackAnErrorIsAFault) {
  LifeCycleBench b;
  Counter& c = b.add("c", "arm/j/position");
  b.loop.controllers().activate("c");
  b.go();
  c.result = ReturnType::error;
  b.run(1);
  EXPECT_EQ(b.loop.supervisor().state(), RunState::fault);
  EXPECT_EQ(b.loop.supervisor().cause(), StopCause::controller);
}

TEST(ControllerLife, AChainPassesItsReferencesInTheSameCycle) {
  LifeCycleBench b;
  Counter& bottom = b.add("bottom", "arm/j/position", "bottom/r");
  b.add("top", "bottom/r");
  b.loop.controllers().switch_now({{"bottom", "top"}, {}});
  b.go();
  b.run(7);
  EXPECT_EQ(bottom.seen, 7);
  EXPECT_TRUE(b.loop.controllers().list()[0].chained);
}

TEST(ControllerLife, AtItsOwnRateItGetsItsOwnPeriod) {
  LifeCycleBench b;
  LoadOptions slow;
  slow.divisor = 4;
  Counter& c = b.add("c", "arm/j/position", "", slow);
  b.loop.controllers().activate("c");
  b.go();
  b.run(100);
  EXPECT_EQ(c.updates, 25);
  EXPECT_EQ(c.period, 4'000'000);
}

TEST(ControllerLife, AnAsyncOneIsNeverWaitedForAndItsMissedTriggersAreCounted) {
  LifeCycleBench b;
  LoadOptions async;
  async.async = true;
  Counter& c = b.add("c", "arm/j/position", "", async);
  std::binary_semaphore gate{0};
  c.gate = &gate;
  b.loop.controllers().activate("c");
  b.go();
  b.run(10);  // it has been triggered once and waits at the gate
  EXPECT_EQ(b.loop.controllers().list()[0].missed, 9u);
  gate.release();
  for (int k = 0; k < 2'000'000 && b.loop.table().commands()[0] != 1; ++k) {
    b.run(1);
    gate.try_acquire();
    gate.release();
  }
  EXPECT_GE(b.loop.table().commands()[0], 1);
  for (int k = 0; k < 100; ++k) gate.try_acquire(), gate.release();
  b.loop.controllers().deactivate("c");
  for (int k = 0; k < 2'000'000 && c.deactivations == 0; ++k) {
    b.run(1);
    gate.try_acquire();
    gate.release();
  }
  EXPECT_EQ(c.deactivations, 1);
  gate.try_acquire();
  gate.release();
}

TEST(ControllerLife, InLockStepAnAsyncOneIsOnePeriodLateAndRepeats) {
  LifeCycleBench b;
  LoadOptions async;
  async.async = async.lock_step = true;
  Counter& c = b.add("c", "arm/j/position", "", async);
  b.loop.controllers().activate("c");
  b.go();
  b.run(10);
  EXPECT_EQ(c.updates, 10);
  EXPECT_EQ(b.loop.table().commands()[0], 9);
}

TEST(ControllerLife, ASwitchReachesARunningLoopBetweenTwoCycles) {
  LifeCycleBench b;
  Counter& c = b.add("c", "arm/j/position");
  b.go();
  b.loop.begin();
  const auto job = b.loop.controllers().begin_switch({{"c"}, {}});
  EXPECT_FALSE(job->done());
  EXPECT_EQ(c.updates, 0);
  b.run(1);
  ASSERT_TRUE(job->done());
  EXPECT_TRUE(b.loop.controllers().finish(*job));
  EXPECT_EQ(c.updates, 1) << "it is updated in the cycle of the switch";
  EXPECT_EQ(b.part().started, std::vector<std::string>{"arm/j/position"});
  b.loop.end();
}

TEST(ControllerLife, ASwitchThatWasPlannedBeforeAFailureIsPlannedAgain) {
  LifeCycleBench b;
  Counter& c = b.add("c", "arm/j/position");
  b.add("d", "arm/j/velocity");
  b.loop.controllers().activate("c");
  b.go();
  b.loop.begin();
  b.run(1);
  c.result = ReturnType::error;
  b.run(1);  // the cell thread has not heard of it yet
  const auto job = b.loop.controllers().begin_switch({{"d"}, {}});
  b.run(1);
  ASSERT_TRUE(job->done());
  EXPECT_FALSE(b.loop.controllers().finish(*job));
  b.loop.controllers().take_events();
  const auto again = b.loop.controllers().begin_switch({{"d"}, {}});
  b.run(2);
  EXPECT_TRUE(b.loop.controllers().finish(*again));
  EXPECT_EQ(b.state("d"), LifecycleState::active);
  b.loop.end();
}

TEST(ControllerLife, LoadedIntoARunningCellItGetsItsOwnReferences) {
  LifeCycleBench b;
  b.go();
  b.loop.begin();
  Counter& bottom = b.add("bottom", "arm/j/position", "bottom/r");
  b.add("top", "bottom/r");
  const auto job = b.loop.controllers().begin_switch({{"bottom", "top"}, {}});
  b.run(5);
  ASSERT_TRUE(job->done());
  EXPECT_GT(bottom.seen, 0);
  EXPECT_EQ(code_of([&] {
              b.add("thief", "arm/j/position"), b.loop.controllers().begin_switch({{"thief"}, {}});
            }),
            "claimed");
  const auto down = b.loop.controllers().begin_switch({{}, {"top", "bottom"}});
  b.run(2);
  b.loop.controllers().unload("top");
  b.loop.controllers().unload("bottom");
  b.run(2);
  EXPECT_FALSE(b.loop.table().find_command("bottom/r"));
  b.loop.end();
}

}  // namespace
}  // namespace polyarm::control
