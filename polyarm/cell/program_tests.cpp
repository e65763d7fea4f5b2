#include "polyarm/cell/program_tests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/there.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/inside/test_task.hpp"
#include "polyarm/language/lexer.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/program/code.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

namespace {
/// The nearest folder above a test file that contains a cell.yaml.
std::optional<fs::path> cell_above(const fs::path& file) {
  std::error_code error;
  for (fs::path folder = fs::absolute(file).parent_path();; folder = folder.parent_path()) {
    if (fs::exists(folder / "cell.yaml", error)) return folder;
    if (folder == folder.parent_path()) return std::nullopt;
  }
}

std::vector<fs::path> scripts_at(const fs::path& path) {
  if (!is_folder(path)) return {path};
  std::vector<fs::path> out;
  for (auto at = fs::recursive_directory_iterator(path); at != fs::recursive_directory_iterator(); ++at) {
    const std::string name = at->path().filename().string();
    if (at->is_directory() && name.starts_with(".")) at.disable_recursion_pending();
    if (at->is_regular_file() && at->path().extension() == ".script") out.push_back(at->path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// True if a line begins with the word `test` and a quoted name; only such a file is a test file.
bool may_hold_tests(const std::string& text) {
  for (const std::string& line : program::split_lines(text)) {
    const auto words = split_words(line);
    if (words.size() > 1 && equal_ignoring_case(words[0], "test") && words[1].starts_with('"')) return true;
  }
  return false;
}

/// Collects the log of program, PLC and test.
class LogListener : public Observer {
 public:
  void on_log(Nanoseconds time, const std::string& task, const std::string& text) override {
    lines.push_back(fmt::format("{:.3f} s {}: {}", seconds(time), task, text));
  }
  std::vector<std::string> lines;
};
}  // namespace

std::vector<ProgramTest> find_tests(const fs::path& path, Problems& problems) {
  if (!is_there(path)) throw Error("no-file", "there is no '" + path.string() + "'");
  std::vector<ProgramTest> out;
  for (const fs::path& file : scripts_at(path)) {
    const std::string text = read_file(file);
    if (!may_hold_tests(text)) continue;
    Problems found;
    const program::Program program = program::parse(text, file.string(), found);
    for (const Problem& problem : found.list()) problems.add(problem);
    if (found.has_errors()) continue;
    const auto cell = cell_above(file);
    if (!cell) {
      problems.error("no-cell", {file.string()},
                     "neither the folder of this file nor one above it has a cell.yaml",
                     "put the tests into the folder of their cell");
      continue;
    }
    const auto tests = program::tests(program);
    for (std::size_t i = 0; i < tests.size(); ++i)
      out.push_back({file, i, tests[i]->name, tests[i]->place.line, *cell});
  }
  return out;
}

TestResult run_test(const ProgramTest& test, const description::Catalogue& catalogue,
                    const TestOptions& options) {
  TestResult out;
  LogListener listener;
  try {
    CellOptions cell_options;
    cell_options.lock_step = true;
    cell_options.state_folder = options.state_folder;
    cell_options.test = TestEntry{test.file, test.index};
    Cell cell(read_cell_file(test.cell, options.overrides), catalogue, cell_options, listener);
    CellInside& inside = inside_of(cell);
    control::ControlLoop& loop = inside.machine.loop();
    loop.begin();
    Nanoseconds next_tick = 0;
    TestTask& task = *inside.test;
    while (!task.ended()) {
      if (loop.cycle().time >= next_tick) {
        next_tick = loop.cycle().time + Cell::kTick;
        cell.tick(loop.cycle().time);
        if (task.problem()) break;
        if (seconds(loop.cycle().time) > options.seconds)
          throw Error(
              Problem{"too-long",
                      {test.file.string(), test.line},
                      fmt::format("the test has not ended after {:g} s of cell time", options.seconds),
                      "give its waits a timeout, or allow more with --seconds"});
      }
      loop.step_next();
    }
    loop.end();
    out.cell_time_s = seconds(loop.cycle().time);
    if (const auto problem = task.problem()) {
      out.problems.push_back(*problem);
      // The error that ended the program explains more than the failed test.
      const auto& failure = inside.life->failure();
      if (failure && failure->problem.text() != problem->text()) out.problems.push_back(failure->problem);
    }
  } catch (const Error& e) {
    out.problems = e.problems();
  }
  std::erase_if(out.problems, [](const Problem& p) { return p.severity == Severity::warning; });
  out.log = std::move(listener.lines);
  return out;
}

}  // namespace polyarm::cell
