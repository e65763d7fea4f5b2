#include <fmt/format.h>

#include "apps/options.hpp"
#include "polyarm/language/functions.hpp"
#include "polyarm/language/words.hpp"

namespace polyarm::apps {

int run_language(int argc, char** argv) {
  CommandLine app("The language of programs: its words and functions", "polyarm language");
  CommandLine* page = app.add_subcommand("page", "the reference page, as docs/language-reference.md has it");
  CommandLine* list = app.add_subcommand("words", "every word and function, one a line");
  app.require_subcommand();
  app.footer(examples({"polyarm language words", "polyarm language page"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  if (page->parsed()) fmt::print("{}", program::language_reference());
  if (!list->parsed()) return kOk;
  for (const program::Word& word : program::words())
    if (word.role != program::WordRole::closer) fmt::print("{:<14}{}\n", word.name, word.meaning);
  for (const program::Function& function : program::functions())
    fmt::print("{:<14}{}: {}\n", std::string(function.name) + "()", function.signature, function.meaning);
  return kOk;
}

}  // namespace polyarm::apps
