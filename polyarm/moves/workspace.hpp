#pragma once
/// Where in the world the tool centre point (TCP) may be. Metres, world axes.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/paths/path.hpp"

namespace polyarm::moves {

/// plane: the TCP stays on the side that `normal` points to. inside, outside: of the box.
enum class ZoneKind { plane, inside, outside };

struct WorkspaceZone {
  std::string name;
  Location where;  ///< in the file that states it
  ZoneKind kind = ZoneKind::plane;
  Vec3 point, normal{0, 0, 1};  ///< of a plane; the normal is of length 1
  Vec3 low, high;               ///< opposite corners of a box
};

/// Const after construction: any thread, nothing below allocates but check().
class Workspace {
 public:
  /// Boundaries that one workspace may have: one for a plane and for an outside box, six for an inside box.
  static constexpr std::size_t kMostBoundaries = 64;

  Workspace() = default;
  /// Throws Error("bad-workspace") for a box without room, a normal of length zero, or too many boundaries.
  explicit Workspace(std::vector<WorkspaceZone> zones);
  bool empty() const noexcept { return boundaries_.empty(); }
  const std::vector<WorkspaceZone>& zones() const noexcept { return zones_; }

  /// A boundary's signed distance from the TCP, positive on the side where it may be, and the unit vector
  /// away from it.
  struct Distance {
    double distance = 0;
    Vec3 away;
  };
  std::size_t boundaries() const noexcept { return boundaries_.size(); }
  Distance distance(std::size_t boundary, const Vec3& tcp) const noexcept;
  /// The zone that a boundary belongs to, index into zones().
  std::size_t zone_of(std::size_t boundary) const noexcept { return boundaries_[boundary].zone; }

  struct Violation {
    std::string zone;
    double depth = 0;  ///< m beyond the boundary
    Vec3 tcp;          ///< where it is
    double at = 0;     ///< of a path: the parameter at which it leaves
  };
  /// Is the TCP where it may be, to `tolerance`? The deepest violation, if any.
  std::optional<Violation> check(const Vec3& tcp, double tolerance = 0) const;

 private:
  struct Boundary {
    std::size_t zone;
    bool box;  ///< the outside of one; else a plane
    Vec3 point, normal;
  };
  std::vector<WorkspaceZone> zones_;
  std::vector<Boundary> boundaries_;
};

/// The first place at which the TCP leaves the workspace while the joints move along `path`; empty if it does
/// not. What is outside at the beginning already may come back, and counts where it goes deeper. Looked for
/// in steps as long as distance and speed of the TCP allow, at least a 20000th of the path. Allocates little;
/// any thread.
std::optional<Workspace::Violation> first_violation(const Workspace& workspace,
                                                    const kinematics::Chain& chain, const paths::Path& path,
                                                    double tolerance = 1e-6);

/// A violation as an Error("workspace") for a person: `what` names the move, `share` is of its way.
Error leaves_workspace(const Workspace::Violation& found, const std::string& what, double share);
/// Throws that for the first violation of a path.
void check_workspace(const Workspace& workspace, const kinematics::Chain& chain, const paths::Path& path,
                     const std::string& what);

}  // namespace polyarm::moves
