#include "polyarm/program/parser.hpp"

#include <algorithm>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/import_format.hpp"
#include "polyarm/program/expression_parser.hpp"
#include "polyarm/program/lexer.hpp"

namespace polyarm::program {

namespace {
constexpr std::size_t kMostProblems = 200;
using Kind = Statement::Kind;

bool one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Words of the full language that this version refuses by name.
const std::vector<std::string>& later_words() {
  static const std::vector<std::string> words = {
      "movej", "movel", "movec", "include", "use",      "meet", "lock", "func", "return", "try",
      "raise", "retry", "hold",  "task",    "together", "when", "on",   "test", "run",    "expect"};
  return words;
}

bool is_closer(std::string_view word) {
  return one_of(word, {"end", "endwhile", "endif", "endfor", "endwait"});
}
bool ends_block(std::string_view word) {
  return is_closer(word) || word == "else" || word == "elif";
}

/// A statement with the keyword it begins with, corrected where it is misspelt.
struct Line {
  SourceLine source;
  std::string word;  ///< lower case; empty: no keyword is near
  bool misspelt = false;
};

std::string keyword_of(const Token& token, bool& misspelt) {
  misspelt = false;
  if (token.kind != TokenKind::name) return {};
  std::string word = lower(token.text);
  const auto& words = statement_words();
  if (std::find(words.begin(), words.end(), word) != words.end()) return word;
  if (std::find(later_words().begin(), later_words().end(), word) != later_words().end()) return word;
  misspelt = true;
  return nearest_name(word, words).value_or("");
}

/// True where the line is nothing but two or more words that close blocks.
bool is_row_of_closers(const SourceLine& source) {
  bool misspelt = false;
  return source.tokens.size() > 2 &&
         std::all_of(source.tokens.begin(), source.tokens.end() - 1, [&](const Token& t) {
           return is_closer(keyword_of(t, misspelt)) && lower(t.text) != "wait";
         });
}

class Parser {
 public:
  Parser(Program& program, Problems& problems) : program_{program}, problems_{problems} {}

  void run() {
    prepare(read_source(program_.lines));
    program_.statements = block();
    while (next_ < lines_.size() && !given_up_) {  // a closer that closes nothing
      refuse_closer(lines_[next_]);
      ++next_;
      Block more = block();
      std::move(more.begin(), more.end(), std::back_inserter(program_.statements));
    }
  }

 private:
  struct Opener {
    std::string word;
    Place place;
  };

  void prepare(std::vector<SourceLine> sources) {
    for (SourceLine& source : sources) {
      if (is_row_of_closers(source)) {
        split_closers(source);
        continue;
      }
      Line line;
      line.word = keyword_of(source.tokens.front(), line.misspelt);
      line.source = std::move(source);
      if (line.misspelt && is_call(line.source)) line.misspelt = false, line.word = "call";
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
            "every closing word stands on its own line");
    } else {
      error("unexpected", source.tokens[1].place, "one statement stands on a line, here are several",
            "every closing word stands on its own line");
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
      if (ends_block(line.word)) {
        if (line.misspelt) refuse_word(line);
        line.misspelt = false;
        return out;
      }
      ++next_;
      statement(line, out);
    }
    return out;
  }

  void statement(const Line& line, Block& out) {
    Statement made;
    made.place = line.source.place;
    const bool opens = one_of(line.word, {"while", "if", "for"}) || waits_with_else(line);
    try {
      if (line.misspelt || line.word.empty()) {
        refuse_word(line);
        if (!opens) return;
      }
      TokenCursor cursor(line.source.tokens);
      cursor.take();
      parse_statement(line, cursor, made);
    } catch (const SyntaxError& e) {
      error(e);
      if (!opens && made.kind != Kind::let) return;
    }
    if (opens) parse_body(line, made);
    out.push_back(std::move(made));
  }

  /// `wait … timeout … else`, also where something in it is wrong.
  static bool waits_with_else(const Line& line) {
    const auto& tokens = line.source.tokens;
    return line.word == "wait" && tokens.size() > 4 && tokens[tokens.size() - 2].kind == TokenKind::name &&
           equal_ignoring_case(tokens[tokens.size() - 2].text, "else");
  }

  void refuse_word(const Line& line) {
    const Token& first = line.source.tokens.front();
    if (first.kind == TokenKind::bad) return error("bad-text", first.place, first.text);
    if (first.kind == TokenKind::number)
      return error("unknown-word", first.place, "a statement begins with a word, here is " + shown(first),
                   "line numbers are no part of a program");
    const Token& second = line.source.tokens[std::min<std::size_t>(1, line.source.tokens.size() - 1)];
    if (second.kind == TokenKind::symbol && second.text == "=")
      return error("unknown-word", first.place, "no statement begins with " + shown(first),
                   "to change it write `set " + first.text.substr(0, 40) + " = …`, for a new name `let`");
    error("unknown-word", first.place,
          "no statement begins with " + shown(first) + did_you_mean(first.text, statement_words()), "");
  }

  void parse_statement(const Line& line, TokenCursor& cursor, Statement& out) {
    const std::string& word = line.word;
    if (word == "load" || word == "import") return parse_load(line, cursor, out);
    if (word == "set") return parse_set(line, cursor, out);
    if (word == "let") return parse_let(cursor, out);
    if (word == "moveto") return parse_move(cursor, out);
    if (word == "wait") return parse_wait(cursor, out);
    if (word == "while" || word == "if") return parse_condition(word, cursor, out);
    if (word == "for") return parse_for(cursor, out);
    if (one_of(word, {"break", "continue", "stop"})) return parse_single(line, cursor, out);
    if (word == "log") return parse_log(cursor, out);
    if (word == "call") return parse_call(line, out);
    throw SyntaxError{"unknown-word", line.source.place,
                      "'" + word + "' is not part of this version of the language",
                      "statements are " + join(statement_words(), ", ")};
  }

  void parse_load(const Line& line, TokenCursor& cursor, Statement& out) {
    out.kind = line.word == "load" ? Kind::load : Kind::import;
    const Token& token = cursor.peek();
    out.name_place = token.place;
    if (token.kind == TokenKind::text && cursor.peek(1).kind == TokenKind::end) {
      out.name = token.text;
      return;
    }
    const std::string_view raw = trim(line.source.raw);
    out.name = trim(raw.substr(std::min(raw.size(), line.word.size())));
    if (out.name.empty())
      throw SyntaxError{"no-name", token.place, "the name of a data file was expected",
                        "write `load cycledata`"};
    if (out.name.find_first_of(" \t\n\"") != std::string::npos) {
      refuse_bad(token);
      throw SyntaxError{"bad-name", token.place, "one name of a file was expected after '" + line.word + "'",
                        "a name with blanks goes in \"quotes\""};
    }
  }

  /// The name of something that can be changed, with its dots.
  std::string target(TokenCursor& cursor, const char* statement) {
    const Token& token = cursor.peek();
    refuse_bad(token);
    if (token.kind != TokenKind::name && token.kind != TokenKind::quoted)
      throw SyntaxError{"no-name", token.place,
                        std::string("a name was expected after '") + statement + "', here is " + shown(token),
                        ""};
    if (token.kind == TokenKind::name && is_reserved(token.text))
      throw SyntaxError{"reserved", token.place, shown(token) + " is a word of the language and no name", ""};
    std::string name = cursor.take().text;
    while (cursor.is_symbol(".") &&
           (cursor.peek(1).kind == TokenKind::name || cursor.peek(1).kind == TokenKind::quoted)) {
      cursor.take();
      name += "." + cursor.take().text;
    }
    return name;
  }

  void parse_set(const Line& line, TokenCursor& cursor, Statement& out) {
    out.name_place = cursor.peek().place;
    out.name = target(cursor, "set");
    if (cursor.take_symbol("=")) {
      out.kind = Kind::set;
      out.expression = cursor.expression();
      return cursor.expect_end("the value");
    }
    if (cursor.position() > 2)
      throw SyntaxError{"no-equals", cursor.peek().place, "'=' was expected after '" + out.name + "'",
                        "write `set " + out.name + " = …`"};
    if (cursor.is_symbol("["))
      throw SyntaxError{"bad-target", cursor.peek().place, "an element of a list cannot be changed here",
                        "set the whole list"};
    out.kind = Kind::set_literal;
    out.literal = thesis_literal(line, cursor);
  }

  /// True or False, a number, or the rest of the line as text.
  Value thesis_literal(const Line& line, const TokenCursor& cursor) {
    const std::string& raw = line.source.raw;
    std::size_t at = raw.find_first_not_of(" \t", raw.find_first_of(" \t", raw.find_first_not_of(" \t")));
    if (at != std::string::npos && raw[at] == '`') {
      at = raw.find('`', at + 1) + 1;
    } else if (at != std::string::npos) {
      at += line.source.tokens[1].text.size();
    }
    const std::string_view rest =
        at < raw.size() ? trim(std::string_view(raw).substr(at)) : std::string_view{};
    if (rest.empty())
      throw SyntaxError{"no-value", cursor.peek().place,
                        "a value was expected after '" + line.source.tokens[1].text + "'",
                        "write True, False, a number, a text, or `= …`"};
    if (equal_ignoring_case(rest, "true")) return true;
    if (equal_ignoring_case(rest, "false")) return false;
    if (const auto number = parse_number(rest)) return *number;
    const bool signed_number = cursor.is_symbol("-") || cursor.is_symbol("+");
    const Token& token = cursor.peek(signed_number ? 1 : 0);
    if (token.kind == TokenKind::number && cursor.peek(signed_number ? 2 : 1).kind == TokenKind::end)
      return data::Number{cursor.is_symbol("-") ? -token.number : token.number, token.dimension};
    if (rest.size() >= 2 && rest.front() == '"' && rest.back() == '"')
      return std::string(rest.substr(1, rest.size() - 2));
    return std::string(rest);
  }

  void parse_let(TokenCursor& cursor, Statement& out) {
    out.kind = Kind::let;
    out.name_place = cursor.peek().place;
    out.name = target(cursor, "let");
    if (cursor.position() > 2)
      throw SyntaxError{"bad-target", out.name_place, "a name that `let` makes has no dots", ""};
    if (!cursor.take_symbol("=")) {
      refuse_bad(cursor.peek());
      throw SyntaxError{"no-equals", cursor.peek().place,
                        "'=' was expected after '" + out.name + "', here is " + shown(cursor.peek()),
                        "write `let " + out.name + " = …`"};
    }
    out.expression = cursor.expression();
    cursor.expect_end("the value");
  }

  void parse_move(TokenCursor& cursor, Statement& out) {
    out.kind = Kind::move;
    out.name_place = cursor.peek().place;
    if (cursor.at_end())
      throw SyntaxError{"no-value", cursor.peek().place, "a point was expected after 'moveto'",
                        "write `moveto Home`"};
    out.expression = cursor.expression();
    cursor.expect_end("the point");
  }

  static bool begins_value(const TokenCursor& cursor, std::size_t ahead) {
    const Token& token = cursor.peek(ahead);
    if (token.kind == TokenKind::end) return false;
    if (token.kind == TokenKind::name) return !one_of(lower(token.text), {"and", "or", "mod", "timeout"});
    return token.kind != TokenKind::symbol || one_of(token.text, {"(", "-", "["});
  }

  void parse_wait(TokenCursor& cursor, Statement& out) {
    out.name_place = cursor.peek().place;
    if (cursor.at_end())
      throw SyntaxError{"no-value", cursor.peek().place, "'wait' needs to know for what",
                        "write `wait NAME`, `wait 500ms`, `wait time 1` or `wait user`"};
    if (cursor.is_word("time") && begins_value(cursor, 1)) {
      cursor.take();
      out.kind = Kind::wait_time;
      out.expression = cursor.expression();
      return cursor.expect_end("the time");
    }
    if (cursor.is_word("user") || cursor.is_word("input")) {
      if (cursor.peek(1).kind == TokenKind::end) return parse_ask(cursor, out);
      if (cursor.peek(1).kind == TokenKind::text) return parse_ask(cursor, out);
    }
    if (cursor.is_word("var") && begins_value(cursor, 1)) {
      cursor.take();
      out.explicit_variable = true;
    }
    parse_wait_condition(cursor, out);
  }

  void parse_ask(TokenCursor& cursor, Statement& out) {
    out.kind = Kind::ask;
    out.name = cursor.peek().text;
    if (cursor.peek(1).kind == TokenKind::end) {
      out.second = cursor.expression();
      return;
    }
    cursor.take();
    out.expression = cursor.expression();
    cursor.expect_end("the text");
  }

  void parse_wait_condition(TokenCursor& cursor, Statement& out) {
    out.kind = Kind::wait;
    out.expression = cursor.expression();
    if (cursor.take_word("timeout")) {
      out.second = cursor.expression();
      out.has_else = cursor.take_word("else");
    }
    cursor.expect_end("the condition");
  }

  void parse_condition(const std::string& word, TokenCursor& cursor, Statement& out) {
    out.kind = word == "while" ? Kind::while_loop : Kind::branch;
    if (cursor.at_end())
      throw SyntaxError{"no-value", cursor.peek().place, "a condition was expected after '" + word + "'",
                        "write `" + word + " NAME`"};
    ExpressionPtr condition = cursor.expression();
    if (out.kind == Kind::while_loop) {
      out.expression = std::move(condition);
    } else {
      out.branches.push_back({std::move(condition), out.place, {}});
    }
    cursor.expect_end("the condition");
  }

  void parse_for(TokenCursor& cursor, Statement& out) {
    out.kind = Kind::for_loop;
    out.name_place = cursor.peek().place;
    out.name = target(cursor, "for");
    if (!cursor.take_word("in"))
      throw SyntaxError{"no-in", cursor.peek().place,
                        "'in' was expected after '" + out.name + "', here is " + shown(cursor.peek()),
                        "write `for i in 1 .. 5`"};
    out.expression = cursor.expression();
    if (cursor.take_symbol("..")) out.second = cursor.expression();
    cursor.expect_end("the range");
  }

  void parse_single(const Line& line, TokenCursor& cursor, Statement& out) {
    out.kind = line.word == "stop"    ? Kind::stop
               : line.word == "break" ? Kind::break_loop
                                      : Kind::continue_loop;
    const bool in_loop = std::any_of(open_.begin(), open_.end(), [](const Opener& opener) {
      return opener.word == "while" || opener.word == "for";
    });
    if (out.kind != Kind::stop && !in_loop)
      throw SyntaxError{"no-loop", out.place, "'" + line.word + "' stands in no loop", ""};
    cursor.expect_end("'" + line.word + "'");
  }

  void parse_log(TokenCursor& cursor, Statement& out) {
    out.kind = Kind::log;
    if (cursor.is_symbol("(") && closes_at_end(cursor)) {
      const Token& open = cursor.take();
      out.arguments = cursor.list_until(")", open);
    } else {
      out.arguments.push_back(cursor.expression());
    }
    cursor.expect_end("the text");
  }

  /// Whether the bracket at the cursor is closed by the last token of the statement.
  static bool closes_at_end(const TokenCursor& cursor) {
    int depth = 0;
    for (std::size_t i = cursor.position(); i < cursor.tokens().size(); ++i) {
      const Token& token = cursor.tokens()[i];
      if (token.kind != TokenKind::symbol) continue;
      if (token.text == "(") ++depth;
      if (token.text == ")" && --depth == 0) return i + 2 == cursor.tokens().size();
    }
    return true;
  }

  void parse_call(const Line& line, Statement& out) {
    out.kind = Kind::call;
    TokenCursor cursor(line.source.tokens);
    out.expression = cursor.expression();
    cursor.expect_end("the call");
    if (out.expression->kind != Expression::Kind::call)
      throw SyntaxError{"unexpected", line.source.place, "a value alone is no statement",
                        "write `log(…)` or `set … = …`"};
  }

  /// The block that `line` opens, with its branches, up to and with its closing word.
  void parse_body(const Line& line, Statement& out) {
    if (static_cast<int>(open_.size()) >= kDeepestBlocks) {
      error("too-deep", out.place, "blocks are nested deeper than " + std::to_string(kDeepestBlocks),
            "the rest of the file was not read");
      given_up_ = true;
      return;
    }
    open_.push_back({line.word, out.place});
    if (line.word == "if" && out.branches.empty()) out.branches.push_back({nullptr, out.place, {}});
    Block* target = line.word == "if" ? &out.branches.back().body : &out.body;
    bool had_else = false;
    do {
      Block more = block();
      std::move(more.begin(), more.end(), std::back_inserter(*target));
    } while (!given_up_ && !close_block(out, target, had_else));
    open_.pop_back();
  }

  /// Looks at the line that ended a block. True when the block of `out` is closed.
  bool close_block(Statement& out, Block*& target, bool& had_else) {
    const Opener& opener = open_.back();
    if (next_ >= lines_.size()) {
      error("unclosed", opener.place, "this '" + opener.word + "' is never closed",
            "add `end" + opener.word + "`");
      return true;
    }
    const Line& line = lines_[next_];
    if (!is_closer(line.word)) {
      ++next_;
      next_branch(line, out, target, had_else);
      return false;
    }
    if (line.word == "end" || line.word == "end" + opener.word) {
      ++next_;
      closed_line_ends(line);
      return true;
    }
    return mismatch(line);
  }

  void closed_line_ends(const Line& line) {
    const Token& second = line.source.tokens[1];
    if (second.kind == TokenKind::end) return;
    const bool two_words = line.word == "end" && second.kind == TokenKind::name;
    error(
        "unexpected", second.place, shown(second) + " is not expected here, after '" + line.word + "'",
        two_words ? "a closing word is written in one, such as endwhile" : "one statement stands on a line");
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
      return error("stray-else", line.source.place,
                   had_else ? of + " has its 'else' already" : "'" + line.word + "' does not belong to " + of,
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
    const bool closes = is_closer(line.word);
    error("stray-end", line.source.place,
          closes ? "'" + line.word + "' closes nothing" : "'" + line.word + "' belongs to no 'if'", "");
  }

  Program& program_;
  Problems& problems_;
  std::vector<Line> lines_;
  std::size_t next_ = 0, count_ = 0;
  std::vector<Opener> open_;
  bool given_up_ = false;
};
}  // namespace

const std::vector<std::string>& statement_words() {
  static const std::vector<std::string> words = {
      "load", "import", "set", "let",    "moveto", "wait",     "while", "endwhile", "if",  "elif",
      "else", "endif",  "for", "endfor", "break",  "continue", "stop",  "log",      "end", "endwait"};
  return words;
}

Program parse(std::string_view text, const std::string& file, Problems& problems) {
  Program program;
  program.file = file;
  if (const auto why = data::why_not_text(text)) {
    problems.error("not-text", {file}, *why);
    return program;
  }
  program.lines = split_lines(text);
  Problems found;
  Parser(program, found).run();
  std::vector<Problem> list = found.list();
  std::stable_sort(list.begin(), list.end(),
                   [](const Problem& a, const Problem& b) { return a.where.line < b.where.line; });
  for (Problem& problem : list) problems.add(std::move(problem));
  return program;
}

Program load_program(const std::string& path) {
  Problems problems;
  Program program = parse(read_file(path), path, problems);
  problems.throw_if_errors();
  return program;
}

}  // namespace polyarm::program
