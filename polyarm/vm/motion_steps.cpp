#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/language/operators.hpp"
#include "polyarm/language/statement_parser.hpp"
#include "polyarm/vm/task.hpp"
#include "polyarm/program/percent.hpp"

namespace polyarm::program {

using data::Number;

namespace {
struct Refused {
  Place place;
  std::string what, advice;
};

/// A number with one of `dimensions`; a fraction has none.
Number quantity(const Value& value, const Clause& clause, std::initializer_list<Dimension> dimensions,
                const char* such_as) {
  const std::string word = spelling(clause.kind);
  const Number* n = value.as_number();
  const bool fits = n && std::find(dimensions.begin(), dimensions.end(), n->dimension) != dimensions.end();
  if (!fits)
    throw Refused{clause.value->place,
                  "'" + word + "' cannot be " + described(value) + " (" + value.excerpt(40) + ")",
                  std::string("write such as ") + such_as};
  if (n->value < 0 ||
      (n->value == 0 && clause.kind != Clause::Kind::blend && clause.kind != Clause::Kind::payload))
    throw Refused{clause.value->place, "'" + word + "' must be above 0, here is " + value.text(), {}};
  if (n->dimension == Dimension::none && n->value > 1)
    throw Refused{clause.value->place,
                  "'" + word + "' as a percentage is at most 100%, here it is " + percent(n->value),
                  std::string("with a unit write such as ") + such_as};
  return *n;
}

std::string name_in(const Value& value, const Clause& clause) {
  if (value.as_text()) return *value.as_text();
  throw Refused{clause.value->place,
                std::string("'") + spelling(clause.kind) + "' takes a name, here is " + described(value),
                {}};
}

bool boolean_in(const Value& value, const Clause& clause) {
  if (const bool* out = value.as_boolean()) return *out;
  throw Refused{
      clause.value->place,
      std::string("'") + spelling(clause.kind) + "' takes true or false, here is " + described(value),
      std::string("write `") + spelling(clause.kind) + " true`"};
}

/// Applies a clause, of a move or for all following moves.
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
      out.pose_in.clear();
      if (const data::Point* point = value.as_point()) {
        out.frame_pose = point->pose;
        if (point->frame() != "world") out.pose_in = point->frame();
      }
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
    case Kinds::payload:
      out.payload = quantity(value, clause, {Dimension::mass}, "2kg");
      break;
    case Kinds::blend:
      out.blend = quantity(value, clause, {Dimension::length}, "20mm");
      break;
    case Kinds::around:
      out.around = boolean_in(value, clause);
      break;
    default:
      break;
  }
}

data::JointState near_of(const Value& value, const Clause& clause) {
  if (value.as_joints()) return *value.as_joints();
  throw Refused{clause.value->place, "'near' takes a joint state, here is " + described(value),
                "write such as `near Home`, or `near joints(0deg, -90deg, …)`"};
}

bool takes_value(const Clause& clause) {
  return has_value(clause.kind) && clause.kind != Clause::Kind::until && clause.kind != Clause::Kind::at;
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
                    (*list)[i].as_number()
                        ? "joint values are written joints(0deg, -90deg, …); a path is a list of places"
                        : "a path is a list of joint states and poses"};
    move.targets.push_back({(*list)[i], each});
  }
}

constexpr const char* kAxes[] = {"x", "y", "z", "rx", "ry", "rz"};

/// The way of a speedj or speedl in `time` s: velocities become lengths and angles; its speed is the largest
/// of them, or that of the TCP.
void take_velocities(Move& move, const Value& value, const Expression& e, Statement::Motion motion,
                     double time) {
  const std::string word = spelling(motion);
  const bool line = motion == Statement::Motion::speedl;
  const auto refuse = [&](const std::string& what) {
    return Refused{e.place, what, speed_move_advice(motion)};
  };
  const data::Record* record = value.as_record();
  if (!record) throw refuse("'" + word + "' takes a record of velocities, here is " + described(value));
  data::Record by;
  double linear = 0, angular = 0;
  for (std::size_t i = 0; i < record->names.size(); ++i) {
    const std::string& name = record->names[i];
    const Number* v = record->values[i].as_number();
    const auto axis = std::find(std::begin(kAxes), std::end(kAxes), name);
    if (line && axis == std::end(kAxes)) throw refuse("'" + name + "' is not one of x, y, z, rx, ry and rz");
    const bool turns = line ? axis - std::begin(kAxes) >= 3 : v && v->dimension == Dimension::angular_speed;
    const bool fits = v && (v->dimension == (turns ? Dimension::angular_speed : Dimension::speed) ||
                            (v->value == 0 && v->dimension == Dimension::none));
    if (!fits)
      throw refuse("'" + name + "' is " + described(record->values[i]) + ", " +
                   (turns || !line ? "an angular speed" : "a speed") + " was expected");
    if (v->value == 0) continue;
    double& sum = turns ? angular : linear;
    sum = line ? std::hypot(sum, v->value) : std::max(sum, std::abs(v->value));
    by.names.push_back(name);
    by.values.emplace_back(Number{v->value * time, turns ? Dimension::angle : Dimension::length});
  }
  if (by.names.empty()) throw refuse("'" + word + "' has no velocity: it would go nowhere");
  if (line && linear > 0)
    move.speed = Number{linear, Dimension::speed};
  else
    move.speed = Number{std::max(linear, angular), Dimension::angular_speed};
  move.targets.push_back({std::move(by), word + " " + spelled(e)});
}
}  // namespace

/// The points and clauses are on the stack from `first` on.
Move Interpreter::requested_move(Task& task, const Step& step, std::size_t first) const {
  using Motion = Statement::Motion;
  const Statement& s = *source(step).statement;
  const MoveDefaults use = task.uses.empty() ? MoveDefaults{} : task.uses.back();
  Move out;
  out.kind = s.motion == Motion::movec                                 ? Move::Kind::arc
             : s.motion == Motion::movel || s.motion == Motion::speedl ? Move::Kind::line
                                                                       : Move::Kind::joint;
  out.speed = use.speed, out.accel = use.accel, out.blend = use.blend, out.payload = use.payload;
  out.around = use.around;
  out.robot = use.robot, out.tool = use.tool, out.frame = use.frame;
  out.frame_pose = use.frame_pose, out.pose_in = use.pose_in;
  if (s.moves_base()) {
    const bool turns = s.motion == Motion::turn;
    const Slot& amount = task.stack[first++];
    const Number* number = amount.value.as_number();
    const bool to_pose = !turns && amount.value.as_point();
    if (!to_pose && (!number || number->dimension != (turns ? Dimension::angle : Dimension::length)))
      throw Refused{s.arguments.front()->place,
                    std::string("'") + (turns ? "turn" : "drive") + "' takes " +
                        (turns ? "an angle" : "a length or a pose") + ", here is " + described(amount.value),
                    turns ? "write `turn 90deg`, to the left"
                          : "write `drive 500mm`, or `drive pose(2m, 1m, rz = 90deg)`"};
    out.kind = turns ? Move::Kind::turn : Move::Kind::drive;
    out.targets.push_back({amount.value, (turns ? "turn " : "drive ") + spelled(*s.arguments.front())});
  }
  const bool at_speed = s.moves_at_speed();
  const std::size_t velocities = first;
  if (at_speed) ++first, out.blend.reset();
  for (const ExpressionPtr& point : s.arguments) {
    if (s.moves_base() || at_speed) break;
    add_targets(out, task.stack[first++], *point, s.motion == Motion::movej || s.motion == Motion::movel);
  }
  bool exact = use.exact, blends = false;
  for (const Clause& clause : s.clauses) {
    exact = exact || clause.kind == Clause::Kind::exact;
    blends = blends || clause.kind == Clause::Kind::blend;
    out.smooth = out.smooth || clause.kind == Clause::Kind::smooth;
    out.touch = out.touch || clause.kind == Clause::Kind::touch;
    out.waits = out.waits || clause.kind == Clause::Kind::until;
    if (clause.kind == Clause::Kind::duration)
      out.duration = quantity(task.stack[first].value, clause, {Dimension::time}, "2s");
    if (clause.kind == Clause::Kind::near) out.near = near_of(task.stack[first].value, clause);
    if (takes_value(clause)) take(out, clause, task.stack[first].value);
    first += values_of(clause);
  }
  if (at_speed) {
    take_velocities(out, task.stack[velocities].value, *s.arguments.front(), s.motion, out.duration->value);
    out.duration.reset();
    out.around.reset();
  }
  out.step = task.step;
  const bool thesis = s.motion == Motion::moveto || s.moves_base();
  out.waits = out.waits || thesis;
  const bool said = std::any_of(s.clauses.begin(), s.clauses.end(),
                                [](const Clause& c) { return c.kind == Clause::Kind::exact; });
  out.exact = thesis || out.waits || !out.blend || said || (exact && !blends);
  return out;
}

/// Checks that the names that the move sets on its way exist and have the type of the value.
void Interpreter::check_targets(const Task& task, const Step& step, std::size_t next) const {
  for (const Clause& clause : source(step).statement->clauses) {
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
  const Statement& s = *source(step).statement;
  if (task.apart) wait_for(task, WaitKind::move);
  const int count = static_cast<int>(values_of(s));
  const std::size_t first = task.frame().base + static_cast<std::size_t>(step.a);
  require_values(task, step, step.a, count);
  check_targets(task, step, first + s.arguments.size());
  Move move;
  try {
    move = requested_move(task, step, first);
  } catch (const Refused& refused) {
    fail_at(refused.place, "bad-type", refused.what, refused.advice);
  }
  if (!host_.room_for_move(move.robot)) return wait_for(task, WaitKind::room, move.robot);
  move.called = called_from(task);
  if (!host_.ready_for(move, program_.at(source(step).line))) {
    wait_for(task, WaitKind::room, move.robot);
    task.waiting.until = host_.now() + 1;
    return;
  }
  const Handle handle = host_.start_move(move, program_.at(source(step).line));
  forget_arrived(task);
  task.moves.push_back({handle, source(step).line, task.passes, move.robot});
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
  release_now(task, step.a, count);
  ++task.pc;
  note_commanded(task, move.robot);
  if (!move.waits) {
    if (std::find(task.robots.begin(), task.robots.end(), move.robot) == task.robots.end())
      task.robots.push_back(move.robot);
    return;
  }
  std::erase(task.robots, move.robot);  // its queued moves arrive before this
  task.handles = {handle};
  const bool looks = std::any_of(s.clauses.begin(), s.clauses.end(),
                                 [](const Clause& c) { return c.kind == Clause::Kind::until; });
  if (looks) task.until_met = false, task.travelled = task.whole = 0, task.measured = handle;
  if (!looks) wait_for(task, WaitKind::move, move.targets.back().name);
}

/// A part of a task is gone when it has ended: what it moved, its task has moved.
void Interpreter::note_commanded(Task& task, const std::string& robot) {
  for (Task* each = &task; each; each = each->parent ? task_of(each->parent) : nullptr)
    if (std::find(each->commanded.begin(), each->commanded.end(), robot) == each->commanded.end())
      each->commanded.push_back(robot);
}

void Interpreter::use(Task& task, const Step& step) {
  const Statement& s = *source(step).statement;
  const int count = static_cast<int>(values_of(s));
  const std::size_t first = task.frame().base + static_cast<std::size_t>(step.a);
  require_values(task, step, step.a, count);
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
  release_now(task, step.a, count);
  task.uses.push_back(std::move(out));
  ++task.pc;
}

/// The way of a move with `until`, for travelled().
void Interpreter::measure(Task& task) const {
  if (!task.measured) return;
  const Travel travel = host_.travel(*task.measured);
  if (!std::isfinite(travel.covered_m)) return;  // it has ended
  task.travelled = travel.covered_m;
  if (std::isfinite(travel.left_m)) task.whole = travel.covered_m + travel.left_m;
}

/// Sets the values that moves set on their way.
void Interpreter::check_watches() {
  for (std::size_t i = 0; i < watches_.size() && !outcome_;) {
    const Watch watch = watches_[i];
    if (const Task* of = task_of(watch.task); of && is_frozen(*of)) {  // its move is set apart
      ++i;
      continue;
    }
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

}  // namespace polyarm::program
