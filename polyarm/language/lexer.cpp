#include "polyarm/language/lexer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::program {

namespace {
/// A statement over more lines has an unclosed bracket.
constexpr std::size_t kMostLinesOfAStatement = 200;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}

/// The length in bytes of the valid UTF-8 character at `at`, and its code point; length 0: invalid.
struct Character {
  std::size_t length = 0;
  char32_t code = 0;
};

Character character_at(std::string_view text, std::size_t at) {
  const auto byte = static_cast<unsigned char>(text[at]);
  if (byte < 0x80) return {1, byte};
  const std::size_t length = byte >= 0xF0 && byte < 0xF5   ? 4
                             : byte >= 0xE0 && byte < 0xF0 ? 3
                             : byte >= 0xC2 && byte < 0xE0 ? 2
                                                           : 0;
  if (length == 0 || at + length > text.size()) return {};
  char32_t code = byte & (0xFF >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    const auto next = static_cast<unsigned char>(text[at + i]);
    if ((next & 0xC0) != 0x80) return {};
    code = (code << 6) | (next & 0x3F);
  }
  return {length, code};
}

/// Letters of any script; blanks and punctuation that look like ASCII are not allowed in names.
bool is_name_character(char32_t code) {
  if (code < 0x80)
    return code == '_' || is_letter(static_cast<char>(code)) || is_digit(static_cast<char>(code));
  return code >= 0xC0 && code != 0xD7 && code != 0xF7 && !(code >= 0x2000 && code <= 0x2BFF) &&
         !(code >= 0x3000 && code <= 0x3004) && !(code >= 0x3008 && code <= 0x3020) && code != 0xFEFF &&
         !(code >= 0xFF00 && code <= 0xFF0F);
}

/// Adds the tokens of one physical line to `tokens`.
class LineLexer {
 public:
  LineLexer(std::string_view text, Place place, std::vector<Token>& tokens)
      : text_{text}, place_{place}, tokens_{tokens} {}

  void read() {
    while (skip_blanks() && text_[at_] != '#') read_token();
  }
  /// The start of the comment, or the end of the line.
  std::size_t end_of_code() const { return at_; }

 private:
  bool skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) advance(1);
    return at_ < text_.size();
  }

  void advance(std::size_t bytes) {
    for (std::size_t i = 0; i < bytes && at_ < text_.size(); ++i, ++at_)
      if ((static_cast<unsigned char>(text_[at_]) & 0xC0) != 0x80) ++place_.column;
  }

  void read_token() {
    const char c = text_[at_];
    if (is_digit(c) || (c == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1]))) return read_number();
    if (c == '"') return read_text();
    if (c == '`') return read_quoted_name();
    const Character character = character_at(text_, at_);
    if (character.length == 0) return bad(1, "this byte is no UTF-8 text: save the file as UTF-8");
    if (is_name_character(character.code)) return read_name();
    read_symbol(character.length);
  }

  void push(TokenKind kind, std::string text, std::size_t bytes) {
    tokens_.push_back({kind, std::move(text), place_, 0, Dimension::none});
    advance(bytes);
  }
  void bad(std::size_t bytes, const std::string& why) { push(TokenKind::bad, why, bytes); }

  std::size_t name_end(std::size_t from) const {
    while (from < text_.size()) {
      const Character character = character_at(text_, from);
      if (character.length == 0 || !is_name_character(character.code)) break;
      from += character.length;
    }
    return from;
  }

  void read_name() {
    const std::size_t length = name_end(at_) - at_;
    push(TokenKind::name, std::string(text_.substr(at_, length)), length);
  }

  void read_quoted_name() {
    const auto close = text_.find('`', at_ + 1);
    if (close == std::string_view::npos) return bad(text_.size() - at_, "this back-quote is never closed");
    const std::size_t length = close + 1 - at_;
    if (length == 2) return bad(length, "there is no name between these back-quotes");
    push(TokenKind::quoted, std::string(text_.substr(at_ + 1, length - 2)), length);
  }

  void read_text() {
    std::size_t end = at_ + 1;
    while (end < text_.size() && text_[end] != '"') end += text_[end] == '\\' ? 2 : 1;
    if (end >= text_.size())
      return bad(text_.size() - at_, "this text is never closed; it ends with \" on its line");
    push(TokenKind::text, std::string(text_.substr(at_ + 1, end - at_ - 1)), end + 1 - at_);
  }

  std::size_t digits_end(std::size_t from) const {
    while (from < text_.size() && is_digit(text_[from])) ++from;
    return from;
  }

  std::size_t number_end() const {
    std::size_t end = digits_end(at_);
    if (end + 1 < text_.size() && text_[end] == '.' && is_digit(text_[end + 1])) end = digits_end(end + 1);
    if (end < text_.size() && (text_[end] == 'e' || text_[end] == 'E')) {
      const std::size_t sign =
          end + 1 < text_.size() && (text_[end + 1] == '-' || text_[end + 1] == '+') ? 2 : 1;
      if (end + sign < text_.size() && is_digit(text_[end + sign])) end = digits_end(end + sign);
    }
    return end;
  }

  /// The end of the unit that starts at `from`: letters or %, with at most one slash.
  std::size_t unit_end(std::size_t from) const {
    if (from < text_.size() && text_[from] == '%') return from + 1;
    const std::size_t plain = name_end(from);
    if (plain == from || plain + 1 >= text_.size() || text_[plain] != '/') return plain;
    const std::size_t below = name_end(plain + 1);
    return find_unit(text_.substr(from, below - from)) ? below : plain;
  }

  void read_number() {
    const std::size_t end = number_end(), after = unit_end(end);
    const auto number = parse_number(text_.substr(at_, end - at_));
    const std::string unit_text(text_.substr(end, after - end));
    const Unit* unit = unit_text.empty() ? nullptr : find_unit(unit_text);
    if (!number) return bad(after - at_, "this number is too big");
    if (!unit_text.empty() && !unit)
      return bad(after - at_,
                 "'" + unit_text.substr(0, 40) + "' is not a unit, and no name starts with a digit");
    const double value = *number * (unit ? unit->scale : 1);
    if (!std::isfinite(value)) return bad(after - at_, "this number is too big");
    push(TokenKind::number, std::string(text_.substr(at_, after - at_)), after - at_);
    tokens_.back().number = value;
    tokens_.back().dimension = unit ? unit->dimension : Dimension::none;
  }

  void read_symbol(std::size_t length) {
    static constexpr std::array<std::string_view, 5> kPairs = {"==", "!=", "<=", ">=", ".."};
    static constexpr std::string_view kSingles = "()[]{},.=<>+-*/^";
    const std::string_view pair = text_.substr(at_, 2);
    if (std::find(kPairs.begin(), kPairs.end(), pair) != kPairs.end())
      return push(TokenKind::symbol, std::string(pair), 2);
    if (kSingles.find(text_[at_]) != std::string_view::npos)
      return push(TokenKind::symbol, std::string(1, text_[at_]), 1);
    const bool visible = static_cast<unsigned char>(text_[at_]) >= 0x20;
    const std::string_view symbol = text_.substr(at_, length);
    bad(length, (visible ? "'" + std::string(symbol) + "'" : "this control character") +
                    " has no meaning here" + std::string(instead_of(symbol)));
  }

  /// What to write instead of symbols of other languages, and of those that text processors put in.
  static std::string_view instead_of(std::string_view symbol) {
    static constexpr std::pair<std::string_view, std::string_view> kInstead[] = {
        {"!", "; write `not`, and # before a comment"},
        {"&", "; write `and`"},
        {"|", "; write `or`"},
        {"'", "; a text stands in double quotes"},
        {"\u2018", "; a text stands in double quotes"},
        {"\u2019", "; a text stands in double quotes"},
        {"\u201c", "; a text stands in plain double quotes"},
        {"\u201d", "; a text stands in plain double quotes"},
        {"\u2212", "; a minus sign is written -"},
        {"\u2013", "; a minus sign is written -"},
        {"\u00a0", ": it is a special blank; write a plain one"},
        {"$",
         "; inputs and outputs are tags of signals.yaml, speeds are clauses such as `use speed 250mm/s`"},
        {";", "; a statement ends with its line, and a comment begins with #"},
        {":", "; a block begins on the next line"},
        {"%", "; it stands right behind a number, and the rest of a division is `mod`"}};
    const auto at = std::find_if(std::begin(kInstead), std::end(kInstead),
                                 [&](const auto& each) { return each.first == symbol; });
    return at == std::end(kInstead) ? std::string_view() : at->second;
  }

  std::string_view text_;
  Place place_;
  std::size_t at_ = 0;
  std::vector<Token>& tokens_;
};

int depth_after(std::span<const Token> tokens, int depth) {
  for (const Token& token : tokens) {
    if (token.kind != TokenKind::symbol || token.text.size() != 1) continue;
    const char sign = token.text.front();
    if (sign == '(' || sign == '[' || sign == '{') ++depth;
    if (sign == ')' || sign == ']' || sign == '}') depth = std::max(0, depth - 1);
  }
  return depth;
}

bool ends_with_comma(const std::vector<Token>& tokens) {
  return !tokens.empty() && tokens.back().kind == TokenKind::symbol && tokens.back().text == ",";
}

/// Collects statements line by line.
class SourceReader {
 public:
  SourceReader(const std::vector<std::string>& lines, int file) : lines_{lines}, file_{file} {}

  std::vector<SourceLine> read() {
    out_.reserve(lines_.size());
    while (next_ < lines_.size()) read_statement();
    return std::move(out_);
  }

 private:
  void read_statement() {
    SourceLine statement;
    const std::size_t first = next_;
    int depth = read_line(statement, 0);
    const std::size_t own_tokens = statement.tokens.size(), own_text = statement.raw.size();
    if (statement.tokens.empty()) return;
    const bool raw = takes_rest_as_text(statement.tokens);
    while (!raw && (depth > 0 || ends_with_comma(statement.tokens)) && next_ < lines_.size() &&
           next_ - first < kMostLinesOfAStatement)
      depth = read_line(statement, depth);
    if (!raw && depth > 0) {  // the bracket is never closed: only its line is faulty
      next_ = first + 1;
      statement.tokens.resize(own_tokens);
      statement.raw.resize(own_text);
    }
    finish(std::move(statement));
  }

  int read_line(SourceLine& statement, int depth) {
    const std::string& line = lines_[next_];
    const int number = static_cast<int>(++next_);
    const std::size_t before = statement.tokens.size();
    constexpr std::size_t kBytesOfAToken = 3;
    if (before == 0) statement.tokens.reserve(line.size() / kBytesOfAToken + 3);
    LineLexer lexer(line, {number, 1, file_}, statement.tokens);
    lexer.read();
    if (!statement.raw.empty()) statement.raw += '\n';
    statement.raw.append(line, 0, lexer.end_of_code());
    const auto tokens = std::span<const Token>(statement.tokens).subspan(before);
    depth = depth_after(tokens, depth);
    end_ = {number,
            tokens.empty() ? 1 : tokens.back().place.column + static_cast<int>(tokens.back().text.size()),
            file_};
    return depth;
  }

  void finish(SourceLine statement) {
    statement.place = statement.tokens.front().place;
    statement.tokens.push_back({TokenKind::end, "", end_, 0, Dimension::none});
    out_.push_back(std::move(statement));
  }

  const std::vector<std::string>& lines_;
  int file_;
  std::size_t next_ = 0;
  Place end_;
  std::vector<SourceLine> out_;
};
}  // namespace

bool takes_rest_as_text(const std::vector<Token>& tokens) {
  if (tokens.size() < 3 || tokens[0].kind != TokenKind::name || !equal_ignoring_case(tokens[0].text, "set"))
    return false;
  const Token& third = tokens[2];
  const bool target =
      third.kind == TokenKind::symbol && (third.text == "=" || third.text == "." || third.text == "[");
  return !target;
}

std::size_t end_of_code(std::string_view line) {
  std::vector<Token> tokens;
  LineLexer lexer(line, {1, 1, 0}, tokens);
  lexer.read();
  return lexer.end_of_code();
}

std::vector<std::string> split_lines(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::vector<std::string> out;
  while (!text.empty()) {
    const auto end = text.find('\n');
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    out.emplace_back(line);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return out;
}

std::vector<SourceLine> read_source(const std::vector<std::string>& lines, int file) {
  return SourceReader(lines, file).read();
}

std::vector<Token> read_tokens(std::string_view text, Place place) {
  std::vector<Token> tokens;
  LineLexer(text, place, tokens).read();
  const int end = place.column + static_cast<int>(text.size());
  tokens.push_back({TokenKind::end, "", {place.line, end, place.file}, 0, Dimension::none});
  return tokens;
}

}  // namespace polyarm::program
