#include "polyarm/calibration/payload.hpp"

#include <fmt/format.h>

#include <numeric>

#include "polyarm/base/error.hpp"
#include "polyarm/calibration/fit.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/dynamics.hpp"

namespace polyarm::calibration {

namespace {
constexpr double kGravity = 9.81;

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d out;
  out << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return out;
}
/// `v` times a symmetric matrix of the six numbers ixx ixy ixz iyy iyz izz.
Eigen::Matrix<double, 3, 6> times(const Eigen::Vector3d& v) {
  Eigen::Matrix<double, 3, 6> out;
  out << v.x(), v.y(), v.z(), 0, 0, 0, 0, v.x(), 0, v.y(), v.z(), 0, 0, 0, v.x(), 0, v.y(), v.z();
  return out;
}

/// The wrench that a body needs (force, torque at the frame's origin, in the frame's axes) as a linear
/// function of its mass, mass times centre, and inertia about the origin. `pull`: acceleration minus gravity.
Matrix regressor(const Eigen::Vector3d& pull, const Eigen::Vector3d& w, const Eigen::Vector3d& dw,
                 bool inertia) {
  Matrix out = Matrix::Zero(6, inertia ? 10 : 4);
  out.block<3, 1>(0, 0) = pull;
  out.block<3, 3>(0, 1) = skew(dw) + skew(w) * skew(w);
  out.block<3, 3>(3, 1) = -skew(pull);
  if (inertia) out.block<3, 6>(3, 4) = times(dw) + skew(w) * times(w);
  return out;
}

/// Solves for the body and what else is unknown, and refuses what the samples do not determine.
struct Solved {
  Vector values, residual;
  Matrix covariance;
};
Solved solved(const Matrix& left, const Vector& right, Eigen::Index body, bool inertia) {
  constexpr double kWeakest = 1e-3;
  if (left.rows() <= left.cols())
    refuse(fmt::format("{} unknown numbers need more than {} measured values", left.cols(), left.rows()),
           "measure in ten or more orientations");
  Vector scale = left.colwise().norm();
  for (double& each : scale) each = each > 1e-9 ? each : 1;
  const Matrix scaled = left * scale.cwiseInverse().asDiagonal();
  const Eigen::JacobiSVD<Matrix> svd(scaled, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const double weakest = svd.singularValues()[left.cols() - 1];
  if (weakest < kWeakest * svd.singularValues()[0]) {
    const Vector direction = svd.matrixV().col(left.cols() - 1).cwiseAbs();
    Eigen::Index which = 0;
    direction.maxCoeff(&which);
    if (inertia && which >= 4 && which < body)
      refuse("the hand turns too slowly to show the inertia",
             "turn it quickly about three axes, or leave the inertia out");
    refuse(
        "the hand hardly changes its direction against gravity, so the payload cannot be told from the rest",
        "measure with the hand pointing down, to the side, and turned by 90 degrees about its own axis");
  }
  Solved out;
  out.values = scale.cwiseInverse().asDiagonal() * svd.solve(right);
  out.residual = left * out.values - right;
  const double variance = out.residual.squaredNorm() / static_cast<double>(left.rows() - left.cols());
  const Matrix half = svd.matrixV() * svd.singularValues().cwiseInverse().asDiagonal();
  out.covariance = scale.cwiseInverse().asDiagonal() * Matrix(variance * half * half.transpose()) *
                   scale.cwiseInverse().asDiagonal();
  return out;
}

Payload payload_of(const Solved& found, bool inertia) {
  Payload out;
  out.mass = found.values[0];
  out.mass_sigma = std::sqrt(std::max(0.0, found.covariance(0, 0)));
  if (!(out.mass > std::max(1e-3, 3 * out.mass_sigma)))
    refuse(fmt::format("the mass comes out as {:.3f} kg with an uncertainty of {:.3f} kg", out.mass,
                       out.mass_sigma),
           "check signs and units of the forces; a payload must weigh more than the noise of the sensor");
  const Eigen::Vector3d center = found.values.segment<3>(1) / out.mass;
  out.center = vec3(center);
  Matrix change = Matrix::Zero(3, 4);
  change.col(0) = -center / out.mass;
  change.rightCols<3>() = Eigen::Matrix3d::Identity() / out.mass;
  out.center_sigma = largest_sigma(change * found.covariance.topLeftCorner<4, 4>() * change.transpose());
  if (!inertia) return out;
  out.inertia_known = true;
  const double x = center.x(), y = center.y(), z = center.z(), m = out.mass;
  const double shift[6] = {m * (y * y + z * z), -m * x * y, -m * x * z,
                           m * (x * x + z * z), -m * y * z, m * (x * x + y * y)};
  for (Eigen::Index k = 0; k < 6; ++k) {
    out.inertia[static_cast<std::size_t>(k)] = found.values[4 + k] - shift[k];
    out.inertia_sigma = std::max(out.inertia_sigma, std::sqrt(std::max(0.0, found.covariance(4 + k, 4 + k))));
  }
  return out;
}

void add_residuals(Payload& out, const Vector& residual, Eigen::Index rows_of_one, Eigen::Index counted) {
  double sum = 0;
  for (Eigen::Index row = 0; row < residual.size(); row += rows_of_one) {
    out.residuals.push_back(residual.segment(row, counted).norm());
    sum += out.residuals.back() * out.residuals.back();
  }
  out.rms = std::sqrt(sum / std::max<double>(1, static_cast<double>(out.residuals.size())));
}
}  // namespace

namespace {
/// A linear problem of wrenches, and the weight of its torques against its forces.
struct WrenchFit {
  Solved found;
  double weight = 10;        ///< torques of wrist sensors are about ten times as exact as forces
  std::vector<double> each;  ///< weighted squares of the residuals, by sample
};

WrenchFit fit_wrenches(std::span<const WrenchSample> samples, const PayloadOptions& options,
                       std::optional<double> fixed_weight = {}) {
  const Eigen::Index body = options.inertia ? 10 : 4, all = body + (options.offsets ? 6 : 0);
  const auto n = static_cast<Eigen::Index>(samples.size());
  Matrix left = Matrix::Zero(6 * n, all);
  Vector right(6 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const WrenchSample& each = samples[static_cast<std::size_t>(i)];
    const Eigen::Vector3d up = eigen(inverse(each.rotation) * Vec3{0, 0, kGravity});
    // The sensor feels the reaction of what the body needs.
    left.block(6 * i, 0, 6, body) = -regressor(eigen(each.acceleration) + up, eigen(each.angular_velocity),
                                               eigen(each.angular_acceleration), options.inertia);
    if (options.offsets) left.block<6, 6>(6 * i, body).setIdentity();
    right.segment<3>(6 * i) = eigen(each.force);
    right.segment<3>(6 * i + 3) = eigen(each.torque);
  }
  WrenchFit out;
  if (fixed_weight) out.weight = *fixed_weight;
  // The residuals say how exact torques are against forces.
  for (int round = 0; round < (fixed_weight ? 1 : 3); ++round) {
    Vector rows = Vector::Ones(6 * n);
    for (Eigen::Index i = 0; i < n; ++i) rows.segment<3>(6 * i + 3).setConstant(out.weight);
    out.found = solved(rows.asDiagonal() * left, rows.cwiseProduct(right), body, options.inertia);
    const Vector off = left * out.found.values - right;
    double force = 0, torque = 0;
    out.each.clear();
    for (Eigen::Index i = 0; i < n; ++i) {
      const double f = off.segment<3>(6 * i).squaredNorm(), t = off.segment<3>(6 * i + 3).squaredNorm();
      out.each.push_back(f + out.weight * out.weight * t);
      force += f;
      torque += t;
    }
    if (n >= 6 && !fixed_weight)
      out.weight = std::clamp(std::sqrt(std::max(force, 1e-20) / std::max(torque, 1e-20)), 1.0, 100.0);
    out.found.residual = off;
  }
  return out;
}

/// The cost of a fit, or nothing if the samples do not determine it.
template <typename CostOf>
std::optional<double> cost_if_determined(const CostOf& cost_of) {
  try {
    return cost_of();
  } catch (const Error&) {
    return std::nullopt;
  }
}

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

std::vector<double> norms_about_mean(const std::vector<Vec3>& off) {
  Vec3 mean;
  for (const Vec3& each : off) mean = mean + (1.0 / static_cast<double>(off.size())) * each;
  std::vector<double> out;
  for (const Vec3& each : off) out.push_back(norm(each - mean));
  return out;
}
}  // namespace

Payload payload_from_wrenches(std::span<const WrenchSample> samples, const PayloadOptions& options) {
  const Eigen::Index body = options.inertia ? 10 : 4;
  const WrenchFit fit = fit_wrenches(samples, options);
  Payload out = payload_of(fit.found, options.inertia);
  if (options.offsets) {
    out.force_offset = vec3(fit.found.values.segment<3>(body));
    out.torque_offset = vec3(fit.found.values.segment<3>(body + 3));
  }
  add_residuals(out, fit.found.residual, 6, 3);
  const std::vector<WrenchSample> all(samples.begin(), samples.end());
  out.outlier = find_outlier(fit.each, 6, static_cast<double>(fit.found.values.size()), [&](std::size_t k) {
    return cost_if_determined([&] { return sum(fit_wrenches(without(all, k), options, fit.weight).each); });
  });
  return out;
}

namespace {
Solved fit_torques(const description::RobotModel& model, int tip, std::span<const TorqueSample> samples,
                   const PayloadOptions& options) {
  const kinematics::Chain chain(model, tip);
  const kinematics::Tree tree(model);
  kinematics::Dynamics dynamics(tree);
  const std::size_t joints = chain.joints();
  const auto rows = static_cast<Eigen::Index>(joints);
  const Eigen::Index body = options.inertia ? 10 : 4, all = body + (options.friction ? 2 * rows : 0);
  Matrix left = Matrix::Zero(rows * static_cast<Eigen::Index>(samples.size()), all);
  Vector right(left.rows());
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Rows J(6, rows), ahead(6, rows), behind(6, rows);
  Eigen::Index row = 0;
  for (const TorqueSample& each : samples) {
    for (const auto* list : {&each.q, &each.v, &each.a, &each.tau})
      if (list->size() != joints)
        refuse(fmt::format("a sample has {} values, the robot has {} joints", list->size(), joints),
               "give one value for each joint");
    const Eigen::Map<const Vector> q(each.q.data(), rows), v(each.v.data(), rows), a(each.a.data(), rows);
    constexpr double kStep = 1e-6;
    const auto jacobian = [&](const Vector& at, Rows& out) {
      return chain.jacobian(std::span(at.data(), joints), std::span(out.data(), 6 * joints));
    };
    jacobian(q + kStep * v, ahead);
    jacobian(q - kStep * v, behind);
    const Pose at = jacobian(q, J);
    const Vector twist = J * v, pull = J * a + (ahead - behind) / (2 * kStep) * v;
    const Eigen::Matrix3d into = matrix(at.rotation).transpose();
    const Matrix wrench = regressor(into * (pull.head<3>() + Eigen::Vector3d(0, 0, kGravity)),
                                    into * twist.tail<3>(), into * pull.tail<3>(), options.inertia);
    Matrix turned(6, body);
    turned << into.transpose() * wrench.topRows<3>(), into.transpose() * wrench.bottomRows<3>();
    left.block(row, 0, rows, body) = J.transpose() * turned;
    std::vector<double> own(joints);
    dynamics.inverse(each.q, each.v, each.a, own);
    for (Eigen::Index j = 0; j < rows; ++j) {
      const auto k = static_cast<std::size_t>(j);
      right[row + j] = each.tau[k] - own[k];
      if (!options.friction) continue;
      left(row + j, body + j) = each.v[k] > 1e-3 ? 1 : each.v[k] < -1e-3 ? -1 : 0;
      left(row + j, body + rows + j) = each.v[k];
    }
    row += rows;
  }
  return solved(left, right, body, options.inertia);
}

/// The sums of squares of the residuals, by sample.
std::vector<double> squares(const Vector& residual, Eigen::Index rows_of_one) {
  std::vector<double> out;
  for (Eigen::Index row = 0; row < residual.size(); row += rows_of_one)
    out.push_back(residual.segment(row, rows_of_one).squaredNorm());
  return out;
}
}  // namespace

Payload payload_from_torques(const description::RobotModel& model, int tip,
                             std::span<const TorqueSample> samples, const PayloadOptions& options) {
  const Solved found = fit_torques(model, tip, samples, options);
  const Eigen::Index rows = found.residual.size() / static_cast<Eigen::Index>(samples.size());
  Payload out = payload_of(found, options.inertia);
  add_residuals(out, found.residual, rows, rows);
  const std::vector<TorqueSample> all(samples.begin(), samples.end());
  out.outlier =
      find_outlier(squares(found.residual, rows), static_cast<double>(rows),
                   static_cast<double>(found.values.size()), [&](std::size_t k) {
                     return cost_if_determined([&] {
                       return fit_torques(model, tip, without(all, k), options).residual.squaredNorm();
                     });
                   });
  return out;
}

Payload without_part(Payload total, const KnownLoad& part, const std::string& name) {
  const double mass = total.mass - part.mass;
  if (part.mass == 0) return total;
  if (mass < std::max(0.01, 3 * total.mass_sigma))
    refuse(fmt::format("the hand carries {:.3f} kg with an uncertainty of {:.3f} kg, and {} has {:.3f} kg of "
                       "that: nothing is left for a payload",
                       total.mass, total.mass_sigma, name, part.mass),
           mass < -3 * total.mass_sigma ? "correct the mass of the tool" : "let the hand carry its load");
  total.center = (1 / mass) * (total.mass * total.center - part.mass * part.center);
  total.center_sigma *= total.mass / mass;
  total.mass = mass;
  return total;
}

std::vector<double> load_residuals(std::span<const WrenchSample> samples, const KnownLoad& load) {
  if (samples.size() < 2)
    refuse(fmt::format("the zero of the sensor is unknown: two poses or more are needed, here are {}",
                       samples.size()),
           "measure with the hand pointing in another direction, too");
  std::vector<Vec3> off;
  for (const WrenchSample& each : samples)
    off.push_back(each.force - inverse(each.rotation) * Vec3{0, 0, -load.mass * kGravity});
  return norms_about_mean(off);
}

std::vector<double> load_residuals(const description::RobotModel& model, int tip,
                                   std::span<const TorqueSample> samples, const KnownLoad& load) {
  description::RobotModel loaded = model;
  description::Link& hand = loaded.links[static_cast<std::size_t>(tip)];
  const description::Inertial own = hand.inertial.value_or(description::Inertial{});
  const double mass = own.mass + load.mass;
  hand.inertial = own;
  hand.inertial->mass = mass;
  if (mass > 0) hand.inertial->center = (1 / mass) * (own.mass * own.center + load.mass * load.center);
  const kinematics::Tree tree(loaded);
  kinematics::Dynamics dynamics(tree);
  std::vector<double> out;
  for (const TorqueSample& each : samples) {
    std::vector<double> needed(each.q.size());
    dynamics.inverse(each.q, each.v, each.a, needed);
    double square = 0;
    for (std::size_t j = 0; j < needed.size(); ++j)
      square += (each.tau[j] - needed[j]) * (each.tau[j] - needed[j]);
    out.push_back(std::sqrt(square));
  }
  return out;
}

}  // namespace polyarm::calibration
