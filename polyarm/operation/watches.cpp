#include "polyarm/operation/watches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/tasks/wait_hints.hpp"

namespace polyarm::cell {

namespace {
/// Cell time without any possible progress after which a run counts as a deadlock.
constexpr Nanoseconds kDeadlockTimeout = 2'000'000'000;
/// Time for released parts to come to rest after the program has ended.
constexpr Nanoseconds kSettleTimeout = 2'000'000'000;
/// A cell that only sends messages ends when nothing has moved for this time.
constexpr Nanoseconds kSendSettle = 500'000'000;
/// Tick period; and the duration after which a wait is checked, once.
constexpr Nanoseconds kTick = 2'000'000, kLongWait = 3'000'000'000;
/// A program that neither waits nor moves gets a warning after kBusyTimeout. After kEndlessTimeout, if
/// nothing that it reads changes, the run fails with "endless-loop".
constexpr Nanoseconds kBusyTimeout = 1'000'000'000, kEndlessTimeout = 30'000'000'000;
}  // namespace

void LifeCycle::fail(Problem problem) {
  if (failure_) return;
  observer_.on_problem(machine_.now(), problem);
  failure_ = Failure{std::move(problem), machine_.now()};
  motions_.drop();
  machine_.supervisor().latch().request(realtime::StopKind::controlled);
}

Problem LifeCycle::stop_cause() const {
  const control::StopCause cause = machine_.snapshot().cause;
  if (cause == control::StopCause::asked && machine_.held_by()) return *machine_.held_by();
  if (cause == control::StopCause::asked && failure_) return {"run-failed", {}, "the run failed", {}};
  return {control::code(cause), {}, control::name(cause), {}};
}

bool recovered_by_others(const CellSetup& setup, const Programs& programs) {
  return programs.waits() || (!setup.options.lock_step && !programs.program() && setup.file.send.empty());
}

FaultRecord Watches::begin_record(const Problem& problem) const {
  std::string stop;
  if (!stops_.empty() && stops_.back().begun == cell_.machine.snapshot().stop.begun)
    stop = stops_.back().sentence();
  return cell::begin_record(cell_.setup, cell_.machine.loop(), problem, stop);
}

void Watches::watch_stops() {
  constexpr std::size_t kKept = 1000;
  const control::Snapshot& snapshot = cell_.machine.snapshot();
  const JointPlaces& places = cell_.machine.joint_places();
  held_place_.tick(snapshot, places, cell_.jogging.engaged() || cell_.contacts.touching());
  if (snapshot.state == control::RunState::stopping && snapshot.cause == control::StopCause::contact)
    stop_watch_.set_category(cell_.machine.supervisor().contact_stop() == control::ContactStop::cut ? 0 : 1);
  auto stop = stop_watch_.tick(snapshot, cell_.setup.robots, places);
  if (!stop) return;
  const Problem cause = cell_.life.stop_cause();
  stop->cause = cause.what;
  stop->cause_code = cause.code;
  if (stops_.size() >= kKept) stops_.erase(stops_.begin());
  stops_.push_back(*stop);
  cell_.observer.on_stop(cell_.machine.now(), *stop);
  recorder_.note_stop(stop->sentence());
}

void Watches::hold_if_missing(const std::optional<Problem>& missing) {
  const bool works = cell_.programs.under_way() || cell_.jogging.engaged();
  const realtime::StopLatch& latch = cell_.machine.supervisor().latch();
  if (!missing || !works || cell_.machine.snapshot().state != control::RunState::running) return;
  if (latch.requested() != realtime::StopKind::none) return;
  Problem problem = *missing;
  if (const Task* const program = cell_.programs.program()) problem.where = program->status().where;
  problem.advice = "correct this, then polyarm control resume";
  cell_.observer.on_problem(cell_.machine.now(), problem);
  cell_.machine.hold_for(std::move(problem));
}

void Watches::watch_faults_and_end() {
  const control::Snapshot& snapshot = cell_.machine.snapshot();
  contacts_max_ = std::max(contacts_max_, snapshot.world.contacts);
  tracking_error_max_ = std::max(tracking_error_max_, snapshot.world.tracking_error);
  if (cell_.life.failure()) return;
  watch_fault();
  watch_groups();
  if (const auto note = recorder_.tick(cell_.machine.now(), cell_.machine.loop(), cell_.worker))
    cell_.observer.on_note(*note);
  watch_for_deadlock();
  watch_end();
}

void Watches::add_component(std::size_t component, polyarm::Facts& facts) const {
  const hardware::Hardware& hardware = cell_.machine.hardware();
  facts.push_back({"component", hardware.component_name(component)});
  if (const std::string name = hardware.diagnostics().blamed_interface(component); !name.empty())
    facts.push_back({"interface", name});
  if (const std::string own = hardware.diagnostics().own_reason(component); !own.empty())
    facts.push_back({"reason", own});
}

namespace {
/// ": measured 2, its limits are -1 to 1", for the joint that the command belongs to.
std::string range_left(const CellRobots& robots, const std::string& command, double measured) {
  for (const auto& robot : robots)
    for (const controllers::JointFacts& joint : robot->joints)
      if (command.starts_with(joint.name + "/"))
        return ": measured " + format_number(measured) + ", its limits are " + format_number(joint.lower) +
               " to " + format_number(joint.upper);
  return {};
}
}  // namespace

/// " (arm: the bus is silent)": the cause of the fault, if known; also added to `facts`.
std::string Watches::blame(polyarm::Facts& facts) const {
  using Cause = control::StopCause;
  const control::Snapshot& snapshot = cell_.machine.snapshot();
  const Cause cause = snapshot.cause;
  const bool of_hardware = cause == Cause::component || cause == Cause::not_a_number ||
                           cause == Cause::jump || cause == Cause::not_following || cause == Cause::late;
  if (of_hardware && snapshot.event.component >= 0) {
    const auto component = static_cast<std::size_t>(snapshot.event.component);
    const hardware::Hardware& hardware = cell_.machine.hardware();
    std::string reason = hardware.diagnostics().reason(component);
    add_component(component, facts);
    if (const std::string contact = contact_behind(cause); !contact.empty()) {
      facts.push_back({"reason", contact});
      reason += reason.empty() ? contact : "; " + contact;
    }
    return " (" + hardware.component_name(component) + (reason.empty() ? "" : ": " + reason) + ")";
  }
  if (cause == Cause::limits && snapshot.event.interface >= 0) {
    const std::string& name =
        cell_.machine.table().command_names()[static_cast<std::size_t>(snapshot.event.interface)];
    facts.push_back({"interface", name});
    return " (" + name + range_left(cell_.setup.robots, name, snapshot.event.value) + ")";
  }
  if (cause == Cause::controller && snapshot.event.controller >= 0) {
    const std::string name = cell_.machine.controllers().name_of(snapshot.event.controller);
    facts.push_back({"controller", name});
    return " (" + name + ")";
  }
  return {};
}

/// A fault ends a run that works towards an end. A run whose faults are recovered externally continues.
void Watches::watch_fault() {
  const control::Snapshot& snapshot = cell_.machine.snapshot();
  const bool fault = snapshot.state == control::RunState::fault;
  const bool news = fault && !std::exchange(in_fault_, fault);
  in_fault_ = fault;
  if (!news) return;
  polyarm::Facts facts{{"cause", control::code(snapshot.cause)}};
  const std::string blamed = blame(facts);
  Problem problem{"fault",         {},   std::string(control::name(snapshot.cause)) + blamed, {},
                  Severity::error, facts};
  const bool waits = recovered_by_others();
  problem.advice =
      !waits ? "see the recorded cycles of this run"
      : snapshot.cause == control::StopCause::limits
          ? "polyarm control recover and resume; it can then only move inwards"
          : "recover the hardware (Health on the pendant, or polyarm hardware recover), start its "
            "controllers, resume";
  if (!waits) return cell_.life.fail(std::move(problem));
  cell_.observer.on_problem(cell_.machine.now(), problem);
  recorder_.begin(begin_record(problem), cell_.machine.now());
}

void Watches::report_group_fault(std::size_t i) {
  const hardware::Hardware& hardware = cell_.machine.hardware();
  const control::StopCause cause = cell_.machine.snapshot().fallen[i];
  const std::string reason = hardware.diagnostics().reason(i), name = hardware.component_name(i);
  Problem problem{
      "fault",
      {},
      fmt::format("{} ({}{}); only the controllers of {} have stopped", control::name(cause), name,
                  reason.empty() ? "" : ": " + reason, hardware.group(i)),
      "polyarm hardware recover " + name + ", then start its controllers: polyarm control switch -a NAME",
      Severity::error,
      {{"cause", control::code(cause)}, {"group", hardware.group(i)}}};
  add_component(i, problem.facts);
  cell_.observer.on_problem(cell_.machine.now(), problem);
  if (group_faults_.size() < 1000) group_faults_.push_back(problem);  // faults may come and go
  if (recovered_by_others()) recorder_.begin(begin_record(problem), cell_.machine.now());
}

/// Faults that stop one robot only: the run continues, but its outcome is a failure.
void Watches::watch_groups() {
  const control::Snapshot& snapshot = cell_.machine.snapshot();
  const hardware::Hardware& hardware = cell_.machine.hardware();
  failed_seen_.resize(snapshot.fallen.size());
  std::string reported;  // components that failed together are reported once
  for (std::size_t i = 0; i < snapshot.fallen.size(); ++i) {
    const control::StopCause cause = snapshot.fallen[i];
    const bool news = std::exchange(failed_seen_[i], cause) == control::StopCause::none &&
                      cause != control::StopCause::none;
    if (!news || !hardware.contained(i) || snapshot.state == control::RunState::fault) continue;
    if (std::exchange(reported, hardware.group(i)) == hardware.group(i)) continue;
    report_group_fault(i);
  }
}

namespace {
bool is_busy_for(const Task* task, Nanoseconds now, Nanoseconds patience) {
  return task && !task->ended() && task->busy_since() && now - *task->busy_since() >= patience;
}

Problem problem_of_busy(const Task& task) {
  return {"busy-loop", task.status().where,
          "'" + task.name() + "' has neither waited nor moved for 1 s; it is in this line now",
          "a loop that waits for something needs `wait CONDITION`, or `wait 10ms`", Severity::warning};
}
}  // namespace

/// True if the task loops endlessly or each of its tasks waits for something that time does not bring.
bool Watches::is_stuck(const Task* task) const {
  return !task || task->ended() || is_busy_for(task, cell_.machine.now(), kEndlessTimeout) ||
         task->interpreter().waits_for_others();
}

/// True if nothing moves and no clock, link or file can end the programs' waits.
bool Watches::is_quiet() const {
  const control::Snapshot& snapshot = cell_.machine.snapshot();
  const Task* const program = cell_.programs.program();
  return !cell_.setup.options.test && !cell_.programs.waits() && program && !program->ended() &&
         is_stuck(program) && is_stuck(cell_.programs.plc()) && snapshot.standing && snapshot.world.at_rest &&
         !cell_.parts.anything_moving() && snapshot.state == control::RunState::running &&
         !cell_.data.files().has_outside_writers() && !cell_.data.links().any() &&
         !cell_.programs.hears_devices() && cell_.data.store.version() == quiet_version_;
}

std::string Watches::hint_of_wait() const {
  const std::string hint =
      cell::hint_of_wait({cell_.setup, cell_.machine, cell_.data, cell_.motions, cell_.programs});
  return hint.empty() ? cell_.programs.hint_of_live() : hint;
}

void Watches::warn_of_long_wait() {
  if (!cell_.programs.under_way()) return;
  const Task& program = *cell_.programs.program();
  const auto since = program.waits_since();
  if (!since || cell_.machine.now() - *since != kLongWait / kTick * kTick) return;
  if (const std::string hint = hint_of_wait(); !hint.empty() && reported_warnings_.insert(hint).second)
    cell_.observer.on_note(program.status().where.text() + ": " + hint);
}

void Watches::warn_of_busy_tasks() {
  if (cell_.machine.snapshot().state != control::RunState::running) return;  // a held program takes no steps
  const Nanoseconds now = cell_.machine.now();
  for (const Task* task : {cell_.programs.program(), cell_.programs.plc()})
    if (is_busy_for(task, now, kBusyTimeout) && reported_warnings_.insert("busy " + task->name()).second)
      cell_.observer.on_problem(now, problem_of_busy(*task));
}

void Watches::watch_for_deadlock() {
  const Nanoseconds now = cell_.machine.now();
  warn_of_long_wait();
  warn_of_busy_tasks();
  const bool quiet = is_quiet();
  quiet_version_ = cell_.data.store.version();
  if (!quiet) quiet_since_ = now;
  if (now - quiet_since_ >= kDeadlockTimeout) fail_for_deadlock();
}

void Watches::fail_for_deadlock() {
  const Task& program = *cell_.programs.program();
  const std::string hint = hint_of_wait();
  std::string waiting = program.sentences();
  if (const Task* const plc = cell_.programs.plc(); plc && !plc->ended()) waiting += "; " + plc->sentences();
  const bool busy = program.busy_since().has_value();
  const std::string advice =
      busy ? "end the loop, or let it wait for what it needs" : "check what should set these tags";
  cell_.life.fail({busy ? "endless-loop" : "deadlock",
                   program.status().where,
                   (busy ? "the program loops forever, and nothing changes the values that it reads: "
                         : "every task waits, and no clock, link or motion can change what it waits for: ") +
                       waiting,
                   hint.empty() ? advice : hint,
                   Severity::error,
                   {{"waiting", waiting}}});
}

void Watches::watch_failed_tasks() {
  for (Task* task : {cell_.programs.program(), cell_.programs.plc()}) {
    if (!task || !task->failed()) continue;
    if (cell_.life.failure() || reported_ended_.contains(task->name())) continue;
    Problem problem = task->status().problem.value_or(
        Problem{"failed", task->status().where, task->name() + " failed", {}});
    explain_timeout({cell_.setup, cell_.machine, cell_.data, cell_.motions, cell_.programs}, *task, problem);
    if (!cell_.programs.waits()) {
      cell_.life.fail(problem);
      continue;
    }
    reported_ended_.insert(task->name());
    cell_.observer.on_problem(cell_.machine.now(), problem);
    if (task == cell_.programs.program()) cell_.motions.end();
  }
}

void Watches::watch_end() {
  const Nanoseconds now = cell_.machine.now();
  const control::Snapshot& snapshot = cell_.machine.snapshot();
  const Task* const program = cell_.programs.program();
  if (std::exchange(starts_seen_, cell_.programs.starts()) != cell_.programs.starts()) {
    ended_at_ = -1;
    cell_.life.set_finished(false);
    reported_ended_.erase("program");
  }
  watch_failed_tasks();
  if (const auto lost = cell_.data.files().take_failure()) cell_.life.fail(lost->problems().front());
  if (cell_.life.failure() || cell_.programs.waits()) return;
  const bool only_sends = !program && !cell_.setup.file.send.empty();
  if (only_sends && !started_) return;
  if (only_sends) {  // the messages were executed
    if (!snapshot.standing) ended_at_ = now;
    const bool settled = ended_at_ >= 0 && snapshot.standing && now - ended_at_ > kSendSettle;
    const bool nothing_moved = now - cell_.arming.armed_at() > kSettleTimeout && ended_at_ < 0;
    cell_.life.set_finished(settled || nothing_moved);
    return;
  }
  if (!program || !program->ended()) return;
  if (ended_at_ < 0) ended_at_ = now;
  const bool settled = !cell_.parts.anything_moving() && snapshot.standing;
  cell_.life.set_finished((settled || now - ended_at_ > kSettleTimeout) && cell_.data.outputs_settled(now));
}

}  // namespace polyarm::cell
