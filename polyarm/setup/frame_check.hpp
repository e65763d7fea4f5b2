#pragma once
/// Where points of data files are, before a cell runs: frames are followed as ProgramMoves does it.
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "polyarm/data/data_set.hpp"
#include "polyarm/language/ast.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::cell {

class FrameCheck {
 public:
  /// `sets` and `robots` outlive this. `later`: names of poses that come while the cell runs.
  FrameCheck(const std::vector<data::DataSet>& sets, const CellRobots& robots, std::set<std::string> later);

  /// Points that the program changes, and those that stand for frames and tools.
  void look_at(const program::Program& program);

  /// The pose in the world; nothing where only a run can know it. Throws Error at the point's line: there is
  /// no such frame, or frames hang on one another in a circle.
  std::optional<Pose> in_world(const data::Entry& entry) const;
  /// Poses in the world that moves of the program may mean by this point: as it is, and in each frame that
  /// the program states for moves. Empty: only a run can know.
  std::vector<Pose> meanings(const data::Entry& entry) const;
  /// The line of the `on error` that handles a move to this point; 0 if lines outside of every `try` use it,
  /// or none does.
  int handled_in(const std::string& name) const;
  /// It stands for a frame or a tool, and no move of the program names it.
  bool is_no_target(const std::string& name) const;

 private:
  std::optional<Pose> frame(const std::string& name, const data::Entry& of,
                            std::vector<std::string>& way) const;

  void note_uses(const program::Block& statements, int handler);

  std::map<std::string, const data::Entry*> entries_;
  std::map<std::string, int> handled_;  ///< names that a `try` reads, with the line of its `on error`
  std::set<std::string> unhandled_;     ///< names that other lines read
  const CellRobots& robots_;
  std::set<std::string> later_;    ///< not known before the run
  std::set<std::string> origins_;  ///< frames and tools
  std::set<std::string> targets_;
  std::set<std::string> stated_;  ///< frames of moves
  bool calculated_ = false;       ///< a frame of a move is calculated
};

}  // namespace polyarm::cell
