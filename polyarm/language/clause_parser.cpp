#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

#include "polyarm/base/text.hpp"
#include "polyarm/language/statement_parser.hpp"

namespace polyarm::program {

namespace {
using Kind = Statement::Kind;

constexpr std::array kClauses = {Clause::Kind::robot,    Clause::Kind::tool,  Clause::Kind::frame,
                                 Clause::Kind::payload,  Clause::Kind::near,  Clause::Kind::around,
                                 Clause::Kind::speed,    Clause::Kind::accel, Clause::Kind::blend,
                                 Clause::Kind::duration, Clause::Kind::exact, Clause::Kind::smooth,
                                 Clause::Kind::touch,
                                 Clause::Kind::until,    Clause::Kind::at};

std::optional<Clause::Kind> clause_at(const TokenCursor& cursor, std::size_t ahead) {
  for (const Clause::Kind kind : kClauses)
    if (cursor.is_word(spelling(kind), ahead)) return kind;
  return std::nullopt;
}

std::vector<std::string> clause_words() {
  std::vector<std::string> out;
  for (const Clause::Kind kind : kClauses) out.emplace_back(spelling(kind));
  return out;
}

/// What to write instead of a clause of URScript (v=0.25), RAPID (v200, z50, fine), KRL (C_DIS) or TP
/// (CNT50).
std::string clause_instead_of(const std::string& word, bool assigned) {
  const bool numbered = word.size() > 1 && std::all_of(word.begin() + 1, word.end(),
                                                       [](unsigned char c) { return std::isdigit(c) != 0; });
  const std::string number = numbered ? word.substr(1) : std::string{};
  if (word == "fine") return "write `exact`, or no blend";
  if (word == "c_dis" || word == "c_vel" || word == "c_ori" || word.starts_with("cnt"))
    return "write a length: `blend 20mm`";
  if (numbered && word[0] == 'v') return "write `speed " + number + "mm/s`";
  if (numbered && word[0] == 'z') return "write `blend " + number + "mm`";
  if (!assigned) return {};
  if (word == "v") return "write such as `speed 250mm/s`";
  if (word == "a") return "write such as `accel 1m/s2`";
  if (word == "r") return "write such as `blend 20mm`";
  if (word == "t") return "write such as `duration 2s`";
  return {};
}

[[noreturn]] void refuse_clause(const TokenCursor& cursor, bool after_comma) {
  const Token& token = cursor.peek();
  refuse_bad(token);
  refuse_lone_unit(cursor);
  const std::vector<std::string> words = clause_words();
  const bool word = token.kind == TokenKind::name;
  std::string advice = "clauses are " + join(words, ", ");
  const std::string instead = word ? clause_instead_of(lower(token.text), cursor.is_symbol("=", 1)) : "";
  if (!instead.empty())
    throw SyntaxError{after_comma ? "no-clause" : "unexpected", token.place,
                      shown(token) + " is not a clause", instead};
  if (after_comma && cursor.is_word("else"))
    advice = "write `else` without a comma before it";
  else if (after_comma && token.kind != TokenKind::end && (!word || !nearest_name(token.text, words)))
    advice = "a path through several points is a list: [A, B]";
  throw SyntaxError{after_comma ? "no-clause" : "unexpected", token.place,
                    (after_comma ? "a clause was expected after ',', here is " + shown(token)
                                 : shown(token) + " is not expected here, after the point") +
                        (word ? did_you_mean(token.text, words) : ""),
                    advice};
}

/// at (start|end) [(+|-) EXPR] set NAME = EXPR
void parse_at(TokenCursor& cursor, Clause& out) {
  out.from_end = cursor.is_word("end");
  if (!out.from_end && !cursor.is_word("start"))
    throw SyntaxError{"no-place", cursor.peek().place,
                      "'start' or 'end' was expected after 'at', here is " + shown(cursor.peek()),
                      "write `at end - 20mm set NAME = VALUE`"};
  cursor.take();
  if (cursor.is_symbol("+") || cursor.is_symbol("-")) {
    const Token& sign = cursor.take();
    if ((sign.text == "-") != out.from_end)
      throw SyntaxError{"bad-place", sign.place,
                        out.from_end ? "write what is set after the end on the next line"
                                     : "nothing can be set before the start of a move",
                        "write `at end - 20mm` or `at start + 20mm`"};
    out.value = cursor.expression();
  }
  if (!cursor.take_word("set"))
    throw SyntaxError{"no-set", cursor.peek().place, "'set' was expected here, is " + shown(cursor.peek()),
                      "write `at end - 20mm set NAME = VALUE`"};
  out.target = parse_target(cursor, "set");
  if (!cursor.take_symbol("="))
    throw SyntaxError{"no-equals", cursor.peek().place, "'=' was expected after '" + out.target + "'",
                      "write `set " + out.target + " = …`"};
  out.to = cursor.expression();
}

void parse_clause(TokenCursor& cursor, Statement& out) {
  Clause clause;
  clause.kind = *clause_at(cursor, 0);
  clause.place = cursor.take().place;
  const bool twice = std::any_of(out.clauses.begin(), out.clauses.end(),
                                 [&](const Clause& c) { return c.kind == clause.kind; });
  if (twice && clause.kind != Clause::Kind::at)
    throw SyntaxError{"twice", clause.place,
                      std::string("'") + spelling(clause.kind) + "' is said twice here", ""};
  const bool moves_only = clause.kind == Clause::Kind::until || clause.kind == Clause::Kind::at ||
                          clause.kind == Clause::Kind::touch || clause.kind == Clause::Kind::duration;
  if (moves_only && out.kind == Kind::use)
    throw SyntaxError{"bad-clause", clause.place,
                      std::string("'") + spelling(clause.kind) + "' belongs to one move", ""};
  const bool of_joints = out.kind == Kind::move &&
                         (out.motion == Statement::Motion::moveto || out.motion == Statement::Motion::movej);
  if (clause.kind == Clause::Kind::near && !of_joints)
    throw SyntaxError{"bad-clause", clause.place,
                      "'near' belongs to a movej: a line and an arc keep the configuration they begin in",
                      "write `movej P, near NAME` before it"};
  if (clause.kind == Clause::Kind::smooth &&
      (out.kind != Kind::move || out.motion != Statement::Motion::movel))
    throw SyntaxError{"bad-clause", clause.place, "'smooth' belongs to a movel through several points",
                      "write `movel [A, B, C], smooth`"};
  using Kinds = Clause::Kind;
  const bool of_base = clause.kind == Kinds::speed || clause.kind == Kinds::accel ||
                       clause.kind == Kinds::robot || clause.kind == Kinds::duration ||
                       clause.kind == Kinds::frame;
  const bool at_speed = out.moves_at_speed();
  const bool of_speed = clause.kind == Kinds::duration || clause.kind == Kinds::accel ||
                        clause.kind == Kinds::robot || clause.kind == Kinds::tool ||
                        clause.kind == Kinds::frame || clause.kind == Kinds::payload ||
                        clause.kind == Kinds::touch || clause.kind == Kinds::until || clause.kind == Kinds::at;
  if (at_speed && !of_speed)
    throw SyntaxError{"bad-clause", clause.place,
                      std::string("'") + spelling(clause.kind) + "' belongs to a move to a point",
                      out.name + " takes duration, accel, touch, until, at, robot, tool, frame and payload"};
  if (out.moves_base() && !of_base)
    throw SyntaxError{"bad-clause", clause.place,
                      std::string("'") + spelling(clause.kind) + "' belongs to a move of an arm",
                      "drive and turn take speed, accel, duration and robot, a drive to a pose also frame"};
  if (clause.kind == Clause::Kind::at) {
    parse_at(cursor, clause);
  } else if (has_value(clause.kind)) {
    clause.value = cursor.expression();
  }
  if (clause.kind == Clause::Kind::until) clause.has_else = cursor.take_word("else");
  out.clauses.push_back(std::move(clause));
}

/// Clauses up to the end of the statement, with or without commas.
void parse_clauses(TokenCursor& cursor, Statement& out) {
  while (!cursor.at_end()) {
    const bool comma = !out.clauses.empty() || out.kind == Kind::move ? cursor.take_symbol(",") : false;
    if (cursor.is_word("until") && cursor.is_word("else", 1)) refuse_clause(cursor, comma);
    if (!clause_at(cursor, 0)) refuse_clause(cursor, comma);
    parse_clause(cursor, out);
    if (!out.clauses.empty() && out.clauses.back().has_else) return cursor.expect_end("'else'");
  }
}

}  // namespace

namespace {
/// How a statement that takes a name is written.
std::string name_advice(std::string_view statement) {
  if (statement == "(") return "the parameters of a function are names: `func NAME(A, B = 1)`";
  if (statement == "for") return "write `for i in 1 .. 5`, or `for x in LIST`";
  if (statement == "set" || statement == "let") return "write `" + std::string(statement) + " NAME = VALUE`";
  return "write `" + std::string(statement) + " NAME`";
}
}  // namespace

std::string parse_target(TokenCursor& cursor, const char* statement) {
  const Token& token = cursor.peek();
  refuse_bad(token);
  if (token.kind != TokenKind::name && token.kind != TokenKind::quoted)
    throw SyntaxError{"no-name", token.place,
                      std::string("a name was expected after '") + statement + "', here is " + shown(token),
                      name_advice(statement)};
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

void parse_move(const Line& line, TokenCursor& cursor, Statement& out) {
  using Motion = Statement::Motion;
  out.kind = Kind::move;
  out.motion = motion_of(line.word).value_or(Motion::moveto);
  const bool at_speed = out.moves_at_speed();
  out.name_place = cursor.peek().place;
  if (cursor.at_end() && out.moves_base())
    throw SyntaxError{"no-value", cursor.peek().place, "how far was expected after '" + line.word + "'",
                      out.motion == Motion::turn
                          ? "write `turn 90deg`, to the left"
                          : "write `drive 500mm`, or `drive pose(2m, 1m, rz = 90deg)`"};
  if (cursor.at_end() && at_speed)
    throw SyntaxError{"no-value", cursor.peek().place, "velocities were expected after '" + line.word + "'",
                      speed_move_advice(out.motion)};
  if (cursor.at_end())
    throw SyntaxError{
        "no-value", cursor.peek().place, "a point was expected after '" + line.word + "'",
        out.motion == Motion::movec ? "write `movec OnTheWay, End`" : "write `" + line.word + " Home`"};
  out.arguments.push_back(cursor.expression());
  if (out.motion == Motion::movec) {
    if (!cursor.take_symbol(","))
      throw SyntaxError{"no-value", cursor.peek().place,
                        "',' and the end of the arc were expected after the point on the way, here is " +
                            shown(cursor.peek()),
                        "write `movec OnTheWay, End`"};
    out.arguments.push_back(cursor.expression());
  }
  parse_clauses(cursor, out);
  const bool lasts = std::any_of(out.clauses.begin(), out.clauses.end(),
                                 [](const Clause& c) { return c.kind == Clause::Kind::duration; });
  if (at_speed && !lasts)
    throw SyntaxError{"no-duration", out.name_place, "'" + line.word + "' needs to know for how long at most",
                      speed_move_advice(out.motion)};
}

std::string speed_move_advice(Statement::Motion motion) {
  return motion == Statement::Motion::speedj ? "write `speedj {JOINT = 10deg/s}, duration 2s`"
                                             : "write `speedl {z = -20mm/s}, duration 2s`";
}

void parse_use(TokenCursor& cursor, Statement& out) {
  out.kind = Kind::use;
  if (cursor.at_end())
    throw SyntaxError{"no-clause", cursor.peek().place, "'use' needs to know what",
                      "write `use tool NAME, speed 50%`"};
  parse_clauses(cursor, out);
}

}  // namespace polyarm::program
