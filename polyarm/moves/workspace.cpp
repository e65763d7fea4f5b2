#include "polyarm/moves/workspace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace polyarm::moves {

Workspace::Workspace(std::vector<WorkspaceZone> zones) : zones_(std::move(zones)) {
  const auto bad = [](const WorkspaceZone& zone, const std::string& what, const std::string& advice) {
    throw Error(Problem{"bad-workspace", zone.where, "the zone '" + zone.name + "' " + what, advice});
  };
  for (std::size_t i = 0; i < zones_.size(); ++i) {
    WorkspaceZone& zone = zones_[i];
    if (zone.kind == ZoneKind::plane) {
      if (!(norm(zone.normal) > 1e-9))
        bad(zone, "has a normal of length zero", "it points to where the TCP may be: [0, 0, 1] is up");
      zone.normal = normalized(zone.normal);
      boundaries_.push_back({i, false, zone.point, zone.normal});
      continue;
    }
    const Vec3 size = zone.high - zone.low;
    if (!(size.x > 0 && size.y > 0 && size.z > 0))
      bad(zone, "is a box without room",
          "every value of its first corner must be less than that of its second");
    if (zone.kind == ZoneKind::outside) {
      boundaries_.push_back({i, true, {}, {}});
      continue;
    }
    for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      boundaries_.push_back({i, false, zone.low, axis});
      boundaries_.push_back({i, false, zone.high, -axis});
    }
  }
  if (boundaries_.size() > kMostBoundaries)
    throw Error(
        "bad-workspace",
        fmt::format("the workspace has {} boundaries, {} are possible", boundaries_.size(), kMostBoundaries),
        "a plane and a box to stay out of are one each, a box to stay in is six");
}

Workspace::Distance Workspace::distance(std::size_t i, const Vec3& tcp) const noexcept {
  const Boundary& boundary = boundaries_[i];
  if (!boundary.box) return {dot(boundary.normal, tcp - boundary.point), boundary.normal};
  const WorkspaceZone& zone = zones_[boundary.zone];
  const std::array<double, 3> p{tcp.x, tcp.y, tcp.z}, low{zone.low.x, zone.low.y, zone.low.z},
      high{zone.high.x, zone.high.y, zone.high.z};
  std::array<double, 3> out{}, face{};
  double squared = 0, nearest = -1e300;
  std::size_t axis = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double beyond = std::max(low[k] - p[k], p[k] - high[k]);  // for this pair of faces
    const double side = p[k] < (low[k] + high[k]) / 2 ? -1 : 1;
    out[k] = side * std::max(beyond, 0.0);
    squared += out[k] * out[k];
    if (beyond > nearest) {
      nearest = beyond;
      axis = k;
      face = {};
      face[axis] = side;
    }
  }
  if (nearest <= 0) return {nearest, {face[0], face[1], face[2]}};
  const double distance = std::sqrt(squared);
  return {distance, (1 / distance) * Vec3{out[0], out[1], out[2]}};
}

std::optional<Workspace::Violation> Workspace::check(const Vec3& tcp, double tolerance) const {
  std::optional<Violation> out;
  for (std::size_t i = 0; i < boundaries_.size(); ++i) {
    const double d = distance(i, tcp).distance;
    if (d >= -tolerance || (out && -d <= out->depth)) continue;
    out = Violation{zones_[boundaries_[i].zone].name, -d, tcp, 0};
  }
  return out;
}

namespace {

/// The TCP along a path of the joints.
class Along {
 public:
  Along(const Workspace& workspace, const kinematics::Chain& chain, const paths::Path& path)
      : workspace_(workspace), chain_(chain), path_(path), q_(path.joints()) {
    allowed_.reserve(workspace.boundaries());
    const Vec3 start = tcp(0);
    for (std::size_t i = 0; i < workspace.boundaries(); ++i)
      allowed_.push_back(std::min(0.0, workspace.distance(i, start).distance));
  }
  Vec3 tcp(double s) {
    path_.at(s, {q_, {}, {}, {}});
    return chain_.forward(q_).position;
  }
  /// The distance of the TCP from the nearest boundary, and that boundary.
  std::pair<double, std::size_t> clearance(const Vec3& tcp) const {
    std::pair<double, std::size_t> out{1e300, 0};
    for (std::size_t i = 0; i < allowed_.size(); ++i)
      out = std::min(out, {workspace_.distance(i, tcp).distance - allowed_[i], i});
    return out;
  }
  double length() const { return path_.length(); }

 private:
  const Workspace& workspace_;
  const kinematics::Chain& chain_;
  const paths::Path& path_;
  std::vector<double> q_;
  std::vector<double> allowed_;
};

}  // namespace

std::optional<Workspace::Violation> first_violation(const Workspace& workspace,
                                                    const kinematics::Chain& chain, const paths::Path& path,
                                                    double tolerance) {
  if (workspace.empty()) return std::nullopt;
  Along along(workspace, chain, path);
  const double shortest = along.length() / 20000;
  double s = 0;
  Vec3 at = along.tcp(0);
  for (double step = along.length() / 2000; s < along.length();) {
    double next = std::min(s + std::max(step, shortest), along.length());
    Vec3 there = along.tcp(next);
    if (along.clearance(there).first < -tolerance) {
      double inside = s;
      for (int i = 0; i < 50; ++i) {
        const double middle = (inside + next) / 2;
        (along.clearance(along.tcp(middle)).first < -tolerance ? next : inside) = middle;
      }
      there = along.tcp(next);
      const auto [clearance, boundary] = along.clearance(there);
      return Workspace::Violation{workspace.zones()[workspace.zone_of(boundary)].name,
                                  -workspace.distance(boundary, there).distance, there, next};
    }
    // Advances by the distance over which the TCP, at twice its present speed, reaches the boundary.
    const double speed = std::max(norm(there - at) / (next - s), 1e-9);
    step = std::min(std::max(along.clearance(there).first, 0.0) / (2 * speed), along.length() / 200);
    s = next;
    at = there;
  }
  return std::nullopt;
}

Error leaves_workspace(const Workspace::Violation& found, const std::string& what, double share) {
  return Error("workspace",
               fmt::format("{} leaves the workspace: after {:.1f} % of the way the TCP, at ({:.4f}, "
                           "{:.4f}, {:.4f}) m, crosses '{}'",
                           what, 100 * share, found.tcp.x, found.tcp.y, found.tcp.z, found.zone),
               "move the points, or change 'workspace' in the cell file");
}

void check_workspace(const Workspace& workspace, const kinematics::Chain& chain, const paths::Path& path,
                     const std::string& what) {
  if (const auto found = first_violation(workspace, chain, path))
    throw leaves_workspace(*found, what, path.length() > 0 ? found->at / path.length() : 0);
}

}  // namespace polyarm::moves
