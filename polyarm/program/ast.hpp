#pragma once
/// A program as it was written: a tree of statements and expressions with their places.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/data/value.hpp"
#include "polyarm/program/token.hpp"

namespace polyarm::program {

using data::Value;

enum class Operator {
  logical_or,
  logical_and,
  logical_not,
  equal,
  unequal,
  less,
  less_equal,
  greater,
  greater_equal,
  add,
  subtract,
  multiply,
  divide,
  modulo,
  negate,
  power
};

/// As it is spelled in a program.
const char* spelling(Operator op);

struct Expression;
using ExpressionPtr = std::unique_ptr<Expression>;

/// One node; `kind` says which fields count.
struct Expression {
  enum class Kind {
    literal,  ///< value
    name,     ///< name, with its dots: "in.part_ready"
    unary,    ///< op, parts[0]
    binary,   ///< op, parts[0], parts[1]
    call,     ///< name, parts
    index,    ///< parts[0] [ parts[1] ], first index 1
    list,     ///< parts
    joined,   ///< parts, each as text, one after the other
  };
  Kind kind = Kind::literal;
  Place place;
  int depth = 1;  ///< of the tree below and including this node
  Value value;
  std::string name;
  Operator op = Operator::add;
  std::vector<ExpressionPtr> parts;
};

/// The names that `expression` reads, each once, in the order of the text.
std::vector<std::string> names_read(const Expression& expression);

struct Statement;
using Block = std::vector<Statement>;

/// One branch of an if: `condition` is empty for else.
struct Branch;

struct Statement {
  enum class Kind {
    load,
    import,
    set_literal,
    set,
    let,
    move,
    wait_time,
    wait,
    ask,
    while_loop,
    branch,
    for_loop,
    break_loop,
    continue_loop,
    stop,
    log,
    call
  };
  Kind kind = Kind::stop;
  Place place;
  std::string name;  ///< data file, variable
  Place name_place;
  bool explicit_variable = false;        ///< wait var NAME
  Value literal;                         ///< set_literal; the text of ask
  ExpressionPtr expression;              ///< value, condition, time, point, first of a range, list
  ExpressionPtr second;                  ///< end of a range; timeout; of a bare `wait user` the name `user`
  std::vector<ExpressionPtr> arguments;  ///< log
  Block body;                            ///< of a loop; what happens after a timeout
  bool has_else = false;                 ///< wait … timeout … else
  std::vector<Branch> branches;
};

struct Branch {
  ExpressionPtr condition;
  Place place;
  Block body;
};

/// A parsed program and its text.
struct Program {
  std::string file;
  std::vector<std::string> lines;
  Block statements;

  Location at(Place place) const { return {file, place.line, place.column}; }
  /// The source line without blanks around it; empty for a line there is not.
  std::string source(int line) const;
};

}  // namespace polyarm::program
