#pragma once
/// Reads Python source as text. Assignments, loops, conditions, functions of the file and expressions become
/// values if they are literal. Calls are passed to the derived class. No Python is run. Private to the room.
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/launch/python_source.hpp"
#include "polyarm/launch/python_value.hpp"

namespace polyarm::ros_files::python {

class PythonReader {
 protected:
  PythonReader(std::string_view text, std::string file);
  virtual ~PythonReader() = default;

  /// Reads the whole source several times, because a value may be used above the line that assigns it.
  /// `again` is called before each pass, with true for the last one.
  template <class Again>
  void read(Again again) {
    for (int pass = 0; pass < kPasses; ++pass) {
      variables_.clear();
      unsure_ = 0;
      again(pass + 1 == kPasses);
      at_ = 0;
      block(main_.tokens.size(), 0);
    }
  }

  /// True inside a condition or loop that Python may or may not enter.
  bool unsure() const { return unsure_ > 0; }

  /// `whole` is the dotted name ("launch.actions.Node"), `function` its last word.
  virtual Value call(const std::string& whole, const std::string& function, const Arguments& arguments,
                     const Location& where) = 0;
  /// A method or, if `arguments` is null, an attribute of a value.
  virtual Value method(Value value, const std::string& name, const Arguments* arguments,
                       const Location& where) = 0;
  /// A name without an assignment.
  virtual Value unassigned(const std::string& name) = 0;
  /// Reports what is ignored because a limit is reached.
  virtual void left_out(const Location& where, std::string what) = 0;

 private:
  static constexpr int kPasses = 3, kDeepestCall = bounds::kLaunchCalls;
  static constexpr std::size_t kMostRounds = bounds::kLaunchRounds, kMostCopied = bounds::kLaunchValues,
                               kMostSteps = bounds::kLaunchSteps;

  struct Function {
    std::size_t parameters = 0, body = 0, end = 0;
  };
  /// Counts nested conditions with unknown values.
  struct Unsure {
    Unsure(int& count, bool is) : count_{count}, by_{is ? 1 : 0} { count_ += by_; }
    ~Unsure() { count_ -= by_; }
    int& count_;
    const int by_;
  };
  /// Restores the old values of names.
  struct Bound {
    Bound(std::map<std::string, Value>& variables, const std::vector<std::string>& names);
    ~Bound();
    std::map<std::string, Value>& variables_;
    std::vector<std::pair<std::string, std::optional<Value>>> before_;
  };

  const PythonToken& token(std::size_t ahead = 0) const;
  bool is(const char* sign, std::size_t ahead = 0) const;
  bool is_name(std::size_t ahead = 0) const;
  bool is_word(const char* word, std::size_t ahead = 0) const;
  Location here() const { return {file_, token().line}; }
  bool may_repeat(const Location& where);

  // python_statements.cpp
  void block(std::size_t end, int depth);
  void statement(int depth);
  bool compound(int depth);
  std::size_t body_begin(std::size_t from) const;
  std::size_t body_end(std::size_t statement, std::size_t begin) const;
  void define(int depth);
  void choose(int depth);
  void loop(int depth);
  void with(int depth);
  void simple(std::size_t end);
  bool assignment(std::size_t end);
  bool grown_list();
  void returned();
  std::vector<std::string> targets(const char* end_word);
  void bind(const std::vector<std::string>& names, const Value& value);
  static std::vector<Value> rounds(const Value& over, std::size_t names);
  Value run(const Function& function, const Arguments& arguments, int depth);
  void bind_parameters(const Function& function, const Arguments& arguments, int depth);

  // python_reader.cpp
  void skip_element(int depth);
  std::size_t find_word(const char* word) const;
  Value expression(int depth);
  Value either(std::size_t condition, int depth);
  Value disjunction(int depth);
  Value conjunction(int depth);
  Value comparison(int depth);
  Value sum_of(int depth);
  Value operand(int depth);
  Value strings(int depth);
  std::string formatted(const std::string& text, int line, int depth);
  Value inserted(const std::string& text, int line, int depth);
  Value sequence(const char* close, int depth);
  Value comprehension(std::size_t item, std::size_t loop, std::size_t close, int depth);
  void comprehension(std::size_t item, std::size_t loop, std::size_t close, int depth, Value& out);
  Value parenthesised(int depth);
  Value map(int depth);
  Value lambda(int depth);
  Value name(int depth);
  Value followed(Value value, int depth);
  Value indexed(const Value& value, int depth);
  Value called(const std::string& whole, const std::string& last, const Location& where, int depth);
  std::string function_given(std::size_t open) const;
  void call_given(const std::string& name, const Arguments& given, int depth);
  std::string condition_ahead(int depth);
  Arguments called_with(int depth);

  const std::string file_;
  const PythonSource main_;
  const PythonSource* source_ = &main_;
  std::size_t at_ = 0;
  std::map<std::string, Value> variables_;
  std::map<std::string, Function> functions_;  ///< from earlier passes, too: they may be called above
  std::set<std::string> called_;               ///< names of functions that are called somewhere
  std::vector<Value> results_;                 ///< return values of the functions being read
  std::size_t copied_ = 0, steps_ = 0;
  int unsure_ = 0, calls_ = 0;
};

/// The truth value of a Python value, or open if unknown.
enum class Known { no, yes, open };
Known known(const Value& value);

}  // namespace polyarm::ros_files::python
