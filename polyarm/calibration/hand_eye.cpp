#include "polyarm/calibration/hand_eye.hpp"

#include <fmt/format.h>

#include "polyarm/calibration/fit.hpp"
#include "polyarm/calibration/touch.hpp"

namespace polyarm::calibration {

namespace {

/// The common form of both cases, A_i Q = P M_i: on the hand, A is the base as the flange sees it.
struct Pair {
  Pose carrier, marker;  ///< A_i, M_i
};
using Pairs = std::vector<Pair>;

/// Camera and marker, each on its carrier.
struct Placed {
  Pose camera, marker;
};
Placed moved_by(const Placed& state, const Vector& step) {
  return {moved(state.camera, step.head<6>()), moved(state.marker, step.tail<6>())};
}

/// One standard deviation of the sightings.
struct Noise {
  double position = 1e-3, rotation = 2e-3;
};

Pairs pairs_of(std::span<const Sighting> sightings, CameraPlace place) {
  Pairs out;
  for (const Sighting& each : sightings)
    out.push_back({place == CameraPlace::on_hand ? inverse(each.flange) : each.flange, each.marker});
  return out;
}

/// Rotations between pairs of poses, of the carrier and of the marker: all pairs of up to 300 poses. Of more,
/// each pose with 300 others at most, because memory would grow with the square of their number.
struct Turns {
  std::vector<Eigen::Vector3d> carrier, marker;
};
Turns turns_of(const Pairs& pairs) {
  constexpr double kLargest = 3.0;  // rad: beyond it, noise may flip the rotation vector
  constexpr std::size_t kMost = 300;
  const std::size_t stride = (pairs.size() + kMost - 1) / kMost;
  Turns out;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (std::size_t j = (i / stride) % stride; j < i; j += stride) {
      const Eigen::Vector3d a =
          rotation_vector(pairs[i].carrier.rotation * inverse(pairs[j].carrier.rotation));
      const Eigen::Vector3d b = rotation_vector(pairs[i].marker.rotation * inverse(pairs[j].marker.rotation));
      if (a.norm() > kLargest || b.norm() > kLargest) continue;
      out.carrier.push_back(a);
      out.marker.push_back(b);
    }
  return out;
}

void require_turns(std::size_t count, const Turns& turns) {
  constexpr double kLeastTurn = 10 * M_PI / 180, kLeastSpread = 0.035;
  if (count < 3)
    refuse(fmt::format("a camera needs three sightings, here {} {}", count == 1 ? "is" : "are", count),
           "ten or more, each turned by 20 degrees or more against the others, give a good result");
  double largest = 0;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& turn : turns.carrier) {
    largest = std::max(largest, turn.norm());
    spread += turn * turn.transpose() / static_cast<double>(turns.carrier.size());
  }
  if (largest < kLeastTurn)
    refuse(
        fmt::format("the hand turned by {:.1f} degrees at most between the sightings", largest * 180 / M_PI),
        "turn it by 20 degrees and more, about two axes; moving it without turning does not help");
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> found(spread);
  if (std::sqrt(std::max(0.0, found.eigenvalues()[1])) < kLeastSpread) {
    const Eigen::Vector3d axis = found.eigenvectors().col(2);
    refuse(
        fmt::format(
            "all turns of the hand are about one axis, ({:.2f}, {:.2f}, {:.2f}); the camera may be anywhere "
            "along it",
            axis.x(), axis.y(), axis.z()),
        "add sightings that turn it by 20 degrees and more about another axis");
  }
}

/// Rotation from all motions, then both positions at once.
Placed closed_form(const Pairs& pairs, const Turns& turns) {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero(), R_marker = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < turns.carrier.size(); ++k) H += turns.carrier[k] * turns.marker[k].transpose();
  const Eigen::Matrix3d R = best_rotation(H);
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Matrix left(3 * n, 6);
  Vector right(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Pair& pair = pairs[static_cast<std::size_t>(i)];
    const Eigen::Matrix3d A = matrix(pair.carrier.rotation);
    R_marker += A.transpose() * R * matrix(pair.marker.rotation);
    left.block<3, 3>(3 * i, 0) = -Eigen::Matrix3d::Identity();
    left.block<3, 3>(3 * i, 3) = A;
    right.segment<3>(3 * i) = R * eigen(pair.marker.position) - eigen(pair.carrier.position);
  }
  const Vector found = left.colPivHouseholderQr().solve(right);
  return {{vec3(found.head<3>()), quaternion(R)},
          {vec3(found.tail<3>()), quaternion(best_rotation(R_marker))}};
}

/// The marker as predicted against the marker as seen, in the camera's axes: position and rotation.
Eigen::Matrix<double, 6, 1> difference(const Placed& state, const Pair& pair) {
  const Pose predicted = inverse(state.camera) * pair.carrier * state.marker;
  Eigen::Matrix<double, 6, 1> out;
  out.head<3>() = eigen(predicted.position - pair.marker.position);
  out.tail<3>() = rotation_vector(predicted.rotation * inverse(pair.marker.rotation));
  return out;
}

Fit refined(Placed& state, const Pairs& pairs, const Noise& noise) {
  const auto residual = [&](const Placed& at) {
    Vector out(6 * static_cast<Eigen::Index>(pairs.size()));
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto row = 6 * static_cast<Eigen::Index>(i);
      out.segment<6>(row) = difference(at, pairs[i]);
      out.segment<3>(row) /= noise.position;
      out.segment<3>(row + 3) /= noise.rotation;
    }
    return out;
  };
  return fit(state, 12, residual, moved_by);
}

/// The noise of both kinds from the residuals. Few samples say little of it, so that a ratio far from the
/// usual one is believed only with many.
Noise noise_of(const Placed& state, const Pairs& pairs) {
  constexpr double kUsual = 0.5, kLeast = 0.02, kMost = 20;  // m/rad
  constexpr double kPrior = 6;                               // samples that the usual ratio counts for
  double position = 0, rotation = 0;
  for (const Pair& pair : pairs) {
    const Eigen::Matrix<double, 6, 1> off = difference(state, pair);
    position += off.head<3>().squaredNorm();
    rotation += off.tail<3>().squaredNorm();
  }
  const auto n = static_cast<double>(pairs.size());
  const double seen = std::sqrt(std::max(position, 1e-24) / std::max(rotation, 1e-24));
  const double ratio =
      std::clamp(std::exp((n * std::log(seen) + kPrior * std::log(kUsual)) / (n + kPrior)), kLeast, kMost);
  // Each kind's own size; a ratio of zero noise is the usual one.
  const double freedom = std::max(1.0, 6 * n - 12);
  const double size = std::max(std::sqrt((position / (ratio * ratio) + rotation) / freedom), 1e-12);
  return {size * ratio, size};
}

Placed solved(const Pairs& pairs, const Turns& turns, Noise& noise, Fit& fit) {
  constexpr int kRounds = 4;
  Placed state = closed_form(pairs, turns);
  for (int round = 0; round < kRounds; ++round) {
    noise = noise_of(state, pairs);
    fit = refined(state, pairs, noise);
  }
  return state;
}

constexpr double kAngles[] = {20 * M_PI / 180, 40 * M_PI / 180};

/// Turns of the known poses about `place` (in the base).
std::vector<Pose> turned(std::span<const Pose> flanges, const std::function<Vec3(const Pose&)>& place) {
  std::vector<Pose> out;
  const std::size_t stride = std::max<std::size_t>(1, flanges.size() / 6);
  for (std::size_t k = 0; k < flanges.size(); k += stride)
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          for (const double angle : kAngles) {
            const Vec3 axis{double(x), double(y), double(z)};
            if (x == 0 && y == 0 && z == 0) continue;
            const Vec3 at = place(flanges[k]);
            const Quaternion by = from_axis_angle(normalized(axis), angle);
            out.push_back({at + by * (flanges[k].position - at), by * flanges[k].rotation});
          }
  return out;
}

double position_sigma(const Matrix& normal) {
  return largest_sigma(Eigen::Matrix3d(normal.inverse().topLeftCorner<3, 3>()));
}

/// The candidate with the best normal matrix. `rows`: the Jacobian's rows of a sample at a pose.
NextPose best_of(const std::vector<Pose>& candidates, const Matrix& normal, double sigma_of_rows,
                 const std::function<Matrix(const Pose&)>& rows) {
  NextPose out;
  out.sigma_now = sigma_of_rows * position_sigma(normal);
  double best = 1e300;
  for (const Pose& pose : candidates) {
    const Matrix more = rows(pose);
    const double then = position_sigma(normal + more.transpose() * more);
    if (then >= best) continue;
    best = then;
    out.flange = pose;
  }
  out.sigma_then = sigma_of_rows * best;
  return out;
}
}  // namespace

HandEye hand_eye(std::span<const Sighting> sightings, CameraPlace place) {
  const Pairs pairs = pairs_of(sightings, place);
  const Turns turns = turns_of(pairs);
  require_turns(pairs.size(), turns);
  Noise noise;
  Fit fit;
  const Placed state = solved(pairs, turns, noise, fit);
  const Matrix covariance = covariance_of(fit, variance_of(fit));
  HandEye out;
  out.camera = estimate(state.camera, covariance.topLeftCorner<6, 6>());
  out.marker = estimate(state.marker, covariance.bottomRightCorner<6, 6>());
  std::vector<Residual> each;
  std::vector<double> squares;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Matrix<double, 6, 1> off = difference(state, pairs[i]);
    each.push_back({off.head<3>().norm(), off.tail<3>().norm()});
    squares.push_back(fit.residual.segment<6>(6 * static_cast<Eigen::Index>(i)).squaredNorm());
  }
  const double scale = std::sqrt(variance_of(fit));
  out.position_noise = scale * noise.position;
  out.rotation_noise = scale * noise.rotation;
  out.residuals = summarised(std::move(each));
  out.residuals.outlier = find_outlier(squares, 6, 12, [&](std::size_t k) -> std::optional<double> {
    const Pairs rest = without(pairs, k);
    if (rest.size() < 3) return std::nullopt;
    Placed at = state;
    return refined(at, rest, noise).cost();
  });
  return out;
}

NextPose next_sighting(std::span<const Sighting> sightings, CameraPlace place, const HandEye& result) {
  const Placed state{result.camera.pose, result.marker.pose};
  const Noise noise{std::max(result.position_noise, 1e-9), std::max(result.rotation_noise, 1e-9)};
  const auto rows = [&](const Pose& flange) -> Matrix {
    Pair pair{place == CameraPlace::on_hand ? inverse(flange) : flange, {}};
    pair.marker = inverse(state.camera) * pair.carrier * state.marker;
    Placed at = state;
    return refined(at, {pair}, noise).jacobian;
  };
  std::vector<Pose> flanges;
  for (const Sighting& each : sightings) flanges.push_back(each.flange);
  Matrix normal = Matrix::Zero(12, 12);
  for (const Pose& each : flanges) {
    const Matrix some = rows(each);
    normal += some.transpose() * some;
  }
  const auto marker_at = [&](const Pose& flange) {
    return place == CameraPlace::on_hand ? result.marker.pose.position : flange * result.marker.pose.position;
  };
  return best_of(turned(flanges, marker_at), normal, 1, rows);
}

NextPose next_touch(std::span<const Pose> poses) {
  const TouchedTool tool = tool_from_poses(poses);
  const auto rows = [](const Pose& flange) -> Matrix {
    Matrix out(3, 6);
    out << matrix(flange.rotation), -Eigen::Matrix3d::Identity();
    return out;
  };
  Matrix normal = Matrix::Zero(6, 6);
  for (const Pose& each : poses) {
    const Matrix some = rows(each);
    normal += some.transpose() * some;
  }
  const double now = position_sigma(normal);
  return best_of(turned(poses, [&](const Pose&) { return tool.tip; }), normal, now > 0 ? tool.sigma / now : 0,
                 rows);
}

}  // namespace polyarm::calibration
