#pragma once
/// The equation of admittance control: a force at a sensor moves a virtual mass on a damper and a spring, and
/// the motion becomes offsets of joints. The equations are those of ros2_control's admittance_controller. SI
/// units; six-vectors are linear x y z, then angular.
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "polyarm/kinematics/chain.hpp"

namespace polyarm::controllers {

using SixVector = std::array<double, 6>;

struct AdmittanceParameters {
  std::array<bool, 6> axes{};  ///< which axes of the control frame comply
  SixVector mass{1, 1, 1, 1, 1, 1}, damping_ratio{1, 1, 1, 1, 1, 1}, stiffness{};
  std::optional<SixVector> damping;  ///< N s/m, N m s/rad, instead of that of the ratios
  double joint_damping = 5;          ///< 1/s
  double filter = 0.05;      ///< share of the newest wrench; 1: no filter
  double weight = 0;         ///< N, of everything behind the sensor
  Vec3 cog;                  ///< m, its centre in the frame `gravity`
  double alpha = 0.01;       ///< damping of the inverse of the Jacobian
};

/// Links of the model. Wrenches are measured in `sensor`, and its pose is what complies. Mass, stiffness and
/// axes count in `control`, results in `base`. Gravity is along −z of `world`.
struct AdmittanceFrames {
  int sensor = 0, base = 0, control = 0, world = 0, gravity = 0;
};

/// Everything but the constructor and set() is real-time, on one thread.
class AdmittanceRule {
 public:
  /// `joints`: places of the controlled joints in RobotModel::actuated. Throws Error("bad-value") if another
  /// joint moves the sensor, and what Chain throws.
  AdmittanceRule(const description::RobotModel& model, const AdmittanceFrames& frames,
                 std::vector<std::size_t> joints);

  void set(const AdmittanceParameters& parameters) noexcept;
  void set_joint_damping(double damping) noexcept { parameters_.joint_damping = damping; }
  void set_filter(double filter) noexcept { parameters_.filter = filter; }
  void set_weight(double weight) noexcept { parameters_.weight = weight; }

  /// Forgets offsets, velocities and the filtered wrench.
  void reset() noexcept;
  /// Stands still and keeps its offsets.
  void freeze() noexcept;
  /// One step of `dt` seconds: joint positions as measured and as they would be without the offset, and the
  /// wrench that the sensor measures. False if a result is not finite; then nothing moves.
  bool update(std::span<const double> measured, std::span<const double> reference, const SixVector& wrench,
              double dt) noexcept;
  /// Leaves this share, 0 to 1, of the last step of `dt` seconds: of its velocities and of its motion.
  void slow_down(double share, double dt) noexcept;
  /// Bounds offset `i`; at a bound it has no velocity.
  void bound(std::size_t i, double lower, double upper) noexcept;

  std::span<const double> offset() const noexcept { return offset_; }      ///< rad or m
  std::span<const double> velocity() const noexcept { return velocity_; }  ///< per s
  std::span<const double> acceleration() const noexcept { return acceleration_; }

  /// In the base's frame, of the last step.
  const SixVector& wrench() const noexcept { return wrench_base_; }
  const SixVector& displacement() const noexcept { return displacement_; }
  const SixVector& twist() const noexcept { return twist_; }
  const SixVector& twist_rate() const noexcept { return twist_rate_; }
  const Pose& reference_pose() const noexcept { return reference_pose_; }  ///< of the sensor
  const Quaternion& control_rotation() const noexcept { return R_base_control_; }
  SixVector damping() const noexcept;  ///< N s/m, N m s/rad

 private:
  static constexpr std::size_t kMost = kinematics::Chain::kMostMoving;

  void place(std::span<const double> values) noexcept;
  Quaternion rotation_in_base(int link) const noexcept;
  void filter_wrench(const SixVector& wrench) noexcept;
  SixVector law() const noexcept;
  bool solve(const SixVector& acceleration) noexcept;
  void integrate(double dt) noexcept;
  SixVector cartesian(std::span<const double> joints) const noexcept;

  kinematics::Chain chain_;
  AdmittanceFrames frames_;
  std::vector<std::size_t> joints_;
  AdmittanceParameters parameters_;
  SixVector damping_{};

  std::vector<double> q_, J_;  // of all joints of the model
  std::vector<Pose> poses_;    // of all links
  std::vector<double> offset_, velocity_, acceleration_;
  Quaternion R_base_world_, R_base_gravity_, R_base_sensor_, R_base_control_;
  Quaternion R_root_base_;
  SixVector wrench_world_{}, wrench_base_{}, displacement_{}, twist_{}, twist_rate_{};
  Pose reference_pose_;
};

}  // namespace polyarm::controllers
