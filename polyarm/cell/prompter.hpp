#pragma once
/// Values that the names of a program may come to have, for one that is only rehearsed.
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/cell/definitions.hpp"
#include "polyarm/data/value.hpp"
#include "polyarm/language/ast.hpp"

namespace polyarm::cell {

/// Collected from what programs compare names with, divide by and set them to. Any one thread.
class PossibleValues {
 public:
  /// The present value of a name of the cell; null: there is none.
  using Find = std::function<const data::Value*(const std::string&)>;

  /// `others`: a program beside it that sets its names; null: none.
  PossibleValues(const program::Program& program, const program::Program* others, const Find& find);
  /// Values to try instead of `now`, the likeliest first. Of a number those around what it is compared with,
  /// so that each comparison is true for one of them and false for another.
  std::vector<data::Value> instead_of(const std::string& name, const data::Value& now) const;
  /// The same of an answer, which is called by answer_name(): nothing where no condition depends on it.
  std::vector<data::Value> other_answers(const std::string& name, const data::Value& usual) const;
  /// The names of the cell that conditions of branches and loops depend on, and divisors, in this order.
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

/// Offers values for the names that a wait reads: one name after the other, so that a wait for one of two
/// signals sees one of them, then two at a time. Any one thread.
class Prompter {
 public:
  explicit Prompter(const PossibleValues& values) : values_(values) {}
  /// What to set next at `where`, which waits for these names with their present values; null: everything was
  /// tried.
  const std::vector<NamedValue>* next(const Location& where, const std::vector<NamedValue>& names);
  /// The program went on: waits that it comes to again begin with the first offer.
  void went_on() { waits_.clear(); }

 private:
  struct Wait {
    std::vector<std::vector<NamedValue>> offers;
    std::size_t tried = 0;
  };
  std::vector<std::vector<NamedValue>> offers_for(const std::vector<NamedValue>& names) const;

  const PossibleValues& values_;
  std::map<std::string, Wait> waits_;  ///< by place
};

}  // namespace polyarm::cell
