#include "polyarm/language/operators.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/unit_advice.hpp"
#include "polyarm/data/point_frames.hpp"
#include "polyarm/language/rounding.hpp"

namespace polyarm::program {

using data::Kind;
using data::List;
using data::Number;

namespace {
[[noreturn]] void refuse(std::string what, std::string advice = {}) {
  throw OperationError{"bad-type", std::move(what), std::move(advice)};
}

std::string pair(const Value& a, const Value& b) {
  return described(a) + " and " + described(b);
}

/// Of two numbers of different dimensions.
std::string same_unit_advice(const Number& a, const Number& b) {
  if (a.dimension == Dimension::none) return unit_advice(b.dimension, a.value);
  if (b.dimension == Dimension::none) return unit_advice(a.dimension, b.value);
  return "give both the same kind of unit";
}

Value number(double value, Dimension dimension) {
  if (!std::isfinite(value)) throw OperationError{"overflow", "the result is not a finite number", {}};
  return Number{value, dimension};
}

static_assert(kLongestText == bounds::kTextBytes && kMostListItems == bounds::kListValues);

Value join_texts(const std::string& a, const std::string& b) {
  if (a.size() + b.size() > kLongestText)
    throw OperationError{
        "too-long", "this text would be longer than " + std::to_string(kLongestText) + " bytes", {}};
  return a + b;
}

Value join_lists(const List& a, const List& b) {
  List out = a;
  out.insert(out.end(), b.begin(), b.end());
  return make_list(std::move(out));
}

Value add(const Value& a, const Value& b) {
  if (a.as_text() && b.as_text()) return join_texts(*a.as_text(), *b.as_text());
  if (a.as_list() && b.as_list()) return join_lists(*a.as_list(), *b.as_list());
  const Number *x = a.as_number(), *y = b.as_number();
  if (!x || !y)
    refuse("'+' joins two numbers, two texts or two lists, here are " + pair(a, b),
           a.as_text() || b.as_text() ? "write \"…{value}…\" to put a value into a text" : "");
  if (x->dimension != y->dimension) refuse("'+' cannot add " + pair(a, b), same_unit_advice(*x, *y));
  return number(x->value + y->value, x->dimension);
}

struct NumberPair {
  Number a, b;
};

NumberPair numbers(Operator op, const Value& a, const Value& b) {
  if (!a.as_number() || !b.as_number())
    refuse(std::string("'") + spelling(op) + "' needs two numbers, here are " + pair(a, b));
  return {*a.as_number(), *b.as_number()};
}

NumberPair alike(Operator op, const Value& a, const Value& b) {
  const NumberPair out = numbers(op, a, b);
  if (out.a.dimension != out.b.dimension)
    refuse(std::string("'") + spelling(op) + "' cannot take " + pair(a, b), same_unit_advice(out.a, out.b));
  return out;
}

void refuse_zero(const Number& divisor, Operator op) {
  if (divisor.value == 0) throw OperationError{"zero", std::string("'") + spelling(op) + "' by zero", {}};
}

Value multiply(const Value& a, const Value& b) {
  if (a.as_point() && b.as_point())
    return data::in_frame_of(*a.as_point(), a.as_point()->pose * b.as_point()->pose);
  const auto [x, y] = numbers(Operator::multiply, a, b);
  const auto dimension = product(x.dimension, y.dimension);
  if (!dimension)
    refuse("the product of " + pair(a, b) + " has no unit here", "divide by a unit first, such as d / 1mm");
  return number(x.value * y.value, *dimension);
}

Value divide(const Value& a, const Value& b) {
  const auto [x, y] = numbers(Operator::divide, a, b);
  refuse_zero(y, Operator::divide);
  const auto dimension = quotient(x.dimension, y.dimension);
  if (!dimension)
    refuse("the quotient of " + pair(a, b) + " has no unit here", "divide by a unit first, such as d / 1mm");
  return number(x.value / y.value, *dimension);
}

Value modulo(const Value& a, const Value& b) {
  const auto [x, y] = alike(Operator::modulo, a, b);
  refuse_zero(y, Operator::modulo);
  const double rest = unrounded_rest(std::fmod(x.value, y.value), x.value, y.value);
  return number(rest != 0 && (rest < 0) != (y.value < 0) ? rest + y.value : rest + 0.0, x.dimension);
}

Value power(const Value& a, const Value& b) {
  const auto [x, y] = numbers(Operator::power, a, b);
  if (x.dimension != Dimension::none || y.dimension != Dimension::none)
    refuse("'^' takes numbers without unit, here are " + pair(a, b),
           "divide by a unit first, such as d / 1mm");
  return number(std::pow(x.value, y.value), Dimension::none);
}

Value compare(Operator op, const Value& a, const Value& b) {
  if (a.as_text() && b.as_text()) {
    const int order = a.as_text()->compare(*b.as_text());
    return op == Operator::less         ? order < 0
           : op == Operator::less_equal ? order <= 0
           : op == Operator::greater    ? order > 0
                                        : order >= 0;
  }
  const auto [x, y] = alike(op, a, b);
  switch (op) {
    case Operator::less:
      return less_number(x.value, y.value);
    case Operator::less_equal:
      return !less_number(y.value, x.value);
    case Operator::greater:
      return less_number(y.value, x.value);
    default:
      return !less_number(x.value, y.value);
  }
}

bool equal(Operator op, const Value& a, const Value& b) {
  if (a.kind() != b.kind()) refuse(std::string("'") + spelling(op) + "' cannot compare " + pair(a, b));
  if (a.as_number()) alike(op, a, b);
  return equal_values(a, b);
}

bool boolean(Operator op, const Value& value) {
  if (!value.as_boolean())
    refuse(std::string("'") + spelling(op) + "' needs True or False, here is " + described(value));
  return *value.as_boolean();
}

struct Triple {
  Dimension a, b, product;
};
constexpr std::array kTriples = {
    Triple{Dimension::speed, Dimension::time, Dimension::length},
    Triple{Dimension::acceleration, Dimension::time, Dimension::speed},
    Triple{Dimension::angular_speed, Dimension::time, Dimension::angle},
    Triple{Dimension::angular_acceleration, Dimension::time, Dimension::angular_speed},
    Triple{Dimension::rate, Dimension::time, Dimension::none},
    Triple{Dimension::force, Dimension::length, Dimension::torque},
    Triple{Dimension::mass, Dimension::acceleration, Dimension::force},
};
}  // namespace

bool equal_values(const Value& a, const Value& b) {
  const Number *x = a.as_number(), *y = b.as_number();
  if (x && y) return x->dimension == y->dimension && equal_numbers(x->value, y->value);
  if (const List* p = a.as_list(), *q = b.as_list(); p && q)
    return std::equal(p->begin(), p->end(), q->begin(), q->end(), &equal_values);
  const data::Record *of = a.as_record(), *other = b.as_record();
  if (!of || !other) return a == b;
  bool out = of->names.size() == other->names.size();
  for (std::size_t i = 0; out && i < of->names.size(); ++i) {
    const Value* part = other->find(of->names[i]);
    out = part && equal_values(of->values[i], *part);
  }
  return out;
}

std::optional<Dimension> product(Dimension a, Dimension b) {
  if (a == Dimension::none) return b;
  if (b == Dimension::none) return a;
  for (const Triple& t : kTriples)
    if ((t.a == a && t.b == b) || (t.a == b && t.b == a)) return t.product;
  return std::nullopt;
}

std::optional<Dimension> quotient(Dimension a, Dimension b) {
  if (b == Dimension::none) return a;
  if (a == b) return Dimension::none;
  for (const Triple& t : kTriples) {
    if (t.product == a && t.b == b) return t.a;
    if (t.product == a && t.a == b) return t.b;
  }
  return std::nullopt;
}

Value apply(Operator op, const Value& a, const Value& b) {
  switch (op) {
    case Operator::logical_or:
      return boolean(op, a) | boolean(op, b) ? true : false;
    case Operator::logical_and:
      return boolean(op, a) & boolean(op, b) ? true : false;
    case Operator::equal:
      return equal(op, a, b);
    case Operator::unequal:
      return !equal(op, a, b);
    case Operator::less:
    case Operator::less_equal:
    case Operator::greater:
    case Operator::greater_equal:
      return compare(op, a, b);
    case Operator::add:
      return add(a, b);
    case Operator::multiply:
      return multiply(a, b);
    case Operator::divide:
      return divide(a, b);
    case Operator::modulo:
      return modulo(a, b);
    case Operator::power:
      return power(a, b);
    default:
      break;
  }
  const auto [x, y] = alike(Operator::subtract, a, b);
  return number(x.value - y.value, x.dimension);
}

Value apply(Operator op, const Value& a) {
  if (op == Operator::logical_not) return !boolean(op, a);
  if (!a.as_number()) refuse("'-' needs a number, here is " + described(a));
  return Number{-a.as_number()->value, a.as_number()->dimension};
}

namespace {
std::size_t place_in(const List& items, const Value& index) {
  const Number* number = index.as_number();
  const double at = number ? unrounded(number->value) : 0;
  if (!number || number->dimension != Dimension::none || !is_whole(at))
    refuse("the index of a list is a whole number, here is " + index.excerpt());
  if (at < 1 || at > static_cast<double>(items.size()))
    throw OperationError{
        "no-element", "there is no element " + index.text() + " in a list of " + std::to_string(items.size()),
        at == 0 ? "the first element is 1" : ""};
  return static_cast<std::size_t>(at) - 1;
}

[[noreturn]] void refuse_field(const data::Record& record, const std::string& name) {
  throw OperationError{"unknown-name",
                       "there is no '" + name + "' in this record" + did_you_mean(name, record.names),
                       record.names.empty() ? "it is empty" : "it has " + join(record.names, ", ")};
}

std::optional<Value> part_of_pose(const Pose& pose, std::string_view name) {
  if (name == "x") return Number{pose.position.x, Dimension::length};
  if (name == "y") return Number{pose.position.y, Dimension::length};
  if (name == "z") return Number{pose.position.z, Dimension::length};
  const Vec3 rpy = to_rpy(pose.rotation);
  if (name == "rx") return Number{rpy.x, Dimension::angle};
  if (name == "ry") return Number{rpy.y, Dimension::angle};
  if (name == "rz") return Number{rpy.z, Dimension::angle};
  return std::nullopt;
}
}  // namespace

const Value& element(const Value& list, const Value& index) {
  const List* items = list.as_list();
  if (!items) refuse("only a list has elements, here is " + described(list));
  return (*items)[place_in(*items, index)];
}

Value field(const Value& of, const std::string& name) {
  if (const data::Record* record = of.as_record()) {
    if (const Value* found = record->find(name)) return *found;
    refuse_field(*record, name);
  }
  if (const data::Point* point = of.as_point()) {
    if (const auto part = part_of_pose(point->pose, name)) return *part;
    refuse("a pose has x y z rx ry rz, and no '" + name + "'");
  }
  const data::JointState* const joints = of.as_joints();
  if (const double* joint = joints ? joints->find(name) : nullptr) {
    const bool slides =
        joints->given_at(static_cast<std::size_t>(joint - joints->positions.data())) == Dimension::length;
    return Number{*joint, slides ? Dimension::length : Dimension::angle};
  }
  refuse(described(of) + " has no '" + name + "'");
}

std::size_t part_at(const Value& whole, const PathStep& step) {
  if (step.index) {
    if (!whole.as_list()) refuse("only a list has elements, here is " + described(whole));
    return place_in(*whole.as_list(), *step.index);
  }
  const data::Record* record = whole.as_record();
  if (!record) refuse("only a record has fields that can be set, here is " + described(whole));
  const auto at = std::find(record->names.begin(), record->names.end(), step.field);
  if (at == record->names.end()) refuse_field(*record, step.field);
  return static_cast<std::size_t>(at - record->names.begin());
}

namespace {
void refuse_other_type(const Value& present, const Value& value) {
  if (same_type(present, value)) return;
  refuse("this is " + described(present) + " (" + present.excerpt(60) + ") and cannot become " +
             described(value) + " (" + value.excerpt(60) + ")",
         "a name keeps its type and unit");
}

/// The extent of `whole` after the replacement of a part at this depth.
Value::Extent extent_with(const Value& whole, std::size_t deep, Value::Extent before, Value::Extent after) {
  const Value::Extent now = whole.extent();
  const auto levels = static_cast<std::uint32_t>(deep);
  return {now.values - before.values + after.values, std::max(now.depth, levels + after.depth)};
}
}  // namespace

/// A new list or record may make the whole too large: the old part is kept until that is known.
void replace(Value& whole, std::span<const PathStep> path, Value value) {
  std::vector<Value*> above;
  Value* part = &whole;
  for (const PathStep& step : path) {
    const std::size_t at = part_at(*part, step);
    above.push_back(part);
    part = &(*part->own_parts())[at];
  }
  refuse_other_type(*part, value);
  Value::Extent before = part->extent(), after = value.extent();
  const bool same_size = before.values == after.values && before.depth == after.depth;
  if (!same_size) require_fits(extent_with(whole, above.size(), before, after));
  *part = std::move(value);
  for (auto each = above.rbegin(); each != above.rend() && !same_size; ++each) {
    const Value::Extent was = (*each)->extent();
    (*each)->replaced(before, after);
    before = was, after = (*each)->extent();
  }
}

bool same_type(const Value& a, const Value& b) {
  if (a.is_place() && b.is_place()) return true;
  if (a.kind() != b.kind()) return false;
  return !a.as_number() || a.as_number()->dimension == b.as_number()->dimension;
}

void require_fits(Value::Extent extent) {
  constexpr std::uint32_t kDeepest = 8;
  if (extent.depth > kDeepest) throw OperationError{"too-deep", "lists are nested more than 8 deep", {}};
  if (extent.values > kMostListItems + 1)
    throw OperationError{
        "too-long", "this list would hold more than " + std::to_string(kMostListItems) + " values", {}};
}

namespace {
Value bounded(Value out) {
  require_fits(out.extent());
  return out;
}
}  // namespace

Value make_list(List items) {
  return bounded(Value(std::move(items)));
}

Value make_record(data::Record record) {
  return bounded(Value(std::move(record)));
}

std::string described(const Value& value) {
  const Number* number = value.as_number();
  if (!number) return data::name(value.kind());
  return number->dimension == Dimension::none ? "a number without unit" : name(number->dimension);
}

}  // namespace polyarm::program
