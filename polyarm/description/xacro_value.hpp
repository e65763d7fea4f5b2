#pragma once
/// Values of xacro expressions: what Python has that descriptions use. Private to the room.
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace polyarm::description {

struct XacroScope;
struct XacroValue;
using XacroDict = std::vector<std::pair<XacroValue, XacroValue>>;

/// Tuples are lists that are written and compared as tuples.
struct XacroList : std::vector<XacroValue> {
  using std::vector<XacroValue>::vector;
  bool is_tuple = false;
};

/// A function or a type by its name, as it is given to map() or isinstance().
struct XacroFunction {
  std::string name;
};

/// none, bool, int, float, str, list (also for sets), tuple, dict, a name space of properties, or a function.
struct XacroValue {
  std::variant<std::monostate, bool, std::int64_t, double, std::string, std::shared_ptr<XacroList>,
               std::shared_ptr<XacroDict>, const XacroScope*, XacroFunction>
      data;

  XacroValue() = default;
  template <typename T>
  XacroValue(T value) : data(std::move(value)) {}  // NOLINT: values are written as they are

  const std::string* text() const { return std::get_if<std::string>(&data); }
  const XacroList* list() const {
    const auto* found = std::get_if<std::shared_ptr<XacroList>>(&data);
    return found ? found->get() : nullptr;
  }
  const XacroDict* dict() const {
    const auto* found = std::get_if<std::shared_ptr<XacroDict>>(&data);
    return found ? found->get() : nullptr;
  }
  bool is_number() const {
    return std::holds_alternative<std::int64_t>(data) || std::holds_alternative<double>(data) ||
           std::holds_alternative<bool>(data);
  }
};

/// As Python's str() and repr() write it.
std::string str_of(const XacroValue& value);
std::string repr_of(const XacroValue& value);
bool truth_of(const XacroValue& value);
/// A float as Python writes it: the shortest that reads back the same.
std::string float_text(double value);
/// The same in lists and dictionaries of its own.
XacroValue copy_of(const XacroValue& value);
/// "5" → 5, "0.5" → 0.5, "true" → True, "'text'" → text; else the text itself.
XacroValue literal_of(const XacroValue& value);

/// What an expression may reach.
struct XacroNames {
  /// A property, or nothing when there is none of that name.
  std::function<bool(const std::string& name, XacroValue& out)> property;
  /// A function of xacro itself ("load_yaml", "arg", "find", "env", …); false when there is none.
  std::function<bool(const std::string& name, const XacroList& arguments, XacroValue& out)> function;
  /// A property of a name space.
  std::function<bool(const XacroScope* space, const std::string& name, XacroValue& out)> member;
};

/// Evaluates what stands in ${…}. Throws Error without a place for what is wrong. Nothing in it runs code,
/// reads files beside what `function` does, or takes for ever.
XacroValue evaluate_expression(std::string_view text, const XacroNames& names);

}  // namespace polyarm::description
