#pragma once
/// A program as it was written: a tree of statements and expressions with their places.
#include <memory>
#include <optional>
#include <string>
#include <string_view>
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
/// == != < <= > >=
bool is_comparison(Operator op);

struct Expression;
using ExpressionPtr = std::unique_ptr<Expression>;

/// One node; `kind` says which fields count.
struct Expression {
  enum class Kind {
    literal,  ///< value
    name,     ///< name, with its dots: "in.part_ready"
    unary,    ///< op, parts[0]
    binary,   ///< op, parts[0], parts[1]
    call,     ///< name, parts; names: of an argument that was named, else empty
    index,    ///< parts[0] [ parts[1] ], first index 1
    field,    ///< parts[0] . name
    list,     ///< parts
    record,   ///< names and parts
    joined,   ///< parts, each as text, one after the other
  };
  Kind kind = Kind::literal;
  Place place;
  int depth = 1;  ///< of the tree below and including this node
  Value value;
  std::string name;
  Operator op = Operator::add;
  std::vector<ExpressionPtr> parts;
  std::vector<std::string> names;
};

/// As a message calls it: its name, or its form such as offset(Pick, …).
std::string spelled(const Expression& expression);

/// The names that `expression` reads, each once, in the order of the text.
std::vector<std::string> names_read(const Expression& expression);

struct Statement;
using Block = std::vector<Statement>;

/// One branch of an if: `condition` is empty for else.
struct Branch;

/// What is said about a move, or about all moves of a block by `use`.
struct Clause {
  enum class Kind {
    robot,
    tool,
    frame,
    payload,
    near,
    speed,
    accel,
    blend,
    duration,
    exact,
    smooth,
    until,
    at
  };
  Kind kind = Kind::exact;
  Place place;
  ExpressionPtr value;    ///< all but exact and smooth; of `at` the distance or time, if one is said
  Block otherwise;        ///< until … else
  bool has_else = false;  ///< of until
  bool from_end = false;  ///< of at: before the end, not after the start
  std::string target;     ///< of at: what is set
  ExpressionPtr to;       ///< of at: what it is set to
};
/// As it is spelled in a program.
const char* spelling(Clause::Kind kind);

/// What follows a name on the left of `=`: a field or a place in a list.
struct PathPart {
  Place place;
  std::string field;
  ExpressionPtr index;  ///< empty: a field
};

struct Parameter {
  std::string name;
  Place place;
  ExpressionPtr value;  ///< where a call leaves it out; may be empty
};

struct Statement {
  enum class Kind {
    load,
    import,
    set_literal,
    set,
    let,
    move,
    use,
    wait_time,
    wait,
    ask,
    while_loop,
    branch,
    for_loop,
    break_loop,
    continue_loop,
    stop,
    hold,
    log,
    call,
    include,
    function,
    return_value,
    try_block,
    raise,
    retry,
    task,
    together,
    meet,
    lock,
    when,
    on_stop,
    test,
    run,
    expect
  };
  /// speedj, speedl: their argument is a record of velocities. drive, turn: of a base, by so much.
  enum class Motion { moveto, movej, movel, movec, speedj, speedl, drive, turn };
  Kind kind = Kind::stop;
  Motion motion = Motion::moveto;
  Place place;
  /// Data file, variable, function, task, meeting, lock, test, program; of try the name of the error.
  std::string name;
  Place name_place;
  bool explicit_variable = false;        ///< wait var NAME
  Value literal;                         ///< set_literal; the text of ask
  ExpressionPtr expression;              ///< value, condition, time, first of a range, list
  ExpressionPtr second;                  ///< end of a range; timeout; of a bare `wait user` the name `user`
  std::string second_name;               ///< for NAME, NAME in …: the place in the list comes first
  std::vector<ExpressionPtr> arguments;  ///< log; the points of a move
  std::vector<PathPart> path;            ///< set NAME.field[index] = …
  std::vector<Clause> clauses;           ///< move, use
  std::vector<Parameter> parameters;     ///< function
  Block body;                            ///< of a loop, function, task …; what happens after a timeout
  Block handler;                         ///< try … on error
  Place handler_place;
  bool has_else = false;  ///< wait, meet … timeout … else
  std::vector<Branch> branches;

  /// A move of a base, not of an arm.
  bool moves_base() const {
    return kind == Kind::move && (motion == Motion::drive || motion == Motion::turn);
  }
  /// speedj or speedl: it goes on from where the robot is.
  bool moves_at_speed() const {
    return kind == Kind::move && (motion == Motion::speedj || motion == Motion::speedl);
  }
};

struct Branch {
  ExpressionPtr condition;
  Place place;
  Block body;
};

/// As it is spelled in a program, and the motion that is spelled so.
const char* spelling(Statement::Motion motion);
std::optional<Statement::Motion> motion_of(std::string_view word);

/// A parsed program and its text.
struct Program {
  struct Included {
    std::string file;
    std::vector<std::string> lines;
  };
  std::string file;
  std::vector<std::string> lines;
  Block statements;                ///< with those of the included files where they are included
  std::vector<Included> included;  ///< file 1 and on
  bool lacks_included = false;     ///< a file that it includes could not be read

  Location at(Place place) const;
  /// The source line without blanks around it; empty for a line there is not.
  std::string source(Place place) const;
};

/// The statements that load data, each file once, in the order of the text.
std::vector<const Statement*> loads(const Program& program);

/// Its tests, in the order of the text.
std::vector<const Statement*> tests(const Program& program);

}  // namespace polyarm::program
