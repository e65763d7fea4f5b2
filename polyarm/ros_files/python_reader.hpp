#pragma once
/// Reads Python source as text: assignments and expressions become values where those are written down, and
/// calls are handed to the one who knows what they mean. No Python is run. Private to the room.
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/ros_files/python_text.hpp"
#include "polyarm/ros_files/python_value.hpp"

namespace polyarm::ros_files::python {

class PythonReader {
 protected:
  PythonReader(std::string_view text, std::string file)
      : file_{std::move(file)}, tokens_{python_tokens(text)} {}
  virtual ~PythonReader() = default;

  /// Reads the whole source, as often as a value may be used above the line that states it; `again` is called
  /// before each pass, with whether it is the last one.
  template <class Again>
  void read(Again again) {
    for (int pass = 0; pass < kPasses; ++pass) {
      variables_.clear();
      again(pass + 1 == kPasses);
      for (at_ = 0; at_ < tokens_.size();) statement();
    }
  }

  /// `whole` is the dotted name ("launch.actions.Node"), `function` its last word.
  virtual Value call(const std::string& whole, const std::string& function, const Arguments& arguments,
                     const Location& where) = 0;
  /// A method or, with no arguments (null), an attribute of a value.
  virtual Value method(Value value, const std::string& name, const Arguments* arguments) = 0;
  /// A name that no assignment has stated.
  virtual Value unassigned(const std::string& name) = 0;

 private:
  static constexpr int kPasses = 3;
  static constexpr std::size_t kMostCopied = 20'000'000;  ///< values, of variables that are read

  const PythonToken& token(std::size_t ahead = 0) const;
  bool is(const char* sign, std::size_t ahead = 0) const;
  bool is_name(std::size_t ahead = 0) const;
  Location here() const { return {file_, token().line}; }
  void skip_element();
  void statement();
  Value expression(int depth);
  Value operand(int depth);
  Value strings(int depth);
  std::string formatted(const std::string& text) const;
  Value sequence(const char* close, int depth);
  Value parenthesised(int depth);
  Value map(int depth);
  Value name(int depth);
  Value followed(Value value, int depth);
  Value indexed(const Value& value, int depth);
  Arguments called_with(int depth);

  const std::string file_;
  const std::vector<PythonToken> tokens_;
  std::size_t at_ = 0;
  std::map<std::string, Value> variables_;
  std::size_t copied_ = 0;
};

}  // namespace polyarm::ros_files::python
