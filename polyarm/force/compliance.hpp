#pragma once
/// A robot that yields to forces at its sensor while it moves along its paths, by the equation of admittance.
/// SI units; six-vectors are linear x y z, then angular, in the axes of tool0.
#include <array>
#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/force/admittance_rule.hpp"
#include "polyarm/joint_control/motion_shift.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/trajectory/joint_move.hpp"

namespace polyarm::moves {

/// How a robot yields. In each chosen axis M a = F + push − D v − K x, with x from the path; the other axes
/// stay on the path.
struct ComplianceSettings {
  std::array<bool, 6> axes{};
  controllers::SixVector push{};       ///< N, N m: force with which the tool presses, along its axes
  double stiffness = 0;                ///< K: N/m, of rotations times kRotation N m/rad
  double damping = 1000;               ///< D: N s/m, of rotations times kRotation
  double reach = 0.02;                 ///< m: the sensor's origin stays within this distance of the path
  static constexpr double kArm = 0.1;  ///< m
  static constexpr double kRotation = kArm * kArm;  ///< m²
  /// rad: the sensor turns away from the path by at most this.
  double most_turn() const noexcept { return reach / kArm; }
};

/// Adds the motion of an admittance to the paths of one robot. The wrench comes from the cell thread, at its
/// rate. A stop freezes the offset: the robot does not yield then.
class Compliance : public controllers::MotionShift {
 public:
  /// The model must outlive this object. `limits`: of its joints.
  Compliance(const description::RobotModel& model, const kinematics::Chain& chain,
             std::span<const trajectory::JointMotionLimits> limits);

  // Cell thread.
  /// Only when over(). `at`: where the joints are. Throws Error("bad-value") if the robot cannot yield.
  void begin(const ComplianceSettings& settings, std::span<const double> at);
  /// What acts on the tool, in the axes and at the origin of tool0. Call it in each tick.
  void feed(const controllers::SixVector& wrench, Nanoseconds time) { wrench_.write({wrench, time}); }
  /// The robot stays where it has yielded to, and over() becomes true.
  void release() noexcept { wanted_.store(false, std::memory_order_release); }
  bool over() const noexcept { return !active(); }
  /// True if the robot has reached the end of what it may yield, or the wrench is older than 100 ms.
  bool at_bound() const noexcept { return at_bound_.load(std::memory_order_relaxed); }
  bool stale() const noexcept { return stale_.load(std::memory_order_relaxed); }
  /// Where the joints stay. Valid when over().
  std::span<const double> joints() const noexcept { return last_; }

  // Control thread.
  bool active() const noexcept override {
    return wanted_.load(std::memory_order_acquire) || running_.load(std::memory_order_acquire);
  }
  Outcome apply(const Request& request, const Joints& joints) noexcept override;
  bool standing() const noexcept override { return standing_; }
  void drop() noexcept override;

 private:
  static constexpr std::size_t kMost = kinematics::Chain::kMostMoving;
  struct Felt {
    controllers::SixVector wrench{};
    Nanoseconds time = -1;
  };
  void start() noexcept;
  bool feel(Nanoseconds now, controllers::SixVector& out) noexcept;
  void keep_within(const Joints& path, double period) noexcept;
  void end() noexcept;

  const description::RobotModel& model_;
  const kinematics::Chain& chain_;
  std::vector<trajectory::JointMotionLimits> limits_;
  std::unique_ptr<controllers::AdmittanceRule> rule_;  ///< made at the first begin()
  realtime::Latest<Felt> wrench_;

  // Written by the cell before wanted_.
  ComplianceSettings settings_;
  controllers::AdmittanceParameters yielding_, resting_;
  std::atomic<bool> wanted_{false}, running_{false}, at_bound_{false}, stale_{false};
  std::vector<double> last_;

  // Control thread.
  std::vector<double> put_;  ///< the commanded joints of the last cycle
  bool standing_ = true;
};

/// The shifts of one robot; at most one of them is active.
class EitherShift : public controllers::MotionShift {
 public:
  EitherShift(MotionShift& one, MotionShift& other) : one_(one), other_(other) {}
  bool active() const noexcept override { return one_.active() || other_.active(); }
  Outcome apply(const Request& request, const Joints& joints) noexcept override {
    return present().apply(request, joints);
  }
  bool standing() const noexcept override { return one_.standing() && other_.standing(); }
  void drop() noexcept override { one_.drop(), other_.drop(); }

 private:
  MotionShift& present() const noexcept { return other_.active() ? other_ : one_; }
  MotionShift& one_;
  MotionShift& other_;
};

}  // namespace polyarm::moves
