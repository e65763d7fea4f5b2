#pragma once
/// One statement of a program, without the block that it may open.
#include <string>
#include <vector>

#include "polyarm/program/expression_parser.hpp"

namespace polyarm::program {

/// A statement with the keyword it begins with, corrected where it is misspelt.
struct Line {
  SourceLine source;
  std::string word;  ///< lower case; empty: no keyword is near
  bool misspelt = false;
};

/// A block that is open where a statement stands.
struct Opener {
  std::string word;
  Place place;
  bool handles = false;  ///< behind its `on error`
};
using Openers = std::vector<Opener>;

/// Parses `line` behind its first word, which the cursor has passed; `open` are the blocks around it,
/// innermost last. Throws SyntaxError.
void parse_statement(const Line& line, TokenCursor& cursor, Statement& out, const Openers& open);

/// The name of something that can be changed, with its dots; `statement` stands before it.
std::string parse_target(TokenCursor& cursor, const char* statement);
/// How speedj or speedl is written.
std::string speed_move_advice(Statement::Motion motion);
/// moveto, movej, movel, movec, speedj, speedl, drive, turn and use, with their clauses. speedj and speedl
/// are a movej and a movel whose `name` says the word: their argument is a record of velocities, not a point.
void parse_move(const Line& line, TokenCursor& cursor, Statement& out);
void parse_use(TokenCursor& cursor, Statement& out);

}  // namespace polyarm::program
