#include "polyarm/program/code.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/program/compiler.hpp"

namespace polyarm::program {

using Kind = Statement::Kind;

Code Compiler::run() {
  collect(program_.statements);
  sure_globals_.assign(code_.globals.size(), false);
  compile_block(program_.statements, true);
  add(Op::finish, {static_cast<int>(program_.lines.size()), 1, 0});
  sure_globals_.assign(code_.globals.size(), false);
  for (std::size_t i = 0; i < functions_.size(); ++i) compile_function(*functions_[i], code_.functions[i]);
  for (std::size_t i = 0; i < whens_.size(); ++i) compile_when(*whens_[i], code_.whens[i]);
  for (std::size_t i = 0; i < timers_.size(); ++i) compile_when(*timers_[i], code_.timers[i]);
  for (std::size_t i = 0; i < traps_.size(); ++i) compile_trap(*traps_[i], code_.traps[i]);
  if (on_stop_) {
    FunctionCode entry;
    compile_apart(*on_stop_, entry);
    code_.on_stop = entry.entry;
  }
  all_sure_ = true;  // these begin after all lines outside of them are done
  for (std::size_t i = 0; i < tasks_.size(); ++i) compile_apart(*tasks_[i], code_.tasks[i]);
  for (std::size_t i = 0; i < tests_.size(); ++i) compile_apart(*tests_[i], code_.tests[i]);
  count_meetings();
  weigh();
  return std::move(code_);
}

// First: global names.

void Compiler::add_global(const std::string& name) {
  if (globals_.try_emplace(name, static_cast<int>(code_.globals.size())).second)
    code_.globals.push_back(name);
}

void Compiler::collect(const Block& top) {
  for (const Statement& s : top) {
    if (s.kind == Kind::let && !s.name.empty()) add_global(s.name);
    if (s.kind == Kind::function) {
      function_at_.try_emplace(s.name, functions_.size());
      functions_.push_back(&s), code_.functions.push_back({s.name, 0, 0});
    }
    if (s.kind == Kind::task) {
      tasks_.push_back(&s), code_.tasks.push_back({s.name, 0, 0});
      for (const Statement& inner : s.body)
        if (inner.kind == Kind::trap) traps_.push_back(&inner), code_.traps.push_back({"trap", 0, 0});
    }
    if (s.kind == Kind::when) whens_.push_back(&s), code_.whens.push_back({"when", 0, 0});
    if (s.kind == Kind::every) timers_.push_back(&s), code_.timers.push_back({"every", 0, 0});
    if (s.kind == Kind::trap) traps_.push_back(&s), code_.traps.push_back({"trap", 0, 0});
    if (s.kind == Kind::on_stop) on_stop_ = &s;
    if (s.kind == Kind::test) tests_.push_back(&s), code_.tests.push_back({s.name, 0, 0});
  }
}

// Blocks.

void Compiler::leave(const Depths& from, const Depths& to, Place place) {
  const bool names_alone = from.uses == to.uses && from.locks == to.locks && from.handlers == to.handlers;
  if (names_alone) {
    if (from.locals > to.locals) add(Op::release_now, place, {.a = to.locals, .b = from.locals - to.locals});
    return;
  }
  code_.depths.push_back(to);
  add(Op::leave, place, {.a = static_cast<int>(code_.depths.size()) - 1, .b = from.locals});
}

/// A line at which the program can start: it needs nothing that its enclosing blocks create.
int Compiler::note_start(const Statement& s, bool top) {
  const Depths now = depths();
  if (!in_main_ || now.locals > 0 || now.locks > 0 || now.handlers > 0) return -1;
  code_.starts.push_back({&s, here(), here(), now.uses, top});
  return static_cast<int>(code_.starts.size()) - 1;
}

void Compiler::compile_block(const Block& statements, bool top) {
  const Depths before = depths();
  for (const Statement& s : statements) {
    statement_ = &s;
    line_ = s.place;
    begins_ = true;
    const int start = note_start(s, top);
    statement(s, top);
    if (start >= 0) code_.starts[static_cast<std::size_t>(start)].end = here();
  }
  if (top) return;
  const Depths inside = depths();
  forget(before.locals);
  scope_.depths = before;
  leave(inside, before, line_);
}

void Compiler::statement(const Statement& s, bool top) {
  switch (s.kind) {
    case Kind::load:
    case Kind::import:
      add(Op::load_file, s.place);
      return;
    case Kind::set_literal:
      return set_literal(s);
    case Kind::set:
      return set(s);
    case Kind::let:
      return let(s, top);
    case Kind::move:
      return move(s);
    case Kind::use:
      return use(s);
    case Kind::wait_time:
      return wait_time(s);
    case Kind::wait:
      return wait(s, *s.expression);
    case Kind::ask:
      return ask(s);
    case Kind::while_loop:
      return while_loop(s);
    case Kind::branch:
      return branches(s);
    case Kind::for_loop:
      return for_loop(s);
    case Kind::break_loop:
      return leave_loop(s, true);
    case Kind::continue_loop:
      return leave_loop(s, false);
    case Kind::stop:
      add(Op::stop, s.place);
      return;
    case Kind::log:
      return log(s);
    case Kind::call: {
      const Temporaries inner(*this);
      const Operand result = push(*s.expression);
      add(Op::release_now, s.place, {.a = index(result), .b = 1});
      return;
    }
    case Kind::hold:
      return hold(s);
    default:
      return structure(s);
  }
}

void Compiler::structure(const Statement& s) {
  switch (s.kind) {
    case Kind::return_value:
      return give(s);
    case Kind::try_block:
      return try_block(s);
    case Kind::raise:
      return raise(s);
    case Kind::retry:
      return retry(s);
    case Kind::together:
      return together(s);
    case Kind::meet:
      return meet(s);
    case Kind::lock:
      return lock(s);
    case Kind::when:
      add(Op::begin_when, s.place,
          {.a = static_cast<int>(std::find(whens_.begin(), whens_.end(), &s) - whens_.begin())});
      return;
    case Kind::trap:
      add(Op::begin_trap, s.place,
          {.a = static_cast<int>(std::find(traps_.begin(), traps_.end(), &s) - traps_.begin())});
      return;
    case Kind::every:
      add(Op::begin_every, s.place,
          {.a = static_cast<int>(std::find(timers_.begin(), timers_.end(), &s) - timers_.begin())});
      return;
    case Kind::pulse:
      return pulse(s);
    case Kind::run:
      add(Op::run, s.place);
      return;
    case Kind::expect:
      return expect(s);
    default:  // functions, tasks, tests and on stop are compiled elsewhere
      begins_ = false;
      return;
  }
}

// Blocks apart from the normal flow.

void Compiler::begin_apart(const Statement& s, bool counts_passes) {
  forget(0);
  in_main_ = false;
  scope_ = {};
  scope_.counts_passes = counts_passes;
  registers_ = 0;
  statement_ = &s, line_ = s.place;
  begins_ = false;
}

void Compiler::compile_apart(const Statement& s, FunctionCode& out) {
  begin_apart(s, s.kind == Kind::task);
  out.entry = here();
  compile_block(s.body);
  add(Op::finish, line_);
}

void Compiler::compile_when(const Statement& s, FunctionCode& out) {
  begin_apart(s, false);
  out.entry = here();
  {
    const Temporaries inner(*this);
    const Operand of = read(*s.expression);
    add(s.kind == Kind::every ? Op::due : Op::edge, s.expression->place, {.a = out.entry, .b = of});
  }
  compile_block(s.body);
  statement_ = &s, line_ = s.place;
  add(Op::rest, s.place, {.a = out.entry});
}

/// First what looks at the condition in every tick, then the block, which runs as a task of its own.
void Compiler::compile_trap(const Statement& s, FunctionCode& out) {
  begin_apart(s, false);
  out.entry = here();
  {
    const Temporaries inner(*this);
    const Operand condition = read(*s.expression);
    add(Op::edge, s.expression->place, {.a = out.entry, .b = condition});
  }
  add(Op::spring, s.place);
  add(Op::rest, s.place, {.a = out.entry});
  begin_apart(s, false);
  out.body = here();
  compile_block(s.body);
  statement_ = &s;
  add(Op::finish, line_);
}

void Compiler::compile_function(const Statement& s, FunctionCode& out) {
  begin_apart(s, false);
  out.entry = here();
  function_ = static_cast<int>(&out - code_.functions.data());
  for (const Parameter& parameter : s.parameters) declare(parameter.name);
  for (std::size_t i = 0; i < s.parameters.size(); ++i) {
    if (!s.parameters[i].value) continue;
    const int slot = static_cast<int>(i);
    const int given = add(Op::given, s.parameters[i].place, {.a = slot});
    const Temporaries inner(*this);
    const Operand value = push(*s.parameters[i].value);
    add(Op::load, s.parameters[i].place, {.a = operand(Where::local, slot), .b = value});
    land(given);
  }
  compile_block(s.body);
  {
    const Temporaries inner(*this);
    const Operand none = temporary();
    add(Op::absent, line_, {.a = none});
    add(Op::give, line_, {.b = none, .c = function_});
  }
  out.registers = registers_;
}

// Meetings.

/// The meetings in `block`, including those in the functions that it calls.
void Compiler::meetings_in(const Block& block, std::set<std::string>& out,
                           std::set<std::string>& seen) const {
  std::set<const Statement*> in_traps;  // a trap does not come in place of its task
  for_each_statement(block, [&](const Statement& s) {
    if (s.kind == Kind::trap) for_each_statement(s.body, [&](const Statement& inner) { in_traps.insert(&inner); });
  });
  for_each_statement(block, [&](const Statement& s) {
    if (in_traps.contains(&s)) return;
    if (s.kind == Kind::meet) out.insert(s.name);
    for_each_expression(s, [&](const Expression& e) {
      for_each_call(e, [&](const Expression& call) {
        const auto at = function_at_.find(call.name);
        if (at != function_at_.end() && seen.insert(call.name).second)
          meetings_in(functions_[at->second]->body, out, seen);
      });
    });
  });
}

void Compiler::count_meetings() {
  for (const Statement* task : tasks_) {
    std::set<std::string> names, seen;
    meetings_in(task->body, names, seen);
    for (const std::string& name : names) code_.meetings[name].push_back(task->name);
  }
}

// Costs of statements.

namespace {
/// The approximate cost of the step in plain steps.
int weight(const Step& step) {
  constexpr int kCall = 2, kLarge = 8, kHost = 16, kSet = 64, kLog = 128, kMove = 320;
  if (step.op == Op::move || step.op == Op::load_file) return kMove;
  if (step.op == Op::log) return kLog + step.c * kCall;
  if (step.op == Op::set_host || step.op == Op::pulse || step.op == Op::of_host) return kSet;
  if (step.op == Op::host) return kHost;
  if (step.op == Op::call || step.op == Op::give || step.op == Op::element || step.op == Op::field)
    return kCall;
  if (step.op < Op::absent) return 1;
  const bool has_parts =
      step.op == Op::joined || step.op == Op::list || step.op == Op::record || step.op == Op::builtin;
  return kLarge + (has_parts ? step.c * kCall : 0);
}
}  // namespace

/// A statement with more than kStepsOfAStatement steps counts as several.
void Compiler::weigh() {
  int steps = 0;
  for (auto step = code_.steps.rbegin(); step != code_.steps.rend(); ++step) {
    steps += weight(*step);
    if (!step->begins) continue;
    step->begins = static_cast<std::uint8_t>(std::min(255, 1 + steps / kStepsOfAStatement));
    steps = 0;
  }
}

Code compile(const Program& program) {
  return Compiler(program).run();
}

}  // namespace polyarm::program
