#include "polyarm/program/code.hpp"

namespace polyarm::program {

namespace {
using Kind = Statement::Kind;

class Flattener {
 public:
  Code run(const Program& program) {
    block(program.statements);
    add(Op::finish, {static_cast<int>(program.lines.size()), 1});
    return std::move(code_);
  }

 private:
  struct Loop {
    int locals_in_body = 0, locals_outside = 0;
    std::vector<int> breaks, continues;
  };

  int here() const { return static_cast<int>(code_.size()); }
  int add(Op op, Place place, const Statement* statement = nullptr) {
    code_.push_back({op, place, statement, nullptr, -1, locals_});
    return here() - 1;
  }
  void land(int step) { code_[static_cast<std::size_t>(step)].target = here(); }

  /// The names that `statements` declare end with them.
  void block(const Block& statements) {
    const int before = locals_;
    for (const Statement& statement : statements) add_statement(statement);
    if (locals_ == before) return;
    locals_ = before;
    add(Op::keep_locals, code_.back().place);
  }

  void add_statement(const Statement& s) {
    switch (s.kind) {
      case Kind::load:
      case Kind::import:
        add(Op::load, s.place, &s);
        return;
      case Kind::set_literal:
        add(Op::set_literal, s.place, &s);
        return;
      case Kind::set:
        add(Op::set, s.place, &s);
        return;
      case Kind::let:
        add(Op::let, s.place, &s), ++locals_;
        return;
      case Kind::move:
        add(Op::move, s.place, &s);
        return;
      case Kind::wait_time:
        add(Op::wait_time, s.place, &s);
        return;
      case Kind::wait:
        add_wait(s);
        return;
      case Kind::ask:
        add(Op::ask, s.place, &s);
        return;
      case Kind::while_loop:
        add_while(s);
        return;
      case Kind::branch:
        add_branches(s);
        return;
      case Kind::for_loop:
        add_for(s);
        return;
      case Kind::break_loop:
        leave(s, loops_.back().locals_outside, loops_.back().breaks);
        return;
      case Kind::continue_loop:
        leave(s, loops_.back().locals_in_body, loops_.back().continues);
        return;
      case Kind::stop:
        add(Op::stop, s.place, &s);
        return;
      case Kind::log:
        add(Op::log, s.place, &s);
        return;
      case Kind::call:
        add(Op::call, s.place, &s);
        return;
    }
  }

  /// On timeout the step jumps to its target: the block after `else`.
  void add_wait(const Statement& s) {
    const int wait = add(Op::wait, s.place, &s);
    if (!s.has_else) return;
    const int skip = add(Op::jump, s.place);
    land(wait);
    block(s.body);
    land(skip);
  }

  int add_condition(const Expression& condition, const Statement& s, Place place) {
    const int step = add(Op::jump_unless, place, &s);
    code_.back().expression = &condition;
    return step;
  }

  void add_while(const Statement& s) {
    const bool outermost = loops_.empty();
    const int start = add_condition(*s.expression, s, s.place);
    loops_.push_back({locals_, locals_, {}, {}});
    block(s.body);
    for (const int step : loops_.back().continues) land(step);
    const int pass = outermost ? add(Op::pass, s.place, &s) : -1;
    code_[static_cast<std::size_t>(add(Op::jump, s.place))].target = start;
    land(start);
    if (outermost) land(pass);
    for (const int step : loops_.back().breaks) land(step);
    loops_.pop_back();
  }

  void add_for(const Statement& s) {
    const int outside = locals_;
    add(Op::for_begin, s.place, &s);
    locals_ += 3;
    const int next = add(Op::for_next, s.place, &s);
    loops_.push_back({locals_, outside + 3, {}, {}});
    block(s.body);
    for (const int step : loops_.back().continues) land(step);
    code_[static_cast<std::size_t>(add(Op::jump, s.place))].target = next;
    land(next);
    for (const int step : loops_.back().breaks) land(step);
    loops_.pop_back();
    locals_ = outside;
    add(Op::keep_locals, s.place);
  }

  void leave(const Statement& s, int locals, std::vector<int>& jumps) {
    code_[static_cast<std::size_t>(add(Op::keep_locals, s.place))].locals = locals;
    jumps.push_back(add(Op::jump, s.place, &s));
  }

  void add_branches(const Statement& s) {
    std::vector<int> ends;
    for (const Branch& branch : s.branches) {
      const int unless = branch.condition ? add_condition(*branch.condition, s, branch.place) : -1;
      block(branch.body);
      if (&branch != &s.branches.back()) ends.push_back(add(Op::jump, branch.place));
      if (unless >= 0) land(unless);
    }
    for (const int step : ends) land(step);
  }

  Code code_;
  int locals_ = 0;
  std::vector<Loop> loops_;
};
}  // namespace

Code flatten(const Program& program) {
  return Flattener().run(program);
}

}  // namespace polyarm::program
