#pragma once
/// The one way to a terminal. What the command prints passes through printable(), so that names, messages and
/// files of others cannot steer the terminal; what the command itself draws with is marked, in a way that no
/// text of others can know.
#include <string>
#include <string_view>

namespace polyarm::apps {

/// First in main(): standard output and standard error are guarded where they are terminals. Elsewhere bytes
/// pass as they are.
void guard_terminal();

/// The command's own control sequence: own_escape("[K") clears to the end of the line.
std::string own_escape(std::string_view sequence);
/// Back to the beginning of the line.
std::string own_return();

/// What becomes of printed text on its way to the terminal, a piece at a time.
class TerminalText {
 public:
  /// `mark`: follows the escape character in sequences of the command's own.
  explicit TerminalText(std::string mark) : mark_(std::move(mark)) {}
  /// What can be written now; the rest of a character or a mark that is cut is kept for the next piece.
  std::string pass(std::string_view piece);

 private:
  std::string mark_, kept_;
};

}  // namespace polyarm::apps
