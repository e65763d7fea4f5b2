#pragma once
/// Terminal output. Everything that the command prints passes through printable(), so names, messages and
/// files from others cannot control the terminal. Control sequences of the command itself carry a secret
/// mark.
#include <string>
#include <string_view>

namespace polyarm::apps {

/// Call first in main(): guards standard output and standard error, also in front of pipes and files, which end at a
/// terminal too. `document`: standard output is for a program (JSON, URDF); then only a terminal is guarded, and other
/// bytes pass unchanged.
void guard_terminal(bool document);
/// True if this command line asks for a document.
bool asks_for_document(int argc, char** argv);

/// The command's own control sequence: own_escape("[K") clears to the end of the line.
std::string own_escape(std::string_view sequence);
/// Moves the cursor to the beginning of the line.
std::string own_return();

/// Filters printed text for the terminal, piece by piece.
class TerminalText {
 public:
  /// `mark`: follows the escape character in the command's own sequences.
  explicit TerminalText(std::string mark) : mark_(std::move(mark)) {}
  /// The text to write now; an incomplete character or mark at the end is kept for the next piece.
  std::string pass(std::string_view piece);

 private:
  std::string mark_, kept_;
};

}  // namespace polyarm::apps
