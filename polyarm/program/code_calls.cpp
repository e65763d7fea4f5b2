#include "polyarm/language/functions.hpp"
#include "polyarm/program/code_writer.hpp"

namespace polyarm::program {

void CodeWriter::call(const Expression& e, Operand to) {
  const Temporaries inner(*this);
  try {
    const auto own = function_at_.find(e.name);
    if (own != function_at_.end()) return call_function(e, own->second, to);
    const Function* function = find_function(e.name);
    if (!function) throw OperationError{"unknown-function", "there is no function '" + e.name + "'", {}};
    call_builtin(e, *function, to);
  } catch (const OperationError& error) {
    refuse(e.place, error);
  }
}

void CodeWriter::move_to(Operand to, Operand from, Place place) {
  if (where(to) == Where::temporary && to == from) return;
  add(Op::load, place, {.a = to, .b = from});
}

/// The arguments are the first registers of the called function; its result is stored in the first of them.
void CodeWriter::call_function(const Expression& e, std::size_t which, Operand to) {
  const Bound bound = bind_arguments(signature_of(*functions_[which]), e.names);
  const Operand first = next();
  for (const int argument : bound.argument_of) {
    if (argument >= 0) {
      push(*e.parts[static_cast<std::size_t>(argument)]);
    } else {
      const Operand none = temporary();
      add(Op::absent, e.place, {.a = none});
    }
  }
  const int count = static_cast<int>(bound.argument_of.size());
  add(Op::call, e.place, {.a = index(first), .b = count, .c = static_cast<int>(which)});
  move_to(to, first, e.place);
}

void CodeWriter::call_builtin(const Expression& e, const Function& function, Operand to) {
  const Bound bound = bind_arguments(signature_of(function), e.names);
  if (function.name == "here") {
    add(Op::here, e.place, {.a = to});
    return;
  }
  if (function.name == "ask") return call_ask(e, bound, to);
  const int first = height();
  for (std::size_t i = 0; i < bound.argument_of.size(); ++i) {
    const int argument = bound.argument_of[i];
    if (argument >= 0) {
      push(*e.parts[static_cast<std::size_t>(argument)]);
      continue;
    }
    const FunctionParameter& parameter = function.parameters[i];
    const Dimension dimension = dimension_of(parameter.wanted).value_or(Dimension::none);
    const Operand from = constant(data::Number{*parameter.otherwise, dimension}), argument_ = temporary();
    add(Op::load, e.place, {.a = argument_, .b = from});
  }
  for (const int argument : bound.further) push(*e.parts[static_cast<std::size_t>(argument)]);
  add(function.call ? Op::builtin : Op::of_host, e.place,
      {.more = static_cast<std::uint16_t>(&function - functions().data()),
       .a = to,
       .b = first,
       .c = static_cast<int>(bound.argument_of.size() + bound.further.size()),
       .d = names(e.names)});
}

/// Repeats the question until the answer matches the example.
void CodeWriter::call_ask(const Expression& e, const Bound& bound, Operand to) {
  const int begin = here();
  const Operand like = next();
  if (bound.argument_of[1] < 0) {
    const Operand from = constant(std::string{});
    add(Op::load, e.place, {.a = temporary(), .b = from});
  } else {
    push(*e.parts[static_cast<std::size_t>(bound.argument_of[1])]);
  }
  const Operand question = push(*e.parts[static_cast<std::size_t>(bound.argument_of[0])]);
  add(Op::ask_value, e.place, {.a = like, .b = question});
  add(Op::answered, e.place, {.a = like, .d = begin});
  move_to(to, like, e.place);
}

}  // namespace polyarm::program
