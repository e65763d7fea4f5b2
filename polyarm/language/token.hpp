#pragma once
/// The tokens of one statement, with their places.
#include <string>
#include <vector>

#include "polyarm/base/quantity.hpp"

namespace polyarm::program {

/// A place in a program: line and column from 1, columns in characters; the file as numbered by Program.
struct Place {
  int line = 0;
  int column = 0;
  int file = 0;
};

enum class TokenKind {
  name,    ///< a word; a keyword only where the grammar expects one
  quoted,  ///< a name in back-quotes, never a keyword
  number,
  text,  ///< between double quotes, as written there
  symbol,
  bad,  ///< `text` has the fault
  end,  ///< of the statement
};

struct Token {
  TokenKind kind = TokenKind::end;
  std::string text;  ///< the name, the symbol, the raw content of a text, or the fault
  Place place;
  double number = 0;  ///< SI
  Dimension dimension = Dimension::none;
};

/// One statement: usually one line; more if brackets or a trailing comma continue it.
struct SourceLine {
  std::string raw;            ///< its text without comments; continuation lines are joined with a line break
  Place place;                ///< of its first word
  std::vector<Token> tokens;  ///< the last one is always of kind end
};

}  // namespace polyarm::program
