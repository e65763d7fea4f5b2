#pragma once
/// The functions that every program has: one list for the interpreter, the checker and the reference.
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/program/operators.hpp"

namespace polyarm::program {

/// What a function takes in one place.
enum class Wanted { any, number, length, angle, scalar, text, list, list_or_text, pose, place };

struct FunctionParameter {
  std::string_view name;
  Wanted wanted = Wanted::any;
  std::optional<double> otherwise;  ///< where it is left out, in SI; nothing: it must be given
};

/// A list that is made value by value.
struct Series {
  std::size_t count = 0;
  std::function<Value(std::size_t)> at;
};

struct Function {
  std::string_view name;
  std::string_view signature;  ///< for people: "offset(p, x = 0mm, …)"
  std::string_view meaning;
  std::vector<FunctionParameter> parameters;
  /// Further values of the last parameter's type may follow; with `named` each may have a name.
  bool more = false, named = false;
  /// What it gives; nothing: what its first argument is.
  std::optional<data::Kind> gives;
  std::optional<Dimension> dimension;  ///< of a number
  /// The arguments are complete and of the wanted types. `names` are those of named arguments. Null: the host
  /// does it.
  Value (*call)(std::span<const Value> arguments, std::span<const std::string> names) = nullptr;
  bool in_tests = false;  ///< only there
  /// Where the result may be a long list: as `call`, to be made value by value. Owns what it needs.
  Series (*series)(std::span<const Value> arguments) = nullptr;
};

/// The function of that name, in any case, or nullptr. here() and ask() are among them, which only the
/// interpreter can call.
const Function* find_function(std::string_view name);
std::vector<std::string> function_names();
const std::vector<Function>& functions();

/// Whether `value` is what is wanted; if not, throws OperationError.
void require(const Function& function, std::size_t place, const Value& value);
/// "a length", "a pose".
const char* name(Wanted wanted);

/// Which argument of a call goes to which parameter.
struct Bound {
  std::vector<int> argument_of;  ///< of each parameter its argument, or -1
  std::vector<int> further;      ///< arguments behind the parameters
};
/// Throws OperationError: too many, too few, no such name, one twice.
struct Signature {
  std::string name;
  std::vector<std::string> parameters;
  std::vector<bool> optional;
  bool more = false, named = false;
};
Signature signature_of(const Function& function);
Signature signature_of(const Statement& function);
Bound bind_arguments(const Signature& signature, std::span<const std::string> argument_names);

}  // namespace polyarm::program
