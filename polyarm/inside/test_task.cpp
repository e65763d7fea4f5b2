#include "polyarm/inside/test_task.hpp"

#include <fmt/format.h>

#include <limits>
#include <utility>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/io/typed_words.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/program/code.hpp"
#include "polyarm/tasks/wait_hints.hpp"

namespace polyarm::cell {

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
    report_of_program();
  };
  context.call = [this](std::string_view function, std::span<const data::Value> arguments,
                        const Location& where) { return call(function, arguments, where); };
  task_ = std::make_unique<Task>("test", std::move(tests), std::move(context), index);
}

void TestTask::tick() {
  report_of_program();
  task_->tick();
}

void TestTask::report_of_program() {
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
  double value = std::numeric_limits<double>::quiet_NaN();  // NaN for `heal`
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

/// Handles text as if a person typed it at the cell's console.
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

}  // namespace polyarm::cell
