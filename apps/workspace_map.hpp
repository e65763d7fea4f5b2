#pragma once
/// Maps where an arm reaches and how well it moves there, over a grid of positions in one plane.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/moves/workspace.hpp"

namespace polyarm::apps {

struct WorkspaceQuestion {
  std::string plane = "xz";            ///< xz, xy or yz
  double at = 0;                       ///< the third coordinate, m
  int resolution = 80;                 ///< cells along the longer edge
  std::optional<Quaternion> rotation;  ///< of the TCP; empty: any
  moves::Workspace allowed;            ///< region in which the TCP may be; other positions are not tried
};

/// One cell of the grid. An unreachable cell has no joint state and zeros.
struct WorkspaceCell {
  Vec3 position;
  std::vector<double> q;  ///< a joint state that reaches it
  /// Manipulability of the TCP: Yoshikawa's measure (1985) of the Jacobian's linear part, lengths in units of
  /// the arm's reach; 0 at a singularity.
  double manipulability = 0;
  double smallest_singular_value = 0;  ///< of kinematics::smallest_singular_value()
  bool reached() const { return !q.empty(); }
};

struct WorkspaceMap {
  int columns = 0, rows = 0;  ///< rows from the top
  double cell = 0;            ///< edge, m
  double left = 0, top = 0;   ///< of the grid, along the plane's first and second axis, m
  std::vector<WorkspaceCell> cells;
  bool closed_form = false;
  double best_manipulability() const;
  std::size_t reached() const;
};

/// Tries every cell within the arm's reach, row by row. Uses the closed-form solution nearest to `home` if
/// the arm has one and the rotation is given; otherwise descends from the neighbour's solution, from `home`
/// and from random seeds. Deterministic. `progress` receives the completed share after each row. Throws
/// Error("bad-value").
WorkspaceMap map_workspace(const kinematics::Chain& chain, const std::vector<double>& home,
                           const WorkspaceQuestion& question, const std::function<void(double)>& progress);

std::string csv_of(const WorkspaceMap& map, const kinematics::Chain& chain);
std::string svg_of(const WorkspaceMap& map, const WorkspaceQuestion& question, const std::string& title);
/// The map alone, 8 pixels per cell, uncompressed.
std::string png_of(const WorkspaceMap& map);

}  // namespace polyarm::apps
