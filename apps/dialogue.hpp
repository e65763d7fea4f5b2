#pragma once
/// Questions to a person, answered line by line: at a terminal, or from a pipe.
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/quantity.hpp"

namespace polyarm::apps {

/// Nothing more will be answered: the end of standard input, or the terminal is gone.
struct EndOfAnswers {};
/// The person gives the question up: an empty line where a value is needed, or Ctrl-C.
struct GivenUp {
  bool by_signal = false;
};

struct MenuEntry {
  int number = 0;
  std::string text;
  std::function<void()> act;
};

/// Reads standard input and prints to standard output; one at a time. Ctrl-C is a flag while one lives.
class Dialogue {
 public:
  Dialogue();
  ~Dialogue();
  Dialogue(const Dialogue&) = delete;
  Dialogue& operator=(const Dialogue&) = delete;

  /// Is somebody at a terminal? Else what is read is shown, so that the output reads as a session.
  bool at_terminal() const { return terminal_; }

  /// A line without blanks around it. Throws EndOfAnswers; GivenUp on Ctrl-C.
  std::string line(const std::string& question);
  /// Likewise; throws GivenUp where it is empty.
  std::string name(const std::string& question);
  /// Asks until it is y or n. `otherwise`: what an empty line means.
  bool yes(const std::string& question, bool otherwise = false);
  /// Asks until it is a quantity; bare numbers are SI. An empty line is `otherwise`, or gives it up.
  double quantity(const std::string& question, Dimension dimension, std::optional<double> otherwise = {});
  /// A whole number from `low` to `high`, likewise.
  int number(const std::string& question, int low, int high, std::optional<int> otherwise = {});

  /// Shows the entries as `1->Text` until 0 is chosen, or until `over`. Heading and entries are made anew
  /// each time. What an entry refuses with an Error is told.
  void menu(const std::function<std::string()>& heading,
            const std::function<std::vector<MenuEntry>()>& entries, const std::function<bool()>& over = {});

  /// A line that has come, without waiting longer than this; nothing where none has. Throws EndOfAnswers.
  std::optional<std::string> line_within(std::chrono::milliseconds time);
  /// Ctrl-C since the last call.
  bool take_interrupt();
  /// Whether the process was told to end.
  bool ended() const;

  void say(const std::string& text) const;
  /// An error or another refusal, as a person reads it.
  void complain(const Error& error);
  void complain(const std::string& text);
  /// Something was refused.
  bool complained() const { return complaints_ > 0; }
  /// Marks of a terminal: bold and dim text; empty where there is none, or NO_COLOR is set.
  std::string bold(const std::string& text) const;
  std::string dim(const std::string& text) const;

  /// Called when Ctrl-C comes at a question.
  std::function<void()> on_interrupt;

 private:
  bool fill(int timeout_ms);
  std::optional<std::string> take_line();
  int choose(const std::vector<MenuEntry>& entries);

  bool terminal_, colour_, over_ = false;
  int complaints_ = 0;
  std::string in_;
};

/// Rows of text side by side, as wide as the terminal allows.
std::string in_columns(const std::vector<std::string>& items);
/// One item after the other in lines that begin with `indent`.
std::string flowing(const std::vector<std::string>& items, const std::string& indent);

}  // namespace polyarm::apps
