#pragma once
/// Values that the names of a program may come to have, for one that is only rehearsed.
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/data/value.hpp"
#include "polyarm/program/ast.hpp"

namespace polyarm::cell {

/// Collected from what programs compare names with and set them to. Any one thread.
class PossibleValues {
 public:
  /// `others`: a program beside it that sets its names; null: none.
  PossibleValues(const program::Program& program, const program::Program* others);
  /// Values to try instead of `now`, the likeliest first. Of a number those around what it is compared with,
  /// so that each comparison is true for one of them and false for another.
  std::vector<data::Value> instead_of(const std::string& name, const data::Value& now) const;
  /// The names that conditions of branches read, in the order of the text.
  const std::vector<std::string>& deciding() const { return deciding_; }

 private:
  void add_from(const program::Program& program);
  void add(const program::Expression& condition);
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
