#include <algorithm>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/program/operators.hpp"
#include "polyarm/program/task.hpp"

namespace polyarm::program {

using data::Number;

namespace {
struct Refused {
  Place place;
  std::string what, advice;
};

/// A number of one of `dimensions`; a share of all there is has none.
Number quantity(const Value& value, const Clause& clause, std::initializer_list<Dimension> dimensions,
                const char* such_as) {
  const std::string word = spelling(clause.kind);
  const Number* n = value.as_number();
  const bool fits = n && std::find(dimensions.begin(), dimensions.end(), n->dimension) != dimensions.end();
  if (!fits)
    throw Refused{clause.value->place,
                  "'" + word + "' cannot be " + described(value) + " (" + value.text().substr(0, 40) + ")",
                  std::string("write such as ") + such_as};
  if (n->value < 0 || (n->value == 0 && clause.kind != Clause::Kind::blend))
    throw Refused{
        clause.value->place, "'" + word + "' has to be more than nothing, here is " + value.text(), {}};
  if (n->dimension == Dimension::none && n->value > 1)
    throw Refused{clause.value->place,
                  "'" + word + "' as a share of what the robot can is at most 100%, here is " + value.text(),
                  std::string("with a unit write such as ") + such_as};
  return *n;
}

std::string name_in(const Value& value, const Clause& clause) {
  if (value.as_text()) return *value.as_text();
  throw Refused{clause.value->place,
                std::string("'") + spelling(clause.kind) + "' takes a name, here is " + described(value),
                {}};
}

/// What a clause says, in a move or for all that follow.
template <typename Target>
void take(Target& out, const Clause& clause, const Value& value) {
  using Kinds = Clause::Kind;
  switch (clause.kind) {
    case Kinds::robot:
      out.robot = name_in(value, clause);
      break;
    case Kinds::tool:
      out.tool = name_in(value, clause);
      break;
    case Kinds::frame:
      out.frame_pose.reset();
      if (value.as_point()) out.frame_pose = value.as_point()->pose;
      out.frame = value.as_point() ? spelled(*clause.value) : name_in(value, clause);
      break;
    case Kinds::speed:
      out.speed = quantity(value, clause, {Dimension::speed, Dimension::angular_speed, Dimension::none},
                           "500mm/s, 30deg/s or 50%");
      break;
    case Kinds::accel:
      out.accel =
          quantity(value, clause, {Dimension::acceleration, Dimension::angular_acceleration, Dimension::none},
                   "2m/s2, 200deg/s2 or 50%");
      break;
    case Kinds::blend:
      out.blend = quantity(value, clause, {Dimension::length}, "20mm");
      break;
    default:
      break;
  }
}

bool takes_value(const Clause& clause) {
  return clause.kind != Clause::Kind::exact && clause.kind != Clause::Kind::smooth &&
         clause.kind != Clause::Kind::until && clause.kind != Clause::Kind::at;
}
std::size_t values_of(const Clause& clause) {
  if (clause.kind == Clause::Kind::at) return clause.value ? 2 : 1;
  return takes_value(clause) ? 1 : 0;
}

std::size_t values_of(const Statement& s) {
  std::size_t out = s.arguments.size();
  for (const Clause& clause : s.clauses) out += values_of(clause);
  return out;
}

void add_targets(Move& move, const Slot& slot, const Expression& e, bool may_be_list) {
  const bool named = e.kind == Expression::Kind::name && slot.origin;
  const std::string called = named ? *slot.origin : spelled(e);
  if (slot.value.is_place()) return move.targets.push_back({slot.value, called});
  const data::List* list = slot.value.as_list();
  if (!list || !may_be_list)
    throw Refused{e.place, "'" + called + "' is " + described(slot.value) + ", a point was expected",
                  "a move goes to a joint state or a pose"};
  if (list->empty()) throw Refused{e.place, "there is no point in this list", {}};
  for (std::size_t i = 0; i < list->size(); ++i) {
    const bool written = e.kind == Expression::Kind::list && i < e.parts.size();
    const std::string each = written ? spelled(*e.parts[i]) : called + "[" + std::to_string(i + 1) + "]";
    if (!(*list)[i].is_place())
      throw Refused{e.place, "'" + each + "' is " + described((*list)[i]) + ", a point was expected",
                    "a path is a list of joint states and poses"};
    move.targets.push_back({(*list)[i], each});
  }
}
}  // namespace

/// The points and clauses lie on the stack from `first` on.
Move Interpreter::asked_move(Task& task, const Step& step, std::size_t first) const {
  using Motion = Statement::Motion;
  const Statement& s = *step.statement;
  const MoveDefaults use = task.uses.empty() ? MoveDefaults{} : task.uses.back();
  Move out;
  out.kind = s.motion == Motion::movel   ? Move::Kind::line
             : s.motion == Motion::movec ? Move::Kind::arc
                                         : Move::Kind::joint;
  out.speed = use.speed, out.accel = use.accel, out.blend = use.blend;
  out.robot = use.robot, out.tool = use.tool, out.frame = use.frame, out.frame_pose = use.frame_pose;
  for (const ExpressionPtr& point : s.arguments) {
    add_targets(out, task.stack[first++], *point, s.motion == Motion::movej || s.motion == Motion::movel);
  }
  bool exact = use.exact, blends = false;
  for (const Clause& clause : s.clauses) {
    exact = exact || clause.kind == Clause::Kind::exact;
    blends = blends || clause.kind == Clause::Kind::blend;
    out.smooth = out.smooth || clause.kind == Clause::Kind::smooth;
    out.waits = out.waits || clause.kind == Clause::Kind::until;
    if (clause.kind == Clause::Kind::duration)
      out.duration = quantity(task.stack[first].value, clause, {Dimension::time}, "2s");
    if (takes_value(clause)) take(out, clause, task.stack[first].value);
    first += values_of(clause);
  }
  out.step = task.step;
  const bool thesis = s.motion == Motion::moveto;
  out.waits = out.waits || thesis;
  const bool said = std::any_of(s.clauses.begin(), s.clauses.end(),
                                [](const Clause& c) { return c.kind == Clause::Kind::exact; });
  out.exact = thesis || out.waits || !out.blend || said || (exact && !blends);
  return out;
}

/// What the move is to set on its way is there and of the type of the value.
void Interpreter::check_targets(const Task& task, const Step& step, std::size_t next) const {
  for (const Clause& clause : step.statement->clauses) {
    next += values_of(clause);
    if (clause.kind != Clause::Kind::at) continue;
    const Value* present = host_.find(clause.target);
    if (!present)
      fail_at(clause.place, "unknown-name",
              "there is nothing called '" + clause.target + "'" + did_you_mean(clause.target, host_.names()),
              {});
    if (!same_type(*present, task.stack[next - 1].value))
      fail_at(clause.place, "bad-type",
              "'" + clause.target + "' is " + described(*present) + " and cannot become " +
                  described(task.stack[next - 1].value),
              {});
  }
}

void Interpreter::move(Task& task, const Step& step) {
  const Statement& s = *step.statement;
  if (task.apart) wait_for(task, WaitKind::move);
  const std::size_t first = task.stack.size() - values_of(s);
  require_values(task, step, values_of(s));
  check_targets(task, step, first + s.arguments.size());
  Move move;
  try {
    move = asked_move(task, step, first);
  } catch (const Refused& refused) {
    fail_at(refused.place, "bad-type", refused.what, refused.advice);
  }
  if (!host_.room_for_move(move.robot)) return wait_for(task, WaitKind::room, move.robot);
  const Handle handle = host_.start_move(move, program_.at(step.line));
  std::size_t next = first + s.arguments.size();
  for (const Clause& clause : s.clauses) {
    if (clause.kind == Clause::Kind::at) {
      const Value& offset = task.stack[next].value;
      std::optional<Number> away;
      if (clause.value && offset.as_number()) away = *offset.as_number();
      watches_.push_back({task.id, handle, &clause, away, task.stack[next + values_of(clause) - 1].value,
                          program_.at(clause.place)});
    }
    next += values_of(clause);
  }
  task.stack.resize(first);
  ++task.pc;
  if (!move.waits) {
    if (std::find(task.robots.begin(), task.robots.end(), move.robot) == task.robots.end())
      task.robots.push_back(move.robot);
    return;
  }
  std::erase(task.robots, move.robot);  // what it had queued arrives before this
  task.handles = {handle};
  const bool looks = std::any_of(s.clauses.begin(), s.clauses.end(),
                                 [](const Clause& c) { return c.kind == Clause::Kind::until; });
  if (!looks) wait_for(task, WaitKind::move, move.targets.back().name);
}

void Interpreter::use(Task& task, const Step& step) {
  const Statement& s = *step.statement;
  const std::size_t first = task.stack.size() - values_of(s);
  require_values(task, step, values_of(s));
  MoveDefaults out = task.uses.empty() ? MoveDefaults{} : task.uses.back();
  std::size_t next = first;
  try {
    for (const Clause& clause : s.clauses) {
      if (clause.kind == Clause::Kind::exact) out.exact = true;
      if (clause.kind == Clause::Kind::blend) out.exact = false;
      if (takes_value(clause)) take(out, clause, task.stack[next].value);
      next += values_of(clause);
    }
  } catch (const Refused& refused) {
    fail_at(refused.place, "bad-type", refused.what, refused.advice);
  }
  task.stack.resize(first);
  task.uses.push_back(std::move(out));
  ++task.pc;
}

/// Sets what moves are to set on their way.
void Interpreter::look_at_watches() {
  for (std::size_t i = 0; i < watches_.size() && !outcome_;) {
    const Watch watch = watches_[i];
    bool reached = false;
    try {
      const Travel travel = host_.travel(watch.handle);
      const bool end = watch.clause->from_end;
      const double away = watch.offset ? watch.offset->value : 0;
      if (watch.offset && watch.offset->dimension == Dimension::time) {
        const Nanoseconds limit = nanoseconds(away);
        reached = end ? travel.left <= limit : travel.elapsed >= limit;
      } else {
        reached = end ? travel.left_m <= away && (away > 0 || travel.left == 0)
                      : travel.covered_m >= away && travel.elapsed > 0;
      }
      if (reached) host_.set(watch.clause->target, watch.value, watch.where);
    } catch (const Error& error) {
      watches_.erase(watches_.begin() + static_cast<std::ptrdiff_t>(i));
      Task* task = task_of(watch.task);
      if (task && !task->over()) raise(*task, error.problems().front(), true);
      continue;
    }
    if (reached) {
      watches_.erase(watches_.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

// The world.

void Interpreter::execute_world(Task& task, const Step& step) {
  const Statement& s = *step.statement;
  switch (step.op) {
    case Op::arrive:
      if (!arrived(task)) return;
      break;
    case Op::load: {
      if (!arrived(task)) return;
      const LoadForm form = s.kind == Statement::Kind::import ? LoadForm::import : LoadForm::load;
      wait_for(task, WaitKind::load, s.name);
      task.handles = {host_.start_load(s.name, form, program_.at(s.place))};
      break;
    }
    case Op::move:
      return move(task, step);
    case Op::use:
      return use(task, step);
    case Op::until:
      return until_step(task, step);
    case Op::deadline:
      task.deadline = host_.now() + time(pop(task, step.place), step.place, false);
      break;
    case Op::wait:
      return wait_step(task, step);
    case Op::wait_time: {
      const Nanoseconds until = host_.now() + time(pop(task, step.place), step.place, true);
      wait_for(task, WaitKind::time);
      task.waiting.until = until;
      break;
    }
    case Op::ask:
      return ask(task, step);
    case Op::log: {
      std::string text;
      require_values(task, step, static_cast<std::size_t>(step.a));
      const std::size_t first = task.stack.size() - static_cast<std::size_t>(step.a);
      for (std::size_t i = first; i < task.stack.size(); ++i)
        text += (i > first ? " " : "") + task.stack[i].value.text();
      task.stack.resize(first);
      host_.log(text, program_.at(step.line));
      break;
    }
    case Op::hold: {
      if (task.apart) wait_for(task, WaitKind::user);
      if (!arrived(task)) return;
      const std::string reason = step.a > 0 ? pop(task, step.place).text() : "the program holds";
      ++task.pc;
      return host_.hold(reason, program_.at(step.line));
    }
    case Op::meet:
      return meet(task, step);
    default:
      return lock(task, step);
  }
  ++task.pc;
}

/// A number is a time to wait, a boolean a condition to wait for.
void Interpreter::wait_step(Task& task, const Step& step) {
  const Value value = pop(task, step.place);
  if (value.as_number() && step.statement->kind == Statement::Kind::wait) {
    if (task.deadline) fail_at(step.statement->second->place, "bad-type", "a wait for a time has no timeout");
    const Nanoseconds until = host_.now() + time(value, step.place, false);
    wait_for(task, WaitKind::time);
    task.waiting.until = until;
    ++task.pc;
    return;
  }
  const bool* truth = value.as_boolean();
  if (!truth)
    fail_at(step.place, "bad-type",
            std::string("the condition of 'wait' is ") + data::name(value.kind()) + " (" +
                value.text().substr(0, 60) + "), True or False was expected");
  if (!*truth) {
    begin_look(task, step, WaitKind::condition);
    if (deadline_passed(task)) time_out(task);
    return;
  }
  task.deadline.reset();
  ++task.pc;
}

/// True: the move ends here. At its end without that the block behind `else` is done.
void Interpreter::until_step(Task& task, const Step& step) {
  if (pop_boolean(task, step, "until")) {
    host_.end_move(task.handles.back(), program_.at(step.line));
    wait_for(task, WaitKind::move, "its end");
    ++task.pc;
    return;
  }
  begin_look(task, step, WaitKind::until);
  const std::vector<Handle> handles = task.handles;
  const WaitKind kind = std::exchange(task.waiting.kind, WaitKind::move);
  if (!poll_handles(task)) {
    task.handles = handles;
    task.waiting.kind = kind;
    return;
  }
  task.pc = step.c >= 0 ? static_cast<std::size_t>(step.c) : task.pc + 1;
}

void Interpreter::ask(Task& task, const Step& step) {
  const Statement& s = *step.statement;
  if (step.a >= 0 && host_.find(s.second->name)) {
    task.stack.pop_back();
    task.pc = static_cast<std::size_t>(step.a);
    return;
  }
  if (!arrived(task)) return;
  const std::string text = pop(task, step.place).text();
  wait_for(task, WaitKind::user, text);
  task.handles = {host_.start_ask(text, program_.at(s.place))};
  ++task.pc;
}

// Tasks and one another.

/// Passed when as many tasks have come as mention it.
void Interpreter::meet(Task& task, const Step& step) {
  const std::string& name = code_.texts[static_cast<std::size_t>(step.a)];
  const auto parties = code_.meetings.find(name);
  if (parties == code_.meetings.end() || parties->second < 2)
    fail_at(step.place, "no-meeting", "no other task comes to '" + name + "'",
            "`meet` stands in two or more tasks");
  auto& come = meetings_[name];
  come.push_back(task.id);
  if (come.size() < static_cast<std::size_t>(parties->second)) {
    wait_for(task, WaitKind::meet, name);
    task.waiting.until = task.deadline;
    return;
  }
  for (const std::uint64_t id : come)
    if (Task* other = task_of(id)) other->met = true;
  come.clear();
  task.met = false;
  task.deadline.reset();
  ++task.pc;
}

void Interpreter::lock(Task& task, const Step& step) {
  const std::string& name = code_.texts[static_cast<std::size_t>(step.a)];
  const auto owner = locks_.find(name);
  if (owner != locks_.end() && owner->second == task.id)
    fail_at(step.place, "locked", "this task has '" + name + "' already", {});
  if (owner != locks_.end()) {
    wait_for(task, WaitKind::lock, name);
    task.waiting.until = task.deadline;
    return;
  }
  locks_[name] = task.id;
  task.locks.push_back(name);
  task.deadline.reset();
  ++task.pc;
}

/// Each statement of the block begins at once, with the names there are now.
void Interpreter::together(Task& task, const Step& step) {
  if (!arrived(task)) return;
  const auto& entries = code_.entries[static_cast<std::size_t>(step.a)];
  const CallFrame frame = task.frame();
  for (const int entry : entries) {
    Task& child = add_task(task.name, entry, false);
    child.parent = task.id;
    child.stack.assign(task.stack.begin() + static_cast<std::ptrdiff_t>(frame.base), task.stack.end());
    child.uses = task.uses;
    child.frames.front().uses = child.uses.size();
    if (step.b) child.step = {groups_ + 1, entries.size()};
  }
  if (step.b) ++groups_;
  ++task.pc;
  wait_for(task, WaitKind::together);
}

}  // namespace polyarm::program
