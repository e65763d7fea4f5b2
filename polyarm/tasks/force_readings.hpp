#pragma once
/// What the force sensors of a cell's robots measure, for programs.
#include <array>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "polyarm/machine/machine.hpp"
#include "polyarm/setup/cell_setup.hpp"
#include "polyarm/setup/observer.hpp"

namespace polyarm::cell {

/// Force in N and torque in Nm: x y z rx ry rz in the axes of the sensor.
using Wrench = std::array<double, 6>;

/// True if the robot has a force sensor, or may get one from hardware that only a run knows.
bool may_feel_force(const CellRobot& robot, const CellRobots& robots);

/// Cell thread. The references must outlive this object.
class ForceReadings {
 public:
  ForceReadings(const CellSetup& setup, const Machine& machine, Observer& observer)
      : setup_{setup}, machine_{machine}, observer_{observer} {}

  /// The newest wrench of the robot's sensor, less the one at the last zero(). The first of its states
  /// ROBOT/SENSOR/force.x is the sensor. Throws Error: no sensor, or it gives no numbers.
  Wrench wrench(const std::string& robot);
  /// Takes the present wrench as zero; of a sensor with noise the mean of the last 50 ms in which the robot
  /// stood.
  void zero(const std::string& robot);
  /// Call it in each tick. `stands`: true if the robot with this name is at rest.
  void tick(const std::function<bool(const std::string&)>& stands);
  /// Of the newest wrench: cell time.
  Nanoseconds time() const { return machine_.snapshot().cycle.time; }

 private:
  struct Sensor {
    std::array<std::size_t, 6> states{};
    bool simulated_as_zero = false;  ///< declared in the cell, and the hardware has no such states
    bool noisy = false;
    Wrench zero{};
    std::deque<Wrench> rest;  ///< the newest readings at rest, of a noisy sensor
  };
  const CellRobot* find_robot(const std::string& name) const;
  std::optional<Sensor> find_sensor(const std::string& robot) const;
  Sensor& sensor_of(const std::string& robot);
  Wrench measured(const Sensor& sensor, const std::string& robot) const;

  const CellSetup& setup_;
  const Machine& machine_;
  Observer& observer_;
  std::map<std::string, Sensor> sensors_;
  bool looked_ = false;  ///< for noisy sensors
};

}  // namespace polyarm::cell
