#include "polyarm/language/statement_parser.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/language/words.hpp"

namespace polyarm::program {

namespace {
using Kind = Statement::Kind;

bool among(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
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

/// Indices and fields after a name: [1], [i].x
std::vector<PathPart> path(TokenCursor& cursor) {
  std::vector<PathPart> out;
  while (cursor.is_symbol("[") || cursor.is_field()) {
    const Token& open = cursor.take();
    if (open.text == ".") {
      out.push_back({open.place, cursor.take().text, nullptr});
      continue;
    }
    out.push_back({open.place, {}, cursor.expression()});
    if (!cursor.take_symbol("]"))
      throw SyntaxError{"unclosed", open.place, "this '[' is not closed before " + shown(cursor.peek()),
                        "add ']'"};
  }
  return out;
}

Value thesis_literal(const Line& line, const TokenCursor& cursor);

void parse_set(const Line& line, TokenCursor& cursor, Statement& out) {
  out.name_place = cursor.peek().place;
  out.name = parse_target(cursor, "set");
  out.path = path(cursor);
  if (cursor.take_symbol("=")) {
    out.kind = Kind::set;
    out.expression = cursor.expression();
    return cursor.expect_end("the value");
  }
  if (cursor.position() > 2)
    throw SyntaxError{"no-equals", cursor.peek().place, "'=' was expected after '" + out.name + "'",
                      "write `set " + out.name + " = …`"};
  const Token &operation = cursor.peek(), &then = cursor.peek(1);
  const bool calculates = operation.kind == TokenKind::symbol && then.kind == TokenKind::symbol &&
                          among(operation.text, {"+", "-", "*", "/"}) &&
                          (then.text == "=" || then.text == operation.text);
  if (calculates)  // such as += and ++
    throw SyntaxError{"no-equals", operation.place,
                      "'" + operation.text + then.text + "' is not written here",
                      "write `set " + out.name + " = " + out.name + " " + operation.text + " …`"};
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
  const std::string_view rest = at < raw.size() ? trim(std::string_view(raw).substr(at)) : std::string_view{};
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
  out.name = parse_target(cursor, "let");
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

bool begins_value(const TokenCursor& cursor, std::size_t ahead) {
  const Token& token = cursor.peek(ahead);
  if (token.kind == TokenKind::end) return false;
  if (token.kind == TokenKind::name) return !among(lower(token.text), {"and", "or", "mod", "timeout"});
  return token.kind != TokenKind::symbol || among(token.text, {"(", "-", "["});
}

void parse_ask(TokenCursor& cursor, Statement& out);
void parse_wait_condition(TokenCursor& cursor, Statement& out);

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
    if (cursor.peek(1).kind == TokenKind::name && begins_value(cursor, 1))
      throw SyntaxError{"unexpected", cursor.peek(1).place,
                        "a text was expected after '" + cursor.peek().text + "', here is " +
                            shown(cursor.peek(1)),
                        "write the question in quotes: `wait user \"TEXT\"`"};
  }
  if (cursor.is_word("var") && begins_value(cursor, 1)) {
    cursor.take();
    out.explicit_variable = true;
  }
  if ((cursor.is_word("sec") || cursor.is_word("for")) && begins_value(cursor, 1))
    throw SyntaxError{"unknown-word", cursor.peek().place, shown(cursor.peek()) + " is not written here",
                      "write `wait 500ms`, or `wait NAME` for a condition"};
  // A value after a name can only belong to one of these words.
  const std::vector<std::string> words = {"time", "var"};
  if (cursor.peek().kind == TokenKind::name && !out.explicit_variable &&
      (cursor.peek(1).kind == TokenKind::number || cursor.peek(1).kind == TokenKind::name) &&
      begins_value(cursor, 1))
    if (const auto near = nearest_name(cursor.peek().text, words))
      throw SyntaxError{"unknown-word", cursor.peek().place,
                        "'wait' knows no '" + cursor.peek().text + "'; did you mean '" + *near + "'?",
                        "write `wait time 1`, `wait 500ms`, `wait NAME` or `wait user`"};
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

void parse_timeout(TokenCursor& cursor, Statement& out) {
  if (cursor.is_symbol(",") && cursor.is_word("timeout", 1)) cursor.take();
  if (!cursor.take_word("timeout")) return;
  out.second = cursor.expression();
  out.has_else = cursor.take_word("else");
}

void parse_wait_condition(TokenCursor& cursor, Statement& out) {
  out.kind = Kind::wait;
  out.expression = cursor.expression();
  parse_timeout(cursor, out);
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
  out.name = parse_target(cursor, "for");
  if (cursor.take_symbol(",")) {
    out.second_name = std::exchange(out.name, {});
    out.name_place = cursor.peek().place;
    out.name = parse_target(cursor, "for");
  }
  if (!cursor.take_word("in"))
    throw SyntaxError{"no-in", cursor.peek().place,
                      "'in' was expected after '" + out.name + "', here is " + shown(cursor.peek()),
                      "write `for i in 1 .. 5`"};
  out.expression = cursor.expression();
  if (cursor.take_symbol("..")) out.second = cursor.expression();
  cursor.expect_end("the range");
}

void parse_single(const Line& line, TokenCursor& cursor, Statement& out, const Openers& open) {
  out.kind = line.word == "stop" ? Kind::stop : line.word == "break" ? Kind::break_loop : Kind::continue_loop;
  const auto around = std::find_if(open.rbegin(), open.rend(), [](const Opener& opener) {
    return among(opener.word, {"while", "for", "together", "func", "task"});
  });
  const bool in_loop = around != open.rend() && among(around->word, {"while", "for"});
  if (out.kind != Kind::stop && !in_loop)
    throw SyntaxError{"no-loop", out.place, "'" + line.word + "' is not in a loop", ""};
  cursor.expect_end("'" + line.word + "'");
}

bool closes_at_end(const TokenCursor& cursor);

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

/// True if the last token of the statement closes the bracket at the cursor.
bool closes_at_end(const TokenCursor& cursor) {
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
  if (!cursor.at_end() && out.expression->kind == Expression::Kind::call)
    if (const Word* const word = statement_named(out.expression->name))
      throw SyntaxError{"unexpected", line.source.place,
                        "'" + out.expression->name + "' is a statement, not a function",
                        "write `" + std::string(word->form) + "`"};
  cursor.expect_end("the call");
  if (out.expression->kind != Expression::Kind::call)
    throw SyntaxError{"unexpected", line.source.place, "a value alone is not a statement",
                      "write `log(…)` or `set … = …`"};
}

/// One plain name, for statements that create a name.
void parse_name(const Line& line, TokenCursor& cursor, Statement& out) {
  out.name_place = cursor.peek().place;
  out.name = parse_target(cursor, line.word.c_str());
  if (out.name.find('.') != std::string::npos && cursor.position() > 2)
    throw SyntaxError{"bad-name", out.name_place, "this name has no dots", ""};
}

void parse_parameter(TokenCursor& cursor, Statement& out) {
  Parameter parameter;
  parameter.place = cursor.peek().place;
  parameter.name = parse_target(cursor, "(");
  const auto same = [&](const Parameter& p) { return p.name == parameter.name; };
  if (std::any_of(out.parameters.begin(), out.parameters.end(), same))
    throw SyntaxError{"twice", parameter.place, "there are two parameters '" + parameter.name + "'", ""};
  if (cursor.take_symbol("=")) {
    parameter.value = cursor.expression();
  } else if (!out.parameters.empty() && out.parameters.back().value) {
    throw SyntaxError{"no-default", parameter.place,
                      "'" + parameter.name + "' needs a value, as the parameter before it has one",
                      "write `" + parameter.name + " = …`, or move it before"};
  }
  out.parameters.push_back(std::move(parameter));
}

void parse_function(const Line& line, TokenCursor& cursor, Statement& out) {
  out.kind = Kind::function;
  parse_name(line, cursor, out);
  if (!cursor.take_symbol("("))
    throw SyntaxError{"no-brackets", cursor.peek().place,
                      "'(' was expected after '" + out.name + "', here is " + shown(cursor.peek()),
                      "write `func " + out.name + "()`"};
  while (!cursor.take_symbol(")")) {
    parse_parameter(cursor, out);
    if (cursor.take_symbol(",") || cursor.is_symbol(")")) continue;
    refuse_bad(cursor.peek());
    throw SyntaxError{"unclosed", cursor.peek().place,
                      "',' or ')' was expected here, is " + shown(cursor.peek()), "add ')'"};
  }
  cursor.expect_end("the parameters");
  // At the end: what uses the function and its parameters is not wrong.
  const std::string lowered = lower(out.name);
  const auto& words = statement_words();
  if (std::find(words.begin(), words.end(), lowered) != words.end())
    throw SyntaxError{"bad-name", out.name_place,
                      "a function cannot be called '" + out.name + "': a statement begins with that word",
                      ""};
}

/// True if one of the enclosing blocks, up to a `together`, satisfies `fits`.
template <typename Fits>
bool stands_in(const Openers& open, Fits fits) {
  for (auto opener = open.rbegin(); opener != open.rend(); ++opener) {
    if (fits(*opener)) return true;
    if (opener->word == "together") return false;
  }
  return false;
}

void parse_return(TokenCursor& cursor, Statement& out, const Openers& open) {
  out.kind = Kind::return_value;
  if (!stands_in(open, [](const Opener& o) { return o.word == "func"; }))
    throw SyntaxError{"no-function", out.place, "'return' is not in a function",
                      "write `stop` to end; the statements of a 'together' are tasks of their own"};
  if (!cursor.at_end()) out.expression = cursor.expression();
  cursor.expect_end("the value");
}

bool in_handler(const Openers& open) {
  return stands_in(open, [](const Opener& o) { return o.handles; });
}

void parse_raise(const Line& line, TokenCursor& cursor, Statement& out, const Openers& open) {
  out.kind = line.word == "raise" ? Kind::raise : Kind::retry;
  if (!in_handler(open) && (out.kind == Kind::retry || cursor.at_end()))
    throw SyntaxError{"no-handler", out.place, "'" + line.word + "' is not in an 'on error'",
                      out.kind == Kind::raise ? "write `raise \"what is wrong\"`" : ""};
  if (!cursor.at_end()) out.expression = cursor.expression();
  cursor.expect_end("'" + line.word + "'");
}

void parse_meeting(const Line& line, TokenCursor& cursor, Statement& out) {
  out.kind = line.word == "meet" ? Kind::meet : Kind::lock;
  parse_name(line, cursor, out);
  parse_timeout(cursor, out);
  if (out.kind == Kind::lock && out.has_else)
    throw SyntaxError{"bad-else", out.place, "a lock has no else", "catch its time-out with `try`"};
  cursor.expect_end("the name");
}

void parse_on(TokenCursor& cursor, Statement& out) {
  out.kind = Kind::on_stop;
  if (!cursor.take_word("stop"))
    throw SyntaxError{"unexpected", cursor.peek().place,
                      "'stop' or 'error' was expected after 'on', here is " + shown(cursor.peek()),
                      "write `on stop`"};
  cursor.expect_end("'stop'");
}

void parse_opener(const Line& line, TokenCursor& cursor, Statement& out) {
  if (line.word == "task") {
    out.kind = Kind::task;
    parse_name(line, cursor, out);
  } else if (line.word == "when") {
    out.kind = Kind::when;
    out.expression = cursor.expression();
  } else {
    out.kind = line.word == "try" ? Kind::try_block : Kind::together;
  }
  cursor.expect_end("'" + line.word + "'");
}

/// trap [when] EXPR, every EXPR
void parse_event(const Line& line, TokenCursor& cursor, Statement& out) {
  const bool traps = line.word == "trap";
  out.kind = traps ? Kind::trap : Kind::every;
  if (traps) cursor.take_word("when");
  if (cursor.at_end())
    throw SyntaxError{"no-value", cursor.peek().place,
                      traps ? "'trap' needs to know when" : "'every' needs to know how often",
                      traps ? "write `trap when CONDITION`" : "write `every 500ms`"};
  out.expression = cursor.expression();
  cursor.expect_end("'" + line.word + "'");
}

/// pulse NAME for EXPR
void parse_pulse(TokenCursor& cursor, Statement& out) {
  out.kind = Kind::pulse;
  out.name_place = cursor.peek().place;
  out.name = parse_target(cursor, "pulse");
  if (!cursor.take_word("for"))
    throw SyntaxError{"no-for", cursor.peek().place, "'for' was expected here, is " + shown(cursor.peek()),
                      "write `pulse " + out.name + " for 200ms`"};
  out.expression = cursor.expression();
  cursor.expect_end("the time");
}

void parse_hold(TokenCursor& cursor, Statement& out) {
  out.kind = Kind::hold;
  if (!cursor.at_end()) out.expression = cursor.expression();
  cursor.expect_end("the reason");
}

/// The quoted text of `include` and `test`.
void parse_quoted(TokenCursor& cursor, Statement& out, const char* what, const char* example) {
  const Token& token = cursor.peek();
  out.name_place = token.place;
  if (token.kind != TokenKind::text)
    throw SyntaxError{"no-name", token.place,
                      std::string(what) + " in quotes was expected, here is " + shown(token),
                      std::string("write `") + example + "`"};
  out.name = cursor.take().text;
  cursor.expect_end("the text");
}

void parse_include(TokenCursor& cursor, Statement& out) {
  out.kind = Kind::include;
  parse_quoted(cursor, out, "the name of a file", "include \"tools.script\"");
}

void parse_test(TokenCursor& cursor, Statement& out) {
  out.kind = Kind::test;
  parse_quoted(cursor, out, "the name of the test", "test \"sorts blue parts\"");
}

bool stands_in_test(const Openers& open) {
  return std::any_of(open.begin(), open.end(),
                     [](const Opener& o) { return o.word == "test" || o.word == "func"; });
}

/// run ["PROGRAM"], expect EXPR [timeout EXPR]
void parse_of_test(const Line& line, TokenCursor& cursor, Statement& out, const Openers& open) {
  out.kind = line.word == "run" ? Kind::run : Kind::expect;
  if (!stands_in_test(open))
    throw SyntaxError{"no-test", out.place, "'" + line.word + "' is not in a test",
                      "tests have files of their own: test \"…\", its lines, end"};
  if (out.kind == Kind::run) {
    out.name_place = cursor.peek().place;
    if (cursor.peek().kind == TokenKind::text) out.name = cursor.take().text;
    return cursor.expect_end("the program");
  }
  if (cursor.at_end())
    throw SyntaxError{"no-value", cursor.peek().place, "'expect' needs to know what",
                      "write `expect Placed == 3` or `expect Done timeout 5s`"};
  out.expression = cursor.expression();
  parse_timeout(cursor, out);
  if (out.has_else)
    throw SyntaxError{"bad-else", out.place, "an 'expect' has no else", "write `wait … timeout … else`"};
  cursor.expect_end("the condition");
}

void require_top(const Line& line, const Openers& open) {
  const bool top = among(line.word, {"func", "task", "when", "every", "trap", "on", "include", "test"});
  const bool in_task = line.word == "trap" && open.size() == 1 && open.front().word == "task";
  if (top && !open.empty() && !in_task)
    throw SyntaxError{"nested", line.source.place,
                      "'" + line.word + "' is inside the '" + open.back().word + "' of line " +
                          std::to_string(open.back().place.line),
                      "it belongs outside of every block"};
}
}  // namespace

void parse_statement(const Line& line, TokenCursor& cursor, Statement& out, const Openers& open) {
  const std::string& word = line.word;
  require_top(line, open);
  if (word == "load" || word == "import") return parse_load(line, cursor, out);
  if (word == "set") return parse_set(line, cursor, out);
  if (word == "let") return parse_let(cursor, out);
  if (motion_of(word)) return parse_move(line, cursor, out);
  if (word == "use") return parse_use(cursor, out);
  if (word == "wait") return parse_wait(cursor, out);
  if (word == "while" || word == "if") return parse_condition(word, cursor, out);
  if (word == "for") return parse_for(cursor, out);
  if (among(word, {"break", "continue", "stop"})) return parse_single(line, cursor, out, open);
  if (word == "hold") return parse_hold(cursor, out);
  if (word == "log") return parse_log(cursor, out);
  if (word == "call") return parse_call(line, out);
  if (word == "include") return parse_include(cursor, out);
  if (word == "func") return parse_function(line, cursor, out);
  if (word == "return") return parse_return(cursor, out, open);
  if (word == "raise" || word == "retry") return parse_raise(line, cursor, out, open);
  if (word == "meet" || word == "lock") return parse_meeting(line, cursor, out);
  if (word == "on") return parse_on(cursor, out);
  if (word == "test") return parse_test(cursor, out);
  if (word == "run" || word == "expect") return parse_of_test(line, cursor, out, open);
  if (word == "trap" || word == "every") return parse_event(line, cursor, out);
  if (word == "pulse") return parse_pulse(cursor, out);
  if (among(word, {"task", "when", "try", "together"})) return parse_opener(line, cursor, out);
  throw SyntaxError{"unexpected", line.source.place, "'" + word + "' begins no statement here", ""};
}

}  // namespace polyarm::program
