/// Saves the state of an interpreter and restores it into another one.
#include <algorithm>
#include <utility>

#include "polyarm/vm/task.hpp"

namespace polyarm::program {

namespace {
/// FNV-1a, 64 bits.
void add_to(std::uint64_t& hash, const std::string& text) {
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  hash = (hash ^ 10u) * 1099511628211ull;
}

std::uint64_t fingerprint(const Program& program) {
  std::uint64_t hash = 14695981039346656037ull;
  add_to(hash, "registers 2");  // version of the compiled form: a state of other steps would have another
                                // meaning
  for (const std::string& line : program.lines) add_to(hash, line);
  for (const Program::Included& included : program.included)
    for (const std::string& line : included.lines) add_to(hash, line);
  return hash;
}

SavedSlot saved(const Slot& slot) {
  return {slot.value, slot.origin ? *slot.origin : std::string{}, slot.set};
}
}  // namespace

/// True if no state exists only in this process: no motion, question, file or part of a `together`.
bool Interpreter::safe() const {
  if (outcome_ || !watches_.empty() || !pulses_.empty()) return false;
  return std::all_of(tasks_.begin(), tasks_.end(), [](const auto& task) {
    if (task->frozen || task->interrupts) return false;
    if (task->over()) return task->parent == 0;
    const WaitKind kind = task->waiting.kind;
    const bool alone = kind == WaitKind::none || kind == WaitKind::time || kind == WaitKind::condition ||
                       kind == WaitKind::meet || kind == WaitKind::lock || kind == WaitKind::turn;
    return task->parent == 0 && task->robots.empty() && task->handles.empty() && alone;
  });
}

SavedState Interpreter::save() const {
  SavedState out;
  out.program = fingerprint(program_);
  const auto left = [&](Nanoseconds until) { return std::max<Nanoseconds>(0, until - host_.now()); };
  for (const auto& task : tasks_) {
    SavedTask saved_task;
    saved_task.id = task->id, saved_task.name = task->name;
    saved_task.shown = task->shown, saved_task.apart = task->apart;
    saved_task.met = task->met, saved_task.was_true = task->was_true;
    saved_task.trap = task->trap, saved_task.owner = task->owner, saved_task.sprung = task->sprung;
    saved_task.commanded = task->commanded;
    if (task->next_due) saved_task.next_due = left(*task->next_due);
    saved_task.state = task->state, saved_task.step = task->pc, saved_task.passes = task->passes;
    saved_task.frames = task->frames, saved_task.uses = task->uses;
    saved_task.locks = task->locks, saved_task.handlers = task->handlers;
    saved_task.waits = task->waiting.kind;
    for (const Slot& slot : task->stack) saved_task.stack.push_back(saved(slot));
    if (task->waiting.kind == WaitKind::meet || task->waiting.kind == WaitKind::lock)
      saved_task.waits_at = task->waiting.text;
    if (task->waiting.kind == WaitKind::time) saved_task.waits_for = left(*task->waiting.until);
    if (task->deadline) saved_task.deadline = left(*task->deadline);
    if (task->waiting.kind == WaitKind::condition) {  // it is checked again immediately
      saved_task.step = static_cast<std::size_t>(code_.steps[task->pc].a);
      saved_task.waits = WaitKind::none;
      saved_task.state = TaskState::running;
    }
    out.tasks.push_back(std::move(saved_task));
  }
  for (const Slot& slot : globals_) out.globals.push_back(saved(slot));
  out.meetings = meetings_;
  out.locks = locks_;
  out.last_id = last_id_;
  out.groups = groups_;
  out.random = random_;
  out.clock = host_.now() - began_;
  return out;
}

StartReport Interpreter::restore(const SavedState& from) {
  const auto fits = [&](const SavedTask& task) {
    return task.trap >= -1 && task.trap < static_cast<int>(code_.traps.size()) && task.step < code_.steps.size() && !task.frames.empty() &&
           std::all_of(task.frames.begin(), task.frames.end(),
                       [&](const CallFrame& frame) {
                         return frame.return_to <= code_.steps.size() && frame.base <= task.stack.size() &&
                                frame.uses <= task.uses.size() && frame.locks <= task.locks.size() &&
                                frame.handlers <= task.handlers.size();
                       }) &&
           std::all_of(task.handlers.begin(), task.handlers.end(), [&](const Handler& handler) {
             return handler.step < code_.steps.size() && handler.stack <= task.stack.size() &&
                    handler.frames <= task.frames.size() && handler.uses <= task.uses.size() &&
                    handler.locks <= task.locks.size();
           });
  };
  if (from.program != fingerprint(program_))
    throw Error(Problem{"other-program",
                        {program_.file},
                        "the program has changed since it was interrupted, so it cannot continue there",
                        "begin at a line: --from LINE"});
  if (from.tasks.empty() || from.globals.size() != globals_.size() ||
      !std::all_of(from.tasks.begin(), from.tasks.end(), fits))
    throw Error(Problem{"bad-state",
                        {program_.file},
                        "what was written of the program's state is damaged",
                        "begin at a line: --from LINE"});
  const auto slot_of = [&](const SavedSlot& slot) {
    const std::string* origin = nullptr;
    if (!slot.origin.empty()) origin = &origins_.emplace_back(slot.origin);
    return Slot{slot.value, origin, slot.set};
  };
  tasks_.clear();
  for (const SavedTask& each : from.tasks) {
    Task& task = add_task(each.name, static_cast<int>(each.step), each.shown);
    task.id = each.id;
    task.apart = each.apart, task.met = each.met, task.was_true = each.was_true;
    task.trap = each.trap, task.owner = each.owner, task.sprung = each.sprung;
    task.commanded = each.commanded;
    if (each.next_due) task.next_due = host_.now() + *each.next_due;
    task.state = each.state;
    task.frames = each.frames;
    task.stack.clear();
    for (const SavedSlot& slot : each.stack) task.stack.push_back(slot_of(slot));
    const std::size_t needed = task.frame().base + static_cast<std::size_t>(code_.registers);
    if (task.stack.size() < needed) task.stack.resize(needed);
    task.uses = each.uses;
    task.locks = each.locks;
    task.handlers = each.handlers;
    task.passes = each.passes;
    // It has passed the step of a timed wait, and waits in it.
    task.line = code_.sources[task.pc - (each.waits == WaitKind::time && task.pc > 0 ? 1 : 0)].line;
    task.waiting = {each.waits, {}, {}, each.waits_at};
    if (each.waits_for) task.waiting.until = host_.now() + *each.waits_for;
    if (each.deadline) task.deadline = host_.now() + *each.deadline;
  }
  for (std::size_t i = 0; i < globals_.size(); ++i) globals_[i] = slot_of(from.globals[i]);
  meetings_ = from.meetings;
  locks_ = from.locks;
  last_id_ = from.last_id;
  groups_ = from.groups;
  random_ = from.random;
  began_ = host_.now() - from.clock;
  const TaskStatus now = overview();
  StartReport out{now.where, {}, {}, {}, {}, {}, {}};
  const MoveDefaults use = uses(now.name);
  out.robot = use.robot, out.tool = use.tool, out.frame = use.frame;
  return out;
}

MoveDefaults Interpreter::uses(const std::string& name) const {
  for (const auto& task : tasks_)
    if (task->name == name && !task->uses.empty()) return task->uses.back();
  return {};
}

}  // namespace polyarm::program
