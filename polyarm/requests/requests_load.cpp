/// Requests that load programs into a running cell, start them, answer their questions, and report events.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/inside/requests_later.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/operation/program_status.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/protocol/programs.hpp"
#include "polyarm/requests/families.hpp"
#include "polyarm/setup/build.hpp"
#include "polyarm/tasks/program_hash.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// The parts of the cell that loading needs.
struct LoadOwners {
  const CellSetup& setup;
  Machine& machine;
  CellData& data;
  Motions& motions;
  Programs& programs;
  const Jogging& jogging;
  const Arming& arming;
  Worker& worker;
  const EventLog& events;
};
namespace fs = std::filesystem;
/// A program that is being loaded. The worker writes, then sets `ready`; the cell thread reads after that.
struct Loading {
  std::string name;
  fs::path folder;
  StateFolder files;
  std::optional<program::Program> program;
  std::vector<std::pair<std::string, Location>> sets;  ///< data sets that exist from the start
  program::KnownNames known;
  Problems problems;
  std::optional<Error> error;
  std::atomic<bool> ready{false};

  Loading(std::string named, const LoadOwners& cell, StateFolder state)
      : name(std::move(named)), folder(cell.setup.file.folder), files(std::move(state)) {}

  void read() {
    fs::path path = data::find_file(name, folder);
    if (path.extension() != ".script") {
      std::error_code unknown;
      const std::string set = path.stem().string();
      if (!fs::equivalent(path.parent_path().empty() ? "." : path.parent_path(), folder, unknown))
        throw Error("elsewhere", path.string() + " is not in the folder of the cell",
                    "copy it and what it names to " + fs::weakly_canonical(folder).string());
      files.renew(set, {});
      const fs::path script = data::load_files(set, folder).script;
      if (script.empty())
        throw Error(Problem{"no-script",
                            {path.string()},
                            "'" + name + "' names no script",
                            "add 'Name: ScriptFile' and 'Text: <script>' to it, or load a .script"});
      sets.push_back({set, {path.string()}});
      path = script;
    }
    program = program::load_program(path.string());
    for (const program::Statement* load : program::loads(*program)) {
      const Location where = program->at(load->name_place);
      const bool known_already =
          std::any_of(sets.begin(), sets.end(), [&](const auto& set) { return set.first == load->name; });
      if (known_already) continue;
      try {
        files.renew(load->name, where);
        sets.push_back({load->name, where});
      } catch (const Error& e) {
        if (e.problems().front().code != "no-file") throw;  // the checker reports missing files
      }
    }
  }
  void check() {
    program::check(*program, known, problems);
    problems.throw_if_errors();
  }
};

/// Runs a step of loading on the worker; true when it is done. Rethrows its error.
bool done(const LoadOwners& cell, const std::shared_ptr<Loading>& loading, bool& posted,
          void (Loading::*step)()) {
  if (!std::exchange(posted, true)) {
    loading->ready = false;
    cell.worker.post([loading, step] {
      try {
        ((*loading).*step)();
      } catch (const Error& e) {
        loading->error = e;
      } catch (const std::exception& e) {
        loading->error = Error("unreadable", loading->name + ": " + e.what());
      }
      loading->ready.store(true, std::memory_order_release);
    });
  }
  if (!loading->ready.load(std::memory_order_acquire)) return false;
  if (loading->error) throw *loading->error;
  return true;
}

void require_may_begin(const LoadOwners& cell) {
  if (!cell.arming.armed())
    throw Error("disarmed", "nothing moves: the real hardware is not armed", "polyarm control arm");
  const control::RunState state = cell.machine.snapshot().state;
  if (state == control::RunState::fault)
    throw Error("fault", "the cell is in a fault", "polyarm control recover, then resume");
  if (state == control::RunState::stopping || state == control::RunState::backing)
    throw Error("stopping", std::string("the cell is ") + control::name(state),
                "try again when it is at rest");
  if (state != control::RunState::running)
    throw Error("held", std::string("the cell is ") + control::name(state),
                "continue: polyarm control resume; or discard the motion: polyarm control discard");
}

Poll<ProgramLoad::Answer> program_load(const LoadOwners& cell, const ProgramLoad& request) {
  using Loaded = Progress<ProgramLoad::Answer>;
  if (cell.programs.program() && cell.programs.begun() && !cell.programs.program()->ended())
    throw Error("program-runs", "a program is running: " + cell.programs.program()->sentence(),
                "end it first: program.stop");
  auto loading = std::make_shared<Loading>(request.file, cell, cell.data.files().folder());
  enum class At { reading, data, checking } at = At::reading;
  return [cell, loading, at, posted = false, next = std::size_t{0}, handle = std::int64_t{0}]() mutable {
    if (at == At::reading) {
      if (!done(cell, loading, posted, &Loading::read)) return Loaded{};
      at = At::data;
    }
    for (; at == At::data && next < loading->sets.size(); ++next) {
      if (handle == 0)
        handle = cell.data.files().start_load(loading->sets[next].first, loading->sets[next].second);
      if (!cell.data.files().poll_load(handle)) return Loaded{};
      handle = 0;
    }
    if (at == At::data) {
      loading->known.add(cell.data.store);
      add_robots(cell.setup.file, loading->known);
      loading->known.folder = loading->folder;
      posted = false;
      at = At::checking;
    }
    if (!done(cell, loading, posted, &Loading::check)) return Loaded{};
    cell.programs.put(std::move(*loading->program));
    ProgramLoad::Answer out{
        program_status({cell.setup, cell.machine, cell.programs, cell.jogging, cell.events, cell.data}), {}};
    for (const Problem& problem : loading->problems.list()) out.warnings.push_back(problem.text());
    return Loaded::done(std::move(out));
  };
}

}  // namespace

std::string program_hash(const program::Program& program) {
  std::string all;
  const auto add = [&](const std::string& file, const std::vector<std::string>& lines) {
    all += file + '\0';
    for (const std::string& line : lines) all += line + '\n';
  };
  add(program.file, program.lines);
  for (const auto& included : program.included) add(included.file, included.lines);
  return content_hash(all);
}

namespace {

/// True if files of the prepared program were written since they were read. Throws Error if they now contain
/// errors.
bool written_since(const LoadOwners& cell) {
  const program::Interpreter& read = cell.programs.program()->interpreter();
  const program::Program now = program::load_program(read.program().file);
  if (now.lines != read.program().lines || now.included.size() != read.program().included.size()) return true;
  for (std::size_t i = 0; i < now.included.size(); ++i)
    if (now.included[i].lines != read.program().included[i].lines) return true;
  return false;
}

/// The prepared program must be the one that was shown to the person who starts it.
void require_as_shown(const LoadOwners& cell, const ProgramStart& request) {
  const program::Program& loaded = cell.programs.program()->interpreter().program();
  const std::string file = request.file.value_or(""), hash = request.hash.value_or("");
  std::error_code error;
  const bool same = file == loaded.file || fs::equivalent(cell.setup.file.folder / file, loaded.file, error);
  if (!file.empty() && !same)
    throw Error("program-changed",
                "'" + loaded.file + "' is ready now, not '" + file + "', which was to start",
                "check it, then start it");
  if (!hash.empty() && hash != program_hash(loaded))
    throw Error("program-changed", "'" + loaded.file + "' was changed since it was shown",
                "check it, then start it");
}

/// `saved` is the hash of the program with its includes, or of its script alone as files.read reports it.
void require_saved_as_shown(const LoadOwners& cell, const std::string& saved) {
  const std::string file = cell.programs.program()->interpreter().program().file;
  if (saved.empty() || saved == program_hash(program::load_program(file)) || saved == content_hash(read_file(file)))
    return;
  throw Error("program-changed", "the files of '" + file + "' were changed since they were shown",
              "check them, then start it");
}

ProgramStatus program_start(const LoadOwners& cell, const ProgramStart& request) {
  require_may_begin(cell);
  if (!cell.programs.program())
    throw Error("no-program", "the cell has no program", "load one: program.load, polyarm console");
  if (cell.programs.begun())
    throw Error("program-begun", "the program has begun already: " + cell.programs.program()->sentence(),
                cell.programs.program()->ended() ? "load it again: program.load" : "continue: program.go");
  const double passes = request.passes.value_or(0);
  if (!(passes >= 0 && passes < 1e15 && passes == std::floor(passes)))
    throw Error("bad-argument", "'passes' is " + format_number(passes), "a whole number; 0: no limit");
  if (!cell.motions.all_idle()) throw Error("moving", "a robot still moves", "wait until it has arrived");
  require_as_shown(cell, request);
  if (request.as_saved && written_since(cell)) {
    require_saved_as_shown(cell, request.saved.value_or(""));
    const fs::path file = cell.programs.program()->interpreter().program().file;
    cell.programs.prepare(fs::proximate(file, cell.setup.file.folder).string(), 0);  // searched there
    cell.programs.program()->interpreter().resume();
  }
  program::Interpreter& interpreter = cell.programs.program()->interpreter();
  if (passes > 0) interpreter.limit_passes(static_cast<std::uint64_t>(passes));
  if (request.paused) interpreter.pause_here();
  cell.programs.program()->refresh();
  cell.programs.let_begin();
  return program_status({cell.setup, cell.machine, cell.programs, cell.jogging, cell.events, cell.data});
}

Asked program_answer(const LoadOwners& cell, const ProgramAnswer& request) {
  const bool asks = cell.programs.program() && cell.programs.begun() && !cell.programs.program()->ended() &&
                    cell.programs.program()->status().waiting.kind == program::WaitKind::user;
  if (!asks)
    throw Error("no-question", "the program has no question now",
                "the request `program` reports what it waits for");
  const std::string& whole = cell.programs.program()->status().waiting.text;
  const std::string question = whole.substr(0, whole.find('\n'));
  if (request.question && *request.question != question)
    throw Error("other-question", "the program has another question now: " + question, "read it, then answer again");
  if (!cell.programs.answers().answer(request.text.value_or("")))
    throw Error("answered-already", "the question is answered already, and the program has not continued yet",
                "resume the cell");
  return {"answer"};
}

/// Events are reported in batches, so a late listener receives the stored events at once.
Poll<WatchEvents::Answer> events(const LoadOwners& cell, const WatchEvents& request) {
  using Happened = Progress<WatchEvents::Answer>;
  const double since = request.since.value_or(static_cast<double>(cell.events.last()));
  return [cell, reported = since >= 0 ? static_cast<std::uint64_t>(since) : 0, first = true]() mutable {
    WatchEvents::Answer out;
    for (const Event& event : cell.events.events())
      if (event.number > reported) out.push_back(event);
    reported = std::max(reported, cell.events.last());
    if (out.empty() && !std::exchange(first, false)) return Happened{};
    first = false;
    return Happened::more(std::move(out));
  };
}

}  // namespace

std::vector<Handler> load_handlers() {
  return handlers<events, program_load, program_start, program_answer>();
}

}  // namespace polyarm::cell
