#pragma once
#include <vector>

#include "drivers/mujoco/model_set.hpp"

namespace polyarm::drivers {

enum class JointMode { position, velocity, effort };

/// The drives of one robot. In position and velocity mode: computed torque, that is the acceleration of the
/// set point plus a critically damped correction of 100 rad/s, multiplied by the inertia of the arm, plus
/// gravity and Coriolis forces; limited to the joint's effort. In effort mode: what was commanded and nothing
/// else.
class Servo {
 public:
  explicit Servo(const hardware::RobotInstance& robot);

  /// Takes the set points of the coming control period, NaN for none.
  void command(std::span<const double> position, std::span<const double> velocity,
               std::span<const double> effort, double period) noexcept;
  /// Acceleration asked of each joint in this step, into `acceleration` (by dof of the model).
  void accelerations(const ModelView& view, std::size_t robot, mjtNum* acceleration,
                     double timestep) noexcept;
  /// Torques, given inertia times acceleration of all dofs; writes qfrc_applied.
  void torques(const ModelView& view, std::size_t robot, const mjtNum* inertial_force) noexcept;

  /// The joint is led by `mode` from now on; set points start from where and how fast it is.
  void start(std::size_t joint, JointMode mode, double position, double velocity) noexcept;
  /// If `mode` leads the joint, it is held where it is, whatever its commands say, until something starts.
  void stop(std::size_t joint, JointMode mode, double position) noexcept;
  /// Set points start where the joints are.
  void start_at(std::span<const double> positions) noexcept;
  double torque(std::size_t joint) const noexcept { return joints_[joint].torque; }
  /// Largest distance from set point to joint in position mode in the last step, rad or m.
  double tracking_error() const noexcept { return tracking_error_; }

 private:
  struct Joint {
    JointMode mode = JointMode::position;
    bool led = true;                                       // else held, commands are not looked at
    double reference = 0, velocity = 0, acceleration = 0;  // set point at this physics step
    double target = 0;                                     // of the control period
    double effort = 0, limit = 0;
    double torque = 0;
  };
  std::vector<Joint> joints_;
  double tracking_error_ = 0;
};

}  // namespace polyarm::drivers
