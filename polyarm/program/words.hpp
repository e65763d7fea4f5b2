#pragma once
/// The words of the language: one list for the parser, the messages and the reference.
#include <string>
#include <string_view>
#include <vector>

namespace polyarm::program {

enum class WordRole {
  statement,  ///< first word of a line
  branch,     ///< first word of a line that goes on with a block
  closer,     ///< first word of a line that ends a block
  clause,     ///< behind the points of a move, or in `use`
  reserved,   ///< never a name
};

struct Word {
  std::string_view name;  ///< lower case
  WordRole role = WordRole::statement;
  std::string_view form;     ///< how it is written; of a closer what it ends
  std::string_view meaning;  ///< for people, one sentence
  /// A program that shows it, with what it does on its lines; empty: it is shown under the word `shown_by`.
  std::string_view example;
  std::string_view shown_by;
  bool in_tests = false;  ///< only there
};
const std::vector<Word>& words();

/// The words a statement may begin with, lower case.
const std::vector<std::string>& statement_words();
bool is_statement_word(const std::string& word);
bool is_closer(std::string_view word);

/// The reference page: every word and function with an example, as Markdown.
std::string language_reference();

}  // namespace polyarm::program
