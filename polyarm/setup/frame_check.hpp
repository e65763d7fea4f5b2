#pragma once
/// Resolves the frames of points in data files before a cell runs, in the same way as ProgramMoves.
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
  /// `sets` and `robots` must outlive this object. `later`: names of poses that are received during the run.
  FrameCheck(const std::vector<data::DataSet>& sets, const CellRobots& robots, std::set<std::string> later);

  /// Notes the points that the program changes, and those that it uses as frames and tools.
  void look_at(const program::Program& program);

  /// The pose in the world; empty if it is only known during the run. Throws Error at the point's line if
  /// there is no such frame or if frames form a cycle.
  std::optional<Pose> in_world(const data::Entry& entry) const;
  /// The poses in the world that moves may mean by this point: as it is, and in each frame that the program
  /// states for moves. Empty if it is only known during the run.
  std::vector<Pose> meanings(const data::Entry& entry) const;
  /// The line of the `on error` that handles a move to this point; 0 if lines outside every `try` use it, or
  /// no line does.
  int handled_in(const std::string& name) const;
  /// True if it serves as a frame or tool and no move uses it as a target.
  bool is_no_target(const std::string& name) const;

 private:
  std::optional<Pose> frame(const std::string& name, const data::Entry& of) const;

  void note_uses(const program::Block& statements, int handler);

  std::map<std::string, const data::Entry*> entries_;
  std::map<std::string, int> handled_;  ///< names that a `try` reads, with the line of its `on error`
  std::set<std::string> unhandled_;     ///< names that other lines read
  const CellRobots& robots_;
  std::set<std::string> later_;    ///< unknown before the run
  std::set<std::string> origins_;  ///< frames and tools
  std::set<std::string> targets_;
  std::set<std::string> stated_;  ///< frames of moves
  bool calculated_ = false;       ///< a frame of a move is calculated
};

}  // namespace polyarm::cell
