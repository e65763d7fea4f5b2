#pragma once
/// What went wrong, where, and what to do about it. Exceptions are for outside the control cycle only.
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace polyarm {

/// A place in a file a user wrote. Line and column count from 1; 0 means unknown.
struct Location {
  std::string file;
  int line = 0;
  int column = 0;
  /// "file:line:column", as far as known.
  std::string text() const;
};

enum class Severity { error, warning };

/// A name, text or number that a sentence contains, so that a page can say the sentence in another language.
/// The name of a number ends with its unit: depth_m, moved_rad, time_s.
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

/// Within `catch (...)`: what the exception says, whatever it is.
std::string what_was_thrown();
/// Within `catch (...)`: an Error goes on as it is; anything else becomes one that says "<who> threw: …". For
/// callbacks of others, which may throw what they like.
[[noreturn]] void rethrow_as_error(std::string code, const std::string& who, std::string advice = {});

/// Findings collected before giving up, so that a user sees all of them at once.
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
  /// Throws one Error with everything found, if there is an error among it.
  void throw_if_errors() const;

 private:
  std::vector<Problem> list_;
};

/// Runs `step`; what it throws joins the problems, so that one fault does not hide the next.
template <typename Step>
void collect(Problems& problems, Step step) {
  try {
    step();
  } catch (const Error& e) {
    problems.add(e);
  }
}

}  // namespace polyarm
