#include "polyarm/force/admittance_rule.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "polyarm/base/error.hpp"

namespace polyarm::controllers {

namespace {

Vec3 linear(const SixVector& v) noexcept {
  return {v[0], v[1], v[2]};
}
Vec3 angular(const SixVector& v) noexcept {
  return {v[3], v[4], v[5]};
}
SixVector six(const Vec3& l, const Vec3& a) noexcept {
  return {l.x, l.y, l.z, a.x, a.y, a.z};
}
SixVector rotated(const Quaternion& R, const SixVector& v) noexcept {
  return six(R * linear(v), R * angular(v));
}
bool is_finite(std::span<const double> values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace

AdmittanceRule::AdmittanceRule(const description::RobotModel& model, const AdmittanceFrames& frames,
                               std::vector<std::size_t> joints)
    : chain_(model, frames.sensor),
      frames_(frames),
      joints_(std::move(joints)),
      q_(chain_.joints(), 0.0),
      J_(6 * chain_.joints(), 0.0),
      poses_(chain_.links()),
      offset_(joints_.size(), 0.0),
      velocity_(joints_.size(), 0.0),
      acceleration_(joints_.size(), 0.0) {
  for (std::size_t i = 0; i < chain_.joints(); ++i)
    if (chain_.moves_tcp(i) && std::find(joints_.begin(), joints_.end(), i) == joints_.end())
      throw Error("bad-value", "the joint '" + chain_.names()[i] + "' moves the sensor and is not controlled",
                  "name it in joints");
  if (joints_.size() > kMost)
    throw Error("too-many-joints", "there are more than " + std::to_string(kMost) + " joints");
}

void AdmittanceRule::set(const AdmittanceParameters& parameters) noexcept {
  parameters_ = parameters;
  for (std::size_t i = 0; i < 6; ++i)
    damping_[i] = parameters.damping ? (*parameters.damping)[i]
                                     : parameters.damping_ratio[i] * 2 *
                                           std::sqrt(parameters.mass[i] * parameters.stiffness[i]);
}

SixVector AdmittanceRule::damping() const noexcept {
  return damping_;
}

void AdmittanceRule::reset() noexcept {
  freeze();
  std::fill(offset_.begin(), offset_.end(), 0.0);
  wrench_world_ = wrench_base_ = displacement_ = {};
}

void AdmittanceRule::freeze() noexcept {
  std::fill(velocity_.begin(), velocity_.end(), 0.0);
  std::fill(acceleration_.begin(), acceleration_.end(), 0.0);
  twist_ = twist_rate_ = {};
}

void AdmittanceRule::slow_down(double share, double dt) noexcept {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const double lost = (1 - share) * velocity_[i];
    velocity_[i] -= lost;
    offset_[i] -= lost * dt;
    acceleration_[i] -= lost / dt;
  }
  twist_ = cartesian(velocity_);
  twist_rate_ = cartesian(acceleration_);
}

void AdmittanceRule::bound(std::size_t i, double lower, double upper) noexcept {
  const double free = offset_[i];
  offset_[i] = std::min(std::max(free, lower), upper);
  if (offset_[i] != free) velocity_[i] = acceleration_[i] = 0;
}

void AdmittanceRule::place(std::span<const double> values) noexcept {
  for (std::size_t i = 0; i < joints_.size(); ++i) q_[joints_[i]] = values[i];
  chain_.link_poses(q_, poses_);
  R_root_base_ = poses_[static_cast<std::size_t>(frames_.base)].rotation;
}

Quaternion AdmittanceRule::rotation_in_base(int link) const noexcept {
  return inverse(R_root_base_) * poses_[static_cast<std::size_t>(link)].rotation;
}

/// The wrench of contacts: what the sensor measures without the weight behind it, smoothed in the world.
void AdmittanceRule::filter_wrench(const SixVector& wrench) noexcept {
  const Quaternion R_world_base = inverse(R_base_world_);
  const SixVector measured = rotated(R_world_base * R_base_sensor_, wrench);
  const Vec3 weight{0, 0, -parameters_.weight};
  const Vec3 arm = R_world_base * R_base_gravity_ * parameters_.cog;
  const SixVector contact = six(linear(measured) - weight, angular(measured) - cross(arm, weight));
  const double share = parameters_.filter;
  for (std::size_t i = 0; i < 6; ++i) wrench_world_[i] = share * contact[i] + (1 - share) * wrench_world_[i];
  wrench_base_ = rotated(R_base_world_, wrench_world_);
}

/// M a = F − D v − K x in the control frame; returns a in the base's frame.
SixVector AdmittanceRule::law() const noexcept {
  const Quaternion R = inverse(R_base_control_);
  const SixVector F = rotated(R, wrench_base_), v = rotated(R, twist_), x = rotated(R, displacement_);
  SixVector a;
  for (std::size_t i = 0; i < 6; ++i)
    a[i] = ((parameters_.axes[i] ? F[i] : 0) - damping_[i] * v[i] - parameters_.stiffness[i] * x[i]) /
           parameters_.mass[i];
  return rotated(R_base_control_, a);
}

/// Joint accelerations by the damped inverse (JᵀJ + alpha I)⁻¹ Jᵀ, less the damping of the joints.
bool AdmittanceRule::solve(const SixVector& wanted) noexcept {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;
  const auto n = static_cast<Eigen::Index>(joints_.size());
  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMost> J(6, n);
  for (Eigen::Index row = 0; row < 6; ++row)
    for (Eigen::Index i = 0; i < n; ++i)
      J(row, i) = J_[static_cast<std::size_t>(row) * chain_.joints() + joints_[static_cast<std::size_t>(i)]];
  const Eigen::Map<const Eigen::Matrix<double, 6, 1>> a(wanted.data());
  Matrix square = J.transpose() * J;
  square.diagonal().array() += parameters_.alpha;
  const Vector right = J.transpose() * a;
  const Eigen::LDLT<Matrix> solver(square);
  const Vector found = solver.solve(right);
  if (solver.info() != Eigen::Success || !found.allFinite()) return false;
  for (std::size_t i = 0; i < joints_.size(); ++i)
    acceleration_[i] = found[static_cast<Eigen::Index>(i)] - parameters_.joint_damping * velocity_[i];
  return true;
}

SixVector AdmittanceRule::cartesian(std::span<const double> values) const noexcept {
  SixVector out{};
  for (std::size_t row = 0; row < 6; ++row)
    for (std::size_t i = 0; i < joints_.size(); ++i)
      out[row] += J_[row * chain_.joints() + joints_[i]] * values[i];
  return rotated(inverse(R_root_base_), out);
}

void AdmittanceRule::integrate(double dt) noexcept {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    velocity_[i] += acceleration_[i] * dt;
    offset_[i] += velocity_[i] * dt;
  }
  twist_ = cartesian(velocity_);
  twist_rate_ = cartesian(acceleration_);
}

bool AdmittanceRule::update(std::span<const double> measured, std::span<const double> reference,
                            const SixVector& wrench, double dt) noexcept {
  if (!is_finite(measured) || !is_finite(reference) || !is_finite(wrench) || !(dt > 0)) return false;
  const auto sensor = static_cast<std::size_t>(frames_.sensor), base = static_cast<std::size_t>(frames_.base);
  place(reference);
  reference_pose_ = inverse(poses_[base]) * poses_[sensor];
  place(measured);
  const Pose there = inverse(poses_[base]) * poses_[sensor];
  R_base_sensor_ = there.rotation;
  R_base_world_ = rotation_in_base(frames_.world);
  R_base_control_ = rotation_in_base(frames_.control);
  R_base_gravity_ = rotation_in_base(frames_.gravity);
  chain_.jacobian(q_, J_);
  filter_wrench(wrench);
  displacement_ = six(there.position - reference_pose_.position,
                      to_rotation_vector(there.rotation * inverse(reference_pose_.rotation)));
  const SixVector a = law();
  if (!solve(rotated(R_root_base_, a))) {
    freeze();
    return false;
  }
  integrate(dt);
  return true;
}

}  // namespace polyarm::controllers
