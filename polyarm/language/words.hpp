#pragma once
/// The words of the language: one list for the parser, the messages and the reference. Const: any thread.
#include <string>
#include <string_view>
#include <vector>

namespace polyarm::program {

enum class WordRole {
  statement,  ///< first word of a line
  branch,     ///< first word of a line that continues with a block
  closer,     ///< first word of a line that ends a block
  clause,     ///< after the points of a move, or in `use`
  reserved,   ///< never a name
};

struct Word {
  std::string_view name;  ///< lower case
  WordRole role = WordRole::statement;
  std::string_view form;     ///< its syntax; for a closer, what it ends
  std::string_view meaning;  ///< for readers, one sentence
  /// An example program, with its effects in comments; empty: the example of the word `shown_by` applies.
  std::string_view example;
  std::string_view shown_by;
  bool in_tests = false;  ///< only in tests
};
const std::vector<Word>& words();

/// The words a statement may begin with, lower case.
const std::vector<std::string>& statement_words();
bool is_statement_word(const std::string& word);
bool is_closer(std::string_view word);
/// The statement that begins with this name, lower case; null: none does.
const Word* statement_named(std::string_view name);

/// The reference page: every word and function with an example, as Markdown.
std::string language_reference();

}  // namespace polyarm::program
