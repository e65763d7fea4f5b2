#pragma once
/// Finds collisions by the torques of the motors: what they exert beyond what masses and motion need. N m, N.
#include <optional>
#include <string>
#include <vector>

#include "polyarm/machine/machine.hpp"
#include "polyarm/moves/torque_limits.hpp"
#include "polyarm/setup/cell_setup.hpp"

namespace polyarm::cell {

/// Cell thread. The references must outlive this object.
class TorqueWatch {
 public:
  /// Watches the joints that `collision_torque` names, where the hardware measures position, velocity and
  /// effort; `notes` gets a sentence for each robot that cannot be watched.
  TorqueWatch(const CellSetup& setup, const Machine& machine, std::vector<std::string>& notes);

  struct Found {
    std::size_t robot = 0;
    std::string joint;
    double torque = 0, limit = 0;
    bool slides = false;
  };
  /// Call it once in each tick. Returns the joint that exceeds its limit most, once until its torque is below
  /// half of the limit.
  std::optional<Found> tick();
  /// A torque that still exceeds its limit counts again.
  void forget();

 private:
  struct Joint {
    std::string name;
    std::size_t position = 0, velocity = 0, effort = 0;  ///< states
    double limit = 0;                                    ///< 0: not watched
    double before = 0;                                   ///< its velocity in the last tick
    double outside = 0;                                  ///< smoothed
    bool slides = false;
  };
  struct Arm {
    std::size_t robot = 0;
    kinematics::Dynamics dynamics;
    std::vector<Joint> joints;
    std::vector<double> q, v, a, tau;
    int ticks = 0;
    bool over = false;
  };
  void measure(Arm& arm, double dt);

  const CellSetup& setup_;
  const Machine& machine_;
  std::vector<Arm> arms_;
  Nanoseconds time_ = 0;
};

}  // namespace polyarm::cell
