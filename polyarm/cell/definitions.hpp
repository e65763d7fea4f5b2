#pragma once
/// Where the values of a program come from: its variables, parameters and functions are followed back to the
/// names of the cell and to the answers of people.
#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/language/ast.hpp"

namespace polyarm::cell {

/// A number as a sum: offset + slope * NAME + …
struct LinearForm {
  double offset = 0;
  std::map<std::string, double> slopes;
};

/// An answer of a person counts as a name, too: see answer_name(). `program` outlives this. Any one thread.
class Definitions {
 public:
  static constexpr std::size_t kMostForms = 8;

  explicit Definitions(const program::Program& program);
  /// What `e`, of the statement in the line `where`, may be, at most kMostForms. Without those that are not
  /// linear.
  std::vector<LinearForm> forms(const program::Expression& e, const Location& where) const;
  /// The names of the cell that the value depends on, each once, in the order of the text.
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
  std::map<std::string, std::vector<Given>> given_;  ///< by name; of a function what it returns, as "NAME()"
  std::map<std::string, bool> own_;                  ///< names that the program makes
  std::map<std::string, std::vector<std::string>> parameters_;  ///< by function
};

/// What Definitions calls the answer to the question that the statement in this line asks.
std::string answer_name(const Location& where);
/// Every expression that stands in `s` itself, with the line that a run gives for it.
void for_each_located(const program::Program& program, const program::Statement& s,
                      const std::function<void(const program::Expression&, const Location&)>& visit);

}  // namespace polyarm::cell
