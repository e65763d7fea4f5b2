#pragma once
/// A program compiled to steps of a register machine, so that where it stands is a few numbers and it can be
/// left and resumed between any two steps, also in the middle of an expression (decision 0021).
///
/// Every call of a function has registers: its names first, then the values on their way through an
/// expression. How many are in use is known for every step, and what a step reads are registers, names of the
/// whole program or constants.
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/program/ast.hpp"
#include "polyarm/program/task_state.hpp"

namespace polyarm::program {

/// What a step reads or fills. A temporary has no name, and who reads it takes it.
enum class Where { local, global, constant, temporary };
/// Which of them, counted in bytes, and of what; kNone: nothing.
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

/// `to`, `left`, `from`, … are operands. "first": the first of several registers that follow one another.
enum class Op : std::uint8_t {
  // Plain values; run.cpp takes these without a way around for numbers, booleans, lists and records.
  load,     ///< a to, b from; a global has to have its value
  require,  ///< a global: has it its value?
  add,      ///< a to, b left, c right; so are the next
  subtract,
  multiply,
  divide,
  modulo,
  calculate,  ///< any other operator of two
  add_to,     ///< as add, into a variable, which keeps its type; so are the next
  subtract_to,
  multiply_to,
  divide_to,
  modulo_to,
  unary,         ///< a to, b of
  change,        ///< a variable, which keeps its type, b from
  jump,          ///< to d
  jump_unless,   ///< b condition, to d
  unless_equal,  ///< b left, c right; to d where it is not so; so are the next, in the order of Operator
  unless_unequal,
  unless_less,
  unless_less_equal,
  unless_greater,
  unless_greater_equal,
  when_equal,  ///< to d where it is so
  when_unequal,
  when_less,
  when_less_equal,
  when_greater,
  when_greater_equal,
  settle,       ///< b left of `and` and `or`, to d where it settles them, and stays
  for_next,     ///< a first of the loop's registers, b 1: it names the place, too; next value, or to d
  for_again,    ///< as for_next at the end of a pass, and to d where there is a next value
  element,      ///< a to, b list, c place
  field,        ///< a to, b of, c text
  set_element,  ///< a variable, b place, c from
  set_field,    ///< a variable, b from, c text
  append,       ///< a variable, b first, c how many, d their list's place in the text
  call,         ///< a first argument, where the result comes to, b how many, c function
  give,         ///< b result, c function
  let_go,       ///< a first, b how many: nobody reads them any more
  // Other values.
  absent,    ///< a to: an argument that was left out, the result of a function that returns nothing
  host,      ///< a to, b text with the name; waits for queued motion unless it is a place
  joined,    ///< a to, b first, c how many, as one text
  list,      ///< a to, b first, c how many
  record,    ///< a to, b first, c how many, d their names
  builtin,   ///< a to, b first, c how many, d names of the arguments; the function is `more`
  of_host,   ///< as builtin; the host does it
  answered,  ///< a what the answer is to be like, and then the answer; to d where it is not
  here,      ///< a to
  // Names.
  check_new,    ///< a text: must not be the host's
  let_global,   ///< a global, b from
  set_host,     ///< a text, b from
  set_literal,  ///< a variable or kNone
  replace,      ///< a root, b first of the places and the value behind them, c names before them, d how many
  given,        ///< a register; to d where the argument was given
  // The world.
  arrive,  ///< waits for queued motion
  load_file,
  move,       ///< a first of points and clauses
  use,        ///< a first of the clauses
  until,      ///< a where it is looked at again, b what it reads, c the end was reached, d condition
  deadline,   ///< b timeout
  wait,       ///< a, b, d as of until, c timeout or kNone
  wait_time,  ///< b how long
  ask,        ///< b text, d where to go when its word is a name, or kNone
  log,        ///< b first, c how many
  hold,       ///< b reason or kNone
  ask_value,  ///< b text; the answer is there when the next step is taken
  run,        ///< of statement
  expect,     ///< a, b, d as of until, c where it is told what is not so
  unmet,      ///< b first, c how many, d how they are spelled
  meet,       ///< a text, c timeout or kNone
  lock,       ///< a text, c timeout or kNone
  // Flow.
  for_begin,  ///< a first of the loop's registers, where the list or the two ends are; b as for_next, c 1: a
              ///< range
  leave,      ///< a depths that a block leaves behind, b how many names there are
  pass,       ///< end of a pass of an outermost while; to d when no more are wanted
  try_begin,  ///< a register of the error, d handler
  try_end,
  raise,        ///< b error
  raise_again,  ///< b error
  retry,        ///< a register of the count, b how often, c depths there, d try_begin
  together,     ///< a entries of its statements; b all are moves
  begin_when,   ///< a which
  edge,         ///< a where it is looked at again, b condition; goes on where it has become true
  rest,         ///< to a, in the next tick
  refuse,       ///< a problem
  stop,
  pace,  ///< a long statement goes on; a look at the budget
  finish,
};

/// Plain steps of one statement that count as one; a longer statement counts as several.
inline constexpr int kStepsOfAStatement = 32;

struct Step {
  Op op = Op::finish;
  /// A statement begins, or the next look at a loop: what a budget counts, more for a long line; 0: neither.
  std::uint8_t begins = 0;
  std::uint16_t more = 0;  ///< operator; function; of a field where it was found is kept under this number
  int a = -1, b = -1, c = -1, d = -1;
};

/// What messages and people need of a step.
struct StepSource {
  Place place;  ///< of what may go wrong
  Place line;   ///< of the statement
  const Statement* statement = nullptr;
};

/// How much of each of a task's stacks a block leaves behind.
struct Depths {
  int locals = 0, uses = 0, locks = 0, handlers = 0;
};

struct FunctionCode {
  std::string name;
  int entry = 0;
  int registers = 0;
};

/// What a condition reads that others change.
struct ConditionReads {
  std::vector<std::string> names;
  bool others = false;  ///< globals and functions, too: it is looked at in every tick
};

/// Where the steps are at which a slot has a name.
struct VariableName {
  std::string name;
  int slot = 0, begin = 0, end = -1;
};

/// A line that a program may be started at.
struct StartingPoint {
  const Statement* statement = nullptr;
  int begin = 0, end = 0;  ///< its steps
  int uses = 0;            ///< `use` lines that hold there
  bool top = false;        ///< it stands outside of every block
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
  std::vector<FunctionCode> functions, tasks, whens, tests;
  std::map<std::string, int> meetings;  ///< how many tasks come to each
  std::vector<std::string> globals;
  std::vector<VariableName> variables;
  std::vector<StartingPoint> starts;
  int on_stop = -1;   ///< entry
  int registers = 0;  ///< the most that any function needs
};

/// The steps refer into `program`, which has to outlive them unmoved.
Code compile(const Program& program);

/// A program and its steps, for any number of interpreters, which only read them.
struct Compiled {
  explicit Compiled(Program of) : program(std::move(of)), code(compile(program)) {}
  Compiled(const Compiled&) = delete;
  Compiled& operator=(const Compiled&) = delete;
  Program program;
  Code code;
};

/// Every statement of `block` and of the blocks in it, outermost first.
void for_each_statement(const Block& block, const std::function<void(const Statement&)>& visit);
/// Every expression that stands in `s` itself, not in its blocks.
void for_each_expression(const Statement& s, const std::function<void(const Expression&)>& visit);
/// The statement that begins in this line, or null.
const Statement* statement_at(const Program& program, const Location& where);
/// Calls of functions in `e`, by name.
void for_each_call(const Expression& e, const std::function<void(const Expression&)>& visit);

}  // namespace polyarm::program
