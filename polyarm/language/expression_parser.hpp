#pragma once
/// Parses the expressions of one statement by precedence climbing. Private to the parser's files.
#include <algorithm>
#include <string_view>
#include <vector>

#include "polyarm/language/ast.hpp"

namespace polyarm::program {

/// Aborts the parsing of one statement; the parser catches it and continues with the next.
struct SyntaxError {
  std::string code;
  Place place;
  std::string what;
  std::string advice;
};

/// A cursor over the tokens of a statement.
class TokenCursor {
 public:
  explicit TokenCursor(const std::vector<Token>& tokens, int nesting = 0)
      : tokens_{tokens}, nesting_{nesting} {}

  const Token& peek(std::size_t ahead = 0) const {
    return tokens_[std::min(at_ + ahead, tokens_.size() - 1)];
  }
  const Token& take() { return tokens_[at_ + 1 < tokens_.size() ? at_++ : at_]; }
  bool at_end() const { return peek().kind == TokenKind::end; }
  bool is_symbol(std::string_view symbol, std::size_t ahead = 0) const;
  /// True for an unquoted name equal to `word` in any case.
  bool is_word(std::string_view word, std::size_t ahead = 0) const;
  bool take_symbol(std::string_view symbol);
  bool take_word(std::string_view word);
  std::size_t position() const { return at_; }
  const std::vector<Token>& tokens() const { return tokens_; }

  /// Parses the longest expression from here. Throws SyntaxError.
  ExpressionPtr expression();
  /// Expressions separated by commas, up to and including `close`. With `names` each may be `NAME = EXPR`;
  /// the name, or an empty one, is added there.
  std::vector<ExpressionPtr> list_until(std::string_view close, const Token& open,
                                        std::vector<std::string>* names = nullptr);
  /// True if a dot and a name follow.
  bool is_field() const;
  /// Throws SyntaxError unless the statement ends here.
  void expect_end(const std::string& statement) const;

 private:
  ExpressionPtr binary(int level);
  ExpressionPtr unary(int level);
  ExpressionPtr power();
  ExpressionPtr postfix();
  ExpressionPtr primary();
  ExpressionPtr with(ExpressionPtr of);
  ExpressionPtr list(const Token& open);
  ExpressionPtr each(ExpressionPtr value, const Token& open);
  std::string loop_name();
  [[noreturn]] void refuse_unclosed(const Token& open, std::string_view close) const;
  ExpressionPtr record(const Token& open);
  ExpressionPtr name_or_call();
  ExpressionPtr in_braces(std::string_view inside, const Token& token, std::size_t at);
  ExpressionPtr text_parts(const Token& token);

  const std::vector<Token>& tokens_;
  std::size_t at_ = 0;
  int nesting_ = 0;
  bool in_with_ = false;  ///< the next `with` belongs to the value before this one
};

/// "'x'", or "the end of the line".
std::string shown(const Token& token);
/// Throws SyntaxError if the next token is a unit that a blank separates from its number.
void refuse_lone_unit(const TokenCursor& cursor);
/// Throws SyntaxError for a token of kind bad.
void refuse_bad(const Token& token);
/// and or not mod true false.
bool is_reserved(std::string_view word);

}  // namespace polyarm::program
