#include "polyarm/language/format.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/language/lexer.hpp"
#include "polyarm/language/parser.hpp"

namespace polyarm::program {

namespace {
bool is_one_of(const Token& token, std::string_view symbols) {
  return token.kind == TokenKind::symbol && token.text.size() == 1 &&
         symbols.find(token.text) != std::string_view::npos;
}

std::string written(const Token& token) {
  if (token.kind == TokenKind::text) return '"' + token.text + '"';
  if (token.kind == TokenKind::quoted) return '`' + token.text + '`';
  return token.text;
}

int width(std::string_view text) {
  return static_cast<int>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

bool touch(const Token& a, const Token& b) {
  return a.place.line == b.place.line && a.place.column + width(written(a)) == b.place.column;
}

/// True if a value may end here, so that a following sign is binary.
bool ends_value(const Token& token) {
  if (token.kind == TokenKind::symbol) return is_one_of(token, ")]}");
  static constexpr std::array<std::string_view, 8> kWords = {"and", "or",     "not",     "mod",
                                                             "in",  "return", "timeout", "until"};
  return token.kind != TokenKind::name ||
         std::none_of(kWords.begin(), kWords.end(),
                      [&](std::string_view word) { return equal_ignoring_case(token.text, word); });
}

/// Decides about blanks between two words of a statement.
class Spacing {
 public:
  explicit Spacing(const std::vector<Token>& tokens) : tokens_{tokens} {}

  bool blank_before(std::size_t i) const {
    const Token &left = tokens_[i - 1], &right = tokens_[i];
    if (is_one_of(right, ",)]}") || is_one_of(left, "([{")) return false;
    if (is_one_of(right, ".") || is_one_of(left, ".")) return false;
    if (is_sign(i - 1)) return false;
    if (!is_one_of(right, "([")) return true;
    return left.kind == TokenKind::symbol ? !is_one_of(left, ")]") : !touch(left, right);
  }

 private:
  /// A minus, or the plus of a thesis literal, before one value.
  bool is_sign(std::size_t i) const {
    if (!is_one_of(tokens_[i], "-+")) return false;
    if (i == 0 || !ends_value(tokens_[i - 1])) return true;
    // `movel -x` and `speed -v`: keeps the spacing
    return tokens_[i - 1].kind == TokenKind::name && !touch(tokens_[i - 1], tokens_[i]) &&
           i + 1 < tokens_.size() && touch(tokens_[i], tokens_[i + 1]);
  }

  const std::vector<Token>& tokens_;
};

class Formatter {
 public:
  explicit Formatter(std::string_view text) : lines_{split_lines(text)} {}

  std::string run() {
    for (const SourceLine& statement : read_source(lines_)) {
      comments_up_to(statement.place.line);
      write(statement);
      next_ = last_line(statement) + 1;
    }
    comments_up_to(static_cast<int>(lines_.size()) + 1);
    while (out_.ends_with("\n\n")) out_.pop_back();
    return out_ == "\n" ? std::string{} : out_;
  }

 private:
  static int last_line(const SourceLine& statement) {
    return statement.tokens.size() > 1 ? statement.tokens[statement.tokens.size() - 2].place.line
                                       : statement.place.line;
  }

  std::string_view comment_of(int line) const {
    const std::string& text = lines_[static_cast<std::size_t>(line) - 1];
    return trim(std::string_view(text).substr(end_of_code(text)));
  }

  void put(int depth, std::string_view text) {
    if (text.empty()) {
      if (!out_.empty() && !out_.ends_with("\n\n")) out_ += '\n';
      return;
    }
    out_ += std::string(static_cast<std::size_t>(std::max(0, depth)) * 2, ' ');
    out_ += text;
    out_ += '\n';
  }

  /// Empty lines and comment lines, indented like the lines before them.
  void comments_up_to(int line) {
    for (; next_ < line; ++next_) put(depth_, comment_of(next_));
  }

  void write(const SourceLine& statement) {
    const BlockRole role = block_role(statement);
    const bool back = role == BlockRole::closes || role == BlockRole::continues;
    const int depth = std::max(0, depth_ - (back ? 1 : 0));
    if (keeps_text(statement)) {
      put(depth, with_comment(std::string(trim(statement.raw)), statement.place.line));
    } else {
      write_words(statement, depth);
    }
    depth_ = depth + (role == BlockRole::opens || role == BlockRole::continues ? 1 : 0);
  }

  static bool keeps_text(const SourceLine& statement) {
    const Token& first = statement.tokens.front();
    const bool file = equal_ignoring_case(first.text, "load") || equal_ignoring_case(first.text, "import");
    const bool bad = std::any_of(statement.tokens.begin(), statement.tokens.end(),
                                 [](const Token& token) { return token.kind == TokenKind::bad; });
    return bad || takes_rest_as_text(statement.tokens) || (first.kind == TokenKind::name && file);
  }

  std::string with_comment(std::string code, int line) const {
    const std::string_view comment = comment_of(line);
    return comment.empty() ? code : code + "  " + std::string(comment);
  }

  void write_words(const SourceLine& statement, int depth) {
    const auto& tokens = statement.tokens;
    const Spacing spacing(tokens);
    std::size_t i = 0;
    for (int line = statement.place.line; line <= last_line(statement); ++line) {
      std::string code;
      for (bool first = true; i + 1 < tokens.size() && tokens[i].place.line == line; ++i, first = false) {
        if (!first && spacing.blank_before(i)) code += ' ';
        code += written(tokens[i]);
      }
      if (code.empty() && comment_of(line).empty()) continue;
      put(depth + (line > statement.place.line ? 2 : 0),
          code.empty() ? std::string(comment_of(line)) : with_comment(std::move(code), line));
    }
  }

  std::vector<std::string> lines_;
  std::string out_;
  int next_ = 1;
  int depth_ = 0;
};
}  // namespace

std::string format(std::string_view text) {
  return Formatter(text).run();
}

}  // namespace polyarm::program
