#include "polyarm/control/controller_manager.hpp"

#include <algorithm>
#include <limits>

#include "polyarm/base/text.hpp"
#include "polyarm/control/schedule.hpp"

namespace polyarm::control {

using controllers::CallbackReturn;
using hardware::LifecycleState;

namespace {

/// Runs a callback of a controller outside the loop. An Error passes through; any other exception becomes an
/// Error with the controller's name and the step.
template <typename Step>
auto guarded(const std::string& controller, const char* step, Step call) {
  try {
    return call();
  } catch (...) {
    rethrow_as_error("controller-failed", "the controller '" + controller + "', " + step + ",",
                     "its plugin has an error; report it to its author");
  }
}

/// on_error decides whether the controller can be used again; if it throws, the controller cannot.
bool usable_after_error(controllers::Controller& controller) noexcept {
  try {
    return controller.on_error() == CallbackReturn::success;
  } catch (...) {
    return false;
  }
}

Error not_offered(const std::string& name, const std::vector<std::string>& known, const char* kind,
                  const std::string& controller) {
  const std::string owner = name.substr(0, name.rfind('/') + 1);
  const bool owner_known = std::any_of(known.begin(), known.end(),
                                       [&](const std::string& other) { return other.starts_with(owner); });
  return Error(owner_known ? "interface-not-offered" : "unknown-interface",
               "the controller '" + controller + "' needs the " + kind + " interface '" + name +
                   "', which no hardware offers" + did_you_mean(name, known),
               "check the joint names and the interfaces of the hardware");
}

std::vector<std::size_t> resolve(const std::vector<std::string>& names, const std::vector<std::string>& known,
                                 const char* kind, const std::string& controller, auto find) {
  std::vector<std::size_t> out;
  for (const std::string& name : names) {
    const auto index = find(name);
    if (!index) throw not_offered(name, known, kind, controller);
    out.push_back(*index);
  }
  return out;
}

}  // namespace

/// Replaces the loop's schedule; the old one is freed with the job, on the thread that posted it.
class ControllerManager::NewSchedule : public realtime::Job {
 public:
  NewSchedule(ControllerManager& manager, std::unique_ptr<Schedule> schedule)
      : manager_(manager), schedule_(std::move(schedule)) {}
  void run() noexcept override { std::swap(manager_.schedule_, schedule_); }

 private:
  ControllerManager& manager_;
  std::unique_ptr<Schedule> schedule_;
};

ControllerManager::ControllerManager(hardware::InterfaceTable& table, hardware::Components& hardware,
                                     realtime::Jobs& jobs)
    : table_(table), hardware_(hardware), jobs_(jobs), schedule_(std::make_unique<Schedule>()) {}

ControllerManager::~ControllerManager() = default;

ControllerManager::Slot& ControllerManager::slot(const std::string& name) const {
  for (const auto& slot : slots_)
    if (slot->name == name) return *slot;
  throw Error("unknown-controller", "there is no controller '" + name + "'" + did_you_mean(name, names()),
              {});
}

std::vector<std::string> ControllerManager::names() const {
  std::vector<std::string> out;
  for (const auto& slot : slots_) out.push_back(slot->name);
  return out;
}

void ControllerManager::load(std::unique_ptr<controllers::Controller> controller,
                             controllers::ControllerContext context, LoadOptions options) {
  for (const auto& other : slots_)
    if (other->name == context.name)
      throw Error("duplicate-controller", "two controllers are called '" + context.name + "'",
                  "rename one of them");
  auto slot = std::make_unique<Slot>();
  slot->id = next_id_++;
  slot->name = context.name;
  slot->controller = std::move(controller);
  slot->options = std::move(options);
  slot->budget = slot->options.budget;
  slot->options.divisor = std::max(1u, slot->options.divisor);
  context.loop_period = context.period;
  if (slot->options.period <= context.period) slot->options.period = 0;
  context.period = slot->options.period > 0 ? slot->options.period : context.period * slot->options.divisor;
  slot->context = std::move(context);
  slots_.push_back(std::move(slot));
}

namespace {
std::vector<std::string> named(const std::vector<std::string>& names) {
  std::vector<std::string> out;
  for (const std::string& name : names)
    if (!name.empty()) out.push_back(name);
  return out;
}
}  // namespace

/// Contexts share the list of names while the table's names do not change.
void ControllerManager::name_interfaces(controllers::ControllerContext& context) {
  if (named_at_ != table_.changes()) {
    state_names_ = named(table_.state_names());
    command_names_ = named(table_.command_names());
    named_at_ = table_.changes();
  }
  context.state_names = state_names_;
  context.command_names = command_names_;
}

void ControllerManager::configure(const std::string& name) {
  configure_only(name);
  try {
    refresh();
  } catch (...) {
    Slot& s = slot(name);
    s.state = LifecycleState::unconfigured;
    withdraw(s);
    throw;
  }
}

void ControllerManager::refresh() {
  if (!table_.sealed()) bind_all();
  post_schedule();
}

void ControllerManager::configure_only(const std::string& name) {
  Slot& s = slot(name);
  if (s.state.load() != LifecycleState::unconfigured)
    throw Error(
        "wrong-state",
        "the controller '" + name + "' is " + hardware::name(s.state.load()) + ", it cannot be configured",
        "configuring begins at unconfigured");
  controllers::Controller& c = *s.controller;
  c.forget_interfaces();
  s.context.parameters.begin();
  name_interfaces(s.context);
  try {
    const CallbackReturn result = guarded(name, "on_configure", [&] { return c.on_configure(s.context); });
    s.context.parameters.finish(name);
    s.context.parameters.problems().throw_if_errors();
    if (result != CallbackReturn::success) {
      if (result == CallbackReturn::error && !usable_after_error(c)) s.state = LifecycleState::finalized;
      throw Error("controller-failed", "the controller '" + name + "' could not be configured",
                  "check that its parameters name joints or interfaces");
    }
    for (const std::string& reference : c.reference_interfaces()) table_.add_command(reference);
    for (const std::string& state : c.exported_states())
      table_.add_state(state, std::numeric_limits<double>::quiet_NaN());
    bind(s);
  } catch (...) {
    withdraw(s);
    throw;
  }
  if (s.options.async) make_runner(s);
  s.state = LifecycleState::inactive;
}

void ControllerManager::withdraw(Slot& s) {
  for (const std::string& reference : s.controller->reference_interfaces()) table_.remove_command(reference);
  for (const std::string& state : s.controller->exported_states()) table_.remove_state(state);
}

namespace {
/// True if the command keeps moving its joint until it is withdrawn: velocity, acceleration or effort.
bool pushes(const std::string& command, const controllers::ControllerContext& context) {
  const auto slash = command.rfind('/');
  if (slash == std::string::npos || !context.find_joint(std::string_view(command).substr(0, slash)))
    return false;
  const std::string_view kind = std::string_view(command).substr(slash + 1);
  return kind == "velocity" || kind == "acceleration" || kind == "effort" || kind == "force" ||
         kind == "torque";
}
}  // namespace

void ControllerManager::bind(Slot& s) {
  controllers::Controller& c = *s.controller;
  const auto commands = [&](const std::vector<std::string>& names) {
    return resolve(names, table_.command_names(), "command", s.name,
                   [&](const std::string& name) { return table_.find_command(name); });
  };
  const auto states = [&](const std::vector<std::string>& names) {
    return resolve(names, table_.state_names(), "state", s.name,
                   [&](const std::string& name) { return table_.find_state(name); });
  };
  controllers::Bindings bindings{table_.states(),
                                 table_.commands(),
                                 states(c.state_interfaces()),
                                 commands(c.command_interfaces()),
                                 commands(c.reference_interfaces()),
                                 table_.states(),
                                 states(c.exported_states())};
  s.commands = bindings.command;
  s.exported = bindings.exported;
  s.references = bindings.reference;
  s.pushes.clear();
  for (std::size_t k = 0; k < s.commands.size(); ++k)
    if (pushes(c.command_interfaces()[k], s.context)) s.pushes.push_back(s.commands[k]);
  if (s.options.async) {  // it works on copies
    s.own_states.assign(table_.states().begin(), table_.states().end());
    s.own_commands.assign(table_.commands().begin(), table_.commands().end());
    bindings.states = bindings.own_states = s.own_states;
    bindings.commands = s.own_commands;
  }
  c.bind(std::move(bindings));
}

void ControllerManager::bind_all() {
  for (const auto& s : slots_)
    if (s->state.load() == LifecycleState::inactive || s->state.load() == LifecycleState::active) bind(*s);
}

void ControllerManager::make_runner(Slot& s) {
  Slot* own = &s;
  s.runner = std::make_unique<realtime::AsyncRunner>(
      [own] {
        own->own_result.store(own->controller->update(own->own_cycle, own->own_verdict),
                              std::memory_order_release);
        if (own->own_stop.exchange(false)) own->controller->on_deactivate(own->own_cycle);
      },
      s.options.lock_step, s.options.thread, s.context.period);
}

void ControllerManager::add(std::unique_ptr<controllers::Controller> controller,
                            controllers::ControllerContext context, LoadOptions options) {
  const std::string name = context.name;
  load(std::move(controller), std::move(context), std::move(options));
  configure(name);
}

void ControllerManager::cleanup(const std::string& name) {
  Slot& s = slot(name);
  if (s.state.load() != LifecycleState::inactive)
    throw Error(
        "wrong-state",
        "the controller '" + name + "' is " + hardware::name(s.state.load()) + ", it cannot be cleaned up",
        "deactivate it first");
  for (const auto& other : slots_) {
    if (other.get() == &s || other->state.load() == LifecycleState::unconfigured) continue;
    for (const auto* offered : {&s.controller->reference_interfaces(), &s.controller->exported_states()})
      for (const std::string& interface : *offered)
        for (const auto* wanted :
             {&other->controller->command_interfaces(), &other->controller->state_interfaces()})
          if (std::find(wanted->begin(), wanted->end(), interface) != wanted->end())
            throw Error("chain-in-use",
                        "the controller '" + name + "' cannot be cleaned up: '" + other->name +
                            "' uses its '" + interface + "'",
                        "clean '" + other->name + "' up first");
  }
  std::string thrown;
  CallbackReturn result = CallbackReturn::error;
  try {
    result = s.controller->on_cleanup();
  } catch (...) {
    thrown = what_was_thrown();
  }
  if (result == CallbackReturn::failure)
    throw Error("controller-failed",
                "the controller '" + name + "' could not be cleaned up and stays inactive");
  s.state = LifecycleState::unconfigured;
  if (result == CallbackReturn::error && !usable_after_error(*s.controller))
    s.state = LifecycleState::finalized;
  withdraw(s);
  post_schedule();
  if (!thrown.empty())
    throw Error("controller-failed", "the controller '" + name + "', on_cleanup, threw: " + thrown,
                std::string("it is ") + hardware::name(s.state.load()) + " now");
}

void ControllerManager::unload(const std::string& name) {
  Slot& s = slot(name);
  if (s.state.load() == LifecycleState::active)
    throw Error("wrong-state", "the controller '" + name + "' is active, it cannot be unloaded",
                "deactivate it first");
  if (s.state.load() == LifecycleState::inactive) cleanup(name);
  const auto at = std::find_if(slots_.begin(), slots_.end(), [&](const auto& p) { return p.get() == &s; });
  std::unique_ptr<Slot> gone = std::move(*at);
  slots_.erase(at);
  auto job = std::make_shared<NewSchedule>(*this, make_schedule(active_names()));
  if (!jobs_.post(job)) {
    slots_.push_back(std::move(gone));
    throw Error("busy", "the control loop has not taken the last requests yet", "try again");
  }
  std::erase_if(leaving_, [](const auto& pair) { return pair.first->done(); });
  leaving_.emplace_back(std::move(job), std::move(gone));
}

ControllerView ControllerManager::view(const Slot& s) const {
  const controllers::Controller& c = *s.controller;
  return {s.name,
          s.state.load(),
          c.command_interfaces(),
          c.state_interfaces(),
          c.reference_interfaces(),
          c.exported_states()};
}

std::vector<ControllerView> ControllerManager::views() const {
  std::vector<ControllerView> out;
  for (const auto& s : slots_) out.push_back(view(*s));
  return out;
}

std::string ControllerManager::why_unavailable(const std::string& interface, bool command) const {
  const auto index = command ? table_.find_command(interface) : table_.find_state(interface);
  if (!index) return "it does not exist";
  const int component =
      command ? hardware_.component_of_command(*index) : hardware_.component_of_state(*index);
  if (component < 0) return {};  // offered by another controller
  const LifecycleState state = hardware_.state_of(static_cast<std::size_t>(component));
  if (state == LifecycleState::active || (!command && state == LifecycleState::inactive)) return {};
  return "the hardware component '" + hardware_.component_name(static_cast<std::size_t>(component)) +
         "' is " + hardware::name(state);
}

SwitchPlan ControllerManager::plan(const SwitchRequest& request) const {
  return plan_switch(views(), request, [this](const std::string& interface, bool command) {
    return why_unavailable(interface, command);
  });
}

ControllerManager::Switch::Switch(ControllerManager& manager, SwitchPlan plan)
    : manager_(manager), plan_(std::move(plan)), epoch_(manager.known_epoch_) {}
ControllerManager::Switch::~Switch() = default;

void ControllerManager::Switch::run() noexcept {
  stale_ = manager_.epoch_ != epoch_;
  if (stale_) return;
  manager_.execute(*commit_, manager_.now_);
  std::swap(manager_.schedule_, schedule_);
}

std::shared_ptr<ControllerManager::Switch> ControllerManager::begin_switch(const SwitchRequest& request) {
  SwitchPlan planned = plan(request);
  if (!planned.ok) throw Error(planned.code, planned.reason, planned.advice);
  if (!hardware_.prepare_mode_switch(planned.start_interfaces, planned.stop_interfaces))
    throw Error("mode-refused", "the hardware refuses the commands of " + join(planned.start, ", "),
                "it cannot take these command interfaces together");
  auto job = std::make_shared<Switch>(*this, std::move(planned));
  job->commit_ = commit_of(job->plan_);
  std::vector<std::string> active = active_names();
  for (const std::string& name : job->plan_.stop) std::erase(active, name);
  for (const std::string& name : job->plan_.start) active.push_back(name);
  job->schedule_ = make_schedule(active);
  if (!jobs_.post(job))
    throw Error("busy", "the control loop has not taken the last requests yet", "try again");
  return job;
}

bool ControllerManager::finish(Switch& done) {
  if (done.stale_) return false;
  if (!done.commit_->refused) return true;
  post_schedule();
  throw Error("controller-failed",
              "the controller '" + done.commit_->refused->name + "' could not be activated",
              "it stays inactive; what was to start after it was not started");
}

void ControllerManager::switch_now(const SwitchRequest& request) {
  const auto job = begin_switch(request);
  if (job->done()) finish(*job);
}

void ControllerManager::activate(const std::string& name) {
  switch_now({{name}, {}, Strictness::strict});
}
void ControllerManager::deactivate(const std::string& name) {
  switch_now({{}, {name}, Strictness::strict});
}

namespace {
class ChangeParameters : public realtime::Job {
 public:
  ChangeParameters(controllers::Controller& controller, std::vector<controllers::ParameterChange> changes)
      : controller_(controller), changes_(std::move(changes)) {}
  void run() noexcept override {
    for (const controllers::ParameterChange& change : changes_) change.apply();
    controller_.on_parameters_changed();
  }

 private:
  controllers::Controller& controller_;
  std::vector<controllers::ParameterChange> changes_;
};
}  // namespace

std::shared_ptr<realtime::Job> ControllerManager::begin_change(
    const std::string& name, const std::vector<std::pair<std::string, std::string>>& values) {
  Slot& s = slot(name);
  std::vector<controllers::ParameterChange> changes;
  for (const auto& [key, value] : values) changes.push_back(s.context.parameters.change(key, value));
  const std::string why =
      guarded(name, "refuse_changes", [&] { return s.controller->refuse_changes(changes); });
  if (!why.empty())
    throw Error("bad-value", "the controller '" + name + "' refuses: " + why,
                "its parameters stay as they are");
  auto job = std::make_shared<ChangeParameters>(*s.controller, changes);
  if (!jobs_.post(job))
    throw Error("busy", "the control loop has not taken the last requests yet", "try again");
  for (const controllers::ParameterChange& change : changes) s.context.parameters.note_changed(change);
  return job;
}

std::vector<Problem> ControllerManager::findings(const std::string& name) const {
  return slot(name).context.parameters.problems().list();
}

std::vector<std::string> ControllerManager::active_names() const {
  std::vector<std::string> out;
  for_each_active([&out](const std::string& name) { out.push_back(name); });
  return out;
}

void ControllerManager::for_each_active(const std::function<void(const std::string&)>& call) const {
  for (const auto& s : slots_)
    if (s->state.load() == LifecycleState::active) call(s->name);
}

void ControllerManager::post_schedule() {
  auto job = std::make_shared<NewSchedule>(*this, make_schedule(active_names()));
  if (!jobs_.post(std::move(job)))
    throw Error("busy", "the control loop has not taken the last requests yet", "try again");
}

std::vector<LoopEvent> ControllerManager::take_events() {
  std::vector<LoopEvent> out;
  for (LoopEvent event{}; events_.pop(event);) out.push_back(event);
  const auto switches = [](const LoopEvent& e) { return e.kind != LoopEvent::Kind::commands_stale; };
  if (std::any_of(out.begin(), out.end(), switches)) {
    for (const LoopEvent& event : out)
      if (event.kind == LoopEvent::Kind::controller_failed ||
          event.kind == LoopEvent::Kind::component_failed ||
          event.kind == LoopEvent::Kind::component_deactivated)
        ++known_epoch_;
    post_schedule();
  }
  return out;
}

controllers::Controller* ControllerManager::find(const std::string& name) const {
  for (const auto& s : slots_)
    if (s->name == name) return s->controller.get();
  return nullptr;
}

const controllers::ControllerContext* ControllerManager::context(const std::string& name) const {
  for (const auto& s : slots_)
    if (s->name == name) return &s->context;
  return nullptr;
}

std::vector<std::pair<controllers::Controller*, LifecycleState>> ControllerManager::loaded() const {
  std::vector<std::pair<controllers::Controller*, LifecycleState>> out;
  for (const auto& s : slots_) out.emplace_back(s->controller.get(), s->state.load());
  return out;
}

std::vector<ListedController> ControllerManager::list() const {
  std::vector<ListedController> out;
  for (const auto& s : slots_) {
    const controllers::Controller& c = *s->controller;
    ListedController listed;
    listed.name = s->name;
    listed.type = s->context.type;
    listed.state = s->state.load();
    listed.chained = s->chained.load();
    listed.async = s->options.async;
    listed.stale = listed.state == LifecycleState::active && c.command_watch().stale();
    listed.divisor = s->options.divisor;
    listed.period = s->options.period;
    listed.updates = s->updates.load();
    listed.missed = s->runner ? s->runner->missed() : 0;
    listed.thread = s->runner ? &s->runner->health() : nullptr;
    listed.part = s->part.get();
    listed.required_commands = c.command_interfaces();
    listed.required_states = c.state_interfaces();
    if (listed.state == LifecycleState::active) listed.claimed = listed.required_commands;
    listed.references = c.reference_interfaces();
    listed.exported = c.exported_states();
    listed.fallback = s->options.fallback;
    out.push_back(std::move(listed));
  }
  return out;
}

std::string ControllerManager::name_of(int id) const {
  for (const auto& s : slots_)
    if (s->id == id) return s->name;
  return "controller";
}

std::string ControllerManager::holder_of(const std::string& command) const {
  for (const auto& s : slots_) {
    const auto& claimed = s->controller->command_interfaces();
    if (s->state.load() == LifecycleState::active &&
        std::find(claimed.begin(), claimed.end(), command) != claimed.end())
      return s->name;
  }
  return {};
}

}  // namespace polyarm::control
