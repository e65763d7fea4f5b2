#pragma once
/// The built-in functions of the language: one list for the interpreter, the checker and the reference.
/// Const: any thread.
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/language/operators.hpp"

namespace polyarm::program {

/// The required type of an argument. `joint` is the position of a joint: an angle or a length.
enum class Wanted { any, number, length, angle, scalar, text, list, list_or_text, pose, place, joints, joint };

/// Functions of the running program: their results depend on when they are called.
enum class Live {
  none,
  random,
  clock,
  here_joints,
  ik,
  fk,
  force,
  wrench,
  zero_force,
  met,
  travelled,
  comply,
  stiff,
  next_part,
  waiting_parts,
  missed_parts,
  add_part,
  rows_of,
  is_connected,
  has_line,
  next_line,
  send_text
};

struct FunctionParameter {
  std::string_view name;
  Wanted wanted = Wanted::any;
  std::optional<double> otherwise;  ///< default, in SI; empty: required
};

/// A list that is produced value by value.
struct Series {
  std::size_t count = 0;
  std::function<Value(std::size_t)> at;
};

struct Function {
  std::string_view name;
  std::string_view signature;  ///< for display: "offset(p, x = 0mm, …)"
  std::string_view meaning;
  std::vector<FunctionParameter> parameters;
  /// Accepts more values of the last parameter's type; with `named` each may have a name.
  bool more = false, named = false;
  /// The kind of its result; empty: that of its first argument.
  std::optional<data::Kind> gives;
  std::optional<Dimension> dimension;  ///< of a number
  /// The arguments are complete and have the required types. `names` are those of named arguments. Null: the
  /// host executes it.
  Value (*call)(std::span<const Value> arguments, std::span<const std::string> names) = nullptr;
  bool in_tests = false;  ///< available only in tests
  /// For results that may be long lists: as `call`, but produces the list value by value. Owns its data.
  Series (*series)(std::span<const Value> arguments) = nullptr;
  Live live = Live::none;  ///< the running program executes it; `call` is null
  bool waits = false;      ///< a live function that waits until queued motion has arrived
  bool one_frame = false;  ///< it compares poses, which must be in one frame
  bool open = false;       ///< a live function whose result differs between runs of one program
};

/// The function of that name, in any case, or nullptr. Includes here() and ask(), which only the interpreter
/// can call.
const Function* find_function(std::string_view name);
std::vector<std::string> function_names();
const std::vector<Function>& functions();

/// Throws OperationError if `value` does not have the required type.
void require(const Function& function, std::size_t place, const Value& value);
/// Of a number that is wanted with a certain unit, or without one. Of a joint: an angle, which most have.
std::optional<Dimension> dimension_of(Wanted wanted);
/// "a length", "a pose".
const char* name(Wanted wanted);

/// The assignment of a call's arguments to parameters.
struct Bound {
  std::vector<int> argument_of;  ///< for each parameter its argument, or -1
  std::vector<int> further;      ///< arguments after the parameters
};
/// Throws OperationError: too many or too few arguments, an unknown name, or a repeated one.
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
