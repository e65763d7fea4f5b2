#pragma once
/// Determines which values of a program are known before it runs although others change while it runs ("open"
/// values): those of tags that the hardware, the PLC, a link or a person sets, and all values computed from
/// them.
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/language/ast.hpp"

namespace polyarm::program {

/// A name is open in the whole program as soon as one line assigns an open value, so in doubt the answer is
/// "not known". One thread at a time.
class Certainty {
 public:
  /// `open`: names of the cell whose values others may change while the program runs. `program` must outlive
  /// this object.
  Certainty(const Program& program, std::set<std::string> open);

  /// True if no value read by the statement in this line depends on an open value. False if no statement
  /// begins there.
  bool values_known(const Location& where) const;
  /// The same for a line reached through function calls: the lines of the calls, outermost first, then the
  /// line itself. Only these calls determine the parameters.
  bool values_known(const std::vector<Location>& calls) const;
  /// True if no condition and no range of the program depends on an open value.
  bool conditions_known() const { return conditions_known_; }
  /// True if, between the moves in these two lines, no open value decides whether a move is executed. An
  /// empty `from` is the start of the program.
  bool follows(const Location& from, const Location& to) const;

 private:
  /// The position of a statement.
  struct Spot {
    const Statement* statement = nullptr;
    const Statement* function = nullptr;  ///< the enclosing function; null: none
  };
  /// A block with moves whose execution or repetition depends on an open value.
  struct OpenBlock {
    int file = 0, first = 0, last = 0;
    bool contains(Place place) const {
      return place.file == file && place.line >= first && place.line <= last;
    }
  };
  /// A block around the present statement, and the names that it creates.
  struct Around {
    bool open = false;
    std::set<std::string> made;
  };

  void collect(const Block& statements, const Statement* function);
  void find_moving_functions();
  void check_everything();
  /// Enters a function as called by `by`.
  void enter(const Statement& function, const Statement& by);
  void check_function(const Statement& function);
  void block(const Block& statements, bool open, std::set<std::string> made = {});
  void statement(const Statement& s);
  void branches(const Statement& s);
  void for_loop(const Statement& s);
  void ends(const Statement& s);
  void call(const Expression& e);
  void give(const std::string& name, bool open);
  void make_open(std::set<std::string>& names, const std::string& name);
  bool in_open_block() const;

  bool reads_open(const Expression& e) const;
  bool reads_open(const ExpressionPtr& e) const { return e && reads_open(*e); }
  bool reads_open(const Statement& s) const;
  bool leaves_openly(const Block& statements, bool open) const;
  bool has_moves(const Block& statements) const;
  Place place_of(const Location& where) const;

  const Program& program_;
  std::set<std::string> open_;                 ///< names of the cell and of the program
  std::map<std::pair<int, int>, Spot> spots_;  ///< by file and line
  std::map<std::string, const Statement*> functions_;
  std::set<std::string> open_results_;   ///< functions with a result that depends on an open value
  std::set<std::string> called_openly_;  ///< functions that are called in an open block
  std::set<std::string> leaving_;        ///< functions that may end the program or raise an error, depending
                                         ///< on an open value
  std::set<std::string> moving_;         ///< functions with moves
  std::vector<const Statement*> uses_;
  std::vector<OpenBlock> open_blocks_;
  std::vector<Around> around_;
  const Statement* inside_ = nullptr;  ///< the function under analysis
  bool conditions_known_ = true, changed_ = false;
};

}  // namespace polyarm::program
