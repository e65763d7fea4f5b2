#include "polyarm/program/compiler.hpp"

/// Statements that control the flow: loops, branches, functions, errors.
namespace polyarm::program {

void Compiler::while_loop(const Statement& s) {
  const bool outermost = scope_.loops.empty() && scope_.counts_passes;
  const int start = here();
  std::vector<int> ends;
  jump_unless(*s.expression, ends);
  scope_.loops.push_back({depths(), depths(), {}, {}});
  compile_block(s.body);
  statement_ = &s, line_ = s.place;
  land(scope_.loops.back().continues);
  if (outermost) ends.push_back(add(Op::pass, s.place));
  jump_to(start, s.place);
  land(ends);
  land(scope_.loops.back().breaks);
  scope_.loops.pop_back();
}

/// The first value is requested once at the top, further ones at the end of every pass.
void Compiler::for_loop(const Statement& s) {
  const Depths outside = depths();
  const bool named_place = !s.second_name.empty();
  const int slot = height();
  {
    const Temporaries inner(*this);
    push(*s.expression);
    if (s.second) push(*s.second);
    need(slot + 4);
    const Expression& over = s.second ? *s.second : *s.expression;
    add(Op::for_begin, over.place, {.a = slot, .b = named_place ? 1 : 0, .c = s.second ? 1 : 0, .d = 1});
  }
  declare("");
  declare("");
  if (named_place) declare(s.second_name);
  declare(s.name);
  begins_ = true;
  const int next = add(Op::for_next, s.place, {.a = slot, .b = named_place ? 1 : 0});
  scope_.loops.push_back({depths(), outside, {}, {}});
  compile_block(s.body);
  statement_ = &s, line_ = s.place;
  land(scope_.loops.back().continues);
  begins_ = true;
  add(Op::for_again, s.place, {.a = slot, .b = named_place ? 1 : 0, .d = next + 1});
  land(next);
  const Depths inside = depths();
  forget(outside.locals);
  leave(inside, outside, s.place);
  land(scope_.loops.back().breaks);
  scope_.loops.pop_back();
}

void Compiler::leave_loop(const Statement& s, bool breaks) {
  if (scope_.loops.empty()) return refuse(s.place, {"no-loop", "this is not in a loop", {}});
  Loop& loop = scope_.loops.back();
  leave(depths(), breaks ? loop.outside : loop.body, s.place);
  (breaks ? loop.breaks : loop.continues).push_back(add(Op::jump, s.place));
}

void Compiler::branches(const Statement& s) {
  std::vector<int> ends;
  for (const Branch& branch : s.branches) {
    statement_ = &s, line_ = branch.place;
    std::vector<int> others;
    if (branch.condition) jump_unless(*branch.condition, others);
    compile_block(branch.body);
    if (&branch != &s.branches.back()) ends.push_back(add(Op::jump, branch.place));
    land(others);
  }
  land(ends);
  begins_ = false;
}

void Compiler::give(const Statement& s) {
  const Temporaries inner(*this);
  Operand result = kNone;
  if (s.expression) {
    result = read(*s.expression);
  } else {
    result = temporary();
    add(Op::absent, s.place, {.a = result});
  }
  add(Op::give, s.place, {.b = result, .c = function_});
}

/// The retry counter lies below the variables of the try and its handler, the error above it.
void Compiler::try_block(const Statement& s) {
  const Depths outside = depths();
  const Operand none = constant(0);
  add(Op::load, s.place, {.a = next(), .b = none});
  Handler handler;
  handler.count_slot = declare("");
  handler.outside = depths();
  handler.begin = here();
  begins_ = true;
  need(handler.count_slot + 2);
  const int begin = add(Op::try_begin, s.place, {.a = handler.count_slot + 1});
  ++scope_.depths.handlers;
  compile_block(s.body);
  add(Op::try_end, line_);
  --scope_.depths.handlers;
  const int skip = add(Op::jump, s.place);
  land(begin);
  handler.error_slot = declare(s.name);
  code_.depths.push_back(depths());  // gives back the locks of the body, when the robots have arrived
  add(Op::leave, s.handler_place, {.a = static_cast<int>(code_.depths.size()) - 1, .b = depths().locals});
  scope_.handlers.push_back(handler);
  compile_block(s.handler);
  scope_.handlers.pop_back();
  Depths inside = outside;
  inside.locals = height();
  forget(outside.locals);
  land(skip);
  leave(inside, outside, line_);
}

void Compiler::raise(const Statement& s) {
  const Temporaries inner(*this);
  if (s.expression) {
    const Operand error = read(*s.expression);
    add(Op::raise, s.place, {.b = error});
  } else if (!scope_.handlers.empty()) {
    add(Op::raise_again, s.place, {.b = operand(Where::local, scope_.handlers.back().error_slot)});
  }
}

void Compiler::retry(const Statement& s) {
  if (scope_.handlers.empty()) return;
  const Temporaries inner(*this);
  const Handler& handler = scope_.handlers.back();
  const Operand most = s.expression ? read(*s.expression) : constant(1);
  code_.depths.push_back(handler.outside);
  add(Op::retry, s.place,
      {.a = handler.count_slot,
       .b = most,
       .c = static_cast<int>(code_.depths.size()) - 1,
       .d = handler.begin});
}

}  // namespace polyarm::program
