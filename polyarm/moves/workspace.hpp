#pragma once
/// The region of the world in which the tool centre point (TCP) may be. Metres, world axes.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/paths/path.hpp"

namespace polyarm::moves {

/// plane: the TCP stays on the side that `normal` points to. inside, outside: of a box.
enum class ZoneKind { plane, inside, outside };

struct WorkspaceZone {
  std::string name;
  Location where;  ///< in the file that defines it
  ZoneKind kind = ZoneKind::plane;
  Vec3 point, normal{0, 0, 1};  ///< of a plane; unit normal
  Vec3 low, high;               ///< opposite corners of a box
  bool bodies = false;          ///< it is also of the bodies of the robot, which guards keep
};

/// Const after construction: any thread; only check() allocates.
class Workspace {
 public:
  /// The largest number of boundaries of one workspace: a plane and an outside box have one, an inside box
  /// has six.
  static constexpr std::size_t kMostBoundaries = 64;

  Workspace() = default;
  /// Throws Error("bad-workspace") for an empty box, a zero normal, or too many boundaries.
  explicit Workspace(std::vector<WorkspaceZone> zones);
  bool empty() const noexcept { return boundaries_.empty(); }
  const std::vector<WorkspaceZone>& zones() const noexcept { return zones_; }

  /// The signed distance of the TCP from a boundary, positive on the permitted side, and the unit vector away
  /// from it.
  struct Distance {
    double distance = 0;
    Vec3 away;
  };
  std::size_t boundaries() const noexcept { return boundaries_.size(); }
  Distance distance(std::size_t boundary, const Vec3& tcp) const noexcept;
  /// The index into zones() of a boundary's zone.
  std::size_t zone_of(std::size_t boundary) const noexcept { return boundaries_[boundary].zone; }

  struct Violation {
    std::string zone;
    double depth = 0;  ///< m beyond the boundary
    Vec3 tcp;          ///< its position
    double at = 0;     ///< on a path: the parameter at which it leaves
  };
  /// Checks that the TCP is in the permitted region, to `tolerance`; returns the deepest violation, if any.
  std::optional<Violation> check(const Vec3& tcp, double tolerance = 0) const;

 private:
  struct Boundary {
    std::size_t zone;
    bool box;  ///< the outside of a box; else a plane
    Vec3 point, normal;
  };
  std::vector<WorkspaceZone> zones_;
  std::vector<Boundary> boundaries_;
};

/// The first place at which the TCP leaves the workspace while the joints follow `path`; empty if it does not
/// leave. If the TCP is outside at the beginning, it may return; a violation is then a place where it goes
/// deeper. The step size depends on the distance and the speed of the TCP, and is at least a 20000th of the
/// path. Allocates little; any thread.
std::optional<Workspace::Violation> first_violation(const Workspace& workspace,
                                                    const kinematics::Chain& chain, const paths::Path& path,
                                                    double tolerance = 1e-6);

/// A violation as Error("workspace"). `what` names the move, `share` is the fraction of its path.
Error leaves_workspace(const Workspace::Violation& found, const std::string& what, double share);
/// Throws that error for the first violation of a path.
void check_workspace(const Workspace& workspace, const kinematics::Chain& chain, const paths::Path& path,
                     const std::string& what);

}  // namespace polyarm::moves
