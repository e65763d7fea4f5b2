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
Value call(std::string_view function, std::span<const Value> arguments);
Value element(const Value& list, const Value& index);
/// Throws where a list would be too large or lists stand in lists in lists.
Value make_list(data::List items);

struct Function {
  std::string_view name;
  std::size_t least, most;  ///< how many arguments it takes
};
/// The function, or nullptr.
const Function* find_function(std::string_view name);
std::vector<std::string> function_names();

/// The dimension of a product or quotient; nothing where it has no name here.
std::optional<Dimension> product(Dimension a, Dimension b);
std::optional<Dimension> quotient(Dimension a, Dimension b);

}  // namespace polyarm::program
