#include <fmt/format.h>

#include <utility>

#include "polyarm/cell/cell.hpp"
#include "polyarm/cell/program_tests.hpp"
#include "polyarm/cell/wait_hints.hpp"
#include "polyarm/realtime/refusals.hpp"

namespace polyarm::cell {

namespace {
/// A run in which nothing can happen any more is given this long, in cell time, before it is called a
/// deadlock.
constexpr Nanoseconds kDeadlockPatience = 2'000'000'000;
/// Parts that were let go of are given this long to come to rest after the program has ended.
constexpr Nanoseconds kSettlePatience = 2'000'000'000;
/// A cell that only sends messages ends when nothing has moved for this long.
constexpr Nanoseconds kSendSettle = 500'000'000;
/// A program that neither waits nor moves gets a warning after the first time. After the second, if nothing that
/// it reads changes, the run fails with "endless-loop".
constexpr Nanoseconds kBusyPatience = 1'000'000'000, kEndlessPatience = 30'000'000'000;
}  // namespace

void Cell::tell_loop_events() {
  using Kind = control::LoopEvent::Kind;
  control::ControllerManager& manager = loop_->controllers();
  for (const control::LoopEvent& event : manager.take_events()) {
    const bool hardware = event.kind == Kind::component_failed || event.kind == Kind::component_deactivated;
    const auto who = static_cast<std::size_t>(event.who);
    const std::string name = hardware ? loop_->hardware().component_name(who) : manager.name_of(event.who);
    constexpr const char* kTexts[] = {
        "the controller {} failed and is inactive, with all that works through it",
        "the controller {} was stopped with what it works on",
        "the controller {} took over",
        "the hardware component {} failed",
        "the hardware component {} asked to be deactivated",
        "nothing new comes for the controller {}: what it was sent last has ended"};
    std::string text = fmt::format(fmt::runtime(kTexts[static_cast<std::size_t>(event.kind)]), name);
    if (const std::string reason = hardware ? loop_->hardware().diagnostics().reason(who) : "";
        !reason.empty())
      text += ": " + reason;
    observer_.on_note(text);
    if (hardware || event.kind == Kind::controller_failed) falling_ = hardware ? name : "";
    if (event.kind == Kind::controller_stopped && !falling_.empty()) fallen_[falling_].push_back(name);
    if (event.kind == Kind::component_failed) calls_.post(who, hardware::Step::error);
    if (event.kind == Kind::component_deactivated) calls_.post(who, hardware::Step::deactivate);
  }
  calls_.tick(loop_->hardware(), now_);
}

namespace {
/// 1, 10, 100, …: told at once, and then not a thousand times a second.
bool is_worth_telling(std::uint64_t count) {
  while (count % 10 == 0) count /= 10;
  return count == 1;
}
}  // namespace

void Cell::tell_overruns() {
  const auto tell = [this](const std::string& name, const realtime::Overrun& overrun, const char* advice) {
    const std::uint64_t count = ++overruns_[{name, overrun.callback}];
    if (!manager_.overruns_print_warnings || !is_worth_telling(count)) return;
    observer_.on_note(fmt::format("{}: {} took {:.3f} ms in cycle {}, its budget is {:.3f} ms{} ({})", name,
                                  overrun.callback, static_cast<double>(overrun.took) * 1e-6, overrun.cycle,
                                  static_cast<double>(overrun.budget) * 1e-6,
                                  count == 1 ? "" : fmt::format("; {} times now", count), advice));
  };
  realtime::Overrun overrun;
  while (loop_->hardware().diagnostics().take_overrun(overrun))
    tell(loop_->hardware().component_name(static_cast<std::size_t>(overrun.who)), overrun,
         "is_async=\"true\" of its <ros2_control> gives it a thread of its own");
  while (loop_->controllers().take_overrun(overrun))
    tell(loop_->controllers().name_of(overrun.who), overrun, "is_async: true gives it a thread of its own");
}

/// What the machine refused a component's thread, and that it is late: once.
void Cell::tell_threads() {
  hardware::Hardware& hardware = loop_->hardware();
  told_threads_.resize(hardware.size());
  for (std::int32_t who = 0; hardware.diagnostics().take_late(who);) {
    const auto i = static_cast<std::size_t>(who);
    const realtime::ThreadHealth& health = *hardware.diagnostics().thread_health(i);
    constexpr const char* kThen[] = {"it goes on", "the loop stops on the path and holds", "it is taken off"};
    observer_.on_note(
        fmt::format("the thread of {} is late: {} runs were, and {} missed their turn; {} "
                    "('overrun' of its thread); polyarm health shows its times",
                    hardware.component_name(i), std::uint64_t{health.late}, std::uint64_t{health.missed},
                    kThen[static_cast<std::size_t>(hardware.diagnostics().when_late(i))]));
  }
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    const realtime::ThreadHealth* health = hardware.diagnostics().thread_health(i);
    const unsigned refused = health ? health->refused.load(std::memory_order_acquire) : 0;
    if (refused == 0 || std::exchange(told_threads_[i], 1)) continue;
    for (const std::string& text : realtime::refusals(refused, hardware.diagnostics().thread_options(i),
                                                      "the thread of " + hardware.component_name(i)))
      observer_.on_note(text);
  }
}

/// A link or a sign of life that is missed holds the cell; who resumes it meanwhile is held again.
void Cell::watch_links(Nanoseconds now, const control::Snapshot& snapshot) {
  for (const Problem& problem : links_->take_news()) observer_.on_problem(now, problem);
  if (!links_ready_) {
    links_ready_ = links_->ready();
    if (!links_ready_ && now > 1'000'000'000 && !std::exchange(told_waiting_, true))
      for (const CellLinks::Status& link : links_->status())
        if (!link.state.was_up)
          observer_.on_note("the programs begin when the link '" + link.entry->name +
                            "' is there: " + link.state.reason);
  }
  const std::optional<Problem> lost = links_->lost();
  const std::optional<Problem>& why = lost ? lost : heartbeats_->stopped();
  missed_ = why.has_value();
  const bool works = (program_ && begun_ && !program_->ended()) || jogging_->engaged();
  if (!missed_ || !works || snapshot.state != control::RunState::running) return;
  if (loop_->supervisor().latch().requested() != realtime::StopKind::none) return;
  Problem problem = *why;
  if (program_) problem.where = program_->status().where;
  problem.advice = "mend it, then polyarm control resume";
  observer_.on_problem(now, problem);
  hold_for(std::move(problem));
}

void Cell::hold_for(Problem why) {
  held_by_ = std::move(why);
  loop_->supervisor().latch().request(realtime::StopKind::controlled);
}

Problem Cell::stop_cause() const {
  const control::StopCause cause = snapshot().cause;
  if (cause == control::StopCause::asked && held_by_) return *held_by_;
  if (cause == control::StopCause::asked && failure_) return {"run-failed", {}, "the run failed", {}};
  return {control::code(cause), {}, control::name(cause), {}};
}

void Cell::tell_changes(Nanoseconds now) {
  if (store_.version() == told_version_) return;
  for (const data::Change& change : store_.changes_since(told_version_))
    if (change.now && change.old && change.who != "state")
      observer_.on_tag(now, change.name, change.now->text(), change.who);
  told_version_ = store_.version();
}

void Cell::fail(Nanoseconds now, Problem problem) {
  if (failure_) return;
  observer_.on_problem(now, problem);
  failure_ = Failure{std::move(problem), now};
  for (const auto& motion : motions_)
    if (motion) motion->drop();
  drop_bases();
  loop_->supervisor().latch().request(realtime::StopKind::controlled);
}

namespace {
void add_component_facts(const hardware::Hardware& hardware, std::size_t component, Facts& facts) {
  facts.push_back({"component", hardware.component_name(component)});
  if (const std::string name = hardware.diagnostics().blamed_interface(component); !name.empty())
    facts.push_back({"interface", name});
  if (const std::string own = hardware.diagnostics().own_reason(component); !own.empty())
    facts.push_back({"reason", own});
}
}  // namespace

/// A fault ends what works towards an end; a cell that waits for others is brought back by them.
void Cell::watch_faults(Nanoseconds now, const control::Snapshot& snapshot) {
  const bool fault = snapshot.state == control::RunState::fault;
  const bool news = fault && !std::exchange(in_fault_, fault);
  in_fault_ = fault;
  if (!news) return;
  using Cause = control::StopCause;
  const bool of_hardware = snapshot.cause == Cause::component || snapshot.cause == Cause::not_a_number ||
                           snapshot.cause == Cause::jump || snapshot.cause == Cause::not_following ||
                           snapshot.cause == Cause::late;
  std::string who;
  Facts facts{{"cause", control::code(snapshot.cause)}};
  if (of_hardware && snapshot.event.component >= 0) {
    const auto component = static_cast<std::size_t>(snapshot.event.component);
    const std::string reason = loop_->hardware().diagnostics().reason(component);
    who = " (" + loop_->hardware().component_name(component) + (reason.empty() ? "" : ": " + reason) + ")";
    add_component_facts(loop_->hardware(), component, facts);
  } else if (snapshot.cause == Cause::limits && snapshot.event.interface >= 0) {
    const std::string& name =
        loop_->table().command_names()[static_cast<std::size_t>(snapshot.event.interface)];
    who = " (" + name + ")";
    facts.push_back({"interface", name});
  } else if (snapshot.cause == Cause::controller && snapshot.event.controller >= 0) {
    const std::string name = loop_->controllers().name_of(snapshot.event.controller);
    who = " (" + name + ")";
    facts.push_back({"controller", name});
  }
  Problem problem{"fault", {}, std::string(control::name(snapshot.cause)) + who, {}, Severity::error, facts};
  const bool waits = waits_for_others();
  problem.advice =
      !waits ? "see the recorded cycles of this run"
      : snapshot.cause == Cause::limits
          ? "polyarm control recover and resume; it may then be moved inwards only"
          : "bring the hardware back (Health on the pendant, or polyarm hardware recover), start its "
            "controllers, resume";
  if (!waits) return fail(now, std::move(problem));
  observer_.on_problem(now, problem);
  recorder_.begin(begin_record(*this, problem), now);
}

/// A fault of a robot whose fault stops nothing else: the run goes on, and does not end well.
void Cell::watch_groups(Nanoseconds now, const control::Snapshot& snapshot) {
  hardware::Hardware& hardware = loop_->hardware();
  fallen_seen_.resize(snapshot.fallen.size());
  std::string told;  // what fell together is told once
  for (std::size_t i = 0; i < snapshot.fallen.size(); ++i) {
    const control::StopCause cause = snapshot.fallen[i];
    const bool news = std::exchange(fallen_seen_[i], cause) == control::StopCause::none &&
                      cause != control::StopCause::none;
    if (!news || !hardware.contained(i) || snapshot.state == control::RunState::fault) continue;
    if (std::exchange(told, hardware.group(i)) == hardware.group(i)) continue;
    const std::string reason = hardware.diagnostics().reason(i), name = hardware.component_name(i);
    Problem problem{
        "fault",
        {},
        fmt::format("{} ({}{}); only what works on {} has stopped", control::name(cause), name,
                    reason.empty() ? "" : ": " + reason, hardware.group(i)),
        "polyarm hardware recover " + name + ", then start its controllers: polyarm control switch -a NAME",
        Severity::error,
        {{"cause", control::code(cause)}, {"group", hardware.group(i)}}};
    add_component_facts(hardware, i, problem.facts);
    observer_.on_problem(now, problem);
    if (group_faults_.size() < 1000) group_faults_.push_back(problem);  // one that comes and goes
    if (waits_for_others()) recorder_.begin(begin_record(*this, problem), now);
  }
}

void Cell::watch_stops(Nanoseconds now, const control::Snapshot& snapshot) {
  constexpr std::size_t kKept = 1000;
  const bool asked = loop_->supervisor().latch().requested() != realtime::StopKind::none;
  if (snapshot.state == control::RunState::running && !asked) held_by_.reset();
  held_place_.tick(snapshot, joint_places_, jogging_->engaged() || contact_watch_.touching());
  if (snapshot.state == control::RunState::stopping && snapshot.cause == control::StopCause::contact)
    stop_watch_.set_category(loop_->supervisor().contact_stop() == control::ContactStop::cut ? 0 : 1);
  auto stop = stop_watch_.tick(snapshot, robots_, joint_places_);
  if (!stop) return;
  const Problem cause = stop_cause();
  stop->cause = cause.what;
  stop->cause_code = cause.code;
  if (stops_.size() >= kKept) stops_.erase(stops_.begin());
  stops_.push_back(*stop);
  observer_.on_stop(now, *stop);
  recorder_.note_stop(stop->sentence());
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

std::string any_hint(Cell& cell) {
  const std::string hint = hint_of_wait(cell);
  return hint.empty() ? cell.hint_of_live() : hint;
}
}  // namespace

void Cell::watch_for_deadlock(Nanoseconds now, const control::Snapshot& snapshot) {
  constexpr Nanoseconds kLongWait = 3'000'000'000;
  const auto since = program_ && begun_ && !program_->ended() ? program_->waits_since() : std::nullopt;
  if (since && now - *since == kLongWait / kTick * kTick)
    if (const std::string hint = any_hint(*this); !hint.empty() && told_warnings_.insert(hint).second)
      observer_.on_note(program_->status().where.text() + ": " + hint);
  for (const Task* task : {program_.get(), plc_.get()})
    if (is_busy_for(task, now, kBusyPatience) && told_warnings_.insert("busy " + task->name()).second)
      observer_.on_problem(now, problem_of_busy(*task));
  const auto stuck = [now](const Task* task) {
    return !task || task->ended() || is_busy_for(task, now, kEndlessPatience) ||
           (task->status().waiting.kind == program::WaitKind::condition && !task->status().waiting.until);
  };
  const bool quiet = !test_ && !options_.waits && program_ && !program_->ended() && stuck(program_.get()) &&
                     stuck(plc_.get()) && snapshot.standing && snapshot.world.at_rest &&
                     !parts_.anything_moving() && snapshot.state == control::RunState::running &&
                     !files_->has_outside_writers() && !links_->any() && store_.version() == quiet_version_;
  quiet_version_ = store_.version();
  if (!quiet) quiet_since_ = now;
  if (now - quiet_since_ < kDeadlockPatience) return;
  const std::string hint = any_hint(*this);
  std::string waiting = program_->sentence();
  if (plc_ && !plc_->ended()) waiting += "; " + plc_->sentence();
  const bool busy = program_->busy_since().has_value();
  const std::string advice =
      busy ? "end the loop, or let it wait for what it needs" : "check who is to set these tags";
  fail(now, {busy ? "endless-loop" : "deadlock",
             program_->status().where,
             (busy ? "the program goes round without end, and nothing changes what it reads: "
                   : "every task waits, and no clock, link or motion can change what it waits for: ") +
                 waiting,
             hint.empty() ? advice : hint,
             Severity::error,
             {{"waiting", waiting}}});
}

void Cell::watch_end(Nanoseconds now) {
  for (Task* task : {program_.get(), plc_.get()}) {
    if (!task || !task->failed()) continue;
    if (failure_ || told_ended_.contains(task)) continue;
    Problem problem = task->status().problem.value_or(
        Problem{"failed", task->status().where, task->name() + " failed", {}});
    explain_timeout(*this, *task, problem);
    if (!options_.waits) {
      fail(now, problem);
    } else if (told_ended_.insert(task).second) {
      observer_.on_problem(now, problem);
      if (task == program_.get()) end_moves();
    }
  }
  if (const auto lost = files_->take_failure()) fail(now, lost->problems().front());
  if (failure_ || options_.waits) return;
  if (!program_ && !file_.send.empty() && !started_) return;
  if (!program_ && !file_.send.empty()) {  // what was sent has been done
    if (!loop_->outbox().value().standing) ended_at_ = now;
    finished_ = ended_at_ >= 0 && loop_->outbox().value().standing && now - ended_at_ > kSendSettle;
    if (now - arming_->armed_at() > kSettlePatience && ended_at_ < 0) finished_ = true;
    return;
  }
  if (!program_ || !program_->ended()) return;
  if (ended_at_ < 0) ended_at_ = now;
  const bool settled = !parts_.anything_moving() && loop_->outbox().value().standing;
  finished_ = (settled || now - ended_at_ > kSettlePatience) && outputs_settled();
}

}  // namespace polyarm::cell
