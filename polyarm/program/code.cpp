#include "polyarm/program/code.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "polyarm/program/code_writer.hpp"

namespace polyarm::program {

namespace {
using Kind = Statement::Kind;

class Compiler : private CodeWriter {
 public:
  explicit Compiler(const Program& program) : CodeWriter{program} {}

  Code run() {
    collect(program_.statements);
    compile_block(program_.statements, true);
    add(Op::finish, {static_cast<int>(program_.lines.size()), 1, 0});
    for (std::size_t i = 0; i < functions_.size(); ++i) compile_function(*functions_[i], code_.functions[i]);
    for (std::size_t i = 0; i < tasks_.size(); ++i) compile_apart(*tasks_[i], code_.tasks[i]);
    for (std::size_t i = 0; i < whens_.size(); ++i) compile_when(*whens_[i], code_.whens[i]);
    for (std::size_t i = 0; i < tests_.size(); ++i) compile_apart(*tests_[i], code_.tests[i]);
    if (on_stop_) {
      FunctionCode entry;
      compile_apart(*on_stop_, entry);
      code_.on_stop = entry.entry;
    }
    count_meetings();
    return std::move(code_);
  }

 private:
  // What is made first: names that stand for the whole program.

  void add_global(const std::string& name) {
    if (globals_.try_emplace(name, static_cast<int>(code_.globals.size())).second)
      code_.globals.push_back(name);
  }

  void collect(const Block& top) {
    for (const Statement& s : top) {
      if (s.kind == Kind::let && !s.name.empty()) add_global(s.name);
      if (s.kind == Kind::function) {
        function_at_.try_emplace(s.name, functions_.size());
        functions_.push_back(&s), code_.functions.push_back({s.name, 0});
      }
      if (s.kind == Kind::task) tasks_.push_back(&s), code_.tasks.push_back({s.name, 0});
      if (s.kind == Kind::when) whens_.push_back(&s), code_.whens.push_back({"when", 0});
      if (s.kind == Kind::on_stop) on_stop_ = &s;
      if (s.kind == Kind::test) tests_.push_back(&s), code_.tests.push_back({s.name, 0});
    }
  }

  // Blocks.

  void leave(const Depths& to, Place place) {
    code_.depths.push_back(to);
    add(Op::leave, place, static_cast<int>(code_.depths.size()) - 1);
  }

  static bool same(const Depths& a, const Depths& b) {
    return a.locals == b.locals && a.uses == b.uses && a.locks == b.locks && a.handlers == b.handlers;
  }

  /// A line that the program can begin at: nothing that it needs is made by the blocks around it.
  int note_start(const Statement& s, bool top) {
    const Depths now = depths();
    if (!in_main_ || now.locals > 0 || now.locks > 0 || now.handlers > 0) return -1;
    code_.starts.push_back({&s, here(), here(), now.uses, top});
    return static_cast<int>(code_.starts.size()) - 1;
  }

  void compile_block(const Block& statements, bool top = false) {
    const Depths before = depths();
    for (const Statement& s : statements) {
      statement_ = &s;
      line_ = s.place;
      begins_ = true;
      const int start = note_start(s, top);
      statement(s, top);
      if (start >= 0) code_.starts[static_cast<std::size_t>(start)].end = here();
    }
    if (top || same(before, depths())) return;
    forget(before.locals);
    scope_.depths = before;
    leave(before, line_);
  }

  void statement(const Statement& s, bool top) {
    switch (s.kind) {
      case Kind::load:
      case Kind::import:
        add(Op::load, s.place);
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
        for (const Clause& clause : s.clauses) clause_value(clause);
        add(Op::use, s.place);
        ++scope_.depths.uses;
        return;
      case Kind::wait_time:
        add(Op::arrive, s.place);
        expression(*s.expression);
        add(Op::wait_time, s.expression->place);
        return;
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
        for (const ExpressionPtr& argument : s.arguments) expression(*argument);
        add(Op::log, s.place, static_cast<int>(s.arguments.size()));
        return;
      case Kind::call:
        expression(*s.expression);
        add(Op::drop, s.place);
        return;
      case Kind::hold:
        if (s.expression) expression(*s.expression);
        add(Op::hold, s.place, s.expression ? 1 : 0);
        return;
      default:
        return structure(s);
    }
  }

  void structure(const Statement& s) {
    switch (s.kind) {
      case Kind::return_value:
        if (s.expression) {
          expression(*s.expression);
        } else {
          add(Op::absent, s.place);
        }
        add(Op::give, s.place);
        return;
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
            static_cast<int>(std::find(whens_.begin(), whens_.end(), &s) - whens_.begin()));
        return;
      case Kind::run:
        add(Op::run, s.place);
        return;
      case Kind::expect:
        return expect(s);
      default:  // functions, tasks, tests and on stop stand elsewhere
        begins_ = false;
        return;
    }
  }

  void set_literal(const Statement& s) {
    Resolved resolved;
    const bool variable = find_variable(s.name, resolved);
    const bool local = variable && resolved.where == Resolved::Where::local;
    if (!variable) add(Op::arrive, s.place);
    add(Op::set_literal, s.place, local ? resolved.slot : -1, variable && !local ? resolved.slot : -1);
  }

  void set(const Statement& s) {
    const Resolved resolved = resolve(s.name);
    std::size_t parts = resolved.fields.size() + s.path.size();
    if (parts > 0) {
      Resolved root = resolved;
      root.fields.clear();
      push_variable(root, s.name, s.name_place);
      for (const PathPart& part : s.path)
        if (part.index) expression(*part.index);
    }
    expression(*s.expression);
    if (parts > 0) add(Op::replace, s.name_place, names(resolved.fields));
    if (resolved.where == Resolved::Where::host) {
      add(Op::set_host, s.name_place, text(s.name));
    } else {
      add(resolved.where == Resolved::Where::local ? Op::set_local : Op::set_global, s.name_place,
          resolved.slot);
    }
  }

  void let(const Statement& s, bool top) {
    add(Op::check_new, s.name_place, text(s.name));
    expression(*s.expression);
    if (top) {
      add(Op::let_global, s.name_place, globals_.at(s.name));
    } else {
      declare(s.name);
    }
  }

  void clause_value(const Clause& clause) {
    using Clauses = Clause::Kind;
    const bool is_name =
        clause.kind == Clauses::robot || clause.kind == Clauses::tool || clause.kind == Clauses::frame;
    if (clause.kind == Clauses::exact || clause.kind == Clauses::smooth || clause.kind == Clauses::until)
      return;
    if (clause.kind == Clauses::at) {
      if (clause.value) expression(*clause.value);
      return expression(*clause.to);
    }
    const Expression& value = *clause.value;
    if (is_name && value.kind == Expression::Kind::name &&
        resolve(value.name).where == Resolved::Where::host) {
      add(Op::constant, value.place, constant(value.name));
      return;
    }
    expression(value);
  }

  void move(const Statement& s) {
    for (const ExpressionPtr& point : s.arguments) expression(*point);
    for (const Clause& clause : s.clauses) clause_value(clause);
    add(Op::move, s.place);
    for (const Clause& clause : s.clauses)
      if (clause.kind == Clause::Kind::until)
        look_until(Op::until, *clause.value, clause.has_else, clause.otherwise, s);
  }

  /// The condition again and again; `otherwise` is what is done when the step goes to its c.
  void look_until(Op op, const Expression& condition, bool has_else, const Block& otherwise,
                  const Statement& s) {
    const int start = here();
    const int what = reads(condition);
    expression(condition);
    const int step = add(op, condition.place, start, what);
    or_else(step, has_else, otherwise, s);
  }

  void or_else(int step, bool has_else, const Block& otherwise, const Statement& s) {
    if (!has_else) return;
    const int skip = add(Op::jump, s.place);
    land(step);
    compile_block(otherwise);
    land(skip);
  }

  void timeout(const Statement& s) {
    if (!s.second) return;
    expression(*s.second);
    add(Op::deadline, s.second->place);
  }

  void wait(const Statement& s, const Expression& condition) {
    add(Op::arrive, s.place);
    if (s.kind == Kind::wait) timeout(s);
    look_until(Op::wait, condition, s.has_else, s.body, s);
  }

  /// Where it is not so, what its parts are is looked at once more, for the message.
  void expect(const Statement& s) {
    add(Op::arrive, s.place);
    timeout(s);
    const Expression& condition = *s.expression;
    const int start = here();
    const int what = reads(condition);
    expression(condition);
    const int step = add(Op::expect, condition.place, start, what);
    const int skip = add(Op::jump, s.place);
    land(step);
    std::vector<const Expression*> parts;
    parts_told(condition, parts);
    std::vector<std::string> spellings;
    for (const Expression* part : parts) expression(*part), spellings.push_back(spelled(*part));
    add(Op::unmet, condition.place, static_cast<int>(parts.size()), names(std::move(spellings)));
    land(skip);
  }

  /// The values that decide whether `e` is true.
  static void parts_told(const Expression& e, std::vector<const Expression*>& out) {
    using Kinds = Expression::Kind;
    if (e.kind == Kinds::literal || e.kind == Kinds::record) return;
    const bool splits = e.kind == Kinds::unary || e.kind == Kinds::binary;
    if (!splits) return out.push_back(&e);
    for (const ExpressionPtr& part : e.parts) {
      const bool whole = is_comparison(e.op) && part->kind != Kinds::literal;
      if (whole) {
        out.push_back(part.get());
      } else {
        parts_told(*part, out);
      }
    }
  }

  /// `wait user`: a name where there is one, else a question.
  void ask(const Statement& s) {
    if (s.second && resolve(s.second->name).where != Resolved::Where::host) return wait(s, *s.second);
    if (s.expression) {
      expression(*s.expression);
    } else {
      add(Op::constant, s.place, constant(std::string{}));
    }
    const int question = add(Op::ask, s.place);
    if (!s.second) return;
    const int skip = add(Op::jump, s.place);
    code_.steps[static_cast<std::size_t>(question)].a = here();
    wait(s, *s.second);
    land(skip);
  }

  void while_loop(const Statement& s) {
    const bool outermost = scope_.loops.empty() && scope_.counts_passes;
    const int start = here();
    expression(*s.expression);
    const int unless = add(Op::jump_unless, s.expression->place);
    scope_.loops.push_back({depths(), depths(), {}, {}});
    compile_block(s.body);
    statement_ = &s, line_ = s.place;
    for (const int step : scope_.loops.back().continues) land(step);
    const int pass = outermost ? add(Op::pass, s.place) : -1;
    jump_to(start, s.place);
    land(unless);
    if (outermost) land(pass);
    for (const int step : scope_.loops.back().breaks) land(step);
    scope_.loops.pop_back();
  }

  void for_loop(const Statement& s) {
    const Depths outside = depths();
    expression(*s.expression);
    if (s.second) expression(*s.second);
    const bool named_place = !s.second_name.empty();
    add(Op::for_begin, s.place, s.second ? 1 : 0, named_place ? 1 : 0);
    const int slot = declare("");
    declare("");
    if (named_place) declare(s.second_name);
    declare(s.name);
    begins_ = true;
    const int next = add(Op::for_next, s.place, slot, named_place ? 1 : 0);
    scope_.loops.push_back({depths(), outside, {}, {}});
    compile_block(s.body);
    statement_ = &s, line_ = s.place;
    for (const int step : scope_.loops.back().continues) land(step);
    jump_to(next, s.place);
    land(next);
    forget(outside.locals);
    leave(outside, s.place);
    for (const int step : scope_.loops.back().breaks) land(step);
    scope_.loops.pop_back();
  }

  void leave_loop(const Statement& s, bool breaks) {
    if (scope_.loops.empty()) return refuse(s.place, {"no-loop", "this stands in no loop", {}});
    Loop& loop = scope_.loops.back();
    leave(breaks ? loop.outside : loop.body, s.place);
    (breaks ? loop.breaks : loop.continues).push_back(add(Op::jump, s.place));
  }

  void branches(const Statement& s) {
    std::vector<int> ends;
    for (const Branch& branch : s.branches) {
      statement_ = &s, line_ = branch.place;
      int unless = -1;
      if (branch.condition) {
        expression(*branch.condition);
        unless = add(Op::jump_unless, branch.condition->place);
      }
      compile_block(branch.body);
      if (&branch != &s.branches.back()) ends.push_back(add(Op::jump, branch.place));
      if (unless >= 0) land(unless);
    }
    for (const int step : ends) land(step);
    begins_ = false;
  }

  /// How often it was tried lies below what the try and its handler declare, and the error above it.
  void try_block(const Statement& s) {
    const Depths outside = depths();
    add(Op::constant, s.place, constant(0));
    Handler handler;
    handler.count_slot = declare("");
    handler.outside = depths();
    handler.begin = here();
    begins_ = true;
    const int begin = add(Op::try_begin, s.place);
    ++scope_.depths.handlers;
    compile_block(s.body);
    add(Op::try_end, line_);
    --scope_.depths.handlers;
    const int skip = add(Op::jump, s.place);
    land(begin);
    handler.error_slot = declare(s.name);
    scope_.handlers.push_back(handler);
    compile_block(s.handler);
    scope_.handlers.pop_back();
    forget(outside.locals);
    land(skip);
    leave(outside, line_);
  }

  void raise(const Statement& s) {
    if (s.expression) {
      expression(*s.expression);
      add(Op::raise, s.place);
    } else if (!scope_.handlers.empty()) {
      add(Op::raise_again, s.place, scope_.handlers.back().error_slot);
    }
  }

  void retry(const Statement& s) {
    if (scope_.handlers.empty()) return;
    const Handler& handler = scope_.handlers.back();
    if (s.expression) {
      expression(*s.expression);
    } else {
      add(Op::constant, s.place, constant(1));
    }
    code_.depths.push_back(handler.outside);
    const int step = add(Op::retry, s.place, handler.count_slot, handler.begin);
    code_.steps[static_cast<std::size_t>(step)].c = static_cast<int>(code_.depths.size()) - 1;
  }

  /// Each statement becomes a small task of its own that starts with the names there are.
  void together(const Statement& s) {
    const int skip = add(Op::jump, s.place);
    std::vector<int> entries;
    const Scope around = scope_;
    const bool in_main = std::exchange(in_main_, false);
    for (const Statement& part : s.body) {
      scope_ = {around.locals, around.variables, {}, {}, around.handlers, false};
      entries.push_back(here());
      statement_ = &part, line_ = part.place, begins_ = true;
      statement(part, false);
      add(Op::finish, part.place);
    }
    scope_ = around;
    in_main_ = in_main;
    statement_ = &s, line_ = s.place;
    land(skip);
    code_.entries.push_back(std::move(entries));
    const bool moves = std::all_of(s.body.begin(), s.body.end(), [](const Statement& part) {
      const auto looks = [](const Clause& clause) { return clause.kind == Clause::Kind::until; };
      return part.kind == Kind::move && !part.moves_base() &&
             std::none_of(part.clauses.begin(), part.clauses.end(), looks);
    });
    add(Op::together, s.place, static_cast<int>(code_.entries.size()) - 1, moves ? 1 : 0);
  }

  void meet(const Statement& s) {
    add(Op::arrive, s.place);
    timeout(s);
    or_else(add(Op::meet, s.place, text(s.name)), s.has_else, s.body, s);
  }

  void lock(const Statement& s) {
    const Depths before = depths();
    add(Op::arrive, s.place);
    timeout(s);
    add(Op::lock, s.place, text(s.name));
    ++scope_.depths.locks;
    compile_block(s.body);
    --scope_.depths.locks;
    statement_ = &s;
    add(Op::arrive, line_);
    leave(before, line_);
  }

  // What stands apart from the lines around it.

  void begin_apart(const Statement& s, bool counts_passes) {
    forget(0);
    in_main_ = false;
    scope_ = {};
    scope_.counts_passes = counts_passes;
    statement_ = &s, line_ = s.place;
    begins_ = false;
  }

  void compile_apart(const Statement& s, FunctionCode& out) {
    begin_apart(s, s.kind == Kind::task);
    out.entry = here();
    compile_block(s.body);
    add(Op::finish, line_);
  }

  void compile_when(const Statement& s, FunctionCode& out) {
    begin_apart(s, false);
    out.entry = here();
    expression(*s.expression);
    add(Op::edge, s.expression->place, out.entry);
    compile_block(s.body);
    statement_ = &s, line_ = s.place;
    add(Op::rest, s.place, out.entry);
  }

  void compile_function(const Statement& s, FunctionCode& out) {
    begin_apart(s, false);
    out.entry = here();
    for (const Parameter& parameter : s.parameters) declare(parameter.name);
    for (std::size_t i = 0; i < s.parameters.size(); ++i) {
      if (!s.parameters[i].value) continue;
      const int given = add(Op::given, s.parameters[i].place, static_cast<int>(i));
      expression(*s.parameters[i].value);
      add(Op::fill, s.parameters[i].place, static_cast<int>(i));
      land(given);
    }
    compile_block(s.body);
    add(Op::absent, line_);
    add(Op::give, line_);
  }

  // Meetings.

  /// The meetings that `block` comes to, also in the functions that it calls.
  void meetings_in(const Block& block, std::set<std::string>& out, std::set<std::string>& seen) const {
    for_each_statement(block, [&](const Statement& s) {
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

  void count_meetings() {
    for (const Statement* task : tasks_) {
      std::set<std::string> names, seen;
      meetings_in(task->body, names, seen);
      for (const std::string& name : names) ++code_.meetings[name];
    }
  }

  bool in_main_ = true;
};
}  // namespace

Code compile(const Program& program) {
  return Compiler(program).run();
}

}  // namespace polyarm::program
