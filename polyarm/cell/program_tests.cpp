#include "polyarm/cell/program_tests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/cell/inside.hpp"
#include "polyarm/cell/typed_words.hpp"
#include "polyarm/cell/wait_hints.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/program/code.hpp"
#include "polyarm/program/lexer.hpp"
#include "polyarm/program/parser.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

namespace {
/// The folder of the cell that a file of tests belongs to.
std::optional<fs::path> cell_above(const fs::path& file) {
  std::error_code error;
  for (fs::path folder = fs::absolute(file).parent_path();; folder = folder.parent_path()) {
    if (fs::exists(folder / "cell.yaml", error)) return folder;
    if (folder == folder.parent_path()) return std::nullopt;
  }
}

std::vector<fs::path> scripts_at(const fs::path& path) {
  if (!fs::is_directory(path)) return {path};
  std::vector<fs::path> out;
  for (auto at = fs::recursive_directory_iterator(path); at != fs::recursive_directory_iterator(); ++at) {
    const std::string name = at->path().filename().string();
    if (at->is_directory() && name.starts_with(".")) at.disable_recursion_pending();
    if (at->is_regular_file() && at->path().extension() == ".script") out.push_back(at->path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// Whether a line of `text` begins with the word `test`: everything else is no file of tests.
bool may_hold_tests(const std::string& text) {
  for (const std::string& line : program::split_lines(text)) {
    const auto words = split_words(line);
    if (words.size() > 1 && equal_ignoring_case(words[0], "test") && words[1].starts_with('"')) return true;
  }
  return false;
}

/// What program, PLC and test tell.
class Listener : public Observer {
 public:
  void on_log(Nanoseconds time, const std::string& task, const std::string& text) override {
    lines.push_back(fmt::format("{:.3f} s {}: {}", seconds(time), task, text));
  }
  std::vector<std::string> lines;
};
}  // namespace

std::vector<ProgramTest> find_tests(const fs::path& path, Problems& problems) {
  if (!fs::exists(path)) throw Error("no-file", "there is no '" + path.string() + "'");
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
      problems.error("no-cell", {file.string()}, "no folder from that of this file upwards has a cell.yaml",
                     "put the tests beside the cell that they are about");
      continue;
    }
    const auto tests = program::tests(program);
    for (std::size_t i = 0; i < tests.size(); ++i)
      out.push_back({file, i, tests[i]->name, tests[i]->place.line, *cell});
  }
  return out;
}

TestTask::TestTask(CellInside& cell, program::Program tests, std::size_t index, ProgramHost::Context context,
                   Problems& problems)
    : cell_(cell) {
  const std::vector<std::pair<const char*, data::Value>> names = {{"program.running", false},
                                                                  {"program.state", "waiting"},
                                                                  {"program.line", 0},
                                                                  {"program.passes", 0},
                                                                  {"program.error", ""}};
  for (const auto& [name, value] : names) cell.data.store.declare_tag(name, value, data::TagRole::state);
  program::KnownNames known;
  known.add(cell.data.store);
  known.folder = cell.setup.file.folder;
  program::check(tests, known, problems);
  const auto all = program::tests(tests);
  if (index >= all.size()) throw Error("no-test", fmt::format("{} has {} tests", tests.file, all.size()));
  program::for_each_statement(all[index]->body, [&](const program::Statement& s) {
    program::for_each_expression(s, [&](const program::Expression& e) {
      for (const std::string& name : program::names_read(e))
        asks_for_error_ = asks_for_error_ || name == "program.error" || name == "program.state";
    });
  });
  context.task = "test";
  context.run_program = [this](const std::string& name, const Location& where) {
    cell_.programs->begin(name, where);
  };
  context.call = [this](std::string_view function, std::span<const data::Value> arguments,
                        const Location& where) { return call(function, arguments, where); };
  task_ = std::make_unique<Task>("test", std::move(tests), std::move(context), index);
}

void TestTask::tick() {
  tell_of_program();
  task_->tick();
}

void TestTask::tell_of_program() {
  Task* program = cell_.programs->program();
  std::string error;
  if (cell_.life->failure()) error = cell_.life->failure()->problem.what;
  if (program && program->status().problem) error = program->status().problem->what;
  const auto state = program ? program->status().state : program::TaskState::waiting;
  data::DataStore& store = cell_.data.store;
  store.set("program.running", program && !program->ended(), "cell");
  store.set("program.state", program ? program::name(state) : "waiting", "cell");
  store.set("program.line", program ? program->status().where.line : 0, "cell");
  store.set("program.passes", program ? static_cast<double>(program->status().passes) : 0.0, "cell");
  store.set("program.error", error, "cell");
}

std::optional<Problem> TestTask::problem() const {
  if (task_->failed() && task_->status().problem) {
    Problem out = *task_->status().problem;
    explain_timeout({cell_.setup, cell_.machine, cell_.data, *cell_.motions, *cell_.programs}, *task_, out);
    return out;
  }
  if (cell_.life->failure() && !asks_for_error_) return cell_.life->failure()->problem;
  return std::nullopt;
}

data::Value TestTask::call(std::string_view function, std::span<const data::Value> arguments,
                           const Location& where) {
  const std::string& name = *arguments[0].as_text();
  if (function == "part") return part(name, where);
  if (function == "person") {
    person(name, where);
    return true;
  }
  double value = std::numeric_limits<double>::quiet_NaN();  // heal
  if (function == "fault") {
    const data::Value& forced = arguments[1];
    if (!forced.as_boolean() && !forced.as_number())
      throw Error(Problem{"bad-type", where, "a fault is a number, or true or false", {}});
    value = forced.as_boolean() ? (*forced.as_boolean() ? 1.0 : 0.0) : forced.as_number()->value;
  }
  try {
    cell_.machine.loop().hardware().force(name, value);
  } catch (const Error& e) {
    Problem problem = e.problems().front();
    problem.where = where;
    throw Error(std::move(problem));
  }
  return true;
}

/// What somebody types at the console of the cell.
void TestTask::person(const std::string& words, const Location& where) {
  const std::optional<protocol::Request> request = typed_request(words);
  if (words == "stop") return cell_.programs->stop_all();
  if (!request) return cell_.programs->answers().give(words);
  cell_.requests.ask(*request, [&](const protocol::Reply& reply) {
    if (!reply.refusal) return true;
    const Problem& why = reply.refusal->problems().front();
    throw Error(Problem{"refused", where, why.what, why.advice});
  });
}

data::Value TestTask::part(const std::string& name, const Location& where) const {
  const auto& parts = cell_.setup.scene.parts;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    names.push_back(parts[i].name);
    const auto& seen = cell_.machine.snapshot().world.parts;
    if (parts[i].name == name && i < seen.size()) return data::Point{seen[i].pose, true};
  }
  throw Error(Problem{"unknown-part", where,
                      "the scene has no part '" + name + "'" + did_you_mean(name, names),
                      names.empty() ? "this cell has no simulated scene" : "parts are " + join(names, ", ")});
}

TestResult run_test(const ProgramTest& test, const description::Catalogue& catalogue,
                    const TestOptions& options) {
  TestResult out;
  Listener listener;
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
    TestTask& task = *inside.programs->test();
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
                      "give its waits a timeout, or say --seconds"});
      }
      loop.step_next();
    }
    loop.end();
    out.cell_time_s = seconds(loop.cycle().time);
    if (const auto problem = task.problem()) {
      out.problems.push_back(*problem);
      // What ended the program says more than what the test missed then.
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
