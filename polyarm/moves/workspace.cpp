#include "polyarm/moves/workspace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace polyarm::moves {

namespace {
constexpr double kDegree = M_PI / 180;
/// A cone narrower than this leaves no room to stop before its border.
constexpr double kLeastCone = 0.5 * kDegree;
}  // namespace

Workspace::Workspace(std::vector<WorkspaceZone> zones) : zones_(std::move(zones)) {
  const auto bad = [](const WorkspaceZone& zone, const std::string& what, const std::string& advice) {
    throw Error(Problem{"bad-workspace", zone.where, "the zone '" + zone.name + "' " + what, advice});
  };
  for (std::size_t i = 0; i < zones_.size(); ++i) {
    WorkspaceZone& zone = zones_[i];
    if (zone.kind == ZoneKind::plane || zone.kind == ZoneKind::cone) {
      const bool is_cone = zone.kind == ZoneKind::cone;
      if (!(norm(zone.normal) > 1e-9))
        bad(zone, is_cone ? "has a direction of length zero" : "has a normal of length zero",
            is_cone ? "[0, 0, -1] is down" : "it points to where the TCP may be: [0, 0, 1] is up");
      if (!(norm(zone.axis) > 1e-9)) bad(zone, "has an axis of length zero", "z, or -x, y, …");
      zone.normal = normalized(zone.normal);
      zone.axis = normalized(zone.axis);
      if (is_cone && !(zone.within >= kLeastCone && zone.within < M_PI))
        bad(zone, fmt::format("has an angle of {:.4g} degrees", zone.within / kDegree),
            "an angle from 0.5 to 180 degrees, such as 15deg");
      boundaries_.push_back({i, zone.point, zone.normal});
      continue;
    }
    if (zone.kind == ZoneKind::range) {
      if (!(zone.lower < zone.upper)) bad(zone, "is a range without values", "the lower end comes first");
      boundaries_.push_back({i, {}, {}, 1});
      boundaries_.push_back({i, {}, {}, -1});
      continue;
    }
    const Vec3 size = zone.high - zone.low;
    if (!(size.x > 0 && size.y > 0 && size.z > 0))
      bad(zone, "is a box without room",
          "every value of its first corner must be less than that of its second");
    if (zone.kind == ZoneKind::outside) {
      boundaries_.push_back({i, {}, {}});
      continue;
    }
    for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      boundaries_.push_back({i, zone.low, axis});
      boundaries_.push_back({i, zone.high, -axis});
    }
  }
  if (boundaries_.size() > kMostBoundaries)
    throw Error(
        "bad-workspace",
        fmt::format("the workspace has {} boundaries, {} are possible", boundaries_.size(), kMostBoundaries),
        "a plane, a cone and a box to stay out of are one each, a range is two, a box to stay in is six");
}

namespace {
/// How far the axis of a tool is from the border of a cone, and the turn that brings it farther away.
Workspace::Distance of_cone(const WorkspaceZone& zone, const Quaternion& tcp) noexcept {
  const Vec3 axis = tcp * zone.axis, across = cross(axis, zone.normal);
  const double sine = norm(across);
  Workspace::Distance out;
  out.distance = zone.within - std::atan2(sine, dot(axis, zone.normal));
  if (sine > 1e-9) {
    out.turn = (1 / sine) * across;
  } else if (dot(axis, zone.normal) < 0) {  // it looks the other way: any turn across brings it back
    out.turn = normalized(cross(axis, std::abs(axis.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  }
  return out;
}
}  // namespace

Workspace::Distance Workspace::distance(std::size_t i, const Pose& tcp,
                                        std::span<const double> joints) const noexcept {
  const Boundary& boundary = boundaries_[i];
  const WorkspaceZone& zone = zones_[boundary.zone];
  Distance out;
  switch (zone.kind) {
    case ZoneKind::cone:
      return of_cone(zone, tcp.rotation);
    case ZoneKind::range: {
      const bool known = zone.index >= 0 && static_cast<std::size_t>(zone.index) < joints.size();
      const double at = known ? joints[static_cast<std::size_t>(zone.index)] : (zone.lower + zone.upper) / 2;
      out.distance = boundary.sign > 0 ? at - zone.lower : zone.upper - at;
      out.joint = known ? zone.index : -1;
      out.sign = known ? boundary.sign : 0;
      return out;
    }
    case ZoneKind::outside:
      out.distance = of_box(zone, tcp.position, out.away);
      return out;
    default:
      out.distance = dot(boundary.normal, tcp.position - boundary.point);
      out.away = boundary.normal;
      return out;
  }
}

double Workspace::of_box(const WorkspaceZone& zone, const Vec3& tcp, Vec3& away) const noexcept {
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
  if (nearest <= 0) {
    away = {face[0], face[1], face[2]};
    return nearest;
  }
  const double distance = std::sqrt(squared);
  away = (1 / distance) * Vec3{out[0], out[1], out[2]};
  return distance;
}

std::string Workspace::crossing(std::size_t i, const Pose& tcp, std::span<const double> joints) const {
  const WorkspaceZone& zone = zones_[boundaries_[i].zone];
  if (zone.kind == ZoneKind::cone)
    return fmt::format(
        "the tool, {:.1f} degrees from its direction, leaves '{}', {:.1f} degrees are permitted",
        (zone.within - distance(i, tcp, joints).distance) / kDegree, zone.name, zone.within / kDegree);
  if (zone.kind == ZoneKind::range)
    return fmt::format("{}, at {:.4f}, leaves '{}', {:.4f} to {:.4f}", zone.joint,
                       joints[static_cast<std::size_t>(zone.index)], zone.name, zone.lower, zone.upper);
  return fmt::format("the TCP, at ({:.4f}, {:.4f}, {:.4f}) m, crosses '{}'", tcp.position.x, tcp.position.y,
                     tcp.position.z, zone.name);
}

std::optional<Workspace::Violation> Workspace::check(const Pose& tcp, std::span<const double> joints,
                                                     bool reduced, double tolerance) const {
  std::optional<Violation> out;
  for (std::size_t i = 0; i < boundaries_.size(); ++i) {
    if (!counts(i, reduced)) continue;
    const double d = distance(i, tcp, joints).distance;
    if (d >= -tolerance || (out && -d <= out->depth)) continue;
    out = Violation{zones_[boundaries_[i].zone].name, -d, tcp.position, 0, crossing(i, tcp, joints)};
  }
  return out;
}

namespace {

/// The TCP along a path of the joints.
class Along {
 public:
  Along(const Workspace& workspace, const kinematics::Chain& chain, const paths::Path& path, bool reduced)
      : workspace_(workspace), chain_(chain), path_(path), q_(path.joints()) {
    const Pose start = go(0);
    for (std::size_t i = 0; i < workspace.boundaries(); ++i)
      if (workspace.counts(i, reduced)) counted_.push_back({i, 0, 0});
    for (Counted& of : counted_)
      of.now = workspace_.distance(of.boundary, start, q_).distance, of.allowed = std::min(0.0, of.now);
  }
  const std::vector<double>& joints() const { return q_; }
  Pose go(double s) {
    path_.at(s, {q_, {}, {}, {}});
    return chain_.forward(q_);
  }
  bool empty() const { return counted_.empty(); }
  /// What is left to the nearest boundary, with the joints where go() has put them, and that boundary.
  std::pair<double, std::size_t> clearance(const Pose& tcp) const {
    std::pair<double, std::size_t> out{1e300, 0};
    for (const Counted& of : counted_)
      out = std::min(out, {workspace_.distance(of.boundary, tcp, q_).distance - of.allowed, of.boundary});
    return out;
  }
  /// A step that reaches no boundary at twice the speeds of the last step, which was `ds` long and moved the
  /// TCP from `from` to `to`; at most `most`.
  double free_step(const Pose& from, const Pose& to, double ds, double most) {
    const double speed = std::max(norm(to.position - from.position) / ds, 1e-9);
    const double turning = std::max(angle_between(from.rotation, to.rotation) / ds, 1e-9);
    double out = most;
    for (Counted& of : counted_) {
      const double before = of.now;
      of.now = workspace_.distance(of.boundary, to, q_).distance;
      const ZoneKind kind = workspace_.zones()[workspace_.zone_of(of.boundary)].kind;
      double rate = kind == ZoneKind::cone ? turning : speed;
      if (kind == ZoneKind::range) rate = std::max(std::abs(of.now - before) / ds, 1e-9);
      out = std::min(out, std::max(of.now - of.allowed, 0.0) / (2 * rate));
    }
    return out;
  }
  double length() const { return path_.length(); }

 private:
  struct Counted {
    std::size_t boundary;
    double allowed, now;
  };
  const Workspace& workspace_;
  const kinematics::Chain& chain_;
  const paths::Path& path_;
  std::vector<double> q_;
  std::vector<Counted> counted_;
};

}  // namespace

std::optional<Workspace::Violation> first_violation(const Workspace& workspace,
                                                    const kinematics::Chain& chain, const paths::Path& path,
                                                    bool reduced, double tolerance) {
  if (workspace.empty()) return std::nullopt;
  Along along(workspace, chain, path, reduced);
  if (along.empty()) return std::nullopt;
  const double shortest = along.length() / 20000;
  double s = 0;
  Pose at = along.go(0);
  for (double step = along.length() / 2000; s < along.length();) {
    double next = std::min(s + std::max(step, shortest), along.length());
    Pose there = along.go(next);
    if (along.clearance(there).first < -tolerance) {
      double inside = s;
      for (int i = 0; i < 50; ++i) {
        const double middle = (inside + next) / 2;
        (along.clearance(along.go(middle)).first < -tolerance ? next : inside) = middle;
      }
      there = along.go(next);
      const std::size_t boundary = along.clearance(there).second;
      return Workspace::Violation{workspace.zones()[workspace.zone_of(boundary)].name,
                                  -workspace.distance(boundary, there, along.joints()).distance,
                                  there.position, next, workspace.crossing(boundary, there, along.joints())};
    }
    step = along.free_step(at, there, next - s, along.length() / 200);
    s = next;
    at = there;
  }
  return std::nullopt;
}

Error leaves_workspace(const Workspace::Violation& found, const std::string& what, double share) {
  return Error(
      "workspace",
      fmt::format("{} leaves the workspace: after {:.1f} % of the way {}", what, 100 * share, found.crossing),
      "move the points, or change 'workspace' in the cell file");
}

void check_workspace(const Workspace& workspace, const kinematics::Chain& chain, const paths::Path& path,
                     const std::string& what) {
  if (const auto found = first_violation(workspace, chain, path))
    throw leaves_workspace(*found, what, path.length() > 0 ? found->at / path.length() : 0);
}

}  // namespace polyarm::moves
