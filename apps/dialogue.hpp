#pragma once
/// Asks the user questions that are answered line by line, at a terminal or from a pipe.
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/quantity.hpp"

namespace polyarm::apps {

/// No more answers: end of standard input, or the terminal was closed.
struct EndOfAnswers {};
/// The user cancels: an empty line where a value is needed, or Ctrl-C.
struct GivenUp {
  bool by_signal = false;
};

struct MenuEntry {
  int number = 0;
  std::string text;
  std::function<void()> act;
};

/// Reads standard input and prints to standard output. Only one object at a time; while it exists, Ctrl-C
/// only sets a flag.
class Dialogue {
 public:
  Dialogue();
  ~Dialogue();
  Dialogue(const Dialogue&) = delete;
  Dialogue& operator=(const Dialogue&) = delete;

  /// True at a terminal. Otherwise the input is echoed, so the output reads like a session.
  bool at_terminal() const { return terminal_; }

  /// A trimmed line. Throws EndOfAnswers, or GivenUp on Ctrl-C.
  std::string line(const std::string& question);
  /// The same; throws GivenUp if the line is empty.
  std::string name(const std::string& question);
  /// Repeats the question until the answer is y or n. `otherwise`: meaning of an empty line.
  bool yes(const std::string& question, bool otherwise = false);
  /// Repeats the question until the answer is a quantity; numbers without a unit are SI. An empty line gives
  /// `otherwise`, or cancels without it.
  double quantity(const std::string& question, Dimension dimension, std::optional<double> otherwise = {});
  /// The same for a whole number from `low` to `high`.
  int number(const std::string& question, int low, int high, std::optional<int> otherwise = {});

  /// Shows the entries as `1->Text` until 0 is chosen or `over` returns true. Calls `heading` and `entries`
  /// each time. Prints the Error of an entry that fails.
  void menu(const std::function<std::string()>& heading,
            const std::function<std::vector<MenuEntry>()>& entries, const std::function<bool()>& over = {});

  /// A line that arrives within `time`; empty if none does. Throws EndOfAnswers.
  std::optional<std::string> line_within(std::chrono::milliseconds time);
  /// True if Ctrl-C was pressed since the last call.
  bool take_interrupt();
  /// True if the process was told to end.
  bool ended() const;

  void say(const std::string& text) const;
  /// Prints an error or a refusal as text for people.
  void complain(const Error& error);
  void complain(const std::string& text);
  /// True if anything was refused.
  bool complained() const { return complaints_ > 0; }
  /// Bold and dim text on a terminal; unchanged without one, or if NO_COLOR is set.
  std::string bold(const std::string& text) const;
  std::string dim(const std::string& text) const;

  /// Called when Ctrl-C is pressed at a question.
  std::function<void()> on_interrupt;

 private:
  bool fill(int timeout_ms);
  std::optional<std::string> take_line();
  int choose(const std::vector<MenuEntry>& entries);

  bool terminal_, colour_, over_ = false;
  int complaints_ = 0;
  std::string in_;
};

/// Items in columns, as wide as the terminal allows.
std::string in_columns(const std::vector<std::string>& items);
/// Items one after another in lines that begin with `indent`.
std::string flowing(const std::vector<std::string>& items, const std::string& indent);

}  // namespace polyarm::apps
