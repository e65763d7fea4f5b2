#pragma once
/// Data flow in a program: traces variables, parameters and functions back to the names of the cell and to
/// the answers of people.
#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/language/ast.hpp"

namespace polyarm::cell {

/// A linear expression: offset + slope * NAME + …
struct LinearForm {
  double offset = 0;
  std::map<std::string, double> slopes;
};

/// An answer of a person also counts as a name; see answer_name(). `program` must outlive this object. Use
/// from one thread at a time.
class Definitions {
 public:
  static constexpr std::size_t kMostForms = 8;

  explicit Definitions(const program::Program& program);
  /// The linear forms that `e` may have; `e` belongs to the statement at `where`. At most kMostForms;
  /// non-linear forms are left out.
  std::vector<LinearForm> forms(const program::Expression& e, const Location& where) const;
  /// The cell's names that the value depends on, each once, in text order.
  std::vector<std::string> sources(const program::Expression& e, const Location& where) const;

 private:
  struct Given {
    const program::Expression* value;
    Location where;
  };
  void add(const program::Statement& s);
  void add_arguments(const program::Expression& e, const Location& where);
  std::vector<LinearForm> forms(const program::Expression& e, const Location& where, int depth) const;
  std::vector<LinearForm> forms_of_name(const program::Expression& e, int depth) const;
  std::vector<LinearForm> forms_of_call(const program::Expression& e, const Location& where, int depth) const;
  void sources(const program::Expression& e, const Location& where,
               std::vector<const program::Expression*>& seen, std::vector<std::string>& out) const;

  const program::Program& program_;
  std::map<std::string, std::vector<Given>> given_;  ///< by name; a function's return values under "NAME()"
  std::map<std::string, bool> own_;                  ///< names defined by the program itself
  std::map<std::string, std::vector<std::string>> parameters_;  ///< parameter names by function
};

/// The name that Definitions uses for the answer to the question asked by the statement at `where`.
std::string answer_name(const Location& where);
/// Visits every expression of `s` itself, without nested statements, with its location at run time.
void for_each_located(const program::Program& program, const program::Statement& s,
                      const std::function<void(const program::Expression&, const Location&)>& visit);

}  // namespace polyarm::cell
