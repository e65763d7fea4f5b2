#pragma once
/// Errors: what went wrong, where, and what to do. Exceptions are used outside the control cycle only.
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace polyarm {

/// A place in a user's file. Line and column count from 1; 0 means unknown.
struct Location {
  std::string file;
  int line = 0;
  int column = 0;
  /// "file:line:column", as far as known.
  std::string text() const;
};

enum class Severity { error, warning };

/// A name, text or number that a sentence contains; a page needs it to translate the sentence. The name of a
/// number ends with its unit: depth_m, moved_rad, time_s.
struct Fact {
  std::string name;
  std::variant<std::string, double> value;
};
using Facts = std::vector<Fact>;

/// One finding. `code` is stable and short ("unknown-name"), for tools; the other texts are for people.
struct Problem {
  std::string code;
  Location where;
  std::string what;    ///< one sentence with the offending text and the numbers
  std::string advice;  ///< what to do; may be empty
  Severity severity = Severity::error;
  Facts facts = {};  ///< what `what` contains
  /// "file:line:column: error: what [advice]"
  std::string text() const;
};

class Error : public std::runtime_error {
 public:
  explicit Error(Problem problem) : std::runtime_error(problem.text()), problems_{std::move(problem)} {}
  explicit Error(std::vector<Problem> problems);
  Error(std::string code, std::string what, std::string advice = {})
      : Error(Problem{std::move(code), {}, std::move(what), std::move(advice)}) {}
  const std::vector<Problem>& problems() const { return problems_; }

 private:
  std::vector<Problem> problems_;
};

/// Call it inside `catch (...)`: returns the text of the exception, of any type.
std::string what_was_thrown();
/// The exception that is being handled as an Error: itself; a failure of the file system as "unwritable" with its file;
/// else "internal". Call it in a catch block only.
Error error_thrown();
/// Call it inside `catch (...)`: rethrows an Error unchanged and turns any other exception into an Error
/// "<who> threw: …". Use it around foreign callbacks, which may throw anything.
[[noreturn]] void rethrow_as_error(std::string code, const std::string& who, std::string advice = {});

/// Collects findings, so that a user sees all of them at once.
class Problems {
 public:
  void add(Problem problem) { list_.push_back(std::move(problem)); }
  void error(std::string code, Location where, std::string what, std::string advice = {}) {
    list_.push_back({std::move(code), std::move(where), std::move(what), std::move(advice), Severity::error});
  }
  void warning(std::string code, Location where, std::string what, std::string advice = {}) {
    list_.push_back(
        {std::move(code), std::move(where), std::move(what), std::move(advice), Severity::warning});
  }
  void add(const Error& error) {
    list_.insert(list_.end(), error.problems().begin(), error.problems().end());
  }
  bool has_errors() const;
  const std::vector<Problem>& list() const { return list_; }
  /// Throws one Error with all findings if at least one of them is an error.
  void throw_if_errors() const;

 private:
  std::vector<Problem> list_;
};

/// Runs `step` and adds what it throws to the problems, so that one fault does not hide the next.
template <typename Step>
void collect(Problems& problems, Step step) {
  try {
    step();
  } catch (const Error& e) {
    problems.add(e);
  }
}

}  // namespace polyarm
