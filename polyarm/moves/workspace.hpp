#pragma once
/// What the tool centre point (TCP) and the joints of a robot may do: where the TCP may be, how the tool may
/// be tilted, which values joints may have. Metres, radians, world axes.
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/paths/path.hpp"

namespace polyarm::moves {

/// plane: the TCP stays on the side that `normal` points to. inside, outside: of a box. cone: an axis of the
/// TCP stays around a direction. range: a joint stays between two values.
enum class ZoneKind { plane, inside, outside, cone, range };
/// The limits profile in which a zone counts.
enum class ZoneProfile { any, full, reduced };

struct WorkspaceZone {
  std::string name;
  Location where;  ///< in the file that defines it
  ZoneKind kind = ZoneKind::plane;
  Vec3 point, normal{0, 0, 1};  ///< of a plane; unit normal; of a cone, its direction
  Vec3 low, high;               ///< opposite corners of a box
  bool bodies = false;          ///< it is also of the bodies of the robot, which guards keep
  ZoneProfile profile = ZoneProfile::any;
  bool slows = false;           ///< beyond it the profile is reduced; it is no boundary of motion
  Vec3 axis{0, 0, 1};           ///< of a cone: the axis of the TCP, in the axes of the TCP; unit length
  double within = 0;            ///< of a cone: rad, the largest angle between them
  std::string joint;            ///< of a range
  int index = -1;               ///< of that joint in the robot
  double lower = 0, upper = 0;  ///< rad or m
};

/// Const after construction: any thread; only check() allocates.
class Workspace {
 public:
  /// The largest number of boundaries of one workspace: a plane, an outside box and a cone have one, a range
  /// has two, an inside box has six.
  static constexpr std::size_t kMostBoundaries = 64;

  Workspace() = default;
  /// Throws Error("bad-workspace") for an empty box or range, a zero normal or axis, a cone of no angle, or
  /// too many boundaries.
  explicit Workspace(std::vector<WorkspaceZone> zones);
  bool empty() const noexcept { return boundaries_.empty(); }
  const std::vector<WorkspaceZone>& zones() const noexcept { return zones_; }

  /// The signed distance from a boundary, positive on the permitted side: m; rad of a cone; of a range in the
  /// units of its joint. It grows with the velocity of the TCP along `away`, with its angular velocity along
  /// `turn`, and with that of the joint `joint` times `sign`.
  struct Distance {
    double distance = 0;
    Vec3 away, turn;
    int joint = -1;
    double sign = 0;
  };
  std::size_t boundaries() const noexcept { return boundaries_.size(); }
  Distance distance(std::size_t boundary, const Pose& tcp, std::span<const double> joints) const noexcept;
  /// The index into zones() of a boundary's zone.
  std::size_t zone_of(std::size_t boundary) const noexcept { return boundaries_[boundary].zone; }
  /// True if a boundary counts in the profile.
  bool counts(std::size_t boundary, bool reduced) const noexcept {
    const ZoneProfile of = zones_[boundaries_[boundary].zone].profile;
    return of == ZoneProfile::any || (of == ZoneProfile::reduced) == reduced;
  }
  /// What crosses a boundary there: "the TCP, at (0.1, 0, 0.2) m, crosses 'table'".
  std::string crossing(std::size_t boundary, const Pose& tcp, std::span<const double> joints) const;

  struct Violation {
    std::string zone;
    double depth = 0;      ///< beyond the boundary: m or rad
    Vec3 tcp;              ///< its position
    double at = 0;         ///< on a path: the parameter at which it leaves
    std::string crossing;  ///< on a path: as crossing()
  };
  /// Checks that the TCP and the joints are in the permitted region, to `tolerance`; returns the deepest
  /// violation, if any.
  std::optional<Violation> check(const Pose& tcp, std::span<const double> joints, bool reduced = false,
                                 double tolerance = 0) const;

 private:
  struct Boundary {
    std::size_t zone;
    Vec3 point, normal;  ///< of a plane
    double sign = 0;     ///< of a range: 1 above its lower end, -1 below its upper end
  };
  double of_box(const WorkspaceZone& zone, const Vec3& tcp, Vec3& away) const noexcept;
  std::vector<WorkspaceZone> zones_;
  std::vector<Boundary> boundaries_;
};

/// The first place at which the TCP leaves the workspace while the joints follow `path`; empty if it does not
/// leave. If the TCP is outside at the beginning, it may return; a violation is then a place where it goes
/// deeper. The step size depends on the distance and the speed of the TCP, and is at least a 20000th of the
/// path. `reduced`: in that profile. Allocates little; any thread.
std::optional<Workspace::Violation> first_violation(const Workspace& workspace,
                                                    const kinematics::Chain& chain, const paths::Path& path,
                                                    bool reduced = false, double tolerance = 1e-6);

/// A violation as Error("workspace"). `what` names the move, `share` is the fraction of its path.
Error leaves_workspace(const Workspace::Violation& found, const std::string& what, double share);
/// Throws that error for the first violation of a path.
void check_workspace(const Workspace& workspace, const kinematics::Chain& chain, const paths::Path& path,
                     const std::string& what);

}  // namespace polyarm::moves
