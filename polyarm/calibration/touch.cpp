#include "polyarm/calibration/touch.hpp"

#include <fmt/format.h>

#include "polyarm/calibration/fit.hpp"

namespace polyarm::calibration {

namespace {
constexpr double kNearest = 1e-3;  // m, between places

Quaternion from_axes(const Vec3& x, const Vec3& y, const Vec3& z) {
  Eigen::Matrix3d r;
  r << eigen(x), eigen(y), eigen(z);
  return quaternion(r);
}

std::string shown(const Eigen::Vector3d& axis) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", axis.x() + 0.0, axis.y() + 0.0, axis.z() + 0.0);
}

Eigen::Vector3d mean(std::span<const Vec3> places) {
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  for (const Vec3& each : places) out += eigen(each);
  return out / static_cast<double>(places.size());
}

/// Refuses places on one line.
void require_plane(std::span<const Vec3> places) {
  const Eigen::Vector3d middle = mean(places);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3& each : places) spread += (eigen(each) - middle) * (eigen(each) - middle).transpose();
  const Eigen::Vector3d sizes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread / static_cast<double>(places.size()))
          .eigenvalues();
  if (std::sqrt(std::max(0.0, sizes[2])) < kNearest)
    refuse("all places are within a few millimetres", "touch places that lie far from each other");
  if (sizes[1] < 1e-4 * sizes[2])
    refuse("all places lie on one line, so the frame could turn about it",
           "touch one that is to the side of the line");
}

Pose matched(std::span<const Vec3> known, std::span<const Vec3> measured) {
  const Eigen::Vector3d from = mean(known), to = mean(measured);
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < known.size(); ++i)
    H += (eigen(measured[i]) - to) * (eigen(known[i]) - from).transpose();
  const Eigen::Matrix3d R = best_rotation(H);
  return {vec3(to - R * from), quaternion(R)};
}

double cost(const Pose& frame, std::span<const Vec3> known, std::span<const Vec3> measured) {
  double out = 0;
  for (std::size_t i = 0; i < known.size(); ++i) {
    const Vec3 off = frame * known[i] - measured[i];
    out += dot(off, off);
  }
  return out;
}

/// A tip at one place: the solution of the linear problem, and its residuals.
struct Tip {
  Vec3 tcp, place;
  Fit fit;
};
Tip touched_tip(std::span<const Pose> poses) {
  const auto n = static_cast<Eigen::Index>(poses.size());
  Tip out;
  out.fit.jacobian.resize(3 * n, 6);
  Vector right(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Pose& pose = poses[static_cast<std::size_t>(i)];
    out.fit.jacobian.block<3, 3>(3 * i, 0) = matrix(pose.rotation);
    out.fit.jacobian.block<3, 3>(3 * i, 3) = -Eigen::Matrix3d::Identity();
    right.segment<3>(3 * i) = -eigen(pose.position);
  }
  const Vector found = out.fit.jacobian.colPivHouseholderQr().solve(right);
  out.fit.residual = out.fit.jacobian * found - right;
  out.tcp = vec3(found.head<3>());
  out.place = vec3(found.tail<3>());
  return out;
}

/// Refuses poses that turn about one axis only, or hardly at all.
void require_turns(std::span<const Pose> poses) {
  constexpr double kLeast = 0.03;  // root mean square of the change of a direction
  Eigen::Matrix3d middle = Eigen::Matrix3d::Zero(), spread = Eigen::Matrix3d::Zero();
  for (const Pose& pose : poses) middle += matrix(pose.rotation) / static_cast<double>(poses.size());
  for (const Pose& pose : poses) {
    const Eigen::Matrix3d off = matrix(pose.rotation) - middle;
    spread += off.transpose() * off / static_cast<double>(poses.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> found(spread);
  if (std::sqrt(std::max(0.0, found.eigenvalues()[1])) < kLeast)
    refuse("the poses hardly differ in orientation, so they do not determine the tip",
           "turn the tool by 30 degrees and more about two axes between them");
  if (std::sqrt(std::max(0.0, found.eigenvalues()[0])) < kLeast)
    refuse("all poses turn the tool about one axis, " + shown(found.eigenvectors().col(0)) +
               " in tool0; the tip may be anywhere along it",
           "add poses that turn it by 30 degrees and more about another axis");
}
}  // namespace

Pose frame_from_points(const Vec3& origin, const Vec3& on_x, const Vec3& in_plane) {
  constexpr double kFlattest = 0.01;
  const Vec3 along = on_x - origin, aside = in_plane - origin;
  if (norm(along) < kNearest || norm(aside) < kNearest)
    refuse("two of the three points are less than 1 mm apart", "take points that lie far from each other");
  const Vec3 x = normalized(along), up = cross(x, normalized(aside));
  if (norm(up) < kFlattest)
    refuse("the three points lie on a line",
           "the third is to be to the side of the line through the other two");
  const Vec3 z = normalized(up);
  return {origin, from_axes(x, cross(z, x), z)};
}

MatchedFrame frame_from_matches(std::span<const Vec3> known, std::span<const Vec3> measured) {
  if (known.size() != measured.size() || known.size() < 3)
    refuse(fmt::format("a frame needs three places, here are {}", std::min(known.size(), measured.size())),
           "touch three or more places with known coordinates");
  require_plane(known);
  require_plane(measured);
  const std::vector<Vec3> from(known.begin(), known.end()), to(measured.begin(), measured.end());
  const Pose found = matched(from, to);
  const auto n = static_cast<Eigen::Index>(known.size());
  Fit at;
  at.jacobian.resize(3 * n, 6);
  at.residual.resize(3 * n);
  std::vector<double> squares;
  std::vector<Residual> each;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::Vector3d arm = eigen(found.rotation * known[k]), off = eigen(found * known[k] - measured[k]);
    at.jacobian.block<3, 3>(3 * i, 0).setIdentity();
    at.jacobian.block<3, 3>(3 * i, 3) << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
    at.residual.segment<3>(3 * i) = off;
    squares.push_back(off.squaredNorm());
    each.push_back({off.norm(), 0});
  }
  MatchedFrame out{estimate(found, covariance_of(at, variance_of(at))), summarised(std::move(each))};
  out.residuals.outlier = find_outlier(squares, 3, 6, [&](std::size_t k) -> std::optional<double> {
    const std::vector<Vec3> a = without(from, k), b = without(to, k);
    return cost(matched(a, b), a, b);
  });
  return out;
}

TouchedTool tool_from_poses(std::span<const Pose> poses) {
  if (poses.size() < 4)
    refuse(fmt::format("a tool needs four poses, here are {}", poses.size()),
           "touch one point with its tip from four directions");
  require_turns(poses);
  const Tip tip = touched_tip(poses);
  TouchedTool out;
  out.tcp = tip.tcp;
  out.tip = tip.place;
  const Eigen::Matrix3d covariance = covariance_of(tip.fit, variance_of(tip.fit)).topLeftCorner<3, 3>();
  for (Eigen::Index i = 0; i < 9; ++i) out.covariance[static_cast<std::size_t>(i)] = covariance(i / 3, i % 3);
  out.sigma = largest_sigma(covariance);
  std::vector<double> squares;
  std::vector<Residual> each;
  for (const Pose& pose : poses) {
    each.push_back({norm(pose * out.tcp - out.tip), 0});
    squares.push_back(each.back().position * each.back().position);
  }
  out.residuals = summarised(std::move(each));
  const std::vector<Pose> all(poses.begin(), poses.end());
  out.residuals.outlier = find_outlier(squares, 3, 6, [&](std::size_t k) -> std::optional<double> {
    return touched_tip(without(all, k)).fit.cost();
  });
  return out;
}

Quaternion tool_rotation(const Vec3& tcp, const Vec3& tip, const Pose& on_z, const Pose& on_x) {
  // The place of the tip as the moved tool sees it.
  const Vec3 along_z = inverse(on_z) * tip - tcp, along_x = inverse(on_x) * tip - tcp;
  constexpr double kShortest = 0.01;
  if (norm(along_z) < kShortest || norm(along_x) < kShortest)
    refuse("the tool moved by less than 10 mm along an axis",
           "move it by 100 mm or more along z, and along x");
  const Vec3 z = normalized(along_z), y = cross(z, normalized(along_x));
  if (norm(y) < 0.1)
    refuse("the tool moved along one line both times",
           "move it along its z axis first, then along its x axis");
  return from_axes(cross(normalized(y), z), normalized(y), z);
}

FlatTool axis_from_flat_poses(std::span<const Pose> poses, const Vec3& outwards) {
  if (poses.size() < 2)
    refuse(fmt::format("a flat face needs two poses, here are {}", poses.size()),
           "lay it on the plane, turn it about the plane's normal, and lay it down again");
  const auto n = static_cast<double>(poses.size());
  Eigen::Matrix3d middle = Eigen::Matrix3d::Zero();
  for (const Pose& pose : poses) middle += matrix(pose.rotation) / n;
  // The direction that all rotations map to the same one is the axis.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(middle, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double gap = svd.singularValues()[0] - svd.singularValues()[1];
  if (gap < 0.03)
    refuse("the tool hardly turned on the plane, so any axis fits",
           "turn it by 60 degrees and more about the plane's normal between the poses");
  Eigen::Vector3d axis = svd.matrixV().col(0), normal = svd.matrixU().col(0);
  if (axis.dot(eigen(outwards)) < 0) {
    axis = -axis;
    normal = -normal;
  }
  FlatTool out{vec3(axis), vec3(normal), 0, {}};
  std::vector<Residual> each;
  double squares = 0;
  for (const Pose& pose : poses) {
    const double off = std::acos(std::clamp((matrix(pose.rotation) * axis).dot(normal), -1.0, 1.0));
    squares += off * off;
    each.push_back({0, off});
  }
  out.residuals = summarised(std::move(each));
  const double freedom = 2 * n - 4;
  out.sigma = freedom > 0 ? std::sqrt(squares / freedom / (n * 2 * gap)) : 0;
  return out;
}

Quaternion rotation_with_z(const Vec3& axis) {
  const Vec3 z = normalized(axis), x{1, 0, 0};
  const Vec3 aside = x - dot(x, z) * z;
  const Vec3 along = norm(aside) > 1e-3 ? normalized(aside) : normalized(Vec3{0, 1, 0} - z.y * z);
  return from_axes(along, cross(z, along), z);
}

}  // namespace polyarm::calibration
