#include <algorithm>
#include <set>

#include "polyarm/base/text.hpp"
#include "polyarm/vm/task.hpp"

namespace polyarm::program {

namespace {
/// At a lock or meeting, without a timeout.
bool waits_at(const auto& task) {
  return (task.waiting.kind == WaitKind::meet || task.waiting.kind == WaitKind::lock) && !task.deadline;
}

bool contains(const auto& values, const auto& value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}
}  // namespace

bool Interpreter::waits_for_others() const {
  return std::all_of(tasks_.begin(), tasks_.end(), [](const auto& task) {
    const Waiting& waiting = task->waiting;
    if (task->over() || task->frozen || waiting.kind == WaitKind::turn) return true;
    if (task->state != TaskState::waiting) return false;
    const bool for_data = waiting.kind == WaitKind::condition && !task->deadline;
    return for_data || waits_at(*task) || waiting.kind == WaitKind::together;
  });
}

/// Fails if some tasks can never continue, whatever the others do: they wait for locks and meetings that only
/// they themselves, or tasks that have ended, could provide.
void Interpreter::fail_for_deadlock() {
  const std::vector<const Task*> stuck = tasks_in_deadlock();
  if (stuck.empty()) return;
  std::vector<std::string> reasons;
  bool at_lock = false;
  for (const Task* task : stuck) {
    if (task->waiting.kind == WaitKind::together || task->frozen) continue;
    reasons.push_back(why_stuck(*task));
    at_lock = at_lock || task->waiting.kind == WaitKind::lock;
  }
  auto top = std::find_if(stuck.begin(), stuck.end(),
                          [](const Task* task) { return !task->parent && !task->frozen; });
  if (top == stuck.end()) top = stuck.begin();
  const std::string waiting = join(reasons, "; ");
  Problem problem{"deadlock",
                  program_.at(place_of(**top)),
                  "tasks wait for each other without end: " + waiting,
                  at_lock ? "let all tasks take locks in the same order, or give the wait a `timeout`"
                          : "let each task come to the meeting as often as the others, or give `meet` a `timeout`",
                  Severity::error,
                  {{"waiting", waiting}}};
  raise(*task_of((*top)->id), std::move(problem), false);
}

/// The largest set of waiting tasks none of which goes on unless another one of the set does.
std::vector<const Interpreter::Task*> Interpreter::tasks_in_deadlock() const {
  std::vector<const Task*> stuck;
  bool any = false;
  for (const auto& task : tasks_) {
    if (task->frozen && !task->over()) {
      stuck.push_back(task.get());
      continue;
    }
    if (task->state != TaskState::waiting) continue;
    any = any || waits_at(*task);
    if (waits_at(*task) || task->waiting.kind == WaitKind::together) stuck.push_back(task.get());
  }
  if (!any) return {};
  for (std::size_t before = stuck.size() + 1; before != stuck.size();) {
    before = stuck.size();
    std::erase_if(stuck, [&](const Task* task) { return keeps_going(*task, stuck); });
  }
  return stuck;
}

/// True if the task may continue although the `stuck` ones do not. An error in one part of a `together` ends
/// its other parts.
bool Interpreter::keeps_going(const Task& task, const std::vector<const Task*>& stuck) const {
  if (task.parent && !contains(stuck, task_of(task.parent))) return true;
  if (task.frozen) return !contains(stuck, task_of(task.frozen));
  const auto may_act = [&](const auto& other) { return !other->over() && !contains(stuck, other.get()); };
  if (task.waiting.kind == WaitKind::lock) {
    const auto owner = locks_.find(task.waiting.text);
    return owner == locks_.end() || !contains(stuck, task_of(owner->second));
  }
  if (task.waiting.kind == WaitKind::meet) {
    const std::vector<std::string>& parties = code_.meetings.at(task.waiting.text);
    const auto come = meetings_.find(task.waiting.text);
    const auto may_come = std::count_if(tasks_.begin(), tasks_.end(), [&](const auto& other) {
      return may_act(other) && contains(parties, other->name);
    });
    return task.met || come == meetings_.end() ||
           come->second.size() + static_cast<std::size_t>(may_come) >= parties.size();
  }
  std::size_t parts = 0;
  for (const auto& other : tasks_) {
    if (other->parent != task.id || other->over()) continue;
    if (may_act(other)) return true;
    ++parts;
  }
  return parts == 0;
}

/// "'a' waits in line 5 for the lock 'm', which 'b' has"
std::string Interpreter::why_stuck(const Task& task) const {
  const std::string& name = task.waiting.text;
  const std::string begin =
      "'" + task.name + "' waits in line " + std::to_string(program_.at(place_of(task)).line);
  if (task.waiting.kind == WaitKind::lock) {
    const auto owner = locks_.find(name);
    const Task* has = owner == locks_.end() ? nullptr : task_of(owner->second);
    return begin + " for the lock '" + name + "'" + (has ? ", which '" + has->name + "' has" + (has->frozen ? ", and it is interrupted by a trap" : "")
                    : "");
  }
  std::set<std::string> missing(code_.meetings.at(name).begin(), code_.meetings.at(name).end());
  std::vector<std::string> ended, others;
  const auto come = meetings_.find(name);
  for (const auto& other : tasks_) {
    if (come != meetings_.end() && contains(come->second, other->id)) missing.erase(other->name);
    if (other->over() && missing.contains(other->name)) ended.push_back("'" + other->name + "' has ended");
  }
  for (const std::string& other : missing) others.push_back("'" + other + "'");
  return begin + " at the meeting '" + name + "'" +
         (ended.empty() ? " for " + join(others, ", ") : "; " + join(ended, ", ") + " and does not come");
}

}  // namespace polyarm::program
