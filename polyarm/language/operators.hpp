#pragma once
/// The operators of the language, and access to parts of values. Any thread.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/language/ast.hpp"

namespace polyarm::program {

/// Larger texts and lists are refused, so that no program exhausts the memory.
inline constexpr std::size_t kLongestText = 65536;
inline constexpr std::size_t kMostListItems = 10000;

/// The reason why an operation is impossible; the evaluator adds the place.
struct OperationError {
  std::string code;
  std::string what;
  std::string advice;
};

/// Throw OperationError. `and` and `or` take both sides here.
Value apply(Operator op, const Value& a, const Value& b);
Value apply(Operator op, const Value& a);
/// As `==` of programs compares: numbers up to their rounding, in lists and records, too; poses and joint
/// states exactly. Values of different kinds or units are unequal.
bool equal_values(const Value& a, const Value& b);
const Value& element(const Value& list, const Value& index);
/// A field of a record; x y z rx ry rz of a pose; a joint of a joint state.
Value field(const Value& of, const std::string& name);
/// Throw if a list would be too large or nested too deeply.
void require_fits(Value::Extent extent);
Value make_list(data::List items);
Value make_record(data::Record record);

/// One step from a value to one of its parts.
struct PathStep {
  std::string field;
  std::optional<Value> index;  ///< empty: the field
};
/// The index of the part of `whole`. Throws if there is none.
std::size_t part_at(const Value& whole, const PathStep& step);
/// Changes a part of `whole`; the part keeps its type and unit.
void replace(Value& whole, std::span<const PathStep> path, Value value);

/// True if a name with value `a` may change to `b`.
bool same_type(const Value& a, const Value& b);
/// "a boolean", "a length", "a number without unit".
std::string described(const Value& value);

/// The dimension of a product or quotient; empty if it has no name.
std::optional<Dimension> product(Dimension a, Dimension b);
std::optional<Dimension> quotient(Dimension a, Dimension b);

}  // namespace polyarm::program
