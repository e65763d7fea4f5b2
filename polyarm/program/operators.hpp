#pragma once
/// What the operators and functions of the language do to values.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/program/ast.hpp"

namespace polyarm::program {

/// Texts and lists larger than this are refused, so that no program eats the machine's memory.
inline constexpr std::size_t kLongestText = 65536;
inline constexpr std::size_t kMostListItems = 10000;

/// Why an operation is impossible; the evaluator adds where.
struct OperationError {
  std::string code;
  std::string what;
  std::string advice;
};

/// Throw OperationError. `and` and `or` take both sides as they are here.
Value apply(Operator op, const Value& a, const Value& b);
Value apply(Operator op, const Value& a);
const Value& element(const Value& list, const Value& index);
/// A field of a record; x y z rx ry rz of a pose; a joint of a joint state.
Value field(const Value& of, const std::string& name);
/// Throw where a list would be too large or lists stand in lists in lists.
void require_fits(Value::Extent extent);
Value make_list(data::List items);
Value make_record(data::Record record);

/// One step from a value to a part of it.
struct PathStep {
  std::string field;
  std::optional<Value> index;  ///< nothing: the field
};
/// Which of the parts of `whole` it goes to. Throws where there is none.
std::size_t part_at(const Value& whole, const PathStep& step);
/// Changes a part of `whole`; what is replaced keeps its type and unit.
void replace(Value& whole, std::span<const PathStep> path, Value value);

/// Whether a name that holds `a` may come to hold `b`.
bool same_type(const Value& a, const Value& b);
/// "a boolean", "a length", "a number without unit".
std::string described(const Value& value);

/// The dimension of a product or quotient; nothing where it has no name here.
std::optional<Dimension> product(Dimension a, Dimension b);
std::optional<Dimension> quotient(Dimension a, Dimension b);

}  // namespace polyarm::program
