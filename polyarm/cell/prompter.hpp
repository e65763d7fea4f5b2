#pragma once
/// Values that a program's names may take, used to explore a program in a rehearsal.
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/cell/definitions.hpp"
#include "polyarm/data/value.hpp"
#include "polyarm/language/ast.hpp"

namespace polyarm::cell {

/// Values collected from the program's comparisons, divisors and assignments. Use from one thread at a time.
class PossibleValues {
 public:
  /// The present value of one of the cell's names; null if there is no such name.
  using Find = std::function<const data::Value*(const std::string&)>;

  /// `others` is a program that runs in parallel and sets the same names; null if there is none.
  PossibleValues(const program::Program& program, const program::Program* others, const Find& find);
  /// Values to try instead of `now`, most likely first. For a number: values around those that it is compared
  /// with, so each comparison is true for one of them and false for another.
  std::vector<data::Value> instead_of(const std::string& name, const data::Value& now) const;
  /// The same for an answer, named by answer_name(). Empty if no condition depends on the answer.
  std::vector<data::Value> other_answers(const std::string& name, const data::Value& usual) const;
  /// The cell's names that conditions of branches and loops depend on, then those used in divisors.
  const std::vector<std::string>& deciding() const { return deciding_; }

 private:
  void add_from(const program::Program& program, const Find& find);
  void add_deciding(const program::Program& program);
  void add(const program::Expression& e, const Definitions& definitions, const Location& where,
           const Find& find);
  bool add_boundaries(const LinearForm& form, const Find& find);
  void add(const std::string& name, const data::Value& value);

  std::map<std::string, std::vector<data::Value>> constants_;
  std::vector<std::string> deciding_;
};

using NamedValue = std::pair<std::string, data::Value>;

/// Offers values for the names that a wait reads. First one name at a time, so a wait for one of two signals
/// sees a single change; then two at a time. Use from one thread at a time.
class Prompter {
 public:
  explicit Prompter(const PossibleValues& values) : values_(values) {}
  /// The values to set next for the wait at `where`. `names` are the names that it reads with their present
  /// values. Null when everything was tried.
  const std::vector<NamedValue>* next(const Location& where, const std::vector<NamedValue>& names);
  /// Call when the program continues: later waits then start with the first offer again.
  void went_on() { waits_.clear(); }

 private:
  struct Wait {
    std::vector<std::vector<NamedValue>> offers;
    std::size_t tried = 0;
  };
  std::vector<std::vector<NamedValue>> offers_for(const std::vector<NamedValue>& names) const;

  const PossibleValues& values_;
  std::map<std::string, Wait> waits_;  ///< by location
};

}  // namespace polyarm::cell
