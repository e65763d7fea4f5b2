#include "polyarm/program/evaluator.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/program/operators.hpp"

namespace polyarm::program {

Local* Frame::find(std::string_view name) {
  const auto at =
      std::find_if(locals.rbegin(), locals.rend(), [&](const Local& l) { return l.name == name; });
  return at == locals.rend() || name.empty() ? nullptr : &*at;
}

const Local* Frame::find(std::string_view name) const {
  return const_cast<Frame*>(this)->find(name);
}

void Evaluator::fail(Place place, std::string code, std::string what, std::string advice) const {
  throw Error(Problem{std::move(code), program_.at(place), std::move(what), std::move(advice)});
}

Value Evaluator::value(const Expression& expression) const {
  try {
    return dispatch(expression);
  } catch (const OperationError& error) {
    fail(expression.place, error.code, error.what, error.advice);
  }
}

Value Evaluator::dispatch(const Expression& expression) const {
  using Kind = Expression::Kind;
  const auto& parts = expression.parts;
  switch (expression.kind) {
    case Kind::literal:
      return expression.value;
    case Kind::name:
      return name(expression);
    case Kind::unary:
      return apply(expression.op, value(*parts[0]));
    case Kind::binary:
      return binary(expression);
    case Kind::call:
      return call(expression.name, values(parts));
    case Kind::index:
      return element(value(*parts[0]), value(*parts[1]));
    case Kind::list:
      return make_list(values(parts));
    case Kind::joined:
      break;
  }
  Value text = std::string{};
  for (const ExpressionPtr& part : parts) text = apply(Operator::add, text, Value(value(*part).text()));
  return text;
}

Value Evaluator::name(const Expression& expression) const {
  const std::string& wanted = expression.name;
  if (const Local* local = frame_.find(wanted)) return local->value;
  if (const Value* found = host_.find(wanted)) return *found;
  auto names = host_.names();
  for (const Local& local : frame_.locals) names.push_back(local.name);
  fail(expression.place, "unknown-name",
       "there is nothing called '" + wanted + "'" + did_you_mean(wanted, names),
       "names are data, points, tags and what `let` made");
}

Value Evaluator::binary(const Expression& expression) const {
  const Expression& right = *expression.parts[1];
  Value left = value(*expression.parts[0]);
  const bool settles = left.as_boolean() && ((expression.op == Operator::logical_or && *left.as_boolean()) ||
                                             (expression.op == Operator::logical_and && !*left.as_boolean()));
  return settles ? left : apply(expression.op, left, value(right));
}

std::vector<Value> Evaluator::values(const std::vector<ExpressionPtr>& parts) const {
  std::vector<Value> out;
  out.reserve(parts.size());
  for (const ExpressionPtr& part : parts) out.push_back(value(*part));
  return out;
}

bool Evaluator::boolean(const Expression& expression, const std::string& of) const {
  const Value result = value(expression);
  if (const bool* truth = result.as_boolean()) return *truth;
  fail(expression.place, "bad-type",
       "the condition of '" + of + "' is " + data::name(result.kind()) + " (" + result.text().substr(0, 60) +
           "), True or False was expected");
}

Nanoseconds Evaluator::time(const Expression& expression, bool bare_seconds) const {
  return time(value(expression), expression.place, bare_seconds);
}

Nanoseconds Evaluator::time(const Value& value, Place place, bool bare_seconds) const {
  constexpr double kLongest = 1e9;  // about 30 years, in seconds
  const data::Number* number = value.as_number();
  const bool fits = number && (number->dimension == Dimension::time ||
                               (bare_seconds && number->dimension == Dimension::none));
  if (!fits)
    fail(place, "bad-type", "a time was expected, here is " + value.text().substr(0, 60),
         number && number->dimension == Dimension::none ? "say the unit, such as " + value.text() + "s" : "");
  if (number->value < 0) fail(place, "bad-value", "a time cannot be negative: " + value.text());
  return nanoseconds(std::min(number->value, kLongest));
}

}  // namespace polyarm::program
