/// Requests about the text of programs: what is wrong with it, its statements as a list, what it may say, and
/// building the cell anew.
#include <algorithm>
#include <map>

#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/known_cells.hpp"
#include "polyarm/cell/build.hpp"
#include "polyarm/cell/requests_later.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/program/functions.hpp"
#include "polyarm/program/lexer.hpp"
#include "polyarm/program/parser.hpp"
#include "polyarm/program/words.hpp"

namespace polyarm::cell {

namespace {

using program::Block;
using program::Program;
using program::Statement;

constexpr std::size_t kLargest = 900'000;

Json finding_json(const Problem& p) {
  return {{"code", p.code},           {"severity", p.severity == Severity::error ? "error" : "warning"},
          {"file", p.where.file},     {"line", p.where.line},
          {"column", p.where.column}, {"what", p.what},
          {"advice", p.advice}};
}

/// The text that a request is about, and the file that it is or will be.
struct Source {
  std::filesystem::path file;
  std::optional<std::string> text;
  std::string read() const { return text ? *text : read_file(file); }
};

Source source_of(Cell& cell, const Json& arguments) {
  Source out;
  out.file = project_file(cell.file().folder, text_argument(arguments, "name"));
  if (arguments.contains("text") && !arguments["text"].is_null()) out.text = text_argument(arguments, "text");
  if (out.text && out.text->size() > kLargest) throw Error("too-large", "the text has more than 900 kB");
  return out;
}

/// Names of data that the program loads and the cell may not have loaded.
void add_loaded(const Program& program, program::KnownNames& known) {
  for (const Statement* load : program::loads(program)) try {
      const data::LoadedFiles files =
          data::load_files(load->name, *known.folder, program.at(load->name_place));
      known.add(files.data.values());
      for (const data::ImportFile& points : files.points) known.add(points.values());
    } catch (const Error&) {  // the checker says what is wrong with the load
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

/// Walks through the statements of the file itself, not of what it includes.
class Steps {
 public:
  explicit Steps(const Program& program) : program_(program) {}
  Json list() {
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
        Json points = Json::array();
        for (const auto& argument : statement.arguments) points.push_back(program::spelled(*argument));
        out_.back()["points"] = points;
        out_.back()["name"] = program::spelling(statement.motion);
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
    out_.push_back({{"kind", kind},
                    {"line", line},
                    {"end", line},
                    {"depth", depth},
                    {"text", program_.source({line, 1, 0})},
                    {"name", name},
                    {"points", Json::array()}});
  }
  /// Every step ends with its statement, or where its block is closed or goes on with another branch.
  void close() {
    std::stable_sort(out_.begin(), out_.end(),
                     [](const Json& a, const Json& b) { return a["line"] < b["line"]; });
    std::map<int, std::size_t> at;  // step by line
    for (std::size_t i = 0; i < out_.size(); ++i) at.try_emplace(out_[i]["line"].get<int>(), i);
    std::vector<std::optional<std::size_t>> open;
    int before = 0;  // last line of the statement before
    for (const program::SourceLine& line : program::read_source(program_.lines)) {
      const auto found = at.find(line.place.line);
      const auto step = found == at.end() ? std::nullopt : std::optional(found->second);
      const int last = line.place.line + static_cast<int>(std::count(line.raw.begin(), line.raw.end(), '\n'));
      if (step) out_[*step]["end"] = last;
      const program::BlockRole role = program::block_role(line);
      const bool ends = role == program::BlockRole::continues || role == program::BlockRole::closes;
      if (ends && !open.empty()) {
        if (open.back()) out_[*open.back()]["end"] = role == program::BlockRole::closes ? last : before;
        open.pop_back();
      }
      if (role == program::BlockRole::opens || role == program::BlockRole::continues) open.push_back(step);
      before = last;
    }
  }

  const Program& program_;
  Json out_ = Json::array();
};

Poll program_check(Cell& cell, const Json& arguments) {
  const Source source = source_of(cell, arguments);
  program::KnownNames known;
  known.add(cell.store());
  known.folder = cell.file().folder;
  add_robots(cell.file(), known);
  return later<Json>(
      cell,
      [source, known = std::move(known)]() mutable {
        Problems found;
        const Program parsed = program::parse(source.read(), source.file.string(), found);
        add_loaded(parsed, known);
        program::check(parsed, known, found);
        Json out = Json::array();
        for (const Problem& problem : found.list()) out.push_back(finding_json(problem));
        return Json{{"problems", out}};
      },
      [](Cell&, Json& out) { return std::move(out); });
}

Poll program_steps(Cell& cell, const Json& arguments) {
  return later<Json>(
      cell,
      [source = source_of(cell, arguments)] {
        Problems found;
        const Program parsed = program::parse(source.read(), source.file.string(), found);
        Json problems = Json::array();
        for (const Problem& problem : found.list()) problems.push_back(finding_json(problem));
        return Json{{"steps", Steps(parsed).list()}, {"problems", problems}};
      },
      [](Cell&, Json& out) { return std::move(out); });
}

Poll program_names(Cell& cell, const Json&) {
  constexpr const char* kKinds[] = {"boolean", "number", "text", "list", "joints", "pose", "record"};
  Json names = Json::array();
  std::vector<std::string> known = cell.store().names();
  std::sort(known.begin(), known.end());
  for (const std::string& each : known) {
    const data::Value& value = *cell.store().find(each);
    names.push_back(
        {{"name", each},
         {"kind", cell.store().is_tag(each) ? "tag" : kKinds[static_cast<std::size_t>(value.kind())]},
         {"text", value.text()}});
  }
  for (const auto& robot : cell.robots())
    names.push_back({{"name", robot->entry.name}, {"kind", "robot"}, {"text", robot->entry.model}});
  return at_once({{"names", names}, {"version", cell.store().version()}});
}

Poll language_words(Cell&, const Json&) {
  constexpr const char* kRoles[] = {"statement", "branch", "closer", "clause", "reserved"};
  Json words = Json::array(), functions = Json::array();
  for (const program::Word& word : program::words())
    words.push_back({{"name", word.name},
                     {"role", kRoles[static_cast<std::size_t>(word.role)]},
                     {"form", word.form},
                     {"meaning", word.meaning},
                     {"in_tests", word.in_tests}});
  for (const program::Function& function : program::functions())
    functions.push_back({{"name", function.name},
                         {"signature", function.signature},
                         {"meaning", function.meaning},
                         {"in_tests", function.in_tests}});
  return at_once({{"words", words}, {"functions", functions}});
}

Poll cell_restart(Cell& cell, const Json& arguments) {
  RestartWish wish;
  wish.robot = text_argument(arguments, "robot", "");
  wish.hardware = text_argument(arguments, "hardware", "");
  wish.program = text_argument(arguments, "program", "");
  wish.cell = text_argument(arguments, "cell", "");
  require_within_reach(wish, cell.file().folder);
  cell.ask_restart(std::move(wish));
  return at_once({{"asked", "restart"}});
}

}  // namespace

const std::vector<RequestRow>& text_rows() {
  static const std::vector<RequestRow> table = {
      {{"language.words",
        {},
        "{words: [{name, role, form, meaning, in_tests}], functions: [{name, signature, meaning, in_tests}]}",
        "every word and function that programs have",
        false},
       language_words},
      {{"program.check",
        {{"name", kText, true}, {"text", kText}},
        "{problems: [{code, severity, file, line, column, what, advice}]}",
        "what is wrong with a program, as it is in the file or as `text`",
        false},
       program_check},
      {{"program.steps",
        {{"name", kText, true}, {"text", kText}},
        "{steps: [{kind, line, end, depth, text, name, points}], problems}",
        "a program as the list of its statements, with the lines that each has",
        false},
       program_steps},
      {{"program.names",
        {},
        "{names: [{name, kind, text}], version}",
        "every name that a program of this cell may say",
        false},
       program_names},
      {{"cell.restart",
        {{"robot", kText}, {"hardware", kText}, {"program", kText}, {"cell", kText}},
        "{asked}",
        "stop on the path, and build the cell anew from its files: with another `robot` (MODEL or "
        "NAME=MODEL), `hardware`, "
        "`program` or `cell`; parts are where they begin",
        true},
       cell_restart},
  };
  return table;
}

}  // namespace polyarm::cell
