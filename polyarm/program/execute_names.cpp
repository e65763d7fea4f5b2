#include <algorithm>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/program/operators.hpp"
#include "polyarm/program/task.hpp"

/// Steps that make, change and fill names.
namespace polyarm::program {

void Interpreter::execute_name(Task& task, const Step& step) {
  switch (step.op) {
    case Op::drop:
      task.stack.pop_back();
      break;
    case Op::check_new:
      if (host_.find(at(code_.texts, step.a)))
        fail_at(step.place, "shadowing", "there is a '" + at(code_.texts, step.a) + "' already",
                "choose another name, or change it with `set`");
      break;
    case Op::let_global:
      if (!task.stack.back().set) pop(task, step.place);
      at(globals_, step.a) = std::move(task.stack.back());
      task.stack.pop_back();
      break;
    case Op::set_local:
    case Op::set_global: {
      Slot& slot = step.op == Op::set_local ? task.local(step.a) : at(globals_, step.a);
      const std::string* origin = task.stack.back().origin;
      Value value = pop(task, step.place);
      if (!slot.set)
        fail_at(step.place, "no-value", "'" + step.statement->name + "' has no value yet",
                "its `let` comes later");
      change(slot.value, std::move(value), step);
      slot.origin = origin;
      break;
    }
    case Op::set_host:
      if (!set_host(task, step)) return;
      break;
    case Op::set_literal:
      set_literal(task, step);
      break;
    case Op::replace:
      replace_part(task, step);
      break;
    case Op::given:
      if (task.local(step.a).set) {
        task.pc = static_cast<std::size_t>(step.c);
        return;
      }
      break;
    default:  // fill
      task.local(step.a) = std::move(task.stack.back());
      task.stack.pop_back();
      break;
  }
  ++task.pc;
}

/// A name keeps its type and unit.
void Interpreter::change(Value& present, Value value, const Step& step) {
  const std::string& name = step.statement->name;
  if (!same_type(present, value))
    fail_at(step.place, "bad-type",
            "'" + name + "' is " + described(present) + " (" + present.text().substr(0, 60) +
                ") and cannot become " + described(value) + " (" + value.text().substr(0, 60) + ")",
            "a name keeps its type and unit");
  present = std::move(value);
}

bool Interpreter::set_host(Task& task, const Step& step) {
  const std::string& name = at(code_.texts, step.a);
  const Value* present = host_.find(name);
  if (!present)
    fail_at(step.place, "unknown-name",
            "there is nothing called '" + name + "'" + did_you_mean(name, host_.names()),
            "write `let " + name + " = …` to make it");
  if (!arrived(task)) return false;
  Value old = *present;
  change(old, pop(task, step.place), step);
  host_.set(name, std::move(old), program_.at(step.line));
  return true;
}

void Interpreter::set_literal(Task& task, const Step& step) {
  const Statement& s = *step.statement;
  if (step.a < 0 && step.b < 0) return host_.set(s.name, s.literal, program_.at(s.place));
  Slot& slot = step.a >= 0 ? task.local(step.a) : at(globals_, step.b);
  slot = {s.literal, nullptr, true};
}

/// The stack holds the whole, the places in lists, and the value that comes in.
void Interpreter::replace_part(Task& task, const Step& step) {
  const Statement& s = *step.statement;
  Value value = pop(task, step.place);
  std::vector<PathStep> path;
  for (const std::string& part : at(code_.name_lists, step.a)) path.push_back({part, {}});
  const auto indices =
      std::count_if(s.path.begin(), s.path.end(), [](const PathPart& p) { return p.index != nullptr; });
  std::size_t next = task.stack.size() - static_cast<std::size_t>(indices);
  const std::size_t first = next;
  for (const PathPart& part : s.path) {
    if (part.index) {
      path.push_back({{}, task.stack[next++].value});
    } else {
      path.push_back({part.field, {}});
    }
  }
  task.stack.resize(first);
  replace(task.stack.back().value, path, std::move(value));
}

}  // namespace polyarm::program
