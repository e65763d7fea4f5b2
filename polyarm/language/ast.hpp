#pragma once
/// The syntax tree of a program: statements and expressions with their places. Plain data: any thread.
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/data/value.hpp"
#include "polyarm/language/token.hpp"

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

/// The operator's spelling in a program.
const char* spelling(Operator op);
/// == != < <= > >=
bool is_comparison(Operator op);

struct Expression;
using ExpressionPtr = std::unique_ptr<Expression>;

/// One node; `kind` determines which fields are used.
struct Expression {
  enum class Kind {
    literal,  ///< value
    name,     ///< name, with its dots: "in.part_ready"
    unary,    ///< op, parts[0]
    binary,   ///< name, with dots: "in.part_ready"
    call,     ///< name, parts; names: the name of each named argument, else empty
    index,    ///< parts[0] [ parts[1] ], first index 1
    field,    ///< parts[0] . name
    list,     ///< parts
    record,   ///< names and parts
    joined,   ///< parts, each as text, concatenated
    each,     ///< parts[0] for name in parts[1] [.. parts[2]], as a list; names: of the count, if any
  };
  Kind kind = Kind::literal;
  Place place;
  int depth = 1;  ///< of the tree from this node down
  Value value;
  std::string name;
  Operator op = Operator::add;
  std::vector<ExpressionPtr> parts;
  std::vector<std::string> names;
};

/// For messages: its name, or its form such as offset(Pick, …).
std::string spelled(const Expression& expression);

/// The names that `expression` reads, each once, in text order.
std::vector<std::string> names_read(const Expression& expression);

struct Statement;
using Block = std::vector<Statement>;

/// One branch of an if: `condition` is empty for else.
struct Branch;

/// An option of a move, or of all following moves (`use`).
struct Clause {
  enum class Kind {
    robot,
    tool,
    frame,
    payload,
    near,
    around,
    speed,
    accel,
    blend,
    duration,
    exact,
    smooth,
    touch,
    until,
    at
  };
  Kind kind = Kind::exact;
  Place place;
  ExpressionPtr value;    ///< all except exact, smooth and touch; for `at` the distance or time, if given
  Block otherwise;        ///< until … else
  bool has_else = false;  ///< for until
  bool from_end = false;  ///< for at: before the end instead of after the start
  std::string target;     ///< for at: the name to set
  ExpressionPtr to;       ///< for at: the new value
};
/// The clause's spelling in a program.
const char* spelling(Clause::Kind kind);
/// False for exact, smooth and touch.
bool has_value(Clause::Kind kind);

/// A part of the target of `=` after the name: a field or a list index.
struct PathPart {
  Place place;
  std::string field;
  ExpressionPtr index;  ///< empty: a field
};

struct Parameter {
  std::string name;
  Place place;
  ExpressionPtr value;  ///< default value of a call; may be empty
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
    trap,
    every,
    pulse,
    on_stop,
    test,
    run,
    expect
  };
  /// speedj, speedl: the argument is a record of velocities. drive, turn: of a base, by an amount.
  enum class Motion { moveto, movej, movel, movec, speedj, speedl, drive, turn };
  Kind kind = Kind::stop;
  Motion motion = Motion::moveto;
  Place place;
  /// Data file, variable, function, task, meeting, lock, test, program; for try: the name of the error.
  std::string name;
  Place name_place;
  bool explicit_variable = false;        ///< wait var NAME
  Value literal;                         ///< set_literal; the text of ask
  ExpressionPtr expression;              ///< value, condition, time, first of a range, list
  ExpressionPtr second;                  ///< end of a range; timeout; for a plain `wait user` the name `user`
  std::string second_name;               ///< for NAME, NAME in …: the index comes first
  std::vector<ExpressionPtr> arguments;  ///< log; the points of a move
  std::vector<PathPart> path;            ///< set NAME.field[index] = …
  std::vector<Clause> clauses;           ///< move, use
  std::vector<Parameter> parameters;     ///< function
  Block body;                            ///< of a loop, function, task …; the block after a timeout
  Block handler;                         ///< try … on error
  Place handler_place;
  bool has_else = false;  ///< wait, meet … timeout … else
  std::vector<Branch> branches;

  /// True if it moves a base instead of an arm.
  bool moves_base() const {
    return kind == Kind::move && (motion == Motion::drive || motion == Motion::turn);
  }
  /// speedj or speedl: starts from the present position of the robot.
  bool moves_at_speed() const {
    return kind == Kind::move && (motion == Motion::speedj || motion == Motion::speedl);
  }
};

struct Branch {
  ExpressionPtr condition;
  Place place;
  Block body;
};

/// The keyword of a motion, and the motion of a keyword.
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
  Block statements;                ///< including those of included files, at the place of inclusion
  std::vector<Included> included;  ///< file 1 and following
  bool lacks_included = false;     ///< an included file could not be read

  Location at(Place place) const;
  const std::string& file_of(Place place) const;
  /// The source line, trimmed; empty if the line does not exist.
  std::string source(Place place) const { return std::string(line_of(place)); }
  std::string_view line_of(Place place) const;
};

/// The statements that load data, each file once, in text order.
std::vector<const Statement*> loads(const Program& program);

/// Its tests, in text order.
std::vector<const Statement*> tests(const Program& program);

}  // namespace polyarm::program
