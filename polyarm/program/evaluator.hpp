#pragma once
/// The value of an expression, from local names and the host's data.
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/program/ast.hpp"
#include "polyarm/program/host.hpp"

namespace polyarm::program {

/// A name made by `let` or `for`. Names that no program can write hold the state of a for loop.
struct Local {
  std::string name;
  Value value;
};

/// Local names of one call; the program itself is the first.
struct Frame {
  int return_to = -1;
  std::vector<Local> locals;
  Local* find(std::string_view name);
  const Local* find(std::string_view name) const;
};

class Evaluator {
 public:
  Evaluator(const Program& program, const Host& host, const Frame& frame)
      : program_{program}, host_{host}, frame_{frame} {}

  /// Throws Error with the place in the program.
  Value value(const Expression& expression) const;
  bool boolean(const Expression& expression, const std::string& of) const;
  /// A time; a bare number counts as seconds only where `bare_seconds`.
  Nanoseconds time(const Expression& expression, bool bare_seconds) const;
  Nanoseconds time(const Value& value, Place place, bool bare_seconds) const;

 private:
  Value name(const Expression& expression) const;
  Value binary(const Expression& expression) const;
  std::vector<Value> values(const std::vector<ExpressionPtr>& parts) const;
  [[noreturn]] void fail(Place place, std::string code, std::string what, std::string advice = {}) const;
  Value dispatch(const Expression& expression) const;

  const Program& program_;
  const Host& host_;
  const Frame& frame_;
};

}  // namespace polyarm::program
