#include "polyarm/machine/machine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/plugins/types.hpp"
#include "polyarm/realtime/refusals.hpp"
#include "polyarm/setup/controllers_start.hpp"

namespace polyarm::cell {

Machine::Machine(CellSetup& setup, Observer& observer)
    : setup_(setup), observer_(observer), calls_(setup.options.lock_step, observer) {}

void Machine::make_loop(const ros_files::ControllersFile& described) {
  const double rate = rate_of(setup_.file, described);
  control::LoopOptions loop;
  loop.period = static_cast<Nanoseconds>(std::llround(1e9 / rate));
  loop.limits = setup_.manager.enforce_command_limits;
  loop.measure_parts = !setup_.options.lock_step;
  loop.overrun = setup_.file.loop.overrun;
  loop.overrun_after = setup_.file.loop.overrun_after;
  loop.stall_holds = setup_.file.loop.stall_holds;
  loop.black_box_rows = static_cast<std::size_t>(10 * rate);
  loop.memory_at_once = !setup_.options.lock_step;
  loop_ = std::make_unique<control::ControlLoop>(loop);
  supervisor().set_contact_stop(setup_.options.allow_contact ? control::ContactStop::none
                                                             : setup_.file.contact_stop);
}

void Machine::add_hardware(Problems& problems) {
  add_components(hardware(), setup_.robots, setup_.scene, period(), setup_.options.lock_step, setup_.manager,
                 problems);
  problems.throw_if_errors();
  supervisor().watch_cell = !setup_.options.lock_step && loop_->holds_after_gap();
}

void Machine::start_hardware() {
  constexpr Nanoseconds kShort = 1'000'000'000;  // shorter wait after a person has asked to end
  const CellOptions& options = setup_.options;
  calls_.give_up_when(options.start_given_up);
  try {
    loop_->start_hardware(calls_);
  } catch (...) {
    const bool asked = options.start_given_up && options.start_given_up();
    calls_.give_up_when({});
    shut_hardware_down(asked ? std::min(kShort, options.hardware_timeout) : options.hardware_timeout);
    throw;
  }
  calls_.give_up_when({});
  for (const std::string& summary : hardware().diagnostics().summaries()) observer_.on_note(summary);
}

void Machine::prepare() {
  std::vector<controllers::JointFacts> joints;
  for (const auto& robot : setup_.robots)
    joints.insert(joints.end(), robot->joints.begin(), robot->joints.end());
  loop_->prepare(joints);
  joint_places_ = JointPlaces(setup_.robots, table());
  Problems reported_already;  // by the hardware
  for (const auto& robot : setup_.robots)
    loop_->limits().set_turns(robot->entry.name + "/", divisor_of(*robot, period(), reported_already));
}

bool Machine::shut_hardware_down(Nanoseconds patience) {
  if (!loop_) return true;
  calls_.give_up_after(patience);
  if (hardware().shut_down(calls_)) return true;
  static auto* left = new std::vector<CellRobots>;
  left->push_back(std::move(setup_.robots));
  for (CellRobots& robots : setup_.reloaded) left->push_back(std::move(robots));
  return false;
}

void Machine::begin_tick(Nanoseconds now) {
  now_ = now;
  loop_->outbox().fetch();
  supervisor().heartbeat(now);
  forget_hold_if_running();
}

ControllerSwitch::ControllerSwitch(Machine& machine, control::SwitchRequest request)
    : machine_(machine), request_(std::move(request)), job_(machine.controllers().begin_switch(request_)) {}

bool ControllerSwitch::advance() {
  if (!job_->done()) return false;
  if (machine_.controllers().finish(*job_)) return true;
  if (++tries_ > 5)
    throw Error("busy", "the loop keeps changing its controllers by itself", "look at the log");
  machine_.report_events();
  job_ = machine_.controllers().begin_switch(request_);
  return false;
}

const control::SwitchPlan& ControllerSwitch::plan() const {
  return job_->plan();
}

void Machine::hold_for(Problem why) {
  held_by_ = std::move(why);
  supervisor().latch().request(realtime::StopKind::controlled);
}

void Machine::forget_hold_if_running() {
  const bool stop_requested = supervisor().latch().requested() != realtime::StopKind::none;
  if (snapshot().state == control::RunState::running && !stop_requested) held_by_.reset();
}

void Machine::post(control::Request request) const {
  if (!loop_->post(request)) throw Error("busy", "the control loop has not taken the last requests yet");
}

void Machine::report_events() {
  for (const control::LoopEvent& event : controllers().take_events()) report_loop_event(event);
  calls_.tick(hardware(), now_);
  report_overruns();
  report_threads();
  // Controllers of ROS run their timers here, also while no client follows a goal.
  controllers().for_each_active([this](const std::string& name) { goal_events(name); });
}

void Machine::report_loop_event(const control::LoopEvent& event) {
  using Kind = control::LoopEvent::Kind;
  const bool of_hardware = event.kind == Kind::component_failed || event.kind == Kind::component_deactivated;
  const auto who = static_cast<std::size_t>(event.who);
  const std::string name = of_hardware ? hardware().component_name(who) : controllers().name_of(event.who);
  constexpr const char* kTexts[] = {
      "the controller {} failed and is inactive, with all controllers that work through it",
      "the controller {} was stopped with what it works on",
      "the controller {} took over",
      "the hardware component {} failed",
      "the hardware component {} asked to be deactivated",
      "the controller {} receives nothing new: the last message has expired"};
  std::string text = fmt::format(fmt::runtime(kTexts[static_cast<std::size_t>(event.kind)]), name);
  if (const std::string reason = of_hardware ? hardware().diagnostics().reason(who) : ""; !reason.empty())
    text += ": " + reason;
  observer_.on_note(text);
  if (of_hardware || event.kind == Kind::controller_failed) falling_ = of_hardware ? name : "";
  if (event.kind == Kind::controller_stopped && !falling_.empty()) failed_components_[falling_].push_back(name);
  if (event.kind == Kind::component_failed) calls_.post(who, hardware::Step::error);
  if (event.kind == Kind::component_deactivated) calls_.post(who, hardware::Step::deactivate);
}

namespace {
/// True for 1, 10, 100, …: the first occurrence is reported at once, later ones rarely.
bool is_worth_reporting(std::uint64_t count) {
  while (count % 10 == 0) count /= 10;
  return count == 1;
}
}  // namespace

void Machine::report_overruns() {
  const auto report = [this](const std::string& name, const realtime::Overrun& overrun, const char* advice) {
    const std::uint64_t count = ++overruns_[{name, overrun.callback}];
    if (!setup_.manager.overruns_print_warnings || !is_worth_reporting(count)) return;
    observer_.on_note(fmt::format("{}: {} took {:.3f} ms in cycle {}, its budget is {:.3f} ms{} ({})", name,
                                  overrun.callback, static_cast<double>(overrun.took) * 1e-6, overrun.cycle,
                                  static_cast<double>(overrun.budget) * 1e-6,
                                  count == 1 ? "" : fmt::format("; {} times now", count), advice));
  };
  realtime::Overrun overrun;
  while (hardware().diagnostics().take_overrun(overrun))
    report(hardware().component_name(static_cast<std::size_t>(overrun.who)), overrun,
           "is_async=\"true\" of its <ros2_control> gives it its own thread");
  while (controllers().take_overrun(overrun))
    report(controllers().name_of(overrun.who), overrun, "is_async: true gives it its own thread");
}

/// Reports once what the machine refused a component's thread, and that the thread is late.
void Machine::report_threads() {
  hardware::Hardware& hardware = this->hardware();
  reported_threads_.resize(hardware.size());
  for (std::int32_t who = 0; hardware.diagnostics().take_late(who);) {
    const auto i = static_cast<std::size_t>(who);
    const realtime::ThreadHealth& health = *hardware.diagnostics().thread_health(i);
    constexpr const char* kThen[] = {"it continues", "the loop stops on the path and holds",
                                     "it is switched off"};
    observer_.on_note(
        fmt::format("the thread of {} is late: {} late runs, {} missed runs; {} "
                    "('overrun' of its thread); polyarm health shows its times",
                    hardware.component_name(i), std::uint64_t{health.late}, std::uint64_t{health.missed},
                    kThen[static_cast<std::size_t>(hardware.diagnostics().when_late(i))]));
  }
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    const realtime::ThreadHealth* health = hardware.diagnostics().thread_health(i);
    const unsigned refused = health ? health->refused.load(std::memory_order_acquire) : 0;
    if (refused == 0 || std::exchange(reported_threads_[i], 1)) continue;
    for (const std::string& text : realtime::refusals(refused, hardware.diagnostics().thread_options(i),
                                                      "the thread of " + hardware.component_name(i)))
      observer_.on_note(text);
  }
}

std::vector<std::string> Machine::stopped_with(const std::string& component) const {
  const auto found = failed_components_.find(component);
  return found == failed_components_.end() ? std::vector<std::string>{} : found->second;
}

std::vector<std::string> Machine::take_failed(const std::string& component) {
  return std::exchange(failed_components_[component], {});
}

const std::vector<controllers::GoalEvent>& Machine::goal_events(const std::string& name) {
  constexpr std::size_t kKept = 1000;
  std::vector<controllers::GoalEvent>& out = goal_events_[name];
  controllers::Controller* const controller = controllers().find(name);
  try {
    while (const auto event = controller ? controller->next_goal_event() : std::nullopt)
      out.push_back(*event);
  } catch (...) {
    observer_.on_note(name + ": the report of its goals threw: " + what_was_thrown());
  }
  if (out.size() > 2 * kKept) out.erase(out.begin(), out.end() - kKept);
  return out;
}

Problems Machine::load_controller(const std::string& name, const std::string& type,
                                  controllers::Parameters parameters, const std::string& file) {
  Problems problems, found;
  Observer nobody;
  CellFile source = setup_.file;
  if (!file.empty()) {
    source.controllers = {file};
    source.launched = nullptr;
  }
  ros_files::ControllersFile described;
  if (type.empty()) described = read_cell_controllers(source, problems);
  problems.throw_if_errors();
  std::vector<PlannedController> plan = plan_controllers(
      described, setup_.robots, *loop_, {{}, setup_.options.lock_step, setup_.file.budget}, nobody, problems);
  std::vector<std::string> known;
  for (PlannedController& planned : plan) {
    known.push_back(planned.context.name);
    if (type.empty() ? planned.context.name != name : &planned != &plan.front()) continue;
    if (!type.empty()) {
      planned.context.name = name;
      planned.context.type = type;
      planned.context.parameters = std::move(parameters);
      planned.controller = controllers::make_controller(type, planned.context.parameters);
      hand_models(*planned.controller, setup_.robots);
      planned.options = {};
      planned.options.lock_step = setup_.options.lock_step;
    } else {
      for (auto& [key, entry] : parameters.entries)
        planned.context.parameters.entries[key] = std::move(entry);
    }
    control::ControllerManager& manager = controllers();
    manager.load(std::move(planned.controller), std::move(planned.context), std::move(planned.options));
    goal_events_.erase(name);  // events of an earlier controller with this name
    try {
      manager.configure(name);
    } catch (const Error&) {
      manager.unload(name);
      throw;
    }
    for (const Problem& problem : manager.findings(name)) found.add(problem);
    if (std::optional<Problem> late = late_wheels(name, setup_.robots, manager)) found.add(std::move(*late));
    return found;
  }
  problems.throw_if_errors();
  throw Error("unknown-controller",
              "no controllers file describes '" + name + "'" + did_you_mean(name, known),
              "give its type, or put it into the controllers file");
}

std::shared_ptr<const Remaking> Machine::remake(const std::string& name, Worker& worker) const {
  auto out = std::make_shared<Remaking>();
  out->name = name;
  worker.post([out, file = setup_.file, catalogue = setup_.catalogue, real = setup_.options.real,
               &scene = setup_.scene, period = period()] {
    try {
      out->made = make_again(out->name, file, catalogue, real, scene, period);
    } catch (...) {
      out->failed = std::current_exception();
    }
    out->done.store(true, std::memory_order_release);
  });
  return out;
}

std::shared_ptr<hardware::Transition> Machine::begin_reload(const Remaking& remade) {
  if (remade.failed) std::rethrow_exception(remade.failed);
  setup_.reloaded.push_back(std::move(remade.made.robots));
  hardware::Hardware& hardware = this->hardware();
  return hardware.begin_replace(static_cast<std::size_t>(hardware.find(remade.name)),
                                std::move(remade.made.component), remade.made.context);
}

}  // namespace polyarm::cell
