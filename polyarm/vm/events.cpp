/// Traps, timers and pulses: what happens beside the lines of a task.
#include <algorithm>
#include <limits>

#include "polyarm/language/operators.hpp"
#include "polyarm/vm/task.hpp"

namespace polyarm::program {

/// From this line on the condition of a trap, or the time of an `every`, is looked at in every tick.
void Interpreter::begin_event(Task& task, const Step& step) {
  const bool traps = step.op == Op::begin_trap;
  const std::uint64_t id = task.id;
  const std::vector<MoveDefaults> uses = task.uses;
  Task& event = add_task(traps ? "trap" : "every", at(traps ? code_.traps : code_.timers, step.a).entry, false);
  event.apart = true;
  event.uses = uses;
  event.frames.front().uses = uses.size();
  if (traps) {
    event.trap = step.a;
    event.owner = id;
  }
  wait_for(event, WaitKind::turn);
}

/// True if the task, or the task that it is a part of, is interrupted by a trap.
bool Interpreter::is_frozen(const Task& task) const {
  if (task.frozen) return true;
  const Task* parent = task.parent ? task_of(task.parent) : nullptr;
  return parent && is_frozen(*parent);
}

/// One trap at a time interrupts a task. Others wait until it has ended, in the order of their lines.
void Interpreter::spring_traps() {
  for (std::size_t i = 0; i < tasks_.size() && !outcome_; ++i) {
    Task& watcher = *tasks_[i];
    if (!watcher.sprung) continue;
    Task* const owner = task_of(watcher.owner);
    if (!owner || owner->over()) {
      watcher.sprung = false;
    } else if (!owner->frozen && !paused_) {
      interrupt(watcher, *owner);
    }
  }
}

void Interpreter::interrupt(Task& watcher, Task& owner) {
  watcher.sprung = false;
  const std::vector<MoveDefaults> uses = watcher.uses;
  const int body = at(code_.traps, watcher.trap).body;
  Task& block = add_task("trap", body, true);
  block.interrupts = owner.id;
  block.line = at(code_.sources, body).line;
  block.uses = uses;
  block.frames.front().uses = block.uses.size();
  if (!code_.tasks.empty()) collect_robots(owner, block.stopped_robots);
  owner.frozen = block.id;
  const bool moves_any = code_.tasks.empty() || !block.stopped_robots.empty();
  if (!moves_any) return;
  block.handles = {host_.suspend(block.stopped_robots)};
  wait_for(block, WaitKind::move, "its stop");
}

/// The robots that a task and its parts have moved.
void Interpreter::collect_robots(const Task& task, std::vector<std::string>& out) const {
  for (const std::string& robot : task.commanded)
    if (std::find(out.begin(), out.end(), robot) == out.end()) out.push_back(robot);
  for (const auto& other : tasks_)
    if (other->parent == task.id) collect_robots(*other, out);
}

/// At the end of a trap: the robots return to where they were stopped, and the task goes on.
bool Interpreter::gone_back(Task& task) {
  if (!task.interrupts) return true;
  const bool stopped_any = code_.tasks.empty() || !task.stopped_robots.empty();
  if (stopped_any && !task.goes_back) {
    task.goes_back = true;
    task.handles = {host_.resume(task.stopped_robots)};
    wait_for(task, WaitKind::move, "its place");
    return false;
  }
  if (Task* const owner = task_of(task.interrupts)) owner->frozen = 0;
  if (stepping_ && stepping_->task == task.id)  // whoever steps through the block goes on stepping behind it
    stepping_ = Stepping{task.interrupts, std::numeric_limits<std::size_t>::max()};
  return true;
}

/// True each time the period has passed. A run that was missed is not made up for.
bool Interpreter::is_due(Task& task, const Step& step) {
  const Nanoseconds period = time(take_value(task, step.b, step), source(step).place, false);
  if (period <= 0) fail_at(source(step).place, "bad-value", "'every' needs a time above zero");
  const Nanoseconds now = host_.now();
  if (!task.next_due) task.next_due = now + period;
  if (now < *task.next_due) return false;
  task.next_due = *task.next_due + period > now ? *task.next_due + period : now + period;
  return true;
}

void Interpreter::pulse(Task& task, const Step& step) {
  const std::string& name = at(code_.texts, step.a);
  const Nanoseconds length = time(take_value(task, step.b, step), source(step).place, false);
  const Value* present = host_.find(name);
  if (!present || !present->as_boolean())
    fail_at(source(step).place, "bad-type",
            present ? "'" + name + "' is " + described(*present) + ", and a pulse sets a boolean"
                    : "there is nothing called '" + name + "'");
  const Location where = program_.at(source(step).line);
  host_.set(name, true, where);
  std::erase_if(pulses_, [&](const Pulse& other) { return other.name == name; });
  pulses_.push_back({name, host_.now() + length, where});
}

std::optional<Nanoseconds> Interpreter::next_pulse_end() const {
  std::optional<Nanoseconds> out;
  for (const Pulse& pulse : pulses_) out = std::min(out.value_or(pulse.until), pulse.until);
  return out;
}

void Interpreter::end_pulses() {
  for (std::size_t i = 0; i < pulses_.size();) {
    if (host_.now() < pulses_[i].until) {
      ++i;
      continue;
    }
    const Pulse over = pulses_[i];
    pulses_.erase(pulses_.begin() + static_cast<std::ptrdiff_t>(i));
    host_.set(over.name, false, over.where);
  }
}

}  // namespace polyarm::program
