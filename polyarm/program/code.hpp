#pragma once
/// A program compiled to steps of a stack machine, so that where it stands is a few numbers and it can be
/// left and resumed between any two steps, also in the middle of an expression.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "polyarm/program/ast.hpp"

namespace polyarm::program {

enum class Op {
  // Values: each leaves one on the stack.
  constant,        ///< a: which
  absent,          ///< an argument that was left out, the result of a function that returns nothing
  local,           ///< a: slot from the frame's base
  global,          ///< a
  host,            ///< a: text with the name; waits for queued motion unless it is a place
  local_element,   ///< a: slot of the list; takes the index
  global_element,  ///< a
  unary,           ///< a: operator
  binary,          ///< a: operator
  settle,          ///< a: operator and/or; to c where the left side settles it, which stays
  joined,          ///< a: how many, as one text
  list,            ///< a: how many
  record,          ///< a: how many, b: their names
  element,
  field,     ///< a: text
  builtin,   ///< a: function, b: how many, c: names of the arguments
  call,      ///< a: function, b: how many
  of_host,   ///< a: function, b: how many; the host does it
  answered,  ///< takes what the answer is to be like; to c where it is not
  here,
  // Names.
  drop,
  check_new,    ///< of statement: its name must not be the host's
  let_global,   ///< a
  set_local,    ///< a; keeps its type
  set_global,   ///< a
  set_host,     ///< a: text
  set_literal,  ///< a: slot, or -1 and b: global, or both -1
  replace,      ///< part of what lies below the indices and the value
  given,        ///< a: slot; to c where the argument was given
  fill,         ///< a: slot that takes the value
  // The world.
  arrive,  ///< waits for queued motion
  load,
  move,   ///< takes points and clauses
  use,    ///< takes clauses
  until,  ///< takes the condition; a: where it is looked at again, b: what it reads, c: the end was reached
  deadline,  ///< takes the timeout
  wait,      ///< takes the condition; a, b as of until, c: timeout or -1
  wait_time,
  ask,  ///< takes the text; a: where to go when its word is a name, or -1
  log,  ///< a: how many
  hold,
  ask_value,  ///< takes the text; the answer is there when the next step is taken
  run,        ///< of statement
  expect,     ///< takes the condition; a, b as of until, c: where it is told what is not so
  unmet,      ///< a: how many values, b: how they are spelled
  meet,       ///< a: text, c: timeout or -1
  lock,       ///< a: text
  // Flow.
  jump,         ///< to c
  jump_unless,  ///< to c where the condition is false
  for_begin,    ///< a: takes two values, a range; b: the loop names the place, too
  for_next,     ///< a: first of its slots, b as for_begin; next value, or to c
  leave,        ///< a: depths that a block leaves behind
  pass,         ///< end of a pass of an outermost while; to c when no more are wanted
  give,         ///< takes the value and returns with it
  try_begin,    ///< c: handler
  try_end,
  raise,
  raise_again,  ///< a: slot of the error
  retry,        ///< takes how often; a: slot of the count, b: try_begin, c: depths there
  together,     ///< a: entries of its statements; b: all are moves
  begin_when,   ///< a: which
  edge,         ///< takes the condition; goes on where it has become true, else rests and returns to a
  rest,         ///< to a, in the next tick
  refuse,       ///< a: problem
  stop,
  finish,
};

struct Step {
  Op op = Op::finish;
  int a = -1, b = -1, c = -1;
  Place place;  ///< of what may go wrong
  Place line;   ///< of the statement
  const Statement* statement = nullptr;
  bool begins = false;  ///< a statement, or the next look at a loop; these are what a budget counts
};

/// How much of each of a task's stacks a block leaves behind.
struct Depths {
  int locals = 0, uses = 0, locks = 0, handlers = 0;
};

struct FunctionCode {
  std::string name;
  int entry = 0;
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
  std::vector<Value> constants;
  std::vector<std::string> texts;
  std::vector<std::vector<std::string>> name_lists;
  std::vector<Depths> depths;
  std::vector<ConditionReads> reads;
  std::vector<std::vector<int>> entries;
  std::vector<Problem> problems;
  std::vector<FunctionCode> functions, tasks, whens, tests;
  std::map<std::string, int> meetings;  ///< how many tasks come to each
  std::vector<std::string> globals;
  std::vector<VariableName> variables;
  std::vector<StartingPoint> starts;
  int on_stop = -1;  ///< entry
};

/// The steps refer into `program`, which has to outlive them unmoved.
Code compile(const Program& program);

/// Every statement of `block` and of the blocks in it, outermost first.
void for_each_statement(const Block& block, const std::function<void(const Statement&)>& visit);
/// Every expression that stands in `s` itself, not in its blocks.
void for_each_expression(const Statement& s, const std::function<void(const Expression&)>& visit);
/// Calls of functions in `e`, by name.
void for_each_call(const Expression& e, const std::function<void(const Expression&)>& visit);

}  // namespace polyarm::program
