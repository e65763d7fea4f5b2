#include <fmt/format.h>

#include "apps/options.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/language/format.hpp"
#include "polyarm/language/parser.hpp"

namespace polyarm::apps {

int run_fmt(int argc, char** argv) {
  CommandLine app("Writes programs in one form; comments stay", "polyarm fmt");
  std::vector<std::string> files;
  bool check = false;
  app.add_option("files", files, "scripts")->required();
  app.add_flag("--check", check, "change nothing; exit code 1 if a file would change");
  app.footer(examples({"polyarm fmt cell.script", "polyarm fmt --check *.script"}) +
             "\nA script with errors is left as it is.\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  bool failed = false;
  for (const std::string& file : files) {
    const std::string text = read_file(file);
    Problems problems;
    program::parse(text, file, problems);
    if (problems.has_errors()) {
      for (const Problem& problem : problems.list()) fmt::print(stderr, "{}\n", problem.text());
      failed = true;
      continue;
    }
    const std::string formatted = program::format(text);
    if (formatted == text) continue;
    fmt::print("{}\n", file);
    if (check)
      failed = true;
    else
      write_file_atomically(file, formatted);
  }
  return failed ? kFailed : kOk;
}

}  // namespace polyarm::apps
