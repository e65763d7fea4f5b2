#pragma once
/// Parses one statement, without its block. Private to the parser's files.
#include <string>
#include <vector>

#include "polyarm/language/expression_parser.hpp"

namespace polyarm::program {

/// A statement with its keyword, corrected if it is misspelt.
struct Line {
  SourceLine source;
  std::string word;  ///< lower case; empty: no similar keyword
  bool misspelt = false;
};

/// A block that encloses a statement.
struct Opener {
  std::string word;
  Place place;
  bool handles = false;  ///< after its `on error`
};
using Openers = std::vector<Opener>;

/// Parses `line` after its first word, which the cursor has passed; `open` are the enclosing blocks,
/// innermost last. Throws SyntaxError.
void parse_statement(const Line& line, TokenCursor& cursor, Statement& out, const Openers& open);

/// The name of something that can be changed, with dots; `statement` is the word before it.
std::string parse_target(TokenCursor& cursor, const char* statement);
/// The correct form of speedj or speedl, for messages.
std::string speed_move_advice(Statement::Motion motion);
/// moveto, movej, movel, movec, speedj, speedl, drive, turn and use, with their clauses. speedj and speedl
/// are a movej and a movel with the keyword in `name`: their argument is a record of velocities, not a point.
void parse_move(const Line& line, TokenCursor& cursor, Statement& out);
void parse_use(TokenCursor& cursor, Statement& out);

}  // namespace polyarm::program
