#pragma once
/// Which values of a program are known before it runs, although others change while it runs: those of tags
/// that the hardware, the PLC, a link or a person sets, and everything calculated from them.
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/program/ast.hpp"

namespace polyarm::program {

/// A name is open in the whole program as soon as one line gives it an open value, so the answers err towards
/// "not known". Any one thread.
class Certainty {
 public:
  /// `open`: names of the cell whose values others may change while the program runs. `program` outlives
  /// this.
  Certainty(const Program& program, std::set<std::string> open);

  /// True if no value that the statement in this line reads depends on an open one. False if no statement
  /// begins there.
  bool values_known(const Location& where) const;
  /// The same where functions were called: the lines of the calls, the outermost first, then the line itself.
  /// What their parameters are is judged by these calls alone.
  bool values_known(const std::vector<Location>& calls) const;
  /// True if no condition and no range of the program depends on an open value.
  bool conditions_known() const { return conditions_known_; }
  /// True if, between the moves in these two lines, no move comes or goes by an open value. An empty `from`
  /// is the start of the program.
  bool follows(const Location& from, const Location& to) const;

 private:
  /// Where a statement is.
  struct Spot {
    const Statement* statement = nullptr;
    const Statement* function = nullptr;  ///< around it; null: none
  };
  /// A block that runs or not, or how often, by an open value; with moves in it.
  struct OpenBlock {
    int file = 0, first = 0, last = 0;
    bool contains(Place place) const {
      return place.file == file && place.line >= first && place.line <= last;
    }
  };
  /// A block around the statement that is looked at, and the names that it makes.
  struct Around {
    bool open = false;
    std::set<std::string> made;
  };

  void collect(const Block& statements, const Statement* function);
  void find_moving_functions();
  void look_at_everything();
  /// The function as it is called by `by`.
  void enter(const Statement& function, const Statement& by);
  void look_at_function(const Statement& function);
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
  std::set<std::string> open_results_;   ///< functions whose result depends on an open value
  std::set<std::string> called_openly_;  ///< functions that are called in an open block
  std::set<std::string> leaving_;        ///< functions that may end the program, or raise, by an open value
  std::set<std::string> moving_;         ///< functions with moves
  std::vector<const Statement*> uses_;
  std::vector<OpenBlock> open_blocks_;
  std::vector<Around> around_;
  const Statement* inside_ = nullptr;  ///< the function that is looked at
  bool conditions_known_ = true, changed_ = false;
};

}  // namespace polyarm::program
