/// Requests about the text of programs: check it, list its statements, list the words and names that it may
/// use, and rebuild the cell.
#include <algorithm>
#include <map>

#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/handlers.hpp"
#include "polyarm/cell/known_cells.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/inside/requests_later.hpp"
#include "polyarm/language/functions.hpp"
#include "polyarm/language/lexer.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/language/words.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/protocol/projects.hpp"
#include "polyarm/setup/build.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// The parts of the cell that these handlers read.
struct TextOwners {
  const CellSetup& setup;
  const CellData& data;
  LifeCycle& life;
  Worker& worker;
};
using program::Block;
using program::Program;
using program::Statement;


std::vector<Finding> findings_of(const Problems& problems) {
  std::vector<Finding> out;
  for (const Problem& p : problems.list())
    out.push_back({p.code, static_cast<FindingSeverity>(p.severity), p.where.file, p.where.line,
                   p.where.column, p.what, p.advice, protocol::facts_of(p)});
  return out;
}

/// The text of a request, and the file that it belongs to or will be saved to.
struct Source {
  std::filesystem::path file;
  std::optional<std::string> text;
  std::string read() const { return text ? *text : read_file(file); }
};

Source source_of(const TextOwners& cell, const std::string& name, const std::optional<std::string>& text) {
  Source out{project_file(cell.setup.file.folder, name), text};
  if (out.text && out.text->size() > kLargestText) throw Error("too-large", "the text has more than 900 kB");
  return out;
}

/// Adds the names of data files that the program loads but the cell may not have loaded.
void add_loaded(const Program& program, program::KnownNames& known) {
  for (const Statement* load : program::loads(program)) try {
      const data::LoadedFiles files =
          data::load_files(load->name, *known.folder, program.at(load->name_place));
      known.add(files.data.values());
      for (const data::ImportFile& points : files.points) known.add(points.values());
    } catch (const Error&) {  // the checker reports what is wrong with the load
    }
}

const char* kind_name(const Statement& statement) {
  constexpr const char* kKinds[] = {"load",      "import", "set",     "set",   "let",  "move",     "use",
                                    "wait time", "wait",   "ask",     "while", "if",   "for",      "break",
                                    "continue",  "stop",   "hold",    "log",   "call", "include",  "function",
                                    "return",    "try",    "raise",   "retry", "task", "together", "meet",
                                    "lock",      "when",   "on stop", "test",  "run",  "expect"};
  return kKinds[static_cast<std::size_t>(statement.kind)];
}

/// Lists the statements of the file itself, without included files.
class Steps {
 public:
  explicit Steps(const Program& program) : program_(program) {}
  std::vector<StatementFacts> list() {
    block(program_.statements, 0);
    close();
    return out_;
  }

 private:
  void block(const Block& statements, int depth) {
    for (const Statement& statement : statements) {
      if (statement.place.file != 0 || statement.place.line <= 0) continue;
      add(kind_name(statement), statement.place.line, depth, statement.name);
      if (statement.kind == Statement::Kind::move) {
        for (const auto& argument : statement.arguments)
          out_.back().points.push_back(program::spelled(*argument));
        out_.back().name = program::spelling(statement.motion);
      }
      for (const program::Clause& clause : statement.clauses) block(clause.otherwise, depth + 1);
      block(statement.body, depth + 1);
      bool first = true;
      for (const program::Branch& branch : statement.branches) {
        if (!std::exchange(first, false) && branch.place.line > 0)
          add(branch.condition ? "else if" : "else", branch.place.line, depth, "");
        block(branch.body, depth + 1);
      }
      if (!statement.handler.empty() && statement.handler_place.line > 0)
        add("on error", statement.handler_place.line, depth, "");
      block(statement.handler, depth + 1);
    }
  }
  void add(const char* kind, int line, int depth, const std::string& name) {
    out_.push_back({kind, line, line, depth, program_.source({line, 1, 0}), name, {}});
  }
  /// Sets each step's last line: the end of its statement, or the line that closes its block or begins
  /// another branch.
  void close() {
    std::stable_sort(out_.begin(), out_.end(),
                     [](const StatementFacts& a, const StatementFacts& b) { return a.line < b.line; });
    std::map<int, std::size_t> at;  // step by line
    for (std::size_t i = 0; i < out_.size(); ++i) at.try_emplace(out_[i].line, i);
    std::vector<std::optional<std::size_t>> open;
    int before = 0;  // last line of the previous statement
    for (const program::SourceLine& line : program::read_source(program_.lines)) {
      const auto found = at.find(line.place.line);
      const auto step = found == at.end() ? std::nullopt : std::optional(found->second);
      const int last = line.place.line + static_cast<int>(std::count(line.raw.begin(), line.raw.end(), '\n'));
      if (step) out_[*step].end = last;
      const program::BlockRole role = program::block_role(line);
      const bool ends = role == program::BlockRole::continues || role == program::BlockRole::closes;
      if (ends && !open.empty()) {
        if (open.back()) out_[*open.back()].end = role == program::BlockRole::closes ? last : before;
        open.pop_back();
      }
      if (role == program::BlockRole::opens || role == program::BlockRole::continues) open.push_back(step);
      before = last;
    }
  }

  const Program& program_;
  std::vector<StatementFacts> out_;
};

Poll<ProgramCheck::Answer> program_check(const TextOwners& cell, const ProgramCheck& request) {
  const Source source = source_of(cell, request.name, request.text);
  program::KnownNames known;
  known.add(cell.data.store);
  known.folder = cell.setup.file.folder;
  add_robots(cell.setup.file, known);
  return later(cell.worker, [source, known = std::move(known)]() mutable {
    Problems found;
    const Program parsed = program::parse(source.read(), source.file.string(), found);
    add_loaded(parsed, known);
    program::check(parsed, known, found);
    return ProgramCheck::Answer{findings_of(found)};
  });
}

Poll<ProgramSteps::Answer> program_steps(const TextOwners& cell, const ProgramSteps& request) {
  return later(cell.worker, [source = source_of(cell, request.name, request.text)] {
    Problems found;
    const Program parsed = program::parse(source.read(), source.file.string(), found);
    return ProgramSteps::Answer{Steps(parsed).list(), findings_of(found)};
  });
}

ProgramNames::Answer program_names(const TextOwners& cell, const ProgramNames&) {
  constexpr const char* kKinds[] = {"boolean", "number", "text", "list", "joints", "pose", "record"};
  ProgramNames::Answer out{{}, cell.data.store.version()};
  std::vector<std::string> known = cell.data.store.names();
  std::sort(known.begin(), known.end());
  for (const std::string& each : known) {
    const data::Value& value = *cell.data.store.find(each);
    const char* const kind =
        cell.data.store.is_tag(each) ? "tag" : kKinds[static_cast<std::size_t>(value.kind())];
    out.names.push_back({each, kind, value.text()});
  }
  for (const auto& robot : cell.setup.robots)
    out.names.push_back({robot->entry.name, "robot", robot->entry.model});
  return out;
}

LanguageWords::Answer language_words(const TextOwners&, const LanguageWords&) {
  constexpr const char* kRoles[] = {"statement", "branch", "closer", "clause", "reserved"};
  LanguageWords::Answer out;
  for (const program::Word& word : program::words())
    out.words.push_back({std::string(word.name), kRoles[static_cast<std::size_t>(word.role)], std::string(word.form),
                         std::string(word.meaning), word.in_tests});
  for (const program::Function& function : program::functions())
    out.functions.push_back({std::string(function.name), std::string(function.signature),
                             std::string(function.meaning), function.in_tests});
  return out;
}

protocol::Asked cell_restart(const TextOwners& cell, const CellRestart& request) {
  RestartRequest wish;
  wish.robot = request.robot.value_or("");
  wish.hardware = request.hardware.value_or("");
  wish.program = request.program.value_or("");
  wish.cell = request.cell.value_or("");
  require_within_reach(wish, cell.setup.file.folder);
  cell.life.request_restart(std::move(wish));
  return {"restart"};
}

}  // namespace

std::vector<Handler> text_handlers() {
  return handlers<language_words, program_check, program_steps, program_names, cell_restart>();
}

}  // namespace polyarm::cell
