#pragma once
/// Values of expressions in xacro and launch files: the Python types that they use. Used by this room and by
/// `ros_files`.
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

/// Tuples are lists that are printed and compared as tuples.
struct XacroList : std::vector<XacroValue> {
  using std::vector<XacroValue>::vector;
  bool is_tuple = false;
};

/// A function or type by name, as an argument of map() or isinstance().
struct XacroFunction {
  std::string name;
};

/// A Python value: None, bool, int, float, str, list (also for sets), tuple, dict, a name space of
/// properties, or a function.
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

/// As Python's str() and repr() print it.
std::string str_of(const XacroValue& value);
std::string repr_of(const XacroValue& value);
bool truth_of(const XacroValue& value);
/// A float as Python prints it: the shortest text that reads back the same.
std::string float_text(double value);
/// A deep copy of lists and dictionaries.
XacroValue copy_of(const XacroValue& value);
/// "5" → 5, "0.5" → 0.5, "true" → True, "'text'" → text; else the text itself.
XacroValue literal_of(const XacroValue& value);

/// The names that an expression may use.
struct XacroNames {
  /// Looks up a property; false if it does not exist.
  std::function<bool(const std::string& name, XacroValue& out)> property;
  /// Calls a function of xacro itself ("load_yaml", "arg", "find", "env", …); false if it does not exist.
  std::function<bool(const std::string& name, const XacroList& arguments, XacroValue& out)> function;
  /// Looks up a property of a name space.
  std::function<bool(const XacroScope* space, const std::string& name, XacroValue& out)> member;
};

/// Evaluates the text inside ${…}. Throws an Error without a place. An expression cannot run code, can read
/// files only through `function`, and always terminates.
XacroValue evaluate_expression(std::string_view text, const XacroNames& names);

}  // namespace polyarm::description
