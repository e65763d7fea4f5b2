#include "polyarm/language/expression_parser.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/language/lexer.hpp"
#include "polyarm/language/parser.hpp"

namespace polyarm::program {

namespace {
struct BinarySpelling {
  std::string_view text;
  Operator op;
  int level;
};

// From the lowest to the highest precedence; `not` lies between `and` and the comparisons.
constexpr int kOr = 0, kAnd = 1, kNot = 2, kCompare = 3, kSum = 4, kProduct = 5, kSign = 6;
constexpr std::array kBinary = {
    BinarySpelling{"or", Operator::logical_or, kOr},
    BinarySpelling{"and", Operator::logical_and, kAnd},
    BinarySpelling{"==", Operator::equal, kCompare},
    BinarySpelling{"!=", Operator::unequal, kCompare},
    BinarySpelling{"<", Operator::less, kCompare},
    BinarySpelling{"<=", Operator::less_equal, kCompare},
    BinarySpelling{">", Operator::greater, kCompare},
    BinarySpelling{">=", Operator::greater_equal, kCompare},
    BinarySpelling{"+", Operator::add, kSum},
    BinarySpelling{"-", Operator::subtract, kSum},
    BinarySpelling{"*", Operator::multiply, kProduct},
    BinarySpelling{"/", Operator::divide, kProduct},
    BinarySpelling{"mod", Operator::modulo, kProduct},
};

/// Most tokens after a value are no operators, and each is checked at every level.
bool may_be_operator(const Token& token) {
  constexpr std::size_t kLongestSign = 2, kLongestWord = 3;
  if (token.kind == TokenKind::symbol)
    return token.text.size() <= kLongestSign &&
           std::string_view("=!<>+-*/").find(token.text.front()) != std::string_view::npos;
  return token.kind == TokenKind::name && token.text.size() <= kLongestWord;
}

const BinarySpelling* binary_at(const Token& token) {
  if (!may_be_operator(token)) return nullptr;
  for (const BinarySpelling& spelling : kBinary)
    if (equal_ignoring_case(token.text, spelling.text)) return &spelling;
  return nullptr;
}

const BinarySpelling* binary_at(const Token& token, int level) {
  const BinarySpelling* spelling = binary_at(token);
  return spelling && spelling->level == level ? spelling : nullptr;
}

ExpressionPtr node(Expression::Kind kind, Place place) {
  auto out = std::make_unique<Expression>();
  out->kind = kind;
  out->place = place;
  return out;
}

void adopt(Expression& parent, ExpressionPtr part) {
  parent.depth = std::max(parent.depth, part->depth + 1);
  if (parent.depth > kDeepestExpression)
    throw SyntaxError{"too-deep", parent.place,
                      "this expression is nested deeper than " + std::to_string(kDeepestExpression) +
                          " operators and brackets",
                      "split it with `let`"};
  parent.parts.push_back(std::move(part));
}

ExpressionPtr literal(Value value, Place place) {
  auto out = node(Expression::Kind::literal, place);
  out->value = std::move(value);
  return out;
}

char unescaped(char c, Place place) {
  if (c == 'n') return '\n';
  if (c == 't') return '\t';
  if (c == '"' || c == '\\' || c == '{' || c == '}') return c;
  throw SyntaxError{"bad-escape", place, std::string("'\\") + c + "' is not an escape in a text",
                    "there are \\\" \\\\ \\n \\t \\{ \\}"};
}

/// Counts nested brackets and signs, to bound the parser's recursion.
class Nesting {
 public:
  Nesting(int& depth, Place place) : depth_{depth} {
    if (++depth_ > kDeepestExpression) {
      --depth_;
      throw SyntaxError{
          "too-deep", place,
          "this expression is nested deeper than " + std::to_string(kDeepestExpression) + " brackets",
          "split it with `let`"};
    }
  }
  Nesting(const Nesting&) = delete;
  ~Nesting() { --depth_; }

 private:
  int& depth_;
};
}  // namespace

std::string shown(const Token& token) {
  if (token.kind == TokenKind::end) return "the end of the line";
  constexpr std::size_t kMost = 40;
  const std::string text = token.kind == TokenKind::text ? '"' + token.text + '"' : token.text;
  return "'" + text.substr(0, kMost) + (text.size() > kMost ? "…'" : "'");
}

void refuse_bad(const Token& token) {
  if (token.kind == TokenKind::bad) throw SyntaxError{"bad-text", token.place, token.text, ""};
}

bool is_reserved(std::string_view word) {
  static constexpr std::array<std::string_view, 6> kReserved = {"and", "or", "not", "mod", "true", "false"};
  return std::any_of(kReserved.begin(), kReserved.end(),
                     [&](std::string_view reserved) { return equal_ignoring_case(word, reserved); });
}

bool TokenCursor::is_symbol(std::string_view symbol, std::size_t ahead) const {
  const Token& token = peek(ahead);
  return token.kind == TokenKind::symbol && token.text.front() == symbol.front() && token.text == symbol;
}

bool TokenCursor::is_word(std::string_view word, std::size_t ahead) const {
  const Token& token = peek(ahead);
  return token.kind == TokenKind::name && token.text.size() == word.size() &&
         equal_ignoring_case(token.text, word);
}

bool TokenCursor::take_symbol(std::string_view symbol) {
  if (!is_symbol(symbol)) return false;
  take();
  return true;
}

bool TokenCursor::take_word(std::string_view word) {
  if (!is_word(word)) return false;
  take();
  return true;
}

void refuse_lone_unit(const TokenCursor& cursor) {
  const Token& unit = cursor.peek();
  if (cursor.position() == 0 || unit.kind != TokenKind::name || !find_unit(unit.text)) return;
  const Token& number = cursor.tokens()[cursor.position() - 1];
  if (number.kind == TokenKind::number && number.dimension == Dimension::none)
    throw SyntaxError{"unexpected", unit.place, "a blank separates the unit '" + unit.text + "' from its number",
                      "write the unit right behind it, such as 5mm"};
}

void TokenCursor::expect_end(const std::string& statement) const {
  if (at_end()) return;
  refuse_bad(peek());
  if (is_symbol("="))
    throw SyntaxError{"unexpected", peek().place, "'=' compares nothing here", "write == to compare"};
  if (is_word("then") || is_word("do"))
    throw SyntaxError{"unexpected", peek().place, "'" + peek().text + "' is not written here",
                      "the block begins on the next line"};
  if (is_symbol("{"))
    throw SyntaxError{"unexpected", peek().place, "'{' is not expected here, after " + statement,
                      "a block begins on the next line and ends with `end`"};
  refuse_lone_unit(*this);
  throw SyntaxError{"unexpected", peek().place, shown(peek()) + " is not expected here, after " + statement,
                    "write one statement per line; put a name with blanks in `back-quotes`"};
}

ExpressionPtr TokenCursor::expression() {
  const bool before = std::exchange(in_with_, false);
  ExpressionPtr out = binary(kOr);
  in_with_ = before;
  return out;
}

ExpressionPtr TokenCursor::binary(int level) {
  if (level == kNot) return unary(level);
  if (level == kSign) return unary(level);
  ExpressionPtr left = binary(level + 1);
  bool compared = false;
  while (const BinarySpelling* spelling = binary_at(peek(), level)) {
    const Token& sign = take();
    if (level == kCompare && compared)
      throw SyntaxError{"chained", sign.place, "comparisons cannot be chained",
                        "join two of them with `and`"};
    compared = true;
    auto out = node(Expression::Kind::binary, sign.place);
    out->op = spelling->op;
    adopt(*out, std::move(left));
    adopt(*out, binary(level + 1));
    left = std::move(out);
  }
  return left;
}

ExpressionPtr TokenCursor::unary(int level) {
  const bool found = level == kNot ? is_word("not") : is_symbol("-");
  if (!found) return level == kNot ? binary(kCompare) : power();
  const Token& sign = take();
  const Nesting nested(nesting_, sign.place);
  auto out = node(Expression::Kind::unary, sign.place);
  out->op = level == kNot ? Operator::logical_not : Operator::negate;
  adopt(*out, unary(level));
  return out;
}

ExpressionPtr TokenCursor::power() {
  ExpressionPtr base = postfix();
  if (!is_symbol("^")) return base;
  const Token& sign = take();
  const Nesting nested(nesting_, sign.place);
  auto out = node(Expression::Kind::binary, sign.place);
  out->op = Operator::power;
  adopt(*out, std::move(base));
  adopt(*out, is_symbol("-") ? unary(kSign) : power());
  return out;
}

ExpressionPtr TokenCursor::postfix() {
  ExpressionPtr out = primary();
  while (is_symbol("[") || is_field()) {
    if (is_symbol(".")) {
      auto field = node(Expression::Kind::field, take().place);
      field->name = take().text;
      adopt(*field, std::move(out));
      out = std::move(field);
      continue;
    }
    const Token& open = take();
    const Nesting nested(nesting_, open.place);
    auto index = node(Expression::Kind::index, open.place);
    adopt(*index, std::move(out));
    adopt(*index, expression());
    if (is_symbol(","))
      throw SyntaxError{"unexpected", peek().place, "',' is not expected here: an index is one number",
                        "a pose is written pose(400mm, 0mm, 300mm, 180deg, 0deg, 0deg)"};
    if (!take_symbol("]"))
      throw SyntaxError{"unclosed", open.place, "this '[' is not closed before " + shown(peek()), "add ']'"};
    out = std::move(index);
  }
  while (!in_with_ && is_word("with") && peek(1).kind != TokenKind::end && is_symbol("=", 2)) out = with(std::move(out));
  return out;
}

/// PLACE with NAME = VALUE is the call with(PLACE, NAME = VALUE).
ExpressionPtr TokenCursor::with(ExpressionPtr of) {
  auto out = node(Expression::Kind::call, take().place);
  out->name = "with";
  const Token& field = peek();
  if (field.kind != TokenKind::name && field.kind != TokenKind::quoted)
    throw SyntaxError{"no-name", field.place, "a field was expected after 'with', here is " + shown(field),
                      "write such as P with z = 10mm"};
  out->names = {"", take().text};
  take();
  const Nesting nested(nesting_, out->place);
  adopt(*out, std::move(of));
  in_with_ = true;
  adopt(*out, binary(kSum));
  in_with_ = false;
  return out;
}

bool TokenCursor::is_field() const {
  return is_symbol(".") && (peek(1).kind == TokenKind::name || peek(1).kind == TokenKind::quoted);
}

std::vector<ExpressionPtr> TokenCursor::list_until(std::string_view close, const Token& open,
                                                   std::vector<std::string>* names) {
  const Nesting nested(nesting_, open.place);
  std::vector<ExpressionPtr> out;
  while (!is_symbol(close)) {
    const bool named =
        names && (peek().kind == TokenKind::name || peek().kind == TokenKind::quoted) && is_symbol("=", 1);
    if (names) names->push_back(named ? peek().text : "");
    if (named) take(), take();
    out.push_back(expression());
    if (take_symbol(",") || is_symbol(close)) continue;
    refuse_unclosed(open, close);
  }
  take();
  return out;
}

ExpressionPtr TokenCursor::primary() {
  const Token& token = peek();
  refuse_bad(token);
  if (token.kind == TokenKind::number) {
    take();
    return literal(data::Number{token.number, token.dimension}, token.place);
  }
  if (token.kind == TokenKind::text) return text_parts(take());
  if (token.kind == TokenKind::name || token.kind == TokenKind::quoted) return name_or_call();
  if (is_symbol("(")) {
    auto inside = (take(), list_until(")", token));
    if (inside.size() == 1) return std::move(inside.front());
    throw SyntaxError{"bad-brackets", token.place, "one value was expected between these brackets", ""};
  }
  if (is_symbol("[")) return list(take());
  if (is_symbol("{")) return record(take());
  throw SyntaxError{"no-value", token.place, "a value was expected, here is " + shown(token),
                    is_symbol("=")   ? "write == to compare"
                    : is_symbol("/") ? "a comment begins with #"
                    : is_symbol("+") ? "count with `set N = N + 1`"
                                     : ""};
}

/// [A, B, …] or [VALUE for X in LIST]
ExpressionPtr TokenCursor::list(const Token& open) {
  const Nesting nested(nesting_, open.place);
  auto out = node(Expression::Kind::list, open.place);
  if (!is_symbol("]")) adopt(*out, expression());
  if (!out->parts.empty() && is_word("for")) return each(std::move(out), open);
  if (!out->parts.empty() && !take_symbol(",") && !is_symbol("]")) refuse_unclosed(open, "]");
  for (ExpressionPtr& part : list_until("]", open)) adopt(*out, std::move(part));
  return out;
}

/// [VALUE for NAME [, NAME] in EXPR [.. EXPR]]
ExpressionPtr TokenCursor::each(ExpressionPtr value, const Token& open) {
  ExpressionPtr out = std::move(value);
  out->kind = Expression::Kind::each;
  take();
  out->name = loop_name();
  if (take_symbol(",")) out->names = {std::exchange(out->name, loop_name())};
  if (!take_word("in"))
    throw SyntaxError{"no-in", peek().place, "'in' was expected here, is " + shown(peek()),
                      "write such as [i * 2 for i in 1 .. 5]"};
  adopt(*out, expression());
  if (take_symbol("..")) adopt(*out, expression());
  if (!take_symbol("]")) refuse_unclosed(open, "]");
  return out;
}

std::string TokenCursor::loop_name() {
  const Token& token = peek();
  refuse_bad(token);
  const bool named = token.kind == TokenKind::quoted || (token.kind == TokenKind::name && !is_reserved(token.text));
  if (!named)
    throw SyntaxError{"no-name", token.place, "a name was expected after 'for', here is " + shown(token),
                      "write such as [i * 2 for i in 1 .. 5]"};
  return take().text;
}

void TokenCursor::refuse_unclosed(const Token& open, std::string_view close) const {
  refuse_bad(peek());
  if (is_symbol("="))
    throw SyntaxError{"unexpected", peek().place, "'=' is not expected here",
                      open.text == "("
                          ? "write == to compare; clauses of a move follow its point without brackets: "
                            "`movel P, speed 250mm/s`"
                          : "write == to compare"};
  throw SyntaxError{"unclosed", open.place, "this " + shown(open) + " is not closed before " + shown(peek()),
                    "add '" + std::string(close) + "'"};
}

ExpressionPtr TokenCursor::record(const Token& open) {
  auto out = node(Expression::Kind::record, open.place);
  for (ExpressionPtr& part : list_until("}", open, &out->names)) adopt(*out, std::move(part));
  for (std::size_t i = 0; i < out->names.size(); ++i) {
    const auto before = out->names.begin() + static_cast<std::ptrdiff_t>(i);
    const std::string& name = out->names[i];
    if (name.empty())
      throw SyntaxError{"no-name", out->parts[i]->place, "every value of a record has a name",
                        "write { name = value, … }"};
    if (std::find(out->names.begin(), before, name) != before)
      throw SyntaxError{"twice", out->parts[i]->place, "this record has two values called '" + name + "'",
                        ""};
  }
  return out;
}

ExpressionPtr TokenCursor::name_or_call() {
  const Token& token = take();
  const bool bare = token.kind == TokenKind::name;
  if (bare && equal_ignoring_case(token.text, "true")) return literal(true, token.place);
  if (bare && equal_ignoring_case(token.text, "false")) return literal(false, token.place);
  if (bare && is_reserved(token.text))
    throw SyntaxError{"no-value", token.place, "a value was expected, here is " + shown(token), ""};
  auto out = node(Expression::Kind::name, token.place);
  out->name = token.text;
  if (bare && is_symbol("(")) {
    const Token& open = take();
    out->kind = Expression::Kind::call;
    out->name = token.text;
    for (ExpressionPtr& part : list_until(")", open, &out->names)) adopt(*out, std::move(part));
    return out;
  }
  while (is_field()) {
    take();
    out->name += "." + take().text;
  }
  return out;
}

/// The value in the braces of a text: EXPR, or EXPR:SPEC as format("{:SPEC}", EXPR).
ExpressionPtr TokenCursor::in_braces(std::string_view inside, const Token& token, std::size_t at) {
  const std::size_t colon = inside.rfind(':');
  const auto inner = read_tokens(inside.substr(0, colon),
                                 {token.place.line, token.place.column + static_cast<int>(at) + 1, token.place.file});
  const Nesting nested(nesting_, token.place);
  TokenCursor cursor(inner, nesting_);
  ExpressionPtr value = cursor.expression();
  cursor.expect_end("the value in braces");
  if (colon == std::string_view::npos) return value;
  auto out = node(Expression::Kind::call, value->place);
  out->name = "format";
  out->names = {"", ""};
  adopt(*out, literal("{" + std::string(inside.substr(colon)) + "}", value->place));
  adopt(*out, std::move(value));
  return out;
}

/// A text with {expressions} becomes its pieces, joined.
ExpressionPtr TokenCursor::text_parts(const Token& token) {
  auto out = node(Expression::Kind::joined, token.place);
  std::string piece;
  const auto finish_piece = [&] {
    if (!piece.empty()) adopt(*out, literal(std::exchange(piece, {}), token.place));
  };
  for (std::size_t i = 0; i < token.text.size(); ++i) {
    const char c = token.text[i];
    if (c == '\\' && i + 1 < token.text.size()) {
      piece += unescaped(token.text[++i], token.place);
    } else if (c == '{') {
      const auto close = token.text.find('}', i);
      if (close == std::string::npos)
        throw SyntaxError{
            "unclosed", token.place, "a '{' in this text is never closed",
            "write \\{ for the sign; a text in the braces has quotes of its own: give it a name with "
            "`let` before"};
      const std::string_view inside = std::string_view(token.text).substr(i + 1, close - i - 1);
      if (inside.empty() || inside.front() == ':') {  // a field of format()
        piece.append(token.text, i, close + 1 - i);
      } else {
        finish_piece();
        adopt(*out, in_braces(inside, token, i + 1));
      }
      i = close;
    } else {
      piece += c;
    }
  }
  if (out->parts.empty()) return literal(std::move(piece), token.place);
  finish_piece();
  return out;
}

}  // namespace polyarm::program
