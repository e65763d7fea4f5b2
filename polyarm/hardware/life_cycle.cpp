/// The life cycle of components: order of the callbacks, and when the loop starts and stops calling a
/// component.
#include "polyarm/hardware/life_cycle.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/hardware/hardware.hpp"
#include "polyarm/hardware/hosted.hpp"

namespace polyarm::hardware {

/// Makes the loop start or stop reading and writing a component, between two cycles.
class Hardware::Letting : public realtime::Job {
 public:
  Letting(Hosting& hosting, std::size_t i, bool reading, bool writing)
      : hosting_(hosting), i_(i), hosted_component_(*hosting.all[i]), reading_(reading), writing_(writing) {}
  void run() noexcept override {
    if (reading_ && !hosted_component_.reading) begin_restart();
    if (!reading_ && hosted_component_.own_clock) hosted_component_.own_clock->close();
    if (writing_ && !hosted_component_.writing)
      for (Following& following : hosted_component_.following) following.behind = 0;
    if (writing_) hosted_component_.fallen = StopCause::none;
    hosted_component_.reading = reading_;
    hosted_component_.writing = writing_;
  }

 private:
  /// The joints may be anywhere now, and earlier commands are void.
  void begin_restart() noexcept {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    hosted_component_.ran.store(false, std::memory_order_relaxed);
    hosted_component_.watched.forget();
    const auto commands = hosting_.table.commands().subspan(hosted_component_.first_command, hosted_component_.commands);
    std::fill(commands.begin(), commands.end(), kNone);
    if (hosting_.restarted.size() < hosting_.restarted.capacity()) hosting_.restarted.push_back(i_);
    hosted_component_.late_reported = false;
    hosted_component_.part->pause();
    hosted_component_.missed_in_a_row = 0;
    if (hosted_component_.runner) hosted_component_.runner->forgive();
    if (hosted_component_.own_clock) hosted_component_.own_clock->open();
  }

  Hosting& hosting_;
  std::size_t i_;
  HostedComponent& hosted_component_;
  bool reading_, writing_;
};

std::string reason_of(const Component& component) {
  try {
    return component.reason();
  } catch (...) {
    return "its reason function threw: " + what_was_thrown();
  }
}

std::string because(const Component& component) {
  const std::string reason = reason_of(component);
  return reason.empty() ? reason : ": " + reason;
}

void initialise(Component& component, const ComponentContext& context, const char* which) {
  CallbackReturn result;
  try {
    result = component.on_init(context);
  } catch (...) {
    rethrow_as_error("component-failed", "the hardware component '" + context.name + "', on_init,",
                     "its plugin has an error; report it to its author");
  }
  if (result != CallbackReturn::success)
    throw Error("component-failed",
                std::string(which) + " '" + context.name + "' could not be initialised" + because(component),
                "check its parameters");
}

// --- a callback -------------------------------------------------------------------------------------------

const char* done_word(Step step) {
  constexpr const char* kWords[] = {"initialised", "configured", "activated",           "deactivated",
                                    "cleaned up",  "shut down",  "freed from its error"};
  return kWords[static_cast<std::size_t>(step)];
}

CallbackReturn Transition::call() {
  switch (step_) {
    case Step::init:
      initialise(*component_, *context_, "the old one stays: the new");
      return CallbackReturn::success;
    case Step::configure:
      return component_->on_configure();
    case Step::activate:
      return component_->on_activate();
    case Step::deactivate:
      return component_->on_deactivate();
    case Step::cleanup:
      return component_->on_cleanup();
    case Step::shutdown:
      return component_->on_shutdown();
    case Step::error:
      return component_->on_error();
  }
  return CallbackReturn::error;
}

void Transition::run() noexcept {
  // Its thread may still be in a read that began before the thread was told to leave the component.
  if (exchanging_) exchanging_->wait(true);
  if (step_ == Step::shutdown && was_active_) try {
      component_->on_deactivate();
    } catch (...) {  // shut it down in any case
    }
  try {
    result_ = call();
  } catch (...) {
    thrown_ = std::current_exception();
    result_ = CallbackReturn::error;
  }
  const std::lock_guard lock(mutex_);
  done_.store(true, std::memory_order_release);
  wake_.notify_all();
}

bool Transition::wait(Nanoseconds timeout) const {
  std::unique_lock lock(mutex_);
  return wake_.wait_for(lock, std::chrono::nanoseconds(timeout), [this] { return done(); });
}

namespace {
/// ": it threw: …", or empty.
std::string told(const std::exception_ptr& thrown) {
  if (!thrown) return {};
  try {
    std::rethrow_exception(thrown);
  } catch (...) {
    return ": it threw: " + what_was_thrown();
  }
}

/// Runs transitions on the calling thread.
class Here : public Caller {
 public:
  void start(std::shared_ptr<Transition> transition) override { transition->run(); }
  bool await(const Transition& transition) override { return transition.done(); }
};
Here here;
}  // namespace

// --- transitions ------------------------------------------------------------------------------------------

namespace {
void require(const HostedComponent& hosted, LifecycleState state, const char* what) {
  const LifecycleState now = hosted.state.load(std::memory_order_acquire);
  if (now == state) return;
  throw Error("wrong-state",
              "the hardware component '" + hosted.name + "' is " + name(now) + ", it cannot be " + what,
              std::string("that begins at ") + name(state));
}

[[noreturn]] void fail(const HostedComponent& hosted, Step step, const std::string& why) {
  throw Error("component-failed",
              "the hardware component '" + hosted.name + "' could not be " + done_word(step) + " and is " +
                  name(hosted.state.load()) + (why.empty() ? because(*hosted.component) : why),
              "check that it is connected and that its parameters are right");
}
}  // namespace

std::shared_ptr<realtime::Job> Hardware::let(std::size_t i, bool reading, bool writing) {
  auto job = std::make_shared<Letting>(*hosting_, i, reading, writing);
  if (!hosting_->jobs.post(job)) throw Error("busy", "the control loop has not taken the last requests yet");
  return job;
}

void Hardware::note_world() {
  for (const auto& hosted : hosting_->all)
    if (!hosting_->world.load() && hosted->component->world()) {
      hosting_->world = hosted->component->world();
      hosting_->world_names = hosted->component->world_names();
    }
}

void require_idle(const HostedComponent& hosted) {
  if (!hosted.pending) return;
  throw Error("busy",
              "the hardware component '" + hosted.name + "' is being " + done_word(hosted.pending->step()) +
                  " and has not returned from it",
              "wait until it has; polyarm hardware list shows it");
}

void Hardware::require_idle(std::size_t i) const {
  hardware::require_idle(*hosting_->all[i]);
}

const Transition* Hardware::pending(std::size_t i) const noexcept {
  return hosting_->all[i]->pending.get();
}

std::shared_ptr<Transition> Hardware::begin(std::size_t i, Step step) {
  HostedComponent& hosted = *hosting_->all[i];
  hardware::require_idle(hosted);
  if (step == Step::configure) {
    require(hosted, LifecycleState::unconfigured, "configured");
    hosted.failed_at.store(-1, std::memory_order_relaxed);
    hosted.failed_by.store(StopCause::none, std::memory_order_relaxed);
  }
  if (step == Step::activate) require(hosted, LifecycleState::inactive, "activated");
  if (step == Step::cleanup) require(hosted, LifecycleState::inactive, "cleaned up");
  if (step == Step::error) let(i, false, false);
  return pend(i, step);
}

std::shared_ptr<Transition> Hardware::pend(std::size_t i, Step step) {
  HostedComponent& hosted = *hosting_->all[i];
  auto out = std::make_shared<Transition>();
  out->step_ = step;
  out->index_ = i;
  out->name_ = hosted.name;
  out->component_ = hosted.component.get();
  out->was_active_ = hosted.state.load() == LifecycleState::active;
  if (step != Step::activate && step != Step::deactivate) {
    if (hosted.own_clock) out->exchanging_ = hosted.own_clock->exchanging();
    if (hosted.runner) out->exchanging_ = hosted.runner->busy();
  }
  hosted.reason_before = reason_of(*hosted.component);
  hosted.busy.store(true, std::memory_order_release);
  hosted.pending = out;
  return out;
}

std::shared_ptr<Transition> Hardware::begin_replace(std::size_t i, std::unique_ptr<Component> component,
                                                    const ComponentContext& context) {
  HostedComponent& hosted = *hosting_->all[i];
  hardware::require_idle(hosted);
  const LifecycleState now = hosted.state.load();
  if (now != LifecycleState::unconfigured && now != LifecycleState::finalized)
    require(hosted, LifecycleState::unconfigured, "reloaded");
  const auto out = pend(i, Step::init);
  out->made_ = std::move(component);
  out->component_ = out->made_.get();
  out->context_ = std::make_unique<ComponentContext>(context);
  return out;
}

std::shared_ptr<Transition> Hardware::finish(Transition& done) {
  HostedComponent& hosted = *hosting_->all[done.index_];
  hosted.pending.reset();
  hosted.busy.store(false, std::memory_order_release);
  if (done.step_ == Step::init) {
    take_new(hosted, done);
    return nullptr;
  }
  if (done.step_ == Step::error) {
    settle_error(hosted, done);
    return nullptr;
  }
  if (done.step_ == Step::shutdown || done.result_ == CallbackReturn::success) {
    succeed(done.index_, done.step_);
    return nullptr;
  }
  if (done.result_ == CallbackReturn::error) {  // on_error decides its next state
    let(done.index_, false, false);
    const auto next = pend(done.index_, Step::error);
    next->failed_ = done.step_;
    next->thrown_before_ = told(done.thrown_);
    return next;
  }
  fail(hosted, done.step_, {});
}

void Hardware::succeed(std::size_t i, Step step) {
  HostedComponent& hosted = *hosting_->all[i];
  constexpr LifecycleState kThen[] = {LifecycleState::unconfigured, LifecycleState::inactive,
                                      LifecycleState::active,       LifecycleState::inactive,
                                      LifecycleState::unconfigured, LifecycleState::finalized};
  hosted.state.store(kThen[static_cast<std::size_t>(step)], std::memory_order_release);
  if (step == Step::configure) note_world();
  if (step == Step::configure || step == Step::activate) let(i, true, step == Step::activate);
}

void Hardware::settle_error(HostedComponent& hosted, const Transition& done) {
  const bool usable = done.result_ == CallbackReturn::success;
  hosted.state.store(usable ? LifecycleState::unconfigured : LifecycleState::finalized,
                     std::memory_order_release);
  if (!done.failed_) return;
  std::string why = done.thrown_before_;  // not what on_error says, which came later
  if (why.empty() && !hosted.reason_before.empty()) why = ": " + hosted.reason_before;
  fail(hosted, *done.failed_, why);
}

void Hardware::go(std::shared_ptr<Transition> next, Caller& caller) {
  while (next) {
    caller.start(next);
    if (!caller.await(*next))
      throw Error("given-up",
                  "the hardware component '" + next->component() + "' is being " + done_word(next->step()) +
                      " and has not returned from it",
                  "check its device; polyarm drivers test opens one alone");
    next = finish(*next);
  }
}

void Hardware::run(std::size_t i, Step step) {
  go(begin(i, step), here);
}

std::shared_ptr<realtime::Job> Hardware::begin_deactivate(std::size_t i) {
  require_idle(i);
  require(*hosting_->all[i], LifecycleState::active, "deactivated");
  return let(i, true, false);
}
std::shared_ptr<realtime::Job> Hardware::begin_cleanup(std::size_t i) {
  require_idle(i);
  return let(i, false, false);
}

namespace {
template <typename Names>
void expect_same(const std::vector<InterfaceDescription>& offered, const Names& names, std::size_t first,
                 std::size_t count, const std::string& component) {
  for (std::size_t k = 0; k < std::max(count, offered.size()); ++k) {
    const std::string had = k < count ? names[first + k] : "";
    const std::string has = k < offered.size() ? offered[k].name : "";
    if (had != has)
      throw Error("other-interfaces",
                  "the new '" + component + "' offers '" + (has.empty() ? "nothing" : has) +
                      "' where it had '" + (had.empty() ? "nothing" : had) + "'",
                  "a component is reloaded with the interfaces that it had; start the cell again for others");
  }
}
}  // namespace

void Hardware::take_new(HostedComponent& hosted, Transition& done) {
  if (done.thrown_) std::rethrow_exception(done.thrown_);
  Component& made = *done.made_;
  expect_same(offered(hosted.name, [&] { return made.state_interfaces(); }), hosting_->table.state_names(),
              hosted.first_state, hosted.states, hosted.name);
  expect_same(offered(hosted.name, [&] { return made.command_interfaces(); }),
              hosting_->table.command_names(), hosted.first_command, hosted.commands, hosted.name);
  if (hosted.component->world() && hosted.component->world() == hosting_->world) hosting_->world = nullptr;
  retired_.push_back(std::exchange(hosted.component, std::move(done.made_)));
  hosted.state.store(LifecycleState::unconfigured, std::memory_order_release);
}

// --- all components ---------------------------------------------------------------------------------------

void Hardware::configure_and_activate() {
  configure_and_activate(here);
}

void Hardware::configure_and_activate(Caller& caller) {
  // Those without commands first: an actuator may look for its sensor.
  std::vector<std::size_t> order(hosting_->all.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_partition(order.begin(), order.end(),
                        [&](std::size_t i) { return hosting_->all[i]->commands == 0; });
  for (const std::size_t i : order)
    if (hosting_->all[i]->options.initial != LifecycleState::unconfigured)
      go(begin(i, Step::configure), caller);
  for (const std::size_t i : order)
    if (hosting_->all[i]->options.initial == LifecycleState::active) go(begin(i, Step::activate), caller);
  // A component that waits for a device measures before controllers start; its thread does not run yet.
  for (const auto& hosted : hosting_->all)
    if (hosted->own_clock && hosted->component->blocks() &&
        hosted->state.load() != LifecycleState::unconfigured) {
      hosted->own_clock->measure();
    } else if (hosted->runner && hosted->component->blocks() &&
               hosted->state.load() != LifecycleState::unconfigured) {
      hosted->own_result.store(hosted->component->read(hosted->own_cycle, hosted->own_states));
      hosted->ran.store(true);
    }
  note_world();
}

/// Keeps a component that is still in a call until the process ends, because nothing of it may be freed.
void Hardware::leave_behind(std::unique_ptr<HostedComponent> hosted) {
  static auto* left = new std::vector<std::unique_ptr<HostedComponent>>;
  left->push_back(std::move(hosted));
}

bool Hardware::shut_down() noexcept {
  return shut_down(here);
}

bool Hardware::shut_down(Caller& caller) noexcept {
  auto& all = hosting_->all;
  bool ended = true;
  for (auto each = all.rbegin(); each != all.rend(); ++each) {
    HostedComponent& hosted = **each;
    if (hosted.own_clock) hosted.own_clock->close();
    if (hosted.pending && caller.await(*hosted.pending)) hosted.pending.reset();
    const auto place = static_cast<std::size_t>(all.rend() - each) - 1;
    if (!hosted.pending && hosted.state.load() != LifecycleState::finalized) {
      const auto last = pend(place, Step::shutdown);  // waits for a running exchange
      caller.start(last);
      if (caller.await(*last)) hosted.pending.reset();
    }
    hosted.state = LifecycleState::finalized;
    if (!hosted.pending) continue;
    leave_behind(std::move(*each));
    ended = false;
  }
  std::erase(all, nullptr);
  for (const auto& hosted : hosting_->all) {
    hosted->runner.reset();
    hosted->own_clock.reset();
  }
  return ended;
}

}  // namespace polyarm::hardware
