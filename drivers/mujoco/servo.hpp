#pragma once
/// Joint drives of the simulation. rad or m, N m or N, s. Control thread; nothing allocates in a step.
#include <vector>

#include "drivers/mujoco/model_set.hpp"

namespace polyarm::drivers {

enum class JointMode { position, velocity, effort };

/// The drives of one robot. In position and velocity mode they use computed torque: the acceleration of the
/// set point plus a critically damped correction of 100 rad/s, multiplied by the inertia of the arm, plus
/// gravity and Coriolis forces; limited to the joint's effort. In effort mode they apply exactly the command.
/// A joint whose set point jumped farther than its effort can follow approaches it only as fast as it can brake. A joint
/// that nobody commands is held by a brake, which slips where more than the joint's effort pulls at it.
class Servo {
 public:
  explicit Servo(const hardware::RobotInstance& robot);

  /// Takes the set points of the next control period, NaN for none.
  void command(std::span<const double> position, std::span<const double> velocity,
               std::span<const double> effort, double period) noexcept;
  /// The wanted acceleration of each joint in this step, into `acceleration` (by dof of the model).
  void accelerations(const ModelView& view, std::size_t robot, mjtNum* acceleration,
                     double timestep) noexcept;
  /// Computes torques from inertia times acceleration of all dofs; writes qfrc_applied.
  void torques(const ModelView& view, std::size_t robot, const mjtNum* inertial_force) noexcept;

  /// From now on `mode` drives the joint; set points start at its present position and velocity.
  void start(std::size_t joint, JointMode mode, double position, double velocity) noexcept;
  /// If `mode` drives the joint, it is held at its position and ignores commands until a mode starts.
  void stop(std::size_t joint, JointMode mode, double position) noexcept;
  /// Set points start at the joints' positions.
  void start_at(std::span<const double> positions) noexcept;
  double torque(std::size_t joint) const noexcept { return joints_[joint].torque; }
  /// Largest distance between set point and joint in the last step, of joints with a position command, rad or m.
  double tracking_error() const noexcept { return tracking_error_; }

 private:
  struct Joint;
  static double strongest_acceleration(const Joint& joint, const ModelView& view, int dof) noexcept;
  struct Joint {
    JointMode mode = JointMode::position;
    bool led = true;                                       // driven; else held, commands are ignored
    bool commanded = false;                                // a position was commanded; else its brake holds it
    bool behind = false;                                   // its set point jumped, and it has not caught up
    double reference = 0, velocity = 0, acceleration = 0;  // set point at this physics step
    double target = 0;                                     // at the end of the control period
    double effort = 0, limit = 0;
    double torque = 0;
  };
  std::vector<Joint> joints_;
  double tracking_error_ = 0;
};

}  // namespace polyarm::drivers
