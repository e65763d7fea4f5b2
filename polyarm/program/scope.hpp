#pragma once
/// The types of expressions, as far as they are known before a program runs. Private to the checker's files.
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "polyarm/language/functions.hpp"
#include "polyarm/program/checker.hpp"

namespace polyarm::program {

inline const Type kUnknown{};
inline const Type kBoolean{data::Kind::boolean, {}};
Type number_of(std::optional<Dimension> dimension);
/// "a length", "a boolean", "something".
std::string described(const Type& type);
/// The value of a number that is written without a unit; empty for anything else.
std::optional<double> bare_number(const Expression& e);
/// True if both are known and different.
bool surely_other(const Type& a, const Type& b);
bool is_place(const Type& type);

/// The names visible at one place of a program, and the types of their expressions.
class Scope {
 public:
  Scope(const Program& program, const KnownNames& known, Problems& problems);

  void error(std::string code, Place place, std::string what, std::string advice = {}) {
    problems_.error(std::move(code), program_.at(place), std::move(what), std::move(advice));
  }
  void warning(std::string code, Place place, std::string what, std::string advice = {}) {
    problems_.warning(std::move(code), program_.at(place), std::move(what), std::move(advice));
  }

  const Problems& problems() const { return problems_; }

  Type infer(const Expression& e);
  /// The type of a variable; nullptr if there is none of that name.
  const Type* local(const std::string& name) const;
  /// The variable of `name` or of the part before its first dot; or an empty text.
  std::string variable_in(const std::string& name) const;
  std::vector<std::string> all_names() const;
  void declare(const std::string& name, Place place, Type type);
  const Statement* function(const std::string& name) const;
  /// Warns of names that a reader could confuse.
  void warn_of_case();

  struct Variable {
    std::string name;
    Type type;
    Place place;
  };
  /// "in line 3", with the file where that is another one than the file of `seen_from`.
  std::string in_line(Place place, Place seen_from) const;
  std::map<std::string, Type> names;  ///< data, points, tags
  std::set<std::string> errors;       ///< variables of the `on error` around, whose fields are known
  std::set<std::string> made;         ///< names that lines such as `set NAME True` will create
  std::map<std::string, Place> used;
  std::vector<Variable> variables;  ///< the innermost last
  bool in_function = false;         ///< the statement under check belongs to a function
  /// Ends all but the first `keep` variables.
  void forget(std::size_t keep);
  std::vector<const Statement*> functions;

 private:
  Type type_of_name(const std::string& name, Place place);
  Type type_of_field(const Type& of, const std::string& field, Place place);
  std::vector<Type> infer_all(const Expression& e);
  Type infer_each(const Expression& e);
  Type infer_with(const Expression& e, const std::vector<Type>& arguments);
  void check_format(const Expression& e, const std::vector<Type>& arguments);
  Type infer_unary(const Expression& e);
  void refuse_pair(const Expression& e, const Type& a, const Type& b);
  Type infer_binary(const Expression& e);
  Type infer_arithmetic(const Expression& e, const Type& a, const Type& b);
  std::optional<Dimension> dimension_of(const Expression& e, const Type& a, const Type& b);
  Type infer_call(const Expression& e);
  Type infer_builtin(const Expression& e, const Function& function, const std::vector<Type>& arguments);

  bool is_own_name(const std::string& name, Place place) const;
  std::string suggested(const std::string& name) const;
  std::string where_made(const std::string& name, Place seen_from) const;

  const Program& program_;
  Problems& problems_;
  std::unordered_map<std::string, std::vector<std::size_t>> places_;  ///< of variables, innermost last
  std::unordered_map<std::string, const Statement*> function_at_;
  std::map<std::string, Location> defined_;  ///< where files of the cell define names
  std::map<std::string, std::pair<std::string, std::string>> elsewhere_;  ///< see KnownNames
};

/// True if it waits or moves, and so cannot be in a block that runs within one cycle.
bool takes_time(const Statement& s);
/// Finds tasks, or statements of one `together`, that command the same robot, and meetings of only one task.
void check_tasks(const Program& program, const KnownNames& known, Scope& scope);
/// Finds robots, tools and frames that the cell does not have, and tags that programs may not set.
void check_cell_names(const Program& program, const KnownNames& known, Scope& scope);
/// Finds values that would fail at run time, as far as they are known before.
void check_values(const Program& program, Scope& scope);
/// Finds loops that never end and never wait.
void check_endless(const Program& program, Scope& scope);
/// Warns of impossible blends, with the line that prevents each.
void check_blends(const Program& program, Scope& scope);

}  // namespace polyarm::program
