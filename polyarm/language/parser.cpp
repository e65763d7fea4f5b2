#include "polyarm/language/parser.hpp"

#include <algorithm>
#include <filesystem>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/data/import_format.hpp"
#include "polyarm/language/foreign_words.hpp"
#include "polyarm/language/lexer.hpp"
#include "polyarm/language/libraries.hpp"
#include "polyarm/language/statement_parser.hpp"

namespace polyarm::program {

namespace {
constexpr std::size_t kMostProblems = bounds::kProgramProblems;
constexpr std::size_t kLongestProgram = bounds::kProgramBytes;
static_assert(kDeepestBlocks == bounds::kBlockNesting && kDeepestExpression == bounds::kExpressionNesting);
using Kind = Statement::Kind;

bool one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// `on error` at the start of a statement.
bool is_handler(const SourceLine& source) {
  return source.tokens.size() > 2 && source.tokens[0].kind == TokenKind::name &&
         equal_ignoring_case(source.tokens[0].text, "on") && source.tokens[1].kind == TokenKind::name &&
         equal_ignoring_case(source.tokens[1].text, "error");
}

bool ends_block(const Line& line) {
  return is_closer(line.word) || line.word == "else" || line.word == "elif" || is_handler(line.source);
}

bool is_move(std::string_view word) {
  const auto motion = motion_of(word);
  return motion && *motion < Statement::Motion::drive;
}

/// `wait … timeout … else`, `movel … until … else`, even if it has a fault.
bool ends_with_else(const Line& line) {
  const auto& tokens = line.source.tokens;
  const auto says = [&](std::string_view word) {
    return std::any_of(tokens.begin() + 1, tokens.end(), [&](const Token& t) {
      return t.kind == TokenKind::name && equal_ignoring_case(t.text, word);
    });
  };
  const bool waits = line.word == "wait" || line.word == "meet";
  if (tokens.size() < 5 || !(waits || (is_move(line.word) && says("until")))) return false;
  const Token& last = tokens[tokens.size() - 2];
  return last.kind == TokenKind::name && equal_ignoring_case(last.text, "else");
}

bool opens_block(const Line& line) {
  return one_of(line.word,
                {"while", "if", "for", "func", "task", "together", "when", "trap", "every", "lock", "try", "on", "test"}) ||
         ends_with_else(line);
}

std::string keyword_of(const Token& token, bool& misspelt) {
  misspelt = false;
  if (token.kind != TokenKind::name) return {};
  std::string word = lower(token.text);
  const auto& words = statement_words();
  if (is_statement_word(word)) return word;
  misspelt = true;
  if (const ForeignWord* foreign = foreign_word(word)) return std::string(foreign->keyword);
  return nearest_name(word, words).value_or("");
}

/// True if the line consists of two or more words that close blocks.
bool is_row_of_closers(const SourceLine& source) {
  bool misspelt = false;
  const std::string& first = source.tokens.front().text;
  if (is_statement_word(first) && !is_closer(first)) return false;  // most lines
  return source.tokens.size() > 2 &&
         std::all_of(source.tokens.begin(), source.tokens.end() - 1, [&](const Token& t) {
           return is_closer(keyword_of(t, misspelt)) && lower(t.text) != "wait";
         });
}

class Parser {
 public:
  /// Parses file `file` of the program.
  Parser(Program& program, Problems& problems, int file = 0)
      : program_{program}, problems_{problems}, file_{file} {}

  Block run() {
    prepare(read_source(file_ == 0 ? program_.lines : included().lines, file_));
    Block out = block();
    while (next_ < lines_.size() && !given_up_) {  // a closer that closes nothing
      refuse_closer(lines_[next_]);
      ++next_;
      Block more = block();
      std::move(more.begin(), more.end(), std::back_inserter(out));
    }
    if (file_ == 0) refuse_beside_tests(out);
    return out;
  }

 private:
  /// A test file contains only tests and their shared names; a program contains no tests.
  void refuse_beside_tests(const Block& top) {
    const auto is_test = [](const Statement& s) { return s.kind == Kind::test; };
    if (std::none_of(top.begin(), top.end(), is_test)) return;
    for (const Statement& s : top) {
      const bool fits = is_test(s) || s.kind == Kind::let || s.kind == Kind::function;
      if (!fits)
        error("not-test", s.place, "a file of tests holds only 'test', 'func', 'let' and 'include'",
              "put it into a test, or the tests into a file of their own");
    }
  }

  const Program::Included& included() const { return program_.included[static_cast<std::size_t>(file_) - 1]; }

  void prepare(std::vector<SourceLine> sources) {
    lines_.reserve(sources.size());
    for (SourceLine& source : sources) {
      if (is_row_of_closers(source)) {
        split_closers(source);
        continue;
      }
      Line line;
      line.word = keyword_of(source.tokens.front(), line.misspelt);
      line.source = std::move(source);
      const bool also_names = one_of(line.word, {"drive", "turn", "speedj", "speedl", "trap", "every", "pulse"});
      if ((line.misspelt || also_names) && is_call(line.source)) line.misspelt = false, line.word = "call";
      lines_.push_back(std::move(line));
    }
  }

  static bool is_call(const SourceLine& source) {
    return source.tokens.size() > 2 && source.tokens[1].kind == TokenKind::symbol &&
           source.tokens[1].text == "(";
  }

  void split_closers(const SourceLine& source) {
    const Token& first = source.tokens.front();
    bool misspelt = false;
    const std::string word = keyword_of(first, misspelt);
    if (misspelt) {
      error("unknown-word", first.place,
            "no statement begins with " + shown(first) + "; did you mean '" + word + "'?",
            "write each closing word on its own line");
    } else {
      error("unexpected", source.tokens[1].place, "there are several statements on this line",
            "write each closing word on its own line");
    }
    for (std::size_t i = 0; i + 1 < source.tokens.size(); ++i) {
      Line line;
      line.source = {source.tokens[i].text, source.tokens[i].place, {source.tokens[i], source.tokens.back()}};
      line.word = keyword_of(source.tokens[i], misspelt);
      lines_.push_back(std::move(line));
    }
  }

  void error(std::string code, Place place, std::string what, std::string advice = {}) {
    if (++count_ < kMostProblems)
      problems_.error(std::move(code), program_.at(place), std::move(what), std::move(advice));
    if (count_ == kMostProblems)
      problems_.error("many-errors", program_.at(place), "there are more errors in this file");
  }
  void error(const SyntaxError& e) { error(e.code, e.place, e.what, e.advice); }

  /// Statements up to the next closing word or the end of the file.
  Block block() {
    Block out;
    while (next_ < lines_.size() && !given_up_) {
      Line& line = lines_[next_];
      if (ends_block(line)) {
        if (line.misspelt) refuse_word(line);
        line.misspelt = false;
        return out;
      }
      ++next_;
      statement(line, out);
      line.source = {};  // no longer needed in a long program
    }
    return out;
  }

  void statement(const Line& line, Block& out) {
    Statement made;
    made.place = line.source.place;
    const bool opens = opens_block(line);
    try {
      if (line.misspelt || line.word.empty()) {
        refuse_word(line);
        if (!opens) return;
      }
      TokenCursor cursor(line.source.tokens);
      cursor.take();
      parse_statement(line, cursor, made, open_);
      if (made.kind == Kind::include) return include(made, out);
      if (file_ > 0 && open_.empty() && made.kind != Kind::function && made.kind != Kind::let)
        throw SyntaxError{"not-included", made.place, "an included file holds only 'func' and 'let'", ""};
    } catch (const SyntaxError& e) {
      const bool refused = line.misspelt && foreign_word(line.source.tokens.front().text);
      if (!refused) error(e);  // one error is enough for a line of another language
      if (!opens && made.kind != Kind::let) return;
    }
    if (opens) parse_body(line, made);
    out.push_back(std::move(made));
  }

  /// The functions and names of another file, once, even if it is included repeatedly.
  void include(const Statement& s, Block& out) {
    constexpr std::size_t kMostFiles = 50;
    if (s.name.starts_with(kLibraryPrefix)) return include_library(s, out);
    const std::string by = file_ == 0 ? program_.file : included().file;
    const std::filesystem::path path = (std::filesystem::path(by).parent_path() / s.name).lexically_normal();
    const auto same = [&](const Program::Included& other) { return other.file == path.string(); };
    if (path == std::filesystem::path(by).lexically_normal())
      return error("not-included", s.name_place, "'" + s.name + "' includes itself", "leave this line out");
    if (path == std::filesystem::path(program_.file).lexically_normal())
      return error("not-included", s.name_place, "'" + s.name + "' is the program that includes this file",
                   "put shared functions into a file of their own");
    if (std::any_of(program_.included.begin(), program_.included.end(), same)) return;
    if (program_.included.size() >= kMostFiles)
      return error("too-many", s.name_place, "a program includes at most 50 files");
    std::string text;
    try {
      text = read_file(path, bounds::kProgramBytes);
    } catch (const Error& e) {
      program_.lacks_included = true;
      std::vector<std::string> others = data::file_names_in(path.parent_path());
      std::erase(others, std::filesystem::path(by).filename().string());
      return error("no-file", s.name_place,
                   "'" + s.name + "' cannot be included: " + e.problems().front().what +
                       did_you_mean(path.filename().string(), others),
                   "the name is relative to the folder of this file");
    }
    if (const auto why = data::why_not_text(text)) return error("not-text", s.name_place, *why);
    add_included(path.string(), text, out);
  }

  /// include "polyarm:NAME"
  void include_library(const Statement& s, Block& out) {
    const auto text = library_text(s.name);
    if (!text) {
      const std::vector<std::string> names = library_names();
      return error("no-file", s.name_place, "there is no library '" + s.name + "'" + did_you_mean(s.name, names),
                   "libraries are " + join(names, ", "));
    }
    const bool known = std::any_of(program_.included.begin(), program_.included.end(),
                                   [&](const Program::Included& other) { return other.file == s.name; });
    if (!known) add_included(s.name, *text, out);
  }

  void add_included(const std::string& file, std::string_view text, Block& out) {
    program_.included.push_back({file, split_lines(text)});
    Block more = Parser(program_, problems_, static_cast<int>(program_.included.size())).run();
    std::move(more.begin(), more.end(), std::back_inserter(out));
  }

  void refuse_word(const Line& line) {
    const Token& first = line.source.tokens.front();
    if (first.kind == TokenKind::bad) return error("bad-text", first.place, first.text);
    if (first.kind == TokenKind::number)
      return error("unknown-word", first.place, "a statement begins with a word, here is " + shown(first),
                   "line numbers are no part of a program");
    const Token& second = line.source.tokens[std::min<std::size_t>(1, line.source.tokens.size() - 1)];
    if (first.kind == TokenKind::symbol && second.kind == TokenKind::symbol)  // such as // and --
      return error("unknown-word", first.place, "no statement begins with '" + first.text + second.text + "'",
                   "a comment begins with #");
    if (second.kind == TokenKind::symbol && second.text == "=")
      return error("unknown-word", first.place, "no statement begins with " + shown(first),
                   "to change it write `set " + first.text.substr(0, 40) + " = …`, for a new name `let`");
    if (changes_in_place(line.source.tokens))
      return error("unknown-word", first.place, "no statement begins with " + shown(first),
                   "to change it write `set " + first.text.substr(0, 40) + " = " + first.text.substr(0, 40) + " " +
                       second.text + " …`");
    if (const ForeignWord* foreign = foreign_word(first.text); foreign && first.kind == TokenKind::name)
      return error("unknown-word", first.place, "no statement begins with " + shown(first), foreign->instead);
    error("unknown-word", first.place,
          "no statement begins with " + shown(first) + did_you_mean(first.text, statement_words()), "");
  }

  /// True for `i += 1` and `i++`.
  static bool changes_in_place(const std::vector<Token>& tokens) {
    if (tokens.size() < 3 || tokens[1].kind != TokenKind::symbol || tokens[2].kind != TokenKind::symbol) return false;
    const std::string &operation = tokens[1].text, &then = tokens[2].text;
    const bool calculates = operation == "+" || operation == "-" || operation == "*" || operation == "/";
    return calculates && (then == "=" || (then == operation && then != "*" && then != "/"));
  }

  /// The block that `line` opens, with its branches, up to and including its closing word.
  void parse_body(const Line& line, Statement& out) {
    if (static_cast<int>(open_.size()) >= kDeepestBlocks) {
      error("too-deep", out.place, "blocks are nested deeper than " + std::to_string(kDeepestBlocks),
            "the rest of the file was not read");
      given_up_ = true;
      return;
    }
    open_.push_back({is_move(line.word) ? "move" : line.word, out.place});
    if (line.word == "if" && out.branches.empty()) out.branches.push_back({nullptr, out.place, {}});
    Block* target = line.word == "if" ? &out.branches.back().body : &out.body;
    if (is_move(line.word) && !out.clauses.empty()) target = &out.clauses.back().otherwise;
    bool had_else = false;
    do {
      Block more = block();
      std::move(more.begin(), more.end(), std::back_inserter(*target));
    } while (!given_up_ && !close_block(out, target, had_else));
    open_.pop_back();
  }

  /// Handles the line that ended a block. True if the block of `out` is closed.
  bool close_block(Statement& out, Block*& target, bool& had_else) {
    const Opener& opener = open_.back();
    if (next_ >= lines_.size()) {
      error("unclosed", opener.place, "this '" + opener.word + "' is never closed",
            "add `end" + opener.word + "`");
      return true;
    }
    const Line& line = lines_[next_];
    if (is_handler(line.source)) {
      ++next_;
      begin_handler(line, out, target);
      return false;
    }
    if (!is_closer(line.word)) {
      ++next_;
      next_branch(line, out, target, had_else);
      return false;
    }
    if (line.word == "end" || line.word == "end" + opener.word) {
      ++next_;
      closed_line_ends(line);
      if (opener.word == "try" && !opener.handles)
        error("no-handler", opener.place, "this 'try' has no 'on error'",
              "write `on error e` before its end, and the statements for an error");
      return true;
    }
    return mismatch(line);
  }

  /// on error [NAME]: the following lines run after an error in the previous ones.
  void begin_handler(const Line& line, Statement& out, Block*& target) {
    Opener& opener = open_.back();
    if (opener.word != "try" || opener.handles)
      return error("stray-handler", line.source.place,
                   "'on error' belongs to a 'try', here is the '" + opener.word + "' of line " +
                       std::to_string(opener.place.line),
                   opener.handles
                       ? "it has its 'on error' already, in line " + std::to_string(out.handler_place.line)
                       : std::string("close the block before it"));
    opener.handles = true;
    out.handler_place = line.source.place;
    target = &out.handler;
    const Token& name = line.source.tokens[2];
    if (name.kind == TokenKind::end) return;
    out.name_place = name.place;
    if ((name.kind != TokenKind::name && name.kind != TokenKind::quoted) || is_reserved(name.text))
      return error("no-name", name.place, "a name was expected after 'on error', here is " + shown(name));
    out.name = name.text;
    if (line.source.tokens[3].kind != TokenKind::end)
      error("unexpected", line.source.tokens[3].place,
            shown(line.source.tokens[3]) + " is not expected here, after 'on error'");
  }

  void closed_line_ends(const Line& line) {
    const Token& second = line.source.tokens[1];
    if (second.kind == TokenKind::end) return;
    const bool two_words = line.word == "end" && second.kind == TokenKind::name;
    error("unexpected", second.place, shown(second) + " is not expected here, after '" + line.word + "'",
          two_words ? "a closing word is written in one, such as endwhile" : "write one statement per line");
  }

  bool mismatch(const Line& line) {
    const Opener& opener = open_.back();
    const auto outer = std::find_if(open_.rbegin() + 1, open_.rend(),
                                    [&](const Opener& o) { return line.word == "end" + o.word; });
    const std::string mine = "the '" + opener.word + "' of line " + std::to_string(opener.place.line);
    if (outer == open_.rend()) {
      error("mismatch", line.source.place,
            "'" + line.word + "' in line " + std::to_string(line.source.place.line) + " cannot close " + mine,
            "write `end" + opener.word + "`");
      ++next_;
      return true;
    }
    error("mismatch", line.source.place,
          "'" + line.word + "' in line " + std::to_string(line.source.place.line) + " closes the '" +
              outer->word + "' of line " + std::to_string(outer->place.line) + " while " + mine +
              " is still open",
          "add `end" + opener.word + "` before it");
    return true;
  }

  /// else or elif: the next branch of an if; anywhere else an error.
  void next_branch(const Line& line, Statement& out, Block*& target, bool& had_else) {
    const Opener& opener = open_.back();
    if (opener.word != "if" || had_else) {
      const std::string of = "the '" + opener.word + "' of line " + std::to_string(opener.place.line);
      return error(
          "stray-else", line.source.place,
          had_else ? of + " has its 'else' already, in line " + std::to_string(out.branches.back().place.line)
                   : "'" + line.word + "' does not belong to " + of,
          "");
    }
    out.branches.push_back({nullptr, line.source.place, {}});
    target = &out.branches.back().body;
    try {
      parse_branch(line, out.branches.back(), had_else);
    } catch (const SyntaxError& e) {
      error(e);
    }
  }

  void parse_branch(const Line& line, Branch& branch, bool& had_else) {
    TokenCursor cursor(line.source.tokens);
    cursor.take();
    if (line.word == "elif") {
      branch.condition = cursor.expression();
      return cursor.expect_end("the condition");
    }
    if (cursor.is_word("if"))
      throw SyntaxError{"else-if", line.source.place, "'else if' is two statements on one line",
                        "write `elif`"};
    had_else = true;
    cursor.expect_end("'else'");
  }

  void refuse_closer(const Line& line) {
    const bool closes = is_closer(line.word), handles = is_handler(line.source);
    error("stray-end", line.source.place,
          closes    ? "'" + line.word + "' closes nothing"
          : handles ? "'on error' belongs to no 'try'"
                    : "'" + line.word + "' belongs to no 'if'",
          "");
  }

  Program& program_;
  Problems& problems_;
  std::vector<Line> lines_;
  std::size_t next_ = 0, count_ = 0;
  Openers open_;
  bool given_up_ = false;
  int file_ = 0;
};
}  // namespace

BlockRole block_role(const SourceLine& source) {
  Line line;
  line.word = keyword_of(source.tokens.front(), line.misspelt);
  if (line.misspelt) return BlockRole::none;
  line.source = source;
  if (is_closer(line.word)) return BlockRole::closes;
  if (ends_block(line)) return BlockRole::continues;
  return opens_block(line) ? BlockRole::opens : BlockRole::none;
}

Program parse(std::string_view text, const std::string& file, Problems& problems) {
  Program program;
  program.file = file;
  if (const auto why = data::why_not_text(text)) {
    problems.error("not-text", {file}, *why);
    return program;
  }
  if (text.find('\n') == std::string_view::npos && text.find('\r') + 1 < text.size() &&
      text.find('\r') != std::string_view::npos) {
    problems.error("not-text", {file}, "the lines of this file end with CR alone", "save it with LF");
    return program;
  }
  if (text.size() > kLongestProgram) {
    problems.error("too-large", {file},
                   "this program has " + std::to_string(text.size() >> 20) + " MiB, at most are " +
                       std::to_string(kLongestProgram >> 20),
                   "keep data in data files, and parts of a program in files of their own");
    return program;
  }
  program.lines = split_lines(text);
  Problems found;
  program.statements = Parser(program, found).run();
  std::vector<Problem> list = found.list();
  std::stable_sort(list.begin(), list.end(), [&](const Problem& a, const Problem& b) {
    const bool other_a = a.where.file != file, other_b = b.where.file != file;
    return other_a != other_b ? other_b : a.where.line < b.where.line;
  });
  for (Problem& problem : list) problems.add(std::move(problem));
  return program;
}

Program load_program(const std::string& path) {
  Problems problems;
  Program program = parse(read_file(path, bounds::kProgramBytes), path, problems);
  problems.throw_if_errors();
  return program;
}

}  // namespace polyarm::program
