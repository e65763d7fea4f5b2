#pragma once
/// A program compiled to steps of a register machine. Its position is a few numbers, so it can be paused and
/// resumed between any two steps, even inside an expression (decision 0021).
///
/// Every call of a function has registers: its names first, then temporary values of expressions. The number
/// of used registers is known for every step. A step reads registers, names of the whole program, or
/// constants. Compiling allocates; compiled code is const: any thread.
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/language/ast.hpp"
#include "polyarm/program/task_state.hpp"

namespace polyarm::program {

/// The kinds of operands of a step. A temporary has no name; the step that reads it consumes it.
enum class Where { local, global, constant, temporary };
/// Kind and byte offset of an operand; kNone: no operand.
using Operand = int;
inline constexpr Operand kNone = -1;
static_assert(alignof(Slot) >= 4, "the lowest bits of an operand say of what it is");
constexpr Operand operand(Where where, int index) {
  return index * static_cast<int>(sizeof(Slot)) + static_cast<int>(where);
}
constexpr Where where(Operand operand) {
  return static_cast<Where>(operand & 3);
}
constexpr int index(Operand operand) {
  return operand / static_cast<int>(sizeof(Slot));
}

/// `to`, `left`, `from`, … are operands. "first": the first of several consecutive registers.
enum class Op : std::uint8_t {
  // Plain values; run.cpp executes these directly for numbers, booleans, lists and records.
  load,     ///< a to, b from; a global must have a value
  require,  ///< a global: fails if it has no value
  add,      ///< a to, b left, c right; the next ones alike
  subtract,
  multiply,
  divide,
  modulo,
  calculate,  ///< any other binary operator
  add_to,     ///< as add, into a variable, which keeps its type; the next ones alike
  subtract_to,
  multiply_to,
  divide_to,
  modulo_to,
  unary,         ///< a to, b of
  change,        ///< a variable, which keeps its type; b from
  jump,          ///< to d
  jump_unless,   ///< b condition, to d
  unless_equal,  ///< b left, c right; to d if it is false; the next ones alike, in the order of Operator
  unless_unequal,
  unless_less,
  unless_less_equal,
  unless_greater,
  unless_greater_equal,
  when_equal,  ///< to d if it is true
  when_unequal,
  when_less,
  when_less_equal,
  when_greater,
  when_greater_equal,
  settle,       ///< b left side of `and` or `or`; to d, with its value, if it decides the result
  for_next,     ///< a first of the loop's registers, b 1: has an index name too; next value, or to d
  for_again,    ///< as for_next at the end of a pass; to d if there is a next value
  element,      ///< a to, b list, c index
  field,        ///< a to, b from, c text
  set_element,  ///< a variable, b index, c from
  set_field,    ///< a variable, b from, c text
  append,       ///< a variable, b first, c count, d place of their list in the text
  call,         ///< a first argument and register of the result, b count, c function
  give,         ///< b result, c function
  release_now,       ///< a first, b count: releases values that are no longer read
  // Other values.
  absent,    ///< a to: an omitted argument, or the result of a function without one
  host,      ///< a to, b text with the name; waits for queued motion unless it is a place
  joined,    ///< a to, b first, c count, as one text
  list,      ///< a to, b first, c count
  record,    ///< a to, b first, c count, d their names
  builtin,   ///< a to, b first, c count, d names of the arguments; the function is `more`
  of_host,   ///< as builtin; the host executes it
  answered,  ///< a example of the answer, then the answer; to d if it does not match
  here,      ///< a to
  // Names.
  check_new,    ///< a text: fails if the host has this name
  let_global,   ///< a global, b from
  set_host,     ///< a text, b from
  set_literal,  ///< a variable or kNone
  replace,      ///< a root, b first of the indices followed by the value, c names before them, d count
  given,        ///< a register; to d if the argument was given
  // Interaction with the cell.
  arrive,  ///< waits for queued motion
  load_file,
  move,       ///< a first of points and clauses
  use,        ///< a first of the clauses
  until,      ///< a step of the next check, b condition reads, c the end was reached, d condition
  deadline,   ///< b timeout
  wait,       ///< a, b, d as in until, c timeout or kNone
  wait_time,  ///< b duration
  ask,        ///< b text, d target if its word is a name, or kNone
  log,        ///< b first, c count
  hold,       ///< b reason or kNone
  ask_value,  ///< b text; the answer is available at the next step
  run,        ///< of statement
  expect,     ///< a, b, d as in until, c where the failure is reported
  unmet,      ///< b first, c count, d their spellings
  meet,       ///< a text, c timeout or kNone
  lock,       ///< a text, c timeout or kNone
  pulse,      ///< a text, b duration
  // Control flow.
  for_begin,  ///< a first of the loop's registers, which hold the list or both ends; b as in for_next, c 1: a
              ///< range; d 1: of the statement, whose names may not be names of the host
  leave,      ///< a depths to restore, b number of names
  pass,       ///< end of a pass of an outermost while; to d if the pass limit is reached
  try_begin,  ///< a register of the error, d handler
  try_end,
  raise,        ///< b error
  raise_again,  ///< b error
  retry,        ///< a register of the counter, b count, c depths there, d try_begin
  together,     ///< a entries of its statements; b all of them are moves
  begin_when,   ///< a index
  begin_trap,   ///< a index
  begin_every,  ///< a index
  edge,         ///< a step of the next check, b condition; continues when it has become true
  due,          ///< a step of the next check, b period; continues when it has passed again
  spring,       ///< the trap interrupts its task
  rest,         ///< to a, in the next tick
  refuse,       ///< a problem
  stop,
  pace,  ///< checks the budget within a long statement
  finish,
};

/// The number of plain steps that count as one statement; a longer statement counts as several.
inline constexpr int kStepsOfAStatement = 32;

struct Step {
  Op op = Op::finish;
  /// The cost in the budget at the start of a statement or of the next check of a loop, more for a long line;
  /// 0 for other steps.
  std::uint8_t begins = 0;
  std::uint16_t more = 0;  ///< operator; function; for a field the number of its cached position
  int a = -1, b = -1, c = -1, d = -1;
};

/// The places of a step in the source, for messages and display.
struct StepSource {
  Place place;  ///< for error messages
  Place line;   ///< of the statement
  const Statement* statement = nullptr;
};

/// The heights to which a block restores each of a task's stacks.
struct Depths {
  int locals = 0, uses = 0, locks = 0, handlers = 0;
};

struct FunctionCode {
  std::string name;
  int entry = 0;
  int registers = 0;
  int body = -1;  ///< of a trap: the block that interrupts
};

/// The values read by a condition that others can change.
struct ConditionReads {
  std::vector<std::string> names;
  bool others = false;  ///< globals and functions too: checked in every tick
};

/// The range of steps in which a slot has a name.
struct VariableName {
  std::string name;
  int slot = 0, begin = 0, end = -1;
};

/// A line at which a program may be started.
struct StartingPoint {
  const Statement* statement = nullptr;
  int begin = 0, end = 0;  ///< its steps
  int uses = 0;            ///< number of `use` lines in force there
  bool top = false;        ///< outside all blocks
};

struct Code {
  std::vector<Step> steps;
  std::vector<StepSource> sources;  ///< of each step
  std::vector<Slot> constants;
  std::vector<std::string> texts;
  std::vector<std::vector<std::string>> name_lists;
  std::vector<Depths> depths;
  std::vector<Place> places;
  std::vector<ConditionReads> reads;
  std::vector<std::vector<int>> entries;
  std::vector<Problem> problems;
  std::vector<FunctionCode> functions, tasks, whens, traps, timers, tests;
  std::map<std::string, std::vector<std::string>> meetings;  ///< the tasks that come to each
  std::vector<std::string> globals;
  std::vector<VariableName> variables;
  std::vector<StartingPoint> starts;
  int on_stop = -1;   ///< entry
  int registers = 0;  ///< the largest number that any function needs
};

/// The steps refer to `program`, which must outlive them and must not move.
Code compile(const Program& program);

/// A program and its steps, shared read-only by any number of interpreters.
struct Compiled {
  explicit Compiled(Program of) : program(std::move(of)), code(compile(program)) {}
  Compiled(const Compiled&) = delete;
  Compiled& operator=(const Compiled&) = delete;
  Program program;
  Code code;
};

/// Visits every statement of `block` and of nested blocks, outermost first.
void for_each_statement(const Block& block, const std::function<void(const Statement&)>& visit);
/// Visits every expression of `s` itself, without its blocks.
void for_each_expression(const Statement& s, const std::function<void(const Expression&)>& visit);
/// The statement that begins in this line, or null.
const Statement* statement_at(const Program& program, const Location& where);
/// Visits the calls of functions in `e`.
void for_each_call(const Expression& e, const std::function<void(const Expression&)>& visit);

}  // namespace polyarm::program
